/* The probability to go beside a closed form: strengths are lognormal, and the steepest slope grows with them in a straight line. */
#include <math.h>
#include <stdlib.h>

#include "../support.h"
#include "../support/program.h"
#include "trials/trials.h"

#define RADIANS (3.14159265358979323846 / 180)
#define SOILS 64
#define MOST 0.4 /* tangent of the steepest slope of the soil as it is */

/* Drawbar factor x MOST x N at every slip from 0.1 on. */
static void judge_all(const double (*factors)[3], size_t count, struct mobility_column *columns)
{
	struct trials_vehicle vehicle = {.mass = 1000, .height = 0.1, .clearance = INFINITY, .wheel_count = 4};
	for (size_t i = 0; i < 4; i++)
		vehicle.wheels[i] = (struct trials_wheel){i < 2 ? 1.2 : -1.2, i % 2 == 0 ? 0.7 : -0.7, 0.35, 0.25, true, INFINITY};
	for (size_t k = 0; k < count; k++) {
		struct mobility_curves curves = {.friction_angle = 89, .kind_count = 1};
		for (size_t l = 0; l < MOBILITY_LOADS; l++) {
			const double load = curves.of[0].loads[l] = vehicle.mass * 9.81 / 4 * (0.01 + 0.6 * (double)l);
			for (size_t s = 0; s < MOBILITY_SLIPS; s++)
				curves.of[0].points[l][s] = (struct mobility_point){load * MOST * factors[k][1] * fmin(trials_slips[s] / 0.1, 1), load, 0, 0, true};
		}
		trials_column_make(&vehicle, &curves, 9.81, &columns[k]);
	}
}

/* Of a Latin hypercube one number alone is counted within one soil. Columns have steps of MOBILITY_SLOPE_STEP, so their slopes are taken. */
static void one_number_gives_its_distribution(void **state)
{
	static struct mobility_column columns[SOILS];
	double factors[SOILS][3];
	(void)state;
	for (int64_t seed = 1; seed <= 3; seed++) {
		const double spread = 0.1 * (double)seed;
		trials_spread_factors((double[]){0, spread, 0}, seed, SOILS, factors);
		judge_all((const double(*)[3])factors, SOILS, columns);
		for (double slope = 10; slope < 32; slope += 2) {
			const double wanted = erfc(log(tan(slope * RADIANS) / MOST) / spread / sqrt(2)) / 2; /* P(factor > tan / MOST) */
			assert_true(fabs(trials_probability(columns, SOILS, slope) - wanted) <= 1.0001 / SOILS);
		}
	}
	assert_true(isnan(trials_probability(columns, SOILS, NAN)) && isnan(trials_probability(columns, 0, 10)));
}

static int by_size(const void *a, const void *b)
{
	return (*(const double *)a > *(const double *)b) - (*(const double *)a < *(const double *)b);
}

static void each_share_of_each_number_has_one_soil(void **state)
{
	double factors[SOILS][3], again[SOILS][3], other[SOILS][3], sorted[SOILS];
	static const double spread[3] = {0.3, 0.1, 0.2};
	(void)state;
	trials_spread_factors(spread, 5, SOILS, factors);
	trials_spread_factors(spread, 5, SOILS, again);
	trials_spread_factors(spread, 6, SOILS, other);
	assert_memory_equal(factors, again, sizeof factors);
	assert_memory_not_equal(factors, other, sizeof factors);
	for (int number = 0; number < 3; number++) {
		for (size_t i = 0; i < SOILS; i++)
			sorted[i] = factors[i][number];
		qsort(sorted, SOILS, sizeof *sorted, by_size);
		for (size_t i = 0; i < SOILS; i++) {
			const double share = erfc(-log(sorted[i]) / spread[number] / sqrt(2)) / 2;
			assert_true(share >= (double)i / SOILS - 1e-9 && share <= (double)(i + 1) / SOILS + 1e-9);
		}
	}
	/* The numbers are shuffled each for itself: they are hardly correlated. */
	double sum = 0;
	for (size_t i = 0; i < SOILS; i++)
		sum += log(factors[i][0]) / spread[0] * log(factors[i][1]) / spread[1] / SOILS;
	assert_true(fabs(sum) < 0.4);
}

TEST_PROGRAM(spread)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(one_number_gives_its_distribution),
		cmocka_unit_test(each_share_of_each_number_has_one_soil),
	};
	return cmocka_run_group_tests_name("trials/spread", tests, NULL, NULL);
}
