/*
 * Changes of a store that leave it an SQLite file, and most of them rows whose hashes are right: so
 * that what is behind those checks is reached. The other changes are of bytes, anywhere.
 */
#include "store_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint64_t random_state;

static uint64_t below(uint64_t bound)
{
	return fuzz_below(&random_state, bound);
}

static const char *const tables[ROW_TABLES] = {"base", "\"offset\"", "dirt", "heaped", "pressed", "shear", "dug", "settled", "loose", "floor", "density", "slope", "healed", "risen", "grown"};

/* --- single values --- */

static void bind_any(sqlite3_stmt *statement, int place)
{
	uint8_t bytes[64];
	switch (below(8)) {
	case 0:
	case 1:
	case 2:
		sqlite3_bind_int64(statement, place, fuzz_integer(&random_state));
		break;
	case 3:
	case 4:
	case 5:
		sqlite3_bind_double(statement, place, fuzz_real(&random_state));
		break;
	case 6:
		for (size_t i = 0; i < sizeof bytes; i++)
			bytes[i] = (uint8_t)below(256);
		if (below(2))
			sqlite3_bind_blob(statement, place, bytes, (int)below(sizeof bytes), SQLITE_TRANSIENT);
		else
			sqlite3_bind_text(statement, place, (const char *)bytes, (int)below(sizeof bytes), SQLITE_TRANSIENT);
		break;
	default:
		sqlite3_bind_null(statement, place);
	}
}

/* Runs `sql` with ?1 any value and ?2 a row's number; whatever comes of it. */
static void change(sqlite3 *db, const char *sql, bool any)
{
	sqlite3_stmt *statement;
	if (sqlite3_prepare_v2(db, sql, -1, &statement, NULL) != SQLITE_OK)
		return;
	if (any)
		bind_any(statement, 1);
	else
		sqlite3_bind_int64(statement, 1, fuzz_integer(&random_state));
	sqlite3_bind_int64(statement, 2, (sqlite3_int64)below(below(2) ? 4 : 40));
	sqlite3_step(statement);
	sqlite3_finalize(statement);
}

#define ANY_KEY "UPDATE meta SET value = ?1 WHERE key = (SELECT key FROM meta LIMIT 1 OFFSET ?2 % 16)"

static void change_meta(sqlite3 *db)
{
	static const char *const edits[] = {
		ANY_KEY, ANY_KEY, ANY_KEY, ANY_KEY,
		"UPDATE meta SET value = CAST(?1 AS INTEGER) WHERE key = 'cells'",
		"UPDATE meta SET value = CAST(?1 AS INTEGER) WHERE key IN ('width', 'height')",
		"UPDATE meta SET value = 1 << (?2 & 31) WHERE key IN ('width', 'height')",
		"UPDATE meta SET value = CAST(?1 AS INTEGER) % 30 WHERE key IN ('working', 'pack')",
		"UPDATE meta SET value = 8 << (?2 & 7) WHERE key = 'cells'",
		"UPDATE meta SET value = value + ?2 - 20 WHERE key = 'width'",
		"UPDATE meta SET value = value + ?2 - 20 WHERE key = 'height'",
		"UPDATE meta SET value = 1 << (?2 & 31) WHERE key = 'width'",
		"UPDATE meta SET value = 1 << (?2 & 31) WHERE key = 'height'",
		"UPDATE meta SET value = 0.0 WHERE key = 'step'",
		"DELETE FROM meta WHERE key = (SELECT key FROM meta LIMIT 1 OFFSET ?2)",
		"INSERT OR REPLACE INTO meta VALUES('working', (?2 & 31) - 15)",
		"INSERT OR REPLACE INTO meta VALUES('compacted', ?1)",
		"UPDATE run SET epoch = ?1", "UPDATE run SET step = ?1", "UPDATE run SET time = ?1",
		"UPDATE run SET state = ?1", "UPDATE run SET scene_hash = ?1",
		"UPDATE meta SET value = -1e8 WHERE key = 'low'", "UPDATE meta SET value = 1e8 WHERE key = 'high'",
	};
	change(db, edits[below(sizeof edits / sizeof *edits)], true);
}

