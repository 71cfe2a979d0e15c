/* The law's own powers and exponentials are those of the C library within their told errors, over the whole range that soils ask for. */
#include "soil/law/real.h"
#include "soil_test.h"
#include "../support/program.h"

#define STEPS 200000

static double off(float value, double exact)
{
	return fabs((double)value / exact - 1);
}

static void powers_of_two_are_those_of_the_c_library(void **state)
{
	double worst = 0;
	for (int i = 0; i <= STEPS; i++) {
		const float x = (float)(-126 + 252.0 * i / STEPS), near = (float)(-1 + 2.0 * i / STEPS);
		worst = support_most(worst, support_most(off(exp2_of(x), exp2((double)x)), off(exp2_of(near), exp2((double)near))));
	}
	print_message("2^x: off by at most %.3g\n", worst);
	assert_true(worst < 2e-7);
	for (int k = -126; k <= 126; k++)
		assert_true(exp2_of((float)k) == (float)ldexp(1, k));
}

static void logarithms_are_those_of_the_c_library(void **state)
{
	double worst = 0;
	for (int i = 0; i <= STEPS; i++) {
		const float v = (float)exp2(-120 + 240.0 * i / STEPS), near = (float)exp2(-2 + 4.0 * i / STEPS);
		const double exact = log2((double)v), close = log2((double)near);
		worst = support_most(worst, fabs((double)log2_of(v) - exact) / (1e-7 + 2e-7 * fabs(exact)));
		worst = support_most(worst, fabs((double)log2_of(near) - close) / (1e-7 + 2e-7 * fabs(close)));
	}
	print_message("log2: off by at most %.3g of its told error\n", worst);
	assert_true(worst < 1 && log2_of(1) == 0 && log2_of(8) == 3);
}

/* Sinkages from a fixed-point unit to 128 m, exponents from near 0 to the most that a scene may give. */
static void powers_are_those_of_the_c_library(void **state)
{
	static const double exponents[] = {0.01, 0.11, 0.5, 0.79, 1, 1.1, 1.6, 2, 3};
	double worst = 0;
	for (size_t n = 0; n < sizeof exponents / sizeof *exponents; n++) {
		float before = 0;
		for (int i = 0; i <= STEPS; i++) {
			const float z = (float)(0x1p-20 * exp2(27.0 * i / STEPS)), value = power_of(z, (float)exponents[n]);
			const double exact = pow((double)z, (double)(float)exponents[n]);
			/* The error of the logarithm counts as often as the exponent says. */
			worst = support_most(worst, off(value, exact) / (3e-7 + exponents[n] * M_LN2 * (1e-7 + 2e-7 * fabs(log2((double)z)))));
			assert_true(value >= before * (1 - 4e-7f));
			before = value;
		}
	}
	print_message("powers: off by at most %.3g of what their parts allow\n", worst);
	assert_true(worst < 1);
}

/* From no slip displacement to a hundred times the shear modulus, beyond which all shear is mobilised. */
static void exponentials_are_those_of_the_c_library(void **state)
{
	double worst = 0;
	for (int i = 0; i <= STEPS; i++) {
		const float way = (float)(80.0 * i / STEPS), small = (float)(1e-6 * i);
		worst = support_most(worst, support_most(off(exp_minus(way), exp(-(double)way)) / (2e-7 + 1e-7 * (double)way), off(exp_minus(small), exp(-(double)small)) / 3e-7));
	}
	print_message("exp: off by at most %.3g of what rounding of its argument allows\n", worst);
	assert_true(worst < 1 && exp_minus(0) == 1 && exp_minus(1000) == exp_minus(80) && exp_minus(80) < 1e-30f);
}

static void whole_numbers_are_the_nearest(void **state)
{
	for (int i = 0; i < STEPS; i++) {
		const float v = (float)(any_share() * exp2(30.0 * i / STEPS));
		assert_true(fabs((double)whole_of(v) - (double)v) <= (fabsf(v) < 0x1p22f ? 0.5 : 1));
	}
	assert_true(whole_of(0.5f) == 1 && whole_of(-0.5f) == -1 && whole_of(-2147483000.0f) == -2147483008);
}

TEST_PROGRAM(real)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(powers_of_two_are_those_of_the_c_library),
		cmocka_unit_test(logarithms_are_those_of_the_c_library),
		cmocka_unit_test(powers_are_those_of_the_c_library),
		cmocka_unit_test(exponentials_are_those_of_the_c_library),
		cmocka_unit_test(whole_numbers_are_the_nearest),
	};
	return cmocka_run_group_tests_name("soil/real", tests, NULL, NULL);
}
