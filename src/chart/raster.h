/* What the files of a map raster share: raster.c reads its values, raster_shade.c shades it. */
#ifndef FURROW_CHART_RASTER_H
#define FURROW_CHART_RASTER_H

#include "chart/internal.h"

#define RASTER_STRIP 128 /* rows that are read together */

struct rasterizing {
	const struct chart_raster_params *params;
	const struct extent *extent;
	struct chart_raster *raster;
	float *offset; /* of each pixel, if offsets change the shade; NULL: they do not */
	int working;
	bool deformed;
	int64_t done, total; /* for the progress function */
};

/* Tells the progress function of `more` rows or tiles. */
enum status chart_raster_tell(struct rasterizing *s, int64_t more) FURROW_CHECKED;
/* Fills raster->shade, of the base and s->offset. */
enum status chart_raster_shade(struct rasterizing *s) FURROW_CHECKED;

#endif
