/*
 * Brakes that hold. A braked vehicle stands on a slope, and does not creep: beside a vehicle whose wheels have no hinges, so that what the soil itself yields is told apart. A brake
 * that is too weak slips at the slope where its torque is that of the weight.
 */
#include "train.h"
#include "../long.h"
#include "../support/program.h"

#define MASS (1000 + 4 * WHEEL_MASS)
#define G 9.81

/* m/s down the slope, mean over the last `seconds`. */
static double creeps(struct furrow_world *world, double settles, double seconds)
{
	double from[3];
	go(world, settles);
	mju_copy3(from, vehicle_of(world)->data->xpos + 3 * vehicle_of(world)->root);
	go(world, seconds);
	const double *to = vehicle_of(world)->data->xpos + 3 * vehicle_of(world)->root;
	return mju_dist3(from, to) / seconds;
}

static void brakes_hold_without_creep(void **state)
{
	(void)state;
	static const char *const soils[] = {"dry_sand", "clayey_38"};
	static const double headings[] = {180, 0, 150};
	slope = tan(20 * M_PI / 180);
	write_model(0, 1000, "");
	for (int s = 0; s < (long_run() ? 2 : 1); s++)
		for (int k = 0; k < (s == 0 && long_run() ? 3 : 1); k++) {
			struct furrow_world *world = open_train("brakes: 2500, driver: {hold: {brake: 1}}", STEP, headings[k], soils[s]);
			const double speed = creeps(world, long_run() ? 60 : 3, 2);
			double turned = 0;
			for (int i = 0; i < 4; i++)
				turned = support_most(turned, fabs(turns(world, (size_t)i)));
			print_message("%s, 20 degrees, heading %g: %.3g um/s; wheels turn by %.3g rad/s\n", soils[s], headings[k], 1e6 * speed, turned);
			assert_true(turned < 1e-6);
			assert_true(speed < (s == 0 ? 1e-7 : 2e-7)); /* clay yields for tens of seconds */
			done(furrow_world_close(world));
		}
}

/* The weight pulls each wheel by m g sin(a) r / 4. A wheel that rolls in this soil makes a way of its own, and comes to rest after a tenth of a metre. */
static void a_weak_brake_slips_at_its_torque(void **state)
{
	(void)state;
	write_model(0, 1000, "");
	const double angle = 15 * M_PI / 180, needs = MASS * G * sin(angle) * RADIUS / 4;
	slope = tan(angle);
	for (int holds = 0; holds < 2; holds++) {
		char keys[128];
		snprintf(keys, sizeof keys, "brakes: %g, driver: {hold: {brake: 1}}", needs * (holds ? 1.3 : 0.5));
		struct furrow_world *world = open_train(keys, STEP, 180, "clayey_38");
		const double speed = creeps(world, 2, 1), work = train_of(world)->brake_work;
		print_message("%.2f of the torque of the weight: %.4g m/s; the brakes took %.4g J\n", holds ? 1.3 : 0.5, speed, work);
		assert_true(holds ? speed < 2e-5 && work < 2 : work > 50);
		for (size_t i = 0; i < 4 && !holds; i++)
			assert_true(fabs(train_of(world)->wheels[i].brake) <= 0.5 * needs * (1 + 1e-9));
		done(furrow_world_close(world));
	}
}

/* In the air: a wheel turns by what the engine gives beyond its brake, and not at all below that. It comes to rest under a brake, and stays. */
static void a_brake_takes_its_torque_and_no_more(void **state)
{
	(void)state;
	slope = 0;
	write_model(0.3, 1000, "");
	struct furrow_world *world = open_train("powertrain: {wheels: [turn_*], engine: [[500, 200], [6000, 200]], inertia: 0.3, gears: [10], shift_time: 0}, brakes: 600", STEP, 0, "dry_sand");
	control(world, 1, 1, 1);
	go(world, 1);
	const double angle = vehicle_of(world)->data->qpos[0];
	go(world, 2);
	assert_true(fabs(vehicle_of(world)->data->qpos[0] - angle) < 1e-12); /* 2000 N m of at most 2400 */
	for (size_t i = 0; i < 4; i++) {
		assert_near(turns(world, i), 0, 1e-9);
		assert_near(train_of(world)->wheels[i].brake, -500, 1);
	}
	control(world, 1, 2.0 / 3, 1);
	go(world, 1);
	const double from = turns(world, 0);
	go(world, 0.2);
	const double is = (turns(world, 0) - from) / 0.2, should = (200 * 10 - 1600) / (4 * WHEEL_INERTIA + 100 * 0.3);
	print_message("%.4f rad/s2 against brakes, closed form %.4f\n", is, should);
	assert_near(is, should, 0.0001 * should);
	control(world, 0, 1, 0);
	go(world, 3);
	for (size_t i = 0; i < 4; i++)
		assert_true(fabs(turns(world, i)) < 1e-12);
	done(furrow_world_close(world));
}

TEST_PROGRAM(brakes)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_weak_brake_slips_at_its_torque),
		cmocka_unit_test(a_brake_takes_its_torque_and_no_more),
		cmocka_unit_test(brakes_hold_without_creep),
	};
	return cmocka_run_group_tests_name("brakes that hold", tests, support_enter, support_leave);
}
