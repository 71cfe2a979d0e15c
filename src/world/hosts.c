/*
 * Bodies of a host. The host says where they are at the end of each step, and is told what the soil does to them.
 *
 * Here: their numbers, their names, and where the host says they are. host_steps.c moves them.
 *
 * Invariants:
 * - body.last is the pose up to which motion has changed the ground; body.has_last says that there is one.
 * - `now` is where the body is; `next`, if has_next, is where it will be after the next step.
 */
#include <math.h>
#include <string.h>

#include "world/internal.h"

/* --- numbers --- */

bool world_is_hosted(const struct body *body)
{
	return body != NULL && (body->kind == BODY_HOST || body->kind == BODY_VEHICLE);
}

bool world_is_set_down(const struct body *body)
{
	return body != NULL && body->host.placed && !body->host.removed;
}

struct body *world_body_hosted(const struct world *world, size_t number)
{
	struct body *body = world_body_at(world, number);
	return world_is_hosted(body) ? body : NULL;
}

static enum status gone(int32_t number)
{
	return fail_with(STATUS_USAGE, "body %d: there is none, or it was removed; use a handle that furrow_body_add or "
				       "furrow_body_find gave", (int)number);
}

/* Finds the host's body of this number, or says why there is none. */
static enum status find(const struct world *world, int32_t number, struct body **out)
{
	*out = world_body_hosted(world, (size_t)number);
	if (*out != NULL && !(*out)->host.removed)
		return STATUS_OK;
	if (world_follows_path(world, (size_t)number))
		return fail_with(STATUS_USAGE, "%s: it follows its path; only bodies without one are the host's to move",
				 world->bodies[number]->object->name);
	return gone(number);
}

/* --- adding and removing --- */

enum status world_body_find(struct world *world, const char *name, int32_t *number)
{
	*number = world_names_find(world, name);
	return *number >= 0 ? STATUS_OK
			    : fail_with(STATUS_INPUT, "%s: no body has this name; give one of the scene's objects, or one that was added", name);
}

/* Gives a free name in place of one that the scene made, if that is taken. A name that the host gave stays. */
static enum status name_it(struct world *world, struct scene_object *object)
{
	char name[32];
	if (world_names_find(world, object->name) < 0)
		return STATUS_OK;
	if (!object->name_is_made)
		return fail_with(STATUS_INPUT, "%s: another body has this name; give one that is free", object->name);
	world_names_next(world, name, sizeof name);
	char *copy = mem_alloc(strlen(name) + 1, 1);
	TRY_MEM(copy, "a body");
	strcpy(copy, name);
	mem_free(object->name);
	object->name = copy;
	return STATUS_OK;
}

struct deform_planned world_planned_host(const struct soil_shape *shape)
{
	return (struct deform_planned){shape, true, shape->kind == SOIL_WHEEL};
}

static enum status may_carry(struct world *world, struct scene_object *object, struct soil_carried **carried)
{
	struct body body = {.object = object};
	const enum status status = world_carried_make(world, &body);
	*carried = body.carried;
	return status;
}

enum status world_body_add(struct world *world, struct scene_object *object, int32_t *number)
{
	const struct deform_planned planned = world_planned_host(&object->shape);
	*number = -1;
	if (object->path.count > 0)
		return fail_with(STATUS_INPUT, "%s: it has a path; a body that is added is the host's: leave the path out, or put it into the "
					       "scene's objects", object->name);
	struct scene_object *owned = NULL;
	struct soil_carried *carried = NULL;
	enum status status;
	TRY_OR(failed, soil_shape_check(&object->shape, world->resident.spacing));
	TRY_OR(failed, world_shape_budget(world, object->name, &object->shape));
	TRY_OR(failed, world_check_bearing(world, object->name, &object->shape));
	TRY_OR(failed, world_limits_add(world, &object->shape));
	TRY_OR(failed, name_it(world, object));
	if (world->deform != NULL)
		TRY_OR(failed, deform_warm(world->deform, &planned));
	owned = mem_calloc(1, sizeof *owned);
	TRY_OR(failed, owned != NULL ? STATUS_OK : fail_memory("a body"));
	if (object->carry)
		TRY_OR(failed, may_carry(world, object, &carried));
	TRY_OR(failed, world_list_body(world, BODY_HOST, owned, owned));
	*owned = *object;
	world->bodies[world->body_count - 1]->carried = carried;
	if (carried != NULL)
		carried->shape = &owned->shape;
	*number = (int32_t)world->body_count - 1;
	return STATUS_OK;
failed:
	mem_free(owned);
	soil_carried_destroy(carried);
	world_names_freed(world, object->name); /* it is free again */
	return status;
}

