/*
 * Reads whole tiles and their ranges. Each reader has its own read-only connection to the store.
 *
 * A connection may be frozen (store_frozen.c). Then what it read counts only if nobody wrote meanwhile. Otherwise the reader connects anew
 * and reads again.
 */
#include "base/wide.h"
#include "store/internal.h"

#include <assert.h>
#include <string.h>

static enum status connect_rows(struct store *store, struct store_frozen *frozen, sqlite3 **db, struct rows *rows)
{
	int version = STORE_VERSION;
	uint64_t hash = 0;
	TRY(store_connect_reader(store_file_read(store), store->path, frozen, db));
	/* The name may meanwhile be another file's. */
	TRY(store_schema_check(*db, store->path, &version));
	if (version < STORE_VERSION)
		TRY(store_schema_hide(*db, store->path, version));
	if (store->shown >= 0)
		TRY(store_pinned_show(*db, store->path, store->shown));
	TRY(store_meta_base_hash(*db, store->path, &hash));
	if (hash != store->base_hash)
		return fail_with(STATUS_INPUT, "%s: another store took its place since it was opened; begin again", store->path);
	return store_rows_init(rows, *db, store->path, &store->meta.extent, CODEC_FAST);
}

/* Connects to each file under an overlay that has rows for it. The plain store always has: the base. */
static enum status connect_layers(struct store_reader *reader)
{
	struct store *store = reader->store;
	for (struct store *layer = store->under; layer != NULL; layer = layer->under) {
		int at = layer->depth;
		if (at > 0 && !store_lineage_uses(&store->lineage, (uint32_t)at))
			continue;
		TRY(connect_rows(layer, &reader->layer_frozen[at], &reader->layer_db[at], &reader->layer_rows[at]));
		if (store->inherits)
			TRY(store_overlay_hold(layer, reader->layer_db[at]));
		store_statements_count(&layer->statements, reader->layer_db[at]);
		reader->layers[at] = &reader->layer_rows[at];
	}
	if (store->inherits) {
		reader->rows.lineage = &store->lineage;
		reader->rows.statements = &store->statements;
		reader->rows.layers = reader->layers;
	}
	return STATUS_OK;
}

static void disconnect(struct store_reader *reader)
{
	sqlite3_finalize(reader->imagery);
	store_rows_finish(&reader->rows);
	sqlite3_close(reader->db);
	for (int at = 0; at < STORE_DEPTH_MOST; at++) {
		store_rows_finish(&reader->layer_rows[at]);
		sqlite3_close(reader->layer_db[at]);
	}
	*reader = (struct store_reader){.store = reader->store};
}

static enum status connect(struct store_reader *reader)
{
	struct store *store = reader->store;
	enum status status;
	reader->base = store->under != NULL ? &reader->layer_rows[0] : &reader->rows;
	reader->older = store->older && !atomic_load(&store->raised);
	TRY_OR(failed, connect_rows(store, &reader->frozen, &reader->db, &reader->rows));
	store_statements_count(&store->statements, reader->db);
	TRY_OR(failed, connect_layers(reader));
	return STATUS_OK;
failed:
	disconnect(reader);
	return status;
}

enum status store_reader_create(struct store *store, struct store_reader **out)
{
	assert(store->part_path == NULL);
	struct store_reader *reader = mem_calloc(1, sizeof *reader);
	TRY_MEM(reader, "a reader");
	reader->store = store;
	enum status status = connect(reader);
	if (status != STATUS_OK) {
		store_reader_destroy(reader);
		return status;
	}
	*out = reader;
	return STATUS_OK;
}

void store_reader_destroy(struct store_reader *reader)
{
	if (reader == NULL)
		return;
	disconnect(reader);
	mem_free(reader);
}

bool store_reader_outdated(const struct store_reader *reader)
{
	const struct store *store = reader->store;
	if (reader->db == NULL || sqlite3_get_autocommit(reader->db) == 0)
		return false;
	bool is = store_frozen_changed(store_file_read(store), &reader->frozen) || (reader->older && atomic_load(&store->raised));
	for (const struct store *layer = store->under; layer != NULL && !is; layer = layer->under)
		is = store_frozen_changed(store_file_read(layer), &reader->layer_frozen[layer->depth]);
	return is;
}

