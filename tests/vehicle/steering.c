/*
 * What a path driver finds out of its actuators: which wheels or halves they turn, and how far for each curvature. Beside closed forms. What
 * has no effect is told with its name.
 */
#include <math.h>

#include "rig.h"
#include "vehicle/internal.h"
#include "../support/program.h"

#define KEYS "time_step: 0.002"

/* Loads a model of tests/vehicle. `driver`: what it has beside its path. */
static struct vehicle *load(const char *name, const char *driver, struct scene **scene, struct vehicles **vehicles)
{
	char path[512], more[512];
	snprintf(path, sizeof path, "%s/%s.xml", getenv("MODELS"), name);
	char *text = support_text(path);
	support_write(support_path("model.xml"), text);
	free(text);
	snprintf(more, sizeof more, ", soil: [wheel_*], driver: {path: {points: [[5, 5], [9, 5]], speed: 1}, %s}", driver);
	must(rig_load(KEYS, more, scene, vehicles));
	return &(*vehicles)->list[0];
}

static void let_go(struct scene *scene, struct vehicles *vehicles)
{
	vehicle_destroy(vehicles);
	scene_destroy(scene);
}

/* The table's length of the first steering actuator at a curvature that it has. */
static double length_at(const struct driver *driver, double curvature)
{
	const struct steering *steering = &driver->steering;
	size_t row = steering->first;
	while (row + 2 < steering->end && steering->curvatures[row + 1] <= curvature)
		row++;
	const double share = (curvature - steering->curvatures[row]) / (steering->curvatures[row + 1] - steering->curvatures[row]);
	assert_true(share > -1e-9 && share < 1 + 1e-9);
	const double low = steering->lengths[row * driver->steer_count], high = steering->lengths[(row + 1) * driver->steer_count];
	return low + share * (high - low);
}

static void wheels_of_their_own_need_no_table(void **state)
{
	static const struct {
		const char *name, *steer;
	} models[] = {{"steers_front", "[steer_*]"}, {"steers_rear", "[steer_*]"}, {"steers_skid", "[]"}};
	(void)state;
	for (size_t i = 0; i < sizeof models / sizeof *models; i++) {
		struct scene *scene;
		struct vehicles *vehicles;
		char driver[128];
		snprintf(driver, sizeof driver, "steer: %s, drive: [drive_*]", models[i].steer);
		const struct vehicle *vehicle = load(models[i].name, driver, &scene, &vehicles);
		assert_true(vehicle->driver.steering.plain);
		let_go(scene, vehicles);
	}
}

/* The front half's axle is l1 ahead of the hinge and the rear one l2 behind it: the front one goes on a circle of (l1 cos a + l2) / sin a. */
static void halves_bend_as_geometry_says(void **state)
{
	const double l1 = 0.8, l2 = 0.6;
	struct scene *scene;
	struct vehicles *vehicles;
	(void)state;
	const struct vehicle *vehicle = load("steers_articulated", "steer: [bend], drive: [drive_*]", &scene, &vehicles);
	const struct steering *steering = &vehicle->driver.steering;
	assert_true(!steering->plain && fabs(steering->middle - 0.2) < 2e-3 && fabs(steering->base - 1.4) < 1e-6);
	for (size_t row = steering->first; row < steering->end; row++) {
		const double bend = steering->lengths[row]; /* its hinge looks down: above 0 the rear half heads more to the right, as on a way to the left */
		const double curvature = sin(bend) / (l1 * cos(bend) + l2);
		if (fabs(bend) < 0.79) /* its hinge's limits */
			assert_true(fabs(curvature - steering->curvatures[row]) < 1e-4);
	}
	assert_true(steering->curvatures[steering->end - 1] > 0.3 && steering->curvatures[steering->first] < -0.3);
	let_go(scene, vehicles);
}

