/* Sources of more than 2^31 posts: rows, places and offsets beyond what 32 bits count. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <fcntl.h>
#include <sys/resource.h>

#include <gdal.h>

#include "files.h"
#include "../support/program.h"
#include "../support/skip.h"

enum { SIDE = 50000, PATCH = 64 };

static double patch_height(int64_t x, int64_t from_north)
{
	return 1000 + (double)x - 3 * (double)from_north;
}

static void write_patch(const char *name)
{
	GDALAllRegister();
	GDALDatasetH patch = GDALCreate(GDALGetDriverByName("GTiff"), in_folder(name), PATCH, PATCH, 1, GDT_Int16,
					NULL);
	assert_non_null(patch);
	int16_t values[PATCH * PATCH];
	for (int y = 0; y < PATCH; y++)
		for (int x = 0; x < PATCH; x++)
			values[y * PATCH + x] = (int16_t)patch_height(x, y);
	assert_int_equal(GDALRasterIO(GDALGetRasterBand(patch, 1), GF_Write, 0, 0, PATCH, PATCH, values, PATCH, PATCH,
				      GDT_Int16, 0, 0), CE_None);
	GDALClose(patch);
}

/* SIDE x SIDE posts 10 m apart, nodata but for a patch in each corner. `west` in metres. */
static const char *write_large(const char *name, double west)
{
	write_patch("patch.tif");
	char xml[4096];
	int length = snprintf(xml, sizeof xml, "<VRTDataset rasterXSize=\"%d\" rasterYSize=\"%d\"><SRS>EPSG:32633</SRS>"
			      "<GeoTransform>%.1f, 10, 0, 5500000, 0, -10</GeoTransform><VRTRasterBand dataType="
			      "\"Int16\" band=\"1\"><NoDataValue>-32768</NoDataValue>", SIDE, SIDE, west);
	for (int corner = 0; corner < 4; corner++)
		length += snprintf(xml + length, sizeof xml - (size_t)length,
				   "<SimpleSource><SourceFilename relativeToVRT=\"1\">patch.tif</SourceFilename>"
				   "<SourceBand>1</SourceBand><SrcRect xOff=\"0\" yOff=\"0\" xSize=\"%d\" "
				   "ySize=\"%d\"/><DstRect xOff=\"%d\" yOff=\"%d\" xSize=\"%d\" ySize=\"%d\"/>"
				   "</SimpleSource>", PATCH, PATCH, corner & 1 ? SIDE - PATCH : 0,
				   corner & 2 ? SIDE - PATCH : 0, PATCH, PATCH);
	length += snprintf(xml + length, sizeof xml - (size_t)length, "</VRTRasterBand></VRTDataset>");
	assert_true(length < (int)sizeof xml);
	write_file(name, xml, (size_t)length);
	return in_folder(name);
}

/* What stands at post (x, y) of one large source. */
static double large_height(int64_t x, int64_t y)
{
	int64_t from_north = SIDE - 1 - y, far = SIDE - PATCH;
	bool column = x < PATCH || x >= far, row = from_north < PATCH || from_north >= far;
	return column && row ? patch_height(x < PATCH ? x : x - far, from_north < PATCH ? from_north : from_north - far)
			     : (double)NAN;
}

static void assert_rows(struct dem *dem, int64_t y, int64_t count, int64_t sources)
{
	int64_t width = dem_info(dem)->width;
	double *rows = mem_alloc((size_t)(count * width), sizeof *rows);
	assert_int_equal(read_rows(dem, y, count, rows), STATUS_OK);
	for (int64_t row = 0; row < count; row++)
		for (int64_t x = 0; x < width; x++) {
			double wanted = large_height(x % SIDE, y + row), height = rows[row * width + x];
			if (!(height == wanted || (isnan(height) && isnan(wanted))))
				fail_msg("post %lld, %lld: %g, not %g", (long long)x, (long long)(y + row), height, wanted);
		}
	assert_int_equal(width, sources * SIDE);
	mem_free(rows);
}

static void a_row_beyond_2_31_posts_is_the_right_one(void **state)
{
	struct dem *dem = open_one(write_large("large.vrt", 300000));
	assert_int_equal(dem_info(dem)->width, SIDE);
	assert_int_equal(dem_info(dem)->height, SIDE);
	assert_true(dem_info(dem)->origin[0] == 300005 && dem_info(dem)->origin[1] == 5500000 - 10 * SIDE + 5);
	assert_rows(dem, 0, 2, 1);
	assert_rows(dem, 42949, 3, 1); /* where 2^31 posts end */
	assert_rows(dem, SIDE - 3, 3, 1);
	dem_close(dem);
}

