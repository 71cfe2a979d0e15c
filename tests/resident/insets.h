/*
 * A terrain with two insets, one within the other, and its base by a second way: each post by a formula of its own place, in
 * rational numbers of 128 bits. Include after support.h.
 */
#ifndef FURROW_TESTS_RESIDENT_INSETS_H
#define FURROW_TESTS_RESIDENT_INSETS_H

#include "resident/resident.h"

#define INSETS_FINEST (-4)
#define INSETS_STEP (1.0 / 1024)
#define INSETS_UNITS (1 << (BASE_BITS - 10)) /* of the lattice in a step */

static const struct extent insets_extent = {65, 49, 4, 0}; /* without its cells */

static bool insets_between(int64_t v, int64_t low, int64_t high)
{
	return v >= low && v <= high;
}

/* Places are counted in posts of the finest level. The outer inset is a square with a hole, of whole cells of level 0; the inner
 * one is of whole cells of the outer one. */
static bool insets_outer(int64_t x, int64_t y)
{
	bool hole = x > 14 * 16 && x < 18 * 16 && y > 20 * 16 && y < 24 * 16;
	return insets_between(x, 10 * 16, 26 * 16) && insets_between(y, 12 * 16, 30 * 16) && !hole;
}

static bool insets_inner(int64_t x, int64_t y)
{
	return insets_between(x, 75 * 4, 93 * 4) && insets_between(y, 70 * 4, 79 * 4);
}

/* Returns the code of a post that is stored. *stored: false if it is not. */
static int32_t insets_code(int level, int64_t x, int64_t y, bool *stored)
{
	*stored = false;
	if (level < INSETS_FINEST)
		return HEIGHT_CODE_NODATA;
	const int64_t fine_x = x << (level - INSETS_FINEST), fine_y = y << (level - INSETS_FINEST);
	const uint32_t noise = (uint32_t)(fine_x * 7919 + fine_y * 104729) * 2654435761u >> 24;
	const bool inner = insets_inner(fine_x, fine_y), outer = level >= -2 && insets_outer(fine_x, fine_y);
	*stored = inner || outer || level >= 0;
	const int32_t hills = (int32_t)(90000 + llabs(fine_x % 1200 - 600) * 60 - llabs(fine_y % 900 - 450) * (20 + fine_x % 7));
	if (!inner && !outer && insets_between(fine_x, 40 * 16, 42 * 16) && insets_between(fine_y, 8 * 16, 11 * 16))
		return HEIGHT_CODE_NODATA;
	return hills + (inner ? 3000 + (int32_t)noise : outer ? -2000 + (int32_t)noise * 2 : 0);
}

/* Returns the base of any post on the lattice, from reference 0; BASE_NODATA: none. */
static inline int32_t insets_base(int level, int64_t x, int64_t y)
{
	for (int from = level; from <= 0; from++) {
		const int64_t cell = (int64_t)1 << (from - level), part_x = x % cell, part_y = y % cell;
		int64_t sum = 0, whole = cell * cell;
		bool all = true;
		for (int i = 0; i < 4; i++) {
			const int64_t weight = (i % 2 ? part_x : cell - part_x) * (i / 2 ? part_y : cell - part_y);
			bool stored = true;
			const int32_t code = weight != 0 ? insets_code(from, x / cell + i % 2, y / cell + i / 2, &stored) : 0;
			all = all && stored && code != HEIGHT_CODE_NODATA;
			sum += (int64_t)code * INSETS_UNITS * weight;
		}
		if (!all)
			continue;
		int64_t twice = 2 * sum + whole, rounded = twice / (2 * whole); /* halves up; heights are above 0 */
		return (int32_t)rounded;
	}
	return BASE_NODATA;
}

static bool insets_within(int level, int64_t x, int64_t y)
{
	return x < extent_posts(insets_extent.width, level) && y < extent_posts(insets_extent.height, level);
}

/* Fills a tile with what is stored of it. Returns false if that is nothing. */
static bool insets_tile(const struct extent *extent, struct tile tile, int32_t *codes, struct store_range *range)
{
	const int64_t n = extent->cells;
	bool any = tile.level >= 0;
	for (int64_t y = 0; y <= n; y++)
		for (int64_t x = 0; x <= n; x++) {
			bool stored = false;
			int32_t code = HEIGHT_CODE_NODATA;
			if (insets_within(tile.level, tile.x * n + x, tile.y * n + y))
				code = insets_code(tile.level, tile.x * n + x, tile.y * n + y, &stored);
			codes[y * (n + 1) + x] = stored ? code : HEIGHT_CODE_NODATA;
			any |= stored;
		}
	*range = (struct store_range){(double)NAN, (double)NAN, 0};
	const int64_t scale = (int64_t)1 << (tile.level - INSETS_FINEST);
	for (int64_t y = tile.y * n * scale; any && y <= (tile.y + 1) * n * scale; y++)
		for (int64_t x = tile.x * n * scale; x <= (tile.x + 1) * n * scale; x++) {
			bool stored = false;
			int32_t code = HEIGHT_CODE_NODATA;
			/* the coarsest level that has this place, down from the tile's own */
			for (int level = tile.level; level >= INSETS_FINEST && !stored; level--) {
				const int64_t cell = (int64_t)1 << (level - INSETS_FINEST);
				if (x % cell == 0 && y % cell == 0 && insets_within(level, x / cell, y / cell))
					code = insets_code(level, x / cell, y / cell, &stored);
			}
			if (!stored || code == HEIGHT_CODE_NODATA)
				continue;
			range->low = fmin(range->low, code * INSETS_STEP);
			range->high = fmax(range->high, code * INSETS_STEP);
		}
	return any;
}

/* What the store says of its insets, as import does. */
#define INSETS_TEXT "-2 40 48 65 73 outer\n-4 300 280 73 37 inner\n"
static const char *insets_told; /* NULL: nothing */

/* Makes the store of this group of tests once. Returns its path, valid until the next call. */
static const char *insets_store(uint32_t cells)
{
	char name[32];
	snprintf(name, sizeof name, "insets-%u%s.furrow", cells, insets_told != NULL ? "-told" : "");
	const char *path = support_path(name);
	if (access(path, R_OK) == 0)
		return path;
	struct store_meta meta = {.extent = insets_extent, .step = INSETS_STEP, .max_error = INSETS_STEP / 2, .srs = "", .vertical = "",
				  .sources = "a formula", .insets = insets_told};
	struct store *store;
	int32_t *codes = malloc(sizeof *codes * (cells + 1) * (cells + 1));
	meta.extent.cells = cells;
	must(store_create(path, &meta, true, &store));
	for (int level = INSETS_FINEST; level <= extent_coarsest(&meta.extent); level++)
		for (uint32_t y = 0; y < extent_tiles_y(&meta.extent, level); y++)
			for (uint32_t x = 0; x < extent_tiles_x(&meta.extent, level); x++) {
				struct store_range range;
				if (insets_tile(&meta.extent, (struct tile){level, x, y}, codes, &range))
					must(store_put_base(store, (struct tile){level, x, y}, codes, &range));
			}
	must(store_publish(store));
	store_close(store);
	free(codes);
	return path;
}

#endif
