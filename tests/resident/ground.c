/* The base on the CPU: patches, ranges and heights against the posts they come from. */
#include "../support.h"
#include "../support/program.h"

#include "damage.h"
#include "resident/resident.h"

static const struct extent extent = {129, 97, 1.5, 32};

static double holed(int64_t x, int64_t y)
{
	return x == 50 && y == 40 ? (double)NAN : support_hills(x, y);
}

static struct store *open_store(void)
{
	const char *path = support_path("ground.furrow");
	struct store *store;
	support_store(path, extent, holed);
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	return store;
}

static void a_patch_subdivides_to_the_interpolated_tile(void **state)
{
	struct store *store = open_store();
	struct ground *ground;
	must(resident_ground_create(store, 2, &ground));
	enum { N = 32 };
	int32_t patch[(N + 1) * (N + 1)], posts[(N + 1) * (N + 1)];
	for (int level = -7; level < 0; level++) {
		int holes = 0;
		for (int i = 0; i < 6; i++) {
			int shift;
			uint32_t sub_x, sub_y;
			struct tile tile = {level, (uint32_t)(i * 37) % extent_tiles_x(&extent, level),
					    (uint32_t)(i * 53) % extent_tiles_y(&extent, level)};
			if (i == 5) /* the one with the hole */
				tile = (struct tile){level, (50u << -level) / N, (40u << -level) / N};
			must(resident_ground_patch(ground, tile, patch, &shift, &sub_x, &sub_y));
			assert_int_equal(shift, -level);
			lattice_subdivide(patch, N, shift, sub_x, sub_y, posts);
			/* store_read_posts goes its own way to the same posts. */
			struct post_rect rect = tile_post_rect(&extent, tile);
			double *expected = malloc(sizeof(double) * (N + 1) * (N + 1));
			must(store_read_posts(resident_ground_reader(ground), STORE_BASE, level, rect, expected));
			for (int k = 0; k < (N + 1) * (N + 1); k++) {
				holes += posts[k] == BASE_NODATA;
				if (posts[k] == BASE_NODATA)
					assert_true(isnan(expected[k]));
				else
					assert_true(resident_ground_reference(store) + lattice_base_metres(posts[k]) == expected[k]);
			}
			free(expected);
		}
		assert_true(holes > 0);
	}
	resident_ground_destroy(ground);
	store_close(store);
}

/* How far the middle of each cell's bilinear ground is from its diagonal: from the tile's own posts, which the store gives. */
static void a_bend_is_what_triangles_between_the_posts_are_off(void **state)
{
	struct store *store = open_store();
	struct ground *ground;
	enum { N = 32 };
	static double posts[(N + 1) * (N + 1)];
	int curved = 0;
	must(resident_ground_create(store, 2, &ground));
	for (int level = 0; level >= -7; level--)
		for (uint32_t i = 0; i < 8; i++) {
			const struct tile tile = {level, i * 37 % extent_tiles_x(&extent, level), i * 53 % extent_tiles_y(&extent, level)};
			const struct post_rect whole = {0, 0, extent_posts(extent.width, level), extent_posts(extent.height, level)};
			const struct post_rect rect = post_rect_intersect(tile_post_rect(&extent, tile), whole);
			const int64_t width = rect.x1 - rect.x0;
			double most = 0, bend, again;
			must(store_read_posts(resident_ground_reader(ground), STORE_BASE, level, rect, posts));
			for (int64_t y = 0; y + 1 < rect.y1 - rect.y0; y++)
				for (int64_t x = 0; x + 1 < width; x++) {
					const double *a = posts + y * width + x, *c = a + width;
					const double off = fabs((a[0] + a[1] + c[0] + c[1]) / 4 - (a[0] + c[1]) / 2);
					most = off > most ? off : most; /* not if NaN */
				}
			must(resident_ground_bend(ground, tile, &bend));
			must(resident_ground_bend(ground, tile, &again));
			assert_true(bend == again && resident_ground_has_bend(ground, tile));
			/* finer posts are rounded to the lattice; a tile smaller than a cell has only a part of it, and all cells bend alike */
			assert_true(fabs(bend - most) <= 0x1p-17);
			curved += bend > 0.001;
		}
	assert_true(curved > 20);
	resident_ground_destroy(ground);
	store_close(store);
}