/* --- rows --- */

static void change_row(sqlite3 *db)
{
	static const char *const columns[][7] = { /* the base's, the offset's, any other plane's */
		{"low", "high", "error", "codec", "revision", "key", "blob"},
		{"low", "high", "below", "above", "codec", "key", "blob"},
		{"low", "high", "hash", "codec", "revision", "key", "blob"},
	};
	char sql[256];
	size_t table = below(ROW_TABLES), other = below(ROW_TABLES);
	const char *name = tables[table], *column = columns[table < ROW_DISTURBANCE ? table : ROW_DISTURBANCE][below(7)];
	switch (below(6)) {
	case 0:
	case 1:
		snprintf(sql, sizeof sql, "UPDATE OR REPLACE %s SET %s = ?1 WHERE key = "
			 "(SELECT key FROM %s LIMIT 1 OFFSET ?2)", name, column, name);
		break;
	case 2:
		snprintf(sql, sizeof sql, "DELETE FROM %s WHERE key = (SELECT key FROM %s LIMIT 1 OFFSET ?2)", name, name);
		break;
	case 3: /* to another tile near by, or of another level */
		snprintf(sql, sizeof sql, "UPDATE OR REPLACE %s SET key = key + (((?2 & 3) - 1) << %d) WHERE key = "
			 "(SELECT key FROM %s LIMIT 1 OFFSET ?2 / 2)", name, below(2) ? 0 : 56, name);
		break;
	case 4: /* another row's posts */
		snprintf(sql, sizeof sql, "UPDATE %s SET (codec, blob) = (SELECT codec, blob FROM %s LIMIT 1 OFFSET ?2 / 3) "
			 "WHERE key = (SELECT key FROM %s LIMIT 1 OFFSET ?2)", name, tables[other], name);
		break;
	default: /* all posts one value */
		snprintf(sql, sizeof sql, "UPDATE %s SET codec = 0, blob = x'%08x' WHERE key = "
			 "(SELECT key FROM %s LIMIT 1 OFFSET ?2)", name, (unsigned)fuzz_integer(&random_state), name);
	}
	change(db, sql, true);
}

/* Bytes of a blob. */
static void change_blob(sqlite3 *db)
{
	static uint8_t bytes[65536];
	char sql[160];
	sqlite3_stmt *find = NULL, *write = NULL;
	const char *name = tables[below(ROW_TABLES)];
	snprintf(sql, sizeof sql, "SELECT key, blob FROM %s LIMIT 1 OFFSET %d", name, (int)below(16));
	if (sqlite3_prepare_v2(db, sql, -1, &find, NULL) != SQLITE_OK || sqlite3_step(find) != SQLITE_ROW) {
		sqlite3_finalize(find);
		return;
	}
	sqlite3_int64 key = sqlite3_column_int64(find, 0);
	const void *blob = sqlite3_column_blob(find, 1);
	size_t size = (size_t)sqlite3_column_bytes(find, 1);
	size = size < sizeof bytes ? size : sizeof bytes;
	if (blob != NULL)
		memcpy(bytes, blob, size);
	sqlite3_finalize(find);
	size = LLVMFuzzerMutate(bytes, size, sizeof bytes);
	snprintf(sql, sizeof sql, "UPDATE %s SET blob = ?1 WHERE key = ?2", name);
	if (sqlite3_prepare_v2(db, sql, -1, &write, NULL) == SQLITE_OK) {
		sqlite3_bind_blob(write, 1, bytes, (int)size, SQLITE_STATIC);
		sqlite3_bind_int64(write, 2, key);
		sqlite3_step(write);
	}
	sqlite3_finalize(write);
}

/* --- hashes --- */

static double real_or_nan(sqlite3_stmt *statement, int column)
{
	return sqlite3_column_type(statement, column) == SQLITE_NULL ? (double)NAN
								       : sqlite3_column_double(statement, column);
}

