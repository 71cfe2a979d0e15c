/* Drivers: actuators that are not there and tables that are wrong are refused; controls are what was asked for. */
#include <math.h>

#include "rig.h"
#include "vehicle/internal.h"
#include "../support/program.h"

#define STEP "time_step: 0.002"

static void names_that_are_not_there_are_refused(void **state)
{
	(void)state;
	rig_model("", "", "");
	rig_refused(STEP, ", driver: {hold: {drive_1: 1}}", STATUS_INPUT, "driver.hold: drive_1 names no actuator of the model; there are: drive");
	rig_refused(STEP, ", driver: {path: {points: [[1, 1], [2, 2]], speed: 1}, drive: [wheel*]}", STATUS_INPUT,
		    "driver.drive: wheel* names no actuator");
	rig_refused(STEP, ", driver: {path: {points: [[1, 1], [2, 2]], speed: 1}, drive: [drive], steer: [steer]}", STATUS_INPUT,
		    "driver.steer: steer names no actuator");
	support_write(support_path("model.xml"),
		      "<mujoco><compiler angle=\"radian\"/><worldbody><body><freejoint/><inertial pos=\"0 0 0\" mass=\"9\" diaginertia=\"1 1 1\"/>"
		      "<body><joint name=\"turn\" axis=\"0 1 0\"/><geom name=\"tyre\" type=\"cylinder\" size=\"0.3 0.1\" euler=\"90 0 0\" mass=\"9\"/></body></body>"
		      "</worldbody><actuator><motor name=\"drive\" joint=\"turn\"/></actuator></mujoco>");
	rig_refused(STEP, ", driver: {path: {points: [[1, 1], [2, 2]], speed: 1}, drive: [drive]}", STATUS_INPUT,
		    "driver.drive: drive turns no wheel: car.tyre is a cylinder whose axis is 26.6 degrees off its hinge turn; check its euler, and angle of the ");
	support_write(support_path("model.xml"),
		      "<mujoco><worldbody><body><freejoint/><geom type=\"box\" size=\"1 1 1\" mass=\"1\"/><body><joint name=\"j\" type=\"slide\"/>"
		      "<geom type=\"sphere\" size=\"1\" mass=\"1\"/></body><body><joint name=\"h\"/><geom type=\"sphere\" size=\"1\" mass=\"1\"/></body>"
		      "</body></worldbody><actuator><motor name=\"m\" joint=\"j\"/><motor name=\"n\" joint=\"h\"/></actuator></mujoco>");
	rig_refused("time_step: 0.002\nsoil: {name: dry_sand, elastic_stiffness: 1}", "", STATUS_INPUT, "soil: is written twice");
}

static void wrong_tables_are_refused(void **state)
{
	static const struct {
		const char *text, *says;
	} cases[] = {
		{"", "controls.csv:0: the first line does not begin with t"},
		{"x,drive\n0,1\n", ":1: the first line does not begin with t; allowed: t,ACTUATOR,..."},
		{"t\n0\n", ":1: no actuator; allowed: t,ACTUATOR"},
		{"t,drove\n0,1\n", ":1: drove; allowed: names of the model's actuators"},
		{"t,drive,drive\n0,1,1\n", ":1: drive; allowed: each actuator once"},
		{"t,drive\n", "no row; allowed: at least one"},
		{"t,drive\n0,1\n0,2\n", ":3: t does not grow"},
		{"t,drive\n-1,1\n", ":2: t does not grow"},
		{"t,drive\n0,1,2\n", ":2: another number of columns"},
		{"t,drive\n0\n", ":2: another number of columns"},
		{"t,drive\n\n0,one\n", ":3: one; allowed: numbers"},
		{"t,drive\n0,nan\n", ":2: nan; allowed: numbers"},
	};
	(void)state;
	rig_model("", "", "");
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
		support_write(support_path("controls.csv"), cases[i].text);
		rig_refused(STEP, ", driver: {controls: controls.csv}", STATUS_INPUT, cases[i].says);
	}
	rig_refused(STEP, ", driver: {controls: none.csv}", STATUS_INPUT, "vehicles[0].driver.controls: ");
}

