/* Soil geoms that share one hinge: twin wheels, two belts on one sprocket, a belt beside a wheel. Their hinge is free once the vehicle has
 * settled, and it drives them as far as one geom of the same width, place and mass. */
#include <math.h>

#include "drive.h"
#include "../support/program.h"

#define RATE 2.0   /* rad/s */
#define RADIUS 0.3 /* m, of wheels and sprockets */
#define SECONDS 1.0

static const struct extent extent = {65, 65, 0.25, 64};

static double ground(int64_t x, int64_t y)
{
	(void)x;
	(void)y;
	return 100;
}

#define WHEEL(name, y, half) \
	"<geom name=\"" name "\" type=\"cylinder\" size=\"0.3 " half "\" pos=\"0 " y " 0\" euler=\"90 0 0\"/>"
#define TRACK(name, y, half) \
	"<geom name=\"" name "\" type=\"box\" size=\"0.5 " half " 0.15\" pos=\"0 " y " -0.15\"/>"
#define BELT(name) "<text name=\"belt:" name "\" data=\"turn\"/><numeric name=\"belt:" name "\" data=\"0.3\"/>"

/* What hangs on one hinge: what custom has, geoms of the carriage, geoms of what the hinge turns. */
struct hung {
	const char *what, *custom, *carriage, *hub;
};

/* Returns how far it drives, m. */
static double driven(const struct hung *hung)
{
	static struct drive_row rows[64];
	const char *store = support_path("world.furrow");
	char text[2048];
	snprintf(text, sizeof text,
		 "<mujoco><option timestep=\"0.002\" integrator=\"implicit\"/><custom>%s</custom><worldbody><body pos=\"0 0 0.5\">"
		 "<joint type=\"slide\" axis=\"1 0 0\"/><joint type=\"slide\" axis=\"0 0 1\"/><inertial pos=\"0 0 0\" mass=\"80\" diaginertia=\"1 1 1\"/>%s"
		 "<body><joint name=\"turn\" axis=\"0 1 0\"/><inertial pos=\"0 0 0\" mass=\"20\" diaginertia=\"0.5 0.5 0.5\"/>%s</body></body></worldbody>"
		 "<actuator><velocity name=\"drive\" joint=\"turn\" kv=\"20000\"/></actuator></mujoco>", hung->custom, hung->carriage, hung->hub);
	support_write(support_path("model.xml"), text);
	snprintf(text, sizeof text, "scene: 1\nend_time: %g\ntime_step: 0.002\nspacing: 0.03125\nsoil: {name: dry_sand}\nredistribute: {model: scm}\n"
				    "vehicles:\n  - {name: v, model: model.xml, start: {at: [8, 8]}, driver: {hold: {drive: %g}}}\noutput: {vehicles: 20}\n",
		 SECONDS, RATE);
	support_write(support_path("scene.yaml"), text);
	support_store(store, extent, ground);
	must(make_drive(support_path("scene.yaml"), store, NULL, &(struct drive_cut){.out = support_path("out")}, NULL));
	const size_t count = drive_rows(support_path("out/vehicles.csv"), "v", rows, 64);
	assert_true(count == 21);
	const double way = rows[count - 1].x - rows[0].x;
	print_message("%s: %.5f m of %.5f m that the rim runs\n", hung->what, way, RADIUS * RATE * SECONDS);
	return way;
}

/* Narrower geoms meet a soil that is stiffer by k_c / b: 0.3 % here. */
static double as_far(const struct hung *one, const struct hung *two)
{
	const double way = driven(one), beside = driven(two);
	assert_true(way > 0.8 * RADIUS * RATE * SECONDS && way < RADIUS * RATE * SECONDS);
	assert_true(fabs(beside - way) < 0.002 * way);
	return way;
}

static void two_on_one_hinge_go_as_far_as_one(void **state)
{
	static const struct hung wheel = {"one wheel", "", "", WHEEL("wheel", "0", "0.125")};
	static const struct hung wheels = {"two wheels", "", "", WHEEL("left", "0.25", "0.0625") WHEEL("right", "-0.25", "0.0625")};
	static const struct hung belt = {"one belt", BELT("track"), TRACK("track", "0", "0.125"), ""};
	static const struct hung belts = {"two belts", BELT("left") BELT("right"), TRACK("left", "0.25", "0.0625") TRACK("right", "-0.25", "0.0625"), ""};
	static const struct hung mixed = {"a belt beside a wheel", BELT("track"), TRACK("track", "0.25", "0.0625"), WHEEL("wheel", "-0.25", "0.0625")};
	(void)state;
	const double rolled = as_far(&wheel, &wheels), ran = as_far(&belt, &belts), way = driven(&mixed);
	assert_true(rolled < way && way < ran);
}

TEST_PROGRAM(twins)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(two_on_one_hinge_go_as_far_as_one),
	};
	return cmocka_run_group_tests_name("vehicle/twins", tests, support_enter, support_leave);
}
