/* Calls SQLite for the other files of store, and converts its error codes to a status and a message. */
#include "store/internal.h"

#include <errno.h>
#include <string.h>

#include "base/limits.h"

enum status store_sql_fail(sqlite3 *db, int code, const char *path, const char *doing)
{
	const char *why = db != NULL ? sqlite3_errmsg(db) : sqlite3_errstr(code);
	int error = db != NULL ? sqlite3_system_errno(db) : 0;
	if (code == SQLITE_IOERR_NOMEM)
		return fail_memory(doing);
	if (error == 0 && limits_advice(errno, NULL) != NULL) /* SQLite keeps none of a COMMIT */
		error = errno;
	switch (code & 0xff) {
	case SQLITE_CORRUPT:
		return fail_with(STATUS_INPUT, "%s: %s: %s, the file is damaged or was cut short; "
				 "copy it again from where it was whole, or make it anew with furrow import", path, doing, why);
	case SQLITE_NOTADB:
		return fail_with(STATUS_INPUT, "%s: not a Furrow store (%s); name a store, or make one with furrow import",
				 path, why);
	case SQLITE_CANTOPEN: { /* SQLite's own text is "unable to open database file" */
		const char *limit = limits_advice(error, NULL);
		if (limit != NULL)
			return fail_with(STATUS_FAILED, "%s: %s: %s; %s", path, doing, strerror(error), limit);
		return fail_with(STATUS_INPUT, "%s: %s: %s; check the path and its permissions", path,
				 doing, why);
	}
	case SQLITE_TOOBIG:
		return fail_with(STATUS_INPUT, "%s: %s: %s; no store holds values as large, the file is "
				 "damaged", path, doing, why);
	case SQLITE_NOMEM:
		return fail_memory(doing);
	case SQLITE_FULL:
		return fail_with(STATUS_FAILED, "%s: %s: %s; free some disk space, then run it again",
				 path, doing, why);
	case SQLITE_IOERR:
		return fail_with(STATUS_FAILED, "%s: %s: %s%s%s; %s", path, doing, why, error != 0 ? ": " : "",
				 error != 0 ? strerror(error) : "", limits_advice(error, "check the disk and its free space"));
	case SQLITE_BUSY:
		return fail_with(STATUS_FAILED, "%s: %s: %s; wait for the other process to end", path,
				 doing, why);
	case SQLITE_READONLY:
		return fail_with(STATUS_FAILED, "%s: %s: %s; make the file and its folder writable", path,
				 doing, why);
	default:
		return fail_with(STATUS_FAILED, "%s: %s: %s; furrow verify says what is wrong with it",
				 path, doing, why);
	}
}

enum status store_sql_exec(sqlite3 *db, const char *path, const char *doing, const char *sql)
{
	errno = 0;
	int code = sqlite3_exec(db, sql, NULL, NULL, NULL);
	return code == SQLITE_OK ? STATUS_OK : store_sql_fail(db, code, path, doing);
}

void store_sql_undo(sqlite3 *db)
{
	if (!sqlite3_get_autocommit(db))
		sqlite3_exec(db, "ROLLBACK", NULL, NULL, NULL);
}

enum status store_sql_begin(sqlite3 *db, const char *path, const char *doing)
{
	store_sql_undo(db);
	return store_sql_exec(db, path, doing, "BEGIN IMMEDIATE");
}

enum status store_sql_prepare(sqlite3 *db, const char *path, sqlite3_stmt **statement, const char *sql)
{
	if (*statement != NULL)
		return STATUS_OK;
	int code = sqlite3_prepare_v3(db, sql, -1, SQLITE_PREPARE_PERSISTENT, statement, NULL);
	return code == SQLITE_OK ? STATUS_OK : store_sql_fail(db, code, path, "preparing a statement");
}

enum status store_sql_integer(sqlite3 *db, const char *path, const char *sql, int64_t *value)
{
	sqlite3_stmt *statement = NULL;
	TRY(store_sql_prepare(db, path, &statement, sql));
	int code = sqlite3_step(statement);
	enum status status = code == SQLITE_ROW ? STATUS_OK : store_sql_fail(db, code, path, "reading it");
	if (code == SQLITE_ROW)
		*value = sqlite3_column_int64(statement, 0);
	sqlite3_finalize(statement);
	return status;
}
