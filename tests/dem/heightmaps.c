/* PNG and raw heightmaps, holes and their filling, lists, and what is refused; without GDAL too. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "files.h"
#include "../support/program.h"

static void a_raw_heightmap_is_little_endian_and_starts_in_the_north(void **state)
{
	static const uint8_t bytes[] = {1, 0, 0, 1, 3, 0, 4, 0, 5, 0, 6, 0, 7, 0, 8, 0, 0xff, 0xff};
	write_file("small.r16", bytes, sizeof bytes);
	struct dem *dem = open_one(in_folder("small.r16"));
	assert_int_equal(dem_info(dem)->width, 3);
	assert_int_equal(dem_info(dem)->height, 3);
	assert_true(dem_info(dem)->spacing == 1 && dem_info(dem)->unit == 1);
	assert_string_equal(dem_info(dem)->srs, "");
	assert_true(height_at(dem, 0, 2) == 1);
	assert_true(height_at(dem, 1, 2) == 256);
	assert_true(height_at(dem, 0, 0) == 7);
	assert_true(height_at(dem, 2, 0) == 65535);
	dem_close(dem);

	const char *path = in_folder("small.r16");
	const double nodata[] = {4, 7};
	struct dem_params params = params_of(&path, 1);
	params.spacing = 2.5;
	params.nodata = nodata;
	params.nodata_count = 2;
	params.has_height_range = true;
	params.height_min = -100;
	params.height_max = 555.35;
	dem = open_with(&params);
	assert_true(dem_info(dem)->spacing == 2.5);
	assert_true(fabs(dem_info(dem)->unit - 0.01) < 1e-12);
	assert_true(fabs(height_at(dem, 2, 0) - 555.35) < 1e-4);
	assert_true(fabs(height_at(dem, 1, 2) + 97.44) < 1e-4);
	assert_true(isnan(height_at(dem, 0, 1)) && isnan(height_at(dem, 0, 0)));
	dem_close(dem);
}

static void a_raw_heightmap_of_8_bits_needs_its_height_range(void **state)
{
	static const uint8_t bytes[] = {0, 1, 2, 3, 4, 5, 6, 7, 255};
	static const char *const names[] = {"small.r8", "small.raw"};
	for (int i = 0; i < 2; i++) {
		write_file(names[i], bytes, sizeof bytes);
		const char *path = in_folder(names[i]);
		struct dem_params params = params_of(&path, 1);
		assert_refused(&params, STATUS_INPUT, "--height-range MIN,MAX");
		params.has_height_range = true;
		params.height_min = -10;
		params.height_max = 500;
		struct dem *dem = open_with(&params);
		assert_int_equal(dem_info(dem)->width, 3);
		assert_int_equal(dem_info(dem)->height, 3);
		assert_true(dem_info(dem)->unit == 2);
		assert_true(height_at(dem, 0, 2) == -10 && height_at(dem, 1, 2) == -8 && height_at(dem, 0, 0) == 2 && height_at(dem, 2, 0) == 500);
		dem_close(dem);
	}
	/* Twice a square of bytes has 16 bits, whatever range is given; an ending that says otherwise is not believed. */
	static const struct {
		const char *name, *why;
		size_t size;
	} wrong[] = {{"wrong.r16", "16-bit", 9}, {"wrong.r8", "8-bit", 8}, {"wrong.raw", "8-bit or 16-bit", 7}, {"wrong.r8", "8-bit", 7}};
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
		write_file(wrong[i].name, bytes, wrong[i].size);
		const char *path = in_folder(wrong[i].name);
		struct dem_params params = params_of(&path, 1);
		params.has_height_range = true;
		params.height_max = 1;
		assert_refused(&params, STATUS_INPUT, wrong[i].why);
	}
	write_file("wide.raw", bytes, 8);
	struct dem *dem = open_one(in_folder("wide.raw"));
	assert_int_equal(dem_info(dem)->width, 2);
	assert_true(height_at(dem, 0, 1) == 256);
	dem_close(dem);
}

