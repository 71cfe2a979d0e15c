/*
 * Keeps what overlays depend on, when the store goes on.
 *
 *   revision   2 (pinned)        5 (pinned)            9 (present)
 *   rows       pinned 2 -------> pinned 5 -----------> the tables
 *
 * A commit keeps each row that it replaces, if it is the first to do so since the newest pinned revision. So a row as it was at a
 * pinned revision is the kept one with the least number from there on. If there is none, it is the present one.
 *
 * Rows are kept as they are, at every level, with range and hash. So an overlay reads the same rows as before, and its hash of
 * the parent's state proves that. Only the rows of the file itself are kept: what an overlay inherits is kept by its parent.
 *
 * A connection is shown a pinned revision by temporary views with the names of the tables. A statement does not see the difference.
 *
 * Invariants:
 *   1. A row is kept in the transaction that replaces it.
 *   2. A row is kept for a pinned revision only if none with a greater number is there. So a pin can be dropped.
 *   3. A store without a pin has none of these tables, and nothing is kept.
 */
#include "store/internal.h"

#include <assert.h>
#include <stdio.h>

static_assert(PINS_TABLES == (int)ROW_TABLES, "as many tables as rows have");

static const char keeping[] = "keeping what overlays depend on";

/* --- a life --- */

enum status store_pinned_open(struct store *store)
{
	store->pins.newest = store->pins.label = -1;
	if (store->version < STORE_VERSION_PINS)
		return STATUS_OK;
	TRY(store_sql_integer(store->db, store->path, "SELECT coalesce(max(revision), -1) FROM main.pinned", &store->pins.newest));
	if (store->shown < 0 && store->pins.newest > store->commit)
		return fail_with(STATUS_INPUT, "%s: what it keeps for overlays is not its own; the store is damaged, restore it", store->path);
	return STATUS_OK;
}

void store_pinned_finish(struct store *store)
{
	for (int table = 0; table < ROW_TABLES; table++) {
		sqlite3_finalize(store->pins.keep[table]);
		sqlite3_finalize(store->pins.none[table]);
		store->pins.keep[table] = store->pins.none[table] = NULL;
	}
}

/* --- a transaction --- */

static enum status is_present(void *user, const struct pin *pin)
{
	struct store *store = user;
	if (!pin->base && pin->revision == store->commit)
		store->pins.label = pin->revision;
	return STATUS_OK;
}

struct matching {
	const struct store *store;
	uint64_t hash;
	bool found;
};

static enum status match(void *user, const struct pin *pin)
{
	struct matching *matching = user;
	matching->found |= !pin->base && pin->revision == matching->store->commit && pin->hash == matching->hash;
	return STATUS_OK;
}

/* *written: the rows that the statement wrote. */
static enum status put_by(struct store *store, const char *text, uint64_t hash, int *written)
{
	sqlite3_stmt *statement = NULL;
	TRY(store_sql_prepare(store->db, store->path, &statement, text));
	sqlite3_bind_int64(statement, 1, (sqlite3_int64)hash);
	if (store->working_stored)
		sqlite3_bind_int(statement, 2, store->working);
	sqlite3_bind_int64(statement, 3, store->compacted);
	if (store->working_stored && store->relief_text != NULL)
		sqlite3_bind_text(statement, 4, store->relief_text, -1, SQLITE_STATIC);
	sqlite3_bind_int64(statement, 5, store->commit); /* the first text has no such parameter: no harm */
	int code = sqlite3_step(statement);
	enum status status = code == SQLITE_DONE ? STATUS_OK : store_sql_fail(store->db, code, store->path, keeping);
	*written = sqlite3_changes(store->db);
	sqlite3_finalize(statement);
	return status;
}

static enum status put_revision(struct store *store, uint64_t hash)
{
	static const char *const texts[] = {
		"INSERT INTO pinned SELECT epoch, ?1, scene_hash, step, time, state, made, who, what, ?2, ?3, ?4 FROM run",
		/* a store without a run */
		"INSERT INTO pinned VALUES(?5, ?1, NULL, NULL, NULL, NULL, NULL, NULL, NULL, ?2, ?3, ?4)",
	};
	int written = 0;
	for (int i = 0; i < 2 && written == 0; i++)
		TRY(put_by(store, texts[i], hash, &written));
	return STATUS_OK;
}

/* An older list, of before a reset, may have the same number for another state. So the hash decides. */
static enum status pin_present(struct store *store)
{
	struct matching matching = {.store = store};
	TRY(store_lineage_state(store, &matching.hash));
	TRY(store_pins_each(store->real_path, match, &matching));
	if (!matching.found) {
		store->pins.label = store->pins.newest;
		return STATUS_OK;
	}
	return put_revision(store, matching.hash);
}

