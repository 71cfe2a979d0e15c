/*
 * A set of map tiles in one file: MBTiles 1.3, a SQLite database with a table of tiles. Rows are counted from the south there.
 *
 *  1. The file is written as PATH.part in one transaction, and renamed when it is complete.
 *  2. Any thread puts and gets tiles; the mutex is held meanwhile.
 */
#include "exchange/internal.h"

#include <sqlite3.h>
#include <string.h>
#include <unistd.h>

#include "base/aside.h"

#define APPLICATION 0x4d504258 /* "MPBX", as the specification has it */

struct exchange_mbtiles {
	struct mutex mutex;
	struct aside aside;
	sqlite3 *database;
	sqlite3_stmt *insert, *select;
};

static enum status failed(const struct exchange_mbtiles *file)
{
	return fail_with(STATUS_FAILED, "%s: cannot be written: %s; free some disk space, or give another folder", file->aside.path,
			 file->database != NULL ? sqlite3_errmsg(file->database) : "no memory");
}

static enum status run_sql(struct exchange_mbtiles *file, const char *sql)
{
	return sqlite3_exec(file->database, sql, NULL, NULL, NULL) == SQLITE_OK ? STATUS_OK : failed(file);
}

static enum status prepare(struct exchange_mbtiles *file, const char *sql, sqlite3_stmt **out)
{
	return sqlite3_prepare_v2(file->database, sql, -1, out, NULL) == SQLITE_OK ? STATUS_OK : failed(file);
}

enum status exchange_mbtiles_create(const char *path, struct exchange_mbtiles **out)
{
	static const char schema[] =
		"PRAGMA journal_mode=OFF; PRAGMA synchronous=OFF;"
		"BEGIN; CREATE TABLE metadata (name TEXT, value TEXT);"
		"CREATE TABLE tiles (zoom_level INTEGER, tile_column INTEGER, tile_row INTEGER, tile_data BLOB);"
		"CREATE UNIQUE INDEX tile_index ON tiles (zoom_level, tile_column, tile_row);";
	char application[64];
	*out = NULL;
	TRY(aside_check(path));
	struct exchange_mbtiles *file = mem_calloc(1, sizeof *file);
	TRY_MEM(file, path);
	mutex_init(&file->mutex);
	enum status status;
	TRY_OR(fail, aside_name(&file->aside, path));
	(void)unlink(file->aside.part);
	file->aside.begun = true;
	if (sqlite3_open_v2(file->aside.part, &file->database, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX, NULL) != SQLITE_OK)
		TRY_OR(fail, failed(file));
	snprintf(application, sizeof application, "PRAGMA application_id=%d;", APPLICATION);
	TRY_OR(fail, run_sql(file, application));
	TRY_OR(fail, run_sql(file, schema));
	TRY_OR(fail, prepare(file, "INSERT INTO tiles VALUES (?, ?, ?, ?)", &file->insert));
	TRY_OR(fail, prepare(file, "SELECT tile_data FROM tiles WHERE zoom_level = ? AND tile_column = ? AND tile_row = ?", &file->select));
	*out = file;
	return STATUS_OK;
fail:
	exchange_mbtiles_destroy(file);
	return status;
}

void exchange_mbtiles_destroy(struct exchange_mbtiles *file)
{
	if (file == NULL)
		return;
	sqlite3_finalize(file->insert);
	sqlite3_finalize(file->select);
	sqlite3_close(file->database);
	aside_finish(&file->aside);
	mutex_finish(&file->mutex);
	mem_free(file);
}

static void bind_tile(sqlite3_stmt *statement, struct tile tile)
{
	sqlite3_bind_int(statement, 1, tile.level);
	sqlite3_bind_int64(statement, 2, tile.x);
	sqlite3_bind_int64(statement, 3, ((int64_t)1 << tile.level) - 1 - tile.y);
}

enum status exchange_mbtiles_put(struct exchange_mbtiles *file, struct tile tile, const struct exchange_bytes *bytes)
{
	mutex_lock(&file->mutex);
	bind_tile(file->insert, tile);
	sqlite3_bind_blob64(file->insert, 4, bytes->data, bytes->size, SQLITE_STATIC);
	const bool done = sqlite3_step(file->insert) == SQLITE_DONE;
	enum status status = done ? STATUS_OK : failed(file);
	sqlite3_reset(file->insert);
	sqlite3_clear_bindings(file->insert);
	mutex_unlock(&file->mutex);
	return status;
}

enum status exchange_mbtiles_get(struct exchange_mbtiles *file, struct tile tile, struct exchange_bytes *out, bool *found)
{
	enum status status = STATUS_OK;
	out->size = 0;
	mutex_lock(&file->mutex);
	bind_tile(file->select, tile);
	const int step = sqlite3_step(file->select);
	*found = step == SQLITE_ROW;
	if (*found)
		status = exchange_bytes_add(out, sqlite3_column_blob(file->select, 0), (size_t)sqlite3_column_bytes(file->select, 0));
	else if (step != SQLITE_DONE)
		status = failed(file);
	sqlite3_reset(file->select);
	mutex_unlock(&file->mutex);
	return status;
}

enum status exchange_mbtiles_say(struct exchange_mbtiles *file, const char *name, const char *value)
{
	sqlite3_stmt *statement = NULL;
	enum status status;
	TRY_OR(done, prepare(file, "INSERT INTO metadata VALUES (?, ?)", &statement));
	sqlite3_bind_text(statement, 1, name, -1, SQLITE_STATIC);
	sqlite3_bind_text(statement, 2, value, -1, SQLITE_STATIC);
	if (sqlite3_step(statement) != SQLITE_DONE)
		TRY_OR(done, failed(file));
done:
	sqlite3_finalize(statement);
	return status;
}

enum status exchange_mbtiles_publish(struct exchange_mbtiles *file)
{
	TRY(run_sql(file, "COMMIT;"));
	sqlite3_finalize(file->insert);
	sqlite3_finalize(file->select);
	file->insert = file->select = NULL;
	const bool closed = sqlite3_close(file->database) == SQLITE_OK;
	if (!closed)
		return failed(file);
	file->database = NULL;
	return aside_publish(&file->aside);
}
