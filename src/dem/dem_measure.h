/* Measures one tile's codes: their range, and the error when every second post is left out. */
#ifndef FURROW_DEM_MEASURE_H
#define FURROW_DEM_MEASURE_H

#include <stdint.h>

#include "base/misfit.h"

struct dem_measure {
	double low, high; /* metres; both NaN: all posts are nodata */
	double loss;      /* metres: largest height difference between a post and the bilinear surface of the even posts */
};

/* Measures (cells + 1)^2 codes. A nodata post, or a post beside a nodata post, has no loss. */
struct dem_measure dem_measure(const int32_t *codes, uint32_t cells, double step);
/* Adds by how much codes are off the heights that they were made from, metres. Holes count for nothing. */
void dem_measure_misfit(const double *heights, const int32_t *codes, int64_t count, double step, struct misfit *misfit);

#endif
