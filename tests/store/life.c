/* A store's life: made aside, published whole, one writer, many readers, one file in the end. */
#include <fcntl.h>
#include <sys/wait.h>

#include "fixture.h"
#include "../support/program.h"

static void what_was_put_is_read_back(void **state)
{
	const char *path = in_folder("read.furrow");
	make_store(path);
	struct store *store = open_store(path, STORE_READ);
	const struct store_meta *meta = store_meta(store), want = terrain_meta();
	assert_memory_equal(&meta->extent, &want.extent, sizeof extent);
	assert_true(meta->step == STEP && meta->max_error == STEP / 2);
	assert_true(meta->origin[0] == 1000 && meta->origin[1] == -2000);
	assert_string_equal(meta->srs, want.srs);
	assert_string_equal(meta->vertical, "");
	assert_string_equal(meta->sources, want.sources);
	assert_string_equal(meta->insets, want.insets);
	assert_int_equal(store_finest(store), 0);
	assert_false(store_has_working_level(store, NULL));
	struct store_reader *reader;
	assert_ok(store_reader_create(store, &reader));
	int64_t tiles = 0;
	for (int level = 0; level <= extent_coarsest(&extent); level++)
		for (uint32_t y = 0; y < extent_tiles_y(&extent, level); y++)
			for (uint32_t x = 0; x < extent_tiles_x(&extent, level); x++, tiles++) {
				int32_t codes[POSTS], got[POSTS];
				struct store_range range, got_range, head;
				struct tile tile = {level, x, y};
				terrain_tile(tile, codes, &range);
				assert_ok(store_read_base(reader, tile, got, &got_range));
				assert_memory_equal(codes, got, sizeof codes);
				assert_ok(store_read_base_range(reader, tile, &head));
				assert_true(memcmp(&got_range, &head, sizeof head) == 0);
				assert_true(head.error == range.error);
				assert_true(head.low == range.low || (isnan(head.low) && isnan(range.low)));
				assert_true(head.high == range.high || (isnan(head.high) && isnan(range.high)));
				if (level == extent_coarsest(&extent))
					assert_true(meta->low == range.low && meta->high == range.high);
			}
	struct store_numbers numbers;
	assert_ok(store_count(store, &numbers));
	assert_int_equal(numbers.base_tiles, tiles);
	assert_int_equal(numbers.plane_tiles[PLANE_OFFSET] + numbers.plane_tiles[PLANE_DISTURBANCE] + numbers.commits, 0);
	assert_true(numbers.file_bytes >= numbers.base_bytes && numbers.base_bytes > 0);
	assert_null(numbers.last_run.scene_hash);
	verified(store);
	store_reader_destroy(reader);
	store_close(store);
}

static void lossless_codes_and_holes_everywhere_come_back(void **state)
{
	const char *path = in_folder("lossless.furrow");
	struct store_meta meta = terrain_meta();
	struct store *store;
	static const float heights[] = {-0.0f, 0.0f, 1e-30f, 5.25f, -100.5f};
	int32_t codes[POSTS], got[POSTS];
	meta.extent = (struct extent){17, 17, 1, 16};
	meta.step = 0;
	for (int i = 0; i < POSTS; i++)
		codes[i] = height_code_of_float(heights[i % 5]);
	for (int holes = 0; holes < 2; holes++) {
		struct store_range range = {-100.5, 5.25, 0};
		if (holes) {
			for (int i = 0; i < POSTS; i++)
				codes[i] = HEIGHT_CODE_NODATA;
			range.low = range.high = (double)NAN;
		}
		assert_ok(store_create(path, &meta, STORE_OVERWRITE_FORCE, &store));
		assert_ok(store_put_base(store, (struct tile){0, 0, 0}, codes, &range));
		assert_ok(store_publish(store));
		store_close(store);
		store = open_store(path, STORE_READ);
		struct store_reader *reader;
		assert_ok(store_reader_create(store, &reader));
		assert_ok(store_read_base(reader, (struct tile){0, 0, 0}, got, &range));
		assert_memory_equal(codes, got, sizeof codes);
		assert_int_equal(isnan(range.low), holes);
		verified(store);
		store_reader_destroy(reader);
		store_close(store);
	}
}

