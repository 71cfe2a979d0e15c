/*
 * drive: the one loop that opens, warms, steps, seals and ends a world, with its vehicles, view, rows and report. The command and the window
 * run it whole by drive_run(). The library calls its parts, since its host decides when to step:
 *
 *     drive_open -> drive_start -> drive_begin -> (drive_step | drive_checkpoint | drive_rollback) ... -> drive_end -> drive_stop -> drive_finish
 *
 * What differs between them is in struct drive_params. Only one thread uses a drive, the one that owns its GL context.
 */
#ifndef FURROW_DRIVE_H
#define FURROW_DRIVE_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "render/render.h"
#include "report/report.h"
#include "scene/scene.h"
#include "vehicle/vehicle.h"
#include "world/world.h"

struct drive; /* a world with its vehicles, view, pictures, rows and report */

/*
 * --- a window ---
 *
 * A host watches a drive while it goes on, and may control it. The window is a host.
 *
 * All calls come from the drive's thread, the one that called drive_run. The functions below are called from that thread only,
 * and only inside a call of the host. Between two calls of `turn` the drive makes the steps that are due, and draws at most one
 * picture. What a host asks for decides when steps are made and what is seen. It does not change the ground that they make.
 * Bodies that it drops do change the ground.
 */
enum drive_go {
	DRIVE_ON,   /* makes steps at the speed `pace` */
	DRIVE_ONE,  /* makes one step at once */
	DRIVE_HOLD, /* makes no steps, but still draws pictures */
	DRIVE_STOP, /* ends the drive with STATUS_OK; everything done so far is committed */
};

#define DRIVE_PICTURE_MOST 8192u /* pixels a side */

/* What the host wants. The host changes it in a call of `turn`; it keeps its values until the next call. Before the first call it
 * has the values named here. */
struct drive_control {
	enum drive_go go;               /* DRIVE_ON. After the scene's last step everything but DRIVE_STOP acts as DRIVE_HOLD */
	double pace;                  /* simulated seconds for each second, above 0: 1. INFINITY: as fast as possible */
	bool free;                    /* false: the scene's camera is used; true: `camera` is used */
	struct render_camera camera;
	enum render_layer_kind layer; /* RENDER_NATURAL */
	uint32_t width, height;       /* of the picture, pixels, 1 to DRIVE_PICTURE_MOST each: the scene's */
	bool again;                   /* draws a picture even if nothing changed; set to false when it is drawn */
};

struct drive_host {
	void *user;
	/* May use the functions below. A status other than STATUS_OK ends the drive, as a failed step does. */
	enum status (*turn)(void *user, struct drive *drive, struct drive_control *control);
	/* Takes a picture: sRGB and alpha, 4 x width x height bytes, row 0 at the bottom. The host may change the pixels until
	 * it returns. Pictures come in the order in which they were drawn. With a software driver each comes at most one turn
	 * late. Nothing is drawn when nothing has changed. */
	enum status (*picture)(void *user, struct drive *drive, uint8_t *pixels, uint32_t width, uint32_t height);
};

struct drive_figures {
	double fps;               /* pictures a second: about the mean of the last second in which there were any */
	double frame_ms, step_ms; /* frame_ms: the last picture, until it was read back; step_ms: the last step */
	uint32_t slots, slots_used;
	uint64_t hits, misses;    /* hits and misses of the page cache, counted only for steps, not for pictures */
	size_t dirty, queued;     /* dirty: pages changed since the last commit; queued: images that wait for a commit */
	uint64_t triangles;       /* of the last picture */
	int64_t step, steps;      /* steps done, and all steps of the scene */
	double time, end;         /* simulated seconds: now, and at the end of the scene */
	bool over;                /* the scene's last step is done */
	struct render_layer layer; /* the layer that the last picture shows, with the range of its colours */
};
void drive_figures(struct drive *drive, struct drive_figures *figures);

const struct scene *drive_scene(const struct drive *drive);
const struct store_meta *drive_store(const struct drive *drive);
/* Copies the scene's own camera as it is now. */
void drive_scene_camera(const struct drive *drive, struct render_camera *camera);
/* What an eye can follow, by its number: the scene's objects, then its vehicles. */
struct drive_followed {
	const char *name;
	bool vehicle;    /* the next three are known */
	double speed;    /* m/s: over the ground, without its vertical part */
	double slip;     /* mean of its wheels and belts; NaN: none turns */
	double sinkage;  /* m: of what is deepest in the soil; 0: it touches none */
};
size_t drive_followed_count(const struct drive *drive);
void drive_followed(const struct drive *drive, size_t number, struct drive_followed *out);
/* Tells where one of these is now. `place`: local metres, of an object on the base; `yaw`: radians from east to north. */
void drive_place(const struct drive *drive, size_t number, double place[3], double *yaw);

/* Sends a vehicle, by its number as above, to a place, m, local: its driver leaves its path (vehicle_send). Returns false if the number is of an object, or of a
 * vehicle without a path. */