enum status store_reader_begin(struct store_reader *reader)
{
	if (reader->db != NULL && !store_reader_outdated(reader))
		return STATUS_OK;
	disconnect(reader);
	return connect(reader);
}

static enum status missing(const struct store_reader *reader, struct tile tile)
{
	char text[256];
	store_rows_text(reader->base, ROW_BASE, tile, text, sizeof text);
	return fail_with(STATUS_INPUT, "%s: it is missing; the store is damaged, restore or import it again", text);
}

static void range_of(const struct row *row, struct store_range *range)
{
	*range = (struct store_range){row->low, row->high, row->error};
}

FURROW_WIDE static bool all_between(const int32_t *codes, size_t count, int32_t low, int32_t high)
{
	int32_t bad = 0;
	for (size_t i = 0; i < count; i++)
		bad |= (codes[i] != HEIGHT_CODE_NODATA) & ((codes[i] < low) | (codes[i] > high));
	return bad == 0;
}

/* So that no caller needs to ask whether a height fits the lattice. */
static bool codes_fit(const struct store *store, const int32_t *codes, size_t count)
{
	return all_between(codes, count, store->code_low, store->code_high);
}

/* Only tiles of insets may be missing. */
static bool may_be_missing(const struct store_reader *reader, struct tile tile, bool *found)
{
	*found = tile.level >= store_finest_base(reader->store);
	return tile.level < 0;
}

static enum status find_base(struct store_reader *reader, struct tile tile, int32_t *codes, struct store_range *range, bool *found)
{
	struct row row;
	TRY(store_reader_begin(reader));
	bool may = may_be_missing(reader, tile, found);
	if (!*found)
		return STATUS_OK;
	TRY(store_rows_read(reader->base, ROW_BASE, tile, codes, &row, found));
	if (!*found)
		return may ? STATUS_OK : missing(reader, tile);
	size_t side = tile_posts(reader->rows.extent);
	if (!codes_fit(reader->store, codes, side * side)) {
		char text[256];
		store_rows_text(reader->base, ROW_BASE, tile, text, sizeof text);
		return fail_with(STATUS_INPUT, "%s: it has heights beyond the store's range; the store is damaged, "
				 "restore or import it again", text);
	}
	if (range != NULL)
		range_of(&row, range);
	return STATUS_OK;
}

enum status store_find_base(struct store_reader *reader, struct tile tile, int32_t *codes, struct store_range *range, bool *found)
{
	enum status status = find_base(reader, tile, codes, range, found);
	return store_reader_outdated(reader) ? store_find_base(reader, tile, codes, range, found) : status;
}

enum status store_read_base(struct store_reader *reader, struct tile tile, int32_t *codes, struct store_range *range)
{
	bool found;
	assert(tile.level >= 0);
	return store_find_base(reader, tile, codes, range, &found);
}

static enum status find_base_range(struct store_reader *reader, struct tile tile, struct store_range *range, bool *found)
{
	struct row row;
	TRY(store_reader_begin(reader));
	bool may = may_be_missing(reader, tile, found);
	if (!*found)
		return STATUS_OK;
	TRY(store_rows_head(reader->base, ROW_BASE, tile, &row, found));
	if (!*found)
		return may ? STATUS_OK : missing(reader, tile);
	range_of(&row, range);
	return STATUS_OK;
}

enum status store_find_base_range(struct store_reader *reader, struct tile tile, struct store_range *range, bool *found)
{
	enum status status = find_base_range(reader, tile, range, found);
	return store_reader_outdated(reader) ? store_find_base_range(reader, tile, range, found) : status;
}

enum status store_read_base_range(struct store_reader *reader, struct tile tile, struct store_range *range)
{
	bool found;
	assert(tile.level >= 0);
	return store_find_base_range(reader, tile, range, &found);
}

