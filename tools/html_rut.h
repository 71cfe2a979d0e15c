/* The ground across the way of a drive, at its middle, as the store has it now. */
#ifndef FURROW_TOOLS_HTML_RUT_H
#define FURROW_TOOLS_HTML_RUT_H

#include "html_run.h"

struct html_rut {
	size_t count;            /* 0: there is none; `why` tells */
	double *across, *change; /* m to the left of the way; mm above the ground before all drives, NaN over holes */
	double middle[2], left[2]; /* m: the point of the way, and the unit vector to its left */
	double half;             /* m from the middle to either end */
	double deepest, highest; /* mm, of `change` */
	double below, above;     /* m2: areas of the profile under and over the old ground */
	const char *body;        /* whose way it is; owned by the run */
	char why[512];           /* one sentence */
};

enum status html_rut_read(const struct html_run *run, struct html_rut *out) FURROW_CHECKED;
void html_rut_finish(struct html_rut *rut);

#endif
