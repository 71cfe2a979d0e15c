/* A host's quaternion and deformation's yaw, pitch, roll and turn are the same attitude, in every direction. */
#include "../support.h"
#include "../support/near.h"
#include "../support/program.h"

#include <math.h>

#include "world/internal.h"

static const struct soil_shape box = {.kind = SOIL_BOX, .size = {1, 0.6, 0.4}};
static const struct soil_shape wheel = {.kind = SOIL_WHEEL, .radius = 0.3, .width = 0.2};

static struct furrow_pose pose_of(const struct soil_pose *from)
{
	struct furrow_pose pose = {{1, 2, 3}, {0}};
	world_orientation(from, pose.orientation);
	return pose;
}

static void assert_same_axes(const struct soil_pose *a, const struct soil_pose *b)
{
	double x[3][3], y[3][3];
	soil_axes(a->yaw, a->pitch, a->roll, a->turn, x);
	soil_axes(b->yaw, b->pitch, b->roll, b->turn, y);
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++)
			assert_true(fabs(x[i][k] - y[i][k]) < 1e-12);
}

static void an_attitude_comes_back(void **state)
{
	(void)state;
	for (int yaw = -12; yaw <= 12; yaw++)
		for (int pitch = -8; pitch <= 8; pitch++)
			for (int roll = -12; roll <= 12; roll += 3) {
				const struct soil_pose from = {.yaw = yaw * M_PI / 12, .pitch = pitch * M_PI / 16, .roll = roll * M_PI / 12};
				const struct furrow_pose pose = pose_of(&from);
				struct soil_pose got;
				double length = 0;
				for (int i = 0; i < 4; i++)
					length += pose.orientation[i] * pose.orientation[i];
				assert_true(fabs(length - 1) < 1e-12);
				must(world_attitude(&box, "box", &pose, &got));
				assert_same_axes(&from, &got);
			}
}

static void a_wheel_turns_about_its_axle(void **state)
{
	(void)state;
	for (int yaw = -12; yaw <= 12; yaw++)
		for (int turn = -12; turn <= 12; turn++) {
			const struct soil_pose from = {.yaw = yaw * M_PI / 12, .turn = turn * M_PI / 12};
			const struct furrow_pose pose = pose_of(&from);
			struct soil_pose got;
			must(world_attitude(&wheel, "wheel", &pose, &got));
			assert_same_axes(&from, &got);
			assert_true(got.pitch == 0 && got.roll == 0);
		}
}

/* A wheel's axle may have any attitude. What comes back has the same axle and the same turn about it, and no pitch. */
static void a_wheel_with_camber_comes_back(void **state)
{
	(void)state;
	for (int yaw = -12; yaw <= 12; yaw += 2)
		for (int pitch = -8; pitch <= 8; pitch += 2)
			for (int roll = -12; roll <= 12; roll++)
				for (int turn = -3; turn <= 3; turn++) {
					const struct soil_pose from = {.yaw = yaw * M_PI / 12, .pitch = pitch * M_PI / 16, .roll = roll * M_PI / 12, .turn = turn * 0.9};
					const struct furrow_pose pose = pose_of(&from);
					struct soil_pose got;
					must(world_attitude(&wheel, "wheel", &pose, &got));
					assert_true(got.pitch == 0 && fabs(got.roll) <= M_PI / 2);
					double a[3][3], b[3][3];
					soil_axes(from.yaw, from.pitch, from.roll, from.turn, a);
					soil_axes(got.yaw, 0, got.roll, got.turn, b);
					for (int i = 0; i < 3; i++)
						for (int k = 0; k < 3; k++)
							assert_true(fabs(a[i][k] - b[i][k]) < 1e-5); /* as level as LEVEL: level */
				}
}

/* A wheel's spin is about its own axle: what it yaws counts only where that leans. */
static void spin_is_about_the_axle(void **state)
{
	(void)state;
	const double angular[] = {0.3, -0.8, 2};
	const struct soil_pose level = {.yaw = 0.4}, leaning = {.yaw = 0.4, .roll = 0.3};
	double flat = -sin(0.4) * 0.3 - cos(0.4) * 0.8;
	assert_true(fabs(world_spin(&level, angular) - flat) < 1e-15);
	assert_true(fabs(world_spin(&leaning, angular) - (cos(0.3) * flat + sin(0.3) * 2)) < 1e-15);
}

/* The quaternion of a turn by 90 degrees about z heads north: it is from the body's axes to the local ones. */
static void a_known_turn_has_a_known_quaternion(void **state)
{
	(void)state;
	const struct furrow_pose north = {{0, 0, 0}, {sqrt(0.5), 0, 0, sqrt(0.5)}};
	const struct furrow_pose nose_up = {{0, 0, 0}, {cos(M_PI / 8), 0, -sin(M_PI / 8), 0}};
	struct soil_pose got;
	must(world_attitude(&box, "box", &north, &got));
	assert_near(got.yaw, M_PI / 2, 1e-12);
	must(world_attitude(&box, "box", &nose_up, &got));
	assert_near(got.pitch, M_PI / 4, 1e-12);
}

static void what_is_no_pose_is_refused(void **state)
{
	(void)state;
	const struct furrow_pose bad[] = {
		{{NAN, 0, 0}, {1, 0, 0, 0}}, {{0, 0, INFINITY}, {1, 0, 0, 0}}, {{0, 0, 0}, {0, 0, 0, 0}}, {{0, 0, 0}, {1, 1, 0, 0}},
		{{0, 0, 0}, {NAN, 0, 0, 0}}, {{2e9, 0, 0}, {1, 0, 0, 0}},
	};
	struct soil_pose got;
	for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
		assert_int_equal(world_attitude(&box, "box", &bad[i], &got), STATUS_USAGE);
}

TEST_PROGRAM(attitude)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(an_attitude_comes_back),
		cmocka_unit_test(a_wheel_turns_about_its_axle),
		cmocka_unit_test(a_wheel_with_camber_comes_back),
		cmocka_unit_test(spin_is_about_the_axle),
		cmocka_unit_test(a_known_turn_has_a_known_quaternion),
		cmocka_unit_test(what_is_no_pose_is_refused),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
