/* What a commit leaves: the pyramid above it, only rows that changed, and the last whole one after a failure or a kill. */
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include "fixture.h"
#include "../support/program.h"

/* What store_commit is to have written, from the field alone, at one coarser level. */
static struct field coarser(const struct field *fine)
{
	struct field coarse = field_make(fine->level + 1);
	for (int64_t y = 0; y < coarse.height; y++)
		for (int64_t x = 0; x < coarse.width; x++) {
			if (2 * x >= fine->width || 2 * y >= fine->height)
				continue;
			coarse.offset[y * coarse.width + x] = fine->offset[2 * y * fine->width + 2 * x];
			coarse.dirt[y * coarse.width + x] = fine->dirt[2 * y * fine->width + 2 * x];
		}
	return coarse;
}

static void assert_level(struct store_reader *reader, const struct field *field)
{
	for (uint32_t y = 0; y < extent_tiles_y(&extent, field->level); y++)
		for (uint32_t x = 0; x < extent_tiles_x(&extent, field->level); x++) {
			int32_t offset[POSTS], want[POSTS];
			uint8_t dirt[POSTS], want_dirt[POSTS];
			unsigned present;
			struct tile tile = {field->level, x, y};
			void *const planes[PLANES] = {[PLANE_OFFSET] = offset, [PLANE_DISTURBANCE] = dirt};
			assert_ok(store_read_deformed(reader, tile, PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DISTURBANCE), planes,
						      &present));
			field_tile(field, tile, want, want_dirt);
			assert_memory_equal(offset, want, sizeof want);
			assert_memory_equal(dirt, want_dirt, sizeof want_dirt);
		}
}

static void field_sums(const struct field *field, int64_t *below, int64_t *above)
{
	*below = *above = 0;
	for (int64_t i = 0; i < field->width * field->height; i++) {
		*below += field->offset[i] < 0 ? field->offset[i] : 0;
		*above += field->offset[i] > 0 ? field->offset[i] : 0;
	}
}

static void every_level_is_the_decimation_of_the_finer(void **state)
{
	const char *path = in_folder("pyramid.furrow");
	for (int level = -2; level <= 1; level++) {
		make_store(path);
		struct store *store = open_store(path, STORE_WRITE);
		assert_ok(store_set_working_level(store, level));
		struct field field = field_make(level);
		struct store_commit_result result;
		int64_t below = 0, above = 0, want_below, want_above;
		for (int i = 0; i < 6; i++) {
			int64_t cx = mix((uint32_t)i, 1, 9) % extent_posts(extent.width, level);
			int64_t cy = mix((uint32_t)i, 2, 9) % extent_posts(extent.height, level);
			field_dig(&field, cx, cy, 9, (uint32_t)i);
			assert_ok(field_commit(&field, around(cx, cy, 9), store, i, &result));
			assert_int_equal(result.commit, i + 1);
			assert_true(result.tiles_written > 0 && result.bytes_written > 0);
			below += result.below;
			above += result.above;
		}
		field_sums(&field, &want_below, &want_above);
		assert_int_equal(below, want_below);
		assert_int_equal(above, want_above);
		struct store_check check = verified(store);
		struct store_reader *reader;
		assert_ok(store_reader_create(store, &reader));
		for (int l = level; l <= extent_coarsest(&extent); l++) {
			assert_level(reader, &field);
			field_sums(&field, &want_below, &want_above);
			assert_int_equal(check.offset_sum[l - TILE_LEVEL_MIN], want_below + want_above);
			struct field next = l < extent_coarsest(&extent) ? coarser(&field) : (struct field){0};
			field_free(&field);
			field = next;
		}
		store_reader_destroy(reader);
		store_close(store);
	}
}

static void content_does_not_depend_on_how_it_was_split(void **state)
{
	uint64_t hashes[3];
	int64_t rows[3];
	for (int way = 0; way < 3; way++) {
		const char *path = in_folder("split.furrow");
		make_store(path);
		struct store *store = open_store(path, STORE_WRITE);
		assert_ok(store_set_working_level(store, -1));
		struct field field = field_make(-1);
		struct store_commit_result result;
		int64_t step = 0;
		if (way == 1) { /* dug elsewhere and everywhere, then filled again */
			field_dig(&field, 80, 60, 60, 99);
			assert_ok(field_commit(&field, field_all(&field), store, step++, &result));
			field_clear(&field);
			assert_ok(field_commit(&field, field_all(&field), store, step++, &result));
			struct store_numbers numbers;
			assert_ok(store_count(store, &numbers));
			for (int plane = 0; plane < PLANES; plane++)
				assert_int_equal(numbers.plane_tiles[plane], 0);
		}
		for (int i = 0; i < 5; i++) {
			field_dig(&field, 20 + 25 * i, 40 + 5 * i, 7, (uint32_t)i);
			if (way != 2)
				assert_ok(field_commit(&field, around(20 + 25 * i, 40 + 5 * i, 7), store, step++, &result));
		}
		if (way == 2) /* at once, with the tiles nothing happened to */
			assert_ok(field_commit(&field, field_all(&field), store, step++, &result));
		verified(store);
		hashes[way] = content(store);
		struct store_numbers numbers;
		assert_ok(store_count(store, &numbers));
		rows[way] = numbers.plane_tiles[PLANE_OFFSET] + numbers.plane_tiles[PLANE_PLASTIC_SINKAGE];
		assert_int_equal(numbers.commits, step);
		field_free(&field);
		store_close(store);
	}
	assert_int_equal(rows[0], rows[2]);
	assert_int_equal(rows[1], rows[2]);
	assert_true(hashes[0] == hashes[2]);
	assert_true(hashes[1] == hashes[2]);
}

