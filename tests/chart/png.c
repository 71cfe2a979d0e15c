/* Pictures as PNG files. No GL. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "chart/internal.h"
#include "../support/program.h"
#include "../support/skip.h"

static char folder[] = "/tmp/furrow-png-XXXXXX";
static char path[64], part[72];

static int make_folder(void **state)
{
	if (mkdtemp(folder) == NULL)
		return -1;
	snprintf(path, sizeof path, "%s/a.png", folder);
	snprintf(part, sizeof part, "%s.part", path);
	return 0;
}

static int remove_folder(void **state)
{
	unlink(path);
	return rmdir(folder);
}

static void fill(uint8_t *pixels, uint32_t width, uint32_t height)
{
	for (uint32_t i = 0; i < 4 * width * height; i++)
		pixels[i] = (uint8_t)(i * 37 + i / 11);
}

static void a_picture_comes_back_upright(void **state)
{
	uint8_t pixels[4 * 17 * 5], back[3 * 17 * 5];
	fill(pixels, 17, 5);
	assert_int_equal(chart_png_write(path, pixels, 17, 5), STATUS_OK);
	png_image image = {.version = PNG_IMAGE_VERSION};
	assert_true(png_image_begin_read_from_file(&image, path));
	assert_int_equal(image.width, 17);
	assert_int_equal(image.height, 5);
	image.format = PNG_FORMAT_RGB;
	assert_true(png_image_finish_read(&image, NULL, back, 0, NULL));
	for (uint32_t y = 0; y < 5; y++) /* row 0 is the lowest there, the highest here */
		for (uint32_t x = 0; x < 17; x++)
			assert_memory_equal(back + 3 * (17 * (4 - y) + x), pixels + 4 * (17 * y + x), 3);
	assert_int_not_equal(access(part, F_OK), 0);
}

static void a_folder_that_is_not_there_is_told(void **state)
{
	uint8_t pixels[4 * 2 * 2] = {0};
	assert_int_equal(chart_png_write("/nowhere/at/all/a.png", pixels, 2, 2), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "/nowhere/at/all/a.png"));
}

static void a_full_disk_is_told(void **state)
{
	/* A link to the device that has no room, where the unfinished picture goes. */
	uint8_t *pixels = test_calloc(4 * 64 * 64, 1);
	fill(pixels, 64, 64);
	unlink(path);
	if (access("/dev/full", W_OK) != 0 || symlink("/dev/full", part) != 0) {
		test_free(pixels);
		skip_since(SKIP_ELSEWHERE "no /dev/full");
	}
	assert_int_equal(chart_png_write(path, pixels, 64, 64), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "No space left"));
	assert_int_not_equal(access(path, F_OK), 0);
	assert_int_not_equal(access(part, F_OK), 0);
	test_free(pixels);
}

static void running_out_of_memory_is_told(void **state)
{
	uint8_t pixels[4 * 2 * 2] = {0};
	for (uint64_t nth = 1; nth <= 2; nth++) {
		mem_fail_nth(nth, 0);
		assert_int_equal(chart_png_write(path, pixels, 2, 2), STATUS_FAILED);
		mem_fail_nth(0, 0);
		assert_int_not_equal(access(part, F_OK), 0);
	}
}

TEST_PROGRAM(png)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_picture_comes_back_upright),
		cmocka_unit_test(a_folder_that_is_not_there_is_told),
		cmocka_unit_test(a_full_disk_is_told),
		cmocka_unit_test(running_out_of_memory_is_told),
	};
	return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
