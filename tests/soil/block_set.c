/* A set of blocks has what was added, in order, and sorts along a Morton curve. */
#include "soil_test.h"

#include "../support/program.h"

enum { SIDE_BLOCKS = 40 };

/* At the world's edge, and where x and y together have more than 64 bits. */
static const int64_t corners[][2] = {{0, 0}, {1, 0}, {4096, 70000}, {(int64_t)1 << 31, 3}, {5, (int64_t)1 << 31}, {(int64_t)1 << 40, (int64_t)1 << 34}, {1, (int64_t)1 << 40}};

static void a_block_is_found_once_it_was_added(void **state)
{
	struct soil_block_set set = {.count = 0};
	for (size_t c = 0; c < sizeof corners / sizeof corners[0]; c++) {
		bool in[SIDE_BLOCKS][SIDE_BLOCKS] = {{false}};
		size_t places[SIDE_BLOCKS][SIDE_BLOCKS], count = 0;
		for (int i = 0; i < 3 * SIDE_BLOCKS; i++) {
			int x = (int)(any_word() % SIDE_BLOCKS), y = (int)(any_word() % SIDE_BLOCKS);
			assert_int_equal(soil_block_set_add(&set, (struct soil_block){corners[c][0] + x, corners[c][1] + y}), STATUS_OK);
			if (!in[y][x])
				places[y][x] = count++;
			in[y][x] = true;
		}
		assert_int_equal(set.count, count);
		for (int y = -1; y < SIDE_BLOCKS; y++)
			for (int x = -1; x < SIDE_BLOCKS; x++) {
				const struct soil_block block = {corners[c][0] + x, corners[c][1] + y};
				bool has = x >= 0 && y >= 0 && in[y][x];
				assert_int_equal(soil_block_set_has(&set, block), has);
				assert_int_equal(soil_block_set_place(&set, block), has ? places[y][x] : set.count);
			}
		soil_block_set_clear(&set);
		assert_int_equal(set.count, 0);
		assert_false(soil_block_set_has(&set, (struct soil_block){corners[c][0], corners[c][1]}));
	}
	soil_block_set_finish(&set);
}

static void sorted_blocks_are_found_at_their_new_places(void **state)
{
	struct soil_block_set set = {.count = 0};
	for (int y = 7; y >= 0; y--)
		for (int x = 0; x < 8; x++)
			assert_int_equal(soil_block_set_add(&set, (struct soil_block){x, y}), STATUS_OK);
	soil_block_set_sort(&set);
	for (size_t i = 0; i < set.count; i++) {
		int64_t x = (i & 1) | (i >> 1 & 2) | (i >> 2 & 4), y = (i >> 1 & 1) | (i >> 2 & 2) | (i >> 3 & 4);
		assert_true(set.blocks[i].x == x && set.blocks[i].y == y);
		assert_int_equal(soil_block_set_place(&set, set.blocks[i]), i);
	}
	soil_block_set_finish(&set);
}

TEST_PROGRAM(block_set)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_block_is_found_once_it_was_added),
		cmocka_unit_test(sorted_blocks_are_found_at_their_new_places),
	};
	return cmocka_run_group_tests_name("deform/block_set", tests, NULL, NULL);
}
