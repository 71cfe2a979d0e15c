/*
 * Reads and writes single rows of the tables that hold tiles.
 *
 * Invariants:
 *   1. Each statement is reset before the function that stepped it returns. store_rows_read() resets it after decoding the blob.
 *   2. A row with a wrong hash or an unknown codec never reaches a caller.
 *   3. The same posts, range and sums give the same hash. It covers everything in the row but its revision.
 */
#include "store/internal.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <xxhash.h>

#define SUM_MAX ((int64_t)(TILE_CELLS_MAX + 1) * (TILE_CELLS_MAX + 1) << 31) /* of any tile's posts */

struct table {
	const char *name, *sql_name;
	const char *find, *head, *write, *drop, *under;
};

/* Columns 0..7: low, high, error, codec, revision, hash, below, above; find: blob too. */
#define TABLE(word, from, columns, written, values)                                                \
	{                                                                                          \
		.name = word,                                                                      \
		.sql_name = from,                                                                  \
		.find = "SELECT " columns ", blob FROM " from " WHERE key = ?1",                   \
		.head = "SELECT " columns " FROM " from " WHERE key = ?1",                         \
		.write = "INSERT OR REPLACE INTO " from                                            \
			 "(key, low, high, codec, revision, hash, blob" written ") "               \
			 "VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7" values ")",                           \
		.drop = "DELETE FROM " from " WHERE key = ?1",                                     \
		.under = "SELECT min(low), max(high), count(*) FROM " from                         \
			 " WHERE key BETWEEN ?1 AND ?2",                                           \
	}

#define PLANE_TABLE(word) TABLE(word, word, "low, high, 0.0, codec, revision, hash, 0, 0", "", "")

static const struct table tables[ROW_TABLES] = {
	TABLE("base", "base", "low, high, error, codec, revision, hash, 0, 0", ", error", ", ?8"),
	TABLE("offset", "\"offset\"", "low, high, 0.0, codec, revision, hash, below, above", ", below, above", ", ?8, ?9"),
	PLANE_TABLE("dirt"),
	PLANE_TABLE("heaped"),
	PLANE_TABLE("pressed"),
	PLANE_TABLE("shear"),
	PLANE_TABLE("dug"),
	PLANE_TABLE("settled"),
	PLANE_TABLE("loose"),
	PLANE_TABLE("floor"),
	PLANE_TABLE("density"),
	PLANE_TABLE("slope"),
	PLANE_TABLE("healed"),
	PLANE_TABLE("risen"),
	PLANE_TABLE("grown"),
};

enum status store_rows_init(struct rows *rows, sqlite3 *db, const char *path, const struct extent *extent,
		      enum codec_effort effort)
{
	*rows = (struct rows){.db = db, .path = path, .extent = extent};
	size_t side = tile_posts(extent);
	TRY(mem_make(&rows->wide, side * side, sizeof *rows->wide, "a tile"));
	enum status status = store_codec_init(&rows->codec, (uint32_t)side, effort);
	if (status != STATUS_OK)
		store_rows_finish(rows);
	return status;
}

void store_rows_finish(struct rows *rows)
{
	for (int i = 0; i < ROW_TABLES; i++) {
		sqlite3_finalize(rows->find[i]);
		sqlite3_finalize(rows->head[i]);
		sqlite3_finalize(rows->write[i]);
		sqlite3_finalize(rows->drop[i]);
		sqlite3_finalize(rows->under[i]);
	}
	sqlite3_finalize(rows->below);
	store_codec_finish(&rows->codec);
	mem_free(rows->wide);
	*rows = (struct rows){0};
}

const char *store_rows_name(enum row_table table)
{
	return tables[table].name;
}

const char *store_rows_sql_name(enum row_table table)
{
	return tables[table].sql_name;
}

void store_rows_text(const struct rows *rows, enum row_table table, struct tile tile, char *text, size_t room)
{
	snprintf(text, room, "%s: %s tile level %d x %u y %u", rows->path, tables[table].name, tile.level,
		 tile.x, tile.y);
}

enum status store_rows_bad(const struct rows *rows, enum row_table table, struct tile tile, const char *why)
{
	char text[256];
	store_rows_text(rows, table, tile, text, sizeof text);
	return fail_with(STATUS_INPUT, "%s: %s; the store is damaged, restore or import it again", text, why);
}

uint64_t store_rows_hash(enum row_table table, const struct row *row)
{
	/* SQLite keeps no negative zero. */
	double reals[3] = {row->low + 0.0, row->high + 0.0, row->error};
	uint64_t words[8] = {tile_key(row->tile), (uint64_t)row->codec};
	for (int i = 0; i < 3; i++)
		if (!isnan(reals[i])) /* NULL in the row: 0 here */
			memcpy(&words[2 + i], &reals[i], sizeof reals[i]);
	words[5] = (uint64_t)row->below;
	words[6] = (uint64_t)row->above;
	words[7] = table; /* that no row passes for one of another */
	uint8_t head[sizeof words];
	for (size_t i = 0; i < sizeof head; i++)
		head[i] = (uint8_t)(words[i / 8] >> i % 8 * 8);
	return XXH3_64bits_withSeed(row->bytes, row->size, XXH3_64bits(head, sizeof head));
}

