/* Factors of uncertain soil numbers, and how many of the soils that they give a vehicle passes. */
#include <math.h>
#include <stdint.h>

#include "trials/trials.h"

/* A number from 0 to 1, both excluded, of a fixed sequence (Knuth's MMIX). */
static double uniform(uint64_t *state)
{
	*state = *state * 6364136223846793005u + 1442695040888963407u;
	return ((double)(*state >> 11) + 0.5) * 0x1p-53;
}

/* Returns how many standard deviations above the mean of a normal distribution this share of it ends. */
static double quantile(double share)
{
	double low = -9, high = 9;
	for (int i = 0; i < 60; i++) {
		const double middle = (low + high) / 2;
		*(erfc(-middle / sqrt(2)) / 2 < share ? &low : &high) = middle;
	}
	return (low + high) / 2;
}

void trials_spread_factors(const double spread[3], int64_t seed, size_t count, double (*factors)[3])
{
	uint64_t state = (uint64_t)seed * 0x9e3779b97f4a7c15u + 1;
	for (int number = 0; number < 3; number++) {
		/* One from each of `count` shares that are equally probable, then shuffled (Fisher and Yates). */
		for (size_t i = 0; i < count; i++)
			factors[i][number] = exp(spread[number] * quantile(((double)i + uniform(&state)) / (double)count));
		for (size_t i = count; i > 1; i--) {
			const size_t other = (size_t)(uniform(&state) * (double)i);
			const double kept = factors[i - 1][number];
			factors[i - 1][number] = factors[other][number];
			factors[other][number] = kept;
		}
	}
}

double trials_probability(const struct mobility_column *columns, size_t count, double slope)
{
	if (isnan(slope) || count == 0)
		return NAN;
	/* Between two slopes the steeper one's verdict holds, as in a table. */
	const int i = (int)ceil(fmin(slope, MOBILITY_SLOPE_MOST) / MOBILITY_SLOPE_STEP);
	size_t goes = 0;
	for (size_t k = 0; k < count; k++)
		goes += columns[k].verdicts[i].reason == MOBILITY_GO;
	return (double)goes / (double)count;
}
