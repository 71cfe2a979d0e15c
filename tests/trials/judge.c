/* Verdicts beside closed forms: with straight curves, each answer is a line of algebra. */
#include <math.h>

#include "../support.h"
#include "../support/program.h"
#include "scene/scene.h"
#include "trials/trials.h"

#define RADIANS (3.14159265358979323846 / 180)
#define G 9.81

/* Drawbar N (0.1 + 0.8 s) of every wheel, torque N r (0.3 + 0.5 s), sinkage 1e-5 N. */
static void straight(struct mobility_curves *curves, const struct trials_vehicle *vehicle)
{
	*curves = (struct mobility_curves){.friction_angle = 40, .kind_count = 1};
	struct mobility_wheel_curves *of = &curves->of[0];
	of->radius = vehicle->wheels[0].radius;
	of->width = vehicle->wheels[0].width;
	for (size_t l = 0; l < MOBILITY_LOADS; l++) {
		const double load = of->loads[l] = vehicle->mass * G / 4 * (0.1 + 0.6 * (double)l);
		for (size_t s = 0; s < MOBILITY_SLIPS; s++)
			of->points[l][s] = (struct mobility_point){load * (0.1 + 0.8 * trials_slips[s]),
								   load * vehicle->wheels[0].radius * (0.3 + 0.5 * trials_slips[s]), 1e-5 * load, 0, true};
	}
}

static struct trials_vehicle car(void)
{
	struct trials_vehicle vehicle = {.mass = 1000, .height = 0.6, .clearance = INFINITY, .wheel_count = 4};
	for (size_t i = 0; i < 4; i++)
		vehicle.wheels[i] = (struct trials_wheel){i < 2 ? 1.2 : -1.2, i % 2 == 0 ? 0.7 : -0.7, 0.35, 0.25, true, INFINITY};
	return vehicle;
}

static void slip_is_that_of_the_slope(void **state)
{
	struct trials_vehicle vehicle = car();
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
			const struct mobility_verdict got = trials_judge(&vehicle, &curves, gravity, slope, 0);
			const double wanted = fmax((tan(slope * RADIANS) - 0.1) / 0.8, trials_slips[0]);
			assert_int_equal(got.reason, MOBILITY_GO);
			assert_true(fabs(got.slip - wanted) < 1e-6);
		}
	/* Beyond the pull at the greatest slip: tan > 0.1 + 0.8 x 0.9. */
	curves.friction_angle = 60;
	assert_int_equal(trials_judge(&vehicle, &curves, G, atan(0.81) / RADIANS, 0).reason, MOBILITY_GO);
	assert_int_equal(trials_judge(&vehicle, &curves, G, atan(0.83) / RADIANS, 0).reason, MOBILITY_NO_PULL);
}

static void free_wheels_do_not_pull(void **state)
{
	struct trials_vehicle vehicle = car();
	struct mobility_curves curves;
	(void)state;
	straight(&curves, &vehicle);
	vehicle.wheels[2].driven = vehicle.wheels[3].driven = false;
	/* Curves: torque 0 would be at slip -0.6, off them: the least slip, -0.3, pulls N (0.1 - 0.24). */
	const double a = 5 * RADIANS, transfer = 0.6 * tan(a) / 2.4; /* h tan / wheelbase, of N */
	const double front = 0.5 - transfer, rear = 0.5 + transfer;
	const double wanted = ((tan(a) + 0.14 * rear) / front - 0.1) / 0.8;
	const struct mobility_verdict got = trials_judge(&vehicle, &curves, G, 5, 0);
	assert_int_equal(got.reason, MOBILITY_GO);
	assert_true(fabs(got.slip - wanted) < 1e-6);
}

