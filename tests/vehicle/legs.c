/* A robot on legs stands where it was set down, and walks by its own controls: tools/scenes/vehicles/quadruped.yaml. */
#include <math.h>

#include "../long.h"
#include "drive.h"
#include "../support/near.h"
#include "../support/program.h"

static const struct extent extent = {65, 65, 0.25, 64};

static double ground(int64_t x, int64_t y)
{
	(void)x;
	(void)y;
	return 100;
}

static size_t drive(const char *soil, const char *driver, const char *end, struct drive_row *rows, size_t most)
{
	static const char *const files[] = {"quadruped.xml", "quadruped_controls.csv"};
	char text[1024], path[512];
	const char *store = support_path("world.furrow");
	for (int i = 0; i < 2; i++) {
		snprintf(path, sizeof path, "%s/vehicles/%s", getenv("SCENES"), files[i]);
		char *whole = support_text(path);
		support_write(support_path(files[i]), whole);
		free(whole);
	}
	snprintf(text, sizeof text, "scene: 1\nend_time: %s\ntime_step: 0.002\nspacing: %s\nsoil: {name: %s}\nredistribute: {model: scm}\n"
				    "vehicles:\n  - {name: v, model: quadruped.xml, start: {at: [6, 8], keyframe: home}, soil: [foot_*]%s}\noutput: {vehicles: 10}\n", end, driver[0] == 0 ? "0.03125" : "0.015625", soil, driver);
	support_write(support_path("scene.yaml"), text);
	support_store(store, extent, ground);
	must(make_drive(support_path("scene.yaml"), store, NULL, &(struct drive_cut){.out = support_path("out")}, NULL));
	return drive_rows(support_path("out/vehicles.csv"), "v", rows, most);
}

static void it_stands_in_its_keyframe(void **state)
{
	struct drive_row rows[64];
	(void)state;
	const size_t count = drive("dry_sand", "", "1", rows, 64);
	assert_int_equal(count, 11);
	const struct drive_row *first = &rows[0], *last = &rows[10], *before = &rows[5];
	print_message("trunk at %.4f m; in half a second it moved %.3g um\n", last->z - 100, 1e6 * hypot(last->x - before->x, last->y - before->y));
	/* The keyframe has it at 0.323 m; its feet, of 0.06 m, sink in part. */
	assert_true(first->z - 100 > 0.323 - 0.05 && first->z - 100 < 0.323);
	assert_near(last->z, first->z, 1e-5);
	assert_true(hypot(last->x - before->x, last->y - before->y) < 1e-6);
	assert_true(fabs(last->pitch) < 3 && fabs(last->roll) < 3 && last->kinetic < 1e-9);
}

static void it_walks_a_metre(void **state)
{
	struct drive_row rows[64];
	(void)state;
	if (!long_run()) /* half a minute of a processor */
		return;
	const size_t count = drive("sandy_loam_15", ", driver: {controls: quadruped_controls.csv}", "5", rows, 64);
	const struct drive_row *last = &rows[count - 1];
	print_message("walked to %.3f %.3f m\n", last->x - 6, last->y - 8);
	assert_true(hypot(last->x - 6, last->y - 8) > 1);
	assert_true(last->z - 100 > 0.22 && fabs(last->roll) < 20 && fabs(last->pitch) < 20);
}

TEST_PROGRAM(legs)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(it_stands_in_its_keyframe),
		cmocka_unit_test(it_walks_a_metre),
	};
	return cmocka_run_group_tests_name("a robot on legs", tests, support_enter, support_leave);
}
