/*
 * Inside dem: reading a file as rows of heights in metres.
 *
 * A grid is anything from which rows can be read: a raw heightmap, a PNG, GDAL's mosaic, or another grid with filled holes. A
 * grid owns its data. dem_grid_destroy accepts NULL.
 */
#ifndef FURROW_DEM_INTERNAL_H
#define FURROW_DEM_INTERNAL_H

#include <stdio.h>

#include "dem/dem.h"
#include "dem_kernel.h"

/* --- dem_list.c: lists of file names --- */
struct dem_list {
	char **paths;
	bool *found; /* not named by the user, but found in a directory */
	size_t count, room;
};

/* Fills the list with files. Sources may be files, directories, or "@list". */
enum status dem_list_init(struct dem_list *list, const char *const *sources, size_t count) FURROW_CHECKED;
enum status dem_list_add(struct dem_list *list, const char *path) FURROW_CHECKED; /* copies it */
void dem_list_drop(struct dem_list *list, size_t number);
/* Drops the file, and notes that it has no place among others. */
void dem_list_skip(struct dem_list *list, size_t number);
void dem_list_finish(struct dem_list *list);
/* Returns true for files that accompany rasters but are not rasters, even if some driver would open them. */
bool dem_list_is_sidecar(const char *name);
bool dem_list_has_raster_name(const char *path); /* its ending is one that rasters have */
bool dem_list_is_zip(const char *path); /* an archive, but for an .hgt.zip, which GDAL reads itself */
/* --- dem_zip.c --- */
/* Adds the rasters of an archive, by GDAL's names for them. STATUS_INPUT: it cannot be read. STATUS_FAILED: there is no GDAL. */
enum status dem_zip_add(struct dem_list *list, const char *path) FURROW_CHECKED;

struct dem_grid {
	/* As dem_read. The rectangle lies within the grid. */
	enum status (*read)(struct dem_grid *grid, struct post_rect rect, double *heights);
	/* As dem_misfit_heights. NULL: posts are the sources' own. */
	enum status (*misfit)(struct dem_grid *grid, const struct dem_part *surface, const int64_t ends[2], struct misfit *misfit);
	void (*destroy)(struct dem_grid *grid);
	int64_t width, height; /* posts */
	double spacing, unit;  /* as in dem_info */
	bool whole, placed; /* placed: the sources say where they lie */
	bool shifted, keepable; /* as in dem_info */
	int64_t panel_posts;
	double origin[2];
	char *srs, *vertical, *projected; /* NULL: "" */
	double ground_off; /* share by which distances on the ground differ: as in dem_info */
	struct dem_list files; /* as in dem_info */
	struct dem_list finer; /* as in dem_info */
	size_t *finer_sets;
	double covered; /* as in dem_info; 0: not computed, then dem_info tells 1 */
	int64_t overlap_posts, overlap_differing;
	double overlap_difference;
};

void dem_grid_destroy(struct dem_grid *grid); /* also frees the texts */

/* --- dem_nodata.c: from stored values to metres --- */
struct dem_meaning {
	double scale, offset; /* metres = value * scale + offset */
	const double *nodata; /* nodata values, as stored */
	size_t nodata_count;
	bool single; /* values are only as exact as a float, so they are compared, and heights rounded, as floats */
};

/* Converts a row of values to metres, with NaN for nodata. `metres` may be the same array as `values`. */
void dem_metres(const struct dem_meaning *meaning, const double *values, int64_t count, double *metres);
/* Returns true if whole numbers of this unit are exact in metres: the unit is whole metres or a power of two. 0 (no unit) gives
 * false. */
bool dem_unit_exact(double unit);
/* Returns the metres of a unit named as GDAL does ("ft"), of one or of more. Returns 1 for "" and names that are not known. */
double dem_unit_metres(const char *unit);
bool dem_unit_known(const char *unit);

/* --- dem_open.c: what heights are above, as dem_info tells it --- */
size_t dem_vertical_length(const char *vertical); /* of the reference's name; what follows tells of the unit */
/* Notes that two sources differ in it, or that only one says it. Returns true if so. */
bool dem_vertical_note(const char *path, const char *vertical, const char *other, const char *other_vertical);

/* --- grids --- */
enum status dem_raw_open(const struct dem_params *params, const char *path, struct dem_grid **out)
	FURROW_CHECKED;
enum status dem_png_open(const struct dem_params *params, const char *path, struct dem_grid **out)
	FURROW_CHECKED;
/* Opens all other files, and several files as one grid (dem_gdal.c, or dem_nogdal.c). */
/* Drops from the list what was found in a directory and has no place. */
enum status dem_gdal_open(const struct dem_params *params, struct dem_list *list, struct dem_grid **out) FURROW_CHECKED;
/* Returns true if the file seems to be a raster. Used for the files of a directory. */
bool dem_gdal_knows(const char *path);
/* Returns true if GDAL is there and finds a place in the file. */
bool dem_gdal_places(const struct dem_params *params, const char *path);
/* Makes a grid of the posts of `grid` that lie in params->window. Takes over `grid`, even on failure. */
enum status dem_crop_create(const struct dem_params *params, struct dem_grid *grid, struct dem_grid **out) FURROW_CHECKED;
/* Makes a grid in which the holes of `grid` are filled. Takes over `grid`, even on failure. */
enum status dem_fill_create(struct dem_grid *grid, struct dem_grid **out) FURROW_CHECKED;

/* --- writers --- */
struct dem_sink {
	/* Writes one row. `y` is counted from the south. */
	enum status (*row)(struct dem_sink *sink, int64_t y, const double *values);
	enum status (*finish)(struct dem_sink *sink); /* writes the rest and closes the file */
	void (*destroy)(struct dem_sink *sink);
};

/* `part`: path of the file to write. `raster` must stay valid longer than the sink. */
/* Opens PATH.part to write it, as output_create does. NULL: it failed, and input_problem says why. */
FILE *dem_part_open(const char *part);
enum status dem_gdal_sink(const struct dem_raster *raster, const char *part, struct dem_sink **out)
	FURROW_CHECKED;
enum status dem_png_sink(const struct dem_raster *raster, const char *part, struct dem_sink **out)
	FURROW_CHECKED;
enum status dem_raw_sink(const struct dem_raster *raster, const char *part, struct dem_sink **out)
	FURROW_CHECKED;
/* Returns `value` as the raster's type stores it. NaN becomes the nodata value. */
double dem_raster_value(const struct dem_raster *raster, double value);

#endif
