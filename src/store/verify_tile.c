/*
 * Checks one tile: that it decodes, its range and its sums. Compares its edges with the tiles beside it, and its posts with the
 * tiles that it covers. Checks that there is a tile above it.
 *
 * A tile that does not decode is reported once, and comparisons with it are left out. A missing row of a plane counts as zeros.
 * store_verify.c reports a missing row of the base.
 */
#include "store/verify.h"

#include <math.h>
#include <string.h>

/* --- other tiles --- */

/* Reads a tile of the table that is checked. Wrong content is not a failure of this function: it sets *held to HELD_BROKEN, and
 * the failure message tells the reason. */
static enum status read_tile(struct verifying *verifying, struct tile tile, int32_t *posts, struct row *row,
			     enum held *held)
{
	bool found;
	enum status status = store_rows_read(store_table(verifying->store, verifying->table), verifying->table, tile, posts,
				       row, &found);
	*held = status == STATUS_INPUT ? HELD_BROKEN : found ? HELD_POSTS : HELD_MISSING;
	return status == STATUS_INPUT ? STATUS_OK : status;
}

static enum status other_tile(struct verifying *verifying, struct tile tile, struct entry **out)
{
	uint64_t key = tile_key(tile);
	struct entry *entry = &verifying->entries[key % verifying->entry_count];
	*out = entry;
	if (entry->held != HELD_NOTHING && entry->key == key && entry->table == verifying->table)
		return STATUS_OK;
	entry->held = HELD_NOTHING;
	entry->key = key;
	entry->table = verifying->table;
	size_t count = verifying->side * verifying->side;
	if (entry->posts == NULL && (entry->posts = mem_alloc(count, sizeof *entry->posts)) == NULL)
		return fail_memory("verifying");
	return read_tile(verifying, tile, entry->posts, &entry->row, &entry->held);
}

/* --- one tile --- */

static void widen(struct row *range, const struct row *with)
{
	if (isnan(with->low))
		return;
	range->low = isnan(range->low) || with->low < range->low ? with->low : range->low;
	range->high = isnan(range->high) || with->high > range->high ? with->high : range->high;
}

/* Returns the value of all posts of a tile without a row. */
static int32_t absent(const struct verifying *verifying)
{
	return verifying->table == ROW_BASE ? HEIGHT_CODE_NODATA : 0;
}

/* `other`: the posts of the neighbour; NULL: it has no row. */
static bool edge_same(const struct verifying *verifying, const int32_t *other, bool east)
{
	size_t side = verifying->side;
	for (size_t i = 0; i < side; i++) {
		int32_t mine = verifying->posts[east ? i * side + side - 1 : (side - 1) * side + i];
		if (mine != (other != NULL ? other[east ? i * side : i] : absent(verifying)))
			return false;
	}
	return true;
}

/* Returns true if the west or south edge is that of a tile without a row. Used only if the neighbour there has no row. If it has
 * one, check_edges compares this edge when it checks the neighbour. */
static bool near_edge_absent(const struct verifying *verifying, bool west)
{
	size_t side = verifying->side;
	for (size_t i = 0; i < side; i++)
		if (verifying->posts[west ? i * side : i] != absent(verifying))
			return false;
	return true;
}

static enum status check_edges(struct verifying *verifying, struct tile tile)
{
	const struct extent *extent = &verifying->store->meta.extent;
	const bool may_be_missing = verifying->table != ROW_BASE || tile.level < 0;
	for (int north = 0; north < 2; north++) {
		struct tile next = {tile.level, tile.x + !north, tile.y + (unsigned)north};
		struct entry *other;
		if (!extent_has(extent, next))
			continue;
		TRY(other_tile(verifying, next, &other));
		bool compared = other->held == HELD_POSTS || (other->held == HELD_MISSING && may_be_missing);
		if (compared && !edge_same(verifying, other->held == HELD_POSTS ? other->posts : NULL, !north))
			store_verify_tell_tile(verifying, tile, north ? "its north edge is not its neighbour's south edge"
							 : "its east edge is not its neighbour's west edge");
	}
	for (int south = 0; south < 2 && may_be_missing; south++) {
		if (south ? tile.y == 0 : tile.x == 0)
			continue;
		struct tile before = {tile.level, tile.x - !south, tile.y - (unsigned)south};
		struct entry *other;
		TRY(other_tile(verifying, before, &other));
		if (other->held == HELD_MISSING && !near_edge_absent(verifying, !south))
			store_verify_tell_tile(verifying, tile, south ? "its south edge is not its neighbour's north edge"
							 : "its west edge is not its neighbour's east edge");
	}
	return STATUS_OK;
}

