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
#ifndef FURROW_MOTION_PREFETCHER_H
#define FURROW_MOTION_PREFETCHER_H

#include "motion/motion.h"

struct prefetcher;

struct prefetcher_params {
	struct store *store;
	struct ground *ground;             /* the owner of this ground calls all functions here */
	/* most tiles that it keeps in the ground; fewer than the ground's own limit, which also holds other tiles */
	uint32_t tiles;
	const struct track *const *tracks; /* copied; the tracks must stay valid longer than the prefetcher */
	/* One for each track: while *elsewhere is true nothing is loaded for its body. Copied with the tracks. NULL: there are none */
	const _Atomic bool *const *elsewhere;
	size_t count;                      /* at least 1 */
	double post;                       /* metres between a track's path samples */
	look_ahead_camera_fn camera;            /* NULL: there is no camera */
	const void *user;
	double camera_speed;               /* m/s: about the largest speed of the points of `camera` */
	double prefetch, end;              /* s: how far ahead it looks; end time of the drive */
	unsigned threads;                  /* at most 8; 0: motion_prefetcher_threads */
};

/* Returns the number of threads: by the number of bodies, and of cores of this machine. 0: there is no prefetcher. Pure. */
unsigned motion_prefetcher_threads(double prefetch, size_t count);
/* Adds the plan's lines of a prefetcher, if there is one. `prefetch` and `count` are as in its params. Pure. */
void motion_prefetcher_plan(double prefetch, size_t count, struct plan *plan);
/* Starts the threads, at simulated time 0. */
enum status motion_prefetcher_create(const struct prefetcher_params *params, struct prefetcher **out) FURROW_CHECKED;
void motion_prefetcher_destroy(struct prefetcher *prefetcher); /* prefetcher may be NULL */
/* Sets how many simulated seconds it looks ahead from now on; at the start it is `prefetch`. Does not wait. */
void motion_prefetcher_reach(struct prefetcher *prefetcher, double seconds);
/* Tells it the simulated time, which must not decrease. Does not wait. */
void motion_prefetcher_tell(struct prefetcher *prefetcher, double time);
/* Gives it the ranges that pictures lack, most urgent first. They replace the earlier ones. It takes as many as it has room
 * for, and loads them between tiles. Does not wait. */
void motion_prefetcher_ranges(struct prefetcher *prefetcher, const struct ground_range_key *keys, size_t count);
/* Returns how many ranges it has finished since its start. */
uint64_t motion_prefetcher_ranges_done(struct prefetcher *prefetcher);
/* Waits until everything is loaded that should be, by the last time it was told. */
void motion_prefetcher_wait(struct prefetcher *prefetcher);

#endif
