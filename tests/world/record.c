/* What a drive goes on from: it comes back to the bit, and what is not whole is refused. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "bearing/bearing.h"
#include "world/record.h"
#include "../support/program.h"

#define SUM_MOST (INT64_MAX / 4)

static char left[] = "left", odd[] = "a \"b\" \\ c", right[] = "right";
static struct scene_object two[] = {{.name = left}, {.name = odd}};
static const struct scene scene = {.objects = two, .object_count = 2};

static const struct record_object objects[] = {
	{.next = INT64_MAX, .has_last = true,
	 .last = {INT64_MIN, INT64_MAX, -1, 0.1, -DBL_MIN / 4, 1 / 3.0, -2 / 3.0},
	 .distance = DBL_MAX, .sinkage = -0.0, .skipped = INT64_MAX,
	 .force = {{0.1, -0.0, DBL_MIN / 4}, {DBL_MAX, -1 / 3.0, 3}, 1e-300, 2 / 3.0, 1 / 7.0, 1 / 11.0, 0, 0, INT64_MIN, DEFORM_TOUCHING}},
	{.next = (INT64_C(1) << 53) + 1, .has_last = false,
	 .last = {(INT64_C(1) << 53) + 1, -(INT64_C(1) << 53) - 1, 0, -M_PI, 4.9406564584124654e-324, 1e300, DBL_EPSILON},
	 .distance = 1 + DBL_EPSILON, .sinkage = -1e-17, .skipped = 3},
};

static struct record *room(void)
{
	struct record *record = calloc(1, world_record_bytes(2));
	assert_non_null(record);
	return record;
}

static char *printed(void)
{
	struct record *record = room();
	record->level = -3;
	record->law = 7;
	record->ended = true;
	memcpy(record->objects, objects, sizeof objects);
	record->active_count = 2;
	record->active[0] = (struct soil_block){3, 4};
	record->active[1] = (struct soil_block){INT64_C(1) << 33, 0};
	char *text = world_record_print(record, &scene, &(struct pages_sums){-SUM_MOST, SUM_MOST, SUM_MOST - 1, 5, SUM_MOST, 0, 77, 0});
	assert_non_null(text);
	free(record);
	return text;
}

static enum status parse(const char *state, int64_t step, double time, const struct scene *of, struct record *record)
{
	struct store_run run = {.scene_hash = "abc", .step = step, .time = time, .state = state};
	return world_record_parse(&run, "some.furrow", of, record);
}

static bool same_real(double a, double b)
{
	return memcmp(&a, &b, sizeof a) == 0;
}

static void it_comes_back_to_the_bit(void **state)
{
	char *text = printed();
	struct record *record = room();
	assert_int_equal(parse(text, 7, 0.1, &scene, record), STATUS_OK);
	assert_true(record->step == 7 && same_real(record->time, 0.1) && record->level == -3 && record->ended);
	assert_true(record->sums.below == -SUM_MOST && record->sums.above == SUM_MOST &&
		    record->sums.compacted == SUM_MOST - 1 && record->sums.sunk == 5 && record->sums.slid == SUM_MOST);
	assert_true(record->sums.carried == 77 && record->sums.in_flight == 0 && record->sums.added == 0);
	assert_true(record->active_count == 2 && record->active[0].x == 3 && record->active[0].y == 4);
	assert_true(record->active[1].x == INT64_C(1) << 33 && record->active[1].y == 0);
	for (int i = 0; i < 2; i++) {
		const struct record_object *a = &record->objects[i], *b = &objects[i];
		assert_true(a->next == b->next && a->has_last == b->has_last && a->skipped == b->skipped);
		assert_true(a->last.x == b->last.x && a->last.y == b->last.y && a->last.z == b->last.z);
		assert_true(same_real(a->last.yaw, b->last.yaw) && same_real(a->last.pitch, b->last.pitch) &&
			    same_real(a->last.roll, b->last.roll) && same_real(a->last.turn, b->last.turn));
		assert_memory_equal(&a->force, &b->force, sizeof a->force);
		assert_true(same_real(a->distance, b->distance) && same_real(a->sinkage, b->sinkage));
	}
	free(record);
	mem_free(text);
}

static void refused(const char *text, int64_t step, double time, const struct scene *of)
{
	/* Read into what has just the room it needs. */
	struct record *record = calloc(1, world_record_bytes(of->object_count));
	assert_non_null(record);
	assert_int_equal(parse(text, step, time, of, record), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "some.furrow: "));
	assert_non_null(strstr(failure_message(), "without --resume"));
	free(record);
}

