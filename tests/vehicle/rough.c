/* What strangers do to vehicles: a drive off a cliff, a hammer that strikes a thousand times a second, soil pushed up to a parked car, steps that are far too long, a car of 6 cm. */
#include <math.h>

#include "../support/near.h"
#include "../support/program.h"
#include "drive.h"

#define COUNT(array) (sizeof(array) / sizeof(array)[0])
#define GRAVITY 9.80665
#define CAR_MASS 1910.0 /* kg: of tools/scenes/vehicles/offroad.xml */
#define CLIFF 30.0      /* m: x of its edge; after that the ground is 8 m lower */
#define HAMMER_RATE 1000.0 /* 1/s */

static bool has_cliff;
static const struct extent extent = {257, 257, 0.25, 128};

static double ground(int64_t x, int64_t y)
{
	(void)y;
	return has_cliff && 0.25 * (double)x > CLIFF ? 92 : 100;
}

static void write_car(void)
{
	char path[512];
	snprintf(path, sizeof path, "%s/vehicles/offroad.xml", getenv("SCENES"));
	char *model = support_text(path);
	support_write(support_path("car.xml"), model);
	free(model);
}

/* Drives a scene of such lines. What the soil lost and gained cancels to the unit. */
static size_t driven(const char *keys, struct drive_row *rows, size_t most)
{
	const char *store = support_path("world.furrow"), *scene = support_path("scene.yaml");
	char text[2048], *json;
	support_store(store, extent, ground);
	snprintf(text, sizeof text, "scene: 1\nredistribute: {model: scm}\n%s\n", keys);
	support_write(scene, text);
	must(make_drive(scene, store, NULL, &(struct drive_cut){.out = support_path("out")}, &json));
	const int64_t removed = (int64_t)support_figure(json, "\"quanta\"", "removed"), raised = (int64_t)support_figure(json, "\"quanta\"", "raised");
	assert_true(removed == raised + (int64_t)support_figure(json, "\"quanta\"", "compacted"));
	mem_free(json);
	return drive_rows(support_path("out/vehicles.csv"), "v", rows, most);
}

/* It turns over and over, and lies or drives on. It has never more energy than it had, with what its motors did, and never sinks into the ground whole. */
static void a_car_drives_off_a_cliff(void **state)
{
	static struct drive_row rows[2600];
	(void)state;
	has_cliff = true;
	write_car();
	for (double speed = 3; speed <= 7; speed += 4) {
		char keys[512];
		snprintf(keys, sizeof keys, "soil: {name: sandy_loam_15}\nend_time: 4\ntime_step: 0.002\nspacing: 0.125\nvehicles:\n  - {name: v, model: car.xml, start: {at: [24, 32], speed: %g}, driver: "
					    "{path: {points: [[24, 32], [60, 32]], speed: %g}, steer: [steer_*], drive: [drive_*]}}\noutput: {vehicles: 500}", speed, speed);
		const size_t count = driven(keys, rows, COUNT(rows));
		double rise = 0;
		assert_int_equal(count, 2001);
		for (size_t i = 0; i < count; i++) {
			rise = fmax(rise, rows[i].kinetic - rows[0].kinetic + CAR_MASS * GRAVITY * (rows[i].z - rows[0].z) - rows[i].work);
			assert_true(rows[i].z > 92);
		}
		print_message("off a cliff of 8 m at %g m/s: ends at %.2f m, z %.2f m, roll %.0f degrees; at most %.1f J more than it had, of %.0f\n", speed, rows[count - 1].x, rows[count - 1].z,
			      rows[count - 1].roll, rise, 8 * CAR_MASS * GRAVITY);
		assert_true(rows[count - 1].x > CLIFF && rows[count - 1].z < 94);
		assert_true(rise < 0.01 * 8 * CAR_MASS * GRAVITY);
	}
	has_cliff = false;
}