static void fix_row(enum row_table table, sqlite3_stmt *find, sqlite3_stmt *write)
{
	struct row row = {
		.tile = tile_from_key((uint64_t)sqlite3_column_int64(find, 0)),
		.low = real_or_nan(find, 1),
		.high = real_or_nan(find, 2),
		.error = sqlite3_column_double(find, 3),
		.codec = sqlite3_column_int64(find, 4),
		.below = sqlite3_column_int64(find, 5),
		.above = sqlite3_column_int64(find, 6),
		.bytes = sqlite3_column_blob(find, 7),
		.size = (size_t)sqlite3_column_bytes(find, 7),
	};
	if (row.bytes == NULL)
		return;
	sqlite3_bind_int64(write, 1, (sqlite3_int64)store_rows_hash(table, &row));
	sqlite3_bind_int64(write, 2, sqlite3_column_int64(find, 0));
	sqlite3_step(write);
	sqlite3_reset(write);
}

static void fix_hashes(sqlite3 *db)
{
	for (int table = 0; table < ROW_TABLES; table++) {
		char sql[160];
		sqlite3_stmt *find = NULL, *write = NULL;
		snprintf(sql, sizeof sql, "SELECT key, low, high, %s, blob FROM %s ORDER BY key",
			 table == ROW_BASE     ? "error, codec, 0, 0"
			 : table == ROW_OFFSET ? "0.0, codec, below, above"
					       : "0.0, codec, 0, 0",
			 tables[table]);
		if (sqlite3_prepare_v2(db, sql, -1, &find, NULL) == SQLITE_OK) {
			snprintf(sql, sizeof sql, "UPDATE %s SET hash = ?1 WHERE key = ?2", tables[table]);
			if (sqlite3_prepare_v2(db, sql, -1, &write, NULL) == SQLITE_OK)
				while (sqlite3_step(find) == SQLITE_ROW)
					fix_row((enum row_table)table, find, write);
		}
		sqlite3_finalize(find);
		sqlite3_finalize(write);
	}
}

/* --- */

/* A file whose pages go round has no last row: SQLite asks here, each STEPS_BETWEEN of its own steps. */
#define STEPS_BETWEEN 1000
#define ASKED_MAX 200

static int stop_when_long(void *user)
{
	int *asked = user;
	return ++*asked > ASKED_MAX;
}

static bool change_file(const char *path)
{
	sqlite3 *db;
	int asked = 0;
	bool good = sqlite3_open_v2(path, &db, SQLITE_OPEN_READWRITE, NULL) == SQLITE_OK &&
		    sqlite3_exec(db, "PRAGMA journal_mode=OFF; PRAGMA synchronous=OFF; BEGIN", NULL, NULL, NULL) == SQLITE_OK;
	if (good) {
		sqlite3_progress_handler(db, STEPS_BETWEEN, stop_when_long, &asked);
		for (uint64_t i = 1 + below(3); i > 0; i--)
			switch (below(3)) {
			case 0:
				change_meta(db);
				break;
			case 1:
				change_row(db);
				break;
			default:
				change_blob(db);
			}
		if (below(8) != 0)
			fix_hashes(db);
		sqlite3_progress_handler(db, 0, NULL, NULL);
		good = sqlite3_exec(db, "COMMIT", NULL, NULL, NULL) == SQLITE_OK;
	}
	sqlite3_close(db);
	return good;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned seed)
{
	random_state = seed;
	if (below(4) == 0)
		return LLVMFuzzerMutate(data, size, room);
	const char *path = store_file_fresh();
	fuzz_write(path, data, size);
	if (!change_file(path))
		return LLVMFuzzerMutate(data, size, room);
	size_t changed = fuzz_read(path, data, room);
	if (changed == 0 || changed > room)
		return LLVMFuzzerMutate(data, size, room);
	return below(16) == 0 ? LLVMFuzzerMutate(data, changed, room) : changed;
}
