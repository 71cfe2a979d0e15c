/* Which parts of a tile are drawn at which stride. No GL. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "render/internal.h"
#include "../support/program.h"

static const struct extent extent = {1025, 1025, 1, 256};
static struct render_screen screen = {.width = 1280, .height = 720};

static void look(double x, double y, double z, double tx, double ty, struct render_view *view)
{
	struct render render = {.extent = extent, .screen = &screen};
	struct render_camera camera = {{x, y, z}, {tx, ty, 0}, 0.9, {0}};
	render_view(&render, &camera, view);
}

/* A reach that doubles with the stride, as by the radii: metres a metre of spacing (1 m). */
static const double *doubling(double reach)
{
	static double reaches[RENDER_STRIDES];
	for (int k = 0; k < RENDER_STRIDES; k++)
		reaches[k] = ldexp(reach, k);
	return reaches;
}

struct cell {
	int times;
	uint32_t stride;
};

static void count_cells(const struct render_blocks *blocks, uint32_t side, struct cell *cells)
{
	memset(cells, 0, 256 * 256 * sizeof *cells);
	for (size_t i = 0; i < blocks->count; i++) {
		uint32_t stride = 1u << (blocks->blocks[i] >> 20 & 15);
		uint32_t x0 = (blocks->blocks[i] & 1023) * side * stride, y0 = (blocks->blocks[i] >> 10 & 1023) * side * stride;
		for (uint32_t y = y0; y < y0 + side * stride; y++)
			for (uint32_t x = x0; x < x0 + side * stride; x++) {
				assert_true(x < 256 && y < 256);
				cells[256 * y + x].times++;
				cells[256 * y + x].stride = stride;
			}
	}
}

static void every_visible_cell_of_its_quadrants_is_drawn_once(void **state)
{
	struct cell *cells = test_malloc(256 * 256 * sizeof *cells);
	uint32_t side = render_block_cells(&extent);
	size_t seen = 0;
	for (int round = 0; round < 60; round++) {
		struct render_blocks blocks = {0};
		struct render_view view;
		const struct render_view *looking = &view;
		struct render_draw draw = {.tile = {0, 1, 2}, .quadrants = 1 + (unsigned)round % 15, .low = 0, .high = 5};
		look(100.0 + 9 * round, 900.0 - 11 * round, 4.0 + round, 380, 640, &view);
		assert_int_equal(render_blocks_add(&blocks, &extent, &view, doubling(30), &draw), STATUS_OK);
		count_cells(&blocks, side, cells);
		for (uint32_t y = 0; y < 256; y++)
			for (uint32_t x = 0; x < 256; x++) {
				double low[3] = {256 + x, 512 + y, 0}, high[3] = {257 + x, 513 + y, 5};
				bool mine = draw.quadrants >> ((x >= 128) + 2 * (y >= 128)) & 1;
				bool visible = render_box_visible(looking->planes, low, high);
				assert_true(cells[256 * y + x].times <= mine);
				if (mine && visible) {
					assert_int_equal(cells[256 * y + x].times, 1);
					seen++;
				}
			}
		mem_free(blocks.blocks);
	}
	assert_true(seen > 100000);
	test_free(cells);
}

static void strides_grow_with_distance_and_never_with_nearness(void **state)
{
	struct cell *cells = test_malloc(256 * 256 * sizeof *cells);
	struct render_blocks blocks = {0};
	struct render_view view;
	struct render_draw draw = {.tile = {0, 0, 0}, .quadrants = 15, .low = 0, .high = 1};
	look(128, -5, 3, 128, 200, &view);
	assert_int_equal(render_blocks_add(&blocks, &extent, &view, doubling(30), &draw), STATUS_OK);
	count_cells(&blocks, render_block_cells(&extent), cells);
	uint32_t before = 1;
	for (uint32_t y = 0; y < 256; y++) {
		const struct cell *cell = &cells[256 * y + 128];
		assert_true(cell->times == 1 && cell->stride >= before);
		/* A spacing is used only from its reach on. */
		assert_true(cell->stride == 1 || y + 5 >= 30 * cell->stride);
		before = cell->stride;
	}
	assert_true(before > 2);
	mem_free(blocks.blocks);
	test_free(cells);
}

