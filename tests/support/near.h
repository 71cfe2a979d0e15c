/*
 * Comparisons of doubles that a NaN never passes. cmocka's own compare floats, and a NaN passes them: tests/house forbids those.
 * fmax and fmin drop a NaN: where a test gathers an extreme, support_most and support_least keep it, and no comparison with it holds.
 */
#ifndef FURROW_TESTS_SUPPORT_NEAR_H
#define FURROW_TESTS_SUPPORT_NEAR_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <cmocka.h>

/* Fails unless `actual` is `expected`, or within `tolerance` of it. A NaN in any of the three fails, and so does an infinity that is
 * not expected. Says both values. */
#define assert_near(actual, expected, tolerance) support_near(actual, expected, tolerance, #actual, __FILE__, __LINE__)

/* Returns whether a value is as near as assert_near asks for. */
static inline bool support_is_near(double actual, double expected, double tolerance)
{
	return (actual == expected && tolerance >= 0) || fabs(actual - expected) <= tolerance;
}

static inline void support_near(double actual, double expected, double tolerance, const char *what, const char *file, int line)
{
	if (support_is_near(actual, expected, tolerance))
		return;
	print_error("%s is %.17g, not %.17g within %g\n", what, actual, expected, tolerance);
	_fail(file, line);
}

/* The larger of two values; NaN if one of them is. */
static inline double support_most(double most, double value)
{
	return isnan(most) || most > value ? most : value;
}

/* The smaller of two values; NaN if one of them is. */
static inline double support_least(double least, double value)
{
	return isnan(least) || least < value ? least : value;
}

#endif
