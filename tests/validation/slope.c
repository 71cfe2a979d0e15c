/* Numbers 5 and 6 of the soil models: a vertical cut stands to its height, a pile at its angle. */
#include <stdio.h>

#include "bed.h"
#include "../support/program.h"

static struct soil_numbers cut_soil(void)
{
	return (struct soil_numbers){.cohesion = 4140, .friction_angle = 13 * RADIANS, .unit_weight = 16e3};
}

static void a_vertical_cut_stands_after_culmann(void **state)
{
	struct soil_numbers soil = cut_soil();
	bed_near("height, m", reference_culmann(&soil, 90 * RADIANS), 1.301, 0.0005 / 1.301);
	/* And by trying every plane, for that slope and others. */
	for (int slope = 20; slope <= 90; slope += 10) {
		double height = reference_culmann(&soil, slope * RADIANS);
		char what[64];
		snprintf(what, sizeof what, "safety of that height at %d degrees", slope);
		bed_near(what, reference_safety(&soil, slope * RADIANS, height), 1, 1e-6);
		assert_true(reference_safety(&soil, slope * RADIANS, height * 1.01) < 1);
		assert_true(reference_safety(&soil, slope * RADIANS, height * 0.99) > 1);
	}
	assert_true(reference_culmann(&soil, 12.9 * RADIANS) == INFINITY);
}

static double cliff;

static double cliff_ground(int x, int y)
{
	(void)y;
	return x < 8 ? cliff : 0;
}

static double fallen(double height, double spacing)
{
	const struct bed_params params = {.width = 16, .height = 5, .spacing = spacing, .ground = cliff_ground, .model = DEFORM_SLIPPAGE, .soil = cut_soil()};
	struct bed bed;
	cliff = height;
	bed_init(&bed, &params);
	const double before = bed_surface_at(&bed, 7, 2);
	bed_settle(&bed);
	const double drop = before - bed_surface_at(&bed, 7, 2);
	bed_finish(&bed);
	return drop;
}

/* The height of a cut between two posts at which it is just safe, m. */
static double stands_at(const struct soil_numbers *soil, double spacing)
{
	double low = 0, high = 100;
	for (int i = 0; i < 80; i++) {
		const double middle = (low + high) / 2;
		*(reference_safety(soil, atan(middle / spacing), middle) > 1 ? &low : &high) = middle;
	}
	return low;
}

/*
 * Between posts a cut is no steeper than atan(H / d), and stands higher by that: dH = d cos phi / (1 - sin phi) to first
 * order, 1.26 d. What stands and what slips lies a millimetre from that.
 */
static void a_cut_between_posts_stands_to_that_and_slips_above(void **state)
{
	static const double spacings[] = {1.0 / 4096, 1.0 / 64, 0.05};
	struct soil_numbers soil = cut_soil();
	for (size_t i = 0; i < sizeof spacings / sizeof *spacings; i++) {
		double stands = stands_at(&soil, spacings[i]);
		double first_order = spacings[i] * cos(soil.friction_angle) / (1 - sin(soil.friction_angle));
		bed_near("stands, m", stands, 1.3012 + first_order, 0.0002 + pow(spacings[i] / 1.3, 2));
		assert_true(fallen(stands - 0.001, spacings[i]) == 0);
		assert_true(fallen(stands + 0.001, spacings[i]) > 0.0001);
	}
	/* At a spacing that can be neglected, the number itself. */
	assert_true(fallen(1.300, 1.0 / 4096) == 0);
	assert_true(fallen(1.303, 1.0 / 4096) > 0);
}

#define MIDDLE 40

static double column_ground(int x, int y)
{
	return abs(x - MIDDLE) <= 2 && abs(y - MIDDLE) <= 2 ? 20 : 0;
}

/*
 * Along rows, columns and diagonals the slope is the angle's and no post of these is further than a post's drop from the
 * cone. Between them only those eight are looked at: there a face of the pile is steeper by up to 1 / cos(22.5 degrees).
 */
static void a_pile_of_sand_relaxes_to_its_angle(void **state)
{
	static const int ways[8][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
	double spacing = 0.1, steep = tan(30 * RADIANS), volume = 0;
	struct bed_params params = {.width = 2 * MIDDLE + 1, .height = 2 * MIDDLE + 1, .spacing = spacing, .ground = column_ground,
				    .model = DEFORM_SLIPPAGE, .soil = {.friction_angle = 30 * RADIANS, .unit_weight = 16e3}};
	struct bed bed;
	bed_init(&bed, &params);
	bed_settle(&bed);
	double *surface = bed_surface(&bed);
#define AT(x, y) surface[(y) * bed.ground.posts + (x)]
	double top = AT(MIDDLE, MIDDLE), steepest = 0, face = 0, furthest = 0;
	for (int k = 0; k < 8; k++) {
		double step = spacing * hypot(ways[k][0], ways[k][1]), here = top;
		for (int i = 1; i < MIDDLE; i++) {
			double next = AT(MIDDLE + i * ways[k][0], MIDDLE + i * ways[k][1]);
			double off = fabs(next - fmax(0, top - i * step * steep)) / (step * steep);
			steepest = support_most(steepest, (here - next) / step);
			furthest = support_most(furthest, off);
			here = next;
		}
		/* Half way down a row or a column the slope itself, neither less nor more. */
		if (k % 2 == 0)
			bed_near("slope of ten posts", (AT(MIDDLE + 5 * ways[k][0], MIDDLE + 5 * ways[k][1]) -
							AT(MIDDLE + 15 * ways[k][0], MIDDLE + 15 * ways[k][1])) /
						       (10 * step), steep, 1e-4);
	}
	for (int y = 0; y < params.height; y++)
		for (int x = 0; x < params.width; x++) {
			volume += AT(x, y) * spacing * spacing;
			if (x == 0 || y == 0 || x + 1 == params.width || y + 1 == params.height)
				continue;
			double east = AT(x + 1, y) - AT(x - 1, y);
			double north = AT(x, y + 1) - AT(x, y - 1);
			face = support_most(face, hypot(east, north) / (2 * spacing));
		}
	print_message("steepest of two neighbours %.6f of tan 30, furthest from the cone %.3f of a post, steepest face %.3f\n",
		      steepest / steep, furthest, face / steep);
	assert_true(steepest < steep * 1.0001);
	assert_true(furthest < 1);
	assert_true(face < steep / cos(22.5 * RADIANS) * 1.001);
	bed_near("height, and a cone's of that volume, m", top, cbrt(3 * 5 * steep * steep / M_PI), steep * spacing / top);
	bed_near("volume, m3", volume, 25 * 20 * spacing * spacing, 1e-12);
#undef AT
	mem_free(surface);
	bed_finish(&bed);
}

TEST_PROGRAM(slope)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_vertical_cut_stands_after_culmann),
		cmocka_unit_test(a_cut_between_posts_stands_to_that_and_slips_above),
		cmocka_unit_test(a_pile_of_sand_relaxes_to_its_angle),
	};
	return cmocka_run_group_tests_name("validation/slope", tests, NULL, NULL);
}
