/*
 * Keeps SQLite's write-ahead log (WAL) short while a store is written.
 *
 * After a checkpoint that copied everything, the next commit begins at the start of the WAL again. This fails if a reader uses the
 * WAL at that moment. If a reader stops the checkpoint, or this happens repeatedly, the next checkpoint runs in the mode that
 * waits. While a reader stays, the WAL grows. When the reader has gone, the WAL is cut (journal_size_limit).
 */
#include "store/internal.h"

#include <assert.h>
#include <stdio.h>

#define WAL_BYTES (64 << 20)
#define PATIENCE (2 * WAL_BYTES)
#define FRAME_HEAD 24 /* before each page */
#define WAIT_MS 100

static int committed(void *user, sqlite3 *db, const char *schema, int frames)
{
	struct store *store = user;
	store->wal_bytes = frames * store->frame_bytes;
	return SQLITE_OK;
}

enum status store_wal_begin(struct store *store)
{
	char pragmas[128];
	snprintf(pragmas, sizeof pragmas,
		 "PRAGMA journal_mode=WAL; PRAGMA synchronous=%s; PRAGMA wal_autocheckpoint=0; "
		 "PRAGMA journal_size_limit=%d",
		 store->durable_full || store->part.count > 0 ? "FULL" : "NORMAL", WAL_BYTES);
	TRY(store_sql_exec(store->db, store->path, "opening it for writing", pragmas));
	TRY(store_sql_integer(store->db, store->path, "PRAGMA page_size", &store->frame_bytes));
	store->frame_bytes += FRAME_HEAD;
	store->wal_patience = PATIENCE;
	/* After the pragma: to SQLite its automatic checkpoints are such a hook. */
	sqlite3_wal_hook(store->db, committed, store);
	return STATUS_OK;
}

/* *whole: nothing is left in the WAL that the file has not. */
static enum status checkpoint(struct store *store, int mode, bool *whole)
{
	int frames = 0, copied = 0;
	int code = sqlite3_wal_checkpoint_v2(store->db, NULL, mode, &frames, &copied);
	/* Busy: somebody reads what the WAL holds; the next one goes further. */
	bool busy = (code & 0xff) == SQLITE_BUSY;
	*whole = code == SQLITE_OK && frames == copied;
	return code == SQLITE_OK || busy ? STATUS_OK : store_sql_fail(store->db, code, store->path, "checkpointing it");
}

enum status store_checkpoint(struct store *store)
{
	bool whole;
	assert(store->writing);
	return checkpoint(store, SQLITE_CHECKPOINT_PASSIVE, &whole);
}

enum status store_bound_wal(struct store *store)
{
	bool whole;
	assert(store->writing);
	if (store->wal_bytes < WAL_BYTES) {
		store->wal_patience = PATIENCE;
		return STATUS_OK;
	}
	TRY(checkpoint(store, SQLITE_CHECKPOINT_PASSIVE, &whole));
	if (store->wal_bytes < store->wal_patience)
		return STATUS_OK;
	sqlite3_busy_timeout(store->db, WAIT_MS);
	enum status status = checkpoint(store, SQLITE_CHECKPOINT_TRUNCATE, &whole);
	sqlite3_busy_timeout(store->db, STORE_BUSY_MS);
	/* If a reader is in the way, the next commits do not wait for it again. */
	store->wal_patience = whole ? PATIENCE : store->wal_bytes + WAL_BYTES;
	return status;
}