/* No post of a rectangle is above what is said of it, and below a level's own posts that is no more than the source's. */
static void the_highest_is_that_of_the_posts_it_comes_from(void **state)
{
	struct store *store = open_store();
	struct ground *ground;
	must(resident_ground_create(store, 2, &ground));
	static const int levels[] = {-5, -3, -1, 0, 1, 2};
	for (int l = 0; l < 6; l++)
		for (int i = 0; i < 60; i++) {
			int level = levels[l], shift = level < 0 ? -level : 0;
			int64_t width = extent_posts(extent.width, level), height = extent_posts(extent.height, level);
			/* Along tile edges too, and over those of the world. */
			int64_t x = (i % 4 == 0 ? i % 3 * 32 : i * 7919) % width, y = (i % 5 == 0 ? i % 2 * 64 : i * 104729) % height;
			struct post_rect rect = {x - i % 3, y - i % 2, x + 1 + i * 5 % 40, y + 1 + i * 3 % 23}, in;
			int64_t highest, expected = INT64_MIN, own = INT64_MIN;
			must(resident_ground_highest(ground, level, rect, &highest));
			in = post_rect_intersect(rect, (struct post_rect){0, 0, width, height});
			const struct post_rect source = {in.x0 >> shift, in.y0 >> shift, ((in.x1 - 1 + (1 << shift) - 1) >> shift) + 1,
							 ((in.y1 - 1 + (1 << shift) - 1) >> shift) + 1};
			const struct post_rect rects[2] = {in, source};
			for (int k = 0; k < 2; k++) {
				int64_t count = (rects[k].x1 - rects[k].x0) * (rects[k].y1 - rects[k].y0);
				double *posts = malloc((size_t)count * sizeof *posts);
				must(store_read_posts(resident_ground_reader(ground), STORE_BASE, k == 0 || level > 0 ? level : 0, rects[k], posts));
				int64_t *most = k == 0 ? &own : &expected;
				for (int64_t p = 0; p < count; p++)
					if (!isnan(posts[p])) {
						int64_t reference = resident_ground_reference(store);
						int64_t post = (int64_t)lattice_base_relative(posts[p], (int32_t)reference) * 4 + reference * (1 << OFFSET_BITS);
						*most = post > *most ? post : *most;
					}
				free(posts);
			}
			assert_true(highest > INT64_MIN && highest == expected && own <= highest);
			assert_true(level < 0 || own == highest);
		}
	/* A hole has none, nor has what lies beyond the world. */
	int64_t highest;
	must(resident_ground_highest(ground, 0, (struct post_rect){50, 40, 51, 41}, &highest));
	assert_true(highest == INT64_MIN);
	must(resident_ground_highest(ground, 0, (struct post_rect){50, 40, 52, 41}, &highest));
	assert_true(highest > INT64_MIN);
	must(resident_ground_highest(ground, -2, (struct post_rect){-9, 4, 0, 9}, &highest));
	assert_true(highest == INT64_MIN);
	/* The last post of the world, whose tile it ends. */
	must(resident_ground_highest(ground, 0, (struct post_rect){128, 96, 129, 97}, &highest));
	assert_true(fabs(lattice_offset_metres(highest) - support_hills(128, 96)) < 1.0 / 1024);
	resident_ground_destroy(ground);
	store_close(store);
}

/* Of two tiles beside one another, posts of the first's edge alone ask for but one. */
static void the_highest_asks_for_no_tile_it_does_not_need(void **state)
{
	struct store *store = open_store();
	struct ground *ground;
	struct resident_ground_figures before, after;
	int64_t highest;
	must(resident_ground_create(store, 4, &ground));
	must(resident_ground_highest(ground, 0, (struct post_rect){3, 3, 33, 33}, &highest));
	resident_ground_figures(ground, &before);
	assert_int_equal(before.reads, 1);
	must(resident_ground_highest(ground, 0, (struct post_rect){3, 3, 34, 33}, &highest));
	resident_ground_figures(ground, &after);
	assert_int_equal(after.reads, 2);
	resident_ground_destroy(ground);
	store_close(store);
}

