/* A base tile of a store that cannot be read any more. Include after support.h. */
#ifndef FURROW_TESTS_RUN_DAMAGE_H
#define FURROW_TESTS_RUN_DAMAGE_H

#include <sqlite3.h>

static inline void damage(const char *path, struct tile tile)
{
	sqlite3 *db;
	char sql[128];
	snprintf(sql, sizeof sql, "UPDATE base SET blob = zeroblob(9) WHERE key = %lld", (long long)tile_key(tile));
	assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
	assert_int_equal(sqlite3_exec(db, sql, NULL, NULL, NULL), SQLITE_OK);
	assert_int_equal(sqlite3_changes(db), 1);
	assert_int_equal(sqlite3_close(db), SQLITE_OK);
}

#endif
