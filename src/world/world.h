/*
 * world: a terrain that is open for simulation. It owns the bodies and the step: the events that are due, what they do to the
 * ground, relaxation, forces, and commits. It also owns the record that a resumed drive goes on from.
 *
 * The world does not know who steps it. A host prepares it, starts it, warms it up, and then calls world_step. The command, the
 * window and the library are such hosts. Who draws watches the world through struct world_watcher.
 *
 *     world_prepare -> world_start -> (a view is made) -> world_warm -> world_begin -> world_step ... -> world_end -> world_finish
 *
 * Only one thread uses a world, the one that owns its GL context. Each part of struct world belongs to the file that is named
 * beside it; other files read it.
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

/* What the soil did to a body when this was last computed. All zero: nothing. */
struct world_force {
	double force[3], moment[3]; /* N, N m */
	double sinkage, area;       /* m, m2 */
	int64_t z;                  /* 2^-20 m */
};

/* A part of the record that goes with each commit, as the last whole step or the resumed run left it. */
struct world_recorded {
	int64_t step;             /* steps done since the scene's start */
	double time;              /* s */
	struct pages_sums sums;   /* only in a record that was read from the store */
	size_t active;            /* active blocks: soil may still relax there */
};

/* One path sample that is due in a step, or one pose that a host gave. The body is already set upon the ground. */
struct event {
	size_t body;      /* index into world.bodies */
	double time;      /* s since the scene's start */
	bool contact;     /* false: outside the terrain or over nodata; the sample is skipped */
	double distance;  /* m along the ground since the sample before */
	double sinkage;   /* m below the base */
	double seconds;   /* s since the sample before */
	double next_time; /* s: when the next sample is due; INFINITY: there is no next sample */
	double turned;    /* rad about a wheel's axle since then; a host's bodies only */
	struct deform_pose pose;
};

/* A body is about to change the ground in this area. */
struct contact_area {
	int64_t lowest;         /* 2^-20 m: no part of the body is lower. INT64_MIN: not known */
	struct post_rect changed, read; /* posts of the working level that may change, and posts whose values they may take */
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

/* Calls before a commit. Both may be NULL. */
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
/* Takes the rows in their order. `flush` is called after some rows. */
struct world_rows {
	void *user;
	enum status (*row)(void *user, const struct world_row *row);
	enum status (*flush)(void *user);
	/* `mark`: a checkpoint; rows written so far are kept. `rollback`: drops all rows after the checkpoint. NULL: no
	 * checkpoints. */
	enum status (*mark)(void *user);
	enum status (*rollback)(void *user);
};

struct world_params {
	const struct scene *scene; /* must outlive the world */
	const char *store;         /* path; overrides the scene's; may be NULL if that names one */
	const char *overlay;       /* path of what keeps the deformation instead of the store; made if absent; may be NULL */
	bool resume;               /* goes on from the store's last drive of this scene; begins anew if there was none */
	bool durable_full;
	bool everywhere;           /* contacts are computed where they change nothing, too: for tests that compare */
	bool draws;                /* somebody draws: coarser levels are kept */
	bool drops;                /* a window may drop bodies */
	bool rows;                 /* somebody takes the rows that the scene's output.forces asks for */
	int64_t steps;             /* the last step, counted from the scene's start; 0: until the scene's end_time */
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
	/* m, for a body with a load: `sinkage` as it was a fixed number of steps ago. Waits for commits and pictures do not
	 * change it */
	double sinkage_before;
	int64_t equilibrium;           /* 2^-20 m, for a body with a load: its equilibrium height, where the soil carries it */
	int64_t raised;           /* 2^-20 m: how far `equilibrium` is above the height at which the search began */
	uint32_t loaded_body;         /* for a body with a load: its number among the loaded bodies, from 1 */
	int64_t skipped;          /* path samples without ground */
	uint64_t windows, windows_moved; /* windows computed; windows over which the body moved */
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
	double time;                  /* s: the time of the ground and the state that it describes */
	double force[3], moment[3];   /* N, and N m about the origin, on the body, local axes */
	double point[3];              /* m: the point on the force's line nearest the body's lowest point */
	double normal[3];             /* unit vector: of the undisturbed surface under the body */
	double sinkage, area, slip;   /* m below the undisturbed surface; m2; slip of a wheel */
	double normal_force, shear_limit; /* N */
	enum world_contact_state state;
};

/* One body of a host: hosts.c. */
struct host_body {
	struct body body;             /* `last`: the pose up to which its motion has changed the ground */
	struct scene_object *owned;   /* NULL: it is the scene's object */
	bool placed, removed;
	bool fresh;                   /* placed since the last step: no motion leads to where it is */
	bool has_next;
	struct world_state now, next; /* `now`: after the last step; `next`: after the next step, if has_next */
	double since;                 /* s: time of its motion since `last` */
	double turned;                /* rad about a wheel's axle since `last` */
	struct deform_pose felt;      /* the pose for which its forces were last computed, */
	double felt_turned;           /* the value of `turned` then, */
	bool felt_moving;             /* and whether it moved then */
	uint64_t tag;                 /* of the forces being computed; 0: none */
	double asked;                 /* s: time of those forces */
	double told;                  /* s: time of `force` and `state` */
	struct world_force force;
	enum world_contact_state state;
	uint64_t turn;                /* world_bodies_set: number of the last list that named this body */
};

/* A tile of the working level that changed: changes.c. */
struct changed_tile {
	struct tile tile;
	uint64_t last;         /* revision of the last change */
	uint64_t from;         /* `rect` holds all changes after this revision; 0: it holds the whole tile */
	struct post_rect rect;
};

/* Times the step's thread waited: for a page, for a commit, or for the ground to set a body upon. */
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
	bool torn;        /* inside a step: the ground may not be committed now */
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
	bool was_deformed; /* the store was deformed before this world was opened */
	struct gpu *gpu;
	struct gpu_slots *slots;
	struct ground *ground;
	uint32_t ground_tiles; /* tiles that `ground` keeps at most */
	struct soil_map *soil_map; /* NULL: one soil */
	struct pages *pages;
	struct page_cache *cache;
	struct page_trace *trace; /* NULL: none is asked for */
	struct pyramid *pyramid;  /* NULL: nobody uses coarser levels */
	struct newest *newest;    /* NULL until the first query */
	FILE *commit_log;         /* a line for each commit; NULL: none */

