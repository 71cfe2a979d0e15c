/* One step: collects its events, applies them to the ground, and records it. */
#include <math.h>
#include <string.h>

#include "world/internal.h"

double world_steps_until(const struct scene *scene, double time)
{
	return ceil(time / scene->time_step - 1e-9);
}

int64_t world_step_count(const struct world *world)
{
	int64_t whole = (int64_t)world_steps_until(world->scene, world->scene->end_time);
	if (world->params.steps > 0 && world->params.steps < whole)
		whole = world->params.steps;
	return whole;
}

double world_step_time(const struct scene *scene, int64_t step)
{
	double time = (double)step * scene->time_step;
	/* The last step ends where the scene does, whatever the time step. So the same path samples are due. A host's world has no end. */
	return scene->hosted || time < scene->end_time * (1 - 1e-12) ? time : scene->end_time;
}

enum status world_fill_record(struct world *world)
{
	struct record *record = world->record;
	const struct soil_block *active;
	size_t count;
	enum status status = world_active_blocks(world, &active, &count);
	if (status != STATUS_OK)
		return status;
	if (count > 0)
		memcpy(record->active, active, count * sizeof *active);
	record->active_count = count;
	record->step = world->step;
	record->time = world->time;
	record->level = world->resident.level;
	record->law = world_law(world);
	record->ended = false;
	for (size_t i = 0; i < world->scene->object_count; i++) {
		const struct body *body = world->bodies[i];
		if (body->kind != BODY_PATH) /* a host's begins anew */
			continue;
		world_forces_record(world->forces, i, &record->objects[i].force);
		record->objects[i] = (struct record_object){
			.next = body->next,
			.in_contact = body->in_contact,
			.last = body->last,
			.distance = body->distance,
			.sinkage = body->sinkage,
			.force = record->objects[i].force,
			.skipped = body->skipped,
		};
	}
	const struct world_attached *attached = &world->params.attached;
	if (attached->count > 0)
		attached->save(attached->user, world_record_attached(record, world->scene->object_count));
	return STATUS_OK;
}

const double *world_attached(const struct world *world)
{
	return world->facts.resumed.is && world->record->attached_count > 0
		       ? world_record_attached(world->record, world->scene->object_count)
		       : NULL;
}

const double *world_attached_last(const struct world *world)
{
	return world_record_attached(world->record, world->scene->object_count);
}

#define STOP_SECONDS 2.0 /* a step that takes less is made whole, and committed */

/* Returns true if the drive is to end, and waited for this step for STOP_SECONDS. */
static bool must_stop(struct world *world)
{
	if (!world_stopped(world))
		return false;
	if (world->stop_seen == 0)
		world->stop_seen = clock_seconds();
	return clock_seconds() - world->stop_seen > STOP_SECONDS;
}

static enum status torn_by_stop(const struct world *world)
{
	return fail_with(STATUS_INTERRUPTED, "drive: interrupted in step %lld, which is a long one; the store has the steps up to its last commit, and --resume goes on from there",
			 (long long)world->step + 1);
}

static enum status deform_step(struct world *world, double until)
{
	enum status status = STATUS_OK;
	world_batches_forget(world);
	world_meetings_forget(world);
	if (world->meetings != NULL)
		status = world_near_make(world);
	for (size_t i = 0; i < world->events.count && status == STATUS_OK; i++) {
		struct event *event = &world->events.list[i];
		struct body *body = world->bodies[event->body];
		if (i > 0 && event->time != event[-1].time)
			status = world_meetings_flush(world);
		if (status != STATUS_OK)
			return status;
		status = must_stop(world) ? torn_by_stop(world) : world_intervals(world, event->time, false);
		if (status == STATUS_OK)
			status = world_forces_rows(world->forces, event->time, false);
		if (status != STATUS_OK)
			return status;
		if (!event->contact) {
			status = world_let_go(world, body);
			body->in_contact = false;
			body->skipped++;
			world_forces_absent(world->forces, event->body, event);
			continue;
		}
		body->distance += event->distance;
		if (body->object->load == 0) {
			body->sinkage = event->sinkage;
			body->near += event->sinkage > -2 * soil_shape_bound(&body->object->shape); /* the ground beside it may be higher */
		}
		status = world_contact_or_wait(world, event);
	}
	if (status == STATUS_OK)
		status = world_batches_flush(world);
	if (status == STATUS_OK)
		status = world_meetings_flush(world);
	if (status == STATUS_OK && scene_moves_bodies(world->scene) && world->body_count > 0) {
		status = world_intervals(world, until, false);
		if (status == STATUS_OK)
			status = world_hosts_step(world, until - world->time, until);
	}
	if (status == STATUS_OK)
		status = world_intervals(world, until, true);
	return status == STATUS_OK ? world_forces_end_step(world->forces, until) : status;
}

enum status world_begin(struct world *world)
{
	world_enter(world, WORLD_READY);
	world_intervals_from(world, world->time);
	motion_look_ahead_begin(world->ahead, world->facts.resumed.time);
	enum status status = world->facts.resumed.is ? STATUS_OK : world_fill_record(world);
	page_cache_hold(world->resident.cache, true);
	if (status == STATUS_OK && !world->scene->hosted)
		status = world_begin_run(world);
	world->counts.warmed.stalls = world->counts.warmed.range_waits = (struct stalls){0, 0};
	struct stalls stalls, ranges;
	world_stalls(world, &stalls);
	world_range_waits(world, &ranges);
	world->counts.warmed.stalls = stalls;
	world->counts.warmed.range_waits = ranges;
	return status;
}

