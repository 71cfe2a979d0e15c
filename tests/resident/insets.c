/* Base heights where insets lie, by every way to them, against a second way. Tiles of any size. */
#include "../support.h"
#include "../support/program.h"

#include <sqlite3.h>

#include "insets.h"

static const uint32_t sizes[] = {8, 16, 64};

static struct store *open_insets(uint32_t cells)
{
	struct store *store;
	must(store_open(insets_store(cells), &(struct store_options){.mode = STORE_READ}, &store));
	return store;
}

static void the_store_says_how_fine_it_is(void **state)
{
	struct store *store = open_insets(16);
	struct store_check check;
	assert_int_equal(store_finest_base(store), INSETS_FINEST);
	assert_int_equal(store_finest(store), INSETS_FINEST);
	must(store_verify(store, support_print_problem, NULL, NULL, &check));
	assert_int_equal(check.problems, 0);
	store_close(store);
	support_store(support_path("plain.furrow"), (struct extent){65, 49, 4, 16}, support_hills);
	must(store_open(support_path("plain.furrow"), &(struct store_options){.mode = STORE_READ}, &store));
	assert_int_equal(store_finest_base(store), 0);
	store_close(store);
}

static void every_post_is_that_of_the_finest_level_that_has_it(void **state)
{
	for (int i = 0; i < 3; i++) {
		struct store *store = open_insets(sizes[i]);
		struct store_reader *reader;
		must(store_reader_create(store, &reader));
		for (int level = INSETS_FINEST - 2; level <= 0; level++) {
			/* all of it, or what lies around the inner inset */
			const int64_t m = (int64_t)1 << -level;
			const struct post_rect rect = level > -3 ? (struct post_rect){0, 0, extent_posts(65, level), extent_posts(49, level)}
								 : (struct post_rect){18 * m, 17 * m, 24 * m, 20 * m};
			const int64_t width = rect.x1 - rect.x0;
			double *values = malloc(sizeof *values * (size_t)(width * (rect.y1 - rect.y0)));
			must(store_read_posts(reader, STORE_BASE, level, rect, values));
			for (int64_t y = rect.y0; y < rect.y1; y++)
				for (int64_t x = rect.x0; x < rect.x1; x++) {
					const int32_t base = insets_base(level, x, y);
					const double value = values[(y - rect.y0) * width + x - rect.x0];
					if (base == BASE_NODATA ? !isnan(value) : value != lattice_base_metres(base))
						fail_msg("tiles of %u, level %d, post %lld %lld: %g, not %g", sizes[i], level, (long long)x,
							 (long long)y, value, lattice_base_metres(base));
				}
			free(values);
		}
		store_reader_destroy(reader);
		store_close(store);
	}
}

static void a_loaded_tile_has_the_same_posts(void **state)
{
	for (int i = 0; i < 3; i++) {
		const uint32_t n = sizes[i];
		struct store *store = open_insets(n);
		const struct extent *extent = &store_meta(store)->extent;
		struct ground *ground;
		int32_t *posts = malloc(sizeof *posts * 3 * (n + 1) * (n + 1)), *patch = posts + (n + 1) * (n + 1), *divided = patch + (n + 1) * (n + 1);
		int patches = 0, wholes = 0;
		must(resident_ground_create(store, 2, &ground));
		for (int level = INSETS_FINEST - 1; level < 0; level++)
			for (uint32_t ty = 0; ty < extent_tiles_y(extent, level); ty++)
				for (uint32_t tx = 0; tx < extent_tiles_x(extent, level); tx++) {
					const struct tile tile = {level, tx, ty};
					int shift;
					uint32_t sub_x, sub_y;
					if (level < -1 && (tx + 3 * ty) % 29 != 0 && !insets_inner((int64_t)tx * n / 2, (int64_t)ty * n / 2))
						continue;
					must(resident_ground_posts(ground, tile, posts));
					must(resident_ground_patch(ground, tile, patch, &shift, &sub_x, &sub_y));
					if (shift > 0)
						lattice_subdivide(patch, n, shift, sub_x, sub_y, divided);
					*(shift > 0 ? &patches : &wholes) += 1;
					assert_memory_equal(posts, shift > 0 ? divided : patch, sizeof *posts * (n + 1) * (n + 1));
					for (uint32_t y = 0; y <= n; y++)
						for (uint32_t x = 0; x <= n; x++)
							if (insets_within(level, (int64_t)tx * n + x, (int64_t)ty * n + y))
								assert_int_equal(posts[y * (n + 1) + x],
										 insets_base(level, (int64_t)tx * n + x, (int64_t)ty * n + y));
				}
		assert_true(patches > 0 && wholes > 0);
		free(posts);
		resident_ground_destroy(ground);
		store_close(store);
	}
}

