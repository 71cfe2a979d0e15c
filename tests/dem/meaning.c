/* What a stored value means: nodata by its tag or named, sentinels, scale, offset, feet, kernels at holes. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "raster.h"
#include "../support/program.h"

#define HOLE (-9999.0)

static double ramp_with_hole(int x, int y)
{
	return x == 4 && y == 5 ? HOLE : ramp(x, y);
}

static void nodata_is_what_its_tag_or_the_user_says_and_nan(void **state)
{
	struct made made = utm("hole.tif");
	made.height_of = ramp_with_hole;
	struct dem *dem = make_and_open(&made);
	assert_true(height_at(dem, 4, 1) == HOLE); /* nothing says so */
	dem_close(dem);
	const char *path = in_folder("hole.tif");
	const double value = HOLE;
	struct dem_params params = params_of(&path, 1);
	params.nodata = &value;
	params.nodata_count = 1;
	dem = open_with(&params);
	assert_true(isnan(height_at(dem, 4, 1)));
	assert_true(height_at(dem, 5, 1) == ramp(5, 5));
	dem_close(dem);
	made.tag = true;
	made.nodata = HOLE;
	dem = make_and_open(&made);
	assert_true(isnan(height_at(dem, 4, 1)));
	dem_close(dem);
}

static double sentinel(int x, int y)
{
	return x == 0 ? -3.4028234663852886e38 : x == 1 ? (double)NAN : x == 2 ? (double)-32767.1f : 5.25;
}

/* Tags are decimal text, often with fewer digits than the float they mean. */
static void a_float_sentinel_is_found_by_its_rounded_tag(void **state)
{
	struct made made = utm("float.tif");
	made.type = GDT_Float32;
	made.height_of = sentinel;
	make(&made);
	const char *path = in_folder("float.tif");
	const double values[] = {-3.40282e38, -32767.1};
	struct dem_params params = params_of(&path, 1);
	params.nodata = values;
	params.nodata_count = 2;
	struct dem *dem = open_with(&params);
	assert_true(dem_info(dem)->unit == 0);
	for (int x = 0; x < 3; x++)
		assert_true(isnan(height_at(dem, x, 3)));
	assert_true(height_at(dem, 3, 3) == 5.25);
	dem_close(dem);
}

static void scale_offset_and_feet_become_metres(void **state)
{
	struct made made = utm("scaled.tif");
	made.scale = 0.1;
	made.offset = 1000;
	made.tag = true;
	made.nodata = 120; /* as it is stored: x 2, y 0 */
	struct dem *dem = make_and_open(&made);
	assert_true(fabs(dem_info(dem)->unit - 0.1) < 1e-12);
	assert_true(fabs(height_at(dem, 3, 6) - 1013) < 1e-4);
	assert_true(isnan(height_at(dem, 2, 6)));
	dem_close(dem);
	made = utm("feet.tif");
	made.unit = "ft";
	dem = make_and_open(&made);
	assert_true(fabs(dem_info(dem)->unit - 0.3048) < 1e-12);
	assert_true(fabs(height_at(dem, 3, 6) - 130 * 0.3048) < 1e-4);
	assert_non_null(strstr(dem_info(dem)->vertical, "0.3048"));
	dem_close(dem);
	made.scale = 0.5;
	made.offset = 40;
	dem = make_and_open(&made);
	assert_true(fabs(height_at(dem, 3, 6) - (130 * 0.5 + 40) * 0.3048) < 1e-4);
	dem_close(dem);
	made = utm("survey.tif");
	made.unit = "US survey foot";
	made.type = GDT_Float32;
	dem = make_and_open(&made);
	assert_true(fabs(height_at(dem, 3, 6) - 130 * 1200.0 / 3937.0) < 1e-4);
	dem_close(dem);
}

static double half_hole(int x, int y)
{
	return x < 40 ? 500 : HOLE;
}

