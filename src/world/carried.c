/*
 * Soil aboard bodies with `carry`: it settles after each interval of relaxation, is kept in the record and in checkpoints, and weighs on its body.
 *
 * In the tally, and so in the store, soil aboard counts as compacted. So what a drive leaves aboard is compacted for the next one, and offsets + compacted = 0
 * holds in every store. What is told apart from that follows from the cells.
 */
#define _GNU_SOURCE /* qsort_r */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "world/internal.h"

#define RASTER_MOST (512 * 512) /* places of a body in which its upper envelope is looked at, unless it has more cells */

enum status world_carried_make(struct world *world, struct body *body)
{
	if (!body->object->carry)
		return STATUS_OK;
	TRY(soil_carried_create(&body->object->shape, world->resident.spacing, &body->carried));
	return world_grains_most(world) > 0 ? soil_carried_let_fly(body->carried) : STATUS_OK;
}

static bool carries(const struct body *body)
{
	return body != NULL && body->carried != NULL;
}

/* Tells whether soil aboard is to be put down: its body was removed. */
static bool drops(const struct body *body)
{
	return body->host.removed && body->carried->total > 0;
}

bool world_carried_unsettled(const struct world *world)
{
	bool unsettled = false;
	for (size_t i = 0; i < world->body_count && !unsettled; i++)
		unsettled = carries(world->bodies[i]) && !world->bodies[i]->elsewhere && ((world->bodies[i]->carried->unsettled && world->bodies[i]->has_last) || drops(world->bodies[i]));
	return unsettled;
}

int64_t world_carried_total(const struct world *world)
{
	int64_t total = 0;
	for (size_t i = 0; i < world->body_count; i++)
		total += carries(world->bodies[i]) ? world->bodies[i]->carried->total : 0;
	return total;
}

bool world_carries(const struct world *world)
{
	bool any = world->params.carrying_count > 0; /* vehicles add their bodies late */
	for (size_t i = 0; i < world->body_count && !any; i++)
		any = carries(world->bodies[i]);
	return any;
}

void world_carried_force(const struct world *world, const struct body *body, double force[3], double moment[3])
{
	double weights[SOIL_CLASSES] = {0};
	if (body->carried == NULL || body->carried->total == 0)
		return;
	for (int k = 0; k < world->surface.soil_count; k++)
		weights[k] = world->surface.soils[k].unit_weight;
	soil_carried_weigh(body->carried, weights, force, moment);
}

/* Finds the centre of the soil aboard, m from the body's centre along local axes. What falls counts as level with that. */
static void find_centre(const struct soil_carried *carried, double centre[3])
{
	const double c = cos(carried->yaw + carried->heading), s = sin(carried->yaw + carried->heading);
	double sums[3] = {0, 0, 0};
	for (int row = 0; row < carried->side; row++)
		for (int column = 0; column < carried->side; column++) {
			const size_t i = (size_t)(row * carried->side + column);
			const double amount = (double)carried->amounts[i] + (double)carried->falls[i];
			sums[0] += amount * (column - carried->half);
			sums[1] += amount * (row - carried->half);
			if (carried->amounts[i] > 0 && carried->tops[i] != CARRIED_OPEN)
				sums[2] += (double)carried->amounts[i] * lattice_offset_metres(carried->tops[i] + carried->amounts[i] / 2);
		}
	const double x = sums[0] / (double)carried->total * carried->spacing, y = sums[1] / (double)carried->total * carried->spacing;
	centre[0] = c * x - s * y;
	centre[1] = s * x + c * y;
	centre[2] = sums[2] / (double)carried->total;
}

bool world_body_load(const struct world *world, int32_t number, double *weight, double centre[3])
{
	const struct body *body = world_body_at(world, (size_t)number);
	*weight = centre[0] = centre[1] = centre[2] = 0;
	if (!carries(body) || body->carried->total == 0)
		return false;
	*weight = world_carried_load(world, body);
	find_centre(body->carried, centre);
	return true;
}

double world_carried_load(const struct world *world, const struct body *body)
{
	double force[3] = {0}, moment[3];
	memset(moment, 0, sizeof moment);
	world_carried_force(world, body, force, moment);
	return 0 - force[2]; /* never -0 */
}

