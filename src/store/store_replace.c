/*
 * Prepares an existing store for being replaced by a new one. If a killed writer left files beside it, their content is moved into
 * the store.
 *
 * These files must be gone before the new store gets the name. Otherwise SQLite would use them with the new store. If renaming the
 * new store fails, the old store must still have its last commit.
 */
#include "store/internal.h"

#include <sys/stat.h>

enum status store_replace_settle(const char *path, const char *named)
{
	struct stat file;
	if ((!store_connect_has_wal(path) && !store_connect_has_journal(path)) || stat(path, &file) != 0)
		return STATUS_OK;
	sqlite3 *db;
	enum status status = STATUS_OK;
	TRY(store_connect_file(path, named, true, &db));
	int code = sqlite3_exec(db, "PRAGMA wal_checkpoint(TRUNCATE); PRAGMA journal_mode=DELETE", NULL, NULL, NULL);
	/* What is no store, or a damaged one, is simply replaced. */
	if (code != SQLITE_OK && (code & 0xff) != SQLITE_CORRUPT && (code & 0xff) != SQLITE_NOTADB)
		status = store_sql_fail(db, code, named, "closing the store that is there");
	else if (code == SQLITE_OK && store_connect_has_wal(path))
		status = fail_with(STATUS_FAILED, "%s: cannot be replaced: another process reads it; wait for it to end", named);
	sqlite3_close(db);
	return status;
}
