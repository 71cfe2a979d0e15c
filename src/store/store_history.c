/*
 * Keeps what commits replace, so that the store can return to earlier revisions.
 *
 *   revision   7 (kept)        8 (kept)        9           10 (present)
 *   rows       label 7 ------> label 8 ------------------> the tables
 *
 * A row labelled 7 is as it was at revision 7. The file has it if a commit changed it before revision 8. So a tile at revision 7 is
 * its row with the least label from 7 on. Without such a row it is as it is now.
 *
 * A row has one of two forms. WHOLE has the posts. DELTA has the posts less those that the tile had afterwards: at the next label, or
 * now. Most of them are zero, so a delta is small. Where every revision is kept, rows are deltas. Between two snapshots, where the same row
 * may change many times, the first change keeps it whole and the others cost nothing. Where only the last revision is kept, rows are
 * copied as they are. The next commit drops them, so packing would take longer than what it saves.
 *
 * Only rows of the working level are kept. A restore makes the coarser ones anew.
 *
 * Invariants:
 *   1. The history is written in the transaction that replaces the rows.
 *   2. All rows of the history are of one level. A store with a history is deformed at no other.
 *   3. The labels of rows are in the table of kept revisions.
 */
#include "store/internal.h"

#include <stdio.h>
#include <string.h>
#include <xxhash.h>

enum form { WHOLE, DELTA };

static size_t tile_count(const struct store *store)
{
	size_t side = tile_posts(&store->meta.extent);
	return side * side;
}

uint64_t store_history_hash(const struct history_row *row)
{
	const uint64_t words[] = {(uint64_t)row->table, row->key, (uint64_t)row->revision, (uint64_t)row->form, (uint64_t)row->codec};
	uint8_t head[sizeof words];
	for (size_t i = 0; i < sizeof head; i++)
		head[i] = (uint8_t)(words[i / 8] >> i % 8 * 8);
	return XXH3_64bits_withSeed(row->bytes, row->size, XXH3_64bits(head, sizeof head));
}

/* --- a life --- */

enum status store_history_open(struct store *store)
{
	struct history *history = &store->history;
	int64_t key;
	history->label = -1;
	TRY(store_sql_integer(store->db, store->path, "SELECT coalesce(max(revision), -1) FROM revision", &history->kept));
	TRY(store_sql_integer(store->db, store->path, "SELECT coalesce((SELECT key FROM history LIMIT 1), -1)", &key));
	history->has_level = key >= 0;
	history->level = tile_from_key((uint64_t)key).level;
	if (history->kept > store->commit || (history->has_level && store->has_working && history->level != store->working))
		return fail_with(STATUS_INPUT, "%s: its history is not its own; the store is damaged, restore it", store->path);
	return STATUS_OK;
}

bool store_has_history(const struct store *store)
{
	return store->history.each || store->history.last || store->history.kept >= 0;
}

void store_history_finish(struct store *store)
{
	struct history *history = &store->history;
	sqlite3_finalize(history->find);
	sqlite3_finalize(history->put);
	sqlite3_finalize(history->put_first);
	store_rows_finish(&history->rows);
	mem_free_all(history->before, history->after);
	history->find = history->put = history->put_first = NULL;
	history->before = history->after = NULL;
}

/* Makes the buffers and the second set of statements, which most stores never need. */
static enum status prepare(struct store *store)
{
	struct history *history = &store->history;
	enum status status;
	if (history->after != NULL)
		return STATUS_OK;
	store_history_finish(store);
	history->before = mem_alloc(tile_count(store), sizeof *history->before);
	history->after = mem_alloc(tile_count(store), sizeof *history->after);
	if (history->before == NULL || history->after == NULL)
		TRY_OR(failed, fail_memory("a history"));
	TRY_OR(failed, store_rows_init(&history->rows, store->db, store->path, &store->meta.extent, CODEC_SMALL));
	history->rows.lineage = store->rows.lineage;
	history->rows.layers = store->rows.layers;
	history->rows.statements = &store->statements;
	return STATUS_OK;
failed:
	store_history_finish(store);
	return status;
}

