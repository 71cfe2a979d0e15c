/* Worlds of parts that a test or a bench made. */
#include <math.h>

#include "world/made.h"
#include "world/internal.h"

void world_made_set(struct world *world, const struct world_made *made)
{
	world->resident = made->resident;
	world->bodies = made->bodies;
	world->body_count = made->body_count;
	world->deform = made->deform;
	world->ahead = made->ahead;
	world->time = made->time;
	world->step = made->step;
	world->facts.limits.slots = made->slots;
	world->facts.limits.loaders = made->loaders;
	world->facts.limits.prefetch = made->prefetch;
}

void world_made_get(const struct world *world, struct world_made *made)
{
	*made = (struct world_made){
		.scene = world->scene,
		.resident = world->resident,
		.bodies = world->bodies,
		.body_count = world->body_count,
		.deform = world->deform,
		.ahead = world->ahead,
		.time = world->time,
		.step = world->step,
		.slots = world->facts.limits.slots,
		.loaders = world->facts.limits.loaders,
		.prefetch = world->facts.limits.prefetch,
	};
}

struct world *world_made(const struct world_made *made)
{
	struct world *world;
	if (world_make(&(struct world_params){.scene = made->scene}, &world) != STATUS_OK)
		return NULL;
	world_made_set(world, made);
	world_settle_light(world);
	world->phase = WORLD_STEPPING;
	return world;
}

void world_made_free(struct world *world)
{
	if (world == NULL)
		return;
	world_made_set(world, &(struct world_made){.scene = world->scene});
	world_finish(world, STATUS_OK);
}

void world_made_deform_params(const struct world *world, struct deform_params *params)
{
	world_deform_params(world, params);
}

enum status world_made_set_down(struct world *world, struct body *body, int64_t sample, struct event *event)
{
	return world_set_down(world, body, sample, event);
}

enum status world_made_contact(struct world *world, const struct event *event)
{
	return world_contact(world, event);
}

enum status world_made_contacts(struct world *world, double until)
{
	TRY(world_collect_events(world, until, false));
	TRY(page_cache_poll(world->resident.cache));
	for (size_t i = 0; i < world->events.count; i++)
		TRY(world_contact(world, &world->events.list[i]));
	world->time = until;
	return STATUS_OK;
}

void world_made_set_ranks(struct world *world, const struct world_ranks *ranks)
{
	world->ranks = ranks;
}

struct record *world_made_record(struct world *world)
{
	return world->record;
}

void world_made_throw(struct world *world, const struct bearing_grain *grains, size_t count)
{
	int64_t classes[SOIL_CLASSES] = {0};
	for (size_t i = 0; i < count; i++)
		classes[0] += grains[i].volume;
	world_thrown_count(world, classes);
	world_thrown_add(world, grains, count);
}
