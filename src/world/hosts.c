/*
 * Bodies of a host. The host says where they are at the end of each step, and is told what the soil does to them.
 *
 * Here: their numbers, their names, and where the host says they are. host_steps.c moves them.
 *
 * Invariants:
 * - body.last is the pose up to which motion has changed the ground; body.in_contact says that there is one.
 * - `now` is where the body is; `next`, if has_next, is where it will be after the next step.
 * - A number is given out once. list[number] is NULL for a body with a path, and for one that a rollback removed.
 */
#include <math.h>
#include <string.h>

#include "world/internal.h"

/* --- numbers --- */

struct host_body *world_host_body(const struct world *world, int32_t number)
{
	return number >= 0 && (size_t)number < world->hosts.count ? world->hosts.list[number] : NULL;
}

struct body *world_body_at(const struct world *world, size_t index)
{
	if (index <= world->scene->object_count)
		return &world->bodies[index];
	return &world->hosts.list[index - world->scene->object_count - 1]->body;
}

const struct body *world_body_of(const struct world *world, const struct event *event)
{
	return world_body_at(world, event->body);
}

bool world_is_hosts(const struct world *world, size_t index)
{
	return index > world->scene->object_count;
}

bool world_is_quiet(const struct world *world, size_t index)
{
	return world_is_hosts(world, index) && world->hosts.list[index - world->scene->object_count - 1]->quiet;
}

bool world_follows_path(const struct world *world, int32_t number)
{
	return number >= 0 && (size_t)number < world->scene->object_count && world->bodies[number].track != NULL;
}

static enum status gone(int32_t number)
{
	return fail_with(STATUS_USAGE, "body %d: there is none, or it was removed; use a handle that furrow_body_add or "
				       "furrow_body_find gave", (int)number);
}

/* Finds the host's body of this number, or says why there is none. */
static enum status find(const struct world *world, int32_t number, struct host_body **out)
{
	*out = world_host_body(world, number);
	if (*out != NULL && !(*out)->removed)
		return STATUS_OK;
	if (world_follows_path(world, number))
		return fail_with(STATUS_USAGE, "%s: it follows its path; only bodies without one are the host's to move",
				 world->bodies[number].object->name);
	return gone(number);
}

/* --- adding and removing --- */

static enum status make_room(struct world *world)
{
	struct world_hosts *hosts = &world->hosts;
	if (hosts->count < hosts->room)
		return STATUS_OK;
	if (hosts->count >= INT32_MAX / 2)
		return fail_with(STATUS_FAILED, "bodies: too many were added; close the world and open it again");
	const size_t room = hosts->room > 0 ? 2 * hosts->room : 16;
	struct host_body **list = mem_realloc(hosts->list, room, sizeof *list);
	if (list == NULL)
		return fail_memory("a body");
	hosts->list = list;
	struct deform_rest *rests = mem_realloc(world->relaxation.rests, world->scene->object_count + room, sizeof *rests);
	if (rests == NULL)
		return fail_memory("a body");
	world->relaxation.rests = rests;
	hosts->room = room;
	return STATUS_OK;
}

static struct host_body *new_body(const struct scene_object *object, struct scene_object *owned)
{
	struct host_body *host = mem_calloc(1, sizeof *host);
	if (host == NULL)
		return NULL;
	host->body.object = object;
	host->owned = owned;
	host->stamped = 1;
	for (int i = 0; i < 3; i++)
		host->now.pose.position[i] = NAN;
	return host;
}

enum status world_make_hosts(struct world *world)
{
	if (!scene_moves_bodies(world->scene))
		return STATUS_OK;
	for (size_t i = 0; i < world->scene->object_count; i++) {
		enum status status = make_room(world);
		if (status != STATUS_OK)
			return status;
		struct host_body *host = NULL;
		if (world->bodies[i].track == NULL) {
			host = new_body(&world->scene->objects[i], NULL);
			if (host == NULL)
				return fail_memory("a body");
		}
		world->hosts.list[world->hosts.count++] = host;
	}
	return STATUS_OK;
}

void world_host_free(struct host_body *host)
{
	if (host == NULL)
		return;
	if (host->owned != NULL)
		scene_object_finish(host->owned);
	mem_free(host->owned);
	mem_free(host);
}

void world_free_hosts(struct world *world)
{
	for (size_t i = 0; i < world->hosts.count; i++)
		world_host_free(world->hosts.list[i]);
	mem_free(world->hosts.list);
	world_names_free(world);
	world->hosts = (struct world_hosts){.list = NULL};
}

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
	if (copy == NULL)
		return fail_memory("a body");
	strcpy(copy, name);
	mem_free(object->name);
	object->name = copy;
	return STATUS_OK;
}

struct deform_planned world_planned_host(const struct soil_shape *shape)
{
	return (struct deform_planned){shape, true, shape->kind == SOIL_WHEEL};
}

