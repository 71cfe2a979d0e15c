/*
 * Parts: the overlays of the processes of one run, until they are gathered (store_gather.c).
 *
 * A part is an overlay that inherits, whatever it is over. Its header has its number and that of the run. Its history has two
 * kinds of rows:
 *
 *   what the last commit replaced, as keep_last does;
 *   claims: for each tile of which it committed a page, the number of that commit. A claim has the tile's key, that number for its
 *   revision, and no content.
 *
 * So it is known which part has a tile's last page, even where a page has no row because it equals what is inherited. Of each tile there are
 * at most two claims: one of the last commit, and one of an earlier one.
 */
#include "store/internal.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/random.h>

enum status store_part_run(uint64_t *run)
{
	ssize_t got;
	do
		got = getrandom(run, sizeof *run, 0);
	while (got < 0 && errno == EINTR);
	return got == (ssize_t)sizeof *run ? STATUS_OK
					   : fail_with(STATUS_FAILED, "a number for a run: %s; try again", strerror(errno));
}

enum status store_create_part(const char *path, const char *over, const struct store_part *part)
{
	if (part->index >= part->count || part->count > STORE_PARTS_MOST)
		return fail_with(STATUS_USAGE, "%s: it cannot be part %u of %u; count from 0, and make at most %d parts", path, part->index,
				 part->count, STORE_PARTS_MOST);
	return store_overlay_make(path, over, NULL, part, NULL, NULL);
}

enum status store_part_refuse(const struct store *store, const char *what)
{
	return store->part.count == 0 ? STATUS_OK
				      : fail_with(STATUS_INPUT, "%s: it is part %u of a run of %u processes, and cannot be %s alone; do that with %s",
						  store->path, store->part.index, store->part.count, what,
						  store->under != NULL ? store->under->path : "what it is over");
}

/* --- claims --- */

static enum status step(struct store *store, sqlite3_stmt *statement, const char *doing)
{
	int code = sqlite3_step(statement);
	enum status status = code == SQLITE_DONE ? STATUS_OK : store_sql_fail(store->db, code, store->path, doing);
	sqlite3_reset(statement);
	return status;
}

enum status store_part_claim(struct store *store, const struct store_page *pages, size_t count)
{
	static const int32_t nothing = 0;
	sqlite3_stmt *drop = NULL;
	/* Earlier claims, but for the last of them. */
	enum status status;
	TRY_OR(done, store_sql_prepare(store->db, store->path, &drop,
				       "DELETE FROM history WHERE plane = ?1 AND key = ?2 AND revision < "
				       "(SELECT max(revision) FROM history WHERE plane = ?1 AND key = ?2)"));
	for (size_t i = 0; i < count; i++) {
		const struct history_row row = {
			.table = PART_CLAIM, .key = tile_key(pages[i].tile), .revision = store->commit + 1,
			.codec = CODEC_CONSTANT, .bytes = &nothing, .size = sizeof nothing,
		};
		sqlite3_bind_int(drop, 1, PART_CLAIM);
		sqlite3_bind_int64(drop, 2, (sqlite3_int64)row.key);
		TRY_OR(done, step(store, drop, "claiming its tiles"));
		TRY_OR(done, store_history_put(store, &row));
	}
done:
	sqlite3_finalize(drop);
	return status;
}

/* Checks a claim. Columns: key, revision, form, codec, hash, blob. */
static enum status check_claim(struct store *part, sqlite3_stmt *statement)
{
	const struct history_row row = {
		.table = PART_CLAIM,
		.key = (uint64_t)sqlite3_column_int64(statement, 0),
		.revision = sqlite3_column_int64(statement, 1),
		.form = sqlite3_column_int64(statement, 2),
		.codec = sqlite3_column_int64(statement, 3),
		.bytes = sqlite3_column_blob(statement, 5),
		.size = (size_t)sqlite3_column_bytes(statement, 5),
	};
	struct tile tile = tile_from_key(row.key);
	bool good = part->working_stored && tile_key(tile) == row.key && tile.level == part->working && extent_has(&part->meta.extent, tile) &&
		    row.bytes != NULL && row.revision > part->parent_revision && row.revision <= part->commit &&
		    store_history_hash(&row) == (uint64_t)sqlite3_column_int64(statement, 4);
	return good ? STATUS_OK
		    : fail_with(STATUS_INPUT, "%s: what it says of the commits of tile level %d x %u y %u is wrong; it is damaged, restore it",
				part->path, tile.level, tile.x, tile.y);
}

