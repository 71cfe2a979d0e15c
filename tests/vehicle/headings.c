/* Ten headings: each shipped vehicle goes the same way, whatever way it looks. */
#include <math.h>

#include "../long.h"
#include "../support/program.h"
#include "drive.h"

#define HEADINGS 10
#define MIDDLE 32.0

static const struct extent extent = {257, 257, 0.25, 128};

static double ground(int64_t x, int64_t y)
{
	(void)x, (void)y;
	return 100;
}

/* The way is 6 m straight on and 3 m aside. The soil bears the rover's small wheels over 5 cm: with posts 6.25 cm apart, of which it warns, its ways differ by 2.8 %,
 * with half of that by 0.1 %. */
static const struct {
	const char *name, *keys, *steer;
	double speed, seconds, spacing;
} vehicles[] = {
	{"offroad", "soil: {name: sandy_loam_15}", "[steer_*]", 2, 4, 0.0625},
	{"rover", "gravity: 1.62\nsoil: {name: lunar}", "[steer_*]", 0.5, 8, 0.03125},
	{"tracked", "soil: {name: sandy_loam_15}", "[]", 1, 5, 0.0625},
};

struct end {
	double along, aside, work;
};

static struct end drive(size_t which, double yaw)
{
	static struct drive_row rows[600];
	const char *store = support_path("world.furrow");
	char text[2048], path[512];
	const double c = cos(yaw), s = sin(yaw);
	snprintf(path, sizeof path, "%s/vehicles/%s.xml", getenv("SCENES"), vehicles[which].name);
	char *model = support_text(path);
	support_write(support_path("model.xml"), model);
	free(model);
	snprintf(text, sizeof text, "scene: 1\nend_time: %g\ntime_step: 0.002\nspacing: %g\n%s\nredistribute: {model: scm}\nvehicles:\n"
				    "  - {name: v, model: model.xml, start: {at: [%.6f, %.6f], yaw: %.6f}, soil: [wheel_*, track_*], driver: {path: {points: [[%.6f, %.6f], [%.6f, %.6f], [%.6f, %.6f]], "
				    "speed: %g}, steer: %s, drive: [drive_*]}}\noutput: {vehicles: 20}\n", vehicles[which].seconds, vehicles[which].spacing, vehicles[which].keys, MIDDLE, MIDDLE, yaw * 180 / M_PI,
		 MIDDLE, MIDDLE, MIDDLE + 3 * c, MIDDLE + 3 * s, MIDDLE + 12 * c - 5 * s, MIDDLE + 12 * s + 5 * c, vehicles[which].speed, vehicles[which].steer);
	support_write(support_path("scene.yaml"), text);
	support_store(store, extent, ground);
	must(make_drive(support_path("scene.yaml"), store, NULL, &(struct drive_cut){.out = support_path("out")}, NULL));
	const size_t count = drive_rows(support_path("out/vehicles.csv"), "v", rows, 600);
	const double x = rows[count - 1].x - MIDDLE, y = rows[count - 1].y - MIDDLE;
	return (struct end){c * x + s * y, -s * x + c * y, rows[count - 1].work};
}

static void ten_headings_go_alike(void **state)
{
	(void)state;
	for (size_t v = 0; v < 3; v++) {
		const struct end first = drive(v, 0);
		const double way = hypot(first.along, first.aside);
		assert_true(way > 2);
		for (size_t i = 1; i < HEADINGS; i++) {
			if (!by_turn(i + v, 9))
				continue;
			const struct end end = drive(v, 2 * M_PI * (double)i / HEADINGS);
			const double off = hypot(end.along - first.along, end.aside - first.aside) / way;
			print_message("%s at %zu degrees: %.4f m on, %.4f m aside, %.1f J; %.2f %% of its way off\n", vehicles[v].name, 36 * i, end.along, end.aside, end.work, 100 * off);
			assert_true(off < 0.003);
		}
	}
}

TEST_PROGRAM(headings)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(ten_headings_go_alike)};
	return cmocka_run_group_tests_name("ten headings", tests, support_enter, support_leave);
}
