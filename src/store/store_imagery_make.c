/*
 * Writes imagery into a plain store that is open for writing.
 *
 *   begin -> put ... (a commit from time to time) -> finish: it has imagery
 *                                                 -> suspend: rows and the request stay, for an import that goes on
 *                                                 -> drop: the table goes, and the store is one of version 8 again
 *
 * Invariants:
 *   1. While rows are put, the header has `imagery_request` and no `imagery_level`. Both change in the transaction of the last row.
 *   2. The base and its hash do not change. So overlays go on.
 */
#include "store/internal.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>
#include <xxhash.h>

#define COMMIT_BYTES (32 << 20)
#define COMMIT_SECONDS 2.0

static const char doing[] = "writing its imagery";

static enum status begin(struct store *store)
{
	store->uncommitted = 0;
	store->committed = clock_seconds();
	return store_sql_begin(store->db, store->path, doing);
}

static enum status commit(struct store *store)
{
	TRY(store_sql_exec(store->db, store->path, doing, "COMMIT"));
	return store_bound_wal(store);
}

/* Looks at what the store has. *goes_on: rows of the same import are there. */
static enum status look(struct store *store, const struct store_imagery_making *making, bool *goes_on)
{
	struct store_imagery has;
	*goes_on = false;
	TRY(store_imagery_info(store, &has));
	if (has.found && !making->overwrite)
		return fail_with(STATUS_INPUT, "%s: it has imagery already; give --overwrite to replace the imagery", store->path);
	if (!has.broken_off || !making->resume)
		return STATUS_OK;
	char *request = NULL;
	TRY(store_meta_find_text(store, "imagery_request", &request));
	*goes_on = request != NULL && strcmp(request, making->request) == 0;
	mem_free(request);
	if (!*goes_on)
		return fail_with(STATUS_INPUT, "%s: the import of imagery that was broken off was another one; give the same sources and options, or leave out "
				 "--resume to begin anew", store->path);
	return STATUS_OK;
}

static enum status clear(struct store *store)
{
	static const char *const keys[] = {"imagery_level", "imagery_quality", "imagery_sources", "imagery_hash", "imagery_request"};
	for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
		TRY(store_meta_drop(store, keys[i]));
	return store_sql_exec(store->db, store->path, doing, "DELETE FROM imagery");
}

static enum status open_table(struct store *store, const struct store_imagery_making *making, bool goes_on)
{
	TRY(store_schema_add_imagery(store));
	if (goes_on)
		return STATUS_OK;
	TRY(clear(store));
	TRY(store_meta_put_text(store, "imagery_request", making->request));
	TRY(store_meta_put_integer(store, "imagery_quality", making->quality));
	return store_meta_put_text(store, "imagery_sources", making->sources);
}

enum status store_imagery_begin(struct store *store, const struct store_imagery_making *making, int64_t *tiles)
{
	bool goes_on = false;
	assert(store->writing && !store->late);
	*tiles = 0;
	TRY(store_imagery_check(store->path));
	if (store->base_path != NULL)
		return fail_with(STATUS_INPUT, "%s: it is an overlay, and imagery is part of the terrain; name the store under it, %s", store->path,
				 store_base_path(store));
	TRY(store_place_check(store));
	TRY(look(store, making, &goes_on));
	TRY(begin(store));
	enum status status;
	TRY_OR(failed, open_table(store, making, goes_on));
	TRY_OR(failed, commit(store));
	store->version = STORE_VERSION_IMAGERY;
	store->has_imagery = false;
	TRY(store_sql_integer(store->db, store->path, "SELECT count(*) FROM imagery", tiles));
	TRY(begin(store));
	store->imagery_made = true;
	return STATUS_OK;
failed:
	store_sql_undo(store->db);
	return status;
}

enum status store_imagery_has(struct store *store, struct tile tile, bool *has)
{
	char sql[96];
	int64_t count = 0;
	snprintf(sql, sizeof sql, "SELECT count(*) FROM imagery WHERE key = %lld", (long long)tile_key(tile));
	TRY(store_sql_integer(store->db, store->path, sql, &count));
	*has = count > 0;
	return STATUS_OK;
}

