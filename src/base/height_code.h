/*
 * How a base height is stored as an int32 code, within the error asked for.
 *
 * step > 0: the code is the nearest multiple of `step` metres on the absolute lattice. height = code * step, with an error of
 * at most step / 2. step == 0: lossless float32. The code is the float's bits, mapped so that order is kept. Negative zero
 * becomes the code beside zero, and is read back as negative zero.
 */
#ifndef FURROW_BASE_HEIGHT_CODE_H
#define FURROW_BASE_HEIGHT_CODE_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#define HEIGHT_CODE_NODATA INT32_MIN
#define HEIGHT_MAX 1e8 /* metres, also downwards; no body goes beyond, and the lattice is exact within */

static inline int32_t height_code_of_float(float value)
{
	int32_t bits;
	memcpy(&bits, &value, sizeof bits);
	return bits >= 0 ? bits : (int32_t)(0x80000000u - (uint32_t)bits) - 1;
}

static inline float height_code_to_float(int32_t code)
{
	int32_t bits = code >= 0 ? code : (int32_t)(0x80000000u - (uint32_t)(code + 1));
	float value;
	memcpy(&value, &bits, sizeof value);
	return value;
}

/* Returns false if float32 would add to the error of heights up to `most` metres. It does above 16,384 m, if `step` is a multiple of 2^-10 m
 * and no power of two. */
static inline bool height_code_float_holds(double step, double most)
{
	int exponent;
	return step == 0 || frexp(step, &exponent) == 0.5 || fmod(step * 1024, 1) != 0 || most < 16384;
}

/* Codes a height. Returns false if this is not possible: it is infinite, too far from zero for the step, or (step 0) not a
 * float32. NaN means nodata and becomes HEIGHT_CODE_NODATA. */
static inline bool height_code_encode(double metres, double step, int32_t *code)
{
	if (isnan(metres)) {
		*code = HEIGHT_CODE_NODATA;
		return true;
	}
	if (!isfinite(metres))
		return false;
	if (step == 0) {
		float value = (float)metres;
		*code = height_code_of_float(value);
		return (double)value == metres && *code != HEIGHT_CODE_NODATA;
	}
	double units = metres / step;
	if (fabs(units) > 2147483000.0)
		return false;
	*code = (int32_t)nearbyint(units); /* ties to even */
	return true;
}

/* Codes a row of heights. Returns the number of coded heights: `count`, or the index of the first height that cannot be coded.
 * A height in the middle between two codes gets the even code. */
int64_t height_code_row(const double *metres, int64_t count, double step, int32_t *codes);

static inline double height_code_metres(int32_t code, double step)
{
	if (code == HEIGHT_CODE_NODATA)
		return (double)NAN;
	return step == 0 ? (double)height_code_to_float(code) : (double)code * step;
}

#endif
