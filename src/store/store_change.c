/*
 * Writes and removes rows in a commit. The old row is kept for a rollback and for the history, and the tile is
 * marked as changed.
 *
 * If the new row equals the old row, nothing is written: the row keeps its revision, and the tile counts as unchanged.
 */
#include "store/internal.h"

static enum status begin(struct store *store, enum row_table table, struct tile tile, bool had)
{
	if (store->marked)
		TRY(store_undo_keep(store, row_plane(table), tile, had));
	TRY(store_pinned_keep(store, (int)table, tile_key(tile)));
	TRY(store_history_before(store, table, tile));
	return tile.level == store->working ? store_changes_note(&store->changes, tile_key(tile)) : STATUS_OK;
}

enum status store_change_write(struct store *store, enum row_table table, const int32_t *posts, struct row *row,
			 const struct row *old, struct store_commit_result *result)
{
	row->revision = store->commit + 1;
	store_rows_encode(&store->rows, table, posts, row);
	if (old != NULL && old->hash == row->hash)
		return STATUS_OK;
	TRY(begin(store, table, row->tile, old != NULL));
	TRY(store_rows_put(&store->rows, table, row));
	TRY(store_history_after(store, table, row->tile, posts));
	result->tiles_written++;
	result->changed[row_plane(table)]++;
	result->bytes_written += (int64_t)row->size;
	return STATUS_OK;
}

enum status store_change_drop(struct store *store, enum row_table table, const struct row *old,
			struct store_commit_result *result)
{
	TRY(begin(store, table, old->tile, true));
	TRY(store_rows_drop(&store->rows, table, old->tile, store->commit + 1));
	TRY(store_history_after(store, table, old->tile, NULL));
	result->tiles_written++;
	result->changed[row_plane(table)]++;
	return STATUS_OK;
}
