/* What tests compare doubles with: a NaN is near nothing, and stays where an extreme is gathered. */
#include "../support/near.h"
#include "../support/program.h"

static void a_nan_is_near_nothing(void **state)
{
	assert_true(support_is_near(1, 1, 0) && support_is_near(1, 1.5, 0.5) && support_is_near(-1, -1 - 1e-13, 1e-12));
	assert_true(support_is_near(INFINITY, INFINITY, 0) && support_is_near(0, -0.0, 0));
	assert_false(support_is_near(NAN, NAN, 1) || support_is_near(NAN, 0, INFINITY) || support_is_near(0, NAN, 1) || support_is_near(0, 0.5, NAN));
	assert_false(support_is_near(INFINITY, -INFINITY, 1e300) || support_is_near(INFINITY, 1, 1e300) || support_is_near(1, 1, -1));
	/* No float holds these apart. */
	assert_false(support_is_near(1, 1 + 1e-9, 1e-10) || support_is_near(123456789, 123456789.5, 0.25));
}

static void an_extreme_keeps_a_nan(void **state)
{
	assert_true(support_most(1, 2) == 2 && support_most(2, 1) == 2 && support_least(1, 2) == 1 && support_least(2, 1) == 1);
	assert_true(support_most(-INFINITY, -5) == -5 && support_least(INFINITY, 5) == 5);
	assert_true(isnan(support_most(NAN, 1)) && isnan(support_most(1, NAN)) && isnan(support_least(NAN, 1)) && isnan(support_least(1, NAN)));
}

TEST_PROGRAM(near)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_nan_is_near_nothing),
		cmocka_unit_test(an_extreme_keeps_a_nan),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
