/* What a body that carries soil did: shared by html_digging.c and html_digging_cycles.c. */
#ifndef FURROW_TOOLS_HTML_DIGGING_H
#define FURROW_TOOLS_HTML_DIGGING_H

#include "html_run.h"

/* Values of a row. */
enum html_dig {
	DIG_VOLUME,  /* m3 aboard */
	DIG_WEIGHT,  /* N of it */
	DIG_LEVEL,   /* N: horizontal part of the cutting force */
	DIG_FORCE,   /* N: cutting force, of the ground alone */
	DIG_WORK,    /* J: what the body has done on the soil until then; NaN: not known */
	DIG_VALUES,
};

struct html_digging {
	size_t room;
	double *values[DIG_VALUES]; /* as many as the body has rows */
};

/*
 * A cycle: the volume aboard rises from a low to a peak, and falls to the next low. Rises and falls of less than a tenth of the most that was aboard are part of what
 * they interrupt. Behind the peak it holds its load where the volume stays within a twentieth of the peak's rise for the longest time. What it holds in the middle of that
 * time is what it brought; the rest was spilled. Members are numbers of rows.
 */
struct html_cycle {
	size_t low, peak, end;         /* end: the low after it, or the last row */
	size_t fills, half;            /* 1 % of what it brought was aboard for the first time; half of it */
	size_t holds, held;            /* the first row of that time; its middle */
	size_t dumps, fallen, emptied; /* the last row before 1 % of what it held had left; the first at which half, and 99 %, had left */
	bool dumped;                   /* false: it was not dumped, and the members of dumping are the last row */
};

/* Finds the cycles of a body. *count: how many there are; fills at most `most` of them. STATUS_MEMORY. */
enum status html_digging_cycles(const struct html_body *body, struct html_cycle *list, size_t most, size_t *count) FURROW_CHECKED;

#endif
