/*
 * Elevation data to a store. An import takes options by the command's names, opens its sources, and makes the store by an intake.
 * An intake writes rows of posts from any reader; synthetic terrain needs no more. Any thread; one thread at a time uses an import
 * or an intake. Many threads pack tiles within one (`jobs`).
 */
#ifndef FURROW_INTAKE_INTAKE_H
#define FURROW_INTAKE_INTAKE_H

#include "dem/dem.h"
#include "store/store.h"

/* --- intake: rows of posts to a store --- */

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

/* Makes the complete store, or none. Imagery is no part of it. Any thread. */
enum status intake_run(struct intake *intake) FURROW_CHECKED;

/* Returns the default error: half the source's own unit, or a millimetre for floats (unit 0). */
double intake_default_error(double unit);
/*
 * Returns the step of height codes, metres: twice the error, down to a multiple of 2^-10 m. A float holds every multiple of that
 * below 16 km exactly. So the error bound also holds in an exported raster. A step below 2^-10 m is a power of two. With the
 * source's own unit as step, whole numbers are exact; no smaller bound improves them. `whole`: as in dem_info.
 */
double intake_step(double max_error, double unit, bool whole);
/* Returns a step of at most `step` of which `coarse` is a multiple, if `coarse` is the larger one: `coarse` halved often enough. */
double intake_common_step(double coarse, double step);

/* --- what heights there are --- */

#define CENSUS_BINS 7500

struct census_extreme {
	double height; /* m */
	int64_t posts; /* that have exactly this height */
};

/* Counts of heights. All zero is an empty one. */
struct census {
	int64_t bins[CENSUS_BINS], posts;
	struct census_extreme low, high;
};

/* --- imagery: colours over a store that there is --- */

#define INTAKE_QUALITY 85 /* of WebP, the default */
struct intake_imagery {
	const char *const *sources; /* as of dem_imagery_params */
	size_t count;
	const char *vrt_folder; /* may be NULL */
	const char *store;      /* path of a plain store */
	int quality;            /* 1 to 100; 0: lossless */
	int64_t jobs;           /* threads */
	bool dry;               /* only opens the sources and finds the level */
	bool resume, overwrite; /* as in struct store_imagery_making */
	dem_progress_fn progress; /* of rows of the finest level; may be NULL */
	void *progress_user;
	/* set by intake_imagery_run: */
	int finest;             /* level of the finest pixels */
	double pixel, source_pixel; /* metres: of that level, and of the finest source */
	size_t source_count;
	int64_t tiles, bytes;   /* of all levels, packed */
	int64_t kept;           /* tiles that an import that was broken off had made */
	double seconds;
};
/* Puts colours of the sources and their pyramid into the store. STATUS_INPUT: they give none. STATUS_INTERRUPTED: `progress` stopped it; what
 * was made stays in the store for `resume`, and is not shown. After any other failure the store has the imagery of none of them. */
enum status intake_imagery_run(struct intake_imagery *imagery) FURROW_CHECKED;

/* --- import: sources and options to a store --- */

#define IMPORT_NODATA_MOST 32

/* intake_import_init -> intake_import_option ... -> intake_import_open -> intake_import_run -> intake_import_finish */
struct import {
	struct dem_params dem;
	int64_t tile, jobs;
	double max_error; /* m; below 0: the default */
	double feather;   /* m; below 0: the default */
	bool match_heights;
	bool allow_network; /* dem_network_begin was called */
	char **inset_sources; /* owned; those that were named */
	size_t inset_count;
	char **imagery_sources; /* owned; those that were named */
	size_t imagery_count;
	int quality; /* as of intake_imagery; `lossless` counts for more */
	bool lossless;
	enum store_pack pack;
	bool resume, overwrite, force;
	double nodata[IMPORT_NODATA_MOST];
	uint64_t given; /* a bit for each option that was set */
	/* After intake_import_open: */
	struct dem *opened;
	const char **inset_paths; /* of all insets, one inset after the other */
	struct dem_inset_source *inset_from;
	struct dem_insets *insets; /* NULL: there are none */
	double coarse_step; /* m: heights of the terrain are rounded to multiples of it; 0: they are stored as they come */
	struct store_meta meta; /* of the store that will be made */
	struct census *census;  /* counts the heights that are read; NULL until intake_import_run */
	char *lines, *inset_lines, *description, *texts[6];
};

void intake_import_init(struct import *import); /* sets all options to their defaults */
void intake_import_finish(struct import *import);
/* Sets an option by the command's long name, with dashes or underlines. `value`: as the command takes it; of a switch "",
 * "true" or "false". `nodata` adds one value. STATUS_USAGE: there is no such option, or it does not take this value. */
enum status intake_import_option(struct import *import, const char *name, const char *value) FURROW_CHECKED;
bool intake_import_has_option(const char *name);
/* How an option takes a list. */
enum import_list {
	IMPORT_NO_LIST, /* it has one value */
	IMPORT_EACH,    /* a call of intake_import_option for each value */
	IMPORT_JOINED   /* one call, with the values parted by commas */
};
enum import_list intake_import_list(const char *name); /* IMPORT_NO_LIST of a name that is no option, too */
/* The values of `r`, `radii`, `pack`, `s-unit` and `encoding`, ended by NULL. */
extern const char *const intake_import_methods[], *const intake_import_radii[], *const intake_import_packs[],
	*const intake_import_units[], *const intake_import_encodings[];
/* Opens the sources, which must outlive the import. Writes nothing. STATUS_INPUT: they give no terrain. */
enum status intake_import_open(struct import *import, const char *const *sources, size_t count) FURROW_CHECKED;
/* Makes the store; fills `made`. STATUS_INTERRUPTED: `progress` stopped it. Heights are complete, or there is no store. If imagery was named it is
 * opened first, and put into the store that is made last. Where that fails the store stays, without imagery, and the failure says so.
 * `coloured` gets what the imagery came to, and may be NULL where there is none. */
enum status intake_import_run(struct import *import, const char *store, dem_progress_fn progress, void *user, struct intake *made,
			      struct intake_imagery *coloured) FURROW_CHECKED;
/* Opens the imagery of an import whose sources are open, and closes it. STATUS_INPUT: it cannot be imported over their terrain. */
enum status intake_imagery_check(const struct import *import) FURROW_CHECKED;
/* Imports only the imagery, into a store that exists. intake_import_open() is not called. STATUS_USAGE: an option was set that is of heights. */
enum status intake_import_imagery(const struct import *import, const char *store, bool dry, dem_progress_fn progress, void *user,
				  struct intake_imagery *out) FURROW_CHECKED;

#endif
