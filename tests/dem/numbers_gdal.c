/* Rasters of numbers from GeoTIFFs: any SRS, nodata, scale, and what is refused. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>

#include "numbers.h"
#include "placed_gdal.h"
#include "../support/program.h"

/* A plane: interpolated anywhere it is itself. */
static double plane(int column, int row)
{
	return 100 + 3.5 * column - 1.25 * row;
}

static double plane_with_holes(int column, int row)
{
	return column % 5 == 2 && row % 4 == 1 ? -1 : plane(column, row);
}

static struct tif numbers_tif(const char *name)
{
	struct tif raster = utm(name);
	raster.type = GDT_Float64;
	raster.value_of = plane;
	return raster;
}

static struct dem_pixels *opened(const struct tif *raster)
{
	make(raster);
	struct dem_placed_params params = placed(raster->name, &extent, wkt_of(ZONE), WEST, SOUTH);
	return open_placed(&params, DEM_PLACED_NUMBERS);
}

static void check_plane(const struct tif *raster, int level, struct post_rect rect)
{
	size_t count = (size_t)((rect.x1 - rect.x0) * (rect.y1 - rect.y0)), inside = 0;
	double *columns = malloc(count * sizeof *columns), *rows = malloc(count * sizeof *rows);
	struct dem_pixels *numbers = opened(raster);
	double *values = read_numbers(numbers, level, rect);
	place_posts(raster, 0, level, rect, columns, rows);
	for (size_t i = 0; i < count; i++) {
		double x = columns[i], y = rows[i];
		if (fabs(x) < 1e-5 || fabs(x - raster->width) < 1e-5 || fabs(y) < 1e-5 || fabs(y - raster->height) < 1e-5)
			continue;
		bool in = x > 0 && x < raster->width && y > 0 && y < raster->height;
		/* Middles of pixels are half a pixel in; beyond the rim's middles its own value goes on. */
		double column = fmin(fmax(x - 0.5, 0), raster->width - 1), row = fmin(fmax(y - 0.5, 0), raster->height - 1);
		assert_number(values[i], in ? 100 + 3.5 * column - 1.25 * row : NAN);
		inside += in;
	}
	assert_true(inside > 500);
	free(values);
	free(columns);
	free(rows);
	dem_pixels_close(numbers);
}

static void a_plane_is_itself_wherever_posts_lie(void **state)
{
	struct tif raster = numbers_tif("own.tif");
	for (int level = -3; level <= 2; level++)
		check_plane(&raster, level, (struct post_rect){-30, -30, 220, 160});
	memcpy(raster.place, (double[]){WEST + 203.3, 33.7 * cos(0.4), 20 * sin(0.4), SOUTH + 300.7, 33.7 * sin(0.4), -20 * cos(0.4)},
	       sizeof raster.place); /* turned */
	check_plane(&raster, 0, (struct post_rect){-30, -30, 220, 160});
	raster.srs = "EPSG:4326";
	memcpy(raster.place, (double[]){14.9987, 0.0004, 0, 45.163, 0, -0.0003}, sizeof raster.place);
	check_plane(&raster, 0, (struct post_rect){-30, -30, 220, 160});
	check_plane(&raster, -2, (struct post_rect){0, 200, 250, 360});
}

/* A post whose pixel has no value has none. Others are not drawn towards a hole. */
static void holes_are_where_the_nearest_pixel_has_none(void **state)
{
	struct tif raster = numbers_tif("holes.tif");
	const struct post_rect rect = {0, 0, 320, 240};
	enum { COUNT = 320 * 240 };
	double *columns = malloc(COUNT * sizeof *columns), *rows = malloc(COUNT * sizeof *rows), low, high;
	raster.value_of = plane_with_holes;
	raster.tag = true;
	raster.nodata = -1;
	struct dem_pixels *numbers = opened(&raster);
	double *values = read_numbers(numbers, -2, rect);
	place_posts(&raster, 0, -2, rect, columns, rows);
	int holes = 0, beside = 0, inside = 0;
	for (int i = 0; i < COUNT; i++) {
		double x = columns[i], y = rows[i];
		if (x >= raster.width || y <= 0 || y >= raster.height || fabs(x - round(x)) < 1e-6 || fabs(y - round(y)) < 1e-6)
			continue;
		bool hole = plane_with_holes((int)x, (int)y) < 0;
		assert_true(isnan(values[i]) == hole);
		holes += hole;
		if (hole)
			continue;
		int west = (int)floor(x - 0.5), north = (int)floor(y - 0.5);
		double sum = 0, weights = 0;
		for (int k = 0; k < 4; k++) {
			int column = west + (k & 1), row = north + (k >> 1);
			column = column < 0 ? 0 : column < raster.width ? column : raster.width - 1;
			row = row < 0 ? 0 : row < raster.height ? row : raster.height - 1;
			double value = plane_with_holes(column, row), weight = (1 - fabs(x - 0.5 - (west + (k & 1)))) * (1 - fabs(y - 0.5 - (north + (k >> 1))));
			sum += value < 0 ? 0 : weight * value;
			weights += value < 0 ? 0 : weight;
		}
		beside += weights < 0.99;
		inside += weights > 0.99;
		assert_number(values[i], sum / weights);
	}
	assert_true(holes > 100 && beside > 100 && inside > 100);
	const struct dem_numbers_range range = {"cohesion", "Pa", 0, 1e9, false};
	assert_int_equal(dem_numbers_extremes(numbers, &range, &low, &high), STATUS_OK); /* nodata counts as none */
	assert_true(low == plane(0, 29) && high == plane(39, 0));
	free(values);
	free(columns);
	free(rows);
	dem_pixels_close(numbers);
}

