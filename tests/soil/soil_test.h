/* What the tests of soil share: cmocka, random numbers that are the same in every run, soils by name. */
#ifndef FURROW_TESTS_SOIL_TEST_H
#define FURROW_TESTS_SOIL_TEST_H

#include <math.h>

#include "../support/near.h"
#include "soil/soil.h"

#define DEGREES (M_PI / 180)
#define COUNT(a) (sizeof(a) / sizeof *(a))

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

static inline struct soil_numbers bed_soil(const char *name)
{
	struct soil_numbers soil;
	assert_ok(soil_named(name, &soil));
	return soil;
}

/* Project Chrono's soft soil. */
static inline struct soil_numbers bed_soft(void)
{
	struct soil_numbers soil = bed_soil("dry_sand");
	soil.bekker_kc = soil.cohesion = 0;
	soil.bekker_kphi = 0.2e6;
	soil.bekker_n = 1.1;
	soil.friction_angle = 30 * DEGREES;
	soil.janosi_shear = 0.01;
	return soil;
}

#endif
