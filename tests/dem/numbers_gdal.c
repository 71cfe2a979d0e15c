/* Rasters of numbers from GeoTIFFs: any SRS, nodata, scale, and what is refused. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <gdal.h>
#include <math.h>
#include <ogr_srs_api.h>

#include "numbers.h"

static const struct extent extent = {257, 129, 10, 64};
#define WEST 500000.0
#define SOUTH 5000000.0
#define ZONE "EPSG:32633"

struct raster {
	const char *name, *srs; /* NULL: none */
	int width, height;
	GDALDataType type;
	double place[6];
	double nodata, scale, offset; /* nodata 0: none; scale 0: none */
	double (*value_of)(int column, int row);
};

/* A plane: interpolated anywhere it is itself. */
static double plane(int column, int row)
{
	return 100 + 3.5 * column - 1.25 * row;
}

static double plane_with_holes(int column, int row)
{
	return column % 5 == 2 && row % 4 == 1 ? -1 : plane(column, row);
}

static void make(const struct raster *raster)
{
	GDALAllRegister();
	GDALDatasetH dataset = GDALCreate(GDALGetDriverByName("GTiff"), in_folder(raster->name), raster->width, raster->height, 1,
					  raster->type, NULL);
	assert_non_null(dataset);
	assert_int_equal(GDALSetGeoTransform(dataset, (double *)raster->place), CE_None);
	if (raster->srs != NULL) {
		OGRSpatialReferenceH srs = OSRNewSpatialReference(NULL);
		assert_int_equal(OSRSetFromUserInput(srs, raster->srs), OGRERR_NONE);
		assert_int_equal(GDALSetSpatialRef(dataset, srs), CE_None);
		OSRDestroySpatialReference(srs);
	}
	GDALRasterBandH band = GDALGetRasterBand(dataset, 1);
	if (raster->nodata != 0)
		GDALSetRasterNoDataValue(band, raster->nodata);
	if (raster->scale != 0) {
		GDALSetRasterScale(band, raster->scale);
		GDALSetRasterOffset(band, raster->offset);
	}
	double row[512];
	for (int y = 0; y < raster->height; y++) {
		for (int x = 0; x < raster->width; x++)
			row[x] = raster->value_of(x, y);
		assert_int_equal(GDALRasterIO(band, GF_Write, 0, y, raster->width, 1, row, raster->width, 1, GDT_Float64, 0, 0), CE_None);
	}
	GDALClose(dataset);
}

static struct raster utm(const char *name)
{
	return (struct raster){.name = name, .srs = ZONE, .width = 40, .height = 30, .type = GDT_Float64,
			       .place = {WEST - 300, 50, 0, SOUTH + 1400, 0, -50}, .value_of = plane};
}

static const char *wkt(void)
{
	static char text[8192];
	OGRSpatialReferenceH srs = OSRNewSpatialReference(NULL);
	char *made = NULL;
	assert_int_equal(OSRSetFromUserInput(srs, ZONE), OGRERR_NONE);
	assert_int_equal(OSRExportToWkt(srs, &made), OGRERR_NONE);
	snprintf(text, sizeof text, "%s", made);
	VSIFree(made);
	OSRDestroySpatialReference(srs);
	return text;
}

static struct dem_numbers *opened(const struct raster *raster)
{
	make(raster);
	struct dem_classes_params params = classes_of(raster->name, &extent, wkt(), WEST, SOUTH);
	return open_numbers(&params);
}

/* Where each post lies on the raster: columns and rows from its north-west corner. */
static void place(const struct raster *raster, int level, struct post_rect rect, double *columns, double *rows)
{
	double inverse[6];
	size_t width = (size_t)(rect.x1 - rect.x0), count = width * (size_t)(rect.y1 - rect.y0);
	assert_true(GDALInvGeoTransform((double *)raster->place, inverse));
	for (size_t i = 0; i < count; i++) {
		columns[i] = WEST + ldexp((double)(rect.x0 + (int64_t)(i % width)), level) * extent.spacing;
		rows[i] = SOUTH + ldexp((double)(rect.y0 + (int64_t)(i / width)), level) * extent.spacing;
	}
	if (strcmp(raster->srs, ZONE) != 0)
		assert_int_equal(dem_transform(wkt(), raster->srs, count, columns, rows), STATUS_OK);
	for (size_t i = 0; i < count; i++) {
		double x = columns[i], y = rows[i];
		columns[i] = inverse[0] + inverse[1] * x + inverse[2] * y;
		rows[i] = inverse[3] + inverse[4] * x + inverse[5] * y;
	}
}

