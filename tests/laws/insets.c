/*
 * The laws over drives across the rims of two insets, one within the other: 4 m, 1 m and 0.25 m. Driven at the inner one's spacing, at
 * a finer one, and at one that is coarser than both.
 */
#include "../support.h"

#include "../resident/insets.h"
#include "../support/near.h"
#include "../support/program.h"

static const char scene_text[] =
	"scene: 1\n"
	"time_step: 0.05\n"
	"end_time: 10\n"
	"spacing: 0.25\n"
	"redistribute: {model: sumner}\n"
	"soil: {name: dry_sand}\n"
	"attributes: [dirt]\n"
	"objects:\n"
	"  - {name: a, shape: {wheel: {radius: 0.9, width: 0.7}}, sink: 0.2,\n"
	"     path: {points: [[30, 60], [84, 74.5], [110, 112], [70, 130]], speed: 15}}\n"
	"  - {name: b, shape: {sphere: {radius: 1.5}}, sink: 0.4,\n"
	"     path: {points: [[80, 30], [80, 100]], speed: 10}}\n";

static const char *scene_file(void)
{
	const char *path = support_path("scene.yaml");
	support_write(path, scene_text);
	return path;
}

static const char *fresh(const char *name, uint32_t cells)
{
	char from[256], buffer[1 << 14];
	snprintf(from, sizeof from, "%s", insets_store(cells));
	const char *path = support_path(name);
	FILE *in = fopen(from, "rb"), *out = fopen(path, "wb");
	assert_true(in != NULL && out != NULL);
	for (size_t count; (count = fread(buffer, 1, sizeof buffer, in)) > 0;)
		assert_int_equal(fwrite(buffer, 1, count, out), count);
	fclose(in);
	assert_int_equal(fclose(out), 0);
	return path;
}

static const char *const spacings[] = {"spacing=0.25", "spacing=0.125", "spacing=2"};
static const int levels[] = {-4, -5, -1};

static void the_fewest_slots_leave_the_same_rows_as_all_resident(void **state)
{
	const char *scene = scene_file();
	for (int i = 0; i < 3; i++) {
		const char *few = fresh("few.furrow", 64), *all = fresh("all.furrow", 64);
		char *json = support_drive(scene, few, (const char *[]){spacings[i], "cache.slots=4", "cache.loaders=1", "cache.prefetch=0", NULL});
		assert_true(i == 2 || support_figure(json, "\"cache\"", "evictions") > 3);
		mem_free(json);
		json = support_drive(scene, all, (const char *[]){spacings[i], "cache.slots=512", "cache.loaders=3", "cache.prefetch=2", NULL});
		assert_int_equal(support_figure(json, "\"cache\"", "evictions"), 0);
		mem_free(json);
		struct store_check check = support_verify(few);
		assert_int_equal(check.problems, 0);
		assert_int_equal(check.finest, levels[i] < INSETS_FINEST ? levels[i] : INSETS_FINEST);
		/* nothing is lost: what is missing is what was compacted */
		assert_int_equal(check.offset_sum[levels[i] - TILE_LEVEL_MIN] + check.compacted, 0);
		assert_true(check.offset_sum[levels[i] - TILE_LEVEL_MIN] != 0);
		assert_int_equal(support_verify(all).problems, 0);
		assert_true(support_hash(few) == support_hash(all));
	}
}

static void tiles_of_64_and_512_give_the_same_posts(void **state)
{
	const char *scene = scene_file();
	for (int i = 0; i < 3; i++) {
		const int64_t x1 = 128 * ((int64_t)1 << -levels[i]) / 4, y1 = 140 * ((int64_t)1 << -levels[i]) / 4;
		const struct post_rect rect = {0, 0, x1, y1};
		const char *small = fresh("small.furrow", 64), *large = fresh("large.furrow", 512);
		mem_free(support_drive(scene, small, (const char *[]){spacings[i], "cache.slots=64", NULL}));
		mem_free(support_drive(scene, large, (const char *[]){spacings[i], "cache.slots=16", NULL}));
		double *a = support_quanta(small, levels[i], rect), *b = support_quanta(large, levels[i], rect);
		int64_t moved = 0;
		for (int64_t k = 0; k < x1 * y1; k++) {
			assert_true(a[k] == b[k]);
			moved += a[k] != 0;
		}
		assert_true(moved > (i == 2 ? 10 : 1000));
		free(a);
		free(b);
	}
}

/* The drive deforms the inset's own posts: its rut at each post is the body's lower envelope minus the inset there, not minus what is
 * interpolated from the terrain around. */
static void a_rut_is_cut_into_the_inset(void **state)
{
	const char *path = fresh("rut.furrow", 64);
	support_write(support_path("flat.yaml"),
		      "scene: 1\ntime_step: 0.05\nend_time: 2\nspacing: 0.25\nredistribute: {model: none}\nobjects:\n"
		      "  - {name: a, shape: {box: {size: [1, 1, 1]}}, sink: 0.3, path: {points: [[80, 75], [88, 75]], speed: 6}}\n");
	mem_free(support_drive(support_path("flat.yaml"), path, NULL));
	struct store *store;
	struct store_reader *reader;
	double surface[2][9], base[2][9];
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	must(store_reader_create(store, &reader));
	const struct post_rect rect = {336, 299, 345, 301};
	must(store_read_posts(reader, STORE_SURFACE, -4, rect, surface[0]));
	must(store_read_posts(reader, STORE_BASE, -4, rect, base[0]));
	for (int64_t y = 0; y < 2; y++)
		for (int64_t x = 0; x < 9; x++) {
			bool stored;
			const int32_t code = insets_code(-4, rect.x0 + x, rect.y0 + y, &stored);
			assert_true(stored && base[y][x] == code * INSETS_STEP);
			assert_true(surface[y][x] <= base[y][x] && surface[y][x] > base[y][x] - 3);
		}
	/* under the box all posts are cut to one height for each sample, so the surface is smoother than the inset's noise */
	double rough = 0, cut = 0;
	for (int64_t x = 0; x < 8; x++) {
		rough = support_most(rough, fabs(base[0][x + 1] - base[0][x]));
		cut = support_most(cut, fabs(surface[0][x + 1] - surface[0][x]));
	}
	assert_true(cut < rough);
	store_reader_destroy(reader);
	store_close(store);
}

TEST_PROGRAM(insets)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_fewest_slots_leave_the_same_rows_as_all_resident),
		cmocka_unit_test(tiles_of_64_and_512_give_the_same_posts),
		cmocka_unit_test(a_rut_is_cut_into_the_inset),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
