/* Maps of classes from PNGs; without GDAL too. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>

#include "classes.h"
#include "../support/program.h"

static const struct extent extent = {9, 7, 2, 8};

/* Of pixels, rows from the north. */
static double value_of(int column, int row)
{
	return column + 16 * row;
}

static double too_large(int column, int row)
{
	return value_of(column, row) + 200;
}

static void check(struct dem_pixels *classes, int level, struct post_rect rect, int width, int height)
{
	uint8_t *values = read_classes(classes, level, rect);
	for (int64_t y = rect.y0; y < rect.y1; y++)
		for (int64_t x = rect.x0; x < rect.x1; x++) {
			double column = floor(ldexp((double)x, level) + 0.5), row = floor(6 - ldexp((double)y, level) + 0.5);
			/* Half a pixel on the rim is the pixel's. */
			column -= column == width && ldexp((double)x, level) == width - 0.5;
			row -= row == height && 6 - ldexp((double)y, level) == height - 0.5;
			bool in = column >= 0 && column < width && row >= 0 && row < height;
			int expected = in ? (int)value_of((int)column, (int)row) : ABSENT;
			assert_int_equal(values[(y - rect.y0) * (rect.x1 - rect.x0) + x - rect.x0], expected);
		}
	free(values);
}

static void a_png_is_a_pixel_a_post_from_the_north_west(void **state)
{
	const enum dem_raster_type types[] = {DEM_UINT8, DEM_UINT16};
	const int sizes[][2] = {{9, 7}, {4, 3}, {20, 11}, {1, 1}};
	for (size_t i = 0; i < 8; i++) {
		int width = sizes[i / 2][0], height = sizes[i / 2][1];
		write_placed_png("map.png", types[i % 2], width, height, value_of);
		struct dem_placed_params params = placed("map.png", &extent, "", 1000, -5);
		struct dem_pixels *classes = open_placed(&params, DEM_PLACED_CLASSES);
		check(classes, 0, (struct post_rect){0, 0, 9, 7}, width, height);
		check(classes, 0, (struct post_rect){-30, -30, 40, 40}, width, height);
		check(classes, 0, (struct post_rect){3, 2, 4, 3}, width, height);
		check(classes, 0, (struct post_rect){3, 2, 3, 3}, width, height);
		check(classes, 1, (struct post_rect){-2, -2, 6, 6}, width, height);
		check(classes, 3, (struct post_rect){0, 0, 9, 9}, width, height);
		check(classes, -1, (struct post_rect){-4, -4, 30, 30}, width, height);
		check(classes, -5, (struct post_rect){-40, 100, 217, 357}, width, height);
		dem_pixels_close(classes);
	}
}

static void the_table_says_what_a_value_becomes(void **state)
{
	write_placed_png("map.png", DEM_UINT8, 9, 7, value_of);
	struct dem_placed_params params = placed("map.png", &extent, "", 0, 0);
	struct dem_pixels *classes = open_placed(&params, DEM_PLACED_CLASSES);
	uint8_t table[256] = {[0] = 3, [1] = 4}, values[3];
	assert_int_equal(dem_classes_read(classes, 0, (struct post_rect){-1, 6, 2, 7}, table, 9, values), STATUS_OK);
	assert_true(values[0] == 9 && values[1] == 3 && values[2] == 4);
	dem_pixels_close(classes);
	dem_pixels_close(NULL);
}

static void what_is_no_png_of_classes_is_refused(void **state)
{
	uint8_t bytes[33] = "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\2\0\0\0\2\x08\2";
	struct dem_placed_params params = placed("bad.png", &extent, "", 0, 0);
	assert_placed_refused(&params, DEM_PLACED_CLASSES, "No such file");
	write_file("bad.png", bytes, sizeof bytes);
	assert_placed_refused(&params, DEM_PLACED_CLASSES, "is in colour, and classes are numbers");
	bytes[25] = 3;
	write_file("bad.png", bytes, sizeof bytes);
	assert_placed_refused(&params, DEM_PLACED_CLASSES, "is in colour");
	bytes[24] = 4, bytes[25] = 0;
	write_file("bad.png", bytes, sizeof bytes);
	assert_placed_refused(&params, DEM_PLACED_CLASSES, "has 4 bits a pixel; give one of 8 or 16");
	bytes[24] = 8, bytes[16] = 1, bytes[20] = 1;
	write_file("bad.png", bytes, sizeof bytes);
	assert_placed_refused(&params, DEM_PLACED_CLASSES, "16777218 x 16777218 pixels are too many in a PNG");
	bytes[16] = bytes[20] = 0;
	write_file("bad.png", bytes, sizeof bytes);
	assert_placed_refused(&params, DEM_PLACED_CLASSES, "cannot be read as a PNG");
	write_file("bad.png", bytes, 20);
	assert_placed_refused(&params, DEM_PLACED_CLASSES, "is not a PNG");
	write_file("bad.png", "P5 2 2 255 abcd and some more of that", 37);
	assert_placed_refused(&params, DEM_PLACED_CLASSES, "is not a PNG");
	write_placed_png("whole.png", DEM_UINT8, 60, 4, value_of);
	char whole[400];
	snprintf(whole, sizeof whole, "%s", in_folder("whole.png"));
	assert_int_equal(truncate(whole, 50), 0);
	params.path = whole;
	assert_placed_refused(&params, DEM_PLACED_CLASSES, "cannot be read as a PNG");
	write_placed_png("large.png", DEM_UINT16, 9, 7, too_large);
	params.path = in_folder("large.png");
	assert_read_refused(&params, (struct post_rect){0, 0, 9, 7}, "column 0, row 6: its value 296 is no class; allowed: 0 to 255");
	struct dem_pixels *classes = open_placed(&params, DEM_PLACED_CLASSES);
	uint8_t *values = read_classes(classes, 0, (struct post_rect){0, 6, 9, 7});
	assert_int_equal(values[8], 208); /* where it is one */
	free(values);
	dem_pixels_close(classes);
}

static void memory_that_runs_out_is_told(void **state)
{
	write_placed_png("map.png", DEM_UINT8, 9, 7, value_of);
	struct dem_placed_params params = placed("map.png", &extent, "", 0, 0);
	assert_placed_tells_memory(&params, DEM_PLACED_CLASSES);
}

TEST_PROGRAM(classes)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_png_is_a_pixel_a_post_from_the_north_west),
		cmocka_unit_test(the_table_says_what_a_value_becomes),
		cmocka_unit_test(what_is_no_png_of_classes_is_refused),
		cmocka_unit_test(memory_that_runs_out_is_told),
	};
	return cmocka_run_group_tests_name("classes", tests, folder_make, folder_remove);
}
