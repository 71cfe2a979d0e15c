/* Models that do not fit a scene are refused with what to do; what is told of those that do is right. */
#include <math.h>
#include <unistd.h>

#include "rig.h"
#include "vehicle/internal.h"
#include "../support/program.h"

#define STEP "time_step: 0.002"

static void a_model_that_does_not_load_is_refused(void **state)
{
	static const struct {
		const char *text, *says;
	} cases[] = {
		{"this is no XML", "vehicles.car: "},
		{"<mujoco><worldbody>", "its XML is not whole"},
		{"<mujoco><worldbody><body><goem/></body></worldbody></mujoco>", "vehicles.car: "},
		{"<mujoco><worldbody><body><geom type=\"mesh\" mesh=\"none\"/></body></worldbody></mujoco>", "vehicles.car: "},
		{"<robot name=\"r\"><link name=\"l\"><geometry/></link></robot", "vehicles.car: "},
		{"", "vehicles.car: "},
	};
	(void)state;
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		support_write(support_path("model.xml"), cases[i].text);
		rig_refused(STEP, "", STATUS_INPUT, cases[i].says);
	}
	unlink(support_path("model.xml"));
	rig_refused(STEP, "", STATUS_INPUT, "vehicles[0].model: ");
}

static void what_cannot_press_or_move_is_refused(void **state)
{
	(void)state;
	/* Its only geom belongs to the model's own world. */
	support_write(support_path("model.xml"),
		      "<mujoco><worldbody><geom type=\"plane\" size=\"1 1 1\"/><geom type=\"sphere\" size=\"1\"/></worldbody></mujoco>");
	rig_refused(STEP, "", STATUS_INPUT, "no geom of it collides, so none presses the ground; let geoms of moving bodies collide, or name them in soil");
	rig_model("", "", "");
	rig_refused(STEP, ", soil: [weel*]", STATUS_INPUT, "soil: weel* names no geom of a body that moves; the model has: wheel");
	support_write(support_path("model.xml"),
		      "<mujoco><worldbody><body><freejoint/><geom type=\"plane\" size=\"1 1 1\" mass=\"1\"/></body></worldbody></mujoco>");
	rig_refused(STEP, "", STATUS_INPUT, "vehicles.car");
	/* More grousers than a wheel has room for. */
	support_write(support_path("model.xml"),
		      "<mujoco><size nuser_geom=\"1\"/><worldbody><body><freejoint/><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/>"
		      "<body><joint axis=\"0 0 1\"/><geom type=\"cylinder\" size=\"0.3 0.1\" mass=\"1\" "
		      "user=\"1000\"/></body></body></worldbody></mujoco>");
	rig_refused(STEP, "", STATUS_INPUT, "1000 grousers");
	/* A mass that nothing has. */
	support_write(support_path("model.xml"),
		      "<mujoco><worldbody><body><freejoint/><geom type=\"sphere\" size=\"0.1\" mass=\"0\"/></body></worldbody></mujoco>");
	rig_refused(STEP, "", STATUS_INPUT, "mass");
}

