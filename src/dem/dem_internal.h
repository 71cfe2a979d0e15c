/*
 * Inside dem: how a file becomes rows of metres.
 *
 * A grid is something that rows can be read from: a raw heightmap, a PNG, GDAL's mosaic, or another
 * grid with its holes filled. Grids own what they hold; dem_grid_destroy takes NULL.
 */
#ifndef FURROW_DEM_INTERNAL_H
#define FURROW_DEM_INTERNAL_H

#include "dem/dem.h"

/* --- dem_list.c: names of files --- */
struct dem_list {
	char **paths;
	size_t count, room;
};

/* Sources as named to files: opens directories and "@lists". */
enum status dem_list_init(struct dem_list *list, const char *const *sources, size_t count) FURROW_CHECKED;
enum status dem_list_add(struct dem_list *list, const char *path) FURROW_CHECKED; /* copies it */
void dem_list_finish(struct dem_list *list);

struct dem_grid {
	/* As dem_read; the rectangle lies within. */
	enum status (*read)(struct dem_grid *grid, struct post_rect rect, double *heights);
	void (*destroy)(struct dem_grid *grid);
	int64_t width, height; /* posts */
	double spacing, unit;  /* as in dem_info */
	bool whole;
	int64_t panel_posts;
	double origin[2];
	char *srs, *vertical, *projected; /* NULL: "" */
	struct dem_list files; /* as in dem_info */
	int64_t overlap_posts, overlap_differing;
	double overlap_difference;
};

void dem_grid_destroy(struct dem_grid *grid); /* also frees the texts */

/* --- dem_nodata.c: what a stored value means --- */
struct dem_meaning {
	double scale, offset; /* metres = value * scale + offset */
	const double *nodata; /* values as they are stored */
	size_t nodata_count;
	bool single; /* values are no more exact than a float: they are compared, and heights rounded, so */
};

/* A row of values to metres, NaN where nodata; may be the same row. */
void dem_metres(const struct dem_meaning *meaning, const double *values, int64_t count, double *metres);
/* True if whole numbers of this unit are exact: whole metres, or a power of two. 0 is none. */
bool dem_unit_exact(double unit);
/* Metres in a unit as GDAL names it ("ft"), 1 for "" and names not known. */
double dem_unit_metres(const char *unit);

/* --- grids --- */
enum status dem_raw_open(const struct dem_params *params, const char *path, struct dem_grid **out)
	FURROW_CHECKED;
enum status dem_png_open(const struct dem_params *params, const char *path, struct dem_grid **out)
	FURROW_CHECKED;
/* Everything else, also several files as one (dem_gdal.c, or dem_nogdal.c). */
enum status dem_gdal_open(const struct dem_params *params, const struct dem_list *list,
			  struct dem_grid **out) FURROW_CHECKED;
/* True if the file looks like a raster; for what lies in a directory. */
bool dem_gdal_knows(const char *path);
/* `grid` without holes; owns it from now on, also when it fails. */
enum status dem_fill_create(struct dem_grid *grid, struct dem_grid **out) FURROW_CHECKED;

/* --- writers --- */
struct dem_sink {
	/* One row, `y` counted from the south. */
	enum status (*row)(struct dem_sink *sink, int64_t y, const double *values);
	enum status (*finish)(struct dem_sink *sink); /* all of it is with the system */
	void (*destroy)(struct dem_sink *sink);
};

/* `part` is the file to write; `raster` must outlive the sink. */
enum status dem_gdal_sink(const struct dem_raster *raster, const char *part, struct dem_sink **out)
	FURROW_CHECKED;
enum status dem_png_sink(const struct dem_raster *raster, const char *part, struct dem_sink **out)
	FURROW_CHECKED;
/* `value` as the raster's type holds it, NaN as its nodata. */
double dem_raster_value(const struct dem_raster *raster, double value);

#endif
