/* A cart whose wheels have static camber: where it goes when nothing steers it, and what each wheel's side force does. */
#include <math.h>

#include "drive.h"
#include "../support/program.h"

#define DEGREES (M_PI / 180)
#define YAW 20.0 /* degrees, across the lattice */
#define SECONDS 2.5
#define TURNS 2.0 /* rad/s */

static const struct extent extent = {65, 65, 0.25, 64};

static double ground(int64_t x, int64_t y)
{
	(void)x;
	(void)y;
	return 100;
}

/* left, right: degrees by which the wheels of that side lean, their tops to the left. */
static void write_cart(double left, double right)
{
	char text[4096], wheels[3072], motors[512];
	size_t at = 0, end = 0;
	for (int i = 0; i < 4; i++) {
		at += (size_t)snprintf(wheels + at, sizeof wheels - at,
				       "<body pos=\"%g %g -0.1\" euler=\"%g 0 0\"><joint name=\"turn_%d\" axis=\"0 1 0\"/><geom name=\"wheel_%d\" type=\"cylinder\" size=\"0.25 0.08\" "
				       "euler=\"90 0 0\" mass=\"10\"/></body>", i & 2 ? 0.6 : -0.6, i & 1 ? 0.45 : -0.45, i & 1 ? -left : -right, i, i);
		end += (size_t)snprintf(motors + end, sizeof motors - end, "<velocity name=\"drive_%d\" joint=\"turn_%d\" kv=\"500\"/>", i, i);
	}
	snprintf(text, sizeof text, "<mujoco><option timestep=\"0.002\" integrator=\"implicit\"/><worldbody><body name=\"cart\" pos=\"0 0 0.5\"><freejoint/>"
				    "<geom type=\"box\" size=\"0.6 0.3 0.1\" mass=\"80\" contype=\"0\" conaffinity=\"0\"/>%s</body></worldbody><actuator>%s</actuator></mujoco>",
		 wheels, motors);
	support_write(support_path("cart.xml"), text);
}

struct way {
	double along, aside, turned; /* m: along its first heading, and to its left; degrees to its left */
};

static struct way drive(const char *soil)
{
	static struct drive_row rows[200];
	const char *store = support_path("world.furrow");
	char text[1024];
	snprintf(text, sizeof text, "scene: 1\nend_time: %g\ntime_step: 0.002\nspacing: 0.03125\nsoil: {name: %s}\nredistribute: {model: scm}\n"
				    "vehicles:\n  - {name: v, model: cart.xml, start: {at: [4.01, 6.02], yaw: %g}, driver: {hold: {drive_0: %g, drive_1: %g, drive_2: %g, drive_3: %g}}}\n"
				    "output: {vehicles: 10}\n", SECONDS, soil, YAW, TURNS, TURNS, TURNS, TURNS);
	support_write(support_path("scene.yaml"), text);
	support_store(store, extent, ground);
	must(make_drive(support_path("scene.yaml"), store, NULL, &(struct drive_cut){.out = support_path("out")}, NULL));
	const size_t count = drive_rows(support_path("out/vehicles.csv"), "v", rows, 200);
	assert_true(count > 20);
	const struct drive_row *to = &rows[count - 1];
	const double x = to->x - rows[0].x, y = to->y - rows[0].y, c = cos(YAW * DEGREES), s = sin(YAW * DEGREES);
	return (struct way){c * x + s * y, c * y - s * x, to->yaw - rows[0].yaw};
}

/* Both sides lean inwards, then outwards: their side forces cancel. */
static void with_camber_on_both_sides_it_drives_straight(void **state)
{
	static const struct {
		const char *soil;
		double camber;
	} rows[] = {{"dry_sand", 0}, {"dry_sand", 3}, {"dry_sand", -3}, {"sandy_loam_15", 3}};
	double level = 0;
	(void)state;
	for (int i = 0; i < 4; i++) {
		write_cart(-rows[i].camber, rows[i].camber);
		const struct way way = drive(rows[i].soil);
		print_message("%s, wheels lean inwards by %g degrees: %.3f m along, %.4f m aside, turned by %.3f degrees\n", rows[i].soil, rows[i].camber, way.along, way.aside,
			      way.turned);
		level = i == 0 ? way.along : level;
		assert_true(fabs(way.aside) < 0.005 * way.along && fabs(way.turned) < 0.5);
		assert_true(way.along > 1 && fabs(way.along / level - 1) < 0.04);
	}
}

/* All wheels lean to one side: camber thrust moves it there. */
static void with_camber_to_one_side_it_drives_to_that_side(void **state)
{
	(void)state;
	for (int side = -1; side <= 1; side += 2) {
		write_cart(side * 3, side * 3);
		const struct way way = drive("dry_sand");
		print_message("tops to the %s: %.3f m along, %.4f m aside, turned by %.3f degrees\n", side > 0 ? "left" : "right", way.along, way.aside, way.turned);
		assert_true(side * way.aside > 0.01 * way.along);
	}
}

TEST_PROGRAM(camber)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(with_camber_on_both_sides_it_drives_straight),
		cmocka_unit_test(with_camber_to_one_side_it_drives_to_that_side),
	};
	return cmocka_run_group_tests_name("vehicle/camber", tests, support_enter, support_leave);
}
