/* Places as people give them: in a reference system, or in metres from the south-west post. */
#ifndef FURROW_TOOLS_PLACE_H
#define FURROW_TOOLS_PLACE_H

#include "base/base.h"
#include "store/store.h"

/* Converts x and y from `srs` (as GDAL takes it, or "store": the store's own) to metres from the south-west post. NULL: they are. `command` and
 * `option` name who asks. STATUS_INPUT: the store has no reference system, or there is no way to it. */
enum status place_local(const struct store_meta *meta, const char *srs, const char *command, const char *option, double *x, double *y)
	FURROW_CHECKED;
/* Points that are outside the terrain, given in `srs` (as in place_local): returns true if one of them is inside when read otherwise, as
 * coordinates of the store's system, as degrees, or as degrees with the latitude first. Then writes a hint: as what, and which option says so.
 * At most PLACE_POINTS. */
#define PLACE_POINTS 81
bool place_guess(const struct store_meta *meta, const char *srs, const char *option, size_t count, const double *x, const double *y, char *hint,
		 size_t room);

#endif
