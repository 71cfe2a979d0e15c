/* Places as people give them: in a reference system, or in metres from the south-west post. */
#ifndef FURROW_TOOLS_PLACE_H
#define FURROW_TOOLS_PLACE_H

#include "base/base.h"
#include "store/store.h"

/* Converts x and y from `srs` (as GDAL takes it, or "store": the store's own) to metres from the south-west post. NULL: they are. `command` and
 * `option` name who asks. STATUS_INPUT: the store has no reference system, or there is no way to it. */
enum status place_local(const struct store_meta *meta, const char *srs, const char *command, const char *option, double *x, double *y)
	FURROW_CHECKED;
/* Returns where the name of a WKT's system begins, and its length. NULL: it has none. */
const char *place_system(const char *wkt, int *length);

#endif
