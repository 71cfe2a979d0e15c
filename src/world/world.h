/*
 * world: a terrain that is open for simulation. It owns the bodies and makes the steps. A step collects the events that are
 * due, deforms the ground, relaxes soil, computes forces, and commits. The world also keeps the record with which a drive can
 * be resumed.
 *
 * The world does not know which program steps it. That program is the command, the window, or a host (a program that calls the
 * library). It calls the functions below in this order. It reads what a step did after the step: rows, and for pictures
 * what happened to the ground (events.h).
 *
 *     world_open -> world_start -> (a view is made) -> world_warm -> world_begin -> world_step ... -> world_end -> world_finish
 *
 * Only one thread uses a world, the one that owns its GL context. Its parts:
 * - body.h: bodies and their contacts;
 * - events.h: what happens in a step;
 * - facts.h: what is known before a step, and what was counted;
 * - ranks.h: several processes.
 */
#ifndef FURROW_WORLD_H
#define FURROW_WORLD_H

#include <signal.h>
#include <stdint.h>
#include <stdio.h>

#include "base/base.h"
#include "bearing/bearing.h"
#include "deform/deform.h"
#include "gpu/gpu.h"
#include "motion/motion.h"
#include "page/page.h"
#include "resident/resident.h"
#include "scene/scene.h"
#include "store/store.h"
#include "world/body.h"
#include "world/events.h"
#include "world/facts.h"
#include "world/moved.h"
#include "world/ranks.h"

struct world;

/* A part of the record that is committed next. It is as the last whole step left it, or as the resumed run had it. */
struct world_recorded {
	int64_t step;             /* steps done since the scene's start */
	double time;              /* s */
	struct pages_sums sums;   /* read from the store; 0 if not resumed */
	size_t active;            /* active blocks, where soil may still relax */
};

struct world_params {
	const struct soil_shape *const *carriers; /* of bodies that a vehicle will add and that carry soil, in their order; must stay valid as long as the world */
	size_t carrier_count;
	size_t attached;           /* numbers that another part of the run adds to each record, such as the state of vehicles: world_attach */
	const struct scene *scene; /* must stay valid longer than the world */
	/* path; overrides the store that the scene names; NULL: the scene must name one. Like overlay, it is read while the world opens */
	const char *store;
	/* path of the overlay to which deformation is written in place of the store; made if it does not exist; may be NULL */
	const char *overlay;
	const struct store_staged *staged; /* the base is read from its copy. Read while the world opens. NULL: from where it is */
	bool resume;               /* continue the store's last drive of this scene; if there was none, start from the beginning */
	bool durable_full;
	bool keep_history;         /* each commit keeps what it replaces */
	bool readonly;             /* nothing is ever written: store and overlay are only read, and there are no steps */
	bool advise;               /* world_advise will be called, of a host's world too */
	bool alone;                /* compute every contact alone; for tests that compare */
	int threads;               /* that compute soil that bears, however little there is; for tests that compare. 0: as many as are worth it */
	bool everywhere;           /* compute also contacts that change nothing; for tests that compare */
	bool draws;                /* pictures are drawn, so coarser levels are kept */
	bool drops;                /* a window may drop bodies */
	bool rows;                 /* rows are used: those that the scene's output.forces asks for */
	int64_t steps;             /* the last step, counted from the scene's start; 0: until the scene's end_time */
	const volatile sig_atomic_t *stop; /* becomes non-zero to end waits early; may be NULL */
	const struct world_ranks *ranks;   /* NULL: this process alone steps the world */
};

/* --- life of a world --- */

/* The phases of a world, in their order. phase.c has the table of arrows between them, each with the function that takes it. */
enum world_phase {
	WORLD_OPENED,   /* store and bodies are known */
	WORLD_STARTED,  /* GL, slots and threads are there */
	WORLD_WARM,     /* what the first step needs is loaded */
	WORLD_READY,    /* steps may be made; no byte of a file has changed yet */
	WORLD_STEPPING, /* the run's start is committed */
	WORLD_TORN,     /* in a step, or after one that failed half-way: the ground must not be committed */
	WORLD_ENDED,    /* the threads have stopped, and figures are final */
	WORLD_PHASES
};
enum world_phase world_phase(const struct world *world);
const char *world_phase_name(enum world_phase phase);
bool world_is_torn(const struct world *world); /* the phase is WORLD_TORN */
/* For who makes a step of several parts, such as ranks and vehicles. world_tear: from now on the ground is not that of a whole step. world_mend: it is
 * again. Both do nothing where that is so already, and while no step can be made. */
