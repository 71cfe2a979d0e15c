/* Where and how a vehicle begins: its pose, a fall, a speed, without settling; and what is refused before the drive. */
#include <math.h>

#include "drive.h"
#include "../support/near.h"
#include "../support/program.h"

static const struct extent extent = {65, 65, 0.25, 64};
static double slope; /* tangent */

#define BOX "<mujoco><option timestep=\"0.002\"/><worldbody><body name=\"block\" pos=\"0 0 0.15\"><freejoint/>" \
	    "<geom name=\"block\" type=\"box\" size=\"0.3 0.25 0.15\" mass=\"60\"/></body></worldbody></mujoco>"
/* A leg of two joints, which its servos hold, on a body that slides up and down. */
#define LEG "<mujoco><compiler angle=\"radian\"/><option timestep=\"0.002\" integrator=\"implicitfast\"/><worldbody><body name=\"hip\" pos=\"0 0 0.5\">" \
	    "<joint name=\"guide\" type=\"slide\" axis=\"0 0 1\"/><geom name=\"hip\" type=\"box\" size=\"0.1 0.1 0.1\" mass=\"5\" contype=\"0\" conaffinity=\"0\"/><body>" \
	    "<joint name=\"thigh\" axis=\"0 1 0\" range=\"-1.5 1.5\" limited=\"true\" damping=\"2\"/>" \
	    "<geom type=\"capsule\" fromto=\"0 0 0 0 0 -0.2\" size=\"0.02\" mass=\"1\" contype=\"0\" conaffinity=\"0\"/><body pos=\"0 0 -0.2\">" \
	    "<joint name=\"knee\" axis=\"0 1 0\" range=\"-2.5 0\" limited=\"true\" damping=\"2\"/>" \
	    "<geom type=\"capsule\" fromto=\"0 0 0 0 0 -0.2\" size=\"0.02\" mass=\"0.5\" contype=\"0\" conaffinity=\"0\"/>" \
	    "<geom name=\"foot\" type=\"sphere\" size=\"0.06\" pos=\"0 0 -0.2\" mass=\"0.2\"/></body></body></body></worldbody>" \
	    "<actuator><position name=\"thigh\" joint=\"thigh\" kp=\"800\" ctrlrange=\"-1.5 1.5\" ctrllimited=\"true\"/>" \
	    "<position name=\"knee\" joint=\"knee\" kp=\"800\" ctrlrange=\"-2.5 0\" ctrllimited=\"true\"/></actuator></mujoco>"
/* A wheel under a free carriage. */
#define WHEEL "<mujoco><option timestep=\"0.002\"/><worldbody><body name=\"carriage\" pos=\"0 0 0.5\"><freejoint/>" \
	      "<inertial pos=\"0 0 0\" mass=\"70\" diaginertia=\"5 5 5\"/><body name=\"wheel\"><joint name=\"turn\" axis=\"0 %d 0\"/>" \
	      "<geom name=\"wheel\" type=\"cylinder\" size=\"0.32 0.12\" euler=\"90 0 0\" mass=\"30\"/></body></body></worldbody></mujoco>"

static double ground(int64_t x, int64_t y)
{
	(void)y;
	return 100 + slope * 0.25 * (double)x;
}

/* `vehicles`: the entries of the scene's list. */
static enum status drive(const char *vehicles, const char *end, const struct drive_cut *cut)
{
	char text[2048];
	const char *store = support_path("world.furrow");
	snprintf(text, sizeof text, "scene: 1\nend_time: %s\ntime_step: 0.002\nspacing: 0.0625\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n"
				    "vehicles: [%s]\noutput: {forces: 500, vehicles: 500}\n", end, vehicles);
	support_write(support_path("scene.yaml"), text);
	if (!cut->resume)
		support_store(store, extent, ground);
	return make_drive(support_path("scene.yaml"), store, NULL, cut, NULL);
}

static size_t rows_of(const char *vehicles, const char *end, const char *name, struct drive_row *rows, size_t most)
{
	must(drive(vehicles, end, &(struct drive_cut){.out = support_path("out")}));
	return drive_rows(support_path("out/vehicles.csv"), name, rows, most);
}

