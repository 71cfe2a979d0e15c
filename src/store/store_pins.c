/*
 * The list of the overlays that depend on a store: the file PATH-pins beside it.
 *
 * A parent that is only branched stays as it is, byte for byte. So the list is a file of its own, a SQLite database of one table. It is
 * lost if the store is moved without it. The overlay then says so when the parent has gone on.
 *
 * Invariants:
 *   1. A commit reads the list in its transaction on the store. A process that adds a line has a transaction on the store, too. So no
 *      commit misses a line.
 *   2. The list is not believed. A line keeps rows only if its hash is that of the store's state.
 */
#include "store/internal.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define LIST_APPLICATION_ID 0x46757270 /* "Furp" */
#define LIST_TABLE                                                                                                     \
	"CREATE TABLE pin(path TEXT PRIMARY KEY, revision INTEGER NOT NULL, hash INTEGER NOT NULL, base INTEGER NOT NULL, " \
	"made INTEGER NOT NULL) WITHOUT ROWID"

struct list {
	char *path;
	sqlite3 *db; /* NULL: there is no list */
	struct stat file; /* that is written */
};

static void list_close(struct list *list)
{
	sqlite3_close(list->db);
	mem_free(list->path);
	*list = (struct list){.path = NULL};
}

static enum status damaged(const struct list *list)
{
	return fail_with(STATUS_INPUT, "%s: it is no list of the overlays of a store; restore it, or remove it: then overlays are lost when the store is driven",
			 list->path);
}

/* *empty: nothing was written to it yet. */
static enum status check_list(struct list *list, bool *empty)
{
	sqlite3_stmt *statement = NULL;
	int64_t id = 0, objects = 0;
	enum status status = STATUS_OK;
	*empty = false;
	TRY(store_sql_integer(list->db, list->path, "SELECT count(*) FROM sqlite_schema", &objects));
	TRY(store_sql_integer(list->db, list->path, "PRAGMA application_id", &id));
	*empty = objects == 0 && id == 0;
	if (*empty)
		return STATUS_OK;
	TRY(store_sql_prepare(list->db, list->path, &statement, "SELECT sql FROM sqlite_schema"));
	int code = sqlite3_step(statement);
	const char *sql = code == SQLITE_ROW ? (const char *)sqlite3_column_text(statement, 0) : NULL;
	if (code != SQLITE_ROW && code != SQLITE_DONE)
		status = store_sql_fail(list->db, code, list->path, "reading it");
	else if (id != LIST_APPLICATION_ID || objects != 1 || sql == NULL || strcmp(sql, LIST_TABLE) != 0)
		status = damaged(list);
	sqlite3_finalize(statement);
	return status;
}

static enum status make_list(struct list *list)
{
	char sql[sizeof LIST_TABLE + 64];
	snprintf(sql, sizeof sql, "PRAGMA application_id=%d; %s", LIST_APPLICATION_ID, LIST_TABLE);
	return store_sql_exec(list->db, list->path, "making it", sql);
}

/* Opens the list of a store for reading; without one, list->db is NULL. */
static enum status list_open(const char *real_path, struct list *list)
{
	struct stat file;
	bool empty = false;
	*list = (struct list){.path = store_path_with(real_path, PINS_SUFFIX)};
	TRY_MEM(list->path, "a list of overlays");
	if (lstat(list->path, &file) != 0)
		return STATUS_OK;
	if (!S_ISREG(file.st_mode))
		return damaged(list);
	TRY(store_connect_reader(list->path, list->path, &(struct store_frozen){.is = false}, &list->db));
	TRY(check_list(list, &empty));
	if (empty) {
		sqlite3_close(list->db);
		list->db = NULL;
	}
	return STATUS_OK;
}

static bool is_there(const struct list *list)
{
	struct stat now;
	return lstat(list->path, &now) == 0 && now.st_ino == list->file.st_ino && now.st_dev == list->file.st_dev;
}

