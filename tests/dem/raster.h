/* GeoTIFFs made small for the tests of dem: sizes, places, systems, types, tags and heights as a test wants them. */
#ifndef FURROW_TESTS_DEM_RASTER_H
#define FURROW_TESTS_DEM_RASTER_H

#include "tif.h"

struct made {
	const char *name, *srs; /* in the folder; anything GDAL takes, NULL for none */
	int width, height;
	double west, north, dx, dy; /* pixel corner; dy to the south */
	GDALDataType type;
	double (*height_of)(int x, int y); /* y from the north */
	bool tag;
	double nodata, scale, offset; /* scale 0: none */
	const char *unit;
};

static inline double ramp(int x, int y)
{
	return 100 + 10 * x - 3 * y;
}

static inline void make(const struct made *made)
{
	const double place[6] = {made->west, made->dx, 0, made->north, 0, -made->dy};
	GDALDatasetH dataset = tif_create(made->name, made->width, made->height, 1, made->type, made->dx != 0 ? place : NULL, made->srs);
	GDALRasterBandH band = GDALGetRasterBand(dataset, 1);
	if (made->tag)
		GDALSetRasterNoDataValue(band, made->nodata);
	if (made->scale != 0) {
		GDALSetRasterScale(band, made->scale);
		GDALSetRasterOffset(band, made->offset);
	}
	if (made->unit != NULL)
		GDALSetRasterUnitType(band, made->unit);
	for (int y = 0; y < made->height; y++)
		for (int x = 0; x < made->width; x++) {
			double value = made->height_of(x, y);
			assert_int_equal(GDALRasterIO(band, GF_Write, x, y, 1, 1, &value, 1, 1, GDT_Float64, 0, 0),
					 CE_None);
		}
	GDALClose(dataset);
}

/* 9 x 7 posts every 10 m in UTM 33N. */
static inline struct made utm(const char *name)
{
	return (struct made){.name = name, .srs = "EPSG:32633", .width = 9, .height = 7, .west = 500000,
			     .north = 5000000, .dx = 10, .dy = 10, .type = GDT_Int16, .height_of = ramp};
}

static inline struct dem *make_and_open(const struct made *made)
{
	make(made);
	return open_one(in_folder(made->name));
}

/* Heights that grow by the degree, so that a half-pixel shift would be seen. */
static inline double by_degree(int x, int y)
{
	return 1000 + 4 * x - 7 * y;
}

#endif
