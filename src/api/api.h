/*
 * api: who steps a world. furrow.h is the library's contract; here are the loops of the command and of the window, which
 * are made of the same parts.
 */
#ifndef FURROW_API_H
#define FURROW_API_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "render/render.h"
#include "report/report.h"
#include "scene/scene.h"
#include "terrain/terrain.h"

struct drive; /* a world with its view, its pictures and its report */

/*
 * --- a window ---
 *
 * A host: who watches a drive while it goes on and may have a say in it, a window for one.
 *
 * All of it is on the drive's thread, the one that called api_drive: nothing here may be called from elsewhere, nor but from
 * within a call of the host's. Between two calls of `turn` there are steps of the scene, as many as are due, and at most one
 * picture. What a host wishes decides when steps are made and what is seen; what they make of the ground it does not change.
 * What it drops does.
 
 */
enum api_go {
	API_ON,   /* steps, as the pace has it */
	API_ONE,  /* one step, now */
	API_HOLD, /* none; the picture goes on */
	API_STOP, /* the drive is over: all that was done is committed, STATUS_OK */
};

#define API_PICTURE_MOST 8192u /* pixels a side */

/* Filled before each turn with what the turn before left there; before the first with what is said here. */
struct api_control {
	enum api_go go;               /* API_ON. After the scene's last step all but API_STOP is API_HOLD */
	double pace;                  /* 1: simulated seconds a second, above 0; INFINITY: as fast as it can */
	bool free;                    /* false: the scene's camera; true: this one */
	struct render_camera camera;
	enum render_layer_kind layer; /* RENDER_NATURAL */
	uint32_t width, height;       /* of the picture, pixels, 1 to API_PICTURE_MOST each: the scene's */
	bool again;                   /* a picture is drawn though nothing changed; false again when it is */
};

struct api_host {
	void *user;
	/* May use the functions below. Another status than STATUS_OK ends the drive as a failed step does. */
	enum status (*turn)(void *user, struct drive *drive, struct api_control *wish);
	/* A picture is there: RGBA, sRGB, 4 x width x height bytes, row 0 the lowest; the host may change them, and has them
	 * until it returns. The pictures come in the order in which they were drawn, each at most one turn late on
	 * software, and never waited for elsewhere. None is drawn of what has not changed. */
	enum status (*picture)(void *user, struct drive *drive, uint8_t *pixels, uint32_t width, uint32_t height);
};

struct api_figures {
	double fps;               /* pictures, about the mean of the last second in which there were any */
	double frame_ms, step_ms; /* the last picture, until it was read back; the last step */
	uint32_t slots, slots_used;
	uint64_t hits, misses;    /* of the page cache, by steps */
	size_t dirty, queued;     /* pages changed since the last epoch; images that wait for a commit */
	uint64_t triangles;       /* of the last picture */
	int64_t step, steps;      /* done, of all */
	double time, end;         /* s, simulated */
	bool over;                /* the scene's last step is done */
	struct render_layer layer; /* of the last picture, and what its colours range over */
};
void api_figures(struct drive *drive, struct api_figures *figures);

const struct scene *api_scene(const struct drive *drive);
const struct store_meta *api_store(const struct drive *drive);
/* The scene's own camera, now. */
void api_scene_camera(const struct drive *drive, struct render_camera *camera);
/* Where an object of the scene is by its path, now: local metres, on the base; yaw in radians from east to north. */
void api_place(const struct drive *drive, size_t object, double place[3], double *yaw);

/* world_drop: the soil that relaxes after it goes on relaxing with the scene's time. */
enum status api_drop(struct drive *drive, enum world_drop_shape shape, double x, double y, double yaw, bool *pressed)
	FURROW_CHECKED;

/* --- a drive --- */

