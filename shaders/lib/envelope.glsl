// The lower envelope of a moving object at a post of the window. All numbers are whole, so every driver gives the same result.
// Distances are in 2^-fine m, heights in fixed-point units (2^-20 m) from the window's own zero.

#include "lib/int64.glsl"
#include "lib/root.glsl"

const int ONE = 1 << 28;   // 1 as a fraction: of the motion, of a sine
const int REACH = (1 << 30) - 1;

// F(i, j) = at + i * di + j * dj, in 64 bits, then an arithmetic shift: what src/soil/shape/affine.h holds.
struct functional {
	ivec4 at_di;    // lo, hi of at; lo, hi of di
	ivec4 dj_shift; // lo, hi of dj; the shift
};

// Clamped, since far away only the sign matters.
int functional_int(ivec4 at_di, ivec4 dj_shift, ivec2 post)
{
	i64 at = i64(at_di.y, uint(at_di.x)), di = i64(at_di.w, uint(at_di.z));
	i64 dj = i64(dj_shift.y, uint(dj_shift.x));
	i64 sum = i64_add(at, i64_add(i64_mul_int(di, post.x), i64_mul_int(dj, post.y)));
	i64 v = i64_sar(sum, dj_shift.z);
	return i64_to_int(i64_clamp(v, i64_from(-REACH), i64_from(REACH)));
}

// (a * b) >> n, rounded to nearest; 1 <= n <= 62.
int scaled(int a, int b, int n)
{
	i64 half_unit = i64_shl(i64_from(1), n - 1);
	return i64_to_int(i64_sar(i64_add(i64_mul(a, b), half_unit), n));
}

#if defined PASSED && !defined SIDEWAYS
const int FUNCTIONALS = 2; // a straight wheel and a sphere need no more
#elif defined PASSED
const int FUNCTIONALS = 4; // of the end pose two
#else
const int FUNCTIONALS = 13;
#endif

struct body {
	functional f[FUNCTIONALS];
	ivec4 a; // wheel, sphere: radius, half the width, length of the motion, sine of its slope (of ONE)
	ivec4 b; // height of the centre, rise of the motion, rise per length, its shift
	ivec4 c; // x, w: from 2^-fine m to fixed-point units, factor and shift; y, z: wheel: moves sideways; box:
	         // number of planes, of slabs
#ifndef PASSED
	ivec4 d, e;
#endif
};

// Two: of the contact, of its end pose.
#ifdef PASSED
#ifdef WITH_ENVELOPE
const int BODIES = 5; // lib/part.glsl declares them
#else
const int BODIES = 0;
flat in ivec4 passed[PASSED]; // the parameters, from the vertex shader: passed.vert says why
#endif

// `count`: how many functionals are passed.
body body_from(int first, int count)
{
	functional f[FUNCTIONALS];
	for (int k = 0; k < FUNCTIONALS; k++)
		f[k] = functional(passed[first + (k < count ? 2 * k : 0)], passed[first + (k < count ? 2 * k : 0) + 1]);
	return body(f, passed[first + 2 * count], passed[first + 2 * count + 1], passed[first + 2 * count + 2]);
}

body bodies[2] = body[2](body_from(BODIES, FUNCTIONALS), body_from(BODIES + 2 * FUNCTIONALS + 3, 2));
#else
layout(std140, binding = 0) uniform params {
	body bodies[2];
};
#endif

#define AT(which, k, post) functional_int(bodies[which].f[k].at_di, bodies[which].f[k].dj_shift, post)

#ifdef SHAPE_WHEEL
// Functionals 0 and 1: the post's place along and across the motion, from the centre at the start. 2 and 3: the times, of ONE,
// at which the wheel's two sides pass over the post. They are used only if the wheel moves sideways (c.y).
bool envelope(int which, ivec2 post, out int height)
{
	ivec4 a = bodies[which].a, b = bodies[which].b, c = bodies[which].c;
	int u = AT(which, 0, post), r = a.x;
#ifdef SIDEWAYS
	int p = AT(which, 2, post), q = AT(which, 3, post);
	bool sideways = c.y != 0;
#else
	const int p = 0, q = 0;
	const bool sideways = false;
#endif
	int first = sideways ? max(0, min(p, q)) : 0, last = sideways ? min(ONE, max(p, q)) : ONE;
	bool covered = first <= last && (sideways || abs(AT(which, 1, post)) <= a.y);
	first = clamp(first, 0, ONE);
	last = clamp(last, 0, ONE);
	// x: distance from the centre to the post at the time when the wheel is lowest there. That is where the wheel is
	// tangent to its motion.
	int at_last = u - scaled(last, a.z, 28), at_first = u - scaled(first, a.z, 28);
	int low = max(at_last, -r), high = min(at_first, r);
	covered = covered && low <= high;
	int x = clamp(max(min(scaled(r, a.w, 28), high), low), -r, r);
	// A known time gives the rise more exactly than a place: a wheel may slide aside while it hardly rolls.
	bool lasts = x == at_last && (x != at_first || b.y < 0);
	int rise = lasts || x == at_first ? scaled(lasts ? last : first, b.y, 28) : scaled(u - x, b.z, b.w);
	int up = square_root(i64_sub(i64_mul(r, r), i64_mul(x, x)));
	height = b.x + rise - scaled(up, c.x, c.w);
	return covered;
}

