/* Files of strangers: only regular ones are read, and what is made follows no link. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "base/aside.h"
#include "base/base.h"
#include "../support/program.h"

static char folder[] = "/tmp/furrow-input-XXXXXX";

static int go_in(void **state)
{
	return mkdtemp(folder) == NULL || chdir(folder) != 0;
}

static int go_out(void **state)
{
	return chdir("/") != 0 || rmdir(folder) != 0;
}

static void refused(const char *path, const char *why)
{
	assert_null(input_open(path));
	assert_string_equal(input_problem(), why);
	assert_false(input_is_file(path));
}

static void only_regular_files_are_read(void **state)
{
	struct sockaddr_un address = {.sun_family = AF_UNIX, .sun_path = "socket"};
	const int file = output_create("file", O_WRONLY), listener = socket(AF_UNIX, SOCK_STREAM, 0);
	assert_int_equal(write(file, "text", 4), 4);
	close(file);
	assert_int_equal(bind(listener, (struct sockaddr *)&address, sizeof address), 0);
	assert_int_equal(mkfifo("pipe", 0600), 0); /* nobody writes: to open it as usual would wait for ever */
	assert_int_equal(symlink("pipe", "link"), 0);
	assert_int_equal(symlink("file", "good"), 0);
	refused("pipe", "not a file");
	refused("link", "not a file");
	refused("socket", "not a file");
	refused("/dev/zero", "not a file");
	refused(".", "Is a directory");
	refused("none", "No such file or directory");
	FILE *stream = input_open("good");
	char text[8] = "";
	assert_non_null(stream);
	assert_int_equal(fread(text, 1, sizeof text, stream), 4);
	assert_string_equal(text, "text");
	assert_true(input_is_file("good"));
	fclose(stream);
	close(listener);
	unlink("file"), unlink("socket"), unlink("pipe"), unlink("link"), unlink("good");
}

static void what_is_made_follows_no_link(void **state)
{
	assert_int_equal(symlink("elsewhere", "dangling"), 0);
	assert_int_equal(output_create("dangling", O_WRONLY), -1);
	assert_string_equal(input_problem(), "it is a link");
	assert_false(access("elsewhere", F_OK) == 0);
	const int file = output_create("elsewhere", O_WRONLY);
	assert_int_equal(write(file, "kept", 4), 4);
	close(file);
	assert_int_equal(output_create("dangling", O_WRONLY | O_TRUNC), -1);
	struct stat found;
	assert_int_equal(stat("elsewhere", &found), 0);
	assert_int_equal(found.st_size, 4);
	unlink("dangling");
	assert_int_equal(symlink("/dev/null", "dangling"), 0); /* nothing is made there */
	const int device = output_create("dangling", O_WRONLY | O_TRUNC);
	assert_true(device >= 0);
	close(device);
	unlink("dangling"), unlink("elsewhere");
	static const char *const modes[] = {"w", "w+", "a", "a+"};
	for (int i = 0; i < 4; i++) {
		assert_int_equal(mkfifo("pipe", 0600), 0);
		assert_null(output_open("pipe", modes[i]));
		assert_string_equal(input_problem(), "not a file");
		unlink("pipe");
		FILE *made = output_open("made", modes[i]);
		assert_non_null(made);
		assert_true(fputs("text", made) >= 0);
		assert_int_equal(ftell(made), i < 2 ? 4 : 4 * i);
		fclose(made);
	}
	unlink("made");
}

static void a_file_aside_follows_no_link(void **state)
{
	struct aside aside;
	assert_int_equal(symlink("elsewhere", "out.part"), 0);
	assert_int_equal(aside_begin(&aside, "out"), STATUS_FAILED);
	assert_string_equal(failure_message(), "out: out.part: it is a link; give a file that can be written");
	aside_finish(&aside);
	assert_false(access("elsewhere", F_OK) == 0);
	unlink("out.part");
}

TEST_PROGRAM(input)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(only_regular_files_are_read),
		cmocka_unit_test(what_is_made_follows_no_link),
		cmocka_unit_test(a_file_aside_follows_no_link),
	};
	return cmocka_run_group_tests_name("base/input", tests, go_in, go_out);
}