bool drive_send(struct drive *drive, size_t number, double x, double y);
/* Gives the place to which it was sent. Returns false if it was not. */
bool drive_target(const struct drive *drive, size_t number, double place[2]);
double drive_time(const struct drive *drive); /* s, simulated: now */
/* A wheel or a belt of one of these. */
struct drive_wheel {
	const char *name; /* VEHICLE.GEOM */
	double slip;      /* NaN: it does not turn */
	double sinkage;   /* m; 0: it touches nothing */
};
/* Fills `wheels`, at most `most`. Returns how many there are of them; 0 for an object. */
size_t drive_wheels(const struct drive *drive, size_t number, struct drive_wheel *wheels, size_t most);

/* Drops a body, as world_drop does. The soil that relaxes after it goes on relaxing in the steps that follow. */
enum status drive_drop(struct drive *drive, enum world_drop_shape shape, double x, double y, double yaw, bool *landed)
	FURROW_CHECKED;

/* --- a drive --- */

struct drive_params {
	const struct scene *scene;
	const char *store;     /* path; overrides the scene's; may be NULL if that names one */
	const char *overlay;   /* path of the overlay that takes the deformation instead of the store; made if absent. May be NULL */
	const struct store_staged *staged; /* the base is read from its copy (store_stage). NULL: from where it is */
	/* folder for run.json, epochs.log, frame-*.png and what `output` asks for; made if absent. NULL: nothing is written; only if hosted */
	const char *directory;
	bool hosted;           /* the library's host steps it, and only it sees pictures: no files of pictures and no volume.csv */
	bool advise;           /* of a hosted drive: notes tell what looks wrong with the scene. Otherwise they do so of vehicles alone */
	bool readonly;         /* nothing is written to store and overlay, and there are no steps; only if hosted */
	const char *trace;     /* path of a trace of every access to the page cache (page/page.h). May be NULL */
	int64_t steps;         /* last step, counted from the scene's start; 0: until end_time */
	bool resume;           /* goes on from the store's last drive of this scene, with the same bits; begins anew if there was none */
	bool durable_full;
	bool keep_history;     /* each commit keeps what it replaces, for furrow restore */
	bool progress;         /* writes a line of progress on stderr */
	bool map;              /* writes map.png, of the whole drive, at the end, unless it failed in its first step; run.json does not count it */
	const char *map_also;  /* writes the same map to this file, .png, .svg or .pdf, with or without `map`. May be NULL */
	bool alone;            /* computes every contact alone: for tests that compare results */
	int threads;           /* that compute soil that bears, however little there is: for tests that compare results. 0: as many as are worth it */
	bool everywhere;       /* computes every contact, also one that changes nothing: for tests that compare results */
	/* The host that watches and controls the drive; NULL: none. Only for a scene with a view; then the scene's images are not
	 * written. */
	const struct drive_host *host;
	const volatile sig_atomic_t *stop; /* becomes non-zero to end the drive cleanly, with STATUS_INTERRUPTED. May be NULL */
	/* The drive is one of several processes that step this world together. Then store and overlay are those of `ranks`, and only rank 0
	 * writes files. NULL: it is the only one. */
	const struct world_ranks *ranks;
	/* Says where the rows of all ranks go (NULL: nowhere). */
	void (*share_rows)(void *user, const struct report_rows *rows);
};

struct drive_result {
	const char *ended; /* "complete", "interrupted", "failed" */
	int64_t steps;
	int level;      /* that was deformed */
	double spacing; /* m, of its posts */
	double seconds, rtf;
	char *json; /* the text of run.json; free with mem_free */
	bool reported;     /* run.json was written */
	int64_t committed; /* step from which a later call with `resume` goes on; 0: the first, or not known, as of many processes */
	bool map;   /* map.png was written */
	bool map_also; /* the map that the parameter `map_also` names was written */
};

