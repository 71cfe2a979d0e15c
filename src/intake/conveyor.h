/*
 * A conveyor brings tiles of an import from the thread that cuts them into the store. Several threads pack the tiles. The tiles
 * are stored in the order in which they were cut.
 */
#ifndef FURROW_INTAKE_CONVEYOR_H
#define FURROW_INTAKE_CONVEYOR_H

#include "dem/dem.h"
#include "store/store.h"

struct conveyor;

/*
 * Makes a conveyor. `jobs` threads pack beside the thread that cuts; with 1 that thread does everything. The first `stored`
 * tiles are already in the store and are skipped. Until intake_conveyor_finish only the conveyor may use the store.
 */
enum status intake_conveyor_create(struct store *store, int64_t jobs, int64_t stored, struct conveyor **out)
	FURROW_CHECKED;
/* Gives a tile to the conveyor, which copies it. It is a dem_tile_fn (dem.h). Waits while all buffers are full. Returns also a
 * failure of another thread. */
enum status intake_conveyor_put(void *conveyor, const struct dem_tile *tile) FURROW_CHECKED;
bool intake_conveyor_has(const struct conveyor *conveyor); /* returns true if the next tile is in the store already */
/* Reads a tile that the store has already. It is a dem_known_fn (dem.h). */
enum status intake_conveyor_known(void *conveyor, struct tile tile, int32_t *codes, bool *known) FURROW_CHECKED;
/* Waits until all tiles that were put are stored. */
enum status intake_conveyor_settle(struct conveyor *conveyor) FURROW_CHECKED;
/* Reads a tile that is stored. *found is false if it is not. */
enum status intake_conveyor_get(struct conveyor *conveyor, struct tile tile, int32_t *codes, struct store_range *range, bool *found) FURROW_CHECKED;
/* Waits until everything is stored, then destroys the conveyor. */
enum status intake_conveyor_finish(struct conveyor *conveyor) FURROW_CHECKED;

#endif
