/*
 * An object in the air runs no pass: what of a station's sweep changes nothing is seen on the CPU.
 *
 * Aloft is a sweep whose pose is prescribed, and of whose windows every post, were they computed, would be what it was:
 * 1. The object lies above all ground there, by more than the underside is rounded by: nothing is pressed, and nothing held.
 *    The base is no higher than the posts of level 0 it is interpolated from. Of offsets there are two bounds: a tile
 *    without planes has none; and under the models none and box no offset is ever above the highest there was, or 0: a press
 *    lowers, and a mean of offsets is no higher than the highest of them.
 * 2. Nothing slides: under models that move soil every sweep also makes iterations of sliding over its window, whether it
 *    touches anything or not. Undisturbed ground stands, unless the scene says that it slides, and soil passes only between two
 *    written posts of a window, of which one has risen or sunk. So these models need windows in whose written posts nothing was
 *    ever touched (deform_is_touched); over others the sweep is computed, and no bound on their offsets is of use.
 *
 * What was touched before the drive is known by tiles: those that come with planes when they are first looked at (`old`; a
 * page that comes back was seen before). All of their posts are taken as touched. And where another model left walls in them,
 * a sweep that is computed nearby may wake these: near such tiles all are.
 *
 * It stays what the drive knows the object by (its last pose, that it may have left something), and it is still among those
 * that hold the ground in intervals: soil may slide until it touches what hangs over it.
 */
#include <math.h>

#include "world/internal.h"

/* Underside and touch are right to a few quanta; what is large or goes far, to a 2^-28th of that. */
#define AIR_QUANTA 64
#define AIR_SHARE 26

int64_t world_lowest(const struct deform_sweep *sweep)
{
	const struct deform_shape *shape = sweep->shape;
	const struct deform_pose *from = &sweep->from, *to = &sweep->to;
	double reach = deform_shape_reach(shape, to->pitch, to->roll);
	if (shape->kind == DEFORM_WHEEL && shape->lugs > 0) /* their corners */
		reach = hypot(shape->radius + shape->lug_height, shape->lug_thickness / 2);
	double way = hypot(lattice_offset_metres(to->x - from->x), lattice_offset_metres(to->y - from->y));
	double below = ldexp(reach, OFFSET_BITS) + ldexp(way + deform_shape_bound(shape), OFFSET_BITS - AIR_SHARE);
	return (from->z < to->z ? from->z : to->z) - (int64_t)ceil(below) - AIR_QUANTA;
}

/* Of all bases in the windows, quanta. INT64_MIN: there is no ground. */
static enum status highest_base(struct world *world, const struct deform_window *windows, size_t count, int64_t *highest)
{
	enum status status = STATUS_OK;
	*highest = INT64_MIN;
	for (size_t i = 0; i < count && status == STATUS_OK; i++) {
		int32_t base;
		bool any;
		status = resident_ground_highest(world->ground, world->level, windows[i].write, &base, &any);
		if (status != STATUS_OK || !any)
			continue;
		int64_t height = (int64_t)base * (1 << (OFFSET_BITS - BASE_BITS)) +
				 (int64_t)resident_ground_reference(world->store) * (1 << OFFSET_BITS);
		*highest = height > *highest ? height : *highest;
	}
	return status;
}

/* What is committed is as high as what is there now, or higher: it was there before. Asked for once, and not before an object
 * is above the base. */
static enum status ask_offsets(struct world *world)
{
	const struct tile top = {extent_coarsest(&world->meta->extent), 0, 0};
	double low, high;
	bool found;
	enum status status = resident_ground_offset_range(world->ground, top, &low, &high, &found);
	if (status != STATUS_OK)
		return status;
	world->aloft.offsets_most = found && high > 0 ? lattice_offset(high) + 1 : 0;
	world->aloft.offsets_asked = true;
	return STATUS_OK;
}

/* Whether no tile of the windows has planes. */
static enum status without_planes(struct world *world, const struct deform_window *windows, size_t count, bool *none)
{
	struct held_tiles held = {.count = 0};
	enum status status = STATUS_OK;
	*none = true;
	for (size_t i = 0; i < count && *none && status == STATUS_OK; i++) {
		status = world_hold(world, windows[i].read, &held);
		for (size_t k = 0; k < held.count; k++)
			*none = *none && gpu_slots_get(world->slots, held.tiles[k].slot)->target == NULL;
		world_release(world, &held);
	}
	return status;
}

