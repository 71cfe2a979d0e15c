/* Tiling and the pyramid against brute force: every post of every tile, ranges, errors, order. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "dem/dem.h"
#include "../support/program.h"

#define STEP 0.5
#define TILES_MAX 4096

struct cut_tile {
	struct tile tile;
	double low, high, error;
	int32_t *codes;
};

struct scene {
	struct extent extent;
	double *heights;
	int64_t next_row, next_x, panel_x, progress, asked;
	int64_t panel_posts; /* 0: the cut's own */
	bool skips; /* rows that are known */
	struct cut_tile *tiles;
	struct misfit misfit; /* of all tiles */
	int count, stop_after;
};

static double any_height(int64_t x, int64_t y)
{
	uint64_t v = (uint64_t)(x * 7919 + y * 104729 + 1) * 0x9e3779b97f4a7c15ull;
	v ^= v >> 29;
	if (v % 23 == 0 || (x > 30 && x < 52 && y > 10 && y < 34))
		return (double)NAN;
	return (double)(v % 4001) / 2 - 700;
}

static enum status posts_of(void *user, struct post_rect rect, double *heights)
{
	struct scene *scene = user;
	int64_t width = scene->extent.width;
	scene->asked += (rect.x1 - rect.x0) * (rect.y1 - rect.y0);
	assert_true(rect.x0 >= 0 && rect.x0 < rect.x1 && rect.x1 <= width);
	assert_true(rect.y0 >= 0 && rect.y0 < rect.y1 && rect.y1 <= scene->extent.height);
	assert_true(rect.x1 - rect.x0 <= (scene->panel_posts > 0 ? 2 * scene->panel_posts + 1 : width));
	/* From the south within a panel, panels from the west, each post once but for those panels share. */
	if (!scene->skips) {
		assert_int_equal(rect.y0, scene->next_row);
		assert_true(rect.x0 == scene->panel_x || (rect.x0 == scene->next_x && rect.y0 == 0));
	}
	scene->panel_x = rect.x0;
	scene->next_x = rect.x1 - 1;
	scene->next_row = rect.y1 == scene->extent.height ? 0 : rect.y1;
	for (int64_t y = rect.y0; y < rect.y1; y++, heights += rect.x1 - rect.x0)
		memcpy(heights, scene->heights + y * width + rect.x0, (size_t)(rect.x1 - rect.x0) * sizeof *heights);
	return STATUS_OK;
}

static enum status take(void *user, const struct dem_tile *tile)
{
	struct scene *scene = user;
	size_t posts = scene->extent.cells + 1;
	assert_true(scene->count < TILES_MAX);
	misfit_add(&scene->misfit, &tile->misfit);
	struct cut_tile *kept = &scene->tiles[scene->count++];
	*kept = (struct cut_tile){tile->tile, tile->low, tile->high, tile->error, malloc(posts * posts * 4)};
	memcpy(kept->codes, tile->codes, posts * posts * 4);
	return scene->stop_after != 0 && scene->count == scene->stop_after ? STATUS_INTERRUPTED : STATUS_OK;
}

static enum status told(void *user, int64_t done, int64_t total)
{
	struct scene *scene = user;
	assert_true(done > scene->progress && done <= total);
	assert_int_equal(total % scene->extent.height, 0); /* of every panel */
	scene->progress = done;
	return STATUS_OK;
}

static struct scene scene_make(int64_t width, int64_t height, uint32_t cells)
{
	struct scene scene = {.extent = {width, height, 1, cells}};
	scene.heights = mem_alloc((size_t)(width * height), sizeof *scene.heights);
	scene.tiles = mem_calloc(TILES_MAX, sizeof *scene.tiles);
	for (int64_t y = 0; y < height; y++)
		for (int64_t x = 0; x < width; x++)
			scene.heights[y * width + x] = any_height(x, y);
	return scene;
}

static void scene_free(struct scene *scene)
{
	for (int i = 0; i < scene->count; i++)
		free(scene->tiles[i].codes);
	mem_free(scene->tiles);
	mem_free(scene->heights);
}

static struct dem_cut cut_of(struct scene *scene, double step)
{
	return (struct dem_cut){.extent = &scene->extent, .step = step, .posts = posts_of, .posts_user = scene,
				.emit = take, .emit_user = scene, .progress = told, .progress_user = scene,
				.panel_posts = scene->panel_posts};
}

static enum status cut(struct scene *scene, double step)
{
	struct dem_cut cut = cut_of(scene, step);
	return dem_cut(&cut);
}

static const struct cut_tile *find(const struct scene *scene, struct tile tile, int before)
{
	for (int i = 0; i < before; i++)
		if (tile_equal(scene->tiles[i].tile, tile))
			return &scene->tiles[i];
	return NULL;
}

/* The height of a post of `level`, or NaN beyond the world. */
static double post(const struct scene *scene, int level, int64_t x, int64_t y)
{
	x <<= level;
	y <<= level;
	if (x >= scene->extent.width || y >= scene->extent.height)
		return (double)NAN;
	return scene->heights[y * scene->extent.width + x];
}

