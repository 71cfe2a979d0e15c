/*
 * The forces of the soil on the objects, as they come from the GPU. They give the rows of objects.csv, and sinkage and
 * equilibrium height of loaded bodies.
 *
 * Each row is for a multiple of 1 / output.forces. An object's row is that of its latest path sample until then, at most one
 * post behind the object. It holds while the object is at rest. Only contacts that a row needs are summed.
 *
 * A model without forces gives rows of where its objects are and how deep. Nothing is asked of the GPU for them.
 *
 * Forces asked for in a step are used `delay` steps later, even if they came earlier. So the rows, and the part of them that a
 * commit keeps, do not depend on the GPU's speed. The thread waits for forces only if they have not come by then, and at a
 * commit.
 */
#include <assert.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "world/internal.h"

#define LOAD_DELAY 2 /* steps, if only loaded bodies need forces */

/* Identifies an object's latest path sample. */
struct standing {
	uint64_t tag; /* 0: it touches nothing, or no row needs it */
	struct soil_pose pose;
	bool placed;  /* it was set down once */
};

/* A row that waits for its forces. t < 0: not a row, but the height of a loaded body. */
struct entry {
	int64_t step; /* when it was asked for */
	double t;
	size_t object;
	struct standing at;
	bool ready;
	double slip;
	struct world_force force;
};

