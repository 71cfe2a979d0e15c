/*
 * A contact that changes nothing is not computed. It is found out before.
 *
 * An object is aloft if its pose is given (it has no load) and computing its windows would change no post. Two things must
 * hold:
 *
 * 1. The object lies above all ground in the windows, by more than the rounding of its lower envelope. So it lowers and holds
 * no post. The base is no higher than the posts of level 0 from which it is interpolated. Offsets have two bounds. A tile
 * without planes has no offset. Under the models none and box, no offset is higher than the highest one so far, or 0, and what was
 * poured. A contact only lowers the ground, and a mean of offsets is no higher than the highest one.
 *
 * 2. No soil slides. Under models that move soil every contact also makes relaxation iterations over its window. Undisturbed
 * ground is stable, unless the scene says that it slides. Soil passes only between two written posts of a window of which one
 * has risen or sunk. So these models need windows in which no written post was ever touched (deform_is_touched). Over other
 * windows the contact is computed, and bounds of offsets do not help. The CPU does not keep touched posts: there no tile of the windows may have planes.
 *
 * Ground touched before the drive is known by tiles: tiles that have planes when they are first looked at (`old`). A page that
 * comes back was looked at before. All posts of an old tile count as touched. Another model may have left walls in it, and a
 * contact nearby may make blocks there active. So near old tiles every contact is computed.
 *
 * The drive still notes the object's last pose and that it may have left a rest pose. The object also still holds the ground in
 * intervals, since soil may slide until it touches the object.
 */
#include <math.h>

#include "world/internal.h"

/* Fixed-point units: the error of the lower envelope and of a touch. For large or far objects, 2^-28 of the size is added. */
#define AIR_UNITS 64
#define AIR_SHARE 26

int64_t world_lowest(const struct deform_contact *contact)
{
	const struct soil_shape *shape = contact->shape;
	const struct soil_pose *from = &contact->from, *to = &contact->to;
	double reach = soil_shape_reach(shape, to->pitch, to->roll);
	if (shape->kind == SOIL_WHEEL && shape->grousers > 0) /* their corners */
		reach += hypot(shape->radius + shape->grouser_height, shape->grouser_thickness / 2) - shape->radius - shape->grouser_height;
	double way = hypot(lattice_offset_metres(to->x - from->x), lattice_offset_metres(to->y - from->y));
	double below = ldexp(reach, OFFSET_BITS) + ldexp(way + soil_shape_bound(shape), OFFSET_BITS - AIR_SHARE);
	return (from->z < to->z ? from->z : to->z) - (int64_t)ceil(below) - AIR_UNITS;
}

/* Finds the highest base in the windows, 2^-20 m. INT64_MIN: there is no ground. */
static enum status highest_base(struct world *world, const struct deform_window *windows, size_t count, int64_t *highest)
{
	*highest = INT64_MIN;
	for (size_t i = 0; i < count; i++) {
		int64_t height;
		TRY(resident_ground_highest(world->resident.ground, world->resident.level, windows[i].write, &height));
		*highest = height > *highest ? height : *highest;
	}
	return STATUS_OK;
}

/* Finds a bound of the offsets, 2^-20 m: the highest one that the store had when it was first asked. A rollback makes it ask anew.
 * No offset is higher now, but for what was poured: bodies only lower the ground. */
static enum status highest_offset(struct world *world, int64_t *highest)
{
	const struct tile top = {extent_coarsest(&world->resident.meta->extent), 0, 0};
	double low, high;
	bool found;
	enum status status = resident_ground_offset_range(world->resident.ground, top, &low, &high, &found);
	*highest = (high > 0 ? lattice_offset(high) + 1 : 0) + world->aloft.poured;
	return status;
}

static bool has_planes(const struct world *world, uint32_t slot)
{
	struct host_slot tile;
	bool has = false;
	if (world->resident.host == NULL)
		return gpu_slots_get(world->resident.slots, slot)->target != NULL;
	resident_host_get(world->resident.host, slot, &tile);
	for (int plane = 0; plane < PLANES; plane++)
		has = has || tile.planes[plane] != NULL;
	return has;
}

/* Tells whether no tile of the windows has planes. */
static enum status without_planes(struct world *world, const struct deform_window *windows, size_t count, bool *none)
{
	struct held_tiles held = {.count = 0};
	enum status status = STATUS_OK;
	*none = true;
	for (size_t i = 0; i < count && *none && status == STATUS_OK; i++) {
		status = world_hold(world, windows[i].read, &held);
		for (size_t k = 0; k < held.count; k++)
			*none = *none && !has_planes(world, held.tiles[k].slot);
		world_release(world, &held);
	}
	return status;
}