struct world_aboard world_aboard_of(const struct world *world, const struct body *body)
{
	if (!carries(body))
		return (struct world_aboard){0, 0, 0};
	const double unit = lattice_offset_metres(1) * world->resident.spacing * world->resident.spacing;
	return (struct world_aboard){body->carried->total, (double)body->carried->total * unit, world_carried_load(world, body)};
}

struct world_aboard world_aboard(const struct world *world, size_t number)
{
	return world_aboard_of(world, world_body(world, number));
}

bool world_heap(const struct world *world, size_t number, struct world_heap *heap)
{
	const struct body *body = world_body(world, number);
	struct soil_pose pose;
	if (!carries(body) || body->carried->total == 0 || body->host.removed)
		return false;
	const struct soil_carried *carried = body->carried;
	pose = body->last;
	if (body->kind != BODY_PATH && world_attitude(&body->object->shape, body->object->name, &body->host.now.pose, &pose) != STATUS_OK)
		return false;
	/* Since the cells were placed, angles may be told by the other triple, whose yaw differs by half a turn. */
	*heap = (struct world_heap){
		.at = {lattice_offset_metres(pose.x), lattice_offset_metres(pose.y), lattice_offset_metres(pose.z)},
		.heading = carried->yaw + carried->heading + remainder(pose.yaw - carried->yaw, M_PI),
		.spacing = carried->spacing, .side = carried->side, .amounts = carried->amounts, .tops = carried->tops, .shares = soil_carried_shares(carried),
	};
	for (int k = 1; k < SOIL_CLASSES; k++)
		heap->class = carried->classes[k] > carried->classes[heap->class] ? k : heap->class;
	return true;
}

/* Two numbers of a record for each cell, eleven of its own, three where soil flies, and the raster of places in them. */
static uint64_t bytes_of(const struct world *world, const struct scene_object *object, bool flies)
{
	const uint64_t cells = soil_carried_numbers(&object->shape, world->resident.spacing) / 2, places = cells > RASTER_MOST ? cells : RASTER_MOST;
	return cells * (2 * sizeof(int64_t) + 58 + (flies ? 12 : 0)) + 3 * sizeof(int32_t) * (64 * cells < places ? 64 * cells : places);
}

uint64_t world_carried_bytes(const struct world *world)
{
	uint64_t bytes = 0;
	for (size_t i = 0; i < world->body_count; i++)
		if (carries(world->bodies[i]) && (world->bodies[i]->kind != BODY_VEHICLE || world->params.carrying_count == 0)) /* those of vehicles are told before they are added */
			bytes += bytes_of(world, world->bodies[i]->object, world->bodies[i]->carried->fell != NULL);
	for (size_t i = 0; i < world->params.carrying_count; i++) {
		const struct scene_object object = {.shape = *world->params.aboard_shapes[i]};
		bytes += bytes_of(world, &object, scene_throws(world->scene));
	}
	return bytes;
}

void world_carried_plan(const struct world *world, struct plan *plan)
{
	const uint64_t bytes = world_carried_bytes(world);
	if (bytes > 0)
		plan_add(plan, &(struct plan_line){.kind = PLAN_BUFFER, .unit = PLAN_ONCE, .effect = scene_effect_row(EFFECT_CARRIED)->name, .object = -1, .amount = 1, .bytes = bytes}, "soil aboard bodies");
}

/* --- settling between contacts --- */

/* Orders bodies by place, so that their numbers do not show. */
static int by_place(const void *a, const void *b, void *user)
{
	struct body *const *bodies = user;
	const struct soil_pose *p = &bodies[*(const size_t *)a]->last, *q = &bodies[*(const size_t *)b]->last;
	const int64_t first[] = {p->y, p->x, p->z}, second[] = {q->y, q->x, q->z};
	for (int k = 0; k < 3; k++)
		if (first[k] != second[k])
			return first[k] < second[k] ? -1 : 1;
	return *(const size_t *)a < *(const size_t *)b ? -1 : 1;
}

