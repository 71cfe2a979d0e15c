/* Files that are no stores, or once were: one line and STATUS_INPUT. Random changes of stores: tests/fuzz/store_file.c. */
#define _GNU_SOURCE /* memmem */
#include "fixture.h"
#include "../support/program.h"

static void write_file(const char *path, const char *text, size_t size)
{
	FILE *file = fopen(path, "wb");
	assert_non_null(file);
	assert_int_equal(fwrite(text, 1, size, file), size);
	assert_int_equal(fclose(file), 0);
}

static void assert_refused(const char *path, const char *why)
{
	for (int writing = 0; writing < 2; writing++) {
		struct store *store;
		struct store_options options = {.mode = writing ? STORE_WRITE : STORE_READ};
		assert_status(store_open(path, &options, &store), STATUS_INPUT);
		if (strstr(failure_message(), why) == NULL || strstr(failure_message(), path) == NULL)
			fail_msg("does not say '%s': %s", why, failure_message());
		assert_null(strchr(failure_message(), '\n'));
	}
}

static void what_is_no_store_is_refused(void **state)
{
	const char *path = in_folder("text");
	char text[20000];
	memset(text, 'x', sizeof text);
	write_file(path, text, 0);
	assert_refused(path, "empty");
	write_file(path, text, 100);
	assert_refused(path, "not a Furrow store");
	write_file(path, text, sizeof text);
	assert_refused(path, "not a Furrow store");
	unlink(path);
	raw_sql(path, "CREATE TABLE t(a)");
	assert_refused(path, "not a Furrow store");
}

static void another_version_or_schema_is_refused(void **state)
{
	const char *path = in_folder("other.furrow");
	static const struct {
		const char *sql, *why;
	} edits[] = {
		{"PRAGMA user_version=2", "version 2"},
		{"PRAGMA user_version=6", "version 6"},
		{"PRAGMA application_id=7", "application id 7"},
		{"CREATE VIEW v AS SELECT 1", "tables"},
		{"CREATE INDEX aaa ON base(low)", "tables"},
		{"CREATE TRIGGER zzz AFTER INSERT ON run BEGIN DELETE FROM base; END", "tables"},
		{"DROP TABLE shear", "tables"},
		{"ALTER TABLE run ADD COLUMN more", "tables"},
		{"DELETE FROM meta WHERE key = 'step'", "'step'"},
		{"UPDATE meta SET value = 15 WHERE key = 'cells'", "power of two"},
		{"UPDATE meta SET value = 9000000000000000000 WHERE key = 'width'", "too many posts"},
		{"UPDATE meta SET value = 'wide' WHERE key = 'width'", "'width'"},
		{"UPDATE meta SET value = 1e999 WHERE key = 'spacing'", "'spacing'"},
		{"UPDATE meta SET value = -1.0 WHERE key = 'step'", "'step'"},
		{"UPDATE meta SET value = 1e-300 WHERE key = 'step'", "'step'"},
		{"UPDATE meta SET value = 1e9 WHERE key = 'high'", "'low'"},
		{"UPDATE meta SET value = 3 WHERE key = 'srs'", "'srs'"},
		{"UPDATE meta SET value = 9 WHERE key = 'pack'", "'pack'"},
		{"INSERT INTO meta VALUES('working', 12)", "'working'"},
		{"DELETE FROM meta WHERE key = 'base_hash'", "'base_hash'"},
		{"UPDATE meta SET value = 'f00' WHERE key = 'base_hash'", "'base_hash'"},
		{"INSERT INTO run VALUES(1, 9223372036854775807, '', 0, 0, '', 0, '', '')", "'epoch'"},
		{"INSERT INTO run VALUES(1, -1, '', 0, 0, '', 0, '', '')", "'epoch'"},
	};
	for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
		unlink(path);
		make_store(path);
		raw_sql(path, edits[i].sql);
		assert_refused(path, edits[i].why);
	}
}

static void a_file_cut_short_is_refused(void **state)
{
	const char *path = in_folder("whole.furrow"), *cut = in_folder("short.furrow");
	make_store(path);
	struct stat file;
	assert_int_equal(stat(path, &file), 0);
	for (int i = 1; i < 16; i++) {
		copy_file(path, cut);
		assert_int_equal(truncate(cut, file.st_size * i / 16), 0);
		assert_refused(cut, "furrow"); /* some "cut short", the shortest "not a store" */
	}
}

static void make_deformed(const char *path, struct field *field)
{
	struct store_commit_result result;
	make_store(path);
	struct store *store = open_store(path, STORE_WRITE);
	assert_ok(store_set_working_level(store, -1));
	*field = field_make(-1);
	field_dig(field, 64, 48, 20, 1);
	assert_ok(field_commit(field, field_all(field), store, 1, &result));
	store_close(store);
}

/* An epoch takes the old sums from the new ones. */
static void sums_that_no_tile_has_are_refused(void **state)
{
	const char *path = in_folder("sums.furrow");
	static const char *const edits[] = {
		"UPDATE \"offset\" SET below = -9223372036854775807 - 1", "UPDATE \"offset\" SET below = 1",
		"UPDATE \"offset\" SET above = 9223372036854775807", "UPDATE \"offset\" SET above = -1",
	};
	for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
		struct field field;
		struct store_commit_result result;
		make_deformed(path, &field);
		raw_sql(path, edits[i]);
		struct store *store = open_store(path, STORE_WRITE);
		field_dig(&field, 64, 48, 20, 2);
		assert_status(field_commit(&field, field_all(&field), store, 2, &result), STATUS_INPUT);
		assert_non_null(strstr(failure_message(), "sums make no sense"));
		store_close(store);
		field_free(&field);
	}
}

