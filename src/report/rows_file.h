/* A file of rows, a line each, that begin with their time: objects.csv and vehicles.csv. */
#ifndef FURROW_REPORT_ROWS_FILE_H
#define FURROW_REPORT_ROWS_FILE_H

#include "report/report.h"

/*
 * Opens the file, empty for a new run. Of a resumed run's file it keeps the rows until where that run goes on, if its first line begins with
 * `header`. Else it writes that line, and sets *begins. `again`: the first step gives the rows of time 0 once more, so a run that goes on from there keeps
 * none. begins may be NULL. After a failure *file may be open.
 */
enum status report_rows_file_open(const struct world *world, const char *path, const char *header, bool again, FILE **file, bool *begins) FURROW_CHECKED;
/* Returns the failure to open or to read the file. errno tells why. */
enum status report_rows_file_failed(const char *path);

/* Tells where the file ends, when all its rows are written, and cuts it there. Returns false with errno. */
bool report_rows_file_end(FILE *file, int64_t *end);
bool report_rows_file_cut(FILE *file, int64_t end);

#endif
