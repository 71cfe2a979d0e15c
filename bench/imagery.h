/* Imagery for benches: pixels of random colours at the posts of level 0 and of all coarser levels. */
#ifndef FURROW_BENCH_IMAGERY_H
#define FURROW_BENCH_IMAGERY_H

#include "bench.h"
#include "store/store.h"

/* Returns a colour from the place of a post of level 0: patches of 16 posts, and grain. */
static inline uint32_t bench_imagery_colour(uint64_t x, uint64_t y)
{
	const uint64_t patch = (x / 16 * 0x9e3779b97f4a7c15ull + y / 16) * 0xbf58476d1ce4e5b9ull >> 40;
	const uint64_t grain = (x * 0x9e3779b97f4a7c15ull ^ y) * 0xbf58476d1ce4e5b9ull >> 60;
	const uint32_t red = 90 + (patch & 63), green = 90 + (patch >> 8 & 63), blue = 60 + (patch >> 16 & 31);
	return (red + (uint32_t)grain) | (green + (uint32_t)grain) << 8 | (blue + (uint32_t)grain) << 16 | 0xff000000u;
}

static inline void bench_imagery(const char *path)
{
	struct store *store;
	int64_t tiles;
	bench_must(store_open(path, &(struct store_options){.mode = STORE_WRITE}, &store));
	bench_must(store_imagery_begin(store, &(struct store_imagery_making){.finest = 0, .quality = 85, .sources = "bench\n", .request = "bench"}, &tiles));
	const struct extent *extent = &store_meta(store)->extent;
	const uint32_t side = extent->cells + 1;
	uint32_t *pixels = mem_alloc((size_t)side * side, sizeof *pixels);
	for (int level = extent_coarsest(extent); level >= 0; level--)
		for (struct tile tile = {level, 0, 0}; extent_has(extent, tile); tile.x = 0, tile.y++)
			for (; extent_has(extent, tile); tile.x++) {
				void *packed;
				size_t size;
				for (uint32_t y = 0; y < side; y++)
					for (uint32_t x = 0; x < side; x++)
						pixels[y * side + x] = bench_imagery_colour(((uint64_t)tile.x * extent->cells + x) << level, ((uint64_t)tile.y * extent->cells + y) << level);
				bench_must(store_imagery_pack((const uint8_t *)pixels, side, 85, &packed, &size));
				bench_must(store_imagery_put(store, tile, packed, size));
				mem_free(packed);
			}
	mem_free(pixels);
	bench_must(store_imagery_finish(store));
	store_close(store);
}

#endif
