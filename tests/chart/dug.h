/* What tests of maps share: a store over level ground with ruts, a heap and a deep post, and what to ask a map raster for. No GL. */
#ifndef FURROW_TESTS_DUG_H
#define FURROW_TESTS_DUG_H

#include "../support.h"

#include "chart/internal.h"

#define LEVEL (-2)
#define CELLS 32

static const struct extent extent = {201, 150, 2, CELLS};
static struct store *store;
static struct store_reader *reader;

/* Metres at a post of the working level, half a metre apart: a rut one post wide with a rim, a broad one, a heap, one deep post. */
static inline double dug(int64_t x, int64_t y)
{
	if (x == 333 && y > 40)
		return -0.25;
	if (x == 334 && y > 40) /* its rim, higher than it is deep */
		return 0.28125;
	if (y == 596 && x < 4) /* beyond the last pixel's own half, at coarse levels */
		return 0.5;
	if (y == 0 || x == 800) /* at the terrain's edges */
		return 0.03125;
	if (x >= 100 && x < 160 && y >= 100 && y < 200)
		return -0.125;
	if (x >= 500 && x < 540 && y >= 300 && y < 420)
		return 0.0625;
	return x == 700 && y == 77 ? -1 : 0;
}

static inline double level_ground(int64_t x, int64_t y)
{
	return x >= 60 && x < 70 && y >= 20 && y < 30 ? (double)NAN : 500;
}

static inline bool is_hole(int64_t x, int64_t y) /* of level 0 */
{
	return isnan(level_ground(x, y));
}

/* No offset lies in holes. */
static inline int32_t quanta(int64_t x, int64_t y)
{
	bool near_hole = is_hole((x + 3) / 4, (y + 3) / 4) || is_hole(x / 4, y / 4) || is_hole((x + 3) / 4, y / 4) ||
			 is_hole(x / 4, (y + 3) / 4);
	int64_t width = extent_posts(extent.width, LEVEL), height = extent_posts(extent.height, LEVEL);
	return near_hole || x >= width || y >= height ? 0 : (int32_t)lattice_offset(dug(x, y));
}

static inline void commit(void)
{
	static int32_t posts[16][(CELLS + 1) * (CELLS + 1)];
	static int32_t pressed[(CELLS + 1) * (CELLS + 1)];
	struct store_run run = {.scene_hash = "00", .state = "{}"};
	struct store_commit_result result;
	must(store_set_working_level(store, LEVEL));
	for (uint32_t y = 0; y < extent_tiles_y(&extent, LEVEL); y++)
		for (uint32_t x = 0; x < extent_tiles_x(&extent, LEVEL); x++) {
			struct store_page page = {.tile = {LEVEL, x, y}};
			int32_t *to = posts[0];
			for (int64_t i = 0; i < (CELLS + 1) * (CELLS + 1); i++) {
				to[i] = quanta(x * CELLS + i % (CELLS + 1), y * CELLS + i / (CELLS + 1));
				pressed[i] = to[i] < 0 ? -to[i] : 0;
			}
			page.planes[PLANE_OFFSET] = to;
			/* The state of the soil is also where no offset is. */
			if (x == 20 && y == 2) {
				for (int64_t i = 0; i < (CELLS + 1) * (CELLS + 1); i++)
					pressed[i] = i == 40 * 5 ? 1 << 18 : 0;
			}
			page.planes[PLANE_PLASTIC_SINKAGE] = pressed;
			must(store_commit(store, &page, 1, &run, &result));
		}
}

static inline int enter(void **state)
{
	if (support_enter(state) != 0)
		return -1;
	support_store(support_path("map.furrow"), extent, level_ground);
	must(store_open(support_path("map.furrow"), &(struct store_options){.mode = STORE_WRITE}, &store));
	commit();
	must(store_reader_create(store, &reader));
	return 0;
}

static inline int leave(void **state)
{
	store_reader_destroy(reader);
	store_close(store);
	return support_leave(state);
}

static inline struct chart_raster_params asked(int level, enum store_layer layer)
{
	struct chart_raster_params params = {
		.reader = reader,
		.meta = store_meta(store),
		.deformed = true,
		.working = LEVEL,
		.layer = layer,
		.level = level,
		.rect = {0, 0, extent_posts(extent.width, level), extent_posts(extent.height, level)},
		.exaggerate = 1,
	};
	chart_sun_of(CHART_AZIMUTH, CHART_ALTITUDE, &params.sun);
	return params;
}

#endif
