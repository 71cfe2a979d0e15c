/* Rasters of numbers from PNGs: interpolated between pixels, the same at a post whatever is read with it; without GDAL too. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>

#include "numbers.h"

static const struct extent extent = {9, 7, 2, 8};

/* Of pixels, rows from the north. */
static double value_of(int column, int row)
{
	return (column * 977 + row * 353) % 4001;
}

static void write_png(const char *name, enum dem_raster_type type, int width, int height)
{
	struct dem_raster raster = {.path = in_folder(name), .width = width, .height = height, .type = type, .spacing = 1};
	struct dem_writer *writer;
	assert_int_equal(dem_writer_create(&raster, &writer), STATUS_OK);
	double row[1200];
	for (int y = height - 1; y >= 0; y--) {
		for (int x = 0; x < width; x++)
			row[x] = type == DEM_UINT8 ? fmod(value_of(x, y), 256) : value_of(x, y);
		assert_int_equal(dem_writer_rows(writer, 1, row), STATUS_OK);
	}
	assert_int_equal(dem_writer_publish(writer), STATUS_OK);
	dem_writer_destroy(writer);
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
		write_png("n.png", DEM_UINT16, width, height);
		struct dem_classes_params params = classes_of("n.png", &extent, "", 1000, -5);
		struct dem_numbers *numbers = open_numbers(&params);
		for (int level = -4; level <= 2; level++) {
			struct post_rect rect = {-20, -20, 180, 140};
			double *values = read_numbers(numbers, level, rect);
			for (int64_t y = rect.y0; y < rect.y1; y++)
				for (int64_t x = rect.x0; x < rect.x1; x++)
					assert_number(values[(y - rect.y0) * 200 + x - rect.x0],
						      expected(ldexp((double)x, level), ldexp((double)y, level), width, height));
			free(values);
		}
		dem_numbers_close(numbers);
	}
	write_png("bytes.png", DEM_UINT8, 9, 7);
	struct dem_classes_params params = classes_of("bytes.png", &extent, "", 0, 0);
	struct dem_numbers *numbers = open_numbers(&params);
	double *values = read_numbers(numbers, 0, (struct post_rect){8, 6, 9, 7});
	assert_true(values[0] == fmod(value_of(8, 0), 256));
	free(values);
	dem_numbers_close(numbers);
	dem_numbers_close(NULL);
}

/* Bit by bit: alone, in a row, in a large rectangle. Coarse levels need more pixels than fit one window. */
static void a_posts_number_depends_on_this_post_alone(void **state)
{
	static const struct extent wide = {1200, 900, 1, 64};
	write_png("n.png", DEM_UINT16, 1200, 900);
	struct dem_classes_params params = classes_of("n.png", &wide, "", 0, 0);
	struct dem_numbers *numbers = open_numbers(&params);
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
	dem_numbers_close(numbers);
}

static void the_least_and_the_greatest_value_are_found(void **state)
{
	double low, high, least = INFINITY, most = -INFINITY;
	write_png("n.png", DEM_UINT16, 1200, 900);
	for (int y = 0; y < 900; y++)
		for (int x = 0; x < 1200; x++) {
			least = fmin(least, value_of(x, y));
			most = fmax(most, value_of(x, y));
		}
	struct dem_classes_params params = classes_of("n.png", &extent, "", 0, 0);
	struct dem_numbers *numbers = open_numbers(&params);
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
	dem_numbers_close(numbers);
}

static void what_is_no_png_of_numbers_is_refused(void **state)
{
	uint8_t bytes[33] = "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\2\0\0\0\2\x08\2";
	struct dem_classes_params params = classes_of("bad.png", &extent, "", 0, 0);
	assert_numbers_refused(&params, "No such file");
	write_file("bad.png", bytes, sizeof bytes);
	assert_numbers_refused(&params, "is in colour, and here it holds numbers");
	bytes[24] = 4, bytes[25] = 0;
	write_file("bad.png", bytes, sizeof bytes);
	assert_numbers_refused(&params, "has 4 bits a pixel; give one of 8 or 16");
	write_file("bad.png", bytes, 20);
	assert_numbers_refused(&params, "is not a PNG");
}

static void memory_that_runs_out_is_told(void **state)
{
	write_png("n.png", DEM_UINT16, 9, 7);
	struct dem_classes_params params = classes_of("n.png", &extent, "", 0, 0);
	struct dem_numbers *numbers;
	enum status status;
	uint64_t nth = 0;
	do {
		mem_fail_nth(++nth, 0);
		status = dem_numbers_open(&params, &numbers);
		mem_fail_nth(0, 0);
		assert_true(status == STATUS_OK || numbers == NULL);
		assert_true(status == STATUS_OK || strstr(failure_message(), "memory") != NULL);
	} while (status != STATUS_OK && nth < 100);
	assert_true(status == STATUS_OK && nth > 6);
	dem_numbers_close(numbers);
}

int main(void)
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