/* In a part, tiles that other parts have now are as they were. So a post that several tiles share may differ in them. */
static bool planes_of_part(const struct verifying *verifying)
{
	return verifying->store->part.count > 0 && verifying->table != ROW_BASE;
}

/* Returns true if the posts are those that are expected; of a part, those that no two tiles below share. */
static bool same_as_expected(const struct verifying *verifying)
{
	size_t side = verifying->side, half = (side - 1) / 2;
	bool same = true;
	if (!planes_of_part(verifying))
		return memcmp(verifying->expected, verifying->posts, side * side * sizeof *verifying->posts) == 0;
	for (size_t y = 0; y < side; y++)
		for (size_t x = 0; x < side; x++)
			same &= x % half == 0 || y % half == 0 || verifying->expected[y * side + x] == verifying->posts[y * side + x];
	return same;
}

/* Checks that this tile has every second post of the tiles below it. `expected` gets the posts that it should have. Widens `range`
 * by the ranges of the tiles below. *exact: false if a tile below cannot be read. */
static enum status check_below(struct verifying *verifying, struct tile tile, struct row *range, bool *exact)
{
	const struct extent *extent = &verifying->store->meta.extent;
	size_t count = verifying->side * verifying->side;
	bool base = verifying->table == ROW_BASE;
	int children = 0;
	*exact = true;
	for (size_t i = 0; i < count; i++)
		verifying->expected[i] = base ? HEIGHT_CODE_NODATA : 0;
	for (unsigned i = 0; i < 4; i++) {
		struct tile child = {tile.level - 1, 2 * tile.x + (i & 1), 2 * tile.y + (i >> 1)};
		struct entry *other;
		if (!extent_has(extent, child))
			continue;
		TRY(other_tile(verifying, child, &other));
		if (other->held == HELD_BROKEN || (base && other->held == HELD_MISSING)) {
			*exact = false;
			children++;
		}
		if (other->held != HELD_POSTS)
			continue;
		children++;
		widen(range, &other->row);
		lattice_decimate_i32(other->posts, extent->cells, i & 1, i >> 1, verifying->expected);
	}
	if (children == 0)
		store_verify_tell_tile(verifying, tile, "there is no tile below it");
	else if (*exact && !same_as_expected(verifying))
		store_verify_tell_tile(verifying, tile, "it is not every second post of the tiles below it");
	return STATUS_OK;
}

static bool same_where_stored(const struct verifying *verifying)
{
	for (size_t i = 0; i < verifying->side * verifying->side; i++)
		if (verifying->expected[i] != HEIGHT_CODE_NODATA && verifying->expected[i] != verifying->posts[i])
			return false;
	return true;
}

/* Checks a tile at level 0 or below, where insets may have some of the tiles below it. Each post that one of these has must be the
 * same in this tile. Widens `range` by their ranges. *exact: as above. */
static enum status check_insets(struct verifying *verifying, struct tile tile, struct row *range, bool *exact)
{
	const struct extent *extent = &verifying->store->meta.extent;
	bool stored = false;
	*exact = true;
	for (size_t i = 0; i < verifying->side * verifying->side; i++) {
		verifying->expected[i] = HEIGHT_CODE_NODATA;
		stored |= verifying->posts[i] != HEIGHT_CODE_NODATA;
	}
	for (unsigned i = 0; i < 4; i++) {
		struct tile child = {tile.level - 1, 2 * tile.x + (i & 1), 2 * tile.y + (i >> 1)};
		struct entry *other;
		if (!extent_has(extent, child))
			continue;
		TRY(other_tile(verifying, child, &other));
		*exact &= other->held != HELD_BROKEN;
		if (other->held != HELD_POSTS)
			continue;
		widen(range, &other->row);
		lattice_decimate_i32(other->posts, extent->cells, i & 1, i >> 1, verifying->expected);
	}
	if (!same_where_stored(verifying))
		store_verify_tell_tile(verifying, tile, "it does not have every second post of the tiles below it");
	if (tile.level < 0 && !stored)
		store_verify_tell_tile(verifying, tile, "it has no post, it should have no row");
	return STATUS_OK;
}

