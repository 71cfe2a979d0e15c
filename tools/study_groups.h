/* The values of a parameter, sorted into groups for a plot: each value a group, or parts of equal
 * width. */
#ifndef FURROW_TOOLS_STUDY_GROUPS_H
#define FURROW_TOOLS_STUDY_GROUPS_H

#include "study.h"

#define STUDY_GROUPS 24 /* at most */

struct study_groups {
	bool text, cut;	  /* cut: groups are ranges */
	bool logarithmic; /* where they are on the axis */
	size_t count;
	const char *names[STUDY_GROUPS]; /* of values that are not numbers */
	double values[STUDY_GROUPS];
	double low, high; /* of all values */
};

/* Finds the groups of a parameter. If it has more than `most` values, or they are a hypercube's,
 * cuts the range into `parts`. Returns false if they are too many and no numbers. */
bool study_groups_find(const struct study *study, size_t parameter, size_t most, size_t parts, struct study_groups *groups);
/* Returns the group of a value. *value: the number, or for a text the group's index. */
size_t study_groups_index(const struct study_groups *groups, const char *name, double *value);
/* Returns where a value is on the axis: its logarithm, if the axis is logarithmic. */
double study_groups_scale(const struct study_groups *groups, double value);
/* Returns the lower edge of a part; the upper edge of the last one if `i` is the number of parts.
 */
double study_groups_edge(const struct study_groups *groups, size_t i);

#endif
