/* Verdicts beside closed forms: with straight curves, each answer is a line of algebra. */
#include <math.h>

#include "../support.h"
#include "mobility/mobility.h"

#define RADIANS (3.14159265358979323846 / 180)
#define G 9.81

/* Drawbar N (0.1 + 0.8 s) of every wheel, torque N r (0.3 + 0.5 s), sinkage 1e-5 N. */
static void straight(struct mobility_curves *curves, const struct vehicle_outline *vehicle)
{
	*curves = (struct mobility_curves){.friction_angle = 40, .kind_count = 1};
	struct mobility_wheel_curves *of = &curves->of[0];
	for (size_t l = 0; l < MOBILITY_LOADS; l++) {
		const double load = of->loads[l] = vehicle->mass * G / 4 * (0.1 + 0.6 * (double)l);
		for (size_t s = 0; s < MOBILITY_SLIPS; s++)
			of->points[l][s] = (struct mobility_point){load * (0.1 + 0.8 * mobility_slips[s]),
								   load * vehicle->wheels[0].radius * (0.3 + 0.5 * mobility_slips[s]), 1e-5 * load, true};
	}
}

static struct vehicle_outline car(void)
{
	struct vehicle_outline vehicle = {.mass = 1000, .height = 0.6, .clearance = INFINITY, .wheel_count = 4};
	for (size_t i = 0; i < 4; i++)
		vehicle.wheels[i] = (struct vehicle_wheel){i < 2 ? 1.2 : -1.2, i % 2 == 0 ? 0.7 : -0.7, 0.35, 0.25, true, INFINITY};
	return vehicle;
}

static void slip_is_that_of_the_slope(void **state)
{
	struct vehicle_outline vehicle = car();
	struct mobility_curves curves;
	(void)state;
	straight(&curves, &vehicle);
	for (double slope = 0; slope <= 30; slope += 5)
		for (double gravity = 1.62; gravity < 10; gravity += 8.19) {
			/* Curves scale with the load, so gravity changes nothing. */
			for (size_t l = 0; l < MOBILITY_LOADS; l++) {
				const double load = vehicle.mass * gravity / 4 * (0.1 + 0.6 * (double)l), ratio = load / curves.of[0].loads[l];
				curves.of[0].loads[l] = load;
				for (size_t s = 0; s < MOBILITY_SLIPS; s++)
					curves.of[0].points[l][s].drawbar *= ratio;
			}
			const struct mobility_verdict got = mobility_judge(&vehicle, &curves, gravity, slope, 0);
			const double wanted = fmax((tan(slope * RADIANS) - 0.1) / 0.8, mobility_slips[0]);
			assert_int_equal(got.reason, MOBILITY_GO);
			assert_true(fabs(got.slip - wanted) < 1e-6);
		}
	/* Beyond the pull at the greatest slip: tan > 0.1 + 0.8 x 0.9. */
	curves.friction_angle = 60;
	assert_int_equal(mobility_judge(&vehicle, &curves, G, atan(0.81) / RADIANS, 0).reason, MOBILITY_GO);
	assert_int_equal(mobility_judge(&vehicle, &curves, G, atan(0.83) / RADIANS, 0).reason, MOBILITY_NO_PULL);
}

static void free_wheels_do_not_pull(void **state)
{
	struct vehicle_outline vehicle = car();
	struct mobility_curves curves;
	(void)state;
	straight(&curves, &vehicle);
	vehicle.wheels[2].driven = vehicle.wheels[3].driven = false;
	/* Curves: torque 0 would be at slip -0.6, off them: the least slip, -0.3, pulls N (0.1 - 0.24). */
	const double a = 5 * RADIANS, transfer = 0.6 * tan(a) / 2.4; /* h tan / wheelbase, of N */
	const double front = 0.5 - transfer, rear = 0.5 + transfer;
	const double wanted = ((tan(a) + 0.14 * rear) / front - 0.1) / 0.8;
	const struct mobility_verdict got = mobility_judge(&vehicle, &curves, G, 5, 0);
	assert_int_equal(got.reason, MOBILITY_GO);
	assert_true(fabs(got.slip - wanted) < 1e-6);
}

static void it_tips_where_its_weight_leaves_the_wheels(void **state)
{
	struct vehicle_outline vehicle = car();
	struct mobility_curves curves;
	(void)state;
	straight(&curves, &vehicle);
	curves.friction_angle = 89;
	curves.of[0].loads[0] = 1e-6; /* down to no load */
	/* Of a rectangle of wheels the upper ones are free where h tan = half the length, or half the width. */
	const double up = atan(1.2 / 0.6) / RADIANS, aside = atan(0.7 / 0.6) / RADIANS;
	assert_int_not_equal(mobility_judge(&vehicle, &curves, G, up - 0.5, 0).reason, MOBILITY_TIPS);
	assert_int_equal(mobility_judge(&vehicle, &curves, G, up + 0.5, 0).reason, MOBILITY_TIPS);
	assert_int_not_equal(mobility_judge(&vehicle, &curves, G, aside - 0.5, 90).reason, MOBILITY_TIPS);
	assert_int_equal(mobility_judge(&vehicle, &curves, G, aside + 0.5, 90).reason, MOBILITY_TIPS);
}

