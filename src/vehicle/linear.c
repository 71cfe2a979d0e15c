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

/* The number of lanes is a constant where these are called, so that their loops become vector instructions. */
#define INLINED static inline __attribute__((always_inline))

/* Symmetric matrices side by side: a wide vector has a number of each. Of `a` the entries on and above the diagonal count. */
struct abreast {
	double a[6][6][VEHICLE_ABREAST], v[6][6][VEHICLE_ABREAST];
};

/* A rotation in the plane of two axes, of each matrix. */
struct rotation {
	double cosine[VEHICLE_ABREAST], sine[VEHICLE_ABREAST];
};

INLINED void turn(int lanes, double *restrict x, double *restrict y, const struct rotation *restrict r)
{
	for (int i = 0; i < lanes; i++) {
		const double was_x = x[i], was_y = y[i];
		x[i] = r->cosine[i] * was_x - r->sine[i] * was_y;
		y[i] = r->sine[i] * was_x + r->cosine[i] * was_y;
	}
}

/* One rotation of Jacobi's: a' = r^T a r has no entry at (p, q), p < q; v collects the rotations. turns: 0 or 1, of each matrix: 0 leaves it as it is. */
INLINED void rotate(int lanes, struct abreast *m, const double *restrict turns, int p, int q)
{
	struct rotation r;
	for (int i = 0; i < lanes; i++) {
		const double here = m->a[p][q][i] * turns[i], ratio = (m->a[q][q][i] - m->a[p][p][i]) / (2 * here);
		const double t = (ratio >= 0 ? 1.0 : -1.0) / (fabs(ratio) + sqrt(1 + ratio * ratio)), c = 1 / sqrt(1 + t * t), by = here == 0 ? 0 : t;
		r.cosine[i] = here == 0 ? 1 : c;
		r.sine[i] = here == 0 ? 0 : t * c;
		m->a[p][p][i] -= by * here;
		m->a[q][q][i] += by * here;
		m->a[p][q][i] -= here;
	}
	for (int k = 0; k < p; k++)
		turn(lanes, m->a[k][p], m->a[k][q], &r);
	for (int k = p + 1; k < q; k++)
		turn(lanes, m->a[p][k], m->a[k][q], &r);
	for (int k = q + 1; k < 6; k++)
		turn(lanes, m->a[p][k], m->a[q][k], &r);
	for (int k = 0; k < 6; k++)
		turn(lanes, m->v[k][p], m->v[k][q], &r);
}

#define ROUNDS 8
#define DIAGONAL 1e-18 /* of the largest eigenvalue: entries beside the diagonal that change nothing any more */

/* Finds which matrices are not diagonal yet. Each is looked at alone, so those beside it change none of its bits. Returns how many. */
INLINED double turns_of(int lanes, const struct abreast *m, double *restrict turns)
{
	double beside[VEHICLE_ABREAST] = {0}, on[VEHICLE_ABREAST] = {0}, any = 0;
	for (int p = 0; p < 6; p++)
		for (int i = 0; i < lanes; i++)
			on[i] = fabs(m->a[p][p][i]) > on[i] ? fabs(m->a[p][p][i]) : on[i];
	for (int p = 0; p < 5; p++)
		for (int q = p + 1; q < 6; q++)
			for (int i = 0; i < lanes; i++)
				beside[i] = fabs(m->a[p][q][i]) > beside[i] ? fabs(m->a[p][q][i]) : beside[i];
	for (int i = 0; i < lanes; i++)
		turns[i] = beside[i] > DIAGONAL * on[i] ? 1 : 0;
	for (int i = 0; i < lanes; i++)
		any += turns[i];
	return any;
}

/* Puts v min(a, 0) v^T into the entries on and above the diagonal. */
INLINED void keep_negative(int lanes, struct abreast *m)
{
	double kept[6][VEHICLE_ABREAST], row[6][VEHICLE_ABREAST];
	for (int k = 0; k < 6; k++)
		for (int i = 0; i < lanes; i++)
			kept[k][i] = m->a[k][k][i] < 0 ? m->a[k][k][i] : 0;
	for (int p = 0; p < 6; p++) {
		for (int k = 0; k < 6; k++)
			for (int i = 0; i < lanes; i++)
				row[k][i] = m->v[p][k][i] * kept[k][i];
		for (int q = p; q < 6; q++) {
			double sum[VEHICLE_ABREAST] = {0};
			for (int k = 0; k < 6; k++)
				for (int i = 0; i < lanes; i++)
					sum[i] += row[k][i] * m->v[q][k][i];
			for (int i = 0; i < lanes; i++)
				m->a[p][q][i] = sum[i];
		}
	}
}

INLINED void make_negative(int lanes, struct abreast *m)
{
	double turns[VEHICLE_ABREAST];
	for (int round = 0; round < ROUNDS && turns_of(lanes, m, turns) > 0; round++)
		for (int p = 0; p < 5; p++)
			for (int q = p + 1; q < 6; q++)
				rotate(lanes, m, turns, p, q);
	keep_negative(lanes, m);
}

/* Few matrices take fewer lanes. A lane's bits do not depend on how many there are. */
FURROW_WIDE static void make_4_negative(struct abreast *m)
{
	make_negative(4, m);
}

FURROW_WIDE static void make_8_negative(struct abreast *m)
{
	make_negative(8, m);
}

FURROW_WIDE static void make_12_negative(struct abreast *m)
{
	make_negative(12, m);
}
_Static_assert(VEHICLE_ABREAST == 12, "make_12_negative");

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
		(used <= 4 ? make_4_negative : used <= 8 ? make_8_negative : make_12_negative)(&m);
	for (size_t n = 0; n < used; n++)
		for (int i = 0; i < 6; i++)
			for (int j = i; j < 6; j++)
				list[lanes[n]][i][j] = list[lanes[n]][j][i] = m.a[i][j][n];
}
