/*
 * What furrow report knows of one folder that furrow drive left: run.json, and the curves of objects.csv and vehicles.csv. All of it is
 * untrusted: texts are escaped where they are written, numbers are checked where they are read.
 */
#ifndef FURROW_TOOLS_HTML_RUN_H
#define FURROW_TOOLS_HTML_RUN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "base/base.h"
#include "base/json.h"

/* Values of a row, beside its time and its way. */
enum html_value {
	HTML_SINKAGE, /* mm */
	HTML_SLIP,
	HTML_DRAWBAR, /* N: the soil's force along the way */
	HTML_ENERGY,  /* kJ into the soil, since the first row */
	HTML_VALUES,
	/* of a vehicle: */
	HTML_SPEED = 0, /* m/s */
	HTML_WORK,      /* kJ */
	HTML_KINETIC,   /* kJ */
};

/* The rows of one object or vehicle. */
struct html_body {
	char *name;
	size_t count, room;
	double *time, *way;           /* s; m in plan since the first row */
	double *x, *y;                /* m */
	double *values[HTML_VALUES];  /* NaN: not known */
	struct html_row *last;        /* while rows are read */
};

struct html_bodies {
	struct html_body *list;
	size_t count;
	bool there;     /* the file is there, and has rows */
};

struct html_run {
	const char *folder; /* as it was given */
	cJSON *json;
	struct html_bodies objects, vehicles; /* of objects.csv, of vehicles.csv */
	struct html_bodies ways;              /* corners of the objects' ways, of run.json: without times and values */
};

/* Returns true if the path is a regular file. Reading a pipe or a device might never end. */
bool html_is_file(const char *path);
/* STATUS_INPUT if the folder has no run.json, or a file in it is damaged. */
enum status html_run_read(const char *folder, struct html_run *out) FURROW_CHECKED;
void html_run_finish(struct html_run *run); /* also takes one that is all zero */

/* Returns the value at a path with dots, such as "cache.slots". NULL: there is none. */
const cJSON *html_at(const struct html_run *run, const char *path);
/* Returns the value if it is an object, so that its members have names. Else NULL. */
const cJSON *html_members(const struct html_run *run, const char *path);
double html_number(const struct html_run *run, const char *path);    /* NaN: it is no finite number */
const char *html_string(const struct html_run *run, const char *path); /* NULL: it is no text */
/* A setting of the scene by its key; NULL: the scene has none, or run.json does not tell. */
const char *html_setting(const struct html_run *run, const char *key);

/* Returns the ways, from the first of these that has them: vehicles.csv, objects.csv, run.json. */
const struct html_bodies *html_ways(const struct html_run *run);

/* html_rows.c: reads a file of rows; the bodies stay empty if it is not there. */
enum status html_rows_objects(struct html_run *run) FURROW_CHECKED;
enum status html_rows_vehicles(struct html_run *run) FURROW_CHECKED;
/* Adds a body without points; NULL: out of memory. */
struct html_body *html_bodies_add(struct html_bodies *bodies, const char *name);
/* Makes room for one more point. */
enum status html_body_room(struct html_body *body) FURROW_CHECKED;
void html_bodies_finish(struct html_bodies *bodies);

#endif
