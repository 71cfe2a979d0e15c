/* Overlays: deformation in a file of its own over a base that nobody writes. */
#include <sys/wait.h>

#include "overlay.h"
#include "../support/program.h"

static void assert_bytes(const char *path, const char *want, size_t want_size)
{
	size_t size;
	char *bytes = bytes_of(path, &size);
	assert_int_equal(size, want_size);
	assert_memory_equal(bytes, want, size);
	free(bytes);
}

static void same_posts(struct store *a, struct store *b)
{
	struct store_reader *readers[2];
	struct post_rect rect = {40, 20, 70, 50};
	double values[2][900];
	assert_ok(store_reader_create(a, &readers[0]));
	assert_ok(store_reader_create(b, &readers[1]));
	for (int level = -2; level <= extent_coarsest(&extent); level++)
		for (int layer = STORE_SURFACE; layer <= STORE_SOIL; layer++) {
			for (int i = 0; i < 2; i++)
				assert_ok(store_read_posts(readers[i], (enum store_layer)layer, level, rect, values[i]));
			assert_memory_equal(values[0], values[1], sizeof values[0]);
		}
	struct store_sample samples[2];
	for (int i = 0; i < 2; i++)
		assert_ok(store_sample(readers[i], 30.3, 60.7, &samples[i]));
	assert_true(samples[0].height == samples[1].height && samples[0].offset == samples[1].offset);
	assert_true(samples[0].offset != 0 && samples[0].disturbance == samples[1].disturbance);
	for (int i = 0; i < 2; i++)
		store_reader_destroy(readers[i]);
}

static void an_overlay_is_the_store_it_would_have_been(void **state)
{
	const char *base = in_folder("base.furrow"), *overlay = in_folder("over.furrow"), *copy = in_folder("copy.furrow");
	size_t size;
	make_both(base, overlay);
	copy_file(base, copy);
	char *before = bytes_of(base, &size);
	struct store *over = open_store(overlay, STORE_WRITE), *plain = open_store(copy, STORE_WRITE);
	assert_true(content(over) == content(plain));
	dig(over, 5, 3);
	dig(plain, 5, 3);
	assert_true(content(over) == content(plain));
	same_posts(over, plain);
	store_close(over);
	store_close(plain);
	over = open_store(overlay, STORE_READ);
	plain = open_store(copy, STORE_READ);
	assert_true(content(over) == content(plain));
	same_posts(over, plain);
	struct store_check checks[2] = {verified(over), verified(plain)};
	assert_int_equal(checks[0].tiles, checks[1].tiles);
	assert_memory_equal(checks[0].offset_sum, checks[1].offset_sum, sizeof checks[0].offset_sum);
	struct store_numbers numbers[2];
	assert_ok(store_count(over, &numbers[0]));
	assert_ok(store_count(plain, &numbers[1]));
	assert_int_equal(numbers[0].base_tiles, numbers[1].base_tiles);
	assert_int_equal(numbers[0].base_bytes, numbers[1].base_bytes);
	assert_int_equal(numbers[0].plane_tiles[PLANE_OFFSET], numbers[1].plane_tiles[PLANE_OFFSET]);
	assert_true(numbers[0].plane_tiles[PLANE_OFFSET] > 0 && numbers[0].commits == 3);
	assert_true(store_base_hash(over) == store_base_hash(plain));
	assert_string_equal(store_base_path(over), base);
	assert_null(store_base_path(plain));
	store_close(over);
	store_close(plain);
	/* The undo. */
	assert_int_equal(files_of("over.furrow"), 1);
	unlink(overlay);
	assert_bytes(base, before, size);
	assert_int_equal(files_of("base.furrow"), 1);
	free(before);
}

static void a_reset_overlay_is_as_it_was_made(void **state)
{
	const char *base = in_folder("base.furrow"), *overlay = in_folder("over.furrow");
	make_both(base, overlay);
	struct store *store = open_store(overlay, STORE_WRITE), *plain = open_store(base, STORE_READ);
	dig(store, 5, 2);
	assert_true(content(store) != content(plain));
	assert_ok(store_reset(store, true));
	assert_true(content(store) == content(plain));
	verified(store);
	store_close(store);
	store_close(plain);
}

