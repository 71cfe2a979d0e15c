/*
 * Shared by the files of src/drive: the struct drive. A drive is a run of a scene: its world, vehicles, view, rows and report. Only the
 * world's thread uses it.
 */
#ifndef FURROW_DRIVE_INTERNAL_H
#define FURROW_DRIVE_INTERNAL_H

#include "drive/drive.h"

struct host; /* host.c */

struct drive {
	struct drive_params params;   /* its texts are the caller's */
	struct scene unwatched;       /* the scene without what only a window uses */
	const struct scene *scene;    /* the scene that is run: that, or the caller's */
	struct world *world;
	struct vehicles *vehicles;    /* NULL: the scene has none */
	struct report_vehicles *vehicle_rows; /* NULL: no vehicles.csv */
	struct report_sensors *sensor_rows; /* NULL: no sensors.csv */
	struct report_lidars *lidars; /* NULL: the scene has none */
	struct world_commits commits; /* before a commit, rows and pictures of its steps go to their files */
	struct view *view;            /* NULL if the scene has no view */
	struct pictures *pictures;    /* NULL: none are written */
	struct report_poses *poses;   /* NULL: the scene has no cameras, or they write nothing */
	FILE *volume;                 /* volume.csv; NULL: none */
	struct report_rows *rows;     /* NULL: no objects.csv */
	struct report report;
	struct drive_mark {           /* ends of the files of rows at the last checkpoint */
		int64_t rows, vehicle_rows, sensor_rows;
	} mark;
	bool ran;                     /* its loop began */
	bool unbegun;                 /* it failed before its first step, or nothing could be set down: nothing of it is to be kept */
	bool new_folder, new_overlay; /* they were not there before */
	struct host *host;            /* NULL unless a window controls the drive */
	double entered, began;        /* s, of the system's clock: start of the drive, and of its loop */
};

/* --- folder.c --- */
/* Opens the folder's log of commits, and locks the folder with it. */
enum status drive_folder_commits(const char *directory, FILE **out) FURROW_CHECKED;
/* Removes the files of an earlier run, by their names. A resumed run keeps pictures, and the lines that it continues. */
enum status drive_folder_clear(const struct world *world, const char *directory) FURROW_CHECKED;
/* Removes the folder with all that is in it, a link but not what it leads to. What cannot be removed stays. */
void drive_folder_remove(const char *directory);

/* --- life.c --- */
/* The first part of drive_open(), into a drive that is all zero. After a failure, too, the drive is to be let go. */
enum status drive_prepare(struct drive *drive, const struct drive_params *params) FURROW_CHECKED;
/* Both are drive_finish(), but for the memory of the drive. Between them only scene, params and vehicles may be used. */
void drive_let_go(struct drive *drive, enum status status);
void drive_let_go_vehicles(struct drive *drive);
/* Returns true if pictures are for whoever hosts the drive, so that none are written. */
bool drive_is_watched(const struct drive *drive);
/* Returns true if this process writes files: the drive has a folder, and of many ranks this is the first. */
bool drive_writes(const struct drive *drive);
/* Takes what steps did since the last call: rows go to their file, and the view learns what happened to the ground. A failure tears the world. */
enum status drive_take(struct drive *drive) FURROW_CHECKED;
/* Says in drive->report what the drive has. */
void drive_fill_report(struct drive *drive);
/* Returns the failure of any process on all of them. */
enum status drive_agree(struct drive *drive, enum status status) FURROW_CHECKED;

/* --- end.c: the end of drive_run() --- */
/* Stops the threads, and writes run.json, cameras and maps. `status`: how the loop ended; returned, unless only the writing failed. */
enum status drive_conclude(struct drive *drive, struct drive_result *result, enum status status) FURROW_CHECKED;
/* For a resumed drive that has nothing left to do: writes those of the files that are not there. */
enum status drive_conclude_again(struct drive *drive, struct drive_result *result) FURROW_CHECKED;
/* Of many processes, when all have closed the ground: what they did comes together, and the first writes run.json and the map. `status`: how
 * this one ended. */
enum status drive_conclude_ranks(const struct drive *drive, int64_t step, double time, struct drive_result *result, enum status status)
	FURROW_CHECKED;
/* Removes what a drive made that could not begin. What was there before stays. */
void drive_remove_made(const struct drive *drive);

/* host.c: the loop of a drive that a window controls. */
enum status drive_host_steps(struct drive *drive, int64_t total) FURROW_CHECKED;

#endif
