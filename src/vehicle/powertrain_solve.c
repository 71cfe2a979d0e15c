/*
 * Torques within limits that take speeds away: a linear complementarity problem with bounds, by pivoting of blocks.
 *
 * Each row is in one of three states: free, at its upper limit, at its lower one. In each turn the free rows are solved, and rows whose result does not
 * fit their state are found. All of these change their states at once, as long as their number falls. If it has not fallen for TRIES turns, only the
 * last of them changes. For a positive matrix that comes to an end.
 */
#include <math.h>

#include "vehicle/linear.h"
#include "vehicle/powertrain.h"

#define TRIES 3     /* changes of whole blocks without progress */
#define TURNS 200   /* at most */

/* Solves the free rows; those at a limit have it. */
static void solve_free(const double *q, const double *c, const double *limits, size_t count, double *x, double *room, const signed char *bound)
{
	double *matrix = room, *right = room + count * count;
	size_t free = 0;
	for (size_t i = 0; i < count; i++)
		x[i] = bound[i] * (bound[i] != 0 ? limits[i] : 0);
	for (size_t i = 0; i < count; i++) {
		if (bound[i] != 0)
			continue;
		right[free] = -c[i];
		for (size_t k = 0; k < count; k++)
			right[free] -= bound[k] != 0 ? q[i * count + k] * x[k] : 0;
		free++;
	}
	size_t row = 0;
	for (size_t i = 0; i < count; i++) {
		size_t column = 0;
		if (bound[i] != 0)
			continue;
		for (size_t k = 0; k < count; k++)
			if (bound[k] == 0)
				matrix[row * free + column++] = q[i * count + k];
		row++;
	}
	const bool whole = vehicle_factor(matrix, free);
	if (whole)
		vehicle_solve_factored(matrix, right, free);
	for (size_t i = 0, from = 0; i < count; i++)
		if (bound[i] == 0)
			x[i] = whole ? right[from++] : (double)NAN;
}

/* Returns the state that a row should have. */
static signed char better(const double *q, const double *c, const double *limits, size_t count, const double *x, const signed char *bound, size_t row)
{
	if (bound[row] == 0)
		return x[row] > limits[row] ? 1 : x[row] < -limits[row] ? -1 : 0;
	double speed = c[row];
	for (size_t k = 0; k < count; k++)
		speed += q[row * count + k] * x[k];
	return bound[row] * speed > 0 ? 0 : bound[row];
}

void vehicle_solve_bounded(const double *q, const double *c, const double *limits, size_t count, double *x, double *room, signed char *bound)
{
	size_t least = count + 1;
	int tries = TRIES;
	for (size_t i = 0; i < count; i++)
		bound[i] = 0;
	for (int turn = 0; turn < TURNS; turn++) {
		size_t wrong = 0, last = 0;
		solve_free(q, c, limits, count, x, room, bound);
		double *wanted = room + count * count + count;
		for (size_t i = 0; i < count; i++) {
			const signed char state = better(q, c, limits, count, x, bound, i);
			wanted[i] = state;
			if (state != bound[i]) {
				wrong++;
				last = i;
			}
		}
		if (wrong == 0)
			return;
		if (wrong < least) {
			least = wrong;
			tries = TRIES;
		} else {
			tries--;
		}
		for (size_t i = 0; i < count; i++)
			if (tries >= 0 || i == last)
				bound[i] = (signed char)wanted[i];
	}
	for (size_t i = 0; i < count; i++) /* no state fits, by rounding: what is beyond a limit is cut */
		x[i] = fmin(fmax(x[i], -limits[i]), limits[i]);
}