static void resampling_never_mixes_nodata_into_heights(void **state)
{
	struct made made = {.name = "half.tif", .srs = "EPSG:4326", .width = 80, .height = 60, .west = 15.2,
			    .north = 47.1, .dx = 0.001, .dy = 0.001, .type = GDT_Int16, .height_of = half_hole,
			    .tag = true, .nodata = HOLE};
	make(&made);
	const char *path = in_folder("half.tif");
	for (int kernel = DEM_BILINEAR; kernel <= DEM_NEAR; kernel++) {
		struct dem_params params = params_of(&path, 1);
		params.resample = (enum dem_resample)kernel;
		params.spacing = 50;
		struct dem *dem = open_with(&params);
		assert_true(dem_info(dem)->spacing == 50 && dem_info(dem)->unit == 1);
		int64_t holes = 0, posts = 0;
		for (int64_t y = 0; y < dem_info(dem)->height; y++)
			for (int64_t x = 0; x < dem_info(dem)->width; x++) {
				double height = height_at(dem, x, y);
				holes += isnan(height) ? 1 : 0;
				posts += isnan(height) ? 0 : 1;
				assert_true(isnan(height) || fabs(height - 500) < 1e-3);
			}
		assert_true(holes > posts / 2 && posts > holes / 2);
		dem_close(dem);
	}
}

static double zeros(int x, int y)
{
	return (x + y) % 2 == 0 ? -0.0 : 0.0;
}

static void negative_zero_keeps_its_sign(void **state)
{
	struct made made = utm("zeros.tif");
	made.type = GDT_Float32;
	made.height_of = zeros;
	struct dem *dem = make_and_open(&made);
	for (int y = 0; y < 7; y++)
		for (int x = 0; x < 9; x++)
			assert_int_equal(signbit(height_at(dem, x, 6 - y)) != 0, (x + y) % 2 == 0);
	dem_close(dem);
}

static double spike(int x, int y)
{
	return x != 3 || y != 5 ? 12 : 3e38;
}

static double pole(int x, int y)
{
	return x != 3 || y != 5 ? 12 : -(double)INFINITY;
}

/* Row 5 from the north is row 1: the place is a post's, as every other place in a message. */
static void what_no_ground_is_is_refused_where_it_stands(void **state)
{
	struct made made = utm("spike.tif");
	made.type = GDT_Float32;
	double rows[7 * 9];
	for (int kind = 0; kind < 2; kind++) {
		made.height_of = kind == 0 ? spike : pole;
		struct dem *dem = make_and_open(&made);
		assert_int_equal(read_rows(dem, 0, 7, rows), STATUS_INPUT);
		assert_non_null(strstr(failure_message(), "post 3, 1:"));
		dem_close(dem);
		const char *path = in_folder("spike.tif");
		const double nodata[] = {3.4e38, -(double)INFINITY, 3e38}; /* those that match nothing harm nothing */
		struct dem_params params = params_of(&path, 1);
		params.nodata = nodata;
		params.nodata_count = 3;
		dem = open_with(&params);
		assert_int_equal(read_rows(dem, 0, 7, rows), STATUS_OK);
		for (int i = 0; i < 7 * 9; i++)
			assert_true(i == 9 + 3 ? isnan(rows[i]) : rows[i] == 12);
		dem_close(dem);
	}
}

TEST_PROGRAM(meaning)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(nodata_is_what_its_tag_or_the_user_says_and_nan),
		cmocka_unit_test(a_float_sentinel_is_found_by_its_rounded_tag),
		cmocka_unit_test(scale_offset_and_feet_become_metres),
		cmocka_unit_test(resampling_never_mixes_nodata_into_heights),
		cmocka_unit_test(negative_zero_keeps_its_sign),
		cmocka_unit_test(what_no_ground_is_is_refused_where_it_stands),
	};
	return cmocka_run_group_tests_name("meaning", tests, folder_make, folder_remove);
}
