/*
 * world: a terrain that is open for simulation. It owns the bodies and the step: what is due in a step, what it does to the
 * ground, the relaxation of the ground, forces, commits and the record that a resumed drive goes on from.
 *
 * The world does not know who steps it. A host prepares it, starts it, warms it up, and then calls world_step. The
 * command, the window and the library are such hosts. Who draws watches the world through struct world_watcher.
 *
 *     world_prepare -> world_start -> (a view is made) -> world_warm -> world_begin -> world_step ... -> world_end -> world_finish
 *
 * Only one thread uses a world, the one that owns its GL context. Each part of struct world belongs to the file that is
 * named beside it; other files read it.
 */
#ifndef FURROW_WORLD_H
#define FURROW_WORLD_H

#include <signal.h>
#include <stdint.h>
#include <stdio.h>

#include "base/base.h"
#include "base/key_set.h"
#include "deform/deform.h"
#include "gpu/gpu.h"
#include "motion/motion.h"
#include "page/page.h"
#include "resident/resident.h"
#include "scene/scene.h"
#include "store/store.h"
#include "terrain/terrain.h"
#include "world/record.h"

struct forces; /* forces.c */
struct world;

/* One path sample that is due in a step, or one pose that a host gave: the body is already set upon the ground. */
struct event {
	size_t body;      /* index into world.bodies */
	double time;      /* s since the scene's start */
	bool contact;     /* false: outside the terrain or over nodata; the sample is skipped */
	double distance;  /* m along the ground since the sample before */
	double sinkage;   /* m below the base */
	double seconds;   /* since the sample before */
	double next_time; /* s: when the next sample is due; INFINITY: there is none */
	struct deform_pose pose;
};

/* A body is about to change the ground in this area. */
struct contact_area {
	int64_t lowest;         /* 2^-20 m: no part of the body is lower. INT64_MIN: that is not known */
	struct post_rect changed, read; /* posts of the working level that may change, and that they may become like */
};

/*
 * Who watches a world, to draw it. All calls come from the world's thread, except `places`. Any function may be NULL.
 * A status other than STATUS_OK makes the step fail with it.
 */
struct world_watcher {
	void *user;
	/* The next changes come from this contact. Both NULL: from now on changes come from relaxation. */
	enum status (*contact)(void *user, const struct event *event, const struct contact_area *area);
	/* Posts of this tile of the working level have changed. */
	enum status (*changed)(void *user, struct tile tile);
	/* Adds the tiles that the watcher will need and when. */
	enum status (*requests)(void *user, struct requests *requests);
	/* The ground may lie up to so many metres off its base from now on. */
	void (*reach)(void *user, double metres);
};

/* Who must be ready before a commit. Both may be NULL. */
struct world_commits {
	void *user;
	void (*before_record)(void *user);         /* the world's thread, before a commit takes the record */
	enum status (*before_commit)(void *user);  /* the writer thread, before it commits */
};

/* A row of objects.csv: what the soil does to a body at a time. */
struct world_row {
	double time;         /* s */
	size_t body;
	double position[3];  /* m, of the body's origin */
	struct record_force force;
};
/* Who takes the rows, in their order. `flush` is called after some. */
struct world_rows {
	void *user;
	enum status (*row)(void *user, const struct world_row *row);
	enum status (*flush)(void *user);
};

struct world_params {
	const struct scene *scene; /* must outlive the world */
	const char *store;         /* path; overrides the scene's; may be NULL if that names one */
	const char *overlay;       /* path of what keeps the deformation instead of the store; made if absent; may be NULL */
	bool resume;               /* go on from the store's last drive of this scene; begin anew if there was none */
	bool durable_full;
	bool everywhere;           /* contacts are computed where they change nothing, too: for tests that compare */
	bool draws;                /* somebody draws: coarser levels are kept */
	bool drops;                /* a window may drop bodies */
	bool rows;                 /* somebody takes the rows that the scene's output.forces asks for */
	int64_t steps;             /* the last step, since the scene's start; 0: until the scene's end_time */
	const volatile sig_atomic_t *stop; /* becomes non-zero: waits are given up; may be NULL */
};

