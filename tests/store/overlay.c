/* Overlays: deformation in a file of its own over a base that nobody writes, and what is refused. */
#include <fcntl.h>
#include <sys/wait.h>

#include "fixture.h"

static const struct store_options reading = {STORE_READ, false}, writing = {STORE_WRITE, false};

/* A base and an overlay of it, beside each other. */
static void make_both(const char *base, const char *overlay)
{
	make_store(base);
	unlink(overlay);
	assert_ok(store_create_overlay(overlay, base));
}

static char *bytes_of(const char *path, size_t *size)
{
	struct stat file;
	FILE *in = fopen(path, "rb");
	assert_true(in != NULL && fstat(fileno(in), &file) == 0);
	char *bytes = malloc((size_t)file.st_size);
	assert_non_null(bytes);
	*size = fread(bytes, 1, (size_t)file.st_size, in);
	assert_int_equal(*size, file.st_size);
	fclose(in);
	return bytes;
}

static void write_file(const char *path, const char *bytes, size_t size)
{
	FILE *file = fopen(path, "wb");
	assert_non_null(file);
	assert_int_equal(fwrite(bytes, 1, size, file), size);
	assert_int_equal(fclose(file), 0);
}

static void assert_bytes(const char *path, const char *want, size_t want_size)
{
	size_t size;
	char *bytes = bytes_of(path, &size);
	assert_int_equal(size, want_size);
	assert_memory_equal(bytes, want, size);
	free(bytes);
}

static void dig(struct store *store, uint32_t seed, int epochs)
{
	struct field field = field_make(-1);
	struct store_epoch_result result;
	assert_ok(store_set_working_level(store, -1));
	for (int i = 0; i < epochs; i++) {
		int64_t x = 30 + 25 * i, y = 60 - 10 * i;
		field_dig(&field, x, y, 12, seed + (uint32_t)i);
		assert_ok(field_commit(&field, around(x, y, 12), store, i + 1, &result));
		assert_int_equal(result.epoch, i + 1);
	}
	field_free(&field);
}

static void assert_refused(const char *path, const char *why)
{
	for (int mode = 0; mode < 2; mode++) {
		struct store *store;
		assert_status(store_open(path, mode ? &writing : &reading, &store), STATUS_INPUT);
		if (strstr(failure_message(), why) == NULL || strstr(failure_message(), path) == NULL)
			fail_msg("does not say '%s': %s", why, failure_message());
		assert_non_null(strstr(failure_message(), "; "));
	}
}

static void same_posts(struct store *a, struct store *b)
{
	struct store_reader *readers[2];
	struct post_rect rect = {40, 20, 70, 50};
	double values[2][900];
	assert_ok(store_reader_create(a, &readers[0]));
	assert_ok(store_reader_create(b, &readers[1]));
	for (int level = -2; level <= world_coarsest(&world); level++)
		for (int layer = STORE_SURFACE; layer <= STORE_SOIL; layer++) {
			for (int i = 0; i < 2; i++)
				assert_ok(store_read_posts(readers[i], (enum store_layer)layer, level, rect, values[i]));
			assert_memory_equal(values[0], values[1], sizeof values[0]);
		}
	struct store_sample samples[2];
	for (int i = 0; i < 2; i++)
		assert_ok(store_sample(readers[i], 30.3, 60.7, &samples[i]));
	assert_true(samples[0].height == samples[1].height && samples[0].offset == samples[1].offset);
	assert_true(samples[0].offset != 0 && samples[0].dirt == samples[1].dirt);
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
	assert_int_equal(numbers[0].offset_tiles, numbers[1].offset_tiles);
	assert_true(numbers[0].offset_tiles > 0 && numbers[0].epochs == 3);
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
	assert_ok(store_reset(store));
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
		meta.world.spacing += change == 0;
		meta.origin[0] += change == 1;
		meta.origin[1] += change == 2;
		meta.srs = change == 3 ? "LOCAL_CS[\"there\"]" : meta.srs;
		meta.vertical = change == 4 ? "up" : meta.vertical;
		assert_ok(store_create(again, &meta, true, &store));
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

static void only_an_untouched_plain_store_is_a_base(void **state)
{
	const char *base = in_folder("base.furrow"), *overlay = in_folder("over.furrow"), *next = in_folder("next.furrow");
	make_both(base, overlay);
	assert_status(store_create_overlay(overlay, base), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "exists"));
	assert_status(store_create_overlay(base, base), STATUS_INPUT);
	assert_status(store_create_overlay(next, overlay), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "overlay itself"));
	assert_status(store_create_overlay(next, in_folder("absent")), STATUS_INPUT);
	struct store *store = open_store(base, STORE_WRITE);
	dig(store, 1, 1);
	store_close(store);
	assert_status(store_create_overlay(next, base), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "reset"));
	assert_int_equal(files_of("next.furrow"), 0);
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
	assert_ok(store_create(other, &meta, true, &store));
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
	snprintf(overlay, sizeof overlay, "%s/deep", to);
	assert_int_equal(rmdir(overlay) + rmdir(to), 0);
}