static void a_table_is_followed_evenly(void **state)
{
	struct vehicles *vehicles;
	struct scene *scene;
	(void)state;
	rig_model("", "", "");
	support_write(support_path("controls.csv"), "t,drive\n1,10\n2,20\n4,0\n");
	must(rig_load(STEP, ", driver: {controls: controls.csv}", &scene, &vehicles));
	static const double wanted[][2] = {{0, 10}, {1, 10}, {1.5, 15}, {2, 20}, {3, 10}, {4, 0}, {9, 0}};
	for (size_t i = 0; i < sizeof wanted / sizeof wanted[0]; i++) {
		vehicle_control(&vehicles->list[0], wanted[i][0], true);
		assert_true(fabs(vehicles->list[0].data->ctrl[0] - wanted[i][1]) < 1e-12);
		vehicle_control(&vehicles->list[0], wanted[i][0], false);
		assert_true(vehicles->list[0].data->ctrl[0] == 0);
	}
	vehicle_destroy(vehicles);
	scene_destroy(scene);
}

/* Four wheels; the front ones steer. Where it stands and what lies ahead decide angles and speeds. */
static void all_wheels_turn_about_one_middle(void **state)
{
	struct vehicles *vehicles;
	struct scene *scene;
	char text[512];
	(void)state;
	snprintf(text, sizeof text, "%s/vehicles/rover.xml", getenv("SCENES"));
	FILE *from = fopen(text, "r"), *to = fopen(support_path("model.xml"), "w");
	assert_true(from != NULL && to != NULL);
	for (int c; (c = getc(from)) != EOF;)
		putc(c, to);
	fclose(from);
	fclose(to);
	must(rig_load("time_step: 0.002\ngravity: 1.62", ", soil: [wheel_*], driver: {path: {points: [[0, 0], [0, 1], [-2, 1]], speed: 0.1}, steer: [steer_*], "
							 "drive: [drive_*]}", &scene, &vehicles));
	struct vehicle *vehicle = &vehicles->list[0];
	const mjModel *model = vehicle->model;
	double points[3][2] = {{0, 0}, {3, 0}, {3, 5}};
	vehicle->driver.points = mem_calloc(3, sizeof *points);
	assert_non_null(vehicle->driver.points);
	memcpy(vehicle->driver.points, points, sizeof points);
	vehicle->driver.point_count = 3;
	vehicle->driver.speed = 0.1; /* it goes as fast already; the model does not, so rims get a little faster with each call */
	/* Straight ahead: nothing is steered, and all rims go as fast as the ground. */
	vehicle_control(vehicle, 10, true);
	for (int i = 0; i < model->nu; i++)
		assert_true(fabs(vehicle->data->ctrl[i] - (i < 4 ? 0 : 0.1 / 0.15)) < 1e-6);
	/* 2 m on, the point ahead lies round the corner: it turns left, and all wheels about one middle. */
	vehicle->data->qpos[0] = 2;
	mj_forward(model, vehicle->data);
	vehicle_control(vehicle, 10, true);
	const double *ctrl = vehicle->data->ctrl;
	const double ahead = 1.2 * 1.2, corner = 3, past = ahead - (corner - 2);
	const double curvature = 2 * past / ((corner - 2) * (corner - 2) + past * past), radius = 1 / curvature;
	static const char *const steers[] = {"steer_front_left", "steer_front_right", "steer_rear_left", "steer_rear_right"};
	for (int i = 0; i < 4; i++) {
		const int actuator = vehicle_find_part(vehicle, mjOBJ_ACTUATOR, steers[i]);
		const double x = i < 2 ? 0.6 : -0.6, y = i % 2 == 0 ? 0.425 : -0.425;
		const double angle = atan2(x, radius - y), rim = curvature * hypot(x, radius - y) * 0.1 / 0.15;
		const int drives = vehicle_find_part(vehicle, mjOBJ_ACTUATOR, i == 0 ? "drive_front_left" : i == 1 ? "drive_front_right" : i == 2 ? "drive_rear_left"
														: "drive_rear_right");
		assert_true(fabs(ctrl[actuator] - angle) < 1e-3);
		assert_true(fabs(ctrl[drives] - rim) < 3e-3);
	}
	/* At the end it stands. */
	vehicle->data->qpos[0] = 3;
	vehicle->data->qpos[1] = 5.2;
	mj_forward(model, vehicle->data);
	vehicle->driver.at = 1.9;
	vehicle_control(vehicle, 10, true);
	assert_true(vehicle->driver.arrived);
	for (int i = 4; i < model->nu; i++)
		assert_true(ctrl[i] == 0);
	vehicle_destroy(vehicles);
	scene_destroy(scene);
}

TEST_PROGRAM(drivers)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(names_that_are_not_there_are_refused),
		cmocka_unit_test(wrong_tables_are_refused),
		cmocka_unit_test(a_table_is_followed_evenly),
		cmocka_unit_test(all_wheels_turn_about_one_middle),
	};
	return cmocka_run_group_tests_name("drivers of vehicles", tests, support_enter, support_leave);
}
