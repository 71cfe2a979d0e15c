/*
 * Measures a tile, in one of two ways. The plain way computes with heights, for tiles with holes and floats. Most tiles go the
 * other way: it computes with whole codes, which the compiler turns into vector code. Both give the same results. Only the
 * rounding of a loss differs where the step is no power of two.
 */
#include "dem_measure.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/height_code.h"
#include "base/wide.h"

#define RANGE_MOST (1 << 28) /* of codes: four times as much, and a sign, fit 32 bits */

/* --- any codes --- */

static double off_mean(double step, int32_t post, const int32_t *kept, int count)
{
	if (post == HEIGHT_CODE_NODATA)
		return 0;
	double sum = 0;
	for (int i = 0; i < count; i++) {
		if (kept[i] == HEIGHT_CODE_NODATA)
			return 0;
		sum += height_code_metres(kept[i], step);
	}
	return fabs(height_code_metres(post, step) - sum / count);
}

static double loss_of_heights(const int32_t *codes, uint32_t cells, double step)
{
	ptrdiff_t stride = (ptrdiff_t)cells + 1;
	double most = 0;
	for (uint32_t y = 0; y < cells + 1; y++) {
		for (uint32_t x = (y & 1) ? 0 : 1; x < cells + 1; x += (y & 1) ? 1 : 2) {
			const int32_t *p = codes + y * stride + x;
			double off;
			if ((x & 1) != 0 && (y & 1) != 0)
				off = off_mean(step, *p, (int32_t[]){p[-stride - 1], p[-stride + 1], p[stride - 1],
								     p[stride + 1]}, 4);
			else if ((x & 1) != 0)
				off = off_mean(step, *p, (int32_t[]){p[-1], p[1]}, 2);
			else
				off = off_mean(step, *p, (int32_t[]){p[-stride], p[stride]}, 2);
			most = off > most ? off : most;
		}
	}
	return most;
}

/* --- codes near each other, without holes: quarters of a step, modulo 2^32 --- */

static inline int32_t larger_size(int32_t most, uint32_t off)
{
	int32_t size = (int32_t)off < 0 ? (int32_t)(0 - off) : (int32_t)off;
	return size > most ? size : most;
}

/* Even posts go along with the odd ones and count for nothing: so that it becomes vector code. */
static inline int32_t loss_along(const uint32_t *row, uint32_t cells, int32_t most)
{
	for (uint32_t x = 1; x < cells; x++)
		most = larger_size(most, (x & 1) * 2 * (2 * row[x] - row[x - 1] - row[x + 1]));
	return most;
}

static inline int32_t loss_between(const uint32_t *south, const uint32_t *row, const uint32_t *north, uint32_t cells,
				   int32_t most)
{
	most = larger_size(most, 2 * (2 * row[0] - south[0] - north[0]));
	for (uint32_t x = 1; x < cells; x++) {
		uint32_t above = south[x] + north[x], beside = south[x - 1] + south[x + 1] + north[x - 1] + north[x + 1];
		most = larger_size(most, 4 * row[x] - ((x & 1) != 0 ? beside : 2 * above));
	}
	return larger_size(most, 2 * (2 * row[cells] - south[cells] - north[cells]));
}

FURROW_WIDE static double loss_of_steps(const int32_t *codes, uint32_t cells, double step)
{
	uint32_t stride = cells + 1;
	int32_t most = 0;
	for (uint32_t y = 0; y < stride; y++) {
		const uint32_t *row = (const uint32_t *)codes + (size_t)y * stride;
		most = y % 2 == 0 ? loss_along(row, cells, most)
				  : loss_between(row - stride, row, row + stride, cells, most);
	}
	return most * step / 4;
}

struct code_range {
	int32_t low, high; /* low above high: nothing but holes */
	bool holes;
};

FURROW_WIDE static struct code_range code_range_of(const int32_t *codes, size_t count)
{
	int32_t low = INT32_MAX, high = INT32_MIN;
	int32_t holes = 0;
	for (size_t i = 0; i < count; i++) {
		int32_t above = codes[i] == HEIGHT_CODE_NODATA ? INT32_MAX : codes[i];
		low = above < low ? above : low;
		high = codes[i] > high ? codes[i] : high; /* a hole is the lowest code */
		holes |= codes[i] == HEIGHT_CODE_NODATA;
	}
	return (struct code_range){low, high, holes != 0};
}

struct dem_measure dem_measure(const int32_t *codes, uint32_t cells, double step)
{
	struct code_range extent = code_range_of(codes, (size_t)(cells + 1) * (cells + 1));
	struct dem_measure measure = {(double)NAN, (double)NAN, 0};
	if (extent.low > extent.high)
		return measure;
	/* Codes keep the order of heights, so the extremes are the decoded codes'. */
	measure.low = height_code_metres(extent.low, step);
	measure.high = height_code_metres(extent.high, step);
	bool near = step > 0 && !extent.holes && (int64_t)extent.high - extent.low < RANGE_MOST;
	measure.loss = near ? loss_of_steps(codes, cells, step) : loss_of_heights(codes, cells, step);
	return measure;
}

/* --- codes beside their heights --- */

#define LANES 8 /* sums of their own, so that the compiler makes vector code of them and their order is always the same */

FURROW_WIDE static void misfit_of_steps(const double *heights, const int32_t *codes, int64_t count, double step, double greatest[LANES],
					double squares[LANES])
{
	for (int64_t i = 0; i + LANES <= count; i += LANES)
		for (int k = 0; k < LANES; k++) {
			double off = fabs((double)codes[i + k] * step - heights[i + k]);
			off = codes[i + k] == HEIGHT_CODE_NODATA ? 0 : off;
			greatest[k] = off > greatest[k] ? off : greatest[k];
			squares[k] += off * off;
		}
}

void dem_measure_misfit(const double *heights, const int32_t *codes, int64_t count, double step, struct misfit *misfit)
{
	double greatest[LANES] = {0}, squares[LANES] = {0};
	int64_t posts = 0, whole = count - count % LANES;
	for (int64_t i = 0; i < count; i++)
		posts += codes[i] != HEIGHT_CODE_NODATA;
	misfit->posts += posts;
	if (step == 0) /* codes are the heights themselves */
		return;
	misfit_of_steps(heights, codes, whole, step, greatest, squares);
	for (int k = 0; k < LANES; k++)
		misfit_add(misfit, &(struct misfit){0, greatest[k], squares[k]});
	for (int64_t i = whole; i < count; i++) {
		double off = codes[i] != HEIGHT_CODE_NODATA ? codes[i] * step - heights[i] : 0;
		misfit_add(misfit, &(struct misfit){0, fabs(off), off * off});
	}
}
