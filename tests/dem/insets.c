/* Insets: how much they count at each post against the closed form, and every allocation that fails. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "dem/dem_inset.h"
#include "files.h"
#include "../support/program.h"

/* --- the rim --- */

/* A rectangle, without data within a circle. */
struct shape {
	int64_t width, height;
	double x, y, radius; /* posts */
};

static bool is_hole(const struct shape *shape, int64_t x, int64_t y)
{
	return hypot((double)x - shape->x, (double)y - shape->y) < shape->radius;
}

static enum status read_shape(void *user, int64_t y, int64_t rows, double *heights)
{
	const struct shape *shape = user;
	for (int64_t i = 0; i < rows * shape->width; i++)
		heights[i] = is_hole(shape, i % shape->width, y + i / shape->width) ? (double)NAN : 5;
	return STATUS_OK;
}

static double least(double a, double b)
{
	return a < b ? a : b;
}

static double rise(double share)
{
	return share >= 1 ? 1 : share * share * (3 - 2 * share);
}

static void the_weight_rises_from_the_outline_by_a_cubic(void **state)
{
	static const struct {
		int64_t width, height;
		double spacing, feather;
	} cases[] = {{61, 41, 1, 8}, {40, 90, 0.25, 2}, {301, 55, 7, 80}};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		struct shape shape = {.width = cases[i].width, .height = cases[i].height, .radius = 0};
		struct inset_rim rim = {.width = shape.width, .height = shape.height, .spacing = cases[i].spacing, .feather = cases[i].feather};
		assert_int_equal(dem_inset_rim_init(&rim, read_shape, &shape), STATUS_OK);
		for (int64_t y = 0; y < shape.height; y++)
			for (int64_t x = 0; x < shape.width; x++) {
				const double far = (double)least((double)least((double)x, (double)(shape.width - 1 - x)),
								 (double)least((double)y, (double)(shape.height - 1 - y))) * cases[i].spacing;
				assert_true(fabs(dem_inset_rim_far(&rim, x, y) - far) < 1e-4 * (1 + far));
				assert_true(fabs(dem_inset_rim_weight(&rim, x, y) - rise(far / cases[i].feather)) < 1e-5);
			}
		dem_inset_rim_finish(&rim);
	}
}

static void in_a_hole_it_falls_again_from_the_edge(void **state)
{
	struct shape shape = {.width = 101, .height = 101, .x = 50, .y = 50, .radius = 20};
	struct inset_rim rim = {.width = 101, .height = 101, .spacing = 1, .feather = 10};
	assert_int_equal(dem_inset_rim_init(&rim, read_shape, &shape), STATUS_OK);
	assert_non_null(rim.deep);
	for (int64_t y = 15; y < 86; y++)
		for (int64_t x = 15; x < 86; x++) {
			double deep = INFINITY;
			for (int64_t v = 25; v <= 75; v++)
				for (int64_t u = 25; u <= 75; u++)
					if (!is_hole(&shape, u, v))
						deep = least(deep, hypot((double)(x - u), (double)(y - v)));
			deep = is_hole(&shape, x, y) ? deep : 0;
			assert_true(fabs(dem_inset_rim_weight(&rim, x, y) - (1 - rise(deep / 10))) < 1e-5);
		}
	dem_inset_rim_finish(&rim);
}

/* --- allocations --- */

static void write_grid(const char *name, int side, double corner, double cell, double height)
{
	char *text = malloc(64 * (size_t)(side * side) + 256), *at = text;
	at += sprintf(at, "ncols %d\nnrows %d\nxllcenter %g\nyllcenter %g\ncellsize %g\nNODATA_value -9999\n", side, side, corner, corner, cell);
	for (int i = 0; i < side * side; i++)
		at += sprintf(at, "%s%c", i == side * side / 2 ? "-9999" : height > 105 ? "110.5" : "100.5", i % side == side - 1 ? '\n' : ' ');
	write_file(name, (const uint8_t *)text, (size_t)(at - text));
	free(text);
}

static enum status drop(void *user, const struct dem_tile *tile)
{
	*(int *)user += 1;
	return STATUS_OK;
}

static enum status none(void *user, struct tile tile, int32_t *codes, double *low, double *high, double *error, bool *found)
{
	*found = false;
	return STATUS_OK;
}

/* Opens and cuts an inset with a hole. */
static enum status cut_one(const struct dem_params *params, struct dem *country, const char *inset, int *tiles)
{
	const struct extent extent = {dem_info(country)->width, dem_info(country)->height, dem_info(country)->spacing, 8};
	struct dem_insets *insets = NULL;
	const struct dem_inset_source source = {&inset, 1, false};
	enum status status = dem_insets_open(&(struct dem_insets_params){.country = country, .extent = &extent, .dem = params, .sources = &source,
									 .count = 1, .feather = -1}, &insets);
	if (status != STATUS_OK)
		return status;
	status = dem_insets_cut(&(struct dem_insets_cut){.insets = insets, .step = 0.001953125, .emit = drop, .emit_user = tiles, .get = none});
	dem_insets_close(insets);
	return status;
}

static void every_failing_allocation_is_told(void **state)
{
	write_grid("country.asc", 12, 0, 8, 100);
	write_grid("inset.asc", 21, 24, 2, 110);
	const char *path = in_folder("country.asc"), *inset = in_folder("inset.asc");
	struct dem_params params = params_of(&path, 1);
	struct dem *country = open_with(&params);
	int tiles = 0;
	(void)mem_fail_nth(0, 0);
	assert_int_equal(cut_one(&params, country, inset, &tiles), STATUS_OK);
	const uint64_t made = mem_fail_nth(0, 0);
	assert_true(tiles > 10 && made > 20);
	for (uint64_t nth = 1; nth <= made; nth++) {
		(void)mem_fail_nth(nth, 0);
		enum status status = cut_one(&params, country, inset, &tiles);
		(void)mem_fail_nth(0, 0);
		assert_true(status != STATUS_OK);
	}
	dem_close(country);
}

TEST_PROGRAM(insets)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_weight_rises_from_the_outline_by_a_cubic),
		cmocka_unit_test(in_a_hole_it_falls_again_from_the_edge),
		cmocka_unit_test(every_failing_allocation_is_told),
	};
	return cmocka_run_group_tests_name("insets", tests, folder_make, folder_remove);
}
