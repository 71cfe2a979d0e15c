/* Verify finds each kind of damage, names the tile, and finds none where there is none. */
#include "fixture.h"
#include "../support/program.h"

static char told[64][512];
static int told_count;

static void collect(void *user, const char *text)
{
	if (told_count < 64)
		snprintf(told[told_count++], sizeof told[0], "%s", text);
}

static bool was_told(const char *text)
{
	for (int i = 0; i < told_count; i++)
		if (strstr(told[i], text) != NULL)
			return true;
	return false;
}

static struct store_check check_path(const char *path)
{
	struct store *store = open_store(path, STORE_READ);
	struct store_check check;
	told_count = 0;
	assert_ok(store_verify(store, collect, NULL, NULL, &check));
	assert_true(check.problems >= told_count);
	store_close(store);
	return check;
}

#define assert_told(path, text)                                                                    \
	do {                                                                                       \
		struct store_check check_ = check_path(path);                                      \
		if (check_.problems == 0 || !was_told(text))                                       \
			fail_msg("%lld problems, none says '%s'; the first: %s",                   \
				 (long long)check_.problems, text, told_count > 0 ? told[0] : ""); \
	} while (0)

static const char *deformed_store(const char *name)
{
	const char *path = in_folder(name);
	make_store(path);
	struct store *store = open_store(path, STORE_WRITE);
	assert_ok(store_set_working_level(store, -1));
	struct field field = field_make(-1);
	struct store_commit_result result;
	field_dig(&field, 64, 48, 20, 1); /* over where four tiles meet */
	assert_ok(field_commit(&field, field_all(&field), store, 1, &result));
	verified(store);
	store_close(store);
	field_free(&field);
	return path;
}

/* A row rewritten as only a program that knows hashes would. */
static void edit_row(const char *path, enum row_table table, struct tile tile,
		     void (*edit)(struct row *row, int32_t *posts))
{
	struct store *store = open_store(path, STORE_WRITE);
	int32_t posts[POSTS];
	struct row row;
	bool found;
	assert_ok(store_rows_read(&store->rows, table, tile, posts, &row, &found));
	assert_true(found);
	edit(&row, posts);
	store_rows_encode(&store->rows, table, posts, &row);
	assert_ok(store_rows_put(&store->rows, table, &row));
	store_close(store);
}

static void edit_edge(struct row *row, int32_t *posts)
{
	posts[5 * SIDE + SIDE - 1] += 1;
	store_rows_range(ROW_BASE, posts, POSTS, STEP, &row->low, &row->high);
}

static void edit_first(struct row *row, int32_t *posts)
{
	posts[2 * SIDE + 2] += 1;
}

static void edit_odd(struct row *row, int32_t *posts)
{
	posts[3 * SIDE + 3] += 1;
}

static void edit_low(struct row *row, int32_t *posts)
{
	row->low -= 0.5;
}

static void edit_above(struct row *row, int32_t *posts)
{
	row->above += 1;
}

static void edit_zero(struct row *row, int32_t *posts)
{
	memset(posts, 0, POSTS * sizeof *posts);
	row->low = row->high = 0;
	row->below = row->above = 0;
}

static void edit_big(struct row *row, int32_t *posts)
{
	posts[0] = 256;
}

static void edit_plane_edge(struct row *row, int32_t *posts)
{
	posts[5 * SIDE + SIDE - 1] ^= 1;
	row->low = 0;
	row->high = INT32_MAX; /* not what this is about */
}

static void sql_tile(const char *path, const char *format, struct tile tile)
{
	char sql[512];
	snprintf(sql, sizeof sql, format, (long long)tile_key(tile));
	raw_sql(path, sql);
}

static void a_sound_store_has_no_problem(void **state)
{
	const char *path = deformed_store("sound.furrow");
	struct store_check check = check_path(path);
	assert_int_equal(check.problems, 0);
	assert_int_equal(check.finest, -1);
	assert_int_equal(check.coarsest, extent_coarsest(&extent));
	struct store *store = open_store(path, STORE_READ);
	struct store_numbers numbers;
	assert_ok(store_count(store, &numbers));
	int64_t tiles = numbers.base_tiles;
	for (int plane = 0; plane < PLANES; plane++)
		tiles += numbers.plane_tiles[plane];
	assert_int_equal(check.tiles, tiles);
	store_close(store);
}

