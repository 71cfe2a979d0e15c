/*
 * Law 6 for an import: whatever fails, PATH has what it had before, or the whole store.
 *
 * Exhaustive over every kind of call but SQLite's allocations, of which some hundred are tried
 * (MOST): there are thousands, nearly all in the same few functions.
 */
#include "sweep.h"

#include <sys/wait.h>

#include "dem/dem.h"

#define MOST 150

/* What is at PATH when the import begins. */
enum before { NOTHING, STORE, KILLED, BEFORES };

static uint64_t hash_before[BEFORES], hash_after;

static enum status rows_of(void *user, int64_t y0, int64_t rows, double *heights)
{
	for (int64_t y = y0; y < y0 + rows; y++)
		for (int64_t x = 0; x < world.width; x++) {
			int32_t code = terrain(x, y);
			*heights++ = code == HEIGHT_CODE_NODATA ? (double)NAN : code * STEP;
		}
	return STATUS_OK;
}

static enum status put_tile(void *user, const struct dem_tile *tile)
{
	struct store_range range = {tile->low, tile->high, tile->error};
	return store_put_base(user, tile->tile, tile->codes, &range);
}

/* As tools/intake.c does. */
static enum status import(const char *path)
{
	struct store *store;
	struct store_meta meta = terrain_meta();
	enum status status = store_create(path, &meta, true, &store);
	if (status != STATUS_OK)
		return status;
	status = dem_cut(&world, meta.step, rows_of, NULL, put_tile, store, NULL, NULL);
	if (status == STATUS_OK)
		status = store_publish(store);
	store_close(store);
	return status;
}

static const char *beside(const char *path, const char *suffix)
{
	static char with[512];
	snprintf(with, sizeof with, "%s%s", path, suffix);
	return with;
}

/* The older store, and the one that a killed writer left: with a WAL that holds its epochs. */
static void make_before(void)
{
	for (int before = STORE; before < BEFORES; before++) {
		const char *path = in_folder(before == STORE ? "store" : "killed");
		make_store(path);
		pid_t child = fork();
		if (child == 0) {
			struct store *store = open_store(path, STORE_WRITE);
			struct field field = field_make(0);
			struct store_epoch_result result;
			assert_ok(store_set_working_level(store, 0));
			field_dig(&field, 30, 20, 12, 5);
			assert_ok(field_commit(&field, field_all(&field), store, 1, &result));
			/* A part of it is in the file: without the rest of the WAL that is no store. */
			assert_ok(store_checkpoint(store));
			field_dig(&field, 50, 30, 12, 6);
			assert_ok(field_commit(&field, field_all(&field), store, 2, &result));
			if (before == STORE)
				store_close(store);
			_exit(0);
		}
		int ended;
		assert_int_equal(waitpid(child, &ended, 0), child);
		assert_int_equal(WEXITSTATUS(ended), 0);
		unlink(beside(path, "-shm"));
		unlink(beside(path, "-lock"));
		/* Of a copy: looking at it would tidy it. */
		copy_file(path, in_folder("looked"));
		if (before == KILLED)
			copy_file(beside(path, "-wal"), in_folder("looked-wal"));
		struct store *store = open_store(in_folder("looked"), STORE_READ);
		hash_before[before] = content(store);
		store_close(store);
	}
	assert_true(hash_before[STORE] == hash_before[KILLED]);
}

static void put_before(const char *path, enum before before)
{
	unlink(path);
	unlink(beside(path, "-wal"));
	if (before != NOTHING)
		copy_file(in_folder(before == STORE ? "store" : "killed"), path);
	if (before == KILLED)
		copy_file(in_folder("killed-wal"), beside(path, "-wal"));
}

static void expect_store(const char *path, uint64_t hash)
{
	struct store *store;
	struct store_check check;
	uint64_t found;
	expect(store_open(path, &(struct store_options){.mode = STORE_READ}, &store) == STATUS_OK);
	expect(store_verify(store, print_problem, NULL, NULL, &check) == STATUS_OK);
	expect(check.problems == 0);
	expect(store_content_hash(store, &found) == STATUS_OK);
	expect(found == hash);
	store_close(store);
}

/* An import that failed or was done leaves nothing aside, unless the disk refuses to remove it. */
static void expect_nothing_aside(const char *path, const struct fault *fault)
{
	if (fault->kind == FAULT_CALL_UNLINK)
		unlink(beside(path, ".part"));
	expect(access(beside(path, ".part"), F_OK) != 0);
	if (fault->kind == FAULT_CALL_UNLINK)
		unlink(beside(path, "-lock"));
	expect(access(beside(path, "-lock"), F_OK) != 0);
}

static uint64_t trial(const void *user, const struct fault *fault)
{
	enum before before = *(const enum before *)user;
	const char *path = in_folder("trial.furrow");
	put_before(path, before);
	fault_arm_for(fault);
	enum status status = import(path);
	uint64_t calls = fault_disarm();
	/* Renamed, but the folder was not synced: told, and it may be there after all. */
	bool in_place = status == STATUS_FAILED && strstr(failure_message(), "is in place") != NULL;
	expect(status == STATUS_OK || told(status));
	expect(calls >= fault->nth || status == STATUS_OK);
	expect_nothing_aside(path, fault);
	if (status == STATUS_OK || in_place)
		expect_store(path, hash_after);
	else if (before == NOTHING)
		expect(access(path, F_OK) != 0);
	else
		expect_store(path, hash_before[before]);
	/* The next one is not in the way of what this one left. */
	if (status != STATUS_OK && before == NOTHING && fault->forever) {
		expect(import(path) == STATUS_OK);
		expect_store(path, hash_after);
	}
	return calls;
}

static void every_call(enum before before)
{
	uint64_t ran = 0;
	for (int kind = FAULT_NONE + 1; kind < FAULT_KINDS; kind++)
		ran += sweep(trial, &before, (enum fault_kind)kind, kind == FAULT_SQLITE_MEMORY ? MOST : UINT64_MAX);
	assert_true(ran > 100);
}

static void a_failed_import_leaves_nothing(void **state)
{
	every_call(NOTHING);
}

static void a_failed_import_leaves_the_store_it_was_to_replace(void **state)
{
	every_call(STORE);
}

static void a_failed_import_leaves_the_epochs_of_a_killed_writer(void **state)
{
	every_call(KILLED);
}

static int enter(void **state)
{
	if (folder_make(state) != 0)
		return -1;
	make_before();
	assert_ok(import(in_folder("whole.furrow")));
	struct store *store = open_store(in_folder("whole.furrow"), STORE_READ);
	hash_after = content(store);
	store_close(store);
	return 0;
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_failed_import_leaves_nothing),
		cmocka_unit_test(a_failed_import_leaves_the_store_it_was_to_replace),
		cmocka_unit_test(a_failed_import_leaves_the_epochs_of_a_killed_writer),
	};
	fault_install();
	return cmocka_run_group_tests(tests, enter, folder_remove);
}