static void a_base_that_is_not_there_or_another_is_refused(void **state)
{
	const char *base = in_folder("base.furrow"), *overlay = in_folder("over.furrow"), *aside = in_folder("aside");
	make_both(base, overlay);
	assert_int_equal(rename(base, aside), 0);
	assert_refused(overlay, "No such file");
	assert_non_null(strstr(failure_message(), base));
	/* Nothing is left beside it by trying to write. */
	assert_int_equal(files_of("over.furrow"), 1);
	struct store_meta meta = terrain_meta();
	struct store *store;
	meta.origin[0]++;
	assert_ok(store_create(base, &meta, true, &store));
	terrain_put(store);
	assert_ok(store_publish(store));
	store_close(store);
	assert_refused(overlay, "another one now");
	assert_int_equal(rename(aside, base), 0);
	store = open_store(overlay, STORE_READ);
	verified(store);
	store_close(store);
}

static void a_header_that_is_not_the_base_s_is_refused(void **state)
{
	const char *base = in_folder("base.furrow"), *overlay = in_folder("over.furrow");
	static const struct {
		const char *sql, *why;
	} edits[] = {
		{"UPDATE meta SET value = value + 1 WHERE key = 'base_hash'", "another one now"},
		{"UPDATE meta SET value = 32 WHERE key = 'cells'", "not that of its base"},
		{"UPDATE meta SET value = value - 1 WHERE key = 'width'", "not that of its base"},
		{"UPDATE meta SET value = value + 1 WHERE key = 'height'", "not that of its base"},
		{"UPDATE meta SET value = value * 2 WHERE key = 'spacing'", "not that of its base"},
		{"UPDATE meta SET value = value * 2 WHERE key = 'step'", "not that of its base"},
		{"UPDATE meta SET value = value + 1 WHERE key = 'origin_x'", "not that of its base"},
		{"UPDATE meta SET value = value + 1 WHERE key = 'origin_y'", "not that of its base"},
		{"UPDATE meta SET value = value - 1 WHERE key = 'low'", "not that of its base"},
		{"UPDATE meta SET value = value + 1 WHERE key = 'high'", "not that of its base"},
		{"UPDATE meta SET value = 'x' WHERE key = 'srs'", "not that of its base"},
		{"UPDATE meta SET value = 'x' WHERE key = 'vertical'", "not that of its base"},
		{"UPDATE meta SET value = 7 WHERE key = 'base_path'", "'base_path'"},
		{"UPDATE meta SET value = NULL WHERE key = 'base_path'", "'base_path'"},
		{"UPDATE meta SET value = x'61' WHERE key = 'base_path'", "'base_path'"},
		{"UPDATE meta SET value = '' WHERE key = 'base_path'", "'base_path'"},
		{"UPDATE meta SET value = 'base' || char(27) || 'furrow' WHERE key = 'base_path'", "'base_path'"},
		{"UPDATE meta SET value = 'base' || char(10) || 'furrow' WHERE key = 'base_path'", "'base_path'"},
		{"UPDATE meta SET value = 'base.furrow' || char(0) || 'x' WHERE key = 'base_path'", "'base_path'"},
		{"UPDATE meta SET value = printf('%.*c', 1000000, 'x') WHERE key = 'base_path'", "'base_path'"},
		{"UPDATE meta SET value = printf('%.*c', 4000, 'x') WHERE key = 'base_path'", "its base"},
	};
	for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
		make_both(base, overlay);
		raw_sql(overlay, edits[i].sql);
		assert_refused(overlay, edits[i].why);
	}
	/* Without a base it is a store that lacks all its tiles. */
	make_both(base, overlay);
	raw_sql(overlay, "DELETE FROM meta WHERE key = 'base_path'");
	struct store *store = open_store(overlay, STORE_READ);
	struct store_check check;
	assert_ok(store_verify(store, NULL, NULL, NULL, &check));
	assert_true(check.problems > 1);
	store_close(store);
}

