#include "vehicle/linear.h"

#include <math.h>

static size_t pivot_of(const double *a, size_t n, size_t column)
{
	size_t best = column;
	for (size_t row = column + 1; row < n; row++)
		if (fabs(a[row * n + column]) > fabs(a[best * n + column]))
			best = row;
	return best;
}

static void swap_rows(double *a, double *b, size_t n, size_t i, size_t j)
{
	for (size_t k = 0; k < n; k++) {
		const double keep = a[i * n + k];
		a[i * n + k] = a[j * n + k];
		a[j * n + k] = keep;
	}
	const double keep = b[i];
	b[i] = b[j];
	b[j] = keep;
}

bool vehicle_solve(double *a, double *b, size_t n)
{
	for (size_t i = 0; i < n; i++) {
		const size_t pivot = pivot_of(a, n, i);
		if (!(fabs(a[pivot * n + i]) > 0) || !isfinite(a[pivot * n + i]))
			return false;
		if (pivot != i)
			swap_rows(a, b, n, i, pivot);
		for (size_t row = i + 1; row < n; row++) {
			const double share = a[row * n + i] / a[i * n + i];
			if (share == 0)
				continue;
			for (size_t k = i; k < n; k++)
				a[row * n + k] -= share * a[i * n + k];
			b[row] -= share * b[i];
		}
	}
	for (size_t i = n; i-- > 0;) {
		for (size_t k = i + 1; k < n; k++)
			b[i] -= a[i * n + k] * b[k];
		b[i] /= a[i * n + i];
	}
	return true;
}

bool vehicle_factor(double *a, size_t n)
{
	for (size_t i = 0; i < n; i++)
		for (size_t j = 0; j <= i; j++) {
			double sum = a[i * n + j];
			for (size_t k = 0; k < j; k++)
				sum -= a[i * n + k] * a[j * n + k];
			if (i != j)
				a[i * n + j] = sum / a[j * n + j];
			else if (!(sum > 0))
				return false;
			else
				a[i * n + i] = sqrt(sum);
		}
	return true;
}

void vehicle_solve_factored(const double *a, double *b, size_t n)
{
	for (size_t i = 0; i < n; i++) {
		for (size_t k = 0; k < i; k++)
			b[i] -= a[i * n + k] * b[k];
		b[i] /= a[i * n + i];
	}
	for (size_t i = n; i-- > 0;) {
		for (size_t k = i + 1; k < n; k++)
			b[i] -= a[k * n + i] * b[k];
		b[i] /= a[i * n + i];
	}
}

static bool is_negative(double a[6][6])
{
	double minus[36];
	for (int i = 0; i < 6; i++)
		for (int j = 0; j < 6; j++)
			minus[6 * i + j] = -a[i][j];
	return vehicle_factor(minus, 6);
}

/* One rotation of Jacobi's: a' = r^T a r has no entry at (p, q); v collects the rotations. */
static void rotate(double a[6][6], double v[6][6], int p, int q)
{
	if (a[p][q] == 0)
		return;
	const double ratio = (a[q][q] - a[p][p]) / (2 * a[p][q]);
	const double t = (ratio >= 0 ? 1 : -1) / (fabs(ratio) + sqrt(1 + ratio * ratio)), c = 1 / sqrt(1 + t * t), s = t * c;
	for (int k = 0; k < 6; k++) {
		const double x = a[k][p], y = a[k][q];
		a[k][p] = c * x - s * y;
		a[k][q] = s * x + c * y;
	}
	for (int k = 0; k < 6; k++) {
		const double x = a[p][k], y = a[q][k], vx = v[k][p], vy = v[k][q];
		a[p][k] = c * x - s * y;
		a[q][k] = s * x + c * y;
		v[k][p] = c * vx - s * vy;
		v[k][q] = s * vx + c * vy;
	}
}

void vehicle_make_negative(double a[6][6])
{
	double v[6][6] = {{0}}, kept[6];
	for (int i = 0; i < 6; i++)
		for (int j = 0; j < i; j++)
			a[i][j] = a[j][i] = (a[i][j] + a[j][i]) / 2;
	if (is_negative(a))
		return;
	for (int i = 0; i < 6; i++)
		v[i][i] = 1;
	for (int round = 0; round < 8; round++)
		for (int p = 0; p < 5; p++)
			for (int q = p + 1; q < 6; q++)
				rotate(a, v, p, q);
	for (int i = 0; i < 6; i++)
		kept[i] = fmin(a[i][i], 0);
	for (int i = 0; i < 6; i++)
		for (int j = 0; j < 6; j++) {
			a[i][j] = 0;
			for (int k = 0; k < 6; k++)
				a[i][j] += v[i][k] * kept[k] * v[j][k];
		}
}