static void a_flipped_byte_is_named(void **state)
{
	const char *path = deformed_store("flip.furrow");
	struct tile tiles[] = {{0, 2, 1}, {-1, 3, 2}, {-1, 3, 2}};
	static const char *const names[] = {"base tile level 0 x 2 y 1", "offset tile level -1 x 3 y 2",
					    "dirt tile level -1 x 3 y 2"};
	static const char *const sql[] = {
		"UPDATE base SET blob = CAST(substr(blob, 1, 9) || x'5b' || substr(blob, 11) AS BLOB) "
		"WHERE key = %lld",
		"UPDATE \"offset\" SET blob = CAST(substr(blob, 1, 9) || x'5b' || substr(blob, 11) AS BLOB) "
		"WHERE key = %lld",
		"UPDATE dirt SET blob = CAST(substr(blob, 1, 9) || x'5b' || substr(blob, 11) AS BLOB) "
		"WHERE key = %lld",
	};
	for (int i = 0; i < 3; i++) {
		sql_tile(path, sql[i], tiles[i]);
		assert_told(path, names[i]);
		assert_true(was_told("hash"));
		assert_int_equal(told_count, i + 1); /* once each, and nothing else is blamed */
	}
	struct store *store = open_store(path, STORE_READ);
	struct store_reader *reader;
	int32_t codes[POSTS];
	assert_ok(store_reader_create(store, &reader));
	assert_status(store_read_base(reader, tiles[0], codes, NULL), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), names[0]));
	store_reader_destroy(reader);
	store_close(store);
}

static void a_row_moved_to_another_key_is_found(void **state)
{
	const char *path = deformed_store("moved.furrow");
	char sql[256];
	snprintf(sql, sizeof sql, "UPDATE base SET blob = (SELECT blob FROM base WHERE key = %lld) WHERE key = %lld",
		 (long long)tile_key((struct tile){0, 1, 1}), (long long)tile_key((struct tile){0, 0, 0}));
	raw_sql(path, sql);
	assert_told(path, "base tile level 0 x 0 y 0");
}

static void a_broken_edge_is_found(void **state)
{
	const char *path = deformed_store("edge.furrow");
	edit_row(path, ROW_BASE, (struct tile){0, 1, 1}, edit_edge);
	assert_told(path, "base tile level 0 x 1 y 1: its east edge");
	path = deformed_store("edge2.furrow");
	edit_row(path, ROW_OFFSET, (struct tile){-1, 3, 2}, edit_edge);
	assert_told(path, "offset tile level -1 x 3 y 2: its east edge");
	path = deformed_store("edge3.furrow");
	sql_tile(path, "DELETE FROM \"offset\" WHERE key = %lld", (struct tile){-1, 3, 3});
	assert_told(path, "offset tile level -1 x 3 y 2: its north edge");
	assert_true(was_told("offset tile level -1 x 4 y 3: its west edge"));
}

static void every_plane_s_damage_is_found(void **state)
{
	for (int plane = 0; plane < PLANES; plane++) {
		enum row_table table = row_table_of((enum plane)plane);
		const char *name = plane_name((enum plane)plane);
		struct tile tile = {-1, 3, 2};
		char sql[256], text[128];
		const char *path = deformed_store("planes.furrow");
		edit_row(path, table, tile, edit_plane_edge);
		snprintf(text, sizeof text, "%s tile level -1 x 3 y 2: its east edge", name);
		assert_told(path, text);

		path = deformed_store("planes2.furrow");
		snprintf(sql, sizeof sql, "UPDATE \"%s\" SET blob = blob || x'00' WHERE key = %%lld", name);
		sql_tile(path, sql, tile);
		snprintf(text, sizeof text, "%s tile level -1 x 3 y 2: its hash", name);
		assert_told(path, text);

		path = deformed_store("planes3.furrow");
		snprintf(sql, sizeof sql, "DELETE FROM \"%s\" WHERE key = %%lld", name);
		sql_tile(path, sql, (struct tile){-1, 3, 3});
		snprintf(text, sizeof text, "%s tile level -1 x 3 y 2: its north edge", name);
		assert_told(path, text);

		path = deformed_store("planes4.furrow");
		edit_row(path, table, tile, edit_low);
		snprintf(text, sizeof text, "%s tile level -1 x 3 y 2: its range", name);
		assert_told(path, text);
	}
}

