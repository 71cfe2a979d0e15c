/*
 * Whole numbers at posts of a row, as shaders/lib/{envelope,root,int64}.glsl compute them. Loops run over LANES posts at once and have no
 * branch, so that the compiler turns them into vector instructions. Results that do not fit 32 bits wrap, as in a shader. Pure.
 */
#ifndef FURROW_SOIL_ROWS_H
#define FURROW_SOIL_ROWS_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "soil/lanes.h"
#include "soil/shape/affine.h"

#define LANES 16
/* A loop over the lanes. gcc must not unroll it before it makes vector instructions of it. */
#ifdef __clang__
#define EACH_LANE(i) for (int i = 0; i < LANES; i++)
#else
#define EACH_LANE(i) _Pragma("GCC unroll 1") for (int i = 0; i < LANES; i++)
#endif

#define UNDER_NONE INT32_MAX         /* in a lower envelope: the body is not above the post */
#define ENVELOPE_ONE (1 << 28)       /* 1 as a fraction: of the motion, of a sine */
#define ENVELOPE_REACH ((1 << 30) - 1)

SOIL_INLINED int32_t lane_least(int32_t a, int32_t b)
{
	return a < b ? a : b;
}

SOIL_INLINED int32_t lane_most(int32_t a, int32_t b)
{
	return a > b ? a : b;
}

SOIL_INLINED int32_t lane_clamp(int32_t v, int32_t low, int32_t high)
{
	return lane_least(lane_most(v, low), high);
}

SOIL_INLINED int32_t lane_size(int32_t v)
{
	return v < 0 ? -v : v;
}

SOIL_INLINED int64_t lane_product(int32_t a, int32_t b)
{
	return (int64_t)a * b;
}

/* Returns the low 32 bits of a sum that may not fit them. */
SOIL_INLINED int32_t lane_sum(int32_t a, int32_t b)
{
	return (int32_t)((uint32_t)a + (uint32_t)b);
}

/* Returns (a * b) >> n, rounded to nearest; 1 <= n <= 62. */
SOIL_INLINED int32_t lane_scaled(int32_t a, int32_t b, int n)
{
	return (int32_t)((lane_product(a, b) + ((int64_t)1 << (n - 1))) >> n);
}

/* Returns floor(sqrt(d)), 0 <= d < 2^61. The square root in doubles is wrong by 1 at most. */
SOIL_INLINED int32_t lane_root(int64_t d)
{
	double high = (double)(int32_t)(d >> 31), low = (double)(int32_t)(d & 0x7fffffff);
	int32_t q = (int32_t)sqrt(high * 0x1p31 + low);
	int64_t rest = d - lane_product(q, q);
	return q - (rest < 0) + (rest > 2 * (int64_t)q);
}

/* A functional, unpacked. */
struct lane_affine {
	int64_t at, di, dj;
	int shift;
};

SOIL_INLINED struct lane_affine lane_affine_of(const struct functional *f)
{
	return (struct lane_affine){
		(int64_t)((uint64_t)f->at_di[1] << 32 | f->at_di[0]), (int64_t)((uint64_t)f->at_di[3] << 32 | f->at_di[2]),
		(int64_t)((uint64_t)f->dj_shift[1] << 32 | f->dj_shift[0]), (int)f->dj_shift[2],
	};
}

/* Computes the functional at LANES posts from (x, y) on, to the east. Far away only the sign matters, so it is clamped. */
SOIL_INLINED void lane_values(const struct functional *functional, int32_t x, int32_t y, int32_t values[LANES])
{
	const struct lane_affine f = lane_affine_of(functional);
	const uint64_t first = (uint64_t)f.at + (uint64_t)f.di * (uint64_t)(int64_t)x + (uint64_t)f.dj * (uint64_t)(int64_t)y;
	EACH_LANE(i) {
		int64_t v = (int64_t)(first + (uint64_t)f.di * (uint64_t)i) >> f.shift;
		v = v < -ENVELOPE_REACH ? -ENVELOPE_REACH : v;
		values[i] = (int32_t)(v > ENVELOPE_REACH ? ENVELOPE_REACH : v);
	}
}

#endif