/* One servo for four wheels, those behind against those ahead: half the wheelbase over the radius, by the mean of left and right. */
static void four_follow_one_servo(void **state)
{
	struct scene *scene;
	struct vehicles *vehicles;
	(void)state;
	const struct vehicle *vehicle = load("steers_four", "steer: [steer_fl], drive: [drive_*]", &scene, &vehicles);
	const struct steering *steering = &vehicle->driver.steering;
	assert_true(!steering->plain && fabs(steering->middle) < 1e-6);
	assert_true(fabs(length_at(&vehicle->driver, 0.25) - atan(0.25 * 0.6)) < 4e-3);
	assert_true(fabs(length_at(&vehicle->driver, -0.25) + atan(0.25 * 0.6)) < 4e-3);
	let_go(scene, vehicles);
}

/* The rack goes to the right for a way to the left. Its wheels turn by 1 / 0.2 and 1 / 0.22 of its way. */
static void a_rack_turns_wheels_by_tendons(void **state)
{
	struct scene *scene;
	struct vehicles *vehicles;
	(void)state;
	const struct vehicle *vehicle = load("steers_rack", "steer: [rack], drive: [drive_*]", &scene, &vehicles);
	const struct steering *steering = &vehicle->driver.steering;
	assert_true(!steering->plain && fabs(steering->middle + 0.6) < 1e-3);
	const double small = 0.05, mean = (1 / 0.2 + 1 / 0.22) / 2;
	assert_true(fabs(length_at(&vehicle->driver, small) / (-small * 1.2 / mean) - 1) < 0.01);
	/* Its way to the side ends at 0.15 m: then no closer turn is asked for. */
	assert_true(steering->curvatures[steering->end - 1] < 0.75 && length_at(&vehicle->driver, steering->curvatures[steering->end - 1]) >= -0.15 - 1e-9);
	let_go(scene, vehicles);
}

/* --- what is told --- */

static char told[4096];

static void keep(const char *text)
{
	const size_t length = strlen(told);
	snprintf(told + length, sizeof told - length, "%s\n", text);
}

static void what_has_no_effect_is_told_once(void **state)
{
	/* A second servo, of a mast; and a motor of a fan. */
	static const char *mast[2] = {"  <actuator>\n", "  <actuator>\n    <position name=\"steer_mast\" joint=\"mast\" kp=\"10\"/><motor name=\"drive_fan\" joint=\"mast\"/>\n"};
	struct scene *scene;
	struct vehicles *vehicles;
	char path[512];
	(void)state;
	snprintf(path, sizeof path, "%s/steers_front.xml", getenv("MODELS"));
	char *text = support_text(path), *hull = strstr(text, "      <body name=\"hub_fl\"");
	char changed[8192];
	assert_non_null(hull);
	char *actuators = strstr(hull, mast[0]);
	snprintf(changed, sizeof changed, "%.*s<body name=\"top\"><joint name=\"mast\" axis=\"0 0 1\"/><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"0.01 0.01 0.01\"/></body>\n%.*s%s%s",
		 (int)(hull - text), text, (int)(actuators - hull), hull, mast[1], actuators + strlen(mast[0]));
	support_write(support_path("model.xml"), changed);
	free(text);
	told[0] = '\0';
	note_to(keep);
	must(rig_load(KEYS, ", soil: [wheel_*], driver: {path: {points: [[5, 5], [9, 5]], speed: 1}, steer: [steer_*], drive: [drive_*]}", &scene, &vehicles));
	note_to(NULL);
	char *steer = strstr(told, "driver.steer: steer_mast turns nothing that touches the ground"), *drive = strstr(told, "driver.drive: drive_fan turns no wheel");
	assert_true(steer != NULL && drive != NULL);
	assert_true(strstr(steer + 30, "steer_mast") == NULL && strstr(drive + 30, "drive_fan") == NULL);
	assert_true(strstr(told, "steer_fl") == NULL && strstr(told, "drive_rl") == NULL);
	assert_int_equal(vehicles->list[0].driver.drive_count, 4);
	let_go(scene, vehicles);
}

TEST_PROGRAM(steering)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(wheels_of_their_own_need_no_table),
		cmocka_unit_test(halves_bend_as_geometry_says),
		cmocka_unit_test(four_follow_one_servo),
		cmocka_unit_test(a_rack_turns_wheels_by_tendons),
		cmocka_unit_test(what_has_no_effect_is_told_once),
	};
	return cmocka_run_group_tests_name("how actuators steer", tests, support_enter, support_leave);
}
