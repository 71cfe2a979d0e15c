/* The powers and exponentials of probes are those of the C library, over the whole range that soils ask for, and never fall where these rise. */
#include <math.h>

#include "support.h"

#include "deform/probe/powers.h"
#include "../support/program.h"

#define MOST_OFF 1e-13 /* relative */
#define STEPS 200000

static double off(double value, double exact)
{
	return fabs(value - exact) / exact;
}

/* Sinkages from a fixed-point unit to a kilometre, exponents from near 0 to the most that a scene may give. */
static void powers_are_those_of_the_c_library(void **state)
{
	static const double exponents[] = {0.01, 0.11, 0.5, 0.79, 1, 1.1, 1.6, 2, 3};
	for (size_t n = 0; n < sizeof exponents / sizeof *exponents; n++) {
		double before = 0;
		for (int i = 0; i <= STEPS; i++) {
			const double z = 0x1p-20 * exp2(30.0 * i / STEPS), value = probe_pow(z, exponents[n]);
			assert_true(off(value, pow(z, exponents[n])) < MOST_OFF);
			assert_true(value > before);
			before = value;
		}
	}
}

/* From no slip displacement to a hundred times the shear modulus, beyond which all shear is mobilised. */
static void exponentials_are_those_of_the_c_library(void **state)
{
	double before = INFINITY;
	for (int i = 0; i <= STEPS; i++) {
		const double way = 100.0 * i / STEPS, value = probe_exp_minus(way), small = 1e-9 * i;
		assert_true(off(value, exp(-way)) < MOST_OFF);
		assert_true(value < before);
		before = value;
		assert_true(off(probe_exp_minus(small), exp(-small)) < MOST_OFF);
	}
	assert_true(probe_exp_minus(0) == 1);
}

static void logarithms_are_those_of_the_c_library(void **state)
{
	for (int i = 0; i <= STEPS; i++) {
		const double rest = 1e-4 + (1 - 1e-4) * i / STEPS;
		assert_true(fabs(probe_minus_log(rest) + log(rest)) < 1e-14 + MOST_OFF * -log(rest));
	}
	assert_true(probe_minus_log(1) == 0);
}

/* A number is split where it passes a power of two, or half of one: nothing jumps there by more than rounding, or falls. */
static void nothing_jumps_where_a_number_is_split(void **state)
{
	for (int k = -20; k <= 10; k++)
		for (int half = 0; half < 2; half++) {
			const double at = ldexp(half ? M_SQRT1_2 : 1, k), below = at * (1 - 1e-12), above = at * (1 + 1e-12);
			assert_true(probe_pow(below, 1.1) < probe_pow(at, 1.1) && probe_pow(at, 1.1) < probe_pow(above, 1.1));
			const double way = (k + 21 - 0.5 * half) * M_LN2;
			assert_true(probe_exp_minus(way * (1 - 1e-12)) > probe_exp_minus(way) && probe_exp_minus(way) > probe_exp_minus(way * (1 + 1e-12)));
		}
}

TEST_PROGRAM(powers)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(powers_are_those_of_the_c_library),
		cmocka_unit_test(exponentials_are_those_of_the_c_library),
		cmocka_unit_test(logarithms_are_those_of_the_c_library),
		cmocka_unit_test(nothing_jumps_where_a_number_is_split),
	};
	return cmocka_run_group_tests_name("deform/powers", tests, NULL, NULL);
}
