/* The state of one drive, shared by the files of src/run. Only the GPU's thread touches it. */
#ifndef FURROW_RUN_INTERNAL_H
#define FURROW_RUN_INTERNAL_H

#include <stdio.h>

#include "deform/deform.h"
#include "gpu/gpu.h"
#include "page/page.h"
#include "run/ground.h"
#include "run/key_set.h"
#include "run/newest.h"
#include "run/pages.h"
#include "run/pictures.h"
#include "run/pyramid.h"
#include "run/record.h"
#include "run/run.h"
#include "run/scout.h"
#include "run/soil_map.h"
#include "run/times.h"
#include "run/track.h"
#include "run/wishes.h"
#include "store/store.h"

struct cJSON;
struct render_params; /* render/render.h */
struct view;     /* run/view.h */
struct prefetch; /* run/prefetch.c */
struct forces;   /* run/forces.c */
struct host;     /* run/host.c */

/* One object on its way. */
struct rider {
	const struct scene_object *object;
	struct track *track;
	int64_t next;             /* station */
	bool in_contact;          /* `last` was in contact: the next station sweeps from it */
	struct deform_pose last;
	double distance, sinkage; /* m */
	int64_t stands;           /* 2^-20 m: with a load, the height it was found at */
	int64_t raised;           /* how far that is above where it was looked for */
	uint32_t carrier;         /* with a load: its number among those that have one, from 1 */
	int64_t skipped;
	uint64_t windows, windows_moved; /* computed, and those of them over which it moved */
};

/* One station due in a step, already set upon the ground. */
struct event {
	size_t rider;
	double time;
	bool contact; /* false: outside or over nodata, skipped */
	double distance, sinkage;
	double seconds;   /* since the station before */
	double next_time; /* of the next; INFINITY: there is none */
	struct deform_pose pose;
};

/* The step's thread waited: for a page, for an epoch, or for the ground to set an object upon. */
struct stalls {
	uint64_t count;
	double ms;
};

struct drive {
	const struct run_params *params;
	const struct scene *scene;
	const char *path; /* of the store that is driven */
	struct store *store;
	const struct store_meta *meta;
	int level;      /* the working level */
	double spacing; /* metres, of the working level */
	bool was_deformed; /* the store, before this drive */
	struct gpu *gpu;
	struct gpu_slots *slots;
	struct deform *deform;
	struct soil_map *soil_map; /* NULL: one soil */
	struct forces *forces;   /* NULL: nothing asks for any */
	struct ground *ground;
	uint32_t ground_tiles;   /* it keeps at most */
	struct scout *scout;     /* NULL without prefetch, or without an object */
	struct pages *pages;
	struct page_cache *cache;
	struct page_trace *trace; /* NULL: none is asked for */
	struct pyramid *pyramid; /* NULL without a view: nobody looks at coarser levels */
	struct view *view;       /* NULL without one */
	struct pictures *pictures; /* NULL: none are kept */
	struct newest *newest;   /* NULL until the first query */
	struct host *host;       /* NULL but while a host has a say */
	uint64_t drops;          /* pressed by the host */
	FILE *epochs;
	struct rider *riders;
	struct deform_rest *rests; /* room for all objects */
	int64_t intervals;       /* of sliding, done or passed since the scene's start */
	uint64_t blocks_visited, blocks_possible; /* had all of each touched tile been visited */
	struct event *events;    /* of the present step */
	size_t event_count, event_room;
	struct wishes wishes;    /* pages needed in and after the present step */
	struct prefetch *prefetch;
	struct record *record;   /* as the last whole step, or what was resumed, left it */
	struct times step_ms, frame_ms; /* a frame is a step and its picture; without a view a step alone */
	struct gpu_stats before; /* what warming up took: not the drive's */
	struct gpu_slots_figures slots_before;
	unsigned threads;        /* that ran when the last step was over */
	struct stalls stalls_before; /* the first step */
	struct stalls stalls_settled; /* in the first second of the loop, once it is over: settled */
	bool settled;
	size_t frames;
	int64_t step;            /* steps done since the scene's start */
	double time;             /* simulated since then, s */
	bool resumed;            /* from these: */
	int64_t resumed_from;
	double resumed_time;
	bool nothing_left;       /* of what was resumed */
	double began, seconds;   /* wall clock of the loop */
	size_t window_tiles;     /* that one window can touch */
	uint64_t windows, windows_due; /* of sweeps: computed; had all been that are on the ground */
	struct key_set seen, old; /* air.c's: tiles that were looked at; of those, with planes from before the drive */
	bool asks_touched;       /* air.c's, as all of these */
	bool offsets_asked;
	int64_t offsets_most;    /* quanta: no offset is higher, under models that only lower them */
	uint64_t passes_most;    /* most tiles one window touched */
	bool told_tiles;
	bool torn;               /* inside a step's deformation */
};

