/*
 * world: a terrain that is open for simulation. It owns the bodies and makes the steps. A step collects the events that are
 * due, deforms the ground, relaxes soil, computes forces, and commits. The world also keeps the record with which a drive can
 * be resumed.
 *
 * The world does not know which program steps it. That program is the command, the window, or a host (a program that calls the
 * library). It calls the functions below in this order. To draw the world, it watches it through struct world_watcher.
 *
 *     world_prepare -> world_start -> (a view is made) -> world_warm -> world_begin -> world_step ... -> world_end -> world_finish
 *
 * Only one thread uses a world, the one that owns its GL context. Each part of struct world belongs to the file named beside
 * it. Other files only read it.
 */
#ifndef FURROW_WORLD_H
#define FURROW_WORLD_H

#include <signal.h>
#include <stdint.h>
#include <stdio.h>

#include "base/base.h"
#include "base/key_map.h"
#include "base/key_set.h"
#include "bearing/bearing.h"
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

/* The force of the soil on a body, when it was last computed. world_no_force: no force. */
struct world_force {
	double force[3], moment[3]; /* N, N m */
	double sinkage, area;       /* m below the base; m2 */
	double residual, pull;      /* N: struct deform_forces */
	double work;                /* J: what a quiet body has done on the soil since the start; of other bodies 0 */
	int64_t z;                  /* 2^-20 m */
	enum deform_state state;
};

/* A part of the record that is committed next. It is as the last whole step left it, or as the resumed run had it. */
struct world_recorded {
	int64_t step;             /* steps done since the scene's start */
	double time;              /* s */
	struct pages_sums sums;   /* read from the store; 0 if not resumed */
	size_t active;            /* active blocks, where soil may still relax */
};

/* One path sample that is due in a step, or one pose that a host gave. The body is already placed on the ground. */
struct event {
	size_t body;      /* index into world.bodies */
	double time;      /* s since the scene's start */
	bool contact;     /* false: outside the terrain or over nodata; the sample is skipped */
	double distance;  /* m along the ground since the last sample */
	double sinkage;   /* m below the base */
	double seconds;   /* s since the last sample */
	double next_time; /* s: when the next sample is due; INFINITY: there is no next sample */
	double turned;    /* rad that a wheel has turned, m that a belt has run, since the last sample; only for a host's bodies */
	double stamped;   /* as in struct deform_contact; only for a host's bodies */
	double rotated[3]; /* rad about local axes that another body of a host has turned since the last sample */
	struct soil_pose pose;
};

/* The area in which a body is about to change the ground. */
struct contact_area {
	int64_t lowest;         /* 2^-20 m: no part of the body is below this height. INT64_MIN: not known */
	/* changed: posts of the working level that may change. read: posts whose values they may take. */
	struct post_rect changed, read;
};

/*
 * A watcher of a world, which draws it. All calls come from the world's thread. Any function may be NULL. If a function does
 * not return STATUS_OK, the step fails with that status.
 */
struct world_watcher {
	void *user;
	/* The next calls of `changed` belong to this contact. Both arguments NULL: they belong to relaxation. */
	enum status (*contact)(void *user, const struct event *event, const struct contact_area *area);
	/* Posts of this tile of the working level have changed. */
	enum status (*changed)(void *user, struct tile tile);
	/* Adds prefetch requests: the tiles that the watcher will need, and when. */
	enum status (*requests)(void *user, struct requests *requests);
	/* From now on the ground may differ from its base by up to this many metres. */
	void (*reach)(void *user, double metres);
};

/* Functions that are called around a commit. Both may be NULL. */
struct world_commits {
	void *user;
	void (*before_record)(void *user);         /* on the world's thread, before a commit takes the record */
	enum status (*before_commit)(void *user);  /* on the writer thread, before it commits */
};

/* A row of objects.csv: the force of the soil on a body at one time. */
struct world_row {
	double time;         /* s */
	size_t body;
	const struct scene_object *object; /* of the body */
	double slip;         /* of a wheel or a belt */
	double position[3];  /* m, of the body's origin */
	/* index of the soil at the post nearest to the origin, in the scene's soils; -1: outside the terrain */
	int soil;
	struct world_force force;
};
/* Receives the rows in their order. `flush` is called after some rows. */
struct world_rows {
	void *user;
	enum status (*row)(void *user, const struct world_row *row);
	enum status (*flush)(void *user);
	/* mark: tells where the rows so far end, when all are written. rollback: drops the rows after such an end. NULL: there are no
	 * checkpoints. */
	enum status (*mark)(void *user, int64_t *end);
	enum status (*rollback)(void *user, int64_t end);
};

