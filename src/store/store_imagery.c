/*
 * Reads imagery: the table `imagery` of the plain store at the end of a chain, a row for each tile that has a pixel.
 *
 *   no table (version 8) --import begins--> rows and `imagery_request` --finished--> `imagery_level` and `imagery_hash`
 *
 * Invariants:
 *   1. A store has imagery if and only if its header has `imagery_level`. Rows without it are of an import that was broken off.
 *   2. Each tile has all tiles above it.
 */
#include "store/internal.h"

#include <stdio.h>
#include <string.h>
#include <xxhash.h>

const struct store *store_imagery_holder(const struct store *store)
{
	while (store->under != NULL)
		store = store->under;
	return store;
}

uint64_t store_imagery_row_hash(uint64_t key, int64_t codec, const void *bytes, size_t size)
{
	return XXH3_64bits_withSeed(bytes, size, key ^ (uint64_t)codec << 56);
}

/* --- what the header says --- */

/* Copies the sources, whole lines only. */
static enum status copy_sources(const struct store *store, char *text, size_t room)
{
	char *all;
	TRY(store_meta_find_text(store, "imagery_sources", &all));
	snprintf(text, room, "%s", all != NULL ? all : "");
	char *last = strrchr(text, '\n');
	if (all != NULL && strlen(all) >= room && last != NULL)
		last[1] = '\0';
	mem_free(all);
	return STATUS_OK;
}

static enum status bad_header(const struct store *store, const char *key)
{
	return fail_with(STATUS_INPUT, "%s: its header has a wrong %s; the store is damaged, restore it, or import its imagery again with --overwrite",
			 store->path, key);
}

enum status store_imagery_open(struct store *store)
{
	int64_t finest = 0, quality = 0, hash = 0;
	bool quality_known = false, hash_known = false;
	store->has_imagery = false;
	if (store->version < STORE_VERSION_IMAGERY || store->base_path != NULL)
		return STATUS_OK;
	TRY(store_meta_find_integer(store, "imagery_level", &store->has_imagery, &finest));
	if (!store->has_imagery)
		return STATUS_OK;
	TRY(store_meta_find_integer(store, "imagery_quality", &quality_known, &quality));
	TRY(store_meta_find_integer(store, "imagery_hash", &hash_known, &hash));
	if (finest < TILE_LEVEL_MIN || finest > extent_coarsest(&store->meta.extent))
		return bad_header(store, "imagery_level");
	if (!quality_known || quality < 0 || quality > 100)
		return bad_header(store, "imagery_quality");
	if (!hash_known)
		return bad_header(store, "imagery_hash");
	store->imagery_finest = (int)finest;
	store->imagery_quality = (int)quality;
	store->imagery_hash = (uint64_t)hash;
	return STATUS_OK;
}

bool store_has_imagery(const struct store *store, int *finest, int *quality)
{
	const struct store *holder = store_imagery_holder(store);
	if (holder->has_imagery && finest != NULL)
		*finest = holder->imagery_finest;
	if (holder->has_imagery && quality != NULL)
		*quality = holder->imagery_quality;
	return holder->has_imagery;
}

uint64_t store_imagery_hash(const struct store *store)
{
	const struct store *holder = store_imagery_holder(store);
	return holder->has_imagery ? holder->imagery_hash : 0;
}

enum status store_imagery_info(const struct store *store, struct store_imagery *out)
{
	const struct store *holder = store_imagery_holder(store);
	*out = (struct store_imagery){.found = holder->has_imagery};
	if (holder->version < STORE_VERSION_IMAGERY)
		return STATUS_OK;
	TRY(store_sql_integer(holder->db, holder->path, "SELECT count(*) FROM imagery", &out->tiles));
	out->broken_off = !out->found && out->tiles > 0;
	if (!out->found) {
		out->tiles = 0;
		return STATUS_OK;
	}
	out->finest = holder->imagery_finest;
	out->quality = holder->imagery_quality;
	TRY(store_sql_integer(holder->db, holder->path, "SELECT coalesce(sum(length(blob)), 0) FROM imagery", &out->bytes));
	return copy_sources(holder, out->sources, sizeof out->sources);
}

/* --- tiles --- */

static enum status damaged(const char *path, struct tile tile)
{
	return fail_with(STATUS_INPUT, "%s: imagery tile level %d x %u y %u: it is damaged; restore the store, or import its imagery again with --overwrite",
			 path, tile.level, tile.x, tile.y);
}

/* Unpacks the row that a statement gives: codec, hash, blob. */
static enum status take_row(const char *path, const struct extent *extent, struct tile tile, sqlite3_stmt *statement, uint8_t *pixels)
{
	const int64_t codec = sqlite3_column_int64(statement, 0);
	const uint64_t hash = (uint64_t)sqlite3_column_int64(statement, 1);
	const void *bytes = sqlite3_column_blob(statement, 2);
	const size_t size = (size_t)sqlite3_column_bytes(statement, 2);
	TRY(store_imagery_check(path));
	if (codec != STORE_IMAGERY_WEBP || bytes == NULL || store_imagery_row_hash(tile_key(tile), codec, bytes, size) != hash ||
	    !store_imagery_unpack(bytes, size, tile_posts(extent), pixels))
		return damaged(path, tile);
	return STATUS_OK;
}

