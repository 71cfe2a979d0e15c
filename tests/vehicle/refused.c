/* A build without MuJoCo refuses vehicles with what to do, and loads every other scene as before. */
#include "../support.h"
#include "../support/program.h"
#include "vehicle/vehicle.h"

static const char scene_text[] = "scene: 1\nend_time: 1\nsoil: {name: dry_sand}\nredistribute: {model: scm}\nvehicles:\n"
				 "  - {name: car, model: car.xml, start: {at: [5, 5]}}\n";

static void it_says_what_to_do(void **state)
{
	struct vehicles *vehicles;
	struct scene *scene;
	(void)state;
	support_write(support_path("car.xml"), "<mujoco/>");
	support_write(support_path("scene.yaml"), scene_text);
	must(scene_load(support_path("scene.yaml"), NULL, 0, &scene));
	assert_int_equal(vehicle_load(scene, &vehicles), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "vehicles: this build has no MuJoCo; run tools/packages.sh"));
	assert_null(vehicles);
	scene->vehicle_count = 0;
	must(vehicle_load(scene, &vehicles));
	scene->vehicle_count = 1;
	scene_destroy(scene);
}

TEST_PROGRAM(refused)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(it_says_what_to_do)};
	return cmocka_run_group_tests_name("a build without MuJoCo", tests, support_enter, support_leave);
}
