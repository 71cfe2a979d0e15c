/* A world with what a host keeps beside it, shared by the files of api. Only the world's thread touches it. */
#ifndef FURROW_API_INTERNAL_H
#define FURROW_API_INTERNAL_H

#include "api/api.h"

struct host; /* host.c */

struct drive {
	const struct api_params *params;
	struct world world;
	struct world_watcher watcher; /* the view's */
	struct world_commits commits; /* the pictures' */
	struct view *view;            /* NULL without one */
	struct pictures *pictures;    /* NULL: none are written */
	struct report_rows *rows;     /* NULL: no objects.csv */
	struct report report;
	struct host *host;            /* NULL but while a window has a say */
	double began;                 /* s, by the clock: the loop */
};

/* host.c: the loop of a drive that a window has a say in. */
enum status host_steps(struct drive *drive, int64_t total) FURROW_CHECKED;

#endif
