/*
 * The powertrain beside closed forms: on a stand with wheels in the air, where only inertia resists, and with wheels that a brake or the ground holds.
 */
#include "train.h"
#include "../support/program.h"

#define TORQUE 200.0
#define ENGINE 0.3 /* kg m2 */
#define FLAT "engine: [[500, 200], [6000, 200]], inertia: 0.3, "

/* All four wheels in the air: T i / (4 I_w + i2 I_e) in each gear. */
static void wheels_in_the_air_take_the_engine_s_torque(void **state)
{
	(void)state;
	static const double ratios[] = {14, 7, 3.5};
	slope = 0;
	write_model(0.3, 1000, "");
	for (int step = 0; step < 2; step++) {
		struct furrow_world *world = open_train("powertrain: {wheels: [turn_*], " FLAT "gears: [4, 2, 1], final: 3.5, shift_time: 0}", step == 0 ? STEP : 0.005, 0, "dry_sand");
		for (int gear = 1; gear <= 3; gear++) {
			control(world, 0, 0, gear);
			go(world, 2);
			control(world, 1, 0, gear);
			go(world, 0.3);
			const double ratio = ratios[gear - 1], from = turns(world, 0), engine = train_of(world)->speed;
			go(world, 0.1);
			const double is = (turns(world, 0) - from) / 0.1, should = TORQUE * ratio / (4 * WHEEL_INERTIA + ratio * ratio * ENGINE);
			print_message("gear %d: %.4f rad/s2, closed form %.4f; engine %.1f to %.1f rad/s; torque %.2f\n", gear, is, should, engine, train_of(world)->speed, train_of(world)->torque);
			assert_near(is, should, 1e-4 * should);
			assert_near(train_of(world)->speed, ratio * turns(world, 0), 1e-6 * train_of(world)->speed);
			for (size_t i = 1; i < 4; i++)
				assert_near(turns(world, i), turns(world, 0), 1e-9);
		}
		done(furrow_world_close(world));
	}
}

TEST_PROGRAM(powertrain)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(wheels_in_the_air_take_the_engine_s_torque),
	};
	return cmocka_run_group_tests_name("the powertrain beside closed forms", tests, support_enter, support_leave);
}
