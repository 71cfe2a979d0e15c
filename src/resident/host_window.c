/*
 * Copies a rectangle of posts from the slots of several tiles, and back. Tiles share their edge posts, with the same bits (law 1). So it does not
 * show which of them is read; all of them are written.
 */
#include <string.h>

#include "resident/host_slots.h"

/* Where rows of posts begin in a window and in a tile, and how many there are. */
struct part {
	size_t window, tile;       /* number of the first post */
	size_t across, rows;       /* posts */
	size_t width, side;        /* posts from a row to the next one */
};

static struct post_rect rect_of(const struct host_slots *slots, struct tile tile)
{
	const int64_t cells = slots->cells, x = (int64_t)tile.x * cells, y = (int64_t)tile.y * cells;
	return (struct post_rect){x, y, x + cells + 1, y + cells + 1};
}

/* Finds the posts of `rect` that the tile has. Returns false if it has none. */
static bool part_of(const struct host_slots *slots, const struct soil_planes *planes, struct post_rect rect, struct tile tile, struct part *part)
{
	const struct post_rect own = rect_of(slots, tile), in = post_rect_intersect(rect, own);
	if (post_rect_empty(in))
		return false;
	*part = (struct part){
		.window = (size_t)(in.y0 - planes->rect.y0) * planes->width + (size_t)(in.x0 - planes->rect.x0),
		.tile = (size_t)(in.y0 - own.y0) * (slots->cells + 1) + (size_t)(in.x0 - own.x0),
		.across = (size_t)(in.x1 - in.x0),
		.rows = (size_t)(in.y1 - in.y0),
		.width = planes->width,
		.side = slots->cells + 1,
	};
	return true;
}

static void *plane_of(const struct soil_planes *planes, int plane)
{
	void *const all[PLANES] = {
		[PLANE_OFFSET] = planes->offset, [PLANE_DISTURBANCE] = planes->disturbance, [PLANE_DEPOSITED] = planes->deposited,
		[PLANE_PLASTIC_SINKAGE] = planes->sinkage, [PLANE_SHEAR] = planes->shear, [PLANE_DUG] = planes->dug,
		[PLANE_SETTLED] = planes->settled, [PLANE_LOOSE] = planes->loose, [PLANE_FLOOR] = planes->floor, [PLANE_DENSITY] = planes->density,
		[PLANE_SLOPE] = planes->slope,
	};
	return all[plane];
}

/* --- from slots --- */

/* from NULL: zeros. `bytes`: of a post. */
static void take_rows(const struct part *part, size_t bytes, const void *from, void *into)
{
	const char *row = from != NULL ? (const char *)from + part->tile * bytes : NULL;
	char *to = (char *)into + part->window * bytes;
	const size_t length = part->across * bytes, step = part->side * bytes;
	for (size_t y = 0; y < part->rows; y++, to += part->width * bytes)
		if (row != NULL)
			memcpy(to, row + y * step, length);
		else
			memset(to, 0, length);
}

static void take_tile(const struct host_slots *slots, const struct host_tile *tile, const struct part *part, const struct soil_planes *into)
{
	if (into->base != NULL)
		take_rows(part, sizeof *into->base, tile->base, into->base);
	if (into->classes != NULL)
		take_rows(part, 1, tile->classes, into->classes);
	if (into->levels != NULL)
		take_rows(part, PAGES_NUMBER_BYTES, tile->levels, into->levels);
	for (int plane = 0; plane < PLANES; plane++) {
		void *to = plane_of(into, plane);
		if (to != NULL)
			take_rows(part, plane_bytes((enum plane)plane), host_tile_plane(slots, tile, plane), to);
	}
}

