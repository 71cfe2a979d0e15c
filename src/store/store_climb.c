/*
 * Writes tiles of the working level, and every coarser level above them, within a transaction.
 *
 * A climb goes down from the coarsest tile to each tile of the working level, and writes on its way back up. So only one plane of
 * each level is held, however many tiles there are.
 *
 * Invariants:
 *   1. A row of a coarser level exists iff a row exists below it. A row of the working level exists iff it is not all zero.
 *   2. The rows written depend only on the working level's new content, never on how it came about.
 */
#include "store/internal.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

struct climb {
	struct store *store;
	const struct climb_source *source;
	const struct climb_item *items; /* sorted by key */
	enum row_table table;
	int32_t *planes[TILE_LEVEL_MAX - TILE_LEVEL_MIN + 1]; /* one tile of each level; index: level - TILE_LEVEL_MIN */
	const struct store_run *run;
	struct store_commit_result *result;
};

static int item_compare(const void *a, const void *b)
{
	uint64_t x = ((const struct climb_item *)a)->key, y = ((const struct climb_item *)b)->key;
	return x < y ? -1 : x > y;
}

static size_t plane_posts(const struct store *store)
{
	size_t side = tile_posts(&store->meta.extent);
	return side * side;
}

static enum status plane_at(struct climb *climb, int level, int32_t **plane)
{
	int32_t **held = &climb->planes[level - TILE_LEVEL_MIN];
	if (*held == NULL)
		*held = mem_alloc(plane_posts(climb->store), sizeof **held);
	*plane = *held;
	return *held != NULL ? STATUS_OK : fail_memory("a commit");
}

/* Brings one row of the file up to date. If `exists`, writes it with these posts; otherwise deletes it. old: the row that the file
 * has now; NULL: it has none. */
static enum status put_row(struct climb *climb, struct row *row, const int32_t *posts, bool exists,
			   const struct row *old)
{
	struct store *store = climb->store;
	struct store_commit_result *result = climb->result;
	if (climb->table == ROW_OFFSET && exists)
		store_rows_sums(&store->meta.extent, row->tile, posts, &row->below, &row->above);
	if (climb->table == ROW_OFFSET && row->tile.level == store->working) {
		result->below += row->below - (old != NULL ? old->below : 0);
		result->above += row->above - (old != NULL ? old->above : 0);
	}
	if (exists)
		return store_change_write(store, climb->table, posts, row, old, result);
	return old != NULL ? store_change_drop(store, climb->table, old, result) : STATUS_OK;
}

static enum status put_item(struct climb *climb, const struct climb_item *item, const int32_t **posts)
{
	size_t count = plane_posts(climb->store);
	struct tile tile = tile_from_key(item->key);
	int32_t *scratch;
	struct row old, row = {.tile = tile};
	bool had;
	TRY(plane_at(climb, tile.level, &scratch));
	TRY(climb->source->posts(climb->source->user, climb->table, item, scratch, posts));
	TRY(store_rows_head(&climb->store->rows, climb->table, tile, &old, &had));
	store_rows_range(climb->table, *posts, count, 0, &row.low, &row.high);
	return put_row(climb, &row, *posts, !store_rows_all_zero(*posts, count), had ? &old : NULL);
}

static enum status put_parent(struct climb *climb, struct tile tile, const int32_t *posts, const struct row *old)
{
	double low, high;
	int children;
	struct row row = {.tile = tile};
	TRY(store_rows_under(&climb->store->rows, climb->table, tile, &low, &high, &children));
	store_rows_range(climb->table, posts, plane_posts(climb->store), 0, &row.low, &row.high);
	if (children > 0) {
		row.low = low < row.low ? low : row.low;
		row.high = high > row.high ? high : row.high;
	}
	return put_row(climb, &row, posts, children > 0, old);
}

/* Updates one tile of `level` and the tiles below it. Items first .. last - 1 lie in this tile. Sets *posts to its new
 * posts, which stay valid until another tile of the level is updated. */
static enum status climb_tile(struct climb *climb, int level, size_t first, size_t last,
			      const int32_t **posts)
{
	struct tile finest = tile_from_key(climb->items[first].key);
	enum status going = store_commit_goes_on(climb->store, climb->run);
	if (going != STATUS_OK)
		return going;
	if (level == finest.level) {
		assert(last == first + 1); /* each tile is there once */
		return put_item(climb, &climb->items[first], posts);
	}
	struct tile tile = tile_ancestor(finest, level);
	const struct extent *extent = &climb->store->meta.extent;
	int32_t *mine;
	struct row old;
	bool had;
	TRY(plane_at(climb, level, &mine));
	TRY(store_rows_read(&climb->store->rows, climb->table, tile, mine, &old, &had));
	if (!had)
		memset(mine, 0, plane_posts(climb->store) * sizeof *mine);
	for (size_t i = first, next; i < last; i = next) {
		struct tile child = tile_ancestor(tile_from_key(climb->items[i].key), level - 1);
		for (next = i + 1; next < last; next++)
			if (!tile_equal(tile_ancestor(tile_from_key(climb->items[next].key), level - 1), child))
				break;
		const int32_t *fine;
		TRY(climb_tile(climb, level - 1, i, next, &fine));
		lattice_decimate_i32(fine, extent->cells, child.x & 1, child.y & 1, mine);
	}
	*posts = mine;
	climb->result->coarser += climb->table == ROW_OFFSET;
	return put_parent(climb, tile, mine, had ? &old : NULL);
}

enum status store_climb(struct store *store, enum row_table table, struct climb_item *items, size_t count,
			const struct climb_source *source, const struct store_run *run, struct store_commit_result *result)
{
	struct climb climb = {.store = store, .source = source, .items = items, .table = table, .run = run, .result = result};
	const int32_t *top;
	if (count == 0)
		return STATUS_OK;
	qsort(items, count, sizeof *items, item_compare);
	enum status status = climb_tile(&climb, extent_coarsest(&store->meta.extent), 0, count, &top);
	for (size_t i = 0; i < sizeof climb.planes / sizeof *climb.planes; i++)
		mem_free(climb.planes[i]);
	return status;
}
