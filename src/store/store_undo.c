/*
 * Sets a mark in a store, and rolls the store back to that mark. The undo is a set of tables with the old rows.
 *
 *   store_mark -> commits, each of which keeps rows in the undo -> store_rollback -> as after the mark
 *
 * A commit keeps a row in the undo before it changes it for the first time since the mark. A rollback puts all of them back in one
 * transaction of the store. The undo has the store's tables. A row with the codec NONE says that there was no row. The mark itself
 * keeps the run's record and the header's entries.
 *
 * Invariants:
 *   1. A row in the undo is as it was at the mark. The undo has every row that the store's commits changed since then. It may have
 *      more rows, from a commit that failed; they do no harm.
 *   2. A row is in the undo before the store commits a change of it.
 *   3. A row that is put back gets a revision that was never used.
 */
#include "store/internal.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#define NONE (-1) /* codec */
#define CACHE_PRAGMA "PRAGMA cache_size=-4096" /* KiB */

static const char name[] = "what is kept for a rollback";

void store_undo_destroy(struct undo *undo)
{
	if (undo == NULL)
		return;
	sqlite3 *db = undo->rows.db;
	store_rows_finish(&undo->rows);
	sqlite3_close(db);
	store_run_copy_finish(&undo->run);
	mem_free(undo);
}

static enum status create(const struct extent *extent, struct undo **out)
{
	struct undo *undo = mem_calloc(1, sizeof *undo);
	TRY_MEM(undo, "a mark");
	undo->rows = (struct rows){.path = name, .extent = extent};
	int flags = SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE | SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
	int code = sqlite3_open_v2("", &undo->rows.db, flags, NULL);
	enum status status;
	if (code != SQLITE_OK)
		TRY_OR(failed, store_sql_fail(undo->rows.db, code, name, "making it"));
	TRY_OR(failed, store_sql_exec(undo->rows.db, name, "making it", "PRAGMA page_size=16384; PRAGMA journal_mode=MEMORY; " CACHE_PRAGMA));
	TRY_OR(failed, store_schema_create(undo->rows.db, name));
	*out = undo;
	return STATUS_OK;
failed:
	store_undo_destroy(undo);
	return status;
}

/* Removes all kept rows in one transaction. */
static enum status empty(struct undo *undo)
{
	enum status status;
	TRY_OR(failed, store_sql_begin(undo->rows.db, name, "emptying it"));
	TRY_OR(failed, store_sql_exec(undo->rows.db, name, "emptying it",
				      "DELETE FROM \"offset\"; DELETE FROM dirt; DELETE FROM heaped; "
				      "DELETE FROM pressed; DELETE FROM shear; DELETE FROM dug; "
				      "DELETE FROM settled; DELETE FROM loose; DELETE FROM floor; DELETE FROM density; DELETE FROM slope; "
				      "DELETE FROM healed; DELETE FROM risen; DELETE FROM grown; COMMIT"));
	undo->kept = 0;
	return STATUS_OK;
failed:
	store_sql_undo(undo->rows.db);
	return status;
}

enum status store_mark(struct store *store)
{
	assert(store->writing);
	struct store_run_copy run = {0};
	int64_t has_compacted = 0;
	enum status status;
	TRY(store_part_refuse(store, "rolled back"));
	if (store->undo == NULL)
		TRY(create(&store->meta.extent, &store->undo));
	TRY_OR(failed, store_run_copy(store, &run));
	TRY_OR(failed, store_sql_integer(store->db, store->path, "SELECT count(*) FROM meta WHERE key = 'compacted'", &has_compacted));
	TRY_OR(failed, empty(store->undo));
	struct undo *undo = store->undo;
	store_run_copy_finish(&undo->run);
	undo->run = run;
	undo->commit = store->commit;
	undo->working_stored = store->working_stored;
	undo->has_compacted = has_compacted != 0;
	undo->compacted = store->compacted;
	store->marked = true;
	return STATUS_OK;
failed:
	store_run_copy_finish(&run);
	return status;
}

enum status store_undo_keep(struct store *store, enum plane plane, struct tile tile, bool had)
{
	struct undo *undo = store->undo;
	enum row_table table = row_table_of(plane);
	struct row row;
	bool kept;
	store_sql_undo(undo->rows.db); /* an emptying that failed, and that could not be undone then */
	TRY(store_rows_head(&undo->rows, table, tile, &row, &kept));
	if (kept)
		return STATUS_OK;
	row = (struct row){.tile = tile, .codec = NONE, .bytes = "", .size = 0};
	TRY(had ? store_rows_copy(&store->rows, &undo->rows, table, tile, store->commit) : store_rows_put(&undo->rows, table, &row));
	undo->kept++;
	return STATUS_OK;
}

