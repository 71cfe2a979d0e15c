// Computes a contact of scm at one post: the post's new state, and the soil's force and moment on the object there. The contact pass
// and the search for the equilibrium height share it, so that both compute the same force.

#include "lib/scm_body.glsl"

const int CARRIED_MOST = 1 << 23;
const float LEAST = 1.2e-6; // m: a little more than a fixed-point unit: a stored sinkage and a height are each rounded by up to half of one

// What a post remembers, in the units of its planes.
struct post_state {
	int offset, heap, sinkage;
	int dug;   // what slip has dug in all contacts
	int shear; // mobilised shear: two halves of 16 bits, 2^-15, to the east and (high) to the north
};

struct bearing {
	post_state after;   // valid if the post is touched; the shear is always valid
	bool touched, held; // the contact changed it; the object rests on it at the end
	bool refused;       // the change is too large for its planes, and was not made
	int carried;        // what is deposited around, fixed-point units
	int sunk;           // how far the end pose is below the undisturbed surface, fixed-point units
	// Means over the post's area:
	vec3 stress;        // of the soil on the object, Pa, east, north, up
	vec3 moment;        // of this stress about the object's centre, Pa m
	float normal;       // vertical part of the normal stress, Pa
	float stiff;        // growth of that vertical part with the sinkage, Pa/m
	float area;         // the share of the area that bears
#ifdef BELT
	float pull;         // of the belt against the soil, along the belt, Pa
#endif
};

// Mobilised shear in the object's frame.
vec2 shear_of(int post)
{
	return into_frame(vec2(bitfieldExtract(post, 0, 16), bitfieldExtract(post, 16, 16)) * exp2(-15.0));
}

int shear_post(vec2 shear)
{
	ivec2 whole = ivec2(round(clamp(out_of_frame(shear) * 32768.0, -32767.0, 32767.0)));
	return (whole.x & 0xffff) | whole.y << 16;
}

#if defined(SHAPE_WHEEL) && !defined(GROUND_NORMALS)
#define NORMALS_AHEAD // the normals lie in the plane in which the wheel turns
#endif

// A vector along a surface is stored as a level vector: the shortest rotation that makes the surface level turns it. So it keeps its
// length when the surface under a wheel turns. Returns that of the part of a vector that lies along the surface.
vec2 levelled(vec3 v, vec3 n)
{
#ifdef NORMALS_AHEAD
	return vec2(v.x * n.z - v.z * n.x, v.y);
#else
	return v.xy - n.xy * ((dot(v, n) + v.z) / (1.0 + n.z));
#endif
}

vec3 tilted(vec2 level, vec3 n)
{
#ifdef NORMALS_AHEAD
	return vec3(level.x * n.z, level.y, -level.x * n.x);
#else
	float down = dot(n.xy, level);
	return vec3(level - n.xy * (down / (1.0 + n.z)), -down);
#endif
}

// Returns the share of the mobilised shear that stays while the object's surface slides a way, in units of the shear modulus K. The law
// is de = direction d(way) - e d(way). From rest this is Janosi's 1 - exp(-j / K). It is exact, however many contacts the way is
// cut into.
float stays_after(float way)
{
	return exp2(-1.442695 * min(way, 100.0));
}

vec2 sheared(vec2 before, vec2 direction, float stays)
{
	return direction + stays * (before - direction);
}

// Returns the slip displacement that mobilises a shear of this size from rest, in units of the shear modulus K. For nearly full shear it
// returns 1000.
float displacement_of(float mobilised)
{
	return mobilised > 0.9999 ? 1e3 : -0.6931472 * log2(1.0 - mobilised);
}

// The stress along the normal at a sinkage, Pa, and its growth with the sinkage, Pa/m.
struct pressure {
	float stress, stiff;
	float share; // stress / yield stress
};

