/* Collects the path samples that are due in a step, in the order of time, then of the scene's objects. */
#include <math.h>
#include <stdlib.h>

#include "world/internal.h"

#define EVENTS_MAX 1000000

static enum status add_event(struct world *world, const struct event *event)
{
	if (world->events.count == EVENTS_MAX)
		return fail_with(STATUS_INPUT, "time_step: a step of %g s brings more than %d path samples; make it shorter, or the "
					       "spacing coarser",
				 world->scene->time_step, EVENTS_MAX);
	TRY(mem_grow(&world->events.list, &world->events.room, world->events.count + 1, sizeof *world->events.list, "the path samples of a step"));
	world->events.list[world->events.count++] = *event;
	return STATUS_OK;
}

enum status world_set_down(struct world *world, struct body *body, int64_t sample, struct event *event)
{
	struct track_point point;
	motion_track_sample(body->track, sample, &point);
	event->next_time = sample + 1 < motion_track_samples(body->track) ? motion_track_sample_time(body->track, sample + 1) : INFINITY;
	event->pose = (struct soil_pose){
		.x = point.qx,
		.y = point.qy,
		.yaw = point.yaw,
		.pitch = point.pitch,
		.roll = point.roll,
	};
	int64_t ground;
	TRY(resident_ground_height(world->resident.ground, event->pose.x, event->pose.y, &ground, &event->contact));
	if (!event->contact && world->scene->outside == SCENE_STOP)
		return world_no_ground(world, body->object->name, body->object->path.degrees, point.x, point.y, point.time);
	if (!event->contact)
		return STATUS_OK;
	double reach = soil_shape_reach(&body->object->shape, point.pitch, point.roll);
	const bool carried = body->object->load > 0 && (world_feels(world) || !body->object->path.has_z);
	/* A body that the soil carries follows the ground from sample to sample. Contacts add the equilibrium height to both poses. */
	if (body->object->path.has_z && !carried)
		event->pose.z = lattice_offset(point.z);
	else
		event->pose.z = ground + lattice_offset(reach - scene_sinkage_guess(world->scene, body->object));
	event->sinkage = lattice_offset_metres(ground - event->pose.z) + reach;
	if (sample > 0) {
		struct track_point before;
		motion_track_sample(body->track, sample - 1, &before);
		event->distance = hypot(point.x - before.x, point.y - before.y);
		event->seconds = point.time - before.time;
	}
	return STATUS_OK;
}

static int compare(const void *a, const void *b)
{
	const struct event *first = a, *second = b;
	if (first->time != second->time)
		return first->time < second->time ? -1 : 1;
	return first->body < second->body ? -1 : first->body > second->body;
}

/* Asks now and then, so that long loops over path samples end soon. Nothing has changed by then. */
static bool asked_to_stop(const struct world *world, int64_t count)
{
	return count % 1024 == 0 && world_stopped(world);
}

/* Lists time and body of every path sample that is due. Samples of one body are alike, since they are placed in their order. */
static enum status list_due(struct world *world, double until, bool agreed)
{
	world->events.count = 0;
	for (size_t i = 0; i < world->scene->object_count; i++) {
		const struct body *body = world->bodies[i];
		const int64_t samples = body->kind == BODY_PATH && !body->elsewhere ? motion_track_samples(body->track) : 0;
		if (samples - body->next > WORLD_SAMPLES_MOST && motion_track_sample_time(body->track, body->next + WORLD_SAMPLES_MOST) <= until)
			return fail_with(STATUS_USAGE, "%s: more than %d path samples are due in one step; make shorter steps", body->object->name,
					 WORLD_SAMPLES_MOST);
		for (int64_t next = body->next; next < samples; next++) {
			const struct event event = {.time = motion_track_sample_time(body->track, next), .body = i};
			if (event.time > until)
				break;
			TRY(!agreed && asked_to_stop(world, next) ? world_interrupted(world) : add_event(world, &event));
		}
	}
	if (world->events.count > 1)
		qsort(world->events.list, world->events.count, sizeof *world->events.list, compare);
	return STATUS_OK;
}

/* --- events of later steps --- */

/* The events of a body that were placed before their steps. */
struct event_run {
	int64_t sample; /* of the first */
	size_t at, count; /* in world_events.ahead */
};

static enum status add_ahead(struct world_events *events, const struct event *event)
{
	TRY(mem_grow(&events->ahead, &events->ahead_room, events->ahead_count + 1, sizeof *events->ahead, "the path samples of a plan"));
	events->ahead[events->ahead_count++] = *event;
	return STATUS_OK;
}

enum status world_check_events(struct world *world, double until)
{
	struct world_events *events = &world->events;
	enum status status = STATUS_OK;
	if (events->runs == NULL)
		events->runs = mem_calloc(world->scene->object_count + 1, sizeof *events->runs);
	TRY_MEM(events->runs, "the path samples of a plan");
	events->ahead_count = 0;
	for (size_t i = 0; i < world->scene->object_count; i++) {
		struct body *body = world->bodies[i];
		struct event_run *run = &events->runs[i];
		const int64_t samples = body->kind == BODY_PATH && !body->elsewhere ? motion_track_samples(body->track) : 0;
		*run = (struct event_run){body->next, events->ahead_count, 0};
		for (int64_t k = body->next; k < samples && status == STATUS_OK && motion_track_sample_time(body->track, k) <= until; k++) {
			struct event event = {.time = 0};
			status = asked_to_stop(world, k) ? world_interrupted(world) : world_set_down(world, body, k, &event);
			if (status == STATUS_OK)
				status = add_ahead(events, &event);
			run->count += status == STATUS_OK;
		}
	}
	return status;
}

/* Places the event of a body's next sample. What was placed before is the same: it depends on the path and the base alone. */
static enum status place(struct world *world, struct event *event)
{
	struct body *body = world->bodies[event->body];
	const struct event_run *run = world->events.runs != NULL ? &world->events.runs[event->body] : NULL;
	if (run == NULL || body->next < run->sample || body->next >= run->sample + (int64_t)run->count)
		return world_set_down(world, body, body->next, event);
	const struct event due = *event;
	*event = world->events.ahead[run->at + (size_t)(body->next - run->sample)];
	event->body = due.body;
	event->time = due.time;
	return STATUS_OK;
}

/* --- the events of a step --- */

enum status world_collect_events(struct world *world, double until, bool agreed)
{
	enum status status = list_due(world, until, agreed);
	if (status != STATUS_OK)
		world->events.count = 0; /* none was placed */
	for (size_t i = 0; i < world->events.count && status == STATUS_OK; i++) {
		struct event *event = &world->events.list[i];
		struct body *body = world->bodies[event->body];
		status = !agreed && asked_to_stop(world, (int64_t)i) ? world_interrupted(world) : place(world, event);
		if (status == STATUS_OK)
			body->next++;
		else
			world->events.count = i; /* those that were placed */
	}
	return status;
}