static enum status find_or_make(struct list *list)
{
	struct stat *file = &list->file;
	if (lstat(list->path, file) == 0 && !S_ISREG(file->st_mode))
		return damaged(list);
	int made = open(list->path, O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
	if (made < 0 && errno != ELOOP)
		return fail_with(STATUS_FAILED, "%s: cannot be made: %s; make its folder writable", list->path, strerror(errno));
	bool regular = made >= 0 && fstat(made, file) == 0 && S_ISREG(file->st_mode);
	if (made >= 0)
		close(made);
	return regular ? STATUS_OK : damaged(list);
}

/* Opens the list of a store for writing, and begins a transaction. Makes the list if there is none. */
static enum status list_begin(const char *real_path, struct list *list)
{
	bool empty = false, same = false;
	*list = (struct list){.path = store_path_with(real_path, PINS_SUFFIX)};
	TRY_MEM(list->path, "a list of overlays");
	while (!same) {
		sqlite3_close(list->db);
		list->db = NULL;
		TRY(find_or_make(list));
		TRY(store_connect_file(list->path, list->path, true, &list->db));
		TRY(store_sql_exec(list->db, list->path, "opening it", "PRAGMA synchronous=EXTRA"));
		TRY(store_sql_begin(list->db, list->path, "writing it"));
		/* Who dropped the last line has removed the list meanwhile (list_remove). */
		same = is_there(list);
	}
	TRY(check_list(list, &empty));
	return empty ? make_list(list) : STATUS_OK;
}

/* As list_begin(), but makes no list; without one, list->db is NULL. */
static enum status list_begin_if_there(const char *real_path, struct list *list)
{
	enum status status = list_open(real_path, list);
	const bool there = list->db != NULL;
	list_close(list);
	TRY(status);
	return there ? list_begin(real_path, list) : STATUS_OK;
}

/* Removes a list that would have no line. Who waits for it finds that out. */
static enum status list_remove(struct list *list)
{
	bool removed = unlink(list->path) == 0 || errno == ENOENT;
	enum status status = removed ? STATUS_OK
				     : fail_with(STATUS_FAILED, "%s: cannot be removed: %s; make its folder writable", list->path, strerror(errno));
	store_sql_undo(list->db);
	list_close(list);
	return status;
}

/* Removes a list to which nothing could be written. Who is about to write to it finds that out (list_end). */
static void give_up(struct list *list)
{
	struct stat file;
	store_sql_undo(list->db);
	if (is_there(list) && lstat(list->path, &file) == 0 && file.st_size == 0)
		unlink(list->path);
}

static enum status commit(struct list *list)
{
	TRY(store_sql_exec(list->db, list->path, "writing it", "COMMIT"));
	return is_there(list) ? STATUS_OK : fail_with(STATUS_FAILED, "%s: it was removed while it was written; try again", list->path);
}

/* Commits what was written to a list, and closes it. `status`: how the writing went; after a failure nothing is committed. A list that is
 * closed already stays as it is. Returns the first failure. */
static enum status list_end(struct list *list, enum status status)
{
	if (status == STATUS_OK && list->db != NULL)
		status = commit(list);
	if (status != STATUS_OK && list->db != NULL)
		give_up(list);
	list_close(list);
	return status;
}

/* --- lines --- */

enum status store_pins_each(const char *real_path, pin_fn fn, void *user)
{
	struct list list;
	sqlite3_stmt *statement = NULL;
	int code = SQLITE_DONE;
	enum status status;
	TRY_OR(done, list_open(real_path, &list));
	if (list.db != NULL)
		TRY_OR(done, store_sql_prepare(list.db, list.path, &statement, "SELECT path, revision, hash, base, made FROM pin ORDER BY path"));
	while (statement != NULL && (code = sqlite3_step(statement)) == SQLITE_ROW) {
		const char *path = (const char *)sqlite3_column_text(statement, 0);
		const struct pin pin = {
			.path = (char *)(uintptr_t)path,
			.revision = sqlite3_column_int64(statement, 1),
			.hash = (uint64_t)sqlite3_column_int64(statement, 2),
			.base = sqlite3_column_int(statement, 3) != 0,
			.made = sqlite3_column_int64(statement, 4),
		};
		bool fits = path != NULL && store_overlay_path_fits(path, (size_t)sqlite3_column_bytes(statement, 0)) && pin.revision >= 0;
		TRY_OR(done, fits ? fn(user, &pin) : damaged(&list));
	}
	if (code != SQLITE_DONE)
		TRY_OR(done, store_sql_fail(list.db, code, list.path, "reading it"));
done:
	sqlite3_finalize(statement);
	list_close(&list);
	return status;
}

static enum status step(struct list *list, sqlite3_stmt *statement)
{
	int code = sqlite3_step(statement);
	enum status status = code == SQLITE_DONE ? STATUS_OK : store_sql_fail(list->db, code, list->path, "writing it");
	sqlite3_finalize(statement);
	return status;
}

static enum status write_line(const char *real_path, const struct pin *pin, struct list *list)
{
	sqlite3_stmt *statement = NULL;
	TRY(list_begin(real_path, list));
	TRY(store_sql_prepare(list->db, list->path, &statement, "INSERT OR REPLACE INTO pin VALUES(?1, ?2, ?3, ?4, ?5)"));
	sqlite3_bind_text(statement, 1, pin->path, -1, SQLITE_STATIC);
	sqlite3_bind_int64(statement, 2, pin->revision);
	sqlite3_bind_int64(statement, 3, (sqlite3_int64)pin->hash);
	sqlite3_bind_int(statement, 4, pin->base);
	sqlite3_bind_int64(statement, 5, pin->made);
	return step(list, statement);
}

enum status store_pins_put(const char *real_path, const struct pin *pin)
{
	struct list list;
	return list_end(&list, write_line(real_path, pin, &list));
}

/* *others: the lines of other paths. */
static enum status count_others(struct list *list, const char *path, int64_t *others)
{
	sqlite3_stmt *statement = NULL;
	TRY(store_sql_prepare(list->db, list->path, &statement, "SELECT count(*) FROM pin WHERE path <> ?1"));
	sqlite3_bind_text(statement, 1, path, -1, SQLITE_STATIC);
	int code = sqlite3_step(statement);
	enum status status = code == SQLITE_ROW ? STATUS_OK : store_sql_fail(list->db, code, list->path, "reading it");
	*others = code == SQLITE_ROW ? sqlite3_column_int64(statement, 0) : -1;
	sqlite3_finalize(statement);
	return status;
}

static enum status drop_line(const char *real_path, const char *path, struct list *list)
{
	sqlite3_stmt *statement = NULL;
	int64_t others = 0;
	TRY(list_begin_if_there(real_path, list));
	if (list->db == NULL)
		return STATUS_OK;
	TRY(count_others(list, path, &others));
	if (others == 0)
		return list_remove(list);
	TRY(store_sql_prepare(list->db, list->path, &statement, "DELETE FROM pin WHERE path = ?1"));
	sqlite3_bind_text(statement, 1, path, -1, SQLITE_STATIC);
	return step(list, statement);
}

enum status store_pins_drop(const char *real_path, const char *path)
{
	struct list list;
	return list_end(&list, drop_line(real_path, path, &list));
}

/* What depends on the base alone stays. */
static enum status clear(const char *real_path, struct list *list)
{
	int64_t others = 0;
	TRY(list_begin_if_there(real_path, list));
	if (list->db == NULL)
		return STATUS_OK;
	TRY(store_sql_integer(list->db, list->path, "SELECT count(*) FROM pin WHERE base <> 0", &others));
	if (others == 0)
		return list_remove(list);
	return store_sql_exec(list->db, list->path, "writing it", "DELETE FROM pin WHERE base = 0");
}

enum status store_pins_clear(const char *real_path)
{
	struct list list;
	return list_end(&list, clear(real_path, &list));
}
