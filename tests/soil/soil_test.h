/* What the tests of soil share: cmocka, random numbers that are the same in every run. */
#ifndef FURROW_TESTS_SOIL_TEST_H
#define FURROW_TESTS_SOIL_TEST_H

#include "../support/near.h"
#include "soil/soil.h"

#define assert_ok(call)                                                                            \
	do {                                                                                       \
		if ((call) != STATUS_OK)                                                           \
			fail_msg("%s", failure_message());                                         \
	} while (0)

static uint32_t test_seed = 1;
static inline uint32_t any_word(void)
{
	test_seed = test_seed * 1664525u + 1013904223u;
	const uint32_t high = test_seed >> 16;
	test_seed = test_seed * 1664525u + 1013904223u;
	return high << 16 | test_seed >> 16;
}

/* -1 .. 1 */
static inline double any_share(void)
{
	return (double)any_word() / 2147483648.0 - 1;
}

#endif
