/*
 * The soil's state in a commit: deposited thickness, plastic sinkage, shear, what slip dug. It has rows at the working level only, without coarser
 * levels, since nothing draws it.
 *
 * If a page lacks a plane of the state, a model changed it that does not keep this plane. The plane's row describes ground that no
 * longer exists, so it is dropped. Posts that neighbouring tiles share with it become zero, so a shared post still has one value.
 *
 * Invariants:
 *   1. A row exists iff it is not all zero.
 *   2. Before rows of a table are dropped, the table is asked once whether it has any. It is not asked if the store was never
 *      deformed.
 */
#include "store/internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct state {
	struct store *store;
	enum row_table table;
	uint64_t *dropped; /* keys of pages without the plane, sorted */
	size_t drop_count;
	int32_t *posts;
	struct store_commit_result *result;
};

static int compare_keys(const void *a, const void *b)
{
	uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
	return x < y ? -1 : x > y;
}

static bool is_dropped(const struct state *state, struct tile tile)
{
	uint64_t key = tile_key(tile);
	return bsearch(&key, state->dropped, state->drop_count, sizeof key, compare_keys) != NULL;
}

enum status store_state_put_tile(struct store *store, enum row_table table, struct tile tile, const int32_t *posts,
				 struct store_commit_result *result)
{
	struct rows *rows = &store->rows;
	size_t side = tile_posts(rows->extent), count = side * side;
	struct row old, row = {.tile = tile};
	bool had;
	TRY(store_rows_head(rows, table, tile, &old, &had));
	result->looked_up[row_plane(table)]++;
	if (store_rows_all_zero(posts, count))
		return had ? store_change_drop(store, table, &old, result) : STATUS_OK;
	store_rows_range(table, posts, count, 0, &row.low, &row.high);
	return store_change_write(store, table, posts, &row, had ? &old : NULL, result);
}

/* Writes state->posts as the tile's row. */
static enum status put_posts(struct state *state, struct tile tile)
{
	return store_state_put_tile(state->store, state->table, tile, state->posts, state->result);
}

static enum status put_page(struct state *state, const struct store_page *page)
{
	enum plane plane = row_plane(state->table);
	size_t side = tile_posts(state->store->rows.extent), count = side * side;
	const void *texels = page->planes[plane];
	memcpy(state->posts, texels, count * sizeof *state->posts);
	return put_posts(state, page->tile);
}

/* Sets to zero, in state->posts, the posts that `tile` shares with its neighbour at dx, dy. */
static void clear_shared(const struct state *state, int dx, int dy)
{
	size_t side = tile_posts(state->store->rows.extent);
	size_t x0 = dx > 0 ? side - 1 : 0, x1 = dx < 0 ? 1 : side;
	size_t y0 = dy > 0 ? side - 1 : 0, y1 = dy < 0 ? 1 : side;
	for (size_t y = y0; y < y1; y++)
		memset(state->posts + y * side + x0, 0, (x1 - x0) * sizeof *state->posts);
}

/* Corrects a tile beside a dropped one: sets to zero all posts that it shares with dropped tiles. */
static enum status trim(struct state *state, struct tile tile)
{
	struct rows *rows = &state->store->rows;
	struct row row;
	bool found;
	TRY(store_rows_read(rows, state->table, tile, state->posts, &row, &found));
	state->result->looked_up[row_plane(state->table)]++;
	if (!found)
		return STATUS_OK;
	for (int at = 0; at < 9; at++) {
		int dx = at % 3 - 1, dy = at / 3 - 1;
		struct tile other = {tile.level, tile.x + (uint32_t)dx, tile.y + (uint32_t)dy};
		if (extent_has(rows->extent, other) && is_dropped(state, other))
			clear_shared(state, dx, dy);
	}
	return put_posts(state, tile);
}

static enum status drop(struct state *state, struct tile tile)
{
	struct rows *rows = &state->store->rows;
	struct row row;
	bool had;
	TRY(store_rows_head(rows, state->table, tile, &row, &had));
	state->result->looked_up[row_plane(state->table)]++;
	if (!had)
		return STATUS_OK; /* what others share with it is zero then */
	TRY(store_change_drop(state->store, state->table, &row, state->result));
	for (int at = 0; at < 9; at++) {
		struct tile other = {tile.level, tile.x + (uint32_t)(at % 3 - 1), tile.y + (uint32_t)(at / 3 - 1)};
		if (extent_has(rows->extent, other) && !is_dropped(state, other))
			TRY(trim(state, other));
	}
	return STATUS_OK;
}

/* Looks once if the table has rows from an earlier drive. */
static enum status ask_for_rows(struct store *store, enum row_table table, struct store_commit_result *result)
{
	char sql[64];
	int64_t any = 0;
	if (store->state_rows[table] != STATE_UNKNOWN)
		return STATUS_OK;
	if (store->working_stored) {
		snprintf(sql, sizeof sql, "SELECT EXISTS (SELECT 1 FROM %s)", store_rows_sql_name(table));
		TRY(store_sql_integer(store->db, store->path, sql, &any));
		result->looked_up[row_plane(table)]++;
	}
	any += store->lineage.count[table] != 0;
	store->state_rows[table] = any != 0 ? STATE_MAYBE : STATE_NONE;
	return STATUS_OK;
}

static bool all_lack(enum plane plane, const struct store_page *pages, size_t count)
{
	for (size_t i = 0; i < count; i++)
		if (pages[i].planes[plane] != NULL)
			return false;
	return true;
}

enum status store_state_put(struct store *store, enum row_table table, const struct store_page *pages, size_t count,
			    const struct store_run *run, struct store_commit_result *result)
{
	size_t side = tile_posts(&store->meta.extent);
	struct state state = {.store = store, .table = table, .result = result};
	if (count == 0)
		return STATUS_OK;
	if (all_lack(row_plane(table), pages, count)) {
		enum status asked = ask_for_rows(store, table, result);
		if (asked != STATUS_OK || store->state_rows[table] == STATE_NONE)
			return asked;
	} else {
		store->state_rows[table] = STATE_MAYBE;
	}
	state.dropped = mem_alloc(count + 1, sizeof *state.dropped);
	state.posts = mem_alloc(side * side, sizeof *state.posts);
	enum status status = STATUS_OK;
	if (state.dropped == NULL || state.posts == NULL)
		TRY_OR(done, fail_memory("a commit"));
	for (size_t i = 0; i < count; i++)
		if (pages[i].planes[row_plane(table)] == NULL)
			state.dropped[state.drop_count++] = tile_key(pages[i].tile);
	qsort(state.dropped, state.drop_count, sizeof *state.dropped, compare_keys);
	for (size_t i = 0; i < state.drop_count; i++)
		TRY_OR(done, drop(&state, tile_from_key(state.dropped[i])));
	for (size_t i = 0; i < count; i++) {
		TRY_OR(done, store_commit_goes_on(store, run));
		if (pages[i].planes[row_plane(table)] != NULL)
			TRY_OR(done, put_page(&state, &pages[i]));
	}
done:
	mem_free_all(state.dropped, state.posts);
	return status;
}