// z: the sinkage; most: the largest so far; both along the normal of the ground, m. grows: this contact reached `most`, so `most`
// grows with z.
pressure pressure_of(soil s, float by_width, float z, float most, bool grows)
{
	float yields = yield_stress(s, by_width, most), plastic = plastic_part(s, most, yields);
	float elastic = max(most - plastic, 1e-9);
	bool flows = z >= most - LEAST;
	float share = z <= 0.0 ? 0.0 : flows ? 1.0 : clamp((z - plastic) / elastic, 0.0, 1.0);
	pressure p;
	p.stress = yields * share;
	p.share = share;
	p.stiff = share <= 0.0 ? 0.0 : flows || grows ? yield_growth(s, yields, most) : yields / elastic;
	return p;
}

// How the object's surface slides during the contact, along the plane of a normal.
struct slip {
	vec2 direction; // as a level vector
	float size;     // m
};

slip slip_at(vec3 at, vec3 normal)
{
	vec3 moved = way_of_surface(at);
#ifdef BELT
	moved += belt.w * along_belt(normal);
#endif
	vec2 along = levelled(moved, normal);
	float squares = dot(along, along), by_size = inversesqrt(max(squares, 1e-18));
	return slip(along * by_size, squares * by_size);
}

vec3 normal_at(incline i, face f)
{
#ifdef GROUND_NORMALS
	return vec3(-i.rise * i.up, i.up);
#else
	return f.normal;
#endif
}

#ifdef SHAPE_CYLINDER
// Returns the share of its area in plan by which a flat end bears: all of it on level ground. A wheel that leans as its side slope does is
// upright for the ground. There the share is 0 (SOIL.md).
float end_bears(incline i, vec3 normal)
{
#ifdef GROUND_NORMALS
	return 1.0;
#else
	return clamp(1.0 - dot(normal.xy, i.rise) / max(normal.z, 1e-6), 0.0, 1.0);
#endif
}
#endif

// Returns the place on a line across a cell, from -1 to 1, beyond which a parabola is above 0. It goes through three numbers at the line's
// ends and its middle. sign: the end from which it is looked for.
float root_from(float sign, vec3 depths)
{
	float bends = 0.5 * (depths.x + depths.z) - depths.y, rises = 0.5 * (depths.z - depths.x);
	float over = depths.y, root = rises * rises - 4.0 * bends * over;
	float by = sqrt(max(root, 0.0)) - sign * rises;
	// A parabola whose top misses 0 by rounding alone has one root, at its top.
	bool touches = bends < 0.0 && root <= 0.0;
	float at = touches ? -0.5 * rises / min(bends, -1e-18) : sign * 2.0 * over / max(by, 1e-15);
	bool never = root < (touches ? 4.0 * bends * LEAST : 0.0) || (by <= 0.0 && !touches);
	return (sign < 0.0 ? depths.x : depths.z) > 0.0 ? sign : never ? -sign : clamp(at, -1.0, 1.0);
}

// The depth of the lower envelope along a line across a cell is taken as a parabola. Returns the two places on the line between which the object
// bears. An end bears from the surface on. Where it unloads, it bears from what stays of earlier sinkage on.
vec2 between_roots(vec3 depths, vec3 stays, bvec2 unloads)
{
	float low = root_from(-1.0, unloads.x ? depths - stays : depths), high = root_from(1.0, unloads.y ? depths - stays : depths);
	return vec2(low, max(low, high));
}

// A line across a cell, in the direction in which the depth of the lower envelope changes most.
struct across {
	vec2 middle;
	vec2 end;     // from the middle, m
	float ground; // height of the ground at the middle above the object's centre, m
	float rise;   // of the ground from the middle to that end, m
};

// depth: of the lower envelope below the ground at the post, m, vertically.
across line_across(incline i, cell c, face post, float depth)
{
	across l;
	vec2 grows = i.rise - post.slope;
#ifdef SHAPE_WHEEL
	l.end = vec2(half_across, 0.0);
#elif defined(SHAPE_CYLINDER)
	l.end = strips || dot(grows, grows) < 1e-8 ? vec2(half_across, 0.0) : normalize(grows) * half_across;
#else
	l.end = (dot(grows, grows) < 1e-8 ? vec2(1.0, 0.0) : normalize(grows)) * half_across;
#endif
	l.middle = c.at + c.middle;
	l.ground = depth + post.height + dot(i.rise, c.middle);
	l.rise = dot(i.rise, l.end);
	return l;
}

