/* What a mark leaves in the file, and what a damaged or killed one does. */
#include <signal.h>
#include <sys/wait.h>
#include <time.h>

#include "marked.h"
#include "../support/program.h"

static void a_store_that_was_never_deformed_is_that_again(void **state)
{
	static struct model model;
	size_t before, after;
	model = model_make(in_folder("never.furrow"), 9);
	uint64_t fresh = content(model.store);
	model_mark(&model);
	model_rollback(&model); /* nothing to do, no revision */
	assert_int_equal(model.revision, 0);
	model_commit(&model);
	model_compact(&model);
	assert_true(content(model.store) != fresh);
	model_rollback(&model);
	assert_int_equal(model.revision, 3);
	assert_true(content(model.store) == fresh);
	model_commit(&model); /* goes on, and back once more */
	assert_as_model(&model);
	model_rollback(&model);
	assert_int_equal(model.revision, 5);
	assert_true(content(model.store) == fresh);
	assert_ok(store_sql_exec(model.store->db, model.path, "testing", "PRAGMA incremental_vacuum"));
	model_free(&model);
	struct store *store = open_store(model.path, STORE_READ);
	assert_false(store_has_working_level(store, NULL));
	assert_true(content(store) == fresh);
	store_close(store);
	make_store(in_folder("other.furrow"));
	free(bytes_of(model.path, &after));
	free(bytes_of(in_folder("other.furrow"), &before));
	assert_int_equal(after, before);
}

/* Each commit keeps the second in which it was made. Here no second passes, so that two stores can be the same to the byte. */
time_t time(time_t *out)
{
	const time_t now = 1000000000;
	if (out != NULL)
		*out = now;
	return now;
}

/* Law 7: marks that nothing is rolled back to leave the very bytes that none would. */
static void marks_leave_nothing_in_the_file(void **state)
{
	char *bytes[2];
	size_t sizes[2];
	for (int way = 0; way < 2; way++) {
		const char *path = in_folder("marked.furrow");
		make_store(path);
		struct store *store = open_store(path, STORE_WRITE);
		struct field field = field_make(LEVEL);
		struct store_commit_result result;
		assert_ok(store_set_working_level(store, LEVEL));
		for (int i = 0; i < 6; i++) {
			if (way == 1 && i % 2 == 1)
				assert_ok(store_mark(store));
			field_dig(&field, 20 * i, 50, 15, (uint32_t)i);
			assert_ok(field_commit(&field, around(20 * i, 50, 15), store, i, &result));
		}
		field_free(&field);
		store_close(store);
		bytes[way] = bytes_of(path, &sizes[way]);
	}
	assert_int_equal(sizes[0], sizes[1]);
	assert_memory_equal(bytes[0], bytes[1], sizes[0]);
	free(bytes[0]);
	free(bytes[1]);
}

/* What is kept is damaged: that is told, and the store is what its last commit left. */
static void a_damaged_undo_is_told_and_changes_nothing(void **state)
{
	static const char *const damages[] = {
		"UPDATE \"offset\" SET blob = zeroblob(length(blob)) WHERE codec >= 0",
		"UPDATE \"offset\" SET high = high + 1 WHERE codec >= 0",
		"UPDATE pressed SET low = 7, high = 'much'",
		"UPDATE heaped SET blob = '' WHERE codec >= 0",
		"UPDATE shear SET key = key + 1000000 WHERE key = (SELECT max(key) FROM shear)",
		"UPDATE dirt SET key = -1 WHERE key = (SELECT max(key) FROM dirt)",
		"DELETE FROM pressed WHERE key = (SELECT max(key) FROM pressed)",
		"DROP TABLE heaped",
		"PRAGMA writable_schema=ON; UPDATE sqlite_schema SET rootpage = 1 WHERE name = 'dirt'; PRAGMA writable_schema=RESET",
	};
	for (size_t i = 0; i < sizeof damages / sizeof *damages; i++) {
		static struct model model;
		struct store_check check;
		model = model_make(in_folder("damaged.furrow"), 31);
		model_commit(&model);
		model_mark(&model);
		for (int n = 0; n < 4; n++)
			model_commit(&model);
		uint64_t last = content(model.store);
		assert_int_equal(sqlite3_exec(model.store->undo->rows.db, damages[i], NULL, NULL, NULL), SQLITE_OK);
		if (store_rollback(model.store) != STATUS_FAILED)
			fail_msg("rolled back in spite of %s", damages[i]);
		assert_non_null(strstr(failure_message(), "; "));
		assert_true(content(model.store) == last);
		assert_ok(store_verify(model.store, print_problem, NULL, NULL, &check));
		assert_int_equal(check.problems, 0);
		model_free(&model);
	}
}

