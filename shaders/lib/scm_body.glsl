// The lower envelope of an object between posts, in its end pose, and the part of a post's cell that it covers (SOIL.md). Places are in
// metres, in plan, in the object's frame (into_frame).
// Defines: SHAPE_WHEEL, SHAPE_SPHERE, SHAPE_BOX, SHAPE_CYLINDER (also of wheels with camber), SHAPE_CAPSULE, SHAPE_ELLIPSOID. Without these
// the lower envelope is known only at posts.

struct face {
	float height; // of the lower envelope above the centre, m
	vec2 slope;   // its rise for each metre along the axes of the frame
	vec3 normal;  // upwards
#ifdef SHAPE_CYLINDER
	bool end;     // it is the flat end, which bears by its area in plan
#endif
};

#if defined(SHAPE_WHEEL) || defined(SHAPE_SPHERE) || defined(SHAPE_CYLINDER) || defined(SHAPE_ELLIPSOID)
#define ROUND
#endif
#if defined(SHAPE_WHEEL) || defined(SHAPE_BOX) || defined(SHAPE_CYLINDER)
#define SIDES // straight ones, at body.y
#endif

#if defined(SHAPE_CYLINDER) || defined(SHAPE_CAPSULE)
// Of the axis: its rise (a cylinder's towards the left of the frame), its length in plan, half the length of its straight part, m.
float lean = faces[0].x, level = faces[1].x, half_axis = faces[2].x;
#endif

#ifdef SHAPE_CYLINDER
// The plane across the axis cuts it in a circle. In an upright plane that is as wide, and `lift` times as high.
bool strips = body.y > 0.0; // the axis is level enough that its side alone bears, and its lower end beside that
float lift = 1.0 / level, low_side = lean < 0.0 ? 1.0 : -1.0; // where the lower end is: -1: to the right
float half_strip(float ahead)
{
	return sqrt(max(body.x * body.x - ahead * ahead, 0.0));
}

// Returns the height of the lower end above a place.
float end_at(vec2 at)
{
	return (-half_axis + low_side * at.y * level) / max(abs(lean), 1e-6);
}
#elif defined(SHAPE_ELLIPSOID)
// height = dot(shear, at) - faces[0].x sqrt(1 - squares), squares = ahead_by (x + skew y)^2 + aside_by y^2
vec2 shear_of_body = faces[0].yz;
float ahead_by = faces[1].x, skew = faces[1].w, aside_by = faces[2].x, lift = faces[0].x * sqrt(ahead_by);
#else
const float lift = 1.0;
#endif

#ifdef ROUND
// An upright plane through a place, along the motion, cuts the object in a circle, or in one `lift` times as high, and sheared. Returns
// this circle's radius, m.
float ring_at(vec2 at)
{
#ifdef SHAPE_SPHERE
	return sqrt(max(body.x * body.x - at.y * at.y, 0.0));
#elif defined(SHAPE_ELLIPSOID)
	return sqrt(max(1.0 - aside_by * at.y * at.y, 0.0) / ahead_by);
#else
	return body.x;
#endif
}

// Returns how far ahead of the circle's middle a place is.
float ahead_at(vec2 at)
{
#ifdef SHAPE_ELLIPSOID
	return at.x + skew * at.y;
#else
	return at.x;
#endif
}

// Returns how far below the circle's middle the object is, in units of `lift`.
float below_at(vec2 at, face now)
{
#if defined(SHAPE_WHEEL) || defined(SHAPE_SPHERE)
	return -now.height;
#else
	float ring = ring_at(at), ahead = ahead_at(at);
	return sqrt(max(ring * ring - ahead * ahead, 0.0));
#endif
}
#endif

// Returns how far to the left of the middle between its sides a place is.
float aside_at(vec2 at)
{
#ifdef SHAPE_CYLINDER
	return at.y - lean * half_strip(at.x);
#else
	return at.y;
#endif
}

