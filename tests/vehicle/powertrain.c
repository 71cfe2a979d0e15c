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

static void damp(double fl, double fr, double rl, double rr)
{
	const double all[4] = {fl, fr, rl, rr};
	memcpy(damping, all, sizeof damping);
	write_model(0.3, 1000, "");
	memset(damping, 0, sizeof damping);
}

/* What the parts have taken: the engine's work is its own kinetic energy, the wheels' work and losses. `idle`: J of its kinetic energy at the start. */
static void assert_work(struct furrow_world *world)
{
	const struct powertrain *train = train_of(world);
	const double idle = train->scene->inertia * pow(train->scene->idle * RPM, 2) / 2, kinetic = train->scene->inertia * train->speed * train->speed / 2;
	const double wheels = vehicle_of(world)->work;
	print_message("engine %.6g J: %.6g in its own turn, %.6g at the wheels, %.6g lost, %.6g in brakes\n", train->engine_work, kinetic - idle, wheels, train->loss, train->brake_work);
	assert_near(train->engine_work, kinetic - idle + wheels + train->loss, 1e-6 * (fabs(train->engine_work) + 1));
	assert_true(train->loss >= -1e-6 && train->brake_work >= -1e-6);
}

#define DRIVES "gears: [4], final: 3, shift_time: 0, "

/* Steady turns against dampers: the engine runs at its limit, where its torque is what the wheels take. */
static void differentials_share_the_torque(void **state)
{
	(void)state;
	slope = 0;
	damp(20, 1, 8, 8);
	/* open: each wheel has the same torque, so that on both sides which the free one takes */
	struct furrow_world *world = open_train("powertrain: {wheels: [turn_*], " FLAT DRIVES "drag: 1}", STEP, 0, "dry_sand");
	control(world, 1, 0, 1);
	go(world, 10);
	for (size_t i = 0; i < 4; i++) {
		static const double dampers[] = {20, 1, 8, 8};
		assert_near(pulls(world, i), pulls(world, 1), 1e-9 * pulls(world, 1));
		assert_near(pulls(world, i), dampers[i] * turns(world, i), 2e-3 * pulls(world, 1));
	}
	assert_near(12 * (turns(world, 0) + turns(world, 1) + turns(world, 2) + turns(world, 3)) / 4, train_of(world)->speed, 1e-6 * train_of(world)->speed);
	assert_work(world);
	done(furrow_world_close(world));
	/* locked: all turn alike, and each gets what it takes */
	world = open_train("powertrain: {wheels: [turn_*], " FLAT DRIVES "differentials: {centre: locked, front: locked, rear: locked}}", STEP, 0, "dry_sand");
	control(world, 1, 0, 1);
	go(world, 10);
	for (size_t i = 0; i < 4; i++)
		assert_near(turns(world, i), turns(world, 0), 1e-6 * turns(world, 0));
	assert_near(pulls(world, 0) / pulls(world, 1), 20, 0.01);
	assert_work(world);
	done(furrow_world_close(world));
	/* limited: the torques of the front wheels are in the ratio of its bias */
	world = open_train("powertrain: {wheels: [turn_*], " FLAT DRIVES "differentials: {front: limited, bias: 3}}", STEP, 0, "dry_sand");
	control(world, 1, 0, 1);
	go(world, 10);
	print_message("bias: %.5f and %.5f N m, %.4f and %.4f rad/s\n", pulls(world, 0), pulls(world, 1), turns(world, 0), turns(world, 1));
	assert_near(pulls(world, 0) / pulls(world, 1), 3, 1e-3);
	assert_near(pulls(world, 0) + pulls(world, 1), pulls(world, 2) + pulls(world, 3), 1e-6 * pulls(world, 0));
	assert_true(turns(world, 1) > 1.1 * turns(world, 0));
	assert_work(world);
	done(furrow_world_close(world));
	/* a lock's own torque: the difference is twice of it */
	world = open_train("powertrain: {wheels: [turn_*], " FLAT DRIVES "differentials: {front: limited, bias: 1, lock: 30}}", STEP, 0, "dry_sand");
	control(world, 1, 0, 1);
	go(world, 10);
	assert_near(pulls(world, 0) - pulls(world, 1), 60, 1e-3);
	done(furrow_world_close(world));
}

/* A map that falls with speed meets dampers: both are lines. */
static void top_speed_is_where_both_torques_meet(void **state)
{
	(void)state;
	slope = 0;
	damp(2, 2, 2, 2);
	struct furrow_world *world = open_train("powertrain: {wheels: [turn_*], engine: [[500, 220], [6000, 0]], inertia: 0.3, gears: [10], shift_time: 0}", STEP, 0, "dry_sand");
	control(world, 1, 0, 1);
	go(world, 10);
	/* 220 (6000 - n) / 5500 10 = 8 w, n = 10 w / RPM */
	const double fall = 220.0 / 5500 * 10, should = fall * 6000 / (8 + fall * 10 / RPM);
	print_message("%.5f rad/s, closed form %.5f\n", turns(world, 0), should);
	assert_near(turns(world, 0), should, 1e-4 * should);
	/* Half of the throttle: half of the torque, without drag. */
	control(world, 0.5, 0, 1);
	go(world, 10);
	const double half = fall / 2 * 6000 / (8 + fall / 2 * 10 / RPM);
	assert_near(turns(world, 0), half, 1e-4 * half);
	assert_work(world);
	done(furrow_world_close(world));
}