static void a_step_that_does_not_fit_is_refused(void **state)
{
	struct vehicle_info info;
	struct vehicles *vehicles;
	struct scene *scene;
	char keys[64], says[160];
	(void)state;
	rig_model("", "", "");
	/* The engine's steps divide a time step, and are no longer than the model's. */
	for (int i = 0; i < 3; i++) {
		must(rig_load((const char *const[]){"time_step: 0.0025", "time_step: 0.001", "time_step: 0.002000001"}[i], "", &scene, &vehicles));
		vehicle_info(vehicles, 0, &info);
		assert_int_equal(info.engine_steps, i == 0 ? 2 : 1);
		assert_true(fabs(vehicles->list[0].model->opt.timestep * info.engine_steps - scene->time_step) < 1e-15);
		vehicle_destroy(vehicles);
		scene_destroy(scene);
	}
	rig_model("", "", "");
	must(rig_load(STEP, "", &scene, &vehicles));
	vehicle_info(vehicles, 0, &info);
	/* 2 sqrt(m / (K_e A)): a vertical force on the wheel moves the whole of 100 kg. */
	assert_true(fabs(info.largest_mass - 100) < 1e-9);
	assert_true(fabs(info.largest_step - 2 * sqrt(100 / (4e7 * info.largest_area))) < 1e-12);
	/* The towed wheel of Bekker's formula. */
	const double depth = pow(3 * 981 / (0.24 * (990 / 0.24 + 1528430) * 1.9 * sqrt(0.64)), 2 / 3.2);
	assert_true(fabs(info.largest_area - 0.24 * 2 * sqrt(depth * (0.64 - depth))) < 1e-6);
	assert_int_equal(info.engine_steps, 1);
	assert_true(fabs(info.mass - 100) < 1e-9);
	vehicle_destroy(vehicles);
	scene_destroy(scene);
	const double steps = ceil(info.largest_step / 0.002);
	snprintf(keys, sizeof keys, "time_step: %g", steps * 0.002);
	/* A longer one is divided, by the least whole number that does. */
	for (int parts = 2; parts < 4; parts++) {
		snprintf(keys, sizeof keys, "time_step: %.17g", info.largest_step * (parts - 0.5));
		must(rig_load(keys, "", &scene, &vehicles));
		assert_true(fabs(vehicle_scene(vehicles, scene)->time_step - scene->time_step / parts) < 1e-15);
		assert_int_equal(vehicles->engine_steps, (int)ceil(vehicle_scene(vehicles, scene)->time_step / 0.002 - 1e-6));
		vehicle_destroy(vehicles);
		scene_destroy(scene);
	}
	/* Not without end. */
	snprintf(keys, sizeof keys, "time_step: %.17g", info.largest_step * 51);
	snprintf(says, sizeof says, "is longer than %s s, the longest that is stable (car.wheel: 100 kg",
		 number_at_most(info.largest_step, 3).text);
	rig_refused(keys, "", STATUS_INPUT, says);
	snprintf(keys, sizeof keys, "time_step: %g", (steps - 1) * 0.002);
	must(rig_load(keys, "", &scene, &vehicles));
	vehicle_info(vehicles, 0, &info);
	assert_int_equal(info.engine_steps, (int)steps - 1);
	vehicle_destroy(vehicles);
	scene_destroy(scene);
}

static void wheels_are_cylinders_that_turn_about_their_axis(void **state)
{
	struct vehicles *vehicles;
	struct scene *scene;
	(void)state;
	/* Its axis points to the right: the body's own y axis points to the left all the same. */
	support_write(support_path("model.xml"),
		      "<mujoco><worldbody><geom name=\"floor\" type=\"plane\" size=\"1 1 1\"/><body pos=\"0 0 1\"><freejoint/>"
		      "<geom name=\"hull\" type=\"box\" size=\"0.5 0.3 0.1\" mass=\"100\"/>"
		      "<body pos=\"0 0.5 -0.3\"><joint axis=\"0 1 0\"/><geom type=\"cylinder\" size=\"0.3 0.1\" euler=\"90 0 0\" mass=\"5\"/></body>"
		      "<body name=\"right\" pos=\"0 -0.5 -0.3\"><joint axis=\"0 1 0\"/><geom name=\"a/b\" type=\"cylinder\" size=\"0.3 0.1\" "
		      "euler=\"-90 0 0\" mass=\"5\"/></body></body></worldbody></mujoco>");
	must(rig_load(STEP, "", &scene, &vehicles));
	const struct vehicle *vehicle = &vehicles->list[0];
	assert_int_equal(vehicle->geom_count, 3);
	assert_int_equal(vehicle->geoms[0].shape.kind, SOIL_BOX);
	assert_true(vehicle->geoms[0].shape.size[0] == 1 && vehicle->geoms[0].shape.size[2] == 0.2);
	assert_string_equal(vehicle->geoms[0].name, "car.hull");
	assert_string_equal(vehicle->geoms[2].name, "car.a_b");
	for (int i = 1; i < 3; i++) {
		struct furrow_state at;
		double axes[3][3];
		assert_int_equal(vehicle->geoms[i].shape.kind, SOIL_WHEEL);
		assert_true(vehicle->geoms[i].shape.radius == 0.3 && vehicle->geoms[i].shape.width == 0.2);
		vehicle_geom_state(vehicle, &vehicle->geoms[i], &at, NULL);
		world_axes(at.pose.orientation, axes);
		assert_true(fabs(axes[1][1] - 1) < 1e-12 && fabs(axes[1][0]) < 1e-12 && fabs(axes[1][2]) < 1e-12);
	}
	/* Nothing of the model's own world collides. */
	assert_int_equal(vehicle->model->geom_contype[0], 0);
	vehicle_destroy(vehicles);
	scene_destroy(scene);
}

