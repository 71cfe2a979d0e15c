// The lower envelope of an object between posts, in its end pose, and the part of a post's cell that it covers (SOIL.md). Places are in
// metres from the object's centre, in plan.
// Defines: SHAPE_WHEEL, SHAPE_SPHERE, SHAPE_BOX. Without these the lower envelope is known only at posts.

struct face {
	float height; // of the lower envelope above the centre, m
	vec2 slope;   // its rise for each metre east and north
	vec3 normal;  // upwards
};

#if defined(SHAPE_WHEEL) || defined(SHAPE_SPHERE)
#define ROUND
// Returns the part of a place that decides how high the lower envelope is there.
vec2 part_of_place(vec2 at)
{
#ifdef SHAPE_WHEEL
	return dot(at, heading.xy) * heading.xy;
#else
	return at;
#endif
}

// A plane through a place, along the motion, cuts the object in a circle. Returns the square of this circle's radius, m2.
float ring_squares(vec2 at)
{
#ifdef SHAPE_WHEEL
	return body.x * body.x;
#else
	float aside = heading.x * at.y - heading.y * at.x;
	return max(body.x * body.x - aside * aside, 0.0);
#endif
}
#endif

vec3 normal_of_slope(vec2 slope)
{
	slope *= min(1.0, STEEPEST * inversesqrt(max(dot(slope, slope), 1.0)));
	float up = inversesqrt(1.0 + dot(slope, slope));
	return vec3(-slope * up, up);
}

