/* Objects that turn: lugs print where they roll to, and what an object no longer rests on is free to slide. */
#include "../support/near.h"
#include "hard.h"
#include "../support/program.h"

static double flat(int64_t x, int64_t y)
{
	(void)x, (void)y;
	return 20;
}

static const struct extent extent = {65, 65, 1, 64};

#define LUGS 8
#define RADIUS 0.8

/* How much of 20 m of a straight track along y = 20 repeats after so many metres (level -4). */
static double repeats(const double *quanta, double metres)
{
	double re = 0, im = 0;
	for (int i = 0; i < 20 * 16; i++) {
		double window = 1 - cos(2 * M_PI * i / (20 * 16)), phase = 2 * M_PI * i / 16 / metres;
		re += window * quanta[i] * cos(phase);
		im += window * quanta[i] * sin(phase);
	}
	return hypot(re, im);
}

/* From lug to lug a wheel turns 2 pi / n, and goes r (1 - slip) times that. */
static void lugs_print_as_far_apart_as_the_wheel_rolls_between_them(void **state)
{
	static const double slips[] = {0, 0.5, -0.5};
	static const struct hard_model sand = {"scm", "redistribute: {model: scm}\nsoil: {name: dry_sand}\noutput: {forces: 20}\n", true};
	for (int i = 0; i < 3; i++) {
		const char *store = support_path("lugs.furrow");
		char rest[512];
		support_store(store, extent, flat);
		snprintf(rest, sizeof rest, "time_step: 0.05\nend_time: 20\nspacing: 0.0625\nobjects:\n"
			 "  - {name: wheel, shape: {wheel: {radius: %g, width: 0.5, lugs: %d, lug_height: 0.1, lug_thickness: 0.08}}, sink: 0.08,\n"
			 "     slip: %g, path: {points: [[10, 20], [40, 20]], speed: 2}}\n", RADIUS, LUGS, slips[i]);
		mem_free(hard_drive(&sand, rest, store, NULL));
		double apart = 2 * M_PI / LUGS * RADIUS * (1 - slips[i]);
		double *quanta = support_quanta(store, -4, (struct post_rect){15 * 16, 20 * 16, 35 * 16, 20 * 16 + 1});
		double there = repeats(quanta, apart);
		for (int k = 0; k < 40; k++) {
			double other = 0.26 * pow(1.05, k);
			if (fabs(log(other / apart)) > 0.15 && fabs(log(other / (apart / 2))) > 0.15 && fabs(log(other / (apart / 3))) > 0.15 &&
			    !(repeats(quanta, other) <= there / 2))
				fail_msg("slip %g: it repeats after %g m, and not after %g m", slips[i], other, apart);
		}
		free(quanta);
	}
}

/* The steepest pair of a square of the surface, m between posts (level -2); the base is flat. */
static double steepest(const char *store, struct post_rect rect)
{
	double *quanta = support_quanta(store, -2, rect), most = 0;
	int64_t width = rect.x1 - rect.x0, height = rect.y1 - rect.y0;
	for (int64_t i = 0; i < width * height; i++) {
		if (i % width > 0)
			most = support_most(most, fabs(quanta[i] - quanta[i - 1]));
		if (i >= width)
			most = support_most(most, fabs(quanta[i] - quanta[i - width]));
	}
	free(quanta);
	return ldexp(most, -OFFSET_BITS);
}

/* A beam that stands in loose sand, its walls held, until all is at rest; then turns where it is. Its ends were far from
 * where it is now. */
static void what_an_object_turned_away_from_slides(void **state)
{
	static const struct hard_model sand = {
		"slippage", "redistribute: {model: slippage, iterations: 2, interval: 0.02}\nsoil: {name: dry_sand, cohesion: 0, friction_angle: 30}\n", true};
	const char *poses = support_path("beam.csv");
	const double stands = 0.25 * tan(M_PI / 6);
	for (int turned = 0; turned < 2; turned++) {
		char rest[512];
		const char *store = support_path("beam.furrow");
		support_store(store, extent, flat);
		support_write(poses, turned ? "t,x,y,z,yaw,pitch,roll\n0,30,30,20.2,0,0,0\n30,30,30,20.2,0,0,0\n30.1,30.3,30.02,20.2,90,0,0\n"
					    : "t,x,y,z,yaw,pitch,roll\n0,30,30,20.2,0,0,0\n30,30,30,20.2,0,0,0\n");
		snprintf(rest, sizeof rest, "time_step: 0.5\nend_time: 90\nspacing: 0.25\nobjects:\n"
			 "  - {name: beam, shape: {box: {size: [16, 1, 2]}}, path: {file: %s}}\n", poses);
		char *json = hard_drive(&sand, rest, store, NULL);
		assert_int_equal(support_figure(json, "\"slide\"", "awake"), 0);
		mem_free(json);
		double west = steepest(store, (struct post_rect){20 * 4, 26 * 4, 27 * 4, 34 * 4});
		if (turned)
			assert_true(west <= stands + 1e-6);
		else
			assert_true(west > 2 * stands); /* it held that */
	}
}

/* Its next station is no contact, so that nothing else wakes the ground it stood on. */
static void what_an_object_left_at_the_edge_of_the_world_slides(void **state)
{
	static const struct hard_model sand = {
		"slippage", "redistribute: {model: slippage, iterations: 2, interval: 0.02}\nsoil: {name: dry_sand, cohesion: 0, friction_angle: 30}\n", true};
	const char *poses = support_path("ball.csv");
	const double stands = 0.25 * tan(M_PI / 6);
	for (int left = 0; left < 2; left++) {
		char rest[512];
		const char *store = support_path("ball.furrow");
		support_store(store, extent, flat);
		support_write(poses, left ? "t,x,y,z\n0,0.1,30,20.3\n30,0.1,30,20.3\n30.5,-3,30,20.3\n" : "t,x,y,z\n0,0.1,30,20.3\n30,0.1,30,20.3\n");
		snprintf(rest, sizeof rest, "time_step: 0.5\nend_time: 60\nspacing: 0.25\noutside: skip\nobjects:\n"
			 "  - {name: ball, shape: {sphere: {radius: 1.5}}, path: {file: %s}}\n", poses);
		mem_free(hard_drive(&sand, rest, store, NULL));
		double most = steepest(store, (struct post_rect){0, 26 * 4, 4 * 4, 34 * 4});
		if (left)
			assert_true(most <= stands + 1e-6);
		else
			assert_true(most > 2 * stands);
	}
}

TEST_PROGRAM(turns)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(lugs_print_as_far_apart_as_the_wheel_rolls_between_them),
		cmocka_unit_test(what_an_object_turned_away_from_slides),
		cmocka_unit_test(what_an_object_left_at_the_edge_of_the_world_slides),
	};
	return cmocka_run_group_tests_name("hard turns", tests, support_enter, support_leave);
}
