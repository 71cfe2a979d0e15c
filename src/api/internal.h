/* A world with what a host keeps beside it, shared by the files of api. Only the world's thread touches it. */
#ifndef FURROW_API_INTERNAL_H
#define FURROW_API_INTERNAL_H

#include "api/api.h"

struct host; /* host.c */

struct drive {
	const struct api_params *params;
	struct scene scene;           /* without a window: scene_unwatched's */
	struct world world;
	struct world_watcher watcher; /* the view's */
	struct world_commits commits; /* the pictures' */
	struct view *view;            /* NULL without one */
	struct pictures *pictures;    /* NULL: none are written */
	struct report_rows *rows;     /* NULL: no objects.csv */
	struct report report;
	struct host *host;            /* NULL but while a window has a say */
	double entered, began;        /* s, by the clock: the drive; its loop */
};

/* folder.c: the folder is made if it is not there; STATUS_FAILED: it cannot be. */
enum status api_folder_make(const char *path) FURROW_CHECKED;
/* Opens its log of commits, and locks the folder with it. */
enum status api_folder_epochs(const char *directory, FILE **out) FURROW_CHECKED;
/* What an earlier run left goes, but for the lines that a resumed one goes on with. */
enum status api_folder_clear(const struct world *world, const char *directory) FURROW_CHECKED;

/* host.c: the loop of a drive that a window has a say in. */
enum status api_host_steps(struct drive *drive, int64_t total) FURROW_CHECKED;

#endif
