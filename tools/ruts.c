/* Where a store has ruts; see ruts.h. */
#include "ruts.h"

#include <math.h>

struct area {
	double side; /* m of a tile */
	double window[4];
	bool any;
};

static enum status add_tile(void *user, uint64_t key)
{
	struct area *area = user;
	const struct tile tile = tile_from_key(key);
	const double place[2] = {area->side * (double)tile.x, area->side * (double)tile.y};
	for (int i = 0; i < 2; i++) {
		area->window[i] = area->any ? fmin(area->window[i], place[i]) : place[i];
		area->window[2 + i] = area->any ? fmax(area->window[2 + i], place[i] + area->side) : place[i] + area->side;
	}
	area->any = true;
	return STATUS_OK;
}

enum status ruts_window(struct store *store, double window[4], bool *any)
{
	const struct extent *extent = &store_meta(store)->extent;
	struct store_reader *reader = NULL;
	int level;
	*any = false;
	if (!store_has_working_level(store, &level))
		return STATUS_OK;
	struct area area = {.side = extent_spacing(extent, level) * extent->cells};
	enum status status;
	TRY_OR(done, store_reader_create(store, &reader));
	TRY_OR(done, store_each_offset(reader, level, add_tile, &area));
done:
	store_reader_destroy(reader);
	const double ends[2] = {extent_side(extent, 0), extent_side(extent, 1)};
	for (int i = 0; i < 4; i++)
		window[i] = i < 2 ? area.window[i] : fmin(area.window[i], ends[i - 2]);
	*any = area.any;
	return status;
}