/* Written as a stranger might, its hash right: a post's dirt goes into 8 bits, and so on. */
static void planes_beyond_their_range_are_refused(void **state)
{
	const char *path = in_folder("plane.furrow");
	static const struct {
		enum plane plane;
		enum store_layer layer;
		int32_t beyond;
	} cases[] = {
		{PLANE_DISTURBANCE, STORE_SOIL, 256},        {PLANE_DISTURBANCE, STORE_SOIL, -1},    {PLANE_DISTURBANCE, STORE_SOIL, INT32_MIN},
		{PLANE_PLASTIC_SINKAGE, STORE_PLASTIC_SINKAGE, -1},   {PLANE_SHEAR, STORE_SHEAR, 32768},  {PLANE_SHEAR, STORE_SHEAR_NORTH, INT32_MIN + 1},
		{PLANE_PLASTIC_SINKAGE, STORE_PLASTIC_SINKAGE, INT32_MIN},
	};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		struct field field;
		int32_t posts[POSTS] = {0};
		make_deformed(path, &field);
		struct store *store = open_store(path, STORE_WRITE);
		struct row row = {.tile = {-1, 4, 3}, .low = 0, .high = 255};
		posts[7] = cases[i].beyond;
		store_rows_encode(&store->rows, row_table_of(cases[i].plane), posts, &row);
		assert_ok(store_rows_put(&store->rows, row_table_of(cases[i].plane), &row));
		struct store_reader *reader;
		struct store_sample sample;
		double values[4];
		uint32_t texels[POSTS];
		unsigned present;
		void *planes[PLANES] = {NULL};
		planes[cases[i].plane] = texels;
		assert_ok(store_reader_create(store, &reader));
		/* Post (71, 48) of level -1. */
		assert_status(store_sample(reader, 71, 48, &sample), STATUS_INPUT);
		assert_non_null(strstr(failure_message(), plane_name(cases[i].plane)));
		assert_status(store_read_posts(reader, cases[i].layer, -1, (struct post_rect){71, 48, 73, 50}, values),
			      STATUS_INPUT);
		assert_status(store_read_deformed(reader, row.tile, PLANE_BIT(cases[i].plane), planes, &present),
			      STATUS_INPUT);
		store_reader_destroy(reader);
		struct store_check check;
		assert_ok(store_verify(store, NULL, NULL, NULL, &check));
		assert_true(check.problems > 0);
		store_close(store);
		field_free(&field);
	}
}

static void what_was_compacted_must_be_a_number(void **state)
{
	const char *path = in_folder("compacted.furrow");
	static const char *const edits[] = {"'many'", "1.5", "NULL", "9223372036854775807", "-2305843009213693952"};
	for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
		char sql[128];
		make_store(path);
		snprintf(sql, sizeof sql, "INSERT INTO meta(key, value) VALUES('compacted', %s)", edits[i]);
		raw_sql(path, sql);
		assert_refused(path, "'compacted'");
	}
}

static void tell_lost(void *user, const char *text)
{
	assert_true(text[0] != '\0');
	*(int *)user += strstr(text, "x 3 y 1: it is listed and cannot be found") != NULL;
}

/* SQLite's rows out of order: a scan meets what a search does not find. */
static void a_tile_listed_that_cannot_be_found_is_told(void **state)
{
	const char *path = in_folder("order.furrow");
	/* A row's key as SQLite writes it: tile (0, 0) of level 0, which becomes (3, 1). */
	static const char first[9] = {(char)0x90, (char)0x80, (char)0x80, (char)0x80, (char)0x80,
				      (char)0x80, (char)0x80, (char)0x80, 0};
	char bytes[1 << 18];
	char sql[80];
	make_store(path);
	snprintf(sql, sizeof sql, "DELETE FROM base WHERE key = %lld", (long long)tile_key((struct tile){0, 3, 1}));
	raw_sql(path, sql);
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	size_t size = fread(bytes, 1, sizeof bytes, file);
	fclose(file);
	char *at = memmem(bytes, size, first, sizeof first);
	assert_true(at != NULL && size < sizeof bytes);
	at[8] = 7;
	write_file(path, bytes, size);

	struct store *store = open_store(path, STORE_READ);
	struct store_check check;
	uint64_t hash;
	int lost = 0;
	assert_status(store_content_hash(store, &hash), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "cannot be found"));
	assert_ok(store_verify(store, tell_lost, NULL, &lost, &check));
	assert_int_equal(lost, 1);
	store_close(store);
}

TEST_PROGRAM(hostile)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_is_no_store_is_refused),
		cmocka_unit_test(another_version_or_schema_is_refused),
		cmocka_unit_test(a_file_cut_short_is_refused),
		cmocka_unit_test(sums_that_no_tile_has_are_refused),
		cmocka_unit_test(planes_beyond_their_range_are_refused),
		cmocka_unit_test(what_was_compacted_must_be_a_number),
		cmocka_unit_test(a_tile_listed_that_cannot_be_found_is_told),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
