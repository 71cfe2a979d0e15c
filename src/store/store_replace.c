/*
 * Before a store is replaced: what a killed writer left beside it goes back into it.
 *
 * Those files have to be gone before another file takes the name, or they would be taken for that
 * one's. Should the rename then fail, the older store must still hold its last commit.
 */
#include "store/internal.h"

#include <sys/stat.h>

enum status store_replace_settle(const char *path, const char *named)
{
	struct stat file;
	if ((!store_connect_has_wal(path) && !store_connect_has_journal(path)) || stat(path, &file) != 0)
		return STATUS_OK;
	sqlite3 *db;
	enum status status = store_connect_file(path, named, true, false, &db);
	if (status != STATUS_OK)
		return status;
	int code = sqlite3_exec(db, "PRAGMA wal_checkpoint(TRUNCATE); PRAGMA journal_mode=DELETE", NULL, NULL, NULL);
	/* What is no store, or a damaged one, is simply replaced. */
	if (code != SQLITE_OK && (code & 0xff) != SQLITE_CORRUPT && (code & 0xff) != SQLITE_NOTADB)
		status = store_sql_fail(db, code, named, "closing the store that is there");
	else if (code == SQLITE_OK && store_connect_has_wal(path))
		status = fail_with(STATUS_FAILED, "%s: cannot be replaced: another process reads it; wait for it to end", named);
	sqlite3_close(db);
	return status;
}
