/* The ground with rocks over nested insets: posts of every level, points, ranges and the store's own readers, each against one formula for a post. */
#include "../support.h"
#include "../support/program.h"

#include "insets.h"
#include "ways.h"

static const uint32_t sizes[] = {8, 32, 64};

static const struct rocks_spec rocks_spec = {0.15, 0.15, 0.3, 6, 7};
static const struct relief_spec relief_spec = {.seed = 7, .classes = 1, .waves = {{0.15, 5}}};

static struct store *open_rocky(uint32_t cells, int working, bool relief)
{
	struct store *store;
	must(store_open(insets_store(cells), &(struct store_options){.mode = STORE_READ}, &store));
	must(store_set_working_level(store, working));
	must(store_set_ground(store, relief ? &relief_spec : NULL, &rocks_spec, NULL));
	assert_non_null(store_rocks(store));
	assert_true((store_relief(store) != NULL) == (relief && working < -1));
	return store;
}

/* Returns the rocks at a post; none where there is no ground. */
static int32_t rock_at(const struct store *store, int level, int64_t x, int64_t y)
{
	int32_t height;
	rocks_heights(store_rocks(store), level, (struct post_rect){x, y, x + 1, y + 1}, &height);
	return height;
}

/* By the CPU, by the patch that the GPU gets, and by the store's reader, with a store without rocks beside it. */
static void check_tiles(uint32_t n, int working, bool relief)
{
	struct store *store = open_rocky(n, working, relief), *bare;
	const struct extent *extent = &store_meta(store)->extent;
	const size_t count = (size_t)(n + 1) * (n + 1);
	struct ground *ground, *below;
	int32_t *posts = malloc(sizeof *posts * 3 * count), *patch = posts + count, *without = patch + count;
	double *values = malloc(count * sizeof *values);
	size_t raised = 0;
	must(store_open(insets_store(n), &(struct store_options){.mode = STORE_READ}, &bare));
	must(store_set_working_level(bare, working));
	must(store_set_relief(bare, relief ? &relief_spec : NULL, NULL));
	must(resident_ground_create(store, 2, &ground));
	must(resident_ground_create(bare, 2, &below));
	for (int level = working < 0 ? working : 0; level <= extent_coarsest(extent); level++)
		for (uint32_t k = 0; k < 20; k++) {
			const struct tile tile = ways_tile(extent, level, k);
			const struct post_rect rect = tile_post_rect(extent, tile);
			double low, high;
			bool any;
			int64_t highest;
			must(resident_ground_posts(ground, tile, posts));
			must(resident_ground_posts(below, tile, without));
			if (level < 0) {
				int shift;
				uint32_t sub_x, sub_y;
				must(resident_ground_patch(ground, tile, patch, &shift, &sub_x, &sub_y));
				assert_int_equal(shift, 0);
				assert_memory_equal(patch, posts, count * sizeof *posts);
			}
			must(store_read_posts(resident_ground_reader(ground), STORE_BASE, level, rect, values));
			must(resident_ground_range(ground, tile, &low, &high, &any));
			must(resident_ground_highest(ground, level, rect, &highest));
			for (size_t i = 0; i < count; i++) {
				const int64_t x = rect.x0 + (int64_t)(i % (n + 1)), y = rect.y0 + (int64_t)(i / (n + 1));
				if (x >= extent_posts(extent->width, level) || y >= extent_posts(extent->height, level))
					continue;
				const int32_t rock = rock_at(store, level, x, y);
				assert_int_equal(posts[i], without[i] != BASE_NODATA ? without[i] + rock : BASE_NODATA);
				assert_true(posts[i] == BASE_NODATA ? isnan(values[i]) : fabs(values[i] - lattice_base_metres(posts[i])) < 1e-9);
				if (posts[i] == BASE_NODATA)
					continue;
				raised += rock > 0;
				assert_true(any && lattice_base_metres(posts[i]) >= low && lattice_base_metres(posts[i]) <= high && highest >= 4 * (int64_t)posts[i]);
			}
		}
	assert_true(raised > 100);
	free(values);
	free(posts);
	resident_ground_destroy(ground);
	resident_ground_destroy(below);
	store_close(bare);
	store_close(store);
}

