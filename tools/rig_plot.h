/* What furrow rig found, and what was measured, as a CSV and as an SVG. */
#ifndef FURROW_TOOLS_RIG_PLOT_H
#define FURROW_TOOLS_RIG_PLOT_H

#include <stdio.h>

#include "trials/trials.h"

#define RIG_MEASURED_MOST 4096

/* A measured trial. NaN: the file does not have it. */
struct rig_measured {
	double slip, sinkage, drawbar, torque; /* 1, m, N, N m */
};

struct rig_table {
	const struct rig_params *params;
	const char *const *soils; /* what each of the params' soils is called */
	struct rig_found found;
	struct rig_row *rows;
	size_t count;
	struct rig_measured *measured;
	size_t measured_count;
	const char *measured_name; /* path */
};

/* Reads a table of comma-separated values with a line of names: slip, and some of sinkage (m) or sinkage_mm, drawbar or drawbar_N or
 * drag_N (the drawbar, negative), torque or torque_Nm. Lines with a slip_angle_deg other than 0 are left out. */
enum status rig_measured_read(const char *path, struct rig_measured **out, size_t *count) FURROW_CHECKED;

void rig_csv_write(const struct rig_table *table, FILE *file);
void rig_plot_write(const struct rig_table *table, FILE *file);
/* A figure of a row: 0 sinkage in mm, 1 drawbar, 2 torque, 3 efficiency. */
double rig_figure(const struct rig_row *row, int figure);
double rig_measured_figure(const struct rig_measured *measured, int figure);
#define RIG_FIGURES 4
/* Root mean square of the differences between what was measured and one curve, between its first and last slip. NaN: they have no
 * slip in common. */
double rig_difference(const struct rig_table *table, size_t soil, size_t load, int figure);

#endif
