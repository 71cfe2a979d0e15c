/*
 * Tiles, levels and the world that they divide.
 *
 * x counts east, y counts north, both from 0 at the world's south-west post. A tile of level L holds (n + 1) x (n + 1) posts
 * and shares its edge posts with its neighbours. Level 0 has the source's spacing. Level +k has 2^k times the spacing; its
 * posts are every 2^k-th post. Level -k has 2^-k times the spacing.
 */
#ifndef FURROW_BASE_TILE_H
#define FURROW_BASE_TILE_H

#include <stdbool.h>
#include <stdint.h>

#define TILE_LEVEL_MIN (-14) /* 2 * 14 bits of interpolation weight fit the 64-bit formula */
#define TILE_LEVEL_MAX 28
#define TILE_CELLS_MIN 8
#define TILE_CELLS_MAX 1024

struct tile {
	int level;
	uint32_t x, y; /* each below 2^28 */
};

/* A tile, and the slot of the page cache that holds it. */
struct tile_slot {
	struct tile tile;
	uint32_t slot;
};

/* The terrain's size and tiling, which give tile keys their meaning. */
struct extent {
	int64_t width, height; /* posts at level 0, at least 2 each */
	double spacing;        /* metres between posts at level 0 */
	uint32_t cells;        /* N: cells along a tile's side, a power of two */
};

/* Returns the key of a tile, 62 bits, so never negative as int64. Upper 6 bits: level + 32. Lower 56 bits: x and y in Morton
 * order. All tiles of one level below a coarser tile have consecutive keys. */
uint64_t tile_key(struct tile tile);
struct tile tile_from_key(uint64_t key);
bool tile_equal(struct tile a, struct tile b);

/* Returns the tile that contains this one, at a coarser (or the same) level. */
struct tile tile_ancestor(struct tile tile, int level);
/* Returns where the tile begins within the tile that contains it at a coarser `level`. Counted in posts of the finer tile, east
 * (axis 0) or north (axis 1) of the coarser tile's first post. */
uint64_t tile_within(const struct extent *extent, struct tile tile, int level, int axis);
/* Gives the first and last key of the tiles below `tile` at a finer (or the same) `level`, both inclusive. */
void tile_descendants(struct tile tile, int level, uint64_t *first, uint64_t *last);

double extent_spacing(const struct extent *extent, int level);   /* metres */
int64_t extent_posts(int64_t posts, int level);                /* posts along a side that has `posts` posts at level 0 */
uint32_t extent_tiles_x(const struct extent *extent, int level); /* at least 1 */
uint32_t extent_tiles_y(const struct extent *extent, int level);
int extent_coarsest(const struct extent *extent); /* returns the finest level at which the world is one tile */
/* A spacing that was printed with six digits is off by half of this share of it, at most. */
#define SPACING_PRINTED 1e-5
/* Returns the coarsest level whose spacing is at most `spacing` metres, or more by less than SPACING_PRINTED of it. So a spacing that
 * was printed is the level that it was printed for. Returns TILE_LEVEL_MIN - 1 if there is none. */
int extent_level_for(const struct extent *extent, double spacing);
bool extent_has(const struct extent *extent, struct tile tile);
/* Returns NULL if this program can handle such a world. Otherwise returns the reason, a static text. */
const char *extent_problem(const struct extent *extent);

/* Returns the length of a side in metres, from its first to its last post. Axis 0: from west to east; 1: from south to north. */
static inline double extent_side(const struct extent *extent, int axis)
{
	return (double)((axis == 0 ? extent->width : extent->height) - 1) * extent->spacing;
}

/* Returns true if a place in local metres is on the terrain, its edges included. It may be a hole. */
static inline bool extent_holds(const struct extent *extent, double x, double y)
{
	return x >= 0 && y >= 0 && x <= extent_side(extent, 0) && y <= extent_side(extent, 1);
}

static inline uint32_t tile_posts(const struct extent *extent)
{
	return extent->cells + 1;
}

/* A rectangle of posts of one level: x0 <= x < x1. Empty if x1 <= x0 or y1 <= y0. */
struct post_rect {
	int64_t x0, y0, x1, y1;
};

struct post_rect post_rect_intersect(struct post_rect a, struct post_rect b);
struct post_rect post_rect_around(struct post_rect a, struct post_rect b); /* returns the smallest rectangle that contains both */
bool post_rect_empty(struct post_rect rect);
struct post_rect post_rect_joined(struct post_rect a, struct post_rect b); /* as post_rect_around, but one that is empty does not count */
struct post_rect post_rect_grown(struct post_rect rect, int64_t by);       /* by as many posts on each side */
/* Returns the rectangle of a tile's posts, shared edges included. */
struct post_rect tile_post_rect(const struct extent *extent, struct tile tile);
/* Gives the first and last tile of a level that have a post of `rect`, edges included. Returns false if there is none. */
bool tile_range_of(const struct extent *extent, int level, struct post_rect rect, struct tile *first,
		   struct tile *last);

#endif
