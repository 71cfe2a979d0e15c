/* The plugin furrow.soil: bodies rest at their weight, wheels go the way that those of a scene's vehicle go, at any step of any integrator. */
#include <pthread.h>
#include <stdlib.h>

#include "../long.h"
#include "../support/near.h"
#include "engine.h"

#include "api/furrow.h"

static void a_ball_rests_at_its_weight(void **state)
{
	static const char *const options[] = {"integrator=\"Euler\" timestep=\"0.001\"", "integrator=\"implicitfast\" timestep=\"0.002\"",
					      "integrator=\"implicit\" timestep=\"0.004\"", "integrator=\"RK4\" timestep=\"0.001\"", "integrator=\"RK4\" timestep=\"0.004\""};
	char sensors[256];
	(void)state;
	engine_store();
	snprintf(sensors, sizeof sensors, ENGINE_SENSOR, "ball");
	for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
		mjModel *model = engine_ball(options[i], "", "", sensors);
		assert_non_null(model);
		mjData *data = engine.mj_makeData(model);
		data->qvel[0] = 0.3; /* it falls, rolls, digs in, and rests */
		data->qvel[2] = -1;
		engine_run(model, data, 3);
		const double *read = data->sensordata; /* slip, sinkage, force */
		print_message("%s: %.4f N, sunk by %.2f mm, %.2g m/s\n", options[i], read[4], 1e3 * read[1], fabs(data->qvel[2]));
		assert_int_equal(model->nsensordata, 5);
		assert_true(fabs(read[4] - 196.2) < 1e-4 * 196.2 && fabs(read[2]) < 2 && fabs(read[3]) < 2);
		assert_true(fabs(data->qvel[2]) < 1e-3 && fabs(data->qvel[0]) < 2e-3);
		assert_true(read[1] > 0.01 && read[1] < 0.06 && data->qpos[2] < 0.2 - 0.5 * read[1]);
		engine.mj_deleteData(data);
		engine.mj_deleteModel(model);
	}
}

/* one_wheel.xml in this program's way, 1 mm above the ground. */
static mjModel *cart(const char *integrator, double step)
{
	char path[512], xml[8192], option[128], sensors[256];
	snprintf(path, sizeof path, "%s/one_wheel.xml", getenv("MODELS"));
	char *text = support_text(path);
	char *from = strstr(text, "<option"), *world = strstr(text, "<worldbody>"), *end = strstr(text, "</mujoco>");
	char *body = strstr(world, "<body name=\"carriage\" pos=\"0 0 0.5\">");
	assert_true(from != NULL && world != NULL && body != NULL && end != NULL);
	snprintf(sensors, sizeof sensors, ENGINE_SENSOR, "wheel");
	snprintf(option, sizeof option, "<option timestep=\"%g\" integrator=\"%s\" gravity=\"0 0 -9.80665\"/>", step, integrator);
	snprintf(xml, sizeof xml, "%.*s%s%s<worldbody><body name=\"carriage\" pos=\"0 0 0.321\"><plugin plugin=\"furrow.soil\" instance=\"ground\"/>%.*s%s</mujoco>",
		 (int)(from - text), text, option, engine_extension("wheel", ""), (int)(end - body - (long)strlen("<body name=\"carriage\" pos=\"0 0 0.5\">")),
		 body + strlen("<body name=\"carriage\" pos=\"0 0 0.5\">"), sensors);
	free(text);
	return engine_accepted(xml);
}

struct ride {
	double way, sunk, turned;
};

static double wanted(double time)
{
	return 2 * fmin(fmax(time - 0.5, 0) / 0.5, 1); /* rad/s */
}

static struct ride ride_cart(const char *integrator, double step)
{
	mjModel *model = cart(integrator, step);
	mjData *data = engine.mj_makeData(model);
	const long count = lround(2 / step);
	for (long i = 0; i < count; i++) {
		data->ctrl[0] = wanted((double)i * step);
		engine.mj_step(model, data);
	}
	const struct ride ride = {data->qpos[0], data->sensordata[1], data->qpos[3]};
	print_message("%s, %g ms: %.5f m, sunk by %.3f mm\n", integrator, 1e3 * step, ride.way, 1e3 * ride.sunk);
	engine.mj_deleteData(data);
	engine.mj_deleteModel(model);
	return ride;
}

