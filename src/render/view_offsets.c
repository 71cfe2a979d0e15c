/*
 * How far a tile's surface may be off its base: the boxes that pictures cull by, and what errors know of ruts.
 *
 * What was there before the drive the store says exactly, for every tile over its whole subtree; it is read when first
 * asked for, which for what is pressed is before it is changed, so that it is of the drive's start whenever commits come.
 * What the drive presses is known only on the GPU: for that there is a bound.
 * 1. Under models that only lower (none, box) an object of known height leaves every post no lower than the lowest of it,
 *    or than it was; and a mean of offsets is between the lowest and the highest of them. So no offset is below the object
 *    less the highest base beneath, and the offsets around; nor above these, or 0.
 * 2. What an unknown load sinks to, and where soil goes that is moved, is taken to be no farther off what was there before
 *    than the scene's objects reach (heaps: twice that), and where all ground may slide, than the terrain is high. That is
 *    not proven: no law says how high one may push soil together.
 * A bound is not narrowed by commits: the next drive over the store has the exact ranges.
 *
 * Invariants: a tile's range is within its parent's; a tile is in `pressed` with all above it.
 */
#include <math.h>

#include "render/view.h"

/* --- chains of tiles --- */

enum status render_view_widen(const struct view *view, struct key_map *map, struct tile tile, double low, double high)
{
	int coarsest = extent_coarsest(&view->world->meta->extent);
	for (int level = tile.level; level <= coarsest; level++) {
		uint64_t key = tile_key(tile_ancestor(tile, level));
		const struct key_pair *had = key_map_find(map, key);
		if (had != NULL && had->a <= low && had->b >= high)
			return STATUS_OK; /* and so are all above it */
		low = had != NULL ? fmin(had->a, low) : low;
		high = had != NULL ? fmax(had->b, high) : high;
		enum status status = key_map_put(map, key, low, high);
		if (status != STATUS_OK)
			return status;
	}
	return STATUS_OK;
}

bool render_view_is_deformed(const struct view *view, struct tile tile)
{
	uint64_t key = tile_key(tile);
	return key_set_has(&view->deformed, key) || key_map_find(&view->pressed, key) != NULL;
}

/* --- before the drive --- */

enum status render_view_stored_offsets(struct view *view, struct tile tile, double *low, double *high)
{
	uint64_t key = tile_key(tile);
	*low = *high = 0;
	if (!key_set_has(&view->deformed, key))
		return STATUS_OK;
	const struct key_pair *known = key_map_find(&view->stored, key);
	if (known != NULL) {
		*low = known->a;
		*high = known->b;
		return STATUS_OK;
	}
	if (render_view_lacks_range(view, GROUND_OFFSETS, tile))
		return render_view_stored_offsets(view, tile_ancestor(tile, tile.level + 1), low, high);
	double lowest = 0, highest = 0;
	bool found;
	enum status status = resident_ground_offset_range(view->world->ground, tile, &lowest, &highest, &found);
	if (status != STATUS_OK)
		return status;
	if (found) {
		*low = fmin(lowest, 0);
		*high = fmax(highest, 0);
	}
	return key_map_put(&view->stored, key, *low, *high);
}

/* --- in this drive --- */

double render_view_find_reach(const struct world *world)
{
	const struct scene *scene = world->scene;
	double reach = 0, deepest = 0;
	for (size_t i = 0; i < scene->object_count; i++) {
		const struct scene_object *object = &scene->objects[i];
		const double *size = object->shape.size;
		reach = fmax(reach, object->sink + 2 * object->shape.radius +
					    sqrt(size[0] * size[0] + size[1] * size[1] + size[2] * size[2]));
		/* A path with heights of its own may dig as deep as it lies below the ground. */
		for (size_t k = 0; object->path.has_z && k < object->path.count; k++)
			deepest = fmax(deepest, world->meta->high - object->path.points[k].z);
	}
	bool all_slides = deform_conserves(scene->model) && scene->undisturbed == SCENE_SLIDES;
	double relief = all_slides && !isnan(world->meta->low) ? world->meta->high - world->meta->low : 0;
	return reach + deepest + relief;
}

