/* The traps of elevation rasters, each made small: where a post is, what is nodata, which unit. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <gdal.h>
#include <ogr_srs_api.h>

#include "files.h"

#define HOLE (-9999.0)

struct made {
	const char *name, *srs; /* in the folder; anything GDAL takes, NULL for none */
	int width, height;
	double west, north, dx, dy; /* pixel corner; dy to the south */
	GDALDataType type;
	double (*height_of)(int x, int y); /* y from the north */
	bool tag;
	double nodata, scale, offset; /* scale 0: none */
	const char *unit;
};

static double ramp(int x, int y)
{
	return 100 + 10 * x - 3 * y;
}

static double ramp_higher(int x, int y)
{
	return ramp(x, y) + (x == 3 ? 2 : 0);
}

static double ramp_with_hole(int x, int y)
{
	return x == 4 && y == 5 ? HOLE : ramp(x, y);
}

static void make(const struct made *made)
{
	GDALAllRegister();
	GDALDatasetH dataset = GDALCreate(GDALGetDriverByName("GTiff"), in_folder(made->name), made->width,
					  made->height, 1, made->type, NULL);
	assert_non_null(dataset);
	double place[6] = {made->west, made->dx, 0, made->north, 0, -made->dy};
	if (made->dx != 0)
		assert_int_equal(GDALSetGeoTransform(dataset, place), CE_None);
	if (made->srs != NULL) {
		OGRSpatialReferenceH srs = OSRNewSpatialReference(NULL);
		assert_int_equal(OSRSetFromUserInput(srs, made->srs), OGRERR_NONE);
		OSRSetAxisMappingStrategy(srs, OAMS_TRADITIONAL_GIS_ORDER);
		assert_int_equal(GDALSetSpatialRef(dataset, srs), CE_None);
		OSRDestroySpatialReference(srs);
	}
	GDALRasterBandH band = GDALGetRasterBand(dataset, 1);
	if (made->tag)
		GDALSetRasterNoDataValue(band, made->nodata);
	if (made->scale != 0) {
		GDALSetRasterScale(band, made->scale);
		GDALSetRasterOffset(band, made->offset);
	}
	if (made->unit != NULL)
		GDALSetRasterUnitType(band, made->unit);
	for (int y = 0; y < made->height; y++)
		for (int x = 0; x < made->width; x++) {
			double value = made->height_of(x, y);
			assert_int_equal(GDALRasterIO(band, GF_Write, x, y, 1, 1, &value, 1, 1, GDT_Float64, 0, 0),
					 CE_None);
		}
	GDALClose(dataset);
}

/* 9 x 7 posts every 10 m in UTM 33N. */
static struct made utm(const char *name)
{
	return (struct made){.name = name, .srs = "EPSG:32633", .width = 9, .height = 7, .west = 500000,
			     .north = 5000000, .dx = 10, .dy = 10, .type = GDT_Int16, .height_of = ramp};
}

static struct dem *make_and_open(const struct made *made)
{
	make(made);
	return open_one(in_folder(made->name));
}

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

/* Heights that grow by the degree, so that a half-pixel shift would be seen. */
static double by_degree(int x, int y)
{
	return 1000 + 4 * x - 7 * y;
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
			else if (x >= 2)
				assert_true(height == ramp_higher(x - 2, y));
			else
				assert_true(isnan(height));
		}
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

static void sources_in_other_srs_are_refused(void **state)
{
	struct made a = utm("zone33.tif"), b = utm("zone34.tif");
	b.srs = "EPSG:32634";
	make(&a);
	make(&b);
	const char *sources[] = {in_folder("zone33.tif"), in_folder("zone34.tif")};
	struct dem_params params = params_of(sources, 2);
	assert_refused(&params, STATUS_INPUT, "zone34.tif");
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

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_pixels_centre_is_its_post_and_row_0_is_south),
		cmocka_unit_test(nodata_is_what_its_tag_or_the_user_says_and_nan),
		cmocka_unit_test(a_float_sentinel_is_found_by_its_rounded_tag),
		cmocka_unit_test(scale_offset_and_feet_become_metres),
		cmocka_unit_test(degrees_are_projected_without_a_shift),
		cmocka_unit_test(resampling_never_mixes_nodata_into_heights),
		cmocka_unit_test(map_feet_and_a_stretched_projection_are_projected),
		cmocka_unit_test(posts_that_are_not_square_become_so),
		cmocka_unit_test(a_given_spacing_keeps_the_south_west_post),
		cmocka_unit_test(the_first_named_wins_and_disagreement_is_measured),
		cmocka_unit_test(a_seam_of_touching_tiles_is_not_seen_after_projection),
		cmocka_unit_test(sources_in_other_srs_are_refused),
		cmocka_unit_test(a_raster_without_a_place_is_local_metres),
		cmocka_unit_test(a_cut_off_raster_is_refused),
		cmocka_unit_test(what_is_written_comes_back),
		cmocka_unit_test(coordinates_have_x_east_first),
		cmocka_unit_test(every_failing_allocation_is_told),
	};
	return cmocka_run_group_tests_name("sources", tests, folder_make, folder_remove);
}
