/* Files that are moved, replaced or deleted while a store is open. */
#include "fixture.h"
#include "../support/program.h"

/* What a commit says after `change` was done to the store's file or its WAL. All up to the commit before is kept. */
static void a_file_that_is_taken_away_while_it_is_written_is_told(void **state)
{
	static const char *const told[] = {"moved, replaced or deleted", "moved, replaced or deleted", "moved, replaced or deleted", "-wal: "};
	for (int way = 0; way < 4; way++) {
		const char *path = in_folder("taken.furrow"), *elsewhere = in_folder("elsewhere.furrow");
		struct store_commit_result result;
		struct store_numbers numbers;
		make_store(path);
		make_store(elsewhere);
		struct store *store = open_store(path, STORE_WRITE);
		assert_ok(store_set_working_level(store, 0));
		struct field field = field_make(0);
		field_dig(&field, 20, 20, 6, 1);
		assert_ok(field_commit(&field, around(20, 20, 6), store, 5, &result));
		uint64_t first = content(store);
		if (way == 0)
			assert_int_equal(unlink(path), 0);
		else if (way == 1) /* another store in its place */
			assert_int_equal(rename(elsewhere, path), 0);
		else if (way == 2)
			assert_int_equal(rename(path, elsewhere), 0);
		else
			assert_int_equal(unlink(in_folder("taken.furrow-wal")), 0);
		field_dig(&field, 50, 30, 6, 2);
		assert_status(field_commit(&field, around(50, 30, 6), store, 6, &result), STATUS_FAILED);
		assert_non_null(strstr(failure_message(), told[way]));
		store_close(store);
		field_free(&field);
		if (way < 2)
			continue;
		store = open_store(way == 2 ? elsewhere : path, STORE_READ);
		assert_ok(store_count(store, &numbers));
		assert_int_equal(numbers.last_run.step, 5);
		assert_true(content(store) == first);
		store_close(store);
	}
}

static char noted[1024];

/* A store that was opened and not yet changed is not mistaken for the one that lies in its place now. */
static void a_file_that_is_replaced_before_its_first_commit_is_told(void **state)
{
	const char *path = in_folder("late.furrow"), *elsewhere = in_folder("elsewhere.furrow");
	struct store_commit_result result;
	struct store *store;
	make_store(path);
	make_store(elsewhere);
	store = open_store(path, STORE_WRITE);
	assert_ok(store_set_working_level(store, 0));
	store_close(store);
	store = open_store(elsewhere, STORE_READ);
	const uint64_t other = content(store);
	store_close(store);
	assert_ok(store_open(path, &(struct store_options){.mode = STORE_WRITE, .late = true}, &store));
	if (!store_has_working_level(store, &(int){0}))
		assert_ok(store_set_working_level(store, 0));
	struct field field = field_make(0);
	field_dig(&field, 20, 20, 6, 1);
	assert_int_equal(rename(elsewhere, path), 0);
	assert_int_equal(field_commit(&field, around(20, 20, 6), store, 5, &result), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "moved, replaced or deleted"));
	store_close(store);
	field_free(&field);
	store = open_store(path, STORE_READ);
	assert_true(content(store) == other);
	store_close(store);
	unlink(path);
}

static void take_note(const char *text)
{
	snprintf(noted, sizeof noted, "%s", text);
}

static void a_base_that_is_deleted_while_it_is_in_use_is_told_and_loses_nothing(void **state)
{
	const char *path = in_folder("under.furrow"), *kept = in_folder("kept.furrow"), *over = in_folder("over.furrow");
	struct store_commit_result result;
	make_store(path);
	assert_int_equal(link(path, kept), 0);
	assert_ok(store_create_overlay(over, path));
	struct store *store = open_store(over, STORE_WRITE);
	assert_ok(store_set_working_level(store, 0));
	struct field field = field_make(0);
	field_dig(&field, 20, 20, 6, 1);
	assert_int_equal(unlink(path), 0);
	note_to(take_note);
	for (int step = 1; step <= 2; step++) {
		noted[0] = '\0';
		assert_ok(field_commit(&field, around(20, 20, 6), store, step, &result));
		assert_int_equal(strstr(noted, "under.furrow was moved or deleted while it was in use; put it back") != NULL, step == 1);
	}
	note_to(NULL);
	uint64_t hash = content(store);
	store_close(store);
	field_free(&field);
	assert_int_equal(rename(kept, path), 0);
	store = open_store(over, STORE_READ);
	assert_true(content(store) == hash);
	store_close(store);
}

TEST_PROGRAM(taken)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_file_that_is_taken_away_while_it_is_written_is_told),
		cmocka_unit_test(a_file_that_is_replaced_before_its_first_commit_is_told),
		cmocka_unit_test(a_base_that_is_deleted_while_it_is_in_use_is_told_and_loses_nothing),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
