/* Parts of intake_import_open. */
#ifndef FURROW_INTAKE_INTERNAL_H
#define FURROW_INTAKE_INTERNAL_H

#include "intake/intake.h"

/* --- census.c --- */

/* Counts heights, m; NaN is none. */
void intake_census_add(struct census *census, const double *heights, int64_t count);
/* Tells whether the lowest height, or the highest one, is probably an undeclared hole. *height gets it, m. */
bool intake_census_find(const struct census *census, bool low, double *height);

/* --- options.c --- */

/* STATUS_USAGE: an option was set that would not count, or that contradicts another. `alone`: only imagery is imported. */
enum status intake_import_check_options(const struct import *import, bool alone) FURROW_CHECKED;

/* --- imagery.c --- */

/* As intake_import_imagery(), with the options of heights, which counted for the store that was made. */
enum status intake_imagery_add(const struct import *import, const char *store, bool dry, dem_progress_fn progress, void *user,
			       struct intake_imagery *out) FURROW_CHECKED;

/* --- imagery_rows.c: rows of pixels to tiles of all levels --- */

/*
 * Takes the rows of the finest level from the south. Of each it makes half a row of the level above: three rows and three columns smoothed by
 * 1 2 1, every second pixel. So a level depends on no tile. When all pixels of a row of tiles are there, the members of a
 * crew pack them. They are put into the store in the order of x. Memory: about cells + 9 rows of the finest level, twice.
 */
struct imagery_rows;
enum status intake_imagery_rows_create(struct store *store, int finest, int quality, int64_t jobs, struct imagery_rows **out) FURROW_CHECKED;
void intake_imagery_rows_destroy(struct imagery_rows *rows); /* rows may be NULL */
/* `pixels`: 4 bytes for each post of the level's width. */
enum status intake_imagery_rows_put(struct imagery_rows *rows, const uint8_t *pixels) FURROW_CHECKED;
int64_t intake_imagery_rows_kept(const struct imagery_rows *rows); /* tiles that the store had already */

/* --- */

/* Opens the insets, and sets the step of heights by the finest of all. STATUS_INPUT: an inset cannot be used. */
enum status intake_import_open_insets(struct import *import) FURROW_CHECKED;
/* Fills meta.sources, meta.insets and meta.request. The import owns the texts. Fails only when memory runs out. */
enum status intake_import_describe(struct import *import) FURROW_CHECKED;

#endif