static void what_is_not_published_leaves_nothing(void **state)
{
	const char *path = in_folder("gone.furrow");
	struct store_meta meta = terrain_meta();
	struct store *store;
	assert_ok(store_create(path, &meta, false, &store));
	assert_int_equal(access(path, F_OK), -1);
	assert_true(files_of("gone.furrow") > 0);
	/* Two at once do not share the file aside. */
	struct store *second;
	assert_status(store_create(path, &meta, false, &second), STATUS_FAILED);
	/* Not all tiles: not published. */
	assert_status(store_publish(store), STATUS_FAILED);
	store_close(store);
	assert_int_equal(files_of("gone.furrow"), 0);
	store_close(NULL);
}

static void a_killed_import_leaves_nothing_in_the_way(void **state)
{
	const char *path = in_folder("cut.furrow");
	pid_t child = fork();
	if (child == 0) {
		struct store_meta meta = terrain_meta();
		struct store *store;
		if (store_create(path, &meta, false, &store) != STATUS_OK)
			_exit(1);
		terrain_put(store);
		_exit(0);
	}
	int ended;
	assert_int_equal(waitpid(child, &ended, 0), child);
	assert_int_equal(WEXITSTATUS(ended), 0);
	assert_int_equal(access(path, F_OK), -1);
	make_store(path);
	assert_int_equal(files_of("cut.furrow"), 1);
	struct store *store = open_store(path, STORE_READ);
	verified(store);
	store_close(store);
}

/* Tiles of level 0 and above, from the `first` of them up to before `end`. */
static void put_tiles(struct store *store, int64_t first, int64_t end)
{
	int64_t at = 0;
	for (int level = 0; level <= extent_coarsest(&extent); level++)
		for (uint32_t i = 0; i < extent_tiles_x(&extent, level) * extent_tiles_y(&extent, level); i++, at++) {
			int32_t codes[POSTS];
			struct store_range range;
			struct tile tile = {level, i % extent_tiles_x(&extent, level), i / extent_tiles_x(&extent, level)};
			terrain_tile(tile, codes, &range);
			if (at >= first && at < end)
				assert_ok(store_put_base(store, tile, codes, &range));
		}
}

/* What was there before a command is not removed by its failure. */
static void a_resumed_store_that_fails_is_kept(void **state)
{
	const char *path = in_folder("resumed.furrow");
	struct store_meta meta = terrain_meta();
	meta.request = "this one";
	struct store *store;
	int64_t tiles = 0;
	assert_ok(store_create(path, &meta, false, &store));
	put_tiles(store, 0, 5);
	assert_ok(store_suspend(store));
	assert_ok(store_resume(path, &meta, false, &store, &tiles));
	assert_int_equal(tiles, 5);
	store->commit_bytes = 1;
	put_tiles(store, 5, 7);
	assert_status(store_publish(store), STATUS_FAILED); /* not all tiles */
	store_close(store);
	assert_int_equal(files_of("resumed"), 1);
	assert_ok(store_resume(path, &meta, false, &store, &tiles));
	assert_int_equal(tiles, 7);
	put_tiles(store, 7, INT64_MAX);
	assert_ok(store_publish(store));
	store_close(store);
	assert_int_equal(files_of("resumed"), 1);
	store = open_store(path, STORE_READ);
	verified(store);
	store_close(store);
	/* Begun anew though it was asked to go on: nothing was there, nothing stays. */
	assert_ok(store_resume(in_folder("anew.furrow"), &meta, false, &store, &tiles));
	assert_int_equal(tiles, 0);
	store_close(store);
	assert_int_equal(files_of("anew"), 0);
}

static void an_existing_store_is_replaced_only_when_told(void **state)
{
	const char *path = in_folder("old.furrow");
	make_store(path);
	struct store_meta meta = terrain_meta();
	struct store *store, *writer;
	assert_status(store_create(path, &meta, false, &store), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "--overwrite"));
	/* Not while it is written. */
	writer = open_store(path, STORE_WRITE);
	assert_status(store_create(path, &meta, STORE_OVERWRITE_FORCE, &store), STATUS_FAILED);
	store_close(writer);
	/* A WAL that a killed writer left is not applied to what replaces its store. */
	pid_t child = fork();
	if (child == 0) {
		struct field field = field_make(0);
		struct store_commit_result result;
		field_dig(&field, 30, 20, 8, 1);
		struct store_options options = {.mode = STORE_WRITE};
		if (store_open(path, &options, &writer) != STATUS_OK ||
		    store_set_working_level(writer, 0) != STATUS_OK ||
		    field_commit(&field, field_all(&field), writer, 1, &result) != STATUS_OK)
			_exit(1);
		_exit(0);
	}
	int ended;
	assert_int_equal(waitpid(child, &ended, 0), child);
	assert_int_equal(WEXITSTATUS(ended), 0);
	assert_true(files_of("old.furrow-wal") == 1);
	make_store(path);
	assert_int_equal(files_of("old.furrow"), 1);
	store = open_store(path, STORE_READ);
	struct store_numbers numbers;
	assert_ok(store_count(store, &numbers));
	assert_int_equal(numbers.plane_tiles[PLANE_OFFSET], 0);
	verified(store);
	store_close(store);
}

