/* Relief: what it keeps, that it is the same however it is asked for, and its roughness against the definition. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <math.h>
#include <cmocka.h>

#include "../support/near.h"
#include "base/base.h"
#include "../support/program.h"

#define must(call) assert_int_equal(call, STATUS_OK)

static struct relief made(double roughness, double wavelength, uint32_t seed, double spacing, int finest)
{
	const struct relief_spec spec = {.seed = seed, .classes = 1, .waves = {{roughness, wavelength}}};
	struct relief relief;
	relief_make(&spec, spacing, finest, &relief);
	return relief;
}

static int32_t *heights_of(const struct relief *relief, int level, int from, struct post_rect rect)
{
	int32_t *heights = malloc((size_t)(rect.x1 - rect.x0) * (size_t)(rect.y1 - rect.y0) * sizeof *heights);
	must(relief_heights(relief, level, from, rect, heights));
	return heights;
}

/* Places of the ground: near the origin, and 8 km, 10,000 km and 2^41 posts away. The relief does not know of heights. */
static const int64_t places[] = {0, 8000 << 4, (int64_t)10000000 << 4, ((int64_t)1 << 41) - 4096};
enum { PLACES = 4 };

static void posts_of_coarser_levels_stay(void **state)
{
	enum { SIDE = 65 };
	struct relief relief = made(0.3, 8, 7, 4, -5);
	for (int p = 0; p < PLACES; p++)
		for (int from = 0; from >= -3; from--)
			for (int level = -1; level >= -5; level--) {
				const int64_t x = places[p] & ~(int64_t)31, y = places[PLACES - 1 - p] & ~(int64_t)31;
				int32_t *fine = heights_of(&relief, level, from, (struct post_rect){x, y, x + SIDE, y + SIDE});
				int32_t *coarse = heights_of(&relief, level + 1, from, (struct post_rect){x / 2, y / 2, x / 2 + 33, y / 2 + 33});
				int raised = 0;
				for (int j = 0; j < SIDE; j++)
					for (int i = 0; i < SIDE; i++) {
						int32_t height = fine[j * SIDE + i];
						raised += height != 0;
						if (i % 2 == 0 && j % 2 == 0)
							assert_int_equal(height, coarse[j / 2 * 33 + i / 2]);
						if (level < from && (i & ((1 << (from - level)) - 1)) == 0 && (j & ((1 << (from - level)) - 1)) == 0)
							assert_int_equal(height, 0); /* a post of the source */
					}
				assert_true(level < from ? raised > SIDE * SIDE / 2 : raised == 0);
				free(fine);
				free(coarse);
			}
}

/* Any rectangle, across edges of tiles and of pieces, has what its posts have one by one. */
static void it_is_the_same_on_any_tiles(void **state)
{
	struct relief relief = made(0.05, 20, 1, 10, -8);
	for (int p = 0; p < PLACES; p++) {
		const struct post_rect whole = {places[p], places[p] + 77, places[p] + 600, places[p] + 77 + 9};
		int32_t *all = heights_of(&relief, -8, 0, whole);
		for (int64_t width = 1; width < 600; width = width * 3 + 1)
			for (int64_t x = whole.x0; x + width <= whole.x1; x += width) {
				int32_t *part = heights_of(&relief, -8, 0, (struct post_rect){x, whole.y0 + 3, x + width, whole.y0 + 5});
				for (int j = 0; j < 2; j++)
					assert_memory_equal(part + j * width, all + (3 + j) * 600 + (x - whole.x0), (size_t)width * sizeof *part);
				free(part);
			}
		free(all);
	}
}

