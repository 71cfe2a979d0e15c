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
	post_state after;
	bool touched, held; // the contact changed it; the object rests on it at the end
	bool refused;       // the change is too large for its planes, and was not made
	int carried;        // what is deposited around, fixed-point units
	int sunk;           // how far the end pose is below the undisturbed surface, fixed-point units
	// Means over the post's area:
	vec3 stress;        // of the soil on the object, Pa
	vec3 moment;        // of this stress about the object's centre, Pa m
	float normal;       // vertical part of the normal stress, Pa
	float stiff;        // growth of that vertical part with the sinkage, Pa/m
	float area;         // the share of the area that bears
};

vec2 shear_of(int post)
{
	return vec2(bitfieldExtract(post, 0, 16), bitfieldExtract(post, 16, 16)) * exp2(-15.0);
}

int shear_post(vec2 shear)
{
	ivec2 whole = ivec2(round(clamp(shear * 32768.0, -32767.0, 32767.0)));
	return (whole.x & 0xffff) | whole.y << 16;
}

// A vector along a surface is stored as a level vector: the shortest rotation that makes the surface level turns it. So it keeps its
// length when the surface under a wheel turns.
vec2 levelled(vec3 along, vec3 n)
{
	return along.xy - n.xy * (along.z / (1.0 + n.z));
}

vec3 tilted(vec2 level, vec3 n)
{
	float down = dot(n.xy, level);
	return vec3(level - n.xy * (down / (1.0 + n.z)), -down);
}

// Returns the mobilised shear e after the object's surface slid a way in one direction. way: in units of the shear modulus K. The law is
// de = direction d(way) - e d(way). From rest this is Janosi's 1 - exp(-j / K). It is exact, however many contacts the way is
// cut into.
vec2 sheared(vec2 before, vec2 direction, float way)
{
	float stays = exp2(-1.442695 * min(way, 100.0));
	return before * stays + direction * (1.0 - stays);
}

// Returns the slip displacement that mobilises this shear from rest, in units of the shear modulus K. For nearly full shear it
// returns 1000.
float displacement_of(vec2 shear)
{
	float mobilised = length(shear);
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
	vec3 surface = way_of_surface(at), along = surface - dot(surface, normal) * normal;
	slip s;
	s.size = length(along);
	s.direction = levelled(along, normal) / max(s.size, 1e-9);
	return s;
}

vec3 normal_at(vec3 n, face f)
{
	return load.w > 0.0 ? n : f.normal;
}

// The depth of the lower envelope along a line across a cell is taken as a parabola through three places. These are the line's ends, at
// -1 and 1, and its middle, at 0. Returns the two places on the line between which the depth exceeds `stays`. stays.x is the limit for the first place, stays.y for
// the second.
vec2 between_roots(vec3 depths, vec2 stays)
{
	float bends = 0.5 * (depths.x + depths.z) - depths.y, rises = 0.5 * (depths.z - depths.x);
	vec2 over = depths.yy - stays, root = rises * rises - 4.0 * bends * over;
	vec2 by = sqrt(max(root, 0.0)) + vec2(rises, -rises);
	// A parabola whose top misses `stays` by rounding alone has one root, at its top.
	bool top = bends < 0.0;
	bvec2 touches = bvec2(top && root.x <= 0.0, top && root.y <= 0.0);
	vec2 at = mix(vec2(-2.0, 2.0) * over / max(by, 1e-15), vec2(-0.5 * rises / min(bends, -1e-18)), touches);
	vec2 least = touches.x || touches.y ? vec2(4.0 * bends * LEAST) : vec2(0.0);
	bvec2 never = bvec2(root.x < least.x || (by.x <= 0.0 && !touches.x), root.y < least.y || (by.y <= 0.0 && !touches.y));
	float low = depths.x > stays.x ? -1.0 : never.x ? 1.0 : clamp(at.x, -1.0, 1.0);
	float high = depths.z > stays.y ? 1.0 : never.y ? -1.0 : clamp(at.y, -1.0, 1.0);
	return vec2(low, max(low, high));
}

// Returns half the length of a line across a cell, m.
float half_across()
{
#ifdef SHAPE_WHEEL
	return 0.5 * scale.y / heading.z;
#else
	return 0.5 * scale.y;
#endif
}

