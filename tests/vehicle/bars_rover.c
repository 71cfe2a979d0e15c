/*
 * A rover of 42 kg on six small wheels with bars, in dry sand under the gravity of Mars: it drives on the level with little slip, and climbs a slope of 8 degrees with much. Without faces it stands
 * still on the level. A measured wheel of about this size, load and bars pulls 0.11 of its load at slip 0.5, and 0.21 at slip 0.9 (VALIDATION.md, "A measured wheel"). The
 * slope takes 0.14. So much slip is to be expected there.
 */
#include <math.h>

#include "../support/near.h"
#include "drive.h"
#include "../support/program.h"

#define ROLLS 0.086   /* m: radius over the tips of its bars */
#define SPEED 0.1     /* m/s: of these */

static const struct extent extent = {65, 65, 0.25, 128};
static double slope; /* tangent */

static double ground(int64_t x, int64_t y)
{
	(void)y;
	return 100 + slope * 0.25 * (double)x;
}

/* Drives it up a slope, degrees. Returns its slip over the last fifth. */
static double drive(double degrees, double seconds)
{
	static struct drive_row rows[2000];
	char text[2048];
	const double turns = SPEED / ROLLS;
	slope = tan(degrees * M_PI / 180);
	snprintf(text, sizeof text, "t,drive_front_left,drive_middle_left,drive_rear_left,drive_front_right,drive_middle_right,drive_rear_right\n"
				    "0,0,0,0,0,0,0\n1,%g,%g,%g,%g,%g,%g\n", turns, turns, turns, turns, turns, turns);
	support_write(support_path("controls.csv"), text);
	snprintf(text, sizeof text, "scene: 1\nend_time: %g\ntime_step: 0.002\nspacing: 0.015625\ngravity: 3.71\nsoil: {name: dry_sand}\nredistribute: {model: scm, faces: on}\n"
				    "vehicles:\n  - {name: v, model: %s/bars_rover.xml, start: {at: [6, 8]}, soil: [wheel_*], driver: {controls: controls.csv}}\n"
				    "output: {vehicles: 20, forces: 20}\n", seconds, getenv("MODELS"));
	support_write(support_path("scene.yaml"), text);
	const char *store = support_path("world.furrow");
	support_store(store, extent, ground);
	must(make_drive(support_path("scene.yaml"), store, NULL, &(struct drive_cut){.out = support_path("out")}, NULL));
	const size_t count = drive_rows(support_path("out/vehicles.csv"), "v", rows, 2000);
	assert_true(count > 30);
	const struct drive_row *from = &rows[count - count / 5], *to = &rows[count - 1];
	const double way = (to->x - from->x) / cos(degrees * M_PI / 180), slip = 1 - way / (SPEED * (to->t - from->t));
	print_message("%g degrees: slip %.3f by the tips of its bars, %.3f by its rims; heading %.1f degrees\n", degrees, slip, 1 - (1 - slip) * ROLLS / 0.08, to->yaw * 180 / M_PI);
	return slip;
}

static void it_drives_on_the_level(void **state)
{
	(void)state;
	const double slip = drive(0, 6);
	assert_true(slip > 0 && slip < 0.3);
}

static void it_climbs(void **state)
{
	(void)state;
	const double slip = drive(8, 8);
	assert_true(slip > 0 && slip < 0.85);
}

TEST_PROGRAM(bars_rover)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(it_drives_on_the_level),
		cmocka_unit_test(it_climbs),
	};
	return cmocka_run_group_tests_name("a rover with bars", tests, support_enter, support_leave);
}
