/* The pure functions every part shares: interpolation, decimation, rounding, references. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <cmocka.h>

#include "base/base.h"
#include "../support/program.h"

static uint32_t seed = 1;
static int32_t any_height(void)
{
	seed = seed * 1664525u + 1013904223u;
	return (int32_t)(seed >> 2) - (1 << 29);
}

static void interpolation_at_a_corner_is_the_corner(void **state)
{
	for (int shift = 0; shift <= 14; shift++) {
		uint32_t s = 1u << shift;
		int32_t a = any_height(), b = any_height(), c = any_height(), d = any_height();
		assert_int_equal(lattice_interpolate(a, b, c, d, 0, 0, shift), a);
		assert_int_equal(lattice_interpolate(a, b, c, d, s, 0, shift), b);
		assert_int_equal(lattice_interpolate(a, b, c, d, 0, s, shift), c);
		assert_int_equal(lattice_interpolate(a, b, c, d, s, s, shift), d);
	}
}

static void interpolation_is_within_half_a_unit_of_the_exact_value(void **state)
{
	for (int i = 0; i < 20000; i++) {
		int shift = i % 15;
		uint32_t s = 1u << shift, fx = (uint32_t)any_height() % (s + 1), fy = (uint32_t)any_height() % (s + 1);
		int32_t a = any_height(), b = any_height(), c = any_height(), d = any_height();
		long double u = (long double)fx / s, v = (long double)fy / s;
		long double exact = (a * (1 - u) + b * u) * (1 - v) + (c * (1 - u) + d * u) * v;
		long double off = lattice_interpolate(a, b, c, d, fx, fy, shift) - exact;
		assert_true(off <= 0.5000001L && off >= -0.5000001L);
	}
}

static void interpolation_ignores_a_hole_without_weight(void **state)
{
	assert_int_equal(lattice_interpolate(5, BASE_NODATA, 7, BASE_NODATA, 0, 1, 1), 6);
	assert_int_equal(lattice_interpolate(5, BASE_NODATA, 7, 8, 1, 1, 1), BASE_NODATA);
	assert_int_equal(lattice_interpolate(5, BASE_NODATA, BASE_NODATA, BASE_NODATA, 0, 0, 3), 5);
}

/* Law 4 below zero: a level's decimation is the next coarser level, whatever way it was made. */
static void subdividing_twice_as_fine_and_decimating_gives_the_coarser_tile(void **state)
{
	enum { N = 16 };
	for (int shift = 1; shift <= 7; shift++) {
		int32_t patch[(N + 1) * (N + 1)], fine[(N + 1) * (N + 1)], coarse[(N + 1) * (N + 1)],
			up[(N + 1) * (N + 1)];
		/* One whole level-0 tile; the patch of a finer tile is cut from it. */
		int32_t zero[(N + 1) * (N + 1)];
		for (int i = 0; i < (N + 1) * (N + 1); i++)
			zero[i] = i % 37 == 5 ? BASE_NODATA : any_height();
		for (int tile = 0; tile < 8; tile++) {
			uint32_t tx = (uint32_t)any_height() % (1u << shift), ty = (uint32_t)any_height() % (1u << shift);
			for (int pass = 0; pass < 2; pass++) {
				int s = shift - pass;
				uint32_t gx = (tx >> pass) * N, gy = (ty >> pass) * N; /* in 2^-s cells */
				uint32_t posts = lattice_patch_posts(N, s), cx = gx >> s, cy = gy >> s;
				for (uint32_t y = 0; y < posts; y++)
					for (uint32_t x = 0; x < posts; x++)
						patch[y * posts + x] = zero[(cy + y) * (N + 1) + cx + x];
				lattice_subdivide(patch, N, s, gx - (cx << s), gy - (cy << s), pass == 0 ? fine : coarse);
			}
			for (int i = 0; i < (N + 1) * (N + 1); i++)
				up[i] = coarse[i];
			lattice_decimate_i32(fine, N, tx & 1, ty & 1, up);
			assert_memory_equal(up, coarse, sizeof up);
		}
	}
}