/* --- back --- */

static enum status put_back_row(struct store *store, enum row_table table, struct tile tile)
{
	struct rows *rows = &store->undo->rows;
	struct row row;
	bool found = false;
	if (extent_has(rows->extent, tile))
		TRY(store_rows_head(rows, table, tile, &row, &found));
	if (!found)
		return fail_with(STATUS_INPUT, "%s: it is damaged", name);
	if (tile.level == store->working)
		TRY(store_changes_note(&store->changes, tile_key(tile)));
	TRY(store_pinned_keep(store, (int)table, tile_key(tile)));
	TRY(store_history_before(store, table, tile));
	TRY(row.codec == NONE ? store_rows_drop(&store->rows, table, tile, store->commit + 1)
			      : store_rows_copy(rows, &store->rows, table, tile, store->commit + 1));
	return store_history_after_read(store, table, tile);
}

static enum status put_back_table(struct store *store, enum row_table table, int64_t *rows)
{
	struct undo *undo = store->undo;
	sqlite3_stmt *statement = NULL;
	char keys[64];
	snprintf(keys, sizeof keys, "SELECT key FROM %s", store_rows_sql_name(table));
	enum status status;
	TRY_OR(done, store_sql_prepare(undo->rows.db, name, &statement, keys));
	int code;
	while ((code = sqlite3_step(statement)) != SQLITE_DONE) {
		struct tile tile = tile_from_key((uint64_t)sqlite3_column_int64(statement, 0));
		++*rows;
		TRY_OR(done, code == SQLITE_ROW ? put_back_row(store, table, tile) : store_sql_fail(undo->rows.db, code, name, "reading it"));
	}
done:
	sqlite3_finalize(statement);
	return status;
}

static enum status put_back_header(struct store *store)
{
	const struct undo *undo = store->undo;
	if (!undo->working_stored)
		TRY(store_meta_drop(store, "working"));
	if (!undo->working_stored && !store->history.has_level)
		TRY(store_meta_drop(store, "relief"));
	return undo->has_compacted ? store_meta_put_integer(store, "compacted", undo->compacted) : store_meta_drop(store, "compacted");
}

/* Not the store's fault: the temporary file's, or the memory's. */
static enum status cannot(const struct store *store)
{
	struct failure failure;
	failure_capture(&failure, STATUS_INPUT);
	char *advice = strstr(failure.message, "; ");
	if (advice != NULL)
		*advice = '\0';
	return fail_with(STATUS_FAILED, "%s: it cannot be rolled back: %s; go on from its last commit", store->path,
			 failure.message);
}

static enum status put_back_rows(struct store *store)
{
	int64_t rows = 0;
	for (int table = ROW_OFFSET; table < ROW_TABLES; table++)
		TRY(put_back_table(store, (enum row_table)table, &rows));
	return rows == store->undo->kept ? STATUS_OK : fail_with(STATUS_INPUT, "%s: rows are missing", name);
}

static enum status put_back(struct store *store)
{
	TRY(store_history_begin(store, false));
	enum status status = put_back_rows(store);
	TRY(status == STATUS_INPUT ? cannot(store) : status);
	TRY(put_back_header(store));
	TRY(store_run_put_back(store, &store->undo->run, "rollback"));
	TRY(store_changes_reserve(&store->changes));
	return store_sql_exec(store->db, store->path, "rolling it back", "COMMIT");
}

enum status store_rollback(struct store *store)
{
	assert(store->writing && store->marked);
	struct undo *undo = store->undo;
	if (store->commit == undo->commit)
		return STATUS_OK; /* no commit since */
	store_sql_undo(undo->rows.db);
	TRY(store_sql_begin(store->db, store->path, "rolling it back"));
	TRY(store_history_end(store, put_back(store)));
	store->commit++;
	store_changes_commit(&store->changes, store->commit);
	undo->commit = store->commit;
	store->working_stored = undo->working_stored;
	store->compacted = undo->compacted;
	/* If that fails it keeps rows too many: they are what they were at the mark still (1). */
	enum status emptied = empty(undo);
	(void)emptied;
	return STATUS_OK;
}
