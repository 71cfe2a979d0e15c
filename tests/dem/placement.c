/* Where a post is: pixels, systems, units of length, projections, spacings. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "raster.h"
#include "../support/program.h"

static void a_pixels_centre_is_its_post_and_row_0_is_south(void **state)
{
	struct made made = utm("plain.tif");
	struct dem *dem = make_and_open(&made);
	const struct dem_info *info = dem_info(dem);
	assert_int_equal(info->width, 9);
	assert_int_equal(info->height, 7);
	assert_true(info->spacing == 10 && info->unit == 1);
	assert_true(info->origin[0] == 500005 && info->origin[1] == 5000000 - 65);
	assert_string_equal(info->projected, "");
	assert_non_null(strstr(info->srs, "UTM zone 33N"));
	for (int y = 0; y < 7; y++)
		for (int x = 0; x < 9; x++)
			assert_true(height_at(dem, x, y) == ramp(x, 6 - y));
	double rows[4 * 9];
	assert_int_equal(read_rows(dem, 2, 4, rows), STATUS_OK);
	assert_true(rows[9 + 1] == ramp(1, 3));
	dem_close(dem);
	dem_close(NULL);
}

static void degrees_are_projected_without_a_shift(void **state)
{
	struct made made = {.name = "degrees.tif", .srs = "EPSG:4326", .width = 80, .height = 60, .west = 15.2,
			    .north = 47.1, .dx = 0.001, .dy = 0.001, .type = GDT_Float32, .height_of = by_degree};
	struct dem *dem = make_and_open(&made);
	const struct dem_info *info = dem_info(dem);
	assert_non_null(strstr(info->srs, "UTM zone 33N"));
	assert_non_null(strstr(info->projected, "WGS 84"));
	assert_true(info->spacing > 76 && info->spacing < 112); /* 75.9 x 111.2 m */
	OGRSpatialReferenceH from = OSRNewSpatialReference(NULL), to = OSRNewSpatialReference(NULL);
	OSRImportFromEPSG(from, 32633);
	OSRImportFromEPSG(to, 4326);
	OSRSetAxisMappingStrategy(from, OAMS_TRADITIONAL_GIS_ORDER);
	OSRSetAxisMappingStrategy(to, OAMS_TRADITIONAL_GIS_ORDER);
	OGRCoordinateTransformationH move = OCTNewCoordinateTransformation(from, to);
	int checked = 0;
	for (int64_t row = 4; row < info->height - 4; row++)
		for (int64_t column = 4; column < info->width - 4; column++) {
			double x = info->origin[0] + (double)column * info->spacing;
			double y = info->origin[1] + (double)row * info->spacing;
			assert_true(OCTTransform(move, 1, &x, &y, NULL));
			double px = (x - made.west) / made.dx - 0.5, py = (made.north - y) / made.dy - 0.5;
			double height = height_at(dem, column, row);
			if (isnan(height))
				continue;
			if (px < 2 || py < 2 || px > 77 || py > 57)
				continue;
			assert_true(fabs(height - (1000 + 4 * px - 7 * py)) < 0.05);
			checked++;
		}
	assert_true(checked > 1500);
	OCTDestroyCoordinateTransformation(move);
	OSRDestroySpatialReference(from);
	OSRDestroySpatialReference(to);
	dem_close(dem);
}

static void map_feet_and_a_stretched_projection_are_projected(void **state)
{
	struct made made = utm("mapfeet.tif");
	made.srs = "EPSG:2229"; /* California 5, US survey feet */
	made.west = 6500000;
	made.north = 1850000;
	struct dem *dem = make_and_open(&made);
	assert_non_null(strstr(dem_info(dem)->srs, "UTM zone 11N"));
	assert_true(fabs(dem_info(dem)->spacing - 3.05) < 0.011); /* 10 ft */
	dem_close(dem);
	made = utm("mercator.tif");
	made.srs = "EPSG:3857";
	made.west = 1700000;
	made.north = 6000000; /* 47 degrees north: 1.47 times too large */
	dem = make_and_open(&made);
	assert_non_null(strstr(dem_info(dem)->srs, "UTM zone 33N"));
	assert_true(fabs(dem_info(dem)->spacing - 6.8) < 0.1);
	dem_close(dem);
	made = utm("moon.tif");
	made.srs = "+proj=longlat +a=1737400 +b=1737400 +no_defs";
	made.west = 30;
	made.north = 40;
	made.dx = made.dy = 0.01;
	dem = make_and_open(&made);
	assert_non_null(strstr(dem_info(dem)->srs, "Equidistant Cylindrical"));
	assert_true(dem_info(dem)->spacing > 232 && dem_info(dem)->spacing < 304); /* 232.3 x 303.2 m */
	dem_close(dem);
	made = utm("mars.tif"); /* an ellipsoid, on which the equirectangular is not true */
	made.srs = "+proj=longlat +a=3396190 +b=3376200 +no_defs";
	made.west = 77;
	made.north = 18;
	made.dx = made.dy = 0.01;
	dem = make_and_open(&made);
	assert_non_null(strstr(dem_info(dem)->srs, "Transverse Mercator"));
	dem_close(dem);
}

