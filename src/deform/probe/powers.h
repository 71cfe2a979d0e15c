/*
 * Powers and exponentials of the soil's law, for loops over the lanes of a batch. They are plain sums and products, which a compiler turns into
 * vector instructions. Their relative error is below 1e-13. They give the same bits on every machine.
 *
 * A number is split into a power of two, which is exact, and a part near 1, for which a series is short. The series are that of the exponential,
 * and log(m) = 2 atanh((m - 1) / (m + 1)): Abramowitz and Stegun 1964, 4.2.1 and 4.1.27. Even and odd terms are added apart, which takes less time.
 */
#ifndef FURROW_DEFORM_PROBE_POWERS_H
#define FURROW_DEFORM_PROBE_POWERS_H

#include <stdint.h>
#include <string.h>

static inline uint64_t probe_bits(double v)
{
	uint64_t bits;
	memcpy(&bits, &v, sizeof bits);
	return bits;
}

static inline double probe_of_bits(uint64_t bits)
{
	double v;
	memcpy(&v, &bits, sizeof v);
	return v;
}

/* Returns 2^x. x: -1000 .. 1000. */
static inline double probe_exp2(double x)
{
	/* The sum has no bits below 1, and its low bits are the whole number. */
	const double shifted = x + 0x1.8p52, r = (x - (shifted - 0x1.8p52)) * 0.69314718055994530942;
	const double squares = r * r, odd = (((1.0 / 39916800 * squares + 1.0 / 362880) * squares + 1.0 / 5040) * squares + 1.0 / 120) * squares + 1.0 / 6;
	const double even = (((1.0 / 3628800 * squares + 1.0 / 40320) * squares + 1.0 / 720) * squares + 1.0 / 24) * squares + 0.5;
	const double sum = 1 + (r + squares * (even + r * odd));
	return sum * probe_of_bits((probe_bits(shifted) << 52) + 0x3ff0000000000000u);
}

/* Returns log2(v). v: positive, not subnormal. */
static inline double probe_log2(double v)
{
	/* v = 2^k m, m between sqrt(1/2) and sqrt(2). */
	const uint64_t bits = probe_bits(v), raised = (bits - 0x3fe6a09e667f3bcdu + 0x3ff0000000000000u) >> 52;
	const double k = probe_of_bits(raised | 0x4330000000000000u) - (0x1p52 + 1023), m = probe_of_bits(bits - ((raised - 1023) << 52));
	const double s = (m - 1) / (m + 1), squares = s * s;
	const double fourths = squares * squares, odd = ((1.0 / 15 * fourths + 1.0 / 11) * fourths + 1.0 / 7) * fourths + 1.0 / 3;
	const double even = (((1.0 / 17 * fourths + 1.0 / 13) * fourths + 1.0 / 9) * fourths + 1.0 / 5) * fourths + 1, sum = even + squares * odd;
	return k + s * sum * 2.8853900817779268147;
}

/* Returns v^n. v: positive, not subnormal; n log2(v): -1000 .. 1000. */
static inline double probe_pow(double v, double n)
{
	return probe_exp2(n * probe_log2(v));
}

/* Returns e^-v. v: 0 .. 600. */
static inline double probe_exp_minus(double v)
{
	return probe_exp2(-1.4426950408889634074 * v);
}

/* Returns -ln(v). v: positive, not subnormal. */
static inline double probe_minus_log(double v)
{
	return -0.69314718055994530942 * probe_log2(v);
}

#endif
