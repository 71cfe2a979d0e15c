/* A rover of six wheels with bars goes the same way under the plugin as in a scene, on level ground and on slopes, and at any step. */
#include <stdlib.h>

#include "../long.h"
#include "../support/near.h"
#include "engine.h"

#include "api/furrow.h"

#define WHEELS 6
#define ROLLS 0.086 /* m: radius over the tips of the bars */
#define SECONDS 4.0 /* it falls, rests, and drives from the first second on */

static const char *const wheels[WHEELS] = {"front_left", "middle_left", "rear_left", "front_right", "middle_right", "rear_right"};

struct case_of {
	const char *soil;
	double gravity, speed, slope; /* m/s2, m/s, degrees */
	const char *faces;
};

struct ride {
	double start[7];  /* its first pose */
	double way, sunk; /* m: over ground; mean of all wheels over the last two seconds */
};

static double slope; /* tangent */

static double ground(int64_t x, int64_t y)
{
	(void)y;
	return 100 + slope * 0.25 * (double)x;
}

static double wanted(const struct case_of *one, double time)
{
	return one->speed / ROLLS * fmin(fmax(time - 1, 0) / 0.5, 1); /* rad/s */
}

/* bars_rover.xml with another option, and what else it needs. The caller frees it. */
static char *rover(const char *option, const char *head, const char *plugin, const char *end)
{
	char path[512];
	snprintf(path, sizeof path, "%s/bars_rover.xml", getenv("MODELS"));
	char *text = support_text(path);
	char *at = strstr(text, "<option"), *world = strstr(text, "<worldbody>"), *joint = strstr(text, "<freejoint"), *last = strstr(text, "</mujoco>");
	assert_true(at != NULL && world != NULL && joint != NULL && last != NULL);
	const char *after = strchr(at, '>') + 1;
	const size_t room = strlen(text) + strlen(option) + strlen(head) + strlen(plugin) + strlen(end) + 64;
	char *all = malloc(room);
	assert_non_null(all);
	snprintf(all, room, "%.*s%s%.*s%s%.*s%s%.*s%s</mujoco>", (int)(at - text), text, option, (int)(world - after), after, head, (int)(joint - world), world, plugin,
		 (int)(last - joint), joint, end);
	free(text);
	return all;
}

static void scene_text(const struct case_of *one, char *text, size_t size)
{
	snprintf(text, size, "scene: 1, spacing: 0.015625, gravity: %g, soil: {name: %s}, redistribute: {model: scm, faces: %s}", one->gravity, one->soil, one->faces);
}

static struct ride ride_scene(const struct case_of *one, double step)
{
	char option[200], text[1400], ground_keys[400];
	struct furrow_world *world = NULL;
	struct furrow_vehicle_state is = {.size = sizeof is};
	struct furrow_contact contact;
	furrow_body bodies[WHEELS];
	struct ride ride = {.sunk = 0};
	const long count = lround(SECONDS / step);
	snprintf(option, sizeof option, "<option timestep=\"%g\" integrator=\"implicit\"/>", step);
	char *model = rover(option, "", "", "");
	support_write(support_path("rover.xml"), model);
	free(model);
	scene_text(one, ground_keys, sizeof ground_keys);
	snprintf(text, sizeof text, "{%s, time_step: %g, vehicles: [{name: v, model: %s, soil: [wheel_*], start: {at: [10.0037, 10.5052], height: 0.005, pitch: %g}}]}", ground_keys, step,
		 support_path("rover.xml"), one->slope);
	const struct furrow_open open = {.size = sizeof open, .scene = text, .store = support_path("slope.furrow"), .overlay = support_path("scene.furrow")};
	if (furrow_world_open(&open, &world) != FURROW_OK)
		print_error("%s\n", furrow_last_error());
	assert_non_null(world);
	for (int w = 0; w < WHEELS; w++) {
		char name[64];
		snprintf(name, sizeof name, "v.wheel_%s", wheels[w]);
		assert_int_equal(furrow_body_find(world, name, &bodies[w]), FURROW_OK);
	}
	assert_int_equal(furrow_vehicle_get(world, 0, &is), FURROW_OK);
	memcpy(ride.start, is.state.pose.position, 3 * sizeof(double));
	memcpy(ride.start + 3, is.state.pose.orientation, 4 * sizeof(double));
	for (long i = 0; i < count; i++) {
		double controls[WHEELS];
		for (int w = 0; w < WHEELS; w++)
			controls[w] = wanted(one, (double)i * step);
		assert_int_equal(furrow_set_controls(world, 0, WHEELS, controls), FURROW_OK);
		assert_int_equal(furrow_step(world, 0), FURROW_OK);
		for (int w = 0; w < WHEELS && i >= count / 2; w++) {
			assert_int_equal(furrow_get_contacts(world, 1, &bodies[w], &contact, sizeof contact), FURROW_OK);
			ride.sunk += contact.sinkage / (WHEELS * (double)(count - count / 2));
		}
	}
	assert_int_equal(furrow_vehicle_get(world, 0, &is), FURROW_OK);
	ride.way = hypot(is.state.pose.position[0] - ride.start[0], is.state.pose.position[1] - ride.start[1]);
	assert_int_equal(furrow_world_close(world), FURROW_OK);
	return ride;
}

