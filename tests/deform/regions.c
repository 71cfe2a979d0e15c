/* Regions of blocks: each active block is computed once, with the posts around it, and its results are kept once. */
#include "ground.h"

#include "deform/schedule/regions.h"
#include "../support/program.h"

enum { SIDE_BLOCKS = 40 };

static int64_t least(int64_t a, int64_t b)
{
	return a < b ? a : b;
}

/* The rectangles that two regions of one atlas read do not meet. */
static void assert_apart(const struct region *a, const struct region *b, uint32_t rim)
{
	int64_t right = least(a->at_x + 32 * a->columns, b->at_x + 32 * b->columns) + rim;
	int64_t top = least(a->at_y + 32 * a->rows, b->at_y + 32 * b->rows) + rim;
	int64_t x = (a->at_x > b->at_x ? a->at_x : b->at_x) - (int64_t)rim, y = (a->at_y > b->at_y ? a->at_y : b->at_y) - (int64_t)rim;
	assert_true(a->atlas != b->atlas || right <= x || top <= y);
}

static void assert_regions(const struct regions *regions, const struct region_limits *limits)
{
	for (size_t i = 0; i < regions->region_count; i++) {
		const struct region *at = &regions->regions[i];
		assert_true(at->atlas < regions->atlas_count && at->run_count > 0);
		assert_true(i == 0 || at->atlas == at[-1].atlas || at->atlas == at[-1].atlas + 1);
		assert_int_equal(at->at_x % REGION_ALIGN + at->at_y % REGION_ALIGN, 0);
		assert_true(at->at_x >= limits->rim && at->at_x + 32 * at->columns + limits->rim <= limits->side);
		assert_true(at->at_y >= limits->rim && at->at_y + 32 * at->rows + limits->rim <= limits->side);
		for (size_t k = 0; k < i; k++)
			assert_apart(at, &regions->regions[k], limits->rim);
	}
}

static void assert_runs(const struct soil_block_set *set, const struct regions *regions, const struct region_limits *limits)
{
	uint8_t *seen = calloc(set->count, 1);
	uint32_t slot = 0;
	assert_non_null(seen);
	for (size_t i = 0; i < regions->run_count; i++) {
		const struct run *run = &regions->runs[i];
		const struct region *in = &regions->regions[run->region];
		assert_true(i >= in->first_run && i < in->first_run + in->run_count && run->count > 0);
		assert_int_equal(run->slot, slot);
		assert_true(run->slot % limits->in_row + run->count <= limits->in_row);
		slot += run->count;
		assert_true(run->first.y >= in->y && run->first.y < in->y + in->rows);
		assert_true(run->first.x >= in->x && run->first.x + run->count <= in->x + in->columns);
		assert_int_equal(run->first.x * 32 / limits->cells, (run->first.x + run->count - 1) * 32 / limits->cells);
		for (int64_t k = 0; k < run->count; k++) {
			size_t place = soil_block_set_place(set, (struct soil_block){run->first.x + k, run->first.y});
			assert_true(place < set->count && !seen[place]);
			seen[place] = 1;
		}
	}
	assert_int_equal(slot, set->count);
	free(seen);
}

static void each_block_is_in_one_region(void **state)
{
	static const uint32_t rims[] = {1, 2, 9, 16, 17, 31};
	struct soil_block_set set = {.count = 0};
	struct regions regions = {.room = 0};
	(void)state;
	for (int round = 0; round < 60; round++) {
		const struct region_limits limits = {DEFORM_WINDOW_POSTS, rims[any_word() % 6], (int64_t)8 << any_word() % 6, 8};
		const int tries = (int)(any_word() % (SIDE_BLOCKS * SIDE_BLOCKS * 2)), side = 1 + (int)(any_word() % SIDE_BLOCKS);
		soil_block_set_clear(&set);
		for (int i = 0; i <= tries; i++)
			assert_ok(soil_block_set_add(&set, (struct soil_block){any_word() % (uint32_t)side, any_word() % (uint32_t)side}));
		soil_block_set_sort(&set);
		assert_ok(deform_regions_cut(&set, &limits, &regions));
		assert_regions(&regions, &limits);
		assert_runs(&set, &regions, &limits);
	}
	soil_block_set_clear(&set);
	assert_ok(deform_regions_cut(&set, &(struct region_limits){DEFORM_WINDOW_POSTS, 1, 32, 8}, &regions));
	assert_true(regions.region_count == 0 && regions.run_count == 0 && regions.atlas_count == 0);
	deform_regions_finish(&regions);
	soil_block_set_finish(&set);
}

static void what_fits_an_atlas_is_one_region(void **state)
{
	const struct region_limits limits = {DEFORM_WINDOW_POSTS, 31, 256, 8};
	struct soil_block_set set = {.count = 0};
	struct regions regions = {.room = 0};
	(void)state;
	assert_int_equal(deform_region_blocks(&limits), 6);
	for (int y = 3; y < 9; y++)
		for (int x = 2; x < 8; x++)
			if (x != y) /* a gap does not cut it */
				assert_ok(soil_block_set_add(&set, (struct soil_block){x, y}));
	soil_block_set_sort(&set);
	assert_ok(deform_regions_cut(&set, &limits, &regions));
	assert_true(regions.region_count == 1 && regions.atlas_count == 1);
	assert_true(regions.regions[0].columns == 6 && regions.regions[0].rows == 6);
	deform_regions_finish(&regions);
	soil_block_set_finish(&set);
}

TEST_PROGRAM(regions)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(each_block_is_in_one_region),
		cmocka_unit_test(what_fits_an_atlas_is_one_region),
	};
	return cmocka_run_group_tests_name("deform/regions", tests, NULL, NULL);
}