static void posts_that_are_not_square_become_so(void **state)
{
	struct made made = utm("oblong.tif");
	made.dx = 20;
	struct dem *dem = make_and_open(&made);
	assert_true(dem_info(dem)->spacing == 14.1);
	assert_true(dem_info(dem)->origin[0] == 500010 && dem_info(dem)->origin[1] == 5000000 - 65);
	for (int y = 0; y < dem_info(dem)->height; y++)
		for (int x = 0; x < dem_info(dem)->width; x++)
			assert_true(fabs(height_at(dem, x, y) - (100 + 10 * x * 14.1 / 20 - 3 * (6 - y * 1.41))) < 1e-3);
	dem_close(dem);
}

static void a_given_spacing_keeps_the_south_west_post(void **state)
{
	struct made made = utm("respaced.tif");
	make(&made);
	const char *path = in_folder("respaced.tif");
	struct dem_params params = params_of(&path, 1);
	params.spacing = 5;
	struct dem *dem = open_with(&params);
	const struct dem_info *info = dem_info(dem);
	assert_int_equal(info->width, 17);
	assert_int_equal(info->height, 13);
	assert_true(info->origin[0] == 500005 && info->origin[1] == 5000000 - 65);
	for (int y = 0; y < 13; y++)
		for (int x = 0; x < 17; x++)
			assert_true(fabs(height_at(dem, x, y) - (100 + 5 * x - 3 * (6 - y / 2.0))) < 1e-3);
	dem_close(dem);
}

static void a_raster_without_a_place_is_local_metres(void **state)
{
	struct made made = utm("nowhere.tif");
	made.srs = NULL;
	made.dx = 0;
	struct dem *dem = make_and_open(&made);
	assert_true(dem_info(dem)->spacing == 1 && dem_info(dem)->origin[0] == 0 &&
		    dem_info(dem)->origin[1] == 0);
	assert_string_equal(dem_info(dem)->srs, "");
	dem_close(dem);
	const char *path = in_folder("nowhere.tif");
	struct dem_params params = params_of(&path, 1);
	params.spacing = 3;
	dem = open_with(&params);
	assert_true(dem_info(dem)->spacing == 3);
	assert_int_equal(dem_info(dem)->width, 9);
	assert_true(height_at(dem, 2, 6) == ramp(2, 0));
	dem_close(dem);
}

static void coordinates_have_x_east_first(void **state)
{
	double x = 15, y = 45;
	assert_int_equal(dem_transform("EPSG:4326", "EPSG:32633", 1, &x, &y), STATUS_OK);
	assert_true(fabs(x - 500000) < 1e-3 && fabs(y - 4982950.4) < 0.1);
	assert_int_equal(dem_transform("EPSG:4326", "", 1, &x, &y), STATUS_INPUT);
	assert_int_equal(dem_transform("nonsense", "EPSG:32633", 1, &x, &y), STATUS_INPUT);
	x = 15;
	y = 95;
	assert_int_equal(dem_transform("EPSG:4326", "EPSG:32633", 1, &x, &y), STATUS_INPUT);
}

TEST_PROGRAM(placement)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_pixels_centre_is_its_post_and_row_0_is_south),
		cmocka_unit_test(degrees_are_projected_without_a_shift),
		cmocka_unit_test(map_feet_and_a_stretched_projection_are_projected),
		cmocka_unit_test(posts_that_are_not_square_become_so),
		cmocka_unit_test(a_given_spacing_keeps_the_south_west_post),
		cmocka_unit_test(a_raster_without_a_place_is_local_metres),
		cmocka_unit_test(coordinates_have_x_east_first),
	};
	return cmocka_run_group_tests_name("placement", tests, folder_make, folder_remove);
}