// What is the same for all posts is computed once.
#ifdef SHAPE_WHEEL
const float STEEPEST_PART = 0.99874922; // of a unit normal: what lies in plan where its z is UPRIGHT_LEAST
float half_across = 0.5 * scale.y / heading.z;
#elif defined(SHAPE_CYLINDER)
const float STEEPEST_PART = 0.99874922;
float half_across = 0.5 * scale.y / (strips ? heading.z : 1.0);
#else
float half_across = 0.5 * scale.y; // half the length of a line across a cell, m
#endif
float by_radius = 1.0 / body.x, step_aside = heading.z * scale.y, by_step = 1.0 / step_aside;
vec2 by_speed = mix(1.0 / max(abs(way.xy), vec2(1e-9)), vec2(0.0), lessThan(abs(way.xy), vec2(1e-9))); // contacts a metre; 0: never
float by_sinking = way.z < 0.0 ? -1.0 / way.z : 0.0, by_moving = moves.x > 0.0 ? 1.0 / moves.x : by_sinking;
vec2 by_way = way.xy / max(dot(way.xy, way.xy), 1e-12);               // contacts a metre along the way
float stamps = max(1.0 - length(way.xy) * (1.0 / half_across), 0.0); // 1: the object stood still; 0: it moved over a cell
// Parts of cells are cut off along the lattice's axis that is nearest to the frame's.
bool northward = abs(heading.y) > abs(heading.x);
ivec2 next_ahead = northward ? ivec2(0, sign(heading.y)) : ivec2(sign(heading.x), 0);
ivec2 next_aside = northward ? ivec2(sign(-heading.y), 0) : ivec2(0, sign(heading.x));
vec2 cut_ahead = scale.y * into_frame(vec2(next_ahead)), cut_aside = scale.y * into_frame(vec2(next_aside));

vec3 normal_of_slope(vec2 slope)
{
	slope *= min(1.0, STEEPEST * inversesqrt(max(dot(slope, slope), 1.0)));
	float up = inversesqrt(1.0 + dot(slope, slope));
	return vec3(-slope * up, up);
}

// own: slope of a lower envelope that is known only at posts. Of a steep cylinder: x is 1 if its
// lower end alone bears. It is 2 if the higher of its end and its side bears at each place.
face face_at(vec2 at, vec2 own)
{
#ifdef SHAPE_WHEEL
	float up = sqrt(max(body.x * body.x - at.x * at.x, 0.0));
	// A place may lie beyond the rim.
	float ahead = clamp(at.x * by_radius, -STEEPEST_PART, STEEPEST_PART);
	return face(-up, vec2(0.0), vec3(-ahead, 0.0, max(up * by_radius, UPRIGHT_LEAST)));
#elif defined(SHAPE_SPHERE)
	float squares = dot(at, at), up = sqrt(max(body.x * body.x - squares, 0.0));
	vec3 inwards = vec3(-at, max(up, sqrt(max(body.x * body.x, squares)) * (1.0 / STEEPEST)));
	return face(-up, at / inwards.z, inwards * inversesqrt(dot(inwards, inwards)));
#elif defined(SHAPE_CYLINDER)
	float ahead = clamp(at.x, -body.x * STEEPEST_PART, body.x * STEEPEST_PART), strip = half_strip(ahead), up = strip * by_radius;
	face f = face((lean * at.y - half_strip(at.x)) * lift, vec2(ahead / strip, lean) * lift, vec3(-ahead * by_radius, -lean * up, level * up), false);
	if (!strips) {
		vec2 slope = vec2(0.0, low_side * level / max(abs(lean), 1e-6));
		f = own.x == 1.0 || end_at(at) > f.height ? face(end_at(at), slope, vec3(0.0), true) : f;
		f.normal = normal_of_slope(f.slope);
	}
	return f;
#elif defined(SHAPE_CAPSULE)
	vec2 axis = faces[0].yz;
	float axial = dot(axis, at), aside = axis.x * at.y - axis.y * at.x, strip = sqrt(max(body.x * body.x - aside * aside, 0.0));
	float middle = strip * lean, ends = axial <= middle - half_axis * level ? -1.0 : axial > middle + half_axis * level ? 1.0 : 0.0;
	vec2 from = at - ends * half_axis * level * axis; // of an end's ball
	float squares = dot(from, from), up = sqrt(max(body.x * body.x - squares, 0.0));
	vec3 inwards = vec3(-from, max(up, sqrt(max(body.x * body.x, squares)) * (1.0 / STEEPEST)));
	face f = face(ends * half_axis * lean - up, vec2(0.0), inwards);
	if (ends == 0.0)
		f = face((lean * axial - strip) / level, vec2(0.0),
			 vec3(-middle * axis - aside * vec2(-axis.y, axis.x), max(level * strip, body.x * (1.0 / STEEPEST))));
	f.slope = -f.normal.xy / f.normal.z;
	f.normal *= inversesqrt(dot(f.normal, f.normal));
	return f;
#elif defined(SHAPE_ELLIPSOID)
	float grows = ahead_by * (at.x + skew * at.y);
	vec2 half_slope = vec2(grows, skew * grows + aside_by * at.y);
	float squares = dot(at, half_slope), root = sqrt(max(1.0 - squares, 0.0));
	vec2 slope = shear_of_body + half_slope * (faces[0].x / max(root, sqrt(max(1.0, squares)) * (1.0 / STEEPEST)));
	return face(dot(shear_of_body, at) - faces[0].x * root, slope, normal_of_slope(slope));
#elif defined(SHAPE_BOX)
	face f = face(-1e9, vec2(0.0), vec3(0.0));
	for (int k = 0; k < 3; k++) {
		float height = faces[k].x + dot(faces[k].yz, at);
		f.slope = height > f.height ? faces[k].yz : f.slope;
		f.height = max(f.height, height);
	}
	f.normal = normal_of_slope(f.slope);
	return f;
#else
	return face(dot(own, at), own, normal_of_slope(own));
#endif
}

