/* Reads the table that describes the store as a whole, and counts amounts of soil in it. The type and the value of every key are checked. */
#include "store/internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define COMPACTED_MAX (INT64_MAX / 4) /* either way; so that sums of such are numbers too. The same of added soil */
#define COMMITS_MOST (INT64_C(1) << 53) /* nobody commits that many */

struct lookup {
	sqlite3 *db;
	const char *path;
	sqlite3_stmt *statement;
};

static enum status bad_key(const struct lookup *lookup, const char *key)
{
	return fail_with(STATUS_INPUT, "%s: its header is wrong at '%s'; the store is damaged, restore or "
			 "import it again", lookup->path, key);
}

/* *found false without that key. */
static enum status look_up(struct lookup *lookup, const char *key, bool *found)
{
	TRY(store_sql_prepare(lookup->db, lookup->path, &lookup->statement, "SELECT value FROM meta WHERE key = ?1"));
	sqlite3_reset(lookup->statement);
	sqlite3_bind_text(lookup->statement, 1, key, -1, SQLITE_STATIC);
	int code = sqlite3_step(lookup->statement);
	*found = code == SQLITE_ROW;
	return code == SQLITE_ROW || code == SQLITE_DONE
		       ? STATUS_OK
		       : store_sql_fail(lookup->db, code, lookup->path, "reading its header");
}

/* *found: there is such a key, and it is of that type. */
static enum status look_for(struct lookup *lookup, const char *key, int type, bool *found)
{
	TRY(look_up(lookup, key, found));
	*found = *found && sqlite3_column_type(lookup->statement, 0) == type;
	return STATUS_OK;
}

enum status store_meta_find_integer(const struct store *store, const char *key, bool *found, int64_t *value)
{
	struct lookup lookup = {.db = store->db, .path = store->path};
	const enum status status = look_for(&lookup, key, SQLITE_INTEGER, found);
	if (status == STATUS_OK && *found)
		*value = sqlite3_column_int64(lookup.statement, 0);
	sqlite3_finalize(lookup.statement);
	return status;
}

enum status store_meta_find_text(const struct store *store, const char *key, char **text)
{
	struct lookup lookup = {.db = store->db, .path = store->path};
	bool found = false;
	*text = NULL;
	enum status status = look_for(&lookup, key, SQLITE_TEXT, &found);
	const char *value = status == STATUS_OK && found ? (const char *)sqlite3_column_text(lookup.statement, 0) : NULL;
	if (value != NULL)
		status = mem_text(text, value, "a store's header");
	else if (found)
		status = fail_memory("a store's header");
	sqlite3_finalize(lookup.statement);
	return status;
}

static enum status get_integer(struct lookup *lookup, const char *key, int64_t low, int64_t high,
			       int64_t *value)
{
	bool found;
	TRY(look_up(lookup, key, &found));
	if (!found || sqlite3_column_type(lookup->statement, 0) != SQLITE_INTEGER)
		return bad_key(lookup, key);
	*value = sqlite3_column_int64(lookup->statement, 0);
	return *value >= low && *value <= high ? STATUS_OK : bad_key(lookup, key);
}

/* Finite, or (where allowed) NULL: NaN. */
static enum status get_real(struct lookup *lookup, const char *key, bool may_lack, double *value)
{
	bool found;
	TRY(look_up(lookup, key, &found));
	int type = found ? sqlite3_column_type(lookup->statement, 0) : 0;
	*value = type == SQLITE_FLOAT ? sqlite3_column_double(lookup->statement, 0) : (double)NAN;
	bool good = type == SQLITE_FLOAT ? isfinite(*value) : may_lack && type == SQLITE_NULL;
	return good ? STATUS_OK : bad_key(lookup, key);
}

/* NaN: there is no such key. */
static enum status get_optional(struct lookup *lookup, const char *key, double *value)
{
	bool found;
	TRY(look_up(lookup, key, &found));
	*value = (double)NAN;
	if (!found)
		return STATUS_OK;
	return get_real(lookup, key, false, value);
}

