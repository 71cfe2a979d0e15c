/* The steps of a run: their number, their record, how a run begins and ends. stages.c makes a step. */
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
	TRY(world_active_blocks(world, &active, &count));
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
			.has_last = body->has_last,
			.last = body->last,
			.trend = body->trend,
			.distance = body->distance,
			.sinkage = body->sinkage,
			.force = record->objects[i].force,
			.skipped = body->skipped,
		};
	}
	world_carried_record(world, record);
	world_thrown_record(world, record);
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

enum status world_begin(struct world *world)
{
	world_enter(world, WORLD_READY);
	world_intervals_from(world, world->time);
	world_thrown_from(world, world->time);
	resident_look_ahead_begin(world->ahead, world->facts.resumed.time);
	page_cache_hold(world->resident.cache, true);
	if (!world->facts.resumed.is)
		TRY(world_fill_record(world));
	if (!world->scene->hosted)
		TRY(world_begin_run(world));
	world->counts.warmed.stalls = world->counts.warmed.range_waits = (struct stalls){0, 0};
	struct stalls stalls, ranges;
	world_stalls(world, &stalls);
	world_range_waits(world, &ranges);
	world->counts.warmed.stalls = stalls;
	world->counts.warmed.range_waits = ranges;
	return STATUS_OK;
}

enum status world_begin_run(struct world *world)
{
	if (world->phase == WORLD_STEPPING)
		return STATUS_OK;
	if (world->params.readonly)
		return fail_with(STATUS_USAGE, "world: it was opened to be read only, and this would change it; open it without readonly");
	/* If the store cannot be written now, nothing has happened, and the step can be made later. */
	TRY(store_begin(world->resident.store));
	page_cache_hold(world->resident.cache, false);
	/* A run that is killed before its first commit must not be taken for the run before it. */
	if (!world->facts.resumed.is || world->params.attached > 0)
		TRY(page_cache_flush(world->resident.cache, world->record));
	world_enter(world, WORLD_STEPPING);
	return world_checkpoint_begun(world);
}

void world_attach(struct world *world, const double *numbers)
{
	if (world->params.attached > 0)
		memcpy(world_record_attached(world->record, world->scene->object_count), numbers, world->params.attached * sizeof *numbers);
}

enum status world_end_change(struct world *world)
{
	TRY(world->resident.pyramid != NULL ? resident_pyramid_flush(world->resident.pyramid, world->resident.cache) : STATUS_OK);
	TRY(world_fill_record(world));
	/* Until the record describes this step too, there is nothing to commit. */
	world_mend(world);
	world_changes_end(world);
	return page_cache_end_step(world->resident.cache, world->record);
}

enum status world_end_or_wait(struct world *world)
{
	return world->params.attached > 0 ? STATUS_OK : world_end_change(world);
}

enum status world_move_hosts(struct world *world)
{
	const struct world_ranks *ranks = world->ranks;
	const enum status polled = page_cache_poll(world->resident.cache);
	const enum status agreed = ranks != NULL ? ranks->step(ranks->user, world->time, polled) : polled;
	world_tear(world);
	TRY(agreed);
	TRY(world_hosts_step(world, 0, world->time)); /* no row is due: the scene's own objects have not begun */
	TRY(world_carried_tell(world));
	return world_end_or_wait(world);
}

enum status world_idle(struct world *world)
{
	TRY(page_cache_poll(world->resident.cache));
	TRY(resident_look_ahead_step(world->ahead, world->time));
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