static void two_large_sources_make_one_of_more_than_2_32_posts(void **state)
{
	const char *sources[] = {write_large("west.vrt", 0), write_large("east.vrt", 10.0 * SIDE)};
	struct dem_params params = params_of(sources, 2);
	params.s_srs = "LOCAL_CS[\"flat\",UNIT[\"metre\",1]]"; /* so wide a UTM zone is none */
	struct dem *dem = open_with(&params);
	assert_int_equal(dem_info(dem)->height, SIDE);
	assert_int_equal(dem_info(dem)->overlap_posts, 0);
	assert_rows(dem, 1, 1, 2);
	assert_rows(dem, SIDE - 2, 2, 2);
	dem_close(dem);
}

/* All of it lies under the few posts there are: it is warped in pieces, or it would not fit. */
static void a_large_source_is_resampled_in_bounded_memory(void **state)
{
	const char *path = write_large("large.vrt", 300000);
	struct dem_params params = params_of(&path, 1);
	params.spacing = 1000;
	params.resample = DEM_NEAR;
	struct dem *dem = open_with(&params);
	assert_int_equal(dem_info(dem)->width, 500);
	assert_int_equal(dem_info(dem)->height, 500);
	assert_true(height_at(dem, 0, 0) == large_height(0, 0));
	assert_true(isnan(height_at(dem, 250, 0)));
	dem_close(dem);
	struct rusage usage;
	assert_int_equal(getrusage(RUSAGE_SELF, &usage), 0);
	assert_in_range(usage.ru_maxrss, 1, 1500000); /* kilobytes */
}

/* A square of more than 2^31 heights, of which a few are written and the rest is a hole in the file. */
static void a_raw_heightmap_beyond_2_31_posts_is_read_where_it_is_asked(void **state)
{
	const int64_t side = 46400;
	const char *path = in_folder("large.r16");
	int file = open(path, O_RDWR | O_CREAT | O_TRUNC, 0600);
	assert_true(file >= 0);
	if (ftruncate(file, (off_t)(2 * side * side)) != 0) {
		close(file);
		skip_since(SKIP_ELSEWHERE "no files of 4 GB");
	}
	static const uint8_t first[2] = {0x39, 0x30}, last[2] = {0x31, 0xd4}; /* 12345 and 54321 */
	assert_int_equal(pwrite(file, first, 2, 0), 2);
	assert_int_equal(pwrite(file, last, 2, (off_t)(2 * (side * side - 1))), 2);
	close(file);
	struct dem *dem = open_one(path);
	assert_int_equal(dem_info(dem)->width, side);
	double *row = mem_alloc((size_t)side, sizeof *row);
	assert_int_equal(read_rows(dem, side - 1, 1, row), STATUS_OK);
	assert_true(row[0] == 12345 && row[side - 1] == 0);
	assert_int_equal(read_rows(dem, 0, 1, row), STATUS_OK);
	assert_true(row[0] == 0 && row[side - 1] == 54321);
	mem_free(row);
	dem_close(dem);
	assert_int_equal(unlink(path), 0);
}

/* Synthetic terrain has any row at once: of the largest world that a store can hold, too. */
static void synthetic_posts_beyond_2_31_do_not_repeat(void **state)
{
	enum { WIDTH = 1 << 22 };
	struct dem_synth synth = {DEM_SYNTH_RIDGED, WIDTH, WIDTH, 2, 120, 5};
	double *here = mem_alloc(WIDTH, sizeof *here), *there = mem_alloc(WIDTH, sizeof *there);
	dem_synth_posts(&synth, (struct post_rect){0, 5, WIDTH, 6}, here);
	dem_synth_posts(&synth, (struct post_rect){0, 5 + (1 << 10), WIDTH, 6 + (1 << 10)}, there); /* 2^32 posts on */
	int64_t equal = 0;
	for (int64_t x = 0; x < WIDTH; x++)
		equal += here[x] == there[x];
	assert_true(equal < WIDTH / 100);
	dem_synth_posts(&synth, (struct post_rect){0, WIDTH - 1, WIDTH, WIDTH}, there);
	for (int64_t x = 0; x < WIDTH; x++)
		assert_true(isfinite(there[x]));
	mem_free(here);
	mem_free(there);
}

TEST_PROGRAM(large)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_row_beyond_2_31_posts_is_the_right_one),
		cmocka_unit_test(two_large_sources_make_one_of_more_than_2_32_posts),
		cmocka_unit_test(a_large_source_is_resampled_in_bounded_memory),
		cmocka_unit_test(a_raw_heightmap_beyond_2_31_posts_is_read_where_it_is_asked),
		cmocka_unit_test(synthetic_posts_beyond_2_31_do_not_repeat),
	};
	return cmocka_run_group_tests_name("large", tests, folder_make, folder_remove);
}
