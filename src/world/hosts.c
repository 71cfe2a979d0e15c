/*
 * Bodies of a host. The host says where they are at the end of each step, and is told what the soil does to them.
 *
 * A host moves a body by less than a post in a step. So its motion accumulates. It changes the ground when it is worth a swept
 * contact:
 * - after a working post of travel or of turn,
 * - after a tenth of a post of sinkage,
 * - at a checkpoint, and before a query.
 *
 * In between only the forces are computed, over the same ground (deform_feel).
 *
 * Invariants:
 * - body.last is the pose up to which motion has changed the ground; body.in_contact says that there is one.
 * - `now` is where the body is; `next`, if has_next, is where it will be after the next step.
 * - A number is given out once. list[number] is NULL for a body with a path, and for one that a rollback removed.
 */
#include <math.h>
#include <string.h>

#include "world/internal.h"

#define SINKAGE_SHARE 0.1     /* of a post */
#define PIECES_MOST 4096      /* posts that a body may travel in a step */
#define TRAVEL_TILES 64       /* tiles that all bodies together may cross in a step */

/* --- numbers --- */

struct host_body *world_host_body(const struct world *world, int32_t number)
{
	return number >= 0 && (size_t)number < world->hosts.count ? world->hosts.list[number] : NULL;
}

static size_t index_of(const struct world *world, int32_t number)
{
	return world->scene->object_count + 1 + (size_t)number;
}

struct body *world_body_at(const struct world *world, size_t index)
{
	if (index <= world->scene->object_count)
		return &world->bodies[index];
	return &world->hosts.list[index - world->scene->object_count - 1]->body;
}

bool world_is_hosts(const struct world *world, size_t index)
{
	return index > world->scene->object_count;
}

static bool follows_path(const struct world *world, int32_t number)
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
	if (follows_path(world, number))
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
	for (int i = 0; i < 3; i++)
		host->now.pose.position[i] = NAN;
	return host;
}

enum status world_make_hosts(struct world *world)
{
	if (!world->scene->hosted)
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
	world->hosts = (struct world_hosts){.list = NULL};
}

static bool is_named(const struct world *world, int32_t number, const char *name)
{
	const struct host_body *host = world_host_body(world, number);
	if (follows_path(world, number))
		return strcmp(world->bodies[number].object->name, name) == 0;
	return host != NULL && !host->removed && strcmp(host->body.object->name, name) == 0;
}

enum status world_body_find(const struct world *world, const char *name, int32_t *number)
{
	for (size_t i = 0; i < world->hosts.count; i++)
		if (is_named(world, (int32_t)i, name)) {
			*number = (int32_t)i;
			return STATUS_OK;
		}
	*number = -1;
	return fail_with(STATUS_INPUT, "%s: no body has this name; give one of the scene's objects, or one that was added", name);
}

/* Gives a free name instead of the scene's "body-1". */
static enum status name_it(const struct world *world, struct scene_object *object, bool given)
{
	int32_t other;
	char name[32];
	if (world_body_find(world, object->name, &other) != STATUS_OK)
		return STATUS_OK;
	if (given)
		return fail_with(STATUS_INPUT, "%s: another body has this name; give one that is free", object->name);
	for (unsigned n = 1;; n++) {
		snprintf(name, sizeof name, "body-%u", n);
		if (world_body_find(world, name, &other) != STATUS_OK)
			break;
	}
	char *copy = mem_alloc(strlen(name) + 1, 1);
	if (copy == NULL)
		return fail_memory("a body");
	strcpy(copy, name);
	mem_free(object->name);
	object->name = copy;
	return STATUS_OK;
}

static bool is_made_up(const char *name)
{
	return strncmp(name, "body-", 5) == 0;
}

enum status world_body_add(struct world *world, struct scene_object *object, int32_t *number)
{
	const struct deform_planned planned = {&object->shape, 0, true};
	*number = -1;
	if (object->path.count > 0)
		return fail_with(STATUS_INPUT, "%s: it has a path; a body that is added is the host's: leave the path out, or put it into the "
					       "scene's objects", object->name);
	enum status status = deform_shape_check(&object->shape, world->spacing);
	if (status == STATUS_OK)
		status = world_shape_budget(world, object->name, &object->shape);
	if (status == STATUS_OK)
		status = make_room(world);
	if (status == STATUS_OK)
		status = name_it(world, object, !is_made_up(object->name));
	if (status == STATUS_OK)
		status = world_forces_wait(world->forces); /* warming up drops forces that are being computed */
	if (status == STATUS_OK)
		status = deform_warm(world->deform, &planned, world_asks_forces(world));
	if (status != STATUS_OK)
		return status;
	struct scene_object *owned = mem_calloc(1, sizeof *owned);
	struct host_body *host = owned != NULL ? new_body(owned, owned) : NULL;
	if (host == NULL) {
		mem_free(owned);
		return fail_memory("a body");
	}
	*owned = *object;
	*number = (int32_t)world->hosts.count;
	world->hosts.list[world->hosts.count++] = host;
	return STATUS_OK;
}