/* From a pose, in a terrain that MuJoCo has at the same place. */
static struct ride ride_plugin(const struct case_of *one, const char *integrator, double step, const double start[7])
{
	char option[200], head[1600], ground_keys[400], sensors[1200] = "<sensor>";
	struct ride ride = {.sunk = 0};
	const long count = lround(SECONDS / step);
	snprintf(option, sizeof option, "<option timestep=\"%g\" integrator=\"%s\" gravity=\"0 0 %g\"/>", step, integrator, -one->gravity);
	scene_text(one, ground_keys, sizeof ground_keys);
	snprintf(head, sizeof head,
		 "<extension><plugin plugin=\"furrow.soil\"><instance name=\"ground\"><config key=\"scene\" value=\"{%s}\"/><config key=\"store\" value=\"%s\"/>"
		 "<config key=\"geoms\" value=\"wheel_*\"/><config key=\"origin\" value=\"10 10 100\"/></instance></plugin></extension>", ground_keys, support_path("slope.furrow"));
	for (int w = 0; w < WHEELS; w++)
		snprintf(sensors + strlen(sensors), sizeof sensors - strlen(sensors), "<plugin plugin=\"furrow.soil\" instance=\"ground\" objtype=\"geom\" objname=\"wheel_%s\"/>", wheels[w]);
	strcat(sensors, "</sensor>");
	char *text = rover(option, head, "<plugin plugin=\"furrow.soil\" instance=\"ground\"/>", sensors);
	mjModel *model = engine_model(text);
	free(text);
	if (model == NULL)
		print_error("%s\n", engine_error);
	assert_non_null(model);
	mjData *data = engine.mj_makeData(model);
	memcpy(data->qpos, start, 7 * sizeof *start);
	data->qpos[0] -= 10;
	data->qpos[1] -= 10;
	data->qpos[2] -= 100;
	const double from[2] = {data->qpos[0], data->qpos[1]};
	for (long i = 0; i < count; i++) {
		for (int w = 0; w < WHEELS; w++)
			data->ctrl[w] = wanted(one, (double)i * step);
		engine.mj_step(model, data);
		for (int w = 0; w < WHEELS && i >= count / 2; w++)
			ride.sunk += data->sensordata[5 * w + 1] / (WHEELS * (double)(count - count / 2));
	}
	ride.way = hypot(data->qpos[0] - from[0], data->qpos[1] - from[1]);
	engine.mj_deleteData(data);
	engine.mj_deleteModel(model);
	return ride;
}

static void make_ground(double degrees)
{
	slope = tan(degrees * M_PI / 180);
	unlink(support_path("slope.furrow"));
	unlink(support_path("scene.furrow")); /* its ruts are not those of another ground */
	support_store(support_path("slope.furrow"), engine_extent, ground);
}

static void tell(const char *who, const struct case_of *one, double step, const struct ride *ride)
{
	print_message("%s, %s, %g m/s2, %g m/s, %g degrees, %g ms: %.5f m, sunk by %.3f mm\n", who, one->soil, one->gravity, one->speed, one->slope, 1e3 * step, ride->way, 1e3 * ride->sunk);
}

static void it_goes_the_way_of_a_scenes_vehicle(void **state)
{
	static const struct case_of cases[] = {
		{"dry_sand", 9.80665, 0.3, 0, "on"}, {"lunar", 1.62, 0.1, 6, "on"}, {"dry_sand", 3.71, 0.1, 4, "on"}, {"lunar", 1.62, 0.05, 0, "on"}, {"dry_sand", 9.80665, 0.1, 0, "on"},
		{"sandy_loam_15", 9.80665, 0.3, 2, "on"}, {"sandy_loam_15", 9.80665, 0.1, 0, "on"},
	};
	(void)state;
	for (size_t i = 0; i < (long_run() ? sizeof cases / sizeof cases[0] : 2); i++) {
		make_ground(cases[i].slope);
		const struct ride scene = ride_scene(&cases[i], 0.002), plugin = ride_plugin(&cases[i], "implicit", 0.002, scene.start);
		tell("scene", &cases[i], 0.002, &scene);
		tell("plugin", &cases[i], 0.002, &plugin);
		if (cases[i].slope == 0) /* it begins 5 mm above the ground with the tips of its bars, which are 20 cm below its origin */
			assert_near(scene.start[2], 100 + 0.005 + 0.2, 1e-6);
		assert_true(scene.way > 0.2 * cases[i].speed * 2.75);
		assert_true(fabs(plugin.way - scene.way) < 0.003 * scene.way);
		assert_true(fabs(plugin.sunk - scene.sunk) < 0.003 * scene.sunk);
	}
}

/* The servos are too stiff for Euler and RK4, with or without soil. */
static void it_goes_that_way_at_any_step(void **state)
{
	static const char *const integrators[] = {"implicitfast", "implicit"};
	static const double steps[] = {0.0005, 0.001, 0.002, 0.004};
	const struct case_of one = {"dry_sand", 9.80665, 0.3, 0, "on"};
	(void)state;
	make_ground(0);
	const double start[7] = {10.0037, 10.5052, 100.22, 1};
	const struct ride fine = ride_plugin(&one, "implicit", long_run() ? 0.00025 : 0.001, start);
	tell("implicit", &one, long_run() ? 0.00025 : 0.001, &fine);
	for (int i = long_run() ? 0 : 1; i < 2; i++)
		for (int k = long_run() ? 0 : 3; k < 4; k++) {
			const struct ride ride = ride_plugin(&one, integrators[i], steps[k], start);
			tell(integrators[i], &one, steps[k], &ride);
			assert_true(fabs(ride.way - fine.way) < 0.02 * fine.way);
			assert_true(fabs(ride.sunk - fine.sunk) < 0.02 * fine.sunk);
		}
}

TEST_PROGRAM(rovers)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(it_goes_the_way_of_a_scenes_vehicle), cmocka_unit_test(it_goes_that_way_at_any_step)};
	return cmocka_run_group_tests(tests, engine_enter, support_leave);
}
