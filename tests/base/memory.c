/* Lists that grow, and memory that is lacking. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "base/memory.h"
#include "../support/program.h"

static void a_list_grows_and_keeps_its_items(void **state)
{
	int32_t *list = NULL;
	size_t room = 0, grown = 0;
	for (size_t count = 0; count < 5000; count++) {
		const size_t had = room;
		assert_int_equal(mem_grow(&list, &room, count + 1, sizeof *list, "a list"), STATUS_OK);
		assert_true(room > count && room >= 64);
		assert_true(room == had || room >= 2 * had);
		grown += room != had;
		list[count] = (int32_t)count;
	}
	for (size_t i = 0; i < 5000; i++)
		assert_int_equal(list[i], i);
	assert_int_equal(grown, 8); /* 64, 128, ... 8192 */
	assert_int_equal(mem_grow(&list, &room, 100000, sizeof *list, "a list"), STATUS_OK);
	assert_int_equal(room, 100000);
	mem_free(list);
}

static void a_list_with_room_is_left_alone(void **state)
{
	char one[1], *list = one; /* no memory of the allocator's */
	size_t room = 7;
	mem_fail_nth(1, true);
	const enum status few = mem_grow(&list, &room, 7, 1, "a list"), none = mem_grow(&list, &room, 0, 1, "a list");
	const uint64_t made = mem_fail_nth(0, false);
	assert_int_equal(few, STATUS_OK);
	assert_int_equal(none, STATUS_OK);
	assert_true(list == one && room == 7 && made == 0);
}

static void a_list_stays_whole_where_memory_is_lacking(void **state)
{
	char *list = NULL;
	size_t room = 0;
	assert_int_equal(mem_grow(&list, &room, 64, 1, "a list"), STATUS_OK);
	memset(list, 'x', 64);
	char *const had = list;
	mem_fail_nth(1, true);
	const enum status grown = mem_grow(&list, &room, 65, 1, "the list of a test"), resized = mem_resize(&list, 65, 1, "a list");
	mem_fail_nth(0, false);
	assert_int_equal(grown, STATUS_FAILED);
	assert_int_equal(resized, STATUS_FAILED);
	assert_true(list == had && room == 64);
	for (int i = 0; i < 64; i++)
		assert_int_equal(list[i], 'x');
	mem_free(list);
}

static void a_failure_names_what_memory_was_for(void **state)
{
	char *list = NULL;
	size_t room = 0;
	mem_fail_nth(1, true);
	const enum status status = mem_grow(&list, &room, 1, 1, "the list of a test");
	mem_fail_nth(0, false);
	assert_int_equal(status, STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "the list of a test"));
}

static void sizes_that_size_t_cannot_count_fail(void **state)
{
	uint64_t *list = NULL;
	size_t room = 0;
	assert_int_equal(mem_grow(&list, &room, 1, sizeof *list, "a list"), STATUS_OK);
	uint64_t *const had = list;
	list[0] = 5;
	assert_int_equal(mem_grow(&list, &room, SIZE_MAX / sizeof *list + 1, sizeof *list, "a list"), STATUS_FAILED);
	assert_int_equal(mem_grow(&list, &room, SIZE_MAX, sizeof *list, "a list"), STATUS_FAILED);
	assert_int_equal(mem_resize(&list, SIZE_MAX / 2, sizeof *list, "a list"), STATUS_FAILED);
	assert_true(list == had && room == 64 && list[0] == 5);
	assert_true(mem_room(SIZE_MAX / 2 + 1, 0) == SIZE_MAX);
	assert_true(mem_room(SIZE_MAX, SIZE_MAX) == SIZE_MAX);
	mem_free(list);
}

static void new_memory_is_null_where_it_is_lacking(void **state)
{
	char some, *made = &some, *zeroed = &some;
	assert_int_equal(mem_zeroed(&zeroed, 3, 1, "a list"), STATUS_OK);
	assert_memory_equal(zeroed, "\0\0\0", 3);
	mem_free(zeroed);
	mem_fail_nth(1, true);
	const enum status of_made = mem_make(&made, 3, 1, "a list"), of_zeroed = mem_zeroed(&zeroed, 3, 1, "a list");
	mem_fail_nth(0, false);
	assert_int_equal(of_made, STATUS_FAILED);
	assert_int_equal(of_zeroed, STATUS_FAILED);
	assert_null(made);
	assert_null(zeroed);
	made = &some;
	mem_fail_nth(1, true);
	const enum status copied = mem_text(&made, "a text", "a list");
	mem_fail_nth(0, false);
	assert_int_equal(copied, STATUS_FAILED);
	assert_null(made);
	assert_int_equal(mem_make(&made, SIZE_MAX, 2, "a list"), STATUS_FAILED);
}

static void what_holds_others_is_freed_with_them(void **state)
{
	struct holder {
		char *one, *other;
	} *holder = NULL;
	assert_int_equal(mem_zeroed(&holder, 1, sizeof *holder, "a list"), STATUS_OK);
	holder->one = mem_strdup("one");
	assert_non_null(holder->one);
	char **list = NULL;
	assert_int_equal(mem_zeroed(&list, 3, sizeof *list, "a list"), STATUS_OK);
	for (int i = 0; i < 2; i++)
		assert_int_equal(mem_text(&list[i], "a text", "a list"), STATUS_OK);
	assert_string_equal(list[1], "a text");
	assert_true(list[0] != list[1]);
	mem_free_list(list, 3);
	mem_free_list(NULL, 3);
	mem_free_all(holder->one, holder->other, holder); /* the address sanitizer tells what is left, and what is read too late */
}

TEST_PROGRAM(memory)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_list_grows_and_keeps_its_items),
		cmocka_unit_test(a_list_with_room_is_left_alone),
		cmocka_unit_test(a_list_stays_whole_where_memory_is_lacking),
		cmocka_unit_test(a_failure_names_what_memory_was_for),
		cmocka_unit_test(sizes_that_size_t_cannot_count_fail),
		cmocka_unit_test(new_memory_is_null_where_it_is_lacking),
		cmocka_unit_test(what_holds_others_is_freed_with_them),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
