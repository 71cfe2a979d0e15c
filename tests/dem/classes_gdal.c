/* Maps of classes from GeoTIFFs: any SRS, any place, nodata, and what is refused. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <cpl_conv.h>
#include <gdal.h>
#include <math.h>
#include <ogr_srs_api.h>

#include "classes.h"

struct map {
	const char *name, *srs; /* NULL: none */
	int width, height, bands;
	GDALDataType type;
	double place[6]; /* all 0: none */
	bool tag, alpha;
	double nodata;
	int (*value_of)(int column, int row);
};

static int mixed(int column, int row)
{
	return (column * 7 + row * 31 + (column ^ row) * 3) & 127;
}

static int all_seven(int column, int row)
{
	return 7;
}

static int beyond(int column, int row)
{
	return column == 3 && row == 2 ? 300 : 1;
}

static void make(const struct map *map)
{
	GDALAllRegister();
	GDALDatasetH dataset = GDALCreate(GDALGetDriverByName("GTiff"), in_folder(map->name), map->width, map->height,
					  map->bands, map->type, NULL);
	assert_non_null(dataset);
	if (map->place[1] != 0 || map->place[2] != 0)
		assert_int_equal(GDALSetGeoTransform(dataset, (double *)map->place), CE_None);
	if (map->srs != NULL) {
		OGRSpatialReferenceH srs = OSRNewSpatialReference(NULL);
		assert_int_equal(OSRSetFromUserInput(srs, map->srs), OGRERR_NONE);
		OSRSetAxisMappingStrategy(srs, OAMS_TRADITIONAL_GIS_ORDER);
		assert_int_equal(GDALSetSpatialRef(dataset, srs), CE_None);
		OSRDestroySpatialReference(srs);
	}
	GDALRasterBandH band = GDALGetRasterBand(dataset, 1);
	if (map->tag)
		GDALSetRasterNoDataValue(band, map->nodata);
	double *row = malloc(sizeof *row * (size_t)map->width);
	for (int y = 0; y < map->height; y++) {
		for (int x = 0; x < map->width; x++)
			row[x] = map->value_of(x, y);
		assert_int_equal(GDALRasterIO(band, GF_Write, 0, y, map->width, 1, row, map->width, 1, GDT_Float64, 0, 0), CE_None);
	}
	if (map->alpha) {
		GDALRasterBandH alpha = GDALGetRasterBand(dataset, 2);
		assert_int_equal(GDALSetRasterColorInterpretation(alpha, GCI_AlphaBand), CE_None);
		for (int x = 0; x < map->width; x++)
			row[x] = x % 2 ? 255 : 0;
		for (int y = 0; y < map->height; y++)
			assert_int_equal(GDALRasterIO(alpha, GF_Write, 0, y, map->width, 1, row, map->width, 1, GDT_Float64, 0, 0),
					 CE_None);
	}
	free(row);
	GDALClose(dataset);
}

static const struct extent extent = {257, 129, 10, 64};
#define WEST 500000.0
#define SOUTH 5000000.0

/* 40 x 30 pixels of 50 m in UTM 33N, over part of the world and beyond its west. */
static struct map utm(const char *name)
{
	return (struct map){.name = name, .srs = "EPSG:32633", .width = 40, .height = 30, .bands = 1, .type = GDT_Byte,
			    .place = {WEST - 300, 50, 0, SOUTH + 1400, 0, -50}, .value_of = mixed};
}

static const char *wkt_of(const char *text)
{
	static char wkt[8192];
	OGRSpatialReferenceH srs = OSRNewSpatialReference(NULL);
	char *made = NULL;
	assert_int_equal(OSRSetFromUserInput(srs, text), OGRERR_NONE);
	assert_int_equal(OSRExportToWkt(srs, &made), OGRERR_NONE);
	snprintf(wkt, sizeof wkt, "%s", made);
	CPLFree(made);
	OSRDestroySpatialReference(srs);
	return wkt;
}

