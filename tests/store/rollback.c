/*
 * Marks and rollbacks: a model that keeps full copies says what the store must be at every point, and which tiles changed
 * after which revision.
 */
#include <signal.h>
#include <sys/wait.h>

#include "overlay.h"

#define LEVEL -1
enum { TILES_X = 10, TILES_Y = 7, TILES = TILES_X * TILES_Y, REVISIONS = 400 };

/* What the store is to be. */
struct content_copy {
	uint64_t hash;
	struct field field;
	struct store_run run; /* scene_hash NULL: none */
	int64_t compacted;
};

struct model {
	char path[256];
	struct store *store;
	struct field field;
	struct content_copy mark;
	bool marked;
	bool since_mark[TILES];
	bool changed[REVISIONS][TILES]; /* by revision */
	int64_t revision, opened;
	int64_t marked_at; /* the revision of the mark, or of the last rollback to it */
	int64_t step, compacted;
	uint32_t seed;
};

static uint32_t draw(struct model *model, uint32_t below)
{
	return mix(model->seed++, 7, 77) % below;
}

static void field_copy(struct field *to, const struct field *from)
{
	for (int plane = 0; plane < PLANES; plane++)
		memcpy(to->planes[plane], from->planes[plane],
		       (size_t)(from->width * from->height) * plane_bytes((enum plane)plane));
}

static void model_open(struct model *model)
{
	model->store = open_store(model->path, STORE_WRITE);
	assert_ok(store_set_working_level(model->store, LEVEL));
	model->opened = model->revision;
}

static struct model model_make(const char *path, uint32_t seed)
{
	struct model model = {.field = field_make(LEVEL), .seed = seed};
	model.mark.field = field_make(LEVEL);
	snprintf(model.path, sizeof model.path, "%s", path);
	make_store(path);
	model_open(&model);
	return model;
}

static void model_free(struct model *model)
{
	store_close(model->store);
	field_free(&model->field);
	field_free(&model->mark.field);
}

static bool tile_same(const struct field *a, const struct field *b, struct tile tile)
{
	bool same = true;
	for (int plane = 0; plane < PLANES; plane++) {
		int32_t texels[2][POSTS] = {{0}};
		field_tile_plane(a, tile, (enum plane)plane, texels[0]);
		field_tile_plane(b, tile, (enum plane)plane, texels[1]);
		same &= memcmp(texels[0], texels[1], sizeof texels[0]) == 0;
	}
	return same;
}

static struct tile tile_at(int i)
{
	return (struct tile){LEVEL, (uint32_t)i % TILES_X, (uint32_t)i / TILES_X};
}

/* --- what is to be found --- */

static enum status note_key(void *user, uint64_t key)
{
	struct tile tile = tile_from_key(key);
	bool *told = (bool *)user + tile.y * TILES_X + tile.x;
	assert_int_equal(tile.level, LEVEL);
	assert_false(*told); /* once */
	*told = true;
	return STATUS_OK;
}

static void assert_changes(struct model *model, int64_t since)
{
	bool told[TILES] = {false};
	int64_t now;
	struct store_reader *reader;
	struct field nothing = field_make(LEVEL);
	assert_ok(store_reader_create(model->store, &reader));
	assert_ok(store_each_changed(reader, since, note_key, told, &now));
	store_reader_destroy(reader);
	assert_int_equal(now, model->revision);
	for (int i = 0; i < TILES; i++) {
		bool want = false;
		for (int64_t revision = since + 1; revision <= model->revision; revision++)
			want |= model->changed[revision][i];
		/* What lost its rows before this opening is forgotten. */
		if (since < model->opened && want && tile_same(&model->field, &nothing, tile_at(i)))
			continue;
		assert_int_equal(told[i], want);
	}
	field_free(&nothing);
}

static void assert_run(struct store *store, const struct store_run *want)
{
	struct store_run run;
	assert_ok(store_last_run(store, &run));
	assert_int_equal(run.scene_hash != NULL, want->scene_hash != NULL);
	if (run.scene_hash == NULL)
		return;
	assert_string_equal(run.scene_hash, want->scene_hash);
	assert_string_equal(run.state, want->state);
	assert_int_equal(run.step, want->step);
	assert_true(run.time == want->time);
}