/* One body. Its shape, sink, load and slip are the scene object's. */
struct body {
	const struct scene_object *object;
	struct track *track;
	int64_t next;             /* path sample */
	bool in_contact;          /* `last` was in contact: the next contact is swept from it */
	struct deform_pose last;
	double distance, sinkage; /* m */
	int64_t stands;           /* 2^-20 m: with a load, the height at which the soil carries it */
	int64_t raised;           /* how far that is above where it was looked for */
	uint32_t carrier;         /* with a load: its number among the loaded bodies, from 1 */
	int64_t skipped;          /* path samples without ground */
	uint64_t windows, windows_moved; /* computed, and those of them over which it moved */
};

/* The step's thread waited: for a page, for a commit, or for the ground to set a body upon. */
struct stalls {
	uint64_t count;
	double ms;
};

struct world {
	struct world_params params;
	const struct scene *scene;
	const char *path; /* of the store or overlay that is written */
	const struct world_watcher *watcher; /* NULL: nobody watches */
	const struct world_rows *rows;       /* NULL: nobody takes rows */
	const struct world_commits *commits; /* NULL: nobody */
	int64_t step;     /* steps done since the scene's start */
	double time;      /* simulated since then, s */
	bool torn;        /* inside a step: the ground may not be committed */
	struct world_resumed {
		bool is;
		int64_t from;  /* step */
		double time;   /* s */
		bool nothing_left;
	} resumed;
	struct record *record; /* as the last whole step, or what was resumed, left it */

	/* The ground in memory. */
	struct store *store;
	const struct store_meta *meta;
	int level;         /* the working level */
	double spacing;    /* m, of the working level */
	bool was_deformed; /* the store, before this world was opened */
	struct gpu *gpu;
	struct gpu_slots *slots;
	struct ground *ground;
	uint32_t ground_tiles; /* it keeps at most */
	struct soil_map *soil_map; /* NULL: one soil */
	struct pages *pages;
	struct page_cache *cache;
	struct page_trace *trace; /* NULL: none is asked for */
	struct pyramid *pyramid;  /* NULL: nobody looks at coarser levels */
	struct newest *newest;    /* NULL until the first query */
	FILE *epochs;             /* a line for each commit; NULL: none */

	struct deform *deform;    /* NULL: no body */
	struct forces *forces;    /* forces.c; NULL: nobody asks for any */
	struct look_ahead *ahead; /* motion: loads what will be needed */
	struct body *bodies;      /* bodies.c: the scene's objects in its order, and one more for what a window drops */

	struct world_events {     /* events.c: of the present step */
		struct event *list;
		size_t count, room;
	} events;
	struct world_relaxation { /* relaxation.c */
		struct deform_rest *rests; /* room for all bodies */
		int64_t intervals;         /* done, or passed, since the scene's start */
		uint64_t visited, possible; /* blocks; `possible`: had all of each touched tile been visited */
	} relaxation;
	struct world_aloft {      /* aloft.c */
		struct key_set seen, old; /* tiles that were looked at; of those, with planes from before this world */
		bool asks_touched;
		bool offsets_asked;
		int64_t offsets_most; /* 2^-20 m: no offset is higher, under models that only lower them */
	} aloft;
	struct world_windows {    /* contact.c */
		uint64_t computed, due; /* of contacts; `due`: had all been computed that are on the ground */
		size_t tiles;           /* that one window can touch, by the budget */
		uint64_t tiles_most;    /* that one window touched */
		bool told;
	} windows;
	uint64_t drops;           /* drop.c: bodies that a window dropped */
	struct world_warmed {     /* what warming up ran: not counted as the steps' */
		struct gpu_stats gpu;
		struct gpu_slots_figures slots;
		struct stalls stalls;
	} warmed;
};

/* --- a world's life --- */

/* Opens the store, makes the bodies, reads the record of what is resumed. Changes nothing. `world` is all zero before. */
enum status world_prepare(struct world *world, const struct world_params *params) FURROW_CHECKED;
/* Starts the look-ahead's thread; makes the GL context, the slots and all that bodies need. */
enum status world_start(struct world *world) FURROW_CHECKED;
/* Makes the page cache and its threads. `epochs` (a line for each commit) and `trace` may be NULL; both become the world's. */
enum status world_start_pages(struct world *world, FILE *epochs, struct page_trace *trace) FURROW_CHECKED;
/* Says who watches, before world_warm. The watcher stays the caller's and must outlive the world. */
void world_watch(struct world *world, const struct world_watcher *watcher);
/* Links every program, runs each once, and loads what the first step needs. */
enum status world_warm(struct world *world) FURROW_CHECKED;
/* From here on passes count as the steps', and a program that is linked is a mistake. */
void world_seal(struct world *world);
/* Commits that this run began, or goes on where the resumed one was. */
enum status world_begin(struct world *world) FURROW_CHECKED;
/* One time step. STATUS_FAILED, before anything changes: a path leaves the terrain and the scene says stop. */
enum status world_step(struct world *world) FURROW_CHECKED;
/* Commits everything, with `ended` in the record. A world inside a failed step commits nothing. */
enum status world_end(struct world *world, bool ended) FURROW_CHECKED;
/* Stops the threads, so that figures are whole. Takes a world that was not started. */
void world_stop(struct world *world);
/* Frees everything. `status`: how it ended; after a failure an overlay that holds nothing is removed. Takes one that is all
 * zero, or that failed half-way. */