static double own_decimation_error(const struct scene *scene, struct tile tile)
{
	int64_t n = scene->extent.cells;
	double most = 0;
	for (int64_t y = 0; y <= n; y++)
		for (int64_t x = 0; x <= n; x++) {
			int64_t gx = tile.x * n + x, gy = tile.y * n + y;
			double sum = 0;
			for (int k = 0; k < 4; k++)
				sum += post(scene, tile.level, gx + ((gx & 1) ? (k & 1 ? 1 : -1) : 0),
					    gy + ((gy & 1) ? (k & 2 ? 1 : -1) : 0)) / 4;
			double off = fabs(sum - post(scene, tile.level, gx, gy));
			most = off > most ? off : most;
		}
	return most;
}

static void check_tile(const struct scene *scene, int index)
{
	const struct cut_tile *tile = &scene->tiles[index];
	const struct extent *extent = &scene->extent;
	int64_t n = extent->cells;
	assert_true(extent_has(extent, tile->tile));
	assert_null(find(scene, tile->tile, index));
	for (int64_t y = 0; y <= n; y++)
		for (int64_t x = 0; x <= n; x++) {
			int32_t expected = 0;
			double height = post(scene, tile->tile.level, tile->tile.x * n + x, tile->tile.y * n + y);
			assert_true(height_code_encode(height, STEP, &expected));
			assert_int_equal(tile->codes[y * (n + 1) + x], expected);
		}
	double low = (double)INFINITY, high = -(double)INFINITY, error = 0;
	int64_t side = n << tile->tile.level, x0 = tile->tile.x * side, y0 = tile->tile.y * side;
	for (int64_t y = y0; y <= y0 + side; y++)
		for (int64_t x = x0; x <= x0 + side; x++) {
			double height = post(scene, 0, x, y);
			low = height < low ? height : low;
			high = height > high ? height : high;
		}
	if (low > high)
		assert_true(isnan(tile->low) && isnan(tile->high));
	else
		assert_true(tile->low == low && tile->high == high);
	for (unsigned q = 0; tile->tile.level > 0 && q < 4; q++) {
		struct tile child = {tile->tile.level - 1, 2 * tile->tile.x + (q & 1), 2 * tile->tile.y + (q >> 1)};
		if (!extent_has(extent, child))
			continue;
		const struct cut_tile *below = find(scene, child, index); /* it came before */
		assert_non_null(below);
		error = fmax(error, below->error + own_decimation_error(scene, child));
	}
	assert_true(fabs(tile->error - error) < 1e-9);
}

static void check_whole(const struct scene *scene)
{
	int expected = 0;
	for (int level = 0; level <= extent_coarsest(&scene->extent); level++)
		expected += (int)(extent_tiles_x(&scene->extent, level) * extent_tiles_y(&scene->extent, level));
	assert_int_equal(scene->count, expected);
	for (int t = 0; t < scene->count; t++)
		check_tile(scene, t);
}

static const int64_t sizes[][2] = {{2, 2}, {9, 9}, {17, 33}, {10, 3}, {101, 67}, {64, 129}, {65, 65}};
static const int64_t panels[] = {0, 8, 16, 32}; /* the cut's own: one */

static void every_tile_of_every_level_is_what_brute_force_says(void **state)
{
	for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++)
		for (size_t p = 0; p < sizeof panels / sizeof panels[0]; p++) {
			struct scene scene = scene_make(sizes[i][0], sizes[i][1], 8);
			scene.panel_posts = panels[p];
			assert_int_equal(cut(&scene, STEP), STATUS_OK);
			assert_int_equal(scene.progress % sizes[i][1], 0);
			check_whole(&scene);
			scene_free(&scene);
		}
}

/* Each post counts once, also where tiles and panels share it. */
static void misfits_are_those_of_every_post(void **state)
{
	static const double steps[] = {0, 0.25, 0.3, 7};
	for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++)
		for (size_t p = 0; p < 4 * sizeof panels / sizeof panels[0]; p++) {
			double step = steps[p / 4];
			struct scene scene = scene_make(sizes[i][0], sizes[i][1], 8);
			struct misfit plain = {0};
			scene.panel_posts = panels[p % 4];
			for (int64_t at = 0; at < sizes[i][0] * sizes[i][1]; at++) {
				int32_t code = 0;
				assert_true(height_code_encode(scene.heights[at], step, &code));
				if (!isnan(scene.heights[at]))
					misfit_add_post(&plain, height_code_metres(code, step) - scene.heights[at]);
			}
			assert_int_equal(cut(&scene, step), STATUS_OK);
			assert_int_equal(scene.misfit.posts, plain.posts);
			assert_true(scene.misfit.greatest == plain.greatest);
			assert_true(fabs(scene.misfit.squares - plain.squares) <= 1e-12 * plain.squares);
			assert_true((plain.greatest > 0) == (step == 0.3 || step == 7) || plain.posts < 5);
			scene_free(&scene);
		}
}

