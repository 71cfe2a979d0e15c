/* Pressing a body into the ground: src/soil/press.c. */
#ifndef FURROW_SOIL_PRESS_H
#define FURROW_SOIL_PRESS_H

#include "soil/laying/laying.h"
#include "soil/soil.h"

/* What pressing needs beside law, planes and motion. */
struct soil_press {
	const struct soil_laying *laying;
	const struct soil_laid *soils; /* SOIL_CLASSES: how each soil is laid */
	int32_t start;                 /* with a load: where the search begins, fixed-point units above motion->to.z */
};

/* What pressing found and did. */
struct soil_pressed {
	struct soil_forces forces;
	struct soil_measured measured; /* for soil_lay */
	struct post_rect reached;      /* around the posts that it changed, and those that it may have freed */
	int64_t compacted;             /* fixed-point units, summed over posts */
	uint64_t refused;              /* posts whose change would leave the range of an offset */
	int32_t raised;                /* with a load: the equilibrium height above motion->to.z, fixed-point units */
	int tries;                     /* evaluations of the search */
};

/* Presses a body into planes that have all posts below it and their neighbours: finds its height if it has a load, computes the forces on it, and changes
 * the posts that it touches. Adds to planes->contact. STATUS_MEMORY: nothing was changed. Any thread; `work` belongs to one. */
enum status soil_press_body(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, const struct soil_press *press,
			    struct soil_work *work, struct soil_pressed *out) FURROW_CHECKED;

/* Computes the forces that soil_press_body would tell, and changes nothing. start: as in struct soil_press. STATUS_MEMORY. Any thread; `work` belongs to
 * one. */
enum status soil_feel(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, int32_t start, struct soil_work *work,
		      struct soil_forces *out) FURROW_CHECKED;

#endif
