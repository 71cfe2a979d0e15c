/* The relief over which a store was deformed: kept as a text, never as heights; another is refused until a reset. */
#include "fixture.h"
#include "../support/program.h"

#define LEVEL (-2)

static const struct relief_spec one = {.seed = 7, .classes = 1, .waves = {{0.05, 4}}};
static const struct relief_spec other = {.seed = 8, .classes = 1, .waves = {{0.05, 4}}};
static const struct relief_spec classes = {.seed = 7, .classes = 2, .map = {1, 2}, .waves = {{0.05, 4}, {0.1, 2}}};
static const char *const text_of_one = "{\"roughness\":0.05,\"wavelength\":4,\"seed\":7}";

static struct store *open_at(const char *path, const struct relief_spec *spec, bool history, enum status wanted)
{
	struct store *store;
	assert_ok(store_open(path, &(struct store_options){.mode = STORE_WRITE, .keep_history = history}, &store));
	assert_ok(store_set_working_level(store, LEVEL));
	assert_status(store_set_relief(store, spec, NULL), wanted);
	return store;
}

static void dig_at(struct store *store, int64_t x, int64_t y)
{
	static struct field field;
	struct store_commit_result result;
	if (field.offset == NULL)
		field = field_make(LEVEL);
	field_clear(&field);
	field_dig(&field, x, y, 6, (uint32_t)x);
	assert_ok(field_commit(&field, around(x, y, 6), store, store->commit + 1, &result));
}

static void refuse(const char *path, const struct relief_spec *spec)
{
	struct store *store = open_at(path, spec, false, STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "was deformed over relief"));
	store_close(store);
}

static bool text_is(const char *path, const char *text)
{
	struct store *store = open_store(path, STORE_READ);
	const bool same = store_relief_equal(store_relief_text(store), text);
	verified(store);
	store_close(store);
	return same;
}

static void another_relief_is_refused_until_a_reset(void **state)
{
	const char *path = in_folder("plain.furrow");
	make_store(path);
	struct store *store = open_at(path, &one, false, STATUS_OK);
	const uint64_t undeformed = content(store);
	assert_ok(store_set_relief(store, &other, NULL)); /* nothing is deformed yet */
	assert_ok(store_set_relief(store, &one, NULL));
	store_close(store);
	assert_true(text_is(path, NULL)); /* nor was it written */
	store = open_at(path, &one, false, STATUS_OK);
	assert_true(content(store) == undeformed);
	dig_at(store, 100, 80);
	const uint64_t deformed = content(store);
	store_close(store);
	assert_true(text_is(path, text_of_one));
	refuse(path, &other);
	refuse(path, NULL);
	refuse(path, &classes);
	store = open_at(path, &one, false, STATUS_OK);
	assert_true(content(store) == deformed && relief_any(store_relief(store)));
	assert_ok(store_reset(store, true));
	assert_true(content(store) == undeformed);
	assert_ok(store_set_working_level(store, LEVEL));
	assert_ok(store_set_relief(store, NULL, NULL));
	dig_at(store, 100, 80);
	assert_true(content(store) != deformed); /* the same offsets over other ground */
	store_close(store);
	assert_true(text_is(path, NULL));
	refuse(path, &one);
}

/* A rollback and a restore to ground that was never deformed, and what may follow. */
static void it_goes_and_comes_with_what_is_deformed(void **state)
{
	const char *path = in_folder("back.furrow");
	make_store(path);
	struct store *store = open_at(path, &one, false, STATUS_OK);
	assert_ok(store_mark(store));
	dig_at(store, 60, 60);
	assert_ok(store_rollback(store));
	assert_ok(store_set_relief(store, &other, NULL));
	dig_at(store, 60, 60);
	store_close(store);
	refuse(path, &one);
	make_store(path);
	store = open_at(path, &one, true, STATUS_OK);
	int64_t revision;
	dig_at(store, 60, 60);
	dig_at(store, 90, 70);
	const uint64_t two = content(store);
	assert_ok(store_restore(store, "0", &revision));
	assert_false(relief_any(store_relief(store)));
	assert_status(store_set_relief(store, &other, NULL), STATUS_INPUT); /* the history is of that relief */
	store_close(store);
	store = open_at(path, &one, true, STATUS_OK);
	assert_ok(store_restore(store, "2", &revision));
	assert_true(content(store) == two && relief_any(store_relief(store)));
	store_close(store);
	assert_true(text_is(path, text_of_one));
}