/* `lacking`: its value if there is no such key; NULL: there must be. */
static enum status get_text(struct lookup *lookup, const char *key, const char *lacking, const char **value)
{
	bool found;
	TRY(look_up(lookup, key, &found));
	if (!found && lacking != NULL) {
		return mem_text(value, lacking, "a store's header");
	}
	if (!found || sqlite3_column_type(lookup->statement, 0) != SQLITE_TEXT)
		return bad_key(lookup, key);
	const char *text = (const char *)sqlite3_column_text(lookup->statement, 0);
	*value = text != NULL ? mem_strdup(text) : NULL;
	return *value != NULL ? STATUS_OK : fail_memory("a store's header");
}

enum status store_meta_same_request(struct store *store, bool *same)
{
	struct lookup lookup = {.db = store->db, .path = store->path};
	enum status status;
	TRY_OR(done, look_up(&lookup, "request", same));
	if (*same) {
		const char *text = (const char *)sqlite3_column_text(lookup.statement, 0);
		*same = text != NULL && strcmp(text, store->meta.request) == 0;
	}
done:
	sqlite3_finalize(lookup.statement);
	return status;
}

static enum status get_world(struct lookup *lookup, struct extent *extent)
{
	int64_t cells;
	bool begun, whole = false;
	TRY(look_up(lookup, "request", &begun));
	TRY(look_up(lookup, "width", &whole));
	if (begun && !whole)
		return fail_with(STATUS_INPUT, "%s: an import that is not done; the same furrow import with --resume goes on "
				 "with it", lookup->path);
	TRY(get_integer(lookup, "width", 0, INT64_MAX, &extent->width));
	TRY(get_integer(lookup, "height", 0, INT64_MAX, &extent->height));
	TRY(get_integer(lookup, "cells", 0, TILE_CELLS_MAX, &cells));
	TRY(get_real(lookup, "spacing", false, &extent->spacing));
	extent->cells = (uint32_t)cells;
	const char *problem = extent_problem(extent);
	if (problem != NULL)
		return fail_with(STATUS_INPUT, "%s: its header is wrong: %s; restore or import it again",
				 lookup->path, problem);
	return STATUS_OK;
}

static enum status get_working(struct lookup *lookup, const struct extent *extent, bool *has, int *level)
{
	TRY(look_up(lookup, "working", has));
	if (!*has)
		return STATUS_OK;
	int64_t value = 0;
	TRY(get_integer(lookup, "working", TILE_LEVEL_MIN, extent_coarsest(extent), &value));
	*level = (int)value;
	return STATUS_OK;
}

enum status store_meta_working(sqlite3 *db, const char *path, const struct extent *extent, bool *has, int *level)
{
	struct lookup lookup = {.db = db, .path = path};
	enum status status = get_working(&lookup, extent, has, level);
	sqlite3_finalize(lookup.statement);
	return status;
}

/* Reads an amount of soil. If there is no such key, it is 0. */
static enum status get_soil(struct lookup *lookup, const char *key, int64_t *amount)
{
	bool found;
	TRY(look_up(lookup, key, &found));
	*amount = 0;
	if (!found)
		return STATUS_OK;
	return get_integer(lookup, key, -COMPACTED_MAX, COMPACTED_MAX, amount);
}

static enum status read_soil(sqlite3 *db, const char *path, const char *key, int64_t *amount)
{
	struct lookup lookup = {.db = db, .path = path};
	enum status status = get_soil(&lookup, key, amount);
	sqlite3_finalize(lookup.statement);
	return status;
}

enum status store_meta_compacted(sqlite3 *db, const char *path, int64_t *compacted)
{
	return read_soil(db, path, "compacted", compacted);
}

enum status store_meta_added(sqlite3 *db, const char *path, int64_t *added)
{
	return read_soil(db, path, "added", added);
}

/* The key of what was added up to a revision that is kept. */
static const char *added_key(int64_t revision, char text[32])
{
	snprintf(text, 32, "added %lld", (long long)revision);
	return text;
}

enum status store_meta_added_at(sqlite3 *db, const char *path, int64_t revision, int64_t *added)
{
	char key[32];
	return read_soil(db, path, added_key(revision, key), added);
}

enum status store_meta_put_added(struct store *store, int64_t added)
{
	return added != 0 ? store_meta_put_integer(store, "added", added) : store_meta_drop(store, "added");
}

enum status store_meta_keep_added(struct store *store)
{
	char key[32];
	return store->added != 0 ? store_meta_put_integer(store, added_key(store->commit, key), store->added) : STATUS_OK;
}

