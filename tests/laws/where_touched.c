/* Law 7 over soil that was touched: bodies that walk and bounce over their own prints, and resumed drives of such bodies. What is
 * left out would have changed nothing. */
#include "../long.h"
#include "../support/program.h"
#include "where.h"

/* --- over soil that was touched, and beside it --- */

static const struct extent lawn = {65, 65, 0.5, 64};

/* A foot: down 3 cm, 0.4 s there, up and on; `back`: it turns half-way and treads between its own prints. */
static void write_steps(const char *name, double x, double y, double stride, double lift, bool back)
{
	FILE *file = fopen(support_path(name), "w");
	assert_non_null(file);
	for (int i = 0; i <= 80; i++) {
		int step = i / 8;
		double swing = i % 8 < 4 ? 0 : (i % 8 - 3) / 5.0, gone = step + swing;
		double along = back && gone > 5 ? 10.4 - gone : gone;
		fprintf(file, "%.17g,%.17g,%.17g,%.17g,0,%.17g,0\n", i * 0.1, x + stride * along, y,
			100.02 + lift * sin(M_PI * swing), 20 * sin(2 * M_PI * swing));
	}
	assert_int_equal(fclose(file), 0);
}

static const char walking[] =
	"end_time: 8\nspacing: 0.03125\n%sobjects:\n"
	"  - {name: left, shape: {box: {size: [0.3, 0.12, 0.1]}}, path: {file: left.csv}}\n"
	"  - {name: right, shape: {box: {size: [0.25, 0.1, 0.1]}}, path: {file: right.csv}}\n";

static const char *walk(int m, const char *more)
{
	char text[1024];
	snprintf(text, sizeof text, walking, more);
	return scene_of("walk.yaml", m, text);
}

/* A foot swings over its own print, beside the other's, and over ground where none was. */
static void what_walks_is_aloft_between_its_prints(void **state)
{
	static const struct {
		double lift, apart, most;
		bool back;
		const char *more;
	} walks[] = {
		{0.2, 0.8, 0.97, false, ""}, {0.2, 0.8, 0.97, false, "cache: {slots: 4}\n"}, {0.07, 0.2, 1.01, false, ""},
		{0.15, 0.25, 1.01, true, ""},
	};
	for (int m = 2; m < MODELS; m++)
		for (size_t i = 0; i < sizeof walks / sizeof *walks; i++) {
			if (!long_or_part((size_t)m, i, 2))
				continue;
			write_steps("left.csv", 10.03, 12.01, 1.2, walks[i].lift, walks[i].back);
			write_steps("right.csv", 9.55, 12.01 + walks[i].apart, 1.2, walks[i].lift, walks[i].back);
			const char *scene = walk(m, walks[i].more);
			the_same_either_way(lawn, flat, scene, NULL, (struct least){0.2, walks[i].most});
			/* Again, where it walked: all of those tiles count as touched. */
			if (i == 0)
				the_same_either_way(lawn, flat, scene, scene, (struct least){0.2, 1.01});
		}
}

/* Up, and down again a little beside: through rims that are above the ground as it was, and over soil that still slides. */
static void what_bounces_over_its_own_rims_leaves_the_same(void **state)
{
	static const char rest[] =
		"end_time: 6\nspacing: 0.0625\nobjects:\n"
		"  - {name: ball, shape: {sphere: {radius: 0.4}}, path: {file: ball.csv}}\n"
		"  - {name: slab, shape: {box: {size: [14, 1, 0.2]}}, path: {file: slab.csv}}\n";
	static const support_height heights[] = {flat, holed};
	for (int h = 0; h < 2; h++)
		for (int m = 2; m < MODELS; m++) {
			if (!long_or_part((size_t)m, (size_t)h, 2))
				continue;
			write_poses("ball.csv", &(struct hops){heights[h], 0.5, 10, 10, 0.7, 0.3, 0.4, 0.15, 0.5, 3.3, 6, false});
			/* Several windows. */
			write_poses("slab.csv", &(struct hops){heights[h], 0.5, 16, 14, 0.2, 1.9, 0.1, 0.1, 0.7, 1.3, 6, false});
			char text[1024];
			snprintf(text, sizeof text, "%s%s", rest, h == 1 ? "outside: skip\n" : "");
			the_same_either_way(lawn, heights[h], scene_of("bounce.yaml", m, text), NULL, (struct least){0.2, 1.01});
		}
}

