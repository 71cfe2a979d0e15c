/* Rows of posts into a store: what synth and import share. */
#ifndef FURROW_TOOLS_INTAKE_H
#define FURROW_TOOLS_INTAKE_H

#include "dem/dem.h"
#include "store/store.h"

struct intake {
	const char *path; /* of the store to make */
	struct store_meta meta;
	bool overwrite;
	int64_t jobs; /* threads; more than 2 find nothing to do */
	double low; /* out: the lowest height, metres; above 0 if nothing was made */
	dem_rows_fn rows;
	void *rows_user;
};

/* Makes the store whole or not at all, with a progress line, and says where it is. */
enum status intake_run(struct intake *intake) FURROW_CHECKED;

/* 0 was given as "the default": half the source's own unit, or a millimetre for floats. */
double intake_default_error(double unit);

#endif
