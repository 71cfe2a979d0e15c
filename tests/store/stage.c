/* Staged bases: an overlay reads its base from a copy, and names the original; a copy that is not what its name says is refused. */
#include "chain.h"
#include "../support/program.h"
#include "../support/skip.h"

#include <pthread.h>

static char stage[256];

static int enter(void **state)
{
	if (folder_make(state) != 0)
		return -1;
	snprintf(stage, sizeof stage, "%s/stage", folder);
	return 0;
}

static int leave(void **state)
{
	char command[300];
	snprintf(command, sizeof command, "rm -rf '%s'", stage);
	return system(command) == 0 ? folder_remove(state) : -1;
}

static enum status count_calls(void *user, int64_t done, int64_t total)
{
	int64_t *calls = user;
	assert_true(done <= total);
	++*calls;
	return STATUS_OK;
}

static struct store_staged staged_of(const char *path, bool wants_made)
{
	struct store_staged staged;
	bool made = !wants_made;
	int64_t calls = 0;
	assert_ok(store_stage_name(path, stage, &staged));
	assert_ok(store_stage(&staged, count_calls, &calls, &made));
	assert_int_equal(made, wants_made);
	assert_true(calls > 10);
	return staged;
}

static struct store *open_staged(const char *path, enum store_mode mode, const struct store_staged *staged)
{
	struct store *store;
	assert_ok(store_open(path, &(struct store_options){.mode = mode, .staged = staged}, &store));
	return store;
}

static void assert_base(struct store *store)
{
	struct store_reader *reader;
	int32_t codes[POSTS], wanted[POSTS];
	struct store_range range, is;
	assert_ok(store_reader_create(store, &reader));
	for (int level = 0; level <= extent_coarsest(&extent); level++)
		for (uint32_t y = 0; y < extent_tiles_y(&extent, level); y++)
			for (uint32_t x = 0; x < extent_tiles_x(&extent, level); x++) {
				struct tile tile = {level, x, y};
				terrain_tile(tile, wanted, &range);
				assert_ok(store_read_base(reader, tile, codes, &is));
				assert_memory_equal(codes, wanted, sizeof codes);
			}
	store_reader_destroy(reader);
}

static void an_overlay_reads_the_copy_and_names_the_original(void **state)
{
	char base[256], over[256], away[256];
	int64_t revision;
	snprintf(base, sizeof base, "%s/base.furrow", folder);
	snprintf(over, sizeof over, "%s/over.furrow", folder);
	snprintf(away, sizeof away, "%s/away", folder);
	make_both(base, over);
	struct store *store = open_store(over, STORE_WRITE);
	dig(store, 3, 2);
	const uint64_t before = content(store);
	store_close(store);
	struct store_staged staged = staged_of(over, true), again = staged_of(base, false);
	assert_string_equal(staged.copy, again.copy);
	assert_string_equal(staged.original, again.original);
	assert_int_equal(files_of("stage"), 1);
	store = open_staged(over, STORE_WRITE, &staged);
	assert_string_equal(store_base_path(store), staged.original);
	assert_string_equal(store_parent(store, &revision), staged.original);
	assert_string_equal(store_copy_path(store), staged.copy);
	assert_true(content(store) == before);
	/* What is opened later is opened where the copy is. */
	assert_int_equal(rename(base, away), 0);
	assert_base(store);
	assert_int_equal(rename(away, base), 0);
	dig(store, 5, 0);
	store_close(store);
	store = open_store(over, STORE_READ);
	assert_string_equal(store_base_path(store), staged.original);
	assert_null(store_copy_path(store));
	assert_true(content(store) == before);
	verified(store);
	store_close(store);
	/* Nothing of a copy that is opened itself, or that another base has, is read. */
	char other[256];
	snprintf(other, sizeof other, "%s/other.furrow", folder);
	copy_file(base, other);
	store = open_staged(other, STORE_READ, &staged);
	assert_null(store_copy_path(store));
	store_close(store);
	store_staged_finish(&staged);
	store_staged_finish(&again);
}

static void a_base_with_ruts_is_staged_as_it_is_now(void **state)
{
	struct chain chain = chain_make("staged", 5);
	chain_grow(&chain, 3, 2);
	struct store *store = open_store(chain.paths[3], STORE_READ);
	const uint64_t before = content(store);
	store_close(store);
	struct store_staged first = staged_of(chain.paths[3], true);
	store = open_staged(chain.paths[3], STORE_READ, &first);
	assert_int_equal(store_depth(store), 3);
	assert_string_equal(store_copy_path(store), first.copy);
	assert_true(content(store) == before);
	assert_base(store);
	struct store *copy = open_store(first.copy, STORE_READ), *original = open_store(chain.paths[0], STORE_READ);
	assert_true(content(copy) == content(original));
	assert_int_equal(copy->commit, original->commit);
	assert_true(store_base_hash(copy) == store_base_hash(original));
	verified(copy);
	store_close(copy);
	store_close(original);
	store_close(store);
	/* Another base, or the same with more ruts, has another copy beside it. */
	char twin[256];
	snprintf(twin, sizeof twin, "%s/twin.furrow", folder);
	copy_file(chain.copy, twin);
	store = open_store(chain.copy, STORE_WRITE);
	struct store *witness = open_store(twin, STORE_WRITE);
	chain_drive(&chain, store, witness);
	store_close(store);
	store_close(witness);
	struct store_staged second = staged_of(chain.copy, true);
	assert_string_not_equal(first.copy, second.copy);
	assert_true(first.state != second.state);
	struct store_staged third = staged_of(chain.paths[3], false);
	assert_string_equal(first.copy, third.copy);
	store_staged_finish(&first);
	store_staged_finish(&second);
	store_staged_finish(&third);
	chain_free(&chain);
}

