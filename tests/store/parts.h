/* Runs of several parts, and the same commits in one overlay. Tiles go from part to part between commits. */
#ifndef FURROW_TEST_STORE_PARTS_H
#define FURROW_TEST_STORE_PARTS_H

#include "overlay.h"

#define LEVEL -1
enum { PARTS_MOST = 8, TILES_X = 10, TILES_Y = 7, TILES = TILES_X * TILES_Y, SEVERAL = (1u << PLANES) - 1 };

struct run {
	char over[256], copy[256];           /* what the parts are over, and the overlay with the same commits */
	char paths[PARTS_MOST][256];
	struct store *stores[PARTS_MOST], *direct;
	uint32_t count, seed;
	int owners[TILES]; /* of each tile */
	bool moved[TILES]; /* since the last commit */
	struct field field;
	int64_t step;
	const char *scene_hash; /* of the records */
	const struct relief_spec *relief; /* NULL: none */
};

static UNUSED uint32_t run_draw(struct run *run, uint32_t below)
{
	return mix(run->seed++, 5, 55) % below;
}

static UNUSED struct tile run_tile(int i)
{
	return (struct tile){LEVEL, (uint32_t)i % TILES_X, (uint32_t)i / TILES_X};
}

/* --- its files --- */

static UNUSED void run_make_parts(struct run *run)
{
	uint64_t number;
	assert_ok(store_part_run(&number));
	for (uint32_t i = 0; i < run->count; i++) {
		unlink(run->paths[i]);
		assert_ok(store_create_part(run->paths[i], run->over, &(struct store_part){number, i, run->count}));
	}
}

/* Makes an overlay, a copy of it and the parts over the former. `ruts`: commits that both have before. */
static UNUSED struct run run_make(const char *base, uint32_t count, uint32_t seed, int ruts)
{
	struct run run = {.count = count, .seed = seed, .field = field_make(LEVEL), .scene_hash = "abc"};
	struct store *store;
	snprintf(run.over, sizeof run.over, "%s/over.furrow", folder);
	snprintf(run.copy, sizeof run.copy, "%s/copy.furrow", folder);
	unlink(run.over);
	unlink(run.copy);
	assert_ok(store_create_overlay(run.over, base));
	if (ruts > 0) {
		store = open_store(run.over, STORE_WRITE);
		struct store_commit_result result;
		struct store_run record = {.scene_hash = "before", .state = "{}", .compacted = 77};
		assert_ok(store_set_working_level(store, LEVEL));
		for (int i = 0; i < ruts; i++) {
			int64_t x = run_draw(&run, 150), y = run_draw(&run, 100);
			field_dig(&run.field, x, y, 14, run_draw(&run, 1000));
			assert_ok(field_commit(&run.field, field_all(&run.field), store, i, &result));
		}
		assert_ok(store_commit(store, NULL, 0, &record, &result));
		store_close(store);
	}
	copy_file(run.over, run.copy);
	for (uint32_t i = 0; i < count; i++)
		snprintf(run.paths[i], sizeof run.paths[i], "%s/part-%u.furrow", folder, i);
	run_make_parts(&run);
	for (int i = 0; i < TILES; i++)
		run.owners[i] = (int)run_draw(&run, count);
	return run;
}

static UNUSED void run_open(struct run *run)
{
	for (uint32_t i = 0; i < run->count; i++) {
		run->stores[i] = open_store(run->paths[i], STORE_WRITE);
		/* A power cut is not what is tested here. */
		assert_int_equal(sqlite3_exec(run->stores[i]->db, "PRAGMA synchronous=OFF", NULL, NULL, NULL), SQLITE_OK);
		assert_ok(store_set_working_level(run->stores[i], LEVEL));
		assert_ok(store_set_relief(run->stores[i], run->relief, NULL));
	}
	run->direct = open_store(run->copy, STORE_WRITE);
	assert_ok(store_set_working_level(run->direct, LEVEL));
	assert_ok(store_set_relief(run->direct, run->relief, NULL));
}

static UNUSED void run_close(struct run *run)
{
	for (uint32_t i = 0; i < run->count; i++) {
		store_close(run->stores[i]);
		run->stores[i] = NULL;
	}
	store_close(run->direct);
	run->direct = NULL;
}

static UNUSED void run_free(struct run *run)
{
	run_close(run);
	field_free(&run->field);
}

/* --- what it does --- */