/* --- a transaction --- */

/* *written: the rows that the statement wrote. */
static enum status keep_by(struct store *store, const char *text, int *written)
{
	sqlite3_stmt *statement = NULL;
	TRY(store_sql_prepare(store->db, store->path, &statement, text));
	if (store->working_stored)
		sqlite3_bind_int(statement, 1, store->working);
	sqlite3_bind_int64(statement, 2, store->compacted);
	sqlite3_bind_int64(statement, 3, store->commit); /* the first text has no such parameter: no harm */
	atomic_fetch_add_explicit(&store->statements.revisions, 1, memory_order_relaxed);
	int code = sqlite3_step(statement);
	enum status status = code == SQLITE_DONE ? STATUS_OK : store_sql_fail(store->db, code, store->path, "keeping a revision");
	*written = sqlite3_changes(store->db);
	sqlite3_finalize(statement);
	return status;
}

enum status store_history_keep(struct store *store)
{
	if (store->history.kept == store->commit)
		return STATUS_OK;
	static const char *const texts[] = {
		"INSERT INTO revision SELECT epoch, scene_hash, step, time, state, made, who, what, ?1, ?2 FROM run",
		/* a store without a run: as it was imported, or an overlay as it was made */
		"INSERT INTO revision VALUES(?3, '', 0, 0, '', 0, '', '', ?1, ?2)",
	};
	int written = 0;
	for (int i = 0; i < 2 && written == 0; i++)
		TRY(keep_by(store, texts[i], &written));
	return store_meta_keep_added(store);
}

/* What no commit needs that keeps only the last revision. Claims of a part stay. */
static enum status drop_older(struct store *store)
{
	char sql[96];
	snprintf(sql, sizeof sql, "DELETE FROM history WHERE plane > %d; DELETE FROM revision WHERE revision < %lld", PART_CLAIM,
		 (long long)store->commit);
	TRY(store_meta_forget_added(store));
	return store_sql_exec(store->db, store->path, "dropping what is older", sql);
}

enum status store_history_begin(struct store *store, bool always)
{
	struct history *history = &store->history;
	history->deltas = always || history->each;
	history->copies = history->last && !always;
	history->label = history->deltas || history->copies ? store->commit : history->kept;
	history->before_read = false;
	TRY(store_pinned_begin(store));
	if (history->label < 0)
		return STATUS_OK;
	TRY(prepare(store));
	if (history->deltas || history->copies)
		TRY(store_history_keep(store));
	return history->copies ? drop_older(store) : STATUS_OK;
}

enum status store_history_end(struct store *store, enum status status)
{
	struct history *history = &store->history;
	const bool committed = status == STATUS_OK;
	if (committed && history->label > history->kept)
		history->kept = history->label;
	history->label = -1;
	store_pinned_end(store, committed);
	if (!committed) {
		store_sql_undo(store->db);
		store_changes_drop(&store->changes);
	}
	return status;
}

/* --- rows --- */

static enum status bad(const struct store *store, const struct history_row *row, const char *why)
{
	struct tile tile = tile_from_key(row->key);
	return fail_with(STATUS_INPUT, "%s: history of revision %lld, %s tile level %d x %u y %u: %s; the store is damaged, restore it",
			 store->path, (long long)row->revision, store_rows_name(row->table), tile.level, tile.x, tile.y, why);
}

/* Adds a row of the history to the posts that follow it in time, or puts it in their place. `statement`: form, codec, hash, blob. */
static enum status apply(struct store *store, struct history_row *row, sqlite3_stmt *statement, int column, int32_t *posts)
{
	struct history *history = &store->history;
	row->form = sqlite3_column_int64(statement, column);
	row->codec = sqlite3_column_int64(statement, column + 1);
	row->bytes = sqlite3_column_blob(statement, column + 3);
	row->size = (size_t)sqlite3_column_bytes(statement, column + 3);
	if (row->bytes == NULL || (row->form != WHOLE && row->form != DELTA) ||
	    store_history_hash(row) != (uint64_t)sqlite3_column_int64(statement, column + 2))
		return bad(store, row, "its hash is wrong");
	if (!store_codec_decode(&history->rows.codec, row->codec, row->bytes, row->size, history->after))
		return bad(store, row, "it cannot be decoded");
	size_t count = tile_count(store);
	for (size_t i = 0; i < count; i++)
		posts[i] = (int32_t)((uint32_t)history->after[i] + (row->form == DELTA ? (uint32_t)posts[i] : 0));
	return STATUS_OK;
}

