/*
 * Bekker's numbers from plates: p = (kc / b + kphi) z^n.
 *
 * Two fits of all rows together, with one n for all plates:
 *   plain: the least squares of p;
 *   Wong:  the least squares of p (ln p - ln of the model): logarithms, weighted by the square of pressure (J. Y. Wong, Data processing
 *          methodology in the characterization of the mechanical properties of terrain, Journal of Terramechanics 17, 1980).
 *
 * Inside, sinkage is in units of z0 and width in units of b0, a mean of each: p = (A b0 / b + B) (z / z0)^n. So A, B and n depend little on each
 * other. kc = A b0 z0^-n, kphi = B z0^-n.
 */
#include "fit.h"

#include <math.h>
#include <string.h>

#define N_MOST 3.0 /* of a scene */

struct plates {
	const struct fit_table *table;
	enum fit_method method;
	double z0, b0;
};

/* --- the model --- */

static bool residual(void *user, size_t i, const double x[FIT_NUMBERS], double *r, double d[FIT_NUMBERS])
{
	const struct plates *plates = user;
	const struct fit_row *row = &plates->table->rows[i];
	const double z = row->x / plates->z0, b = plates->b0 / row->group, power = pow(z, x[2]), k = x[0] * b + x[1], p = row->y;
	if (!(k > 0) || !(power > 0) || !isfinite(power))
		return false;
	if (plates->method == FIT_PLAIN) {
		*r = k * power - p;
		d[0] = b * power;
		d[1] = power;
		d[2] = k * power * log(z);
	} else { /* a pressure of 0 has no weight */
		*r = p > 0 ? p * (log(k * power) - log(p)) : 0;
		d[0] = p * b / k;
		d[1] = p / k;
		d[2] = p * log(z);
	}
	return true;
}

/* --- Wong's formulas: ln p = ln k + n ln z, weighted by p^2 --- */

struct line { /* weighted sums over the rows of a plate */
	double w, x, y, xx, xy;
};

static struct line line_of(const struct plates *plates, size_t group)
{
	struct line line = {0};
	for (size_t i = 0; i < plates->table->count; i++) {
		const struct fit_row *row = &plates->table->rows[i];
		if (!(row->y > 0) || fit_table_group(plates->table, row) != group)
			continue;
		const double w = row->y * row->y, x = log(row->x / plates->z0), y = log(row->y);
		line.w += w;
		line.x += w * x;
		line.y += w * y;
		line.xx += w * x * x;
		line.xy += w * x * y;
	}
	return line;
}

static struct fit_curve curve_of(const struct plates *plates, size_t group)
{
	const struct line line = line_of(plates, group);
	struct fit_sums sums = {.squares = 0};
	struct fit_curve curve;
	curve.n = (line.w * line.xy - line.x * line.y) / (line.w * line.xx - line.x * line.x);
	const double k = exp((line.y - curve.n * line.x) / line.w);
	curve.k = k * pow(plates->z0, -curve.n);
	for (size_t i = 0; i < plates->table->count; i++) {
		const struct fit_row *row = &plates->table->rows[i];
		if (fit_table_group(plates->table, row) == group)
			fit_sums_add(&sums, row, k * pow(row->x / plates->z0, curve.n));
	}
	curve.quality = fit_sums_end(&sums);
	return curve;
}

/* Where the fits begin: one n for all plates, k of each, and the straight line through k over b0 / b. */
static bool begin(const struct plates *plates, double x[FIT_NUMBERS])
{
	const struct fit_table *table = plates->table;
	double up = 0, down = 0, s = 0, sb = 0, sk = 0, sbb = 0, sbk = 0;
	for (size_t g = 0; g < table->group_count; g++) {
		const struct line line = line_of(plates, g);
		up += line.xy - line.x * line.y / line.w;
		down += line.xx - line.x * line.x / line.w;
	}
	x[2] = up / down;
	for (size_t g = 0; g < table->group_count; g++) {
		const struct line line = line_of(plates, g);
		const double k = exp((line.y - x[2] * line.x) / line.w), b = plates->b0 / table->groups[g];
		s += 1;
		sb += b;
		sk += k;
		sbb += b * b;
		sbk += b * k;
	}
	x[0] = table->group_count > 1 ? (s * sbk - sb * sk) / (s * sbb - sb * sb) : 0;
	x[1] = (sk - x[0] * sb) / s;
	return isfinite(x[0]) && isfinite(x[1]) && isfinite(x[2]);
}

/* --- the fits --- */