static void write_png(const char *name, enum dem_raster_type type, int width, int height)
{
	struct dem_raster raster = {.path = in_folder(name), .width = width, .height = height, .type = type,
				    .spacing = 1};
	struct dem_writer *writer;
	assert_int_equal(dem_writer_create(&raster, &writer), STATUS_OK);
	double row[64];
	for (int y = 0; y < height; y++) {
		for (int x = 0; x < width; x++)
			row[x] = y * 3.4 + x * (type == DEM_UINT16 ? 1000 : 10);
		assert_int_equal(dem_writer_rows(writer, 1, row), STATUS_OK);
	}
	assert_int_equal(dem_writer_publish(writer), STATUS_OK);
	dem_writer_destroy(writer);
}

static void a_window_is_in_metres_from_the_south_west_post(void **state)
{
	write_png("windowed.png", DEM_UINT16, 32, 20);
	const char *path = in_folder("windowed.png");
	struct dem_params params = params_of(&path, 1);
	for (params.spacing = 0.5; params.spacing <= 8; params.spacing *= 4) {
		double s = params.spacing;
		params.has_window = false;
		struct dem *whole = open_with(&params);
		params.has_window = true;
		memcpy(params.window, (double[]){2.5 * s, -7, 10 * s, 4.9 * s}, sizeof params.window);
		struct dem *part = open_with(&params);
		assert_int_equal(dem_info(part)->width, 8);
		assert_int_equal(dem_info(part)->height, 5);
		assert_true(dem_info(part)->origin[0] == 3 * s && dem_info(part)->origin[1] == 0);
		for (int y = 0; y < 5; y++)
			for (int x = 0; x < 8; x++)
				assert_true(height_at(part, x, y) == height_at(whole, x + 3, y));
		dem_close(part);
		dem_close(whole);
	}
	(void)mem_fail_nth(0, 0);
	dem_close(open_with(&params));
	uint64_t count = mem_fail_nth(0, 0);
	for (uint64_t nth = 1; nth <= count; nth++) {
		struct dem *dem = NULL;
		(void)mem_fail_nth(nth, 1);
		enum status status = dem_open(&params, &dem);
		(void)mem_fail_nth(0, 0);
		assert_true(status != STATUS_OK);
	}
	memcpy(params.window, (double[]){1000, 0, 2000, 50}, sizeof params.window);
	assert_refused(&params, STATUS_INPUT, "another window");
	params.window_srs = "EPSG:4326";
	assert_refused(&params, STATUS_INPUT, "no place on a planet");
}

static void a_png_comes_back_as_it_was_written(void **state)
{
	write_png("wide.png", DEM_UINT16, 60, 7);
	struct dem *dem = open_one(in_folder("wide.png"));
	assert_int_equal(dem_info(dem)->width, 60);
	assert_int_equal(dem_info(dem)->height, 7);
	for (int y = 0; y < 7; y++)
		for (int x = 0; x < 60; x++)
			assert_true(height_at(dem, x, y) == round(y * 3.4 + x * 1000.0));
	dem_close(dem);
	write_png("small.png", DEM_UINT8, 21, 5);
	dem = open_one(in_folder("small.png"));
	for (int y = 0; y < 5; y++)
		for (int x = 0; x < 21; x++)
			assert_true(height_at(dem, x, y) == round(y * 3.4 + x * 10.0));
	dem_close(dem);
	const char *path = in_folder("small.png");
	struct dem_params params = params_of(&path, 1);
	params.has_height_range = true;
	params.height_min = 100;
	params.height_max = 355;
	dem = open_with(&params);
	assert_true(height_at(dem, 20, 0) == 300);
	dem_close(dem);
}

