/*
 * Which pages of imagery a draw needs, and the table in which the shader finds them (shaders/lib/imagery.glsl).
 *
 * A pixel at a distance d from the eye is at least d / focal metres wide. It shows the level whose pixels are at most as wide as that,
 * blended with the next coarser one. So a page of a level is needed only where the ground is nearer than twice the spacing of its pixels times focal.
 *
 * Invariants:
 *   1. The pages of a draw come with all pages above them.
 *   2. In a table, the rectangle of each level has the parents of all pages in the rectangle of the next finer level.
 */
#include "render/imagery.h"

#include <math.h>
#include <string.h>

#define REACH 1.05 /* more than 1: skirts, rounding, and GL's log2 */

/* --- the pages of a draw --- */

static enum status add_page(struct imagery_pages *pages, struct tile tile)
{
	TRY(mem_grow(&pages->keys, &pages->room, pages->count + 1, sizeof *pages->keys, "imagery"));
	pages->keys[pages->count++] = tile_key(tile);
	return STATUS_OK;
}

/* Gives the box of the part that the tile covers. Returns false if there is none. */
static bool box_of(const struct extent *extent, const struct imagery_area *area, struct tile tile, double low[3], double high[3])
{
	const double side = extent_spacing(extent, tile.level) * extent->cells;
	const uint32_t at[2] = {tile.x, tile.y};
	for (int i = 0; i < 2; i++) {
		low[i] = fmax(at[i] * side, area->low[i]);
		high[i] = fmin((at[i] + 1.0) * side, area->high[i]);
		if (low[i] >= high[i])
			return false;
	}
	low[2] = area->low[2];
	high[2] = area->high[2];
	return true;
}

/* Returns whether a pixel of this part can show the tile. */
static bool is_needed(const struct render_imagery *imagery, const struct imagery_area *area, struct tile tile)
{
	double low[3], high[3];
	if (!extent_has(&imagery->extent, tile) || !box_of(&imagery->extent, area, tile, low, high))
		return false;
	if (tile.level == imagery->coarsest)
		return true;
	const double reach = 2 * REACH * area->focal * extent_spacing(&imagery->extent, tile.level);
	return render_box_distance(area->view->eye, low, high) < reach && render_box_visible(area->view->planes, low, high);
}

static enum status add_needed(const struct render_imagery *imagery, const struct imagery_area *area, struct tile tile, struct imagery_pages *pages)
{
	TRY(add_page(pages, tile));
	for (unsigned i = 0; i < 4 && tile.level > imagery->finest; i++) {
		const struct tile child = {tile.level - 1, 2 * tile.x + (i & 1), 2 * tile.y + (i >> 1)};
		if (is_needed(imagery, area, child))
			TRY(add_needed(imagery, area, child, pages));
	}
	return STATUS_OK;
}

enum status render_imagery_need(const struct render_imagery *imagery, const struct imagery_area *area, struct imagery_pages *pages)
{
	const struct tile top = {imagery->coarsest, 0, 0};
	return is_needed(imagery, area, top) ? add_needed(imagery, area, top, pages) : STATUS_OK;
}

bool render_imagery_coarsen(struct imagery_pages *pages)
{
	int finest = TILE_LEVEL_MAX, coarsest = TILE_LEVEL_MIN;
	size_t kept = 0;
	for (size_t i = 0; i < pages->count; i++) {
		const int level = tile_from_key(pages->keys[i]).level;
		finest = level < finest ? level : finest;
		coarsest = level > coarsest ? level : coarsest;
	}
	if (finest >= coarsest)
		return false;
	for (size_t i = 0; i < pages->count; i++)
		if (tile_from_key(pages->keys[i]).level > finest)
			pages->keys[kept++] = pages->keys[i];
	pages->count = kept;
	return true;
}

/* --- its table --- */

/* The pages of a level: a rectangle of places, counted from the south-west page that the drawn tile has of that level. */
struct level_box {
	int64_t x0, y0, x1, y1; /* x1 and y1 are the last; x1 < x0: there are none */
	size_t first;           /* vector of the first place */
};

#define LEVELS (TILE_LEVEL_MAX - TILE_LEVEL_MIN + 1)

/* Gives the rectangle of each level, and returns the finest level. */
static int find_boxes(const struct render_imagery *imagery, const struct imagery_draw *draw, struct level_box boxes[LEVELS])
{
	int finest = imagery->coarsest;
	for (int i = 0; i < LEVELS; i++)
		boxes[i] = (struct level_box){INT64_MAX, INT64_MAX, -1, -1, 0};
	for (size_t i = 0; i < draw->pages.count; i++) {
		const struct tile page = tile_from_key(draw->pages.keys[i]);
		struct level_box *box = &boxes[page.level - TILE_LEVEL_MIN];
		finest = page.level < finest ? page.level : finest;
		box->x0 = page.x < box->x0 ? page.x : box->x0;
		box->y0 = page.y < box->y0 ? page.y : box->y0;
		box->x1 = page.x > box->x1 ? page.x : box->x1;
		box->y1 = page.y > box->y1 ? page.y : box->y1;
	}
	return finest;
}