static void another_scene_s_objects_are_refused(void **state)
{
	struct scene_object other[] = {{.name = left}, {.name = right}, {.name = odd}}, turned[] = {{.name = odd}, {.name = left}};
	char *text = printed();
	refused(text, 1, 1, &(struct scene){.objects = other, .object_count = 2});
	refused(text, 1, 1, &(struct scene){.objects = turned, .object_count = 2});
	refused(text, 1, 1, &(struct scene){.objects = other, .object_count = 3});
	refused(text, 1, 1, &(struct scene){.objects = other, .object_count = 1});
	refused(text, 1, 1, &(struct scene){.object_count = 0});
	mem_free(text);
}

static void steps_and_times_that_are_none_are_refused(void **state)
{
	char *text = printed();
	refused(text, -1, 1, &scene);
	refused(text, 1, -1, &scene);
	refused(text, 1, INFINITY, &scene);
	refused(text, 1, NAN, &scene);
	mem_free(text);
}

/* Each replaces the first `from` of a good record. */
static void any_value_that_is_not_what_it_must_be_is_refused(void **state)
{
	static const struct { const char *from, *to; } changes[] = {
		{"\"version\":3", "\"version\":2"}, {"\"version\":3", "\"version\":\"3\""}, {"\"version\":3,", ""},
		{"\"law\":\"", "\"law\":\"-"}, {"\"law\":\"", "\"law\":\"99999999999"}, {"\"law\":\"", "\"law\":\"x"},
		{"\"level\":\"-3\"", "\"level\":-3"}, {"\"-3\"", "\"-15\""}, {"\"-3\"", "\"29\""}, {"\"-3\"", "\"\""},
		{"\"-3\"", "\"-\""}, {"\"-3\"", "\" -3\""}, {"\"-3\"", "\"-3x\""}, {"\"-3\"", "null"},
		{"\"ended\":true", "\"ended\":1"}, {"\"ended\":true", "\"ended\":\"true\""}, {"\"ended\"", "\"Ended\""},
		{"\"9223372036854775807\"", "\"9223372036854775808\""}, {"\"above\"", "\"about\""},
		{"\"-9223372036854775808\"", "\"-9223372036854775809\""}, {"\"below\"", "\"b\""},
		{"\"above\":\"2305843009213693951\"", "\"above\":\"2305843009213693952\""},
		{"\"above\":\"2", "\"above\":\"-3"}, {"\"below\":\"-2305843009213693951\"", "\"below\":\"-2305843009213693952\""},
		{"\"below\":\"-2", "\"below\":\"3"}, {"\"compacted\":\"2", "\"compacted\":\"3"},
		{"\"compacted\":\"2", "\"compacted\":\"-3"}, {"\"compacted\"", "\"compact\""},
		{"\"sunk\":\"5\"", "\"sunk\":\"-1\""}, {"\"sunk\":\"5\"", "\"sunk\":5"}, {"\"slid\"", "\"slides\""}, {"\"slid\":\"2", "\"slid\":\"3"},
		{"\"carried\":\"77\"", "\"carried\":\"-1\""}, {"\"carried\":\"77\"", "\"carried\":77"}, {"\"carried\":\"77\"", "\"carried\":\"2305843009213693952\""},
		{"\"state\":\"0\"", "\"state\":\"4\""}, {"\"state\":\"0\"", "\"state\":\"-1\""}, {"\"state\"", "\"stated\""},
		{"\"awake\"", "\"asleep\""}, {"\"3,4;", "\"3,4"}, {"\"3,4;", "\"3;4,"}, {"\"3,4;", "\"-3,4;"}, {"\"3,4;", "\"3,;"},
		{"\"3,4;", "\"3,4;;"}, {"\"3,4;", "\"9223372036854775808,4;"}, {"\"awake\":\"", "\"awake\":[\"\"],\"a\":\""},
		{"\"objects\":[", "\"objects\":[{},"}, {"\"objects\":[{", "\"objects\":[[],{"}, {"\"objects\"", "\"things\""},
		{"\"name\":\"left\"", "\"name\":\"right\""}, {"\"name\":\"left\"", "\"name\":3"},
		{"\"next\":\"9223372036854775807\"", "\"next\":\"-1\""}, {"\"next\":\"9223372036854775807\"", "\"next\":\"1\""},
		{"\"next\":\"9", "\"next\":\"9.0"}, {"\"in_contact\":true", "\"in_contact\":null"},
		{"\"x\":", "\"X\":"}, {"\"y\":\"", "\"y\":\"0x"}, {"\"z\":\"-1\"", "\"z\":\"1e3\""}, {"\"z\":\"-1\"", "\"z\":[]"},
		{"\"yaw\":\"0x1.", "\"yaw\":\"nan"}, {"\"yaw\":\"0x", "\"yaw\":\"0x1p99999"}, {"\"yaw\":\"0x", "\"yaw\":\" 0x"},
		{"\"pitch\":\"", "\"pitch\":\"inf"}, {"\"roll\":\"0x1", "\"roll\":\"0y1"}, {"\"roll\":", "\"rolls\":"},
		{"\"distance\":\"", "\"distance\":\"-"}, {"\"distance\":\"0x1.fffffffffffffp+1023\"", "\"distance\":\"0x1p+1024\""},
		{"\"sinkage\":\"-0x0p+0\"", "\"sinkage\":0"}, {"\"sinkage\":\"-0x0p+0\"", "\"sinkage\":\"\""},
		{"\"skipped\":\"9223372036854775807\"", "\"skipped\":\"-1\""}, {"\"skipped\":\"3\"", "\"skipped\":\"9007199254740994\""},
		{"}]}", "}]}x"}, {"}]}", "}]"}, {"{", "["},
	};
	char *text = printed();
	for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
		char changed[4096];
		const char *at = strstr(text, changes[i].from);
		if (at == NULL)
			fail_msg("no %s in %s", changes[i].from, text);
		snprintf(changed, sizeof changed, "%.*s%s%s", (int)(at - text), text, changes[i].to,
			 at + strlen(changes[i].from));
		refused(changed, 1, 1, &scene);
	}
	for (const char *other[] = {"", "null", "[]", "{}", "1", "{\"version\":3}", NULL}, **at = other; *at != NULL; at++)
		refused(*at, 1, 1, &scene);
	mem_free(text);
}

