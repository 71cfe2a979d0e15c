/*
 * Tells what changed since a revision, for hosts that keep a copy of the ground.
 *
 * A revision is a number of this world. It begins at 1: 0 is left for the time before any drive. It grows by one with each step,
 * each motion committed between steps, and each rollback that changed the ground. Each changed tile has its last revision, and one
 * rectangle with all its changes after the revision `from`. A host that asks regularly gets rectangles. Another host gets whole tiles.
 */
#include "world/internal.h"

void world_changes_begin(struct world *world)
{
	world->changes.revision = world->changes.asked = 1;
}

static enum status add(struct world_changes *changes, struct tile tile, struct changed_tile **out)
{
	TRY(mem_grow(&changes->list, &changes->room, changes->count + 1, sizeof *changes->list, "what changed"));
	TRY(key_map_put(&changes->places, tile_key(tile), (double)changes->count, 0));
	*out = &changes->list[changes->count++];
	**out = (struct changed_tile){.tile = tile};
	return STATUS_OK;
}

enum status world_changed(struct world *world, struct tile tile, struct post_rect rect)
{
	struct world_changes *changes = &world->changes;
	if (!world->scene->hosted)
		return STATUS_OK;
	struct changed_tile *changed = NULL;
	const struct key_pair *place = key_map_find(&changes->places, tile_key(tile));
	if (place != NULL)
		changed = &changes->list[(size_t)place->a];
	else
		TRY(add(changes, tile, &changed));
	if (changed->last <= changes->asked) { /* the last host that asked has seen no part of it */
		changed->from = changes->asked;
		changed->rect = rect;
	} else {
		changed->rect = post_rect_around(changed->rect, rect);
	}
	changed->last = changes->revision + 1;
	changes->pending = true;
	return STATUS_OK;
}

void world_changes_end(struct world *world)
{
	world->changes.revision += world->changes.pending;
	world->changes.pending = false;
}

void world_changes_rollback(struct world *world, uint64_t revision)
{
	struct world_changes *changes = &world->changes;
	changes->revision++;
	for (size_t i = 0; i < changes->count; i++) {
		struct changed_tile *changed = &changes->list[i];
		if (changed->last <= revision)
			continue;
		changed->last = changes->revision;
		changed->from = 0;
		changed->rect = tile_post_rect(&world->resident.meta->extent, changed->tile);
	}
	changes->pending = false;
}

void world_changes_finish(struct world *world)
{
	key_map_finish(&world->changes.places);
	mem_free(world->changes.list);
}

struct telling {
	const struct world *world;
	struct post_rect *rects;
	size_t room, count;
};

static void tell(struct telling *telling, struct post_rect rect)
{
	const struct extent *extent = &telling->world->resident.meta->extent;
	const struct post_rect all = {0, 0, extent_posts(extent->width, telling->world->resident.level), extent_posts(extent->height, telling->world->resident.level)};
	rect = post_rect_intersect(rect, all);
	if (post_rect_empty(rect))
		return;
	if (telling->count < telling->room)
		telling->rects[telling->count] = rect;
	telling->count++;
}

static enum status tell_stored(void *user, uint64_t key)
{
	struct telling *telling = user;
	const struct tile tile = tile_from_key(key);
	if (tile.level == telling->world->resident.level && key_map_find(&telling->world->changes.places, key) == NULL)
		tell(telling, tile_post_rect(&telling->world->resident.meta->extent, tile));
	return STATUS_OK;
}

enum status world_changes_since(struct world *world, uint64_t since, struct post_rect *rects, size_t *count, uint64_t *now)
{
	struct world_changes *changes = &world->changes;
	struct telling telling = {world, rects, *count, 0};
	int64_t stored;
	*now = changes->revision;
	if (since > changes->revision)
		return fail_with(STATUS_USAGE, "changes: revision %llu has not been yet, the last is %llu; give one that this world told",
				 (unsigned long long)since, (unsigned long long)changes->revision);
	for (size_t i = 0; i < changes->count; i++) {
		const struct changed_tile *changed = &changes->list[i];
		if (changed->last > since)
			tell(&telling, since >= changed->from && changed->from > 0 ? changed->rect :
				       tile_post_rect(&world->resident.meta->extent, changed->tile));
	}
	if (since == 0)
		TRY(store_each_changed(resident_ground_reader(world->resident.ground), 0, tell_stored, &telling, &stored));
	const size_t room = *count;
	*count = telling.count;
	if (telling.count > room)
		return fail_with(STATUS_USAGE, "changes: %zu rectangles changed, and there is room for %zu; give more room", telling.count, room);
	changes->asked = changes->revision;
	return STATUS_OK;
}