/* The same in a scene, where furrow steps MuJoCo. */
static struct ride ride_scene(void)
{
	char scene[1024];
	struct furrow_world *world = NULL;
	struct furrow_vehicle_state is = {.size = sizeof is};
	struct furrow_contact contact;
	furrow_body wheel;
	snprintf(scene, sizeof scene, "{scene: 1, time_step: 0.002, spacing: 0.0625, soil: {name: dry_sand}, redistribute: {model: scm}, vehicles: [{name: cart, model: %s/one_wheel.xml, "
				      "start: {at: [10, 10.5], height: 0.001}}]}", getenv("MODELS"));
	const struct furrow_open open = {.size = sizeof open, .scene = scene, .store = support_path("ground.furrow"), .overlay = support_path("scene.furrow")};
	assert_int_equal(furrow_world_open(&open, &world), FURROW_OK);
	assert_int_equal(furrow_body_find(world, "cart.wheel", &wheel), FURROW_OK);
	for (int i = 0; i < 1000; i++) {
		const double control = wanted(i * 0.002);
		assert_int_equal(furrow_set_controls(world, 0, 1, &control), FURROW_OK);
		assert_int_equal(furrow_step(world, 0), FURROW_OK);
	}
	assert_int_equal(furrow_vehicle_get(world, 0, &is), FURROW_OK);
	assert_int_equal(furrow_get_contacts(world, 1, &wheel, &contact, sizeof contact), FURROW_OK);
	const struct ride ride = {is.state.pose.position[0] - 10, contact.sinkage, 0};
	print_message("a scene: %.5f m, sunk by %.3f mm\n", ride.way, 1e3 * ride.sunk);
	assert_int_equal(furrow_world_close(world), FURROW_OK);
	return ride;
}

/* A light wheel whose servo is stiff for it: its inertia is 0.01 kg m2, and the servo has kv 10. Where kv acts at the step's end the wheel turns a third as fast as
 * its torque alone would turn it in a step. */
#define LIGHT "<mujoco>%s<worldbody><body pos=\"0 0 %g\">%s<joint name=\"x\" type=\"slide\" axis=\"1 0 0\"/><joint name=\"z\" type=\"slide\" axis=\"0 0 1\"/>" \
	      "<inertial pos=\"0 0 0\" mass=\"8\" diaginertia=\"1 1 1\"/><body><joint name=\"turn\" axis=\"0 1 0\"/><inertial pos=\"0 0 0\" mass=\"2\" diaginertia=\"0.01 0.01 0.01\"/>" \
	      "<geom name=\"wheel\" type=\"cylinder\" size=\"0.15 0.06\" euler=\"90 0 0\"/></body></body></worldbody>" \
	      "<actuator><velocity name=\"drive\" joint=\"turn\" kv=\"10\"/></actuator>%s</mujoco>"
#define LIGHT_OPTION "<option timestep=\"0.002\" integrator=\"implicit\" gravity=\"0 0 -9.80665\"/>"

#define STEPS 150

/* rad/s: it stands, and spins at once. */
static double jerked(int step)
{
	return step < 100 ? 0 : 12;
}

/* How far it went, m, and the force along the ground in each step, N. */
struct jerks {
	double way, force[STEPS];
};

static void jerk_light(struct jerks *jerks)
{
	char xml[8192], head[4096], sensors[256];
	snprintf(sensors, sizeof sensors, ENGINE_SENSOR, "wheel");
	snprintf(head, sizeof head, "%s%s", LIGHT_OPTION, engine_extension("wheel", ""));
	snprintf(xml, sizeof xml, LIGHT, head, 0.151, "<plugin plugin=\"furrow.soil\" instance=\"ground\"/>", sensors);
	mjModel *model = engine_accepted(xml);
	mjData *data = engine.mj_makeData(model);
	for (int i = 0; i < STEPS; i++) {
		data->ctrl[0] = jerked(i);
		engine.mj_step(model, data);
		jerks->force[i] = data->sensordata[2];
	}
	jerks->way = data->qpos[0];
	engine.mj_deleteData(data);
	engine.mj_deleteModel(model);
}

