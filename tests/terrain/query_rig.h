/* What the tests of queries share: a small rough ground with holes and finer tiles here and there, and every triangle of it. */
#ifndef FURROW_TESTS_TERRAIN_QUERY_RIG_H
#define FURROW_TESTS_TERRAIN_QUERY_RIG_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "terrain/terrain.h"

enum { RIG_CELLS_MOST = 32 };

struct rig {
	struct extent extent;
	uint64_t seed;
	int finest;
	unsigned holes;         /* posts of level 0 in 1,000 that are nodata */
	unsigned fine;          /* tiles of the finest level in 100 that are there */
	double relief, rut;     /* metres */
	double crack;           /* metres: the finest tiles stand so much higher, at their edges too */
	int64_t far;            /* posts from the south-west one to the one that is as post 0 is elsewhere */
	struct terrain_ground ground;
	double heights[(RIG_CELLS_MOST + 1) * (RIG_CELLS_MOST + 1)], blocks[16][2];
	uint64_t reads;         /* posts asked for */
	uint64_t fails_at;      /* the posts asked for that fail; 0: none */
};

static inline uint64_t rig_mix(uint64_t v)
{
	v = (v ^ v >> 31) * 0x7fb5d329728ea185ull;
	v = (v ^ v >> 27) * 0x81dadef4bc2dd44dull;
	return v ^ v >> 33;
}

static inline double rig_unit(uint64_t *state)
{
	*state = rig_mix(*state + 0x9e3779b97f4a7c15ull);
	return (double)(*state >> 11) * 0x1p-53;
}

static inline double rig_between(uint64_t *state, double low, double high)
{
	return low + rig_unit(state) * (high - low);
}

/* Of level 0, in 2^-18 m; NaN: a hole. */
static inline double rig_post(const struct rig *rig, int64_t x, int64_t y)
{
	if (x >= rig->extent.width || y >= rig->extent.height)
		return NAN;
	uint64_t hash = rig_mix((uint64_t)(x - rig->far) * 0x10001 + rig_mix((uint64_t)(y - rig->far) + rig->seed));
	if (hash % 1000 < rig->holes)
		return NAN;
	double wave = sin((double)(x - rig->far) / 7) * cos((double)(y - rig->far) / 5);
	double height = rig->relief * (wave + (double)(hash >> 20 & 1023) / 2048);
	return floor(height * 0x1p18) * 0x1p-18;
}

static inline bool rig_present(const struct rig *rig, struct tile tile)
{
	if (!extent_has(&rig->extent, tile))
		return false;
	if (tile.level == rig->finest)
		return rig_mix(tile_key(tile) + rig->seed) % 100 < rig->fine;
	for (unsigned i = 0; i < 4; i++)
		if (rig_present(rig, (struct tile){tile.level - 1, 2 * tile.x + (i & 1), 2 * tile.y + (i >> 1)}))
			return true;
	return false;
}

/* Bilinear without rounding: of dyadic posts it is exact. A post of the finest level has an offset if every tile that has the
 * post is there. */
