/* Tiling and the pyramid against brute force: every post of every tile, ranges, errors, order. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "dem/dem.h"

#define STEP 0.5
#define TILES_MAX 4096

struct cut_tile {
	struct tile tile;
	double low, high, error;
	int32_t *codes;
};

struct scene {
	struct world world;
	double *heights;
	int64_t next_row, progress;
	struct cut_tile *tiles;
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

static enum status rows_of(void *user, int64_t y0, int64_t rows, double *heights)
{
	struct scene *scene = user;
	assert_int_equal(y0, scene->next_row); /* from the south, each once */
	assert_true(rows >= 1 && y0 + rows <= scene->world.height);
	scene->next_row += rows;
	memcpy(heights, scene->heights + y0 * scene->world.width,
	       (size_t)(rows * scene->world.width) * sizeof *heights);
	return STATUS_OK;
}

static enum status take(void *user, const struct dem_tile *tile)
{
	struct scene *scene = user;
	size_t posts = scene->world.cells + 1;
	assert_true(scene->count < TILES_MAX);
	struct cut_tile *kept = &scene->tiles[scene->count++];
	*kept = (struct cut_tile){tile->tile, tile->low, tile->high, tile->error, mem_alloc(posts * posts, 4)};
	memcpy(kept->codes, tile->codes, posts * posts * 4);
	return scene->stop_after != 0 && scene->count == scene->stop_after ? STATUS_INTERRUPTED : STATUS_OK;
}

static enum status told(void *user, int64_t done, int64_t total)
{
	struct scene *scene = user;
	assert_true(done > scene->progress && done <= total);
	assert_int_equal(total, scene->world.height);
	scene->progress = done;
	return STATUS_OK;
}

static struct scene scene_make(int64_t width, int64_t height, uint32_t cells)
{
	struct scene scene = {.world = {width, height, 1, cells}};
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
		mem_free(scene->tiles[i].codes);
	mem_free(scene->tiles);
	mem_free(scene->heights);
}

static enum status cut(struct scene *scene, double step)
{
	return dem_cut(&scene->world, step, rows_of, scene, take, scene, told, scene);
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
	if (x >= scene->world.width || y >= scene->world.height)
		return (double)NAN;
	return scene->heights[y * scene->world.width + x];
}

static double own_decimation_error(const struct scene *scene, struct tile tile)
{
	int64_t n = scene->world.cells;
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
	const struct world *world = &scene->world;
	int64_t n = world->cells;
	assert_true(world_has(world, tile->tile));
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
		if (!world_has(world, child))
			continue;
		const struct cut_tile *below = find(scene, child, index); /* it came before */
		assert_non_null(below);
		error = fmax(error, below->error + own_decimation_error(scene, child));
	}
	assert_true(fabs(tile->error - error) < 1e-9);
}

static void every_tile_of_every_level_is_what_brute_force_says(void **state)
{
	static const int64_t sizes[][2] = {{2, 2}, {9, 9}, {17, 33}, {10, 3}, {101, 67}, {64, 129}, {65, 65}};
	for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
		struct scene scene = scene_make(sizes[i][0], sizes[i][1], 8);
		assert_int_equal(cut(&scene, STEP), STATUS_OK);
		assert_int_equal(scene.progress, sizes[i][1]);
		int expected = 0;
		for (int level = 0; level <= world_coarsest(&scene.world); level++)
			expected += (int)(world_tiles_x(&scene.world, level) * world_tiles_y(&scene.world, level));
		assert_int_equal(scene.count, expected);
		for (int t = 0; t < scene.count; t++)
			check_tile(&scene, t);
		scene_free(&scene);
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
	uint64_t made = mem_fail_nth(0, 0) - (uint64_t)scene.count; /* less this test's own */
	scene_free(&scene);
	for (uint64_t nth = 1; nth <= made; nth++) {
		scene = scene_make(40, 30, 8);
		(void)mem_fail_nth(nth, 0);
		assert_int_equal(cut(&scene, STEP), STATUS_FAILED);
		(void)mem_fail_nth(0, 0);
		scene_free(&scene);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_tile_of_every_level_is_what_brute_force_says),
		cmocka_unit_test(a_height_that_cannot_be_coded_is_refused_and_named),
		cmocka_unit_test(any_relief_that_can_be_coded_is_cut),
		cmocka_unit_test(emitting_can_stop_it),
		cmocka_unit_test(every_failing_allocation_is_told),
	};
	return cmocka_run_group_tests_name("cut", tests, NULL, NULL);
}