// own: slope of a lower envelope that is known only at posts.
face face_at(vec2 at, vec2 own)
{
#ifdef ROUND
	vec2 part = part_of_place(at);
	float squares = dot(part, part), up = sqrt(max(body.x * body.x - squares, 0.0));
	// A place may lie beyond the rim.
	vec3 inwards = vec3(-part, max(up, sqrt(max(body.x * body.x, squares)) * (1.0 / STEEPEST)));
	return face(-up, part / inwards.z, inwards * inversesqrt(dot(inwards, inwards)));
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

// Returns how much lower than now the object was above a place during its last `back` metres of motion, m. lowered: the same at the
// post.
float lowered_at(vec2 at, float back, float lowered, face now)
{
#ifdef ROUND
	float forward = dot(at, heading.xy), squares = ring_squares(at), ring = sqrt(squares);
	float x = clamp(min(max(ring * moves.z, forward), forward + back), -ring, ring);
	// How much higher the circle is at `forward` than at x, without the cancellation of two roots: near its ends these are inexact.
	float inside = clamp(forward, -ring, ring), rises = (inside - x) * (inside + x) / max(sqrt(max(squares - x * x, 0.0)) - now.height, 1e-9);
	return moves.x > 0.0 ? max(rises + moves.y * (x - forward), 0.0) : 0.0;
#else
	return lowered;
#endif
}

// Returns the time, in contacts, until a place at `at` leaves a strip. size: half the strip's width, m; speed: of the place, m a contact.
float until_beyond(float at, float size, float speed)
{
	return size > 0.0 && abs(speed) > 1e-9 ? max(size - at * sign(speed), 0.0) / abs(speed) : 1e3;
}

// Returns the last share of the contact during which the object was deeper than `stays` below the surface. Below 0: it is not so deep
// at the end. Above 1: it was so deep before the contact too, if it moved then as it moves now.
float contact_share(vec2 at, float depth, float stays, face now, bool over)
{
	float forward = dot(at, heading.xy), gains = depth - stays;
#ifdef ROUND
	// Where the circle along the motion first reached the place, and from there by the rise of the motion.
	float up = max(-now.height - gains, body.x * 0.05), ring = sqrt(max(ring_squares(at) - up * up, 0.0));
	float first = (ring - forward) * (1.0 - moves.y * up / min(moves.y * up - ring, -0.05 * up));
	bool goes = moves.x > 0.0;
	gains = goes ? first : gains;
	float speed = goes ? moves.x : -way.z;
#else
	float speed = face_at(at + way.xy, now.slope).height - now.height - way.z;
#endif
	float share = speed > 0.0 ? gains / speed : 1e3;
#ifdef SHAPE_BOX
	share = over ? min(share, until_beyond(forward, heading.w, dot(way.xy, heading.xy))) : share;
#endif
#if defined(SHAPE_BOX) || defined(SHAPE_WHEEL)
	float aside = heading.x * at.y - heading.y * at.x;
	share = over ? min(share, until_beyond(aside, body.y, heading.x * way.y - heading.y * way.x)) : share;
#endif
	return clamp(share, -4.0, 1e3);
}

// The part of the object that a post bears: what covers the post's cell. The last covered post also bears what lies beyond its cell.
struct cell {
	vec2 at;     // the post, from the object's centre, m
	vec2 middle; // of the part, from the post, m
	float share; // area of the part, in posts
	vec2 own;    // slope of a lower envelope that is known only at posts
};

bool covers(ivec2 post)
{
	return all(greaterThanEqual(post, drawn.xy)) && all(lessThan(post, drawn.zw)) && rest_at(ivec3(post, zero.z)) != UNDER_NONE;
}

// Returns the part of a strip that a post bears: from, to, in posts from this post. at: the post's place across the strip, m. size:
// half the strip's width, m. step: the next post is this much farther across, m. A post on the strip's border counts as covered, as
// it does in the lower envelope.
vec2 part_of(float at, float size, float step)
{
	float covered = size + 1e-6 * size + 1e-7;
	return vec2(abs(at - step) <= covered ? -0.5 : max((-size - at) / step, -1.0), abs(at + step) <= covered ? 0.5 : min((size - at) / step, 1.0));
}

// Tells whether a post beside a wheel bears it. A wheel that is narrower than the spacing may pass between two posts: the nearer one
// bears it. A wheel that has sunk nearly to its axle reaches into the cells of posts in front of it. at: the post from the wheel's
// centre, forwards and to the left, m.
bool bears_beside(vec2 at)
{
#ifdef SHAPE_WHEEL
	float step = heading.z * scale.y;
	bool between = 2.0 * body.y < step && abs(at.y - 1e-4 * step) <= 0.5 * step;
	return abs(at.x) < body.x + 0.5 * scale.y / heading.z && (between || abs(at.x) > body.x && abs(at.y) <= body.y);
#else
	return false;
#endif
}

vec2 along_and_aside(vec2 at)
{
	return vec2(dot(at, heading.xy), heading.x * at.y - heading.y * at.x);
}

cell cell_at(int x, int y, object o)
{
	bool over = o.rests != UNDER_NONE, northward = abs(heading.y) > abs(heading.x);
	vec2 side = vec2(-heading.y, heading.x);
	float step = heading.z * scale.y;
	cell c = cell(place.xy + scale.y * vec2(x, y), vec2(0.0), over ? 1.0 : 0.0, vec2(0.0));
#if defined(SHAPE_WHEEL) || defined(SHAPE_BOX)
	if (body.y > 0.0) {
		vec2 at = along_and_aside(c.at), part = part_of(at.y, body.y, step);
		bool narrow = 2.0 * body.y < step;
		part = over ? part : !bears_beside(at) ? vec2(0.0) : narrow ? vec2(-body.y - at.y, body.y - at.y) / step : part;
		c.share = max(part.y - part.x, 0.0);
		c.middle = 0.5 * (part.x + part.y) * scale.y * (northward ? vec2(sign(side.x), 0.0) : vec2(0.0, sign(side.y)));
	}
#endif
#ifdef SHAPE_BOX
	if (body.y > 0.0 && heading.w > 0.0) {
		vec2 part = part_of(dot(c.at, heading.xy), heading.w, step);
		c.share *= max(part.y - part.x, 0.0);
		c.middle += 0.5 * (part.x + part.y) * scale.y * (northward ? vec2(0.0, sign(heading.y)) : vec2(sign(heading.x), 0.0));
	}
#endif
#if !defined(ROUND) && !defined(SHAPE_BOX)
	if (over)
		for (int k = 0; k < 2; k++) {
			ivec2 next = k == 0 ? ivec2(1, 0) : ivec2(0, 1);
			bool low = covers(ivec2(x, y) - next), high = covers(ivec2(x, y) + next);
			int from = rest_at(ivec3(ivec2(x, y) - (low ? next : ivec2(0)), zero.z));
			int to = rest_at(ivec3(ivec2(x, y) + (high ? next : ivec2(0)), zero.z));
			c.own[k] = float(to - from) * scale.x * (low && high ? 0.5 : 1.0);
		}
#endif
	return c;
}

// Returns a height that the lower envelope is nowhere below, at places up to `reach` from a place, m above the centre.
float lowest_near(vec2 at, float reach, vec2 own)
{
#ifdef ROUND
	float near = max(length(part_of_place(at)) - reach, 0.0);
	return -sqrt(max(body.x * body.x - near * near, 0.0));
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
// not touch the cell. n: normal of the ground, which may be as steep as STEEPEST.
int touch_room(vec3 n, ground g, object o, cell c)
{
	bool over = o.rests != UNDER_NONE;
	vec2 hill = -n.xy / n.z, at = c.at + c.middle;
#ifdef SHAPE_WHEEL
	float reach = 0.5 * scale.y / heading.z, steep = abs(dot(hill, heading.xy));
#else
	float reach = 0.5 * scale.y, steep = length(hill);
#endif
	float above = dot(hill, c.middle) + steep * reach - lowest_near(at, reach, c.own);
	float post = face_at(c.at, c.own).height, depth = over ? float(g.height - o.rests) : float(g.height - o.raised) - post * 1048576.0;
	float room = depth + max(above + post, 0.0) * 1048576.0;
	room += 1e-3 / scale.x + 2.4e-7 * abs(depth);
	return g.base != BASE_NODATA && (over || c.share > 0.0) ? int(clamp(ceil(room), -2e9, 2e9)) : -2000000000;
}