static void it_falls_from_a_height_as_it_is_turned(void **state)
{
	struct drive_row rows[200];
	(void)state;
	slope = 0;
	support_write(support_path("box.xml"), BOX);
	const size_t count = rows_of("{name: v, model: box.xml, start: {at: [8, 8], yaw: 40, pitch: 20, roll: 10, height: 0.5}}", "0.2", "v", rows, 200);
	assert_int_equal(count, 101);
	assert_near(rows[0].yaw, 40, 1e-9);
	assert_near(rows[0].pitch, 20, 1e-9);
	assert_near(rows[0].roll, 10, 1e-9);
	assert_near(rows[0].x, 8, 1e-9);
	assert_near(rows[0].y, 8, 1e-9);
	/* The lowest corner is half a metre above the ground: half the box' sides, each by how much it looks down. */
	const double pitch = 20 * M_PI / 180, roll = 10 * M_PI / 180;
	const double low = 0.3 * sin(pitch) + 0.25 * cos(pitch) * sin(roll) + 0.15 * cos(pitch) * cos(roll);
	assert_near(rows[0].z - 100.5, low, 1e-6);
	assert_near(rows[0].kinetic, 0, 1e-12);
	assert_near(rows[count - 1].vz, -9.80665 * 0.2, 2e-3);
	assert_near(rows[count - 1].pitch, 20, 1e-9);
}

static void it_begins_as_placed_without_settling(void **state)
{
	struct drive_row rows[64];
	(void)state;
	slope = 0;
	support_write(support_path("box.xml"), BOX);
	rows_of("{name: v, model: box.xml, start: {at: [8, 8], settle: false}}", "0.1", "v", rows, 64);
	assert_near(rows[0].z, 100.15, 1e-6);
	assert_near(rows[0].kinetic, 0, 1e-12);
	assert_true(rows[50].z < rows[0].z - 1e-4); /* it sinks after that */
}

/* The last column of the last row: the angle of the wheel's hinge. */
static double last_number(const char *path)
{
	char *text = support_text(path);
	const double number = strtod(strrchr(text, ',') + 1, NULL);
	free(text);
	return number;
}

/* Kinetic energy of a carriage of 100 kg at 2 m/s with a wheel of 30 kg that rolls, whichever way its hinge looks. */
static void a_wheel_rolls_at_the_speed_of_the_start(void **state)
{
	const double turns = 2 / 0.32, inertia = 30 * 0.32 * 0.32 / 2;
	(void)state;
	slope = 0;
	for (int axis = -1; axis <= 1; axis += 2) {
		struct drive_row rows[64];
		char model[1024];
		snprintf(model, sizeof model, WHEEL, axis);
		support_write(support_path("wheel.xml"), model);
		rows_of("{name: v, model: wheel.xml, start: {at: [8, 8], yaw: 90, speed: 2, height: 0.1}}", "0.02", "v", rows, 64);
		assert_near(rows[0].vx, 0, 1e-9);
		assert_near(rows[0].vy, 2, 1e-9);
		assert_near(rows[0].kinetic, 100 * 4 / 2.0 + inertia * turns * turns / 2, 1e-6);
		assert_near(last_number(support_path("out/vehicles.csv")), axis * turns * 0.02, 1e-6);
	}
}

/* A model that looks along another axis of its own begins at the speed along that one. */
static void the_speed_of_the_start_is_forward(void **state)
{
	static const char *const forwards[] = {"+y", "-x", "-y"};
	(void)state;
	slope = 0;
	support_write(support_path("box.xml"), BOX);
	for (int i = 0; i < 3; i++) {
		struct drive_row rows[64];
		char vehicle[256];
		snprintf(vehicle, sizeof vehicle, "{name: v, model: box.xml, forward: %s, start: {at: [8, 8], speed: 2, height: 0.1}}", forwards[i]);
		rows_of(vehicle, "0.02", "v", rows, 64);
		assert_near(rows[0].vx, 2, 1e-9);
		assert_near(rows[0].vy, 0, 1e-9);
	}
}

/* Where the wheel touches, its slip is 0 from the first row on. */
static void a_wheel_that_settled_begins_without_slip(void **state)
{
	char model[1024];
	(void)state;
	slope = 0;
	snprintf(model, sizeof model, WHEEL, 1);
	support_write(support_path("wheel.xml"), model);
	struct drive_row rows[64];
	const size_t count = rows_of("{name: v, model: wheel.xml, start: {at: [8, 8], speed: 1}}", "0.02", "v", rows, 64);
	assert_near(rows[0].vx, 1, 2e-3);
	assert_true(count == 11 && rows[count - 1].vx > 0.9 && rows[count - 1].x > 8.015);
}

