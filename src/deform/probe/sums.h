/* What a probe adds up over the posts: the force on the body, and how it changes. Each lane of the batches has its own sums, so their order is fixed. */
#ifndef FURROW_DEFORM_PROBE_SUMS_H
#define FURROW_DEFORM_PROBE_SUMS_H

#include "deform/probe/lanes.h"
#include "deform/probe/law.h"

struct lane_matrix {
	double at[6][6][LANES];
};

/* Sums in the body's frame: x forwards, y to its left. Forces come before moments, translations before rotations. */
struct sums {
	double force[6][LANES];
	double normal[3][LANES], normal_force[LANES], shear_limit[LANES], sheared[3][LANES], area[LANES], sinkage[LANES], pull[LANES];
	struct lane_matrix stiffness, damping;
};

/* Adds what the posts of a batch bear, after deform_law_bear. */
void deform_sums_add(const struct probe_law *law, const struct lanes *lanes, struct sums *sums);

#endif