/* Finds the row of a tile that is kept of just this revision. The caller resets history->find, whose columns are form, codec, hash, blob. */
static enum status find_kept(struct store *store, const struct history_row *row, bool *found)
{
	sqlite3_stmt **find = &store->history.find;
	*found = false;
	TRY(store_sql_prepare(store->db, store->path, find,
			      "SELECT form, codec, hash, blob FROM history WHERE plane = ?1 AND key = ?2 AND revision = ?3"));
	sqlite3_bind_int(*find, 1, (int)row->table);
	sqlite3_bind_int64(*find, 2, (sqlite3_int64)row->key);
	sqlite3_bind_int64(*find, 3, row->revision);
	int code = sqlite3_step(*find);
	*found = code == SQLITE_ROW;
	return *found || code == SQLITE_DONE ? STATUS_OK : store_sql_fail(store->db, code, store->path, "reading its history");
}

enum status store_history_kept(struct store *store, enum row_table table, struct tile tile, int64_t revision, int32_t *posts, bool *found)
{
	struct history_row row = {.table = table, .key = tile_key(tile), .revision = revision};
	enum status status;
	TRY_OR(done, prepare(store));
	TRY_OR(done, find_kept(store, &row, found));
	if (*found && sqlite3_column_int(store->history.find, 0) != WHOLE)
		TRY_OR(done, bad(store, &row, "it is not whole"));
	if (*found && posts != NULL)
		TRY_OR(done, apply(store, &row, store->history.find, 0, posts));
done:
	sqlite3_reset(store->history.find);
	return status;
}

static enum status present_posts(struct store *store, enum row_table table, struct tile tile, int32_t *posts)
{
	struct row row;
	bool found;
	TRY(store_rows_read(&store->history.rows, table, tile, posts, &row, &found));
	if (!found)
		memset(posts, 0, tile_count(store) * sizeof *posts);
	return STATUS_OK;
}

enum status store_history_posts(struct store *store, enum row_table table, struct tile tile, int64_t revision, int32_t *posts)
{
	sqlite3_stmt *statement = NULL;
	struct history_row row = {.table = table, .key = tile_key(tile)};
	enum status status = STATUS_OK;
	int code;
	TRY(prepare(store));
	TRY(present_posts(store, table, tile, posts));
	TRY(store_sql_prepare(store->db, store->path, &statement,
			      "SELECT revision, form, codec, hash, blob FROM history WHERE plane = ?1 AND key = ?2 AND "
			      "revision >= ?3 ORDER BY revision DESC"));
	sqlite3_bind_int(statement, 1, (int)table);
	sqlite3_bind_int64(statement, 2, (sqlite3_int64)row.key);
	sqlite3_bind_int64(statement, 3, revision);
	while ((code = sqlite3_step(statement)) != SQLITE_DONE) {
		row.revision = sqlite3_column_int64(statement, 0);
		TRY_OR(done, code == SQLITE_ROW ? apply(store, &row, statement, 1, posts)
						: store_sql_fail(store->db, code, store->path, "reading its history"));
	}
done:
	sqlite3_finalize(statement);
	return status;
}

