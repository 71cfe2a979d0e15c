/*
 * keep_last: whatever is committed, the one revision before the present one can be restored, older ones cannot, and the file stays
 * bounded. In a plain store, in an overlay over ruts, and with marks between.
 */
#include "marked.h"
#include "../support/program.h"

static struct store *open_last(const char *path)
{
	struct store *store;
	assert_ok(store_open(path, &(struct store_options){.mode = STORE_WRITE, .keep_last = true, .scene = "last.yaml"}, &store));
	return store;
}

/* What is kept, restored in a copy of the file. */
static void assert_kept(const char *path, int64_t commit, uint64_t before)
{
	char text[24];
	int64_t revision;
	copy_file(path, in_folder("back.furrow"));
	struct store *store = open_last(in_folder("back.furrow"));
	verified(store);
	snprintf(text, sizeof text, "%d", (int)commit - 2);
	if (commit > 1)
		assert_status(store_restore(store, text, &revision), STATUS_INPUT);
	snprintf(text, sizeof text, "%d", (int)commit - 1);
	assert_ok(store_restore(store, text, &revision));
	assert_true(content(store) == before);
	verified(store);
	/* That kept what it replaced, and the next commit drops what is older. */
	snprintf(text, sizeof text, "%d", (int)commit);
	assert_ok(store_restore(store, text, &revision));
	const struct store_run run = {.scene_hash = "abc", .state = "{}"};
	struct store_commit_result result;
	struct store_numbers numbers;
	assert_ok(store_set_working_level(store, LEVEL));
	assert_ok(store_commit(store, NULL, 0, &run, &result));
	assert_ok(store_count(store, &numbers));
	assert_int_equal(numbers.revisions, 1);
	assert_int_equal(numbers.history_rows, 0);
	verified(store);
	store_close(store);
}

static void keeps_the_last(const char *name, uint32_t seed)
{
	char path[256];
	snprintf(path, sizeof path, "%s", in_folder(name));
	struct field field = field_make(LEVEL);
	struct store *store = open_last(path);
	int64_t commit = store->commit;
	for (int i = 0; i < 8; i++) {
		struct store_commit_result result;
		struct store_numbers numbers;
		uint64_t before = content(store);
		int64_t cx = mix(seed, (uint32_t)i, 1) % 150, cy = mix(seed, (uint32_t)i, 2) % 100;
		struct post_rect rect = around(cx, cy, 20);
		assert_ok(store_set_working_level(store, LEVEL));
		if (i == 4) {
			field_clear(&field);
			rect = field_all(&field);
		} else {
			field_dig(&field, cx, cy, 1 + (int64_t)(mix(seed, (uint32_t)i, 3) % 20), seed + (uint32_t)i);
		}
		/* A commit without the other planes drops the soil's state. The next has all of it again. */
		field.carried = i == 5 ? PLANE_BIT(PLANE_OFFSET) : (1u << PLANES) - 1;
		rect = i == 0 || i >= 6 ? field_all(&field) : rect; /* where the field is not what the store has */
		assert_ok(field_commit(&field, rect, store, i, &result));
		commit++;
		if (i == 6) { /* a rollback is a revision, too */
			assert_ok(store_mark(store));
			assert_ok(field_commit(&field, field_all(&field), store, i, &result));
			field_dig(&field, 40, 40, 9, seed);
			assert_ok(field_commit(&field, field_all(&field), store, i, &result));
			before = content(store);
			assert_ok(store_rollback(store));
			commit += 3;
		}
		assert_int_equal(store->commit, commit);
		assert_ok(store_count(store, &numbers));
		assert_int_equal(numbers.revisions, 1);
		verified(store);
		store_close(store);
		assert_kept(path, commit, before);
		store = open_last(path);
	}
	store_close(store);
	field_free(&field);
}

static void the_last_revision_is_kept(void **state)
{
	make_both(in_folder("base.furrow"), in_folder("over.furrow"));
	keeps_the_last("over.furrow", 1);
	assert_ok(store_create_overlay(in_folder("branch.furrow"), in_folder("over.furrow")));
	keeps_the_last("branch.furrow", 2);
	keeps_the_last("base.furrow", 3);
}

/* The same ground again and again takes no more room. */
static void the_file_stays_bounded(void **state)
{
	const char *path = in_folder("bounded.furrow");
	struct field field = field_make(LEVEL);
	struct store_commit_result result;
	struct stat early, late;
	make_store(path);
	struct store *store = open_last(path);
	assert_ok(store_set_working_level(store, LEVEL));
	for (uint32_t i = 0; i < 40; i++) {
		field_dig(&field, 75, 50, 40, i);
		assert_ok(field_commit(&field, field_all(&field), store, i, &result));
		assert_ok(store_checkpoint(store));
		if (i == 4)
			assert_int_equal(stat(path, &early), 0);
	}
	assert_int_equal(stat(path, &late), 0);
	assert_true(late.st_size < early.st_size + early.st_size / 8);
	store_close(store);
	field_free(&field);
}

static void named_revisions_are_not_dropped(void **state)
{
	const char *path = in_folder("named.furrow");
	struct store *store;
	make_store(path);
	store = open_store(path, STORE_WRITE);
	dig(store, 5, 1);
	assert_ok(store_snapshot(store, "dug"));
	store_close(store);
	assert_status(store_open(path, &(struct store_options){.mode = STORE_WRITE, .keep_last = true}, &store), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "have names"));
	assert_status(store_open(path, &(struct store_options){.mode = STORE_WRITE, .keep_last = true, .keep_history = true}, &store), STATUS_USAGE);
	/* Others are, and the ground stays. */
	raw_sql(path, "DELETE FROM snapshot");
	store = open_store(path, STORE_READ);
	uint64_t hash = content(store);
	store_close(store);
	store = open_last(path);
	const struct store_run run = {.scene_hash = "abc", .state = "{}"};
	struct store_commit_result result;
	assert_ok(store_set_working_level(store, LEVEL));
	assert_ok(store_commit(store, NULL, 0, &run, &result));
	assert_ok(store_commit(store, NULL, 0, &run, &result));
	assert_true(content(store) == hash);
	verified(store);
	store_close(store);
}

TEST_PROGRAM(keep_last)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_last_revision_is_kept),
		cmocka_unit_test(the_file_stays_bounded),
		cmocka_unit_test(named_revisions_are_not_dropped),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