static void it_tips_where_its_weight_leaves_the_wheels(void **state)
{
	struct trials_vehicle vehicle = car();
	struct mobility_curves curves;
	(void)state;
	straight(&curves, &vehicle);
	curves.friction_angle = 89;
	curves.of[0].loads[0] = 1e-6; /* down to no load */
	/* Of a rectangle of wheels the upper ones are free where h tan = half the length, or half the width. */
	const double up = atan(1.2 / 0.6) / RADIANS, aside = atan(0.7 / 0.6) / RADIANS;
	assert_int_not_equal(trials_judge(&vehicle, &curves, G, up - 0.5, 0).reason, MOBILITY_TIPS);
	assert_int_equal(trials_judge(&vehicle, &curves, G, up + 0.5, 0).reason, MOBILITY_TIPS);
	assert_int_not_equal(trials_judge(&vehicle, &curves, G, aside - 0.5, 90).reason, MOBILITY_TIPS);
	assert_int_equal(trials_judge(&vehicle, &curves, G, aside + 0.5, 90).reason, MOBILITY_TIPS);
}

/* Shear of 0.9 of the load for each unit of slip, and a resistance of 0.1. Without depth, shear at an angle has the parts 0.9 s and
 * 0.9 (1 - s) tan(crab). */
static void across_a_slope_it_points_up_it(void **state)
{
	struct trials_vehicle vehicle = car();
	struct mobility_curves curves;
	(void)state;
	straight(&curves, &vehicle);
	for (size_t l = 0; l < MOBILITY_LOADS; l++)
		for (size_t s = 0; s < MOBILITY_SLIPS; s++) {
			const double load = curves.of[0].loads[l], shear = 0.9 * trials_slips[s] * load;
			curves.of[0].points[l][s] = (struct mobility_point){shear - 0.1 * load, shear * 0.35, 1e-5 * load, 0, true};
		}
	for (double heading = 30; heading <= 90; heading += 30)
		for (double slope = 4; slope <= 16; slope += 6) {
			const struct mobility_verdict got = trials_judge(&vehicle, &curves, G, slope, heading);
			assert_int_equal(got.reason, MOBILITY_GO);
			const double crab = got.crab * RADIANS, pull = tan(slope * RADIANS), h = heading * RADIANS;
			/* In the vehicle's own directions the weight down the slope has these parts. */
			assert_true(fabs(0.9 * got.slip - 0.1 - pull * cos(h - crab)) < 1e-4);
			assert_true(fabs(0.9 * (1 - got.slip) * tan(crab) - pull * sin(h - crab)) < 1e-4);
		}
	/* Whole shear is 0.81 of the load. At 45 degrees more than that is needed across. */
	curves.friction_angle = 60;
	vehicle.height = 0.01;
	assert_int_equal(trials_judge(&vehicle, &curves, G, atan(0.83 / sin(45 * RADIANS)) / RADIANS, 90).reason, MOBILITY_SLIDES);
	assert_int_equal(trials_judge(&vehicle, &curves, G, atan(0.79 / sin(45 * RADIANS)) / RADIANS, 90).reason, MOBILITY_NO_PULL);
}

/* Sinkage is 1e-5 m / N, so it tells the load of the wheel that has most. */
static void loads_move_down_the_slope(void **state)
{
	struct trials_vehicle vehicle = car();
	struct mobility_curves curves;
	(void)state;
	straight(&curves, &vehicle);
	for (double heading = 0; heading <= 90; heading += 30)
		for (double slope = 2; slope <= 14; slope += 6) {
			const double a = slope * RADIANS, h = heading * RADIANS, quarter = vehicle.mass * G / 4;
			const double most = quarter * (cos(a) + 0.6 * sin(a) * (cos(h) / 1.2 + sin(h) / 0.7));
			const struct mobility_verdict got = trials_judge(&vehicle, &curves, G, slope, heading);
			assert_int_equal(got.reason, MOBILITY_GO);
			assert_true(fabs(got.sinkage - 1e-5 * most) < 1e-9);
		}
}