/* Of rows that are kept as they are, the first of a label counts. Of differences, the last has them all. */
enum status store_history_put(struct store *store, const struct history_row *row)
{
#define VALUES " INTO history(plane, key, revision, form, codec, hash, blob) VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7)"
	struct history *history = &store->history;
	sqlite3_stmt **to = history->copies ? &history->put_first : &history->put;
	TRY(store_sql_prepare(store->db, store->path, to, history->copies ? "INSERT OR IGNORE" VALUES : "INSERT OR REPLACE" VALUES));
	sqlite3_bind_int(*to, 1, (int)row->table);
	sqlite3_bind_int64(*to, 2, (sqlite3_int64)row->key);
	sqlite3_bind_int64(*to, 3, row->revision);
	sqlite3_bind_int64(*to, 4, row->form);
	sqlite3_bind_int64(*to, 5, row->codec);
	sqlite3_bind_int64(*to, 6, (sqlite3_int64)store_history_hash(row));
	sqlite3_bind_blob64(*to, 7, row->bytes, row->size, SQLITE_STATIC);
	int code = sqlite3_step(*to);
	enum status status = code == SQLITE_DONE ? STATUS_OK : store_sql_fail(store->db, code, store->path, "writing its history");
	sqlite3_reset(*to);
	sqlite3_bind_null(*to, 7);
	TRY(status);
	history->has_level = true;
	history->level = store->working;
	return STATUS_OK;
}

/* Encodes `posts` and writes them. */
static enum status put_posts(struct store *store, enum row_table table, struct tile tile, enum form form, const int32_t *posts)
{
	struct history_row row = {.table = table, .key = tile_key(tile), .revision = store->history.label, .form = form};
	row.codec = store_codec_encode(&store->history.rows.codec, posts, &row.bytes, &row.size);
	atomic_fetch_add_explicit(&store->statements.kept[table], 1, memory_order_relaxed);
	return store_history_put(store, &row);
}

struct copying {
	struct store *store;
	struct history_row row;
};

static enum status put_copy(void *user, const struct row *now)
{
	static const int32_t zero = 0;
	struct copying *copying = user;
	struct history_row *row = &copying->row;
	row->codec = now != NULL ? now->codec : CODEC_CONSTANT;
	row->bytes = now != NULL ? now->bytes : &zero;
	row->size = now != NULL ? now->size : sizeof zero;
	atomic_fetch_add_explicit(&copying->store->statements.kept[row->table], 1, memory_order_relaxed);
	return store_history_put(copying->store, row);
}

enum status store_history_before(struct store *store, enum row_table table, struct tile tile)
{
	struct history *history = &store->history;
	struct history_row row = {.table = table, .key = tile_key(tile), .revision = history->label};
	bool found = false, whole = false;
	enum status status;
	history->before_read = false;
	if (history->label < 0 || tile.level != store->working)
		return STATUS_OK;
	if (history->copies)
		return store_rows_bytes(&store->rows, table, tile, put_copy, &(struct copying){store, row});
	atomic_fetch_add_explicit(&store->statements.sought, 1, memory_order_relaxed);
	TRY_OR(done, find_kept(store, &row, &found));
	whole = found && sqlite3_column_int(history->find, 0) == WHOLE;
	if (!whole)
		TRY_OR(done, present_posts(store, table, tile, history->before));
	if (found && !whole)
		TRY_OR(done, apply(store, &row, history->find, 0, history->before));
done:
	sqlite3_reset(history->find);
	TRY(status);
	if (!found && !history->deltas)
		return put_posts(store, table, tile, WHOLE, history->before);
	history->before_read = !whole;
	return STATUS_OK;
}

enum status store_history_after(struct store *store, enum row_table table, struct tile tile, const int32_t *posts)
{
	struct history *history = &store->history;
	if (!history->before_read)
		return STATUS_OK;
	size_t count = tile_count(store);
	for (size_t i = 0; i < count; i++)
		history->after[i] = (int32_t)((uint32_t)history->before[i] - (posts != NULL ? (uint32_t)posts[i] : 0));
	history->before_read = false;
	return put_posts(store, table, tile, DELTA, history->after);
}

enum status store_history_after_read(struct store *store, enum row_table table, struct tile tile)
{
	struct history *history = &store->history;
	if (!history->before_read)
		return STATUS_OK;
	TRY(present_posts(store, table, tile, history->after));
	return store_history_after(store, table, tile, history->after);
}
