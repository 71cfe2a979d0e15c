#include "vehicle/linear.h"

#include <math.h>

#include "base/wide.h"

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

/* Matrices side by side: a wide vector has a number of each. */
struct abreast {
	double a[6][6][VEHICLE_ABREAST], v[6][6][VEHICLE_ABREAST];
};

static inline void turn(double *restrict x, double *restrict y, const double *restrict cosine, const double *restrict sine)
{
	for (int i = 0; i < VEHICLE_ABREAST; i++) {
		const double was_x = x[i], was_y = y[i];
		x[i] = cosine[i] * was_x - sine[i] * was_y;
		y[i] = sine[i] * was_x + cosine[i] * was_y;
	}
}

/* One rotation of Jacobi's: a' = r^T a r has no entry at (p, q); v collects the rotations. */
static inline void rotate(struct abreast *m, int p, int q)
{
	double cosine[VEHICLE_ABREAST], sine[VEHICLE_ABREAST];
	for (int i = 0; i < VEHICLE_ABREAST; i++) {
		const double here = m->a[p][q][i], ratio = (m->a[q][q][i] - m->a[p][p][i]) / (2 * here);
		const double t = (ratio >= 0 ? 1.0 : -1.0) / (fabs(ratio) + sqrt(1 + ratio * ratio)), c = 1 / sqrt(1 + t * t);
		cosine[i] = here == 0 ? 1 : c;
		sine[i] = here == 0 ? 0 : t * c;
	}
	for (int k = 0; k < 6; k++)
		turn(m->a[k][p], m->a[k][q], cosine, sine);
	for (int k = 0; k < 6; k++) {
		turn(m->a[p][k], m->a[q][k], cosine, sine);
		turn(m->v[k][p], m->v[k][q], cosine, sine);
	}
}

FURROW_WIDE static void rotate_all(struct abreast *m)
{
	for (int round = 0; round < 8; round++)
		for (int p = 0; p < 5; p++)
			for (int q = p + 1; q < 6; q++)
				rotate(m, p, q);
}

static void keep_negative(const struct abreast *m, size_t lane, double a[6][6])
{
	double kept[6];
	for (int k = 0; k < 6; k++)
		kept[k] = fmin(m->a[k][k][lane], 0);
	for (int i = 0; i < 6; i++)
		for (int j = 0; j < 6; j++) {
			a[i][j] = 0;
			for (int k = 0; k < 6; k++)
				a[i][j] += m->v[i][k][lane] * kept[k] * m->v[j][k][lane];
		}
}

void vehicle_make_negative(double (*const list[])[6], size_t count)
{
	struct abreast m = {.v = {{{0}}}};
	size_t lanes[VEHICLE_ABREAST], used = 0; /* lanes: their places in the list */
	for (size_t n = 0; n < count; n++) {
		double(*a)[6] = list[n];
		for (int i = 0; i < 6; i++)
			for (int j = 0; j < i; j++)
				a[i][j] = a[j][i] = (a[i][j] + a[j][i]) / 2;
		if (is_negative(a))
			continue;
		for (int i = 0; i < 6; i++) {
			m.v[i][i][used] = 1;
			for (int j = 0; j < 6; j++)
				m.a[i][j][used] = a[i][j];
		}
		lanes[used++] = n;
	}
	if (used > 0)
		rotate_all(&m);
	for (size_t i = 0; i < used; i++)
		keep_negative(&m, i, list[lanes[i]]);
}
