/* Rows of posts into a store: what synth and import share. */
#ifndef FURROW_TOOLS_INTAKE_H
#define FURROW_TOOLS_INTAKE_H

#include "dem/dem.h"
#include "store/store.h"

struct intake {
	const char *path; /* of the store to make */
	struct store_meta meta; /* with a request, what Ctrl-C breaks off can be resumed */
	bool overwrite, resume;
	int64_t jobs; /* threads that pack; 1: one thread for everything */
	dem_posts_fn posts;
	void *posts_user;
	int64_t panel_posts; /* as in struct dem_cut */
	double low, high; /* out: of all heights, metres; 0 both if nothing was made */
};

/* Makes the store whole or not at all, with a progress line, and says where it is. */
enum status intake_run(struct intake *intake) FURROW_CHECKED;

/* Half the source's own unit, or a millimetre for floats (unit 0). */
double intake_default_error(double unit);
/*
 * Codes are whole steps of this. A step that is a power of two makes every stored height exact in a float,
 * so that the bound holds in an exported raster too; the source's own unit makes whole numbers exact, which
 * no bound below half of it makes better. `whole`: as in dem_info.
 */
double intake_step(double max_error, double unit, bool whole);

#endif
