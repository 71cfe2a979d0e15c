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
	HTML_TRACTION, /* N: the soil's force along the ground, in the direction of the way */
	HTML_GRADE,   /* N: the part of it that carries the weight up the slope */
	HTML_DRAWBAR, /* N: the rest of it */
	HTML_ENERGY,  /* kJ into the soil, since the first row */
	HTML_LOSS,    /* J of it for each metre of way */
	HTML_TORQUE,  /* N m about the axle: the soil's moment, turned round. Of what turns */
	HTML_VERTICAL, /* N: the soil's force upward */
	HTML_PUSH,    /* kJ: work of the soil's force along the way, in space, since the first row */
	HTML_VALUES,
	/* of a vehicle: */
	HTML_SPEED = 0, /* m/s */
	HTML_WORK,      /* kJ */
	HTML_KINETIC,   /* kJ */
	HTML_SOIL,      /* kJ into the soil by all its soil geoms, as the rows of objects.csv have it at its times */
	/* of an actuator: */
	HTML_FORCE = 0, /* N m at a hinge, N at a slide or site; before its gear */
};

/* What an object did with its energy from its first row to its last, kJ. NaN: not known. */
struct html_energy {
	double soil;      /* what went into the soil: torque - push */
	double torque;    /* work of the axle's torque; of what does not turn 0 */
	double push;      /* work of the soil's force along the way, in space: above 0 it drives, below 0 it resists */
	double climb;     /* the part of `push` that lifts the weight */
	double slip;      /* the part of `soil` that the wheel's slip takes: slip x torque */
};

/* The rows of one object or vehicle. */
struct html_body {
	char *name;
	size_t count, room;
	double *time, *way;           /* s; m in plan since the first row */
	double *x, *y;                /* m */
	double *values[HTML_VALUES];  /* NaN: not known */
	struct html_row *last;        /* while rows are read */
	struct html_energy energy;    /* of an object */
	double floor, rise;           /* m: height in the first row; how much higher it is in the last one */
	double steepest;              /* of an object: largest grade resistance over the weight, a share of 1 */
	struct html_digging *digging; /* of one that carries soil, for each row what is aboard; NULL: it carries none */
};

struct html_bodies {
	struct html_body *list;
	size_t count;
	bool there;     /* the file is there, and has rows */
};

/* Rows of volume.csv. */
enum html_volume { HTML_REMOVED, HTML_RAISED, HTML_COMPACTED, HTML_NET, HTML_VOLUMES }; /* m3; net: raised - removed */
struct html_volumes {
	size_t count, room;
	double *time, *values[HTML_VOLUMES];
};

struct html_run {
	const char *folder; /* as it was given */
	cJSON *json;
	struct html_bodies objects, vehicles; /* of objects.csv, of vehicles.csv */
	struct html_bodies actuators;         /* of vehicles.csv, each named VEHICLE: ACTUATOR; way and place are the vehicle's */
	struct html_volumes volumes;
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

/* Returns the ways, from the first of these that has them: vehicles.csv, objects.csv, run.json. If there are vehicles and objects on paths, from
 * run.json. */
const struct html_bodies *html_ways(const struct html_run *run);

/* html_forces.c: computes what a row of an object tells, with the row before. */
void html_forces_take(struct html_body *body, struct html_row *row, double went);
/* html_digging.c: takes what a row tells of soil aboard; nothing, if the body carries none. Call it after html_forces_take. */
enum status html_digging_take(struct html_body *body, const struct html_row *row) FURROW_CHECKED;
void html_digging_finish(struct html_digging *digging); /* takes NULL */
/* html_rows.c: reads a file of rows; the bodies stay empty if it is not there. */
enum status html_rows_objects(struct html_run *run) FURROW_CHECKED;
enum status html_rows_vehicles(struct html_run *run) FURROW_CHECKED;
/* html_volume.c: reads volume.csv; there are no rows if it is not there. */
enum status html_volumes_read(struct html_run *run) FURROW_CHECKED;
void html_volumes_finish(struct html_volumes *volumes);
/* Whether an object is a soil geom of a vehicle: VEHICLE.GEOM. */
bool html_is_part(const char *object, const char *vehicle);
/* Sums the energy of each vehicle's soil geoms. */
void html_rows_join(struct html_run *run);
/* Adds a body without points; NULL: out of memory. */
struct html_body *html_bodies_add(struct html_bodies *bodies, const char *name);
/* Makes room for one more point. */
enum status html_body_room(struct html_body *body) FURROW_CHECKED;
void html_bodies_finish(struct html_bodies *bodies);

#endif
