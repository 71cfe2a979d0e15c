/* Rasters of numbers from PNGs: interpolated between pixels, the same at a post whatever is read with it; without GDAL too. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>

#include "numbers.h"
#include "../support/program.h"

static const struct extent extent = {9, 7, 2, 8};

/* Of pixels, rows from the north. */
static double value_of(int column, int row)
{
	return (column * 977 + row * 353) % 4001;
}

static double byte_of(int column, int row)
{
	return fmod(value_of(column, row), 256);
}

/* The bilinear value at a place, in posts of level 0: pixels of a PNG are posts from the north-west. */
static double expected(double x, double y, int width, int height)
{
	double column = x, row = (double)extent.height - 1 - y;
	if (column < -0.5 || column > width - 0.5 || row < -0.5 || row > height - 0.5)
		return NAN;
	column = fmin(fmax(column, 0), width - 1);
	row = fmin(fmax(row, 0), height - 1);
	int west = (int)column, north = (int)row, east = west + 1 < width ? west + 1 : west, south = north + 1 < height ? north + 1 : north;
	double along = column - west, down = row - north;
	return (1 - down) * ((1 - along) * value_of(west, north) + along * value_of(east, north)) +
	       down * ((1 - along) * value_of(west, south) + along * value_of(east, south));
}

static void a_png_is_bilinear_between_posts(void **state)
{
	static const int sizes[][2] = {{9, 7}, {4, 3}, {20, 11}, {1, 1}, {1, 7}};
	for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
		int width = sizes[i][0], height = sizes[i][1];
		write_placed_png("n.png", DEM_UINT16, width, height, value_of);
		struct dem_placed_params params = placed("n.png", &extent, "", 1000, -5);
		struct dem_pixels *numbers = open_placed(&params, DEM_PLACED_NUMBERS);
		for (int level = -4; level <= 2; level++) {
			struct post_rect rect = {-20, -20, 180, 140};
			double *values = read_numbers(numbers, level, rect);
			for (int64_t y = rect.y0; y < rect.y1; y++)
				for (int64_t x = rect.x0; x < rect.x1; x++)
					assert_number(values[(y - rect.y0) * 200 + x - rect.x0],
						      expected(ldexp((double)x, level), ldexp((double)y, level), width, height));
			free(values);
		}
		dem_pixels_close(numbers);
	}
	write_placed_png("bytes.png", DEM_UINT8, 9, 7, byte_of);
	struct dem_placed_params params = placed("bytes.png", &extent, "", 0, 0);
	struct dem_pixels *numbers = open_placed(&params, DEM_PLACED_NUMBERS);
	double *values = read_numbers(numbers, 0, (struct post_rect){8, 6, 9, 7});
	assert_true(values[0] == byte_of(8, 0));
	free(values);
	dem_pixels_close(numbers);
	dem_pixels_close(NULL);
}

/* Bit by bit: alone, in a row, in a large rectangle. Coarse levels need more pixels than fit one window. */
static void a_posts_number_depends_on_this_post_alone(void **state)
{
	static const struct extent wide = {1200, 900, 1, 64};
	write_placed_png("n.png", DEM_UINT16, 1200, 900, value_of);
	struct dem_placed_params params = placed("n.png", &wide, "", 0, 0);
	struct dem_pixels *numbers = open_placed(&params, DEM_PLACED_NUMBERS);
	static const int levels[] = {-3, 0, 4};
	for (size_t i = 0; i < 3; i++) {
		struct post_rect all = {-3, -3, 197, 157};
		double *values = read_numbers(numbers, levels[i], all);
		for (int64_t y = all.y0; y < all.y1; y += 13)
			for (int64_t x = all.x0; x < all.x1; x += 7) {
				double *one = read_numbers(numbers, levels[i], (struct post_rect){x, y, x + 1, y + 1});
				double *row = read_numbers(numbers, levels[i], (struct post_rect){x - 5, y - 1, x + 4, y + 1});
				size_t at = (size_t)((y - all.y0) * 200 + x - all.x0);
				assert_memory_equal(&values[at], &one[0], sizeof one[0]);
				assert_memory_equal(&values[at], &row[9 + 5], sizeof one[0]);
				free(one);
				free(row);
			}
		free(values);
	}
	dem_pixels_close(numbers);
}

static void the_least_and_the_greatest_value_are_found(void **state)
{
	double low, high, least = INFINITY, most = -INFINITY;
	write_placed_png("n.png", DEM_UINT16, 1200, 900, value_of);
	for (int y = 0; y < 900; y++)
		for (int x = 0; x < 1200; x++) {
			least = fmin(least, value_of(x, y));
			most = fmax(most, value_of(x, y));
		}
	struct dem_placed_params params = placed("n.png", &extent, "", 0, 0);
	struct dem_pixels *numbers = open_placed(&params, DEM_PLACED_NUMBERS);
	struct dem_numbers_range range = {"cohesion", "Pa", least, most, false};
	assert_int_equal(dem_numbers_extremes(numbers, &range, &low, &high), STATUS_OK);
	assert_true(low == least && high == most);
	range.above = true;
	assert_extremes_refused(numbers, &range, "n.png: column 0, row 0: cohesion 0 Pa is out of range; allowed: above 0 to 4000");
	range = (struct dem_numbers_range){"bekker_n", NULL, -10, 3999, false};
	/* The first pixel that is too large, in rows from the north. */
	int first = 0;
	while (value_of(first % 1200, first / 1200) <= 3999)
		first++;
	char says[120];
	snprintf(says, sizeof says, "column %d, row %d: bekker_n 4000 is out of range; allowed: -10 to 3999", first % 1200, first / 1200);
	assert_extremes_refused(numbers, &range, says);
	dem_pixels_close(numbers);
}

static void what_is_no_png_of_numbers_is_refused(void **state)
{
	uint8_t bytes[33] = "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\2\0\0\0\2\x08\2";
	struct dem_placed_params params = placed("bad.png", &extent, "", 0, 0);
	assert_placed_refused(&params, DEM_PLACED_NUMBERS, "No such file");
	write_file("bad.png", bytes, sizeof bytes);
	assert_placed_refused(&params, DEM_PLACED_NUMBERS, "is in colour, and here it holds numbers");
	bytes[24] = 4, bytes[25] = 0;
	write_file("bad.png", bytes, sizeof bytes);
	assert_placed_refused(&params, DEM_PLACED_NUMBERS, "has 4 bits a pixel; give one of 8 or 16");
	write_file("bad.png", bytes, 20);
	assert_placed_refused(&params, DEM_PLACED_NUMBERS, "is not a PNG");
}

static void memory_that_runs_out_is_told(void **state)
{
	write_placed_png("n.png", DEM_UINT16, 9, 7, value_of);
	struct dem_placed_params params = placed("n.png", &extent, "", 0, 0);
	assert_placed_tells_memory(&params, DEM_PLACED_NUMBERS);
}

TEST_PROGRAM(numbers)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_png_is_bilinear_between_posts),
		cmocka_unit_test(a_posts_number_depends_on_this_post_alone),
		cmocka_unit_test(the_least_and_the_greatest_value_are_found),
		cmocka_unit_test(what_is_no_png_of_numbers_is_refused),
		cmocka_unit_test(memory_that_runs_out_is_told),
	};
	return cmocka_run_group_tests_name("numbers", tests, folder_make, folder_remove);
}
