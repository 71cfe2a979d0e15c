/* Marks that fade: the shades that are left are those of the closed form, at every rate and time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <cmocka.h>

#include "base/plane.h"
#include "../support/program.h"

static const int32_t rates[] = {PLANE_MARK_MOST, 256, 399, 4000, 345600, 31557600, PLANE_WHOLE_MOST};
static const int32_t times[] = {0, 1, 17, 1 << 20, PLANE_TIME_MOST};

static void a_new_mark_has_its_shades(void **state)
{
	(void)state;
	for (size_t r = 0; r < sizeof rates / sizeof *rates; r++)
		for (size_t t = 0; t < sizeof times / sizeof *times; t++)
			for (int32_t shades = 0; shades <= PLANE_MARK_MOST; shades++)
				assert_int_equal(plane_mark_left(plane_mark(times[t], shades, rates[r]), times[t], rates[r]), shades);
}

/* Compares with fractions: shades - PLANE_MARK_MOST age / whole, rounded down but for what rounding up the end adds. */
static void it_fades_evenly(void **state)
{
	(void)state;
	for (size_t r = 0; r < sizeof rates / sizeof *rates; r++)
		for (int32_t shades = 1; shades <= PLANE_MARK_MOST; shades += 23) {
			const int64_t whole = rates[r];
			int32_t before = shades;
			for (int64_t part = 0; part <= 64; part++) {
				const int32_t age = (int32_t)(whole * part / 64), left = plane_mark_left(plane_mark(1000, shades, rates[r]), 1000 + age, rates[r]);
				const int64_t exact = shades * whole - PLANE_MARK_MOST * (int64_t)age; /* in shades / whole */
				assert_true(left <= before && left >= 0);
				assert_true(left * whole <= (exact > 0 ? exact + PLANE_MARK_MOST : 0));
				assert_true((left + 1) * whole > exact);
				before = left;
			}
			assert_int_equal(plane_mark_left(plane_mark(1000, shades, rates[r]), 1000 + rates[r], rates[r]), 0);
		}
}

static void without_a_rate_there_is_no_mark(void **state)
{
	const struct plane_marks marks = {.now = 5, .heals = 300, .rises = 400};
	(void)state;
	assert_int_equal(plane_mark_left(100, 5, 0), 0);
	assert_int_equal(plane_mark_left(0, 0, 300), 0);
	assert_int_equal(plane_mark_whole(&marks, PLANE_HEALED), 300);
	assert_int_equal(plane_mark_whole(&marks, PLANE_RISEN), 400);
	assert_int_equal(plane_mark_whole(&marks, PLANE_GROWN), 0);
	assert_int_equal(plane_mark_whole(&marks, PLANE_OFFSET), 0);
}

TEST_PROGRAM(marks)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_new_mark_has_its_shades),
		cmocka_unit_test(it_fades_evenly),
		cmocka_unit_test(without_a_rate_there_is_no_mark),
	};
	return cmocka_run_group_tests_name("marks", tests, NULL, NULL);
}