/* Every post as plainly as can be; one on a pixel's edge may fall either way. */
static void check(struct dem_classes *classes, const struct map *map, const char *wkt, int level, struct post_rect rect,
		  double turn, int64_t *inside)
{
	uint8_t *values = read_classes(classes, level, rect);
	double inverse[6];
	assert_true(GDALInvGeoTransform((double *)map->place, inverse));
	size_t width = (size_t)(rect.x1 - rect.x0), count = width * (size_t)(rect.y1 - rect.y0);
	double *east = malloc(count * sizeof *east), *north = malloc(count * sizeof *north);
	for (size_t i = 0; i < count; i++) {
		east[i] = WEST + ldexp((double)(rect.x0 + (int64_t)(i % width)), level) * extent.spacing;
		north[i] = SOUTH + ldexp((double)(rect.y0 + (int64_t)(i / width)), level) * extent.spacing;
	}
	if (map->srs != NULL && strcmp(map->srs, "EPSG:32633") != 0)
		assert_int_equal(dem_transform(wkt, map->srs, count, east, north), STATUS_OK);
	for (size_t i = 0; i < count; i++) {
		double column = inverse[0] + inverse[1] * (east[i] + turn) + inverse[2] * north[i];
		double row = inverse[3] + inverse[4] * (east[i] + turn) + inverse[5] * north[i];
		bool in = column >= 0 && column < map->width && row >= 0 && row < map->height;
		bool edge = fabs(column - round(column)) < 1e-6 || fabs(row - round(row)) < 1e-6;
		if (!edge)
			assert_int_equal(values[i], in ? map->value_of((int)floor(column), (int)floor(row)) : ABSENT);
		*inside += in;
	}
	free(east);
	free(north);
	free(values);
}

static void check_levels(const struct map *map, double turn)
{
	char wkt[8192];
	snprintf(wkt, sizeof wkt, "%s", wkt_of("EPSG:32633"));
	make(map);
	struct dem_classes_params params = classes_of(map->name, &extent, wkt, WEST, SOUTH);
	struct dem_classes *classes = open_classes(&params);
	int64_t inside = 0;
	check(classes, map, wkt, 0, (struct post_rect){0, 0, 257, 129}, turn, &inside);
	assert_true(inside > 1000 && inside < 257 * 129);
	check(classes, map, wkt, 1, (struct post_rect){-20, -20, 100, 100}, turn, &inside);
	check(classes, map, wkt, 4, (struct post_rect){-20, -20, 40, 40}, turn, &inside);
	check(classes, map, wkt, -3, (struct post_rect){100, 700, 357, 800}, turn, &inside);
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
	dem_classes_close(classes);
}

static void pixels_of_the_stores_own_srs_are_nearest(void **state)
{
	struct map map = utm("own.tif");
	check_levels(&map, 0);
	map.place[0] = WEST + 3.3, map.place[1] = 33.7, map.place[5] = -17.1;
	check_levels(&map, 0);
	map.place[3] = SOUTH + 100, map.place[5] = 40; /* rows from the south */
	check_levels(&map, 0);
}

static void another_srs_is_transformed_post_by_post(void **state)
{
	/* 15 degrees east is the middle of zone 33, where 500000 is; 5000000 m north is near 45.15. */
	struct map map = utm("degrees.tif");
	map.srs = "EPSG:4326";
	memcpy(map.place, (double[]){14.9987, 0.0004, 0, 45.163, 0, -0.0003}, sizeof map.place);
	check_levels(&map, 0);
	map.srs = "EPSG:3035"; /* LAEA of Europe: turned by some degrees here */
	double east[1] = {WEST + 300}, north[1] = {SOUTH + 1100};
	assert_int_equal(dem_transform(wkt_of("EPSG:32633"), map.srs, 1, east, north), STATUS_OK);
	memcpy(map.place, (double[]){east[0] - 300, 40, 0, north[0] + 100, 0, -40}, sizeof map.place);
	check_levels(&map, 0);
}

static void longitudes_may_be_counted_round(void **state)
{
	struct map map = utm("round.tif");
	map.srs = "EPSG:4326";
	memcpy(map.place, (double[]){14.9987 + 360, 0.0004, 0, 45.163, 0, -0.0003}, sizeof map.place);
	check_levels(&map, 360);
	map.place[0] -= 720;
	check_levels(&map, -360);
}