/* --- poses --- */

static bool is_finite_state(const struct world_state *state)
{
	double sum = 0;
	for (int i = 0; i < 3; i++)
		sum += fabs(state->linear[i]) + fabs(state->angular[i]);
	return isfinite(sum);
}

static enum status check_state(const struct world *world, const struct host_body *host, const struct world_state *state)
{
	struct deform_pose pose;
	const char *name = host->body.object->name;
	if (!host->placed)
		return fail_with(STATUS_USAGE, "%s: it was not placed; call furrow_place first, since it has nowhere to come from", name);
	if (!is_finite_state(state))
		return fail_with(STATUS_USAGE, "%s: a velocity is not a finite number; give m/s and rad/s", name);
	enum status status = world_attitude(&host->body.object->shape, name, &state->pose, &pose);
	if (status != STATUS_OK)
		return status;
	const struct world_state *from = &host->now;
	const double way = hypot(state->pose.position[0] - from->pose.position[0], state->pose.position[1] - from->pose.position[1]);
	if (way > PIECES_MOST * world->spacing)
		return fail_with(STATUS_USAGE, "%s: it moves %g m in one step, more than %d posts; step more often, or use furrow_place", name, way,
				 PIECES_MOST);
	return STATUS_OK;
}

/* Returns the number of pages that one body's motion can change. */
static double pages_of(const struct world *world, const struct host_body *host, const struct world_state *state)
{
	const double side = world->spacing * world->meta->extent.cells;
	const double across = ceil((2 * deform_shape_bound(&host->body.object->shape) + 16 * world->spacing) / side) + 1;
	const double way = fmax(fabs(state->pose.position[0] - host->now.pose.position[0]),
				fabs(state->pose.position[1] - host->now.pose.position[1]));
	return (2 * (way / side) + across) * across;
}

static enum status check_pages(const struct world *world, size_t count, const int32_t *numbers, const struct world_state *states)
{
	double pages = 0;
	for (size_t i = 0; i < count; i++)
		pages += pages_of(world, world_host_body(world, numbers[i]), &states[i]);
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
	return status;
}

/* Frees the ground that it rested on. It touches nothing until the next step. */
static enum status lift(struct world *world, struct host_body *host)
{
	enum status status = world_let_go(world, &host->body);
	host->body.in_contact = false;
	host->fresh = true;
	host->since = host->turned = 0;
	host->tag = 0;
	host->force = (struct world_force){.z = 0};
	host->state = WORLD_AIR;
	host->told = world->time;
	return status;
}

enum status world_body_place(struct world *world, int32_t number, const struct world_pose *pose)
{
	struct host_body *host;
	struct deform_pose at;
	enum status status = find(world, number, &host);
	if (status == STATUS_OK)
		status = world_attitude(&host->body.object->shape, host->body.object->name, pose, &at);
	if (status == STATUS_OK)
		status = lift(world, host);
	if (status != STATUS_OK)
		return status;
	host->placed = true;
	host->has_next = false;
	host->now = (struct world_state){.pose = *pose};
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
	return status;
}

/* --- steps --- */

static struct event event_of(const struct world *world, int32_t number, const struct deform_pose *pose, double time)
{
	return (struct event){.body = index_of(world, number), .time = time, .contact = true, .next_time = INFINITY, .pose = *pose};
}

/* Sets the parts of the event that follow from the base under the body. */
static enum status over_ground(struct world *world, struct event *event, const struct deform_shape *shape)
{
	int64_t ground;
	enum status status = resident_ground_height(world->ground, event->pose.x, event->pose.y, &ground, &event->contact);
	if (status == STATUS_OK && event->contact)
		event->sinkage = lattice_offset_metres(ground - event->pose.z) + deform_shape_reach(shape, event->pose.pitch, event->pose.roll);
	return status;
}

