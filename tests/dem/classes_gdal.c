/* Maps of classes from GeoTIFFs: any SRS, any place, nodata, and what is refused. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>

#include "classes.h"
#include "placed_gdal.h"
#include "../support/program.h"

static double mixed(int column, int row)
{
	return (column * 7 + row * 31 + (column ^ row) * 3) & 127;
}

static double all_seven(int column, int row)
{
	return 7;
}

static double beyond(int column, int row)
{
	return column == 3 && row == 2 ? 300 : 1;
}

static struct tif classes_tif(const char *name)
{
	struct tif map = utm(name);
	map.type = GDT_Byte;
	map.value_of = mixed;
	return map;
}

/* Every post as plainly as can be; one on a pixel's edge may fall either way. */
static void check(struct dem_pixels *classes, const struct tif *map, int level, struct post_rect rect, double turn,
		  int64_t *inside)
{
	uint8_t *values = read_classes(classes, level, rect);
	size_t count = (size_t)((rect.x1 - rect.x0) * (rect.y1 - rect.y0));
	double *columns = malloc(count * sizeof *columns), *rows = malloc(count * sizeof *rows);
	place_posts(map, turn, level, rect, columns, rows);
	for (size_t i = 0; i < count; i++) {
		double column = columns[i], row = rows[i];
		bool in = column >= 0 && column < map->width && row >= 0 && row < map->height;
		bool edge = fabs(column - round(column)) < 1e-6 || fabs(row - round(row)) < 1e-6;
		if (!edge)
			assert_int_equal(values[i], in ? (int)map->value_of((int)floor(column), (int)floor(row)) : ABSENT);
		*inside += in;
	}
	free(columns);
	free(rows);
	free(values);
}

static void check_levels(const struct tif *map, double turn)
{
	char wkt[8192];
	snprintf(wkt, sizeof wkt, "%s", wkt_of(ZONE));
	make(map);
	struct dem_placed_params params = placed(map->name, &extent, wkt, WEST, SOUTH);
	struct dem_pixels *classes = open_placed(&params, DEM_PLACED_CLASSES);
	int64_t inside = 0;
	check(classes, map, 0, (struct post_rect){0, 0, 257, 129}, turn, &inside);
	assert_true(inside > 1000 && inside < 257 * 129);
	check(classes, map, 1, (struct post_rect){-20, -20, 100, 100}, turn, &inside);
	check(classes, map, 4, (struct post_rect){-20, -20, 40, 40}, turn, &inside);
	check(classes, map, -3, (struct post_rect){100, 700, 357, 800}, turn, &inside);
	/* A part has what the whole has. */
	uint8_t *whole = read_classes(classes, -1, (struct post_rect){-10, -10, 200, 150});
	for (int i = 0; i < 50; i++) {
		struct post_rect rect = {-10 + i * 4, -10 + i * 3, i * 4 - 10 + 1 + i % 7, i * 3 - 10 + 2};
		uint8_t *part = read_classes(classes, -1, rect);
		for (int64_t y = rect.y0; y < rect.y1; y++)
			assert_memory_equal(part + (y - rect.y0) * (rect.x1 - rect.x0), whole + (y + 10) * 210 + rect.x0 + 10,
					    (size_t)(rect.x1 - rect.x0));
		free(part);
	}
	free(whole);
	dem_pixels_close(classes);
}

static void pixels_of_the_stores_own_srs_are_nearest(void **state)
{
	struct tif map = classes_tif("own.tif");
	check_levels(&map, 0);
	map.place[0] = WEST + 3.3, map.place[1] = 33.7, map.place[5] = -17.1;
	check_levels(&map, 0);
	map.place[3] = SOUTH + 100, map.place[5] = 40; /* rows from the south */
	check_levels(&map, 0);
}

