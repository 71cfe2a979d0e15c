/* What one tile's codes hold, and what leaving out every second post of them loses. */
#ifndef FURROW_DEM_MEASURE_H
#define FURROW_DEM_MEASURE_H

#include <stdint.h>

struct dem_measure {
	double low, high; /* metres; NaN both: nothing but nodata */
	double loss;      /* metres: most that a post is off the bilinear surface of the even ones */
};

/* Of (cells + 1)^2 codes. A post without data, or with a neighbour without, loses nothing. */
struct dem_measure dem_measure(const int32_t *codes, uint32_t cells, double step);

#endif