static void a_base_is_known_by_its_hash(void **state)
{
	const char *path = in_folder("known.furrow"), *again = in_folder("again.furrow");
	make_store(path);
	make_store(again);
	struct store *store = open_store(path, STORE_WRITE), *other = open_store(again, STORE_READ);
	uint64_t hash = store_base_hash(store);
	assert_true(store_base_hash(other) == hash);
	store_close(other);
	dig(store, 1, 1);
	store_close(store);
	raw_sql(path, "VACUUM");
	store = open_store(path, STORE_READ);
	assert_true(store_base_hash(store) == hash);
	verified(store);
	store_close(store);
	/* Each thing that makes it another terrain. */
	for (int change = 0; change < 6; change++) {
		struct store_meta meta = terrain_meta();
		meta.extent.spacing += change == 0;
		meta.origin[0] += change == 1;
		meta.origin[1] += change == 2;
		meta.srs = change == 3 ? "LOCAL_CS[\"there\"]" : meta.srs;
		meta.vertical = change == 4 ? "up" : meta.vertical;
		assert_ok(store_create(again, &meta, STORE_OVERWRITE_FORCE, &store));
		terrain_put(store);
		if (change == 5) {
			int32_t codes[POSTS];
			struct store_range range;
			terrain_tile((struct tile){0, 1, 1}, codes, &range);
			codes[7]++;
			assert_ok(store_put_base(store, (struct tile){0, 1, 1}, codes, &range));
		}
		assert_ok(store_publish(store));
		assert_true(store_base_hash(store) != hash);
		store_close(store);
	}
}

/* SQLite keeps no negative zero in a column of reals, but does where the header is. */
static void zeros_of_either_sign_make_a_base(void **state)
{
	const char *base = in_folder("zero.furrow"), *overlay = in_folder("zero.over");
	struct store_meta meta = terrain_meta();
	struct store *store;
	int32_t codes[POSTS];
	meta.extent = (struct extent){17, 17, 1, 16};
	meta.step = 0;
	meta.origin[0] = -0.0;
	for (int i = 0; i < POSTS; i++)
		codes[i] = height_code_of_float(i == 3 ? -0.0f : 5);
	assert_ok(store_create(base, &meta, STORE_OVERWRITE_FORCE, &store));
	assert_ok(store_put_base(store, (struct tile){0, 0, 0}, codes, &(struct store_range){-0.0, 5, 0}));
	assert_ok(store_publish(store));
	store_close(store);
	assert_ok(store_create_overlay(overlay, base));
	store = open_store(base, STORE_READ);
	verified(store);
	store_close(store);
	store = open_store(overlay, STORE_READ);
	verified(store);
	store_close(store);
}

static void an_overlay_of_an_untouched_store_has_only_its_base(void **state)
{
	const char *base = in_folder("base.furrow"), *overlay = in_folder("over.furrow"), *next = in_folder("next.furrow");
	make_both(base, overlay);
	assert_status(store_create_overlay(overlay, base), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "exists"));
	assert_status(store_create_overlay(base, base), STATUS_INPUT);
	assert_status(store_create_overlay(next, in_folder("absent")), STATUS_INPUT);
	assert_int_equal(files_of("next.furrow"), 0);
	struct store *store = open_store(base, STORE_WRITE);
	dig(store, 1, 1);
	store_close(store);
	/* The one made before does not see it. */
	struct store *over = open_store(overlay, STORE_READ);
	assert_false(store_has_working_level(over, NULL));
	verified(over);
	store_close(over);
	unlink(base);
}

static void an_overlay_is_opened_over_its_own_base_only(void **state)
{
	const char *base = in_folder("base.furrow"), *overlay = in_folder("over.furrow");
	struct store *store;
	make_both(base, overlay);
	assert_ok(store_open_overlay(overlay, base, &writing, &store));
	dig(store, 1, 1);
	store_abandon(store); /* not made by this opening, and it holds an epoch */
	assert_int_equal(files_of("over.furrow"), 1);
	assert_status(store_open_overlay(overlay, overlay, &writing, &store), STATUS_INPUT);
	assert_status(store_open_overlay(base, base, &writing, &store), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "not an overlay"));
	const char *copy = in_folder("copy.furrow"), *other = in_folder("other.furrow");
	copy_file(base, copy);
	assert_ok(store_open_overlay(overlay, copy, &writing, &store));
	store_close(store);
	struct store_meta meta = terrain_meta();
	meta.origin[0]++;
	assert_ok(store_create(other, &meta, STORE_OVERWRITE_FORCE, &store));
	terrain_put(store);
	assert_ok(store_publish(store));
	store_close(store);
	assert_status(store_open_overlay(overlay, other, &writing, &store), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "not of"));
	assert_int_equal(files_of("over.furrow"), 1);
}

