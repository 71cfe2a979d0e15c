/* What import and info say about the errors of stored heights. */
#ifndef FURROW_TOOLS_ERRORS_H
#define FURROW_TOOLS_ERRORS_H

#include "json.h"
#include "store/store.h"

/* Prints two lines on stdout, each after `first` or `next`: off the resampled sources, and off the sources at their own posts. */
void print_errors(const struct store_meta *meta, const char *first, const char *next);
/* Tells on stdout what share of the posts has no height, if any has none. */
void print_holes(const struct store_meta *meta, const char *first);
/* Adds holes, max_error, off_resampled and off_source; the latter two are null if they were not measured. */
void errors_json(cJSON *object, const struct store_meta *meta);

#endif