	struct deform *deform;    /* NULL: no body */
	struct forces *forces;    /* forces.c; NULL: nobody asks for any */
	struct look_ahead *ahead; /* motion: loads what will be needed */
	struct body *bodies;      /* bodies.c: the scene's objects in its order, and one more for what a window drops */

	struct world_events {     /* events.c: events of the current step */
		struct event *list;
		size_t count, room;
	} events;
	struct world_relaxation { /* relaxation.c */
		struct deform_rest *rests; /* room for all bodies */
		int64_t intervals;         /* intervals done or skipped since the scene's start */
		uint64_t visited, possible; /* blocks; `possible`: the number if all blocks of each touched tile were visited */
	} relaxation;
	struct world_aloft {      /* aloft.c */
		struct key_set seen, old; /* `seen`: tiles that were looked at; `old`: those of them with planes from before this world */
		bool asks_touched;
	} aloft;
	struct world_windows {    /* contact.c */
		uint64_t computed, due; /* windows of contacts; `due`: the number if all contacts on the ground were computed */
		size_t tiles;           /* most tiles that one window can touch, by the budget */
		uint64_t tiles_most;    /* most tiles that one window touched */
		bool told;
	} windows;
	uint64_t drops;           /* drop.c: bodies that a window dropped */
	struct world_hosts {      /* hosts.c: by number. NULL for a body with a path, and for one that a rollback removed */
		struct host_body **list;
		size_t count, room;
		uint64_t turn;        /* number of lists of states so far */
		double until;         /* s: the end of the current step */
	} hosts;
	struct checkpoint *checkpoint; /* checkpoint.c; NULL: none yet */
	struct world_changes {    /* changes.c; of a host's world */
		struct key_map places;  /* a tile's index in list */
		struct changed_tile *list;
		size_t count, room;
		uint64_t revision;      /* revision of the ground now */
		uint64_t asked;         /* revision that was returned last */
		bool pending;           /* something changed since `revision` */
	} changes;
	struct world_warmed {     /* what warming up ran; it is not counted in the steps' figures */
		struct gpu_stats gpu;
		struct gpu_slots_figures slots;
		struct stalls stalls, range_waits;
		double load_ms; /* time that world_warm waited for tiles */
	} warmed;
};

/* --- a world's life --- */

/* Opens the store, makes the bodies, and reads the record of a resumed run. Changes nothing. `world` must be all zero. */
enum status world_prepare(struct world *world, const struct world_params *params) FURROW_CHECKED;
/* Starts the look-ahead's thread. Makes the GL context, the slots and everything that bodies need. */
enum status world_start(struct world *world) FURROW_CHECKED;
/* Makes the page cache and its threads. `commit_log`: a file that gets a line for each commit. `trace`: notes each access. Either
 * may be NULL. The world takes both over. */
