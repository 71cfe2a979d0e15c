/* Checks what a store keeps for overlays: each pinned revision has the hash that overlays name, and each of its rows has its own. */
#include "store/verify.h"

struct checking {
	struct verifying *verifying;
	struct store *then; /* the store as it was at the revision */
	enum row_table table;
};

static enum status has_bytes(void *user, const struct row *row)
{
	return STATUS_OK;
}

static enum status check_row(void *user, const struct row_entry *entry)
{
	struct checking *checking = user;
	if (entry->inherited != NULL)
		return STATUS_OK; /* of another file */
	return store_rows_bytes(&checking->then->rows, checking->table, tile_from_key(entry->key), has_bytes, checking);
}

static enum status check_revision(struct checking *checking, uint64_t hash)
{
	uint64_t found = 0;
	struct store *then = checking->then;
	TRY(store_lineage_state(then, &found));
	if (found != hash)
		store_verify_tell(checking->verifying, "what overlays depend on at revision %lld: its hash is not the one that they name", (long long)then->commit);
	for (int table = ROW_OFFSET; table < ROW_TABLES; table++) {
		checking->table = (enum row_table)table;
		TRY(store_rows_each(&then->rows, checking->table, 0, INT64_MAX, check_row, checking));
	}
	return STATUS_OK;
}

/* A revision that cannot be read is told. It is no failure. */
static enum status check_pin(struct verifying *verifying, int64_t revision, uint64_t hash)
{
	struct checking checking = {.verifying = verifying};
	enum status status;
	TRY_OR(done, store_open_state(verifying->store->path, hash, &checking.then));
	TRY_OR(done, check_revision(&checking, hash));
done:
	store_close(checking.then);
	if (status != STATUS_INPUT)
		return status;
	store_verify_tell(verifying, "what overlays depend on at revision %lld: %s", (long long)revision, failure_message());
	return STATUS_OK;
}

enum status store_verify_pins(struct verifying *verifying)
{
	struct store *store = verifying->store;
	sqlite3_stmt *statement = NULL;
	int code;
	enum status status = STATUS_OK;
	if (store->version < STORE_VERSION_PINS)
		return STATUS_OK;
	TRY(store_sql_prepare(store->db, store->path, &statement, "SELECT revision, hash FROM pinned ORDER BY revision"));
	while ((code = sqlite3_step(statement)) == SQLITE_ROW)
		TRY_OR(done, check_pin(verifying, sqlite3_column_int64(statement, 0), (uint64_t)sqlite3_column_int64(statement, 1)));
	if (code != SQLITE_DONE)
		TRY_OR(done, store_sql_fail(store->db, code, store->path, "reading what overlays depend on"));
done:
	sqlite3_finalize(statement);
	return status;
}
