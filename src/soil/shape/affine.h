/*
 * Affine functions of a post's position (i, j) in a window, as whole numbers: (at + i * di + j * dj) >> shift, in 64 bits. Shapes
 * of objects are described with them. shaders/lib/envelope.glsl evaluates them. Pure.
 */
#ifndef FURROW_SOIL_AFFINE_H
#define FURROW_SOIL_AFFINE_H

#include <stdint.h>

/* One such function, as the shader has it: std140 twin of `struct functional`. */
struct functional {
	uint32_t at_di[4], dj_shift[4];
};

/* A moving shape, as the shader has it: std140 twin of `struct body`. */
struct body {
	struct functional f[13];
	int32_t a[4], b[4], c[4], d[4], e[4]; /* shaders/lib/envelope.glsl tells what they hold */
};

/* The same kind of function in real numbers: at + x * dx + y * dy. x and y are in posts, counted from the object's anchor, a post
 * that depends on the object alone. */
struct affine {
	long double at, dx, dy;
};

/* Returns v times 2^n, exactly: as ldexpl, without its call. n: -1022 to 1023. */
static inline long double by_power(long double v, int n)
{
	const union {
		uint64_t bits;
		double value;
	} power = {.bits = (uint64_t)(n + 1023) << 52};
	return v * (long double)power.value;
}

#define FUNCTIONAL_POSTS 4096 /* how far from its anchor an object's windows may reach */

/* Converts `value` times 2^scale to whole numbers, rounded to nearest, for a window. The window's first post is (x0, y0) from the
 * anchor. The result has `shift` more bits, or as many as fit 62 bits. Coefficients are rounded before the anchor is moved, so
 * every window has the same bits at a post. A value that does not fit is halved until it fits: at nearly every post only its sign
 * matters. */
struct functional soil_functional_of(struct affine value, int scale, int shift, int64_t x0, int64_t y0);

#endif
