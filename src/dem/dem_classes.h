/* Inside dem: a raster of classes, a PNG or through GDAL, and where its pixels are. */
#ifndef FURROW_DEM_CLASSES_H
#define FURROW_DEM_CLASSES_H

#include "dem_internal.h"

#define DEM_CLASS_NONE INT32_MIN     /* a pixel's value: nodata */
#define DEM_CLASSES_WINDOW (1 << 20) /* pixels that are read at once at most */

struct dem_raster_of_classes {
	/* Converts positions in place. In: posts of level 0, counted from the south-west post. Out: columns and rows of the
	 * raster, counted from its north-west corner. The middle of the first pixel is (0.5, 0.5). NaN: outside of the raster. */
	void (*locate)(struct dem_raster_of_classes *raster, size_t count, double *x, double *y);
	/* Values of pixels, rows from the north; at most DEM_CLASSES_WINDOW. */
	enum status (*window)(struct dem_raster_of_classes *raster, struct post_rect pixels, int32_t *values);
	void (*destroy)(struct dem_raster_of_classes *raster);
	int64_t width, height; /* pixels */
};

/* `params` outlives the raster. */
enum status dem_classes_png_open(const struct dem_classes_params *params, struct dem_raster_of_classes **out)
	FURROW_CHECKED;
enum status dem_classes_gdal_open(const struct dem_classes_params *params, struct dem_raster_of_classes **out)
	FURROW_CHECKED;

#endif
