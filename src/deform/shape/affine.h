/*
 * Affine functionals of a post's place (i, j) in a window, as shaders/lib/envelope.glsl evaluates
 * them: at + i * di + j * dj in 64 bits, shifted right by `shift`. Pure.
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
	int32_t a[4], b[4], c[4]; /* what they hold: shaders/lib/envelope.glsl */
};

/* A real at + x * dx + y * dy of the posts around an object; x and y counted from its anchor, a post
 * that the object alone determines. */
struct affine {
	long double at, dx, dy;
};

/* The same times 2^scale for the window whose first post is (x0, y0) from the anchor, rounded to
 * nearest; kept with `shift` more bits, or with what fits 62 bits. Rounded before it is moved: every
 * window sees the same bits at a post. What does not fit at all is halved down until it does: at nearly every
 * post only its sign counts. */
struct functional deform_functional_of(struct affine value, int scale, int shift, int64_t x0, int64_t y0);

#endif