static void a_second_writer_is_refused(void **state)
{
	const char *path = in_folder("writer.furrow");
	make_store(path);
	struct store *store = open_store(path, STORE_WRITE), *second;
	struct store_options options = {.mode = STORE_WRITE};
	assert_status(store_open(path, &options, &second), STATUS_FAILED);
	assert_non_null(strstr(failure_message(), "writing"));
	/* Under another name, from another process. */
	const char *link = in_folder("link.furrow");
	assert_int_equal(symlink(path, link), 0);
	pid_t child = fork();
	if (child == 0)
		_exit(store_open(link, &options, &second) == STATUS_FAILED ? 0 : 1);
	int ended;
	assert_int_equal(waitpid(child, &ended, 0), child);
	assert_int_equal(WEXITSTATUS(ended), 0);
	/* Readers are welcome. */
	store_close(open_store(path, STORE_READ));
	store_close(store);
	/* Gone with the first. */
	store_close(open_store(path, STORE_WRITE));
	assert_int_equal(files_of("writer.furrow"), 1);
}

static void a_killed_writer_holds_no_lock(void **state)
{
	const char *path = in_folder("lock.furrow");
	make_store(path);
	pid_t child = fork();
	if (child == 0) {
		struct store *store;
		struct store_options options = {.mode = STORE_WRITE};
		_exit(store_open(path, &options, &store) == STATUS_OK ? 0 : 1); /* without closing */
	}
	int ended;
	assert_int_equal(waitpid(child, &ended, 0), child);
	assert_int_equal(WEXITSTATUS(ended), 0);
	store_close(open_store(path, STORE_WRITE));
	assert_int_equal(files_of("lock.furrow"), 1);
}

/* As another user, since root may write anywhere. */
static int as_nobody(const char *path)
{
	if (geteuid() == 0 && setuid(65534) != 0)
		return 2;
	struct store *store;
	struct store_options reading = {.mode = STORE_READ}, writing = {.mode = STORE_WRITE};
	if (store_open(path, &reading, &store) != STATUS_OK) {
		fprintf(stderr, "%s\n", failure_message());
		return 3;
	}
	struct store_reader *reader;
	int32_t codes[POSTS];
	struct store_check check;
	if (store_reader_create(store, &reader) != STATUS_OK ||
	    store_read_base(reader, (struct tile){0, 1, 1}, codes, NULL) != STATUS_OK)
		return 4;
	if (store_verify(store, NULL, NULL, NULL, &check) != STATUS_OK || check.problems != 0)
		return 5;
	store_reader_destroy(reader);
	store_close(store);
	return store_open(path, &writing, &store) == STATUS_FAILED ? 0 : 6;
}

static void a_reader_needs_no_writable_folder(void **state)
{
	for (int wal = 0; wal < 2; wal++) {
		const char *path = in_folder("fixed.furrow");
		make_store(path);
		if (wal) /* closed, but the file still says WAL */
			raw_sql(path, "PRAGMA journal_mode=WAL");
		assert_int_equal(files_of("fixed.furrow"), 1);
		assert_int_equal(chmod(path, 0444), 0);
		assert_int_equal(chmod(folder, 0555), 0);
		pid_t child = fork();
		if (child == 0)
			_exit(as_nobody(path));
		int ended;
		assert_int_equal(waitpid(child, &ended, 0), child);
		assert_int_equal(chmod(folder, 0755), 0);
		assert_int_equal(WEXITSTATUS(ended), 0);
		assert_int_equal(files_of("fixed.furrow"), 1);
		unlink(path);
	}
}

