/* The ground with relief over nested insets: posts, points, ranges and the store's own readers, each against one formula for a post. */
#include "../support.h"
#include "../support/program.h"

#include "insets.h"
#include "ways.h"

static const uint32_t sizes[] = {8, 32, 64};

static const struct relief_spec spec = {.seed = 7, .classes = 1, .waves = {{0.15, 5}}};

static int calls; /* of the map of classes; more than one thread may ask */

static uint8_t class_of(int level, int64_t x, int64_t y)
{
	const double east = (double)x * ldexp(4, level), north = (double)y * ldexp(4, level);
	return east < 100 ? 0 : north < 75 ? 1 : 2;
}

static enum status read_classes(void *user, int level, struct post_rect rect, uint8_t *classes)
{
	calls++;
	for (int64_t y = rect.y0; y < rect.y1; y++)
		for (int64_t x = rect.x0; x < rect.x1; x++)
			*classes++ = class_of(level, x, y);
	return STATUS_OK;
}

static const struct relief_spec by_class = {.seed = 9, .classes = 3, .waves = {{0.15, 5}, {0, 5}, {0.4, 2}}};
static const struct relief_map map = {read_classes, NULL};

static struct store *open_raised(uint32_t cells, int working, bool classes)
{
	struct store *store;
	must(store_open(insets_store(cells), &(struct store_options){.mode = STORE_READ}, &store));
	must(store_set_working_level(store, working));
	must(store_set_relief(store, classes ? &by_class : &spec, classes ? &map : NULL));
	assert_non_null(store_relief(store));
	return store;
}

/* The level from which a post is interpolated, or its own; 1: none has it. */
static int from_of(int level, int64_t x, int64_t y)
{
	for (int from = level; from <= 0; from++) {
		const int64_t cell = (int64_t)1 << (from - level);
		bool all = true;
		for (int i = 0; i < 4; i++) {
			bool stored = true;
			const bool weighs = (i % 2 == 0 || x % cell != 0) && (i / 2 == 0 || y % cell != 0);
			const int32_t code = weighs ? insets_code(from, x / cell + i % 2, y / cell + i / 2, &stored) : 0;
			all = all && stored && code != HEIGHT_CODE_NODATA;
		}
		if (all)
			return from;
	}
	return 1;
}

static int32_t post_of(const struct store *store, int level, int64_t x, int64_t y)
{
	const int from = from_of(level, x, y);
	int32_t raised;
	if (from > 0)
		return BASE_NODATA;
	must(relief_heights(store_relief(store), level, from, (struct post_rect){x, y, x + 1, y + 1}, &raised));
	return insets_base(level, x, y) + raised;
}

/* By the CPU, by the patch that the GPU gets, and by the store's reader. */
static void check_tiles(uint32_t n, int working, bool classes)
{
	struct store *store = open_raised(n, working, classes);
	const struct extent *extent = &store_meta(store)->extent;
	const struct relief *relief = store_relief(store);
	const size_t count = (size_t)(n + 1) * (n + 1);
	struct ground *ground;
	int32_t *posts = malloc(sizeof *posts * 4 * count), *patch = posts + count, *divided = patch + count, *raised = divided + count;
	double *values = malloc(count * sizeof *values);
	size_t changed = 0, patches = 0;
	must(resident_ground_create(store, 2, &ground));
	for (int level = working; level < 0; level++)
		for (uint32_t k = 0; k < 30; k++) {
			const struct tile tile = ways_tile(extent, level, k);
			const struct post_rect rect = tile_post_rect(extent, tile);
			int shift;
			uint32_t sub_x, sub_y;
			must(resident_ground_posts(ground, tile, posts));
			must(resident_ground_patch(ground, tile, patch, &shift, &sub_x, &sub_y));
			if (shift > 0) {
				assert_false(classes);
				lattice_subdivide(patch, n, shift, sub_x, sub_y, divided);
				must(relief_heights(relief, level, 0, rect, raised));
				for (size_t i = 0; i < count; i++)
					divided[i] += divided[i] != BASE_NODATA ? raised[i] : 0;
				patches++;
			}
			assert_memory_equal(posts, shift > 0 ? divided : patch, count * sizeof *posts);
			must(store_read_posts(resident_ground_reader(ground), STORE_BASE, level, rect, values));
			for (size_t i = 0; i < count; i++) {
				const int64_t x = rect.x0 + (int64_t)(i % (n + 1)), y = rect.y0 + (int64_t)(i / (n + 1));
				if (!insets_within(level, x, y))
					continue;
				assert_int_equal(posts[i], post_of(store, level, x, y));
				changed += posts[i] != insets_base(level, x, y);
				assert_true(posts[i] == BASE_NODATA ? isnan(values[i]) : values[i] == lattice_base_metres(posts[i]));
				if (x % 2 == 0 && y % 2 == 0 && level < -1) /* law 4 */
					assert_int_equal(posts[i], post_of(store, level + 1, x / 2, y / 2));
			}
			double low, high;
			bool any;
			int64_t highest;
			must(resident_ground_range(ground, tile, &low, &high, &any));
			must(resident_ground_highest(ground, level, rect, &highest));
			for (size_t i = 0; i < count; i++)
				if (posts[i] != BASE_NODATA && rect.x0 + (int64_t)(i % (n + 1)) < extent_posts(extent->width, level) &&
				    rect.y0 + (int64_t)(i / (n + 1)) < extent_posts(extent->height, level))
					assert_true(any && lattice_base_metres(posts[i]) >= low && lattice_base_metres(posts[i]) <= high &&
						    highest >= 4 * (int64_t)posts[i]);
		}
	assert_true(changed > 1000 && (patches > 0) != classes);
	free(values);
	free(posts);
	resident_ground_destroy(ground);
	store_close(store);
}