static void another_srs_is_transformed_post_by_post(void **state)
{
	/* 15 degrees east is the middle of zone 33, where 500000 is; 5000000 m north is near 45.15. */
	struct tif map = classes_tif("degrees.tif");
	map.srs = "EPSG:4326";
	memcpy(map.place, (double[]){14.9987, 0.0004, 0, 45.163, 0, -0.0003}, sizeof map.place);
	check_levels(&map, 0);
	map.srs = "EPSG:3035"; /* LAEA of Europe: turned by some degrees here */
	double east[1] = {WEST + 300}, north[1] = {SOUTH + 1100};
	assert_int_equal(dem_transform(wkt_of(ZONE), map.srs, 1, east, north), STATUS_OK);
	memcpy(map.place, (double[]){east[0] - 300, 40, 0, north[0] + 100, 0, -40}, sizeof map.place);
	check_levels(&map, 0);
}

static void longitudes_may_be_counted_round(void **state)
{
	struct tif map = classes_tif("round.tif");
	map.srs = "EPSG:4326";
	memcpy(map.place, (double[]){14.9987 + 360, 0.0004, 0, 45.163, 0, -0.0003}, sizeof map.place);
	check_levels(&map, 360);
	map.place[0] -= 720;
	check_levels(&map, -360);
}

static void a_turned_raster_is_read_where_it_lies(void **state)
{
	struct tif map = classes_tif("turned.tif");
	double c = 30 * cos(0.5), s = 30 * sin(0.5);
	memcpy(map.place, (double[]){WEST + 200, c, s, SOUTH + 300, s, -c}, sizeof map.place);
	check_levels(&map, 0);
	memcpy(map.place, (double[]){WEST + 200, 0, 25, SOUTH + 300, 25, 0}, sizeof map.place); /* on its side */
	check_levels(&map, 0);
}

static void posts_on_the_rim_are_in_the_raster(void **state)
{
	struct tif map = classes_tif("rim.tif");
	memcpy(map.place, (double[]){WEST + 100, 50, 0, SOUTH + 600, 0, -50}, sizeof map.place);
	map.width = 4, map.height = 6;
	make(&map);
	struct dem_placed_params params = placed("rim.tif", &extent, wkt_of(ZONE), WEST, SOUTH);
	struct dem_pixels *classes = open_placed(&params, DEM_PLACED_CLASSES);
	uint8_t *values = read_classes(classes, 0, (struct post_rect){0, 0, 64, 64});
	for (int y = 0; y < 64; y++)
		for (int x = 0; x < 64; x++) {
			bool in = x >= 10 && x <= 30 && y >= 30 && y <= 60;
			int column = x == 30 ? 3 : (x - 10) / 5, row = y == 30 ? 5 : (60 - y) / 5;
			assert_int_equal(values[y * 64 + x], in ? (int)mixed(column, row) : ABSENT);
		}
	free(values);
	dem_pixels_close(classes);
}

static void nodata_and_masks_are_absent(void **state)
{
	const struct post_rect rect = {0, 0, 100, 100};
	struct tif map = classes_tif("holes.tif");
	map.value_of = all_seven;
	map.tag = true;
	map.nodata = 7;
	make(&map);
	struct dem_placed_params params = placed("holes.tif", &extent, wkt_of(ZONE), WEST, SOUTH);
	struct dem_pixels *classes = open_placed(&params, DEM_PLACED_CLASSES);
	uint8_t *values = read_classes(classes, 0, rect);
	for (int i = 0; i < 100 * 100; i++)
		assert_int_equal(values[i], ABSENT);
	free(values);
	dem_pixels_close(classes);

	map = classes_tif("large.tif"); /* a nodata that is no class */
	map.type = GDT_UInt16;
	map.value_of = beyond;
	map.tag = true;
	map.nodata = 300;
	make(&map);
	params = placed("large.tif", &extent, wkt_of(ZONE), WEST, SOUTH);
	classes = open_placed(&params, DEM_PLACED_CLASSES);
	values = read_classes(classes, 0, (struct post_rect){-30, 0, 100, 140});
	int absent = 0;
	for (int i = 0; i < 130 * 140; i++)
		absent += values[i] == ABSENT;
	assert_int_equal(absent, 25);
	free(values);
	dem_pixels_close(classes);

	map = classes_tif("alpha.tif");
	map.bands = 2;
	map.alpha = true;
	make(&map);
	params = placed("alpha.tif", &extent, wkt_of(ZONE), WEST, SOUTH);
	classes = open_placed(&params, DEM_PLACED_CLASSES);
	values = read_classes(classes, 0, (struct post_rect){0, 0, 10, 1});
	for (int x = 0; x < 10; x++)
		assert_int_equal(values[x], x < 5 ? ABSENT : (int)mixed(7, 28));
	free(values);
	dem_pixels_close(classes);
}

