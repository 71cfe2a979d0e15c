/*
 * How a stored base height is written as an int32 code, without loss beyond the asked error.
 *
 * step > 0: code = the nearest multiple of `step` metres on the absolute lattice, height =
 * code * step, error at most step / 2. step == 0: lossless float32, the code is its bits mapped so
 * that order is kept (negative zero becomes zero's neighbour and comes back as itself).
 */
#ifndef FURROW_BASE_HEIGHT_CODE_H
#define FURROW_BASE_HEIGHT_CODE_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#define HEIGHT_CODE_NODATA INT32_MIN
#define HEIGHT_MAX 1e8 /* metres either way; beyond no body goes, and the lattice is exact */

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

/* False if the height cannot be coded: infinite, too far from zero for the step, or (step 0) not a
 * float32. NaN is nodata and codes as HEIGHT_CODE_NODATA. */
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

/* A row of them; returns how many were coded: `count`, or where the first is that cannot be. Ties between
 * two codes go to the even one. */
int64_t height_code_row(const double *metres, int64_t count, double step, int32_t *codes);

static inline double height_code_metres(int32_t code, double step)
{
	if (code == HEIGHT_CODE_NODATA)
		return (double)NAN;
	return step == 0 ? (double)height_code_to_float(code) : (double)code * step;
}

#endif