/* Converts the codec's int32 posts to the plane's own type. */
static void narrow(enum plane plane, const int32_t *wide, size_t count, void *texels)
{
	assert(plane_bytes(plane) == sizeof(uint8_t) || wide == texels);
	for (size_t i = 0; i < count && plane_bytes(plane) == sizeof(uint8_t); i++)
		((uint8_t *)texels)[i] = (uint8_t)wide[i];
}

static enum status read_plane(struct store_reader *reader, struct tile tile, enum plane plane, size_t count,
			      void *texels, bool *found)
{
	struct row row;
	int32_t *wide = plane_bytes(plane) == sizeof *wide ? texels : reader->rows.wide;
	TRY(store_rows_read(&reader->rows, row_table_of(plane), tile, wide, &row, found));
	if (*found)
		narrow(plane, wide, count, texels);
	else
		memset(texels, 0, count * plane_bytes(plane));
	return STATUS_OK;
}

static enum status read_planes(struct store_reader *reader, struct tile tile, unsigned wanted, void *const planes[PLANES], unsigned *present)
{
	size_t side = tile_posts(&reader->store->meta.extent);
	*present = 0;
	TRY(store_reader_begin(reader));
	for (int plane = 0; plane < PLANES; plane++) {
		bool found = false;
		if (!(wanted & PLANE_BIT(plane)))
			continue;
		TRY(read_plane(reader, tile, (enum plane)plane, side * side, planes[plane], &found));
		if (found)
			*present |= PLANE_BIT(plane);
	}
	return STATUS_OK;
}

enum status store_read_deformed(struct store_reader *reader, struct tile tile, unsigned wanted,
				void *const planes[PLANES], unsigned *present)
{
	enum status status = read_planes(reader, tile, wanted, planes, present);
	return store_reader_outdated(reader) ? store_read_deformed(reader, tile, wanted, planes, present) : status;
}

static enum status read_offset_range(struct store_reader *reader, struct tile tile, double *low, double *high, bool *found)
{
	struct row row;
	TRY(store_reader_begin(reader));
	TRY(store_rows_head(&reader->rows, ROW_OFFSET, tile, &row, found));
	if (*found) {
		*low = row.low;
		*high = row.high;
	}
	return STATUS_OK;
}

enum status store_read_offset_range(struct store_reader *reader, struct tile tile, double *low,
				    double *high, bool *found)
{
	enum status status = read_offset_range(reader, tile, low, high, found);
	return store_reader_outdated(reader) ? store_read_offset_range(reader, tile, low, high, found) : status;
}

struct keys {
	const struct rows *rows;
	enum row_table table;
	store_key_fn fn;
	void *user;
};

static enum status pass_key(void *user, const struct row_entry *entry)
{
	const struct keys *keys = user;
	if (extent_has(keys->rows->extent, tile_from_key(entry->key)))
		return keys->fn(keys->user, entry->key);
	return fail_with(STATUS_INPUT, "%s: it has an %s tile outside its terrain; the store is damaged, restore it",
			 keys->rows->path, store_rows_name(keys->table));
}

/* `of_base`: the rows of the base's file. Rows that were already passed on are not passed on again, so an outdated reader fails. */
static enum status each_key(struct store_reader *reader, bool of_base, enum row_table table, int level, store_key_fn fn, void *user)
{
	TRY(store_reader_begin(reader));
	struct rows *rows = of_base ? reader->base : &reader->rows;
	struct keys keys = {rows, table, fn, user};
	uint64_t first, last;
	level_keys(level, &first, &last);
	TRY(store_rows_each(rows, table, first, last, pass_key, &keys));
	if (store_reader_outdated(reader))
		return fail_with(STATUS_FAILED, "%s: another process began to write it while it was read; read it again", reader->store->path);
	return STATUS_OK;
}

enum status store_each_base(struct store_reader *reader, int level, store_key_fn fn, void *user)
{
	return each_key(reader, true, ROW_BASE, level, fn, user);
}

enum status store_each_offset(struct store_reader *reader, int level, store_key_fn fn, void *user)
{
	return each_key(reader, false, ROW_OFFSET, level, fn, user);
}

enum status store_each_plane(struct store_reader *reader, enum plane plane, int level, store_key_fn fn, void *user)
{
	return each_key(reader, false, row_table_of(plane), level, fn, user);
}