struct forces {
	struct world *world;
	double rate;
	int delay;
	int64_t row;                /* the next */
	uint64_t tag, tag_before;   /* the last; before this step */
	struct world_tags tags;     /* whose they are */
	struct standing *standing;  /* by object */
	struct world_force *known; /* the latest forces of each object, for known_tag */
	uint64_t *known_tag;
	struct entry *entries;      /* [first, count) wait, in order; [kept, first) were used before `delay` steps had passed */
	size_t kept, first, count, room;
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

bool world_asks_forces(const struct world *world)
{
	return world_feels(world) && (writes_rows(world) || world->scene->hosted);
}

static bool any_load(const struct scene *scene)
{
	for (size_t i = 0; i < scene->object_count; i++)
		if (scene->objects[i].load > 0)
			return true;
	return false;
}

enum status world_forces_create(struct world *world, struct forces **out)
{
	const struct scene *scene = world->scene;
	*out = NULL;
	if (!(world->scene->hosted && world_feels(world)) &&
	    ((scene->object_count == 0 && scene->vehicle_count == 0) || (!writes_rows(world) && !any_load(scene))))
		return STATUS_OK;
	struct forces *forces = mem_calloc(1, sizeof *forces);
	if (forces == NULL)
		return fail_memory("forces");
	forces->world = world;
	forces->rate = world->params.rows ? scene->forces : 0;
	forces->delay = world->bearing != NULL ? 0 : forces->rate > 0 ? scene->forces_delay : LOAD_DELAY;
	forces->standing = mem_calloc(scene->object_count + 1, sizeof *forces->standing);
	forces->known = mem_calloc(scene->object_count + 1, sizeof *forces->known);
	forces->known_tag = mem_calloc(scene->object_count + 1, sizeof *forces->known_tag);
	*out = forces;
	if (forces->standing == NULL || forces->known == NULL || forces->known_tag == NULL)
		return fail_memory("forces");
	for (size_t i = 0; world->resumed.is && i < scene->object_count; i++) {
		const struct record_object *object = &world->record->objects[i];
		if (object->next == 0)
			continue;
		forces->standing[i] = (struct standing){object->in_contact ? 1 : 0, object->last, true};
		struct track_point point;
		motion_track_sample(world->bodies[i].track, object->next - 1, &point);
		forces->standing[i].pose.x = point.qx;
		forces->standing[i].pose.y = point.qy;
		forces->known[i] = object->force;
		forces->known_tag[i] = 1;
	}
	forces->tag = forces->tag_before = 1; /* 1: rows from before the drive was resumed */
	/* The first step gives the rows of time 0. */
	while (world->resumed.is && world->record->step > 0 && (double)forces->row <= world->record->time * forces->rate && forces->rate > 0 &&
	       (double)forces->row / forces->rate <= world->record->time)
		forces->row++;
	return STATUS_OK;
}

void world_forces_destroy(struct forces *forces)
{
	if (forces == NULL)
		return;
	world_tags_free(&forces->tags);
	mem_free(forces->standing);
	mem_free(forces->known);
	mem_free(forces->known_tag);
	mem_free(forces->entries);
	mem_free(forces);
}

/* --- asking --- */

static enum status add_entry(struct forces *forces, const struct entry *entry)
{
	if (forces->kept > 0 && forces->count == forces->room) {
		forces->count -= forces->kept;
		memmove(forces->entries, forces->entries + forces->kept, forces->count * sizeof *forces->entries);
		forces->first -= forces->kept;
		forces->kept = 0;
	}
	if (forces->count == forces->room) {
		size_t room = forces->room != 0 ? 2 * forces->room : 64;
		struct entry *entries = mem_realloc(forces->entries, room, sizeof *entries);
		if (entries == NULL)
			return fail_memory("forces");
		forces->entries = entries;
		forces->room = room;
	}
	struct entry *added = &forces->entries[forces->count++];
	*added = *entry;
	if (entry->ready) /* of a quiet body */
		return STATUS_OK;
	size_t i = entry->object;
	const bool feels = world_feels(forces->world);
	added->slip = forces->world->scene->objects[i].slip;
	added->ready = entry->at.tag == 0 || forces->known_tag[i] == entry->at.tag;
	if (added->ready && (entry->at.tag != 0 || !feels))
		added->force = forces->known[i];
	else if (added->ready)
		added->force = world_no_force(entry->at.pose.z);
	return STATUS_OK;
}

/* Adds the rows of quiet bodies, whose forces are known. */
static enum status add_quiet(struct forces *forces, double t)
{
	const struct world *world = forces->world;
	enum status status = STATUS_OK;
	for (size_t i = 0; i < world->hosts.count && status == STATUS_OK; i++) {
		const struct host_body *host = world->hosts.list[i];
		if (host != NULL && host->quiet && host->placed && !host->body.elsewhere)
			status = add_entry(forces, &(struct entry){.step = world->step, .t = t, .object = world->scene->object_count + 1 + i,
						   .at = {0, host->shown, true}, .ready = true, .slip = host->slip, .force = host->force});
	}
	return status;
}

enum status world_forces_rows(struct forces *forces, double until, bool inclusive)
{
	if (forces == NULL || forces->rate == 0)
		return STATUS_OK;
	enum status status = STATUS_OK;
	for (;; forces->row++) {
		double t = (double)forces->row / forces->rate;
		if (t > until || (!inclusive && t == until))
			return status;
		for (size_t i = 0; i < forces->world->scene->object_count && status == STATUS_OK; i++)
			if (forces->standing[i].placed && !forces->world->bodies[i].elsewhere)
				status = add_entry(forces, &(struct entry){.step = forces->world->step, .t = t, .object = i, .at = forces->standing[i]});
		if (status == STATUS_OK)
			status = add_quiet(forces, t);
		if (status != STATUS_OK)
			return status;
	}
}

/* Gives a new tag for forces on this body. */
static uint64_t new_tag(struct forces *forces, size_t body)
{
	world_tags_add(&forces->tags, ++forces->tag, body);
	return forces->tag;
}

uint64_t world_forces_ask(struct forces *forces, size_t object, const struct event *event, bool last_in_step)
{
	if (forces == NULL)
		return 0;
	if (world_is_hosts(forces->world, object)) {
		if (world_is_quiet(forces->world, object) || !world_feels(forces->world))
			return 0;
		const uint64_t tag = last_in_step ? new_tag(forces, object) : 0;
		if (last_in_step)
			world_host_asked(forces->world, object, tag, event);
		return tag;
	}
	if (object == forces->world->scene->object_count) /* bodies that a window drops have no rows */
		return 0;
	const struct body *body = &forces->world->bodies[object];
	bool asked = last_in_step && (body->object->load > 0 || forces->world->scene->hosted);
	if (forces->rate > 0) {
		/* The next row, and whether this path sample gives it. */
		double row = (double)forces->row / forces->rate;
		asked = asked || event->next_time > row;
	}
	const bool feels = world_feels(forces->world);
	struct standing *standing = &forces->standing[object];
	if (!feels)
		forces->known[object] = (struct world_force){.sinkage = fmax(event->sinkage, 0), .z = event->pose.z,
							     .state = event->sinkage > 0 ? DEFORM_TOUCHING : DEFORM_AIR};
	*standing = (struct standing){asked && feels ? new_tag(forces, object) : 0, event->pose, true};
	return standing->tag;
}

void world_forces_absent(struct forces *forces, size_t object, const struct event *event)
{
	if (forces == NULL)
		return;
	if (world_is_hosts(forces->world, object)) {
		world_host_absent(forces->world, object);
		return;
	}
	if (object == forces->world->scene->object_count)
		return;
	struct standing *standing = &forces->standing[object];
	struct soil_pose pose = event->pose;
	if (!event->contact)
		pose.z = standing->pose.z; /* there is no ground */
	if (event->contact || !world_feels(forces->world)) /* in the air above it; the record has the same */
		forces->known[object] = world_no_force(pose.z);
	*standing = (struct standing){0, pose, true};
}

/* --- using --- */

static void arrived(struct forces *forces, const struct deform_forces *from)
{
	struct world_force force = {.sinkage = from->sinkage, .area = from->area, .z = from->z, .state = from->state, .residual = from->residual,
				    .pull = from->pull};
	memcpy(force.force, from->force, sizeof force.force);
	memcpy(force.moment, from->moment, sizeof force.moment);
	forces->saturated += from->saturated;
	const size_t objects = forces->world->scene->object_count;
	size_t body = SIZE_MAX;
	const bool found = world_tags_find(&forces->tags, from->tag, &body);
	for (size_t i = found ? body : 0; i < objects && (!found || i == body); i++)
		if (forces->standing[i].tag == from->tag) {
			forces->known[i] = force;
			forces->known_tag[i] = from->tag;
		}
	if (!found || body >= objects)
		world_host_arrived(forces->world, from->tag, body, &force);
	for (size_t i = forces->first; i < forces->count; i++)
		if (forces->entries[i].at.tag == from->tag) {
			forces->entries[i].force = force;
			forces->entries[i].ready = true;
		}
}

void world_forces_came(struct forces *forces, const struct deform_forces *from)
{
	if (forces != NULL && from->tag != 0)
		arrived(forces, from);
}

static enum status give_row(const struct forces *forces, const struct entry *entry)
{
	const struct world_rows *rows = forces->world->rows;
	const struct soil_pose *pose = &entry->at.pose;
	struct world_row row = {
		.time = entry->t,
		.body = entry->object,
		.object = world_body_at(forces->world, entry->object)->object,
		.slip = entry->slip,
		.position = {lattice_offset_metres(pose->x), lattice_offset_metres(pose->y), lattice_offset_metres(entry->force.z)},
		.force = entry->force,
	};
	if (!world_feels(forces->world)) {
		for (int i = 0; i < 3; i++)
			row.force.force[i] = row.force.moment[i] = (double)NAN;
		row.force.area = row.force.residual = (double)NAN;
	}
	enum status status = world_soil_at(forces->world, row.position[0], row.position[1], &row.soil);
	return status == STATUS_OK ? rows->row(rows->user, &row) : status;
}

static void count_failed(const struct scene *scene, const struct entry *entry, struct body_failed *failed)
{
	if (failed->steps++ == 0) {
		failed->time = world_step_time(scene, entry->step + 1);
		failed->x = lattice_offset_metres(entry->at.pose.x);
		failed->y = lattice_offset_metres(entry->at.pose.y);
	}
}

/* Uses the entries of all steps until `step`, in order. Waits for forces that have not come. */
static enum status use(struct forces *forces, int64_t step)
{
	enum status status = STATUS_OK;
	for (; forces->first < forces->count && forces->entries[forces->first].step <= step; forces->first++) {
		struct entry *entry = &forces->entries[forces->first];
		while (!entry->ready) {
			struct deform_forces came;
			bool taken;
			status = deform_forces_take(forces->world->deform, true, &came, &taken);
			if (status != STATUS_OK)
				return status;
			assert(taken);
			arrived(forces, &came);
		}
		if (entry->t >= 0) {
			status = give_row(forces, entry);
		} else {
			struct body *body = &forces->world->bodies[entry->object];
			body->near += entry->force.area > 0;
			body->sinkage = entry->force.sinkage;
			body->equilibrium = entry->force.z;
			body->raised = entry->force.z - entry->at.pose.z;
			if (entry->force.state == DEFORM_SUNK)
				count_failed(forces->world->scene, entry, &body->sunk);
			if (entry->force.state == DEFORM_SLIDES)
				count_failed(forces->world->scene, entry, &body->slid);
		}
		if (status != STATUS_OK)
			return status;
	}
	const struct world_rows *rows = forces->world->rows;
	return rows != NULL ? rows->flush(rows->user) : STATUS_OK;
}

/* Takes what was known `delay` steps ago. world_forces_settle may have used it earlier. */
static void look_back(struct forces *forces, int64_t step)
{
	for (; forces->kept < forces->first && forces->entries[forces->kept].step <= step; forces->kept++) {
		const struct entry *entry = &forces->entries[forces->kept];
		if (entry->t < 0)
			forces->world->bodies[entry->object].sinkage_before = entry->force.sinkage;
	}
}

enum status world_forces_end_step(struct forces *forces, double until)
{
	if (forces == NULL)
		return STATUS_OK;
	const struct scene *scene = forces->world->scene;
	enum status status = world_forces_rows(forces, until, true);
	for (size_t i = 0; i < scene->object_count && status == STATUS_OK; i++)
		if (scene->objects[i].load > 0 && forces->standing[i].tag > forces->tag_before)
			status = add_entry(forces, &(struct entry){.step = forces->world->step, .t = -1, .object = i, .at = forces->standing[i]});
	forces->tag_before = forces->tag;
	if (status == STATUS_OK && forces->world->deform != NULL)
		status = deform_forces_begin(forces->world->deform);
	if (status == STATUS_OK)
		status = use(forces, forces->world->step - forces->delay);
	look_back(forces, forces->world->step - forces->delay);
	return status;
}

enum status world_forces_settle(struct forces *forces, struct record *record)
{
	if (forces == NULL)
		return STATUS_OK;
	/* Also forces for a row of a later step. */
	enum status status = world_forces_wait(forces);
	if (status == STATUS_OK)
		status = use(forces, INT64_MAX);
	for (size_t i = 0; i < forces->world->scene->object_count; i++) {
		if (forces->world->bodies[i].elsewhere)
			continue;
		record->objects[i].force = forces->known[i];
		record->objects[i].sinkage = forces->world->bodies[i].sinkage;
	}
	return status;
}

enum status world_forces_wait(struct forces *forces)
{
	bool taken = forces != NULL && forces->world->deform != NULL;
	enum status status = STATUS_OK;
	while (taken && status == STATUS_OK) {
		struct deform_forces came;
		status = deform_forces_take(forces->world->deform, true, &came, &taken);
		if (status == STATUS_OK && taken)
			arrived(forces, &came);
	}
	return status;
}

void world_forces_pack(const struct forces *forces, size_t body, struct world_moved *moved)
{
	if (forces == NULL)
		return;
	const struct standing *standing = &forces->standing[body];
	moved->shown = standing->pose;
	moved->placed = standing->placed;
	moved->felt = standing->tag != 0;
	moved->force = forces->known[body];
}

/* As for a run that is resumed: what came has the tag 1. */
void world_forces_unpack(struct forces *forces, size_t body, const struct world_moved *moved)
{
	if (forces == NULL)
		return;
	forces->standing[body] = (struct standing){moved->felt ? 1 : 0, moved->shown, moved->placed};
	forces->known[body] = moved->force;
	forces->known_tag[body] = 1;
}

bool world_forces_known(const struct forces *forces, size_t body, struct world_force *force)
{
	if (forces == NULL || !forces->standing[body].placed)
		return false;
	const bool feels = world_feels(forces->world);
	if (feels && forces->standing[body].tag == 0) { /* it touches nothing */
		*force = world_no_force(0);
		return true;
	}
	*force = forces->known[body];
	return !feels || forces->known_tag[body] == forces->standing[body].tag;
}

struct forces_saved {
	int64_t row;
	struct standing *standing;
	struct world_force *known;
	uint64_t *known_tag;
	uint64_t saturated;
};

void world_forces_saved_free(struct forces_saved *saved)
{
	if (saved == NULL)
		return;
	mem_free(saved->standing);
	mem_free(saved->known);
	mem_free(saved->known_tag);
	mem_free(saved);
}

enum status world_forces_save(const struct forces *forces, struct forces_saved **out)
{
	*out = NULL;
	if (forces == NULL)
		return STATUS_OK;
	assert(forces->first == forces->count);
	const size_t count = forces->world->scene->object_count;
	struct forces_saved *saved = mem_calloc(1, sizeof *saved);
	if (saved == NULL)
		return fail_memory("a checkpoint");
	*saved = (struct forces_saved){
		.row = forces->row,
		.standing = mem_alloc(count + 1, sizeof *saved->standing),
		.known = mem_alloc(count + 1, sizeof *saved->known),
		.known_tag = mem_alloc(count + 1, sizeof *saved->known_tag),
		.saturated = forces->saturated,
	};
	if (saved->standing == NULL || saved->known == NULL || saved->known_tag == NULL) {
		world_forces_saved_free(saved);
		return fail_memory("a checkpoint");
	}
	memcpy(saved->standing, forces->standing, count * sizeof *saved->standing);
	memcpy(saved->known, forces->known, count * sizeof *saved->known);
	memcpy(saved->known_tag, forces->known_tag, count * sizeof *saved->known_tag);
	*out = saved;
	return STATUS_OK;
}

/* Tags are not set back: none is used twice. */
void world_forces_restore(struct forces *forces, const struct forces_saved *saved)
{
	if (forces == NULL)
		return;
	const size_t count = forces->world->scene->object_count;
	forces->row = saved->row;
	forces->saturated = saved->saturated;
	forces->first = forces->count = 0;
	forces->tag_before = forces->tag;
	memcpy(forces->standing, saved->standing, count * sizeof *saved->standing);
	memcpy(forces->known, saved->known, count * sizeof *saved->known);
	memcpy(forces->known_tag, saved->known_tag, count * sizeof *saved->known_tag);
}

void world_forces_figures(const struct forces *forces, struct world_forces_figures *figures)
{
	*figures = (struct world_forces_figures){forces->saturated};
}

enum status world_settle_forces(struct world *world)
{
	return world_forces_settle(world->forces, world->record);
}
