/*
 * The pyramid of imagery, row by row.
 *
 *   row of level L -> strip of cells + 1 rows -> tiles of level L
 *                  -> sums of three rows      -> row of level L + 1
 *
 * Invariants:
 *   1. A colour counts by its opacity, and pixels beyond the terrain do not count. All sums are whole numbers.
 *   2. A pixel of a level is opaque to some degree if one of the nine under it is. So a tile with a pixel has all tiles above it.
 */
#include "intake/internal.h"

#include <string.h>

#include "base/crew.h"

struct packed_tile {
	void *bytes;
	size_t size;
	bool has, empty; /* the store has it already; it has no pixel */
};

struct level_rows {
	int level;
	int64_t width, height, next; /* pixels; the row that comes next */
	uint8_t *strip;              /* (cells + 1) * width pixels: rows from the first of tile row `tile_y` */
	uint32_t tiles_x, tiles_y, tile_y;
	uint32_t *sums; /* of each pixel of the level above: red, green, blue, opacity, and the weights of the pixels there are */
	uint8_t *above; /* a row of that level */
};

struct imagery_rows {
	struct store *store;
	const struct extent *extent;
	int quality;
	struct crew *crew;
	size_t members;
	uint8_t **scratch; /* of each member: a tile */
	struct level_rows *levels;
	size_t count;
	struct level_rows *packing; /* while the crew packs */
	struct packed_tile *tiles;
	int64_t kept;
};

#define SUMS 5

static enum status level_init(struct level_rows *rows, const struct extent *extent, int level, bool top)
{
	rows->level = level;
	rows->width = extent_posts(extent->width, level);
	rows->height = extent_posts(extent->height, level);
	rows->tiles_x = extent_tiles_x(extent, level);
	rows->tiles_y = extent_tiles_y(extent, level);
	TRY(mem_make(&rows->strip, tile_posts(extent) * (size_t)rows->width, 4, "imagery"));
	if (top)
		return STATUS_OK;
	const size_t above = (size_t)extent_posts(extent->width, level + 1);
	TRY(mem_zeroed(&rows->sums, above, SUMS * sizeof *rows->sums, "imagery"));
	return mem_make(&rows->above, above, 4, "imagery");
}

static enum status make_all(struct imagery_rows *rows, int finest)
{
	const size_t side = tile_posts(rows->extent);
	TRY(mem_zeroed(&rows->levels, rows->count, sizeof *rows->levels, "imagery"));
	for (size_t i = 0; i < rows->count; i++)
		TRY(level_init(&rows->levels[i], rows->extent, finest + (int)i, i + 1 == rows->count));
	TRY(mem_zeroed(&rows->tiles, rows->levels[0].tiles_x, sizeof *rows->tiles, "imagery"));
	TRY(mem_zeroed(&rows->scratch, rows->members, sizeof *rows->scratch, "imagery"));
	for (size_t i = 0; i < rows->members; i++)
		TRY(mem_make(&rows->scratch[i], side * side, 4, "imagery"));
	return crew_create(rows->members, "furrow-pack", NULL, NULL, &rows->crew);
}

enum status intake_imagery_rows_create(struct store *store, int finest, int quality, int64_t jobs, struct imagery_rows **out)
{
	struct imagery_rows *rows = mem_calloc(1, sizeof *rows);
	TRY_MEM(rows, "imagery");
	rows->store = store;
	rows->extent = &store_meta(store)->extent;
	rows->quality = quality;
	rows->members = jobs > 1 ? (size_t)jobs : 1;
	rows->count = (size_t)(extent_coarsest(rows->extent) - finest + 1);
	const enum status status = make_all(rows, finest);
	if (status == STATUS_OK)
		*out = rows;
	else
		intake_imagery_rows_destroy(rows);
	return status;
}

static void free_tiles(struct imagery_rows *rows)
{
	for (uint32_t x = 0; rows->tiles != NULL && x < rows->levels[0].tiles_x; x++) {
		mem_free(rows->tiles[x].bytes);
		rows->tiles[x] = (struct packed_tile){.bytes = NULL};
	}
}

void intake_imagery_rows_destroy(struct imagery_rows *rows)
{
	if (rows == NULL)
		return;
	crew_destroy(rows->crew);
	free_tiles(rows);
	for (size_t i = 0; rows->levels != NULL && i < rows->count; i++)
		mem_free_all(rows->levels[i].strip, rows->levels[i].sums, rows->levels[i].above);
	for (size_t i = 0; rows->scratch != NULL && i < rows->members; i++)
		mem_free(rows->scratch[i]);
	mem_free_all(rows->levels, rows->tiles, rows->scratch, rows);
}

/* --- a row of tiles --- */

/* Copies a tile out of the strip. Returns false if it has no pixel. */
static bool cut(const struct imagery_rows *rows, const struct level_rows *level, uint32_t x, uint8_t *pixels)
{
	const int64_t cells = rows->extent->cells, side = cells + 1, first = (int64_t)level->tile_y * cells;
	const int64_t columns = level->width - (int64_t)x * cells, have = level->next - first;
	bool any = false;
	memset(pixels, 0, 4 * (size_t)(side * side));
	for (int64_t y = 0; y < side && y < have && columns > 0; y++)
		memcpy(pixels + 4 * y * side, level->strip + 4 * (y * level->width + (int64_t)x * cells), 4 * (size_t)(columns < side ? columns : side));
	for (int64_t i = 0; i < side * side && !any; i++)
		any = pixels[4 * i + 3] != 0;
	return any;
}

