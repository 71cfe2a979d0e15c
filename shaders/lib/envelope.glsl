// The lower envelope of a moving object at a post of the window. All numbers are whole, so every driver gives the same result.
// Distances are in 2^-fine m, heights in fixed-point units (2^-20 m) from the window's own zero.

#include "lib/int64.glsl"
#include "lib/root.glsl"

const int ONE = 1 << 28;   // 1 as a fraction: of the motion, of a sine
const int REACH = (1 << 30) - 1;

// F(i, j) = at + i * di + j * dj, in 64 bits, then an arithmetic shift: what src/deform/shape/affine.h holds.
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

#ifdef PASSED
const int FUNCTIONALS = 2; // a straight wheel and a sphere need no more
#else
const int FUNCTIONALS = 10;
#endif

struct body {
	functional f[FUNCTIONALS];
	ivec4 a; // wheel, sphere: radius, half the width, length of the motion, sine of its slope (of ONE)
	ivec4 b; // height of the centre, rise of the motion, rise per length, its shift
	ivec4 c; // x, w: from 2^-fine m to fixed-point units, factor and shift; y, z: wheel: moves sideways; box:
	         // number of planes, of slabs
};

// Two: of the contact, of its end pose.
#ifdef PASSED
flat in ivec4 passed[PASSED]; // the parameters, from the vertex shader: passed.vert says why

body body_from(int first)
{
	functional f[FUNCTIONALS] = functional[FUNCTIONALS](functional(passed[first], passed[first + 1]), functional(passed[first + 2], passed[first + 3]));
	return body(f, passed[first + 4], passed[first + 5], passed[first + 6]);
}

body bodies[2] = body[2](body_from(0), body_from(PASSED / 2));
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

#ifndef SIDEWAYS
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

#ifdef SHAPE_SPHERE
// Functionals 0 and 1: the post's place along and across the motion.
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
	return abs(v) <= r && low <= high;
}
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
