/*
 * Base tiles of odd levels, which have no bytes of their own: their posts are every second one of the tiles below them.
 *
 * Of each four levels' bytes the odd ones' would be a fifth. One statement reads the tile's row and the rows below it.
 */
#include "store/internal.h"

#define KEY_COLUMN 9
#define COLUMNS "low, high, error, codec, revision, hash, 0, 0, blob, key"

bool store_below_has(struct tile tile)
{
	return tile.level > 0 && tile.level % 2 != 0;
}

uint8_t store_below_children(const struct extent *extent, struct tile tile)
{
	unsigned children = 0;
	for (unsigned i = 0; i < 4; i++)
		if (extent_has(extent, (struct tile){tile.level - 1, 2 * tile.x + (i & 1), 2 * tile.y + (i >> 1)}))
			children |= 1u << i;
	return (uint8_t)children;
}

/* Decodes every second post of a tile below into its quarter of the tile. */
static enum status take_quarter(struct rows *rows, struct tile tile, unsigned i, sqlite3_stmt *statement, int32_t *posts)
{
	const struct tile child = {tile.level - 1, 2 * tile.x + (i & 1), 2 * tile.y + (i >> 1)};
	const size_t cells = rows->extent->cells, side = cells + 1;
	struct row row;
	TRY(store_rows_take(rows, ROW_BASE, child, statement, &row));
	int32_t *quarter = posts + (i >> 1) * (cells / 2) * side + (i & 1) * (cells / 2);
	if (!store_codec_decode_half(&rows->codec, row.codec, row.bytes, row.size, quarter, side, rows->wide))
		return store_rows_bad(rows, ROW_BASE, child, "it cannot be decoded");
	return STATUS_OK;
}

/* The statement is at the tile's own row; the rows below it follow. */
static enum status take_quarters(struct rows *rows, struct tile tile, sqlite3_stmt *statement, const struct row *row, int32_t *posts)
{
	const uint8_t children = store_below_children(rows->extent, tile);
	const size_t side = tile_posts(rows->extent);
	const uint64_t first = tile_key((struct tile){tile.level - 1, 2 * tile.x, 2 * tile.y});
	unsigned seen = 0;
	int code;
	if (row->size != 1 || *(const uint8_t *)row->bytes != children)
		return store_rows_bad(rows, ROW_BASE, tile, "it cannot be decoded");
	for (size_t i = 0; i < side * side && children != 15; i++)
		posts[i] = CODEC_NODATA;
	while ((code = sqlite3_step(statement)) == SQLITE_ROW) {
		unsigned i = (unsigned)((uint64_t)sqlite3_column_int64(statement, KEY_COLUMN) - first);
		if (i > 3 || (children >> i & 1) == 0)
			return store_rows_bad(rows, ROW_BASE, tile, "below it is a tile outside the terrain");
		seen |= 1u << i;
		TRY(take_quarter(rows, tile, i, statement, posts));
	}
	if (code != SQLITE_DONE)
		return store_sql_fail(rows->db, code, rows->path, "reading a tile");
	return seen == children ? STATUS_OK : store_rows_bad(rows, ROW_BASE, tile, "a tile below it is missing");
}

static enum status read_row(struct rows *rows, struct tile tile, sqlite3_stmt *statement, int32_t *posts, struct row *row,
			    bool *found)
{
	const uint64_t key = tile_key(tile);
	uint64_t first, last;
	tile_descendants(tile, tile.level - 1, &first, &last);
	sqlite3_bind_int64(statement, 1, (sqlite3_int64)key);
	sqlite3_bind_int64(statement, 2, (sqlite3_int64)first);
	sqlite3_bind_int64(statement, 3, (sqlite3_int64)last);
	int code = sqlite3_step(statement);
	if (code != SQLITE_ROW && code != SQLITE_DONE)
		return store_sql_fail(rows->db, code, rows->path, "reading a tile");
	*found = code == SQLITE_ROW && (uint64_t)sqlite3_column_int64(statement, KEY_COLUMN) == key;
	if (!*found)
		return STATUS_OK;
	TRY(store_rows_take(rows, ROW_BASE, tile, statement, row));
	if (row->codec == CODEC_BELOW)
		return take_quarters(rows, tile, statement, row, posts);
	if (!store_codec_decode(&rows->codec, row->codec, row->bytes, row->size, posts))
		return store_rows_bad(rows, ROW_BASE, tile, "it cannot be decoded");
	return STATUS_OK;
}

enum status store_below_read(struct rows *rows, struct tile tile, int32_t *posts, struct row *row, bool *found)
{
	*found = false;
	TRY(store_sql_prepare(rows->db, rows->path, &rows->below,
			      "SELECT " COLUMNS " FROM base WHERE key = ?1 "
			      "UNION ALL SELECT " COLUMNS " FROM base WHERE key BETWEEN ?2 AND ?3"));
	enum status status = read_row(rows, tile, rows->below, posts, row, found);
	sqlite3_reset(rows->below);
	if (*found)
		row->bytes = NULL;
	return status;
}
