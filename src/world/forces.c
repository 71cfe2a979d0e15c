/*
 * The forces of the soil on bodies with paths, and the rows of objects.csv. A contact tells its forces at once.
 *
 * Each row is for a multiple of 1 / output.forces. An object's row is that of its latest path sample until then, at most one
 * post behind the object. It holds while the object is at rest. A step's rows are given at its end, in order. So a step that fails half-way gives none.
 *
 * A model without forces gives rows of where its objects are and how deep.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "world/internal.h"

/* An object's latest path sample. */
struct standing {
	struct soil_pose pose;
	struct world_force force; /* the latest that is known */
	bool placed;  /* it was set down once */
	bool felt;    /* the soil was asked for the force; false: it touches nothing */
	bool met;     /* in this step */
};

/* A row that waits for the end of the step. */
struct entry {
	double t;
	size_t object;
	struct soil_pose pose;
	double slip;
	struct world_force force;
	struct world_aboard aboard;
};

struct forces {
	struct world *world;
	double rate;
	int64_t row;                /* the next */
	int64_t early;              /* rows of objects before this one are there already: world_forces_early */
	struct standing *standing;  /* by object */
	struct entry *entries;
	size_t count, room;
	uint64_t saturated;         /* posts */
};

bool world_feels(const struct world *world)
{
	return deform_tells_forces(world->scene->model);
}

static bool writes_rows(const struct world *world)
{
	return world->scene->forces > 0 && world->params.rows;
}

static bool any_load(const struct scene *scene)
{
	for (size_t i = 0; i < scene->object_count; i++)
		if (scene->objects[i].load > 0)
			return true;
	return false;
}

static bool is_needed(const struct world *world)
{
	const struct scene *scene = world->scene;
	return (scene->hosted && world_feels(world)) || ((scene->object_count > 0 || scene->vehicle_count > 0) && (writes_rows(world) || any_load(scene)));
}

enum status world_forces_create(struct world *world, struct forces **out)
{
	const struct scene *scene = world->scene;
	*out = NULL;
	if (!is_needed(world))
		return STATUS_OK;
	struct forces *forces = mem_calloc(1, sizeof *forces);
	TRY_MEM(forces, "forces");
	forces->world = world;
	forces->rate = world->params.rows ? scene->forces : 0;
	forces->standing = mem_calloc(scene->object_count + 1, sizeof *forces->standing);
	*out = forces;
	TRY_MEM(forces->standing, "forces");
	for (size_t i = 0; world->facts.resumed.is && i < scene->object_count; i++) {
		const struct record_object *object = &world->record->objects[i];
		if (object->next == 0)
			continue;
		struct track_point point;
		motion_track_sample(world->bodies[i]->track, object->next - 1, &point);
		forces->standing[i] = (struct standing){.pose = object->last, .force = object->force, .placed = true, .felt = object->has_last};
		forces->standing[i].pose.x = point.qx;
		forces->standing[i].pose.y = point.qy;
	}
	/* The first step gives the rows of time 0. */
	while (world->facts.resumed.is && world->record->step > 0 && (double)forces->row <= world->record->time * forces->rate && forces->rate > 0 &&
	       (double)forces->row / forces->rate <= world->record->time)
		forces->row++;
	return STATUS_OK;
}

void world_forces_destroy(struct forces *forces)
{
	if (forces == NULL)
		return;
	mem_free_all(forces->standing, forces->entries, forces);
}

/* --- what contacts tell --- */

/* Returns the place in `standing` of a body with a path; NULL: the body has none. */
static struct standing *standing_of(const struct forces *forces, size_t body)
{
	return forces != NULL && world_follows_path(forces->world, body) ? &forces->standing[body] : NULL;
}

static struct world_force force_of(const struct deform_forces *from)
{
	struct world_force force = {.sinkage = from->sinkage, .area = from->area, .z = from->z, .state = from->state, .residual = from->residual,
				    .pull = from->pull};
	memcpy(force.force, from->force, sizeof force.force);
	memcpy(force.moment, from->moment, sizeof force.moment);
	return force;
}

/* Takes the next path sample of a body. One that carries soil does work from a sample to the next if the soil bears it at both. */
static void stand(const struct forces *forces, size_t body, struct standing next)
{
	struct standing *standing = &forces->standing[body];
	next.force.work = standing->force.work;
	if (forces->world->bodies[body]->carried != NULL && standing->felt && next.felt)
		next.force.work += world_work_between(&standing->pose, &standing->force, &next.pose, &next.force);
	*standing = next;
}

void world_forces_felt(struct forces *forces, size_t body, const struct event *event, const struct deform_forces *from)
{
	if (forces == NULL)
		return;
	const struct world_force force = force_of(from);
	struct standing *standing = standing_of(forces, body);
	forces->saturated += from->saturated;
	if (standing != NULL)
		stand(forces, body, (struct standing){event->pose, force, true, true, true});
	else if (world_body(forces->world, body)->kind == BODY_HOST)
		world_host_felt(forces->world, body, event->time, &force);
}

