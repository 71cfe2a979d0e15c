/* Inside dem, with GDAL: the sources as GDAL sees them, their mosaic, and its projection. */
#ifndef FURROW_DEM_GDAL_H
#define FURROW_DEM_GDAL_H

#include <gdal.h>
#include <ogr_srs_api.h>

#include "dem_internal.h"

/* One file. `vrt` is a small virtual raster among GDAL's files in memory. It gives band 1 in metres, with NaN where there is no
 * data. So the code that reads it needs no tags, scales and units. */
struct gdal_source {
	const char *path;
	char *vrt; /* its name; NULL before it is made */
	int width, height;
	double place[6]; /* GDAL's geotransform: of pixel corners */
	bool placed;
	OGRSpatialReferenceH srs; /* NULL if unknown or local */
	bool doubles;             /* heights are kept in 64 bits */
	double unit;              /* as in dem_info */
	int64_t panel_posts;      /* as in dem_info */
	bool whole;               /* heights are whole numbers of units, to the last bit */
	char vertical[160];
};

#define DEM_CACHE_BYTES (48 << 20) /* of decoded blocks that GDAL holds */

void dem_gdal_init(void);           /* registers what is needed, once; any thread */
const char *dem_gdal_message(void); /* what GDAL said last, until the next call in this thread */

/* --- dem_source.c --- */
/* Adds to `files` what else it is made of. */
enum status dem_source_init(struct gdal_source *source, const struct dem_params *params, const char *path,
			    OGRSpatialReferenceH override, int number, struct dem_list *files) FURROW_CHECKED;
void dem_source_finish(struct gdal_source *source);

/* --- dem_mosaic.c: several sources as one dataset, the first named on top; also compares them --- */
enum status dem_mosaic(const struct gdal_source *sources, size_t count, struct dem_grid *grid,
		       GDALDatasetH *out) FURROW_CHECKED;

/* --- dem_layers.c: sources of one grid, the first named on top --- */
struct dem_layers;
/* True if all posts of the sources are posts of one grid. */
bool dem_layers_fit(const struct gdal_source *sources, size_t count);
/* `place`: the geotransform of all of them together. */
enum status dem_layers_create(const struct gdal_source *sources, size_t count, const double place[6],
			      struct dem_layers **out) FURROW_CHECKED;
void dem_layers_destroy(struct dem_layers *layers); /* takes NULL */
/* Columns and rows from the north-west; heights row by row from the south. *done false: GDAL says why not. */
enum status dem_layers_read(struct dem_layers *layers, struct post_rect rect, double *heights, bool *done)
	FURROW_CHECKED;

/* --- dem_srs.c --- */
/* A new SRS with x east; NULL and a failure message if `text` is none. */
OGRSpatialReferenceH dem_srs_parse(const char *text);
/* Metres on the ground from (x, y) to (x + dx, y + dy); NaN if that cannot be said. */
double dem_srs_ground(OGRSpatialReferenceH srs, double x, double y, double dx, double dy);
/* The metric SRS for data around (x, y): UTM, or on other bodies an equirectangular. NULL: failed. */
OGRSpatialReferenceH dem_srs_metric(OGRSpatialReferenceH srs, double x, double y);
/* In dem's memory; NULL if that ran out. */
char *dem_srs_wkt(OGRSpatialReferenceH srs);

/* --- dem_warp.c --- */
/*
 * What is to be read from `mosaic`, whose geotransform and SRS are `place` and `srs`: itself, or a
 * projection of it. Sets the grid's size, spacing, origin, srs and projected.
 */
enum status dem_warp(const struct dem_params *params, GDALDatasetH mosaic, const double place[6],
		     OGRSpatialReferenceH srs, const char *name, struct dem_grid *grid,
		     GDALDatasetH *warped) FURROW_CHECKED;

#endif