enum status world_begin_run(struct world *world)
{
	if (world->phase == WORLD_STEPPING)
		return STATUS_OK;
	if (world->params.readonly)
		return fail_with(STATUS_USAGE, "world: it was opened to be read only, and this would change it; open it without readonly");
	/* If the store cannot be written now, nothing has happened, and the step can be made later. */
	enum status status = store_begin(world->resident.store);
	if (status != STATUS_OK)
		return status;
	page_cache_hold(world->resident.cache, false);
	/* A run that is killed before its first commit must not be taken for the run before it. */
	if (!world->facts.resumed.is || world->params.attached.count > 0)
		status = page_cache_flush(world->resident.cache, world->record);
	if (status != STATUS_OK)
		return status;
	world_enter(world, WORLD_STEPPING);
	return world_checkpoint_begun(world);
}

enum status world_end_step(struct world *world)
{
	enum status status = world->resident.pyramid != NULL ? resident_pyramid_flush(world->resident.pyramid, world->resident.cache) : STATUS_OK;
	if (status == STATUS_OK)
		status = world_fill_record(world);
	/* Until the record describes this step too, there is nothing to commit. */
	if (status != STATUS_OK)
		return status;
	world_mend(world);
	world_changes_end(world);
	return page_cache_end_step(world->resident.cache, world->record);
}

enum status world_move_hosts(struct world *world)
{
	enum status status = page_cache_poll(world->resident.cache);
	if (world->ranks != NULL)
		status = world->ranks->step(world->ranks->user, world->time, status);
	world_tear(world);
	if (status == STATUS_OK)
		status = world_hosts_step(world, 0, world->time); /* no row is due: the scene's own objects have not begun */
	return status == STATUS_OK ? world_end_step(world) : status;
}

enum status world_step(struct world *world)
{
	return world_step_to(world, world_step_time(world->scene, world->step + 1));
}

/* Does all that can fail before anything changes: a scene that leaves the ground stops at the end of a step. */
static enum status prepare(struct world *world, double until)
{
	enum status status = world_collect_events(world, until, false);
	if (world->ranks != NULL)
		status = world->ranks->step(world->ranks->user, until, status);
	if (world->ranks != NULL && status == STATUS_OK && world->events.count == 0) /* of the bodies that are here now */
		status = world_collect_events(world, until, true);
	if (status == STATUS_OK)
		status = page_cache_poll(world->resident.cache);
	if (status == STATUS_OK)
		status = motion_look_ahead_step(world->ahead, world->time);
	return status;
}

enum status world_step_to(struct world *world, double until)
{
	enum status status = prepare(world, until);
	if (status == STATUS_OK)
		status = world_begin_run(world);
	if (status != STATUS_OK) {
		world_forget_events(world);
		return status;
	}
	world->until = until;
	world_tear(world);
	status = deform_step(world, until);
	world->near.stale = true;
	if (status != STATUS_OK)
		return status;
	world->step++;
	world->time = until;
	world->events.count = 0;
	if (world->ranks != NULL)
		world_pass_elsewhere(world, until);
	motion_look_ahead_tell(world->ahead, until);
	return world_end_step(world);
}

enum status world_idle(struct world *world)
{
	TRY(page_cache_poll(world->resident.cache));
	TRY(motion_look_ahead_step(world->ahead, world->time));
	return page_cache_end_step(world->resident.cache, world->record);
}

enum status world_begin_commit(struct world *world)
{
	return page_cache_begin_commit(world->resident.cache, world->record);
}

void world_stalls(const struct world *world, struct stalls *stalls)
{
	struct page_stats pages;
	struct resident_ground_figures ground;
	page_cache_stats(world->resident.cache, &pages);
	resident_ground_figures(world->resident.ground, &ground);
	*stalls = (struct stalls){
		.count = pages.stalls + ground.waits - world->counts.warmed.stalls.count,
		.ms = pages.stall_ms + ground.wait_ms - world->counts.warmed.stalls.ms,
	};
}

void world_recorded(const struct world *world, struct world_recorded *recorded)
{
	const struct record *record = world->record;
	*recorded = (struct world_recorded){record->step, record->time, record->sums, record->active_count};
}

void world_range_waits(const struct world *world, struct stalls *waits)
{
	struct resident_ground_figures ground;
	resident_ground_figures(world->resident.ground, &ground);
	*waits = (struct stalls){
		.count = ground.range_waits - world->counts.warmed.range_waits.count,
		.ms = ground.range_wait_ms - world->counts.warmed.range_waits.ms,
	};
}

bool world_stopped(const struct world *world)
{
	return world->params.stop != NULL && *world->params.stop;
}

enum status world_interrupted(const struct world *world)
{
	return fail_with(STATUS_INTERRUPTED, "drive: interrupted after step %lld; all of it is in the store",
			 (long long)world->step);
}

enum status world_end(struct world *world, bool ended)
{
	world->record->ended = ended;
	/* A step that failed half-way must not be committed. The last commit remains. */
	return world->phase != WORLD_STEPPING ? STATUS_OK : page_cache_flush(world->resident.cache, world->record);
}
