/*
 * Verifies a store: checks everything about its content that can be checked. The order is:
 *
 *   SQLite's own check -> all rows (verify_tile.c) -> an overlay's own rows (verify_own.c)
 *   -> its history (verify_history.c) -> missing base tiles -> the header's range and the base's hash
 */
#include "store/verify.h"

#include <stdio.h>
#include <string.h>

#define CACHE_BYTES (48u << 20)

void store_verify_tell(struct verifying *verifying, const char *format, ...)
{
	char text[512];
	va_list args;
	verifying->check->problems++;
	if (verifying->problem == NULL)
		return;
	va_start(args, format);
	vsnprintf(text, sizeof text, format, args);
	va_end(args);
	verifying->problem(verifying->user, text);
}

void store_verify_tell_tile(struct verifying *verifying, struct tile tile, const char *what)
{
	store_verify_tell(verifying, "%s tile level %d x %u y %u: %s", store_rows_name(verifying->table), tile.level, tile.x,
	     tile.y, what);
}

/* --- SQLite's own check --- */

static enum status check_file(struct verifying *verifying, const struct rows *rows, const char *name)
{
	sqlite3_stmt *statement = NULL;
	enum status status = STATUS_OK;
	int code;
	TRY(store_sql_prepare(rows->db, rows->path, &statement, "PRAGMA integrity_check(100)"));
	while ((code = sqlite3_step(statement)) == SQLITE_ROW) {
		const char *text = (const char *)sqlite3_column_text(statement, 0);
		char line[400];
		if (text == NULL || strcmp(text, "ok") == 0)
			continue;
		snprintf(line, sizeof line, "%s: %s", name, text);
		for (char *c = line; *c != '\0'; c++)
			*c = *c == '\n' ? ' ' : *c;
		store_verify_tell(verifying, "%s", line);
	}
	if ((code & 0xff) == SQLITE_CORRUPT)
		store_verify_tell(verifying, "%s: %s", name, sqlite3_errmsg(rows->db));
	else if (code != SQLITE_DONE)
		status = store_sql_fail(rows->db, code, rows->path, "checking it");
	sqlite3_finalize(statement);
	return status;
}

static enum status check_files(struct verifying *verifying)
{
	struct store *store = verifying->store;
	TRY(check_file(verifying, &store->rows, "file"));
	for (; store->under != NULL; store = store->under) {
		int64_t own;
		TRY(store_sql_integer(store->db, store->path, "SELECT count(*) FROM base", &own));
		if (own != 0)
			store_verify_tell(verifying, "%s: it has base tiles, though it is an overlay",
					  store == verifying->store ? "file" : store->path);
		TRY(check_file(verifying, &store->under->rows, store->under->under == NULL ? "its base's file" : store->under->path));
	}
	return STATUS_OK;
}

/* --- every row, and rows that are missing --- */

static enum status check_row(void *user, const struct row_entry *entry)
{
	struct verifying *verifying = user;
	enum row_table table = verifying->table;
	struct tile tile = tile_from_key(entry->key);
	verifying->check->tiles++;
	if (tile_key(tile) != entry->key || !extent_has(&verifying->store->meta.extent, tile)) {
		store_verify_tell_tile(verifying, tile, "it is outside the terrain");
	} else {
		verifying->base_found += table == ROW_BASE && tile.level >= 0;
		TRY(store_verify_tile(verifying, tile));
	}
	if (verifying->progress != NULL)
		TRY(verifying->progress(verifying->user, verifying->check->tiles, verifying->total));
	return STATUS_OK;
}

static enum status check_table(struct verifying *verifying, enum row_table table)
{
	verifying->table = table;
	enum status status = store_rows_each(store_table(verifying->store, table), table, 0, INT64_MAX, check_row, verifying);
	if (status != STATUS_INPUT)
		return status;
	store_verify_tell(verifying, "%s tiles: %s", store_rows_name(table), failure_message());
	return STATUS_OK;
}

/* Tells each base tile that is missing. If as many tiles were found as the terrain has, none is missing, and none is looked up. */
static enum status check_missing(struct verifying *verifying)
{
	const struct extent *extent = &verifying->store->meta.extent;
	int64_t want = 0;
	for (int level = 0; level <= extent_coarsest(extent); level++)
		want += (int64_t)extent_tiles_x(extent, level) * extent_tiles_y(extent, level);
	verifying->table = ROW_BASE;
	if (verifying->base_found >= want)
		return STATUS_OK;
	int64_t left = 1000; /* tells at most this many missing tiles */
	for (int level = extent_coarsest(extent); level >= 0; level--)
		for (uint32_t y = 0; y < extent_tiles_y(extent, level); y++)
			for (uint32_t x = 0; x < extent_tiles_x(extent, level); x++) {
				struct tile tile = {level, x, y};
				struct row row;
				bool found;
				enum status status = store_rows_head(verifying->store->base, ROW_BASE, tile, &row, &found);
				if (status == STATUS_INPUT)
					continue;
				TRY(status);
				if (found)
					continue;
				store_verify_tell_tile(verifying, tile, "it is missing");
				if (--left == 0)
					return STATUS_OK;
			}
	return STATUS_OK;
}

