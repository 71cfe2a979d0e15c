/*
 * The base as the lattice has it, on the CPU: decoded tiles of levels >= 0, a few kept. For the page
 * loaders (one each), for resting objects on the ground, and for bounds to cull by. One thread each.
 */
#ifndef FURROW_RUN_GROUND_H
#define FURROW_RUN_GROUND_H

#include "base/base.h"
#include "store/store.h"

struct ground;

/* Keeps up to `tiles` decoded tiles. The store must outlive it. */
enum status ground_create(struct store *store, uint32_t tiles, struct ground **out) FURROW_CHECKED;
void ground_destroy(struct ground *ground);
struct store_reader *ground_reader(struct ground *ground);
int32_t ground_reference(const struct store *store); /* metres, of all bases of this store */

/* (cells + 1)^2 posts relative to the reference; valid until the next call. level >= 0. */
enum status ground_posts(struct ground *ground, struct tile tile, const int32_t **posts) FURROW_CHECKED;
/* The arguments of lattice_subdivide for a tile below level 0. `patch`: room for (cells + 1)^2. */
enum status ground_patch(struct ground *ground, struct tile tile, int32_t *patch, int *shift, uint32_t *sub_x,
			 uint32_t *sub_y) FURROW_CHECKED;
/* Lowest and highest base of the tile's subtree, metres; *any false if all is nodata. */
enum status ground_range(struct ground *ground, struct tile tile, double *low, double *high, bool *any)
	FURROW_CHECKED;
/* Height at a point (quanta of 2^-20 m, local, absolute height), bilinear in the level-0 cell.
 * *any false outside the world and where a corner with weight is nodata. */
enum status ground_height(struct ground *ground, int64_t x, int64_t y, int64_t *height, bool *any)
	FURROW_CHECKED;

#endif