#if defined PASSED || !defined SIDEWAYS
// The same for a motion of no length.
bool envelope_at_rest(int which, ivec2 post, out int height)
{
	ivec4 a = bodies[which].a, b = bodies[which].b, c = bodies[which].c;
	int r = a.x, u = AT(which, 0, post), x = clamp(u, -r, r);
	int up = square_root(i64_sub(i64_mul(r, r), i64_mul(x, x)));
	height = b.x + min(b.y, 0) - scaled(up, c.x, c.w);
	return u == x && abs(AT(which, 1, post)) <= a.y;
}
#define AT_REST
#endif
#endif

#if defined(SHAPE_SPHERE) || defined(SHAPE_ELLIPSOID)
// Functionals 0 and 1: the post's place along and across the motion. An ellipsoid is a sphere that was stretched, then sheared along the
// vertical: by functional 2.
bool envelope(int which, ivec2 post, out int height)
{
	int u = AT(which, 0, post), v = AT(which, 1, post), r = bodies[which].a.x;
	int across = clamp(v, -r, r);
	i64 ring_squared = i64_sub(i64_mul(r, r), i64_mul(across, across));
	int ring = square_root(ring_squared);
	int low = max(u - bodies[which].a.z, -ring), high = min(u, ring);
	int x = max(min(scaled(ring, bodies[which].a.w, 28), high), low);
	int bottom = square_root(i64_max(i64_sub(ring_squared, i64_mul(x, x)), i64_from(0)));
	int rise = bodies[which].a.z == 0 ? min(bodies[which].b.y, 0) : scaled(u - x, bodies[which].b.z, bodies[which].b.w);
	height = bodies[which].b.x + rise - scaled(bottom, bodies[which].c.x, bodies[which].c.w);
#ifdef SHAPE_ELLIPSOID
	height += AT(which, 2, post);
#endif
	return abs(v) <= r && low <= high;
}
#endif

#if defined(SHAPE_CYLINDER) || defined(SHAPE_CAPSULE)
// A shape that is round about an axis.
//
// The numbers of struct body are:
//
// - a: radius; half the length of the axis in plan; rise of the axis, of ONE; length of the motion of its ends
// - b: height of the centre at the start; rise of the motion; from 2^-fine m across the axis to units of height: factor, shift
// - c: the motion across and along the axis; by how much functionals 2 and 3 are higher at its end
// - d: 1: there is a flat face; from 2^-fine m of an end to units of height: factor, shift; height of a capsule's upper end
// - e: a capsule's ends: sine of the slope of their motion, of ONE; rise per length and its shift
//
// The functionals are:
//
// - 0, 1: place across and along the axis, from the centre at the start
// - 2: height of the axis above that centre; 3: height of a cylinder's lower end plane
// - 4 to 6 and 10 to 12: src/soil/shape/body.c, rod_ends; 7 to 9: rod_face