static double column_real(sqlite3_stmt *statement, int column)
{
	return sqlite3_column_type(statement, column) == SQLITE_NULL ? (double)NAN
								       : sqlite3_column_double(statement, column);
}

static void take_head(sqlite3_stmt *statement, struct tile tile, struct row *row)
{
	*row = (struct row){
		.tile = tile,
		.low = column_real(statement, 0),
		.high = column_real(statement, 1),
		.error = sqlite3_column_double(statement, 2),
		.codec = sqlite3_column_int64(statement, 3),
		.revision = sqlite3_column_int64(statement, 4),
		.hash = (uint64_t)sqlite3_column_int64(statement, 5),
		.below = sqlite3_column_int64(statement, 6),
		.above = sqlite3_column_int64(statement, 7),
	};
}

static bool head_sane(enum row_table table, const struct row *row)
{
	if (row->below > 0 || row->below < -SUM_MAX || row->above < 0 || row->above > SUM_MAX)
		return false;
	if (isnan(row->low) || isnan(row->high))
		return table == ROW_BASE && isnan(row->low) && isnan(row->high);
	return row->low <= row->high && isfinite(row->low) && isfinite(row->high) && row->error >= 0 &&
	       isfinite(row->error);
}

/* Finds a row of this file. */
static enum status find_own(struct rows *rows, enum row_table table, struct tile tile, bool whole,
			    struct row *row, bool *found, sqlite3_stmt **out)
{
	assert(extent_has(rows->extent, tile));
	*found = false;
	sqlite3_stmt **statement = whole ? &rows->find[table] : &rows->head[table];
	TRY(store_sql_prepare(rows->db, rows->path, statement, whole ? tables[table].find : tables[table].head));
	*out = *statement;
	sqlite3_bind_int64(*out, 1, (sqlite3_int64)tile_key(tile));
	int code = sqlite3_step(*out);
	*found = code == SQLITE_ROW;
	if (code == SQLITE_DONE)
		return STATUS_OK;
	if (code != SQLITE_ROW)
		return store_sql_fail(rows->db, code, rows->path, "reading a tile");
	take_head(*out, tile, row);
	return head_sane(table, row) ? STATUS_OK : store_rows_bad(rows, table, tile, "its range or sums make no sense");
}

static const struct lineage_entry *inherited(const struct rows *rows, enum row_table table, uint64_t key)
{
	return rows->lineage != NULL ? store_lineage_find(rows->lineage, table, key) : NULL;
}

static void count_further(const struct rows *rows, enum row_table table, uint64_t reads)
{
	atomic_fetch_add_explicit(&rows->statements->inherited[table], reads, memory_order_relaxed);
}

/* Finds the row that counts. *at: the rows of the file that has it. */
static enum status find_row(struct rows *rows, enum row_table table, struct tile tile, bool whole,
			    struct row *row, bool *found, sqlite3_stmt **out, struct rows **at)
{
	TRY(find_own(rows, table, tile, whole, row, found, out));
	*at = rows;
	if (rows->lineage == NULL || table == ROW_BASE)
		return STATUS_OK;
	if (*found) {
		*found = !row_is_none(row);
		return STATUS_OK;
	}
	const struct lineage_entry *entry = inherited(rows, table, tile_key(tile));
	if (entry == NULL)
		return STATUS_OK;
	sqlite3_reset(*out);
	*at = rows->layers[entry->layer];
	count_further(rows, table, 1);
	TRY(find_own(*at, table, tile, whole, row, found, out));
	if (!*found)
		return store_rows_bad(*at, table, tile, "it is listed and cannot be found");
	return STATUS_OK;
}

enum status store_rows_head(struct rows *rows, enum row_table table, struct tile tile, struct row *row,
		      bool *found)
{
	sqlite3_stmt *statement = NULL;
	struct rows *at;
	enum status status = find_row(rows, table, tile, false, row, found, &statement, &at);
	sqlite3_reset(statement);
	return status;
}

