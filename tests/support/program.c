/* Runs one file of a folder's tests:
 *
 *   test_FOLDER                 the names of its files
 *   test_FOLDER NAME            the tests of NAME.c; the exit status is the number that failed
 *   test_FOLDER NAME FILTER     those whose names match FILTER, in which * and ? are wildcards (cmocka's own filter)
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#include "program.h"

#define TEST(name) int test_##name(void);
#include TEST_LIST
#undef TEST

static const struct {
	const char *name;
	int (*run)(void);
} files[] = {
#define TEST(name) {#name, test_##name},
#include TEST_LIST
#undef TEST
};

char **program_words;

int main(int argc, char **argv)
{
	const size_t count = sizeof files / sizeof files[0];
	if (argc == 1) {
		for (size_t i = 0; i < count; i++)
			puts(files[i].name);
		return 0;
	}
	for (size_t i = 0; i < count; i++) {
		if (strcmp(argv[1], files[i].name) != 0)
			continue;
		program_words = argv + 2;
		if (argc == 3)
			cmocka_set_test_filter(argv[2]);
		const int failed = files[i].run();
		return failed < 255 ? failed : 255;
	}
	fprintf(stderr, "%s: no file '%s' among this folder's tests; without an argument it lists their names\n", argv[0], argv[1]);
	return 2;
}