/* With closed throttle the engine's drag slows the wheels by drag i / (4 I_w + i2 I_e), until it idles. */
static void the_engine_brakes_and_idles(void **state)
{
	(void)state;
	slope = 0;
	damp(0, 0, 0, 0);
	struct furrow_world *world = open_train("powertrain: {wheels: [turn_*], " FLAT "gears: [10], drag: 40, shift_time: 0}", STEP, 0, "dry_sand");
	go(world, 1);
	assert_near(train_of(world)->speed / RPM, 500, 0.01);
	control(world, 1, 0, 1);
	go(world, 1.5);
	control(world, 0, 0, 1);
	go(world, 0.02);
	const double from = turns(world, 0);
	go(world, 0.2);
	const double is = (turns(world, 0) - from) / 0.2, should = -40 * 10 / (4 * WHEEL_INERTIA + 100 * ENGINE);
	print_message("engine brakes by %.4f rad/s2, closed form %.4f\n", is, should);
	assert_near(is, should, 1e-4 * -should);
	go(world, 10);
	assert_near(train_of(world)->speed / RPM, 500, 0.5);
	assert_work(world);
	/* Neutral and full throttle: it stays at its limit. */
	control(world, 1, 0, 0);
	go(world, 3);
	assert_true(train_of(world)->speed / RPM > 6000 && train_of(world)->speed / RPM < 6120);
	assert_int_equal((int)train_of(world)->gear, 0);
	/* Reverse: the wheels turn backward. */
	control(world, 0.3, 0, -1);
	go(world, 3);
	assert_true(turns(world, 0) < -5);
	assert_near(turns(world, 0) * -10, train_of(world)->speed, 1e-6 * train_of(world)->speed);
	done(furrow_world_close(world));
}

/* Gears come in at the speeds that the scene gives, up and down. */
static void it_shifts_at_its_speeds(void **state)
{
	(void)state;
	static const double ratios[] = {4, 2, 1};
	slope = 0;
	damp(0.1, 0.1, 0.1, 0.1);
	struct furrow_world *world = open_train("powertrain: {wheels: [turn_*], " FLAT "gears: [4, 2, 1], final: 3, shift: [1500, 3500], shift_time: 0.2}", STEP, 0, "dry_sand");
	int last = 1;
	double began = -1;
	for (int phase = 0; phase < 2; phase++) {
		control(world, 1 - phase, phase == 0 ? 0 : (double)NAN, 3);
		for (int i = 0; i < 40000 && (phase == 0 ? last < 3 || began >= 0 : last > 1 || began >= 0); i++) {
			const double rpm = 3 * ratios[last - 1] * turns(world, 0) / RPM;
			done(furrow_step(world, 0));
			const struct powertrain *train = train_of(world);
			if ((int)train->gear != last) {
				print_message("from gear %d to %d at %.1f rpm\n", last, (int)train->gear, rpm);
				assert_int_equal((int)train->gear, last + (phase == 0 ? 1 : -1));
				assert_true(phase == 0 ? rpm > 3500 && rpm < 3530 : rpm < 1500 && rpm > 1470);
				last = (int)train->gear;
				began = furrow_time(world);
			}
			if (began >= 0 && train->shifting == 0) {
				assert_near(furrow_time(world) - began, 0.2, 2 * STEP);
				began = -1;
			} else if (began >= 0) {
				assert_true(pulls(world, 0) == 0); /* the clutch is open */
			}
		}
		assert_int_equal(last, phase == 0 ? 3 : 1);
	}
	assert_work(world);
	done(furrow_world_close(world));
}

/* Brakes hold the wheels: the engine turns where its torque is C w2, and the wheels get that, times the ratios of the converter and the gear. */
static void a_converter_multiplies_at_stall(void **state)
{
	(void)state;
	slope = 0;
	damp(0, 0, 0, 0);
	struct furrow_world *world = open_train("powertrain: {wheels: [turn_*], " FLAT "gears: [10], shift_time: 0, converter: {capacity: 0.005, ratio: 2.2, coupling: 0.8}}, brakes: 5000", STEP, 0,
						"dry_sand");
	control(world, 1, 1, 1);
	go(world, 3);
	double sum = 0;
	for (size_t i = 0; i < 4; i++) {
		assert_near(turns(world, i), 0, 1e-9);
		sum += pulls(world, i);
		assert_near(train_of(world)->wheels[i].brake, -pulls(world, i), 1e-6 * pulls(world, i));
	}
	assert_near(train_of(world)->speed, sqrt(TORQUE / 0.005), 1e-4 * train_of(world)->speed);
	assert_near(sum, 10 * 2.2 * TORQUE, 1e-4 * sum);
	/* All is heat: what the engine gives, and the brakes take nothing. */
	const double work = train_of(world)->engine_work, loss = train_of(world)->loss;
	go(world, 1);
	assert_near(train_of(world)->loss - loss, train_of(world)->engine_work - work, 1e-6 * work);
	assert_near(train_of(world)->brake_work, 0, 1e-3);
	assert_work(world);
	done(furrow_world_close(world));
}

TEST_PROGRAM(powertrain)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(wheels_in_the_air_take_the_engine_s_torque),
		cmocka_unit_test(differentials_share_the_torque),
		cmocka_unit_test(top_speed_is_where_both_torques_meet),
		cmocka_unit_test(the_engine_brakes_and_idles),
		cmocka_unit_test(it_shifts_at_its_speeds),
		cmocka_unit_test(a_converter_multiplies_at_stall),
	};
	return cmocka_run_group_tests_name("the powertrain beside closed forms", tests, support_enter, support_leave);
}
