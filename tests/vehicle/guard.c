/* MuJoCo's errors and warnings neither end the process nor write a file, and its handlers are given back. */
#include "vehicle_mujoco.h"
#include <unistd.h>

#include "../support.h"
#include "../support/program.h"
#include "vehicle/guard.h"

static void fails(void *argument)
{
	(void)argument;
	mju_error("too many wheels");
}

static void warns(void *argument)
{
	(void)argument;
	mju_warning("first");
	mju_warning("second");
}

static void counts(void *argument)
{
	++*(int *)argument;
}

static void an_error_is_a_status(void **state)
{
	(void)state;
	assert_int_equal(vehicle_guard("car", fails, NULL), STATUS_FAILED);
	assert_string_equal(failure_message(), "car: MuJoCo " VEHICLE_MUJOCO_VERSION " says: too many wheels; change the model");
	assert_null(mju_user_error);
	assert_null(mju_user_warning);
}

static void a_warning_is_kept(void **state)
{
	int calls = 0;
	(void)state;
	assert_int_equal(chdir(support_path("")), 0);
	must(vehicle_guard("car", warns, NULL));
	assert_string_equal(vehicle_guard_warning(), "first");
	assert_int_equal(access("MUJOCO_LOG.TXT", F_OK), -1);
	must(vehicle_guard("car", counts, &calls));
	assert_int_equal(calls, 1);
	assert_string_equal(vehicle_guard_warning(), "");
}

static int others;

static void of_another(const char *text)
{
	(void)text;
	others++;
}

static void the_handlers_of_others_stay(void **state)
{
	(void)state;
	mju_user_warning = of_another;
	must(vehicle_guard("car", warns, NULL));
	assert_int_equal(others, 0);
	assert_true(mju_user_warning == of_another);
	mju_warning("theirs");
	assert_int_equal(others, 1);
	mju_user_warning = NULL;
}

TEST_PROGRAM(guard)
{
	must(vehicle_mujoco_load());
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(an_error_is_a_status),
		cmocka_unit_test(a_warning_is_kept),
		cmocka_unit_test(the_handlers_of_others_stay),
	};
	return cmocka_run_group_tests_name("calls of MuJoCo", tests, support_enter, support_leave);
}