static void a_height_is_bilinear_and_misses_only_holes_and_the_outside(void **state)
{
	struct store *store = open_store();
	struct ground *ground;
	must(resident_ground_create(store, 2, &ground));
	int64_t height;
	bool any;
	const double a[][3] = {{0, 0, 1}, {192, 144, 1}, {192.001, 10, 0}, {-0.001, 10, 0}, {75, 60, 0}, {74.9, 60.7, 0},
			       {76.5, 60, 1}, {76.5, 61, 1}};
	for (size_t i = 0; i < sizeof a / sizeof *a; i++) {
		must(resident_ground_height(ground, lattice_offset(a[i][0]), lattice_offset(a[i][1]), &height, &any));
		assert_int_equal(any, a[i][2] != 0);
	}
	/* A third of the way through the cell of posts 10, 20 (off a dyadic place: 2^-20 m / 1.5 m). */
	must(resident_ground_height(ground, lattice_offset(15.5), lattice_offset(31), &height, &any));
	double u = 15.5 / 1.5 - 10, v = 31 / 1.5 - 20, expected = 0;
	for (int k = 0; k < 4; k++) {
		double metres = round(support_hills(10 + k % 2, 20 + k / 2) * 1024) / 1024;
		expected += metres * (k % 2 ? u : 1 - u) * (k / 2 ? v : 1 - v);
	}
	assert_true(any && fabs(lattice_offset_metres(height) - expected) < 1e-5);
	resident_ground_destroy(ground);
	store_close(store);
}

static void a_range_bounds_every_post_below_it(void **state)
{
	struct store *store = open_store();
	struct ground *ground;
	must(resident_ground_create(store, 2, &ground));
	for (int level = -5; level <= extent_coarsest(&extent); level++) {
		struct tile tile = {level, extent_tiles_x(&extent, level) / 2, extent_tiles_y(&extent, level) / 3};
		double low, high;
		bool any;
		must(resident_ground_range(ground, tile, &low, &high, &any));
		assert_true(any);
		struct post_rect rect = tile_post_rect(&extent, tile);
		double *posts = malloc(sizeof(double) * 33 * 33);
		must(store_read_posts(resident_ground_reader(ground), STORE_BASE, level, rect, posts));
		int there = 0;
		for (int k = 0; k < 33 * 33; k++) {
			assert_true(isnan(posts[k]) || (posts[k] >= low - 1e-5 && posts[k] <= high + 1e-5));
			there += !isnan(posts[k]);
		}
		assert_true(there > 0);
		free(posts);
	}
	resident_ground_destroy(ground);
	store_close(store);
}


static struct store_reader *open_reader(struct store *store)
{
	struct store_reader *reader;
	must(store_reader_create(store, &reader));
	return reader;
}

static uint64_t waits(struct ground *ground)
{
	struct resident_ground_figures figures;
	resident_ground_figures(ground, &figures);
	assert_true((figures.waits > 0) == (figures.wait_ms > 0) && figures.reads >= figures.waits);
	return figures.waits;
}

static struct tile tile_at(int i)
{
	return (struct tile){0, (uint32_t)i % extent_tiles_x(&extent, 0), (uint32_t)i / extent_tiles_x(&extent, 0)};
}

/* Some post of a tile, as its owner asks for it. */
static void use(struct ground *ground, struct tile tile, int salt)
{
	uint32_t n = extent.cells;
	int64_t x = tile.x * n + 1 + (uint32_t)(salt * 7) % (n - 1), y = tile.y * n + 1 + (uint32_t)(salt * 11) % (n - 1);
	int64_t height;
	bool any;
	must(resident_ground_height(ground, lattice_offset((double)x * 1.5), lattice_offset((double)y * 1.5), &height, &any));
	assert_int_equal(any, !isnan(holed(x, y)));
	double metres = round(support_hills(x, y) * 1024) / 1024;
	assert_true(!any || fabs(lattice_offset_metres(height) - metres) < 1e-5);
}