/* --- kills --- */

enum { KILL_EPOCHS = 60 };

/* The epoch number that this commits; epoch 1 was before the mark. Every fifth is a rollback. */
static enum status kill_step(struct store *store, struct field *field, struct field *marked, int64_t number)
{
	struct store_commit_result result;
	if (number % 5 == 0) {
		field_copy(field, marked);
		return store_rollback(store);
	}
	int64_t cx = mix((uint32_t)number, 1, 5) % 150, cy = mix((uint32_t)number, 2, 5) % 100;
	field_dig(field, cx, cy, 20, (uint32_t)number);
	enum status status = field_commit(field, around(cx, cy, 20), store, number, &result);
	if (status == STATUS_OK && number == 1) {
		field_copy(marked, field);
		status = store_mark(store);
	}
	return status;
}

static void kill_run(const char *path, int say, uint64_t *hashes)
{
	struct store *store = open_store(path, STORE_WRITE);
	struct field field = field_make(LEVEL), marked = field_make(LEVEL);
	assert_ok(store_set_working_level(store, LEVEL));
	for (int64_t number = 1; number <= KILL_EPOCHS; number++) {
		assert_ok(kill_step(store, &field, &marked, number));
		assert_int_equal(store->commit, number);
		if (hashes != NULL)
			hashes[number] = content(store);
		if (say >= 0 && write(say, &number, sizeof number) != sizeof number)
			_exit(1);
	}
	if (hashes == NULL)
		pause(); /* to be killed */
	store_close(store);
	field_free(&field);
	field_free(&marked);
}

static void a_kill_leaves_the_last_commit_and_nothing_of_the_mark(void **state)
{
	const char *path = in_folder("killed.furrow");
	uint64_t hashes[KILL_EPOCHS + 1];
	make_store(in_folder("twin.furrow"));
	kill_run(in_folder("twin.furrow"), -1, hashes);
	for (int number = 10; number <= KILL_EPOCHS; number += 5)
		assert_true(hashes[number] == hashes[1]);
	for (int round = 0; round < 20; round++) {
		int ends[2];
		make_store(path);
		assert_int_equal(pipe(ends), 0);
		pid_t child = fork();
		assert_true(child >= 0);
		if (child == 0) {
			kill_run(path, ends[1], NULL);
			_exit(0);
		}
		close(ends[1]);
		int64_t number = 0, last = 0;
		int wanted = 2 + 3 * round;
		while (wanted-- > 0 && read(ends[0], &number, sizeof number) == sizeof number)
			last = number;
		usleep((useconds_t)(mix((uint32_t)round, 3, 3) % 3000));
		kill(child, SIGKILL);
		int ended;
		assert_int_equal(waitpid(child, &ended, 0), child);
		while (read(ends[0], &number, sizeof number) == sizeof number)
			last = number;
		close(ends[0]);
		struct store *store = open_store(path, round % 2 ? STORE_WRITE : STORE_READ);
		assert_true(store->commit == last || store->commit == last + 1);
		assert_true(content(store) == hashes[store->commit]);
		verified(store);
		store_close(store);
	}
	store_close(open_store(path, STORE_WRITE));
	assert_int_equal(files_of("killed.furrow"), 1);
}

TEST_PROGRAM(marks)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_store_that_was_never_deformed_is_that_again),
		cmocka_unit_test(marks_leave_nothing_in_the_file),
		cmocka_unit_test(a_damaged_undo_is_told_and_changes_nothing),
		cmocka_unit_test(a_kill_leaves_the_last_commit_and_nothing_of_the_mark),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