static void brakes_hold_it_down_to_a_slope(void **state)
{
	struct trials_vehicle vehicle = car();
	struct mobility_curves curves;
	(void)state;
	straight(&curves, &vehicle);
	const struct mobility_verdict down = trials_judge(&vehicle, &curves, G, 5, 180);
	assert_int_equal(down.reason, MOBILITY_GO);
	assert_true(fabs(down.slip - (-tan(5 * RADIANS) - 0.1) / 0.8) < 1e-5);
	/* At a slip of -0.3 the wheels hold 0.14 of their load. */
	assert_int_equal(trials_judge(&vehicle, &curves, G, atan(0.13) / RADIANS, 180).reason, MOBILITY_GO);
	assert_int_equal(trials_judge(&vehicle, &curves, G, atan(0.15) / RADIANS, 180).reason, MOBILITY_SLIDES);
}

static void wheels_behind_each_other_share_a_track(void **state)
{
	struct trials_vehicle vehicle = car();
	(void)state;
	for (size_t i = 0; i < 4; i++)
		assert_int_equal(trials_wheel_pass(&vehicle, i), i < 2 ? 0 : 1);
	/* A rear axle that is narrower by more than half a wheel has ground of its own. */
	vehicle.wheels[2].y = 0.7 - 0.13;
	assert_int_equal(trials_wheel_pass(&vehicle, 2), 0);
	vehicle.wheels[2].y = 0.7 - 0.12;
	assert_int_equal(trials_wheel_pass(&vehicle, 2), 1);
	/* Twin wheels of one axle are side by side. */
	vehicle.wheels[1] = (struct trials_wheel){1.2, 0.6, 0.35, 0.25, true, INFINITY};
	assert_int_equal(trials_wheel_pass(&vehicle, 0), 0);
	for (size_t i = 4; i < 9; i++)
		vehicle.wheels[vehicle.wheel_count++] = (struct trials_wheel){-1.2 * (double)i, -0.7, 0.35, 0.25, true, INFINITY};
	assert_int_equal(trials_wheel_pass(&vehicle, 8), RIG_PASSES_MOST - 1);
}

static void each_limit_is_told(void **state)
{
	struct trials_vehicle vehicle = car();
	struct mobility_curves curves;
	(void)state;
	straight(&curves, &vehicle);
	const struct mobility_verdict free = trials_judge(&vehicle, &curves, G, 15, 0);
	assert_int_equal(free.reason, MOBILITY_GO);
	for (size_t i = 0; i < 4; i++)
		vehicle.wheels[i].torque_most = 0.99 * free.torque;
	assert_int_equal(trials_judge(&vehicle, &curves, G, 15, 0).reason, MOBILITY_NO_TORQUE);
	for (size_t i = 0; i < 4; i++)
		vehicle.wheels[i].torque_most = 1.01 * free.torque;
	assert_int_equal(trials_judge(&vehicle, &curves, G, 15, 0).reason, MOBILITY_GO);
	vehicle.clearance = 0.99 * free.sinkage;
	assert_int_equal(trials_judge(&vehicle, &curves, G, 15, 0).reason, MOBILITY_NO_CLEARANCE);
	vehicle.clearance = INFINITY;
	assert_int_equal(trials_judge(&vehicle, &curves, G, 41, 0).reason, MOBILITY_TOO_STEEP);
	assert_true(trials_is_unknown(MOBILITY_TOO_STEEP) && trials_is_unknown(MOBILITY_OFF_CURVES));
	assert_true(!trials_is_unknown(MOBILITY_DIGS) && !trials_is_unknown(MOBILITY_SLIDES) && !trials_is_unknown(MOBILITY_TIPS));
	for (size_t l = 0; l < MOBILITY_LOADS; l++)
		for (size_t s = 0; s < MOBILITY_SLIPS; s++)
			curves.of[0].points[l][s].steady = trials_slips[s] < 0.15;
	assert_int_equal(trials_judge(&vehicle, &curves, G, 2, 0).reason, MOBILITY_GO);
	assert_int_equal(trials_judge(&vehicle, &curves, G, 15, 0).reason, MOBILITY_DIGS);
	straight(&curves, &vehicle);
	curves.of[0].loads[MOBILITY_LOADS - 1] = 1.0001 * vehicle.mass * G / 4;
	curves.of[0].loads[MOBILITY_LOADS - 2] = 0.9 * vehicle.mass * G / 4;
	assert_int_equal(trials_judge(&vehicle, &curves, G, 0, 0).reason, MOBILITY_GO);
	assert_int_equal(trials_judge(&vehicle, &curves, G, 10, 0).reason, MOBILITY_OFF_CURVES);
}