static void assert_refused_copy(const struct store_staged *staged, const char *why)
{
	bool made;
	struct stat before, after;
	assert_int_equal(stat(staged->copy, &before), 0);
	assert_status(store_stage(staged, NULL, NULL, &made), STATUS_INPUT);
	if (strstr(failure_message(), why) == NULL || strstr(failure_message(), staged->copy) == NULL ||
	    strstr(failure_message(), staged->original) == NULL || strstr(failure_message(), "; remove that file") == NULL)
		fail_msg("does not say '%s': %s", why, failure_message());
	assert_int_equal(stat(staged->copy, &after), 0);
	assert_int_equal(before.st_ino, after.st_ino);
}

static void what_is_no_whole_copy_is_refused_and_kept(void **state)
{
	static const char *const edits[][2] = {
		{"UPDATE base SET blob = zeroblob(length(blob)) WHERE key = (SELECT max(key) FROM base)", "base tile"},
		{"DELETE FROM base WHERE key = (SELECT max(key) FROM base)", "another base"},
		{"UPDATE base SET (low, high, error, codec, hash, blob) = (SELECT low, high, error, codec, hash, blob FROM base ORDER BY key LIMIT 1) "
		 "WHERE key = (SELECT max(key) FROM base)", "another base"},
		{"UPDATE offset SET blob = zeroblob(length(blob)) WHERE key = (SELECT max(key) FROM offset)", "offset tile"},
		{"DELETE FROM offset WHERE key = (SELECT max(key) FROM offset)", "other ruts"},
		{"UPDATE shear SET blob = zeroblob(length(blob)) WHERE key = (SELECT max(key) FROM shear)", "shear tile"},
	};
	char base[256], kept[256], over[256];
	snprintf(base, sizeof base, "%s/refused.furrow", folder);
	snprintf(kept, sizeof kept, "%s/kept", folder);
	snprintf(over, sizeof over, "%s/refused_over.furrow", folder);
	make_store(base);
	struct store *store = open_store(base, STORE_WRITE);
	dig(store, 8, 2);
	store_close(store);
	struct store_staged staged = staged_of(base, true);
	bool made;
	copy_file(staged.copy, kept);
	for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
		copy_file(kept, staged.copy);
		raw_sql(staged.copy, edits[i][0]);
		assert_refused_copy(&staged, edits[i][1]);
	}
	/* Cut short, empty, of another kind, of another base, an overlay. */
	copy_file(kept, staged.copy);
	assert_int_equal(truncate(staged.copy, 20000), 0);
	assert_refused_copy(&staged, "opening it");
	assert_int_equal(truncate(staged.copy, 0), 0);
	assert_refused_copy(&staged, "empty");
	copy_file("/proc/self/cmdline", staged.copy);
	assert_refused_copy(&staged, "not a Furrow store");
	copy_file(base, staged.copy);
	raw_sql(staged.copy, "DELETE FROM shear");
	assert_refused_copy(&staged, "other ruts");
	unlink(staged.copy);
	assert_ok(store_create_overlay(staged.copy, base));
	assert_refused_copy(&staged, "overlay");
	/* What a killed copying left is no obstacle. */
	unlink(staged.copy);
	snprintf(over, sizeof over, "%s.part", staged.copy);
	copy_file("/proc/self/cmdline", over);
	assert_ok(store_stage(&staged, NULL, NULL, &made));
	assert_true(made);
	assert_int_equal(access(over, F_OK), -1);
	store_staged_finish(&staged);
	/* No folder, and none that can be made. */
	assert_ok(store_stage_name(base, in_folder("no/such/folder"), &staged));
	assert_status(store_stage(&staged, NULL, NULL, &made), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "No such file or directory; give a folder"));
	store_staged_finish(&staged);
	assert_ok(store_stage_name(base, base, &staged));
	assert_status(store_stage(&staged, NULL, NULL, &made), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "; give a folder"));
	store_staged_finish(&staged);
}

