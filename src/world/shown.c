/* What others may see of a world. */
#include <string.h>

#include "world/internal.h"

const struct scene *world_scene(const struct world *world)
{
	return world->scene;
}

const struct world_params *world_params(const struct world *world)
{
	return &world->params;
}

const struct world_facts *world_facts(const struct world *world)
{
	return &world->facts;
}

const struct world_counts *world_counts(const struct world *world)
{
	return &world->counts;
}

const struct resident *world_resident(const struct world *world)
{
	return &world->resident;
}

double world_time(const struct world *world)
{
	return world->time;
}

int64_t world_steps_done(const struct world *world)
{
	return world->step;
}

const struct deform *world_deform(const struct world *world)
{
	return world->deform;
}

const struct bearing *world_bearing(const struct world *world)
{
	return world->bearing;
}

struct look_ahead *world_look_ahead(const struct world *world)
{
	return world->ahead;
}

FILE *world_commit_log(const struct world *world)
{
	return world->commit_log;
}

uint64_t world_revision(const struct world *world)
{
	return world->changes.revision;
}

bool world_meets(const struct world *world)
{
	return world->meetings != NULL;
}

/* --- bodies --- */

bool world_unplaced(const struct world *world)
{
	return world->unplaced;
}

void world_placed(struct world *world)
{
	world->unplaced = false;
}

/* --- who is told --- */

void world_set_commits(struct world *world, const struct world_commits *commits)
{
	world->commits = commits;
}

void world_set_figures(struct world *world, const struct world_figures *figures)
{
	world->figures = *figures;
}

const struct world_figures *world_figures(const struct world *world)
{
	return &world->figures;
}

const char *world_instance_of(const struct world *world, uint32_t number)
{
	const size_t objects = world->scene->object_count, figured = world->figures.body_count, at = (size_t)number - 1;
	if (number == 0)
		return NULL;
	if (at < objects)
		return world->scene->objects[at].name;
	if (at < objects + figured)
		return world->figures.bodies[at - objects];
	const struct body *body = at - figured < world->body_count ? world->bodies[at - figured] : NULL;
	return body != NULL && body->kind == BODY_HOST ? body->object->name : NULL;
}

uint32_t world_instance_of_figured(const struct world *world, size_t body)
{
	return (uint32_t)(world->scene->object_count + body + 1);
}

uint32_t world_instance_of_added(const struct world *world, size_t body)
{
	return (uint32_t)(body + world->figures.body_count + 1);
}

const struct world_place *world_frame_of(const struct world *world, size_t vehicle, const char *body)
{
	for (size_t i = 0; i < world->figures.frame_count; i++) {
		const struct world_frame *frame = &world->figures.frames[i];
		const bool same = body == NULL || frame->body == NULL ? body == frame->body : strcmp(body, frame->body) == 0;
		if (frame->vehicle == vehicle && same)
			return frame->place.there ? &frame->place : NULL;
	}
	return NULL;
}
