/*
 * A plane in levels: the posts of a coarse grid first, then for each finer grid those between,
 * predicted from the coarser one.
 *
 * A grid of n cells has (n + 1)^2 posts, every (cells / n)-th of the plane. The coarsest has
 * LEVELS_TOP cells. A finer grid's residuals are three bands of rows:
 *
 *   1. the odd posts of the even rows, predicted along the row
 *   2. the posts of the odd rows but the last, predicted along their columns
 *   3. the last posts of the odd rows, as one row
 *
 * Blocks of LEVELS_BLOCK residuals share a width. A residual is in two's complement, and a block of
 * width w takes w bytes.
 */
#ifndef FURROW_STORE_CODEC_LEVELS_H
#define FURROW_STORE_CODEC_LEVELS_H

#include "store/codec_parts.h"

#define LEVELS_TOP 8   /* cells of the coarsest grid */
#define LEVELS_BLOCK 8 /* residuals that share a bit width */
#define LEVELS_TOP_POSTS ((LEVELS_TOP + 1) * (LEVELS_TOP + 1))
#define LEVELS_PAD 1 /* posts before and after a row of a coarser grid in scratch memory */

struct level_band {
	uint32_t rows, blocks; /* rows, and blocks of a row */
};

/* The bands of the grid of n cells, in the order of their residuals. Returns how many there are. */
static inline int level_bands(uint32_t n, struct level_band bands[3])
{
	if (n == LEVELS_TOP) {
		bands[0] = (struct level_band){1, (LEVELS_TOP_POSTS + LEVELS_BLOCK - 1) /
		                                          LEVELS_BLOCK};
		return 1;
	}
	bands[0] = (struct level_band){n / 2 + 1, n / 2 / LEVELS_BLOCK};
	bands[1] = (struct level_band){n / 2, n / LEVELS_BLOCK};
	bands[2] = (struct level_band){1, n / 2 / LEVELS_BLOCK};
	return 3;
}

/* The blocks of the grids of `from` to `to` cells. */
static inline size_t level_blocks(uint32_t from, uint32_t to)
{
	size_t blocks = 0;
	for (uint32_t n = from; n <= to; n *= 2) {
		struct level_band bands[3];
		for (int i = 0, count = level_bands(n, bands); i < count; i++)
			blocks += (size_t)bands[i].rows * bands[i].blocks;
	}
	return blocks;
}

/* A blob has two parts: the grids up to half the cells, and the finest one. A plane of LEVELS_TOP
 * cells has one part. */
static inline uint32_t level_half(uint32_t cells)
{
	return cells > LEVELS_TOP ? cells / 2 : cells;
}

static inline size_t level_stride(uint32_t n)
{
	return n + 1 + 2 * LEVELS_PAD;
}

/* int32 of all grids of less than n cells in scratch memory. */
static inline size_t level_room(uint32_t n)
{
	size_t room = 0;
	for (uint32_t m = LEVELS_TOP; m < n; m *= 2)
		room += (m + 1) * level_stride(m);
	return room;
}

/* The post between a and b. l is before a, r after b. Arithmetic is modulo 2^32. */
static inline int32_t level_between(int32_t l, int32_t a, int32_t b, int32_t r, bool cubic)
{
	uint32_t sum = (uint32_t)a + (uint32_t)b;
	if (!cubic)
		return (int32_t)(sum + 1) >> 1;
	return (int32_t)(9 * sum - ((uint32_t)l + (uint32_t)r) + 8) >> 4;
}

/* The post before a, where a, b and c are the first of a row: on the parabola through them. So is
 * the one after the last. */
static inline int32_t level_beyond(int32_t a, int32_t b, int32_t c)
{
	return (int32_t)(3 * ((uint32_t)a - (uint32_t)b) + (uint32_t)c);
}

/* A grid of n cells: its row y begins at posts + y * stride. */
struct level_grid {
	int32_t *posts;
	size_t stride;
};

/* Returns the grid of n cells in the codec's scratch memory. Its rows have LEVELS_PAD posts before
 * and after them. */
static inline struct level_grid level_scratch(const struct codec *codec, uint32_t n)
{
	return (struct level_grid){codec->grids + level_room(n) + LEVELS_PAD, level_stride(n)};
}

/* Sets the posts before and after each row of a grid of n cells in scratch memory. */
void store_level_pad(struct level_grid grid, uint32_t n);
/* Sets n + 1 posts of the row beyond a row at the edge. `next`: from that row to the next even one.
 */
void store_level_edge(const int32_t *first, ptrdiff_t next, uint32_t n, int32_t *edge);
/* Returns the four even rows around the odd row 2 * y + 1. `edges`: the row before the first one,
 * then the row after the last. */
void store_level_around(struct level_grid grid, uint32_t n, uint32_t y, const int32_t *edges,
                        const int32_t *rows[4]);

#endif