static struct bearing_laden laden_of(const struct body *body)
{
	return (struct bearing_laden){body->carried, {&body->object->shape, body->last, body->loaded_body, false}};
}

/* Lists other bodies that may be below what falls from one. */
static size_t others_of(const struct world *world, const struct body *body, const size_t *order, size_t count, struct bearing_laden *others)
{
	const struct bearing_laden own = laden_of(body);
	const struct post_rect reach = bearing_carried_posts(world->bearing, own.carried, &own.rest);
	size_t found = 0;
	for (size_t i = 0; i < count; i++) {
		const struct body *other = world->bodies[order[i]];
		const struct bearing_laden laden = laden_of(other);
		if (other != body && !other->host.removed && other->has_last && !post_rect_empty(post_rect_intersect(reach, bearing_carried_posts(world->bearing, laden.carried, &laden.rest))))
			others[found++] = laden;
	}
	return found;
}

static enum status settle(struct world *world, struct body *body, double time, size_t rests, const struct bearing_laden *others, size_t other_count)
{
	const struct bearing_aboard how = {laden_of(body), drops(body), others, other_count, world->relaxation.rests, rests};
	const struct post_rect posts = bearing_carried_posts(world->bearing, body->carried, &how.body.rest);
	struct held_tiles held;
	struct post_rect changed;
	enum status status;
	if (post_rect_empty(posts))
		return STATUS_OK;
	TRY(world_hold(world, posts, &held));
	TRY_OR(done, bearing_carried_settle(world->bearing, &how, held.tiles, held.count, &changed));
	if (!post_rect_empty(changed))
		TRY_OR(done, world_mark(world, changed, &held));
	world_falls_take(world, body, &how.body.rest.pose, time);
done:
	world_release(world, &held);
	return status;
}

enum status world_carried_settle(struct world *world, double time, size_t rests)
{
	struct bearing_laden *others = NULL;
	size_t *order = NULL, count = 0;
	enum status status = STATUS_OK;
	if (!world_carries(world))
		return STATUS_OK;
	TRY_OR(done, mem_make(&order, world->body_count, sizeof *order, "soil aboard bodies"));
	TRY_OR(done, mem_make(&others, world->body_count, sizeof *others, "soil aboard bodies"));
	for (size_t i = 0; i < world->body_count; i++)
		if (carries(world->bodies[i]) && (world->bodies[i]->has_last || drops(world->bodies[i])) && !world->bodies[i]->elsewhere)
			order[count++] = i;
	if (count > 1)
		qsort_r(order, count, sizeof *order, by_place, world->bodies);
	for (size_t i = 0; i < count; i++) {
		struct body *body = world->bodies[order[i]];
		TRY_OR(done, settle(world, body, time, rests, others, others_of(world, body, order, count, others)));
	}
done:
	mem_free_all(order, others);
	return status;
}

/* --- the record, and checkpoints --- */

/* Returns how many numbers the record keeps of an object of the scene. Bodies that a host adds begin anew. */
static size_t numbers_of(const struct scene_object *object, double spacing)
{
	return object->carry ? soil_carried_numbers(&object->shape, spacing) : 0;
}

size_t world_carried_numbers(const struct world *world)
{
	size_t count = 0;
	for (size_t i = 0; i < world->scene->object_count; i++)
		count += numbers_of(&world->scene->objects[i], world->resident.spacing);
	for (size_t i = 0; i < world->params.carrying_count; i++)
		count += soil_carried_numbers(world->params.aboard_shapes[i], world->resident.spacing);
	return count;
}

/* Returns the body of a vehicle of the scene that carries, the first from number *at on, and moves *at behind it. NULL: there is none. A world whose scene has no vehicles
 * may have bodies of a host's model instead. These begin anew, and the record has no room for them. */
static struct body *next_aboard(const struct world *world, size_t *at)
{
	while (world->params.carrying_count > 0 && *at < world->body_count) {
		struct body *body = world->bodies[(*at)++];
		if (carries(body) && body->kind == BODY_VEHICLE)
			return body;
	}
	return NULL;
}