#ifdef ROUND
// Returns how much lower than now the object was above a place when x was there, m. x, inside: on the circle, m ahead of its middle.
float lower_by(float x, float inside, float ring, float below)
{
	// How much higher the circle is at `inside` than at x, without the cancellation of two roots: near its ends these are inexact.
	return lift * ((inside - x) * (inside + x) / max(sqrt(max(ring * ring - x * x, 0.0)) + below, 1e-9));
}
#endif

// Returns how much lower than now the object was above a place during its last `back` metres of motion, m. lowered: the same at the
// post. ground: rise of the ground for each metre along the frame's x axis.
float lowered_at(vec2 at, float back, float ground, float lowered, face now)
{
#ifdef ROUND
	float forward = ahead_at(at), ring = ring_at(at), below = below_at(at, now), inside = clamp(forward, -ring, ring), last = forward + back;
	// A host may move the object steeply, by little. Before this contact it moved along the ground. On each way the lowest place is found.
	float first = digs.w > 0.0 ? min(forward + moves.x, last) : last, least = 0.0;
	float x = clamp(min(max(ring * moves.z, forward), first), -ring, ring), less = lower_by(x, inside, ring, below) + moves.y * (x - forward);
	if (digs.w > 0.0) {
#ifdef SHAPE_ELLIPSOID
		ground -= shear_of_body.x;
#endif
		x = clamp(min(max(ring * ground * inversesqrt(lift * lift + ground * ground), first), last), -ring, ring);
		least = lower_by(x, inside, ring, below) + moves.y * (x - forward) + max(x - first, 0.0) * (ground - moves.y);
	}
#ifdef SHAPE_CYLINDER
	if (!strips) // its end bears, too, which is no circle
		return lowered;
#endif
	return moves.x > 0.0 ? max(max(less, least), 0.0) : 0.0;
#else
	return lowered;
#endif
}

// Returns the time, in contacts, until a place at `at` leaves a strip. size: half the strip's width, m; speed: of the place, m a contact;
// by: contacts a metre.
float until_beyond(float at, float size, float speed, float by)
{
	return size > 0.0 && by > 0.0 ? max(size - at * sign(speed), 0.0) * by : 1e3;
}

