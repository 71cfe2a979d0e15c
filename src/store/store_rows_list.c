/* Lists the rows of a table in the order of their keys. Of an overlay these are the rows that count, wherever they are. */
#include "store/internal.h"

#include <stdio.h>

struct listing {
	struct rows *rows;
	enum row_table table;
	row_entry_fn fn;
	void *user;
	size_t at, end; /* the inherited rows that are left */
};

/* Calls `fn` for the inherited rows with a key less than `key`. */
static enum status before(struct listing *listing, uint64_t key)
{
	const struct lineage *lineage = listing->rows->lineage;
	for (; listing->at < listing->end; listing->at++) {
		const struct lineage_entry *entry = &lineage->entries[listing->table][listing->at];
		if (entry->key >= key)
			break;
		TRY(listing->fn(listing->user, &(struct row_entry){entry->key, entry->hash, entry->revision, entry->size, entry}));
	}
	return STATUS_OK;
}

static enum status own(struct listing *listing, sqlite3_stmt *statement)
{
	struct row_entry entry = {
		.key = (uint64_t)sqlite3_column_int64(statement, 0),
		.hash = (uint64_t)sqlite3_column_int64(statement, 1),
		.revision = sqlite3_column_int64(statement, 2),
		.size = (uint32_t)sqlite3_column_int64(statement, 3),
	};
	TRY(before(listing, entry.key));
	if (listing->at < listing->end && listing->rows->lineage->entries[listing->table][listing->at].key == entry.key)
		listing->at++; /* this file's row counts */
	bool none = listing->rows->lineage != NULL && sqlite3_column_int(statement, 4) != 0;
	return none ? STATUS_OK : listing->fn(listing->user, &entry);
}

enum status store_rows_each(struct rows *rows, enum row_table table, uint64_t first, uint64_t last, row_entry_fn fn, void *user)
{
	struct listing listing = {.rows = rows, .table = table, .fn = fn, .user = user};
	sqlite3_stmt *statement = NULL;
	char sql[192];
	snprintf(sql, sizeof sql, "SELECT key, hash, revision, length(blob), low = 0 AND high = 0 FROM %s "
		 "WHERE key BETWEEN ?1 AND ?2 ORDER BY key", store_rows_sql_name(table));
	enum status status = STATUS_OK;
	int code;
	TRY(store_sql_prepare(rows->db, rows->path, &statement, sql));
	if (rows->lineage != NULL) {
		listing.at = store_lineage_from(rows->lineage, table, first);
		listing.end = store_lineage_from(rows->lineage, table, last + 1);
	}
	sqlite3_bind_int64(statement, 1, (sqlite3_int64)first);
	sqlite3_bind_int64(statement, 2, (sqlite3_int64)last);
	while ((code = sqlite3_step(statement)) != SQLITE_DONE)
		TRY_OR(done, code == SQLITE_ROW ? own(&listing, statement) : store_sql_fail(rows->db, code, rows->path, "reading its tiles"));
done:
	sqlite3_finalize(statement);
	TRY(status);
	return before(&listing, UINT64_MAX);
}

struct counting {
	int64_t rows, bytes;
};

static enum status count_one(void *user, const struct row_entry *entry)
{
	struct counting *counting = user;
	counting->rows++;
	counting->bytes += entry->size;
	return STATUS_OK;
}

enum status store_rows_count(struct rows *rows, enum row_table table, int64_t *count, int64_t *bytes)
{
	struct counting counting = {0};
	enum status status = store_rows_each(rows, table, 0, INT64_MAX, count_one, &counting);
	*count = counting.rows;
	*bytes = counting.bytes;
	return status;
}
