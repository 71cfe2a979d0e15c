/*
 * motion: paths, path samples, and where bodies and cameras will be. One look-ahead loads what they will need.
 *
 * Paths are pure: no store, no GL. The look-ahead has two halves: a thread that brings tiles of base heights to the CPU, and
 * requests for pages that the world's thread gives the page cache before each step.
 */
#ifndef FURROW_MOTION_H
#define FURROW_MOTION_H

#include <signal.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "base/plan.h"
#include "deform/deform.h"
#include "page/page.h"
#include "resident/resident.h"
#include "scene/scene.h"
#include "store/store.h"

/*
 * --- paths ---
 *
 * A path flattened once into stations one working post apart, whatever the time step.
 *
 * Length along a path is travel in three dimensions plus, so that turning in place counts, the turn
 * in radians times `turn_reach`. Station i lies at length i * post; the last one at the path's end.
 * Places are kept relative to the path's first point on the pose lattice, so that a path is the same
 * to the bit wherever it lies. Pure: no store, no GL. A struct track is read-only after motion_track_create.
 */
struct track;

struct track_point {
	double time;             /* s */
	int64_t qx, qy;          /* 2^-20 m, local */
	double x, y, z;          /* metres, local; z only if the path gives it */
	double yaw, pitch, roll; /* radians; yaw is the direction of travel if the path gives none */
};

/* `points` are local metres, in the order of path->points. */
enum status motion_track_create(const struct scene_path *path, const double (*points)[2], double post,
			 double turn_reach, struct track **out) FURROW_CHECKED;
void motion_track_destroy(struct track *track);

int64_t motion_track_samples(const struct track *track); /* INT64_MAX for a loop */
void motion_track_sample(const struct track *track, int64_t index, struct track_point *point);
double motion_track_sample_time(const struct track *track, int64_t index);
/* The first station that is not within 0 .. width, 0 .. height of the local metres; -1: all are. Of a loop, of its first lap,
 * which all others are like. */
int64_t motion_track_leaves(const struct track *track, double width, double height);
/* The fastest it goes along the ground, m/s. */
double motion_track_fastest(const struct track *track);
/* Where it was until `time`, for a picture: its corners and where it is, local metres, straight lines between them; of a loop,
 * no more than one lap. Returns how many, 1 to motion_track_corners(). */
size_t motion_track_corners(const struct track *track);
size_t motion_track_way(const struct track *track, double time, double (*places)[2]);
/* Where the scene's camera stands or looks on at `time`, metres, local: none to two places. `target`: the path of the body
 * that it follows or is above. Any thread. */
size_t motion_track_camera_places(const struct scene_view *view, const struct scene_path *path, const struct track *target, double time,
			   double places[2][2]);
/* Where the object is at `time` (held at the path's ends). */
void motion_track_at(const struct track *track, double time, struct track_point *point);

/*
 * --- page requests ---
 *
 * Wishes: pages that will be needed, and when. Gathered anew from everything that looks ahead (the
 * objects' paths, the camera), then put in the order of need for the page cache.
 */
struct request {
	uint64_t key;
	double time; /* simulated seconds: when it is needed */
	size_t order; /* of adding: settles equal times */
};

struct requests {
	struct request *requests;
	uint64_t *keys; /* filled by motion_requests_order */
	size_t count, room;
};

void motion_requests_clear(struct requests *requests);
void motion_requests_finish(struct requests *requests);
enum status motion_requests_add(struct requests *requests, uint64_t key, double time) FURROW_CHECKED;
/* Each key once, soonest first; of equal times the first added. Returns how many; valid until changed. */
size_t motion_requests_order(struct requests *requests, const uint64_t **keys);

/*
 * --- the look-ahead ---
 *
 * What it loads never decides what comes out, only when. Its thread is there where the scene prefetches and has a body with
 * a path, or a camera that follows one. All calls come from the world's thread.
 */
struct look_ahead;

