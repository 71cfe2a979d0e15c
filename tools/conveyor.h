/*
 * Tiles from the thread that cuts them to the one that codes and stores them, in order, through a
 * few buffers: the two halves of an import at once.
 */
#ifndef FURROW_TOOLS_CONVEYOR_H
#define FURROW_TOOLS_CONVEYOR_H

#include "dem/dem.h"
#include "store/store.h"

struct conveyor;

/* From now on only the conveyor's thread uses the store, until conveyor_finish. */
enum status conveyor_create(struct store *store, uint32_t cells, struct conveyor **out) FURROW_CHECKED;
/* A dem_tile_fn: copies the tile; waits while all buffers are full. A failure of the other thread
 * comes back here. */
enum status conveyor_put(void *conveyor, const struct dem_tile *tile) FURROW_CHECKED;
/* Waits until everything is stored; destroys it. */
enum status conveyor_finish(struct conveyor *conveyor) FURROW_CHECKED;

#endif