static void what_base_path_names_must_be_a_plain_store(void **state)
{
	const char *base = in_folder("base.furrow"), *overlay = in_folder("over.furrow");
	make_both(base, overlay);
	assert_ok(store_create_overlay(in_folder("second"), base));
	assert_int_equal(mkfifo(in_folder("fifo"), 0644), 0);
	assert_int_equal(symlink(in_folder("over.furrow"), in_folder("link")), 0);
	assert_int_equal(symlink("loop", in_folder("loop")), 0);
	assert_int_equal(mkdir(in_folder("folder"), 0755), 0);
	fclose(fopen(in_folder("empty"), "w"));
	static const struct {
		const char *path, *why;
	} names[] = {
		{"over.furrow", "overlay itself"}, {"link", "overlay itself"}, {"second", "overlay itself"},
		{"folder", "not a file"},          {".", "not a file"},        {"fifo", "not a file"},
		{"/dev/zero", "not a file"},       {"/dev/tty", "its base"},   {"empty", "empty"},
		{"missing", "No such file"},       {"loop", "its base"},       {"base.furrow/x", "Not a directory"},
		{"/proc/self/environ", "its base"},
	};
	alarm(120); /* one that waits for a FIFO's writer would for ever */
	for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
		char sql[256];
		snprintf(sql, sizeof sql, "UPDATE meta SET value = '%s' WHERE key = 'base_path'", names[i].path);
		raw_sql(overlay, sql);
		assert_refused(overlay, names[i].why);
		assert_int_equal(files_of("over.furrow"), 1);
	}
	alarm(0);
	rmdir(in_folder("folder"));
}

static void a_base_replaced_while_it_is_open_is_noticed(void **state)
{
	const char *base = in_folder("base.furrow"), *overlay = in_folder("over.furrow");
	make_both(base, overlay);
	struct store *store = open_store(overlay, STORE_READ), *other;
	struct store_reader *early, *late;
	int32_t codes[POSTS], want[POSTS];
	struct store_range range;
	assert_ok(store_reader_create(store, &early));
	struct store_meta meta = terrain_meta();
	meta.world = (struct world){600, 400, 1, 32};
	int32_t *zeros = calloc(33 * 33, sizeof *zeros);
	assert_ok(store_create(base, &meta, true, &other));
	for (int level = 0; level <= world_coarsest(&meta.world); level++)
		for (uint32_t y = 0; y < world_tiles_y(&meta.world, level); y++)
			for (uint32_t x = 0; x < world_tiles_x(&meta.world, level); x++)
				assert_ok(store_put_base(other, (struct tile){level, x, y}, zeros,
							 &(struct store_range){0, 0, 0}));
	assert_ok(store_publish(other));
	store_close(other);
	free(zeros);
	assert_status(store_reader_create(store, &late), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), base));
	/* Who had it open still reads what it was. */
	terrain_tile((struct tile){0, 1, 1}, want, &range);
	assert_ok(store_read_base(early, (struct tile){0, 1, 1}, codes, NULL));
	assert_memory_equal(codes, want, sizeof codes);
	store_reader_destroy(early);
	store_close(store);
}

