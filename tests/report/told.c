/* Notes at the end of a drive: pictures that take far longer than the steps. tests/cli/notes.py has those on bodies and on black pictures. */
#include "../support.h"
#include "../support/program.h"

#include "report/report.h"

static char told[512];
static int count;

static void keep(void *user, const char *text)
{
	snprintf(told, sizeof told, "%s", text);
	count++;
}

static struct times times_of(double ms, int times)
{
	struct times out = {.count = 0};
	for (int i = 0; i < times; i++)
		times_add(&out, ms);
	return out;
}

/* How much is told of `steps` steps of 1 ms and 100 pictures of `ms`. */
static int told_of(const struct scene *scene, int steps, double ms)
{
	const struct times step = times_of(1, steps), picture = times_of(ms, 100);
	count = 0;
	report_slow_pictures(scene, &step, &picture, keep, NULL);
	return count;
}

static void slow_pictures_are_told_with_what_draws_most(void **state)
{
	struct scene_camera cameras[2] = {{.name = "nav", .width = 640, .height = 480, .rate = 10}, {.name = "far", .width = 64, .height = 48, .rate = 1}};
	struct scene scene = {.time_step = 0.02, .view = {.present = true, .images = 5, .width = 320, .height = 180}};
	assert_int_equal(told_of(&scene, 100, 100), 1);
	assert_string_equal(told, "pictures took 100 times as long as the steps: 0.1 s each, 10 s for all 100; most of their pixels are of view (320 x 180 pixels every 5 "
				  "steps); give larger view.images, or a smaller view.size");
	scene.cameras = cameras;
	scene.camera_count = 2;
	assert_int_equal(told_of(&scene, 100, 100), 1);
	assert_non_null(strstr(told, "most of their pixels are of cameras.nav (640 x 480 pixels, 10 frames for each simulated second); give a lower rate or a smaller size"));
	/* Not where steps take long too, nor where all is soon over. */
	assert_int_equal(told_of(&scene, 1000, 100), 0);
	assert_int_equal(told_of(&scene, 10, 40), 0);
	assert_int_equal(told_of(&scene, 0, 0), 0);
}

TEST_PROGRAM(told)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(slow_pictures_are_told_with_what_draws_most),
	};
	return cmocka_run_group_tests_name("told", tests, NULL, NULL);
}