/* The mean over each cell of the source, by the trapezoidal rule: zero but for the rounding of each post. */
static void the_mean_over_a_cell_is_zero(void **state)
{
	static const struct {
		double spacing, wavelength;
		int level, from;
	} cases[] = {{1, 2, -4, 0}, {30, 2, -6, 0}, {30, 60, -6, 0}, {4, 100, -3, 0}, {16, 3, -6, -2}, {1, 0.2, -7, 0}};
	for (size_t c = 0; c < sizeof cases / sizeof *cases; c++)
		for (int p = 0; p < PLACES; p++) {
			const int level = cases[c].level, shift = cases[c].from - level;
			const int64_t cell = (int64_t)1 << shift;
			struct relief relief = made(0.4, cases[c].wavelength, 99, cases[c].spacing, level);
			assert_true(relief_any(&relief));
			for (int k = 0; k < 6; k++) {
				const int64_t x = ((places[p] >> shift) + k) << shift, y = ((places[p] >> shift) + 2 * k) << shift;
				int32_t *heights = heights_of(&relief, level, cases[c].from, (struct post_rect){x, y, x + cell + 1, y + cell + 1});
				double sum = 0, edge = 0, most = 0;
				for (int64_t j = 0; j <= cell; j++)
					for (int64_t i = 0; i <= cell; i++) {
						const double height = heights[j * (cell + 1) + i];
						sum += height * (i % cell == 0 ? 0.5 : 1) * (j % cell == 0 ? 0.5 : 1);
						edge += j == 0 ? height : 0;
						most = support_most(most, fabs(height));
					}
				assert_true(most > 1000); /* mm */
				assert_true(edge != 0);   /* edges are raised, too */
				if (!(fabs(sum / (double)(cell * cell)) <= 0.5))
					fail_msg("spacing %g, wavelength %g: a cell's mean is off by %g quanta", cases[c].spacing, cases[c].wavelength,
						 sum / (double)(cell * cell));
				free(heights);
			}
		}
}

/* The variance that the detail of a level gives to posts `finer` levels finer, of that of its midpoints: by hand. A cell's corner has
 * none, its middle and its midpoints have one, and the middle's covariance with each midpoint is -1/2. */
static double share(int finer)
{
	const double own = 1.0 / 3 + ldexp(1.0 / 6, -2 * finer), between = 1.0 / 6 - ldexp(1.0 / 6, -2 * finer);
	return 3 * own * own - 2 * own * between;
}

/* Root mean square, by the definition: the levels' variances halve, and of infinitely many the sum over an area is the roughness'. */
static double expected_rms(double roughness, double wavelength, double spacing, int level)
{
	double variance = 0;
	for (int at = -1; at >= level; at--) {
		double first = wavelength / 2 / (spacing * ldexp(1, at)), step = 1;
		if (first < 1)
			continue;
		while (step * 2 <= first)
			step *= 2;
		variance += 2.25 * roughness * roughness / step * share(at - level);
	}
	return sqrt(variance);
}

static void the_roughness_is_that_asked_for(void **state)
{
	static const struct {
		double spacing, wavelength, roughness;
		int level;
	} cases[] = {{30, 2, 0.02, -9}, {4, 4, 0.05, -6}, {1, 2, 0.01, -5}, {1, 2, 0.01, -2}, {10, 80, 1.5, -3}};
	enum { SIDE = 1024 };
	for (size_t c = 0; c < sizeof cases / sizeof *cases; c++)
		for (uint32_t seed = 1; seed < 4; seed++)
			for (int p = 0; p < PLACES; p++) {
				struct relief relief = made(cases[c].roughness, cases[c].wavelength, seed * 7919, cases[c].spacing, cases[c].level);
				const struct post_rect rect = {places[p], places[p], places[p] + SIDE, places[p] + SIDE};
				int32_t *heights = heights_of(&relief, cases[c].level, 0, rect);
				double squares = 0, sum = 0;
				const double expected = expected_rms(cases[c].roughness, cases[c].wavelength, cases[c].spacing, cases[c].level);
				const double bound = relief_bound(&relief, 0);
				for (int i = 0; i < SIDE * SIDE; i++) {
					const double height = lattice_base_metres(heights[i]);
					assert_true(fabs(height) <= bound);
					squares += height * height;
					sum += height;
				}
				const double rms = sqrt(squares / SIDE / SIDE);
				if (!(fabs(rms / expected - 1) <= 0.06))
					fail_msg("spacing %g, seed %u, place %d: rms %g, not %g", cases[c].spacing, seed, p, rms, expected);
				if (ldexp(cases[c].spacing, cases[c].level) <= cases[c].wavelength / 32 && cases[c].spacing >= cases[c].wavelength)
					assert_true(fabs(rms / cases[c].roughness - 1) < 0.1);
				assert_true(fabs(sum / SIDE / SIDE) < 0.02 * rms);
				free(heights);
			}
}

