/*
 * Returns a store to a revision that it keeps, in one transaction.
 *
 *   BEGIN -> the present revision is kept -> tiles that changed since are written as they were -> header and run's record -> COMMIT
 *
 * A restore is a revision itself. So it can be undone by another one.
 */
#include "store/internal.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>

/* A kept revision, as its table has it. */
struct kept {
	struct store_run_copy run; /* its commit is the revision */
	struct store_run_header header;
};

struct restoring {
	struct store *store;
	int64_t revision;
	struct climb_item *items; /* of one table */
	size_t count, room;
};

/* Returns true if the text names the revision of the parent at which an overlay begins, and the overlay keeps it. */
static bool inherited_name(const struct store *store, const char *name)
{
	sqlite3_stmt *statement = NULL;
	char kept[96];
	int64_t own = 0;
	bool same = false;
	snprintf(kept, sizeof kept, "SELECT count(*) FROM revision WHERE revision = %lld", (long long)store->parent_revision);
	if (!store->inherits || store_sql_integer(store->db, store->path, kept, &own) != STATUS_OK || own == 0 ||
	    store_sql_prepare(store->under->db, store->under->path, &statement, "SELECT revision FROM snapshot WHERE name = ?1") != STATUS_OK)
		return false;
	sqlite3_bind_text(statement, 1, name, -1, SQLITE_STATIC);
	same = sqlite3_step(statement) == SQLITE_ROW && sqlite3_column_int64(statement, 0) == store->parent_revision;
	sqlite3_finalize(statement);
	return same;
}

/* Finds what the text names: a number of a revision, or a snapshot. *revision is the present one if the text names that. */
static enum status find_revision(struct store *store, const char *text, int64_t *revision)
{
	char *end;
	*revision = strtoll(text, &end, 10);
	bool number = *text >= '0' && *text <= '9' && *end == '\0';
	sqlite3_stmt *statement = NULL;
	enum status status = STATUS_OK;
	TRY(store_sql_prepare(store->db, store->path, &statement, number ? "SELECT revision FROM revision WHERE revision = ?1"
									 : "SELECT revision FROM snapshot WHERE name = ?2"));
	if (number)
		sqlite3_bind_int64(statement, 1, *revision);
	else
		sqlite3_bind_text(statement, 2, text, -1, SQLITE_STATIC);
	int code = sqlite3_step(statement);
	if (code == SQLITE_ROW)
		*revision = sqlite3_column_int64(statement, 0);
	else if (code != SQLITE_DONE)
		status = store_sql_fail(store->db, code, store->path, "reading its history");
	else if (!number && inherited_name(store, text))
		*revision = store->parent_revision;
	else if (!number || *revision != store->commit)
		status = fail_with(STATUS_INPUT, "%s: it keeps no %s %s; furrow log tells what it keeps", store->path,
				   number ? "revision" : "snapshot", text);
	sqlite3_finalize(statement);
	return status;
}

/* --- which tiles changed since --- */

static enum status add(struct restoring *restoring, uint64_t key)
{
	const struct store *store = restoring->store;
	struct tile tile = tile_from_key(key);
	if (tile_key(tile) != key || tile.level != store->history.level || !extent_has(&store->meta.extent, tile))
		return fail_with(STATUS_INPUT, "%s: its history has a tile outside its terrain; the store is damaged, restore it", store->path);
	TRY(mem_grow(&restoring->items, &restoring->room, restoring->count + 1, sizeof *restoring->items, "a restore"));
	restoring->items[restoring->count++] = (struct climb_item){.key = key};
	return STATUS_OK;
}

/* Finds each tile of a table that has a row of the history from the revision on. Skips from tile to tile, past their rows. */
static enum status find_tiles(struct restoring *restoring, enum row_table table)
{
	struct store *store = restoring->store;
	sqlite3_stmt *next = NULL, *any = NULL;
	int64_t key = -1;
	int code = SQLITE_ROW;
	restoring->count = 0;
	enum status status;
	TRY_OR(done, store_sql_prepare(store->db, store->path, &next, "SELECT key FROM history WHERE plane = ?1 AND key > ?2 ORDER BY key LIMIT 1"));
	TRY_OR(done, store_sql_prepare(store->db, store->path, &any,
				       "SELECT 1 FROM history WHERE plane = ?1 AND key = ?2 AND revision >= ?3 LIMIT 1"));
	while (code == SQLITE_ROW) {
		sqlite3_reset(next);
		sqlite3_bind_int(next, 1, (int)table);
		sqlite3_bind_int64(next, 2, key);
		code = sqlite3_step(next);
		if (code != SQLITE_ROW)
			break;
		key = sqlite3_column_int64(next, 0);
		sqlite3_reset(any);
		sqlite3_bind_int(any, 1, (int)table);
		sqlite3_bind_int64(any, 2, key);
		sqlite3_bind_int64(any, 3, restoring->revision);
		code = sqlite3_step(any);
		if (code == SQLITE_ROW)
			TRY_OR(done, add(restoring, (uint64_t)key));
		code = code == SQLITE_DONE ? SQLITE_ROW : code;
	}
	if (code != SQLITE_DONE)
		TRY_OR(done, store_sql_fail(store->db, code, store->path, "reading its history"));
done:
	sqlite3_finalize(next);
	sqlite3_finalize(any);
	return status;
}