static void rows_that_did_not_change_are_not_written(void **state)
{
	const char *path = in_folder("same.furrow");
	make_store(path);
	struct store *store = open_store(path, STORE_WRITE);
	assert_ok(store_set_working_level(store, -1));
	struct field field = field_make(-1);
	struct store_commit_result result;
	field_dig(&field, 40, 40, 6, 1);
	assert_ok(field_commit(&field, around(40, 40, 6), store, 0, &result));
	assert_ok(field_commit(&field, around(40, 40, 6), store, 1, &result));
	assert_int_equal(result.tiles_written, 0);
	assert_int_equal(result.below, 0);
	assert_int_equal(result.commit, 2);
	field_free(&field);
	store_close(store);
}

static void a_working_level_is_fixed_by_the_first_epoch_until_reset(void **state)
{
	const char *path = in_folder("level.furrow");
	make_store(path);
	struct store *store = open_store(path, STORE_WRITE);
	uint64_t fresh = content(store);
	struct store_numbers numbers;
	assert_ok(store_count(store, &numbers));
	int64_t fresh_bytes = numbers.file_bytes;
	assert_ok(store_set_working_level(store, -2));
	store_close(store); /* no epoch: nothing was fixed */
	store = open_store(path, STORE_WRITE);
	int level;
	assert_false(store_has_working_level(store, &level));
	assert_ok(store_set_working_level(store, -1));
	struct field field = field_make(-1);
	struct store_commit_result result;
	field_dig(&field, 40, 40, 6, 1);
	assert_ok(field_commit(&field, around(40, 40, 6), store, 7, &result));
	store_close(store);
	store = open_store(path, STORE_WRITE);
	assert_true(store_has_working_level(store, &level));
	assert_int_equal(level, -1);
	assert_int_equal(store_finest(store), -1);
	assert_status(store_set_working_level(store, -2), STATUS_INPUT);
	assert_ok(store_set_working_level(store, -1));
	assert_ok(store_count(store, &numbers));
	assert_int_equal(numbers.last_run.step, 7);
	assert_string_equal(numbers.last_run.scene_hash, "abc");
	assert_string_equal(numbers.last_run.state, "{\"poses\":[]}");
	assert_true(content(store) != fresh);
	assert_ok(store_reset(store, true));
	assert_true(content(store) == fresh);
	assert_ok(store_count(store, &numbers));
	assert_null(numbers.last_run.scene_hash);
	for (int plane = 0; plane < PLANES; plane++)
		assert_int_equal(numbers.plane_tiles[plane], 0);
	assert_int_equal(numbers.commits, 0);
	assert_ok(store_set_working_level(store, -2));
	verified(store);
	field_free(&field);
	store_close(store);
	store = open_store(path, STORE_READ);
	assert_ok(store_count(store, &numbers));
	assert_int_equal(numbers.file_bytes, fresh_bytes);
	store_close(store);
}

static void a_failed_epoch_leaves_the_one_before(void **state)
{
	const char *path = in_folder("failed.furrow");
	make_store(path);
	struct store *store = open_store(path, STORE_WRITE);
	assert_ok(store_set_working_level(store, -1));
	struct field field = field_make(-1);
	struct store_commit_result result;
	field_dig(&field, 40, 40, 6, 1);
	assert_ok(field_commit(&field, around(40, 40, 6), store, 1, &result));
	uint64_t before = content(store);
	field_dig(&field, 60, 50, 30, 2);
	/* Memory: the nth allocation fails, for every n. */
	mem_fail_nth(0, 0);
	for (uint64_t nth = 1;; nth++) {
		mem_fail_nth(nth, 0);
		enum status status = field_commit(&field, around(60, 50, 30), store, 2, &result);
		mem_fail_nth(0, 0);
		if (status == STATUS_OK) {
			assert_true(nth > 3);
			break;
		}
		assert_int_equal(status, STATUS_FAILED);
		assert_true(content(store) == before);
	}
	uint64_t after = content(store);
	assert_true(after != before);
	/* The disk: nothing more can be written, then it can. */
	assert_ok(store_checkpoint(store));
	field_dig(&field, 90, 50, 30, 3);
	signal(SIGXFSZ, SIG_IGN);
	struct rlimit limit, none;
	getrlimit(RLIMIT_FSIZE, &limit);
	none = (struct rlimit){8192, limit.rlim_max};
	setrlimit(RLIMIT_FSIZE, &none);
	enum status status = field_commit(&field, around(90, 50, 30), store, 3, &result);
	setrlimit(RLIMIT_FSIZE, &limit);
	assert_int_equal(status, STATUS_FAILED);
	assert_non_null(strstr(failure_message(), path));
	assert_true(content(store) == after);
	assert_ok(field_commit(&field, around(90, 50, 30), store, 3, &result));
	assert_int_equal(result.commit, 3);
	verified(store);
	field_free(&field);
	store_close(store);
	store = open_store(path, STORE_READ);
	verified(store);
	store_close(store);
}