static void a_turned_raster_is_read_where_it_lies(void **state)
{
	struct map map = utm("turned.tif");
	double c = 30 * cos(0.5), s = 30 * sin(0.5);
	memcpy(map.place, (double[]){WEST + 200, c, s, SOUTH + 300, s, -c}, sizeof map.place);
	check_levels(&map, 0);
	memcpy(map.place, (double[]){WEST + 200, 0, 25, SOUTH + 300, 25, 0}, sizeof map.place); /* on its side */
	check_levels(&map, 0);
}

static void posts_on_the_rim_are_in_the_raster(void **state)
{
	struct map map = utm("rim.tif");
	memcpy(map.place, (double[]){WEST + 100, 50, 0, SOUTH + 600, 0, -50}, sizeof map.place);
	map.width = 4, map.height = 6;
	make(&map);
	struct dem_classes_params params = classes_of("rim.tif", &extent, wkt_of("EPSG:32633"), WEST, SOUTH);
	struct dem_classes *classes = open_classes(&params);
	uint8_t *values = read_classes(classes, 0, (struct post_rect){0, 0, 64, 64});
	for (int y = 0; y < 64; y++)
		for (int x = 0; x < 64; x++) {
			bool in = x >= 10 && x <= 30 && y >= 30 && y <= 60;
			int column = x == 30 ? 3 : (x - 10) / 5, row = y == 30 ? 5 : (60 - y) / 5;
			assert_int_equal(values[y * 64 + x], in ? mixed(column, row) : ABSENT);
		}
	free(values);
	dem_classes_close(classes);
}

static void nodata_and_masks_are_absent(void **state)
{
	const struct post_rect rect = {0, 0, 100, 100};
	struct map map = utm("holes.tif");
	map.value_of = all_seven;
	map.tag = true;
	map.nodata = 7;
	make(&map);
	struct dem_classes_params params = classes_of("holes.tif", &extent, wkt_of("EPSG:32633"), WEST, SOUTH);
	struct dem_classes *classes = open_classes(&params);
	uint8_t *values = read_classes(classes, 0, rect);
	for (int i = 0; i < 100 * 100; i++)
		assert_int_equal(values[i], ABSENT);
	free(values);
	dem_classes_close(classes);

	map = utm("large.tif"); /* a nodata that is no class */
	map.type = GDT_UInt16;
	map.value_of = beyond;
	map.tag = true;
	map.nodata = 300;
	make(&map);
	params = classes_of("large.tif", &extent, wkt_of("EPSG:32633"), WEST, SOUTH);
	classes = open_classes(&params);
	values = read_classes(classes, 0, (struct post_rect){-30, 0, 100, 140});
	int absent = 0;
	for (int i = 0; i < 130 * 140; i++)
		absent += values[i] == ABSENT;
	assert_int_equal(absent, 25);
	free(values);
	dem_classes_close(classes);

	map = utm("alpha.tif");
	map.bands = 2;
	map.alpha = true;
	make(&map);
	params = classes_of("alpha.tif", &extent, wkt_of("EPSG:32633"), WEST, SOUTH);
	classes = open_classes(&params);
	values = read_classes(classes, 0, (struct post_rect){0, 0, 10, 1});
	for (int x = 0; x < 10; x++)
		assert_int_equal(values[x], x < 5 ? ABSENT : mixed(7, 28));
	free(values);
	dem_classes_close(classes);
}

static void a_coarse_level_over_many_pixels_is_read_in_parts(void **state)
{
	struct map map = utm("many.tif");
	map.width = 2600, map.height = 1300;
	memcpy(map.place, (double[]){WEST, 1, 0, SOUTH + 1300, 0, -1}, sizeof map.place);
	char wkt[8192];
	snprintf(wkt, sizeof wkt, "%s", wkt_of("EPSG:32633"));
	make(&map);
	struct dem_classes_params params = classes_of("many.tif", &extent, wkt, WEST, SOUTH);
	struct dem_classes *classes = open_classes(&params);
	uint8_t *values = read_classes(classes, 1, (struct post_rect){0, 0, 129, 65});
	for (int y = 0; y < 65; y++)
		for (int x = 0; x < 129; x++)
			assert_int_equal(values[y * 129 + x], mixed(x * 20, y == 0 ? 1299 : 1300 - y * 20));
	free(values);
	dem_classes_close(classes);
}

