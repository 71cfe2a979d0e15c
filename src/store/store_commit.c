/*
 * Commits: pages of the working level and every coarser level above them, in one transaction.
 *
 *   BEGIN IMMEDIATE -> a climb for the offsets (store_climb.c) -> one for the disturbance -> the soil's state (store_state.c)
 *   -> what was compacted, the run's record -> COMMIT
 *
 * The soil's state has no coarser levels. If the store keeps a history, each row that is replaced goes there (store_history.c).
 *
 * Invariant: after a failure the file has the content that it had before.
 */
#include "store/internal.h"

#include <assert.h>

enum status store_commit_goes_on(const struct store *store, const struct store_run *run)
{
	if (run->given_up == NULL || !run->given_up(run->user))
		return STATUS_OK;
	return fail_with(STATUS_INTERRUPTED, "%s: a commit was given up; roll back, or commit again", store->path);
}

static enum status page_posts(void *user, enum row_table table, const struct climb_item *item, int32_t *scratch, const int32_t **posts)
{
	const struct store_page *page = (const struct store_page *)user + item->index;
	*posts = page->planes[PLANE_OFFSET];
	if (table >= ROW_HEALED)
		*posts = page->planes[row_plane(table)];
	if (table != ROW_DISTURBANCE)
		return STATUS_OK;
	const uint8_t *disturbance = page->planes[PLANE_DISTURBANCE];
	for (size_t i = 0; i < item->posts; i++)
		scratch[i] = disturbance[i];
	*posts = scratch;
	return STATUS_OK;
}

static enum status climb_table(struct store *store, enum row_table table, const struct store_page *pages,
			       size_t count, const struct store_run *run, struct store_commit_result *result)
{
	const struct climb_source source = {(void *)(uintptr_t)pages, page_posts};
	size_t side = tile_posts(&store->meta.extent), with = 0;
	struct climb_item *items = mem_alloc(count, sizeof *items);
	TRY_MEM(items, "a commit");
	for (size_t i = 0; i < count; i++)
		if (pages[i].planes[row_plane(table)] != NULL)
			items[with++] = (struct climb_item){tile_key(pages[i].tile), i, side * side};
	enum status status = store_climb(store, table, items, with, &source, run, result);
	mem_free(items);
	return status;
}

static enum status put_run(struct store *store, const struct store_run *run,
			   const struct store_commit_result *result)
{
	const char *state = run->describe != NULL ? run->describe(run->user, result) : run->state;
	TRY_MEM(state, "the run's record");
	return store_run_put(store, run, state);
}

static enum status put_all(struct store *store, const struct store_page *pages, size_t count,
			   const struct store_run *run, struct store_commit_result *result)
{
	TRY(store_history_begin(store, false));
	if (!store->working_stored && count > 0) {
		TRY(store_meta_put_working(store, store->working, store->relief_text));
		result->header += store->relief_text != NULL ? 2 : 1;
	}
	TRY(climb_table(store, ROW_OFFSET, pages, count, run, result));
	TRY(climb_table(store, ROW_DISTURBANCE, pages, count, run, result));
	for (int table = ROW_HEALED; table <= ROW_GROWN; table++)
		TRY(climb_table(store, (enum row_table)table, pages, count, run, result));
	for (int table = ROW_DEPOSITED; row_is_state((enum row_table)table); table++)
		TRY(store_state_put(store, (enum row_table)table, pages, count, run, result));
	if (store->part.count > 0)
		TRY(store_part_claim(store, pages, count));
	TRY(store_meta_add_compacted(store, run->compacted));
	result->header += run->compacted != 0;
	TRY(put_run(store, run, result));
	TRY(store_changes_reserve(&store->changes));
	return store_sql_exec(store->db, store->path, "committing", "COMMIT");
}

enum status store_commit(struct store *store, const struct store_page *pages, size_t count,
			const struct store_run *run, struct store_commit_result *result)
{
	assert(store->writing && store->has_working);
	for (size_t i = 0; i < count; i++)
		assert(pages[i].tile.level == store->working && extent_has(&store->meta.extent, pages[i].tile) &&
		       pages[i].planes[PLANE_OFFSET] != NULL);
	*result = (struct store_commit_result){.commit = store->commit + 1};
	TRY(store_begin(store));
	TRY(store_place_check(store));
	TRY(store_sql_begin(store->db, store->path, "beginning a commit"));
	TRY(store_history_end(store, put_all(store, pages, count, run, result)));
	if (count > 0 && !store->working_stored) {
		store->working_stored = true;
		store->relief_stored = store->relief_text != NULL;
	}
	store->compacted += run->compacted;
	store->commit++;
	store_changes_commit(&store->changes, store->commit);
	return STATUS_OK;
}