static void a_row_of_another_plane_is_found(void **state)
{
	const char *path = deformed_store("other.furrow");
	char sql[256];
	snprintf(sql, sizeof sql, "DELETE FROM heaped; INSERT INTO heaped SELECT * FROM pressed");
	raw_sql(path, sql);
	assert_told(path, "heaped tile level -1 x 3 y 2: its hash");
}

/* The soil's state has no coarser levels. */
static void state_at_a_coarser_level_is_found(void **state)
{
	const char *path = deformed_store("coarser.furrow");
	struct store *store = open_store(path, STORE_WRITE);
	struct row row = {.tile = {0, 1, 1}, .low = 0, .high = lattice_offset_metres(1)};
	int32_t posts[POSTS] = {[5 * SIDE + 5] = 1};
	store_rows_encode(&store->rows, ROW_PLASTIC_SINKAGE, posts, &row);
	assert_ok(store_rows_put(&store->rows, ROW_PLASTIC_SINKAGE, &row));
	store_close(store);
	assert_told(path, "pressed tile level 0 x 1 y 1: it is coarser than the level that is deformed");
}

static void a_broken_pyramid_is_found(void **state)
{
	const char *path = deformed_store("pyramid.furrow");
	edit_row(path, ROW_BASE, (struct tile){0, 1, 1}, edit_first);
	assert_told(path, "base tile level 1 x 0 y 0: it is not every second post");
	path = deformed_store("pyramid2.furrow");
	edit_row(path, ROW_OFFSET, (struct tile){0, 1, 1}, edit_odd);
	assert_told(path, "offset tile level 0 x 1 y 1: it is not every second post");
	path = deformed_store("pyramid3.furrow");
	edit_row(path, ROW_DISTURBANCE, (struct tile){1, 0, 0}, edit_odd);
	assert_told(path, "dirt tile level 1 x 0 y 0: it is not every second post");
	path = deformed_store("pyramid4.furrow");
	sql_tile(path, "DELETE FROM \"offset\" WHERE key = %lld", (struct tile){1, 0, 0});
	assert_told(path, "there is no tile above it");
	path = deformed_store("pyramid5.furrow");
	raw_sql(path, "DELETE FROM dirt WHERE key < (SELECT max(key) FROM dirt) - 1");
	assert_told(path, "there is no tile below it");
}

static void a_missing_base_tile_is_named(void **state)
{
	const char *path = deformed_store("missing.furrow");
	sql_tile(path, "DELETE FROM base WHERE key = %lld", (struct tile){0, 3, 2});
	assert_told(path, "base tile level 0 x 3 y 2: it is missing");
	struct store *store = open_store(path, STORE_READ);
	struct store_reader *reader;
	int32_t codes[POSTS];
	assert_ok(store_reader_create(store, &reader));
	assert_status(store_read_base(reader, (struct tile){0, 3, 2}, codes, NULL), STATUS_INPUT);
	store_reader_destroy(reader);
	store_close(store);
}

static void a_wrong_range_or_sum_is_found(void **state)
{
	const char *path = deformed_store("range.furrow");
	edit_row(path, ROW_BASE, (struct tile){0, 1, 1}, edit_low);
	assert_told(path, "base tile level 0 x 1 y 1: its range");
	path = deformed_store("range2.furrow");
	edit_row(path, ROW_OFFSET, (struct tile){1, 0, 0}, edit_low);
	assert_told(path, "offset tile level 1 x 0 y 0: its range");
	path = deformed_store("range3.furrow");
	sql_tile(path, "UPDATE base SET low = low - 1 WHERE key = %lld", (struct tile){0, 1, 1});
	assert_told(path, "base tile level 0 x 1 y 1: its hash");
	path = deformed_store("range4.furrow");
	sql_tile(path, "UPDATE base SET low = high + 1 WHERE key = %lld", (struct tile){0, 1, 1});
	assert_told(path, "base tile level 0 x 1 y 1: its range");
	path = deformed_store("range5.furrow");
	raw_sql(path, "UPDATE meta SET value = value + 1.0 WHERE key = 'high'");
	assert_told(path, "header");
	path = deformed_store("identity.furrow");
	raw_sql(path, "UPDATE meta SET value = value + 1 WHERE key = 'base_hash'");
	assert_told(path, "header: its base_hash");
	assert_int_equal(told_count, 1);
	path = deformed_store("sum.furrow");
	edit_row(path, ROW_OFFSET, (struct tile){-1, 3, 2}, edit_above);
	assert_told(path, "offset tile level -1 x 3 y 2: its sums");
}

