/*
 * Commits: pages of the working level and every coarser level above them, in one transaction.
 *
 *   BEGIN IMMEDIATE -> a climb for the offsets -> one for the disturbance -> the soil's state
 *   -> what was compacted, the run's record -> COMMIT
 *
 * A climb goes down from the coarsest tile to each page, and writes on its way back up. So only one plane of each level is held.
 * The soil's state has no coarser levels (store_state.c).
 *
 * Invariants:
 *   1. A row of a coarser level exists iff a row exists below it. A row of the working level exists iff it is not all zero.
 *   2. The rows written depend only on the working level's new content, never on how it came about.
 *   3. After a failure the file has the content that it had before.
 */
#include "store/internal.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

struct order {
	uint64_t key;
	size_t page;
};

struct climb {
	struct store *store;
	const struct store_page *pages;
	struct order *order; /* the pages, sorted by key */
	enum row_table table;
	int32_t *planes[TILE_LEVEL_MAX - TILE_LEVEL_MIN + 1]; /* one tile of each level; index: level - TILE_LEVEL_MIN */
	const struct store_run *run;
	struct store_commit_result *result;
};

static int order_compare(const void *a, const void *b)
{
	uint64_t x = ((const struct order *)a)->key, y = ((const struct order *)b)->key;
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

static enum status put_page(struct climb *climb, const struct store_page *page, const int32_t **posts)
{
	size_t count = plane_posts(climb->store);
	*posts = page->planes[PLANE_OFFSET];
	if (climb->table == ROW_DISTURBANCE) {
		int32_t *wide;
		enum status status = plane_at(climb, page->tile.level, &wide);
		if (status != STATUS_OK)
			return status;
		const uint8_t *disturbance = page->planes[PLANE_DISTURBANCE];
		for (size_t i = 0; i < count; i++)
			wide[i] = disturbance[i];
		*posts = wide;
	}
	struct row old, row = {.tile = page->tile};
	bool had;
	store_rows_range(climb->table, *posts, count, 0, &row.low, &row.high);
	enum status status = store_rows_head(&climb->store->rows, climb->table, page->tile, &old, &had);
	if (status != STATUS_OK)
		return status;
	return put_row(climb, &row, *posts, !store_rows_all_zero(*posts, count), had ? &old : NULL);
}

static enum status put_parent(struct climb *climb, struct tile tile, const int32_t *posts, const struct row *old)
{
	double low, high;
	int children;
	struct row row = {.tile = tile};
	enum status status = store_rows_under(&climb->store->rows, climb->table, tile, &low, &high, &children);
	if (status != STATUS_OK)
		return status;
	store_rows_range(climb->table, posts, plane_posts(climb->store), 0, &row.low, &row.high);
	if (children > 0) {
		row.low = low < row.low ? low : row.low;
		row.high = high > row.high ? high : row.high;
	}
	return put_row(climb, &row, posts, children > 0, old);
}

enum status store_commit_goes_on(const struct store *store, const struct store_run *run)
{
	if (run->given_up == NULL || !run->given_up(run->user))
		return STATUS_OK;
	return fail_with(STATUS_INTERRUPTED, "%s: a commit was given up; roll back, or commit again", store->path);
}

/* Updates one tile of `level` and the tiles below it. Pages first .. last - 1 of the order lie in this tile. Sets *posts to its new
 * posts, which stay valid until another tile of the level is updated. */
static enum status climb_tile(struct climb *climb, int level, size_t first, size_t last,
			      const int32_t **posts)
{
	const struct store_page *page = &climb->pages[climb->order[first].page];
	enum status going = store_commit_goes_on(climb->store, climb->run);
	if (going != STATUS_OK)
		return going;
	if (level == page->tile.level) {
		assert(last == first + 1); /* each page is in the order once */
		return put_page(climb, page, posts);
	}
	struct tile tile = tile_ancestor(page->tile, level);
	const struct extent *extent = &climb->store->meta.extent;
	int32_t *mine;
	struct row old;
	bool had;
	enum status status = plane_at(climb, level, &mine);
	if (status == STATUS_OK)
		status = store_rows_read(&climb->store->rows, climb->table, tile, mine, &old, &had);
	if (status != STATUS_OK)
		return status;
	if (!had)
		memset(mine, 0, plane_posts(climb->store) * sizeof *mine);
	for (size_t i = first, next; i < last; i = next) {
		struct tile child = tile_ancestor(tile_from_key(climb->order[i].key), level - 1);
		for (next = i + 1; next < last; next++)
			if (!tile_equal(tile_ancestor(tile_from_key(climb->order[next].key), level - 1), child))
				break;
		const int32_t *fine;
		status = climb_tile(climb, level - 1, i, next, &fine);
		if (status != STATUS_OK)
			return status;
		lattice_decimate_i32(fine, extent->cells, child.x & 1, child.y & 1, mine);
	}
	*posts = mine;
	climb->result->coarser += climb->table == ROW_OFFSET;
	return put_parent(climb, tile, mine, had ? &old : NULL);
}

static enum status climb_table(struct store *store, enum row_table table, const struct store_page *pages,
			       size_t count, const struct store_run *run, struct store_commit_result *result)
{
	struct climb climb = {.store = store, .pages = pages, .table = table, .run = run, .result = result};
	size_t with = 0;
	climb.order = mem_alloc(count, sizeof *climb.order);
	if (climb.order == NULL)
		return fail_memory("a commit");
	for (size_t i = 0; i < count; i++)
		if (pages[i].planes[row_plane(table)] != NULL)
			climb.order[with++] = (struct order){tile_key(pages[i].tile), i};
	enum status status = STATUS_OK;
	if (with > 0) {
		const int32_t *top;
		qsort(climb.order, with, sizeof *climb.order, order_compare);
		status = climb_tile(&climb, extent_coarsest(&store->meta.extent), 0, with, &top);
	}
	for (size_t i = 0; i < sizeof climb.planes / sizeof *climb.planes; i++)
		mem_free(climb.planes[i]);
	mem_free(climb.order);
	return status;
}

static enum status put_run(struct store *store, const struct store_run *run,
			   const struct store_commit_result *result)
{
	const char *state = run->describe != NULL ? run->describe(run->user, result) : run->state;
	if (state == NULL)
		return fail_memory("the run's record");
	return store_run_put(store, run, state);
}

static enum status put_all(struct store *store, const struct store_page *pages, size_t count,
			   const struct store_run *run, struct store_commit_result *result)
{
	enum status status = STATUS_OK;
	if (!store->working_stored && count > 0) {
		status = store_meta_put_integer(store, "working", store->working);
		result->header++;
	}
	if (status == STATUS_OK)
		status = climb_table(store, ROW_OFFSET, pages, count, run, result);
	if (status == STATUS_OK)
		status = climb_table(store, ROW_DISTURBANCE, pages, count, run, result);
	for (int table = ROW_DEPOSITED; table < ROW_TABLES && status == STATUS_OK; table++)
		status = store_state_put(store, (enum row_table)table, pages, count, run, result);
	if (status == STATUS_OK)
		status = store_meta_add_compacted(store, run->compacted);
	result->header += run->compacted != 0;
	if (status == STATUS_OK)
		status = put_run(store, run, result);
	if (status == STATUS_OK)
		status = store_changes_reserve(&store->changes);
	if (status == STATUS_OK)
		status = store_sql_exec(store->db, store->path, "committing", "COMMIT");
	return status;
}

enum status store_commit(struct store *store, const struct store_page *pages, size_t count,
			const struct store_run *run, struct store_commit_result *result)
{
	assert(store->writing && store->has_working);
	for (size_t i = 0; i < count; i++)
		assert(pages[i].tile.level == store->working && extent_has(&store->meta.extent, pages[i].tile) &&
		       pages[i].planes[PLANE_OFFSET] != NULL);
	*result = (struct store_commit_result){.commit = store->commit + 1};
	enum status status = store_sql_begin(store->db, store->path, "beginning a commit");
	if (status != STATUS_OK)
		return status;
	status = put_all(store, pages, count, run, result);
	if (status != STATUS_OK) {
		store_sql_undo(store->db);
		store_changes_drop(&store->changes);
		return status;
	}
	if (count > 0)
		store->working_stored = true;
	store->compacted += run->compacted;
	store->commit++;
	store_changes_commit(&store->changes, store->commit);
	return STATUS_OK;
}