static void jerk_scene(struct jerks *jerks)
{
	char text[4096];
	struct furrow_world *world = NULL;
	struct furrow_vehicle_state is = {.size = sizeof is};
	struct furrow_contact contact;
	furrow_body wheel;
	snprintf(text, sizeof text, LIGHT, LIGHT_OPTION, 0.5, "", "");
	support_write(support_path("light.xml"), text);
	snprintf(text, sizeof text, "{scene: 1, time_step: 0.002, spacing: 0.0625, soil: {name: dry_sand}, redistribute: {model: scm}, vehicles: [{name: cart, model: %s, "
				    "start: {at: [10, 10.5], height: 0.001}}]}", support_path("light.xml"));
	const struct furrow_open open = {.size = sizeof open, .scene = text, .store = support_path("ground.furrow"), .overlay = support_path("light.furrow")};
	assert_int_equal(furrow_world_open(&open, &world), FURROW_OK);
	assert_int_equal(furrow_body_find(world, "cart.wheel", &wheel), FURROW_OK);
	for (int i = 0; i < STEPS; i++) {
		const double control = jerked(i);
		assert_int_equal(furrow_set_controls(world, 0, 1, &control), FURROW_OK);
		assert_int_equal(furrow_step(world, 0), FURROW_OK);
		assert_int_equal(furrow_get_contacts(world, 1, &wheel, &contact, sizeof contact), FURROW_OK);
		jerks->force[i] = contact.force[0];
	}
	assert_int_equal(furrow_vehicle_get(world, 0, &is), FURROW_OK);
	jerks->way = is.state.pose.position[0] - 10;
	assert_int_equal(furrow_world_close(world), FURROW_OK);
}

static void a_stiff_servo_is_foreseen(void **state)
{
	static struct jerks plugin, scene;
	double most = 0, differ = 0;
	(void)state;
	engine_store();
	jerk_light(&plugin);
	jerk_scene(&scene);
	for (int i = 0; i < STEPS; i++) {
		most = support_most(most, fabs(scene.force[i]));
		differ = support_most(differ, fabs(plugin.force[i] - scene.force[i]));
	}
	print_message("%.5f and %.5f m; up to %.4g N, which differ by up to %.4g N\n", plugin.way, scene.way, most, differ);
	assert_true(most > 50 && differ < 0.01 * most);
	assert_true(scene.way > 0.005 && fabs(plugin.way - scene.way) < 0.01 * scene.way);
}

static void a_wheel_goes_the_way_of_a_scenes_vehicle(void **state)
{
	(void)state;
	engine_store();
	const struct ride scene = ride_scene(), plugin = ride_cart("implicit", 0.002);
	assert_true(scene.way > 0.3);
	assert_true(fabs(plugin.way - scene.way) < 0.001 * scene.way);
	assert_true(fabs(plugin.sunk - scene.sunk) < 0.005 * scene.sunk);
}

static void a_wheel_goes_that_way_at_any_step(void **state)
{
	static const char *const integrators[] = {"Euler", "implicitfast", "RK4"};
	static const double steps[] = {0.0005, 0.001, 0.002, 0.004};
	const struct ride fine = ride_cart("implicit", 0.0005);
	(void)state;
	for (int i = 0; i < 3; i++)
		for (int k = long_run() ? 0 : 2; k < 4; k++) {
			const struct ride ride = ride_cart(integrators[i], steps[k]);
			assert_true(fabs(ride.way - fine.way) < 0.05 * fine.way);
			assert_true(fabs(ride.sunk - fine.sunk) < 0.05 * fine.sunk);
		}
}

