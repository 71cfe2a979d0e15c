/* Hillshade and colours over it: pure functions. */
#include "../support.h"
#include "../support/program.h"

#include "chart/internal.h"

enum { W = 7, H = 5 };

static struct chart_sun usual(void)
{
	struct chart_sun sun;
	chart_sun_of(CHART_AZIMUTH, CHART_ALTITUDE, &sun);
	return sun;
}

/* Posts with one more at each side. */
static void posts(double *heights, double east, double north, double spacing)
{
	for (int y = 0; y < H + 2; y++)
		for (int x = 0; x < W + 2; x++)
			heights[y * (W + 2) + x] = 1000 + spacing * (east * x + north * y);
}

/* A plane has its own slope everywhere, at any spacing, also beside holes and at the edge of all posts. */
static void a_plane_has_its_slope_up_to_its_last_post(void **state)
{
	for (double spacing = 1.0 / 64; spacing < 1000; spacing *= 7) {
		double heights[(W + 2) * (H + 2)], east[W * H], north[W * H];
		posts(heights, 0.25, -0.5, spacing);
		for (int y = 0; y < H + 2; y++)
			for (int x = 0; x < W + 2; x++)
				if (x == 0 || y == 0 || y == H + 1 || (x == 4 && y == 3))
					heights[y * (W + 2) + x] = (double)NAN;
		chart_slopes(heights, W, H, spacing, east, north);
		for (int i = 0; i < W * H; i++) {
			bool hole = i == 2 * W + 3;
			assert_int_equal(isnan(east[i]) && isnan(north[i]), hole);
			assert_true(hole || fabs(east[i] - 0.25) < 1e-9);
			assert_true(hole || fabs(north[i] + 0.5) < 1e-9);
		}
	}
}

static void a_post_alone_is_level(void **state)
{
	double heights[9], east, north;
	for (int i = 0; i < 9; i++)
		heights[i] = i == 4 ? 12 : (double)NAN;
	chart_slopes(heights, 1, 1, 2, &east, &north);
	assert_true(east == 0 && north == 0);
}

/* Horn's weights: 1 2 1. */
static void neighbours_weigh_as_horn_says(void **state)
{
	for (int i = 0; i < 9; i++) {
		static const double wanted_east[9] = {-1, 0, 1, -2, 0, 2, -1, 0, 1}, wanted_north[9] = {-1, -2, -1, 0, 0, 0, 1, 2, 1};
		double heights[9] = {0}, east, north;
		heights[i] = 1;
		chart_slopes(heights, 1, 1, 4, &east, &north);
		assert_true(fabs(east - wanted_east[i] / 32) < 1e-12 && fabs(north - wanted_north[i] / 32) < 1e-12);
	}
}

static void light_comes_from_the_north_west(void **state)
{
	struct chart_sun sun = usual();
	double flat = chart_shade(&sun, 0, 0);
	/* Ground that falls to the north-west rises to the south-east. */
	double toward = chart_shade(&sun, 0.4, -0.4), away = chart_shade(&sun, -0.4, 0.4);
	assert_true(flat > 0.6 && flat < 0.85);
	assert_true(toward > flat + 0.1 && away < flat - 0.25);
	/* The same to both sides, but steeper is told from flat there, too. */
	double left = chart_shade(&sun, 0.4, 0.4), right = chart_shade(&sun, -0.4, -0.4);
	assert_true(fabs(left - right) < 1e-12 && fabs(left - flat) > 0.05);
	for (double angle = 0; angle < 6.3; angle += 0.1)
		for (double steep = 0; steep < 1e6; steep = 3 * steep + 0.1) {
			double shade = chart_shade(&sun, steep * cos(angle), steep * sin(angle));
			assert_true(shade > 0.03 && shade <= 1);
		}
	assert_true(isnan(chart_shade(&sun, (double)NAN, 0)));
	/* Turned to the east it lights what falls to the east. */
	chart_sun_of(M_PI / 2, M_PI / 4, &sun);
	assert_true(chart_shade(&sun, -0.5, 0) > chart_shade(&sun, 0.5, 0) + 0.2);
}

static int distance(struct chart_colour a, struct chart_colour b)
{
	return abs(a.r - b.r) + abs(a.g - b.g) + abs(a.b - b.b);
}

/* Nothing is transparent; ruts are blue, heaps red; each step of a ramp is seen on flat ground. */
static void ramps_tell_values_apart(void **state)
{
	struct chart_sun sun = usual();
	double flat = chart_shade(&sun, 0, 0);
	for (enum chart_ramp ramp = CHART_RAMP_SIGNED; ramp <= CHART_RAMP_ROSE; ramp++) {
		assert_int_equal(chart_ramp(ramp, 0).a, 0);
		struct chart_colour bare = chart_ground_colour(flat, flat, chart_ramp(ramp, 0));
		assert_true(bare.r == bare.g || abs(bare.r - bare.b) < 10); /* paper */
		for (int sign = ramp == CHART_RAMP_SIGNED ? -1 : 1; sign <= 1; sign += 2)
			for (int i = 0; i < 10; i++) {
				struct chart_colour a = chart_ground_colour(flat, flat, chart_ramp(ramp, sign * i / 10.0));
				struct chart_colour b = chart_ground_colour(flat, flat, chart_ramp(ramp, sign * (i + 1) / 10.0));
				assert_true(distance(a, b) > 15);
			}
		/* Beyond the end is the end. */
		assert_int_equal(distance(chart_ramp(ramp, 7), chart_ramp(ramp, 1)), 0);
	}
	struct chart_colour rut = chart_ground_colour(flat, flat, chart_ramp(CHART_RAMP_SIGNED, -1));
	struct chart_colour heap = chart_ground_colour(flat, flat, chart_ramp(CHART_RAMP_SIGNED, 1));
	assert_true(rut.b > rut.r && heap.r > heap.b);
}

static void lengths_and_ranges_are_round(void **state)
{
	assert_true(chart_round_length(99.99) == 50 && chart_round_length(100) == 100 && chart_round_length(0.021) > 0.0199);
	assert_true(fabs(chart_round_length(4.9e-3) - 2e-3) < 1e-12 && chart_round_length(7e6) == 5e6);
	for (double size = 1e-6; size < 2000; size *= 1.37) {
		double range = chart_round_range(size), length = chart_round_length(size);
		assert_true(range >= size * (1 - 1e-5) && range < 1.67 * size);
		assert_true(length <= size * (1 + 1e-8) && length > 0.39 * size);
	}
	struct chart_range range = {-0.5, 2};
	assert_true(chart_ramp_place(CHART_RAMP_SIGNED, &range, -0.25) == -0.5 && chart_ramp_place(CHART_RAMP_SIGNED, &range, 1) == 0.5);
	assert_true(chart_ramp_place(CHART_RAMP_SIGNED, &range, 0) == 0);
}

TEST_PROGRAM(shade)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_plane_has_its_slope_up_to_its_last_post),
		cmocka_unit_test(a_post_alone_is_level),
		cmocka_unit_test(neighbours_weigh_as_horn_says),
		cmocka_unit_test(light_comes_from_the_north_west),
		cmocka_unit_test(ramps_tell_values_apart),
		cmocka_unit_test(lengths_and_ranges_are_round),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
