/*
 * report: what a run did and what it took: run.json, objects.csv, map.png; and before it, what it will make and run.
 *
 * All of it is for the world's thread, and reads the world without changing it.
 */
#ifndef FURROW_REPORT_H
#define FURROW_REPORT_H

#include "base/base.h"
#include "base/times.h"
#include "render/render.h"
#include "world/world.h"

struct cJSON;

/* What a run's own loop measured. */
struct report {
	const struct world *world;
	const struct view *view;         /* NULL: no view, or nobody asked for a picture of it */
	struct pictures *pictures;       /* NULL: none are written */
	struct times step_ms, frame_ms;  /* a frame is a step and its picture; where none is drawn, a step alone */
	struct stalls stalls_settled;    /* in the first second of the loop, once it is over: settled */
	bool settled;
	double warm_seconds;             /* wall clock until the loop began */
	unsigned threads;                /* that ran when the last step was over */
	double seconds;                  /* wall clock of the loop */
};

/* run.json's text, for mem_free. `ended`: "complete", "interrupted" or "failed". NULL: out of memory. */
char *report_json(const struct report *report, const char *ended);
/* Into DIRECTORY/run.json, written aside and renamed. */
enum status report_write(const char *directory, const char *json) FURROW_CHECKED;
/* A picture of the run so far, from what is committed; written aside and renamed. */
enum status report_map(const struct world *world, const char *path, const char *ended) FURROW_CHECKED;

/* counts.c: what was made and run; `gpu`: passes without those of warming up. */
void report_counts(struct cJSON *root, const struct report *report, const struct gpu_stats *gpu, const struct resident_pages_io *io);
/* where.c: where effects were, of where they might have been. */
void report_where(struct cJSON *root, const struct report *report, const struct gpu_stats *gpu);

/* --- objects.csv --- */

struct report_rows;
/* DIRECTORY/objects.csv: anew, or cut to the rows that a resumed run goes on from. *out NULL: the scene asks for no rows, and
 * another run's file is removed. The directory's name stays the caller's. */
enum status report_rows_open(const struct world *world, const char *directory, struct report_rows **out) FURROW_CHECKED;
void report_rows_close(struct report_rows *rows); /* takes NULL */
/* For world.rows; valid until it is closed. NULL of NULL. */
const struct world_rows *report_rows_sink(const struct report_rows *rows);

/* --- the plan --- */

/*
 * What a run will make and run, before it does: needs no GL, makes no thread, and changes nothing, the store neither.
 *
 * What counts depends on the way (windows, tiles, commits) is in the plan by unit; what is known before is here. A run
 * of the same scene over the same store makes and runs what the plan says, times its counts of units, and nothing else.
 */
struct report_plan {
	struct plan plan;
	uint64_t effects;     /* scene_effects of the working level */
	char *store;          /* path; NULL: none was given or found, and what is told of it is assumed: */
	char *missing;        /* path of the store that the scene names, and that is not there; NULL: it names none, or it is */
	uint32_t cells;       /* of a tile's side; assumed 256 */
	int level;            /* the working level; assumed 0 */
	double spacing;       /* metres between its posts; assumed the scene's, or 1 */
	bool deformed;        /* the store is, before the run; assumed not */
	struct {
		uint64_t slots, loads, queue, ground;
		uint64_t queue_few; /* of the queue, while no step changes more pages than a commit waits for: most often */
	} most;               /* bytes, as run.json's memory.budget: of the planes in slots, and of tiles on the host */
	size_t window_tiles;  /* that one window, or block of relaxing ground, can touch, at most */
	int64_t steps, pictures; /* until end_time; pictures that are drawn: those that are written */
	int64_t picture_steps; /* one is written every so many steps; 0: none is */
	uint64_t *stations;   /* of each object, until end_time */
	char **notes;         /* scene_advise's, and what the store adds: "KEY: WHY; WHAT TO DO" */
	size_t note_count;
};

/* `store`: path; overrides the scene's; NULL: the scene's, if there is such a file. Fails as a drive would that cannot
 * begin: STATUS_INPUT for what the store or its spacing does not allow. On failure `out` is all zero. */
enum status report_plan(const struct scene *scene, const char *store, struct report_plan *out) FURROW_CHECKED;
void report_plan_finish(struct report_plan *plan); /* of one that is all zero too */

#endif
