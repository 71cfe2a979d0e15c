/* What the files newest*.c share. */
#ifndef FURROW_RUN_NEWEST_INTERNAL_H
#define FURROW_RUN_NEWEST_INTERNAL_H

#include "resident/ground.h"
#include "base/key_map.h"
#include "resident/newest.h"
#include "resident/pages.h"

struct newest_tile {
	uint64_t key;
	uint64_t used; /* by the clock; 0: empty */
	bool offsets;  /* any that is not 0 */
	double *heights, (*blocks)[2];
};

struct newest {
	struct store *store;
	const struct world *world; /* NULL: the store alone */
	const struct extent *extent;
	struct terrain_ground ground;
	struct ground *base;
	bool fits;                 /* on the lattice */
	bool deformed;             /* there is a level with offsets: */
	int level;
	bool settled;              /* the ground is as it was when what follows was found */
	uint64_t *changed;         /* keys of what may not be in the store, sorted */
	size_t changed_count, changed_room;
	bool lost;                 /* no memory for one of them */
	struct key_cache offsets;  /* ranges over the subtree; a: NaN where there are none. Of this moment */
	struct key_cache bases;    /* the same of the base, for good */
	struct newest_tile *tiles;
	size_t tile_count;
	uint64_t clock;
	int32_t *posts, *patch;    /* of one tile */
};

/* newest_tiles.c */
enum status newest_create_tiles(struct newest *newest) FURROW_CHECKED;
void newest_destroy_tiles(struct newest *newest);
/* Those with offsets are as they were: another step was done. */
void newest_forget_tiles(struct newest *newest);
/* A tile of level 0 or below; valid until another is asked for. */
enum status newest_tile(struct newest *newest, struct tile tile, const struct newest_tile **out) FURROW_CHECKED;

#endif
