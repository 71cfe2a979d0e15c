/* The lines that say which insets a store has: they come back, and what is no such line ends the reading. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#include "store/store.h"
#include "../support/program.h"

static const struct extent extent = {1000, 800, 30, 64};

static void lines_come_back(void **state)
{
	static const struct store_inset insets[] = {{-1, 0, 0, 3, 3, "a.tif", 5}, {-5, 31968, 12, 1, 25557, "a folder/b c.tif", 16},
						    {-14, 16000000, 9, 300, 5, "", 0}};
	char text[400] = "";
	for (size_t i = 0; i < 3; i++) {
		const size_t used = strlen(text);
		const int length = store_inset_line(&insets[i], text + used, sizeof text - used);
		assert_int_equal(length, strlen(text + used));
	}
	const char *at = text;
	struct store_inset inset;
	for (size_t i = 0; i < 3; i++) {
		assert_true(store_inset_next(&at, &extent, &inset));
		assert_int_equal(inset.level, insets[i].level);
		assert_true(inset.x == insets[i].x && inset.y == insets[i].y && inset.width == insets[i].width && inset.height == insets[i].height);
		assert_int_equal(inset.source_length, insets[i].source_length);
		assert_memory_equal(inset.source, insets[i].source, inset.source_length);
	}
	assert_false(store_inset_next(&at, &extent, &inset));
	assert_int_equal(*at, 0);
}

static void what_is_no_line_ends_the_reading(void **state)
{
	static const char *const texts[] = {"", "\n", "-1", "-1 0 0 3 3", "-1 0 0 3", "0 0 0 3 3 a", "1 0 0 3 3 a", "-15 0 0 3 3 a", "-1 -1 0 3 3 a",
					    "-1 0 0 0 3 a", "-1 0 0 2000 3 a", "-1 1998 0 2 3 a", "-1 0 1599 3 1 a", "-1  0 0 3 3 a", "x 0 0 3 3 a",
					    "-1 0 0 3 99999999999999999999 a", "-1 0 0 3 3.5 a", " -1 0 0 3 3 a", "-1\n0 0 3 3 a"};
	for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
		const char *at = texts[i];
		struct store_inset inset;
		assert_false(store_inset_next(&at, &extent, &inset));
		assert_ptr_equal(at, texts[i]);
	}
}

TEST_PROGRAM(insets_text)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(lines_come_back),
		cmocka_unit_test(what_is_no_line_ends_the_reading),
	};
	return cmocka_run_group_tests_name("insets_text", tests, NULL, NULL);
}