/* Joints of `start` are the pose, and servos hold them while it settles and after that. */
static void servos_hold_the_joints_of_the_start(void **state)
{
	struct drive_row rows[64];
	(void)state;
	slope = 0;
	support_write(support_path("leg.xml"), LEG);
	rows_of("{name: v, model: leg.xml, start: {at: [8, 8], joints: {thigh: 0.7, knee: -1.4}}}", "0.1", "v", rows, 64);
	const double high = 0.4 * cos(0.7) + 0.06, was = rows[0].z;
	print_message("hip at %.4f m, %.4f m without sinkage\n", rows[0].z - 100, high);
	assert_true(rows[0].z - 100 < high && rows[0].z - 100 > high - 0.06);
	assert_near(rows[50].z, rows[0].z, 1e-3);
	rows_of("{name: v, model: leg.xml, start: {at: [8, 8], joints: {thigh: 0.7, knee: -1.4}, controls: {thigh: 0.2, knee: -0.4}}}", "0.1", "v", rows, 64);
	print_message("hip at %.4f m with straighter controls\n", rows[0].z - 100);
	assert_true(rows[0].z > was + 0.03); /* controls move the leg while it settles */
}

static void one_that_falls_waits_until_the_others_rest(void **state)
{
	struct drive_row rows[64];
	(void)state;
	slope = 0;
	support_write(support_path("box.xml"), BOX);
	rows_of("{name: a, model: box.xml, start: {at: [8, 8]}}, {name: b, model: box.xml, start: {at: [10, 8], height: 0.3, speed: 1}}", "0.1", "b", rows, 64);
	assert_near(rows[0].z, 100.45, 1e-6);
	assert_near(rows[0].vz, 0, 1e-9);
	assert_near(rows[0].vx, 1, 1e-9);
	assert_near(rows[50].vz, -0.980665, 2e-3);
	drive_rows(support_path("out/vehicles.csv"), "a", rows, 64);
	assert_true(rows[0].z < 100.15 - 1e-3 && rows[0].kinetic < 1e-6); /* this one has settled */
}

static void a_resumed_start_goes_on_to_the_same_bits(void **state)
{
	const char *vehicles = "{name: v, model: box.xml, start: {at: [8, 8], yaw: 30, pitch: 10, height: 0.02, speed: 1}}";
	(void)state;
	slope = 0.1;
	support_write(support_path("box.xml"), BOX);
	must(drive(vehicles, "0.2", &(struct drive_cut){.out = support_path("whole")}));
	must(drive(vehicles, "0.2", &(struct drive_cut){.out = support_path("cut"), .steps = 37}));
	must(drive(vehicles, "0.2", &(struct drive_cut){.out = support_path("cut"), .resume = true}));
	assert_same_rows(support_path("whole"), support_path("cut"), 1000);
}

static void refused(const char *vehicles, const char *says)
{
	enum status status = drive(vehicles, "0.1", &(struct drive_cut){.out = support_path("out")});
	if (status != STATUS_INPUT || strstr(failure_message(), says) == NULL || strchr(failure_message(), '\n') != NULL)
		fail_msg("%d \"%s\" does not say \"%s\"", status, failure_message(), says);
}

static void what_slides_away_before_the_drive_is_refused(void **state)
{
	(void)state;
	slope = tan(30 * M_PI / 180);
	support_write(support_path("box.xml"), BOX);
	refused("{name: v, model: box.xml, start: {at: [8, 8]}}", "m away, more than half its length of 0.6 m");
	assert_non_null(strstr(failure_message(), "on this slope of 30 degrees"));
	must(drive("{name: v, model: box.xml, start: {at: [8, 8], settle: false}}", "0.01", &(struct drive_cut){.out = support_path("out")}));
}

#define BALL "<mujoco><option timestep=\"0.002\"/><worldbody><body name=\"ball\" pos=\"0 0 0.2\"><freejoint/><geom name=\"ball\" type=\"sphere\" size=\"0.2\" mass=\"30\"/></body></worldbody></mujoco>"
#define ROLLER(name, at) "<body pos=\"" at "\"><joint name=\"" name "\" axis=\"0 1 0\"/><geom type=\"cylinder\" size=\"0.2 0.08\" euler=\"90 0 0\" mass=\"5\"/></body>"
#define CART "<mujoco><option timestep=\"0.002\"/><worldbody><body name=\"cart\" pos=\"0 0 0.2\"><freejoint/><geom type=\"box\" size=\"0.5 0.3 0.08\" mass=\"60\"/>" \
	     ROLLER("fl", ".4 .4 0") ROLLER("fr", ".4 -.4 0") ROLLER("rl", "-.4 .4 0") ROLLER("rr", "-.4 -.4 0") "</body></worldbody>" \
	     "<keyframe><key name=\"turned\" qpos=\"0 0 0.2 1 0 0 0 0.5 0.5 0.5 0.5\"/></keyframe></mujoco>"

