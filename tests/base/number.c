/* Numbers that a user types again: what is read back is the number, or lies on the side that was asked for. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "base/number.h"
#include "../support/program.h"

static double back(struct number_text number)
{
	char *end;
	double value = strtod(number.text, &end);
	assert_true(*end == '\0' && end > number.text);
	return value;
}

static double any(uint64_t *state)
{
	*state = *state * 6364136223846793005u + 1442695040888963407u;
	const double mantissa = (double)(*state >> 11) * 0x1p-53;
	*state = *state * 6364136223846793005u + 1442695040888963407u;
	return ldexp(mantissa + 0.5, (int)(*state >> 58) - 32) * (*state & 1 ? 1 : -1);
}

static void exact_numbers_are_read_back_with_few_digits(void **state)
{
	uint64_t random = 3;
	for (int i = 0; i < 20000; i++) {
		const double value = any(&random);
		assert_true(back(number_exact(value)) == value);
	}
	assert_string_equal(number_exact(0.1).text, "0.1");
	assert_string_equal(number_exact(0.25 / 1024).text, "0.000244140625");
	assert_string_equal(number_exact(0.012207031250).text, "0.01220703125");
	assert_string_equal(number_exact(0).text, "0");
}

static void rounded_numbers_lie_on_their_side_and_within_a_digit(void **state)
{
	uint64_t random = 9;
	for (int i = 0; i < 20000; i++) {
		const double value = any(&random);
		const int digits = 1 + i % 12;
		const double least = back(number_at_least(value, digits)), most = back(number_at_most(value, digits));
		const double unit = pow(10, floor(log10(fabs(value))) - digits + 1);
		assert_true(most <= value && value <= least);
		assert_true(least - value < unit * (1 + 1e-9) && value - most < unit * (1 + 1e-9));
	}
	assert_string_equal(number_at_most(0.12496, 3).text, "0.124");
	assert_string_equal(number_at_least(0.12434, 3).text, "0.125");
	assert_string_equal(number_at_most(0.125, 3).text, "0.125");
	assert_string_equal(number_at_least(0.125, 3).text, "0.125");
	assert_string_equal(number_at_least(9.996, 3).text, "10");
	assert_string_equal(number_at_most(9.996, 3).text, "9.99");
	assert_string_equal(number_at_most(INFINITY, 3).text, "inf");
}

TEST_PROGRAM(number)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(exact_numbers_are_read_back_with_few_digits),
		cmocka_unit_test(rounded_numbers_lie_on_their_side_and_within_a_digit),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