static char told[8][512];
static int told_count;

static void collect(void *user, const char *text)
{
	if (told_count < 8)
		snprintf(told[told_count++], sizeof told[0], "%s", text);
}

static void damage_in_either_file_is_found(void **state)
{
	const char *base = in_folder("base.furrow"), *overlay = in_folder("over.furrow");
	static const struct {
		const char *sql;
		bool in_base;
		const char *why;
	} edits[] = {
		{"UPDATE base SET blob = CAST(substr(blob, 1, 9) || x'5b' || substr(blob, 11) AS BLOB) WHERE key = "
		 "(SELECT min(key) FROM base)", true, "base tile level 0 x 0 y 0: its hash is wrong"},
		{"DELETE FROM base WHERE key = (SELECT min(key) FROM base)", true, "base tile level 0 x 0 y 0: it is missing"},
		{"UPDATE base SET hash = hash + 1 WHERE key = (SELECT max(key) FROM base)", true, "base_hash"},
		{"UPDATE \"offset\" SET above = above + 1 WHERE key = (SELECT min(key) FROM \"offset\")", false,
		 "its hash is wrong"},
		{"INSERT INTO base VALUES(0, 1, 1, 0, 0, 0, 0, x'00000000')", false, "base tiles, though it is an overlay"},
	};
	for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
		make_both(base, overlay);
		struct store *store = open_store(overlay, STORE_WRITE);
		struct store_check check;
		dig(store, 1, 1);
		store_close(store);
		raw_sql(edits[i].in_base ? base : overlay, edits[i].sql);
		store = open_store(overlay, STORE_READ);
		told_count = 0;
		assert_ok(store_verify(store, collect, NULL, NULL, &check));
		bool said = false;
		for (int line = 0; line < told_count; line++)
			said |= strstr(told[line], edits[i].why) != NULL;
		if (!said)
			fail_msg("none of %d says '%s': %s", told_count, edits[i].why, told_count > 0 ? told[0] : "");
		store_close(store);
	}
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
	assert_int_equal(numbers.epochs, 3);
	store_close(store);
	store_close(open_store(overlay, STORE_WRITE));
	assert_int_equal(files_of("over.furrow"), 1);
}

/* Whatever becomes of it: a status and a message, no harm. */
static void use(const char *overlay, bool write, int *opened, int *found)
{
	struct store *store;
	struct store_check check;
	struct store_reader *reader = NULL;
	struct store_numbers numbers;
	uint64_t hash;
	double values[64];
	if (store_open(overlay, write ? &writing : &reading, &store) != STATUS_OK)
		return;
	++*opened;
	if (store_verify(store, NULL, NULL, NULL, &check) == STATUS_OK)
		*found += check.problems > 0;
	int ignored = store_count(store, &numbers) + (int)store_content_hash(store, &hash);
	if (store_reader_create(store, &reader) == STATUS_OK)
		for (int level = -2; level <= world_coarsest(&store_meta(store)->world); level++)
			ignored += store_read_posts(reader, STORE_SURFACE, level, (struct post_rect){8, 8, 16, 16}, values);
	(void)ignored;
	store_reader_destroy(reader);
	store_close(store);
}

