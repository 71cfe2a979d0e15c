/* Several sources as one, sources that cannot be read, and rasters written. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "raster.h"
#include "../support/program.h"

static double ramp_higher(int x, int y)
{
	return ramp(x, y) + (x == 3 ? 2 : 0);
}

static void the_first_named_wins_and_disagreement_is_measured(void **state)
{
	/* `b` is two posts further east than `a`, and 2 m higher in one column of the overlap. */
	struct made a = utm("a.tif"), b = utm("b.tif");
	b.west += 20;
	b.height_of = ramp_higher;
	a.tag = true;
	a.nodata = ramp(5, 2);
	make(&a);
	make(&b);
	const char *sources[] = {in_folder("a.tif"), in_folder("b.tif")};
	struct dem_params params = params_of(sources, 2);
	struct dem *dem = open_with(&params);
	const struct dem_info *info = dem_info(dem);
	assert_int_equal(info->width, 11);
	assert_int_equal(info->source_count, 2);
	int holes = 0;
	for (int y = 0; y < 7; y++)
		for (int x = 0; x < 9; x++)
			holes += ramp(x, y) == a.nodata && x >= 2 ? 1 : 0;
	assert_true(holes > 0);
	assert_int_equal(info->overlap_posts, 7 * 7 - holes);
	assert_true(info->overlap_differing > 0 && info->overlap_difference == 20);
	for (int y = 0; y < 7; y++)
		for (int x = 0; x < 11; x++) {
			double height = height_at(dem, x, 6 - y);
			bool in_a = x < 9 && ramp(x, y) != a.nodata;
			if (in_a)
				assert_true(height == ramp(x, y));
			else
				assert_true(x >= 2 && height == ramp_higher(x - 2, y));
		}
	dem_close(dem);
	a.nodata = ramp(1, 4); /* where `b` is not */
	make(&a);
	dem = open_with(&params);
	assert_true(isnan(height_at(dem, 1, 2)) && height_at(dem, 1, 3) == ramp(1, 3));
	dem_close(dem);
	const char *turned[] = {sources[1], sources[0]};
	params = params_of(turned, 2);
	dem = open_with(&params);
	assert_true(height_at(dem, 5, 6) == ramp_higher(3, 0));
	assert_true(height_at(dem, 0, 6) == ramp(0, 0));
	dem_close(dem);
}

static double east_part(int x, int y)
{
	return by_degree(x + 40, y);
}

/* Two tiles that only touch: across the seam heights go on as if they were one. */
static void a_seam_of_touching_tiles_is_not_seen_after_projection(void **state)
{
	struct made west = {.name = "west.tif", .srs = "EPSG:4326", .width = 40, .height = 60, .west = 15.2,
			    .north = 47.1, .dx = 0.001, .dy = 0.001, .type = GDT_Float32, .height_of = by_degree};
	struct made east = west, whole = west;
	east.name = "east.tif";
	east.west += 0.04;
	east.height_of = east_part;
	whole.name = "whole.tif";
	whole.width = 80;
	make(&west);
	make(&east);
	make(&whole);
	const char *sources[] = {in_folder("west.tif"), in_folder("east.tif")};
	struct dem_params params = params_of(sources, 2);
	struct dem *two = open_with(&params), *one = open_one(in_folder("whole.tif"));
	assert_int_equal(dem_info(two)->width, dem_info(one)->width);
	assert_int_equal(dem_info(two)->height, dem_info(one)->height);
	assert_int_equal(dem_info(two)->overlap_posts, 0);
	for (int64_t y = 0; y < dem_info(one)->height; y++)
		for (int64_t x = 0; x < dem_info(one)->width; x++) {
			double a = height_at(one, x, y), b = height_at(two, x, y);
			assert_true((isnan(a) && isnan(b)) || fabs(a - b) < 1e-3);
		}
	dem_close(one);
	dem_close(two);
}

static void an_srs_that_is_none_or_not_metric_is_refused(void **state)
{
	struct made a = utm("zone33.tif"), b = utm("zone34.tif");
	b.srs = "EPSG:32634";
	make(&a);
	make(&b);
	const char *sources[] = {in_folder("zone33.tif"), in_folder("zone34.tif")};
	struct dem_params params = params_of(sources, 2);
	params.s_srs = "EPSG:32633";
	dem_close(open_with(&params));
	params.s_srs = "EPSG:nonsense";
	assert_refused(&params, STATUS_INPUT, "EPSG:nonsense");
	params.s_srs = NULL;
	params.source_count = 1;
	params.t_srs = "EPSG:4326";
	assert_refused(&params, STATUS_INPUT, "not in metres");
	params.t_srs = "EPSG:32634";
	struct dem *dem = open_with(&params);
	assert_non_null(strstr(dem_info(dem)->srs, "UTM zone 34N"));
	dem_close(dem);
	params.t_srs = NULL;
	params.has_height_range = true;
	params.height_max = 1;
	assert_refused(&params, STATUS_USAGE, "zone33.tif");
}