/* steps.c */
/* Everything stands: commits that the drive began, or goes on where it was. */
enum status drive_begin(struct drive *drive) FURROW_CHECKED;
enum status drive_steps(struct drive *drive) FURROW_CHECKED;
enum status drive_step(struct drive *drive) FURROW_CHECKED; /* the next one */
/* The ground is whole again after something changed it: it may be committed, with the record as it is. */
enum status drive_end_step(struct drive *drive) FURROW_CHECKED;
bool drive_stopped(const struct drive *drive); /* Ctrl-C */
enum status drive_interrupted(const struct drive *drive) FURROW_CHECKED;
int64_t drive_step_count(const struct drive *drive);
void drive_stalls(const struct drive *drive, struct stalls *stalls); /* since the first step */
double drive_steps_until(const struct scene *scene, double time); /* whole ones */
double drive_step_time(const struct scene *scene, int64_t step); /* s: when it is done */

/* resume.c: sets the drive to where the store's last one of this scene is. The riders are mounted. */
enum status drive_resume(struct drive *drive) FURROW_CHECKED;
void drive_tell_unfinished(const struct drive *drive); /* that it could be resumed, and is not */

/* host.c: the loop of a drive that a host has a say in. */
enum status host_steps(struct drive *drive, int64_t total) FURROW_CHECKED;
/* drop.c: links what a host's drops can run, before the first step. */
enum status drop_warm(struct drive *drive) FURROW_CHECKED;

/* riders.c: makes the riders and the record, both of the scene's objects. One rider more is for what a host drops. */
enum status drive_mount(struct drive *drive) FURROW_CHECKED;
void drive_unmount(struct drive *drive); /* of one that was not mounted, too */

/* plan.c: what follows from the scene and the store, before anything is made. */
/* Settles the working level; the store refuses another than it has. STATUS_INPUT: it cannot be deformed so. */
enum status drive_settle_level(struct drive *drive) FURROW_CHECKED;
uint32_t drive_ground_tiles(const struct drive *drive);
/* Without gpu, slots and reference. */
void drive_deform_params(const struct drive *drive, struct deform_params *params);
/* Without gpu, slots, reference, low, high and layers. */
void drive_render_params(const struct drive *drive, struct render_params *params);
struct deform_planned drive_planned(const struct scene_object *object);
/* What the scene, over this store, says without effect. */
void drive_advise(const struct drive *drive, scene_advice_fn tell, void *user);

/* events.c: what is due, in the order of time, then of the scene. */
enum status drive_collect_events(struct drive *drive, double until) FURROW_CHECKED;
/* The object upon the ground at a station: pose, contact, distance and sinkage are filled. */
enum status drive_set_down(struct drive *drive, struct rider *rider, int64_t station, struct event *event)
	FURROW_CHECKED;

/* prefetch.c: what is loaded ahead. */
enum status prefetch_create(struct drive *drive, struct prefetch **out) FURROW_CHECKED;
void prefetch_destroy(struct prefetch *prefetch);
/* Before each step: asks for what will be needed. */
enum status prefetch_step(struct prefetch *prefetch) FURROW_CHECKED;
/* Before the first: waits for it too, as far as there are slots, so that no step pays. */
enum status prefetch_first(struct prefetch *prefetch) FURROW_CHECKED;

