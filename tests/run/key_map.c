/* The table of tiles. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "run/key_map.h"

static void what_was_put_is_found_and_nothing_else(void **state)
{
	struct key_map map = {NULL, 0, 0};
	assert_null(key_map_find(&map, 7));
	for (uint64_t i = 0; i < 5000; i++)
		assert_int_equal(key_map_put(&map, tile_key((struct tile){(int)(i % 9) - 4, (uint32_t)i, 3}), (double)i, 1),
				 STATUS_OK);
	assert_int_equal(map.count, 5000);
	for (uint64_t i = 0; i < 5000; i++) {
		const struct key_pair *pair = key_map_find(&map, tile_key((struct tile){(int)(i % 9) - 4, (uint32_t)i, 3}));
		assert_non_null(pair);
		assert_true(pair->a == (double)i);
		assert_null(key_map_find(&map, tile_key((struct tile){(int)(i % 9) - 4, (uint32_t)i, 4})));
	}
	key_map_finish(&map);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_was_put_is_found_and_nothing_else),
	};
	return cmocka_run_group_tests_name("key_map", tests, NULL, NULL);
}