// at: -1 .. 1
vec2 place_on(across l, float at)
{
	return l.middle + at * l.end;
}

float depth_on(across l, float at, face f)
{
	return l.ground + at * l.rise - f.height;
}

float depth_at_post(ground g, object o, face post)
{
	return (o.rests != UNDER_NONE ? float(g.height - o.rests) : float(g.height - o.raised) - post.height * 1048576.0) * UNIT_METRES;
}

// Returns how the object's surface slides over a post in the whole contact. above: how much higher the lower envelope of the post is than
// that of its place. share: for how much of the contact the object touches the post.
slip slides_over(incline i, cell c, float above, float share)
{
	vec2 half_back = c.at + 0.5 * max(share, 0.0) * way.xy;
	face then = face_at(half_back, c.own);
	vec3 normal = normal_at(i, then);
	slip s = slip_at(vec3(half_back, then.height + above), normal);
#ifdef NORMALS_AHEAD
	s.size *= moves.w / normal.z;
#elif defined(SHAPE_CYLINDER) && !defined(GROUND_NORMALS)
	s.size *= strips ? moves.w * level / normal.z : 1.0;
#elif defined(BELT) && !defined(GROUND_NORMALS)
	s.size *= moves.w * belt_level / normal.z;
#endif
	return s;
}

#ifdef SLIP
// What slip digs more in this contact, fixed-point units. D is what it has dug in all contacts, along the ground's normal. Then dD is
// |e| (kappa K - D) / K for each way that the object slips. mobilised: the mean of |e|.
int digs_more(soil s, incline i, int dug, float share, float mobilised)
{
	float most = min(digs.y * s.c.y * i.by_up * 1048576.0, 1e8), stays = stays_after(digs.x * share * s.b.z * mobilised);
	return int(round(max(most - float(dug), 0.0) * (1.0 - stays)));
}
#endif

// Tells whether an object is in contact whose lower envelope has this sinkage. most: the largest sinkage so far, of which `plastic`, m,
// is plastic.
bool in_contact(int sunk, int most, float plastic)
{
	return sunk > 0 && (sunk >= most || float(sunk) * UNIT_METRES > plastic);
}

float plastic_of(soil s, float by_width, int most)
{
	float z = float(most) * UNIT_METRES;
	return plastic_part(s, z, yield_stress(s, by_width, z));
}

int whole_units(float metres)
{
	return int(round(min(metres * 1048576.0, 1.9e9)));
}

#ifdef SHAPE_CYLINDER
const int END_STEPS = 4; // within 0.1 % of the load of what 40 steps give

// Returns how the soil is sheared that the lower end slid over, at a place of the end. The end turns over the soil: downwards ahead of the axle,
// upwards behind it. So its way is followed from where it began, in equal steps. since: contacts ago.
vec2 sheared_by_end(soil s, vec3 arm, vec3 normal, float since)
{
	vec2 mobilised = vec2(0.0);
	float each = since / float(END_STEPS);
	for (int k = END_STEPS - 1; k >= 0; k--) {
		slip slides = slip_at(arm + (float(k) + 0.5) * each * way.xyz, normal);
		mobilised = sheared(mobilised, slides.direction, stays_after(slides.size * each * s.b.z));
	}
	return mobilised;
}