/* Returns true if all posts are allowed in this table. Base posts are checked against the header when they are read. */
static bool all_fit(enum row_table table, const int32_t *posts, size_t count)
{
	static const int32_t most[ROW_TABLES] = {
		[ROW_DISTURBANCE] = UINT8_MAX, [ROW_PLASTIC_SINKAGE] = INT32_MAX, [ROW_DUG] = INT32_MAX,
		[ROW_LOOSE] = INT32_MAX, [ROW_FLOOR] = INT32_MAX, [ROW_DENSITY] = INT32_MAX,
		[ROW_HEALED] = INT32_MAX, [ROW_RISEN] = INT32_MAX, [ROW_GROWN] = INT32_MAX,
	};
	bool fits = true;
	for (size_t i = 0; i < count && table == ROW_SHEAR; i++)
		fits &= plane_shear(posts[i], PLANE_SHEAR_EAST) >= -PLANE_SHEAR_MOST && plane_shear(posts[i], PLANE_SHEAR_NORTH) >= -PLANE_SHEAR_MOST;
	for (size_t i = 0; i < count && most[table] != 0; i++)
		fits &= posts[i] >= 0 && posts[i] <= most[table];
	return fits;
}

static enum status take_bytes(const struct rows *rows, enum row_table table, sqlite3_stmt *statement, struct row *row)
{
	row->bytes = sqlite3_column_blob(statement, 8);
	row->size = (size_t)sqlite3_column_bytes(statement, 8);
	if (row->bytes == NULL)
		return store_rows_bad(rows, table, row->tile, "it is empty");
	if (store_rows_hash(table, row) != row->hash)
		return store_rows_bad(rows, table, row->tile, "its hash is wrong");
	return STATUS_OK;
}

enum status store_rows_take(const struct rows *rows, enum row_table table, struct tile tile, sqlite3_stmt *statement, struct row *row)
{
	take_head(statement, tile, row);
	if (!head_sane(table, row))
		return store_rows_bad(rows, table, tile, "its range or sums make no sense");
	return take_bytes(rows, table, statement, row);
}

/* `at`: the rows of the file that the statement reads. */
static enum status take_blob(struct rows *rows, const struct rows *at, enum row_table table, sqlite3_stmt *statement,
			     struct row *row, int32_t *posts)
{
	TRY(take_bytes(at, table, statement, row));
	if (!store_codec_decode(&rows->codec, row->codec, row->bytes, row->size, posts))
		return store_rows_bad(at, table, row->tile, "it cannot be decoded");
	size_t side = tile_posts(rows->extent);
	if (!all_fit(table, posts, side * side))
		return store_rows_bad(at, table, row->tile, "it has posts beyond its plane's range");
	return STATUS_OK;
}

enum status store_rows_read(struct rows *rows, enum row_table table, struct tile tile, int32_t *posts,
		      struct row *row, bool *found)
{
	sqlite3_stmt *statement = NULL;
	struct rows *at;
	enum status status;
	if (table == ROW_BASE && store_below_has(tile))
		return store_below_read(rows, tile, posts, row, found);
	TRY_OR(done, find_row(rows, table, tile, true, row, found, &statement, &at));
	if (*found)
		TRY_OR(done, take_blob(rows, at, table, statement, row, posts));
done:
	sqlite3_reset(statement);
	if (*found)
		row->bytes = NULL;
	return status;
}

static void bind_real(sqlite3_stmt *statement, int column, double value)
{
	if (isnan(value))
		sqlite3_bind_null(statement, column);
	else
		sqlite3_bind_double(statement, column, value);
}

void store_rows_encode(struct rows *rows, enum row_table table, const int32_t *posts, struct row *row)
{
	row->codec = store_codec_encode(&rows->codec, posts, &row->bytes, &row->size);
	row->hash = store_rows_hash(table, row);
}

/* Writes a row into this file. */
static enum status put_own(struct rows *rows, enum row_table table, const struct row *row)
{
	TRY(store_sql_prepare(rows->db, rows->path, &rows->write[table], tables[table].write));
	sqlite3_stmt *statement = rows->write[table];
	sqlite3_bind_int64(statement, 1, (sqlite3_int64)tile_key(row->tile));
	bind_real(statement, 2, row->low);
	bind_real(statement, 3, row->high);
	sqlite3_bind_int64(statement, 4, row->codec);
	sqlite3_bind_int64(statement, 5, row->revision);
	sqlite3_bind_int64(statement, 6, (sqlite3_int64)row->hash);
	sqlite3_bind_blob64(statement, 7, row->bytes, row->size, SQLITE_STATIC);
	if (table == ROW_BASE)
		sqlite3_bind_double(statement, 8, row->error);
	if (table == ROW_OFFSET) {
		sqlite3_bind_int64(statement, 8, row->below);
		sqlite3_bind_int64(statement, 9, row->above);
	}
	int code = sqlite3_step(statement);
	enum status status = code == SQLITE_DONE ? STATUS_OK : store_sql_fail(rows->db, code, rows->path, "writing a tile");
	sqlite3_reset(statement);
	sqlite3_bind_null(statement, 7);
	return status;
}

