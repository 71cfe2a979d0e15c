/* The work of a body on the soil between two path samples, against closed forms. */
#include "../support.h"
#include "../support/near.h"
#include "../support/program.h"

#include "world/internal.h"

static int64_t place(double metres)
{
	return lattice_offset(metres);
}

static void a_force_that_does_not_change_works_along_the_way(void **state)
{
	(void)state;
	const struct soil_pose from = {.x = place(1), .y = place(2), .yaw = 0.5}, to = {.x = place(4), .y = place(-2), .yaw = 0.5};
	struct world_force before = {.force = {-100, 50, 300}, .moment = {7, 8, 9}, .z = place(10)}, after = before;
	after.z = place(9.5); /* a body with a load stands as high as its force says, wherever its path is */
	assert_near(world_work_between(&from, &before, &to, &after), 100 * 3 + 50 * 4 + 300 * 0.5, 1e-3);
	/* One that grows from nothing does half of it. */
	before.force[0] = before.force[1] = before.force[2] = 0;
	assert_near(world_work_between(&from, &before, &to, &after), (100 * 3 + 50 * 4 + 300 * 0.5) / 2, 1e-3);
}

static void a_moment_works_along_the_turn(void **state)
{
	(void)state;
	/* It looks east and raises its nose by 30 degrees, which turns it by -30 degrees about north: by the right hand, from its left to its back. */
	const double angle = M_PI / 6;
	const struct soil_pose from = {.yaw = 0}, to = {.pitch = angle}, north = {.yaw = M_PI / 2}, turned = {.yaw = M_PI / 2 + angle};
	const struct world_force force = {.moment = {11, 200, 30}};
	assert_near(world_work_between(&from, &force, &to, &force), 200 * angle, 1e-9);
	assert_near(world_work_between(&to, &force, &from, &force), -200 * angle, 1e-9);
	assert_near(world_work_between(&north, &force, &turned, &force), -30 * angle, 1e-9);
}

TEST_PROGRAM(work)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_force_that_does_not_change_works_along_the_way),
		cmocka_unit_test(a_moment_works_along_the_turn),
	};
	return cmocka_run_group_tests_name("world/work", tests, NULL, NULL);
}