/* Numbers that another part of the run adds to each record, such as the state of vehicles. */
struct world_attached {
	size_t count;
	void *user;
	void (*save)(void *user, double *numbers); /* on the world's thread; `count` finite numbers */
};

/* What pictures show beside the scene's objects: the parts of vehicles. */
struct world_figures {
	const struct scene_object *list; /* their shapes and names; must stay valid longer than the world */
	size_t count;
	void *user;
	/* Gives the middle of a figure, m, and its axes forward, left, up. Returns false: it is not there yet. */
	bool (*place)(void *user, size_t figure, double middle[3], double axes[3][3]);
	/* Gives the place of a vehicle, m, and its axes forward, left, up. `body`: those of this body of its model; NULL: of its root body.
	 * Returns false: it is not there yet. */
	bool (*vehicle)(void *user, size_t vehicle, const char *body, double place[3], double axes[3][3]);
};

struct world_params {
	struct world_attached attached; /* count 0: none */
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

/* One body. Its shape, sink, load and slip are in the scene object. */
struct body {
	const struct scene_object *object;
	struct track *track;
	int64_t next;             /* number of its next path sample */
	bool in_contact;          /* `last` is a pose in contact, so the next contact is swept from it */
	struct soil_pose last;
	double distance, sinkage; /* m */
	int64_t equilibrium;           /* 2^-20 m, for a body with a load: its equilibrium height, at which the soil carries it */
	int64_t raised;           /* 2^-20 m: height of `equilibrium` above the height where the search for it began */
	uint32_t loaded_body;         /* for a body with a load: its number among the loaded bodies, from 1 */
	int64_t skipped;          /* number of path samples without ground */
	int64_t near;             /* path samples of this run in which it was near the ground. With a load: steps at whose end the soil bore it */
	uint64_t met_turn;        /* meet.c: when its contacts waited last, and how many */
	size_t met;
	uint64_t windows, windows_moved; /* windows computed; of these, the windows in which the body moved */
	_Atomic bool elsewhere;   /* another rank computes its contacts. Threads that load ahead read it */
	/* Of a body with a load, since this run began: the soil did not carry it, or did not hold it on its slope */
	struct body_failed {
		int64_t steps;      /* at whose end it was so */
		double time, x, y;  /* the first time, s, and the place then, local metres */
	} sunk, slid;
};

/* Where a host's body is, and how it moves. Local axes: x east, y north, z up. */
struct world_pose {
	double position[3];    /* m */
	double orientation[4]; /* unit quaternion w, x, y, z, from the body's axes (x forward, y left, z up) to local axes */
};
struct world_state {
	struct world_pose pose;
	double linear[3];  /* m/s, velocity of the origin. Of a state that a host gives: all NaN: that of the poses (rates.c) */
	double angular[3]; /* rad/s. All NaN: likewise */
	struct world_belt {
		double travel, speed; /* m: how far its belt has run, counted from anywhere, and m/s. 0: it has none */
	} belt;                       /* world_bodies_set takes it of quiet bodies alone. Of others world_belts_set tells it */
};

enum world_contact_state { WORLD_AIR, WORLD_TOUCHING, WORLD_SLIDES, WORLD_SUNK, WORLD_UNKNOWN };

/* The contact of a body with the soil. NaN: not known. */
struct world_contact {
	double time;                  /* s: time at which the ground and the body were as described here; on a path that of the latest path sample */
	double force[3], moment[3];   /* on the body, in local axes: N, and N m about the origin */
	double point[3];              /* m: on the line of the force, the point nearest to the body's lowest point */
	double normal[3];             /* unit normal of the undisturbed surface under the body */
	double sinkage, area, slip;   /* m below the undisturbed surface; m2; slip of a wheel or a belt */
	double stiffness[6][6], damping[6][6]; /* d(force, moment) / d(translation, rotation about local axes), and of their rates */
	double normal_force, shear_limit; /* N */
	double pull;                  /* N: of its belt, as in struct deform_forces */
	enum world_contact_state state;
};

/* One body of a host: hosts.c. */
struct host_body {
	struct body body;             /* its member `last` is the pose up to which the motion has changed the ground */
	struct scene_object *owned;   /* NULL: the scene owns the object */
	bool placed, removed;
	bool fresh;                   /* placed since the last step, so there is no motion from an earlier pose */
	bool has_next;
	struct world_state now, next; /* now: after the last step. next: after the next step, if has_next */
	bool posed_linear, posed_angular; /* rates.c: the velocities in `now` are those of the poses */
	bool unposed;                 /* rates.c: the host leaves the turns of a round body out of its poses */
	bool rates_told;              /* a note told what is wrong with its velocities */
	int rates_far;                /* for so many steps on end, velocities and poses differed by far */
	double since;                 /* s: time of its motion since `last` */
	struct world_belt belt;       /* as world_belts_set told it; of a quiet body now.belt counts */
	bool belt_told;               /* it was called for this body */
	double turned;                /* rad about a wheel's axle, m that its belt ran, since `last` */
	double rotated[3];            /* other shapes: rad about local axes since `last` */
	double stamped;               /* 1: the hollow below `last` is an impression of the body; 0: it is a flat rut */
	struct soil_pose felt;      /* the pose for which forces were last computed, */
	double felt_turned;           /* the value of `turned` then, */
	bool felt_moving;             /* and true if it moved then */
	double told;                  /* s: time of `force` and `state` */
	struct world_force force;
	enum world_contact_state state;
	uint64_t turn;                /* number of the last call of world_bodies_set that named this body */
	bool quiet;                   /* world_body_quiet; then `since` is the time of the last contact, */
	double slip;                  /* and these two are what its caller told for rows */
	struct soil_pose shown;
};

/* A changed tile of the working level: changes.c. */
struct changed_tile {
	struct tile tile;
	uint64_t last;         /* revision of the last change */
	uint64_t from;         /* `rect` contains all changes after this revision; 0: it is the whole tile */
	struct post_rect rect;
};

/* Waits of the step's thread: for a page, for a commit, or for the ground on which a body is placed. */
struct stalls {
	uint64_t count;
	double ms;
};

/* What ranks did together. */
struct world_ranked {
	struct pages_sums sums; /* of the whole drive */
	int64_t tiles_moved, bodies_moved, blocks_moved, bytes_moved, exchanges;
	double waiting; /* s that ranks waited for others, all together */
	/* Processor time of all ranks in steps without waiting, s; of that, for who computes what, and for what moves. */
	double busy, planning, moving;
	double balance; /* work of the busiest rank by the mean of all, in the mean over steps */
};

/*
 * The other processes (ranks) that step this world, too: fleet. Each rank has its own ground, and computes the contacts of its own bodies.
 * All functions are called on the world's thread, on every rank in the same order. They may wait for the other ranks.
 */
struct world_ranks {
	void *user;
	int rank, ranks;         /* number of this one, from 0; how many there are */
	const char *over, *part; /* overlay of the run, and the one over it that this rank writes */
	/* Before the contacts of a step that ends at `until`. Afterwards this rank has the newest ground of all that its bodies touch in
	 * this step, and where soil slides near them. `status`: of this rank so far. A failure of any rank is returned on all. */
	enum status (*step)(void *user, double until, enum status status);
	/* Fills the contacts of bodies that are elsewhere. `status`: of this rank's own probes. */
	enum status (*probed)(void *user, size_t count, const int32_t *numbers, struct world_contact *contacts, enum status status);
	/* This rank changes the tile in this step. */
	enum status (*changes)(void *user, uint64_t key);
	/* Returns true if this rank may read the tile in this step. */
	bool (*has)(void *user, uint64_t key);
	/* Before the run's last commit. `status`: how this rank ended. */
	enum status (*end)(void *user, enum status status);
	/* When this rank has closed its ground: puts what all ranks have committed into `over`. Fills `figures`. */
	enum status (*gather)(void *user, struct world_ranked *figures);
	/* Returns the failure of any rank on all. What ranks have in common is compared at the first call. */
	enum status (*agree)(void *user, struct world *world, enum status status);
};

struct world {
	struct world_params params;
	const struct scene *scene;
	struct scene_light light; /* the scene's; on the store's body, if the scene names none */
	const char *path; /* the store's: path of the file that is written, the store or the overlay */
	const struct world_watcher *watcher; /* NULL: nothing watches the world */
	const struct world_rows *rows;       /* NULL: rows are not used */
	const struct world_commits *commits; /* NULL: no functions */
	const struct world_ranks *ranks;     /* NULL: this process alone steps the world */
	bool unplaced;    /* ranks: a body was placed since the last call of ranks->step */
	struct world_figures figures; /* count 0: none. Set it before a view is made */
	int64_t step;     /* steps done since the scene's start */
	double time;      /* s of simulated time since the scene's start */
	double stop_seen; /* s of the clock: when a step first saw that the drive is to end; 0: not yet */
	bool torn;        /* true inside a step: the ground must not be committed now */
	bool begun;       /* this run has changed the store, or is about to (world_begin_run). Until then no byte of a file has changed */
	struct world_resumed {
		bool is;
		int64_t from;  /* step */
		double time;   /* s */
		bool nothing_left;
	} resumed;
	struct record *record; /* as the last whole step left it, or as it was resumed */