// Adds what the lower end of a cylinder that leans bears beside a cell. Along its way the end is nowhere lower, so the soil there yields all
// over, and slides along it since its rim came. All stresses count by the end's area in plan.
void bear_brim(inout bearing b, soil s, float by_width, incline i, across l, float above)
{
	float steep = level / max(abs(lean), 1e-6), edge = low_side * half_axis * level;
	vec3 depths;
	for (int k = 0; k < 3; k++) {
		float strip = half_strip(place_on(l, float(k - 1)).x);
		vec2 there = vec2(place_on(l, float(k - 1)).x, lean * strip + edge);
		depths[k] = l.ground + dot(i.rise, there - l.middle) - (lean * there.y - strip) * lift;
	}
	vec2 ends = between_roots(depths, vec3(0.0), bvec2(false));
	float at = 0.5 * (ends.x + ends.y), ahead = place_on(l, at).x, strip = half_strip(ahead);
	vec2 there = vec2(ahead, lean * strip + edge);
	float lowest = (lean * there.y - strip) * lift, depth = l.ground + dot(i.rise, there - l.middle) - lowest;
	float width = clamp(depth / max(steep - low_side * i.rise.y, 1e-6), 0.0, 2.0 * strip * abs(lean));
	// The mean and the middle of a power of the depth, from 0 to all of it.
	float mean = depth * exp2(-log2(s.a.z + 1.0) / s.a.z), out_by = width / (s.a.z + 2.0), below = strip - out_by / max(abs(lean), 1e-6);
	vec3 normal = normal_at(i, face(lowest, vec2(0.0, low_side * steep), vec3(0.0, -low_side * level, abs(lean)), true)), arm = vec3(there + vec2(0.0, low_side * out_by), lowest + out_by * steep + above);
	// Since the rim came from ahead, or the end from above.
	float came = moves.x > 0.0 ? max(half_strip(below) - ahead, 0.0) * by_moving : 1e9, sank = by_sinking > 0.0 ? mean * by_sinking : 1e9;
	float since = min(came, sank) < 1e9 ? min(came, sank) : 1.0, rolled = min(moves.x / half_across, 1.0);
	if (digs.w > 0.0 && since > 1.0)
		since = 1.0 + (since - 1.0) * rolled * rolled; // a short motion says little of where the end came from
	pressure p = pressure_of(s, by_width, i.up * mean, i.up * mean, true);
	float stress = p.stress + damped(s, arm, normal) * min(4.0 * i.up * mean * s.b.z, 1.0), weight = 0.5 * (ends.y - ends.x) * width * by_step * end_bears(i, normal);
	vec3 sum = stress * normal - holds(s, 1.0, stress) * tilted(sheared_by_end(s, arm, normal, since), normal);
	if (mean <= 0.0)
		return;
	b.stress += weight * sum;
	b.moment += weight * cross(arm, sum);
	b.normal += weight * p.stress * normal.z;
	b.stiff += weight * p.stiff * i.up * normal.z;
	b.area += weight;
}
#endif

// What a post remembers of its largest sinkage, for its whole cell.
struct memory {
	float sinkage;      // of the post, vertically, m
	float stamped;      // share of the shape of the lower envelope as it is
	float printed;      // share of its shape at the contact's start: for a body that a host moves, where the soil bore it then
	float print_height; // of that shape at the post
};

// stays: the plastic part of the sinkage; depth: of the post; both vertically.
memory memory_of(cell c, face post, float depth, float was, float stays)
{
	memory m = memory(was, was > 0.0 ? stamps : 0.0, 0.0, 0.0);
	if (digs.w > 0.0 && was > 0.0) {
		m.stamped = min(m.stamped, digs.w - 1.0);
		m.print_height = face_at(c.at + way.xy, c.own).height;
		m.printed = clamp((depth + post.height - m.print_height + way.z - stays + 4.0 * LEAST) / max(was - stays, 1e-9), 0.0, 1.0);
	}
	return m;
}

// Returns the largest sinkage that a place of the cell remembers, vertically. deeper: how much deeper the object is there than at the post;
// rise: of the ground from the post to the place.
float remembered_at(memory m, cell c, vec2 there, float deeper, float rise)
{
	float print = m.printed > 0.0 ? rise + m.print_height - face_at(there + way.xy, c.own).height : 0.0;
	return m.sinkage + m.printed * print + (1.0 - m.printed) * m.stamped * deeper;
}