static double whole(int column, int row)
{
	return column + row;
}

static double not_a_number(int column, int row)
{
	return column == 3 ? (double)NAN : 5;
}

static double infinite(int column, int row)
{
	return column == 3 && row == 1 ? (double)INFINITY : 5;
}

static void scale_offset_and_nan_are_understood(void **state)
{
	const struct dem_numbers_range range = {"cohesion", "Pa", -1e9, 1e9, false};
	double low, high;
	struct tif raster = numbers_tif("scaled.tif");
	raster.type = GDT_UInt16;
	raster.value_of = whole;
	raster.scale = 0.25;
	raster.offset = -3;
	struct dem_pixels *numbers = opened(&raster);
	assert_int_equal(dem_numbers_extremes(numbers, &range, &low, &high), STATUS_OK);
	assert_true(low == -3 && high == -3 + 0.25 * 68);
	dem_pixels_close(numbers);
	raster = numbers_tif("nan.tif");
	raster.type = GDT_Float32;
	raster.value_of = not_a_number;
	numbers = opened(&raster);
	assert_int_equal(dem_numbers_extremes(numbers, &range, &low, &high), STATUS_OK);
	assert_true(low == 5 && high == 5);
	double *values = read_numbers(numbers, 0, (struct post_rect){-15, 60, -10, 61}); /* in column 3 */
	assert_true(isnan(values[1]) && isnan(values[4]));
	free(values);
	dem_pixels_close(numbers);
	raster.name = "infinite.tif";
	raster.value_of = infinite;
	numbers = opened(&raster);
	assert_extremes_refused(numbers, &range, "column 3, row 1: cohesion inf Pa is out of range; allowed: -1000000000 to 1000000000");
	dem_pixels_close(numbers);
}

static void what_is_no_raster_of_numbers_is_refused(void **state)
{
	const struct dem_numbers_range range = {"cohesion", "Pa", 0, 1e9, false};
	struct tif raster = numbers_tif("bad.tif");
	struct dem_placed_params params = placed("bad.tif", &extent, wkt_of(ZONE), WEST, SOUTH);
	assert_placed_refused(&params, DEM_PLACED_NUMBERS, "cannot be opened as a raster of soil numbers");
	raster.type = GDT_CFloat32;
	make(&raster);
	assert_placed_refused(&params, DEM_PLACED_NUMBERS, "holds CFloat32, and numbers are real");
	raster.type = GDT_Float32;
	make(&raster);
	params.srs = "";
	assert_placed_refused(&params, DEM_PLACED_NUMBERS, "lies on a planet, and the store is local metres");
	struct dem_pixels *numbers = opened(&raster);
	dem_pixels_close(numbers);
	char path[400];
	snprintf(path, sizeof path, "%s", in_folder("bad.tif"));
	assert_int_equal(truncate(path, 3000), 0);
	params = placed("bad.tif", &extent, wkt_of(ZONE), WEST, SOUTH);
	if (dem_pixels_open(&params, DEM_PLACED_NUMBERS, &numbers) != STATUS_OK) { /* a driver may look for the end at once */
		assert_told("cannot be opened as a raster of soil numbers", path);
		return;
	}
	assert_extremes_refused(numbers, &range, "reading it failed at column 0, row");
	dem_pixels_close(numbers);
}

TEST_PROGRAM(numbers_gdal)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_plane_is_itself_wherever_posts_lie),
		cmocka_unit_test(holes_are_where_the_nearest_pixel_has_none),
		cmocka_unit_test(scale_offset_and_nan_are_understood),
		cmocka_unit_test(what_is_no_raster_of_numbers_is_refused),
	};
	return cmocka_run_group_tests_name("numbers_gdal", tests, folder_make, folder_remove);
}