	/* The ground in memory. */
	struct store *store;
	const struct store_meta *meta;
	int level;         /* the working level */
	double spacing;    /* m, of the working level */
	struct store_reader *follower; /* follow.c; NULL: nothing is followed yet */
	bool was_deformed; /* the store was deformed before this world was opened */
	double slip_sinkage; /* the scene's; 0 where no body slips and no earlier drive may have dug */
	struct world_began {
		double low, high; /* m: the deepest rut, at most 0, and the highest heap that earlier runs left. Of a run that is resumed both are 0 */
	} began;
	struct gpu *gpu;
	struct gpu_slots *slots;
	struct ground *ground;
	struct world_limits {      /* limits.c: most tiles in memory */
		uint32_t slots;    /* of the GPU */
		uint32_t images;   /* of changed pages, as in pages_params */
		uint32_t ground;   /* base heights that `ground` keeps */
		uint32_t queries;  /* that `newest` keeps; 0: nobody asks */
		bool all;          /* every tile that the drive may come to has a slot, so nothing is read ahead */
		uint32_t loaders;  /* threads that load tiles: the scene's, or 0 with `all` */
		double prefetch;   /* s of travel that is looked ahead: the scene's, or 0 with `all` */
		struct mem_usable usable; /* by this process: bounds the queue of changed pages */
		double hosts_need, hosts_work; /* tiles of base heights, and pages, under bodies that a host added */
	} limits;
	struct soil_map *soil_map; /* NULL: one soil */
	struct world_relief *relief;       /* what relief by class reads; NULL: it has none */
	struct soil_rasters *soil_rasters; /* NULL: every number is that of a post's soil */
	struct world_soils_met *met;       /* NULL: not known, or nobody asks */
	struct pages *pages;
	struct page_cache *cache;
	struct page_trace *trace; /* NULL: no trace was asked for */
	struct pyramid *pyramid;  /* NULL: coarser levels are not used */
	struct newest *newest;    /* NULL until the first query */
	FILE *commit_log;         /* a line for each commit; NULL: none */

