/* Relinks: an overlay finds its base again by content, wherever that was moved; anything else is refused, and nothing is written. */
#include "chain.h"
#include "../support/program.h"

static char elsewhere[300]; /* a folder beside `folder` */

static int make_folders(void **state)
{
	if (folder_make(state) != 0)
		return -1;
	snprintf(elsewhere, sizeof elsewhere, "%s-elsewhere", folder);
	return mkdir(elsewhere, 0700);
}

static int remove_folders(void **state)
{
	char list[340];
	snprintf(list, sizeof list, "%s/parent.furrow" PINS_SUFFIX, elsewhere);
	unlink(list); /* what depends on it */
	return rmdir(elsewhere) == 0 ? folder_remove(state) : -1;
}

static const char *moved_to(const char *name)
{
	static char paths[2][400];
	static unsigned next;
	char *path = paths[next++ % 2];
	snprintf(path, sizeof paths[0], "%s/%s", elsewhere, name);
	return path;
}

static uint64_t content_of(const char *path)
{
	struct store *store = open_store(path, STORE_READ);
	uint64_t hash = content(store);
	store_close(store);
	return hash;
}

static void assert_named(const char *path, const char *name)
{
	sqlite3 *db;
	sqlite3_stmt *statement;
	assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
	assert_int_equal(sqlite3_prepare_v2(db, "SELECT value FROM meta WHERE key = 'base_path'", -1, &statement, NULL), SQLITE_OK);
	assert_int_equal(sqlite3_step(statement), SQLITE_ROW);
	assert_string_equal((const char *)sqlite3_column_text(statement, 0), name);
	sqlite3_finalize(statement);
	sqlite3_close(db);
}

/* `ruts`: the base is deformed, so that the overlay goes on from its ruts. */
static void moves_of(int depth, bool ruts)
{
	struct chain chain = chain_make("moved", 31u + (uint32_t)depth);
	struct store *store;
	char name[64];
	if (ruts) {
		chain_grow(&chain, depth, 2);
	} else {
		assert_ok(store_create_overlay(chain.paths[1], chain.paths[0]));
		store = open_store(chain.paths[1], STORE_WRITE);
		dig(store, 5, 2);
		store_close(store);
	}
	const char *over = chain.paths[depth], *parent = chain.paths[depth - 1], *new_parent = moved_to("parent.furrow");
	uint64_t before = content_of(over);
	/* The parent, into another folder: an overlay itself finds its own parent no more. */
	assert_int_equal(rename(parent, new_parent), 0);
	assert_refused(over, "furrow relink");
	if (depth > 1) {
		assert_status(store_relink(over, new_parent), STATUS_INPUT);
		assert_non_null(strstr(failure_message(), "furrow relink"));
		assert_ok(store_relink(new_parent, chain.paths[depth - 2]));
	}
	assert_ok(store_relink(over, new_parent));
	snprintf(name, sizeof name, "../%s-elsewhere/parent.furrow", strrchr(folder, '/') + 1);
	assert_named(over, name);
	assert_true(content_of(over) == before);
	assert_int_equal(files_of(strrchr(over, '/') + 1), 1);
	/* The overlay, to where its parent is, under another name. */
	const char *new_over = moved_to("over.furrow");
	assert_int_equal(rename(over, new_over), 0);
	assert_ok(store_relink(new_over, new_parent));
	assert_named(new_over, "parent.furrow");
	assert_true(content_of(new_over) == before);
	/* Both back, and it can be written. */
	assert_int_equal(rename(new_over, over), 0);
	assert_int_equal(rename(new_parent, parent), 0);
	if (depth > 1)
		assert_ok(store_relink(parent, chain.paths[depth - 2]));
	assert_ok(store_relink(over, parent));
	assert_named(over, strrchr(parent, '/') + 1);
	store = open_store(over, STORE_WRITE);
	assert_true(content(store) == before);
	assert_ok(store_set_working_level(store, -1));
	struct field field = field_make(-1);
	struct store_commit_result result;
	field_dig(&field, 40, 30, 5, 77);
	assert_ok(field_commit(&field, field_all(&field), store, 50, &result));
	verified(store);
	store_close(store);
	field_free(&field);
	chain_free(&chain);
}

