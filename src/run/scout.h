/*
 * A thread that goes ahead of the objects, and of the camera that follows one, and brings the ground's tiles they
 * will ask for, so that no step reads the store. What it does shows in ground_figures alone: a tile it has
 * not brought, or could not read, the ground's owner reads itself, and tells of it.
 *
 * It looks `prefetch` seconds of simulated time ahead, but only as far as `tiles` tiles reach: the soonest needed.
 */
#ifndef FURROW_RUN_SCOUT_H
#define FURROW_RUN_SCOUT_H

#include "base/plan.h"
#include "run/ground.h"
#include "run/track.h"
#include "store/store.h"

struct scout;

/* Where (metres, local) the camera asks for the ground at `time`: up to two places. Called on the scout's thread. */
typedef size_t (*scout_camera_fn)(const void *user, double time, double places[2][2]);

struct scout_params {
	struct store *store;
	struct ground *ground;             /* its owner calls all of this */
	uint32_t tiles;                    /* most it keeps there; fewer than the ground's, which has others too */
	const struct track *const *tracks; /* copied; the tracks must outlive it */
	size_t count;                      /* at least 1 */
	double post;                       /* metres between a track's stations */
	scout_camera_fn camera;            /* NULL: asks for none */
	const void *user;
	double camera_speed;               /* m/s, about the fastest its places move */
	double prefetch, end;              /* s: how far ahead, and where time ends */
};

/* The lines of one, if there is any: `prefetch` and `count` as its params'. Pure. */
void scout_plan(double prefetch, size_t count, struct plan *plan);
/* Starts at time 0. */
enum status scout_create(const struct scout_params *params, struct scout **out) FURROW_CHECKED;
void scout_destroy(struct scout *scout); /* takes NULL */
/* How far ahead it looks from now on, simulated seconds; until then `prefetch`. Waits for nothing. */
void scout_reach(struct scout *scout, double seconds);
/* What time it is: no less than before. Waits for nothing. */
void scout_tell(struct scout *scout, double time);
/* Until everything is there that it would bring at the time last told. */
void scout_wait(struct scout *scout);

#endif