/*
 * Runs a drive to its end. Writes run.json and the trace however the drive ends, once it has begun. A drive that cannot begin
 * leaves no file.
 *
 * Of run.json, these describe the drive as a whole, also after a resume: ended, steps, simulated, volume, objects. Everything
 * else describes the process that wrote it: seconds, rtf, times, cache, passes, memory, io, where, refused_posts, view, counts.
 *
 * "where" has {visited, possible} for each effect. `visited` counts the work that was done. `possible` counts the work without
 * any test of whether there is something to do. The entries are:
 * - displace, or the model's name (box, sumner, slippage, scm), spread, and "dirt": windows of contacts. `possible` has the
 * windows of all path samples that are on the ground or above it.
 * - slide or shed: blocks of 32 x 32 posts, each interval. `possible` has all blocks of the tiles touched so far.
 * - pyramid, with a view: coarser tiles brought up to date, each step. `possible` has the resident ones.
 * - draw, with a view: tiles drawn with an offset, each frame. `possible` has all drawn tiles.
 * - slots, always: slots for which planes were made. `possible` has all slots. Of bearing soil: tiles in memory at the end.
 *
 * The entries for windows and blocks do not depend on paging. All others may differ from drive to drive. The windows visited
 * may differ too, where soil moves and an object rises from it. That depends on when the flags of the GPU arrive. Normals have
 * no entry: they are computed from the posts when these are drawn.
 *
 * "counts" agrees with the lines of the plan (base/plan.h). Each count is the sum of amounts times "units". Units are listed by
 * object or by table, where the lines are. A unit of memory (base_slot to ring) is the largest number that ever existed at
 * once, since none is freed before the end. "bytes" are those of the GPU, and with bearing soil those of tiles and windows in host memory too.
 *
 * Counted from the start of the process: programs, textures, bytes, threads, units of memory, and the store's work (statements,
 * "loaded" to "epoch"). Counted from the first step: passes and the other units. "threads" ran when the last step was over.
 * "unplanned" counts programs that were linked in a step; more than 0 is an error in the plan.
 *
 * A resumed drive with nothing left to do needs no GL and describes only the drive as a whole. It writes run.json and map.png
 * only where there is none.
 *
 * If the map fails, the drive fails with it, unless it failed already. Then the map's failure is printed on stderr.
 */
enum status drive_run(const struct drive_params *params, struct drive_result *result) FURROW_CHECKED;

/*
 * --- queries: the ground of a drive that runs ---
 *
 * Call them on the drive's thread, between two steps. They tell the newest ground, with the changes of the last step. A query
 * changes nothing that the results of a drive depend on. What it reads is counted in run.json (memory, statements, read-backs)
 * and is in no plan.
 *
 * resident/heights.h defines heights and rays. One call for many points is cheaper than many calls. In each step the first query
 * near ground that changed and is not committed may wait. On a hardware GPU it waits for all work begun before.
 */
enum status drive_heights(struct drive *drive, const struct resident_point *points, size_t count, struct resident_height *heights) FURROW_CHECKED;
enum status drive_rays(struct drive *drive, const struct resident_ray *rays, size_t count, struct resident_hit *hits) FURROW_CHECKED;

/* Makes the folder if it does not exist. STATUS_FAILED: it cannot be made, or is no folder. */
enum status drive_folder_make(const char *path) FURROW_CHECKED;

/*
 * --- the parts of a drive: for who hosts it ---
 *
 * Failures are those of the functions of world.h, vehicle.h, render.h and report.h that they call.
 */

/* Loads the vehicles, opens the store, and makes the bodies. Changes no file. The texts of `params` and the scene must stay valid as long as the
 * drive, but for those of store, overlay and staged. *out gets the drive, or NULL after a failure. */
enum status drive_open(const struct drive_params *params, struct drive **out) FURROW_CHECKED;
/* Tells advice as notes. Makes GL, pages, the view of the scene and the files of rows, and loads what the first step needs. */
enum status drive_start(struct drive *drive) FURROW_CHECKED;
/* Makes the view of the drive's scene, if that got one after the start. Call world_start_drawing() before. */
enum status drive_start_view(struct drive *drive) FURROW_CHECKED;
/* Begins, or goes on where a resumed drive stopped. Vehicles are set down. */
enum status drive_begin(struct drive *drive) FURROW_CHECKED;
/* Makes one time_step, with the vehicles. */
enum status drive_step(struct drive *drive) FURROW_CHECKED;
/* Makes one step that ends at `until`, s. Only without vehicles. */
enum status drive_step_to(struct drive *drive, double until) FURROW_CHECKED;
/* Marks the present state: ground, bodies, vehicles and files of rows. drive_rollback() goes back to it. On failure the mark stays where it was. */
enum status drive_checkpoint(struct drive *drive) FURROW_CHECKED;
/* STATUS_FAILED: there is no checkpoint, or vehicles are not back; then the world is torn. */
enum status drive_rollback(struct drive *drive) FURROW_CHECKED;
/* Commits all. `complete`: it went as far as the scene says. */
enum status drive_end(struct drive *drive, bool complete) FURROW_CHECKED;
/* Stops the threads, so that figures are final. */
void drive_stop(struct drive *drive);
/* Returns the text of run.json as of now, to free with mem_free. `ended` as in report_json(). NULL: out of memory. */
char *drive_describe(struct drive *drive, const char *ended);
/* Frees it, whatever part it came to. Takes NULL. `status`: how it ended; its message stays. */
void drive_finish(struct drive *drive, enum status status);

/* What a drive has, valid until it is closed. */
struct world *drive_world(struct drive *drive);
struct vehicles *drive_vehicles(struct drive *drive); /* NULL: the scene has none */
struct view *drive_view(struct drive *drive);         /* NULL: there is none yet */
struct report *drive_report(struct drive *drive);     /* times are added by who measures them */

#endif
