/*
 * motion: paths, path samples, and where bodies and cameras will be. One look-ahead loads what they will need.
 *
 * Paths are pure: no store, no GL. The look-ahead has two halves. A thread brings tiles of base heights to the CPU. The world's
 * thread gives prefetch requests for pages to the page cache before each step.
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
 * A path is flattened once into path samples one working post apart. They do not depend on the time step.
 *
 * Length along a path is the distance in three dimensions plus the turn in radians times `turn_reach`. So turning in place
 * counts too. Path sample i lies at length i * post; the last one lies at the path's end. Places are kept relative to the
 * path's first point on the pose lattice. So a path has the same bits wherever it lies. Pure: no store, no GL. A struct track
 * is read-only after motion_track_create.
 */
struct track;

struct track_point {
	double time;             /* s */
	int64_t qx, qy;          /* 2^-20 m, local */
	double x, y, z;          /* metres, local; z only if the path gives it */
	double yaw, pitch, roll; /* radians; yaw is the direction of travel if the path gives none */
};

/* Makes a track. `points`: local metres, one for each of path->points. `post`: metres between path samples. */
enum status motion_track_create(const struct scene_path *path, const double (*points)[2], double post,
			 double turn_reach, struct track **out) FURROW_CHECKED;
void motion_track_destroy(struct track *track);

int64_t motion_track_samples(const struct track *track); /* INT64_MAX for a loop */
void motion_track_sample(const struct track *track, int64_t index, struct track_point *point);
double motion_track_sample_time(const struct track *track, int64_t index);
/* Returns the first path sample outside 0 .. width, 0 .. height (local metres); -1: none is. Of a loop only the first lap is
 * looked at, since all laps are alike. */
int64_t motion_track_leaves(const struct track *track, double width, double height);
/* Returns the greatest speed along the ground, m/s. */
double motion_track_fastest(const struct track *track);
/* Fills `places` with the way until `time`, for a picture: the corners and the last place, in local metres. Straight lines join
 * them. Of a loop it tells at most one lap. Returns the number of places, 1 to motion_track_corners(). */
size_t motion_track_corners(const struct track *track);
size_t motion_track_way(const struct track *track, double time, double (*places)[2]);
/* Fills `places` with where the scene's camera is or looks at `time`, local metres. Returns how many: 0 to 2. `target`: the
 * path of the body that the camera follows or is above. Any thread. */
size_t motion_track_camera_places(const struct scene_view *view, const struct scene_path *path, const struct track *target, double time,
			   double places[2][2]);
/* Tells where the object is at `time`, s. Before the path's start and after its end it is at rest there. */
void motion_track_at(const struct track *track, double time, struct track_point *point);

/*
 * --- page requests ---
 *
 * Prefetch requests: pages that will be needed, and when. They are gathered anew from everything that looks ahead (the paths of
 * bodies, the camera). Then they are put in the order of need for the page cache.
 */
struct request {
	uint64_t key;
	double time; /* s, simulated: when the page is needed */
	size_t order; /* in which requests were added; decides between equal times */
};

struct requests {
	struct request *requests;
	uint64_t *keys; /* filled by motion_requests_order */
	size_t count, room;
};

void motion_requests_clear(struct requests *requests);
void motion_requests_finish(struct requests *requests);
enum status motion_requests_add(struct requests *requests, uint64_t key, double time) FURROW_CHECKED;
/* Sorts the requests: each key once, soonest first; among equal times the first added. Returns how many there are. *keys is
 * valid until the requests change. */
size_t motion_requests_order(struct requests *requests, const uint64_t **keys);

/*
 * --- the look-ahead ---
 *
 * What it loads decides only how long a step waits, never the result. It has a thread if the scene prefetches and has a body
 * with a path, or a camera that follows one. All calls come from the world's thread.
 */
struct look_ahead;

/* Fills `places` with where a camera needs the ground at `time`, local metres. Returns how many: 0 to 2. Called on the
 * look-ahead's thread. */
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
	struct ground *ground;             /* the world's; at most `tiles` of its tiles are loaded ahead */
	uint32_t tiles;
	const struct look_ahead_body *bodies; /* copied */
	size_t count;
	double spacing;                    /* m between path samples */
	look_ahead_camera_fn camera;       /* NULL: no camera needs the ground */
	const void *camera_user;
	double camera_speed;               /* m/s: about the greatest speed of the camera's places */
	double prefetch;                   /* s of simulated time to look ahead; 0: nothing is loaded ahead */
	double end;                        /* s: the end of time; INFINITY: there is none */
};
/* Adds the plan's lines of a look-ahead. `prefetch` and `count` are as in look_ahead_params. Pure. */
void motion_look_ahead_plan(double prefetch, size_t count, struct plan *plan);
/* Makes a look-ahead at time 0 and starts its thread. */
enum status motion_look_ahead_create(const struct look_ahead_params *params, struct look_ahead **out) FURROW_CHECKED;
void motion_look_ahead_destroy(struct look_ahead *ahead); /* takes NULL */
/* Stops the thread. Requests for pages still work. Takes NULL. */
void motion_look_ahead_stop(struct look_ahead *ahead);

/* What requests for pages are computed from, and the cache that gets them. */
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
/* Call before each step. Gives the cache the pages that will be needed. `time`: simulated now, s. */
enum status motion_look_ahead_step(struct look_ahead *ahead, double time) FURROW_CHECKED;
/* Call before the first step. Also waits until the requested pages are resident, as far as there are slots, so that no step
 * waits for them. `stop` may be NULL. */
enum status motion_look_ahead_first(struct look_ahead *ahead, double time, const volatile sig_atomic_t *stop) FURROW_CHECKED;
/* Says that the steps begin now, at simulated `time`, s. From here on the pace of the steps is measured. */
void motion_look_ahead_begin(struct look_ahead *ahead, double time);
/* Moves time back or forward to `time`, s. `next`: the next path sample of each body, in the order of the params. */
void motion_look_ahead_rewind(struct look_ahead *ahead, const int64_t *next, double time);
/* Returns what was requested last, in no order. Valid until the next call. NULL for NULL. */
const struct requests *motion_look_ahead_requests(const struct look_ahead *ahead);
/* Returns how far ahead of `time` tiles for bodies are loaded, in simulated seconds. It grows with the pace of the steps. */
double motion_look_ahead_reach(const struct look_ahead *ahead, double time);
/* Returns true if a thread reads ranges (motion_look_ahead_ranges). */
bool motion_look_ahead_brings_ranges(const struct look_ahead *ahead); /* takes NULL */
/* Gives the ranges that pictures lack, most urgent first. They replace those given before. Does not wait. */
void motion_look_ahead_ranges(struct look_ahead *ahead, const struct ground_range_key *keys, size_t count);
/* Returns how many ranges the thread has finished. If the number has grown, some ranges may have come. */
uint64_t motion_look_ahead_ranges_done(const struct look_ahead *ahead);
/* Tells the thread the simulated time after a step, s. Does not wait. */
void motion_look_ahead_tell(struct look_ahead *ahead, double time);

#endif
