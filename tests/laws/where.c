/* Law 7: a contact is computed only where it has something to do. Bodies that fly and hop over ground that nothing touched, over
 * rims and over the parts of a shape: what is left out would have changed nothing. */
#include "../long.h"
#include "../support/program.h"
#include "where.h"

/* --- ground --- */

static double cliff(int64_t x, int64_t y)
{
	return smooth(x, y) + (x > 40 + y % 3 ? 40 : 0);
}

/* --- laws --- */

/* Over hills and their own ruts, over cliffs and holes, under every model. */
static void what_hops_leaves_the_same_rows(void **state)
{
	static const support_height heights[] = {support_hills, flat, cliff, holed};
	for (int h = 0; h < 4; h++)
		for (int m = 0; m <= SHEET; m++) {
			if (m != SHEET && !long_or_part((size_t)m, (size_t)h, 4))
				continue;
			write_hops(heights[h]);
			/* Where soil slides a tile that was touched is looked at, and the next to it then is touched. */
			the_same_either_way(extent, heights[h], scene_of("hops.yaml", m, hopping), NULL,
					    (struct least){0.05, slides(m) ? 1.01 : 0.8});
		}
}

/* What passes above it works on ground that has not come to rest, too. */
static void loose_ground_slides_under_what_flies(void **state)
{
	static const char flying[] = "end_time: 1.5\nobjects:\n  - {name: fly, shape: {sphere: {radius: 6}}, path: {file: fly.csv}}\n";
	char soil[256];
	write_poses("fly.csv", &(struct hops){support_hills, 2, 30, 61, 80, 30, 6, -9, 10, 1, 1.5, false});
	for (int m = 2; m < MODELS - 1; m++) {
		snprintf(soil, sizeof soil, "scene: 1\ntime_step: 0.1\nsoil: {name: sand, cohesion: 0, friction_angle: 10, unit_weight: 16000}\n"
			 "redistribute: {model: %s, undisturbed: slides}\n%s", models[m], flying);
		support_write(support_path("loose.yaml"), soil);
		the_same_either_way(extent, support_hills, support_path("loose.yaml"), NULL, (struct least){0.5, 1.01});
	}
}

/* Rims that earlier drives have piled up, or this one does: above the base, and a body that flies between the two. */
static void what_flies_into_a_rim_presses_it(void **state)
{
	static const char digs[] = "end_time: 4\nspacing: 0.25\nobjects:\n"
				   "  - {name: dig, shape: {box: {size: [4, 4, 4]}}, sink: 1.6, path: {points: [[60, 60], [66, 60]], speed: 8}}\n";
	static const char flies[] = "end_time: 4\nspacing: 0.25\nobjects:\n"
				    "  - {name: fly, shape: {box: {size: [0.5, 0.5, 0.5]}}, path: {file: fly.csv}}\n";
	write_poses("fly.csv", &(struct hops){flat, 2, 40, 61, 20, 0.3, 0.25, -0.05, 0.06, 1, 4, false});
	const char *first = scene_of("first.yaml", 3, digs);
	for (int m = 0; m <= SHEET; m++) {
		if (!by_turn((size_t)m, 2))
			continue;
		the_same_either_way(extent, flat, scene_of("fly.yaml", m, flies), first, (struct least){0.1, 1});
		struct store_check check = support_verify(support_path("few.furrow"));
		assert_int_equal(check.finest, -3);
	}
	/* Its own: it digs, rises just above the ground beside, and comes through what it heaped. */
	for (int m = 2; m < MODELS; m++) {
		FILE *file = fopen(support_path("fly.csv"), "w");
		assert_non_null(file);
		fprintf(file, "0,40,61,100.3\n1,60,61,100.3\n1.2,60,61,98.3\n1.4,63,61,98.3\n1.6,63,61,104\n2,56,61,104\n2.2,56,61,100.3\n4,70,61,100.3\n");
		assert_int_equal(fclose(file), 0);
		the_same_either_way(extent, flat, scene_of("own.yaml", m, flies), NULL, (struct least){0.3, 1.01});
	}
}

/* 64 m posts, as in laws.c: 156,000 of them are 9,984 km. */
static double strip(int64_t x, int64_t y)
{
	return 50 + (double)((x % 16) * (x % 16) % 11) + 0.37 * (double)y;
}