void world_forces_met(struct forces *forces, size_t body, const struct event *event)
{
	struct standing *standing = standing_of(forces, body);
	if (standing == NULL)
		return;
	const struct world_force force = {.sinkage = fmax(event->sinkage, 0), .z = event->pose.z, .state = event->sinkage > 0 ? DEFORM_TOUCHING : DEFORM_AIR};
	*standing = (struct standing){event->pose, force, true, false, true};
}

void world_forces_absent(struct forces *forces, size_t body, const struct event *event)
{
	if (forces == NULL)
		return;
	if (world_is_hosted(world_body(forces->world, body))) {
		world_host_absent(forces->world, body);
		return;
	}
	struct standing *standing = standing_of(forces, body);
	if (standing == NULL)
		return;
	struct standing next = {.pose = event->pose, .force = standing->force, .placed = true};
	next.pose.z = event->contact ? event->pose.z : standing->pose.z; /* there may be no ground */
	if (event->contact || !world_feels(forces->world)) /* in the air above it; the record has the same */
		next.force = world_no_force(next.pose.z);
	stand(forces, body, next);
}

bool world_forces_known(const struct forces *forces, size_t body, struct world_force *force)
{
	const struct standing *standing = standing_of(forces, body);
	if (standing == NULL || !standing->placed)
		return false;
	*force = world_feels(forces->world) && !standing->felt ? world_no_force(0) : standing->force;
	return true;
}

void world_forces_record(const struct forces *forces, size_t body, struct world_force *force)
{
	const struct standing *standing = standing_of(forces, body);
	if (standing != NULL && !forces->world->bodies[body]->elsewhere)
		*force = standing->force;
}

/* --- rows --- */

static enum status add_entry(struct forces *forces, const struct entry *entry)
{
	TRY(mem_grow(&forces->entries, &forces->room, forces->count + 1, sizeof *forces->entries, "forces"));
	forces->entries[forces->count++] = *entry;
	return STATUS_OK;
}

/* Adds the weight of what a body carries. */
static struct world_force with_load(const struct world *world, const struct body *body, struct world_force force)
{
	world_carried_force(world, body, force.force, force.moment);
	return force;
}

/* Adds the rows of bodies of vehicles. */
static enum status add_vehicles(struct forces *forces, double t)
{
	const struct world *world = forces->world;
	for (size_t i = 0; i < world->body_count; i++) {
		const struct body *body = world->bodies[i];
		if (body != NULL && body->kind == BODY_VEHICLE && body->host.placed && !body->elsewhere)
			TRY(add_entry(forces, &(struct entry){t, i, body->host.shown, body->host.slip, with_load(world, body, body->host.force), world_aboard_of(world, body)}));
	}
	return STATUS_OK;
}

/* Adds the rows of objects on this rank. */
static enum status add_objects(struct forces *forces, double t)
{
	const struct world *world = forces->world;
	const bool feels = world_feels(world);
	for (size_t i = 0; i < world->scene->object_count; i++) {
		const struct standing *at = &forces->standing[i];
		struct world_force force = feels && !at->felt ? world_no_force(at->pose.z) : at->force;
		force.work = at->force.work;
		if (at->placed && !world->bodies[i]->elsewhere)
			TRY(add_entry(forces, &(struct entry){t, i, at->pose, world->scene->objects[i].slip, with_load(world, world->bodies[i], force), world_aboard_of(world, world->bodies[i])}));
	}
	return STATUS_OK;
}

enum status world_forces_rows(struct forces *forces, double until, bool inclusive)
{
	if (forces == NULL || forces->rate == 0)
		return STATUS_OK;
	for (; ; forces->row++) {
		double t = (double)forces->row / forces->rate;
		if (t > until || (!inclusive && t == until))
			return STATUS_OK;
		if (forces->row >= forces->early)
			TRY(add_objects(forces, t));
		TRY(add_vehicles(forces, t));
	}
}

enum status world_forces_early(struct forces *forces, double until)
{
	if (forces == NULL || forces->rate == 0)
		return STATUS_OK;
	forces->early = forces->early > forces->row ? forces->early : forces->row;
	for (double t; (t = (double)forces->early / forces->rate) < until; forces->early++)
		TRY(add_objects(forces, t));
	return STATUS_OK;
}

/* The order in which world_forces_rows adds them. */
static int by_time(const void *a, const void *b)
{
	const struct entry *x = a, *y = b;
	if (x->t != y->t)
		return x->t < y->t ? -1 : 1;
	return (x->object > y->object) - (x->object < y->object);
}

