/* What the files newest*.c share. */
#ifndef FURROW_RESIDENT_NEWEST_INTERNAL_H
#define FURROW_RESIDENT_NEWEST_INTERNAL_H

#include "base/key_map.h"
#include "base/recent.h"
#include "resident/pages_internal.h"

struct resident_newest_tile {
	bool offsets;  /* any that is not 0 */
	double *heights, (*blocks)[2];
};

struct newest {
	struct store *store;
	struct pages *pages;       /* NULL: the store alone */
	const struct extent *extent;
	struct terrain_ground ground;
	struct ground *base;
	bool fits;                 /* on the lattice */
	bool deformed;             /* there is a level with offsets: */
	int level;
	bool settled;              /* the ground has not changed since the following was found */
	struct offset_bounds changed; /* tiles that may not be in the store, with infinite ranges */
	enum status noted;         /* of a callback that noted them */
	struct key_cache bases;    /* ranges of bases over the subtree; a: NaN: all is nodata */
	struct recent recent;
	struct resident_newest_tile *tiles; /* by place */
	int32_t *posts, *patch;    /* of one tile */
};

/* newest.c */
enum status resident_newest_settle(struct newest *newest) FURROW_CHECKED; /* before each query */

/* newest_tiles.c */
enum status resident_newest_create_tiles(struct newest *newest) FURROW_CHECKED;
void resident_newest_destroy_tiles(struct newest *newest);
/* Drops tiles with offsets: another step was made. */
void resident_newest_forget_tiles(struct newest *newest);
/* Reads a plane of a tile of the level with offsets, in the plane's own type; zeros if it is missing. `posts`: room for int32. */
enum status resident_newest_plane(struct newest *newest, struct tile tile, enum plane plane, void *posts) FURROW_CHECKED;
/* Finds a tile of level 0 or below; valid until the next one is asked for. */
enum status resident_newest_tile(struct newest *newest, struct tile tile, const struct resident_newest_tile **out) FURROW_CHECKED;

#endif