/* Tiles that are pinned together. */
#define BUDGET_WINDOW_TILES 64 /* that a window may touch at most */
struct held_tiles {
	struct deform_tile tiles[BUDGET_WINDOW_TILES];
	uint64_t keys[BUDGET_WINDOW_TILES];
	size_t count;
};

/* awake.c: the ground at large */
/* For undisturbed ground that slides: all of it may, from the first. Not more than budget_check lets pass. */
enum status drive_wake_all(struct drive *drive) FURROW_CHECKED;
/* What is over at `time` is: of the scene's start, or of what was resumed. */
void drive_intervals_from(struct drive *drive, double time);
/* All intervals before `time`, or also the one at it. */
enum status drive_intervals(struct drive *drive, double time, bool at_it) FURROW_CHECKED;
/* What the rider rests on it rests on no longer. */
enum status drive_let_go(struct drive *drive, const struct rider *rider) FURROW_CHECKED;

/* sweep.c: one station's deformation. */
/* Pins all tiles that hold a post of the rectangle; none after a failure. */
enum status drive_hold(struct drive *drive, struct post_rect rect, struct held_tiles *held) FURROW_CHECKED;
void drive_release(struct drive *drive, struct held_tiles *held);
/* The posts of the rectangle have changed in the held tiles: all who must know are told. */
enum status drive_mark(struct drive *drive, struct post_rect rect, const struct held_tiles *held) FURROW_CHECKED;
/* `last`: no other of this object follows in this step. */
enum status drive_sweep(struct drive *drive, const struct event *event, bool last) FURROW_CHECKED;

/* air.c: whether soil must be known by what was touched: it moves, and an object may be above it. */
bool drive_asks_touched(const struct drive *drive);
/* No part of the object is below this anywhere in the sweep, quanta. */
int64_t drive_lowest(const struct deform_sweep *sweep);
/* A tile is held: before anything changes it. */
enum status drive_see(struct drive *drive, const struct deform_tile *held) FURROW_CHECKED;
/* Whether nothing would change, were the sweep's windows computed; sets its `above`. May pin tiles for a while. */
enum status drive_is_aloft(struct drive *drive, const struct event *event, struct deform_sweep *sweep,
			   const struct deform_window *windows, size_t count, bool *aloft) FURROW_CHECKED;
/* counts.c: what was made and run; `gpu`: passes without those of warming up. */
void counts_add(struct cJSON *root, const struct drive *drive, const struct gpu_stats *gpu, const struct pages_io *io);

/* forces.c; a NULL forces is none. */
enum status forces_create(struct drive *drive, struct forces **out) FURROW_CHECKED; /* NULL: nothing asks for any */
void forces_destroy(struct forces *forces);
/* objects.csv: anew, or cut to what a resumed drive goes on from. */
enum status forces_open(struct drive *drive) FURROW_CHECKED;
/* The rows until then: before an event, with what stands so far. */
enum status forces_rows(struct forces *forces, double until, bool inclusive) FURROW_CHECKED;
/* The tag for the sweep of an event; 0: its forces are not asked for. */
uint64_t forces_ask(struct forces *forces, size_t object, const struct event *event, bool last_in_step);
/* It touches nothing there. */
void forces_absent(struct forces *forces, size_t object, const struct event *event);
/* What is due after so many steps is used. `until`: the step's end, s. */
enum status forces_end_step(struct forces *forces, double until) FURROW_CHECKED;
/* Everything that was asked for is used, whatever waits for it; into the record too. */
enum status forces_settle(struct forces *forces, struct record *record) FURROW_CHECKED;
struct forces_figures {
	uint64_t saturated; /* posts whose share was too large to count */
	uint64_t sunk;      /* sweeps in which the soil did not carry the load */
};
void forces_figures(const struct forces *forces, struct forces_figures *figures); /* not of NULL */

