/*
 * A world's life with each allocation failing in turn: every call returns a status, a failed one says why, and the world can be
 * closed. What is committed verifies.
 */
#include "hosted.h"

#include "store/store.h"
#include "../support/program.h"
#include "../support/skip.h"

/* Beyond this every GROWTH-th allocation is tried, so that a test of thousands ends. */
#define EACH 150
#define GROWTH 1.07

static const char *store;

/* A call that failed for want of memory, or was refused since an earlier one failed. */
static bool tell(furrow_status status)
{
	if (status == FURROW_NO_GL)
		skip_since("no GL");
	if (status != FURROW_OK) {
		if (status != FURROW_FAILED)
			print_error("%d: %s\n", (int)status, furrow_last_error());
		assert_int_equal(status, FURROW_FAILED);
		assert_true(furrow_last_error()[0] != '\0');
	}
	return status == FURROW_OK;
}

static bool move(struct furrow_world *world, furrow_body ball)
{
	bool whole = true;
	for (int i = 0; i < 4; i++) {
		const struct furrow_state at = hosted_state(16 + 0.1 * i, 16, 100.4);
		whole = tell(furrow_set_states(world, 1, &ball, &at)) && whole;
		whole = tell(furrow_step(world, 0)) && whole;
	}
	return whole;
}

static bool pour(struct furrow_world *world)
{
	static const double heights[2][2] = {{0.5, 0.25}, {0, -0.5}}, corners[] = {5, 5, 7, 5, 6, 8};
	const bool whole = tell(furrow_pour(world, 63, 63, 2, 2, &heights[0][0], 2, -1, true));
	return tell(furrow_pour_polygon(world, 3, corners, 0.7, -1, false)) && whole;
}

static bool ask(struct furrow_world *world, furrow_body ball)
{
	const double xy[2] = {16, 16}, from[3] = {16, 16, 110}, down[3] = {0, 0, -1};
	struct furrow_contact contact;
	struct furrow_state state;
	struct furrow_point point;
	struct furrow_hit hit;
	struct furrow_rect rects[64];
	double posts[16];
	size_t count = 64;
	uint64_t now;
	char *json = NULL;
	bool whole = tell(furrow_get_contacts(world, 1, &ball, &contact, sizeof contact));
	whole = tell(furrow_get_states(world, 1, &ball, &state)) && whole;
	whole = tell(furrow_points(world, 1, xy, &point)) && whole;
	whole = tell(furrow_rays(world, 1, from, down, &hit)) && whole;
	whole = tell(furrow_read(world, FURROW_SURFACE, 0, 60, 60, 4, 4, posts, 4)) && whole;
	whole = tell(furrow_changes(world, 0, rects, &count, &now)) && whole;
	whole = tell(furrow_stats(world, &json)) && whole;
	furrow_free(json);
	return whole;
}

/* True if nothing failed. */
static bool live(void)
{
	static uint8_t rgb[3 * 32 * 24];
	/* A picture of few effects: these lives are many. */
	const struct furrow_open open = hosted_open("{time_step: 0.01, spacing: 0.125, soil: {name: dry_sand}, redistribute: {model: scm}, "
						    "view: {effects: [skirts, objects]}}", store);
	const struct furrow_camera camera = {.size = sizeof camera, .pose = hosted_pose(10, 16, 102), .fovy = 1, .width = 32, .height = 24};
	const struct furrow_pose pose = hosted_pose(16, 16, 100.5);
	struct furrow_world *world = NULL;
	furrow_body ball = -1;
	if (!tell(furrow_world_open(&open, &world))) {
		assert_null(world);
		return false;
	}
	bool whole = false;
	if (tell(furrow_body_add(world, HOSTED_BALL, &ball)) && tell(furrow_place(world, ball, &pose))) {
		whole = move(world, ball);
		whole = pour(world) && whole;
		whole = ask(world, ball) && whole;
		const bool kept = tell(furrow_checkpoint(world));
		whole = kept && whole;
		whole = move(world, ball) && whole;
		whole = tell(furrow_render(world, &camera, rgb, NULL)) && whole;
		whole = tell(furrow_rollback(world)) && whole;
		/* Without the checkpoint it goes back to the opening, when there was no ball. */
		whole = (!kept || tell(furrow_body_remove(world, ball))) && whole;
	}
	return tell(furrow_world_close(world)) && whole;
}

static void a_life_without_memory_ends_with_statuses(void **state)
{
	uint64_t tried = 0;
	bool whole = false;
	store = support_path("memory.furrow");
	support_store(store, hosted_extent, hosted_flat);
	for (uint64_t nth = 1; !whole; nth = nth < EACH ? nth + 1 : (uint64_t)(GROWTH * (double)nth), tried++) {
		mem_fail_nth(nth, false);
		whole = live();
		const uint64_t made = mem_fail_nth(0, false);
		whole = whole && made < nth; /* it was not reached */
	}
	print_message("%llu lives\n", (unsigned long long)tried);
	assert_true(tried > EACH);
	struct furrow_world *world;
	const struct furrow_open open = hosted_open(HOSTED_SCENE, store);
	done(furrow_world_open(&open, &world));
	done(furrow_world_close(world));
	struct store *stored;
	struct store_check check;
	assert_int_equal(store_open(store, &(struct store_options){.mode = STORE_READ}, &stored), STATUS_OK);
	assert_int_equal(store_verify(stored, NULL, NULL, NULL, &check), STATUS_OK);
	assert_int_equal(check.problems, 0);
	assert_true(check.added > 0 && check.offset_sum[-1 - TILE_LEVEL_MIN] + check.compacted == check.added); /* whichever pours failed */
	store_close(stored);
}

TEST_PROGRAM(memory)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(a_life_without_memory_ends_with_statuses)};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