static void clear(const struct soil_planes *into)
{
	const struct post_rect *rect = &into->rect;
	const struct part all = {.across = (size_t)(rect->x1 - rect->x0), .rows = (size_t)(rect->y1 - rect->y0), .width = into->width};
	for (size_t y = 0; into->base != NULL && y < all.rows; y++)
		for (size_t x = 0; x < all.across; x++)
			into->base[y * all.width + x] = BASE_NODATA;
	if (into->classes != NULL)
		take_rows(&all, 1, NULL, into->classes);
	if (into->levels != NULL)
		take_rows(&all, PAGES_NUMBER_BYTES, NULL, into->levels);
	for (int plane = 0; plane < PLANES; plane++)
		if (plane_of(into, plane) != NULL)
			take_rows(&all, plane_bytes((enum plane)plane), NULL, plane_of(into, plane));
}

void resident_host_gather(const struct host_slots *slots, const struct tile_slot *held, size_t count, const struct soil_planes *into)
{
	struct post_rect around = {INT64_MAX, INT64_MAX, INT64_MIN, INT64_MIN};
	struct part part;
	if (post_rect_empty(into->rect))
		return;
	for (size_t i = 0; i < count; i++)
		around = post_rect_around(around, rect_of(slots, held[i].tile));
	if (around.x0 > into->rect.x0 || around.y0 > into->rect.y0 || around.x1 < into->rect.x1 || around.y1 < into->rect.y1)
		clear(into); /* posts beyond the terrain */
	for (size_t i = 0; i < count; i++)
		if (part_of(slots, into, into->rect, held[i].tile, &part))
			take_tile(slots, &host_entry(slots, held[i].slot)->tile, &part, into);
}

/* --- into slots --- */

void resident_host_scatter(struct host_slots *slots, const struct tile_slot *held, size_t count, const struct soil_planes *from,
			   struct post_rect rect, unsigned planes)
{
	struct part part;
	rect = post_rect_intersect(rect, from->rect);
	for (size_t i = 0; i < count; i++) {
		if (!part_of(slots, from, rect, held[i].tile, &part))
			continue;
		for (int plane = 0; plane < PLANES; plane++) {
			if (!(planes & slots->planes & ~PLANE_MARKS & PLANE_BIT(plane)))
				continue;
			const size_t bytes = plane_bytes((enum plane)plane);
			char *to = (char *)resident_host_plane(slots, held[i].slot, (enum plane)plane) + part.tile * bytes;
			const char *row = (const char *)plane_of(from, plane) + part.window * bytes;
			for (size_t y = 0; y < part.rows; y++, to += part.side * bytes, row += part.width * bytes)
				memcpy(to, row, part.across * bytes);
		}
	}
}

/* --- marks that fade --- */

void resident_host_gather_mark(const struct host_slots *slots, const struct tile_slot *held, size_t count, const struct soil_planes *rows, enum plane plane,
			       int32_t *into)
{
	const struct part all = {.across = (size_t)(rows->rect.x1 - rows->rect.x0), .rows = (size_t)(rows->rect.y1 - rows->rect.y0), .width = rows->width};
	struct part part;
	if (post_rect_empty(rows->rect))
		return;
	take_rows(&all, sizeof *into, NULL, into);
	for (size_t i = 0; i < count; i++)
		if (part_of(slots, rows, rows->rect, held[i].tile, &part))
			take_rows(&part, sizeof *into, host_tile_plane(slots, &host_entry(slots, held[i].slot)->tile, plane), into);
}

void resident_host_scatter_mark(struct host_slots *slots, const struct tile_slot *held, size_t count, const struct soil_planes *rows, enum plane plane,
				const int32_t *from, struct post_rect rect)
{
	struct part part;
	rect = post_rect_intersect(rect, rows->rect);
	for (size_t i = 0; i < count; i++) {
		if (!part_of(slots, rows, rect, held[i].tile, &part))
			continue;
		int32_t *to = (int32_t *)resident_host_plane(slots, held[i].slot, plane) + part.tile;
		const int32_t *row = from + part.window;
		for (size_t y = 0; y < part.rows; y++, to += part.side, row += part.width)
			memcpy(to, row, part.across * sizeof *to);
	}
}
