/* Keys, levels, and which tiles hold a post. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "base/base.h"
#include "../support/program.h"

static const struct extent worlds[] = {
	{1201, 2401, 90, 256}, {257, 257, 1, 256}, {258, 1025, 1, 256}, {65537, 65537, 0.5, 256},
	{2, 2, 30, 64},	       {1280, 99, 2, 64},
};
#define WORLDS (sizeof worlds / sizeof *worlds)

static void a_key_comes_back_as_its_tile(void **state)
{
	const struct tile tiles[] = {{0, 0, 0}, {-14, (1u << 28) - 1, 5}, {28, 0, 0}, {3, 123456, 654321}};
	for (size_t i = 0; i < sizeof tiles / sizeof *tiles; i++) {
		uint64_t key = tile_key(tiles[i]);
		assert_true(key < (uint64_t)1 << 62);
		assert_true(tile_equal(tile_from_key(key), tiles[i]));
	}
}

static void every_tile_has_its_parent(void **state)
{
	for (size_t w = 0; w < WORLDS; w++)
		for (int level = -4; level < extent_coarsest(&worlds[w]); level++) {
			uint32_t x = extent_tiles_x(&worlds[w], level) - 1, y = extent_tiles_y(&worlds[w], level) - 1;
			assert_true(extent_has(&worlds[w], (struct tile){level, x, y}));
			assert_true(extent_has(&worlds[w], tile_ancestor((struct tile){level, x, y}, level + 1)));
		}
}

static void descendants_are_one_range_of_keys(void **state)
{
	struct tile parent = {2, 5, 9};
	uint64_t first, last;
	tile_descendants(parent, -1, &first, &last);
	assert_int_equal(last - first + 1, 64);
	for (uint64_t key = first; key <= last; key++)
		assert_true(tile_equal(tile_ancestor(tile_from_key(key), 2), parent));
}

static void a_post_is_in_every_tile_that_shares_it(void **state)
{
	const struct extent *extent = &worlds[0];
	for (int64_t y = 0; y <= 1024; y += 64)
		for (int64_t x = 0; x <= 1024; x += 32) {
			struct tile first, last;
			struct post_rect post = {x, y, x + 1, y + 1};
			assert_true(tile_range_of(extent, 0, post, &first, &last));
			for (uint32_t ty = 0; ty < extent_tiles_y(extent, 0); ty++)
				for (uint32_t tx = 0; tx < extent_tiles_x(extent, 0); tx++) {
					bool holds = !post_rect_empty(post_rect_intersect(
						post, tile_post_rect(extent, (struct tile){0, tx, ty})));
					bool in = tx >= first.x && tx <= last.x && ty >= first.y && ty <= last.y;
					assert_int_equal(holds, in);
				}
		}
}

static void a_spacing_picks_the_coarsest_level_that_is_fine_enough(void **state)
{
	const struct extent *extent = &worlds[0];
	assert_int_equal(extent_level_for(extent, 90), 0);
	assert_int_equal(extent_level_for(extent, 89.9), -1);
	assert_int_equal(extent_level_for(extent, 0.1), -10);
	assert_int_equal(extent_level_for(extent, 1e-4), TILE_LEVEL_MIN - 1);
}

static void a_world_that_cannot_be_held_says_why(void **state)
{
	assert_null(extent_problem(&worlds[0]));
	assert_non_null(extent_problem(&(struct extent){1201, 1201, 90, 100}));
	assert_non_null(extent_problem(&(struct extent){1, 1201, 90, 256}));
	assert_non_null(extent_problem(&(struct extent){1201, 1201, 0, 256}));
	assert_non_null(extent_problem(&(struct extent){(int64_t)1 << 40, 1201, 90, 256}));
}

/* The largest world: posts, tiles and rectangles beyond 2^31 and 2^32, down to the finest level. */
static void the_largest_world_is_counted_without_overflow(void **state)
{
	const struct extent extent = {(int64_t)1024 << 14, (int64_t)1024 << 14, 1, 1024};
	assert_null(extent_problem(&extent));
	assert_non_null(extent_problem(&(struct extent){extent.width + 1, extent.height, 1, 1024}));
	assert_int_equal(extent_coarsest(&extent), 14);
	for (int level = TILE_LEVEL_MIN; level <= 14; level++) {
		uint32_t tiles = extent_tiles_x(&extent, level);
		/* The last post has no cell after it: below level 0 that leaves tiles out. */
		assert_int_equal(tiles, level >= 0 ? 1 << (14 - level)
						   : (((extent.width - 1) << -level) + 1023) / 1024);
		struct tile last = {level, tiles - 1, tiles - 1};
		assert_true(extent_has(&extent, last));
		assert_true(tile_equal(tile_from_key(tile_key(last)), last));
		struct post_rect rect = tile_post_rect(&extent, last), one = {rect.x1 - 2, rect.y0 + 1, rect.x1 - 1,
									     rect.y0 + 2};
		assert_int_equal(rect.x1, (int64_t)tiles * 1024 + 1);
		struct tile first, end;
		assert_true(tile_range_of(&extent, level, one, &first, &end));
		assert_true(tile_equal(first, last) && tile_equal(end, last));
	}
	assert_int_equal(extent_posts(extent.width, TILE_LEVEL_MIN), ((extent.width - 1) << 14) + 1);
}

TEST_PROGRAM(tile)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_key_comes_back_as_its_tile),
		cmocka_unit_test(every_tile_has_its_parent),
		cmocka_unit_test(descendants_are_one_range_of_keys),
		cmocka_unit_test(a_post_is_in_every_tile_that_shares_it),
		cmocka_unit_test(a_spacing_picks_the_coarsest_level_that_is_fine_enough),
		cmocka_unit_test(a_world_that_cannot_be_held_says_why),
		cmocka_unit_test(the_largest_world_is_counted_without_overflow),
	};
	return cmocka_run_group_tests_name("tile", tests, NULL, NULL);
}