static enum status stop_late(void *user, int64_t done, int64_t total)
{
	return total > 0 && done >= total / 2 ? fail_with(STATUS_INTERRUPTED, "stage: interrupted; run it again") : STATUS_OK;
}

static void a_copying_that_is_stopped_leaves_nothing(void **state)
{
	const char *base = in_folder("stopped.furrow");
	struct store_staged staged;
	struct stat file;
	bool made;
	char part[300];
	make_store(base);
	assert_ok(store_stage_name(base, stage, &staged));
	assert_status(store_stage(&staged, stop_late, NULL, &made), STATUS_INTERRUPTED);
	assert_true(!made && stat(staged.copy, &file) != 0);
	snprintf(part, sizeof part, "%s.part", staged.copy);
	assert_int_equal(access(part, F_OK), -1);
	snprintf(part, sizeof part, "%s-stage", staged.copy);
	assert_int_equal(access(part, F_OK), -1);
	/* A base that is driven between the two calls is not the one that was named. */
	struct store *store = open_store(base, STORE_WRITE);
	dig(store, 2, 1);
	store_close(store);
	assert_status(store_stage(&staged, NULL, NULL, &made), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "driven since"));
	assert_int_equal(stat(staged.copy, &file), -1);
	store_staged_finish(&staged);
}

/* --- several processes, here threads: each opens its own lock --- */

struct copier {
	const struct store_staged *staged;
	pthread_barrier_t *start;
	bool made;
	enum status status;
};

static void *copy_at_once(void *user)
{
	struct copier *copier = user;
	pthread_barrier_wait(copier->start);
	copier->status = store_stage(copier->staged, NULL, NULL, &copier->made);
	return NULL;
}

static void of_many_that_stage_at_once_one_copies(void **state)
{
	enum { MANY = 6 };
	const char *base = in_folder("many.furrow");
	make_store(base);
	for (int turn = 0; turn < 5; turn++) {
		struct store_staged staged;
		struct copier copiers[MANY];
		pthread_t threads[MANY];
		pthread_barrier_t start;
		int made = 0;
		assert_ok(store_stage_name(base, stage, &staged));
		pthread_barrier_init(&start, NULL, MANY);
		for (int i = 0; i < MANY; i++) {
			copiers[i] = (struct copier){.staged = &staged, .start = &start};
			assert_int_equal(pthread_create(&threads[i], NULL, copy_at_once, &copiers[i]), 0);
		}
		for (int i = 0; i < MANY; i++) {
			pthread_join(threads[i], NULL);
			assert_int_equal(copiers[i].status, STATUS_OK);
			made += copiers[i].made;
		}
		pthread_barrier_destroy(&start);
		assert_int_equal(made, 1);
		unlink(staged.copy);
		store_staged_finish(&staged);
	}
}

/* Imagery may be far larger than the heights, and no run reads it. */
static void a_copy_has_no_imagery(void **state)
{
	static const uint8_t grey[4 * POSTS] = {90, 90, 90, 255};
	const char *base = in_folder("coloured.furrow");
	const struct store_imagery_making making = {.quality = 0, .sources = "o.tif\n", .request = "o.tif"};
	struct store_staged before;
	int64_t tiles;
	if (!store_imagery_possible())
		skip_since("no libwebp");
	make_store(base);
	assert_ok(store_stage_name(base, stage, &before));
	struct store *store = open_store(base, STORE_WRITE);
	assert_ok(store_imagery_begin(store, &making, &tiles));
	for (int level = 0; level <= extent_coarsest(&extent); level++) {
		void *packed;
		size_t size;
		assert_ok(store_imagery_pack(grey, SIDE, 0, &packed, &size));
		assert_ok(store_imagery_put(store, (struct tile){level, 0, 0}, packed, size));
		mem_free(packed);
	}
	assert_ok(store_imagery_finish(store));
	store_close(store);
	struct store_staged staged = staged_of(base, true);
	assert_string_equal(staged.copy, before.copy);
	store = open_store(base, STORE_READ);
	struct store *copy = open_store(staged.copy, STORE_READ);
	assert_true(store_has_imagery(store, NULL, NULL));
	assert_false(store_has_imagery(copy, NULL, NULL));
	assert_true(store_base_hash(copy) == store_base_hash(store));
	verified(copy);
	store_close(copy);
	store_close(store);
	unlink(staged.copy);
	store_staged_finish(&staged);
	store_staged_finish(&before);
}

TEST_PROGRAM(stage)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(an_overlay_reads_the_copy_and_names_the_original),
		cmocka_unit_test(a_base_with_ruts_is_staged_as_it_is_now),
		cmocka_unit_test(what_is_no_whole_copy_is_refused_and_kept),
		cmocka_unit_test(a_copying_that_is_stopped_leaves_nothing),
		cmocka_unit_test(of_many_that_stage_at_once_one_copies),
		cmocka_unit_test(a_copy_has_no_imagery),
	};
	return cmocka_run_group_tests(tests, enter, leave);
}
