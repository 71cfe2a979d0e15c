/* Active blocks: the ground becomes the same as if all of it were computed. */
#include "late.h"
#include "sliding.h"
#include "../support/program.h"

/* The whole block of ground as one window. */
static void whole(struct ground *ground)
{
	struct deform *deform = ground->deform;
	struct post_rect all = all_of(ground);
	struct deform_window window = {.read = {-1, -1, all.x1 + 1, all.y1 + 1}, .write = all};
	struct gpu_rect rect = rect_of(0, 0, (uint32_t)all.x1 + 2, (uint32_t)all.y1 + 2);
	deform_gather(deform, window.read, 0, 0, 0, true, PLANE_BIT(PLANE_OFFSET), ground->tiles, ground->tile_count);
	gpu_texture_clear(deform->contacts, 0, rect, 0);
	gpu_texture_clear(deform->deposits, 0, rect, 0);
	deform->scratch[0].now[PLANE_OFFSET] = 1;
	deform->scratch[0].near = false;
	assert_ok(deform_slide(deform, &window, 0));
	assert_ok(deform_scatter(deform, &window, 0, ground->tiles, ground->tile_count));
}

static const struct setup setups[] = {
	{DEFORM_SLIPPAGE, 64, 3, 0.0625, 0, 4, hills}, {DEFORM_SUMNER, 64, 3, 0.0625, 0, 4, hills},
	{DEFORM_SLIPPAGE, 32, 4, 0.125, 0.02, 8, hills}, {DEFORM_SUMNER, 16, 7, 0.125, 0, 8, hills},
	{DEFORM_SLIPPAGE, 8, 14, 0.25, 0, 1, conserve_holed}, {DEFORM_SUMNER, 128, 1, 0.25, 0, 1, conserve_holed},
};

static void few_blocks_do_what_all_would(void **state)
{
	(void)state;
	need_gpu();
	for (size_t s = 0; s < sizeof setups / sizeof *setups; s++) {
		struct ground few, all, one;
		start(&few, &setups[s]);
		start(&all, &setups[s]);
		start(&one, &setups[s]);
		struct ground *grounds[] = {&few, &all, &one};
		size_t visited = 0, possible = 0;
		int64_t side = few.posts, n = 0, still = 0;
		for (; n < 900 && still < 2; n++) {
			/* Now and then something happens, near corners of blocks and at the edge of the world. */
			if (n % 40 == 0 && n < 120)
				for (int k = 0; k < 3; k++)
					disturb(grounds[k], n == 0 ? 64 : n == 40 ? 3 : side / 2, n == 80 ? side - 4 : 60, n == 80 ? 0.4 : 0.9);
			size_t blocks = interval(&few, NULL, 0);
			visited += blocks;
			still += blocks == 0 && n > 120;
			assert_ok(deform_wake(all.deform, all_of(&all)));
			possible += interval(&all, NULL, 0);
			whole(&one);
			if (n % 32 == 0 || still > 0) {
				assert_same(&few, &one, (int)n);
				assert_same(&all, &one, (int)n);
			}
		}
		/* It came to rest, and cost less on the way. */
		assert_true(still == 2 && visited > 0 && visited < possible / 2);
		struct deform_tally tally;
		assert_ok(deform_tally(few.deform, &tally));
		assert_true(conserve_sum(&few) == -tally.compacted);
		for (int k = 0; k < 3; k++)
			ground_finish(grounds[k]);
	}
}

static void more_blocks_than_a_layer_holds_are_as_right(void **state)
{
	struct ground few, all;
	struct setup setup = {DEFORM_SLIPPAGE, 64, 5, 0.0625, 0, 4, hills};
	(void)state;
	need_gpu();
	start(&few, &setup);
	start(&all, &setup);
	for (int k = 0; k < 4; k++) {
		disturb(&few, k % 2 * 250 + 40, k / 2 * 250 + 40, 0.9);
		disturb(&all, k % 2 * 250 + 40, k / 2 * 250 + 40, 0.9);
	}
	for (int n = 0; n < 6; n++) {
		size_t blocks = interval(&few, NULL, 0);
		assert_true(blocks > 0 && blocks < 64);
		assert_ok(deform_wake(all.deform, all_of(&all)));
		assert_int_equal(interval(&all, NULL, 0), 121);
	}
	assert_same(&few, &all, 6);
	ground_finish(&few);
	ground_finish(&all);
}

