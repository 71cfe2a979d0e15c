/* A body sinks into the ground: src/soil/sink.c. */
#ifndef FURROW_SOIL_SINK_H
#define FURROW_SOIL_SINK_H

#include "soil/laying/laying.h"
#include "soil/soil.h"

/* What soil_sink_body needs beside law, planes and motion. */
struct soil_sink {
	const struct soil_laying *laying;
	const struct soil_laid *soils; /* SOIL_CLASSES: how each soil is laid */
	int32_t start;                 /* with a load: where the search begins, fixed-point units above motion->to.z */
};

/* What soil_sink_body found and did. */
struct soil_imprint {
	struct soil_forces forces;
	struct soil_measured measured; /* for soil_lay */
	struct post_rect reached;      /* around the posts that it changed, and those that it may have freed */
	int64_t compacted;             /* fixed-point units, summed over posts */
	uint64_t refused;              /* posts whose change would leave the range of an offset */
	int32_t raised;                /* with a load: the equilibrium height above motion->to.z, fixed-point units */
	int tries;                     /* evaluations of the search */
};

/* Finds the height of a body if it has a load, computes the forces on it, and changes the posts that it touches. planes: of a rectangle that has all
 * posts below the body with their neighbours. Adds to planes->contact. STATUS_MEMORY: nothing was changed. Any thread; `work` belongs to one. */
enum status soil_sink_body(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, const struct soil_sink *sink,
			    struct soil_work *work, struct soil_imprint *out) FURROW_CHECKED;

/* Computes the forces that soil_sink_body would tell, and changes nothing. start: as in struct soil_sink. STATUS_MEMORY. Any thread; `work` belongs to
 * one. */
enum status soil_feel(const struct soil_law *law, const struct soil_planes *planes, const struct soil_motion *motion, int32_t start, struct soil_work *work,
		      struct soil_forces *out) FURROW_CHECKED;

#endif