/* Where it is after 0.3 s, m. */
static double hammered(double step, size_t *count, struct drive_row *rows, size_t most)
{
	FILE *table = fopen(support_path("strikes.csv"), "w");
	assert_non_null(table);
	fputs("t,push\n", table);
	for (int i = 0; i < 300; i++) /* half of each millisecond with 3 kN */
		fprintf(table, "%.5f,-3000\n%.5f,-3000\n%.5f,0\n%.5f,0\n", i / HAMMER_RATE, (i + 0.45) / HAMMER_RATE, (i + 0.5) / HAMMER_RATE, (i + 0.95) / HAMMER_RATE);
	assert_int_equal(fclose(table), 0);
	support_write(support_path("hammer.xml"), "<mujoco><option integrator=\"implicitfast\"/><worldbody><body name=\"hammer\" pos=\"0 0 1\"><joint name=\"guide\" type=\"slide\" axis=\"0 0 1\"/>"
		"<geom name=\"foot\" type=\"cylinder\" size=\"0.1 0.1\" mass=\"20\"/></body></worldbody><actuator><motor name=\"push\" joint=\"guide\"/></actuator></mujoco>");
	char keys[512];
	snprintf(keys, sizeof keys, "soil: {name: dry_sand}\nend_time: 0.3\ntime_step: %g\nspacing: 0.03125\nvehicles:\n  - {name: v, model: hammer.xml, start: {at: [32, 32]}, "
				    "driver: {controls: strikes.csv}}\noutput: {vehicles: 1000}", step);
	*count = driven(keys, rows, most);
	return rows[*count - 1].z;
}

static void a_hammer_strikes_a_thousand_times_a_second(void **state)
{
	static struct drive_row rows[400];
	static const double steps[] = {2e-4, 1e-4, 5e-5};
	double at[COUNT(steps)];
	size_t count;
	(void)state;
	for (size_t i = 0; i < COUNT(steps); i++) {
		at[i] = hammered(steps[i], &count, rows, COUNT(rows));
		double rise = 0, deepest = rows[0].z;
		for (size_t r = 0; r < count; r++) {
			rise = fmax(rise, rows[r].kinetic + 20 * GRAVITY * (rows[r].z - rows[0].z) - rows[r].work);
			deepest = fmin(deepest, rows[r].z);
		}
		print_message("steps of %g s: %.4f mm deep, at most %.2e J more than it had, of %.1f\n", steps[i], 1e3 * (rows[0].z - at[i]), rise, rows[count - 1].work);
		assert_true(rise < 0.01 * rows[count - 1].work);
		assert_true(at[i] - deepest < 5e-4); /* it works on, and is not thrown out */
	}
	assert_true(rows[0].z - at[2] > 0.02);
	assert_true(fabs(at[1] - at[2]) < 0.02 * (rows[0].z - at[2]));
}

/* The heap comes up to its bumper, below its wheels' axles. */
static void soil_pushed_up_to_a_parked_car_leaves_it(void **state)
{
	static struct drive_row rows[2600];
	(void)state;
	write_car();
	const size_t count = driven("soil: {name: dry_sand}\nend_time: 4\ntime_step: 0.002\nspacing: 0.0625\nobjects:\n  - {name: blade, shape: {box: {size: [0.2, 3, 1]}}, sink: 0.25, "
				    "path: {points: [[26, 32], [29.5, 32]], speed: 1}}\nvehicles:\n  - {name: v, model: car.xml, start: {at: [32, 32]}}\noutput: {vehicles: 500}", rows, COUNT(rows));
	for (size_t i = 0; i < count; i++)
		assert_true(hypot(rows[i].x - rows[0].x, rows[i].y - rows[0].y) < 0.005 && fabs(rows[i].z - rows[0].z) < 0.005 && rows[i].kinetic < 1);
}