static void a_coarse_level_over_many_pixels_is_read_in_parts(void **state)
{
	struct tif map = classes_tif("many.tif");
	map.width = 2600, map.height = 1300;
	memcpy(map.place, (double[]){WEST, 1, 0, SOUTH + 1300, 0, -1}, sizeof map.place);
	char wkt[8192];
	snprintf(wkt, sizeof wkt, "%s", wkt_of(ZONE));
	make(&map);
	struct dem_placed_params params = placed("many.tif", &extent, wkt, WEST, SOUTH);
	struct dem_pixels *classes = open_placed(&params, DEM_PLACED_CLASSES);
	uint8_t *values = read_classes(classes, 1, (struct post_rect){0, 0, 129, 65});
	for (int y = 0; y < 65; y++)
		for (int x = 0; x < 129; x++)
			assert_int_equal(values[y * 129 + x], (int)mixed(x * 20, y == 0 ? 1299 : 1300 - y * 20));
	free(values);
	dem_pixels_close(classes);
}

static void what_is_no_map_of_classes_is_refused(void **state)
{
	char wkt[8192];
	snprintf(wkt, sizeof wkt, "%s", wkt_of(ZONE));
	struct tif map = classes_tif("bad.tif");
	struct dem_placed_params params = placed("bad.tif", &extent, wkt, WEST, SOUTH);
	char path[400];
	snprintf(path, sizeof path, "%s", params.path);
	params.path = path;
	assert_placed_refused(&params, DEM_PLACED_CLASSES, "cannot be opened as a map of classes");
	write_file("bad.tif", "not a raster at all", 19);
	assert_placed_refused(&params, DEM_PLACED_CLASSES, "cannot be opened as a map of classes");
	const GDALDataType types[] = {GDT_Float32, GDT_Float64, GDT_CInt16};
	for (int i = 0; i < 3; i++) {
		map.type = types[i];
		make(&map);
		assert_placed_refused(&params, DEM_PLACED_CLASSES, "and classes are whole numbers from 0 to 255; make it bytes");
	}
	map = classes_tif("bad.tif");
	map.bands = 3;
	make(&map);
	assert_placed_refused(&params, DEM_PLACED_CLASSES, "has 3 bands, and a map of classes is one");
	map = classes_tif("bad.tif");
	memset(map.place, 0, sizeof map.place);
	make(&map);
	assert_placed_refused(&params, DEM_PLACED_CLASSES, "has no place; give it one");
	map = classes_tif("bad.tif");
	memcpy(map.place, (double[]){WEST, 10, 10, SOUTH, 10, 10}, sizeof map.place);
	make(&map);
	assert_placed_refused(&params, DEM_PLACED_CLASSES, "its geotransform has no area");
	map = classes_tif("bad.tif");
	make(&map);
	params.srs = "";
	assert_placed_refused(&params, DEM_PLACED_CLASSES, "lies on a planet, and the store is local metres");
	params.srs = wkt;
	map.type = GDT_Int16;
	map.value_of = beyond;
	make(&map);
	/* Column 3, row 2: 150 to 200 m east and 100 to 150 m south of the corner. */
	assert_read_refused(&params, (struct post_rect){-30, 120, 0, 140}, "column 3, row 2: its value 300 is no class; allowed: 0 to 255");
	map = classes_tif("bad.tif");
	map.width = map.height = 400;
	make(&map);
	assert_int_equal(truncate(path, 100000), 0);
	struct dem_pixels *classes;
	if (dem_pixels_open(&params, DEM_PLACED_CLASSES, &classes) == STATUS_OK) { /* as GDAL finds its directory or not */
		dem_pixels_close(classes);
		assert_read_refused(&params, (struct post_rect){0, -1800, 10, -1000}, "reading it failed at column");
	} else {
		assert_placed_refused(&params, DEM_PLACED_CLASSES, "cannot be opened as a map of classes");
	}
	/* A format that names other files is not opened. */
	write_file("map.vrt", "<VRTDataset rasterXSize=\"2\" rasterYSize=\"2\"/>", 46);
	params.path = in_folder("map.vrt");
	assert_placed_refused(&params, DEM_PLACED_CLASSES, "cannot be opened as a map of classes");
}

