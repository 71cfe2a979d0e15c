/* Numbers of the soil at posts: a byte for each raster, the same alone and in a tile; ranges; what is refused. */
#include "../support.h"
#include "../support/program.h"

#include "resident/resident.h"

enum { CELLS = 16, SIDE = CELLS + 1, WIDTH = 40, HEIGHT = 30 };

/* A pixel a post from the north-west, over a part of the terrain. */
static const struct store_meta meta = {.extent = {65, 49, 2, CELLS}, .srs = ""};

static int cohesion_of(int column, int row)
{
	return 200 + (column * 37 + row * 101) % 2541;
}

static int angle_of(int column, int row)
{
	return 20 + (column + row) % 2;
}

static const char *write_raster(const char *name, int (*value_of)(int column, int row))
{
	static char paths[2][400];
	static int next;
	char *path = paths[next++ % 2];
	double row[WIDTH];
	snprintf(path, sizeof paths[0], "%s", support_path(name));
	struct dem_raster raster = {.path = path, .width = WIDTH, .height = HEIGHT, .type = DEM_UINT16, .spacing = 1};
	struct dem_writer *writer;
	must(dem_writer_create(&raster, &writer));
	for (int y = HEIGHT - 1; y >= 0; y--) {
		for (int x = 0; x < WIDTH; x++)
			row[x] = value_of(x, y);
		must(dem_writer_rows(writer, 1, row));
	}
	must(dem_writer_publish(writer));
	dem_writer_destroy(writer);
	return path;
}

static struct soil_rasters_params params_of(unsigned loaders)
{
	return (struct soil_rasters_params){
		.rasters = {{write_raster("angle.png", angle_of), "friction_angle", "degrees", 0, 89, false},
			    {write_raster("cohesion.png", cohesion_of), "cohesion", "Pa", 0, 1e9, false}},
		.count = 2,
		.loaders = loaders,
		.places = true,
		.meta = &meta,
	};
}

/* Of a post of level 0. */
static uint8_t level_at(int (*value_of)(int column, int row), double low, double high, int64_t x, int64_t y)
{
	int64_t row = meta.extent.height - 1 - y;
	if (x >= WIDTH || row < 0 || row >= HEIGHT)
		return 0;
	return (uint8_t)(1 + floor((value_of((int)x, (int)row) - low) / (high - low) * 254 + 0.5));
}

static void a_post_has_a_byte_of_each_raster(void **state)
{
	struct soil_rasters *rasters;
	struct soil_rasters_params params = params_of(3);
	double low, high, least = INFINITY, most = 0;
	int above = 0, below = 0;
	must(resident_soil_rasters_open(&params, &rasters));
	for (int i = 0; i < WIDTH * HEIGHT; i++) {
		least = fmin(least, cohesion_of(i % WIDTH, i / WIDTH));
		most = fmax(most, cohesion_of(i % WIDTH, i / WIDTH));
	}
	resident_soil_rasters_range(rasters, 0, &low, &high);
	assert_true(low == 20 && high == 21);
	resident_soil_rasters_range(rasters, 1, &low, &high);
	assert_true(low == least && high == most);
	for (uint32_t ty = 0; ty < 3; ty++)
		for (uint32_t tx = 0; tx < 4; tx++) {
			uint8_t numbers[SIDE * SIDE][PAGES_NUMBER_BYTES], one[PAGES_NUMBER_BYTES];
			must(resident_soil_rasters_read(rasters, (tx + ty) % 3, (struct tile){0, tx, ty}, numbers[0]));
			for (int i = 0; i < SIDE * SIDE; i++) {
				int64_t x = tx * CELLS + i % SIDE, y = ty * CELLS + i / SIDE;
				assert_int_equal(numbers[i][0], level_at(angle_of, 20, 21, x, y));
				assert_int_equal(numbers[i][1], level_at(cohesion_of, least, most, x, y));
				assert_int_equal(numbers[i][2] | numbers[i][3], 0);
				above += numbers[i][1] > 1;
				below += numbers[i][1] == 0;
				must(resident_soil_rasters_at(rasters, 0, x, y, one));
				assert_memory_equal(one, numbers[i], sizeof one);
			}
		}
	assert_true(above > 100 && below > 100);
	resident_soil_rasters_close(rasters);
	resident_soil_rasters_close(NULL);
}

/* Between 20 and 21 half way, and at finer posts in steps of what the place has. */
static void finer_posts_have_numbers_between(void **state)
{
	struct soil_rasters *rasters;
	struct soil_rasters_params params = params_of(0);
	uint8_t one[PAGES_NUMBER_BYTES];
	must(resident_soil_rasters_open(&params, &rasters));
	for (int64_t x = 0; x <= 32; x++) {
		must(resident_soil_rasters_at(rasters, -3, x, 48 * 8, one)); /* the northern row */
		double value = fabs(fmod((double)x / 8, 2) - 1);             /* 1 at even pixels, 0 at odd */
		assert_int_equal(one[0], 1 + (int)floor((1 - value) * 254 + 0.5));
	}
	resident_soil_rasters_close(rasters);
}

static int all_alike(int column, int row)
{
	return 700;
}

static void one_value_everywhere_is_level_1(void **state)
{
	struct soil_rasters *rasters;
	struct soil_rasters_params params = {.rasters = {{write_raster("alike.png", all_alike), "cohesion", "Pa", 0, 1e9, false}}, .count = 1,
					     .places = true, .meta = &meta};
	uint8_t one[PAGES_NUMBER_BYTES];
	double low, high;
	must(resident_soil_rasters_open(&params, &rasters));
	resident_soil_rasters_range(rasters, 0, &low, &high);
	assert_true(low == 700 && high == 700);
	must(resident_soil_rasters_at(rasters, 0, 3, 40, one));
	assert_int_equal(one[0], 1);
	must(resident_soil_rasters_at(rasters, 0, 60, 40, one));
	assert_int_equal(one[0], 0);
	resident_soil_rasters_close(rasters);
}

static void what_is_not_allowed_is_refused(void **state)
{
	struct soil_rasters *rasters = NULL;
	struct soil_rasters_params params = params_of(1);
	params.rasters[1].high = 1000;
	assert_int_equal(resident_soil_rasters_open(&params, &rasters), STATUS_INPUT);
	assert_null(rasters);
	assert_non_null(strstr(failure_message(), "cohesion.png: column "));
	params = params_of(1);
	params.rasters[0].path = support_path("absent.png");
	assert_int_equal(resident_soil_rasters_open(&params, &rasters), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "absent.png"));
}

static void memory_that_runs_out_is_told(void **state)
{
	struct soil_rasters *rasters;
	struct soil_rasters_params params = params_of(2);
	enum status status;
	uint64_t nth = 0;
	do {
		rasters = NULL;
		mem_fail_nth(++nth, 0);
		status = resident_soil_rasters_open(&params, &rasters);
		mem_fail_nth(0, 0);
		assert_true(status == STATUS_OK || (rasters == NULL && strstr(failure_message(), "memory") != NULL));
	} while (status != STATUS_OK && nth < 200);
	assert_true(status == STATUS_OK && nth > 20);
	resident_soil_rasters_close(rasters);
}

TEST_PROGRAM(soil_rasters)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_post_has_a_byte_of_each_raster),
		cmocka_unit_test(finer_posts_have_numbers_between),
		cmocka_unit_test(one_value_everywhere_is_level_1),
		cmocka_unit_test(what_is_not_allowed_is_refused),
		cmocka_unit_test(memory_that_runs_out_is_told),
	};
	return cmocka_run_group_tests_name("soil_rasters", tests, support_enter, support_leave);
}