// A line across a cell, in the direction in which the depth of the lower envelope changes most.
struct across {
	vec2 middle;  // from the object's centre, m
	vec2 end;     // from the middle, m
	float ground; // height of the ground at the middle above the object's centre, m
	float rise;   // of the ground from the middle to that end, m
};

// depth: of the lower envelope below the ground at the post, m, vertically.
across line_across(vec3 n, cell c, face post, float depth)
{
	vec2 hill = -n.xy / n.z, grows = hill - post.slope;
	across l;
#ifdef SHAPE_WHEEL
	l.end = heading.xy * half_across();
#else
	l.end = (dot(grows, grows) < 1e-8 ? heading.xy : normalize(grows)) * half_across();
#endif
	l.middle = c.at + c.middle;
	l.ground = depth + post.height + dot(hill, c.middle);
	l.rise = dot(hill, l.end);
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
slip slides_over(vec3 n, cell c, float above, float share)
{
	vec2 half_back = c.at + 0.5 * max(share, 0.0) * way.xy;
	face then = face_at(half_back, c.own);
	vec3 normal = normal_at(n, then);
	slip s = slip_at(vec3(half_back, then.height + above), normal);
	s.size *= moves.w > 0.0 ? moves.w / normal.z : 1.0;
	return s;
}

#ifdef SLIP
// What slip digs more in this contact, fixed-point units. With D, what it has dug in all contacts, dD is |e| (kappa K - D) / K for each way
// that the object slips. The mean of |e| is by Simpson's rule.
int digs_more(soil s, post_state before, slip over, float share)
{
	float along = over.size * share * s.b.z;
	vec2 shear = shear_of(before.shear);
	float halfway = length(sheared(shear, over.direction, 0.5 * along)), end = length(sheared(shear, over.direction, along));
	float mobilised = (length(shear) + 4.0 * halfway + end) / 6.0;
	float most = min(digs.y / s.b.z * 1048576.0, 1e8), stays = exp2(-1.442695 * min(digs.x * share * s.b.z * mobilised, 100.0));
	return int(round(max(most - float(before.dug), 0.0) * (1.0 - stays)));
}
#endif

// n: normal of the ground.
bearing bearing_of(soil s, float by_width, vec3 n, ground g, object o, cell c, post_state before)
{
	bearing b;
	b.after = before;
	answer a = answer_of(s, by_width, n.z, g, o, before.sinkage);
	b.touched = a.touched && may_touch(g, o);
	b.held = a.held && b.touched;
	float was = float(before.sinkage) * UNIT_METRES;
	float was_plastic = plastic_part(s, was, yield_stress(s, by_width, was));
	int more = 0;
	// share: of the contact, in which the object touches the post. It counts from the ground before slip digs. A post beside the object
	// stores no shear. There the object counts as having moved before as it moves now.
	bool over = o.rests != UNDER_NONE;
	face post = face_at(c.at, c.own);
	float since = contact_share(c.at, depth_at_post(g, o, post), was_plastic / n.z, post, over), share = over ? min(since, 1.0) : since;
	float above = over ? float(o.rests - o.raised) * UNIT_METRES - post.height : 0.0;
	slip passed = slides_over(n, c, above, share);
#ifdef SLIP
	// Slip digs soil from below the object, so the object must sink by that much more to be borne as before. Compacted soil stays
	// where it is, so it lies less deep below the lowered ground.
	if (b.held && !g.far && digs.x > 0.0) {
		more = digs_more(s, before, passed, clamp(share, 0.0, 1.0));
		more = max(min(more, g.height - o.rests - 2), 0); // it never digs itself free
		g.height -= more;
		int remains = max(before.sinkage - int(round(n.z * float(more))), 0);
		was = float(remains) * UNIT_METRES;
		was_plastic = plastic_part(s, was, yield_stress(s, by_width, was));
		a = answer_of(s, by_width, n.z, g, o, remains);
		b.held = a.held && may_touch(g, o);
	}
#endif
	int released = int(round(min(a.plastic / n.z * 1048576.0, 1.9e9)));
	int had = int(round(min(was_plastic / n.z * 1048576.0, 1.9e9)));
	b.sunk = b.held ? g.height - o.rests : released;
	b.refused = b.touched && (g.far || b.sunk > OFFSET_LIMIT || abs(before.heap - more - b.sunk) > OFFSET_LIMIT);
	b.touched = b.touched && !b.refused;
	b.held = b.held && !b.refused;
	b.carried = b.touched ? int(min(spin.w * float(max(released - had, 0)), float(max(CARRIED_MOST - more, 0)))) + min(more, CARRIED_MOST) : 0;

	float depth = depth_at_post(g, o, post), slides = passed.size;
	vec2 shear = shear_of(before.shear);
	if (b.touched) {
		b.after.heap = before.heap - more;
		b.after.offset = b.after.heap - b.sunk;
		b.after.sinkage = a.most;
		b.after.dug = before.dug + more;
	}
	b.after.shear = b.held ? shear_post(sheared(shear, passed.direction, slides * max(share, 0.0) * s.b.z)) : 0;

	// The part of the cell that bears.
	across l = line_across(n, c, post, depth);
	float lowered = over ? float(o.rests - o.lowest) * UNIT_METRES : 0.0;
	float back = over ? moves.x + half_across() : 1e3;
	// The stored sinkage counts for the post's whole cell. It is taken as a flat rut if the object passed over the cell. If the object
	// hardly moved, it is taken as an impression of the lower envelope.
	float stamped = was > 0.0 ? max(1.0 - length(way.xy) / half_across(), 0.0) : 0.0, rut = was / n.z - stamped * depth;
	vec3 depths, mosts;
	for (int k = 0; k < 3; k++) {
		vec2 there = place_on(l, float(k - 1));
		face f = face_at(there, c.own);
		depths[k] = depth_on(l, float(k - 1), f);
		mosts[k] = max(rut + stamped * depths[k], depths[k] + lowered_at(there, back, lowered, f));
	}
	float most = max(mosts.x, max(mosts.y, mosts.z)) * n.z;
	float stays = plastic_part(s, most, yield_stress(s, by_width, most)) / n.z;
	vec2 ends = between_roots(depths, vec2(mosts.x > max(depths.x, 0.0) + LEAST ? stays : 0.0,
							mosts.z > max(depths.z, 0.0) + LEAST ? stays : 0.0));
	// A wheel that has sunk to its axle does not bear on the soil in front of its rim.
	bool nothing = !over && abs(dot(c.at, heading.xy)) > body.x && depth > 0.0;
	float part = b.refused || g.far || nothing ? 0.0 : 0.5 * c.share * (ends.y - ends.x);
	b.stress = b.moment = vec3(0.0);
	b.normal = b.stiff = b.area = 0.0;
	// Of the places in a cell, those farther ahead came into contact later, so they slid less. But if the post stores less shear than
	// the motion since the first touch gives, the object stood on it before it moved. Then the places differ less.
	float lasts = over && since > 1.0 ? clamp(displacement_of(shear) / max(slides * (since - 1.0) * s.b.z, 1e-9), 0.0, 1.0) : 1.0;
	for (int k = 0; k < 2; k++) {
		float at = 0.5 * (ends.x + ends.y) + (float(k) - 0.5) * 0.57735027 * (ends.y - ends.x);
		vec2 there = place_on(l, at);
		face f = face_at(there, c.own);
		float deep = depth_on(l, at, f);
		float remembered = rut + stamped * deep, largest = max(remembered, deep + lowered_at(there, back, lowered, f));
		pressure p = pressure_of(s, by_width, n.z * deep, n.z * largest, largest > remembered);
		vec3 normal = normal_at(n, f), arm = vec3(there, f.height + above);
		float upright = load.w > 0.0 ? 1.0 : normal.z, weight = 0.5 * part / upright;
		float later = dot(there - c.at, way.xy) / max(dot(way.xy, way.xy), 1e-12) * lasts;
		float stress = p.stress + damped(s, arm, normal) * min(4.0 * p.share, 1.0) * min(4.0 * n.z * largest * s.b.z, 1.0);
		vec2 mobilised = sheared(shear, slip_at(arm, normal).direction, slides * max(share - later, 0.0) * s.b.z);
		float strength = p.share > 0.0 ? holds(s, 1.0, stress) : 0.0;
		vec3 sum = stress * normal - strength * tilted(mobilised, normal);
		b.stress += weight * sum;
		b.moment += weight * cross(arm, sum);
		b.normal += weight * p.stress * normal.z;
		b.stiff += weight * p.stiff * n.z * normal.z;
		b.area += p.share > 0.0 ? 0.5 * part : 0.0;
	}
	return b;
}
