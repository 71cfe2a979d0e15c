/* Writes the table that describes the store as a whole: store_meta_read.c reads it. */
#include "store/internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum status store_meta_copy(struct store_meta *to, const struct store_meta *from)
{
	*to = *from;
	to->srs = mem_strdup(from->srs != NULL ? from->srs : "");
	to->vertical = mem_strdup(from->vertical != NULL ? from->vertical : "");
	to->sources = mem_strdup(from->sources != NULL ? from->sources : "");
	to->insets = mem_strdup(from->insets != NULL ? from->insets : "");
	to->request = mem_strdup(from->request != NULL ? from->request : "");
	to->low = to->high = (double)NAN;
	if (to->srs != NULL && to->vertical != NULL && to->sources != NULL && to->insets != NULL && to->request != NULL)
		return STATUS_OK;
	store_meta_finish(to);
	return fail_memory("a store");
}

void store_meta_finish(struct store_meta *meta)
{
	mem_free_all(meta->srs, meta->vertical, meta->sources, meta->insets, meta->request);
	meta->srs = meta->vertical = meta->sources = meta->insets = meta->request = NULL;
}

static enum status begin_put(struct store *store, const char *key, sqlite3_stmt **statement)
{
	TRY(store_sql_prepare(store->db, store->path, &store->meta_statement, "INSERT OR REPLACE INTO meta(key, value) VALUES(?1, ?2)"));
	*statement = store->meta_statement;
	sqlite3_bind_text(*statement, 1, key, -1, SQLITE_STATIC);
	return STATUS_OK;
}

static enum status end_put(struct store *store)
{
	int code = sqlite3_step(store->meta_statement);
	enum status status = code == SQLITE_DONE ? STATUS_OK : store_sql_fail(store->db, code, store->path, "writing it");
	sqlite3_reset(store->meta_statement);
	sqlite3_clear_bindings(store->meta_statement);
	return status;
}

enum status store_meta_put_integer(struct store *store, const char *key, int64_t value)
{
	sqlite3_stmt *statement;
	TRY(begin_put(store, key, &statement));
	sqlite3_bind_int64(statement, 2, value);
	return end_put(store);
}

enum status store_meta_put_real(struct store *store, const char *key, double value)
{
	sqlite3_stmt *statement;
	TRY(begin_put(store, key, &statement));
	if (isnan(value))
		sqlite3_bind_null(statement, 2);
	else
		sqlite3_bind_double(statement, 2, value);
	return end_put(store);
}

enum status store_meta_put_text(struct store *store, const char *key, const char *value)
{
	sqlite3_stmt *statement;
	TRY(begin_put(store, key, &statement));
	sqlite3_bind_text(statement, 2, value, -1, SQLITE_STATIC);
	return end_put(store);
}

enum status store_meta_put_base_path(struct store *store)
{
	return store_meta_put_text(store, "base_path", store->base_path);
}

enum status store_meta_write(struct store *store)
{
	const struct store_meta *meta = &store->meta;
	const struct { const char *key; int64_t value; } integers[] = {
		{"width", meta->extent.width}, {"height", meta->extent.height},
		{"cells", meta->extent.cells}, {"pack", meta->pack},
		{"base_hash", (int64_t)store->base_hash},
	};
	const struct { const char *key; double value; } reals[] = {
		{"spacing", meta->extent.spacing}, {"step", meta->step}, {"max_error", meta->max_error},
		{"origin_x", meta->origin[0]}, {"origin_y", meta->origin[1]},
		{"low", meta->low}, {"high", meta->high},
	};
	const struct { const char *key, *value; } texts[] = {
		{"srs", meta->srs}, {"vertical", meta->vertical}, {"sources", meta->sources},
	};
	for (size_t i = 0; i < sizeof integers / sizeof *integers; i++)
		TRY(store_meta_put_integer(store, integers[i].key, integers[i].value));
	for (size_t i = 0; i < sizeof reals / sizeof *reals; i++)
		TRY(store_meta_put_real(store, reals[i].key, reals[i].value));
	for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
		TRY(store_meta_put_text(store, texts[i].key, texts[i].value));
	if (!isnan(meta->ground_off))
		TRY(store_meta_put_real(store, "ground_off", meta->ground_off));
	if (!isnan(meta->holes))
		TRY(store_meta_put_real(store, "holes", meta->holes));
	if (meta->insets != NULL && meta->insets[0] != '\0')
		TRY(store_meta_put_text(store, "insets", meta->insets));
	TRY(store_misfit_write(store));
	if (store->base_path != NULL)
		TRY(store_meta_put_base_path(store));
	if (store->inherits)
		TRY(store_meta_put_integer(store, "parent_hash", (int64_t)store->parent_hash));
	if (store->inherits)
		TRY(store_meta_put_integer(store, "parent_revision", store->parent_revision));
	const struct { const char *key; int64_t value; } part[] = {
		{"part_run", (int64_t)store->part.run}, {"part_index", store->part.index}, {"part_count", store->part.count},
	};
	for (size_t i = 0; i < sizeof part / sizeof *part && store->part.count > 0; i++)
		TRY(store_meta_put_integer(store, part[i].key, part[i].value));
	return STATUS_OK;
}

enum status store_meta_put_request(struct store *store)
{
	return store_meta_put_text(store, "request", store->meta.request);
}

enum status store_meta_drop(struct store *store, const char *key)
{
	sqlite3_stmt *statement = NULL;
	TRY(store_sql_prepare(store->db, store->path, &statement, "DELETE FROM meta WHERE key = ?1"));
	sqlite3_bind_text(statement, 1, key, -1, SQLITE_STATIC);
	int code = sqlite3_step(statement);
	enum status status = code == SQLITE_DONE ? STATUS_OK : store_sql_fail(store->db, code, store->path, "writing it");
	sqlite3_finalize(statement);
	return status;
}