static void what_was_warmed_is_found_without_a_wait(void **state)
{
	struct store *store = open_store();
	struct store_reader *reader = open_reader(store);
	struct ground *ground;
	must(resident_ground_create(store, 12, &ground));
	for (int i = 0; i < 12; i++) {
		assert_false(resident_ground_touch(ground, tile_at(i)));
		if (i % 2 == 0)
			must(resident_ground_warm(ground, reader, tile_at(i)));
	}
	for (int i = 0; i < 12; i += 2)
		use(ground, tile_at(i), i);
	assert_int_equal(waits(ground), 0);
	for (int i = 0; i < 12; i++)
		use(ground, tile_at(i), i);
	assert_int_equal(waits(ground), 6);
	/* The same posts, whoever read them. */
	int32_t warmed[33 * 33], read[33 * 33];
	struct ground *other;
	must(resident_ground_create(store, 1, &other));
	for (int i = 0; i < 12; i++) {
		must(resident_ground_posts(ground, tile_at(i), warmed));
		must(resident_ground_posts(other, tile_at(i), read));
		assert_memory_equal(warmed, read, sizeof read);
	}
	assert_int_equal(waits(ground), 6);
	assert_int_equal(waits(other), 12);
	struct resident_ground_figures figures;
	resident_ground_figures(ground, &figures);
	assert_int_equal(figures.reads, 12);
	resident_ground_destroy(other);
	resident_ground_destroy(ground);
	store_reader_destroy(reader);
	store_close(store);
}

static void warming_evicts_what_was_used_longest_ago_and_never_the_owners_last(void **state)
{
	struct store *store = open_store();
	struct store_reader *reader = open_reader(store);
	struct ground *ground;
	must(resident_ground_create(store, 3, &ground));
	for (int i = 0; i < 3; i++)
		must(resident_ground_warm(ground, reader, tile_at(i)));
	assert_true(resident_ground_touch(ground, tile_at(0)));
	must(resident_ground_warm(ground, reader, tile_at(1))); /* there already: used again, not read again */
	must(resident_ground_warm(ground, reader, tile_at(3)));
	assert_true(resident_ground_touch(ground, tile_at(0)) && resident_ground_touch(ground, tile_at(1)) && resident_ground_touch(ground, tile_at(3)));
	assert_false(resident_ground_touch(ground, tile_at(2)));
	resident_ground_destroy(ground);
	for (uint32_t tiles = 1; tiles <= 3; tiles++) {
		must(resident_ground_create(store, tiles, &ground));
		use(ground, tile_at(0), 1);
		for (int i = 1; i < 12; i++) {
			must(resident_ground_warm(ground, reader, tile_at(i)));
			use(ground, tile_at(0), i);
		}
		assert_int_equal(waits(ground), 1);
		/* The owner's own miss takes any. */
		use(ground, tile_at(5), 1);
		assert_int_equal(resident_ground_touch(ground, tile_at(0)), tiles > 1);
		resident_ground_destroy(ground);
	}
	store_reader_destroy(reader);
	store_close(store);
}

static void a_tile_that_cannot_be_warmed_changes_nothing(void **state)
{
	struct tile none = tile_at(7);
	support_store(support_path("ground.furrow"), extent, holed);
	damage(support_path("ground.furrow"), none);
	struct store *store;
	must(store_open(support_path("ground.furrow"), &(struct store_options){.mode = STORE_READ}, &store));
	struct store_reader *reader = open_reader(store);
	struct ground *ground;
	must(resident_ground_create(store, 2, &ground));
	must(resident_ground_warm(ground, reader, tile_at(0)));
	must(resident_ground_warm(ground, reader, tile_at(1)));
	for (int i = 0; i < 5; i++)
		assert_int_equal(resident_ground_warm(ground, reader, none), STATUS_INPUT);
	assert_false(resident_ground_touch(ground, none));
	must(resident_ground_warm(ground, reader, tile_at(2)));
	assert_true(resident_ground_touch(ground, tile_at(1)) && resident_ground_touch(ground, tile_at(2)));
	resident_ground_destroy(ground);
	must(resident_ground_create(store, 2, &ground));
	mem_fail_nth(1, 0);
	assert_int_equal(resident_ground_warm(ground, reader, tile_at(4)), STATUS_FAILED);
	mem_fail_nth(0, 0);
	must(resident_ground_warm(ground, reader, tile_at(4)));
	use(ground, tile_at(4), 1);
	assert_int_equal(waits(ground), 0);
	resident_ground_destroy(ground);
	store_reader_destroy(reader);
	store_close(store);
}

struct hammer {
	struct thread thread;
	struct ground *ground;
	struct store_reader *reader;
	uint32_t random;
};

