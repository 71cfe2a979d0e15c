/*
 * The WAL stays about as long as it may, however much is written and whoever reads meanwhile.
 *
 * Epochs of tiles that do not pack: 64 of 257 x 257 posts and those above them, some 22 MB each.
 */
#include <pthread.h>
#include <stdatomic.h>
#include <time.h>

#include "fixture.h"
#include "../support/program.h"

enum { TILES = 8, CELLS = 256, LEVEL = -2 };
#define MEGABYTE (INT64_C(1) << 20)
#define BOUND (64 * MEGABYTE)

static int32_t *planes; /* an epoch's; others are these, turned about */
static struct store_page pages[TILES * TILES];

static struct store *make(const char *path)
{
	const struct store_meta meta = {.extent = {513, 513, 1, CELLS}, .step = 1, .srs = "", .vertical = "", .sources = ""};
	const struct tile tiles[] = {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 0}};
	int32_t *codes = calloc((CELLS + 1) * (CELLS + 1), sizeof *codes);
	struct store *store;
	assert_ok(store_create(path, &meta, STORE_OVERWRITE_FORCE, &store));
	for (size_t i = 0; i < sizeof tiles / sizeof *tiles; i++)
		assert_ok(store_put_base(store, tiles[i], codes, &(struct store_range){0, 0, 0}));
	assert_ok(store_publish(store));
	store_close(store);
	free(codes);
	store = open_store(path, STORE_WRITE);
	assert_ok(store_set_working_level(store, LEVEL));
	return store;
}

static int64_t wal_bytes(const char *path)
{
	char wal[300];
	struct stat file;
	snprintf(wal, sizeof wal, "%s-wal", path);
	return stat(wal, &file) == 0 ? file.st_size : 0;
}

/* Returns the bytes of its rows. */
static int64_t write_epoch(struct store *store, int step)
{
	struct store_run run = {.scene_hash = "abc", .step = step, .state = "{}"};
	struct store_commit_result result;
	size_t posts = (CELLS + 1) * (CELLS + 1);
	for (int i = 0; i < TILES * TILES; i++)
		pages[i] = (struct store_page){{LEVEL, (uint32_t)(i % TILES), (uint32_t)(i / TILES)},
					       {planes + (size_t)((i + step) % (TILES * TILES)) * posts}};
	assert_ok(store_commit(store, pages, TILES * TILES, &run, &result));
	assert_ok(store_bound_wal(store));
	return result.bytes_written;
}

static atomic_bool over;

/* As a loader does: one short read after the other, and a little work with what it read. */
static void *read_tiles(void *argument)
{
	const struct timespec nap = {0, 200000};
	struct store_reader *reader;
	int32_t *offset = calloc((CELLS + 1) * (CELLS + 1), sizeof *offset);
	uintptr_t failed = store_reader_create(argument, &reader) != STATUS_OK;
	for (uint32_t i = 0; failed == 0 && !atomic_load(&over); i++) {
		unsigned present;
		struct tile tile = {LEVEL, i % TILES, i / TILES % TILES};
		failed = store_read_deformed(reader, tile, PLANE_BIT(PLANE_OFFSET), (void *[PLANES]){offset}, &present) !=
			 STATUS_OK;
		nanosleep(&nap, NULL);
	}
	store_reader_destroy(reader);
	free(offset);
	return (void *)failed;
}

static void it_stays_short_while_others_read(void **state)
{
	const char *path = in_folder("short.furrow");
	struct store *store = make(path);
	pthread_t readers[3];
	int64_t most = 0, written = 0;
	atomic_store(&over, false);
	for (int i = 0; i < 3; i++)
		assert_int_equal(pthread_create(&readers[i], NULL, read_tiles, store), 0);
	for (int step = 0; step < 12; step++) {
		written += write_epoch(store, step);
		most = wal_bytes(path) > most ? wal_bytes(path) : most;
	}
	atomic_store(&over, true);
	for (int i = 0; i < 3; i++) {
		void *failed;
		assert_int_equal(pthread_join(readers[i], &failed), 0);
		assert_null(failed);
	}
	assert_true(written > 240 * MEGABYTE);
	/* Up to twice the bound nobody is waited for; then comes the epoch that went over. Once, a reader may have had no processor
	 * for longer than the wait. */
	assert_true(most > BOUND / 2 && most < 3 * BOUND + 32 * MEGABYTE);
	store_close(store);
	assert_int_equal(wal_bytes(path), 0);
}

