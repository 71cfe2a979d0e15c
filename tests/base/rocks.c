/* Rocks: their cover and diameters against the law, and that they are the same however they are asked for. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <math.h>
#include <cmocka.h>

#include "base/base.h"
#include "base/rocks.h"
#include "../support/near.h"
#include "../support/program.h"

#define must(call) assert_int_equal(call, STATUS_OK)

static struct rocks made(const struct rocks_spec *spec, double spacing)
{
	struct rocks rocks;
	rocks_make(spec, spacing, &rocks);
	return rocks;
}

/* The law itself, told anew. */
static double law(const struct rocks_spec *spec, double diameter)
{
	const double q = 1.79 + 0.152 / spec->k;
	return spec->cover * (exp(-q * diameter) - exp(-q * spec->largest));
}

static const struct rocks_spec specs[] = {
	{0.05, 0.05, 0.1, 1, 7}, {0.2, 0.2, 0.15, 1.2, 1}, {0.4, 0.1, 0.2, 0.7, 4000000000},
};
static const double spacings[] = {0.25, 1, 2.7};

/* Counts the share of posts that rocks raise, over a square of so many metres. */
static double share_of_posts(const struct rocks *rocks, double spacing, double side)
{
	int level = 0;
	while (ldexp(spacing, level) > 0.1)
		level--;
	const int64_t posts = (int64_t)(side / ldexp(spacing, level)), rows = 64;
	int32_t *heights = malloc((size_t)(posts * rows) * sizeof *heights);
	int64_t raised = 0, all = 0;
	for (int64_t y = 0; y < posts; y += rows) {
		rocks_heights(rocks, level, (struct post_rect){0, y, posts, y + rows}, heights);
		for (int64_t i = 0; i < posts * rows; i++)
			raised += heights[i] > 0;
		all += posts * rows;
	}
	free(heights);
	return (double)raised / (double)all;
}

static void they_cover_what_the_law_says(void **state)
{
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++) {
			const struct rocks rocks = made(&specs[i], spacings[k]);
			const double share = share_of_posts(&rocks, spacings[k], 350), expected = law(&specs[i], specs[i].smallest);
			assert_true(fabs(share / expected - 1) < 0.02);
			assert_true(fabs(rocks_cover(&specs[i], 0) / expected - 1) < 1e-9);
		}
}

struct list {
	double *diameters, area;
	size_t count, room;
	double lowest_ratio, highest_ratio, highest;
};

static bool take(void *user, const struct rock *rock)
{
	struct list *list = user;
	if (list->count == list->room) {
		list->room = list->room > 0 ? 2 * list->room : 1024;
		list->diameters = realloc(list->diameters, list->room * sizeof *list->diameters);
	}
	list->diameters[list->count++] = rock->diameter;
	list->area += M_PI / 4 * rock->diameter * rock->diameter;
	list->lowest_ratio = fmin(list->lowest_ratio, rock->height / rock->diameter);
	list->highest_ratio = fmax(list->highest_ratio, rock->height / rock->diameter);
	list->highest = fmax(list->highest, rock->height);
	return true;
}

static int by_size(const void *a, const void *b)
{
	const double *x = a, *y = b;
	return (*x > *y) - (*x < *y);
}

