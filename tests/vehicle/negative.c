/*
 * How a stiffness of the soil is made one that resists. What is left has no eigenvalue above 0 and differs from the matrix by what was above 0 alone. A matrix
 * comes to the same bits whatever stands beside it, and however many there are.
 */
#include <math.h>
#include <string.h>

#include "../support.h"
#include "../support/near.h"
#include "../support/program.h"
#include "vehicle/linear.h"

#define MOST VEHICLE_ABREAST

static uint32_t next = 1;

static double number(void)
{
	next = next * 1664525u + 1013904223u;
	return (double)next / 4294967296.0 * 2 - 1;
}

/* Makes a rotation of six axes from planes that turn, in `axes`: columns are unit vectors, at right angles. */
static void turn_axes(double axes[6][6])
{
	memset(axes, 0, 36 * sizeof(double));
	for (int i = 0; i < 6; i++)
		axes[i][i] = 1;
	for (int p = 0; p < 5; p++)
		for (int q = p + 1; q < 6; q++) {
			const double angle = 3 * number(), c = cos(angle), s = sin(angle);
			for (int i = 0; i < 6; i++) {
				const double x = axes[i][p], y = axes[i][q];
				axes[i][p] = c * x - s * y;
				axes[i][q] = s * x + c * y;
			}
		}
}

/* Makes a matrix of known eigenvalues, and what shall be left of it. Some eigenvalues are equal, and some 0. */
static void make(double a[6][6], double left[6][6], double *size)
{
	double axes[6][6], values[6];
	turn_axes(axes);
	*size = 0;
	for (int k = 0; k < 6; k++) {
		values[k] = k > 0 && number() > 0.5 ? values[k - 1] : number() > 0.6 ? 0 : number() * pow(10, 3 * number());
		*size = support_most(*size, fabs(values[k]));
	}
	for (int i = 0; i < 6; i++)
		for (int j = 0; j < 6; j++) {
			const double skew = i == j ? 0 : (i < j ? 1 : -1) * (double)(i + j); /* the mean of it and its transpose has none of that */
			a[i][j] = skew;
			left[i][j] = 0;
			for (int k = 0; k < 6; k++) {
				a[i][j] += axes[i][k] * values[k] * axes[j][k];
				left[i][j] += axes[i][k] * (values[k] < 0 ? values[k] : 0) * axes[j][k];
			}
		}
}

static void what_is_above_zero_is_taken_away(void **state)
{
	double worst = 0;
	(void)state;
	for (int turn = 0; turn < 300; turn++) {
		double a[MOST][6][6], left[MOST][6][6], size[MOST], (*list[MOST])[6];
		const size_t count = 1 + (size_t)turn % MOST;
		for (size_t n = 0; n < count; n++) {
			make(a[n], left[n], &size[n]);
			list[n] = a[n];
		}
		vehicle_make_negative(list, count);
		for (size_t n = 0; n < count; n++)
			for (int i = 0; i < 6; i++)
				for (int j = 0; j < 6; j++) {
					assert_true(a[n][i][j] == a[n][j][i]);
					worst = support_most(worst, fabs(a[n][i][j] - left[n][i][j]) / (size[n] + 10)); /* 10: the skew part is rounded, too */
				}
	}
	print_message("the matrices differ from the closed form by %.2g of their largest eigenvalue, at most\n", worst);
	assert_true(worst < 2e-14);
}

static void a_matrix_alone_has_the_same_bits(void **state)
{
	(void)state;
	for (int turn = 0; turn < 50; turn++) {
		double a[MOST][6][6], alone[MOST][6][6], left[6][6], size, (*list[MOST])[6];
		for (size_t n = 0; n < MOST; n++) {
			make(a[n], left, &size);
			memcpy(alone[n], a[n], sizeof a[n]);
			list[n] = a[n];
		}
		vehicle_make_negative(list, MOST);
		for (size_t n = 0; n < MOST; n++) {
			double(*one[])[6] = {alone[n]};
			vehicle_make_negative(one, 1);
			assert_memory_equal(alone[n], a[n], sizeof a[n]);
		}
	}
}

TEST_PROGRAM(negative)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_is_above_zero_is_taken_away),
		cmocka_unit_test(a_matrix_alone_has_the_same_bits),
	};
	return cmocka_run_group_tests_name("matrices that resist", tests, NULL, NULL);
}
