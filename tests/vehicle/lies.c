/* What collides presses the soil: a belly, a roof. It costs nothing while it is high above the ground. What is wrong with how a vehicle lies is told. */
#include <math.h>

#include "../api/hosted.h"
#include "../support/near.h"
#include "../support/program.h"
#include "drive.h"

#include "api/library.h"
#include "vehicle/internal.h"

static const struct extent extent = {161, 65, 0.25, 64};

static double level(int64_t x, int64_t y)
{
	(void)x;
	(void)y;
	return 10;
}

/* Along y = 8 a ridge rises to 0.6 m between the wheels. */
static double ridge(int64_t x, int64_t y)
{
	return 10 + (llabs(y - 32) <= 1 ? fmin(0.6, fmax(0, ((double)x * 0.25 - 5) * 0.12)) : 0);
}

/* %s: attributes of hull and cabin. */
static void write_car(const char *hull, const char *cabin)
{
	char text[8192];
	size_t at = (size_t)snprintf(text, sizeof text,
				     "<mujoco><option timestep=\"0.002\" integrator=\"implicit\"/><worldbody><body name=\"car\" pos=\"0 0 0.6\"><freejoint/>"
				     "<geom name=\"hull\" type=\"box\" size=\"0.9 0.3 0.15\" mass=\"120\" %s/>"
				     "<geom name=\"cabin\" type=\"box\" size=\"0.4 0.3 0.15\" pos=\"-0.1 0 0.3\" mass=\"20\" %s/>", hull, cabin);
	for (int i = 0; i < 4; i++)
		at += (size_t)snprintf(text + at, sizeof text - at,
				       "<body name=\"w%d\" pos=\"%g %g -0.2\"><joint name=\"turn_%d\" axis=\"0 1 0\"/>"
				       "<geom name=\"wheel_%d\" type=\"cylinder\" size=\"0.25 0.07\" euler=\"90 0 0\" mass=\"10\"/></body>",
				       i, i & 1 ? 0.65 : -0.65, i & 2 ? 0.5 : -0.5, i, i);
	at += (size_t)snprintf(text + at, sizeof text - at, "</body></worldbody><actuator>");
	for (int i = 0; i < 4; i++)
		at += (size_t)snprintf(text + at, sizeof text - at, "<velocity name=\"drive_%d\" joint=\"turn_%d\" kv=\"60\" forcerange=\"-150 150\"/>", i, i);
	snprintf(text + at, sizeof text - at, "</actuator></mujoco>");
	support_write(support_path("model.xml"), text);
}

#define HOLD "driver: {hold: {drive_0: 6, drive_1: 6, drive_2: 6, drive_3: 6}}"

/* `keys`: lines of the scene; `more`: keys of the vehicle, after a comma. */
static void prepare(double (*ground)(int64_t x, int64_t y), double seconds, const char *keys, const char *more)
{
	char text[2048];
	snprintf(text, sizeof text, "scene: 1\nend_time: %g\ntime_step: 0.002\nspacing: 0.0625\nsoil: {name: sandy_loam_15}\nredistribute: {model: scm}\n%s"
				    "vehicles:\n  - {name: car, model: model.xml, start: {at: [3, 8]}, " HOLD "%s}\noutput: {forces: 50, vehicles: 50}\n",
		 seconds, keys, more);
	support_write(support_path("scene.yaml"), text);
	support_store(support_path("world.furrow"), extent, ground);
}

/* Drives, from scratch or on. Returns run.json; mem_free it. */
static char *driven(const char *name, int64_t steps, bool resume)
{
	char overlay[64], out[512];
	char *json = NULL;
	snprintf(overlay, sizeof overlay, "%s.furrow", name);
	snprintf(out, sizeof out, "%s", support_path(name));
	char *over = strdup(support_path(overlay));
	const struct drive_cut cut = {.overlay = over, .out = out, .resume = resume, .steps = steps};
	assert_int_equal(make_drive(support_path("scene.yaml"), support_path("world.furrow"), NULL, &cut, &json), STATUS_OK);
	free(over);
	return json;
}

static bool has(const char *json, const char *text)
{
	return strstr(json, text) != NULL;
}

static struct furrow_world *opened(const char *overlay)
{
	struct furrow_world *world = NULL;
	const struct furrow_open open = {.size = sizeof open, .scene_file = support_path("scene.yaml"), .store = support_path("world.furrow"), .overlay = overlay};
	done(furrow_world_open(&open, &world));
	return world;
}

static bool finds(const struct furrow_world *world, const char *what, struct vehicle_lie *lie)
{
	for (size_t n = 0; vehicle_lie(world->vehicles, 0, n, lie); n++)
		if (strcmp(lie->what, what) == 0)
			return true;
	return false;
}

/* Turns the car over, 10 m above where it stands. */
static void turn_over(struct vehicles *vehicles)
{
	const struct vehicle *car = &vehicles->list[0];
	double *place = car->data->qpos + car->own.qpos.first, turned[4];
	mju_mulQuat(turned, (const double[]){0, 1, 0, 0}, place + 3);
	mju_copy4(place + 3, turned);
	place[2] += 10;
	vehicle_find_places(vehicles);
}