/* A child digs epoch after epoch and says which it was told are committed; it is killed in the
 * middle. What is in the file is then the last it said, or the one that it could not say. */
static void a_killed_writer_leaves_its_last_epoch(void **state)
{
	const char *path = in_folder("killed.furrow");
	int64_t furthest = 0;
	make_store(path);
	for (int round = 0; round < 20; round++) {
		int ends[2];
		assert_int_equal(pipe(ends), 0);
		pid_t child = fork();
		assert_true(child >= 0);
		if (child == 0) {
			struct store *store;
			struct store_options options = {.mode = STORE_WRITE, .durable_full = round % 2 == 1};
			if (store_open(path, &options, &store) != STATUS_OK ||
			    store_set_working_level(store, -1) != STATUS_OK)
				_exit(1);
			struct field field = field_make(-1);
			for (int64_t i = 0;; i++) {
				struct store_commit_result result;
				field_dig(&field, 75, 50, 40, (uint32_t)(round * 1000 + i));
				if (field_commit(&field, around(75, 50, 40), store, i, &result) != STATUS_OK ||
				    (i % 5 == 4 && store_checkpoint(store) != STATUS_OK) ||
				    write(ends[1], &result.commit, sizeof result.commit) != sizeof result.commit)
					_exit(1);
			}
		}
		close(ends[1]);
		int64_t epoch = 0, last = 0;
		int wanted = 1 + round % 7;
		while (wanted-- > 0 && read(ends[0], &epoch, sizeof epoch) == sizeof epoch)
			last = epoch;
		usleep((useconds_t)(mix((uint32_t)round, 3, 3) % 4000));
		kill(child, SIGKILL);
		int ended;
		assert_int_equal(waitpid(child, &ended, 0), child);
		assert_true(WIFSIGNALED(ended));
		while (read(ends[0], &epoch, sizeof epoch) == sizeof epoch)
			last = epoch;
		close(ends[0]);
		struct store *store = open_store(path, round % 3 == 0 ? STORE_READ : STORE_WRITE);
		struct store_numbers numbers;
		assert_ok(store_count(store, &numbers));
		assert_true(numbers.commits == last || numbers.commits == last + 1);
		assert_true(numbers.commits > furthest);
		furthest = numbers.commits;
		verified(store);
		store_close(store);
	}
	store_close(open_store(path, STORE_WRITE));
	assert_int_equal(files_of("killed.furrow"), 1);
}

static void readers_see_a_whole_epoch_or_the_one_before(void **state)
{
	const char *path = in_folder("seen.furrow");
	make_store(path);
	struct store *store = open_store(path, STORE_WRITE);
	struct store *other = open_store(path, STORE_READ);
	struct store_reader *inside, *outside;
	assert_ok(store_reader_create(store, &inside));
	assert_ok(store_reader_create(other, &outside));
	assert_ok(store_set_working_level(store, -1));
	struct field field = field_make(-1);
	struct store_commit_result result;
	for (int i = 0; i < 4; i++) {
		field_dig(&field, 40 + i, 40, 6, (uint32_t)i);
		assert_ok(field_commit(&field, around(40 + i, 40, 6), store, i, &result));
		assert_level(inside, &field);
		assert_level(outside, &field);
		if (i == 1)
			assert_ok(store_checkpoint(store));
	}
	store_reader_destroy(inside);
	store_reader_destroy(outside);
	store_close(other);
	store_close(store);
	field_free(&field);
	assert_int_equal(files_of("seen.furrow"), 1);
}

TEST_PROGRAM(commits)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_level_is_the_decimation_of_the_finer),
		cmocka_unit_test(content_does_not_depend_on_how_it_was_split),
		cmocka_unit_test(rows_that_did_not_change_are_not_written),
		cmocka_unit_test(a_working_level_is_fixed_by_the_first_epoch_until_reset),
		cmocka_unit_test(a_failed_epoch_leaves_the_one_before),
		cmocka_unit_test(a_killed_writer_leaves_its_last_epoch),
		cmocka_unit_test(readers_see_a_whole_epoch_or_the_one_before),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