enum status store_meta_forget_added(struct store *store)
{
	char sql[112];
	if (store->added == 0)
		return STATUS_OK;
	snprintf(sql, sizeof sql, "DELETE FROM meta WHERE key GLOB 'added [0-9]*' AND CAST(substr(key, 7) AS INTEGER) < %lld",
		 (long long)store->commit);
	return store_sql_exec(store->db, store->path, "dropping what is older", sql);
}

enum status store_meta_add_added(struct store *store, int64_t more)
{
	int64_t sum;
	if (more == 0)
		return STATUS_OK;
	if (__builtin_add_overflow(store->added, more, &sum) || sum > COMPACTED_MAX || sum < -COMPACTED_MAX)
		return fail_with(STATUS_FAILED, "%s: more soil was added than it can count; furrow reset %s", store->path, shell_path(store->path).text);
	return store_meta_put_added(store, sum);
}

enum status store_meta_add_compacted(struct store *store, int64_t more)
{
	int64_t sum;
	if (more == 0)
		return STATUS_OK;
	if (__builtin_add_overflow(store->compacted, more, &sum) || sum > COMPACTED_MAX || sum < -COMPACTED_MAX)
		return fail_with(STATUS_FAILED, "%s: more soil was compacted than it can count; furrow reset %s", store->path, shell_path(store->path).text);
	return store_meta_put_integer(store, "compacted", sum);
}

/* Without these keys nothing was measured. */
static enum status get_misfit(struct lookup *lookup, const char *posts, const char *greatest, const char *squares, struct misfit *misfit)
{
	bool found;
	TRY(look_up(lookup, posts, &found));
	if (!found)
		return STATUS_OK;
	TRY(get_integer(lookup, posts, 1, INT64_MAX, &misfit->posts));
	TRY(get_real(lookup, greatest, false, &misfit->greatest));
	TRY(get_real(lookup, squares, false, &misfit->squares));
	if (!(misfit->greatest >= 0))
		return bad_key(lookup, greatest);
	return misfit->squares >= 0 ? STATUS_OK : bad_key(lookup, squares);
}

enum status store_meta_misfit(struct store *store, const char *posts, const char *greatest, const char *squares,
			      struct misfit *misfit)
{
	struct lookup lookup = {.db = store->db, .path = store->path};
	*misfit = (struct misfit){0};
	enum status status = get_misfit(&lookup, posts, greatest, squares, misfit);
	sqlite3_finalize(lookup.statement);
	return status;
}

static enum status get_base_hash(struct lookup *lookup, uint64_t *hash)
{
	int64_t value = 0;
	enum status status = get_integer(lookup, "base_hash", INT64_MIN, INT64_MAX, &value);
	*hash = (uint64_t)value;
	return status;
}

enum status store_meta_base_hash(sqlite3 *db, const char *path, uint64_t *hash)
{
	struct lookup lookup = {.db = db, .path = path};
	enum status status = get_base_hash(&lookup, hash);
	sqlite3_finalize(lookup.statement);
	return status;
}

/* Only an overlay has it. */
static enum status get_base_path(struct lookup *lookup, char **path)
{
	bool found;
	TRY(look_up(lookup, "base_path", &found));
	if (!found)
		return STATUS_OK;
	const char *text = NULL;
	if (sqlite3_column_type(lookup->statement, 0) == SQLITE_TEXT)
		text = (const char *)sqlite3_column_text(lookup->statement, 0);
	if (text == NULL || !store_overlay_path_fits(text, (size_t)sqlite3_column_bytes(lookup->statement, 0)))
		return bad_key(lookup, "base_path");
	return mem_text(path, text, "a store's header");
}

/* Only an overlay that shows the deformation of its parent has them. */
static enum status get_parent(struct lookup *lookup, struct store *store)
{
	int64_t hash = 0;
	TRY(look_up(lookup, "parent_hash", &store->inherits));
	if (!store->inherits)
		return STATUS_OK;
	if (store->base_path == NULL)
		return bad_key(lookup, "parent_hash");
	TRY(get_integer(lookup, "parent_hash", INT64_MIN, INT64_MAX, &hash));
	store->parent_hash = (uint64_t)hash;
	return get_integer(lookup, "parent_revision", 0, COMMITS_MOST, &store->parent_revision);
}