/* --- back --- */

static enum status posts_then(void *user, enum row_table table, const struct climb_item *item, int32_t *scratch, const int32_t **posts)
{
	const struct restoring *restoring = user;
	*posts = scratch;
	return store_history_posts(restoring->store, table, tile_from_key(item->key), restoring->revision, scratch);
}

static enum status put_state(struct restoring *restoring, enum row_table table, struct store_commit_result *result)
{
	size_t side = tile_posts(&restoring->store->meta.extent);
	const int32_t *posts;
	int32_t *scratch = mem_alloc(side * side, sizeof *scratch);
	enum status status = STATUS_OK;
	TRY_MEM(scratch, "a restore");
	for (size_t i = 0; i < restoring->count; i++) {
		TRY_OR(done, posts_then(restoring, table, &restoring->items[i], scratch, &posts));
		TRY_OR(done, store_state_put_tile(restoring->store, table, tile_from_key(restoring->items[i].key), posts, result));
	}
done:
	mem_free(scratch);
	return status;
}

static enum status put_tiles(struct restoring *restoring)
{
	const struct climb_source source = {restoring, posts_then};
	const struct store_run run = {0};
	struct store_commit_result result = {0};
	struct store *store = restoring->store;
	for (int table = ROW_OFFSET; table < ROW_TABLES; table++) {
		TRY(find_tiles(restoring, (enum row_table)table));
		if (row_is_state((enum row_table)table))
			TRY(put_state(restoring, (enum row_table)table, &result));
		else
			TRY(store_climb(store, (enum row_table)table, restoring->items, restoring->count, &source, &run, &result));
	}
	return STATUS_OK;
}

static enum status put_header(struct store *store, struct kept *kept)
{
	char what[48];
	snprintf(what, sizeof what, "restore %lld", (long long)kept->run.commit);
	if (kept->header.has_working)
		TRY(store_meta_put_working(store, store->working, store->relief_text));
	else
		TRY(store_meta_drop(store, "working"));
	TRY(kept->header.compacted != 0 ? store_meta_put_integer(store, "compacted", kept->header.compacted) : store_meta_drop(store, "compacted"));
	TRY(store_meta_put_added(store, kept->header.added));
	const struct store_run run = {.scene_hash = kept->run.scene_hash, .step = kept->run.step, .time = kept->run.time, .what = what};
	return store_run_put(store, &run, kept->run.state);
}

static enum status put_all(struct restoring *restoring, struct kept *kept)
{
	struct store *store = restoring->store;
	TRY(store_history_begin(store, true));
	TRY(put_tiles(restoring));
	TRY(put_header(store, kept));
	TRY(store_changes_reserve(&store->changes));
	return store_sql_exec(store->db, store->path, "restoring it", "COMMIT");
}

static enum status restore(struct store *store, struct kept *kept)
{
	struct restoring restoring = {.store = store, .revision = kept->run.commit};
	const bool had_working = store->has_working;
	const int working = store->working;
	enum status status;
	if (store->history.has_level) { /* the present revision may be of ground that was never deformed */
		store->has_working = true;
		store->working = store->history.level;
	}
	TRY_OR(failed, store_sql_begin(store->db, store->path, "restoring it"));
	TRY_OR(failed, store_history_end(store, put_all(&restoring, kept)));
	mem_free(restoring.items);
	return STATUS_OK;
failed:
	mem_free(restoring.items);
	store->has_working = had_working;
	store->working = working;
	return status;
}

/* After the commit: sets what is kept in memory to what was restored. */
static enum status take_restored(struct store *store, const struct kept *kept)
{
	store->commit++;
	store_changes_commit(&store->changes, store->commit);
	store->has_working = store->working_stored = kept->header.has_working;
	store->compacted = kept->header.compacted;
	store->added = kept->header.added;
	store->marked = false;
	for (int table = 0; table < ROW_TABLES; table++)
		store->state_rows[table] = STATE_UNKNOWN;
	return store_relief_settle(store);
}

enum status store_restore(struct store *store, const char *text, int64_t *revision)
{
	struct kept kept = {0};
	assert(store->writing);
	TRY(store_part_refuse(store, "restored"));
	TRY(find_revision(store, text, revision));
	if (*revision == store->commit)
		return STATUS_OK;
	enum status status;
	TRY_OR(done, store_run_copy_kept(store, *revision, &kept.run, &kept.header));
	/* Where nothing has a row, no drive left a rut, and nothing tells which level it had. */
	kept.header.has_working = kept.header.has_working && (store->has_working || store->history.has_level);
	TRY_OR(done, restore(store, &kept));
	TRY_OR(done, take_restored(store, &kept));
done:
	store_run_copy_finish(&kept.run);
	return status;
}
