/* Real elevation data, where there is some: each opens as what it is known to be. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "files.h"
#include "../support/program.h"
#include "../support/skip.h"

struct seen {
	double low, high, holes; /* metres, and the share of posts without data */
};

/* NULL if it is not there: the test is skipped. */
static const char *shared_file(const char *name)
{
	static char paths[2][512];
	static int turn;
	const char *shared = getenv("SHARED");
	char *path = paths[turn++ % 2];
	snprintf(path, sizeof paths[0], "%s/dem/%s", shared != NULL ? shared : "", name);
	if (shared == NULL || access(path, R_OK) != 0)
		skip_since(SKIP_ELSEWHERE "no shared elevation data");
	return path;
}

static struct seen look(struct dem *dem)
{
	const struct dem_info *info = dem_info(dem);
	double *row = mem_alloc((size_t)info->width, sizeof *row);
	struct seen seen = {1e9, -1e9, 0};
	for (int64_t y = 0; y < info->height; y++) {
		assert_int_equal(read_rows(dem, y, 1, row), STATUS_OK);
		for (int64_t x = 0; x < info->width; x++) {
			if (isnan(row[x])) {
				seen.holes++;
				continue;
			}
			seen.low = fmin(seen.low, row[x]);
			seen.high = fmax(seen.high, row[x]);
		}
	}
	seen.holes /= (double)info->width * (double)info->height;
	mem_free(row);
	return seen;
}

static void two_srtm_tiles_share_a_row_and_become_one_in_utm(void **state)
{
	const char *sources[] = {shared_file("N41E001.hgt"), shared_file("N42E001.hgt")};
	struct dem_params params = params_of(sources, 2);
	struct dem *dem = open_with(&params);
	const struct dem_info *info = dem_info(dem);
	assert_non_null(strstr(info->srs, "UTM zone 31N"));
	assert_true(info->spacing == 79.9 && info->unit == 1);
	assert_int_equal(info->overlap_posts, 1201);
	assert_int_equal(info->overlap_differing, 0);
	struct seen seen = look(dem);
	assert_true(seen.low > -21 && seen.low < 0 && seen.high > 3080 && seen.high < 3101);
	assert_true(seen.holes < 0.07);
	dem_close(dem);
}

static void metres_stay_as_they_are(void **state)
{
	struct dem *dem = open_one(shared_file("bigtujunga.tif"));
	assert_int_equal(dem_info(dem)->width, 1197);
	assert_true(dem_info(dem)->spacing == 30);
	struct seen seen = look(dem);
	assert_true(seen.low == 315 && seen.high == 2295 && seen.holes == 0);
	dem_close(dem);
	dem = open_one(shared_file("gabilan_dtm1m.bil"));
	assert_int_equal(dem_info(dem)->height, 859);
	assert_true(dem_info(dem)->spacing == 1 && dem_info(dem)->unit == 0);
	seen = look(dem);
	assert_true(fabs(seen.low - 187.9) < 0.01 && fabs(seen.high - 307.28) < 0.01 && seen.holes == 0);
	dem_close(dem);
	dem = open_one(shared_file("sthelens.dem"));
	assert_int_equal(dem_info(dem)->width, 327);
	seen = look(dem);
	assert_true(seen.low == 682 && seen.high == 2543 && seen.holes > 0.02 && seen.holes < 0.03);
	dem_close(dem);
}

static void mars_is_made_true_at_its_own_latitude(void **state)
{
	struct dem *dem = open_one(shared_file("mars_gale_ctx20m.tif"));
	assert_non_null(strstr(dem_info(dem)->srs, "Equidistant Cylindrical"));
	assert_true(dem_info(dem)->spacing == 20 && dem_info(dem)->unit == 0);
	struct seen seen = look(dem);
	assert_true(seen.low > -4512 && seen.high < -2284 && fabs(seen.holes - 0.39) < 0.01);
	dem_close(dem);
}

static void voids_stay_voids_unless_filled(void **state)
{
	const char *path = shared_file("everest_voids.tif");
	struct dem_params params = params_of(&path, 1);
	struct dem *dem = open_with(&params);
	struct seen seen = look(dem);
	assert_true(seen.low > 191 && seen.high > 8500 && seen.high < 8643 && seen.holes > 0.09 &&
		    seen.holes < 0.1);
	dem_close(dem);
	params.fill = true;
	dem = open_with(&params);
	struct seen filled = look(dem);
	assert_true(filled.holes == 0 && filled.low >= seen.low - 1e-3 && filled.high <= seen.high + 1e-3);
	dem_close(dem);
}

static void an_undeclared_nodata_can_be_named(void **state)
{
	const char *path = shared_file("craterlake.tif");
	const double nodata = -32767;
	struct dem_params params = params_of(&path, 1);
	params.nodata = &nodata;
	params.nodata_count = 1;
	struct dem *dem = open_with(&params);
	struct seen seen = look(dem);
	assert_true(seen.low >= 1289 && seen.high <= 1880 && fabs(seen.holes - 0.34) < 0.02);
	dem_close(dem);
}

static void a_16_bit_png_is_a_metre_a_unit(void **state)
{
	struct dem *dem = open_one(shared_file("heightmap16_1280.png"));
	assert_int_equal(dem_info(dem)->width, 1280);
	struct seen seen = look(dem);
	assert_true(seen.low == 0 && seen.high == 65528);
	dem_close(dem);
}

TEST_PROGRAM(shared)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(two_srtm_tiles_share_a_row_and_become_one_in_utm),
		cmocka_unit_test(metres_stay_as_they_are),
		cmocka_unit_test(mars_is_made_true_at_its_own_latitude),
		cmocka_unit_test(voids_stay_voids_unless_filled),
		cmocka_unit_test(an_undeclared_nodata_can_be_named),
		cmocka_unit_test(a_16_bit_png_is_a_metre_a_unit),
	};
	return cmocka_run_group_tests_name("shared", tests, NULL, NULL);
}
