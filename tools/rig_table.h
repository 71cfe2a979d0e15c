/* What furrow rig found, and what was measured, as a CSV and for python/furrow/plot.py. */
#ifndef FURROW_TOOLS_RIG_TABLE_H
#define FURROW_TOOLS_RIG_TABLE_H

#include <stdio.h>

#include "trials/trials.h"

#define RIG_MEASURED_MOST 4096

/* A measured trial. NaN: the file does not have it. */
struct rig_measured {
	double slip, sinkage, drawbar, side, torque; /* 1, m, N, N, N m */
	double angle;                                /* degrees: the slip angle; 0 where the file has none */
};

struct rig_table {
	const struct rig_params *params;
	const char *const *soils; /* what each of the params' soils is called */
	struct rig_found found;
	struct rig_row *rows;
	size_t count;
	struct rig_measured *measured;
	size_t measured_count;
};

/* Reads a table of comma-separated values with a line of names: slip, and some of sinkage (m) or sinkage_mm, drawbar or drawbar_N or
 * drag_N (the drawbar, negative), side or side_N or lateral_N, torque or torque_Nm, and slip_angle_deg. */
enum status rig_measured_read(const char *path, struct rig_measured **out, size_t *count) FURROW_CHECKED;

void rig_csv_write(const struct rig_table *table, FILE *file);
/* rig_lists.c: numbers and ranges of an option, parted by commas. otherwise: what it is where it is not given; NULL: none. */
struct arguments;
enum status rig_list_read(const struct arguments *arguments, const char *option, const char *otherwise, double *list, size_t *count) FURROW_CHECKED;

/* rig_told.c: all rows on stdout. */
void rig_told_print(const struct rig_table *table);
enum status rig_told_json(const struct rig_table *table) FURROW_CHECKED;
/* What rig.svg is drawn from: the same rows as JSON, with the measured trials. The caller deletes it. NULL: out of memory. */
struct cJSON *rig_told_plan(const struct rig_table *table);

bool rig_has_slip(const struct rig_table *table);          /* a wheel or a belt */
bool rig_same_angle(double a, double b);                     /* degrees: those of one setting */
bool rig_is_turned(const struct rig_params *params);       /* some angle is not 0 */
double rig_angle(const struct rig_params *params, size_t angle); /* degrees */

/* The numbers of a row, as columns of rig.csv and keys of the JSON. NaN: there is none. */
enum { RIG_COLUMNS = 18 };
struct rig_column {
	const char *name;
	double value;
};
void rig_columns(const struct rig_params *params, const struct rig_row *row, struct rig_column columns[RIG_COLUMNS]);

/* A figure of a row: 0 sinkage in mm, 1 drawbar, 2 side force, 3 torque, 4 efficiency, 5 force against the way. */
double rig_figure(const struct rig_row *row, int figure);
double rig_measured_figure(const struct rig_measured *measured, int figure);
#define RIG_FIGURES 6
/* Root mean square of the differences between what was measured and one curve, between its first and last slip. NaN: they have no
 * slip in common. */
double rig_difference(const struct rig_table *table, size_t soil, size_t load, size_t angle, int figure);

#endif