/* Changes the field. changed[]: the tiles that a commit must have. */
static UNUSED void run_change(struct run *run, bool changed[TILES])
{
	struct field before = field_make(LEVEL);
	memcpy(before.offset, run->field.offset, (size_t)(before.width * before.height) * sizeof *before.offset);
	int64_t cx = run_draw(run, 150), cy = run_draw(run, 100), radius = 1 + run_draw(run, 24);
	uint32_t what = run_draw(run, 6);
	memset(changed, 0, TILES * sizeof *changed);
	if (what == 0) { /* filled again: rows go */
		field_clear(&run->field);
	} else if (what < 5) {
		field_dig(&run->field, cx, cy, radius, run_draw(run, 1000));
	}
	for (int i = 0; i < TILES; i++) {
		int32_t texels[2][POSTS];
		field_tile_plane(&before, run_tile(i), PLANE_OFFSET, texels[0]);
		field_tile_plane(&run->field, run_tile(i), PLANE_OFFSET, texels[1]);
		changed[i] = memcmp(texels[0], texels[1], sizeof texels[0]) != 0;
	}
	field_free(&before);
}

/* Commits the changed tiles that belong to `owner`; all if it is negative. */
static UNUSED enum status run_commit_as(struct run *run, int owner, const bool changed[TILES], struct store *store)
{
	static int32_t texels[TILES][PLANES][POSTS];
	struct store_page pages[TILES];
	struct store_commit_result result;
	size_t count = 0;
	for (int i = 0; i < TILES; i++) {
		if ((owner >= 0 && run->owners[i] != owner) || !changed[i])
			continue;
		pages[count] = (struct store_page){.tile = run_tile(i)};
		for (int plane = 0; plane < PLANES; plane++) {
			if (!(run->field.carried & PLANE_BIT(plane)))
				continue;
			field_tile_plane(&run->field, run_tile(i), (enum plane)plane, texels[i][plane]);
			pages[count].planes[plane] = texels[i][plane];
		}
		count++;
	}
	const struct store_run record = {
		.scene_hash = run->scene_hash, .step = run->step, .time = (double)run->step / 8, .state = owner < 0 ? "[-1]" : "[1]", .what = "run.yaml",
		.compacted = owner < 0 ? (int64_t)run->count * (run->count - 1) / 2 : owner,
	};
	return store_commit(store, pages, count, &record, &result);
}

/* One step: tiles move, the ground changes, all parts up to `last` commit, and so does the copy if `all` do. */
static UNUSED void run_step(struct run *run, uint32_t last, bool direct)
{
	bool changed[TILES];
	run_change(run, changed);
	for (int i = 0; i < TILES; i++) {
		if (run_draw(run, 5) != 0)
			continue;
		int to = (int)run_draw(run, run->count);
		changed[i] |= to != run->owners[i];
		run->owners[i] = to;
	}
	run->step++;
	for (uint32_t i = 0; i < last; i++)
		assert_ok(run_commit_as(run, (int)i, changed, run->stores[i]));
	if (direct)
		assert_ok(run_commit_as(run, -1, changed, run->direct));
}

/* --- what is gathered --- */

struct described {
	uint32_t parts;
	int64_t step;
};

static UNUSED const char *describe(void *user, const struct store_run *runs, size_t count, const struct store_commit_result *result)
{
	struct described *described = user;
	for (size_t i = 0; i < count; i++) {
		assert_string_equal(runs[i].state, "[1]");
		assert_string_equal(runs[i].what, "run.yaml");
		assert_int_equal(runs[i].step, described->step);
		assert_int_equal(runs[i].compacted, (int64_t)i * described->step);
	}
	assert_int_equal(count, described->parts);
	assert_true(result->commit > 0);
	return "[-1]";
}

/* Gathers the first `count` parts, in the order of their names or against it. */
static UNUSED enum status run_gather(const struct run *run, uint32_t count, int64_t step, struct store_commit_result *result)
{
	const char *parts[PARTS_MOST];
	struct described described = {run->count, step};
	for (uint32_t i = 0; i < count; i++)
		parts[i] = run->paths[run->seed % 2 == 0 ? i : count - 1 - i];
	return store_gather(run->over, parts, count, &(struct store_gathering){.user = &described, .describe = describe}, result);
}

static UNUSED uint64_t hash_at(const char *path)
{
	struct store *store = open_store(path, STORE_READ);
	uint64_t hash = content(store);
	verified(store);
	store_close(store);
	return hash;
}

#endif
