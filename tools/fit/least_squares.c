/*
 * Least squares of a model with up to three numbers, by Levenberg's and Marquardt's method (D. W. Marquardt, An algorithm for least-squares
 * estimation of nonlinear parameters, 1963). Each number is scaled by the size of its column of the Jacobian.
 */
#include "fit.h"

#include <math.h>
#include <string.h>

#define ITERATIONS_MOST 500
#define DAMPING_MOST 1e20
#define SINGULAR 1e-13 /* of a scaled pivot */
#define STEP_LEAST 1e-15

/* Cholesky's factors of a matrix whose diagonal is 1. */
static bool factor(double a[FIT_NUMBERS][FIT_NUMBERS])
{
	for (int i = 0; i < FIT_NUMBERS; i++)
		for (int j = 0; j <= i; j++) {
			double sum = a[i][j];
			for (int k = 0; k < j; k++)
				sum -= a[i][k] * a[j][k];
			if (i == j && !(sum > SINGULAR))
				return false;
			a[i][j] = i == j ? sqrt(sum) : sum / a[j][j];
		}
	return true;
}

bool fit_solve(double a[FIT_NUMBERS][FIT_NUMBERS], const double b[FIT_NUMBERS], double x[FIT_NUMBERS])
{
	double scale[FIT_NUMBERS], scaled[FIT_NUMBERS][FIT_NUMBERS];
	for (int i = 0; i < FIT_NUMBERS; i++) {
		if (!(a[i][i] > 0) || !isfinite(a[i][i]))
			return false;
		scale[i] = 1 / sqrt(a[i][i]);
	}
	for (int i = 0; i < FIT_NUMBERS; i++)
		for (int j = 0; j < FIT_NUMBERS; j++)
			scaled[i][j] = a[i][j] * scale[i] * scale[j];
	if (!factor(scaled))
		return false;
	for (int i = 0; i < FIT_NUMBERS; i++) {
		x[i] = b[i] * scale[i];
		for (int k = 0; k < i; k++)
			x[i] -= scaled[i][k] * x[k];
		x[i] /= scaled[i][i];
	}
	for (int i = FIT_NUMBERS; i-- > 0;) {
		for (int k = i + 1; k < FIT_NUMBERS; k++)
			x[i] -= scaled[k][i] * x[k];
		x[i] /= scaled[i][i];
	}
	for (int i = 0; i < FIT_NUMBERS; i++)
		x[i] *= scale[i];
	return true;
}

/* The sum of squares, and with it J'J and J'r. INFINITY: the model has no value at x. */
static double sums(const struct fit_problem *problem, const double x[FIT_NUMBERS], double jj[FIT_NUMBERS][FIT_NUMBERS], double jr[FIT_NUMBERS])
{
	double sum = 0;
	memset(jj, 0, sizeof(double[FIT_NUMBERS][FIT_NUMBERS]));
	memset(jr, 0, sizeof(double[FIT_NUMBERS]));
	for (size_t row = 0; row < problem->count; row++) {
		double r, d[FIT_NUMBERS];
		if (!problem->residual(problem->user, row, x, &r, d) || !isfinite(r))
			return INFINITY;
		sum += r * r;
		for (int i = 0; i < FIT_NUMBERS; i++) {
			if (problem->fixed[i])
				continue;
			jr[i] += d[i] * r;
			for (int j = 0; j < FIT_NUMBERS; j++)
				jj[i][j] += problem->fixed[j] ? 0 : d[i] * d[j];
		}
	}
	for (int i = 0; i < FIT_NUMBERS; i++)
		jj[i][i] = problem->fixed[i] ? 1 : jj[i][i];
	return sum;
}

/* A step with this damping. Returns false if there is none. */
static bool step(double jj[FIT_NUMBERS][FIT_NUMBERS], const double jr[FIT_NUMBERS], double damping, double out[FIT_NUMBERS])
{
	double damped[FIT_NUMBERS][FIT_NUMBERS];
	memcpy(damped, jj, sizeof damped);
	for (int i = 0; i < FIT_NUMBERS; i++)
		damped[i][i] *= 1 + damping;
	return fit_solve(damped, jr, out);
}

static void find_covariance(const struct fit_problem *problem, double jj[FIT_NUMBERS][FIT_NUMBERS], struct fit_solution *solution)
{
	size_t fitted = 0;
	for (int i = 0; i < FIT_NUMBERS; i++)
		fitted += !problem->fixed[i];
	const double variance = problem->count > fitted ? solution->sum / (double)(problem->count - fitted) : 0;
	memset(solution->covariance, 0, sizeof solution->covariance);
	solution->determined = true;
	for (int i = 0; i < FIT_NUMBERS && solution->determined; i++) {
		double unit[FIT_NUMBERS] = {0}, column[FIT_NUMBERS];
		unit[i] = 1;
		solution->determined = fit_solve(jj, unit, column);
		for (int k = 0; k < FIT_NUMBERS && solution->determined; k++)
			solution->covariance[k][i] = problem->fixed[i] || problem->fixed[k] ? 0 : column[k] * variance;
	}
}

bool fit_least_squares(const struct fit_problem *problem, struct fit_solution *solution)
{
	double jj[FIT_NUMBERS][FIT_NUMBERS], jr[FIT_NUMBERS], damping = 1e-3;
	double *x = solution->x;
	solution->sum = sums(problem, x, jj, jr);
	solution->iterations = 0;
	if (!isfinite(solution->sum))
		return false;
	while (solution->iterations++ < ITERATIONS_MOST && damping < DAMPING_MOST) {
		double by[FIT_NUMBERS] = {0}, next[FIT_NUMBERS], next_jj[FIT_NUMBERS][FIT_NUMBERS], next_jr[FIT_NUMBERS];
		if (!step(jj, jr, damping, by)) {
			damping *= 10;
			continue;
		}
		bool moves = false;
		for (int i = 0; i < FIT_NUMBERS; i++) {
			next[i] = x[i] - (problem->fixed[i] ? 0 : by[i]);
			moves = moves || fabs(next[i] - x[i]) > STEP_LEAST * fabs(x[i]);
		}
		const double sum = sums(problem, next, next_jj, next_jr);
		if (sum < solution->sum) {
			memcpy(x, next, sizeof next);
			memcpy(jj, next_jj, sizeof jj);
			memcpy(jr, next_jr, sizeof jr);
			solution->sum = sum;
			damping = fmax(damping / 10, 1e-12);
		} else {
			damping *= 10;
		}
		if (!moves)
			break;
	}
	find_covariance(problem, jj, solution);
	return true;
}