static enum status read_tile(struct store_reader *reader, struct tile tile, uint8_t *pixels, bool *found)
{
	const struct extent *extent = &reader->store->meta.extent;
	const size_t side = tile_posts(extent);
	*found = false;
	TRY(store_reader_begin(reader));
	sqlite3 *db = reader->base->db;
	const char *path = reader->base->path;
	memset(pixels, 0, side * side * 4);
	enum status status = STATUS_OK;
	if (reader->imagery == NULL)
		TRY(store_sql_prepare(db, path, &reader->imagery, "SELECT codec, hash, blob FROM imagery WHERE key = ?"));
	sqlite3_stmt *const statement = reader->imagery;
	sqlite3_bind_int64(statement, 1, (sqlite3_int64)tile_key(tile));
	const int code = sqlite3_step(statement);
	if (code == SQLITE_ROW) {
		*found = true;
		TRY_OR(done, take_row(path, extent, tile, statement, pixels));
	} else if (code != SQLITE_DONE) {
		TRY_OR(done, store_sql_fail(db, code, path, "reading its imagery"));
	}
done:
	sqlite3_reset(statement); /* it must hold no transaction: readers see what is committed later */
	return status;
}

enum status store_imagery_read(struct store_reader *reader, struct tile tile, uint8_t *pixels, bool *found)
{
	*found = false;
	if (!store_has_imagery(reader->store, NULL, NULL)) {
		const size_t side = tile_posts(&reader->store->meta.extent);
		memset(pixels, 0, side * side * 4);
		return STATUS_OK;
	}
	enum status status = read_tile(reader, tile, pixels, found);
	return store_reader_outdated(reader) ? store_imagery_read(reader, tile, pixels, found) : status;
}

/* --- rectangles --- */

/* Copies what a tile has of `rect` into the pixels of the rectangle. */
static void place_tile(const struct extent *extent, struct tile tile, const uint8_t *from, struct post_rect rect, uint8_t *to)
{
	const struct post_rect all = tile_post_rect(extent, tile), part = post_rect_intersect(all, rect);
	const size_t width = (size_t)(rect.x1 - rect.x0), side = tile_posts(extent);
	for (int64_t y = part.y0; y < part.y1; y++)
		memcpy(to + 4 * ((size_t)(y - rect.y0) * width + (size_t)(part.x0 - rect.x0)),
		       from + 4 * ((size_t)(y - all.y0) * side + (size_t)(part.x0 - all.x0)), 4 * (size_t)(part.x1 - part.x0));
}

static enum status read_stored(struct store_reader *reader, int level, struct post_rect rect, uint8_t *pixels)
{
	const struct extent *extent = &reader->store->meta.extent;
	struct tile first, last;
	memset(pixels, 0, 4 * (size_t)(rect.x1 - rect.x0) * (size_t)(rect.y1 - rect.y0));
	if (!tile_range_of(extent, level, rect, &first, &last))
		return STATUS_OK;
	const size_t side = tile_posts(extent);
	uint8_t *tile = mem_alloc(side * side, 4);
	TRY_MEM(tile, "imagery");
	enum status status = STATUS_OK;
	for (uint32_t y = first.y; y <= last.y; y++)
		for (uint32_t x = first.x; x <= last.x; x++) {
			bool found;
			TRY_OR(done, store_imagery_read(reader, (struct tile){level, x, y}, tile, &found));
			if (found)
				place_tile(extent, (struct tile){level, x, y}, tile, rect, pixels);
		}
done:
	mem_free(tile);
	return status;
}

/* Bilinear between four pixels, at (fx, fy) / 2^shift of the way. Colours count by their opacity. */
static void blend(const uint8_t *const corners[4], uint32_t fx, uint32_t fy, int shift, uint8_t *out)
{
	const uint64_t s = 1u << shift;
	const uint64_t weights[4] = {(s - fx) * (s - fy), fx * (s - fy), (s - fx) * fy, fx * fy};
	uint64_t sums[4] = {0};
	for (int i = 0; i < 4; i++) {
		const uint64_t opaque = weights[i] * corners[i][3];
		for (int c = 0; c < 3; c++)
			sums[c] += opaque * corners[i][c];
		sums[3] += opaque;
	}
	for (int c = 0; c < 3; c++)
		out[c] = sums[3] == 0 ? 0 : (uint8_t)((sums[c] + sums[3] / 2) / sums[3]);
	out[3] = (uint8_t)((sums[3] + s * s / 2) / (s * s));
	if (out[3] == 0)
		memset(out, 0, 3);
}

static void refine(const uint8_t *from, struct post_rect coarse, int shift, struct post_rect rect, uint8_t *to)
{
	const size_t width = (size_t)(coarse.x1 - coarse.x0);
	const uint32_t mask = (1u << shift) - 1;
	for (int64_t y = rect.y0; y < rect.y1; y++)
		for (int64_t x = rect.x0; x < rect.x1; x++, to += 4) {
			const size_t at = (size_t)((y >> shift) - coarse.y0) * width + (size_t)((x >> shift) - coarse.x0);
			const uint8_t *corner = from + 4 * at;
			const uint8_t *const corners[4] = {corner, corner + 4, corner + 4 * width, corner + 4 * width + 4};
			blend(corners, (uint32_t)x & mask, (uint32_t)y & mask, shift, to);
		}
}

enum status store_imagery_read_rect(struct store_reader *reader, int level, struct post_rect rect, uint8_t *pixels)
{
	int finest = level;
	if (!store_has_imagery(reader->store, &finest, NULL) || level >= finest)
		return read_stored(reader, level, rect, pixels);
	const int shift = finest - level;
	const struct post_rect coarse = {rect.x0 >> shift, rect.y0 >> shift, (rect.x1 >> shift) + 2, (rect.y1 >> shift) + 2};
	uint8_t *from = mem_alloc((size_t)(coarse.x1 - coarse.x0) * (size_t)(coarse.y1 - coarse.y0), 4);
	TRY_MEM(from, "imagery");
	enum status status = read_stored(reader, finest, coarse, from);
	if (status == STATUS_OK)
		refine(from, coarse, shift, rect, pixels);
	mem_free(from);
	return status;
}
