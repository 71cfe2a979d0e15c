/* The miss curves of furrow cache-sim. */
#ifndef FURROW_TOOLS_CACHE_CURVES_H
#define FURROW_TOOLS_CACHE_CURVES_H

#include "sim/sim.h"

#define CACHE_SIZES_MAX 64

struct cache_curves {
	const char *title; /* the trace's path */
	const struct sim_accesses *accesses;
	size_t count; /* of slots, which grow */
	uint32_t slots[CACHE_SIZES_MAX];
	bool wanted[SIM_POLICIES];
	uint64_t misses[SIM_POLICIES][CACHE_SIZES_MAX];
};

extern const char *const cache_policy_labels[SIM_POLICIES];

/* Sizes from 4 slots to one for every tile. */
void cache_sizes(struct cache_curves *curves);

#endif