/* What a level adds to its new posts, over all levels: its variance halves from level to level, a spectrum with the square of the wave number. */
static void variances_halve_from_level_to_level(void **state)
{
	enum { SIDE = 513 };
	for (uint32_t seed = 1; seed < 4; seed++) {
		struct relief relief = made(0.1, 16, seed, 16, -6);
		for (int level = -1; level >= -6; level--) {
			const int64_t x = places[seed] & ~(int64_t)1;
			int32_t *heights = heights_of(&relief, level, 0, (struct post_rect){x, x, x + SIDE, x + SIDE});
			double squares = 0;
			size_t count = 0;
			for (int j = 0; j < SIDE; j += 2)
				for (int i = 1; i < SIDE; i += 2, count++) {
					const int32_t *at = heights + j * SIDE + i;
					const double detail = *at - 0.5 * ((double)at[-1] + at[1]);
					squares += detail * detail;
				}
			const double rms = ldexp(sqrt(squares / (double)count), -BASE_BITS), expected = 1.5 * 0.1 * sqrt(ldexp(1, level + 1));
			if (!(fabs(rms / expected - 1) <= 0.03))
				fail_msg("seed %u, level %d: %g, not %g", seed, level, rms, expected);
			free(heights);
		}
	}
}

static void longer_waves_than_asked_for_have_none(void **state)
{
	/* 2 m: levels with posts 1 m apart and less. */
	struct relief relief = made(0.02, 2, 7, 8, -6);
	assert_int_equal(relief.coarsest, -3);
	assert_true(relief_has_level(&relief, -3) && !relief_has_level(&relief, -2) && relief_any(&relief));
	relief = made(0.02, 1.999, 7, 8, -6);
	assert_int_equal(relief.coarsest, -4);
	relief = made(0.02, 2, 7, 8, -2);
	assert_false(relief_any(&relief));
	assert_true(relief_bound(&relief, 0) == 0 && relief_rms(&relief, 0) == 0 && relief_bound(NULL, 0) == 0);
	relief = made(0, 2, 7, 8, -6);
	assert_false(relief_any(&relief));
	/* A source that has the longer waves itself gets the rest of the same spectrum. */
	struct relief rest = made(0.02, 8, 7, 1, -4), all = made(0.02, 8, 7, 8, -7);
	for (int band = 0; band < 4; band++)
		assert_int_equal(rest.amplitudes[0][band], all.amplitudes[0][band + 3]);
	/* All together, over an area, it is the roughness; and the finer, the less. */
	all = made(0.02, 8, 7, 8, -14);
	assert_true(fabs(relief_rms(&all, 0) - 0.02) < 1e-5 && relief_rms(&all, -4) < 0.01 && relief_bound(&all, -4) < relief_bound(&all, 0));
}

