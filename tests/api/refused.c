/* A close for which the world's GL cannot be made current. Here gpu_take says so when a test asks for it; a host sees it where a GLX
 * context is current. */
#include "rut.h"

#include "gpu/gpu.h"
#include "../support/program.h"

#define SCENE "{\"scene\": 1, \"time_step\": 0.01, \"spacing\": 0.125, \"redistribute\": {\"model\": \"none\"}}"

static bool refuses;

enum status __real_gpu_take(struct gpu *gpu);
enum status __wrap_gpu_take(struct gpu *gpu);

enum status __wrap_gpu_take(struct gpu *gpu)
{
	return refuses ? fail_with(STATUS_NO_GL, "GL: it cannot be made current; release the other one") : __real_gpu_take(gpu);
}

static void leaves_the_world_open_and_nothing_is_lost(void **state)
{
	(void)state;
	/* A world whose soil bears has no GL. */
	struct furrow_world *world = hosted_world_over("refused.furrow", SCENE, hosted_flat), *again = NULL;
	const furrow_body ball = hosted_ball(world, 16, 16);
	hosted_move(world, ball, 16, 16, 100.45);
	const double pressed = point_at(world, 16, 16).offset;
	assert_true(pressed < -0.04);

	refuses = true;
	refused(FURROW_NO_GL, furrow_world_close(world));
	refused(FURROW_NO_GL, furrow_step(world, 0));
	refuses = false;

	hosted_move(world, ball, 16, 16, 100.44);
	const double deeper = point_at(world, 16, 16).offset;
	assert_true(deeper < pressed);
	done(furrow_world_close(world));
	const struct furrow_open open = hosted_open(SCENE, support_path("refused.furrow"));
	done(furrow_world_open(&open, &again));
	assert_true(point_at(again, 16, 16).offset == deeper);
	done(furrow_world_close(again));
}

TEST_PROGRAM(refused)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(leaves_the_world_open_and_nothing_is_lost),
	};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