enum status world_body_add(struct world *world, struct scene_object *object, int32_t *number)
{
	const struct deform_planned planned = world_planned_host(&object->shape);
	*number = -1;
	if (object->path.count > 0)
		return fail_with(STATUS_INPUT, "%s: it has a path; a body that is added is the host's: leave the path out, or put it into the "
					       "scene's objects", object->name);
	enum status status = soil_shape_check(&object->shape, world->resident.spacing);
	if (status == STATUS_OK)
		status = world_shape_budget(world, object->name, &object->shape);
	if (status == STATUS_OK)
		status = world_check_bearing(world, object->name, &object->shape);
	if (status == STATUS_OK)
		status = world_limits_add(world, &object->shape);
	if (status == STATUS_OK)
		status = make_room(world);
	if (status == STATUS_OK)
		status = name_it(world, object);
	if (status == STATUS_OK && world->deform != NULL)
		status = deform_warm(world->deform, &planned);
	struct scene_object *owned = status == STATUS_OK ? mem_calloc(1, sizeof *owned) : NULL;
	struct host_body *host = owned != NULL ? new_body(owned, owned) : NULL;
	if (host == NULL) {
		mem_free(owned);
		world_names_freed(world, object->name); /* it is free again */
		return status != STATUS_OK ? status : fail_memory("a body");
	}
	*owned = *object;
	*number = (int32_t)world->hosts.count;
	world->hosts.list[world->hosts.count++] = host;
	return STATUS_OK;
}

/* --- poses --- */

static enum status check_state(const struct world *world, const struct host_body *host, const struct world_state *state)
{
	struct soil_pose pose;
	const char *name = host->body.object->name;
	if (!host->placed)
		return fail_with(STATUS_USAGE, "%s: it was not placed; call furrow_place first, since it has nowhere to come from", name);
	enum status status = world_state_check(&host->body.object->shape, name, state, &pose);
	if (status != STATUS_OK)
		return status;
	const struct world_state *from = &host->now;
	const double way = hypot(state->pose.position[0] - from->pose.position[0], state->pose.position[1] - from->pose.position[1]);
	if (way > WORLD_HOST_WAY * world->resident.spacing)
		return fail_with(STATUS_USAGE, "%s: it moves %g m in one step, more than %d posts; step more often, or use furrow_place", name, way,
				 WORLD_HOST_WAY);
	return STATUS_OK;
}

/* Returns the number of pages that one body's motion can change. */
static double pages_of(const struct world *world, const struct host_body *host, const struct world_state *state)
{
	const double side = world->resident.spacing * world->resident.meta->extent.cells;
	const double across = ceil((2 * soil_shape_bound(&host->body.object->shape) + 16 * world->resident.spacing) / side) + 1;
	const double way = fmax(fabs(state->pose.position[0] - host->now.pose.position[0]),
				fabs(state->pose.position[1] - host->now.pose.position[1]));
	return (2 * (way / side) + across) * across;
}

/* Adds the tiles that one body's motion can change, within the terrain. */
static enum status add_tiles(const struct world *world, const struct host_body *host, const struct world_state *state, struct key_set *tiles)
{
	const double *from = host->now.pose.position, *to = state->pose.position;
	const double beside = soil_shape_bound(&host->body.object->shape) + 8 * world->resident.spacing;
	const struct post_rect rect = {
		(int64_t)floor((fmin(from[0], to[0]) - beside) / world->resident.spacing), (int64_t)floor((fmin(from[1], to[1]) - beside) / world->resident.spacing),
		(int64_t)ceil((fmax(from[0], to[0]) + beside) / world->resident.spacing), (int64_t)ceil((fmax(from[1], to[1]) + beside) / world->resident.spacing),
	};
	struct tile first, last;
	enum status status = STATUS_OK;
	if (!tile_range_of(&world->resident.meta->extent, world->resident.level, rect, &first, &last))
		return STATUS_OK;
	for (uint32_t y = first.y; y <= last.y && status == STATUS_OK; y++)
		for (uint32_t x = first.x; x <= last.x && status == STATUS_OK && tiles->count <= WORLD_HOST_PAGES; x++)
			status = key_set_add(tiles, tile_key((struct tile){world->resident.level, x, y}));
	return status;
}