/* Flags that come late keep more awake, and change nothing. */
static void flags_that_come_late_change_nothing(void **state)
{
	static const int64_t lates[] = {2, 3, LATE_UNTIL_WAITED};
	(void)state;
	need_gpu();
	for (int s = 0; s < 6; s++) {
		struct ground prompt, late;
		start(&prompt, &setups[s % 2]);
		start(&late, &setups[s % 2]);
		disturb(&prompt, 96, 96, 0.9);
		disturb(&late, 96, 96, 0.9);
		size_t visited = 0, possible = 0;
		for (int n = 0; n < 60; n++) {
			if (n == 7) {
				disturb(&prompt, 100, 40, 0.5);
				disturb(&late, 100, 40, 0.5);
			}
			visited += interval(&prompt, NULL, 0);
			late_by = lates[s / 2];
			possible += interval(&late, NULL, 0);
			late_by = 0;
			late_pass();
		}
		assert_same(&prompt, &late, 60);
		assert_true(visited > 0 && possible > visited);
		ground_finish(&prompt);
		ground_finish(&late);
	}
}

static void what_an_object_rests_on_is_held(void **state)
{
	static const enum deform_model models[] = {DEFORM_SLIPPAGE, DEFORM_SUMNER};
	(void)state;
	need_gpu();
	for (int m = 0; m < 2; m++) {
		struct ground few, all;
		struct setup setup = {models[m], 64, 3, 0.0625, 0, 4, hills};
		start(&few, &setup);
		start(&all, &setup);
		struct ground *grounds[] = {&few, &all};
		struct soil_shape box = {.kind = SOIL_BOX, .size = {1.4, 0.9, 4}}, ball = {.kind = SOIL_SPHERE, .radius = 0.5};
		struct deform_contact sweep = {.shape = &box, .from = ground_pose(&few, 64.3, 63.8, 0.7)};
		sweep.from.yaw = 0.5;
		sweep.to = sweep.from;
		struct deform_rest rests[] = {{.shape = &ball, .pose = ground_pose(&few, 150, 20, 0.4)}, {.shape = &box, .pose = sweep.to}};
		for (int k = 0; k < 2; k++) {
			ground_sweep(grounds[k], &sweep);
			assert_ok(deform_wake(grounds[k]->deform, grounds[k]->windows[0].write));
		}
		uint8_t *contacts = ground_contacts(&few);
		ground_read(&few);
		int32_t *before = ground_room(few.posts * few.posts, sizeof *before);
		memcpy(before, few.offset, (size_t)(few.posts * few.posts) * sizeof *before);
		size_t passes = 0, awake = 0;
		for (int n = 0; n < 500 && (n < 10 || awake); n++) {
			awake = interval(&few, rests, 2);
			passes += awake;
			assert_ok(deform_wake(all.deform, all_of(&all)));
			interval(&all, rests, 2);
		}
		assert_same(&few, &all, 500);
		size_t held = 0, moved = 0, in_the_hole = 0;
		for (int64_t i = 0; i < few.posts * few.posts; i++) {
			bool rests_here = (contacts[i] & REFERENCE_HELD) != 0;
			held += rests_here;
			moved += few.offset[i] != before[i];
			in_the_hole += rests_here && few.offset[i] != before[i];
		}
		assert_true(held > 150 && moved > 100 && passes > 8);
		if (models[m] == DEFORM_SLIPPAGE)
			assert_int_equal(in_the_hole, 0);
		/* It rests; the ground too, until what held it is gone. */
		assert_int_equal(interval(&few, rests, 2), 0);
		assert_ok(deform_wake(few.deform, few.windows[0].write));
		assert_true(interval(&few, rests, 1) > 0);
		ground_read(&few);
		in_the_hole = 0;
		for (int64_t i = 0; i < few.posts * few.posts; i++)
			in_the_hole += (contacts[i] & REFERENCE_HELD) != 0 && few.offset[i] != before[i];
		assert_true(in_the_hole > 0);
		mem_free(before);
		mem_free(contacts);
		ground_finish(&few);
		ground_finish(&all);
	}
}

/* A spike on the plain, steeper than what is held stands at, less than that diagonally. */
static int32_t spike(int64_t x, int64_t y)
{
	return x == 48 && y == 48 ? (int32_t)lrint(ldexp(1.1 * 0.0625, BASE_BITS)) : 0;
}

/* 20 m from one block to the next. */
static int32_t ledge_between_blocks(int64_t x, int64_t y)
{
	(void)y;
	return x >= 32 ? -20 * (1 << BASE_BITS) : 0;
}