/* What each vehicle does on each slope: it rests where it was set down, or begins as it was told, or is refused with how far it went. */
static void starts_on_slopes(void **state)
{
	static const struct {
		const char *model, *start;
		double degrees, speed; /* speed: m/s at the start, along the slope or the level, within 1 %; 0: at rest, slower than 5 mm/s */
		const char *says;      /* NULL: it begins */
	} rows[] = {
		{"box.xml", "yaw: 30", 5, 0, NULL},
		{"box.xml", "yaw: 90", 15, 0, NULL},
		{"box.xml", "pitch: 0", 25, 0, "on this slope of 25 degrees, and it has no wheels or belts that brake"},
		{"box.xml", "settle: false, speed: -1.5", 30, 1.5, NULL},
		{"ball.xml", "yaw: 0", 0, 0, NULL},
		{"ball.xml", "settle: false, speed: 1", 10, 1, NULL},
		{"cart.xml", "yaw: 0", 10, 0, NULL},
		{"cart.xml", "yaw: 180", 20, 0, NULL},
		{"cart.xml", "yaw: 45, keyframe: turned", 15, 0, NULL},
		{"cart.xml", "yaw: 90, speed: 2", 10, 2, NULL},
		{"cart.xml", "yaw: 180, speed: 3, settle: false", 30, 3, NULL},
		{"cart.xml", "joints: {fl: 0.3, 'r*': -0.2}", 5, 0, NULL},
		{"cart.xml", "height: 0.3, pitch: -10, roll: 15", 20, 0, NULL},
	};
	(void)state;
	support_write(support_path("box.xml"), BOX);
	support_write(support_path("ball.xml"), BALL);
	support_write(support_path("cart.xml"), CART);
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		struct drive_row first[4];
		char vehicle[300];
		slope = tan(rows[i].degrees * M_PI / 180);
		snprintf(vehicle, sizeof vehicle, "{name: v, model: %s, start: {at: [8, 8], %s}}", rows[i].model, rows[i].start);
		if (rows[i].says != NULL) {
			refused(vehicle, rows[i].says);
			continue;
		}
		assert_true(rows_of(vehicle, "0.01", "v", first, 4) > 1);
		const double speed = hypot(hypot(first->vx, first->vy), first->vz), moved = hypot(first->x - 8, first->y - 8);
		print_message("%s {%s} on %g degrees: %.4g m/s, %.4g m away\n", rows[i].model, rows[i].start, rows[i].degrees, speed, moved);
		assert_true(rows[i].speed > 0 ? fabs(speed - rows[i].speed) < 0.01 * rows[i].speed : speed < 0.005);
		assert_true(moved < 0.25);
	}
}

static void wrong_starts_are_refused(void **state)
{
	(void)state;
	slope = 0;
	support_write(support_path("leg.xml"), LEG);
#define START "{name: v, model: leg.xml, start: {at: [8, 8], "
	/* The scene itself is refused by its table: tests/scene and tests/cli. */
	refused(START "joints: {ankle: 1}}}", "start.joints: ankle names no hinge or slide of the model; there are: guide, thigh, knee");
	refused(START "joints: {'*': 1}}}", "knee: 1 rad is outside its range of -2.5 to 0 rad");
	refused(START "joints: {thigh: -1.6}}}", "thigh: -1.6 rad is outside its range of -1.5 to 1.5 rad");
	refused(START "controls: {hip: 1}}}", "start.controls: hip names no actuator of the model; there are: thigh, knee");
	refused(START "controls: {knee: 1}}}", "knee: 1 is outside its range of -2.5 to 0");
	refused(START "speed: 1}}", "speed: the joints of its root body hip do not let it move forward");
#undef START
}

TEST_PROGRAM(start)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(it_falls_from_a_height_as_it_is_turned),
		cmocka_unit_test(it_begins_as_placed_without_settling),
		cmocka_unit_test(a_wheel_rolls_at_the_speed_of_the_start),
		cmocka_unit_test(the_speed_of_the_start_is_forward),
		cmocka_unit_test(a_wheel_that_settled_begins_without_slip),
		cmocka_unit_test(servos_hold_the_joints_of_the_start),
		cmocka_unit_test(one_that_falls_waits_until_the_others_rest),
		cmocka_unit_test(a_resumed_start_goes_on_to_the_same_bits),
		cmocka_unit_test(what_slides_away_before_the_drive_is_refused),
		cmocka_unit_test(starts_on_slopes),
		cmocka_unit_test(wrong_starts_are_refused),
	};
	return cmocka_run_group_tests_name("how vehicles begin", tests, support_enter, support_leave);
}
