/* Kernels for resampling. All of them leave out posts without data and divide by the weights of the others. */
#include "dem_kernel.h"

#include <math.h>
#include <string.h>

#define NEAR_POST 1e-7 /* posts: a position so near to a post is at it */
#define TAPS_MOST 64   /* weights that are computed ahead, along a row */

int64_t dem_kernel_reach(const struct dem_kernel *kernel, int axis)
{
	double radius = kernel->method == DEM_CUBIC ? 2 : 1;
	return (int64_t)ceil(radius * kernel->span[axis]) + 1;
}

static bool post_of(const struct dem_part *part, int64_t x, int64_t y, double *height)
{
	const struct post_rect *rect = &part->rect;
	if (x < rect->x0 || y < rect->y0 || x >= rect->x1 || y >= rect->y1)
		return false;
	*height = part->heights[(y - rect->y0) * (rect->x1 - rect->x0) + x - rect->x0];
	return !isnan(*height);
}

static enum dem_sampled bilinear_part(const struct dem_part *part, double column, double row, double *height)
{
	double x0 = floor(column), y0 = floor(row), u = column - x0, v = row - y0, sum = 0, weights = 0, post;
	bool whole = true;
	for (int i = 0; i < 4; i++) {
		double weight = ((i & 1) != 0 ? u : 1 - u) * ((i & 2) != 0 ? v : 1 - v);
		if (weight == 0)
			continue;
		if (!post_of(part, (int64_t)x0 + (i & 1), (int64_t)y0 + (i >> 1), &post)) {
			whole = false;
			continue;
		}
		sum += weight * post;
		weights += weight;
	}
	*height = whole ? sum : sum / weights; /* the nearest post is one of them */
	return whole ? DEM_SAMPLED_WHOLE : DEM_SAMPLED_PART;
}

static enum dem_sampled bilinear(const struct dem_part *part, double column, double row, double *height)
{
	const struct post_rect *rect = &part->rect;
	int64_t x = (int64_t)floor(column), y = (int64_t)floor(row), stride = rect->x1 - rect->x0;
	if (x >= rect->x0 && y >= rect->y0 && x + 1 < rect->x1 && y + 1 < rect->y1) {
		const double *p = part->heights + (y - rect->y0) * stride + x - rect->x0;
		double u = column - (double)x, v = row - (double)y;
		double south = p[0] + (p[1] - p[0]) * u, north = p[stride] + (p[stride + 1] - p[stride]) * u;
		*height = south + (north - south) * v;
		if (!isnan(*height))
			return DEM_SAMPLED_WHOLE;
	}
	return bilinear_part(part, column, row, height);
}

static double cubic_weight(double off)
{
	double d = fabs(off);
	return d < 1 ? (1.5 * d - 2.5) * d * d + 1 : d < 2 ? ((-0.5 * d + 2.5) * d - 4) * d + 2 : 0;
}

/* Where a post around has no data, bilinear: a cubic would swing there. */
static enum dem_sampled cubic(const struct dem_part *part, double column, double row, double *height)
{
	double x0 = floor(column), y0 = floor(row), sum = 0, post;
	for (int j = -1; j <= 2; j++)
		for (int i = -1; i <= 2; i++) {
			double weight = cubic_weight(column - x0 - i) * cubic_weight(row - y0 - j);
			if (weight == 0)
				continue;
			if (!post_of(part, (int64_t)x0 + i, (int64_t)y0 + j, &post))
				return bilinear(part, column, row, height);
			sum += weight * post;
		}
	*height = sum;
	return DEM_SAMPLED_WHOLE;
}

static double mean_weight(enum dem_resample method, double off)
{
	return method == DEM_CUBIC ? cubic_weight(off) : fmax(0, 1 - fabs(off));
}

