/* furrow report's page: one HTML file that needs nothing beside it. */
#ifndef FURROW_TOOLS_HTML_REPORT_H
#define FURROW_TOOLS_HTML_REPORT_H

#include "html_cache.h"
#include "html_run.h"
#include "html_rut.h"

enum { HTML_RUNS = 8 };

struct html_report {
	struct html_run runs[HTML_RUNS];
	struct html_rut ruts[HTML_RUNS];
	struct html_cache caches[HTML_RUNS];
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
/* html_curves.c: */
enum status html_curves_write(const struct html_report *report) FURROW_CHECKED; /* ways, curves of objects and vehicles */
enum status html_curves_rut(const struct html_report *report) FURROW_CHECKED;
enum status html_curves_steps(const struct html_report *report) FURROW_CHECKED;
enum status html_curves_cache(const struct html_report *report) FURROW_CHECKED;
/* html_map.c: map.png of each folder, within the page. */
enum status html_map_write(const struct html_report *report) FURROW_CHECKED;

/* Pieces of the page. */
void html_section(const struct html_report *report, const char *id, const char *title);
void html_section_end(const struct html_report *report);
/* A paragraph of one sentence; with several runs it begins with the folder. */
void html_sentence(const struct html_report *report, const struct html_run *run, const char *text);
/* The head of a table: an empty cell, or `corner`, then the folders. */
void html_table(const struct html_report *report, const char *corner);
void html_table_end(const struct html_report *report);

#endif
