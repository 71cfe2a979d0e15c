/* Threads that share tasks: each task once, one at a time by member, failures told, nothing after the end. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdatomic.h>
#include <sched.h>
#include <stdio.h>
#include <string.h>

#include "base/crew.h"
#include "../support/program.h"

#define TASKS 1000

struct seen {
	atomic_int done[TASKS], at_once[8], most_members, tasks;
	size_t fails; /* number of the task that fails */
	int scratch[8];
};

static enum status note_task(void *user, size_t member, size_t task)
{
	struct seen *seen = user;
	if (atomic_fetch_add(&seen->at_once[member], 1) != 0)
		return fail_with(STATUS_FAILED, "member %zu: two tasks at once; this is a bug", member);
	seen->scratch[member]++; /* a race, if two threads were one member */
	atomic_fetch_add(&seen->done[task], 1);
	atomic_fetch_add(&seen->tasks, 1);
	if (task % 7 == 0)
		sched_yield();
	atomic_fetch_sub(&seen->at_once[member], 1);
	return task == seen->fails ? fail_with(STATUS_INPUT, "task %zu: it fails; try another", task) : STATUS_OK;
}

static void each_task_is_done_once(void **state)
{
	for (size_t members = 1; members <= 7; members += 3) {
		struct crew *crew;
		assert_int_equal(crew_create(members, "crew", NULL, NULL, &crew), STATUS_OK);
		for (size_t count = 0; count <= TASKS; count = count * 3 + 1) {
			static struct seen seen;
			memset(&seen, 0, sizeof seen);
			seen.fails = TASKS;
			assert_int_equal(crew_run(crew, count, note_task, &seen), STATUS_OK);
			for (size_t i = 0; i < TASKS; i++)
				assert_int_equal(seen.done[i], i < count);
			int sum = 0;
			for (size_t i = 0; i < 8; i++)
				sum += seen.scratch[i];
			assert_int_equal(sum, count);
		}
		crew_destroy(crew);
	}
	crew_destroy(NULL);
}

static void a_failure_is_told_and_ends_the_call_not_the_crew(void **state)
{
	struct crew *crew;
	assert_int_equal(crew_create(4, "crew", NULL, NULL, &crew), STATUS_OK);
	for (size_t fails = 0; fails < 600; fails += 150) {
		static struct seen seen;
		memset(&seen, 0, sizeof seen);
		seen.fails = fails;
		assert_int_equal(crew_run(crew, 600, note_task, &seen), STATUS_INPUT);
		char wanted[32];
		snprintf(wanted, sizeof wanted, "task %zu:", fails);
		assert_non_null(strstr(failure_message(), wanted));
		const int done = seen.tasks;
		assert_true(done >= 1 && done <= 600);
		seen.fails = TASKS;
		assert_int_equal(crew_run(crew, 3, note_task, &seen), STATUS_OK);
		assert_int_equal(seen.tasks, done + 3); /* none of those that were left */
	}
	crew_destroy(crew);
	assert_int_equal(thread_running(), 0);
}

static void every_failing_allocation_is_told(void **state)
{
	struct crew *crew = NULL;
	(void)mem_fail_nth(0, 0);
	assert_int_equal(crew_create(3, "crew", NULL, NULL, &crew), STATUS_OK);
	crew_destroy(crew);
	const uint64_t count = mem_fail_nth(0, 0);
	assert_true(count >= 3);
	for (uint64_t nth = 1; nth <= count; nth++) {
		(void)mem_fail_nth(nth, 1);
		assert_int_not_equal(crew_create(3, "crew", NULL, NULL, &crew), STATUS_OK);
		(void)mem_fail_nth(0, 0);
	}
	assert_int_equal(thread_running(), 0);
}

TEST_PROGRAM(crew)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(each_task_is_done_once),
		cmocka_unit_test(a_failure_is_told_and_ends_the_call_not_the_crew),
		cmocka_unit_test(every_failing_allocation_is_told),
	};
	return cmocka_run_group_tests_name("crew", tests, NULL, NULL);
}
