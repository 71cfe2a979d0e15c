/*
 * Used inside dem only, in a build with GDAL. The grid of all sources, and how its posts are read.
 *
 *     dem_gdal.c: opens it  ->  dem_read.c: reads its posts, in parts, with several threads
 */
#ifndef FURROW_DEM_GRID_H
#define FURROW_DEM_GRID_H

#include "base/crew.h"
#include "dem_gdal.h"

/* What one thread reads with: one thread at a time may use a dataset of GDAL, so each has its own. */
struct dem_reader {
	struct dem_groups groups;
	struct dem_misfit_room *room; /* NULL before it is needed */
};

struct gdal_grid {
	struct dem_grid grid;
	struct gdal_source *sources;
	size_t source_count;
	char *name; /* of the first source, for messages */
	struct dem_groups groups;
	struct dem_target target;
	enum dem_resample method;
	int64_t jobs; /* most threads that read */
	/* Made when the first rectangle is read that is resampled. The groups of the first reader are `groups`. */
	struct crew *crew;
	struct dem_reader *readers;
	size_t reader_count;
	uint8_t *sampled; /* of a read */
	size_t room;
};

/* --- dem_split.c --- */
/* Finds the first source that has the same SRS as source number i. */
void dem_grid_find_system(struct gdal_source *sources, size_t i);
/* Takes those sources out of the grid, its groups and `list` that are finer than others and lie within them, and names them in
 * gdal->grid.finer. */
enum status dem_split(struct gdal_grid *gdal, const struct dem_params *params, struct dem_list *list) FURROW_CHECKED;

/* --- dem_read.c --- */
/* Makes the sampler and the way back of a group, for the grid's target. */
enum status dem_grid_sampler(const struct gdal_grid *gdal, struct dem_group *group) FURROW_CHECKED;
void dem_reader_finish(struct dem_reader *reader, bool owns_groups);
enum status dem_grid_read(struct dem_grid *grid, struct post_rect rect, double *heights) FURROW_CHECKED;
enum status dem_grid_misfit(struct dem_grid *grid, const struct dem_part *part, const int64_t ends[2], struct misfit *misfit) FURROW_CHECKED;

#endif
