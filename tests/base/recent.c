#include "base/recent.h"
#include "../support/program.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { MOST = 40, KEYS = 64 };

/* The obvious one: looks at every place. */
struct plain {
	uint64_t keys[MOST], used[MOST], clock; /* used 0: empty */
	uint32_t count;
};

static uint32_t find(const struct plain *plain, uint64_t key)
{
	for (uint32_t i = 0; i < plain->count; i++)
		if (plain->used[i] != 0 && plain->keys[i] == key)
			return i;
	return RECENT_NONE;
}

/* Returns true if that place may be given: it is empty, or no other is empty or was used before. */
static bool may_go(const struct plain *plain, uint32_t place, uint32_t spared)
{
	for (uint32_t i = 0; i < plain->count; i++)
		if (i != spared && plain->used[i] < plain->used[place])
			return false;
	return place != spared;
}

static void check(const struct recent *recent, const struct plain *plain)
{
	for (uint64_t key = 0; key < KEYS; key++)
		assert_int_equal(recent_find(recent, key << 40), find(plain, key << 40));
	for (uint32_t spared = 0; spared <= plain->count; spared++) {
		const uint32_t without = spared < plain->count ? spared : RECENT_NONE, place = recent_oldest(recent, without);
		if (plain->count == 1 && without == 0)
			assert_int_equal(place, RECENT_NONE);
		else
			assert_true(place < plain->count && may_go(plain, place, without));
	}
}

static void it_finds_and_gives_places_as_one_that_looks_at_all(void **state)
{
	static const uint32_t counts[] = {1, 2, 3, 17, MOST};
	uint64_t luck = 1;
	(void)state;
	for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
		struct plain plain = {.count = counts[i]};
		struct recent recent;
		assert_int_equal(recent_create(&recent, counts[i]), STATUS_OK);
		for (int turn = 0; turn < 600; turn++) {
			luck = luck * 6364136223846793005u + 1442695040888963407u;
			const uint64_t key = (luck >> 33) % KEYS << 40;
			uint32_t place = recent_find(&recent, key);
			if (turn % 7 == 6 && place != RECENT_NONE) {
				recent_empty(&recent, place);
				plain.used[place] = 0;
				recent_empty(&recent, place);
			} else {
				if (place == RECENT_NONE)
					place = recent_oldest(&recent, RECENT_NONE);
				recent_use(&recent, place, key);
				plain.keys[place] = key;
				plain.used[place] = ++plain.clock;
			}
			if (turn == 300 && counts[i] < MOST) {
				assert_int_equal(recent_grow(&recent, counts[i] + 1), STATUS_OK);
				plain.count++;
			}
			check(&recent, &plain);
		}
		recent_finish(&recent);
	}
}

TEST_PROGRAM(recent)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(it_finds_and_gives_places_as_one_that_looks_at_all)};
	return cmocka_run_group_tests_name("recent", tests, NULL, NULL);
}