void world_finish(struct world *world, enum status status);

/* --- steps --- */

int64_t world_step_count(const struct world *world); /* the last step */
double world_steps_until(const struct scene *scene, double time); /* whole ones */
double world_step_time(const struct scene *scene, int64_t step);  /* s: when it is done */
bool world_stopped(const struct world *world); /* Ctrl-C */
enum status world_interrupted(const struct world *world) FURROW_CHECKED;
/* The ground is whole again after something changed it: it may be committed, with the record as it is. */
enum status world_end_step(struct world *world) FURROW_CHECKED;
void world_stalls(const struct world *world, struct stalls *stalls); /* since world_begin */

/* --- forces --- */

struct forces_figures {
	uint64_t saturated; /* posts whose share was too large to count */
	uint64_t sunk;      /* contacts in which the soil did not carry the load */
};
void forces_figures(const struct forces *forces, struct forces_figures *figures); /* not of NULL */
/* Uses everything that was asked for, waiting for it; into the record too. */
enum status forces_settle(struct forces *forces, struct record *record) FURROW_CHECKED;

/* --- bodies that a window drops: set down, pressed once and taken away. Its lowest point comes `sink` under the surface as
 * it is; with a load the soil decides --- */
enum world_drop_shape {
	WORLD_DROP_FIRST, /* the scene's first object's shape and sink or load */
	WORLD_DROP_BALL,
	WORLD_DROP_SHAPES
};
/* *pressed false: there is no ground there, or the scene has no object, and nothing was done. */
enum status world_drop(struct world *world, enum world_drop_shape shape, double x, double y, double yaw, bool *pressed)
	FURROW_CHECKED;
/* Where a body is by its path, now: local metres, on the base; yaw in radians from east to north. */
void world_place(const struct world *world, size_t body, double place[3], double *yaw);

/*
 * --- queries ---
 *
 * Between two steps. What is told is the newest ground, wherever it is: a rut of the step before, too. A query changes nothing
 * that results depend on. terrain/terrain.h says what heights and rays are. A call for many is cheaper than many calls.
 */
enum status world_heights(struct world *world, const struct terrain_point *points, size_t count, struct terrain_height *heights)
	FURROW_CHECKED;
enum status world_rays(struct world *world, const struct terrain_ray *rays, size_t count, struct terrain_hit *hits) FURROW_CHECKED;

/* --- what follows from scene and store, before anything is made: plan.c --- */

/* Opens the store for reading, or (store NULL) takes ground that is assumed, which `assumed` gets, and makes the bodies. Only for
 * plans; world_finish ends it. */
enum status world_prepare_plan(struct world *world, const struct scene *scene, const char *store, struct store_meta *assumed)
	FURROW_CHECKED;
/* Tells what of the scene, over this store, has no effect. */
void world_advise(const struct world *world, scene_advice_fn tell, void *user);
/* Adds the lines of what contacts make and run; then those of the pages and of the look-ahead. */
enum status world_plan_deform(const struct world *world, struct plan *plan) FURROW_CHECKED;
void world_plan_pages(const struct world *world, struct plan *plan);
uint64_t world_samples_until(const struct track *track, double end); /* path samples that are due until then */

/* --- what a world needs at least, and what it takes at most: budget.c --- */

/* STATUS_INPUT, with the number needed, if there are fewer slots than one window touches tiles, or more ground that relaxes
 * than may at once. */
enum status world_budget_check(struct world *world) FURROW_CHECKED;
void world_budget(const struct world *world, struct pages_budget *budget); /* bytes, of everything that holds tiles */

#endif
