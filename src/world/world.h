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
#include "base/key_map.h"
#include "base/key_set.h"
#include "deform/deform.h"
#include "gpu/gpu.h"
#include "motion/motion.h"
#include "page/page.h"
#include "resident/resident.h"
#include "scene/scene.h"
#include "store/store.h"
#include "terrain/terrain.h"

struct forces; /* forces.c */
struct record; /* record.c */
struct world;

/* What the soil did to a body, as it was last asked for; all zero: nothing. */
struct world_force {
	double force[3], moment[3]; /* N, N m */
	double sinkage, area;       /* m, m2 */
	int64_t z;                  /* 2^-20 m */
};

/* Of the record that goes with each commit: as the last whole step, or what was resumed, left it. */
struct world_recorded {
	int64_t step;             /* done since the scene's start */
	double time;              /* s */
	struct pages_sums sums;   /* only of one that was read */
	size_t awake;             /* blocks where the ground may slide on */
};

/* One path sample that is due in a step, or one pose that a host gave: the body is already set upon the ground. */
struct event {
	size_t body;      /* index into world.bodies */
	double time;      /* s since the scene's start */
	bool contact;     /* false: outside the terrain or over nodata; the sample is skipped */
	double distance;  /* m along the ground since the sample before */
	double sinkage;   /* m below the base */
	double seconds;   /* since the sample before */
	double next_time; /* s: when the next sample is due; INFINITY: there is none */
	double turned;    /* rad about a wheel's axle since then; a host's bodies only */
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
	int soil;            /* index into the scene's soils, of the post nearest to the origin; -1: there is no terrain */
	struct world_force force;
};
/* Who takes the rows, in their order. `flush` is called after some. */
struct world_rows {
	void *user;
	enum status (*row)(void *user, const struct world_row *row);
	enum status (*flush)(void *user);
	/* A checkpoint: what is written so far stays. Then, to drop all that came after it. NULL: neither. */
	enum status (*mark)(void *user);
	enum status (*rollback)(void *user);
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
	double sinkage_before;    /* m, with a load: as it was some steps ago, always as many, whenever a commit or a picture waited */
	int64_t stands;           /* 2^-20 m: with a load, the height at which the soil carries it */
	int64_t raised;           /* how far that is above where it was looked for */
	uint32_t carrier;         /* with a load: its number among the loaded bodies, from 1 */
	int64_t skipped;          /* path samples without ground */
	uint64_t windows, windows_moved; /* computed, and those of them over which it moved */
};

/* Where a host's body is, and how it moves. Local axes: x east, y north, z up. */
struct world_pose {
	double position[3];    /* m */
	double orientation[4]; /* unit quaternion w, x, y, z: from the body's axes (x forward, y left, z up) to the local ones */
};
struct world_state {
	struct world_pose pose;
	double linear[3];  /* m/s, of the origin */
	double angular[3]; /* rad/s */
};

enum world_contact_state { WORLD_AIR, WORLD_TOUCHING, WORLD_SLIDES, WORLD_SUNK, WORLD_UNKNOWN };

/* What the soil does to a body. NaN: not known. */
struct world_contact {
	double time;                  /* s: of the ground and the state that it is of */
	double force[3], moment[3];   /* N, and N m about the origin, on the body, local axes */
	double point[3];              /* m: on the force's line, nearest the body's lowest point */
	double normal[3];             /* unit: of the undisturbed surface under the body */
	double sinkage, area, slip;   /* m below the undisturbed surface; m2; of a wheel */
	double normal_force, shear_limit; /* N */
	enum world_contact_state state;
};

/* One body of a host: hosts.c. */
struct host_body {
	struct body body;             /* `last`: the pose up to which its motion has changed the ground */
	struct scene_object *owned;   /* NULL: it is the scene's object */
	bool placed, removed;
	bool fresh;                   /* placed since the last step: nothing is between it and where it was */
	bool has_next;
	struct world_state now, next; /* after the last step; after the next, if has_next */
	double since;                 /* s in which it moved since `last` */
	double turned;                /* rad about a wheel's axle since `last` */
	struct deform_pose felt;      /* where its forces were found last, */
	double felt_turned;           /* with this `turned`, */
	bool felt_moving;             /* and with rates */
	uint64_t tag;                 /* of the forces that are on their way; 0: none */
	double asked;                 /* s: of those */
	double told;                  /* s: of `force` and `state` */
	struct world_force force;
	enum world_contact_state state;
	uint64_t turn;                /* world_bodies_set: of its last list */
};