/* A fall of 10 m onto the roof ends on the roof, without driving, though the wheels turn all the time. */
static void a_car_that_falls_on_its_roof_ends_there(void **state)
{
	struct vehicle_lie lie;
	(void)state;
	write_car("", "");
	prepare(level, 1, "", "");
	struct furrow_world *world = opened(support_path("roof.furrow"));
	struct vehicle *car = &world->vehicles->list[0];
	turn_over(world->vehicles);
	for (int i = 0; i < 1500; i++)
		done(furrow_step(world, 0));
	double before[3], after[3];
	mju_copy3(before, car->data->xpos + 3 * car->root);
	for (int i = 0; i < 500; i++)
		done(furrow_step(world, 0));
	mju_copy3(after, car->data->xpos + 3 * car->root);
	assert_true(car->data->xmat[9 * car->root + 8] < -0.9);            /* on its roof */
	/* It rocks on its roof by some centimetres; wheels that drove would have gone 1.5 m in this second. */
	assert_true(hypot(after[0] - before[0], after[1] - before[1]) < 0.1 && hypot(after[0], after[1]) < 0.3);
	assert_true(fabs(car->data->qvel[car->own.dof.first + 6]) > 1);    /* a wheel turns */
	/* Its roof is 0.45 m from the middle, and sank by less than 10 cm. */
	assert_true(after[2] + car->origin[2] > 10 + 0.35 && after[2] + car->origin[2] < 10 + 0.5);
	assert_true(finds(world, "overturned", &lie));
	assert_true(lie.time > 0 && lie.time < 0.1 && isnan(lie.depth) && lie.geom == NULL);
	assert_near(lie.at[0], 3, 0.2);
	assert_false(finds(world, "under_ground", &lie));
	done(furrow_world_close(world));
}

/* Hull and cabin of before, which had no say: the wheels alone press, so the car lies in the ground, and that is told. */
static void a_part_without_a_say_below_the_ground_is_told(void **state)
{
	struct vehicle_lie lie;
	(void)state;
	write_car("", "");
	prepare(level, 1, "", ", soil: [wheel_*]");
	struct furrow_world *world = opened(support_path("wheels.furrow"));
	turn_over(world->vehicles);
	for (int i = 0; i < 2000; i++)
		done(furrow_step(world, 0));
	assert_true(finds(world, "under_ground", &lie));
	assert_true(strcmp(lie.geom, "car.cabin") == 0 || strcmp(lie.geom, "car.hull") == 0);
	assert_true(lie.time > 1.3 && lie.time < 3 && lie.depth > 0.2); /* 10 m of fall take 1.4 s */
	assert_true(finds(world, "overturned", &lie));
	done(furrow_world_close(world));
}

/* A belly on a ridge stops the car. It is told, and a resumed drive goes on with the same bits. */
static void a_belly_on_a_ridge_stops_the_car(void **state)
{
	struct drive_row rows[600];
	(void)state;
	write_car("", "");
	prepare(ridge, 9, "stuck: {after: 1, below: 0.2}\n", "");
	char *whole = driven("whole", 0, false);
	assert_true(has(whole, "\"stuck\"") && has(whole, "\"high_centred\"") && has(whole, "\"car.hull\""));
	const size_t count = drive_rows(support_path("whole/vehicles.csv"), "car", rows, 600);
	assert_true(count > 150 && rows[count - 1].t < 8.9 && rows[count - 1].x < 9 && rows[count - 1].x > 7);
	mem_free(driven("parts", 2100, false));
	char *parts = driven("parts", 0, true);
	assert_true(has(parts, "\"high_centred\""));
	assert_same_rows(support_path("whole"), support_path("parts"), 500);
	mem_free(whole);
	mem_free(parts);
}

/* The hull of a car on level ground changes no bit of its motion. */
static void a_hull_aloft_changes_nothing(void **state)
{
	(void)state;
	write_car("", "");
	prepare(level, 2, "", "");
	mem_free(driven("all", 0, false));
	prepare(level, 2, "", ", soil: [wheel_*]");
	mem_free(driven("named", 0, false));
	prepare(level, 2, "", ", no_soil: [hull, cab*]");
	mem_free(driven("not", 0, false));
	assert_same_rows(support_path("all"), support_path("named"), 500);
	assert_same_rows(support_path("all"), support_path("not"), 500);
	/* It has no rows, since it is not in the world. */
	char *rows = support_text(support_path("all/objects.csv"));
	assert_true(has(rows, "car.wheel_0") && !has(rows, "car.hull"));
	free(rows);
}