enum status store_pinned_begin(struct store *store)
{
	struct pins *pins = &store->pins;
	pins->label = pins->newest;
	if (store->part.count > 0)
		return STATUS_OK; /* a part ends with its run */
	if (store->under != NULL && !pins->told)
		TRY(store_pins_tell_parent(store));
	pins->told = true;
	if (pins->newest != store->commit)
		TRY(store_pins_each(store->real_path, is_present, store));
	return pins->label > pins->newest ? pin_present(store) : STATUS_OK;
}

void store_pinned_end(struct store *store, bool committed)
{
	struct pins *pins = &store->pins;
	if (committed && pins->label > pins->newest)
		pins->newest = pins->label;
	pins->label = -1;
}

static enum status prepare(struct store *store, enum row_table table)
{
	char text[480];
	const char *from = store_rows_sql_name(table), *sums = table == ROW_OFFSET ? "below, above" : "NULL, NULL";
	snprintf(text, sizeof text,
		 "INSERT INTO replaced SELECT ?1, key, ?3, low, high, %s, codec, revision, hash, blob FROM %s WHERE key = ?2 AND "
		 "NOT EXISTS (SELECT 1 FROM replaced WHERE plane = ?1 AND key = ?2 AND pinned >= ?3)", sums, from);
	TRY(store_sql_prepare(store->db, store->path, &store->pins.keep[table], text));
	/* There was no row: one without content says so. */
	snprintf(text, sizeof text,
		 "INSERT INTO replaced(plane, key, pinned) SELECT ?1, ?2, ?3 WHERE NOT EXISTS (SELECT 1 FROM %s WHERE key = ?2) AND "
		 "NOT EXISTS (SELECT 1 FROM replaced WHERE plane = ?1 AND key = ?2 AND pinned >= ?3)", from);
	return store_sql_prepare(store->db, store->path, &store->pins.none[table], text);
}

enum status store_pinned_keep(struct store *store, int table, uint64_t key)
{
	struct pins *pins = &store->pins;
	if (pins->label < 0)
		return STATUS_OK;
	TRY(prepare(store, (enum row_table)table));
	sqlite3_stmt *const statements[] = {pins->keep[table], pins->none[table]};
	for (int i = 0; i < 2; i++) {
		sqlite3_bind_int(statements[i], 1, table);
		sqlite3_bind_int64(statements[i], 2, (sqlite3_int64)key);
		sqlite3_bind_int64(statements[i], 3, pins->label);
		int code = sqlite3_step(statements[i]);
		enum status status = code == SQLITE_DONE ? STATUS_OK : store_sql_fail(store->db, code, store->path, keeping);
		sqlite3_reset(statements[i]);
		TRY(status);
		if (sqlite3_changes(store->db) > 0)
			break;
	}
	return STATUS_OK;
}

/* --- a pinned revision is shown --- */

enum status store_pinned_find(const struct store *store, uint64_t hash, int64_t *revision)
{
	sqlite3_stmt *statement = NULL;
	*revision = -1;
	if (store->version < STORE_VERSION_PINS)
		return STATUS_OK;
	enum status status = STATUS_OK;
	TRY(store_sql_prepare(store->db, store->path, &statement, "SELECT revision FROM main.pinned WHERE hash = ?1"));
	sqlite3_bind_int64(statement, 1, (sqlite3_int64)hash);
	int code = sqlite3_step(statement);
	if (code == SQLITE_ROW)
		*revision = sqlite3_column_int64(statement, 0);
	else if (code != SQLITE_DONE)
		status = store_sql_fail(store->db, code, store->path, "reading what overlays depend on");
	sqlite3_finalize(statement);
	return status;
}