static double travel(const struct deform_pose *from, const struct deform_pose *to)
{
	return hypot(lattice_offset_metres(to->x - from->x), lattice_offset_metres(to->y - from->y));
}

static double turn_between(double from, double to)
{
	return remainder(to - from, 2 * M_PI);
}

/* Returns the metres by which its outermost points have turned. */
static double turned_by(const struct host_body *host, const struct deform_pose *to)
{
	const struct deform_pose *from = &host->body.last;
	const double attitude = fabs(turn_between(from->yaw, to->yaw)) + fabs(to->pitch - from->pitch) +
				fabs(turn_between(from->roll, to->roll));
	return deform_shape_bound(&host->body.object->shape) * fmax(attitude, fabs(host->turned));
}

static bool is_worth_a_contact(const struct world *world, const struct host_body *host, const struct deform_pose *to)
{
	const double sinkage = fabs(lattice_offset_metres(to->z - host->body.last.z));
	return travel(&host->body.last, to) >= world->spacing || turned_by(host, to) >= world->spacing ||
	       sinkage >= SINKAGE_SHARE * world->spacing;
}

static bool has_moved(const struct host_body *host, const struct deform_pose *to)
{
	const struct deform_pose *at = &host->felt;
	return at->x != to->x || at->y != to->y || at->z != to->z || at->yaw != to->yaw || at->pitch != to->pitch || at->roll != to->roll ||
	       host->turned != host->felt_turned;
}

static struct deform_pose between(const struct deform_pose *a, const struct deform_pose *b, size_t part, size_t parts)
{
	if (part == parts)
		return *b;
	const double share = (double)part / (double)parts;
	return (struct deform_pose){
		.x = a->x + llround((double)(b->x - a->x) * share),
		.y = a->y + llround((double)(b->y - a->y) * share),
		.z = a->z + llround((double)(b->z - a->z) * share),
		.yaw = a->yaw + turn_between(a->yaw, b->yaw) * share,
		.pitch = a->pitch + (b->pitch - a->pitch) * share,
		.roll = a->roll + turn_between(a->roll, b->roll) * share,
		.turn = a->turn + turn_between(a->turn, b->turn) * share,
	};
}

/* Changes the ground up to this pose, by swept contacts of at most one post each. */
static enum status press(struct world *world, int32_t number, const struct deform_pose *to, double time)
{
	struct host_body *host = world_host_body(world, number);
	struct body *body = &host->body;
	const struct deform_pose from = body->last;
	size_t parts = 1;
	if (body->in_contact)
		parts = (size_t)fmin(PIECES_MOST, fmax(1, ceil(fmax(travel(&from, to), turned_by(host, to)) / world->spacing - 1e-9)));
	enum status status = STATUS_OK;
	for (size_t part = 1; part <= parts && status == STATUS_OK; part++) {
		const struct deform_pose pose = body->in_contact ? between(&from, to, part, parts) : *to;
		struct event event = event_of(world, number, &pose, time);
		event.seconds = host->since / (double)parts;
		event.turned = host->turned / (double)parts;
		event.distance = body->in_contact ? travel(&body->last, &pose) : 0;
		status = over_ground(world, &event, &body->object->shape);
		if (status != STATUS_OK)
			return status;
		if (!event.contact) { /* off the terrain, or over a hole */
			status = world_let_go(world, body);
			body->in_contact = false;
			world_host_absent(world, event.body);
			continue;
		}
		body->distance += event.distance;
		body->sinkage = event.sinkage;
		status = world_contact(world, &event, part == parts);
	}
	host->fresh = !body->in_contact;
	host->since = host->turned = 0;
	host->felt = *to;
	host->felt_turned = 0;
	host->felt_moving = parts > 1 || from.x != to->x || from.y != to->y || from.z != to->z;
	return status;
}

/* The forces alone. */
static enum status feel(struct world *world, int32_t number, const struct deform_pose *to, double time, bool moves)
{
	struct host_body *host = world_host_body(world, number);
	struct event event = event_of(world, number, to, time);
	event.seconds = moves ? host->since : 0;
	event.turned = host->turned;
	enum status status = over_ground(world, &event, &host->body.object->shape);
	if (status != STATUS_OK)
		return status;
	host->felt = *to;
	host->felt_turned = host->turned;
	host->felt_moving = moves;
	if (event.contact)
		return world_feel(world, &event);
	world_host_absent(world, event.body);
	return STATUS_OK;
}