static void overlays_have_their_parents_relief(void **state)
{
	char names[6][256];
	static const char *const files[6] = {"base", "child", "flat", "free", "second", "merged"};
	for (int i = 0; i < 6; i++)
		snprintf(names[i], sizeof names[i], "%s/%s.furrow", folder, files[i]);
	const char *path = names[0], *child = names[1], *flat = names[2], *free_one = names[3], *second = names[4], *merged = names[5];
	struct store_conflicts conflicts;
	make_store(path);
	assert_ok(store_create_overlay(free_one, path));
	struct store *store = open_at(free_one, &other, false, STATUS_OK);
	dig_at(store, 40, 40);
	store_close(store);
	store = open_at(path, &one, false, STATUS_OK);
	dig_at(store, 100, 80);
	store_close(store);
	assert_ok(store_create_overlay(child, path));
	assert_true(text_is(child, text_of_one) && !text_is(free_one, text_of_one));
	refuse(child, &other);
	store = open_at(child, &one, false, STATUS_OK);
	dig_at(store, 30, 30);
	const uint64_t both = content(store);
	assert_ok(store_reset(store, true));
	assert_ok(store_set_working_level(store, LEVEL));
	assert_status(store_set_relief(store, &other, NULL), STATUS_INPUT);
	assert_ok(store_set_relief(store, &one, NULL));
	dig_at(store, 30, 30);
	assert_true(content(store) == both);
	store_close(store);
	assert_ok(store_flatten(child, flat, false, NULL, NULL));
	assert_true(text_is(flat, text_of_one));
	refuse(flat, &other);
	assert_status(store_merge(child, free_one, merged, &conflicts), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "another relief"));
	/* Two of one relief. */
	assert_ok(store_create_overlay(second, path));
	store = open_at(second, &one, false, STATUS_OK);
	dig_at(store, 130, 20);
	store_close(store);
	assert_ok(store_merge(child, second, merged, &conflicts));
	assert_true(text_is(merged, text_of_one));
}

/* Readers without a scene see the ground that was driven on; by class they do not know it. */
static void readers_add_it(void **state)
{
	const char *path = in_folder("read.furrow");
	struct post_rect rect = {40, 40, 73, 73};
	double flat[33 * 33], raised[33 * 33];
	int32_t heights[33 * 33];
	make_store(path);
	for (int round = 0; round < 2; round++) {
		struct store *store = open_at(path, round == 0 ? &one : &classes, false, STATUS_OK);
		struct store_reader *reader;
		struct relief relief;
		dig_at(store, 200, 150);
		assert_ok(store_reader_create(store, &reader));
		assert_true(relief_any(store_relief(store)) == (round == 0));
		assert_ok(store_read_posts(reader, STORE_SURFACE, LEVEL, rect, raised));
		relief_make(&one, store->meta.extent.spacing, LEVEL, &relief);
		assert_ok(relief_heights(&relief, LEVEL, 0, rect, heights));
		store_reader_destroy(reader);
		assert_ok(store_reset(store, true));
		assert_ok(store_reader_create(store, &reader));
		assert_ok(store_read_posts(reader, STORE_SURFACE, LEVEL, rect, flat));
		int differ = 0;
		for (int i = 0; i < 33 * 33; i++) {
			assert_true(isnan(flat[i]) ? isnan(raised[i]) : raised[i] == flat[i] + (round == 0 ? lattice_base_metres(heights[i]) : 0));
			differ += !isnan(flat[i]) && raised[i] != flat[i];
		}
		assert_true(round == 0 ? differ > 500 : differ == 0);
		store_reader_destroy(reader);
		store_close(store);
	}
}

static void a_wrong_text_is_refused(void **state)
{
	static const char *const texts[] = {"''", "'{}'", "7", "x'00'", "'{\"roughness\":1e9,\"wavelength\":2,\"seed\":1}'", "hex(zeroblob(9000))"};
	for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
		const char *path = in_folder("wrong.furrow");
		struct store *store;
		char sql[160];
		make_store(path);
		snprintf(sql, sizeof sql, "INSERT INTO meta VALUES('working', -2); INSERT INTO meta VALUES('relief', %s)", texts[i]);
		raw_sql(path, sql);
		for (int mode = STORE_READ; mode <= STORE_WRITE; mode++) {
			assert_status(store_open(path, &(struct store_options){.mode = (enum store_mode)mode}, &store), STATUS_INPUT);
			assert_non_null(strstr(failure_message(), "relief"));
		}
	}
}

TEST_PROGRAM(relief)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(another_relief_is_refused_until_a_reset),
		cmocka_unit_test(it_goes_and_comes_with_what_is_deformed),
		cmocka_unit_test(overlays_have_their_parents_relief),
		cmocka_unit_test(readers_add_it),
		cmocka_unit_test(a_wrong_text_is_refused),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