/* --- what is resumed --- */

static void what_is_resumed_in_the_air_goes_on_the_same(void **state)
{
	static const int64_t stops[] = {7, 17, 18, 25, 33};
	static const int ms[] = {1, 3, 4};
	for (int i = 0; i < 3; i++) {
		write_hops(smooth);
		const char *scene = scene_of("hops.yaml", ms[i], hopping);
		const char *whole = support_path("all.furrow"), *parts = support_path("few.furrow");
		support_store(whole, extent, smooth);
		support_store(parts, extent, smooth);
		char *json = drive(scene, whole, "out-all", true, false, 0), *resumed = NULL;
		for (int k = 0; k < 5; k++)
			mem_free(drive(scene, parts, "out-few", false, k > 0, stops[k]));
		resumed = drive(scene, parts, "out-few", false, true, 0);
		assert_true(support_hash(whole) == support_hash(parts));
		same_forces("out-all", "out-few");
		same_figures(json, resumed);
		mem_free(json);
		mem_free(resumed);
	}
}

static void what_walks_is_resumed_over_its_prints(void **state)
{
	static const int64_t stops[] = {6, 13, 27, 41, 55};
	const char *whole = support_path("all.furrow"), *parts = support_path("few.furrow");
	write_steps("left.csv", 10.03, 12.01, 0.9, 0.15, true);
	write_steps("right.csv", 9.55, 12.21, 0.9, 0.15, true);
	for (int m = 2; m < MODELS; m++) {
		const char *scene = walk(m, "cache: {slots: 4}\n");
		support_store(whole, lawn, flat);
		support_store(parts, lawn, flat);
		char *json = drive(scene, whole, "out-all", true, false, 0);
		for (int k = 0; k < 5; k++)
			mem_free(drive(scene, parts, "out-few", false, k > 0, stops[k]));
		char *resumed = drive(scene, parts, "out-few", false, true, 0);
		assert_true(support_hash(whole) == support_hash(parts));
		same_forces("out-all", "out-few");
		same_figures(json, resumed);
		mem_free(json);
		mem_free(resumed);
	}
}

/* It pressed the ground, left the world, and has come back to hang above other ground: nothing acts on it, and a resumed drive
 * knows that. */
static void what_parks_in_the_air_is_told_so_when_resumed(void **state)
{
	static const char rest[] = "end_time: 4\nspacing: 0.5\noutside: skip\nobjects:\n"
				   "  - {name: back, shape: {sphere: {radius: 1}}, path: {file: back.csv}}\n";
	const char *all = support_path("all.furrow"), *few = support_path("few.furrow"), *scene = scene_of("back.yaml", 4, rest);
	support_write(support_path("back.csv"), "0,8,100,100.7\n0.5,-9,100,100.7\n1,-9,180,104\n1.5,8,180,104\n");
	support_store(all, extent, flat);
	support_store(few, extent, flat);
	char *json = drive(scene, all, "out-all", true, false, 0), *csv = text_of("out-all", "objects.csv");
	mem_free(drive(scene, few, "out-few", false, false, 20));
	char *resumed = drive(scene, few, "out-few", false, true, 0);
	assert_non_null(strstr(csv, "\n3,back,8,180,104,0,0,0,0,0,0,0,0,0,"));
	same_forces("out-all", "out-few");
	same_figures(json, resumed);
	assert_true(support_hash(all) == support_hash(few));
	mem_free(json);
	mem_free(resumed);
	free(csv);
}

TEST_PROGRAM(where_touched)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_walks_is_aloft_between_its_prints),
		cmocka_unit_test(what_bounces_over_its_own_rims_leaves_the_same),
		cmocka_unit_test(what_is_resumed_in_the_air_goes_on_the_same),
		cmocka_unit_test(what_walks_is_resumed_over_its_prints),
		cmocka_unit_test(what_parks_in_the_air_is_told_so_when_resumed),
	};
	return cmocka_run_group_tests_name("where", tests, support_enter, support_leave);
}