/* One that has a load, or whose height is the ground's less its sink, is never above it. */
bool world_asks_touched(const struct world *world)
{
	const struct scene *scene = world->scene;
	bool rises = world->scene->hosted;
	for (size_t i = 0; i < scene->object_count; i++) {
		const struct scene_object *object = &scene->objects[i];
		rises = rises || (object->load == 0 && (object->path.has_z || object->sink < 0));
	}
	bool everywhere = world->params.everywhere;
	return rises && !everywhere && deform_conserves(scene->model) && scene->undisturbed == SCENE_STANDS;
}

enum status world_see(struct world *world, const struct deform_tile *held)
{
	uint64_t key = tile_key(held->tile);
	if (!world->aloft.asks_touched || !world->was_deformed || key_set_has(&world->aloft.seen, key))
		return STATUS_OK;
	enum status status = key_set_add(&world->aloft.seen, key);
	if (status != STATUS_OK || gpu_slots_get(world->slots, held->slot)->target == NULL)
		return status;
	status = key_set_add(&world->aloft.old, key);
	return status == STATUS_OK ? deform_touch(world->deform, tile_post_rect(&world->meta->extent, held->tile)) : status;
}

static enum status look(struct world *world, struct tile tile)
{
	uint64_t key = tile_key(tile);
	struct deform_tile held = {.tile = tile};
	if (key_set_has(&world->aloft.seen, key))
		return STATUS_OK;
	enum status status = page_cache_pin_all(world->cache, &key, 1, &held.slot);
	if (status != STATUS_OK)
		return status;
	status = world_see(world, &held);
	page_cache_unpin(world->cache, key);
	return status;
}

/* Whether a tile that was touched before the drive has posts in a block that the window, were it computed, might keep awake.
 * Where it has none no wall stands at the block's sides either: posts on an edge are in both tiles. */
static enum status near_old(struct world *world, const struct deform_window *window, bool *near)
{
	struct tile first, last;
	enum status status = STATUS_OK;
	*near = false;
	if (!world->was_deformed || !tile_range_of(&world->meta->extent, world->level,
						   deform_wakes(world->deform, window->write), &first, &last))
		return STATUS_OK;
	for (uint32_t y = first.y; y <= last.y && !*near; y++)
		for (uint32_t x = first.x; x <= last.x && !*near && status == STATUS_OK; x++) {
			const struct tile tile = {world->level, x, y};
			status = look(world, tile);
			*near = key_set_has(&world->aloft.old, tile_key(tile));
		}
	return status;
}

static enum status untouched_soil(struct world *world, const struct deform_window *windows, size_t count, bool *none)
{
	enum status status = STATUS_OK;
	bool is = false;
	for (size_t i = 0; i < count && !is && status == STATUS_OK; i++) {
		status = near_old(world, &windows[i], &is);
		if (status == STATUS_OK && !is)
			status = deform_is_touched(world->deform, windows[i].write, &is);
	}
	*none = status == STATUS_OK && !is;
	return status;
}

enum status world_is_aloft(struct world *world, const struct event *event, struct deform_sweep *sweep,
			   const struct deform_window *windows, size_t count, bool *aloft)
{
	bool conserves = deform_conserves(world->scene->model);
	*aloft = false;
	/* Most are on the ground where they are: those look no farther. */
	if (count == 0 || sweep->load > 0 || event->sinkage >= 0 || world->params.everywhere)
		return STATUS_OK;
	if (conserves && !world->aloft.asks_touched)
		return STATUS_OK;
	int64_t low = world_lowest(sweep), highest;
	enum status status = highest_base(world, windows, count, &highest);
	if (status != STATUS_OK || low <= highest)
		return status;
	sweep->above = true;
	if (conserves)
		return untouched_soil(world, windows, count, aloft);
	if (!world->aloft.offsets_asked)
		status = ask_offsets(world);
	if (status != STATUS_OK)
		return status;
	if (low > highest + world->aloft.offsets_most) {
		*aloft = true;
		return STATUS_OK;
	}
	return without_planes(world, windows, count, aloft);
}
