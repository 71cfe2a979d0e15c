/* Under kinematic models no ground stands inside a body that a host has set down: what another one pushes against it goes around it. */
#include "rut.h"

#include "../support/program.h"

#define KINEMATIC(model, soil, compute) \
	"{\"scene\": 1, \"time_step\": 0.01, \"spacing\": 0.0625, \"compute\": \"" compute "\", \"soil\": " soil ", \"redistribute\": {\"model\": \"" model "\", \"iterations\": 3}}"

/* Returns litres of ground that is inside the plate: 2 m along x, 1 m along y, from 100 to 100.2 m, at (8.03, 8.02). beside: in front of it, above the ground. */
static double inside(const double *offsets, const struct furrow_info *info, double *beside)
{
	double sum = 0;
	*beside = 0;
	for (int64_t i = 0; i < (int64_t)(info->columns * info->rows); i++) {
		const double x = (double)(i % (int64_t)info->columns) * 0.0625 - 8.03, y = (double)(i / (int64_t)info->columns) * 0.0625 - 8.02, height = offsets[i];
		if (fabs(x) < 1 - 0.0625 && fabs(y) < 0.5 - 0.0625)
			sum += height < 0.2 ? fmax(height - 1e-5, 0) : 0.2;
		else if (fabs(x) < 1 && y < -0.5 && y > -1)
			*beside += fmax(height, 0);
	}
	*beside *= 1e3 * 0.0625 * 0.0625;
	return 1e3 * 0.0625 * 0.0625 * sum;
}

/* Pushes a blade towards the plate, from y = 6.2 m on, and lets what it pushed come to rest. */
static void push(struct furrow_world *world, furrow_body blade)
{
	for (int i = 0; i <= 60; i++)
		hosted_move(world, blade, 8.03, 6.2 + 0.02 * i, 100.15);
	for (int i = 0; i < 30; i++)
		done(furrow_step(world, 0.05));
}

static void no_ground_stands_inside_a_plate_that_a_host_set_down(void **state)
{
	static const char *const scenes[] = {
		KINEMATIC("slippage", "{\"name\": \"dry_sand\"}", "cpu"), KINEMATIC("slippage", "{\"name\": \"dry_sand\"}", "gpu"),
		KINEMATIC("sumner", "{\"name\": \"sand\", \"compression\": 0}", "cpu"), KINEMATIC("sumner", "{\"name\": \"sand\", \"compression\": 0}", "gpu"),
	};
	double *first[2] = {NULL, NULL};
	(void)state;
	for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
		struct furrow_world *world = hosted_world_over("beside.furrow", scenes[i], hosted_flat);
		struct furrow_info info;
		furrow_body plate = -1, blade = -1;
		done(furrow_body_add(world, "{name: plate, shape: {box: {size: [2, 1, 0.2]}}}", &plate));
		done(furrow_body_add(world, "{name: blade, shape: {box: {size: [2, 0.2, 0.6]}}}", &blade));
		const struct furrow_pose flat = hosted_pose(8.03, 8.02, 100.1), begins = hosted_pose(8.03, 6.2, 100.15);
		done(furrow_place(world, plate, &flat));
		done(furrow_place(world, blade, &begins));
		done(furrow_step(world, 0));
		done(furrow_checkpoint(world));
		double *offsets[2], beside;
		for (int way = 0; way < 2; way++) {
			push(world, blade);
			offsets[way] = hosted_read(world, FURROW_OFFSET, &info);
			done(furrow_rollback(world));
		}
		const size_t bytes = (size_t)(info.columns * info.rows) * sizeof(double);
		const double litres = inside(offsets[0], &info, &beside);
		print_message("%s: %.6f l inside the plate, %.1f l before it\n", scenes[i], litres, beside);
		assert_true(beside > 5);
		assert_true(litres < 1e-3);
		assert_memory_equal(offsets[0], offsets[1], bytes);
		if (i % 2 == 1)
			assert_memory_equal(offsets[0], first[i / 2], bytes);
		else
			first[i / 2] = offsets[0];
		free(offsets[1]);
		if (i % 2 == 1)
			free(offsets[0]);
		done(furrow_world_close(world));
	}
	free(first[0]);
	free(first[1]);
}

TEST_PROGRAM(beside)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(no_ground_stands_inside_a_plate_that_a_host_set_down),
	};
	return cmocka_run_group_tests_name("beside", tests, support_enter, support_leave);
}