static void skirts_hang_only_where_strides_or_tiles_meet(void **state)
{
	struct render_blocks blocks = {0};
	struct render_view view;
	struct render_draw draw = {.tile = {0, 1, 1}, .quadrants = 15, .low = 0, .high = 0};
	look(384, 384, 3000, 384.1, 384, &view);
	/* So far above that one stride does for all, the coarsest: 2 x 2 blocks. */
	assert_int_equal(render_blocks_add(&blocks, &extent, &view, doubling(1), &draw), STATUS_OK);
	assert_int_equal(blocks.count, 4);
	for (size_t i = 0; i < blocks.count; i++) {
		uint32_t x = blocks.blocks[i] & 1023, y = blocks.blocks[i] >> 10 & 1023;
		assert_int_equal((blocks.blocks[i] & RENDER_SKIRT_WEST) != 0, x == 0);
		assert_int_equal((blocks.blocks[i] & RENDER_SKIRT_EAST) != 0, x == 1);
		assert_int_equal((blocks.blocks[i] & RENDER_SKIRT_SOUTH) != 0, y == 0);
		assert_int_equal((blocks.blocks[i] & RENDER_SKIRT_NORTH) != 0, y == 1);
	}
	/* At the world's corner two sides border on nothing. */
	blocks.count = 0;
	draw.tile = (struct tile){0, 0, 0};
	look(128, 128, 3000, 128.1, 128, &view);
	assert_int_equal(render_blocks_add(&blocks, &extent, &view, doubling(1), &draw), STATUS_OK);
	unsigned edges = 0;
	for (size_t i = 0; i < blocks.count; i++)
		edges |= blocks.blocks[i];
	assert_int_equal(edges & (RENDER_SKIRT_SOUTH | RENDER_SKIRT_WEST), 0);
	assert_true((edges & RENDER_SKIRT_NORTH) && (edges & RENDER_SKIRT_EAST));
	mem_free(blocks.blocks);
}

static void by_the_radii_reach_doubles_with_the_stride_and_nothing_asks_for_errors(void **state)
{
	struct render render = {.extent = extent, .screen = &screen};
	struct render_camera camera = {{0, 0, 9}, {5, 5, 0}, 0.9, {0}};
	struct render_axes axes;
	struct render_view view;
	struct render_draw draw = {.tile = {1, 0, 0}};
	double reaches[RENDER_STRIDES];
	for (int k = 0; k < RENDER_STRIDES; k++)
		draw.errors[k] = (double)NAN;
	render_axes(&render, &camera, &axes);
	render_view(&render, &camera, &view);
	assert_false(view.by_error);
	assert_true(view.radius == axes.focal / 6 / 256);
	/* What is as far apart reaches as far, whatever the tile; below 0.3 m half as far again. */
	for (int level = -5; level < 4; level++) {
		draw.tile.level = level;
		render_reaches(&render, &axes, &draw, reaches);
		for (int k = 0; k < RENDER_STRIDES; k++)
			assert_true(reaches[k] == render_mesh_reach(&render, &axes) * (level + k < -1 ? 1.5 : 1) * ldexp(1, level + k));
	}
}

static void by_error_a_stride_reaches_as_far_as_its_error_is_seen(void **state)
{
	struct render render = {.extent = extent, .screen = &screen, .pixel_error = 2};
	struct render_camera camera = {{0, 0, 9}, {5, 5, 0}, 0.9, {0}};
	struct render_axes axes;
	struct render_view view;
	struct render_draw draw = {.tile = {1, 0, 0}, .errors = {0, 0.25, 0.25, 4, 1e300, 1e308, INFINITY}};
	double reaches[RENDER_STRIDES];
	render_axes(&render, &camera, &axes);
	render_view(&render, &camera, &view);
	assert_true(view.by_error && view.radius == axes.focal / 2);
	{
		render_reaches(&render, &axes, &draw, reaches);
		/* The same error twice: room to slide in is left all the same. */
		assert_true(reaches[0] == 0 && reaches[2] == 1.25 * reaches[1]);
		/* From there on 0.25 m are less than 2 pixels of 720 / 2 / tan(0.45). */
		assert_true(fabs(reaches[1] - 0.25 / 2 * 360 / tan(0.45)) < 1e-9);
		assert_true(fabs(reaches[3] - 16 * reaches[1]) < 1e-9);
		for (int k = 4; k < 7; k++)
			assert_true(isfinite((float)reaches[k]) && reaches[k] >= reaches[k - 1]);
	}
	/* Where nothing is off, too. */
	memset(draw.errors, 0, sizeof draw.errors);
	render_reaches(&render, &axes, &draw, reaches);
	for (int k = 1; k < RENDER_STRIDES; k++)
		assert_true(reaches[k] == 10 * ldexp(extent_spacing(&extent, 1), k));
}