/* drive.c: of the pages, without store, gpu, slots, and what the drive has so far. */
void drive_pages_params(const struct drive *drive, struct pages_params *params);

/* budget.c */
/* STATUS_INPUT, with the number needed, if there are fewer slots than one window touches tiles, or more ground that slides
 * than may at once. */
enum status budget_check(struct drive *drive) FURROW_CHECKED;
/* Most pages one step can touch, for the queue's bound. */
uint32_t budget_step_pages(const struct drive *drive);
/* Of everything that holds tiles. */
void budget_bytes(const struct drive *drive, struct pages_budget *budget);

/* view.c */
enum status view_create(struct drive *drive, struct view **out) FURROW_CHECKED;
void view_destroy(struct view *view);
/* Loads what the first picture needs and draws it once, so that no step pays for either. */
enum status view_warm(struct view *view) FURROW_CHECKED;
/* `image`: wait for what the picture needs, and begin to write it. */
enum status view_frame(struct view *view, struct drive *drive, bool image) FURROW_CHECKED;
/* After the last step: what is still counted by the GPU is waited for. */
void view_settle(struct view *view);
/* A tile of the working level is deformed now: finer tiles exist below its ancestors. */
enum status view_deformed(struct view *view, struct tile tile) FURROW_CHECKED;
/* An object presses: what is deformed until the next call, it deforms. NULL: soil that moves by itself does. */
struct view_sweep {
	int64_t lowest;         /* quanta: no part of the object is lower. INT64_MIN: that is not known */
	struct post_rect changed, read; /* posts of the working level that may change, and that they may become like */
};
enum status view_pressed(struct view *view, const struct event *event, const struct view_sweep *sweep) FURROW_CHECKED;
/* The places (metres, local) whose ground the camera stands or looks on at `time`: none to two. `user` is the
 * drive. Any thread. */
size_t view_places(const void *user, double time, double places[2][2]);
/* Adds what the last picture lacked, needed now, and what pictures will need while `prefetch` lasts. */
enum status view_wishes(struct view *view, struct wishes *wishes) FURROW_CHECKED;
struct view_figures {
	double triangles;   /* a frame */
	double overdraw;    /* samples of ground drawn, over the picture's: a frame, of those that could be counted; NaN: of none */
	uint64_t starved;   /* frames drawn coarser than asked for: a tile stood in, or coarsened */
	uint64_t coarsened; /* frames cut to what the slots hold */
	uint64_t drawn, deformed; /* draws of tiles; those that read an offset */
};
void view_figures(const struct view *view, struct view_figures *figures);
/* For a host: */
struct render_camera;
struct render_layer;
void view_look_from(struct view *view, const struct render_camera *camera); /* NULL: the scene's camera */
void view_reach_at_least(struct view *view, double metres); /* from the base, either way, that the ground may be by now */
void view_show_layer(struct view *view, const struct render_layer *layer);
enum status view_resize(struct view *view, uint32_t width, uint32_t height) FURROW_CHECKED; /* from the next picture on */
bool view_lacks(const struct view *view);         /* the last picture was drawn before all its tiles had come */
uint64_t view_triangles(const struct view *view); /* of the last picture */
/* Begins to bring the last picture: gpu_texture_read_into, 4 x width x height bytes. */
void view_read_into(struct view *view, struct gpu_staging *staging);

/* where.c: where effects were, of where they might have been, into `root`; of the drive's passes alone. */
void where_report(struct cJSON *root, const struct drive *drive, const struct gpu_stats *gpu);

/* map.c: a picture of the drive so far, from what is committed; `ended` as in run.json. Aside and renamed. */
enum status map_write(const struct drive *drive, const char *path, const char *ended) FURROW_CHECKED;

/* report.c */
char *report_json(const struct drive *drive, const char *ended); /* NULL: out of memory */
enum status report_write(const char *directory, const char *json) FURROW_CHECKED;

#endif