/* What slides from under an object, and stood beside it, stands no longer where nothing is held. */
static void what_slid_out_of_an_object_slides_on(void **state)
{
	struct ground few, all;
	const struct setup setup = {DEFORM_SUMNER, 32, 3, 0.0625, 0, 4, spike};
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 0.5};
	(void)state;
	need_gpu();
	start(&few, &setup);
	start(&all, &setup);
	struct deform_rest rest = {.shape = &ball, .pose = ground_pose(&few, 48, 48, 0.5 + ldexp(spike(48, 48), -BASE_BITS))};
	assert_ok(deform_wake(few.deform, all_of(&few)));
	for (int n = 0; n < 60; n++) {
		interval(&few, &rest, 1);
		assert_ok(deform_wake(all.deform, all_of(&all)));
		interval(&all, &rest, 1);
	}
	assert_same(&few, &all, 60);
	assert_true(few.offset[48 * few.posts + 48] < 0);
	ground_finish(&few);
	ground_finish(&all);
}

/* As another model may have left it: one block awake, the steep one beside it asleep. */
static void beside_a_block_that_sleeps_no_soil_is_lost(void **state)
{
	static const enum deform_model models[] = {DEFORM_SLIPPAGE, DEFORM_SUMNER};
	(void)state;
	need_gpu();
	for (int m = 0; m < 2; m++) {
		struct ground ground;
		int64_t sum = 0;
		start(&ground, &(struct setup){models[m], 64, 2, 0.25, 0, 4, ledge_between_blocks});
		for (int n = 0; n < 3; n++) {
			assert_ok(deform_wake_block(ground.deform, (struct soil_block){0, 0}));
			assert_ok(deform_wake_block(ground.deform, (struct soil_block){2, 1}));
			assert_int_equal(interval(&ground, NULL, 0), 2);
		}
		ground_read(&ground);
		for (int64_t i = 0; i < ground.posts * ground.posts; i++)
			sum += ground.offset[i];
		assert_int_equal(sum, 0);
		ground_finish(&ground);
	}
}

static void a_world_at_rest_makes_no_pass(void **state)
{
	struct ground ground;
	struct gpu_stats before, after;
	(void)state;
	need_gpu();
	start(&ground, &setups[0]);
	gpu_stats(test_gpu, &before);
	for (int n = 0; n < 10; n++)
		assert_int_equal(interval(&ground, NULL, 0), 0);
	gpu_stats(test_gpu, &after);
	assert_memory_equal(&before, &after, sizeof before);
	ground_finish(&ground);
}

static void more_blocks_than_there_may_be_are_refused(void **state)
{
	struct ground ground;
	const struct soil_block *blocks;
	size_t count;
	(void)state;
	need_gpu();
	start(&ground, &(struct setup){DEFORM_SLIPPAGE, 8, 1, 0.125, 0, 1, NULL});
	ground.extent.width = ground.extent.height = 129 * 32;
	for (int64_t y = 0; y < 128; y++)
		for (int64_t x = 0; x < 128; x++)
			assert_ok(deform_wake_block(ground.deform, (struct soil_block){x, y}));
	assert_ok(deform_active_blocks(ground.deform, &blocks, &count));
	assert_int_equal(count, DEFORM_BLOCKS_MAX);
	for (size_t i = 1; i < count; i++)
		assert_true(blocks[i].x != blocks[i - 1].x || blocks[i].y != blocks[i - 1].y);
	assert_ok(deform_wake_block(ground.deform, (struct soil_block){500, 3})); /* beyond the world */
	assert_ok(deform_active_blocks(ground.deform, &blocks, &count));
	assert_ok(deform_wake_block(ground.deform, (struct soil_block){128, 3}));
	assert_int_equal(deform_active_blocks(ground.deform, &blocks, &count), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "16384"));
	ground_finish(&ground);
}

TEST_PROGRAM(active)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(few_blocks_do_what_all_would),
		cmocka_unit_test(more_blocks_than_a_layer_holds_are_as_right),
		cmocka_unit_test(flags_that_come_late_change_nothing),
		cmocka_unit_test(what_an_object_rests_on_is_held),
		cmocka_unit_test(what_slid_out_of_an_object_slides_on),
		cmocka_unit_test(beside_a_block_that_sleeps_no_soil_is_lost),
		cmocka_unit_test(a_world_at_rest_makes_no_pass),
		cmocka_unit_test(more_blocks_than_there_may_be_are_refused),
	};
	return cmocka_run_group_tests_name("deform/active", tests, open_gpu, close_gpu);
}
