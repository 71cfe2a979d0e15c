/*
 * A thread that goes ahead of the objects, and of the camera that follows one, and brings the ground's tiles they
 * will ask for, so that no step reads the store. It also brings ranges that pictures lack. What it does shows in resident_ground_figures alone: a tile it has
 * not brought, or could not read, the ground's owner reads itself, and tells of it.
 *
 * It looks `prefetch` seconds of simulated time ahead, but only as far as `tiles` tiles reach: the soonest needed.
 */
#ifndef FURROW_MOTION_PREFETCHER_H
#define FURROW_MOTION_PREFETCHER_H

#include "motion/motion.h"

struct prefetcher;

struct prefetcher_params {
	struct store *store;
	struct ground *ground;             /* its owner calls all of this */
	uint32_t tiles;                    /* most it keeps there; fewer than the ground's, which has others too */
	const struct track *const *tracks; /* copied; the tracks must outlive it */
	size_t count;                      /* at least 1 */
	double post;                       /* metres between a track's stations */
	look_ahead_camera_fn camera;            /* NULL: asks for none */
	const void *user;
	double camera_speed;               /* m/s, about the fastest its places move */
	double prefetch, end;              /* s: how far ahead, and where time ends */
};

/* The lines of one, if there is any: `prefetch` and `count` as its params'. Pure. */
void motion_prefetcher_plan(double prefetch, size_t count, struct plan *plan);
/* Starts at time 0. */
enum status motion_prefetcher_create(const struct prefetcher_params *params, struct prefetcher **out) FURROW_CHECKED;
void motion_prefetcher_destroy(struct prefetcher *prefetcher); /* takes NULL */
/* How far ahead it looks from now on, simulated seconds; until then `prefetch`. Waits for nothing. */
void motion_prefetcher_reach(struct prefetcher *prefetcher, double seconds);
/* What time it is: no less than before. Waits for nothing. */
void motion_prefetcher_tell(struct prefetcher *prefetcher, double time);
/* The ranges that pictures lack, most urgent first: brought between tiles, in the place of those that were given before. As many as
 * there is room for are taken. Waits for nothing. */
void motion_prefetcher_ranges(struct prefetcher *prefetcher, const struct ground_range_key *keys, size_t count);
/* How many ranges it has been through since it began. */
uint64_t motion_prefetcher_ranges_done(struct prefetcher *prefetcher);
/* Until everything is there that it would bring at the time last told. */
void motion_prefetcher_wait(struct prefetcher *prefetcher);

#endif
