/*
 * How far a tile's surface may be off its base. Pictures cull by these bounds, and errors know of ruts by them.
 *
 * The store knows the offsets from before the drive exactly, for each tile over its whole subtree. They are read when first asked
 * for. For a tile that is about to change this is before the change. So they are those of the drive's start, whenever commits come.
 *
 * Only the GPU knows what contacts of this drive leave. For that there is a bound.
 * 1. The models none and box only lower the ground. An object of known height then leaves each post where it was, or no lower than
 *    the object's lowest point. A mean of offsets is between the lowest and the highest one. So no offset is below the object's
 *    lowest point less the highest base beneath it, nor below the offsets around. None is above those around, or 0.
 * 2. How deep a load sinks, and where moved soil goes, is not known. It is taken to be no farther off what was there before than
 *    the scene's objects reach. For deposits it is twice that. Where all ground may slide, the terrain's relief is added. This is
 *    not proven: no law says how high soil can be pushed.
 * Commits do not narrow a bound. The next drive over the store has the exact ranges.
 *
 * Invariants: a tile's range is within that of the tile above it. If a tile has bounds, so have all tiles above it.
 */
#include <math.h>

#include "render/view.h"

bool render_view_is_deformed(const struct view *view, struct tile tile)
{
	uint64_t key = tile_key(tile);
	return key_set_has(&view->deformed, key) || key_map_find(&view->bounds.added, key) != NULL;
}

/* --- before the drive --- */

enum status render_view_stored_offsets(struct view *view, struct tile tile, double *low, double *high)
{
	bool found;
	*low = *high = 0;
	if (!key_set_has(&view->deformed, tile_key(tile)))
		return STATUS_OK;
	while (render_view_lacks_range(view, GROUND_OFFSETS, tile))
		tile = tile_ancestor(tile, tile.level + 1);
	return resident_ground_offset_range(world_resident(view->world)->ground, tile, low, high, &found);
}

/* --- in this drive --- */

double render_view_find_reach(const struct world *world)
{
	const struct scene *scene = world_scene(world);
	double reach = 0, deepest = 0, raised = relief_bound(world_relief(world), 0) + rocks_bound(world_rocks(world));
	for (size_t i = 0; i < scene->object_count; i++) {
		const struct scene_object *object = &scene->objects[i];
		const double *size = object->shape.size;
		reach = fmax(reach, object->sink + 2 * object->shape.radius +
					    sqrt(size[0] * size[0] + size[1] * size[1] + size[2] * size[2]));
		/* If a path gives heights, the object may dig as deep as the path is below the ground. */
		for (size_t k = 0; object->path.has_z && k < object->path.count; k++)
			deepest = fmax(deepest,
				       world_resident(world)->meta->high + raised - object->path.points[k].z);
	}
	bool all_slides = deform_conserves(scene->model) && scene->undisturbed == SCENE_SLIDES;
	double relief = all_slides && !isnan(world_resident(world)->meta->low)
				? world_resident(world)->meta->high - world_resident(world)->meta->low + 2 * raised
				: 0;
	return reach + deepest + relief + world_poured(world);
}

/* Returns how far moved or poured soil may rise above what was there, metres. */
static double deposit(const struct view *view)
{
	return deform_raises(world_scene(view->world)->model) ? 2 * view->reach : world_poured(view->world);
}

/* Finds the range of the offsets around, metres. Soil that is moved or smoothed may become like them. */
static enum status around(struct view *view, struct post_rect rect, double *low, double *high)
{
	struct tile first, last;
	*low = *high = 0;
	if (!tile_range_of(&world_resident(view->world)->meta->extent, world_resident(view->world)->level, rect, &first, &last))
		return STATUS_OK;
	for (uint32_t y = first.y; y <= last.y; y++)
		for (uint32_t x = first.x; x <= last.x; x++) {
			const struct tile tile = {world_resident(view->world)->level, x, y};
			double lowest, highest;
			TRY(render_view_stored_offsets(view, tile, &lowest, &highest));
			if (view->contact.known)
				resident_bounds_widen(&view->bounds, tile, &lowest, &highest);
			*low = fmin(*low, lowest);
			*high = fmax(*high, highest);
		}
	return STATUS_OK;
}

enum status render_view_offsets_contact(struct view *view, const struct contact_area *area)
{
	const struct world *world = view->world;
	const bool raises = deform_raises(world_scene(world)->model);
	struct view_contact *contact = &view->contact;
	*contact = (struct view_contact){.low = -view->reach, .high = deposit(view)};
	if (area == NULL)
		return STATUS_OK;
	contact->known = area->lowest != INT64_MIN && !raises;
	double low = 0, high = 0, depth = 0;
	TRY(around(view, area->read, &low, &high));
	int64_t base = INT64_MIN;
	if (area->lowest != INT64_MIN)
		TRY(resident_ground_highest(world_resident(world)->ground, world_resident(world)->level, area->changed, &base));
	if (base != INT64_MIN)
		depth = fmax(lattice_offset_metres(base - area->lowest), 0);
	if (contact->known)
		*contact = (struct view_contact){.known = true, .low = fmin(low, -depth), .high = high};
	else
		*contact = (struct view_contact){.low = fmin(low - view->reach, -depth), .high = high + contact->high};
	return STATUS_OK;
}

enum status render_view_offsets_touch(struct view *view, struct tile tile)
{
	double low, high;
	TRY(render_view_stored_offsets(view, tile, &low, &high));
	/* Read the store's ranges of all tiles above, too, before this change is committed. */
	for (int level = tile.level; level <= extent_coarsest(&world_resident(view->world)->meta->extent); level++) {
		const struct tile above = tile_ancestor(tile, level);
		double above_low, above_high;
		if (key_map_find(&view->bounds.added, tile_key(above)) != NULL)
			break;
		if (level > tile.level)
			TRY(render_view_stored_offsets(view, above, &above_low, &above_high));
	}
	const struct view_contact *contact = &view->contact;
	low -= contact->known ? 0 : view->reach;
	high += contact->known ? 0 : deposit(view);
	return resident_bounds_add(&view->bounds, tile, fmin(contact->low, low), fmax(contact->high, high));
}

enum status render_view_offsets(struct view *view, struct tile tile, bool expected, double *low, double *high)
{
	enum status status = render_view_stored_offsets(view, tile, low, high);
	resident_bounds_widen(&view->bounds, tile, low, high);
	if (expected) {
		*low -= view->reach;
		*high += deposit(view);
	}
	return status;
}