/* --- poses --- */

static enum status check_state(const struct world *world, const struct body *body, const struct furrow_state *state)
{
	struct soil_pose pose;
	const char *name = body->object->name;
	if (!body->host.placed)
		return fail_with(STATUS_USAGE, "%s: it was not placed; call furrow_place first, since it has nowhere to come from", name);
	TRY(world_state_check(&body->object->shape, name, state, &pose));
	const struct furrow_state *from = &body->host.now;
	const double way = hypot(state->pose.position[0] - from->pose.position[0], state->pose.position[1] - from->pose.position[1]);
	if (way > WORLD_HOST_WAY * world->resident.spacing)
		return fail_with(STATUS_USAGE, "%s: it moves %g m in one step, more than %d posts; step more often, or use furrow_place", name, way,
				 WORLD_HOST_WAY);
	return STATUS_OK;
}

/* Returns the number of pages that one body's motion can change. */
static double pages_of(const struct world *world, const struct body *body, const struct furrow_state *state)
{
	const double side = world->resident.spacing * world->resident.meta->extent.cells;
	const double across = ceil((2 * soil_shape_bound(&body->object->shape) + 16 * world->resident.spacing) / side) + 1;
	const double way = fmax(fabs(state->pose.position[0] - body->host.now.pose.position[0]),
				fabs(state->pose.position[1] - body->host.now.pose.position[1]));
	return (2 * (way / side) + across) * across;
}

/* Adds the tiles that one body's motion can change, within the terrain. */
static enum status add_tiles(const struct world *world, const struct body *body, const struct furrow_state *state, struct key_set *tiles)
{
	const double *from = body->host.now.pose.position, *to = state->pose.position;
	const double beside = soil_shape_bound(&body->object->shape) + 8 * world->resident.spacing;
	const struct post_rect rect = {
		(int64_t)floor((fmin(from[0], to[0]) - beside) / world->resident.spacing), (int64_t)floor((fmin(from[1], to[1]) - beside) / world->resident.spacing),
		(int64_t)ceil((fmax(from[0], to[0]) + beside) / world->resident.spacing), (int64_t)ceil((fmax(from[1], to[1]) + beside) / world->resident.spacing),
	};
	struct tile first, last;
	if (!tile_range_of(&world->resident.meta->extent, world->resident.level, rect, &first, &last))
		return STATUS_OK;
	for (uint32_t y = first.y; y <= last.y; y++)
		for (uint32_t x = first.x; x <= last.x && tiles->count <= WORLD_HOST_PAGES; x++)
			TRY(key_set_add(tiles, tile_key((struct tile){world->resident.level, x, y})));
	return STATUS_OK;
}

/* Counts the tiles that the bodies' motions can change: bodies may share tiles. */
static enum status count_tiles(const struct world *world, size_t count, const int32_t *numbers, const struct furrow_state *states, double *pages)
{
	struct key_set tiles = {.count = 0};
	enum status status = STATUS_OK;
	for (size_t i = 0; i < count; i++)
		TRY_OR(done, add_tiles(world, world->bodies[numbers[i]], &states[i], &tiles));
done:
	*pages = (double)tiles.count;
	key_set_finish(&tiles);
	return status;
}

static enum status check_pages(const struct world *world, size_t count, const int32_t *numbers, const struct furrow_state *states)
{
	double pages = 0;
	for (size_t i = 0; i < count; i++)
		pages += pages_of(world, world->bodies[numbers[i]], &states[i]);
	if (pages > WORLD_HOST_PAGES && pages / (double)count <= WORLD_HOST_PAGES)
		TRY(count_tiles(world, count, numbers, states, &pages));
	if (pages > WORLD_HOST_PAGES)
		return fail_with(STATUS_USAGE, "states: these motions touch up to %.0f tiles in one step, and %d is the most; step more often, or use "
					       "larger tiles", pages, WORLD_HOST_PAGES);
	return STATUS_OK;
}

