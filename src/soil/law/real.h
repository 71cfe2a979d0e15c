/*
 * Numbers of the soil's law: single precision, in loops over lanes that a compiler turns into vector instructions. Sums, products, quotients and
 * square roots only, so a result has the same bits on every machine and for every width of its vectors.
 *
 * exp and log split a number into a power of two, which is exact, and a part near 1. For that a short series is enough: the exponential
 * series, and log(m) = 2 atanh((m - 1) / (m + 1)): Abramowitz and Stegun 1964, 4.2.1 and 4.1.27. Pure.
 */
#ifndef FURROW_SOIL_REAL_H
#define FURROW_SOIL_REAL_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "soil/lanes.h"

SOIL_INLINED float least(float a, float b)
{
	return a < b ? a : b;
}

SOIL_INLINED float most(float a, float b)
{
	return a > b ? a : b;
}

SOIL_INLINED float clamped(float v, float low, float high)
{
	return least(most(v, low), high);
}

/* Returns one of two numbers. Both are computed, so that a loop over lanes has no branch. */
SOIL_INLINED float either(bool first, float a, float b)
{
	return first ? a : b;
}

SOIL_INLINED float root(float squares)
{
	return sqrtf(most(squares, 0));
}

SOIL_INLINED uint32_t bits_of(float v)
{
	uint32_t bits;
	memcpy(&bits, &v, sizeof bits);
	return bits;
}

SOIL_INLINED float of_bits(uint32_t bits)
{
	float v;
	memcpy(&v, &bits, sizeof v);
	return v;
}

/* Returns 2^x, x -126 .. 126. Relative error: below 2e-7. */
SOIL_INLINED float exp2_of(float x)
{
	/* The sum has no bits below 1, and its low bits are the whole number. */
	const float shifted = x + 0x1.8p23f, r = (x - (shifted - 0x1.8p23f)) * 0.69314718f;
	const float squares = r * r, even = ((1 / 720.0f * squares + 1 / 24.0f) * squares + 0.5f) * squares;
	const float odd = ((1 / 5040.0f * squares + 1 / 120.0f) * squares + 1 / 6.0f) * squares + 1;
	return (1 + (even + r * odd)) * of_bits((bits_of(shifted) << 23) + 0x3f800000u);
}

/* Returns log2(v) of a positive v that is not subnormal. Error: below 1e-7 and 2e-7 of the result. */
SOIL_INLINED float log2_of(float v)
{
	/* v = 2^k m, m between sqrt(1/2) and sqrt(2). */
	const uint32_t bits = bits_of(v), raised = (bits - 0x3f3504f3u + 0x3f800000u) >> 23;
	const float k = (float)((int32_t)raised - 127), m = of_bits(bits - ((raised - 127) << 23));
	const float s = (m - 1) / (m + 1), squares = s * s;
	return k + s * ((((1 / 9.0f * squares + 1 / 7.0f) * squares + 1 / 5.0f) * squares + 1 / 3.0f) * squares + 1) * 2.8853901f;
}

/* Returns v^n. v: as in log2_of. A result outside of 2^-126 .. 2^126 is taken as the nearer of these. */
SOIL_INLINED float power_of(float v, float n)
{
	return exp2_of(clamped(n * log2_of(v), -126, 126));
}

/* Returns e^-v, v 0 or more. */
SOIL_INLINED float exp_minus(float v)
{
	return exp2_of(-1.4426950f * least(v, 80));
}

/* Rounds to the nearest whole number, halves away from 0; beyond 2^22 to a number that is at most 1 away. v: -2147483000 .. 2147483000. */
SOIL_INLINED int32_t whole_of(float v)
{
	return (int32_t)(v + (v < 0 ? -0.5f : 0.5f));
}

SOIL_INLINED float dot3(const float a[3], const float b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

SOIL_INLINED void cross3(const float a[3], const float b[3], float out[3])
{
	out[0] = a[1] * b[2] - a[2] * b[1];
	out[1] = a[2] * b[0] - a[0] * b[2];
	out[2] = a[0] * b[1] - a[1] * b[0];
}

#endif
