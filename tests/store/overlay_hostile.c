/* Overlays that are damaged or lie, and bases that are not theirs: one line and a status, never harm. */
#include "overlay.h"
#include "../support/program.h"

static void write_file(const char *path, const char *bytes, size_t size)
{
	FILE *file = fopen(path, "wb");
	assert_non_null(file);
	assert_int_equal(fwrite(bytes, 1, size, file), size);
	assert_int_equal(fclose(file), 0);
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
	assert_ok(store_create(base, &meta, STORE_OVERWRITE_FORCE, &store));
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
	meta.extent = (struct extent){600, 400, 1, 32};
	int32_t *zeros = calloc(33 * 33, sizeof *zeros);
	assert_ok(store_create(base, &meta, STORE_OVERWRITE_FORCE, &other));
	for (int level = 0; level <= extent_coarsest(&meta.extent); level++)
		for (uint32_t y = 0; y < extent_tiles_y(&meta.extent, level); y++)
			for (uint32_t x = 0; x < extent_tiles_x(&meta.extent, level); x++)
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
		for (int level = -2; level <= extent_coarsest(&store_meta(store)->extent); level++)
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
				size_t page = h % (size / 8192) * 8192;
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

TEST_PROGRAM(overlay_hostile)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_base_that_is_not_there_or_another_is_refused),
		cmocka_unit_test(a_header_that_is_not_the_base_s_is_refused),
		cmocka_unit_test(what_base_path_names_must_be_a_plain_store),
		cmocka_unit_test(a_base_replaced_while_it_is_open_is_noticed),
		cmocka_unit_test(damage_in_either_file_is_found),
		cmocka_unit_test(changed_bytes_in_either_file_do_no_harm),
		cmocka_unit_test(every_allocation_may_fail),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