static void a_record_cut_short_anywhere_is_refused(void **state)
{
	char *text = printed();
	for (size_t length = strlen(text); length-- > 0;) {
		text[length] = '\0';
		refused(text, 1, 1, &scene);
	}
	mem_free(text);
}

static void as_many_blocks_as_may_be_awake_and_no_more(void **state)
{
	struct record *record = room();
	record->active_count = DEFORM_BLOCKS_MAX;
	for (int64_t i = 0; i < DEFORM_BLOCKS_MAX; i++)
		record->active[i] = (struct soil_block){i, INT64_MAX - i};
	memcpy(record->objects, objects, sizeof objects);
	char *text = world_record_print(record, &scene, &(struct pages_sums){.below = 0}), *more, *at;
	struct record *read = room();
	assert_int_equal(parse(text, 1, 1, &scene, read), STATUS_OK);
	assert_int_equal(read->active_count, DEFORM_BLOCKS_MAX);
	assert_memory_equal(read->active, record->active, sizeof read->active);
	/* One more. */
	more = malloc(strlen(text) + 8);
	at = strstr(text, "\"awake\":\"");
	assert_true(more != NULL && at != NULL);
	at += strlen("\"awake\":\"");
	sprintf(more, "%.*s1,1;%s", (int)(at - text), text, at);
	assert_int_equal(parse(more, 1, 1, &scene, read), STATUS_INPUT);
	free(more);
	free(read);
	free(record);
	mem_free(text);
}

#define GRAINS 3

static struct record *with_grains(const int *order)
{
	struct record sized = {.thrown = {.room = GRAINS}};
	struct record *record = calloc(1, world_record_bytes_of(&sized, 2));
	assert_non_null(record);
	record->thrown.room = GRAINS;
	memcpy(record->objects, objects, sizeof objects);
	for (int i = 0; order != NULL && i < GRAINS; i++)
		world_record_grains(record, 2)[i] = (struct bearing_grain){.from = {5, order[i] % 2, 9}, .since = 11, .volume = 100 + order[i], .velocity = {-order[i], 0, 1}};
	record->thrown.count = order != NULL ? GRAINS : 0;
	return record;
}

static void the_order_of_grains_does_not_show(void **state)
{
	(void)state;
	static const int orders[][GRAINS] = {{0, 1, 2}, {2, 0, 1}, {1, 2, 0}};
	char *texts[3];
	for (int i = 0; i < 3; i++) {
		struct record *record = with_grains(orders[i]);
		assert_int_equal(world_record_in_flight(record, 2), 303);
		texts[i] = world_record_print(record, &scene, &(struct pages_sums){.in_flight = 303});
		assert_string_equal(texts[i], texts[0]);
		free(record);
	}
	struct record *read = with_grains(NULL);
	assert_int_equal(parse(texts[0], 1, 1, &scene, read), STATUS_OK);
	assert_int_equal(read->thrown.count, GRAINS);
	assert_int_equal(read->sums.in_flight, 303);
	free(read);
	for (int i = 0; i < 3; i++)
		mem_free(texts[i]);
}

TEST_PROGRAM(record)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(it_comes_back_to_the_bit),
		cmocka_unit_test(the_order_of_grains_does_not_show),
		cmocka_unit_test(as_many_blocks_as_may_be_awake_and_no_more),
		cmocka_unit_test(another_scene_s_objects_are_refused),
		cmocka_unit_test(steps_and_times_that_are_none_are_refused),
		cmocka_unit_test(any_value_that_is_not_what_it_must_be_is_refused),
		cmocka_unit_test(a_record_cut_short_anywhere_is_refused),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
