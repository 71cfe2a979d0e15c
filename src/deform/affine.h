/*
 * Affine functionals of a post's place (i, j) in a window, as shaders/lib/underside.glsl evaluates
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
	int32_t a[4], b[4], c[4]; /* what they hold: shaders/lib/underside.glsl */
};

/* value(i, j) = (at + i * di + j * dj) * 2^scale, kept with `shift` more bits. What does not fit 62
 * bits is halved down until it does: it lies beyond every window, only its sign counts. */
struct functional functional_of(long double at, long double di, long double dj, int scale, int shift);

#endif
