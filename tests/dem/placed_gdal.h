/* GeoTIFFs that lie over one world, in any place and SRS. */
#ifndef FURROW_TESTS_DEM_PLACED_GDAL_H
#define FURROW_TESTS_DEM_PLACED_GDAL_H

#include <cpl_conv.h>
#include <gdal.h>
#include <ogr_srs_api.h>

#include "placed.h"

static const struct extent extent = {257, 129, 10, 64};
#define WEST 500000.0
#define SOUTH 5000000.0
#define ZONE "EPSG:32633"

struct tif {
	const char *name, *srs; /* NULL: none */
	int width, height, bands;
	GDALDataType type;
	double place[6]; /* all 0: none */
	bool tag, alpha;
	double nodata, scale, offset; /* scale 0: none */
	double (*value_of)(int column, int row);
};

/* 40 x 30 pixels of 50 m in UTM 33N, over part of the world and beyond its west. */
static inline struct tif utm(const char *name)
{
	return (struct tif){.name = name, .srs = ZONE, .width = 40, .height = 30, .bands = 1,
			    .place = {WEST - 300, 50, 0, SOUTH + 1400, 0, -50}};
}

static inline void make(const struct tif *tif)
{
	GDALAllRegister();
	GDALDatasetH dataset = GDALCreate(GDALGetDriverByName("GTiff"), in_folder(tif->name), tif->width, tif->height, tif->bands,
					  tif->type, NULL);
	assert_non_null(dataset);
	if (tif->place[1] != 0 || tif->place[2] != 0)
		assert_int_equal(GDALSetGeoTransform(dataset, (double *)tif->place), CE_None);
	if (tif->srs != NULL) {
		OGRSpatialReferenceH srs = OSRNewSpatialReference(NULL);
		assert_int_equal(OSRSetFromUserInput(srs, tif->srs), OGRERR_NONE);
		OSRSetAxisMappingStrategy(srs, OAMS_TRADITIONAL_GIS_ORDER);
		assert_int_equal(GDALSetSpatialRef(dataset, srs), CE_None);
		OSRDestroySpatialReference(srs);
	}
	GDALRasterBandH band = GDALGetRasterBand(dataset, 1);
	if (tif->tag)
		GDALSetRasterNoDataValue(band, tif->nodata);
	if (tif->scale != 0) {
		GDALSetRasterScale(band, tif->scale);
		GDALSetRasterOffset(band, tif->offset);
	}
	double *row = malloc(sizeof *row * (size_t)tif->width);
	assert_non_null(row);
	for (int y = 0; y < tif->height; y++) {
		for (int x = 0; x < tif->width; x++)
			row[x] = tif->value_of(x, y);
		assert_int_equal(GDALRasterIO(band, GF_Write, 0, y, tif->width, 1, row, tif->width, 1, GDT_Float64, 0, 0), CE_None);
	}
	if (tif->alpha) {
		GDALRasterBandH alpha = GDALGetRasterBand(dataset, 2);
		assert_int_equal(GDALSetRasterColorInterpretation(alpha, GCI_AlphaBand), CE_None);
		for (int x = 0; x < tif->width; x++)
			row[x] = x % 2 ? 255 : 0;
		for (int y = 0; y < tif->height; y++)
			assert_int_equal(GDALRasterIO(alpha, GF_Write, 0, y, tif->width, 1, row, tif->width, 1, GDT_Float64, 0, 0),
					 CE_None);
	}
	free(row);
	GDALClose(dataset);
}

static inline const char *wkt_of(const char *text)
{
	static char wkt[8192];
	OGRSpatialReferenceH srs = OSRNewSpatialReference(NULL);
	char *made = NULL;
	assert_int_equal(OSRSetFromUserInput(srs, text), OGRERR_NONE);
	assert_int_equal(OSRExportToWkt(srs, &made), OGRERR_NONE);
	snprintf(wkt, sizeof wkt, "%s", made);
	CPLFree(made);
	OSRDestroySpatialReference(srs);
	return wkt;
}

/* Computes where each post of a level lies on a raster: columns and rows from its north-west corner, whole numbers at edges of pixels. */
static inline void place_posts(const struct tif *tif, double turn, int level, struct post_rect rect, double *columns, double *rows)
{
	double inverse[6];
	size_t width = (size_t)(rect.x1 - rect.x0), count = width * (size_t)(rect.y1 - rect.y0);
	assert_true(GDALInvGeoTransform((double *)tif->place, inverse));
	for (size_t i = 0; i < count; i++) {
		columns[i] = WEST + ldexp((double)(rect.x0 + (int64_t)(i % width)), level) * extent.spacing;
		rows[i] = SOUTH + ldexp((double)(rect.y0 + (int64_t)(i / width)), level) * extent.spacing;
	}
	if (tif->srs != NULL && strcmp(tif->srs, ZONE) != 0)
		assert_int_equal(dem_transform(wkt_of(ZONE), tif->srs, count, columns, rows), STATUS_OK);
	for (size_t i = 0; i < count; i++) {
		double x = columns[i] + turn, y = rows[i];
		columns[i] = inverse[0] + inverse[1] * x + inverse[2] * y;
		rows[i] = inverse[3] + inverse[4] * x + inverse[5] * y;
	}
}

#endif
