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

enum status world_carried_make(struct world *world, struct body *body)
{
	if (!body->object->carry)
		return STATUS_OK;
	if (world->ranks != NULL)
		return fail_with(STATUS_INPUT, "%s: carry: soil aboard a body does not go from rank to rank; drive with one process, or take carry away", body->object->name);
	return soil_carried_create(&body->object->shape, world->resident.spacing, &body->carried);
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
		unsettled = carries(world->bodies[i]) && ((world->bodies[i]->carried->unsettled && world->bodies[i]->has_last) || drops(world->bodies[i]));
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
	bool any = false;
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

double world_carried_load(const struct world *world, const struct body *body)
{
	double force[3] = {0}, moment[3];
	memset(moment, 0, sizeof moment);
	world_carried_force(world, body, force, moment);
	return -force[2];
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

void world_carried_plan(const struct world *world, struct plan *plan)
{
	uint64_t bytes = 0;
	for (size_t i = 0; i < world->scene->object_count; i++)
		if (world->scene->objects[i].carry) /* two numbers of a record for each cell; seven of its own, with the envelope's scratch memory */
			bytes += soil_carried_numbers(&world->scene->objects[i].shape, world->resident.spacing) * (sizeof(int64_t) + 18);
	if (bytes > 0)
		plan_add(plan, &(struct plan_line){.kind = PLAN_BUFFER, .unit = PLAN_ONCE, .effect = "scm", .object = -1, .amount = 1, .bytes = bytes}, "soil aboard bodies");
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

static enum status settle(struct world *world, struct body *body, size_t rests)
{
	const struct deform_rest rest = {&body->object->shape, body->last, body->loaded_body, false};
	const struct post_rect posts = bearing_carried_posts(world->bearing, body->carried, &rest);
	struct held_tiles held;
	struct post_rect changed;
	enum status status;
	if (post_rect_empty(posts))
		return STATUS_OK;
	TRY(world_hold(world, posts, &held));
	TRY_OR(done, bearing_carried_settle(world->bearing, body->carried, &rest, drops(body), world->relaxation.rests, rests, held.tiles, held.count, &changed));
	if (!post_rect_empty(changed))
		TRY_OR(done, world_mark(world, changed, &held));
done:
	world_release(world, &held);
	return status;
}

enum status world_carried_settle(struct world *world, size_t rests)
{
	size_t *order, count = 0;
	enum status status = STATUS_OK;
	if (!world_carries(world))
		return STATUS_OK;
	TRY(mem_make(&order, world->body_count, sizeof *order, "soil aboard bodies"));
	for (size_t i = 0; i < world->body_count; i++)
		if (carries(world->bodies[i]) && (world->bodies[i]->has_last || drops(world->bodies[i])) && !world->bodies[i]->elsewhere)
			order[count++] = i;
	if (count > 1)
		qsort_r(order, count, sizeof *order, by_place, world->bodies);
	for (size_t i = 0; i < count; i++)
		TRY_OR(done, settle(world, world->bodies[order[i]], rests));
done:
	mem_free(order);
	return status;
}

/* --- the record, and checkpoints --- */

/* Returns how many numbers the record keeps of an object of the scene. A host's bodies begin anew. */
static size_t numbers_of(const struct scene_object *object, double spacing)
{
	return object->carry && object->path.count > 0 ? soil_carried_numbers(&object->shape, spacing) : 0;
}

size_t world_carried_numbers(const struct world *world)
{
	size_t count = 0;
	for (size_t i = 0; i < world->scene->object_count; i++)
		count += numbers_of(&world->scene->objects[i], world->resident.spacing);
	return count;
}

void world_carried_record(const struct world *world, struct record *record)
{
	int64_t *numbers = world_record_carried(record, world->scene->object_count);
	for (size_t i = 0; i < world->scene->object_count; i++) {
		const size_t count = numbers_of(&world->scene->objects[i], world->resident.spacing);
		record->objects[i].carried = count;
		if (count > 0)
			soil_carried_save(world->bodies[i]->carried, numbers);
		numbers += count;
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
