/*
 * Tiles from the thread that cuts them to the store: packed by several threads at once, stored in the
 * order they were cut in.
 */
#ifndef FURROW_API_CONVEYOR_H
#define FURROW_API_CONVEYOR_H

#include "dem/dem.h"
#include "store/store.h"

struct conveyor;

/*
 * `jobs` threads pack beside the one that cuts; with 1 that one does it all. The first `stored` tiles
 * are in the store already and are let pass. From now on only the conveyor uses the store, until
 * api_conveyor_finish.
 */
enum status api_conveyor_create(struct store *store, int64_t jobs, int64_t stored, struct conveyor **out)
	FURROW_CHECKED;
/* A dem_tile_fn: copies the tile; waits while all buffers are full. A failure of another thread comes
 * back here. */
enum status api_conveyor_put(void *conveyor, const struct dem_tile *tile) FURROW_CHECKED;
/* A dem_known_fn: the tiles that are stored. */
enum status api_conveyor_known(void *conveyor, struct tile tile, int32_t *codes, bool *known) FURROW_CHECKED;
/* Waits until everything is stored; destroys it. */
enum status api_conveyor_finish(struct conveyor *conveyor) FURROW_CHECKED;

#endif