enum status world_start_pages(struct world *world, FILE *commit_log, struct page_trace *trace) FURROW_CHECKED;
/* Sets the watcher. Call it before world_warm. The watcher stays the caller's and must outlive the world. */
void world_watch(struct world *world, const struct world_watcher *watcher);
/* Lets a host's world be drawn from now on, if it was not drawn before. */
enum status world_start_drawing(struct world *world) FURROW_CHECKED;
/* Links every program, runs each once, and loads what the first step needs. */
enum status world_warm(struct world *world) FURROW_CHECKED;
/* From here on passes are counted as the steps'. A program linked later is counted as an error. */
void world_seal(struct world *world);
/* Commits the start of this run, or goes on where the resumed run stopped. */
enum status world_begin(struct world *world) FURROW_CHECKED;
/* Makes one time step. STATUS_FAILED, before anything changes: a path leaves the terrain and the scene says stop. */
enum status world_step(struct world *world) FURROW_CHECKED;
/* Makes one step that ends at `until`, s, which must be later than now. */
enum status world_step_to(struct world *world, double until) FURROW_CHECKED;
/* Commits everything, with `ended` in the record. Commits nothing if a step failed half-way. */
enum status world_end(struct world *world, bool ended) FURROW_CHECKED;
/* Stops the threads, so that figures are complete. Also takes a world that was not started. */
void world_stop(struct world *world);
/* Frees everything. `status`: how the drive ended; after a failure an overlay without a commit is removed. Also takes a world
 * that is all zero or that failed half-way. */
void world_finish(struct world *world, enum status status);

/* --- steps --- */

int64_t world_step_count(const struct world *world); /* the last step */
double world_steps_until(const struct scene *scene, double time); /* whole steps until `time`, s */
double world_step_time(const struct scene *scene, int64_t step);  /* s: when this step ends */
bool world_stopped(const struct world *world); /* true after Ctrl-C */
enum status world_interrupted(const struct world *world) FURROW_CHECKED;
/* Ends a change of the ground: from now on it may be committed, with the record as it is. */
enum status world_end_step(struct world *world) FURROW_CHECKED;
void world_stalls(const struct world *world, struct stalls *stalls); /* since world_begin */
void world_recorded(const struct world *world, struct world_recorded *recorded);
/* waits for ranges of tiles, which are not counted as stalls; since world_begin */
void world_range_waits(const struct world *world, struct stalls *waits);

/* --- forces --- */

struct world_forces_figures {
	uint64_t saturated; /* posts whose pressure was too large to count */
	uint64_t sunk;      /* contacts in which the soil did not carry the load */
};
void world_forces_figures(const struct forces *forces, struct world_forces_figures *figures); /* `forces` must not be NULL */
/* Waits for all forces that were asked for, and uses them, also in the record. */
enum status world_settle_forces(struct world *world) FURROW_CHECKED;

/*
 * --- bodies of a host: bodies without a path, in a scene that was read for a host ---
 *
 * Numbers 0 .. object_count - 1 are the scene's objects in its order. Bodies that are added get the numbers after them. A
 * number is never used again. STATUS_USAGE: there is no such body, or it follows a path.
 */

/* Adds a body and gives its number. Takes over `object`, which scene_object_parse made, unless it fails. STATUS_INPUT: the name
 * is taken, or the shape is too large for the spacing or the slots. */
enum status world_body_add(struct world *world, struct scene_object *object, int32_t *number) FURROW_CHECKED;
/* Finds a body by name. STATUS_INPUT: no body has that name; then *number is -1. */
enum status world_body_find(const struct world *world, const char *name, int32_t *number) FURROW_CHECKED;
/* Removes a body. The soil under it is unloaded. */
enum status world_body_remove(struct world *world, int32_t number) FURROW_CHECKED;
/* Puts a body at a pose, at rest. It touches nothing between the old pose and the new one. */
enum status world_body_place(struct world *world, int32_t number, const struct world_pose *pose) FURROW_CHECKED;
/* Sets where bodies will be after the next step. Names each body at most once. On failure it sets none. */
enum status world_bodies_set(struct world *world, size_t count, const int32_t *numbers, const struct world_state *states)
	FURROW_CHECKED;
