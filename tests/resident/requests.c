/* Wishes: each key once, at its soonest, soonest first, however many were added in whatever order. */
#include <stdarg.h>
#include <setjmp.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "resident/look_ahead.h"
#include "../support/program.h"

static void wishes_come_out_soonest_first_and_once(void **state)
{
	(void)state;
	struct requests requests = {.requests = NULL};
	const uint64_t *keys;
	assert_int_equal(resident_requests_order(&requests, &keys), 0);
	const struct { uint64_t key; double time; } added[] = {{7, 3}, {9, 1}, {7, 2}, {4, 2}, {9, 5}, {1, 2}};
	for (size_t i = 0; i < sizeof added / sizeof *added; i++)
		assert_int_equal(resident_requests_add(&requests, added[i].key, added[i].time), STATUS_OK);
	const uint64_t expected[] = {9, 7, 4, 1}; /* 7, 4 and 1 at once: as they were added */
	assert_int_equal(resident_requests_order(&requests, &keys), 4);
	assert_memory_equal(keys, expected, sizeof expected);
	resident_requests_clear(&requests);
	assert_int_equal(resident_requests_order(&requests, &keys), 0);
	for (uint64_t i = 0; i < 1000; i++)
		assert_int_equal(resident_requests_add(&requests, i % 300, (double)(1000 - i)), STATUS_OK);
	assert_int_equal(resident_requests_order(&requests, &keys), 300);
	for (size_t i = 0; i < 300; i++) /* the soonest of key k is its last */
		assert_int_equal(keys[i], (999 - i) % 300);
	resident_requests_finish(&requests);
}

TEST_PROGRAM(requests)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(wishes_come_out_soonest_first_and_once),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