/* The rows of a store that came to the same ground in one epoch. */
static uint64_t hash_of(const struct field *field, int64_t compacted)
{
	const char *path = in_folder("fresh.furrow");
	make_store(path);
	struct store *store = open_store(path, STORE_WRITE);
	struct store_commit_result result;
	struct store_run run = {.scene_hash = "abc", .state = "{}", .compacted = compacted};
	assert_ok(store_set_working_level(store, LEVEL));
	assert_ok(field_commit(field, field_all(field), store, 1, &result));
	assert_ok(store_commit(store, NULL, 0, &run, &result));
	uint64_t hash = content(store);
	store_close(store);
	return hash;
}

static void assert_as_model(struct model *model)
{
	if (model->revision > 0 && store_has_working_level(model->store, NULL) && model->store->working_stored)
		assert_true(content(model->store) == hash_of(&model->field, model->compacted));
	assert_int_equal(verified(model->store).compacted, model->compacted);
	for (int i = 0; i < 3; i++)
		assert_changes(model, draw(model, (uint32_t)model->revision + 1));
	assert_changes(model, model->opened);
	assert_changes(model, model->revision);
}

/* --- what is done --- */

static void model_commit(struct model *model)
{
	struct field before = field_make(LEVEL);
	struct store_commit_result result;
	struct post_rect rect;
	field_copy(&before, &model->field);
	int64_t cx = draw(model, 150), cy = draw(model, 100);
	if (draw(model, 6) == 0) { /* filled again: rows go */
		field_clear(&model->field);
		rect = field_all(&model->field);
	} else {
		field_dig(&model->field, cx, cy, 1 + draw(model, 20), draw(model, 1000));
		rect = around(cx, cy, 21);
	}
	assert_ok(field_commit(&model->field, rect, model->store, ++model->step, &result));
	model->revision++;
	assert_int_equal(result.commit, model->revision);
	for (int i = 0; i < TILES; i++) {
		bool changed = !tile_same(&before, &model->field, tile_at(i));
		model->changed[model->revision][i] = changed;
		model->since_mark[i] |= changed;
	}
	field_free(&before);
}

static void model_compact(struct model *model)
{
	struct store_commit_result result;
	struct store_run run = {.scene_hash = "abd", .step = ++model->step, .time = 0.125, .state = "[1]"};
	run.compacted = (int64_t)draw(model, 1000) - 500;
	assert_ok(store_commit(model->store, NULL, 0, &run, &result));
	model->compacted += run.compacted;
	model->revision++;
}

static void model_mark(struct model *model)
{
	assert_ok(store_mark(model->store));
	model->marked = true;
	model->mark.hash = content(model->store);
	model->mark.compacted = model->compacted;
	field_copy(&model->mark.field, &model->field);
	assert_ok(store_last_run(model->store, &model->mark.run));
	if (model->mark.run.scene_hash != NULL) {
		static char texts[2][64];
		snprintf(texts[0], sizeof texts[0], "%s", model->mark.run.scene_hash);
		snprintf(texts[1], sizeof texts[1], "%s", model->mark.run.state);
		model->mark.run.scene_hash = texts[0];
		model->mark.run.state = texts[1];
	}
	memset(model->since_mark, 0, sizeof model->since_mark);
	model->marked_at = model->revision;
}

static void model_rollback(struct model *model)
{
	assert_ok(store_rollback(model->store));
	assert_true(content(model->store) == model->mark.hash);
	assert_run(model->store, &model->mark.run);
	if (model->revision != model->marked_at)
		memcpy(model->changed[++model->revision], model->since_mark, sizeof model->since_mark);
	model->marked_at = model->revision;
	memset(model->since_mark, 0, sizeof model->since_mark);
	field_copy(&model->field, &model->mark.field);
	model->compacted = model->mark.compacted;
}

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