/* Wherever the store lies: by its own SRS, by none but with a place, or nowhere. */
static void a_map_without_an_srs_is_in_metres_from_the_south_west_post(void **state)
{
	const struct {
		const char *srs, *of_map;
		double x, y;
	} stores[] = {{"", NULL, 0, 0}, {"", NULL, 20, -7}, {wkt_of(ZONE), NULL, WEST, SOUTH}, {"", "LOCAL_CS[\"a field\",UNIT[\"metre\",1]]", 300, 400}};
	for (size_t i = 0; i < sizeof stores / sizeof *stores; i++) {
		struct tif map = classes_tif("plain.tif");
		map.srs = stores[i].of_map;
		memcpy(map.place, (double[]){20, 50, 0, 1000, 0, -50}, sizeof map.place);
		make(&map);
		struct dem_placed_params params = placed("plain.tif", &extent, stores[i].srs, stores[i].x, stores[i].y);
		struct dem_pixels *classes = open_placed(&params, DEM_PLACED_CLASSES);
		uint8_t *values = read_classes(classes, 0, (struct post_rect){0, 0, 10, 10});
		assert_int_equal(values[5 * 10 + 1], ABSENT);
		assert_int_equal(values[5 * 10 + 3], (int)mixed(0, 19));
		assert_int_equal(values[5 * 10 + 8], (int)mixed(1, 19));
		free(values);
		dem_pixels_close(classes);
	}
}

/* A raster on no planet that has the store's own SRS, as an export of it has, lies where it says. */
static void a_local_srs_that_is_the_stores_own_counts(void **state)
{
	static const char field[] = "LOCAL_CS[\"a field\",UNIT[\"metre\",1]]";
	struct tif map = classes_tif("field.tif");
	map.srs = field;
	memcpy(map.place, (double[]){320, 50, 0, 1400, 0, -50}, sizeof map.place);
	make(&map);
	struct dem_placed_params params = placed("field.tif", &extent, field, 300, 400);
	struct dem_pixels *classes = open_placed(&params, DEM_PLACED_CLASSES);
	uint8_t *values = read_classes(classes, 0, (struct post_rect){0, 0, 10, 10});
	assert_int_equal(values[5 * 10 + 1], ABSENT);
	assert_int_equal(values[5 * 10 + 3], (int)mixed(0, 19));
	free(values);
	dem_pixels_close(classes);
}

TEST_PROGRAM(classes_gdal)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(pixels_of_the_stores_own_srs_are_nearest),
		cmocka_unit_test(another_srs_is_transformed_post_by_post),
		cmocka_unit_test(longitudes_may_be_counted_round),
		cmocka_unit_test(a_turned_raster_is_read_where_it_lies),
		cmocka_unit_test(posts_on_the_rim_are_in_the_raster),
		cmocka_unit_test(nodata_and_masks_are_absent),
		cmocka_unit_test(a_coarse_level_over_many_pixels_is_read_in_parts),
		cmocka_unit_test(what_is_no_map_of_classes_is_refused),
		cmocka_unit_test(a_map_without_an_srs_is_in_metres_from_the_south_west_post),
		cmocka_unit_test(a_local_srs_that_is_the_stores_own_counts),
	};
	return cmocka_run_group_tests_name("classes_gdal", tests, folder_make, folder_remove);
}