enum status store_part_claims(struct store *part, int64_t commit, part_claim_fn fn, void *user)
{
	sqlite3_stmt *statement = NULL;
	uint64_t key = 0;
	int64_t last = -1; /* of `key` */
	enum status status = STATUS_OK;
	int code;
	TRY(store_sql_prepare(part->db, part->path, &statement,
			      "SELECT key, revision, form, codec, hash, blob FROM history WHERE plane = ?1 ORDER BY key, revision"));
	sqlite3_bind_int(statement, 1, PART_CLAIM);
	while ((code = sqlite3_step(statement)) != SQLITE_DONE) {
		TRY_OR(done, code == SQLITE_ROW ? check_claim(part, statement) : store_sql_fail(part->db, code, part->path, "reading its history"));
		if (sqlite3_column_int64(statement, 1) > commit)
			continue;
		uint64_t next = (uint64_t)sqlite3_column_int64(statement, 0);
		if (last >= 0 && next != key)
			TRY_OR(done, fn(user, key, last));
		key = next;
		last = sqlite3_column_int64(statement, 1);
	}
done:
	sqlite3_finalize(statement);
	TRY(status);
	return last >= 0 ? fn(user, key, last) : STATUS_OK;
}

/* --- what it has --- */

enum status store_part_open(const char *path, struct store **out)
{
	struct store *part = NULL;
	enum status status;
	TRY(store_open_alone(path, &part));
	if (part->part.count == 0)
		TRY_OR(failed, fail_with(STATUS_INPUT, "%s: it is not a part of a run; name the files that a run of several processes made", path));
	TRY_OR(failed, store_overlay_hold(part, part->db)); /* all that is read of it is of one commit */
	*out = part;
	return STATUS_OK;
failed:
	store_close(part);
	return status;
}

enum status store_part_posts(struct store *part, enum row_table table, struct tile tile, int64_t commit, int32_t *posts, bool *found)
{
	struct row row;
	*found = false;
	if (commit < part->commit) {
		TRY(store_history_kept(part, table, tile, commit, posts, found));
		if (*found)
			return STATUS_OK;
	}
	return posts != NULL ? store_rows_read(&part->rows, table, tile, posts, &row, found)
			     : store_rows_head(&part->rows, table, tile, &row, found);
}

enum status store_part_each(struct store *part, enum row_table table, int64_t commit, store_key_fn fn, void *user)
{
	sqlite3_stmt *statement = NULL;
	enum status status = STATUS_OK;
	int code;
	char sql[160];
	snprintf(sql, sizeof sql, "SELECT key FROM %s UNION SELECT key FROM history WHERE plane = ?1 AND revision = ?2 ORDER BY key",
		 store_rows_sql_name(table));
	TRY(store_sql_prepare(part->db, part->path, &statement, sql));
	sqlite3_bind_int(statement, 1, (int)table);
	sqlite3_bind_int64(statement, 2, commit);
	while ((code = sqlite3_step(statement)) != SQLITE_DONE) {
		uint64_t key = (uint64_t)sqlite3_column_int64(statement, 0);
		struct tile tile = tile_from_key(key);
		if (code != SQLITE_ROW)
			TRY_OR(done, store_sql_fail(part->db, code, part->path, "reading its tiles"));
		if (tile_key(tile) != key || tile.level != part->working || !extent_has(&part->meta.extent, tile))
			TRY_OR(done, fail_with(STATUS_INPUT, "%s: it has a tile outside its terrain; the store is damaged, restore it", part->path));
		TRY_OR(done, fn(user, key));
	}
done:
	sqlite3_finalize(statement);
	return status;
}
