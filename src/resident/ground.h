/*
 * The base as the lattice has it, on the CPU: decoded tiles of levels >= 0, the last used of them kept. For the
 * page loaders (one each), for resting objects on the ground, and for bounds to cull by.
 *
 * A ground has one owner, the thread that calls all of this but the last few functions. With those others bring
 * what the owner will ask for: they change when a tile is read, never what is found. What is not there the owner
 * reads itself, and waits.
 */
#ifndef FURROW_RUN_GROUND_H
#define FURROW_RUN_GROUND_H

#include "base/base.h"
#include "store/store.h"

struct ground;

/* Keeps up to `tiles` decoded tiles, at least 1, of (cells + 1)^2 int32 each, and one more for each thread that
 * warms it. The store must outlive it. */
enum status ground_create(struct store *store, uint32_t tiles, struct ground **out) FURROW_CHECKED;
void ground_destroy(struct ground *ground);
struct store_reader *ground_reader(struct ground *ground);
int32_t ground_reference(const struct store *store); /* metres, of all bases of this store */

/* Copies the (cells + 1)^2 posts, relative to the reference. level >= 0. */
enum status ground_posts(struct ground *ground, struct tile tile, int32_t *posts) FURROW_CHECKED;
/* The arguments of lattice_subdivide for a tile below level 0. `patch`: room for (cells + 1)^2. */
enum status ground_patch(struct ground *ground, struct tile tile, int32_t *patch, int *shift, uint32_t *sub_x,
			 uint32_t *sub_y) FURROW_CHECKED;
/* Lowest and highest base of the tile's subtree, metres; *any false if all is nodata. */
enum status ground_range(struct ground *ground, struct tile tile, double *low, double *high, bool *any)
	FURROW_CHECKED;
/* What the store keeps of a tile from level 0 up, and of the offsets of any: read each time, and counted. The owner's. */
enum status ground_base_range(struct ground *ground, struct tile tile, struct store_range *range) FURROW_CHECKED;
enum status ground_offset_range(struct ground *ground, struct tile tile, double *low, double *high, bool *found)
	FURROW_CHECKED;
/* No post of the rectangle, of any level, has a higher base than this, 2^-18 m from the reference. Below level 0 that is the
 * highest of the posts of level 0 they are interpolated from, else their own highest. *any false: none has data. */
enum status ground_highest(struct ground *ground, int level, struct post_rect rect, int32_t *highest, bool *any)
	FURROW_CHECKED;
/* Height at a point (quanta of 2^-20 m, local, absolute height), bilinear in the level-0 cell.
 * *any false outside the world and where a corner with weight is nodata. */
enum status ground_height(struct ground *ground, int64_t x, int64_t y, int64_t *height, bool *any)
	FURROW_CHECKED;

/* --- any thread --- */

struct ground_figures {
	uint64_t reads, waits; /* tiles read by whoever, and those of them that the owner read itself */
	uint64_t ranges;       /* of bases, read without a tile */
	uint64_t offset_ranges;
	double wait_ms;
};
void ground_figures(struct ground *ground, struct ground_figures *figures);
/* The level-0 tile whose posts a height at (x, y), in posts of level 0, comes from. Within the world only. */
struct tile ground_tile(const struct extent *extent, double x, double y);
/* Whether it is there; if so it is kept as one just used. */
bool ground_touch(struct ground *ground, struct tile tile);
/* Puts a tile there, read with the caller's own reader and without holding the owner up. In its place goes the one
 * used longest ago, never the owner's last. On failure nothing changed. */
enum status ground_warm(struct ground *ground, struct store_reader *reader, struct tile tile) FURROW_CHECKED;

#endif