/* A tile of the working level that changed: changes.c. */
struct changed_tile {
	struct tile tile;
	uint64_t last;         /* revision of its last change */
	uint64_t from;         /* `rect` holds all its changes after this revision; 0: it holds the whole tile */
	struct post_rect rect;
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
	struct world_hosts {      /* hosts.c: by number; NULL of a body with a path, and of one that a rollback took back */
		struct host_body **list;
		size_t count, room;
		uint64_t turn;        /* lists of states so far */
		double until;         /* s: the end of the step that is made */
	} hosts;
	struct checkpoint *checkpoint; /* checkpoint.c; NULL: none yet */
	struct world_changes {    /* changes.c; of a host's world */
		struct key_map places;  /* a tile's index in list */
		struct changed_tile *list;
		size_t count, room;
		uint64_t revision;      /* of the ground now */
		uint64_t asked;         /* that was told last */
		bool pending;           /* something changed since `revision` */
	} changes;
	struct world_warmed {     /* what warming up ran: not counted as the steps' */
		struct gpu_stats gpu;
		struct gpu_slots_figures slots;
		struct stalls stalls, range_waits;
		double load_ms; /* world_warm waited for tiles */
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
/* From now on somebody draws: of a host's world that did not until now. */
enum status world_start_drawing(struct world *world) FURROW_CHECKED;
/* Links every program, runs each once, and loads what the first step needs. */
enum status world_warm(struct world *world) FURROW_CHECKED;
/* From here on passes count as the steps', and a program that is linked is a mistake. */
void world_seal(struct world *world);
/* Commits that this run began, or goes on where the resumed one was. */
enum status world_begin(struct world *world) FURROW_CHECKED;
/* One time step. STATUS_FAILED, before anything changes: a path leaves the terrain and the scene says stop. */
enum status world_step(struct world *world) FURROW_CHECKED;
/* The same, to a time of the caller's, s, that is later than now. */
enum status world_step_to(struct world *world, double until) FURROW_CHECKED;
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
void world_recorded(const struct world *world, struct world_recorded *recorded);
void world_range_waits(const struct world *world, struct stalls *waits); /* for ranges of tiles, which are no stalls; since world_begin */

/* --- forces --- */

struct world_forces_figures {
	uint64_t saturated; /* posts whose share was too large to count */
	uint64_t sunk;      /* contacts in which the soil did not carry the load */
};
void world_forces_figures(const struct forces *forces, struct world_forces_figures *figures); /* not of NULL */
/* Uses everything that was asked for, waiting for it; into the record too. */
enum status world_settle_forces(struct world *world) FURROW_CHECKED;

/*
 * --- bodies of a host: those without a path, of a scene that was read for a host ---
 *
 * Numbers 0 .. object_count - 1 are the scene's objects in its order; those that are added follow. A number is never used again.
 * STATUS_USAGE: there is no such body, or it follows a path.
 */

/* Takes the object over, which scene_object_parse made, unless it fails. STATUS_INPUT: its name is taken, or its shape is
 * too large for the spacing or the slots. */
enum status world_body_add(struct world *world, struct scene_object *object, int32_t *number) FURROW_CHECKED;
/* STATUS_INPUT: no body has that name; *number is -1 then. */
enum status world_body_find(const struct world *world, const char *name, int32_t *number) FURROW_CHECKED;
/* Its soil is unloaded. */
enum status world_body_remove(struct world *world, int32_t number) FURROW_CHECKED;
/* Puts it there at rest, touching nothing in between. */
enum status world_body_place(struct world *world, int32_t number, const struct world_pose *pose) FURROW_CHECKED;
/* Where they will be after the next step: all of them, or on failure none. Each body at most once. */
enum status world_bodies_set(struct world *world, size_t count, const int32_t *numbers, const struct world_state *states)
	FURROW_CHECKED;
/* Of any body, also of one with a path. NaN: it was never placed. */
enum status world_body_state(const struct world *world, int32_t number, struct world_state *state) FURROW_CHECKED;
/* The same. Waits for the forces that are on their way. */
enum status world_body_contact(struct world *world, int32_t number, struct world_contact *contact) FURROW_CHECKED;
/* All so far is in the store, and what world_rollback goes back to. */
enum status world_checkpoint(struct world *world) FURROW_CHECKED;
/* Ground, bodies, forces, time and rows as the last checkpoint left them. STATUS_FAILED: there was none. */
enum status world_rollback(struct world *world) FURROW_CHECKED;
/* Rectangles of the working level that changed after the revision `since`, and the revision now. 0: all that the store keeps, too.
 * *count: room in, number out. STATUS_USAGE: too little room (number and revision are told), or a revision to come. */
enum status world_changes_since(struct world *world, uint64_t since, struct post_rect *rects, size_t *count, uint64_t *now)
	FURROW_CHECKED;
/* The ground changes up to where the host's bodies are. Nothing if none is behind. */
enum status world_hosts_commit(struct world *world) FURROW_CHECKED;

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
/* resident_read_posts. */
enum status world_read_posts(struct world *world, enum store_layer layer, int level, struct post_rect rect, double *values)
	FURROW_CHECKED;

/* Which of the scene's soils is at the post of the working level that is nearest to a place; -1: it is outside the terrain. */
enum status world_soil_at(struct world *world, double x, double y, int *soil) FURROW_CHECKED;

/* --- what follows from scene and store, before anything is made: plan.c --- */

/* The planes that are read and committed: those of the scene's model and dirt where it has objects; where it has none,
 * those that are drawn of what earlier drives left, if the store `was_deformed`. */
unsigned world_planes(const struct scene *scene, bool was_deformed);
bool world_needs_soil_map(const struct scene *scene); /* there is one, and something looks at it */
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
void world_budget(const struct world *world, struct resident_pages_budget *budget); /* bytes, of everything that holds tiles */

#endif
