/*
 * run: turns the crank. A checked scene and a store become steps, epochs, pictures and run.json.
 */
#ifndef FURROW_RUN_H
#define FURROW_RUN_H

#include <signal.h>
#include <stdint.h>

#include "base/base.h"
#include "base/plan.h"
#include "run/host.h"
#include "scene/scene.h"
#include "terrain/terrain.h"

struct run_params {
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
	const struct run_host *host; /* run/host.h: who watches, and says when to step. A scene with a view alone, whose images are
				      * not written. NULL: nobody */
	const volatile sig_atomic_t *stop; /* becomes non-zero: end cleanly, STATUS_INTERRUPTED. May be NULL */
};

struct run_result {
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
enum status run_drive(const struct run_params *params, struct run_result *result) FURROW_CHECKED;

/*
 * What run_drive will make and run, before it does: needs no GL, makes no thread, and changes nothing, the store neither.
 *
 * What counts depends on the way (windows, tiles, commits) is in the plan by unit; what is known before is here. A drive
 * of the same scene over the same store makes and runs what the plan says, times its counts of units, and nothing else.
 */
struct run_plan {
	struct plan plan;
	uint64_t effects;     /* scene_effects of the working level */
	char *store;          /* path; NULL: none was given or found, and what is told of it is assumed: */
	char *missing;        /* path of the store that the scene names, and that is not there; NULL: it names none, or it is */
	uint32_t cells;       /* of a tile's side; assumed 256 */
	int level;            /* the working level; assumed 0 */
	double spacing;       /* metres between its posts; assumed the scene's, or 1 */
	bool deformed;        /* the store is, before the drive; assumed not */
	struct {
		uint64_t slots, loads, queue, ground;
		uint64_t queue_few; /* of the queue, while no step changes more pages than an epoch waits for: most often */
	} most;               /* bytes, as run.json's memory.budget: of the planes in slots, and of tiles on the host */
	size_t window_tiles;  /* that one window, or block of sliding ground, can touch, at most */
	int64_t steps, pictures; /* until end_time; pictures that are drawn: one a step */
	uint64_t *stations;   /* of each object, until end_time */
	char **notes;         /* scene_advise's, and what the store adds: "KEY: WHY; WHAT TO DO" */
	size_t note_count;
};

/* `store`: path; overrides the scene's; NULL: the scene's, if there is such a file. Fails as a drive would that cannot
 * begin: STATUS_INPUT for what the store or its spacing does not allow. On failure `out` is all zero. */
enum status run_plan(const struct scene *scene, const char *store, struct run_plan *out) FURROW_CHECKED;
void run_plan_finish(struct run_plan *plan); /* of one that is all zero too */

/*
 * --- queries: the ground of a drive that runs ---
 *
 * On the drive's thread, between two steps. What is told is the newest, wherever it is: a rut of the step before, too. A query
 * changes nothing that a drive's results depend on; what it reads shows in run.json's memory, statements and read-backs, and
 * is in no plan. terrain/terrain.h says what heights and rays are. A call for many is cheaper than many calls; of each step the
 * first that comes near ground that changed and is not committed waits, on a real GPU, for the work begun before.
 */
struct drive;
enum status run_heights(struct drive *drive, const struct terrain_point *points, size_t count, struct terrain_height *heights) FURROW_CHECKED;
enum status run_rays(struct drive *drive, const struct terrain_ray *rays, size_t count, struct terrain_hit *hits) FURROW_CHECKED;

#endif