static void rows_that_do_not_belong_are_found(void **state)
{
	const char *path = deformed_store("zero.furrow");
	edit_row(path, ROW_OFFSET, (struct tile){-1, 3, 2}, edit_zero);
	assert_told(path, "offset tile level -1 x 3 y 2: all its posts are zero");
	path = deformed_store("big.furrow");
	edit_row(path, ROW_DISTURBANCE, (struct tile){-1, 3, 2}, edit_big);
	assert_told(path, "dirt tile level -1 x 3 y 2: it has posts beyond its plane's range");
	path = deformed_store("far.furrow");
	raw_sql(path, "INSERT INTO \"offset\" SELECT key + 1000000, low, high, below, above, codec, revision, hash, "
		      "blob FROM \"offset\" LIMIT 1");
	assert_told(path, "outside the terrain");
	path = deformed_store("none.furrow");
	raw_sql(path, "DELETE FROM meta WHERE key = 'working'");
	assert_told(path, "finer than the level that is deformed");
}

static enum status stop(void *user, int64_t done, int64_t total)
{
	assert_true(done <= total);
	return done == 5 ? STATUS_INTERRUPTED : STATUS_OK;
}

static void it_stops_when_told(void **state)
{
	const char *path = deformed_store("stop.furrow");
	struct store *store = open_store(path, STORE_READ);
	struct store_check check;
	assert_status(store_verify(store, NULL, stop, NULL, &check), STATUS_INTERRUPTED);
	assert_int_equal(check.tiles, 5);
	store_close(store);
}

static void content_is_what_the_rows_mean(void **state)
{
	const char *path = deformed_store("content.furrow");
	struct store *store = open_store(path, STORE_READ);
	uint64_t hash = content(store);
	store_close(store);
	/* Not which epoch wrote them, nor the run's record. */
	raw_sql(path, "UPDATE \"offset\" SET revision = revision + 1; UPDATE run SET step = 99; VACUUM");
	store = open_store(path, STORE_READ);
	assert_true(content(store) == hash);
	store_close(store);
	/* But a post, and what was compacted. */
	for (int plane = 0; plane <= PLANES; plane++) {
		path = deformed_store("content2.furrow");
		if (plane < PLANES)
			edit_row(path, row_table_of((enum plane)plane), (struct tile){-1, 3, 2}, edit_odd);
		else
			raw_sql(path, "INSERT INTO meta(key, value) VALUES('compacted', 1)");
		store = open_store(path, STORE_READ);
		assert_true(content(store) != hash);
		store_close(store);
	}
}

TEST_PROGRAM(verify)
{
	field_marks = true;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_sound_store_has_no_problem),
		cmocka_unit_test(a_flipped_byte_is_named),
		cmocka_unit_test(a_row_moved_to_another_key_is_found),
		cmocka_unit_test(a_broken_edge_is_found),
		cmocka_unit_test(every_plane_s_damage_is_found),
		cmocka_unit_test(a_row_of_another_plane_is_found),
		cmocka_unit_test(state_at_a_coarser_level_is_found),
		cmocka_unit_test(a_broken_pyramid_is_found),
		cmocka_unit_test(a_missing_base_tile_is_named),
		cmocka_unit_test(a_wrong_range_or_sum_is_found),
		cmocka_unit_test(rows_that_do_not_belong_are_found),
		cmocka_unit_test(it_stops_when_told),
		cmocka_unit_test(content_is_what_the_rows_mean),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
