/* Writes rows of posts into a store, for imports and for synthetic terrain. */
#ifndef FURROW_API_INTAKE_H
#define FURROW_API_INTAKE_H

#include "dem/dem.h"
#include "store/store.h"

struct intake {
	const char *path; /* of the store to make */
	struct store_meta meta; /* describes the store; its errors are results. If it has a request, an interrupted import can be resumed later */
	bool overwrite, resume;
	bool force; /* with `overwrite`: also a store that overlays depend on, or that has snapshots */
	int64_t jobs; /* threads that pack; 1: one thread for everything */
	dem_posts_fn posts;
	void *posts_user;
	double rounded; /* as in struct dem_cut */
	/* as dem_misfit, with posts_user; NULL: the posts are the sources' own */
	enum status (*misfit)(void *user, const struct extent *extent, const struct dem_tile *tile, double step, struct misfit *misfit);
	int64_t panel_posts; /* as in struct dem_cut */
	struct dem_insets *insets; /* NULL: there are none */
	const char *none; /* what to look at if no post has a height: the end of that error; NULL: a store without heights is made */
	/* called with the rows done and all rows; NULL: no calls. If it returns STATUS_INTERRUPTED, the import stops */
	dem_progress_fn progress;
	void *progress_user;
	/* Results, once the store is made: */
	double low, high; /* of all heights, metres */
	int64_t stored;   /* tiles that were already there */
	int64_t bytes;    /* of the file */
	double seconds;   /* time that it took */
};

/* Makes the complete store, or none. Any thread. */
enum status api_intake_run(struct intake *intake) FURROW_CHECKED;

/* Returns the default error: half the source's own unit, or a millimetre for floats (unit 0). */
double api_intake_default_error(double unit);
/*
 * Returns the step of height codes, metres: twice the error, down to a multiple of 2^-10 m. A float holds every multiple of that
 * below 16 km exactly. So the error bound also holds in an exported raster. A step below 2^-10 m is a power of two. With the
 * source's own unit as step, whole numbers are exact; no smaller bound improves them. `whole`: as in dem_info.
 */
double api_intake_step(double max_error, double unit, bool whole);
/* Returns a step of at most `step` of which `coarse` is a multiple, if `coarse` is the larger one: `coarse` halved often enough. */
double api_intake_common_step(double coarse, double step);

#endif