static void every_way_gives_the_same_posts(void **state)
{
	for (int i = 0; i < 3; i++)
		for (int working = -6; working <= 0; working += 3)
			for (int relief = 0; relief < 2; relief++)
				check_tiles(sizes[i], working, relief == 1);
}

/* Bodies, queries of the command and those of a host stand on the same rocks. */
static void every_way_gives_the_same_point(void **state)
{
	for (int i = 0; i < 3; i++)
		for (int working = -6; working <= 0; working += 6) {
			struct store *store = open_rocky(sizes[i], working, working < 0);
			struct ways ways;
			int raised = 0;
			ways_open(store, &ways);
			for (int k = 0; k < 150; k++) {
				const double x = lattice_offset_metres(lattice_offset(256 * (k * 977 % 4001) / 4001.0)), y = lattice_offset_metres(lattice_offset(192 * (k * 1613 % 4003) / 4003.0));
				struct ways_heights at;
				double corners[4];
				if (!ways_at(&ways, x, y, &at))
					continue;
				const int level = working;
				const double px = ldexp(x / 4, -level), py = ldexp(y / 4, -level);
				const int64_t cx = (int64_t)px, cy = (int64_t)py;
				must(store_read_posts(ways.reader, STORE_BASE, level, (struct post_rect){cx, cy, cx + 2, cy + 2}, corners));
				const double wanted = lattice_bilinear(corners, px - (double)cx, py - (double)cy, 0);
				assert_true(fabs(lattice_offset_metres(at.height) - at.sample.height) < 1e-5);
				/* Where an inset is finer than the working level, its own posts count. */
				assert_true(at.told.level == working || (working == 0 && at.told.level < 0));
				assert_true(at.told.level != working || (fabs(at.sample.height - wanted) < 1e-9 && fabs(at.told.bilinear - wanted) < 1e-9));
				raised += rock_at(store, level, cx, cy) > 0;
			}
			assert_true(raised > 5);
			ways_close(&ways);
			store_close(store);
		}
}

/* Which posts have the soil of rocks: those that they raise, whatever the rectangle. */
static void posts_of_rocks_have_their_soil(void **state)
{
	struct store *store = open_rocky(32, -4, false);
	struct soil_map *map;
	const struct road_part road = {{0, 96}, {256, 96}, 20, 1};
	must(resident_soil_map_open(&(struct soil_map_params){.parts = &road, .part_count = 1, .rocks = store_rocks(store), .rocks_soil = 2, .places = true, .meta = store_meta(store)}, &map));
	size_t counts[3] = {0};
	for (int level = -4; level <= 2; level++) {
		const struct post_rect rect = {3, 40, 60, 70};
		uint8_t soils[57 * 30], soil;
		int value;
		must(resident_soil_map_rect(map, level, rect, soils));
		for (int64_t k = 0; k < 57 * 30; k++) {
			const int64_t x = 3 + k % 57, y = 40 + k / 57;
			const bool rock = rock_at(store, level, x, y) > 0, paved = fabs(ldexp(4, level) * (double)y - 96) <= 20;
			assert_int_equal(soils[k], rock ? 2 : paved && ldexp(4, level) * (double)x <= 276 ? 1 : 0);
			counts[soils[k]]++;
			must(resident_soil_map_at(map, level, x, y, &soil));
			assert_int_equal(soil, soils[k]);
			must(resident_soil_map_value(map, level, x, y, &value, &soil));
			assert_int_equal(soil, soils[k]);
			assert_int_equal(value, rock ? SOIL_MAP_ROCK : soil == 1 ? SOIL_MAP_ROAD : SOIL_MAP_NONE);
		}
	}
	assert_true(counts[0] > 100 && counts[1] > 100 && counts[2] > 100);
	resident_soil_map_close(map);
	store_close(store);
}

TEST_PROGRAM(rocks)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_way_gives_the_same_posts),
		cmocka_unit_test(every_way_gives_the_same_point),
		cmocka_unit_test(posts_of_rocks_have_their_soil),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
