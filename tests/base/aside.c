/* Files that are written aside: what is told where one cannot be made, before long work and at its end. */
#include "../support.h"
#include "../support/program.h"

#include <errno.h>
#include <sys/stat.h>

#include "base/aside.h"
#include "base/limits.h"

static void a_full_disk_is_told_as_one(void **state)
{
	assert_string_equal(limits_advice(ENOSPC, "give another"), "free some disk space");
	assert_string_equal(limits_advice(EDQUOT, "give another"), "free some space: the disk's quota is used up");
	assert_string_equal(limits_advice(EACCES, "give another"), "give another");
}

static void what_cannot_be_written_is_told_before_the_work(void **state)
{
	char path[4200];
	assert_int_equal(mkdir(support_path("pages"), 0777), 0);
	snprintf(path, sizeof path, "%s/map.pdf", support_path("pages"));
	assert_int_equal(aside_check(path), STATUS_OK);
	assert_int_equal(aside_check("map.pdf"), STATUS_OK);
	assert_int_equal(aside_check(support_path("pages")), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "Is a directory; give a file that can be written"));
	snprintf(path, sizeof path, "%s/pages/none/map.pdf", support_path("."));
	assert_int_equal(aside_check(path), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "/pages/none is not there; make it, or give a file in another"));
	struct aside aside;
	assert_int_equal(aside_begin(&aside, path), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "/pages/none is not there; make it, or give a file in another"));
	aside_finish(&aside);
	support_write(support_path("pages/map.pdf"), "as it was");
	assert_int_equal(aside_check(support_path("pages/map.pdf")), STATUS_OK);
}

static void a_device_or_a_pipe_is_not_replaced(void **state)
{
	struct aside aside;
	struct stat found;
	const char *pipe = support_path("pipe");
	assert_int_equal(mkfifo(pipe, 0666), 0);
	for (int i = 0; i < 2; i++) {
		const char *path = i == 0 ? pipe : "/dev/null";
		assert_int_equal(aside_check(path), STATUS_INPUT);
		assert_non_null(strstr(failure_message(), "is a device or a pipe, and would be replaced; give a file"));
		assert_int_equal(aside_begin(&aside, path), STATUS_FAILED);
		assert_non_null(strstr(failure_message(), "is a device or a pipe, and would be replaced; give a file"));
		aside_finish(&aside);
	}
	assert_true(stat(pipe, &found) == 0 && S_ISFIFO(found.st_mode));
}

TEST_PROGRAM(aside)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_full_disk_is_told_as_one),
		cmocka_unit_test(what_cannot_be_written_is_told_before_the_work),
		cmocka_unit_test(a_device_or_a_pipe_is_not_replaced),
	};
	return cmocka_run_group_tests_name("aside", tests, support_enter, support_leave);
}