/* An object with a load, or with a height given as the ground's less its sink, is never above the ground. */
bool world_asks_touched(const struct world *world)
{
	const struct scene *scene = world->scene;
	bool rises = scene_moves_bodies(world->scene);
	for (size_t i = 0; i < scene->object_count; i++) {
		const struct scene_object *object = &scene->objects[i];
		rises = rises || (object->load == 0 && (object->path.has_z || object->sink < 0));
	}
	bool everywhere = world->params.everywhere || world_is_bearing(world);
	return rises && !everywhere && deform_conserves(scene->model) && scene->undisturbed == SCENE_STABLE;
}

enum status world_see(struct world *world, const struct tile_slot *held)
{
	uint64_t key = tile_key(held->tile);
	if (!world->aloft.asks_touched || !world->resident.was_deformed || key_set_has(&world->aloft.seen, key))
		return STATUS_OK;
	enum status status = key_set_add(&world->aloft.seen, key);
	if (status != STATUS_OK || gpu_slots_get(world->resident.slots, held->slot)->target == NULL)
		return status;
	status = key_set_add(&world->aloft.old, key);
	return status == STATUS_OK ? deform_touch(world->deform, tile_post_rect(&world->resident.meta->extent, held->tile)) : status;
}

static enum status look(struct world *world, struct tile tile)
{
	uint64_t key = tile_key(tile);
	struct tile_slot held = {.tile = tile};
	if (key_set_has(&world->aloft.seen, key))
		return STATUS_OK;
	enum status status = page_cache_pin_all(world->resident.cache, &key, 1, &held.slot);
	if (status != STATUS_OK)
		return status;
	status = world_see(world, &held);
	page_cache_unpin(world->resident.cache, key);
	return status;
}

/* Tells whether a tile touched before the drive has posts in a block that this window might keep active. If not, there is no
 * wall at the sides of the block either, since posts on an edge are in both tiles. */
static enum status near_old(struct world *world, const struct deform_window *window, bool *near)
{
	struct tile first, last;
	enum status status = STATUS_OK;
	*near = false;
	if (!world->resident.was_deformed || !tile_range_of(&world->resident.meta->extent, world->resident.level,
						   deform_wakes(world->deform, window->write), &first, &last))
		return STATUS_OK;
	for (uint32_t y = first.y; y <= last.y && !*near; y++)
		for (uint32_t x = first.x; x <= last.x && !*near && status == STATUS_OK; x++) {
			const struct tile tile = {world->resident.level, x, y};
			status = look(world, tile);
			*near = key_set_has(&world->aloft.old, tile_key(tile));
		}
	return status;
}

static enum status untouched_soil(struct world *world, const struct deform_window *windows, size_t count, bool *none)
{
	bool is = false;
	for (size_t i = 0; i < count && !is; i++) {
		TRY(near_old(world, &windows[i], &is));
		if (!is)
			TRY(deform_is_touched(world->deform, windows[i].write, &is));
	}
	*none = !is;
	return STATUS_OK;
}

enum status world_is_aloft(struct world *world, const struct event *event, struct deform_contact *contact,
			   const struct deform_window *windows, size_t count, bool *aloft)
{
	bool conserves = deform_conserves(world->scene->model);
	*aloft = false;
	/* Most objects are on the ground: they need no further test. */
	if (count == 0 || contact->load > 0 || event->sinkage >= 0 || world->params.everywhere)
		return STATUS_OK;
	if (conserves && (world->bearing != NULL ? world->scene->undisturbed != SCENE_STABLE : !world->aloft.asks_touched))
		return STATUS_OK;
	int64_t low = world_lowest(contact), highest;
	enum status status = highest_base(world, windows, count, &highest);
	if (status != STATUS_OK || low <= highest)
		return status;
	contact->above = true;
	/* What an object leaves comes back, so offsets have no bound. Where no tile has planes there is nothing to let go of. */
	if (deform_is_elastic(world->scene->model))
		return without_planes(world, windows, count, aloft);
	if (conserves)
		return world->bearing != NULL ? without_planes(world, windows, count, aloft) : untouched_soil(world, windows, count, aloft);
	int64_t offset;
	status = highest_offset(world, &offset);
	if (status != STATUS_OK)
		return status;
	if (low > highest + offset) {
		*aloft = true;
		return STATUS_OK;
	}
	return without_planes(world, windows, count, aloft);
}
