/* An elastic sheet in a hosted world: what bodies press down comes back when they rise, jump or are removed; rollbacks, and the store. */
#include "../support/near.h"
#include "../support/program.h"
#include "rut.h"

#define SHEET "{scene: 1, time_step: 0.01, spacing: 0.125, %sredistribute: {model: sheet, tension: 20000%s}, cache: {slots: 64}}"

/* state: that of a test. What is there: the GPU bends the sheet. */
static struct furrow_world *world_of(void **state, const char *more)
{
	char scene[256];
	snprintf(scene, sizeof scene, SHEET, *state == NULL ? "" : "compute: gpu, ", more);
	return hosted_world_over("sheet.furrow", scene, hosted_flat);
}

/* The sum of all offsets, m, and the lowest. */
static double offsets(struct furrow_world *world, double *lowest)
{
	struct furrow_info info;
	double *posts = hosted_read(world, FURROW_OFFSET, &info), sum = 0;
	*lowest = 0;
	for (int64_t i = 0; i < info.columns * info.rows; i++) {
		sum += posts[i];
		*lowest = fmin(*lowest, posts[i]);
		assert_true(isfinite(posts[i]));
	}
	free(posts);
	return sum;
}

static void assert_level(struct furrow_world *world)
{
	double lowest;
	assert_true(offsets(world, &lowest) == 0 && lowest == 0);
}

static void assert_pressed(struct furrow_world *world, double deep)
{
	double lowest;
	assert_true(offsets(world, &lowest) < -deep); /* it bends far beyond one post */
	assert_near(lowest, -deep, 1e-5);
}

static void what_a_body_presses_comes_back_however_it_goes(void **state)
{
	struct furrow_world *world = world_of(state, "");
	furrow_body ball = hosted_ball(world, 10, 16);
	const struct furrow_pose away = hosted_pose(20, 20, 100.5);
	/* It goes along, over edges of tiles, and rises in one step, or in small ones. */
	make_rut(world, ball, 10, 16, 60);
	assert_pressed(world, 0.1);
	hosted_move(world, ball, 13, 16, 105);
	assert_level(world);
	make_rut(world, ball, 10, 16, 20);
	for (int i = 0; i <= 40; i++)
		hosted_move(world, ball, 11, 16, 100.4 + 0.01 * i);
	assert_level(world);
	/* It jumps. */
	make_rut(world, ball, 10, 16, 4);
	done(furrow_place(world, ball, &away));
	assert_level(world);
	hosted_move(world, ball, 20, 20, 100.3);
	assert_pressed(world, 0.2);
	/* It is removed; another one stays. */
	furrow_body other = hosted_ball(world, 20, 21);
	hosted_move(world, other, 20, 21, 100.45);
	assert_pressed(world, 0.2);
	done(furrow_body_remove(world, ball));
	assert_pressed(world, 0.05);
	done(furrow_body_remove(world, other));
	assert_level(world);
	done(furrow_world_close(world));
	const struct store_check check = support_verify(support_path("sheet.furrow"));
	assert_true(check.compacted == 0);
	for (int level = TILE_LEVEL_MIN; level <= TILE_LEVEL_MAX; level++)
		assert_true(check.offset_sum[level - TILE_LEVEL_MIN] == 0);
}

static void beyond_the_yield_a_rut_stays(void **state)
{
	struct furrow_world *world = world_of(state, ", yield: 0.04, rut: 0.5");
	furrow_body ball = hosted_ball(world, 10, 16);
	double lowest;
	make_rut(world, ball, 10, 16, 40);
	done(furrow_body_remove(world, ball));
	assert_true(offsets(world, &lowest) < 0);
	assert_near(lowest, -0.5 * (0.1 - 0.04), 1e-5);
	done(furrow_world_close(world));
	const struct store_check check = support_verify(support_path("sheet.furrow"));
	assert_true(check.compacted > 0 && check.offset_sum[check.finest - TILE_LEVEL_MIN] + check.compacted == 0);
}

