/*
 * Cohesion, friction angle and Janosi's shear modulus from shear tests: tau = (c + sigma tan phi) (1 - exp(-j / K)), the least squares of tau.
 *
 * For a given K the model is linear in c and tan phi. So the search begins at the best of some K, each with its c and tan phi.
 */
#include "fit.h"

#include <math.h>
#include <string.h>

enum { STARTS = 24 };
#define SHEAR_MOST 10.0 /* m, of a scene */

struct shear {
	const struct fit_table *table;
	double unit; /* Pa: of c, so that its size is that of tan phi */
};

static bool residual(void *user, size_t i, const double x[FIT_NUMBERS], double *r, double d[FIT_NUMBERS])
{
	const struct shear *shear = user;
	const struct fit_row *row = &shear->table->rows[i];
	if (!(x[2] > 0))
		return false;
	const double decay = exp(-row->x / x[2]), share = -expm1(-row->x / x[2]), most = x[0] * shear->unit + row->group * x[1];
	*r = most * share - row->y;
	d[0] = shear->unit * share;
	d[1] = row->group * share;
	d[2] = -most * decay * row->x / (x[2] * x[2]);
	return true;
}

/* c and tan phi for this K, those that are fixed at 0. Returns the sum of squares; INFINITY: there are none. */
static double start_at(struct shear *shear, const bool fixed[FIT_NUMBERS], double x[FIT_NUMBERS])
{
	struct fit_problem problem = {.count = shear->table->count, .fixed = {fixed[0], fixed[1], true}, .user = shear, .residual = residual};
	struct fit_solution solution = {.x = {0, 0, x[2]}};
	if (!fit_least_squares(&problem, &solution))
		return INFINITY;
	memcpy(x, solution.x, sizeof solution.x);
	return solution.sum;
}

static bool solve(struct shear *shear, const bool fixed[FIT_NUMBERS], struct fit_solution *best)
{
	const struct fit_table *table = shear->table;
	double low = INFINITY, high = 0, least = INFINITY;
	for (size_t i = 0; i < table->count; i++) {
		low = fmin(low, table->rows[i].x);
		high = fmax(high, table->rows[i].x);
	}
	for (int i = 0; i < STARTS; i++) {
		double x[FIT_NUMBERS] = {0, 0, low / 3 * pow(9 * high / low, i / (double)(STARTS - 1))};
		const double sum = start_at(shear, fixed, x);
		if (sum < least) {
			least = sum;
			memcpy(best->x, x, sizeof x);
		}
	}
	struct fit_problem problem = {.count = table->count, .fixed = {fixed[0], fixed[1], false}, .user = shear, .residual = residual};
	return isfinite(least) && fit_least_squares(&problem, best) && best->determined;
}

double fit_shear_stress(const struct fit_shear *fit, double sigma, double j)
{
	return (fit->cohesion.value + sigma * tan(fit->friction.value)) * -expm1(-j / fit->shear.value);
}

static double error_of(const struct fit_solution *solution, const bool fixed[FIT_NUMBERS], int i)
{
	return fixed[i] ? (double)NAN : sqrt(fmax(solution->covariance[i][i], 0));
}

static void take(const struct shear *shear, const struct fit_solution *solution, const bool fixed[FIT_NUMBERS], struct fit_shear *out)
{
	const double t = solution->x[1];
	out->cohesion = (struct fit_number){solution->x[0] * shear->unit, error_of(solution, fixed, 0) * shear->unit};
	out->friction = (struct fit_number){atan(t), error_of(solution, fixed, 1) / (1 + t * t)};
	out->shear = (struct fit_number){solution->x[2], error_of(solution, fixed, 2)};
	struct fit_sums sums = {.squares = 0};
	for (size_t i = 0; i < shear->table->count; i++)
		fit_sums_add(&sums, &shear->table->rows[i], fit_shear_stress(out, shear->table->rows[i].group, shear->table->rows[i].x));
	out->quality = fit_sums_end(&sums);
}

static enum status check(const struct fit_table *table)
{
	const size_t least = table->group_count > 1 ? 4 : 3;
	double low = INFINITY, high = 0, most = 0;
	for (size_t i = 0; i < table->count; i++) {
		low = fmin(low, table->rows[i].x);
		high = fmax(high, table->rows[i].x);
		most = fmax(most, table->rows[i].y);
	}
	if (table->count < least)
		return fail_with(STATUS_INPUT, "%s: has %zu rows with a displacement above 0, and %zu are needed; give more", table->path, table->count, least);
	if (!(high > low * (1 + 1e-9)))
		return fail_with(STATUS_INPUT, "%s: all rows have one displacement; give the stress at several", table->path);
	return most > 0 ? STATUS_OK : fail_with(STATUS_INPUT, "%s: has no shear stress above 0; check the column", table->path);
}

enum status fit_shear(const struct fit_table *table, struct fit_shear *out)
{
	struct shear shear = {.table = table, .unit = 1};
	struct fit_solution solution;
	memset(out, 0, sizeof *out);
	TRY(check(table));
	for (size_t g = 0; g < table->group_count; g++)
		shear.unit = fmax(shear.unit, table->groups[g]);
	out->one_stress = table->group_count == 1;
	const bool none = out->one_stress && !(table->groups[0] > 0);
	bool fixed[FIT_NUMBERS] = {out->one_stress && !none, none, false};
	bool good = solve(&shear, fixed, &solution);
	if (good && !fixed[0] && solution.x[0] < 0) {
		out->no_cohesion = fixed[0] = true;
		good = solve(&shear, fixed, &solution);
	} else if (good && !fixed[1] && solution.x[1] < 0) {
		out->no_friction = fixed[1] = true;
		good = solve(&shear, fixed, &solution);
	}
	if (!good || solution.x[2] > SHEAR_MOST)
		return fail_with(STATUS_INPUT, "%s: its rows do not tell cohesion, friction and K apart: the shear stress has to level off within the measured "
					       "displacement; measure to a larger one, and under clearly different normal stresses", table->path);
	take(&shear, &solution, fixed, out);
	return STATUS_OK;
}