static void after_a_move_of_either_the_same_content_is_there(void **state)
{
	moves_of(1, false);
	for (int depth = 1; depth <= 3; depth++)
		moves_of(depth, true);
}

static void a_copy_of_the_base_with_other_bytes_will_do(void **state)
{
	const char *base = in_folder("base.furrow"), *over = in_folder("over.furrow"), *copy = in_folder("copy.furrow");
	make_both(base, over);
	copy_file(base, copy);
	raw_sql(copy, "VACUUM");
	uint64_t before = content_of(over);
	unlink(base);
	assert_ok(store_relink(over, copy));
	assert_true(content_of(over) == before);
}

/* Refused, with a reason and what to do, and not a byte of the overlay is another. */
static void assert_kept(const char *over, const char *parent, const char *why)
{
	size_t sizes[2];
	char *bytes[2] = {bytes_of(over, &sizes[0]), NULL};
	assert_status(store_relink(over, parent), STATUS_INPUT);
	if (strstr(failure_message(), why) == NULL || strstr(failure_message(), "; ") == NULL || strchr(failure_message(), '\n') != NULL)
		fail_msg("does not say '%s': %s", why, failure_message());
	bytes[1] = bytes_of(over, &sizes[1]);
	assert_int_equal(sizes[0], sizes[1]);
	assert_memory_equal(bytes[0], bytes[1], sizes[0]);
	assert_int_equal(files_of(strrchr(over, '/') + 1), 1);
	free(bytes[0]);
	free(bytes[1]);
}

static void what_is_not_the_base_is_refused(void **state)
{
	struct chain chain = chain_make("wrong", 8);
	struct store_meta meta = terrain_meta();
	struct store *store;
	char other[256], kept[256];
	snprintf(other, sizeof other, "%s/other.furrow", folder);
	snprintf(kept, sizeof kept, "%s/kept", folder);
	chain_grow(&chain, 3, 2);
	copy_file(chain.paths[1], kept);
	meta.origin[1]--;
	assert_ok(store_create(other, &meta, STORE_OVERWRITE_FORCE, &store));
	terrain_put(store);
	assert_ok(store_publish(store));
	store_close(store);
	assert_kept(chain.paths[2], other, "another one");
	assert_kept(chain.paths[2], chain.paths[0], "ruts are others");
	assert_kept(chain.paths[2], chain.paths[2], "overlay of itself");
	assert_kept(chain.paths[2], chain.paths[3], "overlay of itself");
	assert_kept(chain.paths[2], in_folder("absent"), "No such file");
	assert_kept(chain.paths[2], folder, "not a file");
	assert_kept(chain.paths[0], chain.paths[1], "store of its own");
	copy_file(kept, in_folder("cut"));
	assert_int_equal(truncate(in_folder("cut"), 40000), 0);
	assert_kept(chain.paths[2], in_folder("cut"), "; ");
	/* The parent, driven on without its list; and back at the revision. */
	char list[340];
	snprintf(list, sizeof list, "%s" PINS_SUFFIX, chain.paths[1]);
	assert_int_equal(unlink(list), 0);
	struct field field = field_make(-1);
	struct store_commit_result result;
	assert_ok(store_open(chain.paths[1], &(struct store_options){.mode = STORE_WRITE, .keep_history = true}, &store));
	int64_t revision = store->commit;
	char text[24];
	snprintf(text, sizeof text, "%lld", (long long)revision);
	field_dig(&field, 50, 50, 4, 3);
	assert_ok(field_commit(&field, around(50, 50, 4), store, 60, &result));
	store_close(store);
	assert_kept(chain.paths[2], chain.paths[1], "ruts are others");
	store = open_store(chain.paths[1], STORE_WRITE);
	assert_ok(store_restore(store, text, &revision));
	store_close(store);
	assert_ok(store_relink(chain.paths[2], chain.paths[1]));
	field_free(&field);
	chain_free(&chain);
}

TEST_PROGRAM(relink)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(after_a_move_of_either_the_same_content_is_there),
		cmocka_unit_test(a_copy_of_the_base_with_other_bytes_will_do),
		cmocka_unit_test(what_is_not_the_base_is_refused),
	};
	return cmocka_run_group_tests(tests, make_folders, remove_folders);
}