/* Drop, rest, drive, brake, rest: what it has at the end is what it had less what the soil took; soil never adds. */
static void soil_gives_no_energy(void **state)
{
	mjModel *model = cart("implicit", 0.002);
	mjData *data = engine.mj_makeData(model);
	const double kv = 500;
	double put = 0, most = -INFINITY;
	(void)state;
	const double start = 100 * 9.80665 * data->qpos[2];
	for (int i = 0; i < 3000; i++) {
		const double time = i * 0.002, before = data->qvel[3];
		data->ctrl[0] = time < 1 || time > 4 ? 0 : 2 * fmin(time - 1, 1);
		engine.mj_step(model, data);
		const double after = data->qvel[3];
		put += kv * (data->ctrl[0] - after) * (before + after) / 2 * 0.002;
		const double has = 50 * (pow(data->qvel[0], 2) + pow(data->qvel[1], 2) + pow(data->qvel[2], 2)) + 100 * 9.80665 * data->qpos[2];
		most = fmax(most, has - start - fmax(put, 0));
	}
	print_message("%.3f J put in, never more than %.3g J above that; at rest %.2g m/s after %.3f m\n", put, most, fabs(data->qvel[0]), data->qpos[0]);
	assert_true(data->qpos[0] > 0.5 && fabs(data->qvel[0]) < 2e-3 && fabs(data->qvel[2]) < 5e-4);
	assert_true(most < 0.001 * put);
	engine.mj_deleteData(data);
	engine.mj_deleteModel(model);
}

/* MuJoCo's inertia is its own again once a step is made. */
static void a_step_leaves_the_inertia(void **state)
{
	mjModel *model = cart("implicit", 0.002);
	mjData *data = engine.mj_makeData(model);
	double mass[16];
	(void)state;
	engine_run(model, data, 0.4);
	engine.mj_fullM(model, data, mass);
	assert_true(fabs(mass[0] - 100) < 1e-9 && fabs(mass[10] - 100) < 1e-9);
	engine.mj_deleteData(data);
	engine.mj_deleteModel(model);
}

struct rollout {
	const mjModel *model;
	double end[2];
	double push;
};

static void *roll_out(void *argument)
{
	struct rollout *rollout = argument;
	mjData *data = engine.mj_makeData(rollout->model);
	data->qvel[0] = rollout->push;
	engine_run(rollout->model, data, 0.3);
	rollout->end[0] = data->qpos[0];
	rollout->end[1] = data->qpos[2];
	engine.mj_deleteData(data);
	return NULL;
}

static void threads_have_grounds_of_their_own(void **state)
{
	mjModel *model = engine_ball("timestep=\"0.002\"", "", "", "");
	struct rollout alone[3], together[3];
	pthread_t threads[3];
	(void)state;
	for (int i = 0; i < 3; i++) {
		alone[i] = together[i] = (struct rollout){.model = model, .push = 0.2 * (i + 1)};
		roll_out(&alone[i]);
	}
	for (int i = 0; i < 3; i++)
		assert_int_equal(pthread_create(&threads[i], NULL, roll_out, &together[i]), 0);
	for (int i = 0; i < 3; i++) {
		pthread_join(threads[i], NULL);
		assert_memory_equal(together[i].end, alone[i].end, sizeof alone[i].end);
	}
	assert_true(alone[0].end[0] > 0 && alone[1].end[0] > alone[0].end[0]);
	engine.mj_deleteModel(model);
}

TEST_PROGRAM(rides)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_ball_rests_at_its_weight),
		cmocka_unit_test(a_wheel_goes_the_way_of_a_scenes_vehicle),
		cmocka_unit_test(a_wheel_goes_that_way_at_any_step),
		cmocka_unit_test(a_stiff_servo_is_foreseen),
		cmocka_unit_test(soil_gives_no_energy),
		cmocka_unit_test(a_step_leaves_the_inertia),
		cmocka_unit_test(threads_have_grounds_of_their_own),
	};
	return cmocka_run_group_tests(tests, engine_enter, support_leave);
}