static void take(const struct plates *plates, const struct fit_solution *solution, const bool fixed[FIT_NUMBERS], struct fit_plates *out)
{
	const double *x = solution->x, n = x[2], unit = pow(plates->z0, -n), log_z0 = log(plates->z0);
	const double value[FIT_NUMBERS] = {x[0] * plates->b0 * unit, x[1] * unit, n};
	/* how they change with A, B and n */
	const double by[FIT_NUMBERS][FIT_NUMBERS] = {
		{plates->b0 * unit, 0, -value[0] * log_z0},
		{0, unit, -value[1] * log_z0},
		{0, 0, 1},
	};
	struct fit_number *numbers[FIT_NUMBERS] = {&out->kc[plates->method], &out->kphi[plates->method], &out->n[plates->method]};
	for (int k = 0; k < FIT_NUMBERS; k++) {
		double variance = 0;
		for (int i = 0; i < FIT_NUMBERS; i++)
			for (int j = 0; j < FIT_NUMBERS; j++)
				variance += by[k][i] * by[k][j] * solution->covariance[i][j];
		*numbers[k] = (struct fit_number){value[k], fixed[k] ? (double)NAN : sqrt(fmax(variance, 0))};
	}
}

double fit_pressure(const struct fit_plates *fit, enum fit_method method, double b, double z)
{
	return (fit->kc[method].value / b + fit->kphi[method].value) * pow(z, fit->n[method].value);
}

static enum status cannot_tell(const struct fit_table *table)
{
	return fail_with(STATUS_INPUT, "%s: its rows do not tell kc, kphi and n apart; measure each plate at several sinkages, and plates of clearly "
				       "different widths", table->path);
}

static enum status fit_by(struct plates *plates, const double from[FIT_NUMBERS], struct fit_plates *out)
{
	const struct fit_table *table = plates->table;
	struct fit_problem problem = {.count = table->count, .fixed = {out->one_width, false, false}, .user = plates, .residual = residual};
	struct fit_solution solution;
	memcpy(solution.x, from, sizeof solution.x);
	bool good = fit_least_squares(&problem, &solution) && solution.determined;
	if (good && solution.x[1] < 0) { /* no scene takes that */
		out->no_kphi = problem.fixed[1] = true;
		solution.x[0] += solution.x[1];
		solution.x[1] = 0;
		good = fit_least_squares(&problem, &solution) && solution.determined;
	}
	if (!good)
		return cannot_tell(table);
	take(plates, &solution, problem.fixed, out);
	const double n = out->n[plates->method].value;
	if (!(n > 0) || n > N_MOST)
		return fail_with(STATUS_INPUT, "%s: n would be %.3g, and a soil's is above 0 and at most %g; check the units of its columns, and leave out "
					       "rows where the plate did not yet touch", table->path, n, N_MOST);
	struct fit_sums sums = {.squares = 0};
	for (size_t i = 0; i < table->count; i++)
		fit_sums_add(&sums, &table->rows[i], fit_pressure(out, plates->method, table->rows[i].group, table->rows[i].x));
	out->quality[plates->method] = fit_sums_end(&sums);
	return STATUS_OK;
}

/* Means of sinkage, weighted as the logarithms are, and of 1 / b. */
static void find_units(struct plates *plates)
{
	const struct fit_table *table = plates->table;
	double w = 0, log_z = 0, inverse = 0;
	for (size_t i = 0; i < table->count; i++) {
		const double p = table->rows[i].y;
		w += p * p;
		log_z += p * p * log(table->rows[i].x);
	}
	for (size_t g = 0; g < table->group_count; g++)
		inverse += 1 / table->groups[g] / (double)table->group_count;
	plates->z0 = w > 0 ? exp(log_z / w) : 1;
	plates->b0 = 1 / inverse;
}

static enum status check(const struct fit_table *table)
{
	const size_t least = table->group_count > 1 ? 4 : 3;
	if (table->count < least)
		return fail_with(STATUS_INPUT, "%s: has %zu rows with a sinkage above 0, and %zu are needed; give more", table->path, table->count, least);
	for (size_t g = 0; g < table->group_count; g++) {
		double low = INFINITY, high = 0, most = 0;
		for (size_t i = 0; i < table->count; i++)
			if (fit_table_group(table, &table->rows[i]) == g) {
				low = fmin(low, table->rows[i].x);
				high = fmax(high, table->rows[i].x);
				most = fmax(most, table->rows[i].y);
			}
		if (!(high > low * (1 + 1e-9)))
			return fail_with(STATUS_INPUT, "%s: the plate of %g m has rows of one sinkage only; measure it at several", table->path, table->groups[g]);
		if (!(most > 0))
			return fail_with(STATUS_INPUT, "%s: the plate of %g m has no pressure above 0; check the column", table->path, table->groups[g]);
	}
	return STATUS_OK;
}

enum status fit_plates(const struct fit_table *table, struct fit_plates *out)
{
	struct plates plates = {.table = table};
	double from[FIT_NUMBERS];
	memset(out, 0, sizeof *out);
	TRY(check(table));
	out->one_width = table->group_count == 1;
	find_units(&plates);
	for (size_t g = 0; g < table->group_count; g++)
		out->curves[g] = curve_of(&plates, g);
	if (!begin(&plates, from))
		return cannot_tell(table);
	for (int method = 0; method < FIT_METHODS; method++) {
		plates.method = (enum fit_method)method;
		TRY(fit_by(&plates, from, out));
	}
	return STATUS_OK;
}