// Returns the last share of the contact during which the object was deeper than `stays` below the surface. Below 0: it is not so deep
// at the end. Above 1: it was so deep before the contact too, if it moved then as it moves now.
float contact_share(vec2 at, vec2 own, float depth, float stays, face now, bool over)
{
	float gains = depth - stays;
#ifdef ROUND
	// Where the circle along the motion first reached the place, and from there by the rise of the motion.
	float all = ring_at(at), up = max(below_at(at, now) - gains / lift, body.x * 0.05), ring = sqrt(max(all * all - up * up, 0.0));
	float rise = moves.y / lift, first = (ring - ahead_at(at)) * (1.0 - rise * up / min(rise * up - ring, -0.05 * up));
	float share = by_moving > 0.0 ? (moves.x > 0.0 ? first : gains) * by_moving : 1e3;
	if (digs.w > 0.0) {
		// A host may move the object steeply. This is when the circle leaves the place, whatever the direction.
#ifdef SHAPE_CYLINDER
		float plunge = way.z * level - way.y * lean;
#elif defined(SHAPE_ELLIPSOID)
		float plunge = (way.z - dot(shear_of_body, way.xy)) / lift;
#else
		float plunge = way.z;
#endif
		float ahead = ahead_at(at), height = gains / lift - below_at(at, now), path = moves.x * moves.x + plunge * plunge;
		float nears = ahead * moves.x + height * plunge, beyond = ahead * ahead + height * height - all * all;
		float root = nears * nears - path * beyond;
		share = path <= 0.0 ? 1e3 : root >= 0.0 ? -beyond / max(nears + sqrt(root), 1e-18) : -4.0;
	}
#ifdef SHAPE_CYLINDER
	if (digs.w > 0.0 && !strips) {
		float speed = face_at(at + way.xy, own).height - now.height - way.z;
		share = speed > 0.0 ? gains / speed : 1e3;
	}
#endif
#else
	float speed = face_at(at + way.xy, own).height - now.height - way.z;
	float share = speed > 0.0 ? gains / speed : 1e3;
#endif
#ifdef SHAPE_BOX
	share = over ? min(share, until_beyond(at.x, heading.w, way.x, by_speed.x)) : share;
#endif
#ifdef SIDES
	share = over ? min(share, until_beyond(aside_at(at), body.y, way.y, by_speed.y)) : share;
#endif
	return clamp(share, -4.0, 1e3);
}

// The part of the object that a post bears: what covers the post's cell. The last covered post also bears what lies beyond its cell.
struct cell {
	vec2 at;     // the post
	vec2 middle; // of the part, from the post, m
	float share; // area of the part, in posts
	vec2 own;    // as for face_at
#ifdef SHAPE_CYLINDER
	bool brim;   // it also bears what the lower end covers
#endif
};

vec2 place_of(int x, int y)
{
	return into_frame(place.xy + scale.y * vec2(x, y));
}

bool covers(ivec2 post)
{
	return all(greaterThanEqual(post, drawn.xy)) && all(lessThan(post, drawn.zw)) && rest_at(image_post(post.x, post.y)) != UNDER_NONE;
}

const float BORDER = 1e-5; // m: nearer to a border only the lower envelope, in whole numbers, tells whether a post is covered

// Tells whether a post is within a strip. at: its place across the strip, m. size: half the strip's width, m.
bool within(ivec2 post, float at, float size)
{
#ifdef SHAPE_CYLINDER
	bool beyond_end = at * low_side > 0.0; // there the lower envelope goes on, below the end
#else
	const bool beyond_end = false;
#endif
	return abs(abs(at) - size) > BORDER || beyond_end ? abs(at) < size : covers(post);
}

// Returns the part of a strip that a post bears: from, to, in posts from this post. next: from it to the next post across the strip.
vec2 part_of(ivec2 post, ivec2 next, float at, float size)
{
	return vec2(within(post - next, at - step_aside, size) ? -0.5 : max((-size - at) * by_step, -1.0),
		    within(post + next, at + step_aside, size) ? 0.5 : min((size - at) * by_step, 1.0));
}