/* Removes a row from this file. */
static enum status drop_own(struct rows *rows, enum row_table table, struct tile tile)
{
	TRY(store_sql_prepare(rows->db, rows->path, &rows->drop[table], tables[table].drop));
	sqlite3_bind_int64(rows->drop[table], 1, (sqlite3_int64)tile_key(tile));
	int code = sqlite3_step(rows->drop[table]);
	enum status status = code == SQLITE_DONE ? STATUS_OK : store_sql_fail(rows->db, code, rows->path, "removing a tile");
	sqlite3_reset(rows->drop[table]);
	return status;
}

enum status store_rows_put(struct rows *rows, enum row_table table, const struct row *row)
{
	const struct lineage_entry *entry = inherited(rows, table, tile_key(row->tile));
	return entry != NULL && entry->hash == row->hash ? drop_own(rows, table, row->tile) : put_own(rows, table, row);
}

enum status store_rows_drop(struct rows *rows, enum row_table table, struct tile tile, int64_t revision)
{
	static const int32_t zero = 0;
	if (inherited(rows, table, tile_key(tile)) == NULL)
		return drop_own(rows, table, tile);
	struct row none = {.tile = tile, .codec = CODEC_CONSTANT, .revision = revision, .bytes = &zero, .size = sizeof zero};
	none.hash = store_rows_hash(table, &none);
	return put_own(rows, table, &none);
}

enum status store_rows_bytes(struct rows *rows, enum row_table table, struct tile tile, row_bytes_fn fn, void *user)
{
	sqlite3_stmt *statement = NULL;
	struct row row;
	struct rows *at;
	bool found;
	enum status status;
	TRY_OR(done, find_row(rows, table, tile, true, &row, &found, &statement, &at));
	if (found)
		TRY_OR(done, take_bytes(at, table, statement, &row));
	TRY_OR(done, fn(user, found ? &row : NULL));
done:
	sqlite3_reset(statement);
	return status;
}

enum status store_rows_copy(struct rows *from, struct rows *to, enum row_table table, struct tile tile, int64_t revision)
{
	sqlite3_stmt *statement = NULL;
	struct row row;
	struct rows *at;
	bool found;
	enum status status;
	TRY_OR(done, find_row(from, table, tile, true, &row, &found, &statement, &at));
	if (!found)
		TRY_OR(done, store_rows_bad(at, table, tile, "it is listed and cannot be found"));
	TRY_OR(done, take_bytes(at, table, statement, &row));
	row.revision = revision;
	TRY_OR(done, store_rows_put(to, table, &row));
done:
	sqlite3_reset(statement);
	return status;
}

/* As store_rows_under(), where rows may be inherited: looks for the four tiles one by one. */
static enum status under_inherited(struct rows *rows, enum row_table table, struct tile tile, double *low, double *high, int *count)
{
	enum status status = STATUS_OK;
	*low = (double)INFINITY;
	uint64_t looked_up = 0;
	*high = -(double)INFINITY;
	*count = 0;
	for (unsigned i = 0; i < 4; i++) {
		struct tile child = {tile.level - 1, 2 * tile.x + (i & 1), 2 * tile.y + (i >> 1)};
		struct row row;
		bool found = false;
		if (!extent_has(rows->extent, child))
			continue;
		looked_up++;
		TRY_OR(done, store_rows_head(rows, table, child, &row, &found));
		if (!found)
			continue;
		*low = fmin(*low, row.low);
		*high = fmax(*high, row.high);
		++*count;
	}
done:
	/* In a plain store one statement finds all of them. */
	count_further(rows, table, looked_up - 1);
	return status;
}

enum status store_rows_under(struct rows *rows, enum row_table table, struct tile tile, double *low,
		       double *high, int *count)
{
	uint64_t first, last;
	tile_descendants(tile, tile.level - 1, &first, &last);
	if (rows->lineage != NULL) {
		size_t at = store_lineage_from(rows->lineage, table, first);
		if (at < rows->lineage->count[table] && rows->lineage->entries[table][at].key <= last)
			return under_inherited(rows, table, tile, low, high, count);
	}
	TRY(store_sql_prepare(rows->db, rows->path, &rows->under[table], tables[table].under));
	sqlite3_stmt *statement = rows->under[table];
	sqlite3_bind_int64(statement, 1, (sqlite3_int64)first);
	sqlite3_bind_int64(statement, 2, (sqlite3_int64)last);
	int code = sqlite3_step(statement);
	enum status status = code == SQLITE_ROW ? STATUS_OK : store_sql_fail(rows->db, code, rows->path, "reading a tile");
	if (code == SQLITE_ROW) {
		*low = column_real(statement, 0);
		*high = column_real(statement, 1);
		*count = sqlite3_column_int(statement, 2);
	}
	sqlite3_reset(statement);
	return status;
}
