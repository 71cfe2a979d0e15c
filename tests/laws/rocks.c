/*
 * The laws with rocks under the wheels: the same rows with the fewest slots and with all, the same posts on any tiles, pages or
 * pictures beside. The base is never written.
 */
#include "../support.h"
#include "../support/program.h"

static const struct extent extent = {129, 129, 4, 64};

static const char scene_text[] =
	"scene: 1\n"
	"time_step: 0.05\n"
	"end_time: 6\n"
	"spacing: 0.25\n"
	"ground: {rocks: {cover: 0.2, largest: 3, smallest: 0.5, seed: 7}}\n"
	"redistribute: {model: box}\n"
	"objects:\n"
	/* Through corners of four tiles. */
	"  - {name: a, shape: {wheel: {radius: 0.9, width: 0.7}}, sink: 0.1,\n"
	"     path: {points: [[20, 20], [300, 300], [290, 40]], speed: 60}}\n"
	"  - {name: b, shape: {sphere: {radius: 2.5}}, sink: 0.3,\n"
	"     path: {points: [[64, 300], [64, 64], [200, 128]], speed: 40}}\n";

static const char *const models[] = {"none", "box", "slippage", "scm", "sheet"};
#define MODELS 5

static double level_ground(int64_t x, int64_t y)
{
	return 40 + (double)(x * 3 + y) / 1024;
}

static const char *fresh(const char *name, uint32_t cells)
{
	const char *path = support_path(name);
	struct extent shape = extent;
	shape.cells = cells;
	support_store(path, shape, level_ground);
	return path;
}

static const char *scene_file(void)
{
	const char *path = support_path("rocks.yaml");
	support_write(path, scene_text);
	return path;
}

static const char *const *with(const char *model, const char *a, const char *b)
{
	static char text[48];
	static const char *told[6];
	snprintf(text, sizeof text, "redistribute.model=%s", model);
	const bool soil = strcmp(model, "none") != 0 && strcmp(model, "box") != 0 && strcmp(model, "sheet") != 0;
	int count = 0;
	told[count++] = text;
	if (soil) {
		told[count++] = "soil.name=dry_sand";
		told[count++] = "end_time=1.5";
	}
	if (strcmp(model, "sheet") == 0)
		told[count++] = "redistribute.yield=0.02";
	told[count++] = a;
	told[count++] = b;
	told[count] = NULL;
	return told;
}

static void the_fewest_slots_leave_the_same_rows_as_all_resident(void **state)
{
	const char *scene = scene_file();
	for (int m = 0; m < MODELS; m++) {
		const char *few = fresh("few.furrow", 64), *all = fresh("all.furrow", 64);
		char *json = support_drive(scene, few, with(models[m], "cache.slots=4", "cache.prefetch=0"));
		assert_true(support_figure(json, "\"cache\"", "evictions") > 10);
		mem_free(json);
		json = support_drive(scene, all, with(models[m], "cache.slots=256", "cache.loaders=3"));
		assert_int_equal(support_figure(json, "\"cache\"", "evictions"), 0);
		assert_non_null(strstr(json, "\"rocks\""));
		mem_free(json);
		support_verify(few);
		assert_true(support_hash(few) == support_hash(all));
	}
}

static void tiles_of_64_and_256_give_the_same_posts(void **state)
{
	const char *scene = scene_file();
	const struct post_rect rect = {0, 0, 1300, 1300};
	for (int m = 0; m < MODELS; m++) {
		double *first = NULL;
		for (uint32_t cells = 64; cells <= 256; cells *= 2) {
			const char *path = fresh("tiles.furrow", cells);
			mem_free(support_drive(scene, path, with(models[m], "cache.slots=64", NULL)));
			double *quanta = support_quanta(path, -4, rect);
			size_t touched = 0;
			for (int64_t k = 0; k < rect.x1 * rect.y1; k++)
				touched += quanta[k] != 0;
			assert_true(touched > 1000);
			if (first == NULL) {
				first = quanta;
				continue;
			}
			assert_memory_equal(quanta, first, (size_t)(rect.x1 * rect.y1) * sizeof *quanta);
			free(quanta);
		}
		free(first);
	}
}

/* Where the GPU deforms, its tiles have the same rocks as those of the CPU. */
static void the_cpu_and_the_gpu_leave_the_same_rows(void **state)
{
	static const char *const both[] = {"box", "slippage", "sheet"};
	const char *scene = scene_file();
	for (int m = 0; m < 3; m++) {
		const char *cpu = fresh("cpu.furrow", 64), *gpu = fresh("gpu.furrow", 64);
		mem_free(support_drive(scene, cpu, with(both[m], "compute=cpu", "end_time=1")));
		mem_free(support_drive(scene, gpu, with(both[m], "end_time=1", NULL)));
		support_verify(gpu);
		assert_true(support_hash(cpu) == support_hash(gpu));
	}
}

/* Level 0 of the store is what it was, bit for bit; only offsets and their like are written; another seed makes other ruts. */
static void the_base_is_never_written(void **state)
{
	const char *scene = scene_file(), *path = fresh("one.furrow", 64), *other = fresh("other.furrow", 64);
	struct store *store;
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	const uint64_t before = store_base_hash(store);
	store_close(store);
	mem_free(support_drive(scene, path, (const char *[]){"end_time=2", NULL}));
	mem_free(support_drive(scene, other, (const char *[]){"end_time=2", "ground.rocks.seed=8", NULL}));
	must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	struct store_reader *reader;
	struct store_numbers numbers;
	int32_t posts[65 * 65];
	must(store_reader_create(store, &reader));
	must(store_count(store, &numbers));
	assert_int_equal(numbers.base_tiles, 4 + 1);
	for (uint32_t tile = 0; tile < 4; tile++) {
		must(store_read_base(reader, (struct tile){0, tile % 2, tile / 2}, posts, NULL));
		for (int64_t i = 0; i < 65 * 65; i++)
			assert_true(height_code_metres(posts[i], store_meta(store)->step) == level_ground(tile % 2 * 64 + i % 65, tile / 2 * 64 + i / 65));
	}
	assert_true(store_base_hash(store) == before);
	store_reader_destroy(reader);
	store_close(store);
	assert_true(support_hash(path) != support_hash(other));
}

TEST_PROGRAM(rocks)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_fewest_slots_leave_the_same_rows_as_all_resident),
		cmocka_unit_test(tiles_of_64_and_256_give_the_same_posts),
		cmocka_unit_test(the_cpu_and_the_gpu_leave_the_same_rows),
		cmocka_unit_test(the_base_is_never_written),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