static void ten_thousand_kilometres_out_too(void **state)
{
	static const struct extent far = {160001, 4, 64, 256};
	double out = 156000.0 * 64;
	char text[512];
	snprintf(text, sizeof text, "end_time: 4\nspacing: 0.125\nobjects:\n"
		 "  - {name: ball, shape: {sphere: {radius: 0.6}}, path: {file: far.csv}}\n");
	write_poses("far.csv", &(struct hops){strip, 64, out + 100.3, 64, 6, 0.5, 0.6, 8, 12, 3.1, 4, false});
	for (int m = 0; m <= SHEET; m++)
		the_same_either_way(far, strip, scene_of("far.yaml", m, text), NULL, (struct least){0.1, slides(m) ? 1.01 : 0.95});
}

/* --- to the post, and to less than a millimetre --- */

static int64_t spike_x, spike_y;

static double spike(int64_t x, int64_t y)
{
	return x == spike_x && y == spike_y ? 110 : 100;
}

/* How much of the ground one station presses, and how many windows it computes. */
static long long pressed_on_the_way(const char *shape, double x, double y, double from, double z, double pitch, const char *spacing,
				    long long *windows)
{
	char text[512];
	const char *store = support_path("one.furrow");
	support_store(store, (struct extent){65, 65, 1, 64}, spike);
	FILE *file = fopen(support_path("one.csv"), "w");
	assert_non_null(file);
	fprintf(file, "0,%.17g,%.17g,%.17g,0,%.17g,0\n1,%.17g,%.17g,%.17g,0,%.17g,0\n", x, y, from, pitch, x, y, z, pitch);
	assert_int_equal(fclose(file), 0);
	snprintf(text, sizeof text, "end_time: 1\nspacing: %s\nobjects:\n  - {name: a, shape: %s, path: {file: one.csv}}\n", spacing, shape);
	char *json = drive(scene_of("one.yaml", 0, text), store, "out", false, false, 0);
	long long removed = support_figure(json, "\"quanta\"", "removed");
	*windows = where(json, "displace", "visited");
	mem_free(json);
	return removed;
}

static long long pressed_by(const char *shape, double x, double y, double z, double pitch, const char *spacing, long long *windows)
{
	return pressed_on_the_way(shape, x, y, z, z, pitch, spacing, windows);
}

/* The one post it touches, at each of its corners; the ground under its middle is 10 m lower. */
static void a_single_post_at_the_rim_counts(void **state)
{
	long long windows;
	for (int i = 0; i < 4; i++) {
		spike_x = 30 + (i % 2 == 0 ? -4 : 4);
		spike_y = 30 + (i / 2 == 0 ? -4 : 4);
		assert_true(pressed_by("{box: {size: [8, 8, 2]}}", 30, 30, 110, 0, "1", &windows) > 0);
		/* To a tenth of a millimetre. */
		assert_true(pressed_by("{box: {size: [8, 8, 2]}}", 30, 30, 111 - 1e-4, 0, "1", &windows) > 0);
		assert_int_equal(pressed_by("{box: {size: [8, 8, 2]}}", 30, 30, 111 + 1e-4, 0, "1", &windows), 0);
		assert_int_equal(windows, 0);
		/* From far above, onto it: the station before, a post away, is clear of it. */
		assert_true(pressed_on_the_way("{box: {size: [8, 8, 2]}}", 30, 30, 140.5, 110.6, 0, "1", &windows) > 0);
		/* What is between two posts of the source, the higher of which lies without. */
		double in = i % 2 == 0 ? -1 : 1;
		assert_true(pressed_by("{box: {size: [8, 8, 2]}}", 30 - in * 0.8, 30, 102, 0, "0.125", &windows) > 0);
		spike_x += (int64_t)(i % 2 == 0 ? -2 : 2);
		assert_int_equal(pressed_by("{box: {size: [8, 8, 2]}}", 30, 30, 110, 0, "1", &windows), 0);
		assert_int_equal(windows, 0);
	}
}

