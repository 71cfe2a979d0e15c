/* The scenes handed out load, and stay where their comments say. SCENES: their folder. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/scene.h"
#include "../support/program.h"
#include "../support/skip.h"

/* NULL: it has meshes, and this build none. */
static struct scene *load(const char *name)
{
	char path[1024];
	struct scene *scene;
	const char *scenes = getenv("SCENES");
	if (scenes == NULL)
		skip_since("the scenes that ship are not named");
	snprintf(path, sizeof path, "%s/%s.yaml", scenes, name);
	if (scene_load(path, NULL, 0, &scene) == STATUS_OK)
		return scene;
	if (strstr(failure_message(), "this build reads no meshes") == NULL)
		fail_msg("%s", failure_message());
	return NULL;
}

static void every_example_loads_and_stays_within_its_ground(void **state)
{
	static const struct {
		const char *name;
		size_t objects;
		double low, high; /* metres, of every path point */
		bool view;
	} examples[] = {
		{"demo", 4, 40, 130, true},  {"rover", 6, 40, 100, true}, {"table2", 4, 40, 410, true},
		{"convoy", 12, 20, 200, true}, {"shapes", 3, 40, 85, true}, {"bare", 1, 40, 100, false},
		{"foot", 2, 59, 66, true}, {"tracks", 2, 40, 90, true},
	};
	for (size_t e = 0; e < sizeof examples / sizeof examples[0]; e++) {
		struct scene *scene = load(examples[e].name);
		if (scene == NULL)
			continue;
		assert_int_equal(scene->object_count, examples[e].objects);
		assert_int_equal(scene->view.present, examples[e].view);
		for (size_t i = 0; i < scene->object_count; i++)
			for (size_t p = 0; p < scene->objects[i].path.count; p++) {
				const struct scene_waypoint *at = &scene->objects[i].path.points[p];
				assert_true(at->x >= examples[e].low && at->x <= examples[e].high);
				assert_true(at->y >= examples[e].low && at->y <= examples[e].high);
			}
		scene_destroy(scene);
	}
}

static void the_bare_scene_calls_for_displacement_and_reading_alone(void **state)
{
	struct scene *scene = load("bare");
	assert_int_equal(scene_effects(scene, 0), EFFECT_BIT(EFFECT_OF(DEFORM_NONE)) | EFFECT_BIT(EFFECT_LOADERS) | EFFECT_BIT(EFFECT_PREFETCH));
	scene_destroy(scene);
}

static void the_demonstrations_vehicle_is_rigid(void **state)
{
	struct scene *scene = load("demo");
	const struct scene_path *left = &scene->objects[0].path, *right = &scene->objects[1].path;
	assert_int_equal(left->count, right->count);
	for (size_t p = 0; p < left->count; p++) {
		double dx = left->points[p].x - right->points[p].x;
		double dy = left->points[p].y - right->points[p].y;
		assert_true(fabs(hypot(dx, dy) - 2) < 0.002);
		assert_true(left->points[p].t == right->points[p].t);
	}
	assert_true(left->points[left->count - 1].t == scene->end_time);
	scene_destroy(scene);
}

TEST_PROGRAM(examples)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_example_loads_and_stays_within_its_ground),
		cmocka_unit_test(the_bare_scene_calls_for_displacement_and_reading_alone),
		cmocka_unit_test(the_demonstrations_vehicle_is_rigid),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