/* The closed form beside slopes that are counted: along both axes, and how many are steeper than a multiple of it. */
static void slopes_are_as_steep_as_the_closed_form_says(void **state)
{
	static const struct {
		double roughness, wavelength, spacing;
		int finest;
	} cases[] = {{0.02, 2, 1, -1}, {0.02, 2, 1, -4}, {0.05, 8, 1, -5}, {0.3, 3, 20, -6}, {0.1, 50, 20, -7}};
	enum { ACROSS = 1025 };
	for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
		struct relief relief = made(cases[c].roughness, cases[c].wavelength, 11, cases[c].spacing, cases[c].finest);
		const double apart = ldexp(cases[c].spacing, cases[c].finest), told = relief_slope(&relief, 0, cases[c].spacing);
		const struct post_rect rect = {4096, 8192, 4096 + ACROSS, 8192 + ACROSS};
		int32_t *heights = heights_of(&relief, cases[c].finest, 0, rect);
		for (int axis = 0; axis < 2; axis++) {
			const size_t step = axis == 0 ? 1 : ACROSS;
			double squares = 0, steep = 0, count = 0;
			for (size_t y = 0; y + 1 < ACROSS; y++)
				for (size_t x = 0; x + 1 < ACROSS; x++) {
					const size_t at = y * ACROSS + x;
					const double slope = lattice_base_metres((int64_t)heights[at + step] - heights[at]) / apart;
					squares += slope * slope;
					steep += fabs(slope) > 1.5 * told;
					count++;
				}
			print_message("%g m, %g m, %g m apart: slope %.4f, %.4f by the closed form; %.3f steeper than 1.5 of it\n", cases[c].roughness,
				      cases[c].wavelength, apart, sqrt(squares / count), told, steep / count);
			assert_true(fabs(sqrt(squares / count) / told - 1) < 0.03);
			/* of a normal distribution: 0.134 */
			assert_true(steep / count > 0.1 && steep / count < 0.16);
		}
		free(heights);
	}
	assert_true(relief_slope(NULL, 0, 1) == 0);
}

static void seeds_differ_and_are_kept(void **state)
{
	enum { COUNT = 100 * 100 };
	const struct post_rect rect = {1000, 2000, 1100, 2100};
	struct relief one = made(0.02, 2, 7, 1, -4), same = made(0.02, 2, 7, 1, -4), other = made(0.02, 2, 8, 1, -4);
	int32_t *a = heights_of(&one, -4, 0, rect), *b = heights_of(&same, -4, 0, rect), *c = heights_of(&other, -4, 0, rect);
	double together = 0, squares = 0;
	assert_memory_equal(a, b, COUNT * sizeof *a);
	for (int i = 0; i < COUNT; i++) {
		together += (double)a[i] * c[i];
		squares += (double)a[i] * a[i];
	}
	assert_true(fabs(together) < 0.1 * squares);
	free(a);
	free(b);
	free(c);
}

/* The western half is of class 1, and two columns beside it of class 2. */
static enum status halves(void *user, int level, struct post_rect rect, uint8_t *classes)
{
	const int64_t edge = (int64_t)100 << -level;
	++*(int *)user;
	for (int64_t y = rect.y0; y < rect.y1; y++)
		for (int64_t x = rect.x0; x < rect.x1; x++)
			*classes++ = x < edge ? 1 : x < edge + ((int64_t)2 << -level) ? 2 : 0;
	return STATUS_OK;
}