static void one_made_for_nothing_is_removed(void **state)
{
	const char *base = in_folder("base.furrow");
	const char *overlay = in_folder("brief.furrow");
	struct store *store;
	make_store(base);
	assert_ok(store_open_overlay(overlay, base, &writing, &store));
	assert_int_equal(access(overlay, F_OK), 0);
	store_abandon(store);
	assert_int_equal(files_of("brief.furrow"), 0);
	assert_ok(store_open_overlay(overlay, base, &writing, &store));
	dig(store, 1, 1);
	store_abandon(store);
	assert_int_equal(files_of("brief.furrow"), 1);
	store = open_store(overlay, STORE_READ);
	verified(store);
	store_abandon(store);
	store_abandon(NULL);
	assert_int_equal(files_of("brief.furrow"), 1);
	unlink(overlay);
	assert_ok(store_open_overlay(overlay, base, &writing, &store));
	store_close(store);
	assert_int_equal(files_of("brief.furrow"), 1);
}

static void overlays_of_one_base_have_writers_at_once(void **state)
{
	const char *base = in_folder("base.furrow"), *one = in_folder("one.furrow"), *two = in_folder("two.furrow");
	make_both(base, one);
	assert_ok(store_create_overlay(two, base));
	struct store *first = open_store(one, STORE_WRITE), *second = open_store(two, STORE_WRITE), *again;
	struct store *under = open_store(base, STORE_WRITE); /* neither has the base's lock */
	assert_status(store_open(one, &writing, &again), STATUS_FAILED);
	dig(first, 1, 2);
	dig(second, 2, 2);
	dig(under, 3, 2);
	assert_true(content(first) != content(second));
	uint64_t hash = content(first);
	store_close(under);
	verified(first);
	verified(second);
	store_close(second);
	assert_true(content(first) == hash);
	store_close(first);
	/* It was read when its writer ended: the next one makes it one file. */
	store_close(open_store(base, STORE_WRITE));
	assert_int_equal(files_of("one.furrow") + files_of("two.furrow") + files_of("base.furrow"), 3);
}

static void both_may_be_moved_together(void **state)
{
	char from[128], to[128], base[160], overlay[160], far[64] = "/var/tmp/furrow-overlay-XXXXXX";
	snprintf(from, sizeof from, "%s", in_folder("from"));
	snprintf(to, sizeof to, "%s", in_folder("to"));
	snprintf(base, sizeof base, "%s/base.furrow", from);
	snprintf(overlay, sizeof overlay, "%s/deep", from);
	assert_int_equal(mkdir(from, 0755), 0);
	assert_int_equal(mkdir(overlay, 0755), 0);
	snprintf(overlay, sizeof overlay, "%s/deep/over.furrow", from);
	make_store(base);
	assert_ok(store_create_overlay(overlay, base));
	assert_int_equal(rename(from, to), 0);
	assert_refused((snprintf(overlay, sizeof overlay, "%s/deep/over.furrow", from), overlay), "No such file");
	snprintf(overlay, sizeof overlay, "%s/deep/over.furrow", to);
	struct store *store = open_store(overlay, STORE_READ);
	verified(store);
	store_close(store);
	snprintf(base, sizeof base, "%s/base.furrow", to);
	/* Where only the root is shared, the path is absolute: the overlay alone may be moved. */
	assert_non_null(mkdtemp(far));
	char there[96], deeper[96], moved[96];
	snprintf(there, sizeof there, "%s/over.furrow", far);
	snprintf(deeper, sizeof deeper, "%s/deeper", far);
	snprintf(moved, sizeof moved, "%s/deeper/over.furrow", far);
	assert_int_equal(mkdir(deeper, 0755), 0);
	assert_ok(store_create_overlay(there, base));
	assert_int_equal(rename(there, moved), 0);
	store = open_store(moved, STORE_READ);
	assert_string_equal(store_base_path(store), base);
	store_close(store);
	unlink(moved);
	assert_int_equal(rmdir(deeper) + rmdir(far), 0);
	unlink(overlay);
	unlink(base);
	snprintf(base, sizeof base, "%s/base.furrow" PINS_SUFFIX, to);
	assert_int_equal(unlink(base), 0); /* moved together with both */
	snprintf(overlay, sizeof overlay, "%s/deep", to);
	assert_int_equal(rmdir(overlay) + rmdir(to), 0);
}