static void a_writer_leaves_nothing_half_made(void **state)
{
	struct dem_raster raster = {.path = in_folder("half.png"), .width = 4, .height = 4, .type = DEM_UINT8};
	struct dem_writer *writer;
	double row[4] = {0};
	assert_int_equal(dem_writer_create(&raster, &writer), STATUS_OK);
	assert_int_equal(dem_writer_rows(writer, 1, row), STATUS_OK);
	assert_int_equal(dem_writer_publish(writer), STATUS_FAILED); /* rows are missing */
	dem_writer_destroy(writer);
	assert_int_not_equal(access(in_folder("half.png"), F_OK), 0);
	assert_int_not_equal(access(in_folder("half.png.part"), F_OK), 0);
	dem_writer_destroy(NULL);
	raster.path = "/nonexistent-folder/out.png";
	assert_int_equal(dem_writer_create(&raster, &writer), STATUS_FAILED);
	raster.path = in_folder("out.bmp");
	assert_int_equal(dem_writer_create(&raster, &writer), STATUS_USAGE);
	raster.path = in_folder("out.png");
	raster.type = DEM_FLOAT32;
	assert_int_equal(dem_writer_create(&raster, &writer), STATUS_USAGE);
}

/* A slope with a hole of 12 x 12 in it and one at a corner. */
static void holes_are_filled_from_their_rims_and_data_stays(void **state)
{
	enum { N = 40 };
	uint8_t bytes[N * N * 2];
	for (int y = 0; y < N; y++)
		for (int x = 0; x < N; x++) {
			bool hole = (x >= 10 && x < 22 && y >= 12 && y < 24) || (x > 35 && y > 35);
			unsigned v = hole ? 9 : (unsigned)(1000 + 50 * x + 20 * y);
			bytes[2 * (y * N + x)] = (uint8_t)v;
			bytes[2 * (y * N + x) + 1] = (uint8_t)(v >> 8);
		}
	write_file("holes.raw", bytes, sizeof bytes);
	const char *path = in_folder("holes.raw");
	const double nodata = 9;
	struct dem_params params = params_of(&path, 1);
	params.nodata = &nodata;
	params.nodata_count = 1;
	struct dem *dem = open_with(&params);
	assert_true(isnan(height_at(dem, 15, N - 1 - 15)));
	dem_close(dem);
	params.fill = true;
	dem = open_with(&params);
	for (int y = 0; y < N; y++)
		for (int x = 0; x < N; x++) {
			double height = height_at(dem, x, N - 1 - y), plane = 1000 + 50 * x + 20 * y;
			bool inner = x >= 10 && x < 22 && y >= 12 && y < 24, corner = x > 35 && y > 35;
			assert_false(isnan(height));
			if (inner)
				assert_true(fabs(height - plane) < 60); /* of 840 across the hole */
			else if (!corner)
				assert_true(height == plane);
		}
	dem_close(dem);
	static const uint8_t empty[8] = {9, 0, 9, 0, 9, 0, 9, 0};
	write_file("holes.raw", empty, sizeof empty);
	assert_refused(&params, STATUS_INPUT, "no data at all");
}

static void lists_may_end_their_lines_as_windows_does(void **state)
{
	static const uint8_t bytes[8] = {1, 0, 2, 0, 3, 0, 4, 0};
	write_file("listed.raw", bytes, sizeof bytes);
	static const char text[] = "\xef\xbb\xbf# a comment\r\n\r\n  listed.raw \r\n";
	write_file("list.txt", text, sizeof text - 1);
	char at[420];
	snprintf(at, sizeof at, "@%s", in_folder("list.txt"));
	struct dem *dem = open_one(at);
	assert_int_equal(dem_info(dem)->source_count, 1);
	assert_string_equal(dem_info(dem)->sources[0], in_folder("listed.raw"));
	assert_true(height_at(dem, 1, 0) == 4);
	dem_close(dem);
	const char *path = at;
	struct dem_params params = params_of(&path, 1);
	write_file("list.txt", "# nothing\n", 10);
	assert_refused(&params, STATUS_INPUT, "list.txt");
	path = "@/nonexistent.txt";
	assert_refused(&params, STATUS_INPUT, "/nonexistent.txt");
}

