/* What a probe adds up over the posts: the force on the body, and how it changes. */
#ifndef FURROW_DEFORM_PROBE_SUMS_H
#define FURROW_DEFORM_PROBE_SUMS_H

#include "deform/probe/law.h"
#include "deform/probe/terms.h"

/* Sums in the body's frame: x forwards, y to its left. Forces come before moments, translations before rotations. */
struct sums {
	double force[6];
	double normal[3], normal_force, shear_limit, sheared[3], area, sinkage, pull;
	struct terms stiffness, damping;
};

/* Adds what a post bears. */
void deform_sums_add(const struct probe_law *law, const struct probe_post *ground, const struct probe_bearing *bearing, struct sums *sums);

#endif