static enum dem_sampled mean(const struct dem_kernel *kernel, const struct dem_part *part, double column, double row,
			     double *height)
{
	const struct post_rect *rect = &part->rect;
	double radius = kernel->method == DEM_CUBIC ? 2 : 1, ahead[TAPS_MOST], sum = 0, weights = 0;
	double rx = radius * kernel->span[0], ry = radius * kernel->span[1];
	int64_t x0 = (int64_t)ceil(column - rx), x1 = (int64_t)floor(column + rx) + 1;
	int64_t y0 = (int64_t)ceil(row - ry), y1 = (int64_t)floor(row + ry) + 1;
	bool whole = x0 >= rect->x0 && y0 >= rect->y0 && x1 <= rect->x1 && y1 <= rect->y1;
	x0 = x0 > rect->x0 ? x0 : rect->x0;
	y0 = y0 > rect->y0 ? y0 : rect->y0;
	x1 = x1 < rect->x1 ? x1 : rect->x1;
	y1 = y1 < rect->y1 ? y1 : rect->y1;
	for (int64_t x = x0; x < x1 && x - x0 < TAPS_MOST; x++)
		ahead[x - x0] = mean_weight(kernel->method, ((double)x - column) / kernel->span[0]);
	for (int64_t y = y0; y < y1; y++) {
		double across = mean_weight(kernel->method, ((double)y - row) / kernel->span[1]), of_row = 0, seen = 0;
		const double *posts = part->heights + (y - rect->y0) * (rect->x1 - rect->x0) - rect->x0;
		for (int64_t x = x0; x < x1; x++) {
			double along = x - x0 < TAPS_MOST ? ahead[x - x0]
							  : mean_weight(kernel->method, ((double)x - column) / kernel->span[0]);
			bool known = !isnan(posts[x]);
			whole = whole && (known || along == 0);
			of_row += known ? along * posts[x] : 0;
			seen += known ? along : 0;
		}
		sum += across * of_row;
		weights += across * seen;
	}
	if (!(weights > 1e-6)) /* a cubic's negative weights outdo the others at a ragged edge */
		return bilinear(part, column, row, height);
	*height = sum / weights;
	return whole ? DEM_SAMPLED_WHOLE : DEM_SAMPLED_PART;
}

static double snap(double position)
{
	double post = rint(position);
	return fabs(position - post) < NEAR_POST ? post : position;
}

/* Samples that have all four posts in the part and data in all of them. Returns the count of samples done, from the first. */
static int64_t bilinear_run(const struct dem_part *part, int64_t count, const double *columns, const double *rows, double *heights)
{
	const struct post_rect *rect = &part->rect;
	int64_t stride = rect->x1 - rect->x0;
	double west = (double)rect->x0, south = (double)rect->y0, east = (double)rect->x1 - 1, north = (double)rect->y1 - 1;
	for (int64_t i = 0; i < count; i++) {
		if (!(columns[i] >= west && columns[i] < east && rows[i] >= south && rows[i] < north))
			return i;
		double column = columns[i] - west, row = rows[i] - south;
		int64_t x = (int64_t)column, y = (int64_t)row;
		const double *p = part->heights + y * stride + x;
		double u = column - (double)x, v = row - (double)y;
		double below = p[0] + (p[1] - p[0]) * u, above = p[stride] + (p[stride + 1] - p[stride]) * u;
		heights[i] = below + (above - below) * v;
		if (isnan(heights[i]))
			return i;
	}
	return count;
}

void dem_kernel_run(const struct dem_kernel *kernel, const struct dem_part *part, int64_t count, const double *columns,
		    const double *rows, double *heights, uint8_t *sampled)
{
	bool plain = kernel->method == DEM_BILINEAR && kernel->span[0] <= 1 && kernel->span[1] <= 1;
	for (int64_t i = 0; i < count; i++) {
		int64_t quick = plain ? bilinear_run(part, count - i, columns + i, rows + i, heights + i) : 0;
		memset(sampled + i, DEM_SAMPLED_WHOLE, (size_t)quick);
		i += quick;
		if (i == count)
			break;
		heights[i] = (double)NAN;
		sampled[i] = isnan(columns[i]) ? DEM_SAMPLED_NONE
					       : (uint8_t)dem_kernel_sample(kernel, part, columns[i], rows[i], &heights[i]);
	}
}

enum dem_sampled dem_kernel_sample(const struct dem_kernel *kernel, const struct dem_part *part, double column, double row,
				   double *height)
{
	column = snap(column);
	row = snap(row);
	if (!post_of(part, (int64_t)floor(column + 0.5), (int64_t)floor(row + 0.5), height))
		return DEM_SAMPLED_NONE;
	if (kernel->method == DEM_NEAR)
		return DEM_SAMPLED_WHOLE;
	if (kernel->span[0] > 1 || kernel->span[1] > 1)
		return mean(kernel, part, column, row, height);
	return kernel->method == DEM_CUBIC ? cubic(part, column, row, height) : bilinear(part, column, row, height);
}
