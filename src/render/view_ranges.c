/*
 * Ranges that are not on the CPU yet. A picture that is written reads them, so that it is always the same. All other selections
 * wait for nothing: those of pictures in a window, and of times ahead. They use the range of a tile above, which contains the
 * tile's own. The look-ahead's thread is asked to read the tile's own.
 */
#include "render/view.h"

bool render_view_has_range(struct view *view, enum ground_range_kind kind, struct tile tile)
{
	return resident_ground_has_range(world_resident(view->world)->ground, &(struct ground_range_key){kind, tile});
}

static void add(struct view *view, enum ground_range_kind kind, struct tile tile)
{
	if (view->missing_count < VIEW_MISSING)
		view->missing[view->missing_count++] = (struct ground_range_key){kind, tile};
}

bool render_view_lacks_range(struct view *view, enum ground_range_kind kind, struct tile tile)
{
	bool coarsest = tile.level == extent_coarsest(&world_resident(view->world)->meta->extent); /* nothing is above it */
	if (view->exact || coarsest || render_view_has_range(view, kind, tile))
		return false;
	view->guessed = true;
	add(view, kind, tile);
	return true;
}

void render_view_ask_ranges(struct view *view)
{
	if (view->missing_count > 0)
		resident_look_ahead_ranges(world_look_ahead(view->world), view->missing, view->missing_count);
	view->missing_count = 0;
}

void render_view_expect_contacts(struct view *view)
{
	const struct world *world = view->world;
	if (view->deformed.count == 0 || !resident_look_ahead_brings_ranges(world_look_ahead(world)))
		return;
	const struct requests *requests = resident_look_ahead_requests(world_look_ahead(world));
	for (size_t i = 0; i < requests->count; i++) {
		struct tile tile = tile_from_key(requests->requests[i].key);
		for (int level = world_resident(world)->level; tile.level == world_resident(world)->level && level <= extent_coarsest(&world_resident(world)->meta->extent); level++) {
			const struct tile above = tile_ancestor(tile, level);
			if (!key_set_has(&view->deformed, tile_key(above)))
				continue;
			if (render_view_has_range(view, GROUND_OFFSETS, above))
				break; /* mostly the tiles above have theirs, too */
			add(view, GROUND_OFFSETS, above);
		}
	}
}