enum status store_pinned_show(sqlite3 *db, const char *path, int64_t revision)
{
	static const char doing[] = "showing what an overlay depends on";
	char sql[1024];
	const long long at = revision;
	int64_t loose = 0, marks = 0;
	TRY(store_sql_exec(db, path, doing, "PRAGMA temp_store=MEMORY"));
	TRY(store_sql_integer(db, path, "SELECT count(*) FROM main.sqlite_schema WHERE name = 'settled'", &loose));
	TRY(store_sql_integer(db, path, "SELECT count(*) FROM main.sqlite_schema WHERE name = 'healed'", &marks));
	for (int table = ROW_OFFSET; table < (marks != 0 ? ROW_TABLES : loose != 0 ? ROW_HEALED : ROW_SETTLED); table++) { /* an older file lacks some tables, which are hidden */
		const char *name = store_rows_sql_name((enum row_table)table), *sums = table == ROW_OFFSET ? "below, above, " : "";
		snprintf(sql, sizeof sql,
			 "CREATE TEMP VIEW %s AS SELECT key, low, high, %scodec, revision, hash, blob FROM main.replaced AS kept "
			 "WHERE plane = %d AND pinned >= %lld AND codec IS NOT NULL AND NOT EXISTS (SELECT 1 FROM main.replaced AS other WHERE "
			 "other.plane = %d AND other.key = kept.key AND other.pinned >= %lld AND other.pinned < kept.pinned) UNION ALL "
			 "SELECT key, low, high, %scodec, revision, hash, blob FROM main.%s AS present WHERE NOT EXISTS (SELECT 1 FROM "
			 "main.replaced AS other WHERE other.plane = %d AND other.key = present.key AND other.pinned >= %lld)",
			 name, sums, table, at, table, at, sums, name, table, at);
		TRY(store_sql_exec(db, path, doing, sql));
	}
	snprintf(sql, sizeof sql,
		 "CREATE TEMP VIEW run AS SELECT 1 AS id, revision AS epoch, scene_hash, step, time, state, made, who, what FROM main.pinned "
		 "WHERE revision = %lld AND state IS NOT NULL", at);
	TRY(store_sql_exec(db, path, doing, sql));
	snprintf(sql, sizeof sql,
		 "CREATE TEMP VIEW meta AS SELECT key, value FROM main.meta WHERE key NOT IN ('working', 'compacted', 'relief') "
		 "UNION ALL SELECT 'working', working FROM main.pinned WHERE revision = %lld AND working IS NOT NULL "
		 "UNION ALL SELECT 'compacted', compacted FROM main.pinned WHERE revision = %lld AND compacted <> 0 "
		 "UNION ALL SELECT 'relief', relief FROM main.pinned WHERE revision = %lld AND relief IS NOT NULL", at, at, at);
	TRY(store_sql_exec(db, path, doing, sql));
	snprintf(sql, sizeof sql, "CREATE TEMP VIEW revision AS SELECT * FROM main.revision WHERE revision <= %lld", at);
	return store_sql_exec(db, path, doing, sql);
}

/* --- dropping --- */

/* A row is needed by the pinned revisions from after the kept row before it, up to its own number. */
static enum status drop_rows(struct store *store)
{
	return store_sql_exec(store->db, store->path, "dropping what no overlay needs",
			      "DELETE FROM replaced WHERE (plane, key, pinned) IN (SELECT plane, key, pinned FROM replaced AS kept WHERE NOT EXISTS "
			      "(SELECT 1 FROM pinned WHERE pinned.revision <= kept.pinned AND pinned.revision > coalesce((SELECT max(other.pinned) "
			      "FROM replaced AS other WHERE other.plane = kept.plane AND other.key = kept.key AND other.pinned < kept.pinned), -1)))");
}

enum status store_pinned_drop(struct store *store, bool (*wanted)(void *user, int64_t revision, uint64_t hash), void *user, int64_t *dropped)
{
	sqlite3_stmt *statement = NULL;
	int code;
	enum status status;
	*dropped = 0;
	if (store->version < STORE_VERSION_PINS)
		return STATUS_OK;
	TRY_OR(done, store_sql_prepare(store->db, store->path, &statement, "SELECT revision, hash FROM pinned"));
	while ((code = sqlite3_step(statement)) == SQLITE_ROW) {
		char sql[80];
		const int64_t revision = sqlite3_column_int64(statement, 0);
		if (wanted(user, revision, (uint64_t)sqlite3_column_int64(statement, 1)))
			continue;
		snprintf(sql, sizeof sql, "DELETE FROM pinned WHERE revision = %lld", (long long)revision);
		TRY_OR(done, store_sql_exec(store->db, store->path, "dropping what no overlay needs", sql));
		++*dropped;
	}
	if (code != SQLITE_DONE)
		TRY_OR(done, store_sql_fail(store->db, code, store->path, "reading what overlays depend on"));
done:
	sqlite3_finalize(statement);
	TRY(status);
	return *dropped > 0 ? drop_rows(store) : STATUS_OK;
}

enum status store_pinned_clear(struct store *store)
{
	return store->version < STORE_VERSION_PINS
		       ? STATUS_OK
		       : store_sql_exec(store->db, store->path, "dropping what overlays depend on", "DELETE FROM replaced; DELETE FROM pinned");
}
