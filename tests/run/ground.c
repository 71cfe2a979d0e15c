/* The base on the CPU: patches, ranges and heights against the posts they come from. */
#include "../support.h"

#include "run/ground.h"

static const struct world world = {129, 97, 1.5, 32};

static double holed(int64_t x, int64_t y)
{
	return x == 50 && y == 40 ? (double)NAN : support_hills(x, y);
}

static struct store *open_store(void)
{
	const char *path = support_path("ground.furrow");
	struct store *store;
	support_store(path, world, holed);
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	return store;
}

static void a_patch_subdivides_to_the_interpolated_tile(void **state)
{
	struct store *store = open_store();
	struct ground *ground;
	must(ground_create(store, 2, &ground));
	enum { N = 32 };
	int32_t patch[(N + 1) * (N + 1)], posts[(N + 1) * (N + 1)];
	for (int level = -7; level < 0; level++)
		for (int i = 0; i < 6; i++) {
			int shift;
			uint32_t sub_x, sub_y;
			struct tile tile = {level, (uint32_t)(i * 37) % world_tiles_x(&world, level),
					    (uint32_t)(i * 53) % world_tiles_y(&world, level)};
			must(ground_patch(ground, tile, patch, &shift, &sub_x, &sub_y));
			assert_int_equal(shift, -level);
			lattice_subdivide(patch, N, shift, sub_x, sub_y, posts);
			/* store_read_posts goes its own way to the same posts. */
			struct post_rect rect = tile_post_rect(&world, tile);
			double *expected = malloc(sizeof(double) * (N + 1) * (N + 1));
			must(store_read_posts(ground_reader(ground), STORE_BASE, level, rect, expected));
			for (int k = 0; k < (N + 1) * (N + 1); k++) {
				if (posts[k] == BASE_NODATA)
					assert_true(isnan(expected[k]));
				else
					assert_true(ground_reference(store) + lattice_base_metres(posts[k]) == expected[k]);
			}
			free(expected);
		}
	ground_destroy(ground);
	store_close(store);
}

static void a_height_is_bilinear_and_misses_only_holes_and_the_outside(void **state)
{
	struct store *store = open_store();
	struct ground *ground;
	must(ground_create(store, 2, &ground));
	int64_t height;
	bool any;
	const double a[][3] = {{0, 0, 1}, {192, 144, 1}, {192.001, 10, 0}, {-0.001, 10, 0}, {75, 60, 0}, {74.9, 60.7, 0},
			       {76.5, 60, 1}, {76.5, 61, 1}};
	for (size_t i = 0; i < sizeof a / sizeof *a; i++) {
		must(ground_height(ground, lattice_offset(a[i][0]), lattice_offset(a[i][1]), &height, &any));
		assert_int_equal(any, a[i][2] != 0);
	}
	/* A third of the way through the cell of posts 10, 20 (off a dyadic place: 2^-20 m / 1.5 m). */
	must(ground_height(ground, lattice_offset(15.5), lattice_offset(31), &height, &any));
	double u = 15.5 / 1.5 - 10, v = 31 / 1.5 - 20, expected = 0;
	for (int k = 0; k < 4; k++) {
		double metres = round(support_hills(10 + k % 2, 20 + k / 2) * 1024) / 1024;
		expected += metres * (k % 2 ? u : 1 - u) * (k / 2 ? v : 1 - v);
	}
	assert_true(any && fabs(lattice_offset_metres(height) - expected) < 1e-5);
	ground_destroy(ground);
	store_close(store);
}

static void a_range_bounds_every_post_below_it(void **state)
{
	struct store *store = open_store();
	struct ground *ground;
	must(ground_create(store, 2, &ground));
	for (int level = -5; level <= world_coarsest(&world); level++) {
		struct tile tile = {level, world_tiles_x(&world, level) / 2, world_tiles_y(&world, level) / 3};
		double low, high;
		bool any;
		must(ground_range(ground, tile, &low, &high, &any));
		assert_true(any);
		struct post_rect rect = tile_post_rect(&world, tile);
		double *posts = malloc(sizeof(double) * 33 * 33);
		must(store_read_posts(ground_reader(ground), STORE_BASE, level, rect, posts));
		for (int k = 0; k < 33 * 33; k++)
			assert_true(isnan(posts[k]) || (posts[k] >= low - 1e-5 && posts[k] <= high + 1e-5));
		free(posts);
	}
	ground_destroy(ground);
	store_close(store);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_patch_subdivides_to_the_interpolated_tile),
		cmocka_unit_test(a_height_is_bilinear_and_misses_only_holes_and_the_outside),
		cmocka_unit_test(a_range_bounds_every_post_below_it),
	};
	return cmocka_run_group_tests_name("ground", tests, support_enter, support_leave);
}
