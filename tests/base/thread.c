/* A thread has the locale "C", whatever the locale of the process and of the thread that starts it. */
#include "../comma.h"
#include "../support.h"
#include "../support/program.h"
#include "../support/skip.h"

#include "base/thread.h"

struct seen {
	double number;
	char text[16];
};

static void *look(void *user)
{
	struct seen *seen = user;
	seen->number = strtod("0.5", NULL);
	snprintf(seen->text, sizeof seen->text, "%g", 0.5);
	return NULL;
}

static void numbers_of_a_thread_have_a_point(void **state)
{
	if (!comma_begin(support_folder))
		skip_since("no locale with a decimal comma");
	struct thread thread = {.started = false};
	struct seen seen, here;
	must(thread_start(&thread, look, &seen, "furrow-test"));
	thread_join(&thread);
	look(&here);
	comma_end(state);
	assert_string_equal(here.text, "0,5");
	assert_string_equal(seen.text, "0.5");
	assert_true(seen.number == 0.5);
}

TEST_PROGRAM(thread)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(numbers_of_a_thread_have_a_point)};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
