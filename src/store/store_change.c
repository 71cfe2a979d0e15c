/*
 * Writes and removes rows in a commit. The old row is kept for a rollback and for the history, and the tile is
 * marked as changed.
 *
 * If the new row equals the old row, nothing is written: the row keeps its revision, and the tile counts as unchanged.
 */
#include "store/internal.h"

static enum status begin(struct store *store, enum row_table table, struct tile tile, bool had)
{
	enum status status = STATUS_OK;
	if (store->marked)
		status = store_undo_keep(store, row_plane(table), tile, had);
	if (status == STATUS_OK)
		status = store_pinned_keep(store, (int)table, tile_key(tile));
	if (status == STATUS_OK)
		status = store_history_before(store, table, tile);
	return status == STATUS_OK && tile.level == store->working ? store_changes_note(&store->changes, tile_key(tile)) : status;
}

enum status store_change_write(struct store *store, enum row_table table, const int32_t *posts, struct row *row,
			 const struct row *old, struct store_commit_result *result)
{
	row->revision = store->commit + 1;
	store_rows_encode(&store->rows, table, posts, row);
	if (old != NULL && old->hash == row->hash)
		return STATUS_OK;
	enum status status = begin(store, table, row->tile, old != NULL);
	if (status == STATUS_OK)
		status = store_rows_put(&store->rows, table, row);
	if (status == STATUS_OK)
		status = store_history_after(store, table, row->tile, posts);
	if (status != STATUS_OK)
		return status;
	result->tiles_written++;
	result->changed[row_plane(table)]++;
	result->bytes_written += (int64_t)row->size;
	return STATUS_OK;
}

enum status store_change_drop(struct store *store, enum row_table table, const struct row *old,
			struct store_commit_result *result)
{
	enum status status = begin(store, table, old->tile, true);
	if (status == STATUS_OK)
		status = store_rows_drop(&store->rows, table, old->tile, store->commit + 1);
	if (status == STATUS_OK)
		status = store_history_after(store, table, old->tile, NULL);
	if (status != STATUS_OK)
		return status;
	result->tiles_written++;
	result->changed[row_plane(table)]++;
	return STATUS_OK;
}
