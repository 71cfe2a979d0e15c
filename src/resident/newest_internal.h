/* What the files newest*.c share. */
#ifndef FURROW_RESIDENT_NEWEST_INTERNAL_H
#define FURROW_RESIDENT_NEWEST_INTERNAL_H

#include "base/key_map.h"
#include "base/recent.h"
#include "resident/pages_internal.h"

struct resident_newest_tile {
	bool offsets;  /* at least one offset is not 0 */
	double *heights, (*blocks)[2];
};

enum { NEWEST_BASES = 4 }; /* tiles whose base is kept */

struct newest {
	struct store *store;
	struct pages *pages;       /* NULL: only the store is read */
	const struct extent *extent;
	struct resident_source ground;
	struct ground *base;
	bool fits;                 /* the level is on the lattice */
	bool deformed;             /* there is a level with offsets, namely `level` */
	int level;
	bool settled;              /* true: the ground has not changed since the members below were filled */
	struct offset_bounds changed; /* tiles whose newest version may not be in the store; their ranges are infinite */
	enum status noted;         /* status of the callback that filled `changed` */
	struct key_cache bases;    /* ranges of bases over the tile and all finer tiles below it; a is NaN: all is nodata */
	struct recent recent;
	struct resident_newest_tile *tiles; /* by place number in `recent` */
	int32_t *posts, *patch;    /* scratch memory for one tile */
	struct recent recent_posts; /* heights of a tile are often made anew: offsets change with each step, the base never */
	int32_t *base_posts[NEWEST_BASES]; /* by place number in `recent_posts`: base posts of a tile; NULL: not made yet */
};

/* newest.c */
enum status resident_newest_settle(struct newest *newest) FURROW_CHECKED; /* before each query */

/* newest_tiles.c */
enum status resident_newest_create_tiles(struct newest *newest) FURROW_CHECKED;
void resident_newest_destroy_tiles(struct newest *newest);
/* Drops the tiles with offsets. Called after a step changed the ground. */
void resident_newest_forget_tiles(struct newest *newest);
/* Reads a plane of a tile, of the level with offsets, in the plane's own type. Zeros if the plane is missing. `posts`: room for
 * one int32 for each post. */
enum status resident_newest_plane(struct newest *newest, struct tile tile, enum plane plane, void *posts) FURROW_CHECKED;
/* Gives a tile of level 0 or below. It is valid until the next call. */
enum status resident_newest_tile(struct newest *newest, struct tile tile, const struct resident_newest_tile **out) FURROW_CHECKED;

#endif