void world_tear(struct world *world);
void world_mend(struct world *world);

/* Opens the store, makes the bodies, and reads the record if a run is resumed. Changes no file. Gives a world after a failure, too: half of one, to be
 * freed by world_finish. NULL: there is no memory for it. */
enum status world_open(const struct world_params *params, struct world **world) FURROW_CHECKED;
/* Starts the look-ahead's thread. Makes the GL context, the slots, and everything that bodies need. */
enum status world_start(struct world *world) FURROW_CHECKED;
/* Makes the page cache and its threads. `commit_log`: a file that gets a line for each commit. `trace`: notes each access. Both
 * may be NULL. The world owns them from now on. */
enum status world_start_pages(struct world *world, FILE *commit_log, struct page_trace *trace) FURROW_CHECKED;
/* Allows drawing a host's world from now on, if it was not drawn before. */
enum status world_start_drawing(struct world *world) FURROW_CHECKED;
/* Links every program, runs each once, and loads what the first step needs. */
enum status world_warm(struct world *world) FURROW_CHECKED;
/* From now on passes count as those of steps. Linking another program counts as an error. */
void world_seal(struct world *world);
/* Begins this run. If it is resumed, continues where it stopped. A run of a command commits its start now. A host's may only want to look: its
 * start is committed with the first step. */
enum status world_begin(struct world *world) FURROW_CHECKED;
/* Commits the start of this run, unless that was done. Each step calls it before it changes anything. STATUS_USAGE: the world is readonly. */
enum status world_begin_run(struct world *world) FURROW_CHECKED;
/* Makes one time step. STATUS_FAILED, and nothing has changed: a path leaves the terrain, and the scene's `outside` is stop. */
enum status world_step(struct world *world) FURROW_CHECKED;
/* Makes one step that ends at time `until`, in s, later than now. */
enum status world_step_to(struct world *world, double until) FURROW_CHECKED;
/* Commits everything. `ended` is written to the record. If a step failed half-way, or none was made, nothing is committed. */
enum status world_end(struct world *world, bool ended) FURROW_CHECKED;
/* Stops the threads, so that figures are final. The world need not have been started. */
void world_stop(struct world *world);
/* Before a query: a readonly world drops what it has read, if another process has committed since. STATUS_INPUT: it must be opened again. */
enum status world_follow(struct world *world) FURROW_CHECKED;
/* After a query: *moved: another process has committed meanwhile, so ask once more. */
enum status world_has_moved(struct world *world, bool *moved) FURROW_CHECKED;
/* For a child of the world's process: lets go of the locks that it has inherited. So they end with those of the world's process. The world must
 * not be used in the child. */
void world_forked(const struct world *world);
/* Frees everything. `status`: how the drive ended. After a failure, an overlay without a commit is removed. The world may be
 * half made, or NULL. */
void world_finish(struct world *world, enum status status);

/* Makes the way that a path of the scene says, in local metres. `name`: of the object or vehicle, for messages. The caller frees it by
 * motion_route_finish. STATUS_INPUT: the store has no reference system, or there is no such way. */
enum status world_route(const struct world *world, const struct scene_path *path, const char *name, struct scene_path *route) FURROW_CHECKED;
/* Fails with STATUS_FAILED. The message tells that `name` has no ground at (x, y), local metres, after `time` seconds: off the terrain, or over a hole. It
 * also gives the point in degrees if `degrees`, otherwise in the scene's coordinates. */
enum status world_no_ground(const struct world *world, const char *name, bool degrees, double x, double y, double time) FURROW_CHECKED;
/* Gives where a vehicle starts, in local metres. STATUS_INPUT: the store has no reference system, or the point is nowhere in it. */
enum status world_start_point(const struct world *world, const struct scene_vehicle *vehicle, double to[2]) FURROW_CHECKED;

/* --- steps --- */

