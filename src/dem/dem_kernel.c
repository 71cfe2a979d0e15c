/* Kernels for resampling. All of them leave out posts without data and divide by the weights of the others. */
#include "dem_kernel.h"

#include <math.h>
#include <string.h>

#define NEAR_POST 1e-7 /* posts: a position so near to a post is at it */
#define LANCZOS_RADIUS 3
#define RADIUS_MOST LANCZOS_RADIUS
#define TAPS_MOST 64   /* weights that are computed ahead, along a row */

/* Returns how far from a position posts still have a weight. */
static double radius_of(const struct dem_kernel *kernel, int axis)
{
	const double span = kernel->span[axis];
	switch (kernel->method) {
	case DEM_CUBIC:
		return 2 * span;
	case DEM_LANCZOS:
		return LANCZOS_RADIUS * span;
	case DEM_AVERAGE:
		return (span + 1) / 2;
	case DEM_BILINEAR:
	case DEM_NEAR:
		break;
	}
	return span;
}

int64_t dem_kernel_reach(const struct dem_kernel *kernel, int axis)
{
	return (int64_t)ceil(radius_of(kernel, axis)) + 1;
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

static double lanczos_weight(double off)
{
	const double x = M_PI * off;
	if (off == 0)
		return 1;
	return fabs(off) < LANCZOS_RADIUS ? LANCZOS_RADIUS * sin(x) * sin(x / LANCZOS_RADIUS) / (x * x) : 0;
}

/* The weight of a post that is `off` posts from the position. */
static double weight_of(enum dem_resample method, double span, double off)
{
	switch (method) {
	case DEM_CUBIC:
		return cubic_weight(off / span);
	case DEM_LANCZOS:
		return lanczos_weight(off / span);
	case DEM_AVERAGE: /* how much of the post's own width lies in the mean's */
		return fmax(0, fmin((span + 1) / 2 - fabs(off), fmin(1, span)));
	case DEM_BILINEAR:
	case DEM_NEAR:
		break;
	}
	return fmax(0, 1 - fabs(off / span));
}

/* A kernel that is not widened, of 2 `radius` posts each way. Where a post around has no data, bilinear: it would swing there. */
static enum dem_sampled narrow(enum dem_resample method, int radius, const struct dem_part *part, double column, double row, double *height)
{
	double x0 = floor(column), y0 = floor(row), along[2 * RADIUS_MOST], across[2 * RADIUS_MOST], sum = 0, weights = 0, post;
	for (int i = 0; i < 2 * radius; i++) {
		along[i] = weight_of(method, 1, column - x0 - (i + 1 - radius));
		across[i] = weight_of(method, 1, row - y0 - (i + 1 - radius));
	}
	for (int j = 1 - radius; j <= radius; j++)
		for (int i = 1 - radius; i <= radius; i++) {
			double weight = along[i - 1 + radius] * across[j - 1 + radius];
			if (weight == 0)
				continue;
			if (!post_of(part, (int64_t)x0 + i, (int64_t)y0 + j, &post))
				return bilinear(part, column, row, height);
			sum += weight * post;
			weights += weight;
		}
	*height = method == DEM_LANCZOS ? sum / weights : sum; /* a cubic's weights are 1 together */
	return DEM_SAMPLED_WHOLE;
}

static enum dem_sampled mean(const struct dem_kernel *kernel, const struct dem_part *part, double column, double row,
			     double *height)
{
	const struct post_rect *rect = &part->rect;
	double ahead[TAPS_MOST], sum = 0, weights = 0;
	double rx = radius_of(kernel, 0), ry = radius_of(kernel, 1);
	int64_t x0 = (int64_t)ceil(column - rx), x1 = (int64_t)floor(column + rx) + 1;
	int64_t y0 = (int64_t)ceil(row - ry), y1 = (int64_t)floor(row + ry) + 1;
	bool whole = x0 >= rect->x0 && y0 >= rect->y0 && x1 <= rect->x1 && y1 <= rect->y1;
	x0 = x0 > rect->x0 ? x0 : rect->x0;
	y0 = y0 > rect->y0 ? y0 : rect->y0;
	x1 = x1 < rect->x1 ? x1 : rect->x1;
	y1 = y1 < rect->y1 ? y1 : rect->y1;
	for (int64_t x = x0; x < x1 && x - x0 < TAPS_MOST; x++)
		ahead[x - x0] = weight_of(kernel->method, kernel->span[0], (double)x - column);
	for (int64_t y = y0; y < y1; y++) {
		double across = weight_of(kernel->method, kernel->span[1], (double)y - row), of_row = 0, seen = 0;
		const double *posts = part->heights + (y - rect->y0) * (rect->x1 - rect->x0) - rect->x0;
		for (int64_t x = x0; x < x1; x++) {
			double along = x - x0 < TAPS_MOST ? ahead[x - x0]
							  : weight_of(kernel->method, kernel->span[0], (double)x - column);
			bool known = !isnan(posts[x]);
			whole = whole && (known || along == 0);
			of_row += known ? along * posts[x] : 0;
			seen += known ? along : 0;
		}
		sum += across * of_row;
		weights += across * seen;
	}
	if (!(weights > 1e-6)) /* the others' negative weights outdo the others at a ragged edge */
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
	if (kernel->span[0] > 1 || kernel->span[1] > 1 || kernel->method == DEM_AVERAGE)
		return mean(kernel, part, column, row, height);
	if (kernel->method == DEM_LANCZOS)
		return narrow(kernel->method, LANCZOS_RADIUS, part, column, row, height);
	return kernel->method == DEM_CUBIC ? narrow(kernel->method, 2, part, column, row, height) : bilinear(part, column, row, height);
}
