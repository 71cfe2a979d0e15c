/* Electric drives beside the closed form of a motor: torque K (V - K w) / R. */
#include "train.h"
#include "../support/program.h"

#include "vehicle/drives.h"

#define K 0.5
#define R 0.2
#define V 24.0
#define GEAR 10.0
#define MOTORS "<actuator><dcmotor name=\"m\" joint=\"turn_fl\" motorconst=\"0.5\" resistance=\"0.2\" gear=\"10\"/>" \
	"<dcmotor name=\"slow\" joint=\"turn_fr\" motorconst=\"0.5\" resistance=\"0.2\" inductance=\"0.004\" gear=\"10\"/></actuator>"

static struct vehicle_drive drive_of(struct furrow_world *world, size_t drive)
{
	struct vehicle_drive told;
	vehicle_drive(world->vehicles, 0, drive, &told);
	return told;
}

static void set(struct furrow_world *world, double m, double slow, double brake)
{
	done(furrow_set_controls(world, 0, 3, (const double[]){m, slow, brake}));
}

/* One wheel has a damper that takes half of the no-load speed, the other one turns freely. */
static void a_motor_has_its_closed_form(void **state)
{
	(void)state;
	slope = 0;
	damping[0] = GEAR * GEAR * K * K / R;
	write_model(0.3, 1000, MOTORS);
	memset(damping, 0, sizeof damping);
	struct furrow_world *world = open_train("brakes: 5000", STEP, 0, "dry_sand");
	/* Stalled: all of the power is heat. */
	set(world, V, V, 1);
	go(world, 0.5);
	const struct vehicle_drive stalled = drive_of(world, 0), slow = drive_of(world, 1);
	assert_near(stalled.torque, K * V / R, 1e-9);
	assert_near(stalled.current, V / R, 1e-9);
	assert_near(stalled.voltage, V, 1e-9);
	assert_near(stalled.taken, V * V / R * 0.5, 1e-6);
	assert_near(stalled.heat, stalled.taken, 1e-6);
	assert_near(slow.current, V / R, 1e-6);
	/* The current of the one with an inductance grows by 1 - exp(-t R / L): its heat is less by 2 L / R - L / 2R of full power. */
	assert_near(stalled.taken - slow.taken, V * V / R * 1.5 * 0.02, 0.06 * V * V / R * 1.5 * 0.02);
	/* No load, and half of that speed: a quarter of stall torque times no-load speed. */
	set(world, V, V, 0);
	go(world, 6);
	const struct vehicle_drive half = drive_of(world, 0), fast = drive_of(world, 1);
	assert_near(turns(world, 1), V / K / GEAR, 0.0001 * V / K / GEAR);
	assert_near(fast.current, 0, 0.01);
	assert_near(turns(world, 0), V / K / GEAR / 2, 1e-6);
	assert_near(half.torque * half.speed, K * V / R * V / K / 4, 0.001 * half.torque * half.speed);
	assert_near(half.voltage, V, 1e-6);
	go(world, 1);
	assert_near(drive_of(world, 0).taken - half.taken, V * half.current, 0.0001 * V * half.current);
	assert_near(drive_of(world, 0).mechanical - half.mechanical, half.torque * half.speed, 0.0001 * half.torque * half.speed);
	/* Half of the voltage: the wheel slows down to half of its speed, and drives the motor. The charge that comes back is J w / 2 / (K gear), and its energy that times the voltage. */
	const struct vehicle_drive before = drive_of(world, 1);
	const double slower = turns(world, 1) / 2, should = WHEEL_INERTIA * slower / (K * GEAR) * V / 2;
	set(world, 0, V / 2, 0);
	go(world, 3);
	const struct vehicle_drive back = drive_of(world, 1);
	const double net = back.recovered - before.recovered - (back.taken - before.taken);
	print_message("%.3f J came back, closed form %.3f J; heat %.3f J\n", net, should, back.heat - before.heat);
	assert_near(net, should, 0.03 * should);
	assert_true(back.recovered > before.recovered + should);
	assert_near(drive_of(world, 0).current, 0, 1e-6);
	assert_near(back.mechanical + drive_of(world, 0).mechanical, vehicle_of(world)->work, 1e-9 * vehicle_of(world)->work);
	assert_true(back.heat > 0);
	done(furrow_world_close(world));
}

TEST_PROGRAM(electric)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_motor_has_its_closed_form),
	};
	return cmocka_run_group_tests_name("electric drives beside closed forms", tests, support_enter, support_leave);
}
