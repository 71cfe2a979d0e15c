/*
 * Affine functionals of a post's place (i, j) in a window: (at + i * di + j * dj) >> shift, in 64 bits.
 * shaders/lib/envelope.glsl evaluates them. Pure.
 */
#ifndef FURROW_DEFORM_AFFINE_H
#define FURROW_DEFORM_AFFINE_H

#include <stdint.h>

/* std140 twin of `struct functional`. */
struct functional {
	uint32_t at_di[4], dj_shift[4];
};

/* std140 twin of `struct body`. */
struct body {
	struct functional f[10];
	int32_t a[4], b[4], c[4]; /* shaders/lib/envelope.glsl tells what they hold */
};

/* A real functional at + x * dx + y * dy of posts around an object. x and y count from the object's anchor, a post that depends
 * on the object alone. */
struct affine {
	long double at, dx, dy;
};

/* Returns `value` times 2^scale for a window whose first post is (x0, y0) from the anchor, rounded to nearest. It keeps `shift`
 * more bits, or as many as fit 62 bits. Coefficients are rounded before the anchor is moved, so every window has the same bits
 * at a post. A value that does not fit at all is halved until it does: at nearly every post only its sign matters. */
struct functional deform_functional_of(struct affine value, int scale, int shift, int64_t x0, int64_t y0);

#endif