static void each_limit_is_told(void **state)
{
	struct vehicle_outline vehicle = car();
	struct mobility_curves curves;
	(void)state;
	straight(&curves, &vehicle);
	const struct mobility_verdict free = mobility_judge(&vehicle, &curves, G, 15, 0);
	assert_int_equal(free.reason, MOBILITY_GO);
	for (size_t i = 0; i < 4; i++)
		vehicle.wheels[i].torque_most = 0.99 * free.torque;
	assert_int_equal(mobility_judge(&vehicle, &curves, G, 15, 0).reason, MOBILITY_NO_TORQUE);
	for (size_t i = 0; i < 4; i++)
		vehicle.wheels[i].torque_most = 1.01 * free.torque;
	assert_int_equal(mobility_judge(&vehicle, &curves, G, 15, 0).reason, MOBILITY_GO);
	vehicle.clearance = 0.99 * free.sinkage;
	assert_int_equal(mobility_judge(&vehicle, &curves, G, 15, 0).reason, MOBILITY_NO_CLEARANCE);
	vehicle.clearance = INFINITY;
	assert_int_equal(mobility_judge(&vehicle, &curves, G, 41, 0).reason, MOBILITY_TOO_STEEP);
	for (size_t l = 0; l < MOBILITY_LOADS; l++)
		for (size_t s = 0; s < MOBILITY_SLIPS; s++)
			curves.of[0].points[l][s].steady = mobility_slips[s] < 0.15;
	assert_int_equal(mobility_judge(&vehicle, &curves, G, 2, 0).reason, MOBILITY_GO);
	assert_int_equal(mobility_judge(&vehicle, &curves, G, 15, 0).reason, MOBILITY_DIGS);
	straight(&curves, &vehicle);
	curves.of[0].loads[MOBILITY_LOADS - 1] = 1.0001 * vehicle.mass * G / 4;
	curves.of[0].loads[MOBILITY_LOADS - 2] = 0.9 * vehicle.mass * G / 4;
	assert_int_equal(mobility_judge(&vehicle, &curves, G, 0, 0).reason, MOBILITY_GO);
	assert_int_equal(mobility_judge(&vehicle, &curves, G, 10, 0).reason, MOBILITY_OFF_CURVES);
}

static void the_table_is_the_judge(void **state)
{
	static struct mobility_table table;
	struct vehicle_outline vehicle = car();
	struct mobility_curves curves;
	(void)state;
	straight(&curves, &vehicle);
	for (size_t i = 0; i < 4; i++)
		vehicle.wheels[i].torque_most = 0.35 * vehicle.mass * G / 4 * 0.55; /* enough for some slopes */
	mobility_table_make(&vehicle, &curves, G, &table);
	double before = 91;
	for (double slope = 0; slope < 45; slope += 0.5) {
		const struct mobility_slope got = mobility_table_at(&table, slope);
		const struct mobility_verdict up = mobility_judge(&vehicle, &curves, G, slope, 0);
		assert_int_equal(got.up.reason, up.reason);
		assert_true(up.reason != MOBILITY_GO || fabs(got.up.slip - up.slip) < 1e-9);
		/* Steeper ground allows no steeper heading. Straight up is 90 degrees. */
		const double steepest = isnan(got.steepest) ? -1 : got.steepest;
		assert_true(steepest <= before && (up.reason != MOBILITY_GO || steepest == 90));
		before = steepest;
	}
	assert_true(before == -1);
	assert_int_equal(mobility_table_at(&table, NAN).up.reason, MOBILITY_NO_GROUND);
	assert_int_equal(mobility_table_at(&table, 80).up.reason, MOBILITY_TOO_STEEP);
}

static void soils_vary_by_their_factors(void **state)
{
	const char *key;
	double value, wanted;
	struct scene *plain, *varied;
	(void)state;
	must(rig_soil_scene("dry_sand", &plain));
	char *text = mobility_soil_varied("dry_sand", (double[]){0.5, 1.2, 0.8});
	assert_non_null(text);
	must(rig_soil_scene(text, &varied));
	for (size_t i = 0; scene_soil_number(&plain->soils[0], i, &key, &wanted); i++) {
		assert_true(scene_soil_number(&varied->soils[0], i, &key, &value));
		if (strcmp(key, "cohesion") == 0)
			wanted *= 0.5;
		else if (strcmp(key, "friction_angle") == 0)
			wanted = atan(1.2 * tan(wanted * RADIANS)) / RADIANS;
		else if (strncmp(key, "bekker_k", 8) == 0)
			wanted *= 0.8;
		assert_true(isnan(value) ? isnan(wanted) : fabs(value - wanted) <= 1e-9 * fabs(wanted));
	}
	mem_free(text);
	scene_destroy(plain);
	scene_destroy(varied);
	assert_null(mobility_soil_varied("moondust", (double[]){1, 1, 1}));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(slip_is_that_of_the_slope),
		cmocka_unit_test(free_wheels_do_not_pull),
		cmocka_unit_test(it_tips_where_its_weight_leaves_the_wheels),
		cmocka_unit_test(each_limit_is_told),
		cmocka_unit_test(the_table_is_the_judge),
		cmocka_unit_test(soils_vary_by_their_factors),
	};
	return cmocka_run_group_tests_name("mobility/judge", tests, NULL, NULL);
}
