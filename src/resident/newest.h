/*
 * The ground as it is now, for queries (terrain/terrain.h): the base, and the newest offsets of a tile, wherever those are:
 * in a slot, in the queue of what is to be committed, or in the store.
 *
 * Over a running drive: on the drive's thread, between two steps. It reads and changes nothing else: it pins, loads and uses
 * no page, has its own reader of the store and its own tiles, so that a drive gives the same bits however it is asked. Over a
 * store alone: any one thread, without GL; what another process commits meanwhile may or may not be seen.
 *
 * What is asked is kept, bounded: some 32 MB of tiles, or 4, and ranges. A tile that is dirty in its slot is read from there,
 * which on a real GPU waits for all work that was begun before; once a tile until the ground changes, however much is asked.
 */
#ifndef FURROW_RUN_NEWEST_H
#define FURROW_RUN_NEWEST_H

#include "page/page.h"
#include "gpu/gpu.h"
#include "store/store.h"
#include "terrain/terrain.h"

struct newest;
struct world;

/* `drive` NULL: the store alone. Both must outlive it. */
enum status newest_create(struct store *store, const struct world *world, struct newest **out) FURROW_CHECKED;
void newest_destroy(struct newest *newest); /* takes NULL */
/* The drive's ground is not as it was when last asked: within a step, too. Takes NULL. */
void newest_changed(struct newest *newest);
enum status newest_heights(struct newest *newest, const struct terrain_point *points, size_t count, struct terrain_height *heights)
	FURROW_CHECKED;
enum status newest_rays(struct newest *newest, const struct terrain_ray *rays, size_t count, struct terrain_hit *hits) FURROW_CHECKED;

#endif
