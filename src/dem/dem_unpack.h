/* Used inside dem only, in a build with GDAL. Unpacks a source that is packed with xz, so that GDAL can read it. */
#ifndef FURROW_DEM_UNPACK_H
#define FURROW_DEM_UNPACK_H

#include "dem_scratch.h"

/* Bytes that a packed file may unpack to; more is refused. The largest .hgt tiles have 7201 x 7201 posts. */
#define DEM_UNPACK_MOST (INT64_C(1) << 30)
#define DEM_UNPACK_MOST_HGT (INT64_C(128) << 20)

struct dem_unpacked {
	struct dem_scratch scratch; /* the unpacked bytes */
	char *name; /* under which GDAL opens them: it ends as the packed file does without ".xz"; NULL: none */
};

bool dem_unpack_is_packed(const char *path);
/* Unpacks the file at `path` into a temporary file. STATUS_INPUT: it is no whole xz file, or too large. dem_unpack_finish is due
 * also after a failure. */
enum status dem_unpack_init(struct dem_unpacked *unpacked, const char *path) FURROW_CHECKED;
void dem_unpack_finish(struct dem_unpacked *unpacked); /* closes and forgets the temporary file, if there is one */

#endif