static inline double rig_height(const struct rig *rig, int level, int64_t x, int64_t y)
{
	int shift = -level;
	int64_t part = ((int64_t)1 << shift) - 1, cx = x >> shift, cy = y >> shift;
	double u = ldexp((double)(x & part), level), v = ldexp((double)(y & part), level), height = 0;
	const double weights[4] = {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
	for (int i = 0; i < 4; i++)
		if (weights[i] != 0)
			height += weights[i] * rig_post(rig, cx + i % 2, cy + i / 2);
	if (level != rig->finest || level == 0)
		return height;
	int64_t cells = rig->extent.cells;
	height += rig->crack;
	for (int i = 0; i < 4; i++) {
		int64_t tx = x / cells - (i % 2 && x % cells == 0), ty = y / cells - (i / 2 && y % cells == 0);
		if (tx < 0 || ty < 0)
			continue;
		struct tile tile = {level, (uint32_t)tx, (uint32_t)ty};
		if (extent_has(&rig->extent, tile) && !rig_present(rig, tile))
			return height;
	}
	uint64_t hash = rig_mix((uint64_t)x + rig_mix((uint64_t)y * 3 + rig->seed));
	return height - floor(rig->rut * (double)(hash >> 40 & 255) / 255 * 0x1p20) * 0x1p-20;
}

static inline enum status rig_posts(void *user, struct tile tile, struct terrain_posts *posts)
{
	struct rig *rig = user;
	int64_t cells = rig->extent.cells;
	assert_true(extent_has(&rig->extent, tile) && tile.level <= 0 && tile.level >= rig->finest);
	if (++rig->reads == rig->fails_at)
		return fail_with(STATUS_INPUT, "rig: it is broken; mend it");
	for (int64_t y = 0; y <= cells; y++)
		for (int64_t x = 0; x <= cells; x++)
			rig->heights[y * (cells + 1) + x] = rig_height(rig, tile.level, tile.x * cells + x, tile.y * cells + y);
	terrain_fill_blocks(rig->extent.cells, rig->heights, rig->blocks);
	*posts = (struct terrain_posts){rig->heights, (const double(*)[2])rig->blocks};
	return STATUS_OK;
}

static inline enum status rig_ask(void *user, struct tile tile, bool *present)
{
	*present = rig_present(user, tile);
	return STATUS_OK;
}

static inline enum status rig_bounds(void *user, struct tile tile, double *low, double *high, bool *any)
{
	const struct rig *rig = user;
	assert_true(extent_has(&rig->extent, tile));
	/* True of a single post, at least, in every other tile: so that much is passed over. */
	*low = -rig->relief - rig->rut;
	*high = 1.5 * rig->relief + rig->crack;
	*any = true;
	if (tile.level > 0)
		return STATUS_OK;
	double least = INFINITY, most = -INFINITY;
	int64_t side = rig->extent.cells >> -tile.level, cells = rig->extent.cells;
	side = side > 0 ? side : 1;
	int64_t x0 = (tile.x * cells) >> -tile.level, y0 = (tile.y * cells) >> -tile.level;
	for (int64_t y = y0; y <= y0 + side; y++)
		for (int64_t x = x0; x <= x0 + side; x++) {
			double height = rig_post(rig, x, y);
			least = height < least ? height : least;
			most = height > most ? height : most;
		}
	*any = least <= most;
	*low = least - rig->rut;
	*high = most + rig->crack;
	return STATUS_OK;
}

static inline void rig_open(struct rig *rig)
{
	rig->ground = (struct terrain_ground){rig, &rig->extent, rig->finest, rig_posts, rig_ask, rig_bounds};
}

struct rig_triangle {
	double corner[3][3];
	int level;
};

/* All of the ground: those that have no hole, in the finest tile there. */
static inline size_t rig_triangles(const struct rig *rig, struct rig_triangle **out)
{
	size_t count = 0, room = 1 << 16;
	struct rig_triangle *all = malloc(room * sizeof *all);
	int64_t across = (rig->extent.width - 1) << -rig->finest, up = (rig->extent.height - 1) << -rig->finest;
	assert_non_null(all);
	for (int level = 0; level >= rig->finest; level--) {
		int64_t width = across >> (level - rig->finest), height = up >> (level - rig->finest), cells = rig->extent.cells;
		double spacing = extent_spacing(&rig->extent, level);
		for (int64_t y = 0; y < height; y++)
			for (int64_t x = 0; x < width; x++) {
				struct tile own = {level, (uint32_t)(x / cells), (uint32_t)(y / cells)};
				struct tile below = {level - 1, (uint32_t)(2 * x / cells), (uint32_t)(2 * y / cells)};
				if ((level < 0 && !rig_present(rig, own)) || (level > rig->finest && rig_present(rig, below)))
					continue;
				for (int upper = 0; upper < 2; upper++) {
					const int64_t corners[3][2] = {{x, y}, {x + !upper, y + upper}, {x + 1, y + 1}};
					struct rig_triangle triangle = {.level = level};
					for (int i = 0; i < 3; i++) {
						triangle.corner[i][0] = (double)corners[i][0] * spacing;
						triangle.corner[i][1] = (double)corners[i][1] * spacing;
						triangle.corner[i][2] = rig_height(rig, level, corners[i][0], corners[i][1]);
					}
					if (isnan(triangle.corner[0][2] + triangle.corner[1][2] + triangle.corner[2][2]))
						continue;
					if (count == room)
						assert_non_null(all = realloc(all, (room *= 2) * sizeof *all));
					all[count++] = triangle;
				}
			}
	}
	*out = all;
	return count;
}

#endif
