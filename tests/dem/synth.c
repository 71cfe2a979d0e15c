/* Synthetic terrain: the same posts whatever is asked with them, within its relief. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <cmocka.h>

#include "dem/dem.h"
#include "../support/program.h"

enum { W = 611, H = 97 };

static void rows_of(const struct dem_synth *synth, int64_t y0, int64_t rows, double *heights)
{
	dem_synth_posts(synth, (struct post_rect){0, y0, synth->width, y0 + rows}, heights);
}

static struct dem_synth synth_of(enum dem_synth_kind kind)
{
	return (struct dem_synth){kind, W, H, 2, 120, 5};
}

static void a_post_does_not_depend_on_the_strip_it_is_asked_in(void **state)
{
	double *all = mem_alloc(W * H, sizeof *all), *row = mem_alloc(W, sizeof *row);
	for (int kind = DEM_SYNTH_RIDGED; kind <= DEM_SYNTH_PLAIN; kind++) {
		struct dem_synth synth = synth_of((enum dem_synth_kind)kind);
		rows_of(&synth, 0, H, all);
		for (int64_t y = H - 1; y >= 0; y--) {
			rows_of(&synth, y, 1, row);
			assert_memory_equal(row, all + y * W, W * sizeof *row);
		}
	}
	mem_free(all);
	mem_free(row);
}

static void heights_lie_within_the_relief_and_use_it(void **state)
{
	double *all = mem_alloc(W * H, sizeof *all);
	for (int kind = DEM_SYNTH_RIDGED; kind <= DEM_SYNTH_PLAIN; kind++) {
		struct dem_synth synth = synth_of((enum dem_synth_kind)kind);
		rows_of(&synth, 0, H, all);
		double low = 1e9, high = -1e9;
		for (int i = 0; i < W * H; i++) {
			assert_true(all[i] >= 0 && all[i] <= synth.relief);
			low = fmin(low, all[i]);
			high = fmax(high, all[i]);
		}
		assert_true(high - low > 0.2 * synth.relief);
	}
	mem_free(all);
}

static void seeds_and_kinds_differ(void **state)
{
	double *a = mem_alloc(W, sizeof *a), *b = mem_alloc(W, sizeof *b);
	struct dem_synth synth = synth_of(DEM_SYNTH_RIDGED), other = synth;
	other.seed++;
	rows_of(&synth, 3, 1, a);
	rows_of(&other, 3, 1, b);
	assert_memory_not_equal(a, b, W * sizeof *a);
	other = synth_of(DEM_SYNTH_PLAIN);
	rows_of(&other, 3, 1, b);
	assert_memory_not_equal(a, b, W * sizeof *a);
	mem_free(a);
	mem_free(b);
}

/* A plain has no cliffs: the cells of the noise meet where they must. */
static void neighbouring_posts_are_close(void **state)
{
	double *all = mem_alloc(W * H, sizeof *all);
	struct dem_synth synth = synth_of(DEM_SYNTH_PLAIN);
	synth.spacing = 0.05;
	rows_of(&synth, 0, H, all);
	for (int y = 0; y + 1 < H; y++)
		for (int x = 0; x + 1 < W; x++) {
			assert_true(fabs(all[y * W + x + 1] - all[y * W + x]) < 0.02 * synth.relief);
			assert_true(fabs(all[(y + 1) * W + x] - all[y * W + x]) < 0.02 * synth.relief);
		}
	mem_free(all);
}

static void no_relief_is_level_ground(void **state)
{
	double *row = mem_alloc(W, sizeof *row);
	struct dem_synth synth = synth_of(DEM_SYNTH_DUNES);
	synth.relief = 0;
	rows_of(&synth, 0, 1, row);
	for (int x = 0; x < W; x++)
		assert_true(row[x] == 0);
	mem_free(row);
}

TEST_PROGRAM(synth)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_post_does_not_depend_on_the_strip_it_is_asked_in),
		cmocka_unit_test(heights_lie_within_the_relief_and_use_it),
		cmocka_unit_test(seeds_and_kinds_differ),
		cmocka_unit_test(neighbouring_posts_are_close),
		cmocka_unit_test(no_relief_is_level_ground),
	};
	return cmocka_run_group_tests_name("synth", tests, NULL, NULL);
}
