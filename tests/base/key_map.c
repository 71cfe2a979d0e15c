/* The table of tiles. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "base/key_map.h"
#include "base/key_set.h"
#include "../support/program.h"

static void what_was_put_is_found_and_nothing_else(void **state)
{
	struct key_map map = {.room = 0};
	assert_null(key_map_find(&map, 7));
	for (uint64_t i = 0; i < 5000; i++)
		assert_int_equal(key_map_put(&map, tile_key((struct tile){(int)(i % 9) - 4, (uint32_t)i, 3}), (double)i, 1),
				 STATUS_OK);
	assert_int_equal(map.keys.count, 5000);
	for (uint64_t i = 0; i < 5000; i++) {
		const struct key_pair *pair = key_map_find(&map, tile_key((struct tile){(int)(i % 9) - 4, (uint32_t)i, 3}));
		assert_non_null(pair);
		assert_true(pair->a == (double)i);
		assert_null(key_map_find(&map, tile_key((struct tile){(int)(i % 9) - 4, (uint32_t)i, 4})));
	}
	key_map_finish(&map);
}

static void a_cache_of_them_stays_small_and_keeps_what_is_asked_for(void **state)
{
	struct key_cache cache = {.most = 100};
	struct key_pair pair;
	bool found;
	size_t lost = 0;
	for (uint64_t i = 0; i < 20000; i++) {
		assert_int_equal(key_cache_put(&cache, i, (double)i, 1), STATUS_OK);
		/* Number 0 is asked for again and again; number i - 40 once. */
		assert_int_equal(key_cache_find(&cache, 0, &pair, &found), STATUS_OK);
		assert_true(found && pair.a == 0);
		if (i >= 40) {
			assert_int_equal(key_cache_find(&cache, i - 40, &pair, &found), STATUS_OK);
			assert_true(found && pair.a == (double)(i - 40) && pair.b == 1);
		}
		if (i >= 1000) {
			assert_int_equal(key_cache_find(&cache, i - 500, &pair, &found), STATUS_OK);
			lost += !found;
		}
		assert_true(cache.young.keys.count <= 100 && cache.old.keys.count <= 100 && cache.young.room + cache.old.room <= 1024);
	}
	assert_int_equal(lost, 19000);
	key_cache_finish(&cache);
}

static void a_set_has_what_was_added_until_it_is_cleared(void **state)
{
	struct key_set set = {.count = 0};
	uint32_t number;
	bool fresh;
	assert_false(key_set_has(&set, 7));
	key_set_clear(&set);
	for (int round = 0; round < 2; round++) {
		for (uint64_t i = 0; i < 5000; i++) {
			uint64_t key = tile_key((struct tile){(int)(i % 9) - 4, (uint32_t)i, 3});
			assert_false(key_set_has(&set, key));
			assert_int_equal(key_set_add(&set, key), STATUS_OK);
			assert_int_equal(key_set_add(&set, key), STATUS_OK);
			assert_true(key_set_has(&set, key) && key_set_find(&set, key, &number) && number == i);
			assert_int_equal(key_set_number(&set, key, &number, &fresh), STATUS_OK);
			assert_true(number == i && !fresh);
		}
		assert_false(key_set_find(&set, tile_key((struct tile){0, 0, 9}), &number));
		assert_int_equal(set.count, 5000);
		assert_int_equal(set.room, 8192);
		key_set_clear(&set);
		assert_int_equal(set.count, 0);
	}
	/* What room was made for is added without more. */
	assert_int_equal(key_set_reserve(&set, 20000), STATUS_OK);
	mem_fail_nth(1, 0);
	for (uint64_t i = 0; i < 20000; i++)
		key_set_put(&set, i);
	mem_fail_nth(0, 0);
	assert_int_equal(set.count, 20000);
	key_set_finish(&set);
}

TEST_PROGRAM(key_map)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_was_put_is_found_and_nothing_else),
		cmocka_unit_test(a_cache_of_them_stays_small_and_keeps_what_is_asked_for),
		cmocka_unit_test(a_set_has_what_was_added_until_it_is_cleared),
	};
	return cmocka_run_group_tests_name("key_map", tests, NULL, NULL);
}