static enum status check_pages(const struct world *world, size_t count, const int32_t *numbers, const struct world_state *states)
{
	double pages = 0;
	for (size_t i = 0; i < count; i++)
		pages += pages_of(world, world_host_body(world, numbers[i]), &states[i]);
	if (pages > WORLD_HOST_PAGES && pages / (double)count <= WORLD_HOST_PAGES) { /* bodies may share tiles */
		struct key_set tiles = {.count = 0};
		enum status status = STATUS_OK;
		for (size_t i = 0; i < count && status == STATUS_OK; i++)
			status = add_tiles(world, world_host_body(world, numbers[i]), &states[i], &tiles);
		pages = (double)tiles.count;
		key_set_finish(&tiles);
		if (status != STATUS_OK)
			return status;
	}
	if (pages > WORLD_HOST_PAGES)
		return fail_with(STATUS_USAGE, "states: these motions touch up to %.0f tiles in one step, and %d is the most; step more often, or use "
					       "larger tiles", pages, WORLD_HOST_PAGES);
	return STATUS_OK;
}

enum status world_bodies_set(struct world *world, size_t count, const int32_t *numbers, const struct world_state *states)
{
	const uint64_t turn = ++world->hosts.turn;
	for (size_t i = 0; i < count; i++) {
		struct host_body *host;
		enum status status = find(world, numbers[i], &host);
		if (status == STATUS_OK)
			status = check_state(world, host, &states[i]);
		if (status != STATUS_OK)
			return status;
		if (host->turn == turn)
			return fail_with(STATUS_USAGE, "%s: it stands twice in the list; give one state for each body", host->body.object->name);
		host->turn = turn;
	}
	enum status status = check_pages(world, count, numbers, states);
	for (size_t i = 0; i < count && status == STATUS_OK; i++) {
		struct host_body *host = world_host_body(world, numbers[i]);
		host->next = states[i];
		host->has_next = true;
	}
	world->near.stale = true;
	return status;
}

const struct world_belt *world_belt_of(const struct host_body *host, const struct world_state *state)
{
	return host->quiet ? &state->belt : &host->belt;
}

enum status world_belts_set(struct world *world, size_t count, const int32_t *numbers, const struct world_belt *belts)
{
	for (size_t i = 0; i < count; i++) {
		struct host_body *host;
		enum status status = find(world, numbers[i], &host);
		if (status != STATUS_OK)
			return status;
		if (!host->body.object->shape.belt)
			return fail_with(STATUS_USAGE, "%s: it has no belt; give it belt: true of a box or a mesh", host->body.object->name);
		if (!isfinite(belts[i].travel) || !isfinite(belts[i].speed))
			return fail_with(STATUS_USAGE, "%s: the travel or the speed of its belt is not a finite number; give m and m/s",
					 host->body.object->name);
	}
	for (size_t i = 0; i < count; i++) {
		struct host_body *host = world_host_body(world, numbers[i]);
		if (!host->belt_told)
			host->body.last.turn = belts[i].travel; /* its travel is counted from here */
		host->belt = belts[i];
		host->belt_told = true;
	}
	return STATUS_OK;
}

/* Frees the ground that it rested on. It touches nothing until the next step. */
static enum status lift(struct world *world, struct host_body *host)
{
	enum status status = world_let_go(world, &host->body);
	host->body.in_contact = false;
	host->fresh = true;
	host->since = host->turned = 0;
	memset(host->rotated, 0, sizeof host->rotated);
	host->stamped = 1;
	host->force = world_no_force(0);
	host->state = WORLD_AIR;
	host->told = world->time;
	return status;
}

enum status world_body_place(struct world *world, int32_t number, const struct world_pose *pose)
{
	struct host_body *host;
	struct soil_pose at;
	enum status status = find(world, number, &host);
	if (status == STATUS_OK)
		status = world_attitude(&host->body.object->shape, host->body.object->name, pose, &at);
	if (status == STATUS_OK)
		status = lift(world, host);
	if (status != STATUS_OK)
		return status;
	host->placed = world->unplaced = true;
	host->has_next = host->posed_linear = host->posed_angular = host->unposed = false;
	host->rates_far = 0;
	host->now = (struct world_state){.pose = *pose};
	world->near.stale = true;
	return STATUS_OK;
}

enum status world_body_remove(struct world *world, int32_t number)
{
	struct host_body *host;
	enum status status = find(world, number, &host);
	if (status == STATUS_OK)
		status = lift(world, host);
	if (status == STATUS_OK)
		host->removed = true;
	world->near.stale = true;
	if (status == STATUS_OK)
		world_names_freed(world, host->body.object->name);
	return status;
}

enum status world_body_state(const struct world *world, int32_t number, struct world_state *state)
{
	const struct host_body *host = world_host_body(world, number);
	*state = (struct world_state){.pose = {{NAN, NAN, NAN}, {NAN, NAN, NAN, NAN}}};
	if (host != NULL && !host->removed) {
		if (host->placed)
			*state = host->now;
		else
			for (int i = 0; i < 3; i++)
				state->linear[i] = state->angular[i] = NAN;
		return STATUS_OK;
	}
	if (!world_follows_path(world, number))
		return gone(number);
	return world_path_state(world, (size_t)number, state);
}