static void the_scene_says_what_stops_a_drive(void **state)
{
	(void)state;
	write_car("", "");
	char *model = support_text(support_path("model.xml")), turned[8192];
	const char *place = strstr(model, "pos=\"0 0 0.6\"");
	snprintf(turned, sizeof turned, "%.*s quat=\"0 1 0 0\" %s", (int)(place - model), model, place);
	support_write(support_path("model.xml"), turned);
	free(model);
	prepare(level, 2, "stop: [overturned]\n", "");
	char *json = driven("stops", 0, false);
	assert_true(has(json, "\"overturned\"") && support_figure(json, "{", "steps") < 600);
	mem_free(json);
	prepare(level, 1.2, "stop: [buried]\n", "");
	json = driven("goes", 0, false);
	assert_true(has(json, "\"complete\"") && has(json, "\"overturned\"") && support_figure(json, "{", "steps") == 600);
	mem_free(json);
}

/* Spheres on hinges, whose axles look to the left or to the right. */
static void a_sphere_that_turns_has_slip(void **state)
{
	char text[4096];
	size_t at = (size_t)snprintf(text, sizeof text, "<mujoco><option timestep=\"0.002\" integrator=\"implicit\"/><worldbody><body name=\"car\" pos=\"0 0 0.4\"><freejoint/>"
							"<inertial pos=\"0 0 0\" mass=\"100\" diaginertia=\"5 10 10\"/>");
	for (int i = 0; i < 4; i++)
		at += (size_t)snprintf(text + at, sizeof text - at, "<body pos=\"%g %g -0.1\"><joint name=\"turn_%d\" axis=\"0 %d 0\"/><geom name=\"ball_%d\" type=\"sphere\" size=\"0.2\" mass=\"5\"/></body>",
				       i & 1 ? 0.6 : -0.6, i & 2 ? 0.4 : -0.4, i, i & 2 ? -1 : 1, i);
	at += (size_t)snprintf(text + at, sizeof text - at, "</body></worldbody><actuator>");
	for (int i = 0; i < 4; i++)
		at += (size_t)snprintf(text + at, sizeof text - at, "<velocity name=\"drive_%d\" joint=\"turn_%d\" kv=\"%d\" gear=\"%d\"/>", i, i, 60, i & 2 ? -1 : 1);
	snprintf(text + at, sizeof text - at, "</actuator></mujoco>");
	support_write(support_path("model.xml"), text);
	for (int backward = 0; backward < 2; backward++) { /* backward both speeds are below 0, and so is their difference */
		prepare(level, 2, "", backward ? ", forward: -x" : "");
		struct furrow_world *world = opened(support_path(backward ? "back.furrow" : "balls.furrow"));
		struct vehicle *car = &world->vehicles->list[0];
		for (size_t g = 0; g < car->geom_count; g++) /* it stands */
			assert_true(isfinite(car->geoms[g].contact.slip_velocity));
		for (int i = 0; i < 500; i++)
			done(furrow_step(world, 0));
		assert_int_equal(car->geom_count, 4);
		for (size_t g = 0; g < car->geom_count; g++) {
			const struct furrow_contact *contact = &car->geoms[g].contact;
			const double rim = 0.2 * fabs(car->data->qvel[car->geoms[g].roll_dof]);
			assert_true(car->geoms[g].roll_dof >= 0 && rim > 0.3);
			assert_true(contact->slip > 0 && contact->slip < 0.9);
			assert_near(contact->slip_velocity, (backward ? -1 : 1) * contact->slip * rim, 0.02 * rim);
		}
		done(furrow_world_close(world));
	}
}

/* A wheel that is braked and slides has no slip, and a slip velocity. */
static void slip_velocity_is_finite_at_standstill(void **state)
{
	(void)state;
	write_car("", "");
	prepare(level, 2, "", "");
	struct furrow_world *world = opened(support_path("still.furrow"));
	struct vehicle *car = &world->vehicles->list[0];
	const double none[4] = {0};
	done(furrow_set_controls(world, 0, 4, none));
	for (int i = 0; i < 50; i++)
		done(furrow_step(world, 0));
	for (size_t g = 0; g < car->geom_count; g++)
		if (car->geoms[g].is_standing)
			assert_true(isnan(car->geoms[g].contact.slip) && fabs(car->geoms[g].contact.slip_velocity) < 5e-3);
	car->data->qvel[car->own.dof.first] = 0.3;
	done(furrow_step(world, 0));
	done(furrow_step(world, 0));
	for (size_t g = 0; g < car->geom_count; g++)
		if (car->geoms[g].is_standing)
			assert_true(car->geoms[g].contact.slip_velocity < -0.05);
	done(furrow_world_close(world));
}

TEST_PROGRAM(lies)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_car_that_falls_on_its_roof_ends_there),
		cmocka_unit_test(a_part_without_a_say_below_the_ground_is_told),
		cmocka_unit_test(a_belly_on_a_ridge_stops_the_car),
		cmocka_unit_test(a_hull_aloft_changes_nothing),
		cmocka_unit_test(the_scene_says_what_stops_a_drive),
		cmocka_unit_test(a_sphere_that_turns_has_slip),
		cmocka_unit_test(slip_velocity_is_finite_at_standstill),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
