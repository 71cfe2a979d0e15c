/* Stores of older versions: their ruts are read and driven over. What lies deposited on them counts as loose. Shear of version 3 counts as none. */
#include "fixture.h"
#include "../support/program.h"

static char told[512];
static int notes;

static void take_note(const char *text)
{
	snprintf(told, sizeof told, "%s", text);
	notes++;
}

/* The tables of version 6, and of version 5. */
static void tables_of(const char *path, int version)
{
	raw_sql(path, "DROP TABLE healed; DROP TABLE risen; DROP TABLE grown; DROP TABLE settled; DROP TABLE loose; DROP TABLE floor; DROP TABLE density; DROP TABLE slope; PRAGMA user_version=6");
	if (version == 5)
		raw_sql(path, "DROP TABLE pinned; DROP TABLE replaced; PRAGMA user_version=5");
}

/* The tables of version 4. */
static void older_tables(const char *path)
{
	tables_of(path, 5);
	raw_sql(path, "CREATE TEMP TABLE kept AS SELECT id, epoch, scene_hash, step, time, state FROM run; DROP TABLE run; "
		      "CREATE TABLE run(id INTEGER PRIMARY KEY CHECK (id = 1), epoch INTEGER NOT NULL, scene_hash TEXT NOT NULL, "
		      "step INTEGER NOT NULL, time REAL NOT NULL, state TEXT NOT NULL); INSERT INTO run SELECT * FROM kept; "
		      "DROP TABLE history; DROP TABLE revision; DROP TABLE snapshot; PRAGMA user_version=4");
}

/* Makes what the older version made: the same tables, with numbers in `shear` that mean nothing to this version. */
static void make_older(const char *path, struct field *field, bool driven)
{
	struct store_commit_result result;
	make_store(path);
	struct store *store = open_store(path, STORE_WRITE);
	*field = field_make(-1);
	if (driven) {
		assert_ok(store_set_working_level(store, -1));
		field_dig(field, 64, 48, 20, 1);
		assert_ok(field_commit(field, field_all(field), store, 1, &result));
		int32_t posts[POSTS];
		for (int i = 0; i < POSTS; i++)
			posts[i] = 0x8000 + i;
		struct row row = {.tile = {-1, 4, 3}, .low = 0.5, .high = 0.51, .revision = 1};
		store_rows_encode(&store->rows, ROW_SHEAR, posts, &row);
		assert_ok(store_rows_put(&store->rows, ROW_SHEAR, &row));
	}
	store_close(store);
	older_tables(path);
	raw_sql(path, "DROP TABLE dug; PRAGMA user_version=3");
	for (int plane = PLANE_SHEAR; plane < PLANES; plane++)
		memset(field->planes[plane], 0, (size_t)(field->width * field->height) * plane_bytes((enum plane)plane));
}

static int64_t version_of(const char *path)
{
	sqlite3 *db;
	int64_t version;
	assert_int_equal(sqlite3_open_v2(path, &db, SQLITE_OPEN_READONLY, NULL), SQLITE_OK);
	assert_ok(store_sql_integer(db, path, "PRAGMA user_version", &version));
	sqlite3_close(db);
	return version;
}

/* Makes an older store with ruts and opens it. One note says so. */
static struct store *open_older(const char *path, struct field *field, enum store_mode mode, const char *says)
{
	make_older(path, field, true);
	notes = 0;
	struct store *store = open_store(path, mode);
	assert_int_equal(notes, 1);
	assert_non_null(strstr(told, says));
	return store;
}

