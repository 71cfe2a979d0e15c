/* furrow export --layer imagery: the colours of a window as a PNG, transparent where there are none, with its place beside it. */
#include <stdio.h>
#include <string.h>

#include "export.h"
#include "world_file.h"

#define SIDE_MOST 32768 /* pixels */

struct rows {
	struct store_reader *reader;
	int level;
	struct post_rect rect;
	uint8_t *pixels; /* of one row of tiles */
	int64_t first, next; /* the rows it has */
	int64_t cells;
	enum status status;
	struct failure failure;
};

/* Reads the rows of the tiles in which row `y` lies. */
static enum status read_rows(struct rows *rows, int64_t y)
{
	const int64_t end = (y / rows->cells + 1) * rows->cells;
	const struct post_rect part = {rows->rect.x0, y, rows->rect.x1, end < rows->rect.y1 ? end : rows->rect.y1};
	rows->first = part.y0;
	rows->next = part.y1;
	return store_imagery_read_rect(rows->reader, rows->level, part, rows->pixels);
}

/* Rows are asked for from the north, so the row of tiles that is read begins at its first row. */
static void put_row(const void *user, uint32_t y, uint8_t *row)
{
	struct rows *rows = (struct rows *)(uintptr_t)user;
	const int64_t post = rows->rect.y0 + y, width = rows->rect.x1 - rows->rect.x0, first = post / rows->cells * rows->cells;
	if (rows->status == STATUS_OK && (post < rows->first || post >= rows->next)) {
		rows->status = read_rows(rows, first > rows->rect.y0 ? first : rows->rect.y0);
		failure_capture(&rows->failure, rows->status);
	}
	if (rows->status != STATUS_OK)
		return;
	const uint8_t *from = rows->pixels + 4 * (post - rows->first) * width;
	memcpy(row, from, 4 * (size_t)width);
}

static enum status ended(const void *user)
{
	const struct rows *rows = user;
	return rows->status == STATUS_OK ? STATUS_OK : failure_restore(&rows->failure);
}

static enum status write_png(const struct export_request *request, struct rows *rows)
{
	const uint32_t width = (uint32_t)(rows->rect.x1 - rows->rect.x0), height = (uint32_t)(rows->rect.y1 - rows->rect.y0);
	const struct chart_png png = {width, height, 8, 4, put_row, rows, ended, .srgb = true, .small = true};
	TRY(mem_zeroed(&rows->pixels, (size_t)width * (size_t)rows->cells, 4, "imagery"));
	const enum status status = chart_png_rows(request->path, &png);
	mem_free(rows->pixels);
	return status;
}

enum status export_imagery(const struct export_request *request, bool leveled, struct store *store)
{
	const struct store_meta *meta = store_meta(store);
	struct export_request chosen = *request;
	struct rows rows = {.cells = meta->extent.cells};
	int finest = 0;
	if (!store_has_imagery(store, &finest, NULL))
		return fail_with(STATUS_INPUT, "%s: it has no imagery; put some into it: furrow import --imagery ORTHO... -o %s", request->store,
				 shell_path(request->store).text);
	chosen.level = leveled ? request->level : finest;
	TRY(export_find_rect(&chosen, &meta->extent, &rows.rect));
	if (rows.rect.x1 - rows.rect.x0 > SIDE_MOST || rows.rect.y1 - rows.rect.y0 > SIDE_MOST)
		return fail_with(STATUS_INPUT, "export: %lld x %lld pixels are too many for one picture; give a --window or a coarser --level",
				 (long long)(rows.rect.x1 - rows.rect.x0), (long long)(rows.rect.y1 - rows.rect.y0));
	rows.level = (int)chosen.level;
	const double spacing = extent_spacing(&meta->extent, rows.level);
	TRY(store_reader_create(store, &rows.reader));
	enum status status;
	TRY_OR(done, write_png(request, &rows));
	if (meta->srs[0] != '\0') /* a PNG has no place of its own */
		TRY_OR(done, world_file_write(request->path, meta, &(struct chart_place){.east = spacing, .south = spacing,
			.west_edge = ((double)rows.rect.x0 - 0.5) * spacing, .north_edge = ((double)rows.rect.y1 - 0.5) * spacing}));
	printf("%s: imagery, %lld x %lld pixels, %g m apart\n", request->path, (long long)(rows.rect.x1 - rows.rect.x0), (long long)(rows.rect.y1 - rows.rect.y0), spacing);
done:
	store_reader_destroy(rows.reader);
	return status;
}
