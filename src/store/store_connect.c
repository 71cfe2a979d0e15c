/* Opens connections to a store's file, with the settings that an untrusted file needs. */
#include "store/internal.h"

#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define VALUE_BYTES (24 << 20) /* the largest plane coded, and texts, are below that */

/* "file:PATH?immutable=1": what is special in a URI is escaped. */
static char *uri_of(const char *path)
{
	static const char hex[] = "0123456789abcdef", tail[] = "?immutable=1";
	char *uri = mem_alloc(3 * strlen(path) + sizeof "file:" + sizeof tail, 1);
	if (uri == NULL)
		return NULL;
	char *to = uri + sprintf(uri, "file:");
	for (const char *c = path; *c != '\0'; c++) {
		if (*c == '?' || *c == '#' || *c == '%') {
			*to++ = '%';
			*to++ = hex[(unsigned char)*c >> 4];
			*to++ = hex[*c & 15];
		} else {
			*to++ = *c;
		}
	}
	memcpy(to, tail, sizeof tail);
	return uri;
}

/* SQLite follows a link beside a store, and waits for a pipe. */
static enum status check_beside(const char *path, const char *named)
{
	static const char *const suffixes[] = {"-journal", "-wal", "-shm"};
	char beside[PATH_MAX + 16];
	struct stat file;
	for (size_t i = 0; i < sizeof suffixes / sizeof suffixes[0]; i++) {
		snprintf(beside, sizeof beside, "%s%s", path, suffixes[i]);
		if (lstat(beside, &file) == 0 && !S_ISREG(file.st_mode))
			return fail_with(STATUS_INPUT, "%s: %s lies beside it and is no plain file; remove that", named, beside);
	}
	return STATUS_OK;
}

/* Sets what an untrusted file needs. */
static enum status settle(sqlite3 *db, const char *named, enum store_way way)
{
	sqlite3_busy_timeout(db, STORE_BUSY_MS);
	sqlite3_db_config(db, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, (int *)NULL);
	sqlite3_db_config(db, SQLITE_DBCONFIG_DEFENSIVE, 1, (int *)NULL);
	sqlite3_db_config(db, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, (int *)NULL);
	sqlite3_db_config(db, SQLITE_DBCONFIG_ENABLE_VIEW, 0, (int *)NULL);
	sqlite3_db_config(db, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, way == STORE_ASIDE, (int *)NULL);
	sqlite3_limit(db, SQLITE_LIMIT_LENGTH, VALUE_BYTES);
	TRY(store_sql_exec(db, named, "opening it", "PRAGMA cell_size_check=ON"));
	if (way != STORE_ASIDE)
		return STATUS_OK;
	/* Only so does SQLite keep the index of the WAL in memory. */
	return store_sql_exec(db, named, "opening it", "PRAGMA locking_mode=EXCLUSIVE");
}

/* Closes the connection if `status` is a failure. Returns `status`. */
static enum status close_if_failed(sqlite3 **db, enum status status)
{
	if (status != STATUS_OK) {
		sqlite3_close(*db);
		*db = NULL;
	}
	return status;
}

static enum status connect_as(const char *path, const char *named, bool writing, enum store_way way, sqlite3 **db)
{
	*db = NULL;
	TRY(check_beside(path, named));
	char *uri = way == STORE_IMMUTABLE ? uri_of(path) : mem_strdup(path);
	TRY_MEM(uri, "opening a store");
	int flags = SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE | (way == STORE_IMMUTABLE ? SQLITE_OPEN_URI : 0) |
		    (writing ? SQLITE_OPEN_READWRITE : SQLITE_OPEN_READONLY);
	int code = sqlite3_open_v2(uri, db, flags, way == STORE_ASIDE ? store_frozen_vfs() : NULL);
	mem_free(uri);
	return close_if_failed(db, code == SQLITE_OK ? settle(*db, named, way) : store_sql_fail(*db, code, named, "opening it"));
}

enum status store_connect_file(const char *path, const char *named, bool writing, sqlite3 **db)
{
	return connect_as(path, named, writing, STORE_PLAIN, db);
}

static bool has_beside(const char *path, const char *suffix)
{
	char beside[PATH_MAX + 16];
	struct stat file;
	snprintf(beside, sizeof beside, "%s%s", path, suffix);
	return stat(beside, &file) == 0 && file.st_size > 0;
}

bool store_connect_has_wal(const char *path)
{
	return has_beside(path, "-wal");
}

bool store_connect_has_journal(const char *path)
{
	return has_beside(path, "-journal");
}

/* Tells whether this process may write in the store's folder. If so, it can create the file that WAL needs, and an error of that
 * is temporary. Such a store may also still change. */
static bool may_write(const char *path)
{
	char folder[PATH_MAX];
	snprintf(folder, sizeof folder, "%s", path);
	return access(path, W_OK) == 0 && access(dirname(folder), W_OK) == 0;
}

/* After a power cut a journal may be back that a writer was done with: only who may write can undo it. */
static enum status roll_back(const char *path, const char *named)
{
	sqlite3 *db;
	TRY(store_connect_file(path, named, true, &db));
	enum status status = store_sql_exec(db, named, "undoing what a power cut left", "SELECT count(*) FROM sqlite_schema");
	sqlite3_close(db);
	return status;
}

/* Limits the page cache of a reader's connection. A reader rarely reads a tile twice, and there are many readers. */
static enum status keep_little(sqlite3 **db, const char *named)
{
	return close_if_failed(db, store_sql_exec(*db, named, "opening it", "PRAGMA cache_size=-512"));
}

/* Connects in the way that fits what is beside the file: nobody may have to make a file there. A journal has to be undone first, and may
 * change what the header says. */
static enum status connect_quietly(const char *path, const char *named, struct store_frozen *frozen, sqlite3 **db)
{
	const enum store_way way = store_frozen_way(path, frozen);
	TRY(connect_as(path, named, false, STORE_PLAIN, db));
	if (way == STORE_PLAIN || store_connect_has_journal(path) || !store_frozen_says_wal(*db))
		return STATUS_OK;
	sqlite3_close(*db);
	frozen->is = true;
	return connect_as(path, named, false, way, db);
}

enum status store_connect_reader(const char *path, const char *named, struct store_frozen *frozen, sqlite3 **db)
{
	for (bool undone = false;; undone = true) {
		TRY(connect_quietly(path, named, frozen, db));
		int code = sqlite3_exec(*db, "SELECT count(*) FROM sqlite_schema", NULL, NULL, NULL);
		if (code == SQLITE_OK)
			return keep_little(db, named);
		/* SQLite may need to make or to write a file beside the store, in a folder that may not be written. */
		bool beside = (code & 0xff) == SQLITE_CANTOPEN || (code & 0xff) == SQLITE_READONLY;
		bool journal = store_connect_has_journal(path);
		if (frozen->is || !beside || (journal && undone) || (!journal && may_write(path)))
			return close_if_failed(db, store_sql_fail(*db, code, named, "opening it"));
		sqlite3_close(*db);
		*db = NULL;
		if (journal) {
			TRY(roll_back(path, named));
			continue;
		}
		frozen->is = true;
		TRY(connect_as(path, named, false, store_connect_has_wal(path) ? STORE_ASIDE : STORE_IMMUTABLE, db));
		return keep_little(db, named);
	}
}