/* Every post of every plane is the field's. */
static void assert_posts(struct store *store, const struct field *field)
{
	struct store_reader *reader;
	struct store_numbers numbers;
	assert_ok(store_reader_create(store, &reader));
	for (uint32_t y = 0; y < extent_tiles_y(&extent, -1); y++)
		for (uint32_t x = 0; x < extent_tiles_x(&extent, -1); x++) {
			int32_t got[PLANES][POSTS], want[POSTS];
			void *planes[PLANES];
			unsigned present;
			for (int plane = 0; plane < PLANES; plane++)
				planes[plane] = got[plane];
			assert_ok(store_read_deformed(reader, (struct tile){-1, x, y}, (1u << PLANES) - 1, planes, &present));
			for (int plane = 0; plane < PLANES; plane++) {
				field_tile_plane(field, (struct tile){-1, x, y}, (enum plane)plane, want);
				assert_memory_equal(got[plane], want, POSTS * plane_bytes((enum plane)plane));
			}
		}
	assert_ok(store_count(store, &numbers));
	assert_int_equal(numbers.plane_tiles[PLANE_SHEAR], 0);
	assert_true(numbers.plane_tiles[PLANE_PLASTIC_SINKAGE] > 0);
	store_reader_destroy(reader);
}

static void ruts_of_the_version_before_are_read_without_their_shear(void **state)
{
	const char *path = in_folder("ruts.furrow");
	struct field field;
	struct store_check check;
	(void)state;
	struct store *store = open_older(path, &field, STORE_READ, "its shear counts as none");
	assert_posts(store, &field);
	assert_ok(store_verify(store, NULL, NULL, NULL, &check));
	assert_int_equal(check.problems, 0);
	store_close(store);
	assert_int_equal(version_of(path), 3); /* who reads changes nothing */
	field_free(&field);
}

static void who_writes_makes_it_one_of_this_version(void **state)
{
	const char *path = in_folder("write.furrow");
	struct field field;
	struct store_commit_result result;
	(void)state;
	struct store *store = open_older(path, &field, STORE_WRITE, "older furrows cannot read");
	assert_posts(store, &field);
	store_close(store);
	assert_int_equal(version_of(path), STORE_VERSION);
	store = open_store(path, STORE_WRITE);
	assert_int_equal(notes, 1);
	field_dig(&field, 40, 40, 9, 2);
	assert_ok(field_commit(&field, field_all(&field), store, 2, &result));
	verified(store);
	store_close(store);
	field_free(&field);
}

static void an_import_of_the_version_before_is_read_in_silence(void **state)
{
	const char *path = in_folder("base.furrow");
	struct field field;
	(void)state;
	make_older(path, &field, false);
	notes = 0;
	for (int mode = 0; mode < 2; mode++) {
		struct store *store = open_store(path, mode == 0 ? STORE_READ : STORE_WRITE);
		assert_false(store_has_working_level(store, NULL));
		store_close(store);
	}
	assert_int_equal(notes, 0);
	assert_int_equal(version_of(path), STORE_VERSION);
	field_free(&field);
}

/* Version 4 lacks only the history, and who made the last commit. */
static void a_store_of_version_4_is_what_it_was(void **state)
{
	const char *path = in_folder("four.furrow");
	struct field field = field_make(-1);
	struct store_commit_result result;
	struct store_run runs[2];
	make_store(path);
	struct store *store = open_store(path, STORE_WRITE);
	assert_ok(store_set_working_level(store, -1));
	field_dig(&field, 64, 48, 20, 1);
	assert_ok(field_commit(&field, field_all(&field), store, 5, &result));
	store_close(store);
	older_tables(path);
	store = open_store(path, STORE_READ);
	uint64_t hash = content(store); /* without what loose soil is remembered by */
	store_close(store);
	notes = 0;
	for (int mode = 0; mode < 2; mode++) {
		store = open_store(path, mode == 0 ? STORE_READ : STORE_WRITE);
		assert_true(content(store) == hash);
		verified(store);
		assert_ok(store_last_run(store, &runs[mode]));
		assert_int_equal(runs[mode].step, 5);
		store_close(store);
		assert_int_equal(version_of(path), mode == 0 ? 4 : STORE_VERSION);
	}
	store = open_store(path, STORE_WRITE);
	assert_int_equal(store->commit, 1);
	assert_ok(store_snapshot(store, "now"));
	verified(store);
	store_close(store);
	assert_int_equal(notes, 2);
	assert_non_null(strstr(told, "what lies deposited on them counts as loose"));
	field_free(&field);
}

