/* Reads the forces of actuators of vehicles.csv into curves. */
#ifndef FURROW_TOOLS_HTML_ACTUATORS_H
#define FURROW_TOOLS_HTML_ACTUATORS_H

#include "html_run.h"

/* The columns of a file; all zero: none yet. */
struct html_actuators {
	size_t *cells; /* number of each column in a row */
	char **names;  /* without f: */
	size_t count;
};

/* Finds the columns in the file's first row. */
enum status html_actuators_find(struct html_actuators *actuators, char *const *names, size_t count) FURROW_CHECKED;
/* Adds the forces of a row, whose vehicle has just got its own values, to the curves. A cell that is no number has none. */
enum status html_actuators_take(const struct html_actuators *actuators, char *const *cells, const struct html_body *vehicle,
				struct html_bodies *bodies) FURROW_CHECKED;
void html_actuators_finish(struct html_actuators *actuators);

#endif