// The lower envelope of the shape at one time, above the centre at the start. v, a: place across and along the axis; axis: height of the
// axis there; end: of the lower end plane; centre: of the centre.
bool at_rest(int which, int v, int a, int axis, int end, int centre, out int height)
{
	ivec4 n = bodies[which].a, b = bodies[which].b, d = bodies[which].d;
	int across = clamp(v, -n.x, n.x);
	i64 squares = i64_sub(i64_mul(n.x, n.x), i64_mul(across, across));
	int strip = square_root(squares), middle = scaled(strip, n.z, 28), side = axis - scaled(strip, b.z, b.w);
#ifdef SHAPE_CAPSULE
	bool low = a <= middle - n.y, high = a > middle + n.y;
	int beyond = low ? a + n.y : a - n.y, x = clamp(beyond, -strip, strip);
	int bottom = square_root(i64_max(i64_sub(squares, i64_mul(x, x)), i64_from(0)));
	height = low || high ? centre + (low ? -d.w : d.w) - scaled(bottom, d.y, d.z) : side;
	return abs(v) <= n.x && (beyond == x || !low && !high);
#else
	height = n.z > 0 && a <= middle - n.y ? end : side;
	return abs(v) <= n.x && abs(a) <= middle + n.y;
#endif
}

// Lowers `height` to the lower envelope of one end while it moves. q, u: place across and along its motion.
#ifdef SHAPE_CAPSULE
void end_moves(int which, int q, int u, int above, inout int height)
{
	ivec4 n = bodies[which].a, d = bodies[which].d, e = bodies[which].e;
	int across = clamp(q, -n.x, n.x);
	i64 squares = i64_sub(i64_mul(n.x, n.x), i64_mul(across, across));
	int ring = square_root(squares), low = max(u - n.w, -ring), high = min(u, ring);
	int x = max(min(scaled(ring, e.x, 28), high), low);
	int bottom = square_root(i64_max(i64_sub(squares, i64_mul(x, x)), i64_from(0)));
	int z = above + scaled(u - x, e.y, e.z) - scaled(bottom, d.y, d.z);
	height = abs(q) <= n.x && low <= high ? min(height, z) : height;
}
#else
void end_moves(int which, int q, int u, int middle, inout int height)
{
	ivec4 n = bodies[which].a, d = bodies[which].d;
	int across = clamp(q, -n.x, n.x), ring = square_root(i64_sub(i64_mul(n.x, n.x), i64_mul(across, across)));
	// The rim passes over the post twice.
	int apart = scaled(ring, n.z, 28), lift = scaled(ring, d.y, d.z);
	bool covered = abs(q) <= n.x;
	height = covered && u - apart >= 0 && u - apart <= n.w ? min(height, middle - lift) : height;
	height = covered && u + apart >= 0 && u + apart <= n.w ? min(height, middle + lift) : height;
}
#endif

bool envelope(int which, ivec2 post, out int height)
{
	ivec4 b = bodies[which].b, c = bodies[which].c, d = bodies[which].d;
	int v = AT(which, 0, post), a = AT(which, 1, post), axis = AT(which, 2, post), end = AT(which, 3, post), there, lowest = REACH;
	if (at_rest(which, v, a, axis, end, 0, there))
		lowest = min(lowest, there);
	if ((b.y != 0 || c.x != 0 || c.y != 0) && at_rest(which, v - c.x, a - c.y, axis + c.z, end + c.w, b.y, there))
		lowest = min(lowest, there);
	if (bodies[which].a.w != 0) {
#ifdef SHAPE_CAPSULE
		end_moves(which, AT(which, 4, post), AT(which, 5, post), -d.w, lowest);
		end_moves(which, AT(which, 10, post), AT(which, 11, post), d.w, lowest);
#else
		end_moves(which, AT(which, 4, post), AT(which, 5, post), AT(which, 6, post), lowest);
		end_moves(which, AT(which, 10, post), AT(which, 11, post), AT(which, 12, post), lowest);
#endif
	}
	if (d.x != 0 && abs(AT(which, 8, post)) <= ONE && abs(AT(which, 9, post)) <= ONE)
		lowest = min(lowest, AT(which, 7, post));
	height = b.x + lowest;
	return lowest != REACH;
}

bool envelope_at_rest(int which, ivec2 post, out int height)
{
	bool covered = at_rest(which, AT(which, 0, post), AT(which, 1, post), AT(which, 2, post), AT(which, 3, post), 0, height);
	height += bodies[which].b.x;
	return covered;
}
#define AT_REST
#endif

#ifdef SHAPE_BOX
// A moving box is a zonotope. The post must lie inside all slabs (f[6] ..). The height is the highest of the lower planes (f[0] ..).
bool envelope(int which, ivec2 post, out int height)
{
	height = -REACH;
	for (int k = 0; k < bodies[which].c.z; k++)
		if (abs(AT(which, 6 + k, post)) > ONE)
			return false;
	for (int k = 0; k < bodies[which].c.y; k++)
		height = max(height, AT(which, k, post));
	return true;
}
#endif
