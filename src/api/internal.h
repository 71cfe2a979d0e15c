/*
 * Shared by the files of src/api: the struct drive. A drive is a run of a scene: its world, view, pictures and report. Only the
 * world's thread uses it.
 */
#ifndef FURROW_API_INTERNAL_H
#define FURROW_API_INTERNAL_H

#include "api/api.h"

struct host; /* host.c */

struct drive {
	const struct api_params *params;
	struct scene scene;           /* the scene that is run; without a window it comes from scene_unwatched */
	struct world *world;
	struct vehicles *vehicles;    /* NULL: the scene has none */
	struct report_vehicles *vehicle_rows; /* NULL: no vehicles.csv */
	struct world_commits commits; /* the pictures' */
	struct view *view;            /* NULL if the scene has no view */
	struct pictures *pictures;    /* NULL: none are written */
	struct report_poses *poses;   /* NULL: the scene has no cameras, or they write nothing */
	FILE *volume;                 /* volume.csv; NULL: none */
	struct report_rows *rows;     /* NULL: no objects.csv */
	struct report report;
	bool ran;                     /* its loop began */
	bool unbegun;                 /* it failed before its first step, or nothing could be set down: nothing of it is to be kept */
	bool new_folder, new_overlay; /* they were not there before */
	struct host *host;            /* NULL unless a window controls the drive */
	double entered, began;        /* s, of the system's clock: start of the drive, and of its loop */
};

/* --- folder.c --- */
/* Opens the folder's log of commits, and locks the folder with it. */
enum status api_folder_commits(const char *directory, FILE **out) FURROW_CHECKED;
/* Removes the files of an earlier run, by their names. A resumed run keeps pictures, and the lines that it continues. */
enum status api_folder_clear(const struct world *world, const char *directory) FURROW_CHECKED;

/* Removes the folder with all that is in it, a link but not what it leads to. What cannot be removed stays. */
void api_folder_remove(const char *directory);

/* --- drive_start.c --- */
/* Of many processes that step the world together, the first writes the files. */
bool api_writes(const struct drive *drive);
/* Returns the failure of any process on all of them. */
enum status api_agree(struct drive *drive, enum status status) FURROW_CHECKED;
/* Opens and makes all that the drive changes: pages, the view, files of rows. */
enum status api_start(struct drive *drive) FURROW_CHECKED;

/* drive.c: takes what steps did since the last call: rows go to their file, and the view learns what happened to the ground. */
enum status api_take(struct drive *drive) FURROW_CHECKED;
/* drive.c: makes one step of the world, and of the vehicles in it. */
enum status api_one_step(struct drive *drive) FURROW_CHECKED;

/* --- drive_end.c --- */
/* Stops the threads, and writes run.json, cameras and maps. `status`: how the loop ended; returned, unless only the writing failed. */
enum status api_end(struct drive *drive, struct api_result *result, enum status status) FURROW_CHECKED;
/* Writes of these what is missing, for a resumed drive that has nothing left to do. */
enum status api_end_again(struct drive *drive, struct api_result *result) FURROW_CHECKED;
/* Of many processes, when all have closed the ground: what they did comes together, and the first writes run.json and the map. `status`: how
 * this one ended. */
enum status api_conclude(const struct drive *drive, int64_t step, double time, struct api_result *result, enum status status) FURROW_CHECKED;
/* Removes what a drive made that could not begin. What was there before stays. */
void api_remove_made(const struct drive *drive);

/* host.c: the loop of a drive that a window controls. */
enum status api_host_steps(struct drive *drive, int64_t total) FURROW_CHECKED;

#endif