static void without_memory(struct field *field)
{
	for (int plane = PLANE_SETTLED; plane < PLANES; plane++)
		memset(field->planes[plane], 0, (size_t)(field->width * field->height) * plane_bytes((enum plane)plane));
}

/* Versions 5 and 6 remember no loose soil. Version 6 keeps what overlays depend on, version 5 does not. */
static void stores_of_versions_5_and_6_are_read_as_they_were(void **state)
{
	(void)state;
	for (int version = 5; version < 7; version++) {
		const char *path = in_folder(version == 5 ? "five.furrow" : "six.furrow"), *over = in_folder(version == 5 ? "o5.furrow" : "o6.furrow");
		struct field field = field_make(-1);
		struct store_commit_result result;
		make_store(path);
		struct store *store = open_store(path, STORE_WRITE);
		assert_ok(store_set_working_level(store, -1));
		field_dig(&field, 64, 48, 20, 1);
		without_memory(&field);
		assert_ok(field_commit(&field, field_all(&field), store, 5, &result));
		store_close(store);
		assert_ok(store_create_overlay(over, path));
		if (version == 6) { /* the overlay depends on what was there before this */
			store = open_store(path, STORE_WRITE);
			field_dig(&field, 40, 40, 30, 2);
			without_memory(&field);
			assert_ok(field_commit(&field, field_all(&field), store, 6, &result));
			store_close(store);
		}
		tables_of(path, version);
		notes = 0;
		store = open_store(path, STORE_READ);
		const uint64_t hash = content(store);
		verified(store);
		store_close(store);
		assert_int_equal(notes, 1);
		assert_non_null(strstr(told, "what lies deposited on them counts as loose"));
		assert_int_equal(version_of(path), version);
		store = open_store(path, STORE_WRITE);
		assert_true(content(store) == hash);
		verified(store);
		store_close(store);
		assert_int_equal(version_of(path), STORE_VERSION);
		notes = 0;
		store = open_store(path, STORE_WRITE);
		assert_int_equal(notes, 0);
		field_dig(&field, 50, 40, 9, 3);
		assert_ok(field_commit(&field, field_all(&field), store, 7, &result));
		verified(store);
		store_close(store);
		field_free(&field);
	}
}

/* A store of each version is branched. It stays as it is, and keeps what the branch depends on when it is driven. */
static void a_branch_of_an_older_store_stays_what_it_is(void **state)
{
	for (int version = 3; version < 5; version++) {
		const char *path = in_folder(version == 3 ? "b3.furrow" : "b4.furrow"), *over = in_folder(version == 3 ? "o3.furrow" : "o4.furrow");
		struct field field;
		struct store_commit_result result;
		make_older(path, &field, true);
		if (version == 4) {
			store_close(open_store(path, STORE_WRITE));
			older_tables(path);
		}
		assert_ok(store_create_overlay(over, path));
		assert_int_equal(version_of(path), version);
		struct store *store = open_store(over, STORE_READ);
		const uint64_t hash = content(store);
		store_close(store);
		store = open_store(path, STORE_WRITE);
		field_dig(&field, 40, 40, 30, 2);
		assert_ok(field_commit(&field, field_all(&field), store, 2, &result));
		verified(store);
		store_close(store);
		assert_int_equal(version_of(path), STORE_VERSION);
		store = open_store(over, STORE_WRITE);
		assert_true(content(store) == hash);
		verified(store);
		store_close(store);
		field_free(&field);
	}
}

TEST_PROGRAM(older)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_branch_of_an_older_store_stays_what_it_is),
		cmocka_unit_test(ruts_of_the_version_before_are_read_without_their_shear),
		cmocka_unit_test(who_writes_makes_it_one_of_this_version),
		cmocka_unit_test(an_import_of_the_version_before_is_read_in_silence),
		cmocka_unit_test(a_store_of_version_4_is_what_it_was),
		cmocka_unit_test(stores_of_versions_5_and_6_are_read_as_they_were),
	};
	note_to(take_note);
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
