/*
 * Draws in groups. All pages that a group shows are there at once, and its tables are written once. With enough slots a frame is one
 * group.
 *
 *     empty -> collecting -> (brought, tabulated, run, released) -> empty
 *
 * Invariant: the pages of a group are at most as many as there are slots, and its tables fit into a texture.
 */
#include "render/imagery.h"

#include <math.h>

void render_imagery_begin_frame(struct render_imagery *imagery)
{
	assert(imagery->draw_count == 0 && imagery->group.count == 0);
	imagery->lacking.count = 0;
	imagery->parted = false;
}

enum status render_imagery_flush(struct render_imagery *imagery, imagery_run_fn run, void *user)
{
	enum status status = STATUS_OK;
	imagery->vector_count = 0;
	if (imagery->draw_count == 0)
		return STATUS_OK;
	TRY_OR(done, render_imagery_bring(imagery));
	for (size_t i = 0; i < imagery->draw_count; i++)
		render_imagery_tabulate(imagery, &imagery->draws[i]);
	imagery->table = (imagery->table + 1) % IMAGERY_TABLES;
	gpu_texture_upload(imagery->tables[imagery->table], 0,
			   (struct gpu_rect){0, 0, IMAGERY_TABLE_SIDE, (uint32_t)((imagery->vector_count + IMAGERY_TABLE_SIDE - 1) / IMAGERY_TABLE_SIDE)}, imagery->vectors);
	for (size_t i = 0; i < imagery->draw_count; i++)
		TRY_OR(done, run(user, &imagery->draws[i]));
done:
	render_imagery_release(imagery);
	imagery->draw_count = 0;
	imagery->vector_count = 0;
	return status;
}

/* --- the part of the ground that some blocks cover --- */

static void widen(struct imagery_area *area, const struct extent *extent, struct tile tile, uint32_t block)
{
	const double spacing = extent_spacing(extent, tile.level), side = spacing * extent->cells;
	const double across = (double)render_block_cells(extent) * spacing * (1u << (block >> 20 & 15));
	const uint32_t at[2] = {block & 1023u, block >> 10 & 1023u}, place[2] = {tile.x, tile.y};
	for (int i = 0; i < 2; i++) {
		const double low = place[i] * side;
		/* Vertices may move to the south-west, by less than a block. */
		area->low[i] = fmin(area->low[i], fmax(low + (at[i] - 1.0) * across, low));
		area->high[i] = fmax(area->high[i], low + (at[i] + 1.0) * across);
	}
}

static void find_area(const struct render_imagery *imagery, const struct render_view *view, double focal, const struct render_draw *draw,
		      const uint32_t *blocks, uint32_t first, uint32_t count, struct imagery_area *area)
{
	*area = (struct imagery_area){view, focal, {INFINITY, INFINITY, draw->low}, {-INFINITY, -INFINITY, draw->high}};
	for (uint32_t i = first; i < first + count; i++)
		widen(area, &imagery->extent, draw->tile, blocks[i]);
}

/* --- a group --- */

/* Returns how many pages the group has with those of the draw. */
static size_t count_with(const struct render_imagery *imagery, const struct imagery_draw *draw)
{
	size_t count = imagery->group.count;
	for (size_t i = 0; i < draw->pages.count; i++)
		count += !key_set_has(&imagery->keys, draw->pages.keys[i]);
	return count;
}

/* Returns whether the draw needs more than a group can have. */
static bool is_over(const struct render_imagery *imagery, const struct imagery_draw *draw)
{
	return draw->pages.count > imagery->slots || render_imagery_table_size(imagery, draw) > IMAGERY_VECTORS;
}

static enum status join(struct render_imagery *imagery, struct imagery_draw *draw, size_t vectors)
{
	struct imagery_pages *group = &imagery->group;
	for (size_t i = 0; i < draw->pages.count; i++) {
		uint32_t number;
		bool fresh;
		TRY(key_set_number(&imagery->keys, draw->pages.keys[i], &number, &fresh));
		if (!fresh)
			continue;
		TRY(mem_grow(&group->keys, &group->room, group->count + 1, sizeof *group->keys, "imagery"));
		group->keys[group->count++] = draw->pages.keys[i];
	}
	imagery->vector_count += vectors;
	imagery->draw_count++;
	return STATUS_OK;
}

/* Returns the next draw of the group, with no pages, which the group does not have yet. */
static enum status next_draw(struct render_imagery *imagery, struct imagery_draw **out)
{
	const size_t before = imagery->draw_room;
	TRY(mem_grow(&imagery->draws, &imagery->draw_room, imagery->draw_count + 1, sizeof *imagery->draws, "imagery"));
	for (size_t i = before; i < imagery->draw_room; i++)
		imagery->draws[i] = (struct imagery_draw){.first = 0};
	*out = &imagery->draws[imagery->draw_count];
	(*out)->pages.count = 0;
	return STATUS_OK;
}

static void tell(struct render_imagery *imagery, size_t pages, bool coarser)
{
	const double page = 4e-6 * (imagery->extent.cells + 1) * (imagery->extent.cells + 1);
	imagery->parted_frames += !imagery->parted;
	imagery->parted = true;
	if (imagery->told[coarser])
		return;
	imagery->told[coarser] = true;
	if (coarser)
		note("view.imagery_budget: a part of the picture needs %zu tiles of imagery and the budget has %u: drawn coarser; give at least %s MB, and more if another part needs more", pages,
		     imagery->slots, number_at_least((double)pages * page * 1.001, 4).text);
	else
		note("view.imagery_budget: the picture needs more than the %u tiles of imagery that it has: it reads them again in each picture, which takes long; give more", imagery->slots);
}

enum status render_imagery_draw(struct render_imagery *imagery, const struct render_view *view, double focal, const struct render_draw *draw, size_t index,
				const uint32_t *blocks, uint32_t first, uint32_t count, imagery_run_fn run, void *user)
{
	struct imagery_draw *next;
	struct imagery_area area;
	TRY(next_draw(imagery, &next));
	next->draw = index;
	next->first = first;
	next->count = count;
	next->tile = draw->tile;
	find_area(imagery, view, focal, draw, blocks, first, count, &area);
	TRY(render_imagery_need(imagery, &area, &next->pages));
	if (is_over(imagery, next) && count > 1) {
		TRY(render_imagery_draw(imagery, view, focal, draw, index, blocks, first, count / 2, run, user));
		return render_imagery_draw(imagery, view, focal, draw, index, blocks, first + count / 2, count - count / 2, run, user);
	}
	const size_t needed = next->pages.count;
	while (is_over(imagery, next) && render_imagery_coarsen(&next->pages))
		tell(imagery, needed, true);
	const size_t vectors = render_imagery_table_size(imagery, next);
	if (count_with(imagery, next) <= imagery->slots && imagery->vector_count + vectors <= IMAGERY_VECTORS)
		return join(imagery, next, vectors);
	if (count_with(imagery, next) > imagery->slots)
		tell(imagery, needed, false);
	/* The group ends, and this draw begins the next one. */
	const struct imagery_draw kept = *next;
	next->pages = (struct imagery_pages){.count = 0};
	enum status status = render_imagery_flush(imagery, run, user);
	mem_free(imagery->draws[0].pages.keys);
	imagery->draws[0] = kept;
	return status == STATUS_OK ? join(imagery, &imagery->draws[0], vectors) : status;
}
