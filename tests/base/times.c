/* The histogram of times against all of them, sorted. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <cmocka.h>

#include "base/times.h"
#include "../support/program.h"

static int by_size(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

static double uniform(uint64_t *state)
{
	*state = *state * 6364136223846793005u + 1442695040888963407u;
	return (double)(*state >> 11) * 0x1p-53;
}

enum { MOST = 20000 };
static const double shares[] = {0, 0.001, 0.01, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95, 0.99, 0.999, 1};

static void compare(double *values, size_t count)
{
	static struct times times;
	double sum = 0;
	times = (struct times){.count = 0};
	for (size_t i = 0; i < count; i++) {
		times_add(&times, values[i]);
		sum += values[i];
	}
	qsort(values, count, sizeof *values, by_size);
	assert_true(times.count == count && times.least == values[0] && times.most == values[count - 1]);
	assert_true(times_mean(&times) == sum / (double)count);
	assert_true(times_percentile(&times, 0) == values[0] && times_percentile(&times, 1) == values[count - 1]);
	for (size_t i = 0; i < sizeof shares / sizeof *shares; i++) {
		double exact = values[(size_t)(shares[i] * (double)(count - 1) + 0.5)];
		assert_true(fabs(times_percentile(&times, shares[i]) - exact) <= TIMES_ERROR * exact * (1 + 1e-12));
	}
}

/* A machine's clock that goes back: no time, and the others stay what they are. */
static void a_time_below_zero_counts_as_none(void **state)
{
	static struct times times;
	times_add(&times, 2);
	times_add(&times, -1e8);
	assert_true(times.count == 2 && times.least == 0 && times.most == 2 && times.sum == 2);
}

static void percentiles_are_within_the_error_of_the_sorted_ones(void **state)
{
	static double values[MOST];
	uint64_t random = 5;
	const size_t counts[] = {1, 2, 3, 10, 101, 4096, MOST};
	for (size_t c = 0; c < sizeof counts / sizeof *counts; c++)
		for (int shape = 0; shape < 4; shape++) {
			for (size_t i = 0; i < counts[c]; i++) {
				double u = uniform(&random);
				values[i] = shape == 0	 ? u
					    : shape == 1 ? 3 - log(1 - u) * 2                 /* a tail */
					    : shape == 2 ? exp2(-13.9 + 39.8 * u)             /* all there are */
							 : u < 0.98 ? 0.7 : 40 * (1 + u);     /* and some stalls */
			}
			compare(values, counts[c]);
		}
}

static void every_value_is_within_the_error_alone(void **state)
{
	static struct times times;
	uint64_t random = 11;
	for (int i = 0; i < 5000; i++) {
		/* At, just below and between the edges of parts. */
		double value = TIMES_LEAST * ldexp(1 + (double)(i % TIMES_PARTS) / TIMES_PARTS, i % TIMES_OCTAVES);
		value = i % 3 == 0 ? value : i % 3 == 1 && i % TIMES_OCTAVES > 0 ? nextafter(value, 0) : value * (1 + uniform(&random) / 300);
		/* The two others hold the ends. */
		times = (struct times){.count = 0};
		times_add(&times, 0);
		times_add(&times, value);
		times_add(&times, 1e9);
		assert_true(fabs(times_percentile(&times, 0.5) - value) <= TIMES_ERROR * value * (1 + 1e-12));
	}
}

static void what_lies_beyond_the_buckets_is_counted_at_their_ends(void **state)
{
	static struct times times;
	assert_true(isnan(times_mean(&times)) && isnan(times_percentile(&times, 0.5)));
	const double values[] = {0, 1e-300, TIMES_LEAST / 2, TIMES_MOST, 1e30, 1e300};
	for (int i = 0; i < 6; i++)
		times_add(&times, values[i]);
	assert_true(times_percentile(&times, 0) == 0 && times_percentile(&times, 1) == 1e300);
	assert_true(times_mean(&times) > 1e299);
	assert_true(fabs(times_percentile(&times, 0.2) - TIMES_LEAST) <= 2 * TIMES_ERROR * TIMES_LEAST);
	assert_true(fabs(times_percentile(&times, 0.8) - TIMES_MOST) <= 2 * TIMES_ERROR * TIMES_MOST);
	/* No percentile leaves the values there are. */
	times = (struct times){.count = 0};
	for (int i = 0; i < 9; i++)
		times_add(&times, 7.003);
	for (size_t i = 0; i < sizeof shares / sizeof *shares; i++)
		assert_true(times_percentile(&times, shares[i]) == 7.003);
}

static void the_slow_end_is_not_lost_among_the_many(void **state)
{
	static struct times times;
	for (int64_t i = 0; i < 1000000; i++)
		times_add(&times, i % 100 == 99 ? 250 : 1);
	assert_true(times_percentile(&times, 0.5) < 1.01 && times_percentile(&times, 0.98) < 1.01);
	assert_true(times_percentile(&times, 0.995) > 249);
}

/* --- ranges --- */

struct told {
	double first, last; /* edges */
	uint64_t count;
	int ranges;
	double values[4]; /* sought within the ranges */
	uint64_t found;
};

static void take_range(void *user, double from, double to, uint64_t count)
{
	struct told *told = user;
	assert_true(from < to && (told->ranges == 0 || from == told->last));
	told->first = told->ranges++ == 0 ? from : told->first;
	told->last = to;
	told->count += count;
	uint64_t inside = 0;
	for (int i = 0; i < 4; i++)
		inside += told->values[i] >= from && told->values[i] < to ? 1 : 0;
	assert_int_equal(count, inside);
	told->found += inside;
}

static void ranges_follow_each_other_and_hold_every_value(void **state)
{
	static const double lists[][4] = {{0.4, 0.5, 3, 1000}, {1, 1, 1, 1}, {0.0999, 0.1, 0.1001, 0.11}, {2, 2.5, 3, 3.5}};
	for (size_t k = 0; k < sizeof lists / sizeof *lists; k++)
		for (int parts = 1; parts <= TIMES_PARTS; parts *= 2) {
			static struct times times;
			struct told told = {.ranges = 0};
			times = (struct times){.count = 0};
			for (int i = 0; i < 4; i++) {
				told.values[i] = lists[k][i];
				times_add(&times, lists[k][i]);
			}
			times_ranges(&times, parts, take_range, &told);
			assert_int_equal(told.count, 4);
			assert_int_equal(told.found, 4);
			assert_true(told.first <= lists[k][0] && told.last > lists[k][3]);
			/* No empty range at either end. */
			assert_true(told.first * (1 + 1.0 / parts) * (1 + 1e-12) > lists[k][0] && told.last <= lists[k][3] * (1 + 1.0 / parts) * (1 + 1e-12));
		}
	static struct times none;
	struct told told = {.ranges = 0};
	times_ranges(&none, 4, take_range, &told);
	assert_int_equal(told.ranges, 0);
}

TEST_PROGRAM(times)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_time_below_zero_counts_as_none),
		cmocka_unit_test(percentiles_are_within_the_error_of_the_sorted_ones),
		cmocka_unit_test(every_value_is_within_the_error_alone),
		cmocka_unit_test(what_lies_beyond_the_buckets_is_counted_at_their_ends),
		cmocka_unit_test(the_slow_end_is_not_lost_among_the_many),
		cmocka_unit_test(ranges_follow_each_other_and_hold_every_value),
	};
	return cmocka_run_group_tests_name("times", tests, NULL, NULL);
}
