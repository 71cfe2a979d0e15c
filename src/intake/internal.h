/* Parts of intake_import_open. */
#ifndef FURROW_INTAKE_INTERNAL_H
#define FURROW_INTAKE_INTERNAL_H

#include "intake/intake.h"

/* --- census.c --- */

/* Counts heights, m; NaN is none. */
void intake_census_add(struct census *census, const double *heights, int64_t count);
/* Tells whether the lowest height, or the highest one, is probably an undeclared hole. *height gets it, m. */
bool intake_census_find(const struct census *census, bool low, double *height);

/* --- */

/* Opens the insets, and sets the step of heights by the finest of all. STATUS_INPUT: an inset cannot be used. */
enum status intake_import_open_insets(struct import *import) FURROW_CHECKED;
/* Fills meta.sources, meta.insets and meta.request. The import owns the texts. Fails only when memory runs out. */
enum status intake_import_describe(struct import *import) FURROW_CHECKED;

#endif
