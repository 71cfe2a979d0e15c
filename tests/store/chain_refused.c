/* Chains that cannot be read: a parent that changed, is gone or is another's, loops, and too many files. Each gets one line. */
#include "chain.h"
#include "../support/program.h"

static void assert_says(const char *path, const char *why, const char *what_to_do)
{
	assert_refused(path, why);
	assert_non_null(strstr(failure_message(), what_to_do));
	assert_null(strchr(failure_message(), '\n'));
}

static void a_parent_that_changed_is_refused(void **state)
{
	struct chain chain = chain_make("changed", 1);
	chain_grow(&chain, 3, 2);
	struct store *store;
	for (int i = 0; i < 3; i++) { /* the plain store, the overlays */
		char kept[300];
		snprintf(kept, sizeof kept, "%s.kept", chain.paths[i]);
		char list[300];
		snprintf(list, sizeof list, "%s" PINS_SUFFIX, chain.paths[i]);
		copy_file(chain.paths[i], kept);
		assert_int_equal(unlink(list), 0); /* or it would keep what the next one depends on */
		/* chain_grow's overlays stop others from being opened once one has changed. */
		store = open_store(chain.paths[i], STORE_WRITE);
		dig(store, 3, 0);
		struct field field = field_make(-1);
		struct store_commit_result result;
		field_dig(&field, 60, 60, 4, 9);
		assert_ok(field_commit(&field, around(60, 60, 4), store, 99, &result));
		store_close(store);
		assert_says(chain.paths[i + 1], "changed since", "branch");
		assert_non_null(strstr(failure_message(), chain.paths[i]));
		assert_refused(chain.paths[3], chain.paths[i]);
		assert_int_equal(rename(kept, chain.paths[i]), 0);
		field_free(&field);
	}
	store = open_store(chain.paths[3], STORE_READ);
	verified(store);
	store_close(store);
	chain_free(&chain);
}

static void a_parent_with_other_bytes_and_the_same_rows_is_the_same(void **state)
{
	struct chain chain = chain_make("bytes", 2);
	chain_grow(&chain, 2, 2);
	raw_sql(chain.paths[0], "VACUUM");
	raw_sql(chain.paths[1], "VACUUM");
	struct store *store = open_store(chain.paths[2], STORE_WRITE);
	verified(store);
	store_close(store);
	chain_free(&chain);
}

static void each_link_that_lies_is_refused(void **state)
{
	struct chain chain = chain_make("links", 3);
	static const struct {
		const char *sql, *why, *what;
	} edits[] = {
		{"UPDATE meta SET value = value + 1 WHERE key = 'parent_hash'", "changed since", "; "},
		{"UPDATE meta SET value = 'x' WHERE key = 'parent_hash'", "'parent_hash'", "; "},
		{"UPDATE meta SET value = -1 WHERE key = 'parent_revision'", "'parent_revision'", "; "},
		{"DELETE FROM meta WHERE key = 'parent_revision'", "'parent_revision'", "; "},
		{"DELETE FROM meta WHERE key = 'parent_hash'", "overlay itself", "; "},
		{"DELETE FROM meta WHERE key = 'base_path'", "'parent_hash'", "; "},
		{"UPDATE meta SET value = 'gone' WHERE key = 'base_path'", "No such file", "furrow relink"},
		{"UPDATE meta SET value = 'links2.furrow' WHERE key = 'base_path'", "overlay of itself", "; "},
		{"UPDATE meta SET value = 'links3.furrow' WHERE key = 'base_path'", "overlay of itself", "; "},
		{"UPDATE meta SET value = 'other.furrow' WHERE key = 'base_path'", "another one now", "; "},
	};
	struct store_meta meta = terrain_meta();
	struct store *store;
	const char *kept = in_folder("kept");
	chain_grow(&chain, 3, 1);
	meta.origin[0]++;
	assert_ok(store_create(in_folder("other.furrow"), &meta, STORE_OVERWRITE_FORCE, &store));
	terrain_put(store);
	assert_ok(store_publish(store));
	store_close(store);
	copy_file(chain.paths[2], kept);
	for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
		copy_file(kept, chain.paths[2]);
		raw_sql(chain.paths[2], edits[i].sql);
		assert_says(chain.paths[2], edits[i].why, edits[i].what);
		assert_refused(chain.paths[3], "; ");
		/* Nothing was left beside it by trying. */
		assert_int_equal(files_of("links2.furrow"), 1);
	}
	chain_free(&chain);
}