static enum status give_row(struct forces *forces, const struct entry *entry)
{
	struct world *world = forces->world;
	const struct soil_pose *pose = &entry->pose;
	TRY(mem_grow(&world->rows.list, &world->rows.room, world->rows.count + 1, sizeof *world->rows.list, "rows"));
	struct world_row row = {
		.time = entry->t,
		.body = entry->object,
		.object = world_body_at(world, entry->object)->object,
		.slip = entry->slip,
		.position = {lattice_offset_metres(pose->x), lattice_offset_metres(pose->y), lattice_offset_metres(entry->force.z)},
		.force = entry->force,
		.aboard = entry->aboard,
	};
	if (!world_feels(world)) {
		for (int i = 0; i < 3; i++)
			row.force.force[i] = row.force.moment[i] = (double)NAN;
		row.force.area = row.force.residual = (double)NAN;
	}
	TRY(world_soil_at(world, row.position[0], row.position[1], &row.soil));
	world->rows.list[world->rows.count++] = row;
	return STATUS_OK;
}

const struct world_row *world_rows(const struct world *world, size_t *count)
{
	*count = world->rows.count;
	return world->rows.list;
}

void world_rows_clear(struct world *world)
{
	world->rows.count = 0;
}

/* --- the end of a step --- */

static void count_failed(const struct forces *forces, const struct standing *standing, struct body_failed *failed)
{
	if (failed->steps++ == 0) {
		failed->time = world_step_time(forces->world->scene, forces->world->step + 1);
		failed->x = lattice_offset_metres(standing->pose.x);
		failed->y = lattice_offset_metres(standing->pose.y);
	}
}

/* Takes sinkage and equilibrium height of a body with a load that had a contact in this step. */
static void settle(const struct forces *forces, size_t object)
{
	const struct standing *standing = &forces->standing[object];
	struct body *body = forces->world->bodies[object];
	body->near += standing->force.area > 0;
	body->sinkage = standing->force.sinkage;
	body->equilibrium = standing->force.z;
	body->raised = standing->force.z - standing->pose.z;
	if (standing->force.state == DEFORM_SUNK)
		count_failed(forces, standing, &body->sunk);
	if (standing->force.state == DEFORM_SLIDES)
		count_failed(forces, standing, &body->slid);
}

enum status world_forces_end_step(struct forces *forces, double until)
{
	if (forces == NULL)
		return STATUS_OK;
	const struct scene *scene = forces->world->scene;
	const size_t before = forces->world->rows.count;
	const bool early = forces->early > forces->row;
	enum status status = world_forces_rows(forces, until, true);
	if (early && forces->count > 0)
		qsort(forces->entries, forces->count, sizeof *forces->entries, by_time);
	for (size_t i = 0; i < forces->count && status == STATUS_OK; i++)
		status = give_row(forces, &forces->entries[i]);
	if (status != STATUS_OK)
		forces->world->rows.count = before;
	forces->count = 0;
	for (size_t i = 0; i < scene->object_count; i++) {
		if (scene->objects[i].load > 0 && forces->standing[i].felt && forces->standing[i].met)
			settle(forces, i);
		forces->standing[i].met = false;
	}
	return status;
}

/* --- other ranks, checkpoints --- */

void world_forces_pack(const struct forces *forces, size_t body, struct world_moved *moved)
{
	const struct standing *standing = standing_of(forces, body);
	if (standing == NULL)
		return;
	moved->shown = standing->pose;
	moved->placed = standing->placed;
	moved->felt = standing->felt;
	moved->force = standing->force;
}

void world_forces_unpack(struct forces *forces, size_t body, const struct world_moved *moved)
{
	struct standing *standing = standing_of(forces, body);
	if (standing != NULL)
		*standing = (struct standing){moved->shown, moved->force, moved->placed, moved->felt, false};
}

struct forces_saved {
	int64_t row;
	struct standing *standing;
	uint64_t saturated;
};

void world_forces_saved_free(struct forces_saved *saved)
{
	if (saved == NULL)
		return;
	mem_free_all(saved->standing, saved);
}

enum status world_forces_save(const struct forces *forces, struct forces_saved **out)
{
	*out = NULL;
	if (forces == NULL)
		return STATUS_OK;
	const size_t count = forces->world->scene->object_count;
	struct forces_saved *saved = mem_calloc(1, sizeof *saved);
	TRY_MEM(saved, "a checkpoint");
	*saved = (struct forces_saved){forces->row, mem_alloc(count + 1, sizeof *saved->standing), forces->saturated};
	if (saved->standing == NULL) {
		world_forces_saved_free(saved);
		return fail_memory("a checkpoint");
	}
	memcpy(saved->standing, forces->standing, count * sizeof *saved->standing);
	*out = saved;
	return STATUS_OK;
}

void world_forces_restore(struct forces *forces, const struct forces_saved *saved)
{
	if (forces == NULL)
		return;
	forces->row = saved->row;
	forces->early = 0;
	forces->saturated = saved->saturated;
	forces->count = 0;
	memcpy(forces->standing, saved->standing, forces->world->scene->object_count * sizeof *saved->standing);
}

bool world_forces_figures(const struct world *world, struct world_forces_figures *figures)
{
	if (world->forces != NULL)
		*figures = (struct world_forces_figures){world->forces->saturated};
	return world->forces != NULL;
}
