/* Measures one tile's codes: their range, and the error when every second post is left out. */
#ifndef FURROW_DEM_MEASURE_H
#define FURROW_DEM_MEASURE_H

#include <stdint.h>

struct dem_measure {
	double low, high; /* metres; both NaN: all posts are nodata */
	double loss;      /* metres: largest height difference between a post and the bilinear surface of the even posts */
};

/* Measures (cells + 1)^2 codes. A nodata post, or a post beside a nodata post, has no loss. */
struct dem_measure dem_measure(const int32_t *codes, uint32_t cells, double step);

#endif
