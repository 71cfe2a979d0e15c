/* Limits of shapes. */
#include "soil_test.h"

#include "../support/program.h"

static void shapes_beyond_limits_are_refused(void **state)
{
	const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.5, .width = 0.4};
	struct soil_shape shape = {.kind = SOIL_SPHERE, .radius = 257};
	(void)state;
	assert_int_equal(soil_shape_check(&shape, 30), STATUS_INPUT);
	shape.radius = 250;
	assert_int_equal(soil_shape_check(&shape, 30), STATUS_OK);
	assert_int_equal(soil_shape_check(&shape, 0.25), STATUS_INPUT);
	assert_int_equal(soil_shape_check(&(struct soil_shape){.kind = SOIL_BOX, .size = {1, 1, 0}}, 1), STATUS_INPUT);
	assert_int_equal(soil_shape_check(&(struct soil_shape){.kind = SOIL_WHEEL, .radius = 1}, 1), STATUS_INPUT);
	assert_int_equal(soil_shape_check(&wheel, 0.015625), STATUS_OK);
}

TEST_PROGRAM(shapes)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(shapes_beyond_limits_are_refused),
	};
	return cmocka_run_group_tests_name("soil/shapes", tests, NULL, NULL);
}