static size_t box_count(const struct level_box *box)
{
	return box->x1 < box->x0 ? 0 : (size_t)((box->x1 - box->x0 + 1) * (box->y1 - box->y0 + 1));
}

size_t render_imagery_table_size(const struct render_imagery *imagery, const struct imagery_draw *draw)
{
	struct level_box boxes[LEVELS];
	size_t size = 0;
	for (int level = find_boxes(imagery, draw, boxes); level <= imagery->coarsest; level++)
		size += box_count(&boxes[level - TILE_LEVEL_MIN]);
	return size;
}

static void fill(float to[4], double x, double y, double z, double w)
{
	to[0] = (float)x;
	to[1] = (float)y;
	to[2] = (float)z;
	to[3] = (float)w;
}

static void put(struct render_imagery *imagery, size_t vector, double x, double y, double z, double w)
{
	fill(imagery->vectors + 4 * vector, x, y, z, w);
}

/* Writes where the page of a place lies. Without a page of its own it is a part of that above; without any the layer is -1. */
static void put_place(struct render_imagery *imagery, struct tile page, const struct level_box *above, size_t vector)
{
	uint32_t number;
	const uint32_t posts = imagery->extent.cells + 1, in_layer = imagery->across * imagery->across;
	const bool named = key_set_find(&imagery->keys, tile_key(page), &number);
	const uint32_t slot = named ? imagery->places[number] : IMAGERY_NO_SLOT;
	if (slot != IMAGERY_NO_SLOT) {
		put(imagery, vector, 1, slot % in_layer % imagery->across * posts + 0.5, slot % in_layer / imagery->across * posts + 0.5, slot / in_layer);
		return;
	}
	if (above == NULL) {
		put(imagery, vector, 0, 0, 0, -1);
		return;
	}
	const size_t row = (size_t)(above->x1 - above->x0 + 1);
	const float *from = imagery->vectors + 4 * (above->first + (size_t)((page.y >> 1) - above->y0) * row + (size_t)((page.x >> 1) - above->x0));
	const double half = imagery->extent.cells / 2.0 * from[0];
	put(imagery, vector, from[0] / 2, from[1] + (page.x & 1) * half, from[2] + (page.y & 1) * half, from[3]);
}

/* Fills how places of the drawn tile become places in pixels of the level, and its rectangle. */
static void fill_level(const struct render_imagery *imagery, struct tile drawn, int level, const struct level_box *box, float to[2][4])
{
	const int finer = drawn.level - level; /* below 0: the tile is a part of one page */
	const double scale = ldexp(1, finer), cells = imagery->extent.cells;
	const int64_t mask = finer < 0 ? ((int64_t)1 << -finer) - 1 : 0;
	const int64_t x = finer < 0 ? drawn.x >> -finer : (int64_t)drawn.x << finer, y = finer < 0 ? drawn.y >> -finer : (int64_t)drawn.y << finer;
	fill(to[0], scale, (drawn.x & mask) * cells * scale, (drawn.y & mask) * cells * scale, (double)box->first);
	fill(to[1], (double)(box->x0 - x), (double)(box->y0 - y), (double)(box->x1 - x), (double)(box->y1 - y));
}

void render_imagery_tabulate(struct render_imagery *imagery, struct imagery_draw *draw)
{
	struct level_box boxes[LEVELS];
	const int finest = find_boxes(imagery, draw, boxes), coarsest = imagery->coarsest;
	for (int level = coarsest; level >= finest; level--) {
		struct level_box *box = &boxes[level - TILE_LEVEL_MIN];
		box->first = imagery->vector_count;
		imagery->vector_count += box_count(box);
		if (level - finest < RENDER_IMAGERY_LEVELS)
			fill_level(imagery, draw->tile, level, box, draw->levels[level - finest]);
		for (int64_t y = box->y0; y <= box->y1; y++)
			for (int64_t x = box->x0; x <= box->x1; x++)
				put_place(imagery, (struct tile){level, (uint32_t)x, (uint32_t)y}, level < coarsest ? box + 1 : NULL,
					  box->first + (size_t)((y - box->y0) * (box->x1 - box->x0 + 1) + x - box->x0));
	}
	/* So much coarser, nothing is so far away. */
	const int last = coarsest - finest < RENDER_IMAGERY_LEVELS ? coarsest - finest : RENDER_IMAGERY_LEVELS - 1;
	fill(draw->layer, 0, log2(extent_spacing(&imagery->extent, imagery->finest)), finest - imagery->finest, last);
}