static void strides_whose_reaches_meet_are_passed_over(void **state)
{
	struct cell *cells = test_malloc(256 * 256 * sizeof *cells);
	struct render_blocks blocks = {0};
	struct render_view view;
	struct render_draw draw = {.tile = {0, 0, 0}, .quadrants = 15, .low = 0, .high = 1};
	/* A stride of 2 does from 60 m on, and so does one of 4; one of 8 never. */
	const double reaches[RENDER_STRIDES] = {0, 60, 60, 1e30, 1e30, 1e30, 1e30, 1e30, 1e30, 1e30, 1e30, 1e30};
	look(128, -5, 3, 128, 200, &view);
	assert_int_equal(render_blocks_add(&blocks, &extent, &view, reaches, &draw), STATUS_OK);
	count_cells(&blocks, render_block_cells(&extent), cells);
	size_t fine = 0, coarse = 0;
	for (uint32_t y = 0; y < 256; y++) {
		const struct cell *cell = &cells[256 * y + 128];
		assert_true(cell->stride == 1 || y + 5 >= 60);
		fine += cell->stride == 1;
		coarse += cell->stride == 4;
		assert_true(cell->stride != 8);
	}
	assert_true(fine >= 55 && coarse >= 128);
	mem_free(blocks.blocks);
	test_free(cells);
}

static void the_smallest_tiles_have_blocks_too(void **state)
{
	const struct extent small = {33, 33, 1, TILE_CELLS_MIN};
	struct render_blocks blocks = {0};
	struct render_view view;
	struct render_draw draw = {.tile = {0, 1, 1}, .quadrants = 15, .low = 0, .high = 0};
	look(12, 12, 30, 12.1, 12, &view);
	assert_int_equal(render_blocks_add(&blocks, &small, &view, doubling(100), &draw), STATUS_OK);
	assert_int_equal(blocks.count * render_block_cells(&small) * render_block_cells(&small), 64);
	mem_free(blocks.blocks);
}

static void running_out_of_memory_is_told(void **state)
{
	struct render_blocks blocks = {0};
	struct render_view view;
	struct render_draw draw = {.tile = {0, 1, 1}, .quadrants = 15, .low = 0, .high = 0};
	look(384, 384, 30, 384.1, 384, &view);
	for (uint64_t nth = 1; nth <= 2; nth++) {
		blocks.count = 0;
		mem_fail_nth(nth, 0);
		assert_int_equal(render_blocks_add(&blocks, &extent, &view, doubling(30), &draw), STATUS_FAILED);
		mem_fail_nth(0, 0);
		mem_free(blocks.blocks);
		blocks = (struct render_blocks){0};
	}
}

TEST_PROGRAM(blocks)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_visible_cell_of_its_quadrants_is_drawn_once),
		cmocka_unit_test(strides_grow_with_distance_and_never_with_nearness),
		cmocka_unit_test(skirts_hang_only_where_strides_or_tiles_meet),
		cmocka_unit_test(by_the_radii_reach_doubles_with_the_stride_and_nothing_asks_for_errors),
		cmocka_unit_test(by_error_a_stride_reaches_as_far_as_its_error_is_seen),
		cmocka_unit_test(strides_whose_reaches_meet_are_passed_over),
		cmocka_unit_test(the_smallest_tiles_have_blocks_too),
		cmocka_unit_test(running_out_of_memory_is_told),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
