#include "resident/inset_areas.h"

#include <math.h>

static enum status add_area(struct inset_areas *insets, size_t *room, struct inset_area area)
{
	TRY(mem_grow(&insets->areas, room, insets->count + 1, sizeof *insets->areas, "the insets"));
	insets->areas[insets->count++] = area;
	return STATUS_OK;
}

enum status resident_inset_areas_init(const struct store *store, struct inset_areas *insets)
{
	const struct store_meta *meta = store_meta(store);
	const struct extent *extent = &meta->extent;
	const char *text = meta->insets != NULL ? meta->insets : "";
	struct store_inset inset;
	size_t room = 0;
	enum status status;
	*insets = (struct inset_areas){.cells = extent->cells};
	while (store_inset_next(&text, extent, &inset)) {
		const double x = ldexp((double)inset.x, inset.level), y = ldexp((double)inset.y, inset.level);
		const double width = ldexp((double)(inset.width - 1), inset.level), height = ldexp((double)(inset.height - 1), inset.level);
		TRY_OR(failed, add_area(insets, &room, (struct inset_area){x, y, x + width, y + height, inset.level}));
	}
	if (insets->count == 0 && store_finest_base(store) < 0)
		TRY_OR(failed, add_area(insets, &room, (struct inset_area){0, 0, (double)(extent->width - 1), (double)(extent->height - 1),
									   store_finest_base(store)}));
	return STATUS_OK;
failed:
	resident_inset_areas_finish(insets);
	return status;
}

void resident_inset_areas_finish(struct inset_areas *insets)
{
	mem_free(insets->areas);
	*insets = (struct inset_areas){.cells = 0};
}

/* A tile is stored if it has one post of the inset; a post on an edge is in the tiles on both
 * sides. */
static bool tiles_reach(double low, double high, double side, double at, double reach)
{
	return at + reach >= (ceil(low / side) - 1) * side &&
	       at - reach <= (floor(high / side) + 1) * side;
}

int resident_inset_areas_level(const struct inset_areas *insets, double x, double y, double reach)
{
	int finest = 0;
	for (size_t i = 0; i < insets->count; i++) {
		const struct inset_area *area = &insets->areas[i];
		for (int level = area->level; level < finest; level++) {
			double side = ldexp(insets->cells, level);
			if (tiles_reach(area->x0, area->x1, side, x, reach) &&
			    tiles_reach(area->y0, area->y1, side, y, reach))
				finest = level;
		}
	}
	return finest;
}
