/* Rasters of numbers: reading them. */
#ifndef FURROW_TESTS_DEM_NUMBERS_H
#define FURROW_TESTS_DEM_NUMBERS_H

#include "placed.h"

/* Whoever asks frees them. */
static inline double *read_numbers(struct dem_pixels *numbers, int level, struct post_rect rect)
{
	size_t count = (size_t)((rect.x1 - rect.x0) * (rect.y1 - rect.y0));
	double *values = malloc((count + 1) * sizeof *values);
	assert_non_null(values);
	values[count] = 77;
	if (dem_numbers_read(numbers, level, rect, values) != STATUS_OK)
		fail_msg("%s", failure_message());
	assert_true(values[count] == 77);
	return values;
}

static inline void assert_number(double is, double should_be)
{
	if (isnan(is) != isnan(should_be) || fabs(is - should_be) > 1e-7 * fmax(fabs(should_be), 1))
		fail_msg("%.12g is not %.12g", is, should_be);
}

static inline void assert_extremes_refused(struct dem_pixels *numbers, const struct dem_numbers_range *range, const char *says)
{
	double low, high;
	assert_int_equal(dem_numbers_extremes(numbers, range, &low, &high), STATUS_INPUT);
	assert_told(says, NULL);
}

#endif