/* Only a part of a run has them. */
static enum status get_part(struct lookup *lookup, struct store *store)
{
	int64_t run = 0, index = 0, count = 0;
	bool found;
	TRY(look_up(lookup, "part_run", &found));
	if (!found)
		return STATUS_OK;
	if (!store->inherits)
		return bad_key(lookup, "part_run");
	TRY(get_integer(lookup, "part_run", INT64_MIN, INT64_MAX, &run));
	TRY(get_integer(lookup, "part_count", 1, STORE_PARTS_MOST, &count));
	TRY(get_integer(lookup, "part_index", 0, count - 1, &index));
	store->part = (struct store_part){(uint64_t)run, (uint32_t)index, (uint32_t)count};
	return STATUS_OK;
}

static enum status get_relief(struct lookup *lookup, struct store *store)
{
	const char *text;
	bool found;
	TRY(look_up(lookup, "relief", &found));
	if (!found)
		return STATUS_OK;
	TRY(get_text(lookup, "relief", NULL, &text));
	store->relief_text = (char *)(uintptr_t)text;
	store->relief_stored = true;
	return store_relief_settle(store);
}

static enum status get_all(struct lookup *lookup, struct store *store)
{
	struct store_meta *meta = &store->meta;
	TRY(get_world(lookup, &meta->extent));
	int64_t pack;
	TRY(get_integer(lookup, "pack", STORE_PACK_FAST, STORE_PACK_SMALL, &pack));
	meta->pack = (enum store_pack)pack;
	const struct { const char *key; bool may_lack; double *value; } reals[] = {
		{"step", false, &meta->step},          {"max_error", false, &meta->max_error},
		{"origin_x", false, &meta->origin[0]}, {"origin_y", false, &meta->origin[1]},
		{"low", true, &meta->low},             {"high", true, &meta->high},
	};
	for (size_t i = 0; i < sizeof reals / sizeof *reals; i++)
		TRY(get_real(lookup, reals[i].key, reals[i].may_lack, reals[i].value));
	TRY(get_optional(lookup, "ground_off", &meta->ground_off));
	TRY(get_optional(lookup, "holes", &meta->holes));
	TRY(get_text(lookup, "srs", NULL, &meta->srs));
	TRY(get_text(lookup, "vertical", NULL, &meta->vertical));
	TRY(get_text(lookup, "sources", NULL, &meta->sources));
	TRY(get_text(lookup, "insets", "", &meta->insets));
	TRY(get_base_hash(lookup, &store->base_hash));
	TRY(get_base_path(lookup, &store->base_path));
	TRY(get_parent(lookup, store));
	TRY(get_part(lookup, store));
	TRY(get_working(lookup, &meta->extent, &store->has_working, &store->working));
	TRY(get_soil(lookup, "compacted", &store->compacted));
	TRY(get_soil(lookup, "added", &store->added));
	TRY(get_relief(lookup, store));
	store->working_stored = store->has_working;
	if (meta->step < 0)
		return bad_key(lookup, "step");
	bool relief = !isnan(meta->low) || !isnan(meta->high);
	if (relief && !(meta->low <= meta->high && fabs(meta->low) <= HEIGHT_MAX && fabs(meta->high) <= HEIGHT_MAX))
		return bad_key(lookup, "low");
	store->code_low = 1;
	/* A low of zero may have been negative zero, whose code is lower: SQLite keeps only the one. */
	double low = meta->low == 0 ? -0.0 : meta->low;
	if (relief && (!height_code_encode(low, meta->step, &store->code_low) ||
		       !height_code_encode(meta->high, meta->step, &store->code_high)))
		return bad_key(lookup, "step");
	return STATUS_OK;
}

enum status store_meta_read(struct store *store)
{
	struct lookup lookup = {.db = store->db, .path = store->path};
	enum status status = get_all(&lookup, store);
	sqlite3_finalize(lookup.statement);
	TRY(status);
	TRY(store_misfit_read(store));
	TRY(store_sql_integer(store->db, store->path, "SELECT coalesce(max(epoch), 0) FROM run", &store->commit));
	return store->commit >= 0 && store->commit <= COMMITS_MOST ? STATUS_OK : bad_key(&lookup, "epoch");
}