static void the_same_model_has_the_same_sum(void **state)
{
	struct vehicles *vehicles;
	struct scene *scene;
	double first[2], second[2];
	(void)state;
	for (int i = 0; i < 3; i++) {
		rig_model(i < 2 ? "" : "impratio=\"2\"", "", "");
		must(rig_load(STEP, "", &scene, &vehicles));
		memcpy(i == 0 ? first : second, vehicles->list[0].checksum, sizeof first);
		vehicle_destroy(vehicles);
		scene_destroy(scene);
		assert_true(i == 0 || (memcmp(first, second, sizeof first) == 0) == (i == 1));
	}
}

static void each_allocation_that_fails_is_told(void **state)
{
	struct vehicles *vehicles;
	struct scene *scene;
	enum status status;
	uint64_t nth = 0;
	(void)state;
	rig_model("", "", "");
	must(rig_load(STEP, "", &scene, &vehicles));
	vehicle_destroy(vehicles);
	do {
		mem_fail_nth(++nth, 0);
		status = vehicle_load(scene, &vehicles);
		mem_fail_nth(0, 0);
		if (status != STATUS_OK) {
			assert_int_equal(status, STATUS_FAILED);
			assert_non_null(strstr(failure_message(), "out of memory"));
			assert_null(vehicles);
		}
	} while (status != STATUS_OK && nth < 1000);
	assert_true(status == STATUS_OK && nth > 8);
	vehicle_destroy(vehicles);
	scene_destroy(scene);
}

static void a_keyframe_is_the_first_pose(void **state)
{
	struct vehicles *vehicles;
	struct scene *scene;
	char text[4096];
	(void)state;
	snprintf(text, sizeof text, rig_wheel, "", "", "");
	char *end = strstr(text, "</mujoco>");
	snprintf(end, sizeof text - (size_t)(end - text), "<keyframe><key name=\"half\" qpos=\"0 0 2 1 0 0 0 0.5\" ctrl=\"7\"/></keyframe></mujoco>");
	support_write(support_path("model.xml"), text);
	must(rig_load(STEP, "", &scene, &vehicles));
	vehicle_destroy(vehicles);
	scene_destroy(scene);
	must(scene_load(support_path("scene.yaml"), &(struct scene_setting){"vehicles.car.start.keyframe", "half"}, 1, &scene));
	must(vehicle_load(scene, &vehicles));
	struct vehicle *car = &vehicles->list[0];
	assert_true(car->data->qpos[2] == 2 && car->data->qpos[7] == 0.5);
	vehicle_control(car, 0, true); /* nobody drives it */
	assert_true(car->data->ctrl[0] == 7);
	vehicle_control(car, 0, false); /* brakes hold a wheel */
	assert_true(car->data->ctrl[0] == 0);
	vehicle_destroy(vehicles);
	scene_destroy(scene);
	must(scene_load(support_path("scene.yaml"), &(struct scene_setting){"vehicles.car.start.keyframe", "full"}, 1, &scene));
	assert_int_equal(vehicle_load(scene, &vehicles), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "start.keyframe: full is no keyframe of the model; there are: half"));
	scene_destroy(scene);
}

static void gravity_is_the_scene_s(void **state)
{
	struct vehicles *vehicles;
	struct scene *scene;
	(void)state;
	rig_model("gravity=\"0 0 -9.81\"", "", "");
	must(rig_load(STEP "\ngravity: 1.62", "", &scene, &vehicles));
	assert_true(vehicles->list[0].model->opt.gravity[2] == -1.62);
	vehicle_destroy(vehicles);
	scene_destroy(scene);
}

TEST_PROGRAM(load)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_model_that_does_not_load_is_refused),
		cmocka_unit_test(what_cannot_press_or_move_is_refused),
		cmocka_unit_test(a_step_that_does_not_fit_is_refused),
		cmocka_unit_test(wheels_are_cylinders_that_turn_about_their_axis),
		cmocka_unit_test(the_same_model_has_the_same_sum),
		cmocka_unit_test(each_allocation_that_fails_is_told),
		cmocka_unit_test(a_keyframe_is_the_first_pose),
		cmocka_unit_test(gravity_is_the_scene_s),
	};
	return cmocka_run_group_tests_name("models of vehicles", tests, support_enter, support_leave);
}