static void check_plane(const struct raster *raster, int level, struct post_rect rect)
{
	size_t count = (size_t)((rect.x1 - rect.x0) * (rect.y1 - rect.y0)), inside = 0;
	double *columns = malloc(count * sizeof *columns), *rows = malloc(count * sizeof *rows);
	struct dem_numbers *numbers = opened(raster);
	double *values = read_numbers(numbers, level, rect);
	place(raster, level, rect, columns, rows);
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
	dem_numbers_close(numbers);
}

static void a_plane_is_itself_wherever_posts_lie(void **state)
{
	struct raster raster = utm("own.tif");
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
	struct raster raster = utm("holes.tif");
	const struct post_rect rect = {0, 0, 320, 240};
	enum { COUNT = 320 * 240 };
	double *columns = malloc(COUNT * sizeof *columns), *rows = malloc(COUNT * sizeof *rows), low, high;
	raster.value_of = plane_with_holes;
	raster.nodata = -1;
	struct dem_numbers *numbers = opened(&raster);
	double *values = read_numbers(numbers, -2, rect);
	place(&raster, -2, rect, columns, rows);
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
	dem_numbers_close(numbers);
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
	struct raster raster = utm("scaled.tif");
	raster.type = GDT_UInt16;
	raster.value_of = whole;
	raster.scale = 0.25;
	raster.offset = -3;
	struct dem_numbers *numbers = opened(&raster);
	assert_int_equal(dem_numbers_extremes(numbers, &range, &low, &high), STATUS_OK);
	assert_true(low == -3 && high == -3 + 0.25 * 68);
	dem_numbers_close(numbers);
	raster = utm("nan.tif");
	raster.type = GDT_Float32;
	raster.value_of = not_a_number;
	numbers = opened(&raster);
	assert_int_equal(dem_numbers_extremes(numbers, &range, &low, &high), STATUS_OK);
	assert_true(low == 5 && high == 5);
	double *values = read_numbers(numbers, 0, (struct post_rect){-15, 60, -10, 61}); /* in column 3 */
	assert_true(isnan(values[1]) && isnan(values[4]));
	free(values);
	dem_numbers_close(numbers);
	raster.name = "infinite.tif";
	raster.value_of = infinite;
	numbers = opened(&raster);
	assert_extremes_refused(numbers, &range, "column 3, row 1: cohesion inf Pa is out of range; allowed: -1000000000 to 1000000000");
	dem_numbers_close(numbers);
}

static void what_is_no_raster_of_numbers_is_refused(void **state)
{
	const struct dem_numbers_range range = {"cohesion", "Pa", 0, 1e9, false};
	struct raster raster = utm("bad.tif");
	struct dem_classes_params params = classes_of("bad.tif", &extent, wkt(), WEST, SOUTH);
	assert_numbers_refused(&params, "cannot be opened as a raster of soil numbers");
	raster.type = GDT_CFloat32;
	make(&raster);
	assert_numbers_refused(&params, "holds CFloat32, and numbers are real");
	raster.type = GDT_Float32;
	make(&raster);
	params.srs = "";
	assert_numbers_refused(&params, "lies on a planet, and the store is local metres");
	struct dem_numbers *numbers = opened(&raster);
	dem_numbers_close(numbers);
	char path[400];
	snprintf(path, sizeof path, "%s", in_folder("bad.tif"));
	assert_int_equal(truncate(path, 3000), 0);
	params = classes_of("bad.tif", &extent, wkt(), WEST, SOUTH);
	if (dem_numbers_open(&params, &numbers) != STATUS_OK) { /* a driver may look for the end at once */
		assert_told("cannot be opened as a raster of soil numbers");
		return;
	}
	assert_extremes_refused(numbers, &range, "reading it failed at column 0, row");
	dem_numbers_close(numbers);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_plane_is_itself_wherever_posts_lie),
		cmocka_unit_test(holes_are_where_the_nearest_pixel_has_none),
		cmocka_unit_test(scale_offset_and_nan_are_understood),
		cmocka_unit_test(what_is_no_raster_of_numbers_is_refused),
	};
	return cmocka_run_group_tests_name("numbers_gdal", tests, folder_make, folder_remove);
}