static void changed_bytes_in_either_file_do_no_harm(void **state)
{
	const char *base = in_folder("base.furrow"), *overlay = in_folder("over.furrow");
	make_both(base, overlay);
	struct store *store = open_store(overlay, STORE_WRITE);
	dig(store, 1, 2);
	store_close(store);
	const char *const files[] = {base, overlay};
	int opened = 0, found = 0, rounds = 0;
	for (int which = 0; which < 2; which++) {
		size_t size;
		char *good = bytes_of(files[which], &size), *bytes = malloc(size);
		assert_non_null(bytes);
		for (uint32_t round = 0; round < 120; round++, rounds++) {
			memcpy(bytes, good, size);
			for (uint32_t i = 0; i < 1 + round % 5; i++) {
				uint32_t h = mix(round, i, 17);
				size_t page = h % (size / 16384) * 16384;
				size_t at = h & 0x10000 ? (page + mix(h, 1, 1) % 200) % size : mix(h, 2, 1) % size;
				bytes[at] = (char)mix(h, 3, 1);
			}
			write_file(files[which], bytes, size);
			use(overlay, round % 2 != 0, &opened, &found);
		}
		write_file(files[which], good, size);
		free(good);
		free(bytes);
	}
	assert_true(opened > 20 && rounds - opened > 5 && found > 20);
	store = open_store(overlay, STORE_READ);
	verified(store);
	store_close(store);
}

static void every_allocation_may_fail(void **state)
{
	const char *base = in_folder("base.furrow"), *overlay = in_folder("memory.furrow");
	make_store(base);
	for (uint64_t nth = 1;; nth++) {
		mem_fail_nth(nth, 0);
		enum status status = store_create_overlay(overlay, base);
		bool done = mem_fail_nth(0, 0) < nth;
		assert_int_equal(status, done ? STATUS_OK : STATUS_FAILED);
		assert_int_equal(files_of("memory.furrow"), done);
		if (done)
			break;
	}
	for (uint64_t nth = 1;; nth++) {
		struct store *store = NULL;
		struct store_reader *reader = NULL;
		struct store_check check;
		uint64_t hash;
		mem_fail_nth(nth, 0);
		enum status status = store_open_overlay(overlay, base, &writing, &store);
		if (status == STATUS_OK)
			status = store_reader_create(store, &reader);
		if (status == STATUS_OK)
			status = store_verify(store, NULL, NULL, NULL, &check);
		if (status == STATUS_OK)
			status = store_content_hash(store, &hash);
		store_reader_destroy(reader);
		store_close(store);
		bool done = mem_fail_nth(0, 0) < nth;
		assert_int_equal(status, done ? STATUS_OK : STATUS_FAILED);
		assert_int_equal(files_of("memory.furrow"), 1);
		if (done)
			break;
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(an_overlay_is_the_store_it_would_have_been),
		cmocka_unit_test(a_reset_overlay_is_as_it_was_made),
		cmocka_unit_test(a_base_is_known_by_its_hash),
		cmocka_unit_test(only_an_untouched_plain_store_is_a_base),
		cmocka_unit_test(an_overlay_is_opened_over_its_own_base_only),
		cmocka_unit_test(one_made_for_nothing_is_removed),
		cmocka_unit_test(overlays_of_one_base_have_writers_at_once),
		cmocka_unit_test(both_may_be_moved_together),
		cmocka_unit_test(a_base_that_is_not_there_or_another_is_refused),
		cmocka_unit_test(a_header_that_is_not_the_base_s_is_refused),
		cmocka_unit_test(what_base_path_names_must_be_a_plain_store),
		cmocka_unit_test(a_base_replaced_while_it_is_open_is_noticed),
		cmocka_unit_test(damage_in_either_file_is_found),
		cmocka_unit_test(the_base_and_its_folder_may_be_read_only),
		cmocka_unit_test(a_killed_writer_leaves_its_last_epoch),
		cmocka_unit_test(changed_bytes_in_either_file_do_no_harm),
		cmocka_unit_test(every_allocation_may_fail),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