void world_carried_record(const struct world *world, struct record *record)
{
	int64_t *numbers = world_record_carried(record, world->scene->object_count);
	record->carried = world_carried_total(world);
	for (size_t i = 0; i < world->scene->object_count; i++) {
		const size_t count = numbers_of(&world->scene->objects[i], world->resident.spacing);
		record->objects[i].carried = count;
		if (count > 0)
			soil_carried_save(world->bodies[i]->carried, numbers);
		numbers += count;
	}
	size_t at = 0;
	for (const struct body *body = next_aboard(world, &at); body != NULL; body = next_aboard(world, &at)) {
		soil_carried_save(body->carried, numbers);
		numbers += soil_carried_numbers(&body->object->shape, world->resident.spacing);
	}
}

enum status world_carried_resume(struct world *world)
{
	struct record *record = world->record;
	const int64_t *numbers = world_record_carried(record, world->scene->object_count);
	for (size_t i = 0; i < world->scene->object_count; i++) {
		const size_t count = numbers_of(&world->scene->objects[i], world->resident.spacing);
		if (count > 0 && !soil_carried_load(numbers, world->bodies[i]->carried))
			return world_record_damaged(world->facts.path, "the soil aboard its bodies");
		if (count > 0 && record->objects[i].next > 0)
			soil_carried_place(world->bodies[i]->carried, &record->objects[i].last);
		numbers += count;
	}
	return STATUS_OK;
}

enum status world_carried_rejoin(struct world *world)
{
	const int64_t *numbers = world_record_carried(world->record, world->scene->object_count);
	for (size_t i = 0; i < world->scene->object_count; i++)
		numbers += world->record->objects[i].carried;
	size_t at = 0;
	for (const struct body *body = next_aboard(world, &at); body != NULL; body = next_aboard(world, &at)) {
		if (!soil_carried_load(numbers, body->carried))
			return world_record_damaged(world->facts.path, "the soil aboard its vehicles");
		if (body->host.placed)
			soil_carried_place(body->carried, &body->last);
		numbers += soil_carried_numbers(&body->object->shape, world->resident.spacing);
	}
	return STATUS_OK;
}

/* The soil aboard a body at a checkpoint. */
struct carried_saved {
	size_t body;
	struct soil_pose pose;
	bool placed;
	int64_t numbers[];
};

void world_carried_saved_free(struct carried_saved **saved, size_t count)
{
	for (size_t i = 0; i < count && saved != NULL; i++)
		mem_free(saved[i]);
	mem_free(saved);
}

enum status world_carried_save(const struct world *world, struct carried_saved ***out, size_t *count)
{
	struct carried_saved **saved = NULL;
	enum status status = STATUS_OK;
	*out = NULL;
	*count = 0;
	if (!world_carries(world))
		return STATUS_OK;
	TRY(mem_zeroed(&saved, world->body_count, sizeof *saved, "a checkpoint"));
	for (size_t i = 0; i < world->body_count; i++) {
		const struct body *body = world->bodies[i];
		if (!carries(body))
			continue;
		const size_t numbers = soil_carried_numbers(&body->object->shape, world->resident.spacing);
		TRY_OR(failed, mem_make(&saved[*count], 1, sizeof **saved + numbers * sizeof(int64_t), "a checkpoint"));
		const struct soil_carried *from = body->carried;
		*saved[*count] = (struct carried_saved){i, {.yaw = from->yaw, .pitch = from->pitch, .roll = from->roll, .turn = from->turn}, from->placed};
		soil_carried_save(from, saved[(*count)++]->numbers);
	}
	*out = saved;
	return STATUS_OK;
failed:
	world_carried_saved_free(saved, *count);
	*count = 0;
	return status;
}

void world_carried_restore(struct world *world, struct carried_saved *const *saved, size_t count)
{
	for (size_t i = 0; i < count; i++) {
		struct soil_carried *to = world->bodies[saved[i]->body]->carried;
		(void)soil_carried_load(saved[i]->numbers, to); /* it was saved by this world */
		if (saved[i]->placed)
			soil_carried_place(to, &saved[i]->pose);
		to->unsettled = saved[i]->numbers[1] != 0;
	}
}