static enum status check_top(struct verifying *verifying)
{
	struct store *store = verifying->store;
	struct tile tile = {extent_coarsest(&store->meta.extent), 0, 0};
	struct row top;
	bool found;
	enum status status = store_rows_head(store->base, ROW_BASE, tile, &top, &found);
	if (status == STATUS_INPUT)
		return STATUS_OK;
	TRY(status);
	if (found && !(verify_same(top.low, store->meta.low) && verify_same(top.high, store->meta.high)))
		store_verify_tell(verifying, "header: its range is not that of the coarsest tile");
	return STATUS_OK;
}

static enum status check_identity(struct verifying *verifying)
{
	uint64_t hash;
	TRY(store_identity_compute(verifying->store, &hash));
	if (hash != verifying->store->base_hash)
		store_verify_tell(verifying, "header: its base_hash is not that of its base tiles");
	return STATUS_OK;
}

static void tell_imagery(void *user, const char *text)
{
	store_verify_tell(user, "%s", text);
}

static enum status check_all(struct verifying *verifying)
{
	struct store *store = verifying->store;
	TRY(check_files(verifying));
	for (int table = 0; table < ROW_TABLES; table++) {
		int64_t count = 0, bytes;
		TRY(store_rows_count(store_table(store, (enum row_table)table), (enum row_table)table, &count, &bytes));
		verifying->total += count;
	}
	for (int table = 0; table < ROW_TABLES; table++)
		TRY(check_table(verifying, (enum row_table)table));
	if (store->inherits)
		TRY(store_verify_own(verifying));
	TRY(store_verify_history(verifying));
	TRY(store_verify_pins(verifying));
	TRY(check_missing(verifying));
	TRY(check_top(verifying));
	TRY(store_meta_compacted(store->db, store->path, &verifying->check->compacted));
	TRY(store_meta_added(store->db, store->path, &verifying->check->added));
	TRY(store_last_soil(store, &verifying->check->carried, &verifying->check->in_flight));
	TRY(store_imagery_verify(store, tell_imagery, verifying));
	return check_identity(verifying);
}

/* In one transaction, so that all rows that are compared are of the same commit. */
static enum status check_in_transaction(struct verifying *verifying)
{
	struct store *store = verifying->store;
	TRY(store_sql_exec(store->db, store->path, "checking it", "BEGIN"));
	enum status status = check_all(verifying);
	if (status == STATUS_INPUT) { /* the store is too damaged to be read; that is a problem of the store, not a failure */
		store_verify_tell(verifying, "%s", failure_message());
		status = STATUS_OK;
	}
	sqlite3_exec(store->db, "ROLLBACK", NULL, NULL, NULL); /* nothing was written */
	return status;
}

enum status store_verify(struct store *store, store_problem_fn problem, store_progress_fn progress,
			 void *user, struct store_check *check)
{
	*check = (struct store_check){
		.coarsest = extent_coarsest(&store->meta.extent),
		.finest = store_finest(store),
	};
	struct verifying *verifying = mem_calloc(1, sizeof *verifying);
	TRY_MEM(verifying, "verifying");
	*verifying = (struct verifying){
		.store = store,
		.problem = problem,
		.progress = progress,
		.user = user,
		.check = check,
		.side = tile_posts(&store->meta.extent),
	};
	size_t count = verifying->side * verifying->side, bytes = count * sizeof *verifying->posts;
	size_t entries = CACHE_BYTES / bytes;
	verifying->entry_count = entries < VERIFY_CACHE ? (uint32_t)entries : VERIFY_CACHE;
	verifying->posts = mem_alloc(count, sizeof *verifying->posts);
	verifying->expected = mem_alloc(count, sizeof *verifying->expected);
	bool enough = verifying->posts != NULL && verifying->expected != NULL;
	enum status status = enough ? check_in_transaction(verifying) : fail_memory("verifying");
	for (uint32_t i = 0; i < verifying->entry_count; i++)
		mem_free(verifying->entries[i].posts);
	mem_free_all(verifying->posts, verifying->expected, verifying);
	return status;
}
