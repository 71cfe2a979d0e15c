/*
 * A thread that loads the ground's tiles before bodies, and the camera that follows one, need them. So no step reads the store.
 * It also loads ranges that pictures lack.
 *
 * It shows only in resident_ground_figures. The ground's owner itself reads a tile that the thread has not brought or could not
 * read, and returns the failure.
 *
 * It looks `prefetch` seconds of simulated time ahead, but only as far as `tiles` tiles reach, the soonest needed first.
 */
#ifndef FURROW_MOTION_PREFETCHER_H
#define FURROW_MOTION_PREFETCHER_H

#include "motion/motion.h"

struct prefetcher;

struct prefetcher_params {
	struct store *store;
	struct ground *ground;             /* its owner calls all functions here */
	uint32_t tiles;                    /* most tiles that it keeps there; fewer than the ground's, which also holds others */
	const struct track *const *tracks; /* copied; the tracks must outlive it */
	size_t count;                      /* at least 1 */
	double post;                       /* metres between a track's path samples */
	look_ahead_camera_fn camera;            /* NULL: asks for none */
	const void *user;
	double camera_speed;               /* m/s: about the greatest speed of the camera's places */
	double prefetch, end;              /* s: how far ahead it looks; the end of time */
};

/* Adds the plan's lines of a prefetcher, if there is one. `prefetch` and `count` as in its params. Pure. */
void motion_prefetcher_plan(double prefetch, size_t count, struct plan *plan);
/* Starts at time 0. */
enum status motion_prefetcher_create(const struct prefetcher_params *params, struct prefetcher **out) FURROW_CHECKED;
void motion_prefetcher_destroy(struct prefetcher *prefetcher); /* takes NULL */
/* Sets how far ahead it looks from now on, simulated seconds; before this `prefetch`. Does not wait. */
void motion_prefetcher_reach(struct prefetcher *prefetcher, double seconds);
/* Tells it the time, which never goes back. Does not wait. */
void motion_prefetcher_tell(struct prefetcher *prefetcher, double time);
/* Gives the ranges that pictures lack, most urgent first. They replace those given before, and are loaded between tiles. It
 * takes as many as it has room for. Does not wait. */
void motion_prefetcher_ranges(struct prefetcher *prefetcher, const struct ground_range_key *keys, size_t count);
/* Returns how many ranges it has finished since it began. */
uint64_t motion_prefetcher_ranges_done(struct prefetcher *prefetcher);
/* Waits until everything is loaded that it would load for the time last told. */
void motion_prefetcher_wait(struct prefetcher *prefetcher);

#endif