/* A step of an hour is refused with one that is stable, and none of a vehicle's is taken. */
static void an_hours_step_is_refused(void **state)
{
	const char *store = support_path("world.furrow"), *scene = support_path("scene.yaml");
	(void)state;
	write_car();
	support_store(store, extent, ground);
	support_write(scene, "scene: 1\nredistribute: {model: scm}\nsoil: {name: dry_sand}\nend_time: 3600\ntime_step: 3600\nspacing: 0.0625\nvehicles:\n  - {name: v, model: car.xml, start: {at: [32, 32]}}\n");
	assert_int_equal(make_drive(scene, store, NULL, &(struct drive_cut){.out = support_path("out")}, NULL), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "time_step: 3600 s is longer than"));
	assert_non_null(strstr(failure_message(), "give at most that"));
}

/* Posts of 2 and 1 mm under wheels of 6 mm radius: where it comes to does not hang on them. */
static void a_car_of_six_centimetres_drives(void **state)
{
	static struct drive_row rows[600];
	static const double spacings[] = {0x1p-9, 0x1p-10};
	double ways[COUNT(spacings)];
	char model[2048];
	size_t at = (size_t)snprintf(model, sizeof model, "<mujoco><option timestep=\"0.0005\" integrator=\"implicitfast\"/><worldbody><body name=\"car\" pos=\"0 0 .02\"><freejoint/>"
						   "<geom name=\"hull\" type=\"box\" size=\".03 .012 .006\" mass=\".02\"/>");
	(void)state;
	for (int i = 0; i < 4; i++)
		at += (size_t)snprintf(model + at, sizeof model - at, "<body pos=\"%g %g -.006\"><joint name=\"roll_%d\" axis=\"0 1 0\"/><geom name=\"wheel_%d\" type=\"cylinder\" size=\".006 .0035\" "
						    "euler=\"90 0 0\" mass=\".001\"/></body>", i & 1 ? 0.02 : -0.02, i & 2 ? 0.016 : -0.016, i, i);
	at += (size_t)snprintf(model + at, sizeof model - at, "</body></worldbody><actuator>");
	for (int i = 0; i < 4; i++)
		at += (size_t)snprintf(model + at, sizeof model - at, "<velocity name=\"drive_%d\" joint=\"roll_%d\" kv=\"1e-4\"/>", i, i);
	snprintf(model + at, sizeof model - at, "</actuator></mujoco>");
	support_write(support_path("small.xml"), model);
	for (size_t i = 0; i < COUNT(spacings); i++) {
		char keys[512];
		snprintf(keys, sizeof keys, "soil: {name: sandy_loam_15, damping: 0, janosi_shear: 0.0004}\nend_time: 0.5\ntime_step: 0.0005\nspacing: %g\nvehicles:\n  - {name: v, model: small.xml, start: {at: [32, 32]}, driver: "
					    "{path: {points: [[32, 32], [33, 32]], speed: 0.1}, drive: [drive_*]}}\noutput: {vehicles: 100}", spacings[i]);
		const size_t count = driven(keys, rows, COUNT(rows));
		ways[i] = rows[count - 1].x - rows[0].x;
		print_message("posts of %g mm: it has come %.3f mm, its middle is %.3f mm high\n", 1e3 * spacings[i], 1e3 * ways[i], 1e3 * (rows[count - 1].z - 100));
		assert_true(rows[count - 1].z > 100.005 && rows[count - 1].z < 100.02);
	}
	assert_true(ways[1] > 0.01 && fabs(ways[0] - ways[1]) < 0.02 * ways[1]);
}

TEST_PROGRAM(rough)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_car_drives_off_a_cliff),
		cmocka_unit_test(a_hammer_strikes_a_thousand_times_a_second),
		cmocka_unit_test(soil_pushed_up_to_a_parked_car_leaves_it),
		cmocka_unit_test(an_hours_step_is_refused),
		cmocka_unit_test(a_car_of_six_centimetres_drives),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