static void what_is_no_map_of_classes_is_refused(void **state)
{
	char wkt[8192];
	snprintf(wkt, sizeof wkt, "%s", wkt_of("EPSG:32633"));
	struct map map = utm("bad.tif");
	struct dem_classes_params params = classes_of("bad.tif", &extent, wkt, WEST, SOUTH);
	char path[400];
	snprintf(path, sizeof path, "%s", params.path);
	params.path = path;
	assert_open_refused(&params, "cannot be opened as a map of classes");
	write_file("bad.tif", "not a raster at all", 19);
	assert_open_refused(&params, "cannot be opened as a map of classes");
	const GDALDataType types[] = {GDT_Float32, GDT_Float64, GDT_CInt16};
	for (int i = 0; i < 3; i++) {
		map.type = types[i];
		make(&map);
		assert_open_refused(&params, "and classes are whole numbers from 0 to 255; make it bytes");
	}
	map = utm("bad.tif");
	map.bands = 3;
	make(&map);
	assert_open_refused(&params, "has 3 bands, and a map of classes is one");
	map = utm("bad.tif");
	memset(map.place, 0, sizeof map.place);
	make(&map);
	assert_open_refused(&params, "has no place; give it one");
	map = utm("bad.tif");
	memcpy(map.place, (double[]){WEST, 10, 10, SOUTH, 10, 10}, sizeof map.place);
	make(&map);
	assert_open_refused(&params, "its geotransform has no area");
	map = utm("bad.tif");
	make(&map);
	params.srs = "";
	assert_open_refused(&params, "lies on a planet, and the store is local metres");
	params.srs = wkt;
	map.type = GDT_Int16;
	map.value_of = beyond;
	make(&map);
	/* Column 3, row 2: 150 to 200 m east and 100 to 150 m south of the corner. */
	assert_read_refused(&params, (struct post_rect){-30, 120, 0, 140}, "column 3, row 2: its value 300 is no class; allowed: 0 to 255");
	map = utm("bad.tif");
	map.width = map.height = 400;
	make(&map);
	assert_int_equal(truncate(path, 100000), 0);
	struct dem_classes *classes;
	if (dem_classes_open(&params, &classes) == STATUS_OK) { /* as GDAL finds its directory or not */
		dem_classes_close(classes);
		assert_read_refused(&params, (struct post_rect){0, -1800, 10, -1000}, "reading it failed at column");
	} else {
		assert_open_refused(&params, "cannot be opened as a map of classes");
	}
	/* A format that names other files is not opened. */
	write_file("map.vrt", "<VRTDataset rasterXSize=\"2\" rasterYSize=\"2\"/>", 46);
	params.path = in_folder("map.vrt");
	assert_open_refused(&params, "cannot be opened as a map of classes");
}

static void a_map_without_an_srs_is_in_the_stores_coordinates(void **state)
{
	struct map map = utm("plain.tif");
	map.srs = NULL;
	check_levels(&map, 0);
	memcpy(map.place, (double[]){20, 50, 0, 1000, 0, -50}, sizeof map.place);
	make(&map);
	struct dem_classes_params params = classes_of("plain.tif", &extent, "", 0, 0);
	struct dem_classes *classes = open_classes(&params);
	uint8_t *values = read_classes(classes, 0, (struct post_rect){0, 0, 10, 10});
	assert_int_equal(values[5 * 10 + 1], ABSENT);
	assert_int_equal(values[5 * 10 + 3], mixed(0, 19));
	assert_int_equal(values[5 * 10 + 8], mixed(1, 19));
	free(values);
	dem_classes_close(classes);
}

int main(void)
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
		cmocka_unit_test(a_map_without_an_srs_is_in_the_stores_coordinates),
	};
	return cmocka_run_group_tests_name("classes_gdal", tests, folder_make, folder_remove);
}