static enum status pack_tile(void *user, size_t member, size_t task)
{
	struct imagery_rows *rows = user;
	struct packed_tile *tile = &rows->tiles[task];
	if (tile->has)
		return STATUS_OK;
	tile->empty = !cut(rows, rows->packing, (uint32_t)task, rows->scratch[member]);
	return tile->empty ? STATUS_OK : store_imagery_pack(rows->scratch[member], tile_posts(rows->extent), rows->quality, &tile->bytes, &tile->size);
}

static enum status put_tiles(struct imagery_rows *rows, struct level_rows *level)
{
	enum status status;
	for (uint32_t x = 0; x < level->tiles_x; x++)
		TRY(store_imagery_has(rows->store, (struct tile){level->level, x, level->tile_y}, &rows->tiles[x].has));
	rows->packing = level;
	TRY_OR(done, crew_run(rows->crew, level->tiles_x, pack_tile, rows));
	for (uint32_t x = 0; x < level->tiles_x; x++) {
		const struct packed_tile *tile = &rows->tiles[x];
		rows->kept += tile->has;
		if (tile->has || tile->empty)
			continue;
		TRY_OR(done, store_imagery_put(rows->store, (struct tile){level->level, x, level->tile_y}, tile->bytes, tile->size));
	}
done:
	free_tiles(rows);
	return status;
}

/* Begins the next row of tiles with the last row of this one, which both have. */
static void begin_strip(const struct imagery_rows *rows, struct level_rows *level)
{
	const size_t row = 4 * (size_t)level->width;
	memmove(level->strip, level->strip + row * rows->extent->cells, row);
	level->tile_y++;
}

/* Packs what is whole. Behind the last row it is all rows of tiles that are left: a tile may begin beyond it, or with it. */
static enum status flush(struct imagery_rows *rows, struct level_rows *level)
{
	const int64_t cells = rows->extent->cells;
	while (level->tile_y < level->tiles_y && (level->next > ((int64_t)level->tile_y + 1) * cells || level->next == level->height)) {
		TRY(put_tiles(rows, level));
		begin_strip(rows, level);
	}
	return STATUS_OK;
}

/* --- the level above --- */

/* Adds a pixel to one above it. */
static void add_pixel(uint32_t *sums, const uint8_t *pixel, uint32_t weight)
{
	const uint32_t opaque = weight * pixel[3];
	for (int c = 0; c < 3; c++)
		sums[c] += opaque * pixel[c];
	sums[3] += opaque;
	sums[4] += weight;
}

static void add_row(const struct level_rows *level, const uint8_t *row, uint32_t weight)
{
	const int64_t above = (level->width - 1) / 2 + 1;
	for (int64_t x = 0; x < above; x++) {
		uint32_t *sums = level->sums + SUMS * x;
		const uint8_t *pixel = row + 8 * x;
		if (x > 0)
			add_pixel(sums, pixel - 4, weight);
		add_pixel(sums, pixel, 2 * weight);
		if (2 * x + 1 < level->width)
			add_pixel(sums, pixel + 4, weight);
	}
}

static void finish_row(const struct level_rows *level)
{
	const int64_t above = (level->width - 1) / 2 + 1;
	for (int64_t x = 0; x < above; x++) {
		const uint32_t *sums = level->sums + SUMS * x;
		uint8_t *out = level->above + 4 * x;
		const uint32_t opacity = (sums[3] + sums[4] / 2) / sums[4];
		for (int c = 0; c < 3; c++)
			out[c] = sums[3] == 0 ? 0 : (uint8_t)((sums[c] + sums[3] / 2) / sums[3]);
		out[3] = (uint8_t)(opacity == 0 && sums[3] > 0 ? 1 : opacity);
	}
	memset(level->sums, 0, (size_t)above * SUMS * sizeof *level->sums);
}

static enum status put_row(struct imagery_rows *rows, size_t index, const uint8_t *pixels)
{
	struct level_rows *level = &rows->levels[index];
	const int64_t row = level->next++;
	memcpy(level->strip + 4 * (row - (int64_t)level->tile_y * rows->extent->cells) * level->width, pixels, 4 * (size_t)level->width);
	if (index + 1 < rows->count) {
		/* Row 2j counts twice for row j above; row 2j + 1 counts for j, and then for j + 1. */
		add_row(level, pixels, row % 2 == 0 ? 2 : 1);
		if (row % 2 == 1 || row == level->height - 1) {
			finish_row(level);
			TRY(put_row(rows, index + 1, level->above));
		}
		if (row % 2 == 1)
			add_row(level, pixels, 1);
	}
	return flush(rows, level);
}

enum status intake_imagery_rows_put(struct imagery_rows *rows, const uint8_t *pixels)
{
	return put_row(rows, 0, pixels);
}

int64_t intake_imagery_rows_kept(const struct imagery_rows *rows)
{
	return rows->kept;
}