/* How far above what was there soil that is moved may come; metres. */
static double heap(const struct view *view)
{
	return deform_conserves(view->world->scene->model) ? 2 * view->reach : 0;
}

/* What is around there, which soil that is moved or smoothed may become like. */
static enum status around(struct view *view, struct post_rect rect, double *low, double *high)
{
	struct tile first, last;
	enum status status = STATUS_OK;
	*low = *high = 0;
	if (!tile_range_of(&view->world->meta->extent, view->world->level, rect, &first, &last))
		return STATUS_OK;
	for (uint32_t y = first.y; y <= last.y; y++)
		for (uint32_t x = first.x; x <= last.x && status == STATUS_OK; x++) {
			const struct tile tile = {view->world->level, x, y};
			const struct key_pair *pressed = key_map_find(&view->pressed, tile_key(tile));
			double lowest, highest;
			status = render_view_stored_offsets(view, tile, &lowest, &highest);
			if (status == STATUS_OK && pressed != NULL && view->press.known) {
				lowest = fmin(lowest, pressed->a);
				highest = fmax(highest, pressed->b);
			}
			*low = fmin(*low, lowest);
			*high = fmax(*high, highest);
		}
	return status;
}

enum status render_view_offsets_press(struct view *view, const struct contact_area *sweep)
{
	const struct world *world = view->world;
	const bool raises = deform_conserves(world->scene->model);
	struct view_press *press = &view->press;
	*press = (struct view_press){.low = -view->reach, .high = heap(view)};
	if (sweep == NULL)
		return STATUS_OK;
	press->known = sweep->lowest != INT64_MIN && !raises;
	double low = 0, high = 0, depth = 0;
	enum status status = around(view, sweep->read, &low, &high);
	int32_t base = 0;
	bool any = false;
	if (status == STATUS_OK && sweep->lowest != INT64_MIN)
		status = resident_ground_highest(world->ground, world->level, sweep->changed, &base, &any);
	if (status != STATUS_OK)
		return status;
	if (any) {
		int64_t highest = (int64_t)base * (1 << (OFFSET_BITS - BASE_BITS)) +
				  (int64_t)resident_ground_reference(world->store) * (1 << OFFSET_BITS);
		depth = fmax(lattice_offset_metres(highest - sweep->lowest), 0);
	}
	if (press->known)
		*press = (struct view_press){.known = true, .low = fmin(low, -depth), .high = high};
	else
		*press = (struct view_press){.low = fmin(low - view->reach, -depth), .high = high + press->high};
	return STATUS_OK;
}

enum status render_view_offsets_touch(struct view *view, struct tile tile)
{
	double low, high;
	enum status status = STATUS_OK;
	/* The store's of all above it too, as they are before anything of this is committed. */
	for (int level = tile.level; level <= extent_coarsest(&view->world->meta->extent) && status == STATUS_OK; level++) {
		const struct tile above = tile_ancestor(tile, level);
		if (key_map_find(&view->pressed, tile_key(above)) != NULL)
			break;
		status = render_view_stored_offsets(view, above, &low, &high);
	}
	if (status == STATUS_OK)
		status = render_view_stored_offsets(view, tile, &low, &high);
	if (status != STATUS_OK)
		return status;
	const struct view_press *press = &view->press;
	low -= press->known ? 0 : view->reach;
	high += press->known ? 0 : heap(view);
	return render_view_widen(view, &view->pressed, tile, fmin(press->low, low), fmax(press->high, high));
}

enum status render_view_offsets(struct view *view, struct tile tile, bool expected, double *low, double *high)
{
	enum status status = render_view_stored_offsets(view, tile, low, high);
	const struct key_pair *pressed = key_map_find(&view->pressed, tile_key(tile));
	if (pressed != NULL) {
		*low = fmin(*low, pressed->a);
		*high = fmax(*high, pressed->b);
	}
	if (expected) {
		*low -= view->reach;
		*high += heap(view);
	}
	return status;
}
