/* Tables that lead to a body without looking at all: rectangles near a mirror, tags of forces. Each beside the plain loop that it replaces. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "world/internal.h"
#include "../support/program.h"

static uint32_t seed = 1;

static int64_t any(int64_t below)
{
	seed = seed * 1664525 + 1013904223;
	return (int64_t)(seed >> 8) % below;
}

static struct post_rect any_rect(int64_t width, int64_t height, int64_t longest)
{
	const int64_t x = any(width) - width / 2, y = any(height) - height / 2;
	return (struct post_rect){x, y, x + any(longest), y + any(longest)}; /* some are empty */
}

static void a_rectangle_meets_what_the_loop_finds(void **state)
{
	struct world_touched touched = {.count = 0};
	int met = 0;
	for (int round = 0; round < 60; round++) {
		const int64_t width = round % 3 == 0 ? 2000 : 60, height = round % 3 == 1 ? 2000 : 60;
		const size_t count = (size_t)any(40);
		struct post_rect rects[40];
		for (size_t i = 0; i < count; i++) {
			rects[i] = any_rect(width, height, 1 + any(80));
			world_touched_note(&touched, rects[i]);
		}
		world_touched_sort(&touched);
		for (int k = 0; k < 200; k++) {
			const struct post_rect rect = any_rect(width, height, 30);
			bool meets = false;
			for (size_t i = 0; i < count; i++)
				meets = meets || !post_rect_empty(post_rect_intersect(rects[i], rect));
			assert_int_equal(world_touched_meets(&touched, rect), meets);
			met += meets;
		}
		world_touched_clear(&touched);
	}
	assert_true(met > 1000 && met < 11000);
	world_touched_sort(&touched);
	assert_false(world_touched_meets(&touched, (struct post_rect){0, 0, 10, 10}));
	world_touched_free(&touched);
}

/* A tag is its body's, or is not in the table any more. The latest are. */
static void a_tag_leads_to_its_body(void **state)
{
	struct world_tags tags = {.first = 0};
	size_t body;
	assert_false(world_tags_find(&tags, 0, &body));
	for (uint64_t tag = 2; tag < 300000; tag++) {
		world_tags_add(&tags, tag, (size_t)(tag * 7 % 1000));
		assert_true(world_tags_find(&tags, tag, &body));
		assert_int_equal(body, tag * 7 % 1000);
		if (tag > 20000 && tag % 100 == 0) {
			assert_true(world_tags_find(&tags, tag - 19000, &body));
			assert_int_equal(body, (tag - 19000) * 7 % 1000);
		}
	}
	assert_false(world_tags_find(&tags, 300000, &body));
	assert_false(world_tags_find(&tags, 2, &body));
	assert_true(tags.room <= 131072);
	world_tags_add(&tags, 400000, 5); /* others were not asked */
	assert_false(world_tags_find(&tags, 299999, &body));
	assert_true(world_tags_find(&tags, 400000, &body));
	world_tags_free(&tags);
}

TEST_PROGRAM(touched)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_rectangle_meets_what_the_loop_finds),
		cmocka_unit_test(a_tag_leads_to_its_body),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