/* The bilinear height in the cell of the finest level whose posts around are stored. */
static double height_at(double x, double y, int *level)
{
	for (*level = INSETS_FINEST; *level <= 0; ++*level) {
		const double px = ldexp(x / 4, -*level), py = ldexp(y / 4, -*level);
		const int64_t cx = (int64_t)px, cy = (int64_t)py;
		const double u = px - (double)cx, v = py - (double)cy;
		double sum = 0;
		bool all = true;
		for (int i = 0; i < 4; i++) {
			const double weight = (i % 2 ? u : 1 - u) * (i / 2 ? v : 1 - v);
			bool stored = true;
			const int32_t code = weight != 0 ? insets_code(*level, cx + i % 2, cy + i / 2, &stored) : 0;
			all = all && stored && code != HEIGHT_CODE_NODATA;
			sum += weight * code * INSETS_STEP;
		}
		if (all)
			return sum;
	}
	return (double)NAN;
}

/* The bilinear height in the cell of a level, between posts that are stored or not. */
static double tile_height_at(double x, double y, int level)
{
	const double px = ldexp(x / 4, -level), py = ldexp(y / 4, -level);
	const int64_t cx = (int64_t)px, cy = (int64_t)py;
	double corners[4];
	for (int i = 0; i < 4; i++) {
		const int32_t base = insets_base(level, cx + i % 2, cy + i / 2);
		corners[i] = base == BASE_NODATA ? (double)NAN : lattice_base_metres(base);
	}
	return lattice_bilinear(corners, px - (double)cx, py - (double)cy, 0);
}

static void a_point_is_in_the_cell_of_the_finest_level(void **state)
{
	int levels[3] = {0};
	for (int i = 0; i < 3; i++) {
		struct store *store = open_insets(sizes[i]);
		struct ground *ground;
		struct newest *newest;
		must(resident_ground_create(store, 3, &ground));
		must(resident_newest_create(store, NULL, &newest));
		for (int k = 0; k < 400; k++) {
			/* over all of it, and around the inner inset */
			const double share[2] = {(k * 977 % 4001) / 4001.0, (k * 1613 % 4003) / 4003.0};
			const double x = k % 2 ? 256 * share[0] : 70 + 28 * share[0], y = k % 2 ? 192 * share[1] : 66 + 18 * share[1];
			int level;
			const double wanted = height_at(x, y, &level);
			int64_t height;
			bool any;
			struct store_sample sample;
			struct resident_height found;
			must(resident_ground_height(ground, lattice_offset(x), lattice_offset(y), &height, &any));
			must(store_sample(resident_ground_reader(ground), x, y, &sample));
			must(resident_newest_heights(newest, &(struct resident_point){x, y}, 1, &found));
			assert_int_equal(any, !isnan(wanted));
			assert_int_equal(sample.nodata, isnan(wanted));
			assert_int_equal(found.nodata, isnan(wanted));
			if (isnan(wanted))
				continue;
			levels[level == 0 ? 0 : level == -2 ? 1 : 2]++;
			assert_true(fabs(lattice_offset_metres(height) - wanted) < 1e-4);
			assert_true(fabs(sample.height - wanted) < 1e-5);
			/* the level of the tile there: in a cell that an inset has in part, posts that it lacks are interpolated */
			assert_true(found.level <= level && fabs(found.bilinear - tile_height_at(x, y, found.level)) < 1e-4);
		}
		resident_newest_destroy(newest);
		resident_ground_destroy(ground);
		store_close(store);
	}
	assert_true(levels[0] > 100 && levels[1] > 100 && levels[2] > 20);
}

static void ranges_and_bounds_hold_every_post(void **state)
{
	for (int i = 0; i < 3; i++) {
		const int64_t n = sizes[i];
		struct store *store = open_insets(sizes[i]);
		const struct extent *extent = &store_meta(store)->extent;
		struct ground *ground, *warmed;
		struct store_reader *reader;
		must(resident_ground_create(store, 2, &ground));
		must(resident_ground_create(store, 2, &warmed));
		must(store_reader_create(store, &reader));
		for (int level = INSETS_FINEST - 1; level <= 0; level++)
			for (uint32_t k = 0; k < 60; k++) {
				const struct tile tile = {level, k * 37 % extent_tiles_x(extent, level), k * 53 % extent_tiles_y(extent, level)};
				double low, high, its[2];
				bool any, too;
				int64_t highest, most = INT64_MIN;
				must(resident_ground_range(ground, tile, &low, &high, &any));
				must(resident_ground_warm_range(warmed, reader, &(struct ground_range_key){GROUND_BASE, tile}));
				assert_true(resident_ground_has_range(warmed, &(struct ground_range_key){GROUND_BASE, tile}));
				must(resident_ground_range(warmed, tile, &its[0], &its[1], &too));
				assert_true(any == too && (!any || (its[0] == low && its[1] == high)));
				must(resident_ground_highest(ground, level, tile_post_rect(extent, tile), &highest));
				for (int64_t y = tile.y * n; y <= tile.y * n + n; y++)
					for (int64_t x = tile.x * n; x <= tile.x * n + n; x++) {
						const int32_t base = insets_within(level, x, y) ? insets_base(level, x, y) : BASE_NODATA;
						if (base == BASE_NODATA)
							continue;
						assert_true(any && lattice_base_metres(base) >= low && lattice_base_metres(base) <= high);
						most = base > most ? base : most;
					}
				assert_true(most == INT64_MIN || (highest >= 4 * most && highest <= lattice_offset(high)));
			}
		store_reader_destroy(reader);
		resident_ground_destroy(warmed);
		resident_ground_destroy(ground);
		store_close(store);
	}
}