static void it_is_cut_once_a_reader_that_stayed_has_gone(void **state)
{
	const char *path = in_folder("held.furrow");
	struct store *store = make(path);
	sqlite3 *db;
	write_epoch(store, 0);
	assert_int_equal(sqlite3_open_v2(path, &db, SQLITE_OPEN_READONLY, NULL), SQLITE_OK);
	assert_int_equal(sqlite3_exec(db, "BEGIN; SELECT count(*) FROM run", NULL, NULL, NULL), SQLITE_OK);
	for (int step = 1; step <= 8; step++)
		write_epoch(store, step);
	assert_true(wal_bytes(path) > 3 * BOUND - 32 * MEGABYTE);
	assert_int_equal(sqlite3_close(db), SQLITE_OK);
	for (int step = 9; step < 11; step++)
		write_epoch(store, step);
	assert_true(wal_bytes(path) <= BOUND + MEGABYTE);
	store_close(store);
}

/* Reads at every moment, over one of two connections in turn. */
static void *take_turns(void *argument)
{
	static const char *const begin = "BEGIN; SELECT count(*) FROM run";
	const struct timespec nap = {0, 10000000};
	sqlite3 *db[2];
	uintptr_t failed = 0;
	for (int i = 0; i < 2; i++) {
		failed |= sqlite3_open_v2(argument, &db[i], SQLITE_OPEN_READONLY, NULL) != SQLITE_OK;
		sqlite3_busy_timeout(db[i], STORE_BUSY_MS);
	}
	failed |= sqlite3_exec(db[0], begin, NULL, NULL, NULL) != SQLITE_OK;
	for (int i = 1; failed == 0 && !atomic_load(&over); i = 1 - i) {
		failed |= sqlite3_exec(db[i], begin, NULL, NULL, NULL) != SQLITE_OK;
		failed |= sqlite3_exec(db[1 - i], "COMMIT", NULL, NULL, NULL) != SQLITE_OK;
		nanosleep(&nap, NULL);
	}
	for (int i = 0; i < 2; i++)
		sqlite3_close(db[i]);
	return (void *)failed;
}

/* A checkpoint that waits for nobody never gets through. */
static void it_stays_short_where_readers_take_turns(void **state)
{
	const char *path = in_folder("turns.furrow");
	struct store *store = make(path);
	pthread_t reader;
	void *failed;
	int64_t most = 0;
	atomic_store(&over, false);
	assert_int_equal(pthread_create(&reader, NULL, take_turns, (void *)(uintptr_t)path), 0);
	for (int step = 0; step < 12; step++) {
		write_epoch(store, step);
		most = wal_bytes(path) > most ? wal_bytes(path) : most;
	}
	atomic_store(&over, true);
	assert_int_equal(pthread_join(reader, &failed), 0);
	assert_null(failed);
	/* As above; once, a reader may have been slower than the wait. */
	assert_true(most < 3 * BOUND + 32 * MEGABYTE);
	store_close(store);
}

static int enter(void **state)
{
	size_t posts = (size_t)TILES * TILES * (CELLS + 1) * (CELLS + 1);
	uint32_t random = 1;
	planes = malloc(posts * sizeof *planes);
	if (planes == NULL)
		return -1;
	for (size_t i = 0; i < posts; i++) {
		random = random * 1664525 + 1013904223;
		planes[i] = (int32_t)random;
	}
	return folder_make(state);
}

static int leave(void **state)
{
	free(planes);
	return folder_remove(state);
}

TEST_PROGRAM(wal)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(it_stays_short_while_others_read),
		cmocka_unit_test(it_is_cut_once_a_reader_that_stayed_has_gone),
		cmocka_unit_test(it_stays_short_where_readers_take_turns),
	};
	return cmocka_run_group_tests(tests, enter, leave);
}
