/* Used inside dem only. A raster of soil classes, read as PNG or with GDAL, and the position of its pixels. */
#ifndef FURROW_DEM_CLASSES_H
#define FURROW_DEM_CLASSES_H

#include "dem_internal.h"

#define DEM_CLASS_NONE INT32_MIN     /* value of a pixel that is nodata */
#define DEM_CLASSES_WINDOW (1 << 20) /* most pixels that are read at once */

struct dem_raster_of_classes {
	/* Converts positions in place. In: posts of level 0, counted from the south-west post. Out: columns and rows of the
	 * raster, counted from its north-west corner. The middle of the first pixel is (0.5, 0.5). NaN: outside of the raster. */
	void (*locate)(struct dem_raster_of_classes *raster, size_t count, double *x, double *y);
	/* Reads values of pixels. Rows from the north; at most DEM_CLASSES_WINDOW pixels. */
	enum status (*window)(struct dem_raster_of_classes *raster, struct post_rect pixels, int32_t *values);
	void (*destroy)(struct dem_raster_of_classes *raster);
	int64_t width, height; /* pixels */
};

/* `params` must stay valid longer than the raster. */
enum status dem_classes_png_open(const struct dem_classes_params *params, struct dem_raster_of_classes **out)
	FURROW_CHECKED;
enum status dem_classes_gdal_open(const struct dem_classes_params *params, struct dem_raster_of_classes **out)
	FURROW_CHECKED;

#endif
