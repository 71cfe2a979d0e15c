/*
 * Marks and rollbacks: a model that keeps full copies says what the store must be at every point, and which tiles changed
 * after which revision.
 */
#include "marked.h"
#include "../support/program.h"

static void model_reopen(struct model *model)
{
	uint64_t hash = content(model->store);
	struct store_run run;
	assert_ok(store_last_run(model->store, &run));
	bool none = run.scene_hash == NULL;
	store_close(model->store);
	if (none) { /* never deformed: revisions begin again */
		memset(model->changed, 0, sizeof model->changed);
		model->revision = 0;
	}
	model_open(model);
	model->marked = false;
	assert_true(content(model->store) == hash);
}

static void a_rollback_is_the_mark_in_every_row(void **state)
{
	static struct model model;
	for (uint32_t round = 0; round < 4; round++) {
		model = model_make(in_folder("random.furrow"), round * 5000);
		for (int i = 0; i < 60; i++) {
			uint32_t what = draw(&model, 20);
			if (what < 9)
				model_commit(&model);
			else if (what < 10)
				model_compact(&model);
			else if (what < 13)
				model_mark(&model);
			else if (what < 14)
				model_reopen(&model);
			else if (model.marked)
				model_rollback(&model);
			if (i % 4 == 0 || what >= 13)
				assert_as_model(&model);
		}
		assert_int_equal(files_of("random.furrow"), 4); /* with its lock, WAL and index */
		model_free(&model);
		assert_int_equal(files_of("random.furrow"), 1);
	}
}

static void an_overlay_rolls_back_and_its_base_is_not_touched(void **state)
{
	const char *base = in_folder("under.furrow"), *path = in_folder("over.furrow");
	size_t size, then_size;
	make_both(base, path);
	char *bytes = bytes_of(base, &size);
	struct store *store = open_store(path, STORE_WRITE);
	dig(store, 3, 2);
	uint64_t marked = content(store);
	assert_ok(store_mark(store));
	struct field field = field_make(LEVEL);
	struct store_commit_result result;
	field_dig(&field, 75, 50, 40, 4);
	assert_ok(field_commit(&field, around(75, 50, 40), store, 9, &result));
	assert_true(content(store) != marked);
	assert_ok(store_rollback(store));
	assert_true(content(store) == marked);
	verified(store);
	store_close(store);
	char *then = bytes_of(base, &then_size);
	assert_int_equal(size, then_size);
	assert_memory_equal(bytes, then, size);
	free(bytes);
	free(then);
	field_free(&field);
}

/* More than SQLite keeps in memory for it. */
static void much_is_kept_in_a_temporary_file(void **state)
{
	const char *path = in_folder("much.furrow");
	make_store(path);
	struct store *store = open_store(path, STORE_WRITE);
	struct field field = field_make(-3);
	struct store_commit_result result;
	assert_ok(store_set_working_level(store, -3));
	field_dig(&field, 300, 200, 150, 1);
	assert_ok(field_commit(&field, around(300, 200, 150), store, 1, &result));
	assert_true(result.bytes_written > 800 * 1000);
	uint64_t marked = content(store);
	assert_ok(store_mark(store));
	for (uint32_t i = 0; i < 3; i++) {
		field_dig(&field, 300, 200, 200, 2 + i);
		assert_ok(field_commit(&field, around(300, 200, 200), store, 2, &result));
	}
	assert_ok(store_rollback(store));
	assert_true(content(store) == marked);
	verified(store);
	store_close(store);
	field_free(&field);
}

TEST_PROGRAM(rollback)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_rollback_is_the_mark_in_every_row),
		cmocka_unit_test(an_overlay_rolls_back_and_its_base_is_not_touched),
		cmocka_unit_test(much_is_kept_in_a_temporary_file),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