bearing bearing_of(soil s, float by_width, incline i, ground g, object o, cell c, post_state before)
{
	bearing b;
	b.after = before;
	bool over = o.rests != UNDER_NONE, may = may_touch(g, o);
	float had_plastic = plastic_of(s, by_width, before.sinkage);
	int deepest = sinkage_of(i.up, g, o.lowest), sunk = over ? sinkage_of(i.up, g, o.rests) : 0;
	b.touched = may && in_contact(deepest, before.sinkage, had_plastic);
	b.after.sinkage = max(before.sinkage, deepest);
	float plastic = plastic_of(s, by_width, b.after.sinkage);
	b.held = b.touched && in_contact(sunk, b.after.sinkage, plastic);
	// share: of the contact, in which the object touches the post. It counts from the ground before slip digs. A post beside the object
	// stores no shear. There the object counts as having moved before as it moves now.
	face post = face_at(c.at, c.own);
	float since = contact_share(c.at, c.own, depth_at_post(g, o, post), had_plastic * i.by_up, post, over), share = over ? min(since, 1.0) : since;
	float above = over ? float(o.rests - o.raised) * UNIT_METRES - post.height : 0.0;
	slip passed = slides_over(i, c, above, share);
	vec2 shear = shear_of(before.shear);
	float slides = passed.size * s.b.z, mobilised = length(shear), touching = max(share, 0.0), halfway = stays_after(0.5 * slides * touching);
	vec2 sheared_after = sheared(shear, passed.direction, halfway * halfway);
	int more = 0, remains = before.sinkage;
#ifdef SLIP
	// Slip digs soil from below the object, so the object must sink by that much more to be borne as before. Compacted soil stays
	// where it is, so it lies less deep below the lowered ground. The mean of |e| is by Simpson's rule.
	if (b.held && !g.far && digs.x > 0.0) {
		float mean = (mobilised + 4.0 * length(sheared(shear, passed.direction, halfway)) + length(sheared_after)) * (1.0 / 6.0);
		more = max(min(digs_more(s, i, before.dug, touching, mean), g.height - o.rests - 2), 0); // it never digs itself free
		g.height -= more;
		remains = max(remains - int(round(i.up * float(more))), 0);
		had_plastic = plastic_of(s, by_width, remains);
		b.after.sinkage = max(remains, sinkage_of(i.up, g, o.lowest));
		plastic = plastic_of(s, by_width, b.after.sinkage);
		b.held = in_contact(sinkage_of(i.up, g, o.rests), b.after.sinkage, plastic);
	}
#endif
	int released = whole_units(plastic * i.by_up), had = whole_units(had_plastic * i.by_up);
	b.sunk = b.held ? g.height - o.rests : released;
	b.refused = b.touched && (g.far || b.sunk > OFFSET_LIMIT || abs(before.heap - more - b.sunk) > OFFSET_LIMIT);
	b.touched = b.touched && !b.refused;
	b.held = b.held && !b.refused;
	b.carried = b.touched ? int(min(spin.w * float(max(released - had, 0)), float(max(CARRIED_MOST - more, 0)))) + min(more, CARRIED_MOST) : 0;

	b.after.heap = before.heap - more;
	b.after.offset = b.after.heap - b.sunk;
	b.after.dug = before.dug + more;
	b.after.shear = b.held ? shear_post(sheared_after) : 0;

	// The part of the cell that bears.
	float depth = depth_at_post(g, o, post);
	across l = line_across(i, c, post, depth);
	float lowered = over ? float(o.rests - o.lowest) * UNIT_METRES : 0.0;
	float back = over ? moves.x + (digs.w > 0.0 ? min(moves.x, half_across) : (1.0 - stamps) * half_across) : 1e3;
	// The stored sinkage counts for the post's whole cell. It is taken as a flat rut if the object passed over the cell. If the object
	// hardly moved, it is taken as an impression of the lower envelope.
	memory m = memory_of(c, post, depth, float(remains) * UNIT_METRES * i.by_up, had_plastic * i.by_up);
	float centre = l.ground - depth - post.height; // rise of the ground from the post to the line's middle
#ifdef SHAPE_CYLINDER
	// Across its way the rut leans as the cylinder does.
	m.sinkage += remains > 0 && strips ? (1.0 - m.printed) * (1.0 - m.stamped) * (i.rise.y - lean * lift) * c.middle.y : 0.0;
#endif
	vec3 depths, mosts;
	for (int k = 0; k < 3; k++) {
		vec2 there = place_on(l, float(k - 1));
		face f = face_at(there, c.own);
		depths[k] = depth_on(l, float(k - 1), f);
		mosts[k] = max(remembered_at(m, c, there, depths[k] - depth, centre + float(k - 1) * l.rise), depths[k] + lowered_at(there, back, i.rise.x, lowered, f));
	}
	float most = max(mosts.x, max(mosts.y, mosts.z)) * i.up;
	vec3 stays = vec3(plastic_part(s, most, yield_stress(s, by_width, most)) * i.by_up);
	if (digs.w > 0.0)
		for (int k = 0; k < 3; k++)
			stays[k] = plastic_part(s, mosts[k] * i.up, yield_stress(s, by_width, mosts[k] * i.up)) * i.by_up;
	bvec2 unloads = bvec2(mosts.x > max(depths.x, 0.0) + LEAST, mosts.z > max(depths.z, 0.0) + LEAST);
	vec2 ends = between_roots(depths, stays, unloads);
	// A wheel that has sunk to its axle does not bear on the soil in front of its rim.
	bool nothing = !over && abs(c.at.x) > body.x && depth > 0.0;
	float part = b.refused || g.far || nothing ? 0.0 : 0.5 * c.share * (ends.y - ends.x);
	b.stress = b.moment = vec3(0.0);
	b.normal = b.stiff = b.area = 0.0;
#ifdef BELT
	b.pull = 0.0;
#endif
	// Of the places in a cell, those farther ahead came into contact later, so they slid less. But if the post stores less shear than
	// the motion since the first touch gives, the object stood on it before it moved. Then the places differ less.
	float lasts = over && since > 1.0 ? clamp(displacement_of(mobilised) / max(slides * (since - 1.0), 1e-9), 0.0, 1.0) : 1.0;
	if (digs.w > 0.0)
		lasts *= 1.0 - stamps; // a short motion says little of where the places of a cell came from
	for (int k = 0; k < 2; k++) {
		float at = 0.5 * (ends.x + ends.y) + (float(k) - 0.5) * 0.57735027 * (ends.y - ends.x);
		vec2 there = place_on(l, at);
		face f = face_at(there, c.own);
		float deep = depth_on(l, at, f);
		float remembered = remembered_at(m, c, there, deep - depth, centre + at * l.rise), largest = max(remembered, deep + lowered_at(there, back, i.rise.x, lowered, f));
		pressure p = pressure_of(s, by_width, i.up * deep, i.up * largest, largest > remembered);
		vec3 normal = normal_at(i, f), arm = vec3(there, f.height + above);
#ifdef GROUND_NORMALS
		float weight = 0.5 * part;
#else
		float weight = 0.5 * part / normal.z;
#endif
#ifdef SHAPE_CYLINDER
		weight = f.end ? 0.5 * part * end_bears(i, normal) : weight;
#endif
		float later = dot(there - c.at, by_way) * lasts;
		float stress = p.stress + damped(s, arm, normal) * min(4.0 * p.share, 1.0) * min(4.0 * i.up * largest * s.b.z, 1.0);
		vec2 mobilised = sheared(shear, slip_at(arm, normal).direction, stays_after(slides * max(share - later, 0.0)));
		float strength = p.share > 0.0 ? holds(s, 1.0, stress) : 0.0;
		vec3 sum = stress * normal - strength * tilted(mobilised, normal);
		b.stress += weight * sum;
		b.moment += weight * cross(arm, sum);
		b.normal += weight * p.stress * normal.z;
		b.stiff += weight * p.stiff * i.up * normal.z;
		b.area += p.share > 0.0 ? 0.5 * part : 0.0;
#ifdef BELT
		b.pull += weight * strength * dot(tilted(mobilised, normal), along_belt(normal));
#endif
	}
#ifdef SHAPE_CYLINDER
	if (c.brim && !(b.refused || g.far || nothing))
		bear_brim(b, s, by_width, i, l, above);
#endif
	b.stress.xy = out_of_frame(b.stress.xy);
	b.moment.xy = out_of_frame(b.moment.xy);
	return b;
}