static enum status check_above(struct verifying *verifying, struct tile tile)
{
	struct row above;
	bool found;
	enum status status = store_rows_head(store_table(verifying->store, verifying->table), verifying->table,
				       tile_ancestor(tile, tile.level + 1), &above, &found);
	if (status == STATUS_INPUT)
		return STATUS_OK; /* reported when the tile above is checked */
	TRY(status);
	if (!found)
		store_verify_tell_tile(verifying, tile, "there is no tile above it");
	return STATUS_OK;
}

static void check_values(struct verifying *verifying, const struct row *row)
{
	size_t count = verifying->side * verifying->side;
	bool zero = true;
	for (size_t i = 0; i < count; i++)
		zero &= verifying->posts[i] == 0;
	if (verifying->table != ROW_BASE && zero && row->tile.level == verifying->store->working)
		store_verify_tell_tile(verifying, row->tile, "all its posts are zero, it should have no row");
	if (verifying->table != ROW_OFFSET)
		return;
	int64_t below, above;
	store_rows_sums(&verifying->store->meta.extent, row->tile, verifying->posts, &below, &above);
	if (below != row->below || above != row->above)
		store_verify_tell_tile(verifying, row->tile, "its sums are not those of its posts");
	verifying->check->offset_sum[row->tile.level - TILE_LEVEL_MIN] += below + above;
}

enum status store_verify_tile(struct verifying *verifying, struct tile tile)
{
	struct store *store = verifying->store;
	const struct extent *extent = &store->meta.extent;
	int finest = verifying->table == ROW_BASE ? store->finest_base : store->working, coarsest = extent_coarsest(extent);
	if ((verifying->table != ROW_BASE && !store->working_stored) || tile.level < finest) {
		store_verify_tell_tile(verifying, tile, "it is finer than the level that is deformed");
		return STATUS_OK;
	}
	if (row_is_state(verifying->table) && tile.level > finest) {
		store_verify_tell_tile(verifying, tile, "it is coarser than the level that is deformed, which alone has it");
		return STATUS_OK;
	}
	struct row row, range = {.low = (double)NAN, .high = (double)NAN};
	enum held held;
	TRY(read_tile(verifying, tile, verifying->posts, &row, &held));
	if (held == HELD_MISSING) {
		store_verify_tell_tile(verifying, tile, "it is listed and cannot be found");
		return STATUS_OK;
	}
	if (held != HELD_POSTS) {
		/* The message begins with the path of the store, which the reader of the report knows: leave it out. */
		const char *text = failure_message(), *path = store_table(store, verifying->table)->path;
		size_t length = strlen(path);
		store_verify_tell(verifying, "%s", strncmp(text, path, length) == 0 ? text + length + 2 : text);
		return STATUS_OK;
	}
	check_values(verifying, &row);
	store_rows_range(verifying->table, verifying->posts, verifying->side * verifying->side, store->meta.step,
		   &range.low, &range.high);
	bool exact = true;
	if (verifying->table == ROW_BASE && tile.level <= 0)
		TRY(check_insets(verifying, tile, &range, &exact));
	else if (tile.level > finest)
		TRY(check_below(verifying, tile, &range, &exact));
	if (exact && !(verify_same(range.low, row.low) && verify_same(range.high, row.high)))
		store_verify_tell_tile(verifying, tile, "its range is not that of its posts and of those below");
	if (!planes_of_part(verifying))
		TRY(check_edges(verifying, tile));
	return tile.level < coarsest && !row_is_state(verifying->table) ? check_above(verifying, tile) : STATUS_OK;
}
