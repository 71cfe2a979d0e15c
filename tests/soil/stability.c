/* How steep and how high a slope of a soil is stable: Culmann's wedge, beside the reference. */
#include "soil_test.h"

#include "deform/reference/reference.h"
#include "soil/stability.h"
#include "../support/program.h"

static const char *const cohesive[] = {"dry_sand", "clayey_38", "upland_loam_51"};

static struct soil_numbers soil_of(int i)
{
	struct soil_numbers soil;
	assert_ok(soil_named(cohesive[i], &soil));
	return soil;
}

static void the_angle_of_a_height_is_the_one_whose_height_it_is(void **state)
{
	(void)state;
	for (int i = 0; i < 3; i++) {
		struct soil_numbers soil = soil_of(i);
		double upright = reference_culmann(&soil, M_PI / 2), before = 0;
		assert_true(soil_critical_cotangent(&soil, 0.999 * upright) < 0);
		for (double height = 1.001 * upright; height < 200 * upright; height *= 1.3) {
			double cotangent = soil_critical_cotangent(&soil, height);
			assert_true(fabs(reference_culmann(&soil, atan(1 / cotangent)) / height - 1) < 1e-9);
			assert_true(cotangent > before && cotangent * tan(soil.friction_angle) < 1);
			before = cotangent;
		}
		soil.cohesion = 0;
		assert_true(fabs(soil_critical_cotangent(&soil, 1) * tan(soil.friction_angle) - 1) < 1e-12);
	}
	struct soil_numbers clay = {.cohesion = 5000, .unit_weight = 16000};
	double height = 4 * clay.cohesion * sin(1) / (clay.unit_weight * (1 - cos(1)));
	assert_true(fabs(atan(1 / soil_critical_cotangent(&clay, height)) - 1) < 1e-12);
}

static void a_cut_is_stable_to_culmanns_height(void **state)
{
	const struct soil_numbers clay = {.cohesion = 4140, .friction_angle = 13 * M_PI / 180, .unit_weight = 16000};
	(void)state;
	/* Between posts so near the cut is upright, to a per mille. */
	assert_true(fabs(ldexp(soil_critical_difference_cohesive(&clay, 1e-4), -20) - 1.301) < 0.001);
	/* Without cohesion the angle alone. */
	struct soil_numbers sand = clay;
	sand.cohesion = 0;
	assert_int_equal(soil_critical_difference_cohesive(&sand, 0.5), (int)floor(ldexp(0.5 * tan(sand.friction_angle), 20)));
	/* With more than any height is worth, always. */
	sand.cohesion = 1e9;
	assert_int_equal(soil_critical_difference_cohesive(&sand, 0.5), INT32_MAX);
	assert_int_equal(soil_critical_difference(89.95 * M_PI / 180, 1), INT32_MAX);
	assert_true(soil_critical_difference(89.9 * M_PI / 180, 1) < INT32_MAX);
}

TEST_PROGRAM(stability)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_angle_of_a_height_is_the_one_whose_height_it_is),
		cmocka_unit_test(a_cut_is_stable_to_culmanns_height),
	};
	return cmocka_run_group_tests_name("soil/stability", tests, NULL, NULL);
}