/* A body of several windows, of which the post is in one. */
static void a_post_counts_in_whichever_window(void **state)
{
	long long windows;
	for (int i = 0; i < 4; i++) {
		spike_x = 30 + (i % 2 == 0 ? -4 : 4);
		spike_y = 30 + (i / 2 == 0 ? -4 : 4);
		assert_true(pressed_by("{box: {size: [8.5, 8.5, 2]}}", 30, 30, 110, 0, "0.03125", &windows) > 0);
		assert_true(windows >= 4);
	}
	spike_x = 25; /* nearer than 25.75 m, and 0 m higher there */
	assert_int_equal(pressed_by("{box: {size: [8.5, 8.5, 2]}}", 30, 30, 111.5, 0, "0.03125", &windows), 0);
	assert_int_equal(windows, 0);
}

/* Every shape by its lowest point: a tenth of a millimetre into the ground it presses; as much above it is not looked at. */
static void the_lowest_point_decides(void **state)
{
	static const struct {
		const char *shape;
		double reach, pitch;
	} shapes[] = {
		{"{sphere: {radius: 3}}", 3, 0},
		{"{wheel: {radius: 3, width: 4}}", 3, 0},
		{"{box: {size: [8, 8, 2]}}", 1, 0},
		{"{box: {size: [8, 8, 2]}}", 3.2, 36.869897645844021}, /* its edge over a post, with the x below */
		/* On the corners of a bar: 3.1 m down, 0.5 m to either side of it. */
		{"{wheel: {radius: 3, width: 4, lugs: 4, lug_height: 0.1, lug_thickness: 1}}", 3.1, 0},
	};
	spike_x = -1;
	for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
		long long windows;
		assert_true(pressed_by(shapes[i].shape, shapes[i].pitch > 0 ? 30.1 : 30, 30, 100 + shapes[i].reach - 1e-4, shapes[i].pitch, "0.0625", &windows) > 0);
		assert_int_equal(windows, 1);
		assert_int_equal(pressed_by(shapes[i].shape, shapes[i].pitch > 0 ? 30.1 : 30, 30, 100 + shapes[i].reach + 1e-4, shapes[i].pitch, "0.0625", &windows), 0);
		assert_int_equal(windows, i == 4 ? 1 : 0);
	}
	/* Turned by 45 degrees of its way a bar's corner is hypot(3.1, 0.5) = 3.14006 m down. */
	long long windows;
	assert_int_equal(pressed_by(shapes[4].shape, 30, 30, 100 + 3.1402, 0, "0.0625", &windows), 0);
	assert_int_equal(windows, 0);
}

/* A bar turned until a corner points down. */
static void a_bar_of_a_wheel_reaches_farther_than_its_height(void **state)
{
	double turn = atan(0.5 / 3.1), way = 3 * turn;
	char rest[512];
	snprintf(rest, sizeof rest, "end_time: 1\nspacing: 0.0625\nobjects:\n"
		 "  - {name: a, shape: {wheel: {radius: 3, width: 4, lugs: 4, lug_height: 0.1, lug_thickness: 1}}, path: {file: bar.csv}}\n");
	FILE *file = fopen(support_path("bar.csv"), "w");
	assert_non_null(file);
	fprintf(file, "0,30,30,%.17g,0,0,0\n1,%.17g,30,%.17g,0,0,0\n", 100 + 3.13, 30 + 2 * way, 100 + 3.13);
	assert_int_equal(fclose(file), 0);
	spike_x = -1;
	the_same_either_way((struct extent){65, 65, 1, 64}, spike, scene_of("bar.yaml", 0, rest), NULL, (struct least){0.5, 1.1});
	assert_true(support_verify(support_path("few.furrow")).offset_sum[-4 - TILE_LEVEL_MIN] < 0);
}

TEST_PROGRAM(where)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_hops_leaves_the_same_rows),
		cmocka_unit_test(loose_ground_slides_under_what_flies),
		cmocka_unit_test(what_flies_into_a_rim_presses_it),
		cmocka_unit_test(ten_thousand_kilometres_out_too),
		cmocka_unit_test(a_single_post_at_the_rim_counts),
		cmocka_unit_test(a_post_counts_in_whichever_window),
		cmocka_unit_test(the_lowest_point_decides),
		cmocka_unit_test(a_bar_of_a_wheel_reaches_farther_than_its_height),
	};
	return cmocka_run_group_tests_name("where", tests, support_enter, support_leave);
}