static void a_rollback_brings_back_what_was_pressed(void **state)
{
	struct furrow_world *world = world_of(state, ", yield: 0.04");
	struct furrow_info info;
	furrow_body ball = hosted_ball(world, 10, 16);
	make_rut(world, ball, 10, 16, 20);
	done(furrow_checkpoint(world));
	double *first = hosted_read(world, FURROW_OFFSET, &info), *ways[2];
	const size_t bytes = (size_t)(info.columns * info.rows) * sizeof *first;
	for (int i = 0; i < 2; i++) {
		make_rut(world, ball, 11, 16, 12);
		hosted_move(world, ball, 11.6, 16, 103);
		ways[i] = hosted_read(world, FURROW_OFFSET, &info);
		done(furrow_rollback(world));
		double *back = hosted_read(world, FURROW_OFFSET, &info);
		assert_memory_equal(back, first, bytes);
		free(back);
	}
	assert_memory_equal(ways[0], ways[1], bytes);
	assert_memory_not_equal(ways[0], first, bytes);
	for (int i = 0; i < 2; i++)
		free(ways[i]);
	free(first);
	done(furrow_world_close(world));
}

static void a_sheet_that_is_too_long_for_its_posts_is_refused(void **state)
{
	(void)state;
	struct furrow_world *world = NULL;
	const char *store = support_path("long.furrow");
	support_store(store, hosted_extent, hosted_flat);
	const struct furrow_open open = hosted_open("{scene: 1, time_step: 0.01, spacing: 0.125, redistribute: {model: sheet, tension: 300000}}", store);
	furrow_status status = furrow_world_open(&open, &world); /* a world knows its bodies later */
	if (status == FURROW_OK) {
		furrow_body ball = -1;
		status = furrow_body_add(world, HOSTED_BALL, &ball);
		if (status == FURROW_OK) {
			const struct furrow_pose pose = hosted_pose(10, 16, 100.4);
			done(furrow_place(world, ball, &pose));
			status = furrow_step(world, 0);
		}
	}
	assert_int_equal(status, FURROW_INPUT);
	assert_non_null(strstr(furrow_last_error(), "bends over 2.449 m, which is more than 16 posts of 0.125 m; give a coarser spacing"));
	(void)furrow_world_close(world);
}

static void loose_soil_of_scm_is_refused(void **state)
{
	(void)state;
	struct furrow_world *world = hosted_world_over("loose.furrow", "{scene: 1, time_step: 0.01, spacing: 0.125, soil: {name: dry_sand}, redistribute: {model: scm, loosening: 0.5}}",
						       hosted_flat);
	furrow_body ball = hosted_ball(world, 10, 16);
	make_rut(world, ball, 10, 16, 8);
	done(furrow_world_close(world));
	world = NULL;
	const struct furrow_open open = hosted_open("{scene: 1, time_step: 0.01, spacing: 0.125, redistribute: {model: sheet}}", support_path("loose.furrow"));
	furrow_status status = furrow_world_open(&open, &world);
	if (status == FURROW_OK) {
		ball = -1;
		done(furrow_body_add(world, HOSTED_BALL, &ball));
		const struct furrow_pose pose = hosted_pose(10, 16, 100.4);
		done(furrow_place(world, ball, &pose));
		status = furrow_step(world, 0);
	}
	assert_int_equal(status, FURROW_INPUT);
	assert_non_null(strstr(furrow_last_error(), "this store has loose soil of a drive under scm"));
	(void)furrow_world_close(world);
}

static int on_the_gpu(void **state)
{
	static bool gpu = true;
	*state = &gpu;
	return 0;
}

TEST_PROGRAM(sheet)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_a_body_presses_comes_back_however_it_goes),
		cmocka_unit_test(beyond_the_yield_a_rut_stays),
		cmocka_unit_test(a_rollback_brings_back_what_was_pressed),
		cmocka_unit_test_setup(what_a_body_presses_comes_back_however_it_goes, on_the_gpu),
		cmocka_unit_test_setup(beyond_the_yield_a_rut_stays, on_the_gpu),
		cmocka_unit_test_setup(a_rollback_brings_back_what_was_pressed, on_the_gpu),
		cmocka_unit_test(a_sheet_that_is_too_long_for_its_posts_is_refused),
		cmocka_unit_test(loose_soil_of_scm_is_refused),
	};
	return cmocka_run_group_tests_name("api/sheet", tests, NULL, NULL);
}