static void classes_have_their_own(void **state)
{
	const struct relief_spec spec = {.seed = 5, .classes = 3, .waves = {{0, 2}, {0.05, 2}, {0.5, 1}}};
	enum { LEVEL = -3, CELL = 8, SIDE = 30 * CELL + 1 };
	int calls = 0;
	const struct relief_map map = {halves, &calls};
	struct relief relief, alone = made(0.05, 2, 5, 1, LEVEL);
	relief_make(&spec, 1, LEVEL, &relief);
	relief.map = &map;
	const int64_t x0 = 85 * CELL, y0 = 40 * CELL;
	const struct post_rect rect = {x0, y0, x0 + SIDE, y0 + SIDE};
	int32_t *heights = heights_of(&relief, LEVEL, 0, rect), *west = heights_of(&alone, LEVEL, 0, rect);
	assert_int_equal(calls, 3);
	for (int j = 0; j < SIDE; j++) {
		assert_memory_equal(heights + j * SIDE, west + j * SIDE, 14 * CELL * sizeof *west); /* left of the edge */
		for (int i = 18 * CELL; i < SIDE; i++)
			assert_int_equal(heights[j * SIDE + i], 0);
	}
	/* The mean over each cell is zero across borders, too, and tiles agree. */
	for (int cy = 0; cy < 30; cy++)
		for (int cx = 0; cx < 30; cx++) {
			double sum = 0;
			for (int j = 0; j <= CELL; j++)
				for (int i = 0; i <= CELL; i++)
					sum += heights[(cy * CELL + j) * SIDE + cx * CELL + i] * (i % CELL == 0 ? 0.5 : 1) * (j % CELL == 0 ? 0.5 : 1);
			assert_true(fabs(sum) <= 0.5 * CELL * CELL);
		}
	int32_t one;
	for (int64_t i = 0; i < SIDE; i += 7) {
		must(relief_heights(&relief, LEVEL, 0, (struct post_rect){x0 + i, y0 + 33, x0 + i + 1, y0 + 34}, &one));
		assert_int_equal(one, heights[33 * SIDE + i]);
	}
	mem_fail_nth(1, 0);
	assert_int_equal(relief_heights(&relief, LEVEL, 0, rect, heights), STATUS_FAILED);
	mem_fail_nth(0, 0);
	free(heights);
	free(west);
}

static void a_text_is_what_it_was(void **state)
{
	struct relief_spec spec = {.seed = 4294967295u, .classes = 1, .waves = {{0.02, 2.5}}}, read;
	char *text = relief_print(&spec);
	assert_string_equal(text, "{\"roughness\":0.02,\"wavelength\":2.5,\"seed\":4294967295}");
	assert_true(relief_parse(text, &read) && memcmp(&read, &spec, sizeof spec) == 0);
	mem_free(text);
	spec.classes = 3;
	spec.map[0] = 0xfedcba9876543210;
	spec.map[1] = 1;
	spec.waves[1] = (struct relief_waves){0.1, 1.0 / 3};
	spec.waves[2] = (struct relief_waves){0, 1e-3};
	text = relief_print(&spec);
	assert_true(relief_parse(text, &read) && memcmp(&read, &spec, sizeof spec) == 0);
	mem_free(text);
	static const char *const wrong[] = {"", "7", "[]", "{", "{\"roughness\":0.02,\"wavelength\":2}", "{\"roughness\":11,\"wavelength\":2,\"seed\":1}",
		"{\"roughness\":0.02,\"wavelength\":0,\"seed\":1}", "{\"roughness\":-1,\"wavelength\":2,\"seed\":1}",
		"{\"roughness\":0.02,\"wavelength\":2,\"seed\":1.5}", "{\"roughness\":\"a\",\"wavelength\":2,\"seed\":1}",
		"{\"roughness\":1e999,\"wavelength\":2,\"seed\":1}", "{\"seed\":1,\"classes\":[]}", "{\"seed\":1,\"map\":\"12\",\"classes\":[{},{}]}",
		"{\"seed\":1,\"map\":\"00000000000000000000000000000000\",\"classes\":[{\"roughness\":1,\"wavelength\":2}]}"};
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
		assert_false(relief_parse(wrong[i], &read));
}

TEST_PROGRAM(relief)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(posts_of_coarser_levels_stay),
		cmocka_unit_test(it_is_the_same_on_any_tiles),
		cmocka_unit_test(the_mean_over_a_cell_is_zero),
		cmocka_unit_test(the_roughness_is_that_asked_for),
		cmocka_unit_test(variances_halve_from_level_to_level),
		cmocka_unit_test(longer_waves_than_asked_for_have_none),
		cmocka_unit_test(slopes_are_as_steep_as_the_closed_form_says),
		cmocka_unit_test(seeds_differ_and_are_kept),
		cmocka_unit_test(classes_have_their_own),
		cmocka_unit_test(a_text_is_what_it_was),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