/* Where (metres, local) a camera asks for the ground at `time`: up to two places. Called on the look-ahead's thread. */
typedef size_t (*look_ahead_camera_fn)(const void *user, double time, double places[2][2]);
/* Adds the pages that a picture will need. */
typedef enum status (*look_ahead_requests_fn)(void *user, struct requests *requests);

struct look_ahead_body {
	const struct track *track;         /* must outlive the look-ahead */
	const struct deform_shape *shape;  /* the same */
	int64_t next;                      /* its next path sample */
};

struct look_ahead_params {
	struct store *store;
	struct ground *ground;             /* the world's; `tiles` of its tiles are brought ahead at most */
	uint32_t tiles;
	const struct look_ahead_body *bodies; /* copied */
	size_t count;
	double spacing;                    /* m between path samples */
	look_ahead_camera_fn camera;       /* NULL: none asks */
	const void *camera_user;
	double camera_speed;               /* m/s, about the fastest its places move */
	double prefetch;                   /* s of simulated time to look ahead; 0: nothing is loaded ahead */
	double end;                        /* s: where time ends; INFINITY: nowhere */
};
/* The lines of one, `prefetch` and `count` as its params'. Pure. */
void motion_look_ahead_plan(double prefetch, size_t count, struct plan *plan);
/* Starts the thread, at time 0. */
enum status motion_look_ahead_create(const struct look_ahead_params *params, struct look_ahead **out) FURROW_CHECKED;
void motion_look_ahead_destroy(struct look_ahead *ahead); /* takes NULL */
/* Stops the thread; requests go on. Takes NULL. */
void motion_look_ahead_stop(struct look_ahead *ahead);

/* What requests are found by, and given to. */
struct look_ahead_pages {
	struct deform *deform;             /* NULL: no body touches anything */
	const struct extent *extent;
	int level;                         /* the working level */
	struct page_cache *cache;
	size_t slots;                      /* of the cache */
	look_ahead_requests_fn requests;   /* NULL: no picture asks */
	void *user;
};
void motion_look_ahead_serve(struct look_ahead *ahead, const struct look_ahead_pages *pages);
/* Before each step: gives the cache what will be needed. `time`: simulated now, s. */
enum status motion_look_ahead_step(struct look_ahead *ahead, double time) FURROW_CHECKED;
/* Before the first: waits for it too, as far as there are slots, so that no step pays. `stop` may be NULL. */
enum status motion_look_ahead_first(struct look_ahead *ahead, double time, const volatile sig_atomic_t *stop) FURROW_CHECKED;
/* The steps begin now, at simulated `time`: from here on the pace of the steps is known. */
void motion_look_ahead_begin(struct look_ahead *ahead, double time);
/* Time goes back, or on, to `time`: `next` is the next path sample of each of params' bodies. */
void motion_look_ahead_rewind(struct look_ahead *ahead, const int64_t *next, double time);
/* What was requested last, in no order; valid until the next call. Nothing of NULL. */
const struct requests *motion_look_ahead_requests(const struct look_ahead *ahead);
/* Returns how far ahead bodies load, in simulated seconds: farther the faster the steps are. */
double motion_look_ahead_reach(const struct look_ahead *ahead, double time);
/* Returns true if there is a thread that brings ranges (motion_look_ahead_ranges). */
bool motion_look_ahead_brings_ranges(const struct look_ahead *ahead); /* takes NULL */
/* The ranges that pictures lack, most urgent first, in the place of those that were given before. Waits for nothing. */
void motion_look_ahead_ranges(struct look_ahead *ahead, const struct ground_range_key *keys, size_t count);
/* How many ranges the thread has been through: more than before means that some may have come. */
uint64_t motion_look_ahead_ranges_done(const struct look_ahead *ahead);
/* A step is over: what time it is. Waits for nothing. */
void motion_look_ahead_tell(struct look_ahead *ahead, double time);

#endif