static enum status step_body(struct world *world, int32_t number, double seconds, double until)
{
	struct host_body *host = world_host_body(world, number);
	struct deform_pose to;
	if (host->has_next)
		host->now = host->next;
	host->has_next = false;
	enum status status = world_attitude(&host->body.object->shape, host->body.object->name, &host->now.pose, &to);
	if (status != STATUS_OK)
		return status;
	if (host->body.object->shape.kind == DEFORM_WHEEL)
		host->turned += (-sin(to.yaw) * host->now.angular[0] + cos(to.yaw) * host->now.angular[1]) * seconds;
	const bool moved = has_moved(host, &to);
	host->since += moved ? seconds : 0;
	if (host->fresh || !host->body.in_contact || is_worth_a_contact(world, host, &to))
		return press(world, number, &to, until);
	/* Where it came to rest, the rates end. */
	if (world_feels(world) && (moved || host->felt_moving))
		return feel(world, number, &to, until, moved);
	host->told = until; /* nothing moves: the last forces hold */
	return STATUS_OK;
}

enum status world_hosts_step(struct world *world, double seconds, double until)
{
	enum status status = STATUS_OK;
	for (size_t i = 0; i < world->hosts.count && status == STATUS_OK; i++) {
		const struct host_body *host = world->hosts.list[i];
		if (host != NULL && host->placed && !host->removed)
			status = step_body(world, (int32_t)i, seconds, until);
	}
	return status;
}

static bool is_behind(const struct world *world, const struct host_body *host, struct deform_pose *to)
{
	if (host == NULL || !host->placed || host->removed || host->fresh || !host->body.in_contact ||
	    world_attitude(&host->body.object->shape, host->body.object->name, &host->now.pose, to) != STATUS_OK)
		return false;
	const struct deform_pose *last = &host->body.last;
	return to->x != last->x || to->y != last->y || to->z != last->z || to->yaw != last->yaw || to->pitch != last->pitch ||
	       to->roll != last->roll;
}

enum status world_hosts_commit(struct world *world)
{
	enum status status = STATUS_OK;
	bool any = false;
	struct deform_pose to;
	for (size_t i = 0; i < world->hosts.count && status == STATUS_OK; i++) {
		if (!is_behind(world, world->hosts.list[i], &to))
			continue;
		world->torn = any = true;
		status = press(world, (int32_t)i, &to, world->time);
	}
	if (status == STATUS_OK && any)
		status = world_forces_end_step(world->forces, world->time);
	return status == STATUS_OK && any ? world_end_step(world) : status;
}

size_t world_host_rests(const struct world *world, struct deform_rest *rests)
{
	size_t count = 0;
	for (size_t i = 0; i < world->hosts.count; i++) {
		const struct host_body *host = world->hosts.list[i];
		if (host != NULL && host->body.in_contact && !host->removed)
			rests[count++] = (struct deform_rest){&host->body.object->shape, host->body.last, 0};
	}
	return count;
}

/* --- being told --- */

void world_host_asked(struct world *world, size_t index, uint64_t tag, const struct event *event)
{
	struct host_body *host = world->hosts.list[index - world->scene->object_count - 1];
	host->tag = tag;
	host->asked = event->time;
	if (tag != 0)
		return;
	/* The model tells no forces; only the contact state is known. */
	host->state = event->sinkage > 0 ? WORLD_TOUCHING : WORLD_AIR;
	host->force = (struct world_force){.sinkage = event->sinkage};
	host->told = event->time;
}

void world_host_absent(struct world *world, size_t index)
{
	struct host_body *host = world->hosts.list[index - world->scene->object_count - 1];
	host->tag = 0;
	host->state = WORLD_AIR;
	host->force = (struct world_force){.z = 0};
	host->told = world->hosts.until;
}

void world_host_arrived(struct world *world, uint64_t tag, const struct world_force *force)
{
	for (size_t i = 0; i < world->hosts.count; i++) {
		struct host_body *host = world->hosts.list[i];
		if (host == NULL || host->tag != tag)
			continue;
		host->tag = 0;
		host->force = *force;
		host->told = host->asked;
		host->state = force->area > 0 ? WORLD_TOUCHING : WORLD_AIR;
		return;
	}
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
	if (!follows_path(world, number))
		return gone(number);
	return world_path_state(world, (size_t)number, state);
}
