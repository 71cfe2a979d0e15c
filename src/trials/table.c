/* Verdicts of all slopes and headings, so that a map looks them up. */
#include <math.h>

#include "trials/trials.h"

void trials_table_make(const struct trials_vehicle *vehicle, const struct mobility_curves *curves, double gravity, struct mobility_table *table)
{
	for (int i = 0; i < MOBILITY_SLOPES; i++)
		for (int k = 0; k < MOBILITY_HEADINGS; k++)
			table->verdicts[i][k] = trials_judge(vehicle, curves, gravity, i * MOBILITY_SLOPE_STEP, k * MOBILITY_HEADING_STEP);
}

void trials_column_make(const struct trials_vehicle *vehicle, const struct mobility_curves *curves, double gravity, struct mobility_column *column)
{
	for (int i = 0; i < MOBILITY_SLOPES; i++)
		column->verdicts[i] = trials_judge(vehicle, curves, gravity, i * MOBILITY_SLOPE_STEP, 0);
}

/* Between two slopes of the table the slip is read straight; where only the gentler one goes, the steeper one's verdict holds. */
static struct mobility_verdict blend(const struct mobility_verdict *low, const struct mobility_verdict *high, double share)
{
	if (share <= 0)
		return *low;
	if (low->reason != MOBILITY_GO || high->reason != MOBILITY_GO)
		return *high;
	return (struct mobility_verdict){MOBILITY_GO, low->slip + (high->slip - low->slip) * share, low->torque + (high->torque - low->torque) * share,
					 low->sinkage + (high->sinkage - low->sinkage) * share, low->crab + (high->crab - low->crab) * share};
}

struct mobility_slope trials_table_at(const struct mobility_table *table, double slope)
{
	struct mobility_slope found = {{MOBILITY_NO_GROUND, NAN, NAN, NAN, NAN}, NAN, false};
	if (isnan(slope))
		return found;
	const double at = fmin(slope, MOBILITY_SLOPE_MOST) / MOBILITY_SLOPE_STEP;
	const int i = (int)fmin(floor(at), MOBILITY_SLOPES - 2);
	const double share = at - i;
	found.up = blend(&table->verdicts[i][0], &table->verdicts[i + 1][0], share);
	found.every = true;
	for (int k = 0; k < MOBILITY_HEADINGS; k++) {
		const bool goes = blend(&table->verdicts[i][k], &table->verdicts[i + 1][k], share).reason == MOBILITY_GO;
		found.every &= goes;
		if (goes && isnan(found.steepest))
			found.steepest = 90 - k * MOBILITY_HEADING_STEP;
	}
	return found;
}