enum { BLOWS = 3000 };

static void *hammer_body(void *argument)
{
	struct hammer *hammer = argument;
	for (int i = 0; i < BLOWS; i++) {
		hammer->random = hammer->random * 1664525 + 1013904223;
		struct tile tile = tile_at((int)((hammer->random >> 16) % 12));
		if (i % 5 == 0)
			resident_ground_touch(hammer->ground, tile);
		else if (resident_ground_warm(hammer->ground, hammer->reader, tile) != STATUS_OK)
			return hammer;
	}
	return NULL;
}

static void an_owner_reads_right_while_two_threads_warm(void **state)
{
	struct store *store = open_store();
	const uint32_t tiles[] = {1, 2, 5};
	for (size_t t = 0; t < 3; t++) {
		struct ground *ground;
		must(resident_ground_create(store, tiles[t], &ground));
		struct hammer hammers[2] = {{.random = 1}, {.random = 2}};
		for (int i = 0; i < 2; i++) {
			hammers[i].ground = ground;
			hammers[i].reader = open_reader(store);
			must(thread_start(&hammers[i].thread, hammer_body, &hammers[i], "hammer"));
		}
		int32_t patch[33 * 33];
		for (int i = 0; i < BLOWS; i++) {
			int shift;
			uint32_t sub_x, sub_y;
			double low, high;
			bool any;
			use(ground, tile_at(i * 5 % 12), i);
			if (i % 7 == 0)
				must(resident_ground_patch(ground, (struct tile){-2, 3, 2}, patch, &shift, &sub_x, &sub_y));
			if (i % 11 == 0)
				must(resident_ground_range(ground, (struct tile){-1, 5, 1}, &low, &high, &any));
		}
		for (int i = 0; i < 2; i++) {
			void *failed;
			assert_int_equal(pthread_join(hammers[i].thread.handle, &failed), 0);
			assert_null(failed);
			store_reader_destroy(hammers[i].reader);
		}
		resident_ground_destroy(ground);
	}
	store_close(store);
}

static void *all_body(void *argument)
{
	struct hammer *hammer = argument;
	for (int i = 0; i < 12; i++)
		if (resident_ground_warm(hammer->ground, hammer->reader, tile_at(i)) != STATUS_OK)
			return hammer;
	return NULL;
}

static void two_threads_that_bring_the_same_tiles_leave_one_of_each(void **state)
{
	struct store *store = open_store();
	struct hammer hammers[2] = {{.reader = open_reader(store)}, {.reader = open_reader(store)}};
	for (int round = 0; round < 100; round++) {
		struct ground *ground;
		must(resident_ground_create(store, 12, &ground));
		for (int i = 0; i < 2; i++) {
			hammers[i].ground = ground;
			must(thread_start(&hammers[i].thread, all_body, &hammers[i], "hammer"));
		}
		for (int i = 0; i < 2; i++)
			thread_join(&hammers[i].thread);
		for (int i = 0; i < 12; i++)
			assert_true(resident_ground_touch(ground, tile_at(i)));
		resident_ground_destroy(ground);
	}
	for (int i = 0; i < 2; i++)
		store_reader_destroy(hammers[i].reader);
	store_close(store);
}

TEST_PROGRAM(ground)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_patch_subdivides_to_the_interpolated_tile),
		cmocka_unit_test(a_bend_is_what_triangles_between_the_posts_are_off),
		cmocka_unit_test(the_highest_is_that_of_the_posts_it_comes_from),
		cmocka_unit_test(the_highest_asks_for_no_tile_it_does_not_need),
		cmocka_unit_test(a_height_is_bilinear_and_misses_only_holes_and_the_outside),
		cmocka_unit_test(a_range_bounds_every_post_below_it),
		cmocka_unit_test(what_was_warmed_is_found_without_a_wait),
		cmocka_unit_test(warming_evicts_what_was_used_longest_ago_and_never_the_owners_last),
		cmocka_unit_test(a_tile_that_cannot_be_warmed_changes_nothing),
		cmocka_unit_test(two_threads_that_bring_the_same_tiles_leave_one_of_each),
		cmocka_unit_test(an_owner_reads_right_while_two_threads_warm),
	};
	return cmocka_run_group_tests_name("ground", tests, support_enter, support_leave);
}