/* Kolmogorov's test at 0.1 %, nine times, of the diameters in a list, and the areas that the list sums to. */
static void the_list_has_the_laws_diameters(void **state)
{
	enum { STEPS = 20000 };
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++) {
			const struct rocks_spec *spec = &specs[i];
			const struct rocks rocks = made(spec, spacings[k]);
			const double side = 300, q = 1.79 + 0.152 / spec->k;
			struct list list = {.lowest_ratio = 1};
			rocks_each(&rocks, 0, 0, side, side, take, &list);
			qsort(list.diameters, list.count, sizeof *list.diameters, by_size);
			double sum = 0, apart = 0, *sums = malloc((STEPS + 1) * sizeof *sums);
			for (int s = 0; s < STEPS; s++) {
				const double d = spec->smallest + (spec->largest - spec->smallest) * (s + 0.5) / STEPS;
				sums[s] = sum;
				sum += spec->cover * q * exp(-q * d) / (1 - law(spec, d)) / (M_PI / 4 * d * d) * (spec->largest - spec->smallest) / STEPS;
			}
			sums[STEPS] = sum;
			for (size_t n = 0; n < list.count; n++) {
				const double at = (list.diameters[n] - spec->smallest) / (spec->largest - spec->smallest) * STEPS;
				const int s = (int)fmin(fmax(at, 0), STEPS - 1);
				const double expected = (sums[s] + (sums[s + 1] - sums[s]) * (at - s)) / sum;
				const double above = fabs(expected - (double)n / (double)list.count), below = fabs(expected - (double)(n + 1) / (double)list.count);
				apart = support_most(apart, support_most(above, below));
			}
			assert_true(list.count > 5000);
			assert_true(apart < 1.95 / sqrt((double)list.count));
			assert_true(fabs((double)list.count / (sum * side * side) - 1) < 4 / sqrt((double)list.count));
			assert_true(fabs(rocks_density(spec) / sum - 1) < 1e-3);
			assert_true(fabs((1 - exp(-list.area / side / side)) / law(spec, spec->smallest) - 1) < 0.02);
			assert_true(list.lowest_ratio > 0.374 && list.lowest_ratio < 0.38 && list.highest_ratio > 0.6 && list.highest_ratio < 0.61);
			assert_true(list.highest <= rocks_bound(&rocks));
			free(list.diameters);
			free(sums);
		}
}

/* Near the origin, and 8 km, 10,000 km and 2^41 posts away. */
static const int64_t places[] = {0, 8000 << 4, (int64_t)10000000 << 4, ((int64_t)1 << 41) - 4096};
enum { PLACES = 4, SIDE = 65 };

static void posts_are_the_same_in_any_rectangle_and_at_any_level(void **state)
{
	int32_t all[SIDE * SIDE], part[SIDE * SIDE], coarse[33 * 33];
	size_t raised = 0;
	for (int i = 0; i < 3; i++)
		for (int p = 0; p < PLACES; p++)
			for (int level = -10; level <= 6; level++) {
				const struct rocks rocks = made(&specs[i], spacings[i]);
				const int64_t x = (places[p] >> (level > 0 ? level : 0)) & ~(int64_t)1, y = (places[PLACES - 1 - p] >> (level > 0 ? level : 0)) & ~(int64_t)1;
				rocks_heights(&rocks, level, (struct post_rect){x, y, x + SIDE, y + SIDE}, all);
				for (int k = 0; k < SIDE * SIDE; k++)
					raised += all[k] > 0;
				for (int64_t width = 1; width < SIDE; width = width * 3 + 1)
					for (int64_t at = 0; at + width <= SIDE; at += width)
						for (int64_t row = 0; row < SIDE; row += 7) {
							rocks_heights(&rocks, level, (struct post_rect){x + at, y + row, x + at + width, y + row + 1}, part);
							assert_memory_equal(part, all + row * SIDE + at, (size_t)width * sizeof *part);
						}
				rocks_heights(&rocks, level + 1, (struct post_rect){x / 2, y / 2, x / 2 + 33, y / 2 + 33}, coarse);
				for (int k = 0; k < 33 * 33; k++)
					assert_int_equal(coarse[k], all[k / 33 * 2 * SIDE + k % 33 * 2]);
			}
	assert_true(raised > 10000);
}

/* A rock alone: of the height that the list tells at most and three quarters of it at least, on an outline of its area. */
static bool keep(void *user, const struct rock *rock)
{
	*(struct rock *)user = *rock;
	return false;
}

static void a_rock_has_the_listed_place_height_and_area(void **state)
{
	for (uint32_t seed = 0; seed < 40; seed++) {
		const struct rocks_spec spec = {0.001, 1, 0.95, 1, seed};
		const struct rocks rocks = made(&spec, 1);
		struct rock rock = {.diameter = 0};
		rocks_each(&rocks, 20, 20, 2000, 2000, keep, &rock);
		assert_true(rock.diameter >= 0.949 && rock.diameter <= 1.001);
		const double fine = ldexp(1, -8);
		const int64_t x = (int64_t)(rock.x / fine), y = (int64_t)(rock.y / fine), reach = 180;
		const int64_t side = 2 * reach + 1;
		int32_t *heights = malloc((size_t)(side * side) * sizeof *heights), highest = 0;
		int64_t raised = 0;
		double east = 0, north = 0;
		rocks_heights(&rocks, -8, (struct post_rect){x - reach, y - reach, x + reach + 1, y + reach + 1}, heights);
		for (int64_t k = 0; k < side * side; k++) {
			highest = heights[k] > highest ? heights[k] : highest;
			raised += heights[k] > 0;
			east += (heights[k] > 0) * (double)(x - reach + k % side) * fine;
			north += (heights[k] > 0) * (double)(y - reach + k / side) * fine;
		}
		assert_true(lattice_base_metres(highest) <= rock.height && lattice_base_metres(highest) > 0.74 * rock.height);
		assert_true(fabs((double)raised * fine * fine / (M_PI / 4 * rock.diameter * rock.diameter) - 1) < 0.01);
		assert_true(fabs(east / (double)raised - rock.x) < 0.01 && fabs(north / (double)raised - rock.y) < 0.01);
		free(heights);
	}
}