static void a_reference_makes_earths_heights_fit(void **state)
{
	assert_true(lattice_fits(-10994, 4000));
	assert_true(lattice_fits(8000, 8848.86));
	assert_false(lattice_fits(-10994, 8848));
	assert_int_equal(lattice_reference(8000, 8848) % 1024, 0);
	int32_t reference = lattice_reference(8000, 8848.86);
	assert_int_equal(lattice_base_relative(8848.5, reference),
			 ((int64_t)2 * 8848 + 1 - 2 * (int64_t)reference) << (BASE_BITS - 1));
	assert_int_equal(lattice_base_relative((double)NAN, reference), BASE_NODATA);
}

/* A row is coded as its heights are one by one, up to the first that cannot be. */
static void a_row_of_heights_is_coded_as_each(void **state)
{
	static const double wild[] = {0, -0.0, 0.001, 0.003, 1e5, -4294967.2, 4294967.0, 4294966.0, 4294966.5, 8589934.0,
				      -8589934.5, 1e300, (double)INFINITY, -(double)INFINITY, 5.5};
	enum { WILD = sizeof wild / sizeof *wild };
	for (int round = 0; round < 4000; round++) {
		double heights[64], step = round % 3 == 0 ? 0 : 0.002;
		int32_t row[64], one = 0;
		int64_t good = 0;
		for (int i = 0; i < 64; i++) {
			int64_t any = any_height();
			heights[i] = any % 41 == 0  ? (double)NAN
				     : any % 97 == 0 ? wild[(uint64_t)any / 97 % WILD]
						     : (double)(float)(any / 7919.0);
		}
		while (good < 64 && height_code_encode(heights[good], step, &one))
			good++;
		assert_int_equal(height_code_row(heights, 64, step, row), good);
		for (int64_t i = 0; i < good; i++) {
			assert_true(height_code_encode(heights[i], step, &one));
			assert_int_equal(row[i], one);
		}
	}
}

static void height_codes_keep_the_promised_error(void **state)
{
	for (int i = 0; i < 20000; i++) {
		double height = any_height() / 7919.0, step = 0.002;
		int32_t code = 0;
		assert_true(height_code_encode(height, step, &code));
		assert_true(fabs(height_code_metres(code, step) - height) <= step / 2 * (1 + 1e-9));
		float exact = (float)height;
		assert_true(height_code_encode(exact, 0, &code));
		float back = (float)height_code_metres(code, 0);
		assert_memory_equal(&back, &exact, sizeof back);
	}
	int32_t code = 0, before = 0;
	float zero = -0.0f, back;
	assert_true(height_code_encode(zero, 0, &code));
	back = (float)height_code_metres(code, 0);
	assert_memory_equal(&back, &zero, sizeof back);
	assert_true(height_code_encode(-1e-30f, 0, &before));
	assert_true(before < code);
	assert_false(height_code_encode((double)INFINITY, 0.002, &code));
	assert_false(height_code_encode((double)INFINITY, 0, &code));
	assert_false(height_code_encode(0.1, 0, &code)); /* not a float32 */
	assert_false(height_code_encode(1e9, 0.002, &code));
}

TEST_PROGRAM(lattice)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(interpolation_at_a_corner_is_the_corner),
		cmocka_unit_test(interpolation_is_within_half_a_unit_of_the_exact_value),
		cmocka_unit_test(interpolation_ignores_a_hole_without_weight),
		cmocka_unit_test(subdividing_twice_as_fine_and_decimating_gives_the_coarser_tile),
		cmocka_unit_test(a_reference_makes_earths_heights_fit),
		cmocka_unit_test(a_row_of_heights_is_coded_as_each),
		cmocka_unit_test(height_codes_keep_the_promised_error),
	};
	return cmocka_run_group_tests_name("lattice", tests, NULL, NULL);
}