	bool without_gl;          /* no GL context could be made, so the CPU computes what the GPU would */
	struct deform *deform;    /* what the GPU computes; NULL: there is no body, or the CPU computes */
	struct bearing *bearing;  /* what the CPU computes; NULL: nothing */
	struct deform_params surface; /* of deform or bearing */
	struct host_slots *host;  /* where the CPU computes: the home of pages */
	struct forces *forces;    /* forces.c; NULL: forces are not needed */
	struct look_ahead *ahead; /* motion: loads tiles before they are needed */
	struct body *bodies;      /* bodies.c: the scene's objects in its order, and one more for drops of a window */

	struct world_events {     /* events.c: events of the current step */
		struct event *list;
		size_t count, room;
		/* events of later steps that world_check_events() has placed. runs: by body; NULL: none */
		struct event *ahead;
		size_t ahead_count, ahead_room;
		struct event_run *runs;
	} events;
	struct near_table {       /* near.c */
		struct near_entry {
			size_t body;
			struct deform_rest rest; /* where it is; of a body on a path, when it was looked at last */
			struct post_rect rect;   /* it is over these posts until the table is made anew; empty: nowhere */
			bool everywhere;         /* over too many cells */
			uint64_t turn;           /* of the search that looked at it last */
		} *entries, *found;      /* in the order of bodies; found: by the last search */
		struct near_kept {
			size_t at;
			struct near_entry entry;
		} *kept;                 /* those that a probe moved, as they were */
		struct deform_rest *rests;
		size_t count, room, found_count, moved, everywhere;
		struct near_cell *cells; /* sorted */
		size_t cell_count, cell_room;
		int64_t side;            /* posts */
		uint64_t turn;
		bool stale;              /* bodies may have moved */
	} near;
	struct world_relaxation { /* relaxation.c */
		struct deform_rest *rests; /* room for all bodies */
		int64_t intervals;         /* relaxation intervals that were run or skipped since the scene's start */
		/* blocks visited; possible: how many there would be if all blocks of each touched tile were visited */
		uint64_t visited, possible;
	} relaxation;
	struct world_aloft {      /* aloft.c */
		struct key_set seen, old; /* seen: tiles that were looked at; old: those that have planes from before this world */
		bool asks_touched;
	} aloft;
	struct world_windows {    /* contact.c */
		/* windows of contacts that were computed; due: how many there would be if every contact on the ground were
		 * computed */
		uint64_t computed, due;
		size_t tiles;           /* most tiles that one window may touch, by the budget */
		uint64_t tiles_most;    /* most tiles that one window has touched */
		bool told;
	} windows;
	struct crew *crew;        /* crew.c; NULL: one thread computes soil that bears */
	size_t hands;             /* of world->bearing, with a crew */
	struct meetings *meetings; /* meet.c; NULL: no soil bears */
	struct batches *batches;  /* batch.c; NULL: every contact is computed alone */
	uint64_t drops;           /* drop.c: number of bodies that a window dropped */
	struct world_hosts {      /* hosts.c: by number. NULL for a body with a path, and for a body that a rollback removed */
		struct host_body **list;
		size_t count, room;
		struct world_names {  /* names.c */
			struct key_set keys; /* hashes of names */
			int32_t *numbers;    /* by a key's number: the body that had the name last */
			size_t room, known;  /* known: bodies with lower numbers are in the table */
			unsigned taken;      /* names body-1 .. body-TAKEN are taken */
		} names;
		uint64_t turn;        /* number of calls of world_bodies_set so far */
		double until;         /* s: the end of the current step */
	} hosts;
	struct checkpoint *checkpoint; /* checkpoint.c; NULL: none yet */
	struct world_changes {    /* changes.c: for a host's world */
		struct key_map places;  /* a tile's index in list */
		struct changed_tile *list;
		size_t count, room;
		uint64_t revision;      /* present revision of the ground */
		uint64_t asked;         /* revision that was last returned to the host */
		bool pending;           /* the ground changed after `revision` */
	} changes;
	struct world_warmed {     /* figures of warming up, which do not count as figures of steps */
		struct gpu_stats gpu;
		struct gpu_slots_figures slots;
		struct stalls stalls, range_waits;
		double load_ms; /* time that world_warm waited for tiles */
	} warmed;
};

/* --- life of a world --- */

/* Opens the store, makes the bodies, and reads the record if a run is resumed. Changes no file. `world` must be all zero. */
enum status world_prepare(struct world *world, const struct world_params *params) FURROW_CHECKED;
/* Starts the look-ahead's thread. Makes the GL context, the slots, and everything that bodies need. */
enum status world_start(struct world *world) FURROW_CHECKED;
/* Makes the page cache and its threads. `commit_log`: a file that gets a line for each commit. `trace`: notes each access. Both
 * may be NULL. The world owns them from now on. */
enum status world_start_pages(struct world *world, FILE *commit_log, struct page_trace *trace) FURROW_CHECKED;
/* Sets the watcher. Call it before world_warm. The caller owns the watcher, which must stay valid longer than the world. */
void world_watch(struct world *world, const struct world_watcher *watcher);
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
 * all zero, or half made. */
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
/* Ends a change of the ground. From now on it may be committed with the present record. */
enum status world_end_step(struct world *world) FURROW_CHECKED;
void world_stalls(const struct world *world, struct stalls *stalls); /* waits since world_begin */
/* Returns the attached numbers of the run that is resumed. NULL: there are none. Call it before world_begin. */
const double *world_attached(const struct world *world);
/* Returns the attached numbers as the last step left them; after world_rollback as the checkpoint did. */
const double *world_attached_last(const struct world *world);
void world_recorded(const struct world *world, struct world_recorded *recorded);
/* waits for ranges of tiles since world_begin; they do not count as stalls */
void world_range_waits(const struct world *world, struct stalls *waits);

/* --- forces --- */

struct world_forces_figures {
	uint64_t saturated; /* posts whose pressure was too large to count */
};
void world_forces_figures(const struct forces *forces, struct world_forces_figures *figures); /* `forces` must not be NULL */

/*
 * --- bodies of a host: bodies without a path, in a scene that was read for a host ---
 *
 * Numbers 0 .. object_count - 1 are the scene's objects in its order. Bodies that are added get the next numbers. A number is
 * never used twice. STATUS_USAGE: there is no body with this number, or it follows a path.
 */

/* Adds a body and gives its number. `object` was made by scene_object_parse; the world owns it from now on, unless the call
 * fails. STATUS_INPUT: the name is used already, or the shape is too large for the spacing or the slots. */
enum status world_body_add(struct world *world, struct scene_object *object, int32_t *number) FURROW_CHECKED;
/* Finds a body by name. STATUS_INPUT: no body has that name; then *number is -1. */
enum status world_body_find(struct world *world, const char *name, int32_t *number) FURROW_CHECKED;
/* Removes a body. Its weight no longer acts on the soil. */
enum status world_body_remove(struct world *world, int32_t number) FURROW_CHECKED;
/* Puts a body at a pose, at rest. It touches nothing on the way from the old pose to the new one. */
enum status world_body_place(struct world *world, int32_t number, const struct world_pose *pose) FURROW_CHECKED;
/* Sets where bodies will be after the next step. The list names each body at most once. On failure no body is set. */
enum status world_bodies_set(struct world *world, size_t count, const int32_t *numbers, const struct world_state *states) FURROW_CHECKED;
/* Sets where the belts of bodies are at the end of the next step, and in probes from now on. The first call for a body says where its
 * belt is now. On failure no belt is set. */
enum status world_belts_set(struct world *world, size_t count, const int32_t *numbers, const struct world_belt *belts)
	FURROW_CHECKED;
/* For a body whose caller computes its forces with world_probe. The world computes none for it, and each state that is set
 * changes the ground in the next step, however small the motion is. */
void world_body_quiet(struct world *world, int32_t number);
#define WORLD_SINKAGE_SHARE 0.1 /* of a post: a body that moved up or down by so much since its last contact changes the ground */
/* How a body sank and went in plan since its last contact, and how it does in the step that follows; m. turned, turns: rad about local x and y. */
struct world_sinking {
	double sank, went, turned[2];
	double sinks, goes, turns[2];
	double reach;                 /* world_turning_reach */
};
/* Returns true if some place of the body has been deeper than a straight motion since its last contact will be. Such a body rises after it sank by
 * `least` metres. Or it sank steeply and goes on along the ground. A contact is taken as straight, so one must end there. Pure. */
bool world_leaves_dip(const struct world_sinking *sinking, double least);
/* Returns how far from its middle the lower side of a body lies that rises and sinks as it turns, m. 0: it does not. */
double world_turning_reach(const struct soil_shape *shape);
/* Tells the force on a quiet body for the next rows of objects.csv. `force->z` is ignored. `slip`: of a wheel. */
enum status world_body_tell(struct world *world, int32_t number, const struct world_state *state, const struct world_force *force,
			    double slip) FURROW_CHECKED;
/* Moves the host's bodies to the states that were set, without a time step. */
enum status world_move_hosts(struct world *world) FURROW_CHECKED;
/* The state of a quiet body as numbers, for a record, and back. STATUS_INPUT: they contradict each other. */
#define WORLD_BODY_NUMBERS 26
void world_body_save(const struct world *world, int32_t number, double numbers[WORLD_BODY_NUMBERS]);
enum status world_body_restore(struct world *world, int32_t number, const double numbers[WORLD_BODY_NUMBERS]) FURROW_CHECKED;
/* Gives the state of any body, also of a body with a path. NaN: it was never placed. */
enum status world_body_state(const struct world *world, int32_t number, struct world_state *state) FURROW_CHECKED;
/*
 * Tells what the soil would do to `count` bodies of the host in these states, as linear functions around them. Changes nothing. It reads the ground
 * on the host, and may load tiles.
 * world_probe_reads: returns true if a probe of these bodies would read the ground.
 * The contact is `unknown` off the terrain and for a body with a path. It is so, too, where a state is hundreds of working posts from the body's last
 * contact. So it is
 * for a soil model that probes do not know. STATUS_USAGE, STATUS_INPUT: a state is not one that the body can have.
 */
bool world_probe_reads(const struct world *world, size_t count, const int32_t *numbers);
enum status world_probe(struct world *world, size_t count, const int32_t *numbers, const struct world_state *states,
			struct world_contact *contacts) FURROW_CHECKED;
/* Returns a contact whose numbers are all NaN (not known). Pure. */
struct world_contact world_contact_unknown(void);
/* Gives the contact of any body with the soil. Waits for forces that are being computed. */
enum status world_body_contact(struct world *world, int32_t number, struct world_contact *contact) FURROW_CHECKED;
/* Computes the axes of a body (forward, left, up) in local axes. `q`: unit quaternion w, x, y, z. Pure. */
void world_axes(const double q[4], double axes[3][3]);
/* Commits everything so far. world_rollback can restore this state. On failure it restores that of the earlier checkpoint. */
enum status world_checkpoint(struct world *world) FURROW_CHECKED;
/* Restores ground, bodies, forces, time and rows to the last checkpoint. STATUS_FAILED: there is none. */
enum status world_rollback(struct world *world) FURROW_CHECKED;
/* Gives the rectangles of the working level that changed after the revision `since`, and the present revision. With `since` 0
 * it includes everything that the store had before. *count: room on entry, number on return. STATUS_USAGE: the room is too
 * small (*count and *now are still set), or `since` is later than now. */
enum status world_changes_since(struct world *world, uint64_t since, struct post_rect *rects, size_t *count, uint64_t *now)
	FURROW_CHECKED;
/* Changes the ground up to the present places of the host's bodies. Does nothing if that was already done. */
enum status world_hosts_commit(struct world *world) FURROW_CHECKED;

/* --- bodies that a window drops ---
 *
 * Each is placed once and then removed. Its lowest point goes `sink` below the surface. With a load, the soil decides how deep
 * it sinks. */
enum world_drop_shape {
	WORLD_DROP_FIRST, /* shape and sink or load of the scene's first object */
	WORLD_DROP_BALL,
	WORLD_DROP_SHAPES
};
/* Drops a body at (x, y), in local metres. `*landed` is false if there is no ground, or the scene has no object. Then nothing
 * changed. */
enum status world_drop(struct world *world, enum world_drop_shape shape, double x, double y, double yaw, bool *landed)
	FURROW_CHECKED;
/* Gives the present place of a body on its path. `place`: local metres, on the base. `yaw`: radians from east to north. */
void world_place(const struct world *world, size_t body, double place[3], double *yaw);
/* Returns the body of an event: one of the scene, one that a window drops, or one of a host. */
const struct body *world_body_of(const struct world *world, const struct event *event);

/*
 * --- queries ---
 *
 * Call them between two steps. They give the newest ground, with the changes of the last step. They never change results. For
 * heights and rays see terrain/terrain.h. One call for many points is faster than many calls.
 */
enum status world_heights(struct world *world, const struct terrain_point *points, size_t count, struct terrain_height *heights)
	FURROW_CHECKED;
enum status world_rays(struct world *world, const struct terrain_ray *rays, size_t count, struct terrain_hit *hits) FURROW_CHECKED;
/* As resident_read_posts. */
enum status world_read_posts(struct world *world, enum store_layer layer, int level, struct post_rect rect, double *values)
	FURROW_CHECKED;

/* Gives the index of the soil at the post of the working level nearest to (x, y), in local metres. -1: outside the terrain. */
enum status world_soil_at(struct world *world, double x, double y, int *soil) FURROW_CHECKED;
/* The same when the world has stopped. -1: also if the map cannot be read there. */
int world_soil_index(const struct world *world, double x, double y);

/*
 * --- ranks.c: for struct world_ranks ---
 *
 * Bodies are counted as events count them: the scene's objects, one that is no body, then bodies of vehicles.
 */
size_t world_ranked_bodies(const struct world *world);
bool world_ranked(const struct world *world, size_t index); /* false: there is no such body, or it is not placed */
/* Gives the posts that a body may touch in the step that ends at `until`, with those where soil may slide because of it. Empty: none.
 * Gives the same on every rank. */
struct post_rect world_body_area(const struct world *world, size_t index, double until);
int64_t world_intervals_due(const struct world *world, double until); /* number of relaxation intervals until then */
/* Gives the posts that so many intervals may read or change because of an active block. */
struct post_rect world_block_area(const struct world *world, struct soil_block block, int64_t intervals);
void world_body_here(struct world *world, size_t index, bool here); /* says if this rank computes its contacts */
void world_pass_elsewhere(struct world *world, double until);       /* counts the path samples of bodies elsewhere */
/* Returns the failure that collecting the events until then would have. Keeps what it placed for the steps until then. */
enum status world_check_events(struct world *world, double until) FURROW_CHECKED;
/* Undoes the collecting of this step's events. The step collects them again. */
void world_forget_events(struct world *world);

/* The state of a body that moves to another rank. Forces must be settled. It has no pointers. */
struct world_moved {
	int64_t index, next, skipped, equilibrium;
	uint64_t windows, windows_moved;
	struct soil_pose last, shown; /* shown: the pose of its rows */
	struct world_force force;
	double distance, sinkage;
	bool in_contact, placed, felt;  /* placed: it has rows; felt: `force` is that of its last contact */
};
/* Returns true if bodies change the ground. */
bool world_changes_ground(const struct world *world);
/* The same as deform_active_blocks, deform_wake_block and deform_tally, whichever way the ground is changed. */
enum status world_active_blocks(const struct world *world, const struct soil_block **blocks, size_t *count) FURROW_CHECKED;
enum status world_wake_block(struct world *world, struct soil_block block) FURROW_CHECKED;
enum status world_tally(const struct world *world, struct deform_tally *tally) FURROW_CHECKED;
void world_body_pack(const struct world *world, size_t index, struct world_moved *moved);
/* `here`: this rank computes its contacts from now on. STATUS_FAILED: there is no such body. */
enum status world_body_unpack(struct world *world, const struct world_moved *moved, bool here) FURROW_CHECKED;
/* Keeps only the active blocks for which `keeps` returns true. Waits for the GPU. */
typedef bool (*world_block_fn)(void *user, struct soil_block block);
enum status world_active_keep(struct world *world, world_block_fn keeps, void *user) FURROW_CHECKED;
/* Takes the planes of a tile from another rank: resident_pages_put. */
enum status world_tile_came(struct world *world, struct tile tile, unsigned planes, const void *bytes) FURROW_CHECKED;
/* Fills the record of the last whole step. `others`: blocks that are active on other ranks. */
enum status world_record_ranks(struct world *world, const struct soil_block *others, size_t count) FURROW_CHECKED;

/* --- facts that follow from scene and store, before anything is made: plan.c --- */

/* Returns the planes that are read and committed. With bodies: the planes of the scene's model, disturbance if the scene asks for it, and what
 * slip dug if a body may slip. Without bodies: the drawn planes if the store was deformed before, otherwise none. */
unsigned world_planes(const struct world *world);
/* Returns the effects that run over this store, as scene_effects does. Where all tiles have a slot, nothing is loaded ahead. Where earlier drives
 * deformed the ground, slip may have dug there. */
uint64_t world_effects(const struct world *world);
/* Returns true if the CPU computes the ground: soil that bears always, kinematic models if the scene says so or there is no GL. Pages then have their
 * home in host memory. */
bool world_is_bearing(const struct world *world);
bool world_computes_together(const struct world *world); /* contacts of several bodies, whose passes read and write tiles, so the slots lie in arrays */
const struct relief *world_relief(const struct world *world); /* returns what raises the ground below level 0; NULL: nothing */
enum gpu_division world_division(const struct world *world);  /* returns how tiles below level 0 get their base */
bool world_needs_soil_map(const struct scene *scene); /* true if there is a map of soils and something uses it */
bool world_needs_rasters(const struct scene *scene);  /* true if there are rasters of soil numbers and something uses them */
/* Which soils lie along the paths of objects and drivers until the drive's end. Found at some places of each path, before the drive. Amounts are
 * counted in path samples. */
struct world_soils_met {
	size_t places;              /* that were looked at, on the terrain */
	bool partly;                /* some body comes elsewhere: a vehicle without a path, or a host's */
	double all, soils[SOIL_CLASSES];
	double values[256], none;   /* by the value of the map of soils; none: the map has no value there */
	double numbers[SOIL_RASTERS]; /* by raster of soil numbers: where it has a number */
	/* Of object i and soil k, at i * SOIL_CLASSES + k: about what load the soil bears that is weakest there, N, and that soil. NAN: the object has no
	 * load, or does not come to it. INFINITY: not known for its shape */
	double *least;
	struct soil_numbers *weakest;
};
/* One of the scene's rasters, in the unit of its key. Only if world->soil_rasters is not NULL. `step`: from one level to the next. */
struct world_raster {
	const char *key, *unit, *path; /* unit NULL: none */
	double low, high, step;
};
struct world_raster world_raster(const struct world *world, int raster);
/* Opens the store for reading and makes the bodies; only for plans. If `store` is NULL, it assumes a terrain and describes it
 * in `assumed`. End with world_finish. */
enum status world_prepare_plan(struct world *world, const struct scene *scene, const char *store, bool keep_history,
			       struct store_meta *assumed)
	FURROW_CHECKED;
/* Prints a note if this run is the first to write ruts into a store that was imported, and keeps no history. For runs of a command. */
void world_tell_written(const struct world *world);
/* Returns true if vehicles weigh as on the Earth only because the scene gives no gravity, and no note of world_advise says so. */
bool world_assumes_gravity(const struct world *world);
/* Calls `tell` for each setting of the scene that has no effect on this store. */
void world_advise(const struct world *world, scene_advice_fn tell, void *user);
/* Add lines to a plan: the first for the passes and resources of contacts, the second for pages and the look-ahead. `added`: shapes of
 * bodies that will be added (world_body_add). Lines count them as objects, after those of the scene. */
enum status world_plan_deform(const struct world *world, const struct soil_shape *const *added, size_t count, struct plan *plan)
	FURROW_CHECKED;
void world_plan_pages(const struct world *world, struct plan *plan);
uint64_t world_samples_until(const struct track *track, double end); /* number of path samples that are due until `end`, s */

/* --- resources that a world needs at least, and uses at most: budget.c --- */

/* STATUS_INPUT, with the number needed: one window touches more tiles than there are slots, or more ground relaxes than can
 * relax at once. */
enum status world_budget_check(struct world *world) FURROW_CHECKED;
void world_budget(const struct world *world, struct resident_pages_budget *budget); /* bytes of everything that holds tiles */

#endif