static void another_seed_makes_other_rocks_and_none_makes_none(void **state)
{
	int32_t a[SIDE * SIDE], b[SIDE * SIDE];
	struct rocks_spec spec = specs[0];
	const struct post_rect rect = {40, 40, 40 + SIDE, 40 + SIDE};
	struct rocks rocks = made(&spec, 0.5);
	rocks_heights(&rocks, -2, rect, a);
	spec.seed++;
	rocks = made(&spec, 0.5);
	rocks_heights(&rocks, -2, rect, b);
	assert_memory_not_equal(a, b, sizeof a);
	spec.cover = 0;
	rocks = made(&spec, 0.5);
	assert_false(rocks_any(&rocks));
	assert_false(rocks_any(NULL));
	rocks_heights(&rocks, -2, rect, b);
	for (int i = 0; i < SIDE * SIDE; i++)
		assert_int_equal(b[i], 0);
	assert_true(rocks_bound(&rocks) == 0 && rocks_error(&rocks, 0) == 0 && rocks_density(&spec) == 0);
}

static void the_text_is_read_as_it_was_written(void **state)
{
	static const char *const bad[] = {
		"{\"rocks\":{}}", "{\"rocks\":1}", "{\"rocks\":{\"cover\":0.05,\"k\":0.05,\"smallest\":1,\"largest\":1,\"seed\":7}}",
		"{\"rocks\":{\"cover\":1,\"k\":0.05,\"smallest\":0.1,\"largest\":1,\"seed\":7}}",
		"{\"rocks\":{\"cover\":0.05,\"k\":0,\"smallest\":0.1,\"largest\":1,\"seed\":7}}",
		"{\"rocks\":{\"cover\":0.05,\"k\":0.05,\"smallest\":0.001,\"largest\":1,\"seed\":7}}",
		"{\"rocks\":{\"cover\":0.05,\"k\":0.05,\"smallest\":1e-12,\"largest\":1e-11,\"seed\":7}}",
		"{\"rocks\":{\"cover\":0.05,\"k\":0.05,\"smallest\":0.1,\"largest\":1,\"seed\":0.5}}",
		"{\"rocks\":{\"cover\":0.05,\"k\":0.05,\"smallest\":0.1,\"largest\":1,\"seed\":7},\"roughness\":1}",
	};
	struct relief_spec read;
	struct rocks_spec rocks;
	for (int i = 0; i < 6; i++) {
		const struct relief_spec spec = {.seed = 9, .classes = 1, .waves = {{0.1, 3}}}, none = {0};
		char *text = rocks_print(i % 2 == 0 ? &spec : NULL, i < 4 ? &specs[i / 2] : NULL);
		if (i == 5) {
			assert_string_equal(text, "{}");
			assert_false(rocks_parse(text, &read, &rocks));
		} else {
			assert_true(rocks_parse(text, &read, &rocks));
			assert_memory_equal(&rocks, i < 4 ? &specs[i / 2] : &(struct rocks_spec){0}, sizeof rocks);
			assert_memory_equal(&read, i % 2 == 0 ? &spec : &none, sizeof read);
		}
		mem_free(text);
	}
	for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
		assert_false(rocks_parse(bad[i], &read, &rocks));
}

TEST_PROGRAM(rocks)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(they_cover_what_the_law_says),
		cmocka_unit_test(the_list_has_the_laws_diameters),
		cmocka_unit_test(posts_are_the_same_in_any_rectangle_and_at_any_level),
		cmocka_unit_test(a_rock_has_the_listed_place_height_and_area),
		cmocka_unit_test(another_seed_makes_other_rocks_and_none_makes_none),
		cmocka_unit_test(the_text_is_read_as_it_was_written),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
