/*
 * Whole drives of many bodies: contacts that are computed together leave the rows, by one content hash, of contacts that are computed one
 * after another. The bodies cross tiles' sides, corners, and each other's ruts. Neither does the number of threads that compute them show.
 */
#include "../support.h"
#include "../support/program.h"
#include "../support/skip.h"

#define BODIES 14

struct setup {
	const char *model, *more;
	double spacing, time_step;
	uint32_t cells;
	int slots;
	bool rises; /* some bodies leave the ground at times */
};

static uint32_t seed;

static double any_share(void)
{
	seed = seed * 1664525 + 1013904223;
	return (seed >> 8) / 16777216.0;
}

static const char *shape_of(int i)
{
	static const char *const shapes[] = {"wheel: {radius: 0.9, width: 0.7}", "sphere: {radius: 1.2}", "box: {size: [2, 1.4, 1]}",
					     "wheel: {radius: 1.1, width: 0.4, lugs: 8, lug_height: 0.1, lug_thickness: 0.1}",
					     "cylinder: {radius: 0.7, length: 1.2}", "wheel: {radius: 0.6, width: 0.5}", "box: {size: [30, 26, 2]}"};
	return shapes[i % 7];
}

/* A body that is 0.3 m above the ground at times. */
static void write_hops(FILE *scene, int i, double x, double y)
{
	char name[32];
	snprintf(name, sizeof name, "b%d.csv", i);
	FILE *file = fopen(support_path(name), "w");
	assert_non_null(file);
	fputs("t,x,y,z\n", file);
	for (int k = 0; k < 20; k++)
		fprintf(file, "%g,%g,%g,%.17g\n", 0.1 * k, x + 0.4 * k, y,
			support_hills((int64_t)((x + 0.4 * k) / 2), (int64_t)(y / 2)) + 1.1 + (k % 4 < 2 ? -0.3 : 0.3));
	assert_int_equal(fclose(file), 0);
	fprintf(scene, "  - {name: b%d, shape: {sphere: {radius: 1.2}}, path: {file: %s}}\n", i, name);
}

/* Most bodies are spread, and some drive close to others. */
static void write_scene(const char *path, const struct setup *setup)
{
	FILE *file = fopen(path, "w");
	assert_non_null(file);
	seed = 7;
	fprintf(file, "scene: 1\ntime_step: %g\nend_time: 1.6\nspacing: %g\nredistribute: {model: %s}\n%scache: {slots: %d}\nobjects:\n", setup->time_step,
		setup->spacing, setup->model, setup->more, setup->slots);
	for (int i = 0; i < BODIES; i++) {
		double x = i % 4 == 3 ? 100 + 4 * any_share() : 20 + 200 * any_share(), y = i % 4 == 3 ? 100 + 3 * any_share() : 20 + 200 * any_share();
		if (setup->rises && i % 5 == 1) {
			write_hops(file, i, x, y);
			continue;
		}
		fprintf(file, "  - {name: b%d, shape: {%s}, sink: %g, path: {points: [[%g, %g], [%g, %g], [%g, %g]], speed: %g}}\n", i, shape_of(i),
			0.1 + 0.1 * any_share(), x, y, x + 8 * any_share(), y - 5 * any_share(), x + 3, y + 6, 4 + 3 * any_share());
	}
	assert_int_equal(fclose(file), 0);
}

struct left {
	uint64_t rows; /* hash */
	long long batches, passes;
};

static struct left drive(const struct setup *setup, bool alone, int threads)
{
	const char *store = support_path("batches.furrow"), *path = support_path("scene.yaml");
	struct scene *scene;
	struct drive_result result;
	struct left left;
	write_scene(path, setup);
	support_store(store, (struct extent){129, 129, 2, setup->cells}, support_hills);
	must(scene_load(path, NULL, 0, &scene));
	struct drive_params params = {.scene = scene, .store = store, .directory = support_path("out"), .alone = alone, .threads = threads};
	enum status status = drive_run(&params, &result);
	scene_destroy(scene);
	if (status == STATUS_NO_GL)
		skip_since("no GL");
	must(status);
	support_verify(store);
	left.rows = support_hash(store);
	left.batches = support_figure(result.json, "\"units\"", "batch");
	left.passes = support_figure(result.json, "\"passes\"", "displace") + support_figure(result.json, "\"passes\"", "redistribute");
	mem_free(result.json);
	return left;
}

static void batches_do_not_show_in_the_rows(void **state)
{
	static const struct setup setups[] = {
		{"box, radius: 2, repetitions: 2", "attributes: [dirt]\n", 0.25, 0.05, 64, 256, false},
		{"box", "", 0.125, 0.02, 128, 16, true},
		{"none", "attributes: [dirt]\n", 0.5, 0.2, 32, 64, true},
	};
	(void)state;
	for (size_t i = 0; i < sizeof setups / sizeof *setups; i++) {
		struct left alone = drive(&setups[i], true, 0), together = drive(&setups[i], false, 0);
		assert_int_equal(alone.batches, 0);
		assert_true(together.batches > 0 && together.passes < alone.passes);
		if (alone.rows != together.rows)
			fail_msg("model %s, %g m, tiles of %u: other rows in batches", setups[i].model, setups[i].spacing, setups[i].cells);
	}
}

/* Soil that bears: bodies far apart, bodies that touch each other, and soil that slides in many blocks; few slots, and small tiles. */
static void threads_do_not_show_in_the_rows(void **state)
{
	static const struct setup setups[] = {
		{"scm, interval: 0.05", "soil: {name: dry_sand}\nattributes: [dirt]\n", 0.25, 0.05, 64, 256, false},
		{"scm, interval: 0.02", "soil: {name: dry_sand}\n", 0.25, 0.2, 32, 150, true},
		{"scm, interval: 0.05, faces: on", "soil: {name: dry_sand}\n", 0.25, 0.05, 64, 256, true},
	};
	static const int threads[] = {2, 3, 7};
	(void)state;
	for (size_t i = 0; i < sizeof setups / sizeof *setups; i++) {
		const struct left one = drive(&setups[i], false, 1);
		for (size_t k = 0; k < sizeof threads / sizeof *threads; k++)
			if (drive(&setups[i], false, threads[k]).rows != one.rows)
				fail_msg("%g m, tiles of %u: other rows with %d threads", setups[i].spacing, setups[i].cells, threads[k]);
	}
}

TEST_PROGRAM(batches)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(threads_do_not_show_in_the_rows),
		cmocka_unit_test(batches_do_not_show_in_the_rows),
	};
	return cmocka_run_group_tests_name("batches", tests, support_enter, support_leave);
}
