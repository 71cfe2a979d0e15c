/* Used inside dem only, in a build with GDAL. Opens sources, joins them to a mosaic, and projects it to metres. */
#ifndef FURROW_DEM_GDAL_H
#define FURROW_DEM_GDAL_H

#include "dem_gdal_calls.h"
#include "dem_internal.h"

/* One source file. `vrt` is a small virtual raster in GDAL's memory files. It gives band 1 in metres, with NaN for nodata. So
 * its readers need not handle nodata values, scales and units. */
struct gdal_source {
	const char *path;
	char *vrt; /* name of the virtual raster; NULL before it is made */
	int width, height;
	double place[6]; /* GDAL's geotransform, for pixel corners */
	bool placed;
	OGRSpatialReferenceH srs; /* NULL if unknown or local */
	bool doubles;             /* heights need 64 bits */
	double unit;              /* as in dem_info */
	int64_t panel_posts;      /* as in dem_info */
	bool whole;               /* heights are exactly whole numbers of units */
	char vertical[160];
};

#define DEM_CACHE_BYTES (48 << 20) /* bytes of decoded blocks that GDAL keeps */

/* Loads GDAL and registers its drivers, once; any thread. To be called before any function of GDAL. STATUS_FAILED: it cannot
 * be loaded; the message names `what`, the file or name that needs it. */
enum status dem_gdal_init(const char *what) FURROW_CHECKED;
void dem_gdal_register(void);       /* of dem_gdal_init: drivers, the size of the cache, and our pixel function */
const char *dem_gdal_message(void); /* the last message of GDAL; valid until the next call in this thread */

/* --- dem_source.c --- */
/* Opens a source. Adds to `files` the other files that belong to it. */
enum status dem_source_init(struct gdal_source *source, const struct dem_params *params, const char *path,
			    OGRSpatialReferenceH override, int number, struct dem_list *files) FURROW_CHECKED;
void dem_source_finish(struct gdal_source *source);

/* --- dem_mosaic.c: joins several sources into one dataset; the first source is on top; also compares overlaps --- */
enum status dem_mosaic(const struct gdal_source *sources, size_t count, struct dem_grid *grid,
		       GDALDatasetH *out) FURROW_CHECKED;

/* --- dem_layers.c: several sources on one grid; the first source is on top --- */
struct dem_layers;
/* Returns true if the posts of all sources lie on one grid. */
bool dem_layers_fit(const struct gdal_source *sources, size_t count);
/* `place`: the geotransform of the area that all sources cover together. */
enum status dem_layers_create(const struct gdal_source *sources, size_t count, const double place[6],
			      struct dem_layers **out) FURROW_CHECKED;
void dem_layers_destroy(struct dem_layers *layers); /* layers may be NULL */
/* `rect` counts columns and rows from the north-west. Heights are given row by row from the south. *done is false if GDAL could
 * not read them; GDAL's message tells why. */
enum status dem_layers_read(struct dem_layers *layers, struct post_rect rect, double *heights, bool *done)
	FURROW_CHECKED;

/* --- dem_srs.c --- */
/* Returns a new SRS with x east. Returns NULL and sets the failure message if `text` is not an SRS. */
OGRSpatialReferenceH dem_srs_parse(const char *text);
/* Returns the metres on the ground from (x, y) to (x + dx, y + dy). Returns NaN if this cannot be computed. */
double dem_srs_ground(OGRSpatialReferenceH srs, double x, double y, double dx, double dy);
/* Returns a metric SRS for data around (x, y): UTM, or on other planets an equirectangular projection. NULL: failed. */
OGRSpatialReferenceH dem_srs_metric(OGRSpatialReferenceH srs, double x, double y);
/* Returns the SRS as WKT, to free with mem_free; NULL: out of memory. */
char *dem_srs_wkt(OGRSpatialReferenceH srs);

/* --- dem_warp.c --- */
/*
 * Gives the dataset to read: `mosaic` itself, or a projection of it. `place` and `srs`: the mosaic's geotransform and SRS. Sets
 * the grid's size, spacing, origin, srs and projected.
 */
enum status dem_warp(const struct dem_params *params, GDALDatasetH mosaic, const double place[6],
		     OGRSpatialReferenceH srs, const char *name, struct dem_grid *grid,
		     GDALDatasetH *warped) FURROW_CHECKED;

#endif