static void a_directory_stands_for_the_rasters_in_it(void **state)
{
	static const uint8_t bytes[8] = {1, 0, 2, 0, 3, 0, 4, 0};
	assert_int_equal(mkdir(in_folder("sub"), 0700), 0);
	const char *path = in_folder("sub");
	struct dem_params params = params_of(&path, 1);
	assert_refused(&params, STATUS_INPUT, "no raster");
	write_file("sub/only.raw", bytes, sizeof bytes);
	write_file("sub/notes.txt", "x", 1);
	struct dem *dem = open_one(in_folder("sub"));
	assert_string_equal(dem_info(dem)->sources[0], in_folder("sub/only.raw"));
	dem_close(dem);
}

static void what_cannot_be_read_is_refused_by_name(void **state)
{
	const char *path = "/nonexistent.png";
	struct dem_params params = params_of(&path, 1);
	assert_refused(&params, STATUS_INPUT, "/nonexistent.png: no such file");
	write_file("empty.png", "", 0);
	path = in_folder("empty.png");
	assert_refused(&params, STATUS_INPUT, "empty.png: the file is empty");
	write_file("garbage.png", "not a png at all", 16);
	path = in_folder("garbage.png");
	assert_refused(&params, STATUS_INPUT, "garbage.png");
	write_file("odd.raw", "123456", 6);
	path = in_folder("odd.raw");
	assert_refused(&params, STATUS_INPUT, "odd.raw: 6 bytes");
	write_file("dot.raw", "12", 2);
	path = in_folder("dot.raw");
	assert_refused(&params, STATUS_INPUT, "dot.raw: 1 x 1");
	write_file("garbage.tif", "II*\0 no tiff either", 19);
	path = in_folder("garbage.tif");
	assert_refused(&params, STATUS_INPUT, "garbage.tif");
	const char *two[] = {in_folder("wide.png"), in_folder("small.png")};
	params = params_of(two, 2);
	assert_refused(&params, STATUS_INPUT, "has no place");
	params = params_of(two, 0);
	assert_refused(&params, STATUS_USAGE, "no source");
}

static void a_cut_off_png_is_refused(void **state)
{
	FILE *file = fopen(in_folder("wide.png"), "rb");
	char bytes[8192];
	size_t size = fread(bytes, 1, sizeof bytes, file);
	fclose(file);
	const char *path = in_folder("cut.png");
	struct dem_params params = params_of(&path, 1);
	for (size_t keep = 1; keep + 12 < size; keep += 7) {
		write_file("cut.png", bytes, keep);
		assert_refused(&params, STATUS_INPUT, "cut.png");
	}
}

static void every_failing_allocation_is_told(void **state)
{
	const char *path = in_folder("small.png");
	const double nodata = 10;
	struct dem_params params = params_of(&path, 1);
	params.nodata = &nodata;
	params.nodata_count = 1;
	params.fill = true;
	(void)mem_fail_nth(0, 0);
	dem_close(open_with(&params));
	uint64_t made = mem_fail_nth(0, 0);
	assert_true(made > 5);
	for (uint64_t nth = 1; nth <= made; nth++) {
		struct dem *dem = NULL;
		(void)mem_fail_nth(nth, 0);
		enum status status = dem_open(&params, &dem);
		(void)mem_fail_nth(0, 0);
		assert_true(status != STATUS_OK);
	}
}

TEST_PROGRAM(heightmaps)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_raw_heightmap_is_little_endian_and_starts_in_the_north),
		cmocka_unit_test(a_raw_heightmap_of_8_bits_needs_its_height_range),
		cmocka_unit_test(a_window_is_in_metres_from_the_south_west_post),
		cmocka_unit_test(a_png_comes_back_as_it_was_written),
		cmocka_unit_test(a_writer_leaves_nothing_half_made),
		cmocka_unit_test(holes_are_filled_from_their_rims_and_data_stays),
		cmocka_unit_test(lists_may_end_their_lines_as_windows_does),
		cmocka_unit_test(a_directory_stands_for_the_rasters_in_it),
		cmocka_unit_test(what_cannot_be_read_is_refused_by_name),
		cmocka_unit_test(a_cut_off_png_is_refused),
		cmocka_unit_test(every_failing_allocation_is_told),
	};
	return cmocka_run_group_tests_name("heightmaps", tests, folder_make, folder_remove);
}
