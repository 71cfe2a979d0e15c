/* A row of objects.csv or vehicles.csv while it is read: shared by html_rows.c and html_forces.c. */
#ifndef FURROW_TOOLS_HTML_ROW_H
#define FURROW_TOOLS_HTML_ROW_H

#include "html_run.h"

struct html_row {
	double time, place[3], force[3], moment[3], sinkage, slip, load, work;
	double carried, weight;     /* m3 and N of soil aboard, a part of `force`; NaN: it carries none */
	double values[HTML_VALUES]; /* of a vehicle */
	bool flat;                  /* a wheel that rolls by its way in plan: its path gives its heights, and it has no load */
	double radius;              /* of a wheel; 0: it does not turn; NaN: not known how it turns */
	/* Set by html_forces_take: */
	double mark[3];             /* where the direction was taken last: the centre, raised by the sinkage */
	double older[3], newer[3];  /* the same, from where the slope is taken, and from where it will be */
	double tangent[3];          /* unit vector of the way, along the ground in space */
	bool moved;                 /* it is known */
	size_t paid;                /* row from which the energy for each metre is not known yet */
};

#endif