#ifdef SHAPE_CYLINDER
// As part_of. The sides of a cylinder that leans are not straight: lower, upper: where the next posts lie across the strip, m.
vec2 part_between(bool has_lower, bool has_upper, float lower, float at, float upper)
{
	float least = 0.25 * step_aside;
	return vec2(has_lower ? -0.5 : max((-body.y - at) / max(at - lower, least), -1.0),
		    has_upper ? 0.5 : min((body.y - at) / max(upper - at, least), 1.0));
}
#endif

// Tells whether a post beside a wheel bears it. A wheel that is narrower than the spacing may pass between two posts: the nearer one
// bears it. A wheel that has sunk nearly to its axle reaches into the cells of posts in front of it.
bool bears_beside(vec2 at)
{
#if defined(SHAPE_WHEEL) || defined(SHAPE_CYLINDER)
	float aside = aside_at(at);
	bool between = 2.0 * body.y < step_aside && abs(aside - 1e-4 * step_aside) <= 0.5 * step_aside;
	return abs(at.x) < body.x + half_across && (between || abs(at.x) > body.x && abs(aside) <= body.y);
#else
	return false;
#endif
}

#ifdef POSTS_ONLY
// Returns the slope at a post between two others. It is their mean, but no more than twice each of them.
// Otherwise an object would seem, beside an edge, to reach below its own lowest place.
float middle_slope(float before, float after)
{
	float least = min(abs(before), abs(after));
	return before * after > 0.0 ? clamp(0.5 * (before + after), -2.0 * least, 2.0 * least) : 0.0;
}
#endif

cell cell_at(int x, int y, object o)
{
	bool over = o.rests != UNDER_NONE;
#ifdef SHAPE_CYLINDER
	cell c = cell(place_of(x, y), vec2(0.0), over ? 1.0 : 0.0, vec2(0.0), false);
#else
	cell c = cell(place_of(x, y), vec2(0.0), over ? 1.0 : 0.0, vec2(0.0));
#endif
#ifdef SIDES
	if (body.y > 0.0) {
		float aside = aside_at(c.at);
		bool narrow = 2.0 * body.y < step_aside;
#ifdef SHAPE_CYLINDER
		float lower = aside_at(c.at - cut_aside), upper = aside_at(c.at + cut_aside);
		bool has_lower = within(ivec2(x, y) - next_aside, lower, body.y), has_upper = within(ivec2(x, y) + next_aside, upper, body.y);
		vec2 part = part_between(has_lower, has_upper, lower, aside, upper);
		over = over && within(ivec2(x, y), aside, body.y);
		bool beside = !over && bears_beside(c.at);
		c.brim = (over || beside) && !(low_side < 0.0 ? has_lower : has_upper);
#else
		vec2 part = part_of(ivec2(x, y), next_aside, aside, body.y);
		bool beside = !over && bears_beside(c.at);
#endif
		part = over ? part : !beside ? vec2(0.0) : narrow ? vec2(-body.y - aside, body.y - aside) * by_step : part;
		c.share = max(part.y - part.x, 0.0);
		c.middle = 0.5 * (part.x + part.y) * cut_aside;
	}
#endif
#ifdef SHAPE_BOX
	if (body.y > 0.0 && heading.w > 0.0) {
		vec2 part = part_of(ivec2(x, y), next_ahead, c.at.x, heading.w);
		c.share *= max(part.y - part.x, 0.0);
		c.middle += 0.5 * (part.x + part.y) * cut_ahead;
	}
#endif
#ifdef SHAPE_CYLINDER
	// The side of a cylinder that is nearly upright is a wall. Where it is narrower in plan than a quarter of a post, it counts as none.
	if (!strips)
		c.own.x = 2.0 * half_axis * level < 0.25 * scale.y ? 1.0 : 2.0;
#endif
#ifdef POSTS_ONLY
	if (over)
		for (int k = 0; k < 2; k++) {
			ivec2 next = k == 0 ? ivec2(1, 0) : ivec2(0, 1);
			bool low = covers(ivec2(x, y) - next), high = covers(ivec2(x, y) + next);
			int here = rest_at(image_post(x, y));
			float before = low ? float(here - rest_at(image_post(x - next.x, y - next.y))) : 0.0;
			float after = high ? float(rest_at(image_post(x + next.x, y + next.y)) - here) : 0.0;
			c.own[k] = (low && high ? middle_slope(before, after) : before + after) * scale.x;
		}
#endif
	return c;
}