/* --- what verify finds --- */

static void keep_problem(void *user, const char *text)
{
	char *first = user;
	if (first[0] == '\0')
		snprintf(first, 256, "%s", text);
}

/* Adds `by` to one post of a tile's row, with a hash that fits. */
static void change_post(const char *path, struct tile tile, int64_t x, int64_t y, int32_t by)
{
	struct store_meta meta;
	struct store *store, *old;
	struct store_reader *reader;
	const char *copy = support_path("changed.furrow");
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &old));
	must(store_reader_create(old, &reader));
	meta = *store_meta(old);
	const size_t side = meta.extent.cells + 1;
	int32_t *codes = malloc(sizeof *codes * side * side);
	must(store_create(copy, &meta, true, &store));
	for (int level = INSETS_FINEST; level <= extent_coarsest(&meta.extent); level++)
		for (uint32_t ty = 0; ty < extent_tiles_y(&meta.extent, level); ty++)
			for (uint32_t tx = 0; tx < extent_tiles_x(&meta.extent, level); tx++) {
				struct store_range range;
				bool found;
				const struct tile at = {level, tx, ty};
				must(store_find_base(reader, at, codes, &range, &found));
				if (found && tile_equal(at, tile))
					codes[(size_t)y * side + (size_t)x] += by;
				if (found)
					must(store_put_base(store, at, codes, &range));
			}
	must(store_publish(store));
	store_close(store);
	store_reader_destroy(reader);
	store_close(old);
	free(codes);
}

static void a_broken_inset_is_found(void **state)
{
	static const struct {
		struct tile tile;
		int64_t x, y;
		const char *told;
	} breaks[] = {
		/* a post on an edge of the inner inset, one that a coarser level has too, and one of the level between */
		{{-4, 20, 18}, 16, 5, "its east edge is not its neighbour's west edge"},
		{{-4, 20, 18}, 4, 2, "it does not have every second post"},
		{{-2, 3, 4}, 16, 3, "its east edge is not its neighbour's west edge"},
		{{-1, 2, 2}, 8, 8, "it does not have every second post"},
	};
	for (size_t i = 0; i < sizeof breaks / sizeof *breaks; i++) {
		struct store *store;
		struct store_check check;
		char first[256] = "";
		change_post(insets_store(16), breaks[i].tile, breaks[i].x, breaks[i].y, 1);
		must(store_open(support_path("changed.furrow"), &(struct store_options){.mode = STORE_READ}, &store));
		must(store_verify(store, keep_problem, NULL, first, &check));
		assert_true(check.problems > 0);
		if (strstr(first, breaks[i].told) == NULL)
			fail_msg("break %zu: %s", i, first);
		store_close(store);
	}
}

static void a_missing_inset_tile_is_found(void **state)
{
	const char *path = insets_store(32); /* no other test's */
	sqlite3 *db;
	char sql[128], first[256] = "";
	snprintf(sql, sizeof sql, "DELETE FROM base WHERE key = %lld", (long long)tile_key((struct tile){-2, 2, 2}));
	assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
	assert_int_equal(sqlite3_exec(db, sql, NULL, NULL, NULL), SQLITE_OK);
	assert_int_equal(sqlite3_changes(db), 1);
	assert_int_equal(sqlite3_close(db), SQLITE_OK);
	struct store *store;
	struct store_check check;
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	must(store_verify(store, keep_problem, NULL, first, &check));
	assert_true(check.problems > 1);
	assert_non_null(strstr(first, "there is no tile above it"));
	store_close(store);
}

TEST_PROGRAM(insets)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_store_says_how_fine_it_is),
		cmocka_unit_test(every_post_is_that_of_the_finest_level_that_has_it),
		cmocka_unit_test(a_loaded_tile_has_the_same_posts),
		cmocka_unit_test(a_point_is_in_the_cell_of_the_finest_level),
		cmocka_unit_test(ranges_and_bounds_hold_every_post),
		cmocka_unit_test(a_broken_inset_is_found),
		cmocka_unit_test(a_missing_inset_tile_is_found),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
