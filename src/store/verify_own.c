/*
 * Checks the rows in an overlay's own file against those that it inherits. All other checks see only the rows that count.
 *
 * A row of zeros is there only to undo an inherited row, and a row that equals the inherited one is never there. So the file depends
 * only on its parent and on the ground that it shows.
 */
#include "store/verify.h"

#include <stdio.h>

static void check_zeros(struct verifying *verifying, struct tile tile, sqlite3_stmt *statement)
{
	struct store *store = verifying->store;
	struct row row = {.tile = tile, .codec = sqlite3_column_int64(statement, 2), .hash = (uint64_t)sqlite3_column_int64(statement, 1),
			  .bytes = sqlite3_column_blob(statement, 3), .size = (size_t)sqlite3_column_bytes(statement, 3)};
	size_t count = verifying->side * verifying->side;
	if (row.bytes == NULL || store_rows_hash(verifying->table, &row) != row.hash ||
	    !store_codec_decode(&store->rows.codec, row.codec, row.bytes, row.size, verifying->posts) ||
	    !store_rows_all_zero(verifying->posts, count))
		store_verify_tell_tile(verifying, tile, "its range is from 0 to 0, and its posts are not");
}

static enum status check_row(struct verifying *verifying, sqlite3_stmt *statement)
{
	struct store *store = verifying->store;
	uint64_t key = (uint64_t)sqlite3_column_int64(statement, 0);
	const struct lineage_entry *entry = store_lineage_find(&store->lineage, (int)verifying->table, key);
	struct tile tile = tile_from_key(key);
	if (entry != NULL && entry->hash == (uint64_t)sqlite3_column_int64(statement, 1))
		store_verify_tell_tile(verifying, tile, "it is the row that it inherits, it should have none of its own");
	bool zeros = sqlite3_column_int(statement, 4) != 0;
	if (zeros)
		check_zeros(verifying, tile, statement);
	if (zeros && entry == NULL)
		store_verify_tell_tile(verifying, tile, "all its posts are zero and it inherits none, it should have no row");
	return STATUS_OK;
}

static enum status check_table(struct verifying *verifying)
{
	struct store *store = verifying->store;
	sqlite3_stmt *statement = NULL;
	char sql[128];
	snprintf(sql, sizeof sql, "SELECT key, hash, codec, blob, low = 0 AND high = 0 FROM %s", store_rows_sql_name(verifying->table));
	enum status status;
	TRY_OR(done, store_sql_prepare(store->db, store->path, &statement, sql));
	int code;
	while ((code = sqlite3_step(statement)) != SQLITE_DONE)
		TRY_OR(done, code == SQLITE_ROW ? check_row(verifying, statement) : store_sql_fail(store->db, code, store->path, "reading its tiles"));
done:
	sqlite3_finalize(statement);
	return status;
}

enum status store_verify_own(struct verifying *verifying)
{
	for (int table = ROW_OFFSET; table < ROW_TABLES; table++) {
		verifying->table = (enum row_table)table;
		TRY(check_table(verifying));
	}
	return STATUS_OK;
}