/* As another user, since root may write anywhere. */
static int as_nobody(const char *base, const char *overlay)
{
	if (geteuid() == 0 && setuid(65534) != 0)
		return 2;
	struct store *store;
	if (store_open_overlay(overlay, base, &writing, &store) != STATUS_OK) {
		fprintf(stderr, "%s\n", failure_message());
		return 3;
	}
	dig(store, 1, 2);
	verified(store);
	store_close(store);
	return store_open(base, &writing, &store) == STATUS_FAILED ? 0 : 4;
}

static void the_base_and_its_folder_may_be_read_only(void **state)
{
	for (int wal = 0; wal < 2; wal++) {
		char away[] = "/tmp/furrow-away-XXXXXX", overlay[64];
		const char *base = in_folder("fixed.furrow");
		assert_non_null(mkdtemp(away));
		assert_int_equal(chmod(away, 0777), 0);
		snprintf(overlay, sizeof overlay, "%s/over.furrow", away);
		make_store(base);
		if (wal) /* closed, but the file still says WAL */
			raw_sql(base, "PRAGMA journal_mode=WAL");
		assert_int_equal(chmod(base, 0444), 0);
		assert_int_equal(chmod(folder, 0555), 0);
		pid_t child = fork();
		if (child == 0)
			_exit(as_nobody(base, overlay));
		int ended;
		assert_int_equal(waitpid(child, &ended, 0), child);
		assert_int_equal(chmod(folder, 0755), 0);
		assert_int_equal(WEXITSTATUS(ended), 0);
		assert_int_equal(files_of("fixed.furrow"), 1);
		struct store *store = open_store(overlay, STORE_READ);
		verified(store);
		store_close(store);
		unlink(base);
		unlink(overlay);
		assert_int_equal(rmdir(away), 0);
	}
}

static void a_killed_writer_leaves_its_last_epoch(void **state)
{
	const char *base = in_folder("base.furrow"), *overlay = in_folder("over.furrow");
	make_both(base, overlay);
	pid_t child = fork();
	if (child == 0) {
		dig(open_store(overlay, STORE_WRITE), 1, 3);
		_exit(0); /* without closing */
	}
	int ended;
	assert_int_equal(waitpid(child, &ended, 0), child);
	assert_int_equal(WEXITSTATUS(ended), 0);
	assert_int_equal(files_of("over.furrow-wal"), 1);
	struct store *store = open_store(overlay, STORE_READ);
	struct store_numbers numbers;
	verified(store);
	assert_ok(store_count(store, &numbers));
	assert_int_equal(numbers.commits, 3);
	store_close(store);
	store_close(open_store(overlay, STORE_WRITE));
	assert_int_equal(files_of("over.furrow"), 1);
}

TEST_PROGRAM(overlay)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(an_overlay_is_the_store_it_would_have_been),
		cmocka_unit_test(a_reset_overlay_is_as_it_was_made),
		cmocka_unit_test(a_base_is_known_by_its_hash),
		cmocka_unit_test(zeros_of_either_sign_make_a_base),
		cmocka_unit_test(an_overlay_of_an_untouched_store_has_only_its_base),
		cmocka_unit_test(an_overlay_is_opened_over_its_own_base_only),
		cmocka_unit_test(one_made_for_nothing_is_removed),
		cmocka_unit_test(overlays_of_one_base_have_writers_at_once),
		cmocka_unit_test(both_may_be_moved_together),
		cmocka_unit_test(the_base_and_its_folder_may_be_read_only),
		cmocka_unit_test(a_killed_writer_leaves_its_last_epoch),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