/* Whole codes near each other take another way than holes do. */
static void terrain_without_holes_is_what_brute_force_says(void **state)
{
	for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
		struct scene scene = scene_make(sizes[i][0], sizes[i][1], 8);
		for (int64_t at = 0; at < sizes[i][0] * sizes[i][1]; at++)
			if (isnan(scene.heights[at]))
				scene.heights[at] = -(double)(at % 100);
		assert_int_equal(cut(&scene, STEP), STATUS_OK);
		check_whole(&scene);
		scene_free(&scene);
	}
}

/* The tiles of level 0 among the first `known_count` of another cut. */
static enum status known_of(void *user, struct tile tile, int32_t *codes, bool *known)
{
	const struct scene *before = user;
	const struct cut_tile *found = find(before, tile, before->count);
	size_t posts = before->extent.cells + 1;
	*known = found != NULL;
	if (*known)
		memcpy(codes, found->codes, posts * posts * 4);
	return STATUS_OK;
}

/* Broken off after any tile and begun again with what was cut: the same tiles in the same order, of
 * fewer posts. */
static void a_cut_that_was_broken_off_goes_on(void **state)
{
	for (size_t p = 0; p < sizeof panels / sizeof panels[0]; p++) {
		struct scene whole = scene_make(101, 67, 8);
		whole.panel_posts = panels[p];
		assert_int_equal(cut(&whole, STEP), STATUS_OK);
		for (int stop = 1; stop < whole.count; stop += 7) {
			struct scene before = scene_make(101, 67, 8), again = scene_make(101, 67, 8);
			before.panel_posts = again.panel_posts = panels[p];
			before.stop_after = stop;
			assert_int_equal(cut(&before, STEP), STATUS_INTERRUPTED);
			/* It asks for posts of the bands that are not known only. */
			struct dem_cut rest = cut_of(&again, STEP);
			rest.known = known_of;
			rest.known_user = &before;
			again.skips = true;
			assert_int_equal(dem_cut(&rest), STATUS_OK);
			assert_int_equal(again.count, whole.count);
			assert_true(again.asked <= whole.asked);
			assert_true(stop < 30 || again.asked < whole.asked);
			for (int t = 0; t < again.count; t++) {
				assert_true(tile_equal(again.tiles[t].tile, whole.tiles[t].tile));
				assert_true(again.tiles[t].error == whole.tiles[t].error);
				check_tile(&again, t);
			}
			scene_free(&before);
			scene_free(&again);
		}
		scene_free(&whole);
	}
}

static void a_height_that_cannot_be_coded_is_refused_and_named(void **state)
{
	struct scene scene = scene_make(40, 30, 8);
	scene.heights[21 * 40 + 13] = (double)INFINITY;
	assert_int_equal(cut(&scene, STEP), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "13, 21"));
	scene_free(&scene);
	scene = scene_make(40, 30, 8);
	scene.heights[5 * 40 + 4] = 0.1;
	assert_int_equal(cut(&scene, 0), STATUS_INPUT); /* no float32 */
	assert_non_null(strstr(failure_message(), "4, 5"));
	scene_free(&scene);
}

/* Whether a relief can be deformed is not this layer's to say: an undeclared nodata value is cut. */
static void any_relief_that_can_be_coded_is_cut(void **state)
{
	struct scene scene = scene_make(40, 30, 8);
	scene.heights[12 * 40 + 3] = -32767;
	assert_int_equal(cut(&scene, STEP), STATUS_OK);
	assert_true(scene.tiles[scene.count - 1].low == -32767);
	for (int t = 0; t < scene.count; t++)
		check_tile(&scene, t);
	scene_free(&scene);
}

static void emitting_can_stop_it(void **state)
{
	struct scene scene = scene_make(101, 67, 8);
	scene.stop_after = 5;
	assert_int_equal(cut(&scene, STEP), STATUS_INTERRUPTED);
	assert_int_equal(scene.count, 5);
	scene_free(&scene);
}

static void every_failing_allocation_is_told(void **state)
{
	struct scene scene = scene_make(40, 30, 8);
	(void)mem_fail_nth(0, 0);
	assert_int_equal(cut(&scene, STEP), STATUS_OK);
	uint64_t made = mem_fail_nth(0, 0);
	scene_free(&scene);
	for (uint64_t nth = 1; nth <= made; nth++) {
		scene = scene_make(40, 30, 8);
		(void)mem_fail_nth(nth, 0);
		assert_int_equal(cut(&scene, STEP), STATUS_FAILED);
		(void)mem_fail_nth(0, 0);
		scene_free(&scene);
	}
}

TEST_PROGRAM(cut)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_tile_of_every_level_is_what_brute_force_says),
		cmocka_unit_test(misfits_are_those_of_every_post),
		cmocka_unit_test(terrain_without_holes_is_what_brute_force_says),
		cmocka_unit_test(a_cut_that_was_broken_off_goes_on),
		cmocka_unit_test(a_height_that_cannot_be_coded_is_refused_and_named),
		cmocka_unit_test(any_relief_that_can_be_coded_is_cut),
		cmocka_unit_test(emitting_can_stop_it),
		cmocka_unit_test(every_failing_allocation_is_told),
	};
	return cmocka_run_group_tests_name("cut", tests, NULL, NULL);
}
