/* furrow report's page: one HTML file that needs nothing beside it. */
#ifndef FURROW_TOOLS_HTML_REPORT_H
#define FURROW_TOOLS_HTML_REPORT_H

#include "html_cache.h"
#include "html_map.h"
#include "html_run.h"
#include "html_rut.h"

enum { HTML_RUNS = 8 };

struct html_report {
	struct html_run runs[HTML_RUNS];
	struct html_rut ruts[HTML_RUNS];
	struct html_cache caches[HTML_RUNS];
	struct html_map maps[HTML_RUNS];
	size_t count; /* of runs */
	FILE *file;
};

/* Writes the whole page. A write that fails is told by the file's own error. */
enum status html_report_write(const struct html_report *report) FURROW_CHECKED;

/* html_tables.c: */
void html_tables_run(const struct html_report *report);         /* what was run */
void html_tables_differences(const struct html_report *report); /* of two or more runs: settings that differ, */
void html_tables_settings(const struct html_report *report);    /* and all of them */
void html_tables_soils(const struct html_report *report);
void html_tables_results(const struct html_report *report);
void html_tables_volume(const struct html_report *report);
void html_tables_notes(const struct html_report *report);
/* html_means.c: means over the last quarter of the time, of objects and vehicles. */
void html_means_write(const struct html_report *report);
/* html_curves.c: */
bool html_any_slope(const struct html_report *report);          /* Whether grade resistance is a part of the traction somewhere */
enum status html_curves_write(const struct html_report *report) FURROW_CHECKED; /* ways, curves of objects and vehicles */
size_t html_bodies_most(const struct html_report *report);      /* bodies of a drive that plots show */
size_t html_drawn(const struct html_report *report, const struct html_bodies *bodies); /* how many of these they show */
struct html_line html_line_of(const struct html_report *report, size_t run, size_t body); /* its colour and dash */
void html_legend_begin(const struct html_report *report);
void html_legend_line(const struct html_report *report, const struct html_line *line, const char *folder, const char *name);
void html_legend_end(const struct html_report *report);
void html_legend_ways(const struct html_report *report);        /* of the ways that the map shows */
/* Gives the ends of the rut profile, as two x and two y, m. Returns false if there is none. */
bool html_profile(const struct html_report *report, size_t run, double ends[2][2]);
/* html_energy.c: where the energy went, as tables. */
void html_energy_objects(const struct html_report *report);
void html_energy_vehicles(const struct html_report *report);
/* html_drives.c: electric drives, engines and brakes. Nothing where there are none. */
void html_drives(const struct html_report *report);
/* html_digging.c: what bodies carried, how hard they cut, and their cycles. No section where nothing carries. */
enum status html_digging_write(const struct html_report *report) FURROW_CHECKED;
/* html_volume.c: volume over time. */
void html_volume_plot(const struct html_report *report);
/* html_figures.c: */
enum status html_curves_rut(const struct html_report *report) FURROW_CHECKED;
enum status html_curves_steps(const struct html_report *report) FURROW_CHECKED;
enum status html_curves_cache(const struct html_report *report) FURROW_CHECKED;
/* html_cameras.c: what cameras did, and their first and last pictures. */
enum status html_cameras_write(const struct html_report *report) FURROW_CHECKED;
/* html_map.c: the map of each drive. */
enum status html_map_write(const struct html_report *report) FURROW_CHECKED;

/* Pieces of the page. */
void html_section(const struct html_report *report, const char *id, const char *title);
void html_section_end(const struct html_report *report);
/* A paragraph of one sentence; with several runs it begins with the folder. */
void html_sentence(const struct html_report *report, const struct html_run *run, const char *text);
/* The head of a table: an empty cell, or `corner`, then the folders. */
void html_table(const struct html_report *report, const char *corner);
/* Begins a row with its name; a cell with a number, divided by `unit`, NaN: none. The value attribute has all digits. */
void html_row_head(const struct html_report *report, const char *text);
void html_number_cell(double value, double unit, FILE *file);
void html_table_end(const struct html_report *report);

#endif