static enum status put_row(sqlite3 *db, const char *path, int64_t key, int64_t codec, const void *bytes, size_t size)
{
	sqlite3_stmt *statement = NULL;
	enum status status;
	TRY_OR(done, store_sql_prepare(db, path, &statement, "INSERT OR REPLACE INTO imagery VALUES(?, ?, ?, ?)"));
	sqlite3_bind_int64(statement, 1, key);
	sqlite3_bind_int64(statement, 2, codec);
	sqlite3_bind_int64(statement, 3, (sqlite3_int64)store_imagery_row_hash((uint64_t)key, codec, bytes, size));
	sqlite3_bind_blob64(statement, 4, bytes, size, SQLITE_STATIC);
	const int code = sqlite3_step(statement);
	if (code != SQLITE_DONE)
		TRY_OR(done, store_sql_fail(db, code, path, doing));
done:
	sqlite3_finalize(statement);
	return status;
}

enum status store_imagery_put(struct store *store, struct tile tile, const void *packed, size_t size)
{
	assert(store->imagery_made && extent_has(&store->meta.extent, tile));
	TRY(put_row(store->db, store->path, (int64_t)tile_key(tile), STORE_IMAGERY_WEBP, packed, size));
	store->uncommitted += (int64_t)size;
	if (store->uncommitted < COMMIT_BYTES && clock_seconds() - store->committed < COMMIT_SECONDS)
		return STATUS_OK;
	TRY(commit(store));
	return begin(store);
}

/* The finest level is in the rows with the lowest keys. */
static enum status put_header(struct store *store)
{
	uint64_t hash = 0;
	int64_t key = 0;
	TRY(store_imagery_compute(store->db, store->path, &hash));
	TRY(store_sql_integer(store->db, store->path, "SELECT coalesce(min(key), -1) FROM imagery", &key));
	TRY(store_meta_drop(store, "imagery_request"));
	if (key < 0)
		return fail_with(STATUS_INPUT, "%s: the imagery has no pixel on the terrain; look at its place with gdalinfo", store->path);
	TRY(store_meta_put_integer(store, "imagery_level", tile_from_key((uint64_t)key).level));
	return store_meta_put_integer(store, "imagery_hash", (int64_t)hash);
}

enum status store_imagery_finish(struct store *store)
{
	assert(store->imagery_made);
	TRY(put_header(store));
	TRY(store_sql_exec(store->db, store->path, doing, "COMMIT"));
	store->imagery_made = false;
	TRY(store_bound_wal(store));
	return store_imagery_open(store);
}

enum status store_imagery_suspend(struct store *store)
{
	store->imagery_made = false;
	const enum status status = commit(store);
	if (status != STATUS_OK)
		store_sql_undo(store->db);
	return status;
}

enum status store_imagery_drop(struct store *store)
{
	if (!store->imagery_made)
		return STATUS_OK;
	store->imagery_made = false;
	store_sql_undo(store->db);
	TRY(begin(store));
	enum status status;
	TRY_OR(failed, clear(store));
	TRY_OR(failed, store_schema_drop_imagery(store));
	TRY_OR(failed, store_sql_exec(store->db, store->path, doing, "COMMIT"));
	store->version = STORE_VERSION;
	return store_bound_wal(store);
failed:
	store_sql_undo(store->db);
	return status;
}

/* --- hashes, copies, checks --- */

typedef enum status (*row_fn)(void *user, sqlite3_stmt *row);

static enum status each_row(sqlite3 *db, const char *path, const char *sql, row_fn fn, void *user)
{
	sqlite3_stmt *statement = NULL;
	enum status status;
	int code;
	TRY_OR(done, store_sql_prepare(db, path, &statement, sql));
	while ((code = sqlite3_step(statement)) == SQLITE_ROW)
		TRY_OR(done, fn(user, statement));
	if (code != SQLITE_DONE)
		TRY_OR(done, store_sql_fail(db, code, path, "reading its imagery"));
done:
	sqlite3_finalize(statement);
	return status;
}

static enum status hash_row(void *user, sqlite3_stmt *row)
{
	store_hash_words(user, (uint64_t[]){(uint64_t)sqlite3_column_int64(row, 0), (uint64_t)sqlite3_column_int64(row, 1)}, 2);
	return STATUS_OK;
}

enum status store_imagery_compute(sqlite3 *db, const char *path, uint64_t *hash)
{
	XXH3_state_t *state = XXH3_createState();
	TRY_MEM(state, "the hash of imagery");
	XXH3_64bits_reset(state);
	enum status status = each_row(db, path, "SELECT key, hash FROM imagery ORDER BY key", hash_row, state);
	*hash = XXH3_64bits_digest(state);
	XXH3_freeState(state);
	return status;
}