static void a_store_that_was_never_deformed_is_that_again(void **state)
{
	static struct model model;
	size_t before, after;
	model = model_make(in_folder("never.furrow"), 9);
	uint64_t fresh = content(model.store);
	model_mark(&model);
	model_rollback(&model); /* nothing to do, no revision */
	assert_int_equal(model.revision, 0);
	model_commit(&model);
	model_compact(&model);
	assert_true(content(model.store) != fresh);
	model_rollback(&model);
	assert_int_equal(model.revision, 3);
	assert_true(content(model.store) == fresh);
	model_commit(&model); /* goes on, and back once more */
	assert_as_model(&model);
	model_rollback(&model);
	assert_int_equal(model.revision, 5);
	assert_true(content(model.store) == fresh);
	assert_ok(store_sql_exec(model.store->db, model.path, "testing", "PRAGMA incremental_vacuum"));
	model_free(&model);
	struct store *store = open_store(model.path, STORE_READ);
	assert_false(store_has_working_level(store, NULL));
	assert_true(content(store) == fresh);
	store_close(store);
	make_store(in_folder("other.furrow"));
	free(bytes_of(model.path, &after));
	free(bytes_of(in_folder("other.furrow"), &before));
	assert_int_equal(after, before);
}

/* Law 7: marks that nothing is rolled back to leave the very bytes that none would. */
static void marks_leave_nothing_in_the_file(void **state)
{
	char *bytes[2];
	size_t sizes[2];
	for (int way = 0; way < 2; way++) {
		const char *path = in_folder("marked.furrow");
		make_store(path);
		struct store *store = open_store(path, STORE_WRITE);
		struct field field = field_make(LEVEL);
		struct store_commit_result result;
		assert_ok(store_set_working_level(store, LEVEL));
		for (int i = 0; i < 6; i++) {
			if (way == 1 && i % 2 == 1)
				assert_ok(store_mark(store));
			field_dig(&field, 20 * i, 50, 15, (uint32_t)i);
			assert_ok(field_commit(&field, around(20 * i, 50, 15), store, i, &result));
		}
		field_free(&field);
		store_close(store);
		bytes[way] = bytes_of(path, &sizes[way]);
	}
	assert_int_equal(sizes[0], sizes[1]);
	assert_memory_equal(bytes[0], bytes[1], sizes[0]);
	free(bytes[0]);
	free(bytes[1]);
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

/* What is kept is damaged: that is told, and the store is what its last commit left. */
static void a_damaged_undo_is_told_and_changes_nothing(void **state)
{
	static const char *const damages[] = {
		"UPDATE \"offset\" SET blob = zeroblob(length(blob)) WHERE codec >= 0",
		"UPDATE \"offset\" SET high = high + 1 WHERE codec >= 0",
		"UPDATE pressed SET low = 7, high = 'much'",
		"UPDATE heaped SET blob = '' WHERE codec >= 0",
		"UPDATE shear SET key = key + 1000000 WHERE key = (SELECT max(key) FROM shear)",
		"UPDATE dirt SET key = -1 WHERE key = (SELECT max(key) FROM dirt)",
		"DELETE FROM pressed WHERE key = (SELECT max(key) FROM pressed)",
		"DROP TABLE heaped",
		"PRAGMA writable_schema=ON; UPDATE sqlite_schema SET rootpage = 1 WHERE name = 'dirt'; PRAGMA writable_schema=RESET",
	};
	for (size_t i = 0; i < sizeof damages / sizeof *damages; i++) {
		static struct model model;
		struct store_check check;
		model = model_make(in_folder("damaged.furrow"), 31);
		model_commit(&model);
		model_mark(&model);
		for (int n = 0; n < 4; n++)
			model_commit(&model);
		uint64_t last = content(model.store);
		assert_int_equal(sqlite3_exec(model.store->undo->rows.db, damages[i], NULL, NULL, NULL), SQLITE_OK);
		if (store_rollback(model.store) != STATUS_FAILED)
			fail_msg("rolled back in spite of %s", damages[i]);
		assert_non_null(strstr(failure_message(), "; "));
		assert_true(content(model.store) == last);
		assert_ok(store_verify(model.store, print_problem, NULL, NULL, &check));
		assert_int_equal(check.problems, 0);
		model_free(&model);
	}
}

/* --- kills --- */

enum { KILL_EPOCHS = 60 };

/* The epoch number that this commits; epoch 1 was before the mark. Every fifth is a rollback. */
static enum status kill_step(struct store *store, struct field *field, struct field *marked, int64_t number)
{
	struct store_commit_result result;
	if (number % 5 == 0) {
		field_copy(field, marked);
		return store_rollback(store);
	}
	int64_t cx = mix((uint32_t)number, 1, 5) % 150, cy = mix((uint32_t)number, 2, 5) % 100;
	field_dig(field, cx, cy, 20, (uint32_t)number);
	enum status status = field_commit(field, around(cx, cy, 20), store, number, &result);
	if (status == STATUS_OK && number == 1) {
		field_copy(marked, field);
		status = store_mark(store);
	}
	return status;
}

static void kill_run(const char *path, int say, uint64_t *hashes)
{
	struct store *store = open_store(path, STORE_WRITE);
	struct field field = field_make(LEVEL), marked = field_make(LEVEL);
	assert_ok(store_set_working_level(store, LEVEL));
	for (int64_t number = 1; number <= KILL_EPOCHS; number++) {
		assert_ok(kill_step(store, &field, &marked, number));
		assert_int_equal(store->commit, number);
		if (hashes != NULL)
			hashes[number] = content(store);
		if (say >= 0 && write(say, &number, sizeof number) != sizeof number)
			_exit(1);
	}
	if (hashes == NULL)
		pause(); /* to be killed */
	store_close(store);
	field_free(&field);
	field_free(&marked);
}

static void a_kill_leaves_the_last_commit_and_nothing_of_the_mark(void **state)
{
	const char *path = in_folder("killed.furrow");
	uint64_t hashes[KILL_EPOCHS + 1];
	make_store(in_folder("twin.furrow"));
	kill_run(in_folder("twin.furrow"), -1, hashes);
	for (int number = 10; number <= KILL_EPOCHS; number += 5)
		assert_true(hashes[number] == hashes[1]);
	for (int round = 0; round < 20; round++) {
		int ends[2];
		make_store(path);
		assert_int_equal(pipe(ends), 0);
		pid_t child = fork();
		assert_true(child >= 0);
		if (child == 0) {
			kill_run(path, ends[1], NULL);
			_exit(0);
		}
		close(ends[1]);
		int64_t number = 0, last = 0;
		int wanted = 2 + 3 * round;
		while (wanted-- > 0 && read(ends[0], &number, sizeof number) == sizeof number)
			last = number;
		usleep((useconds_t)(mix((uint32_t)round, 3, 3) % 3000));
		kill(child, SIGKILL);
		int ended;
		assert_int_equal(waitpid(child, &ended, 0), child);
		while (read(ends[0], &number, sizeof number) == sizeof number)
			last = number;
		close(ends[0]);
		struct store *store = open_store(path, round % 2 ? STORE_WRITE : STORE_READ);
		assert_true(store->commit == last || store->commit == last + 1);
		assert_true(content(store) == hashes[store->commit]);
		verified(store);
		store_close(store);
	}
	store_close(open_store(path, STORE_WRITE));
	assert_int_equal(files_of("killed.furrow"), 1);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_rollback_is_the_mark_in_every_row),
		cmocka_unit_test(a_store_that_was_never_deformed_is_that_again),
		cmocka_unit_test(marks_leave_nothing_in_the_file),
		cmocka_unit_test(an_overlay_rolls_back_and_its_base_is_not_touched),
		cmocka_unit_test(much_is_kept_in_a_temporary_file),
		cmocka_unit_test(a_damaged_undo_is_told_and_changes_nothing),
		cmocka_unit_test(a_kill_leaves_the_last_commit_and_nothing_of_the_mark),
	};
	return cmocka_run_group_tests(tests, folder_make, folder_remove);
}
