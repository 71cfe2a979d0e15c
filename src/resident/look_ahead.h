/*
 * The look-ahead loads what bodies and pictures will need, before they need it. It has two halves. Its threads load tiles of base heights
 * into CPU memory. On the world's thread it gives prefetch requests for pages to the page cache, before each step.
 */
#ifndef FURROW_RESIDENT_LOOK_AHEAD_H
#define FURROW_RESIDENT_LOOK_AHEAD_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "base/plan.h"
#include "page/page.h"
#include "soil/soil.h"
#include "store/store.h"

struct deform_params;
struct ground;
struct ground_range_key;

/*
 * --- page requests ---
 *
 * Prefetch requests: pages that will be needed, and when. For each step they are collected again from everything that looks
 * ahead: the paths of bodies, and the camera. Then they are sorted by time for the page cache.
 */
struct request {
	uint64_t key;
	double time; /* s, simulated: when the page is needed */
	size_t order; /* number of requests added before this one; decides the order at equal times */
};

struct requests {
	struct request *requests;
	uint64_t *keys; /* filled by resident_requests_order */
	size_t count, room;
};

void resident_requests_clear(struct requests *requests);
void resident_requests_finish(struct requests *requests);
enum status resident_requests_add(struct requests *requests, uint64_t key, double time) FURROW_CHECKED;
/* Sorts the requests: each key once, soonest first; among equal times the first added. Returns how many there are. *keys is
 * valid until the requests change. */
size_t resident_requests_order(struct requests *requests, const uint64_t **keys);

/*
 * --- the look-ahead ---
 *
 * Its loading decides only how long a step waits, never the result. It has a thread if the scene uses prefetch and has a body
 * with a path, or a camera that follows such a body. For many bodies it has several. All calls come from the world's thread.
 */
struct look_ahead;

/* Fills `places` with the points where a camera needs the ground at `time`, in local metres. Returns their number, 0 to 2.
 * Called on the look-ahead's thread. */
typedef size_t (*look_ahead_camera_fn)(const void *user, double time, double places[2][2]);
/* Adds the pages that a picture will need. */
typedef enum status (*look_ahead_requests_fn)(void *user, struct requests *requests);

/* A path sample, as the look-ahead needs it. */
struct look_ahead_sample {
	double time;           /* s */
	double x, y;           /* metres from the south-west post */
	struct soil_pose pose; /* of the body; z and turn are 0 */
};

/* The path samples of a body, `spacing` metres apart. The functions are called on the look-ahead's threads, too. */
struct look_ahead_path {
	const void *user;      /* their first argument; must stay valid longer than the look-ahead */
	int64_t samples;       /* how many there are; INT64_MAX: the path has no end */
	double (*time)(const void *user, int64_t index); /* s; no sample is earlier than the one before it */
	void (*sample)(const void *user, int64_t index, struct look_ahead_sample *sample);
};

struct look_ahead_body {
	struct look_ahead_path path;
	const struct soil_shape *shape;    /* must stay valid longer than the look-ahead; only requests for pages need it */
	int64_t next;                      /* its next path sample */
	/* While it is true nothing is loaded for the body; changed on the world's thread. NULL: it is always false */
	const _Atomic bool *elsewhere;
};

struct look_ahead_params {
	struct store *store;
	struct ground *ground;             /* the world's ground; its owner calls all functions here */
	uint32_t tiles;                    /* most tiles that are kept in the ground; fewer than its own limit, which also holds others */
	const struct look_ahead_body *bodies; /* copied */
	size_t count;
	double spacing;                    /* m between path samples */
	look_ahead_camera_fn camera;       /* NULL: no camera needs the ground */
	const void *camera_user;
	double camera_speed;               /* m/s: about the largest speed of the points of `camera` */
	double prefetch;                   /* s of simulated time to look ahead; 0: nothing is loaded ahead */
	double end;                        /* s: end time of the drive; INFINITY: there is none */
	unsigned threads;                  /* at most 8; 0: resident_look_ahead_threads */
};
/* Returns the number of its threads, by the number of bodies with paths and of cores. Pure. */
unsigned resident_look_ahead_threads(double prefetch, size_t count);
/* Adds the plan's lines of a look-ahead. `prefetch` and `count` are as in look_ahead_params. `effect`: the name that the plan
 * gives as the reason. Pure. */
void resident_look_ahead_plan(double prefetch, size_t count, const char *effect, struct plan *plan);
/* Makes a look-ahead at time 0 and starts its thread. */
enum status resident_look_ahead_create(const struct look_ahead_params *params, struct look_ahead **out) FURROW_CHECKED;
void resident_look_ahead_destroy(struct look_ahead *ahead); /* ahead may be NULL */
/* Stops the thread. Requests for pages still work. ahead may be NULL. */
void resident_look_ahead_stop(struct look_ahead *ahead);

/* The data from which requests for pages are computed, and the cache that gets them. */
struct look_ahead_pages {
	const struct deform_params *surface; /* NULL: no body touches anything */
	const struct extent *extent;
	int level;                         /* the working level */
	struct page_cache *cache;
	size_t slots;                      /* number of slots of the cache */
	look_ahead_requests_fn requests;   /* NULL: no picture asks */
	void *user;
};
void resident_look_ahead_serve(struct look_ahead *ahead, const struct look_ahead_pages *pages);
/* Call this before each step. Requests the pages that will be needed. `time`: present simulated time, s. */
enum status resident_look_ahead_step(struct look_ahead *ahead, double time) FURROW_CHECKED;
/* Call this before the first step, in place of resident_look_ahead_step. It also waits until the requested pages are resident, as
 * far as there are slots. So no step waits for them. `stop` may be NULL. */
enum status resident_look_ahead_first(struct look_ahead *ahead, double time, const volatile sig_atomic_t *stop) FURROW_CHECKED;
/* Call this when the steps begin, at simulated `time`, s. From now on the speed of the steps is measured. */
void resident_look_ahead_begin(struct look_ahead *ahead, double time);
/* Moves time back or forward to `time`, s. `next`: the next path sample of each body, in the order of the params. */
void resident_look_ahead_rewind(struct look_ahead *ahead, const int64_t *next, double time);
/* Returns the last requests, in no order. They are valid until the next call. Returns NULL if ahead is NULL. */
const struct requests *resident_look_ahead_requests(const struct look_ahead *ahead);
/* Returns how many simulated seconds ahead of `time` tiles for bodies are loaded. It grows with the speed of the steps. */
double resident_look_ahead_reach(const struct look_ahead *ahead, double time);
/* Returns true if a thread reads ranges (resident_look_ahead_ranges). */
bool resident_look_ahead_brings_ranges(const struct look_ahead *ahead); /* ahead may be NULL */
/* Gives the thread the ranges that pictures lack, most urgent first. They replace the earlier ones. Does not wait. */
void resident_look_ahead_ranges(struct look_ahead *ahead, const struct ground_range_key *keys, size_t count);
/* Returns how many ranges the thread has finished. If the number has grown, new ranges may be in memory. */
uint64_t resident_look_ahead_ranges_done(const struct look_ahead *ahead);
/* Tells the thread the simulated time after a step, s. Does not wait. */
void resident_look_ahead_tell(struct look_ahead *ahead, double time);

#endif