enum status world_bodies_set(struct world *world, size_t count, const int32_t *numbers, const struct furrow_state *states, const struct furrow_belt *belts)
{
	const uint64_t turn = ++world->set_turn;
	for (size_t i = 0; i < count; i++) {
		struct body *body;
		TRY(find(world, numbers[i], &body));
		TRY(check_state(world, body, &states[i]));
		if (body->host.turn == turn)
			return fail_with(STATUS_USAGE, "%s: it stands twice in the list; give one state for each body", body->object->name);
		body->host.turn = turn;
	}
	TRY(check_pages(world, count, numbers, states));
	for (size_t i = 0; i < count; i++) {
		struct body *body = world->bodies[numbers[i]];
		body->host.next = states[i];
		if (belts != NULL)
			body->host.next_belt = belts[i];
		body->host.has_next = true;
	}
	world->near.stale = true;
	return STATUS_OK;
}

enum status world_belts_set(struct world *world, size_t count, const int32_t *numbers, const struct furrow_belt *belts)
{
	for (size_t i = 0; i < count; i++) {
		struct body *body;
		TRY(find(world, numbers[i], &body));
		if (!body->object->shape.belt)
			return fail_with(STATUS_USAGE, "%s: it has no belt; give it belt: true of a box or a mesh", body->object->name);
		if (!isfinite(belts[i].travel) || !isfinite(belts[i].speed))
			return fail_with(STATUS_USAGE, "%s: the travel or the speed of its belt is not a finite number; give m and m/s",
					 body->object->name);
	}
	for (size_t i = 0; i < count; i++) {
		struct body *body = world->bodies[numbers[i]];
		if (!body->host.belt_told)
			body->last.turn = belts[i].travel; /* its travel is counted from here */
		body->host.belt = belts[i];
		body->host.belt_told = true;
	}
	return STATUS_OK;
}

/* Frees the ground that it rested on. It touches nothing until the next step. */
static enum status lift(struct world *world, struct body *body)
{
	const bool changes = body->has_last && deform_is_elastic(world->scene->model); /* what it held down comes back */
	if (changes)
		world_tear(world);
	enum status status = world_let_go(world, body);
	world->near.stale = true;
	body->has_last = false;
	body->trend = (struct soil_trend){.whole = {.ran = 0}};
	body->host.fresh = true;
	body->host.since = body->host.turned = 0;
	memset(body->host.rotated, 0, sizeof body->host.rotated);
	body->host.stamped = 1;
	body->host.force = world_no_force(0);
	body->host.state = FURROW_AIR;
	body->host.told = world->time;
	if (status == STATUS_OK && changes)
		status = world_end_change(world);
	return status;
}

enum status world_body_place(struct world *world, int32_t number, const struct furrow_pose *pose)
{
	struct body *body;
	struct soil_pose at;
	TRY(find(world, number, &body));
	TRY(world_attitude(&body->object->shape, body->object->name, pose, &at));
	TRY(lift(world, body));
	body->host.placed = world->unplaced = true;
	body->host.has_next = body->host.posed_linear = body->host.posed_angular = body->host.unposed = false;
	body->host.rates_far = 0;
	body->host.now = (struct furrow_state){.pose = *pose};
	if (body->kind == BODY_VEHICLE)
		body->host.belt = (struct furrow_belt){0, 0};
	world->near.stale = true;
	return STATUS_OK;
}

enum status world_body_lift(struct world *world, int32_t number)
{
	struct body *body;
	TRY(find(world, number, &body));
	if (!body->host.placed)
		return STATUS_OK;
	TRY(lift(world, body));
	body->host.placed = body->host.has_next = false;
	return STATUS_OK;
}

enum status world_body_remove(struct world *world, int32_t number)
{
	struct body *body;
	TRY(find(world, number, &body));
	TRY(lift(world, body));
	body->host.removed = true;
	world_names_freed(world, body->object->name);
	return STATUS_OK;
}

enum status world_body_state(const struct world *world, int32_t number, struct furrow_state *state)
{
	const struct body *body = world_body(world, (size_t)number);
	*state = (struct furrow_state){.pose = {{NAN, NAN, NAN}, {NAN, NAN, NAN, NAN}}};
	if (body == NULL || body->host.removed)
		return gone(number);
	if (body->kind != BODY_PATH) {
		if (body->host.placed)
			*state = body->host.now;
		else
			for (int i = 0; i < 3; i++)
				state->linear[i] = state->angular[i] = NAN;
		return STATUS_OK;
	}
	return world_path_state(world, (size_t)number, state);
}