int64_t world_step_count(const struct world *world); /* number of the last step */
double world_steps_until(const struct scene *scene, double time); /* number of whole steps until `time`, s */
double world_step_time(const struct scene *scene, int64_t step);  /* s at which this step ends; at most end_time, unless a host steps */
bool world_stopped(const struct world *world); /* true after Ctrl-C */
enum status world_interrupted(const struct world *world) FURROW_CHECKED;
/* The most path samples of one object in a step. */
#define WORLD_SAMPLES_MOST 1000000
/* For a world with attached numbers: sets them, `params.attached` finite ones, for the next record. Call it before world_begin, and between each step
 * and world_end_step. */
void world_attach(struct world *world, const double *numbers);
/* Ends a step of a world with attached numbers, which world_step, world_step_to and world_move_hosts leave open. From now on it may be committed.
 * In other worlds these end it, and there is nothing to call. */
enum status world_end_step(struct world *world) FURROW_CHECKED;
/* Returns the attached numbers of the run that is resumed. NULL: there are none. Call it before world_begin. */
const double *world_attached(const struct world *world);
/* Returns the attached numbers as the last step left them; after world_rollback as the checkpoint did. */
const double *world_attached_last(const struct world *world);
void world_recorded(const struct world *world, struct world_recorded *recorded);
/* Between two steps, for who waits: loads go on, slots become free, and a commit that is due begins. */
enum status world_idle(struct world *world) FURROW_CHECKED;
FILE *world_commit_log(const struct world *world);       /* the file that gets a line for each commit; NULL: none */
uint64_t world_revision(const struct world *world);      /* present revision of the ground: world_changes_since */

/* Returns the store's time, `time` s after the scene's start, and what marks that fade take. Pure. */
struct plane_marks world_marks_at(const struct world *world, double time);
/* The ground in memory. Who reads it must not change its parts. */
const struct resident *world_resident(const struct world *world);
/* Returns what the GPU, or the CPU, computes the ground with. NULL: nothing. At most one of both is there. */
const struct deform *world_deform(const struct world *world);
const struct bearing *world_bearing(const struct world *world);
struct look_ahead *world_look_ahead(const struct world *world);
/* Sets who is called around commits, and what pictures show of vehicles. Call them before world_warm. Both stay the caller's, and must stay valid longer
 * than the world. */
void world_set_commits(struct world *world, const struct world_commits *commits);
void world_set_figures(struct world *world, const struct world_figures *figures);
const struct world_figures *world_figures(const struct world *world);

/* Commits everything so far. world_rollback can restore this state. On failure it restores that of the earlier checkpoint. */
enum status world_checkpoint(struct world *world) FURROW_CHECKED;
/* Restores ground, bodies, forces, time and rows to the last checkpoint. STATUS_FAILED: there is none. */
enum status world_rollback(struct world *world) FURROW_CHECKED;
/* Gives the rectangles of the working level that changed after the revision `since`, and the present revision. With `since` 0
 * it includes everything that the store had before. *count: room on entry, number on return. STATUS_USAGE: the room is too
 * small (*count and *now are still set), or `since` is later than now. */
enum status world_changes_since(struct world *world, uint64_t since, struct post_rect *rects, size_t *count, uint64_t *now)
	FURROW_CHECKED;

/*
 * --- queries ---
 *
 * Call them between two steps. They give the newest ground, with the changes of the last step. They never change results. For
 * heights and rays see resident/heights.h. One call for many points is faster than many calls.
 */
enum status world_heights(struct world *world, const struct resident_point *points, size_t count, struct resident_height *heights)
	FURROW_CHECKED;
enum status world_rays(struct world *world, const struct resident_ray *rays, size_t count, struct resident_hit *hits) FURROW_CHECKED;
/* As resident_read_posts. */
enum status world_read_posts(struct world *world, enum store_layer layer, int level, struct post_rect rect, double *values)
	FURROW_CHECKED;

/* Gives the index of the soil at the post of the working level nearest to (x, y), in local metres. -1: outside the terrain. */
enum status world_soil_at(struct world *world, double x, double y, int *soil) FURROW_CHECKED;
/* The same when the world has stopped. -1: also if the map cannot be read there. */
int world_soil_index(const struct world *world, double x, double y);

#endif
