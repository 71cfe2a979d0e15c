/* What tests of marks and rollbacks share: a model that keeps full copies of what the store must be, and the comparison of both. */
#ifndef FURROW_TESTS_MARKED_H
#define FURROW_TESTS_MARKED_H

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

static inline uint32_t draw(struct model *model, uint32_t below)
{
	return mix(model->seed++, 7, 77) % below;
}

static inline void field_copy(struct field *to, const struct field *from)
{
	for (int plane = 0; plane < PLANES; plane++)
		memcpy(to->planes[plane], from->planes[plane],
		       (size_t)(from->width * from->height) * plane_bytes((enum plane)plane));
}

static inline void model_open(struct model *model)
{
	model->store = open_store(model->path, STORE_WRITE);
	assert_ok(store_set_working_level(model->store, LEVEL));
	model->opened = model->revision;
}

static inline struct model model_make(const char *path, uint32_t seed)
{
	struct model model = {.field = field_make(LEVEL), .seed = seed};
	model.mark.field = field_make(LEVEL);
	snprintf(model.path, sizeof model.path, "%s", path);
	make_store(path);
	model_open(&model);
	return model;
}

static inline void model_free(struct model *model)
{
	store_close(model->store);
	field_free(&model->field);
	field_free(&model->mark.field);
}

static inline bool tile_same(const struct field *a, const struct field *b, struct tile tile)
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

static inline struct tile tile_at(int i)
{
	return (struct tile){LEVEL, (uint32_t)i % TILES_X, (uint32_t)i / TILES_X};
}

/* --- what is to be found --- */

static inline enum status note_key(void *user, uint64_t key)
{
	struct tile tile = tile_from_key(key);
	bool *told = (bool *)user + tile.y * TILES_X + tile.x;
	assert_int_equal(tile.level, LEVEL);
	assert_false(*told); /* once */
	*told = true;
	return STATUS_OK;
}

static inline void assert_changes(struct model *model, int64_t since)
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

static inline void assert_run(struct store *store, const struct store_run *want)
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
static inline uint64_t hash_of(const struct field *field, int64_t compacted)
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

static inline void assert_as_model(struct model *model)
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

static inline void model_commit(struct model *model)
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

static inline void model_compact(struct model *model)
{
	struct store_commit_result result;
	struct store_run run = {.scene_hash = "abd", .step = ++model->step, .time = 0.125, .state = "[1]"};
	run.compacted = (int64_t)draw(model, 1000) - 500;
	assert_ok(store_commit(model->store, NULL, 0, &run, &result));
	model->compacted += run.compacted;
	model->revision++;
}

static inline void model_mark(struct model *model)
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

static inline void model_rollback(struct model *model)
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

#endif
