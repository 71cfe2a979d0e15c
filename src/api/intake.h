/* Rows of posts into a store: what importing and synthetic terrain share. */
#ifndef FURROW_API_INTAKE_H
#define FURROW_API_INTAKE_H

#include "dem/dem.h"
#include "store/store.h"

struct intake {
	const char *path; /* of the store to make */
	struct store_meta meta; /* with a request, what is broken off can be resumed */
	bool overwrite, resume;
	int64_t jobs; /* threads that pack; 1: one thread for everything */
	dem_posts_fn posts;
	void *posts_user;
	int64_t panel_posts; /* as in struct dem_cut */
	dem_progress_fn progress; /* rows done, of all; NULL: nobody asks. STATUS_INTERRUPTED breaks off */
	void *progress_user;
	/* Out, once the store is made: */
	double low, high; /* of all heights, metres */
	int64_t stored;   /* tiles that were there from before */
	int64_t bytes;    /* of the file */
	double seconds;   /* that it took */
};

/* Makes the store whole or not at all. Any thread. */
enum status api_intake_run(struct intake *intake) FURROW_CHECKED;

/* Half the source's own unit, or a millimetre for floats (unit 0). */
double api_intake_default_error(double unit);
/*
 * Codes are whole steps of this. A step that is a power of two makes every stored height exact in a float,
 * so that the bound holds in an exported raster too; the source's own unit makes whole numbers exact, which
 * no bound below half of it makes better. `whole`: as in dem_info.
 */
double api_intake_step(double max_error, double unit, bool whole);

#endif