static void sixteen_overlays_are_the_most(void **state)
{
	char paths[19][300];
	for (int i = 0; i < 19; i++)
		snprintf(paths[i], sizeof paths[i], "%s/deep%d.furrow", folder, i);
	make_store(paths[0]);
	struct store *store = open_store(paths[0], STORE_WRITE);
	dig(store, 1, 1);
	store_close(store);
	for (int i = 1; i <= STORE_DEPTH_MOST; i++)
		assert_ok(store_create_overlay(paths[i], paths[i - 1]));
	assert_status(store_create_overlay(paths[17], paths[16]), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "further down"));
	assert_int_equal(files_of("deep17"), 0);
	store = open_store(paths[16], STORE_WRITE);
	struct field field = field_make(-1);
	struct store_commit_result result;
	field_dig(&field, 90, 60, 20, 9);
	assert_ok(field_commit(&field, around(90, 60, 20), store, 2, &result));
	verified(store);
	store_close(store);
	/* One whose header says that it is over the sixteenth. */
	copy_file(paths[16], paths[17]);
	raw_sql(paths[17], "UPDATE meta SET value = 'deep16.furrow' WHERE key = 'base_path'");
	assert_says(paths[17], "16 overlays", "further down");
	field_free(&field);
}

static void what_a_file_of_the_chain_lies_about_is_found(void **state)
{
	struct chain chain = chain_make("lies", 4);
	chain_grow(&chain, 2, 3);
	static const char *const edits[] = {
		/* a row of zeros where nothing is inherited; one whose posts are not zero; one that repeats its parent's */
		"UPDATE \"offset\" SET low = 0, high = 0 WHERE key = (SELECT min(key) FROM \"offset\")",
		"UPDATE dirt SET low = 0, high = 0 WHERE key = (SELECT max(key) FROM dirt)",
		"INSERT INTO base(key, error, codec, revision, hash, blob) VALUES(2305843009213693952, 0, 0, 0, 0, x'00000000')",
		"UPDATE \"offset\" SET blob = zeroblob(length(blob)) WHERE key = (SELECT min(key) FROM \"offset\")",
	};
	const char *kept = in_folder("kept");
	copy_file(chain.paths[2], kept);
	for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
		struct store_check check;
		copy_file(kept, chain.paths[2]);
		raw_sql(chain.paths[2], edits[i]);
		struct store *store = open_store(chain.paths[2], STORE_READ);
		assert_ok(store_verify(store, NULL, NULL, NULL, &check));
		assert_true(check.problems > 0);
		store_close(store);
	}
	/* The child's own row becomes its parent's. */
	char sql[600];
	struct store_check check;
	copy_file(kept, chain.paths[2]);
	snprintf(sql, sizeof sql, "ATTACH '%s' AS p; INSERT OR REPLACE INTO heaped SELECT * FROM p.heaped", chain.paths[1]);
	raw_sql(chain.paths[2], sql);
	struct store *store = open_store(chain.paths[2], STORE_READ);
	assert_ok(store_verify(store, NULL, NULL, NULL, &check));
	assert_true(check.problems > 0);
	store_close(store);
	chain_free(&chain);
}

TEST_PROGRAM(chain_refused)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_parent_that_changed_is_refused),
		cmocka_unit_test(a_parent_with_other_bytes_and_the_same_rows_is_the_same),
		cmocka_unit_test(each_link_that_lies_is_refused),
		cmocka_unit_test(sixteen_overlays_are_the_most),
		cmocka_unit_test(what_a_file_of_the_chain_lies_about_is_found),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