/* Tells the state of any body, also of one with a path. NaN: it was never placed. */
enum status world_body_state(const struct world *world, int32_t number, struct world_state *state) FURROW_CHECKED;
/* Returns a contact of which nothing is known: all numbers are NaN. Pure. */
struct world_contact world_contact_unknown(void);
/* Tells what the soil does to any body. Waits for forces that are being computed. */
enum status world_body_contact(struct world *world, int32_t number, struct world_contact *contact) FURROW_CHECKED;
/* Computes the axes of a body, forward, left and up, in local axes. `q`: a quaternion of length 1; w, x, y, z. Pure. */
void world_axes(const double q[4], double axes[3][3]);
/* Commits everything so far. world_rollback goes back to this state. */
enum status world_checkpoint(struct world *world) FURROW_CHECKED;
/* Sets ground, bodies, forces, time and rows back to the last checkpoint. STATUS_FAILED: there was none. */
enum status world_rollback(struct world *world) FURROW_CHECKED;
/* Tells the rectangles of the working level that changed after the revision `since`, and the revision now. `since` 0: also
 * everything that the store already held. *count: room on entry, number on return. STATUS_USAGE: the room is too small (*count
 * and *now are still set), or `since` is later than now. */
enum status world_changes_since(struct world *world, uint64_t since, struct post_rect *rects, size_t *count, uint64_t *now)
	FURROW_CHECKED;
/* Changes the ground up to where the host's bodies are now. Does nothing if it has been changed that far. */
enum status world_hosts_commit(struct world *world) FURROW_CHECKED;

/* --- bodies that a window drops ---
 *
 * Each is set down once and taken away. Its lowest point goes `sink` below the surface; with a load the soil decides how deep. */
enum world_drop_shape {
	WORLD_DROP_FIRST, /* the shape, and the sink or load, of the scene's first object */
	WORLD_DROP_BALL,
	WORLD_DROP_SHAPES
};
/* Drops a body at (x, y), local metres. `*landed` false: there is no ground, or the scene has no object, and nothing changed. */
enum status world_drop(struct world *world, enum world_drop_shape shape, double x, double y, double yaw, bool *landed)
	FURROW_CHECKED;
/* Tells where a body is on its path now. `place`: local metres, on the base; `yaw`: radians from east to north. */
void world_place(const struct world *world, size_t body, double place[3], double *yaw);

/*
 * --- queries ---
 *
 * Call them between two steps. They tell the newest ground, with the changes of the last step. A query changes nothing that
 * results depend on. terrain/terrain.h defines heights and rays. One call for many points is cheaper than many calls.
 */
enum status world_heights(struct world *world, const struct terrain_point *points, size_t count, struct terrain_height *heights)
	FURROW_CHECKED;
enum status world_rays(struct world *world, const struct terrain_ray *rays, size_t count, struct terrain_hit *hits) FURROW_CHECKED;
/* As resident_read_posts. */
enum status world_read_posts(struct world *world, enum store_layer layer, int level, struct post_rect rect, double *values)
	FURROW_CHECKED;

/* Tells which of the scene's soils is at the post of the working level nearest to (x, y), local metres. -1: outside the
 * terrain. */
enum status world_soil_at(struct world *world, double x, double y, int *soil) FURROW_CHECKED;

/* --- facts that follow from scene and store, before anything is made: plan.c --- */

/* Returns the planes that are read and committed. With bodies: the planes of the scene's model, and disturbance if the scene
 * has it. Without bodies: the planes that are drawn, if the store `was_deformed`. */
unsigned world_planes(const struct scene *scene, bool was_deformed);
bool world_needs_soil_map(const struct scene *scene); /* there is a map of soils and something uses it */
/* Opens the store for reading and makes the bodies. `store` NULL: assumes some ground, and fills `assumed`. Only for plans. End
 * it with world_finish. */
enum status world_prepare_plan(struct world *world, const struct scene *scene, const char *store, struct store_meta *assumed)
	FURROW_CHECKED;
/* Tells which settings of the scene have no effect over this store. */
void world_advise(const struct world *world, scene_advice_fn tell, void *user);
/* These add lines to a plan: of the passes and resources of contacts; then of pages and of the look-ahead. */
enum status world_plan_deform(const struct world *world, struct plan *plan) FURROW_CHECKED;
void world_plan_pages(const struct world *world, struct plan *plan);
uint64_t world_samples_until(const struct track *track, double end); /* path samples that are due until `end`, s */

/* --- the resources that a world needs at least, and uses at most: budget.c --- */

/* STATUS_INPUT, with the number needed: one window touches more tiles than there are slots, or more ground relaxes than can at
 * once. */
enum status world_budget_check(struct world *world) FURROW_CHECKED;
void world_budget(const struct world *world, struct resident_pages_budget *budget); /* bytes, of everything that holds tiles */

#endif