static void a_cut_off_raster_is_refused(void **state)
{
	struct made made = utm("whole2.tif");
	made.width = made.height = 200;
	make(&made);
	assert_int_equal(truncate(in_folder("whole2.tif"), 30000), 0);
	const char *path = in_folder("whole2.tif");
	struct dem_params params = params_of(&path, 1);
	struct dem *dem = NULL;
	enum status status = dem_open(&params, &dem);
	double row[200];
	for (int64_t y = 0; status == STATUS_OK && y < 200; y++)
		status = read_rows(dem, y, 1, row);
	assert_int_equal(status, STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "whole2.tif"));
	dem_close(dem);
}

static void what_is_written_comes_back(void **state)
{
	struct made made = utm("for_srs.tif");
	struct dem *dem = make_and_open(&made);
	static const enum dem_raster_type types[] = {DEM_FLOAT32, DEM_INT32, DEM_UINT8, DEM_UINT16};
	for (size_t t = 0; t < 4; t++) {
		bool whole = types[t] != DEM_FLOAT32;
		struct dem_raster raster = {.path = in_folder("out.tif"), .width = 5, .height = 4,
			.type = types[t], .srs = dem_info(dem)->srs, .west = 500005, .south = 4999935,
			.spacing = 10, .has_nodata = true, .nodata = 77};
		struct dem_writer *writer;
		assert_int_equal(dem_writer_create(&raster, &writer), STATUS_OK);
		double rows[20];
		for (int i = 0; i < 20; i++)
			rows[i] = i == 7 ? (double)NAN : i * 2.5;
		assert_int_equal(dem_writer_rows(writer, 1, rows), STATUS_OK);
		assert_int_equal(dem_writer_rows(writer, 3, rows + 5), STATUS_OK);
		assert_int_equal(dem_writer_publish(writer), STATUS_OK);
		dem_writer_destroy(writer);
		assert_int_not_equal(access(in_folder("out.tif.part"), F_OK), 0);
		struct dem *back = open_one(in_folder("out.tif"));
		assert_true(dem_info(back)->origin[0] == 500005 && dem_info(back)->origin[1] == 4999935);
		assert_true(dem_info(back)->spacing == 10);
		assert_string_equal(dem_info(back)->srs, dem_info(dem)->srs);
		for (int i = 0; i < 20; i++) {
			double height = height_at(back, i % 5, i / 5);
			assert_true(i == 7 ? isnan(height) : height == (whole ? round(rows[i]) : rows[i]));
		}
		dem_close(back);
	}
	dem_close(dem);
	struct dem_raster raster = {.path = "/nonexistent-folder/out.tif", .width = 5, .height = 4, .srs = ""};
	struct dem_writer *writer;
	assert_int_equal(dem_writer_create(&raster, &writer), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "/nonexistent-folder/out.tif"));
}

static void every_failing_allocation_is_told(void **state)
{
	struct made made = utm("memory.tif");
	make(&made);
	const char *sources[] = {in_folder("memory.tif"), in_folder("memory.tif")};
	struct dem_params params = params_of(sources, 2);
	params.spacing = 5;
	(void)mem_fail_nth(0, 0);
	dem_close(open_with(&params));
	uint64_t made_count = mem_fail_nth(0, 0);
	for (uint64_t nth = 1; nth <= made_count; nth++) {
		struct dem *dem = NULL;
		(void)mem_fail_nth(nth, 1);
		enum status status = dem_open(&params, &dem);
		(void)mem_fail_nth(0, 0);
		assert_true(status != STATUS_OK);
	}
}

TEST_PROGRAM(sources)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_first_named_wins_and_disagreement_is_measured),
		cmocka_unit_test(a_seam_of_touching_tiles_is_not_seen_after_projection),
		cmocka_unit_test(an_srs_that_is_none_or_not_metric_is_refused),
		cmocka_unit_test(a_cut_off_raster_is_refused),
		cmocka_unit_test(what_is_written_comes_back),
		cmocka_unit_test(every_failing_allocation_is_told),
	};
	return cmocka_run_group_tests_name("sources", tests, folder_make, folder_remove);
}
