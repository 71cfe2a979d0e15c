/* Used inside dem only. Computes heights between posts of a raster. */
#ifndef FURROW_DEM_KERNEL_H
#define FURROW_DEM_KERNEL_H

#include "dem/dem.h"

/* Part of a raster: heights of its posts in `rect`, row by row from the south, metres; NaN: nodata. */
struct dem_part {
	const double *heights;
	struct post_rect rect;
};

struct dem_kernel {
	enum dem_resample method;
	/* If a post of the result is a mean: the number of the raster's posts that are as wide, and as high, as it. Otherwise 1;
	 * then it is a sample of the interpolated surface. An average is always a mean, and its numbers may be below 1. */
	double span[2];
};

enum dem_sampled {
	DEM_SAMPLED_NONE,  /* the nearest post of the raster has no data, or there is none */
	DEM_SAMPLED_PART,  /* some of the posts around have no data, or lie beyond the raster */
	DEM_SAMPLED_WHOLE, /* all posts around have data */
};

/* Returns how many posts beyond a position, rounded down, the kernel needs along an axis. */
int64_t dem_kernel_reach(const struct dem_kernel *kernel, int axis);
/*
 * Computes the height at (column, row) of the raster, metres. A post is at whole numbers. The nearest post decides if there is a
 * height. Weights are GDAL's: of a mean, its kernels widened by `span`. Posts without data count for nothing. Thread-safe.
 */
enum dem_sampled dem_kernel_sample(const struct dem_kernel *kernel, const struct dem_part *part, double column, double row,
				   double *height);
/* Samples a run of positions; NaN: nowhere. Sets heights[i], NaN where there is none, and sampled[i], an enum
 * dem_sampled. */
void dem_kernel_run(const struct dem_kernel *kernel, const struct dem_part *part, int64_t count, const double *columns,
		    const double *rows, double *heights, uint8_t *sampled);

#endif