static void every_way_gives_the_same_posts(void **state)
{
	for (int i = 0; i < 3; i++)
		for (int working = -6; working <= -2; working += 2)
			for (int classes = 0; classes < 2; classes++)
				check_tiles(sizes[i], working, classes == 1);
	assert_true(calls > 100);
}

/* Bodies, queries of the command and those of a host stand on the same ground. */
static void every_way_gives_the_same_point(void **state)
{
	for (int i = 0; i < 3; i++)
		for (int classes = 0; classes < 2; classes++) {
			const int working = -6;
			struct store *store = open_raised(sizes[i], working, classes == 1);
			struct ways ways;
			int raised = 0;
			ways_open(store, &ways);
			for (int k = 0; k < 150; k++) {
				const double share[2] = {(k * 977 % 4001) / 4001.0, (k * 1613 % 4003) / 4003.0};
				const double x = lattice_offset_metres(lattice_offset(k % 2 ? 256 * share[0] : 70 + 28 * share[0]));
				const double y = lattice_offset_metres(lattice_offset(k % 2 ? 192 * share[1] : 66 + 18 * share[1]));
				const double px = ldexp(x / 4, -working), py = ldexp(y / 4, -working);
				const int64_t cx = (int64_t)px, cy = (int64_t)py;
				double corners[4];
				for (int c = 0; c < 4; c++) {
					const int32_t post = post_of(store, working, cx + c % 2, cy + c / 2);
					corners[c] = post == BASE_NODATA ? (double)NAN : lattice_base_metres(post);
				}
				const double wanted = lattice_bilinear(corners, px - (double)cx, py - (double)cy, 0);
				struct ways_heights at;
				const bool any = ways_at(&ways, x, y, &at);
				assert_true(any == !isnan(wanted));
				if (!any)
					continue;
				assert_true(fabs(lattice_offset_metres(at.height) - wanted) < 1e-6);
				assert_true(fabs(at.sample.height - wanted) < 1e-9 && fabs(at.told.bilinear - wanted) < 1e-9);
				assert_int_equal(at.told.level, working);
				raised += fabs(wanted - corners[0]) > 1e-3;
			}
			assert_true(raised > 50);
			ways_close(&ways);
			store_close(store);
		}
}

/* Without it nothing is asked, and nothing changes. */
static void without_relief_posts_are_as_they_were(void **state)
{
	struct store *store;
	must(store_open(insets_store(32), &(struct store_options){.mode = STORE_READ}, &store));
	assert_null(store_relief(store));
	must(store_set_working_level(store, -1)); /* 2 m: no waves of 2 m */
	must(store_set_relief(store, &(struct relief_spec){.seed = 1, .classes = 1, .waves = {{0.1, 2}}}, NULL));
	assert_null(store_relief(store));
	assert_null(store_relief_text(store));
	must(store_set_relief(store, NULL, NULL));
	struct ground *ground;
	int32_t posts[33 * 33];
	must(resident_ground_create(store, 1, &ground));
	must(resident_ground_posts(ground, (struct tile){-1, 1, 1}, posts));
	for (int i = 0; i < 33 * 33; i++)
		assert_int_equal(posts[i], insets_base(-1, 32 + i % 33, 32 + i / 33));
	resident_ground_destroy(ground);
	store_close(store);
}

TEST_PROGRAM(relief)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_way_gives_the_same_posts),
		cmocka_unit_test(every_way_gives_the_same_point),
		cmocka_unit_test(without_relief_posts_are_as_they_were),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