static void what_cannot_be_is_told(void **state)
{
	struct store_meta meta = terrain_meta();
	struct store *store;
	assert_status(store_create("/nowhere/at/all.furrow", &meta, false, &store), STATUS_INPUT);
	struct store_options reading = {.mode = STORE_READ};
	assert_status(store_open(in_folder("missing.furrow"), &reading, &store), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "No such file"));
	assert_status(store_open(folder, &reading, &store), STATUS_INPUT);
	meta.extent.cells = 15;
	assert_status(store_create(in_folder("odd.furrow"), &meta, false, &store), STATUS_INPUT);
	assert_int_equal(files_of("odd.furrow"), 0);
	const char *path = in_folder("low.furrow");
	make_store(path);
	store = open_store(path, STORE_READ);
	assert_status(store_set_working_level(store, TILE_LEVEL_MIN - 1), STATUS_INPUT);
	assert_status(store_set_working_level(store, extent_coarsest(&extent) + 1), STATUS_INPUT);
	store_close(store);
}

static void more_relief_than_the_lattice_holds_is_kept_but_not_divided(void **state)
{
	struct store_meta meta = terrain_meta();
	struct store *store;
	struct store_reader *reader;
	int32_t codes[POSTS] = {0};
	double values[4];
	meta.extent = (struct extent){17, 17, 1, 16};
	codes[0] = (int32_t)lround(-9000 / meta.step);
	codes[1] = (int32_t)lround(9000 / meta.step);
	struct store_range range = {-9000, 9000, 0};
	assert_ok(store_create(in_folder("high.furrow"), &meta, false, &store));
	assert_ok(store_put_base(store, (struct tile){0, 0, 0}, codes, &range));
	assert_ok(store_publish(store));
	store_close(store);
	store = open_store(in_folder("high.furrow"), STORE_READ);
	assert_ok(store_reader_create(store, &reader));
	assert_ok(store_read_posts(reader, STORE_BASE, 0, (struct post_rect){0, 0, 2, 2}, values));
	assert_true(fabs(values[1] - 9000) <= meta.step / 2);
	assert_status(store_read_posts(reader, STORE_BASE, -1, (struct post_rect){0, 0, 2, 2}, values), STATUS_INPUT);
	store_reader_destroy(reader);
	store_close(store);
}

static void every_allocation_may_fail(void **state)
{
	const char *path = in_folder("memory.furrow");
	make_store(path);
	for (int writing = 0; writing < 2; writing++)
		for (uint64_t nth = 1;; nth++) {
			struct store *store = NULL;
			struct store_reader *reader = NULL;
			struct store_options options = {.mode = writing ? STORE_WRITE : STORE_READ};
			double values[4];
			struct store_check check;
			uint64_t hash;
			mem_fail_nth(nth, 0);
			enum status status = store_open(path, &options, &store);
			if (status == STATUS_OK)
				status = store_reader_create(store, &reader);
			if (status == STATUS_OK)
				status = store_read_posts(reader, STORE_SURFACE, -2, (struct post_rect){3, 3, 5, 5}, values);
			if (status == STATUS_OK)
				status = store_verify(store, NULL, NULL, NULL, &check);
			if (status == STATUS_OK)
				status = store_content_hash(store, &hash);
			store_reader_destroy(reader);
			store_close(store);
			bool done = mem_fail_nth(0, 0) < nth;
			assert_int_equal(status, done ? STATUS_OK : STATUS_FAILED);
			if (done)
				break;
		}
	for (uint64_t nth = 1;; nth++) {
		struct store *store = NULL;
		struct store_meta meta = terrain_meta();
		mem_fail_nth(nth, 0);
		enum status status = store_create(path, &meta, STORE_OVERWRITE_FORCE, &store);
		if (status == STATUS_OK) {
			terrain_put(store);
			status = store_publish(store);
		}
		store_close(store);
		bool done = mem_fail_nth(0, 0) < nth;
		assert_int_equal(status, done ? STATUS_OK : STATUS_FAILED);
		assert_int_equal(files_of("memory.furrow"), 1);
		if (done)
			break;
	}
}

TEST_PROGRAM(life)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_was_put_is_read_back),
		cmocka_unit_test(lossless_codes_and_holes_everywhere_come_back),
		cmocka_unit_test(what_is_not_published_leaves_nothing),
		cmocka_unit_test(a_killed_import_leaves_nothing_in_the_way),
		cmocka_unit_test(a_resumed_store_that_fails_is_kept),
		cmocka_unit_test(an_existing_store_is_replaced_only_when_told),
		cmocka_unit_test(a_second_writer_is_refused),
		cmocka_unit_test(a_killed_writer_holds_no_lock),
		cmocka_unit_test(a_reader_needs_no_writable_folder),
		cmocka_unit_test(what_cannot_be_is_told),
		cmocka_unit_test(more_relief_than_the_lattice_holds_is_kept_but_not_divided),
		cmocka_unit_test(every_allocation_may_fail),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