static void the_table_is_the_judge(void **state)
{
	static struct mobility_table table;
	struct trials_vehicle vehicle = car();
	struct mobility_curves curves;
	(void)state;
	straight(&curves, &vehicle);
	for (size_t i = 0; i < 4; i++)
		vehicle.wheels[i].torque_most = 0.35 * vehicle.mass * G / 4 * 0.55; /* enough for some slopes */
	trials_table_make(&vehicle, &curves, G, &table);
	double before = 91;
	int went = 0;
	for (double slope = 0; slope < 45; slope += 0.5) {
		const struct mobility_slope got = trials_table_at(&table, slope);
		const struct mobility_verdict up = trials_judge(&vehicle, &curves, G, slope, 0);
		assert_int_equal(got.up.reason, up.reason);
		assert_true(up.reason != MOBILITY_GO || fabs(got.up.slip - up.slip) < 1e-9);
		/* Steeper ground allows no steeper heading. Straight up is 90 degrees. */
		const double steepest = isnan(got.steepest) ? -1 : got.steepest;
		assert_true(steepest <= before && (up.reason != MOBILITY_GO || steepest == 90));
		before = steepest;
		went += up.reason == MOBILITY_GO;
	}
	assert_true(before == -1 && went > 10);
	assert_int_equal(trials_table_at(&table, NAN).up.reason, MOBILITY_NO_GROUND);
	assert_int_equal(trials_table_at(&table, 80).up.reason, MOBILITY_TOO_STEEP);
}

static void soils_vary_by_their_factors(void **state)
{
	const char *key;
	double value, wanted;
	struct scene *plain, *varied;
	(void)state;
	must(scene_soil_alone("dry_sand", &plain));
	char *text = scene_soil_varied("dry_sand", (double[]){0.5, 1.2, 0.8});
	assert_non_null(text);
	must(scene_soil_alone(text, &varied));
	for (size_t i = 0; scene_soil_number(&plain->soils[0], i, &key, &wanted); i++) {
		assert_true(scene_soil_number(&varied->soils[0], i, &key, &value));
		if (strcmp(key, "cohesion") == 0)
			wanted *= 0.5;
		else if (strcmp(key, "friction_angle") == 0)
			wanted = atan(1.2 * tan(wanted * RADIANS)) / RADIANS;
		else if (strncmp(key, "bekker_k", 8) == 0)
			wanted *= 0.8;
		if (!deform_model_reads(plain->model, key)) /* it is left out */
			wanted = NAN;
		assert_true(isnan(value) ? isnan(wanted) : fabs(value - wanted) <= 1e-9 * fabs(wanted));
	}
	mem_free(text);
	scene_destroy(plain);
	scene_destroy(varied);
	assert_null(scene_soil_varied("moondust", (double[]){1, 1, 1}));
}

TEST_PROGRAM(judge)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(slip_is_that_of_the_slope),
		cmocka_unit_test(free_wheels_do_not_pull),
		cmocka_unit_test(it_tips_where_its_weight_leaves_the_wheels),
		cmocka_unit_test(across_a_slope_it_points_up_it),
		cmocka_unit_test(loads_move_down_the_slope),
		cmocka_unit_test(brakes_hold_it_down_to_a_slope),
		cmocka_unit_test(wheels_behind_each_other_share_a_track),
		cmocka_unit_test(each_limit_is_told),
		cmocka_unit_test(the_table_is_the_judge),
		cmocka_unit_test(soils_vary_by_their_factors),
	};
	return cmocka_run_group_tests_name("trials/judge", tests, NULL, NULL);
}
