/*
 * Threads that load tiles of the ground before bodies, and the camera that follows one, need them. So no step reads the
 * store. They also load ranges that pictures lack. Many bodies have several threads, as far as there are cores.
 *
 * It never changes results; only resident_ground_figures show its work. If it has not loaded a tile, or could not read it, the
 * ground's owner reads the tile itself and returns the failure.
 *
 * It looks `prefetch` seconds of simulated time ahead, but only as far as `tiles` tiles suffice. Tiles that are needed first
 * are loaded first.
 */
#ifndef FURROW_RESIDENT_PREFETCHER_H
#define FURROW_RESIDENT_PREFETCHER_H

#include "resident/resident.h"

struct prefetcher;

/* Starts the threads, at simulated time 0. `params`: of the look-ahead; `prefetch` is above 0 and `count` at least 1. It needs no shapes
 * of bodies. */
enum status resident_prefetcher_create(const struct look_ahead_params *params, struct prefetcher **out) FURROW_CHECKED;
void resident_prefetcher_destroy(struct prefetcher *prefetcher); /* prefetcher may be NULL */
/* Sets how many simulated seconds it looks ahead from now on; at the start it is `prefetch`. Does not wait. */
void resident_prefetcher_reach(struct prefetcher *prefetcher, double seconds);
/* Tells it the simulated time, which must not decrease. Does not wait. */
void resident_prefetcher_tell(struct prefetcher *prefetcher, double time);
/* Gives it the ranges that pictures lack, most urgent first. They replace the earlier ones. It takes as many as it has room
 * for, and loads them between tiles. Does not wait. */
void resident_prefetcher_ranges(struct prefetcher *prefetcher, const struct ground_range_key *keys, size_t count);
/* Returns how many ranges it has finished since its start. */
uint64_t resident_prefetcher_ranges_done(struct prefetcher *prefetcher);
/* Waits until everything is loaded that should be, by the last time it was told. */
void resident_prefetcher_wait(struct prefetcher *prefetcher);

#endif
