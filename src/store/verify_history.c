/* Checks the history of a store: each row's hash and posts, its place, its label, and the revisions that snapshots name. */
#include "store/verify.h"

static enum status check_row(struct verifying *verifying, sqlite3_stmt *statement)
{
	struct store *store = verifying->store;
	struct history_row row = {
		.table = (enum row_table)sqlite3_column_int(statement, 0),
		.key = (uint64_t)sqlite3_column_int64(statement, 1),
		.revision = sqlite3_column_int64(statement, 2),
		.form = sqlite3_column_int64(statement, 3),
		.codec = sqlite3_column_int64(statement, 4),
		.bytes = sqlite3_column_blob(statement, 6),
		.size = (size_t)sqlite3_column_bytes(statement, 6),
	};
	struct tile tile = tile_from_key(row.key);
	const char *wrong = NULL;
	bool claim = row.table == PART_CLAIM && store->part.count > 0;
	if ((row.table < ROW_OFFSET && !claim) || row.table >= ROW_TABLES || tile_key(tile) != row.key || !extent_has(&store->meta.extent, tile) ||
	    tile.level != store->history.level)
		wrong = "it is of no tile of the level that is deformed";
	else if (row.bytes == NULL || store_history_hash(&row) != (uint64_t)sqlite3_column_int64(statement, 5))
		wrong = "its hash is wrong";
	else if ((row.form != 0 && row.form != 1) || !store_codec_decode(&store->rows.codec, row.codec, row.bytes, row.size, verifying->posts))
		wrong = "it cannot be decoded";
	else if (claim && (row.revision <= store->parent_revision || row.revision > store->commit))
		wrong = "it is of no commit of this part";
	else if (!claim && sqlite3_column_int(statement, 7) == 0)
		wrong = "its revision is not kept";
	if (wrong != NULL)
		store_verify_tell(verifying, "history of revision %lld, level %d x %u y %u: %s", (long long)row.revision, tile.level, tile.x, tile.y, wrong);
	return STATUS_OK;
}

static enum status check_rows(struct verifying *verifying)
{
	struct store *store = verifying->store;
	sqlite3_stmt *statement = NULL;
	enum status status = STATUS_OK;
	int code;
	TRY(store_sql_prepare(store->db, store->path, &statement,
			      "SELECT plane, key, revision, form, codec, hash, blob, "
			      "EXISTS (SELECT 1 FROM revision WHERE revision.revision = history.revision) FROM history"));
	while ((code = sqlite3_step(statement)) != SQLITE_DONE)
		TRY_OR(done, code == SQLITE_ROW ? check_row(verifying, statement) : store_sql_fail(store->db, code, store->path, "reading its history"));
done:
	sqlite3_finalize(statement);
	return status;
}

enum status store_verify_history(struct verifying *verifying)
{
	struct store *store = verifying->store;
	int64_t lost = 0;
	TRY(check_rows(verifying));
	TRY(store_sql_integer(store->db, store->path, "SELECT count(*) FROM snapshot WHERE revision NOT IN (SELECT revision FROM revision)", &lost));
	if (lost > 0)
		store_verify_tell(verifying, "history: %lld snapshots name revisions that are not kept", (long long)lost);
	return STATUS_OK;
}