struct api_params {
	const struct scene *scene;
	const char *store;     /* path; overrides the scene's; may be NULL if that names one */
	const char *overlay;   /* path of what keeps the deformation instead of the store; made if absent. May be NULL */
	const char *directory; /* made if absent: run.json, epochs.log, frame-*.png, map.png */
	const char *trace;     /* path: every access to the page cache goes there, as page/page.h says. May be NULL */
	int64_t steps;         /* since the scene's start; 0: until end_time */
	bool resume;           /* go on from the store's last drive of this scene, to the same bits; begin if there was none */
	bool durable_full;
	bool progress;         /* a line on stderr */
	bool map;              /* map.png too, of the whole drive, when all else is over: run.json tells nothing of it */
	bool everywhere;       /* sweeps are computed where they change nothing, too: for tests that compare */
	const struct api_host *host; /* who watches, and says when to step. A scene with a view alone, whose images are
				      * not written. NULL: nobody */
	const volatile sig_atomic_t *stop; /* becomes non-zero: end cleanly, STATUS_INTERRUPTED. May be NULL */
};

struct api_result {
	const char *ended; /* "complete", "interrupted", "failed" */
	int64_t steps;
	double seconds, rtf;
	char *json; /* what run.json holds; free with mem_free */
	bool map;   /* map.png was written */
};

/*
 * run.json and the trace are written however it ends, once it began: a drive that cannot begin leaves nothing.
 * What run.json tells of the drive is of the drive as a whole, also after a resume: ended, steps, simulated, volume, objects; all else
 * (seconds and rtf, times, cache, passes, memory, io, where, refused_posts, view, counts) is of the process that wrote it.
 *
 * "where" has a {visited, possible} for each: what was worked on, of what would have been had nobody looked where there is
 * something to do. By the name of the effect, where the scene calls for it: displace or the model's (box, sumner,
 * slippage, scm), spread and dirt in windows of sweeps, of the stations that are on ground or above it; slide or shed in blocks of
 * 32 x 32 posts, of all in the tiles touched so far, each interval. Where there is a view, pyramid: coarser tiles brought up
 * to date, of those resident, each step; draw: tiles drawn with an offset, of all drawn, each frame. Always, slots: slots
 * with planes that were made, of slots. What depends on the paging (all but windows and blocks) may differ from drive to
 * drive; so may the windows visited where soil moves and an object rises from it, by when the GPU's flags come. There is nothing of normals: they are found from the posts as these are drawn.
 *
 * "counts" is held to the plan's lines (base/plan.h): each is the sum of amounts times "units", which are by object, or by
 * table, where the lines are. Of memory (base_slot to ring) a unit is as many as there ever were at once, since nothing of
 * it is given back before the end; programs, textures, bytes, threads, the units of memory and what the store did
 * (statements, loaded to epoch) count from the process's start, passes and the other units from the first step. "threads"
 * ran when the last step was over. "unplanned": programs that were linked in a step; 0, or it is a mistake.
 *
 * Resumed with nothing left to do: needs no GL, tells the drive as a whole alone, and writes run.json and map.png only where
 * there is none.
 *
 * A map that fails is the drive's failure if nothing else was; otherwise it is told on stderr.
 */
enum status api_drive(const struct api_params *params, struct api_result *result) FURROW_CHECKED;

/*
 * --- queries: the ground of a drive that runs ---
 *
 * On the drive's thread, between two steps. What is told is the newest, wherever it is: a rut of the step before, too. A query
 * changes nothing that a drive's results depend on; what it reads shows in run.json's memory, statements and read-backs, and
 * is in no plan. terrain/terrain.h says what heights and rays are. A call for many is cheaper than many calls; of each step the
 * first that comes near ground that changed and is not committed waits, on a real GPU, for the work begun before.
 */
enum status api_heights(struct drive *drive, const struct terrain_point *points, size_t count, struct terrain_height *heights) FURROW_CHECKED;
enum status api_rays(struct drive *drive, const struct terrain_ray *rays, size_t count, struct terrain_hit *hits) FURROW_CHECKED;

#endif
