/*
 * What happened to the ground since somebody last read it, for who draws it: contacts, and the tiles that changed, in their order. It is kept only once
 * world_watch was called.
 */
#include <math.h>

#include "world/internal.h"

#define NO_TOUCH SIZE_MAX

void world_watch(struct world *world)
{
	world->happened.watched = true;
	world_happened_clear(world);
}

const struct world_happened *world_happened(const struct world *world)
{
	return &world->happened.told;
}

void world_happened_clear(struct world *world)
{
	world->happened.told.touch_count = world->happened.told.change_count = 0;
	world->happened.told.reach = 0;
	world->happened.touch = NO_TOUCH;
}

void world_happened_finish(struct world *world)
{
	mem_free_all(world->happened.told.touches, world->happened.told.changes);
}

enum status world_happened_touch(struct world *world, const struct event *event, const struct contact_area *area)
{
	struct world_happened *told = &world->happened.told;
	const struct body *body = world_body_at(world, event->body);
	TRY(mem_grow(&told->touches, &world->happened.touch_room, told->touch_count + 1, sizeof *told->touches, "what a picture has to know"));
	world->happened.touch = told->touch_count;
	told->touches[told->touch_count++] = (struct world_touch){
		.shape = &body->object->shape,
		.pose = event->pose,
		.depth = body->object->load > 0 ? fmax(event->sinkage, body->sinkage) : event->sinkage,
		.area = *area,
	};
	return STATUS_OK;
}

void world_happened_relaxes(struct world *world)
{
	world->happened.touch = NO_TOUCH;
}

enum status world_happened_change(struct world *world, struct tile tile)
{
	struct world_happened *told = &world->happened.told;
	if (!world->happened.watched)
		return STATUS_OK;
	TRY(mem_grow(&told->changes, &world->happened.change_room, told->change_count + 1, sizeof *told->changes, "what a picture has to know"));
	told->changes[told->change_count++] = (struct world_change){tile, world->happened.touch};
	return STATUS_OK;
}

void world_happened_reach(struct world *world, double metres)
{
	world->happened.told.reach = fmax(world->happened.told.reach, metres);
}

/* --- prefetch requests --- */

struct requests *world_prefetch(struct world *world)
{
	return &world->prefetch;
}
