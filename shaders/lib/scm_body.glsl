// The underside of an object between posts, in its end pose, and the part of a post's cell that it covers (SOIL.md). Places are in
// metres from the object's centre, in plan.

struct face {
	float height; // of the underside above the centre, m
	vec2 slope;   // its rise a metre
};

// own: slope of an underside that only the posts tell.
face face_at(vec2 at, vec2 own)
{
	face f = face(dot(own, at), own);
	if (body.x == ROUND) {
		vec2 part = mix(dot(at, heading.xy) * heading.xy, at, body.z);
		float up = sqrt(max(body.y * body.y - dot(part, part), 0.0));
		f = face(-up, part / max(up, body.y / STEEPEST));
	}
	if (body.x == FLAT) {
		f = face(-1e9, vec2(0.0));
		for (int k = 0; k < 3; k++) {
			float height = faces[k].x + dot(faces[k].yz, at);
			f.slope = height > f.height ? faces[k].yz : f.slope;
			f.height = max(f.height, height);
		}
	}
	return f;
}

vec3 normal_of_face(vec2 slope)
{
	slope *= min(1.0, STEEPEST * inversesqrt(max(dot(slope, slope), 1.0)));
	float up = inversesqrt(1.0 + dot(slope, slope));
	return vec3(-slope * up, up);
}

// Returns how much lower a round object has been above a place than it is now, on its last `back` metres; m.
float lowered_at(vec2 at, float back)
{
	float forward = dot(at, heading.xy);
	float squares = max(body.y * body.y - body.z * (dot(at, at) - forward * forward), 0.0), ring = sqrt(squares);
	float x = clamp(min(max(ring * moves.z, forward), forward + back), -ring, ring);
	float rose = sqrt(squares - x * x) + moves.y * (x - forward) - sqrt(max(squares - forward * forward, 0.0));
	return body.x == ROUND && moves.x > 0.0 ? max(rose, 0.0) : 0.0;
}

// Returns for how much of the contact, counted back from its end, the object has been deeper than `stays` below the surface. It is
// below 0 if it is not so deep at the end. Above 1: it was so before the contact too, if it moved then as it does now.
float contact_share(vec2 at, float depth, float stays, face now)
{
	float forward = dot(at, heading.xy), squares = body.y * body.y - body.z * (dot(at, at) - forward * forward);
	float change = way.z - face_at(at + way.xy, now.slope).height + now.height;
	float share = change < 0.0 ? (depth - stays) / -change : 1e3;
	if (body.x == ROUND && moves.x > 0.0) {
		float up = max(-now.height - depth + stays, body.y * 0.05);
		float first = sqrt(max(squares - up * up, 0.0)) - forward;
		first -= moves.y * first / min(moves.y - (forward + first) / up, -0.05);
		share = first / moves.x;
	}
	vec2 sides = vec2(heading.w, body.w), place = vec2(forward, heading.x * at.y - heading.y * at.x);
	vec2 speed = vec2(dot(way.xy, heading.xy), heading.x * way.y - heading.y * way.x);
	for (int k = 0; k < 2; k++)
		if (sides[k] > 0.0 && abs(speed[k]) > 1e-9)
			share = min(share, max(sides[k] - place[k] * sign(speed[k]), 0.0) / abs(speed[k]));
	return clamp(share, -4.0, 1e3);
}

// What a post bears of the object: the part of its cell below it, and what lies beyond the last post that it covers.
struct cell {
	vec2 at;     // the post
	vec2 middle; // of the part, from the post, m
	float share; // area of the part, in posts
	vec2 own;    // slope of an underside that only the posts tell
};

bool covers(ivec2 post)
{
	return all(greaterThanEqual(post, drawn.xy)) && all(lessThan(post, drawn.zw)) && imageLoad(rests, ivec3(post, zero.z)).r != UNDER_NONE;
}

// Returns what a post bears of a strip, in posts from it. at: its place across the strip; step: how far the next post is. A post on the
// strip's border counts as covered, as in the lower envelope.
vec2 part_of(float at, float size, float step)
{
	float covered = size + 1e-6 * size + 1e-7;
	return vec2(abs(at - step) <= covered ? -0.5 : max((-size - at) / step, -1.0), abs(at + step) <= covered ? 0.5 : min((size - at) / step, 1.0));
}

// A wheel may pass between two posts. The nearer one bears it.
bool between_posts()
{
	return heading.w == 0.0 && body.w > 0.0 && 2.0 * body.w < heading.z * scale.y;
}

cell cell_at(int x, int y, object o)
{
	bool over = o.rests != UNDER_NONE, northward = abs(heading.y) > abs(heading.x);
	vec2 side = vec2(-heading.y, heading.x);
	float step = heading.z * scale.y;
	cell c = cell(place.xy + scale.y * vec2(x, y), vec2(0.0), over ? 1.0 : 0.0, vec2(0.0));
	if (body.w > 0.0) {
		float at = dot(c.at, side);
		vec2 part = part_of(at, body.w, step);
		part = over ? part : between_posts() && abs(at - 1e-4 * step) <= 0.5 * step ? vec2(-body.w - at, body.w - at) / step : vec2(0.0);
		c.share = max(part.y - part.x, 0.0);
		c.middle = 0.5 * (part.x + part.y) * scale.y * (northward ? vec2(sign(side.x), 0.0) : vec2(0.0, sign(side.y)));
	}
	if (body.w > 0.0 && heading.w > 0.0) {
		vec2 part = part_of(dot(c.at, heading.xy), heading.w, step);
		c.share *= max(part.y - part.x, 0.0);
		c.middle += 0.5 * (part.x + part.y) * scale.y * (northward ? vec2(0.0, sign(heading.y)) : vec2(sign(heading.x), 0.0));
	}
	if (body.x == POSTS_ONLY && over)
		for (int k = 0; k < 2; k++) {
			ivec2 next = k == 0 ? ivec2(1, 0) : ivec2(0, 1);
			bool low = covers(ivec2(x, y) - next), high = covers(ivec2(x, y) + next);
			int from = imageLoad(rests, ivec3(ivec2(x, y) - (low ? next : ivec2(0)), zero.z)).r;
			int to = imageLoad(rests, ivec3(ivec2(x, y) + (high ? next : ivec2(0)), zero.z)).r;
			c.own[k] = float(to - from) * scale.x * (low && high ? 0.5 : 1.0);
		}
	return c;
}

// Returns how much higher the object can be raised and still touch a post's cell, fixed-point units; a little more. At or below 0 it
// surely does not touch it.
int touch_room(int x, int y, ground g, object o)
{
	face f = face_at(place.xy + scale.y * vec2(x, y), vec2(0.0));
	float depth = o.rests != UNDER_NONE ? float(g.height - o.rests) : between_posts() ? float(g.height - o.raised) - f.height * 1048576.0 : -1e9;
	// Over half a post the ground and the underside rise by at most about this.
	float rise = body.x == POSTS_ONLY ? 0.0 : (1.25 * length(f.slope) + 0.6) * 0.75 / scale.x;
	return g.base != BASE_NODATA ? int(clamp(ceil(depth + rise), -2e9, 2e9)) : -2000000000;
}

bool may_bear(int x, int y, ground g, object o)
{
	return touch_room(x, y, g, o) > 0;
}
