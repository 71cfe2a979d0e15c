/* Tables in text files that a scene names: a header, then rows of numbers in columns with commas between. */
#ifndef FURROW_VEHICLE_TABLE_H
#define FURROW_VEHICLE_TABLE_H

#include <stdbool.h>
#include <stdio.h>

#include "base/status.h"

#define TABLE_LINE 16384 /* bytes of a line that there is room for, with its end */

struct vehicle_table {
	FILE *file;
	const char *where, *key, *path; /* the vehicle, its key in the scene, the file; not owned */
	size_t most;                    /* bytes of a line that are read, at most TABLE_LINE */
	int line;                       /* of the last read one, from 1; 0: none yet */
	char text[TABLE_LINE];          /* the last read line, without its end */
};

/* Opens a table that has where, key, path and most set. Close it if this is STATUS_OK. */
enum status vehicle_table_open(struct vehicle_table *table) FURROW_CHECKED;
void vehicle_table_close(struct vehicle_table *table);
/* Reads the next line that is not empty. *any: there was one. */
enum status vehicle_table_next(struct vehicle_table *table, bool *any) FURROW_CHECKED;
/* Reads a field as a number of at most 1e12 in size. */
enum status vehicle_table_number(const struct vehicle_table *table, const char *field, double *number) FURROW_CHECKED;
/* Fails: tells file, line, what is wrong with it, and what is allowed. */
enum status vehicle_table_wrong(const struct vehicle_table *table, const char *what, const char *allowed) FURROW_CHECKED;

#endif