static enum status copy_row(void *user, sqlite3_stmt *row)
{
	struct store *to = user;
	const int64_t key = sqlite3_column_int64(row, 0), codec = sqlite3_column_int64(row, 1);
	const void *bytes = sqlite3_column_blob(row, 3);
	const size_t size = (size_t)sqlite3_column_bytes(row, 3);
	if (bytes == NULL || store_imagery_row_hash((uint64_t)key, codec, bytes, size) != (uint64_t)sqlite3_column_int64(row, 2))
		return fail_with(STATUS_INPUT, "%s: a row of its imagery is damaged; import its imagery again with --overwrite", to->path);
	return put_row(to->db, to->path, key, codec, bytes, size);
}

enum status store_imagery_copy(const struct store *from, struct store *to)
{
	const struct store *holder = store_imagery_holder(from);
	struct store_imagery has;
	TRY(store_imagery_info(from, &has));
	if (!has.found)
		return STATUS_OK;
	TRY(store_schema_add_imagery(to));
	to->version = STORE_VERSION_IMAGERY;
	TRY(each_row(holder->db, holder->path, "SELECT key, codec, hash, blob FROM imagery ORDER BY key", copy_row, to));
	TRY(store_meta_put_integer(to, "imagery_level", has.finest));
	TRY(store_meta_put_integer(to, "imagery_quality", has.quality));
	TRY(store_meta_put_integer(to, "imagery_hash", (int64_t)store_imagery_hash(from)));
	return store_meta_put_text(to, "imagery_sources", has.sources);
}

struct checking {
	const struct store *store;
	uint8_t *pixels;
	void (*tell)(void *user, const char *text);
	void *user;
};

static void tell(const struct checking *checking, struct tile tile, const char *what)
{
	char text[160];
	snprintf(text, sizeof text, "imagery tile level %d x %u y %u: %s", tile.level, tile.x, tile.y, what);
	checking->tell(checking->user, text);
}

static enum status check_above(const struct checking *checking, struct tile tile)
{
	const struct store *store = checking->store;
	char sql[96];
	int64_t count = 0;
	if (tile.level >= extent_coarsest(&store->meta.extent))
		return STATUS_OK;
	snprintf(sql, sizeof sql, "SELECT count(*) FROM imagery WHERE key = %lld", (long long)tile_key(tile_ancestor(tile, tile.level + 1)));
	TRY(store_sql_integer(store->db, store->path, sql, &count));
	if (count == 0)
		tell(checking, tile, "the tile above it is missing");
	return STATUS_OK;
}

static enum status check_row(void *user, sqlite3_stmt *row)
{
	struct checking *checking = user;
	const struct extent *extent = &checking->store->meta.extent;
	const uint64_t key = (uint64_t)sqlite3_column_int64(row, 0);
	const struct tile tile = tile_from_key(key);
	const void *bytes = sqlite3_column_blob(row, 3);
	const size_t size = (size_t)sqlite3_column_bytes(row, 3);
	if (!extent_has(extent, tile) || tile_key(tile) != key) {
		tell(checking, tile, "it is outside the terrain");
		return STATUS_OK;
	}
	const int64_t codec = sqlite3_column_int64(row, 1);
	if (bytes == NULL || store_imagery_row_hash(key, codec, bytes, size) != (uint64_t)sqlite3_column_int64(row, 2))
		tell(checking, tile, "its hash is not that of its bytes");
	else if (store_imagery_possible() && !store_imagery_unpack(bytes, size, tile_posts(extent), checking->pixels))
		tell(checking, tile, "it cannot be unpacked");
	return check_above(checking, tile);
}

enum status store_imagery_verify(const struct store *store, void (*problem)(void *user, const char *text), void *user)
{
	const struct store *holder = store_imagery_holder(store);
	const size_t side = tile_posts(&holder->meta.extent);
	uint64_t hash = 0;
	if (!holder->has_imagery)
		return STATUS_OK;
	struct checking checking = {.store = holder, .tell = problem, .user = user, .pixels = mem_alloc(side * side, 4)};
	TRY_MEM(checking.pixels, "verifying");
	enum status status = each_row(holder->db, holder->path, "SELECT key, codec, hash, blob FROM imagery ORDER BY key", check_row, &checking);
	mem_free(checking.pixels);
	TRY(status);
	TRY(store_imagery_compute(holder->db, holder->path, &hash));
	if (hash != holder->imagery_hash)
		problem(user, "header: its imagery_hash is not that of its imagery tiles");
	return STATUS_OK;
}