// Returns a height that the lower envelope is nowhere below, at places up to `reach` from a place, m above the centre.
float lowest_near(vec2 at, float reach, vec2 own)
{
#ifdef SHAPE_WHEEL
	float near = max(abs(at.x) - reach, 0.0);
	return -sqrt(max(body.x * body.x - near * near, 0.0));
#elif defined(SHAPE_SPHERE)
	float near = max(length(at) - reach, 0.0);
	return -sqrt(max(body.x * body.x - near * near, 0.0));
#elif defined(SHAPE_CYLINDER)
	float side = (lean * at.y - abs(lean) * reach - half_strip(max(abs(at.x) - reach, 0.0))) * lift;
	float end = end_at(at) - reach * level / max(abs(lean), 1e-6);
	return strips ? side : own.x > 1.0 ? max(side, end) : end;
#elif defined(SHAPE_CAPSULE)
	vec2 axis = faces[0].yz;
	float aside = max(abs(axis.x * at.y - axis.y * at.x) - reach, 0.0);
	float side = (lean * (dot(axis, at) - reach) - sqrt(max(body.x * body.x - aside * aside, 0.0))) / level;
	return max(side, -half_axis * lean - body.x);
#elif defined(SHAPE_ELLIPSOID)
	float ahead = at.x + skew * at.y, near = max(sqrt(ahead_by * ahead * ahead + aside_by * at.y * at.y) - reach * faces[2].w, 0.0);
	return dot(shear_of_body, at) - length(shear_of_body) * reach - faces[0].x * sqrt(max(1.0 - near * near, 0.0));
#elif defined(SHAPE_BOX)
	float lowest = -1e9;
	for (int k = 0; k < 3; k++)
		lowest = max(lowest, faces[k].x + dot(faces[k].yz, at) - reach * length(faces[k].yz));
	return lowest;
#else
	return dot(own, at) - reach * length(own);
#endif
}

// Returns by how much the object can be raised and still touch a post's cell, and a little more; fixed-point units. 0 or less: it does
// not touch the cell.
int touch_room(incline i, ground g, object o, cell c)
{
	bool over = o.rests != UNDER_NONE;
	vec2 at = c.at + c.middle;
#ifdef SHAPE_WHEEL
	float steep = abs(i.rise.x);
#else
	float steep = length(i.rise);
#endif
	float above = dot(i.rise, c.middle) + steep * half_across - lowest_near(at, half_across, c.own);
	float post = face_at(c.at, c.own).height, depth = over ? float(g.height - o.rests) : float(g.height - o.raised) - post * 1048576.0;
	float room = depth + max(above + post, 0.0) * 1048576.0;
	room += 1e-3 / scale.x + 2.4e-7 * abs(depth);
	return g.base != BASE_NODATA && (over || c.share > 0.0) ? int(clamp(ceil(room), -2e9, 2e9)) : -2000000000;
}

#ifdef SHAPE_WHEEL
// How far the part of a cell that a post bears reaches from the post, along the wheel's way. Its middle is at most half a post away.
float cell_reach = half_across + 0.5 * scale.y;
// The posts that bear lie at most this far to the side.
float bears_aside = max(body.y, 2.0 * body.y < step_aside ? 0.5 * step_aside : 0.0) + abs(way.y) + 1e-3 * step_aside;

// Tells whether the wheel, during the contact, was lower than a height above its centre somewhere within `reach` along its way. It says
// yes also where the wheel was a little higher, and for some posts beside it. It reads no lower envelope, which costs more.
bool was_below(vec2 at, float height, float reach)
{
	float away = max(max(at.x, -at.x - way.x) - reach, 0.0), highest = height + max(way.z, 0.0) + 1e-3 * scale.y + 2e-6 * digs.z;
	return abs(at.y) <= bears_aside && (highest >= 0.0 || away * away + highest * highest <= digs.z * digs.z);
}
#endif
