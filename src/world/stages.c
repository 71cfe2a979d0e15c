/*
 * One step of a world: a list of stages, which are run in their order and timed.
 *
 * `collect` does all that can fail before anything changes. So a scene that leaves the ground stops at the end of a step. From `contact` on the world is
 * torn, until `record` mends it. Soil also relaxes between contacts, when an interval is over: its time counts as that of `relax` all the same.
 */
#include "world/internal.h"

#define STOP_SECONDS 2.0 /* a step that takes less is made whole, and committed */

/* --- collect: the events that are due, and the ground for them --- */

/* Ranks make a step together, or none makes it. */
static enum status agree(struct world *world, const struct step *step)
{
	const enum status status = world_collect_events(world, step->until, false);
	if (world->ranks == NULL)
		return status;
	TRY(world->ranks->step(world->ranks->user, step->until, status));
	return world->events.count == 0 ? world_collect_events(world, step->until, true) : STATUS_OK; /* of the bodies that are here now */
}

static enum status all_that_can_fail(struct world *world, const struct step *step)
{
	TRY(agree(world, step));
	TRY(page_cache_poll(world->resident.cache));
	TRY(resident_look_ahead_step(world->ahead, world->time));
	return world_begin_run(world);
}

static enum status collect(struct world *world, const struct step *step)
{
	const enum status status = all_that_can_fail(world, step);
	if (status != STATUS_OK)
		world_forget_events(world);
	return status;
}

/* --- contact: bodies on paths change the ground --- */

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

static enum status meet(struct world *world, struct event *event)
{
	struct body *body = world->bodies[event->body];
	if (!event->contact) {
		TRY(world_let_go(world, body));
		body->has_last = false;
		body->trend = (struct soil_trend){.whole = {.ran = 0}};
		body->skipped++;
		world_forces_absent(world->forces, event->body, event);
		return STATUS_OK;
	}
	body->distance += event->distance;
	if (body->object->load == 0) {
		body->sinkage = event->sinkage;
		body->near += event->sinkage > -2 * soil_shape_bound(&body->object->shape); /* the ground beside it may be higher */
	}
	return world_contact_or_wait(world, event);
}

static enum status contact(struct world *world, const struct step *step)
{
	world->until = step->until;
	world_tear(world);
	world_batches_forget(world);
	world_meetings_forget(world);
	world->near.stale = true; /* made if a contact asks for it */
	if (world->meetings != NULL && world->events.count > 0)
		TRY(world_near_make(world));
	for (size_t i = 0; i < world->events.count; i++) {
		struct event *event = &world->events.list[i];
		if (i > 0 && event->time != event[-1].time)
			TRY(world_meetings_flush(world));
		if (must_stop(world))
			return torn_by_stop(world);
		TRY(world_intervals(world, event->time, false));
		TRY(world_forces_rows(world->forces, event->time, false));
		TRY(meet(world, event));
	}
	TRY(world_batches_flush(world));
	return world_meetings_flush(world);
}

/* --- hosts: bodies that a host moves change the ground --- */

static enum status hosts(struct world *world, const struct step *step)
{
	if (!scene_moves_bodies(world->scene) || world->body_count == 0)
		return STATUS_OK;
	TRY(world_intervals(world, step->until, false));
	return world_hosts_step(world, step->until - world->time, step->until);
}

/* --- relax, forces, record --- */

static enum status relax(struct world *world, const struct step *step)
{
	return world_intervals(world, step->until, true);
}

static enum status forces(struct world *world, const struct step *step)
{
	return world_forces_end_step(world->forces, step->until);
}

static enum status record(struct world *world, const struct step *step)
{
	TRY(world_carried_tell(world));
	world->step++;
	world->time = step->until;
	world->events.count = 0;
	if (world->ranks != NULL)
		world_pass_elsewhere(world, step->until);
	resident_look_ahead_tell(world->ahead, step->until);
	return world_end_or_wait(world);
}

/* --- the step --- */

static const struct stage {
	const char *name;
	enum status (*run)(struct world *world, const struct step *step);
} stages[WORLD_STAGES] = {
	[WORLD_COLLECT] = {"collect", collect}, [WORLD_CONTACT] = {"contact", contact}, [WORLD_HOSTS] = {"hosts", hosts},
	[WORLD_RELAX] = {"relax", relax},       [WORLD_FORCES] = {"forces", forces},    [WORLD_RECORD] = {"record", record},
};

const char *world_stage_name(enum world_stage stage)
{
	return stages[stage].name;
}

enum world_stage world_stage_enter(struct world *world, enum world_stage stage)
{
	const enum world_stage before = world->stage.now;
	if (world->stage.since == 0) /* no step is made */
		return before;
	const double now = clock_seconds();
	world->counts.stage_seconds[before] += now - world->stage.since;
	world->stage.now = stage;
	world->stage.since = now;
	return before;
}

enum status world_step_to(struct world *world, double until)
{
	const struct step step = {until};
	enum status status = STATUS_OK;
	TRY(world_check_age(world, until));
	world->stage.now = 0;
	world->stage.since = clock_seconds();
	for (int i = 0; i < WORLD_STAGES && status == STATUS_OK; i++) {
		world_stage_enter(world, (enum world_stage)i);
		status = stages[i].run(world, &step);
	}
	world_stage_enter(world, WORLD_COLLECT);
	world->stage.since = 0;
	if (world_is_torn(world) || status == STATUS_OK)
		world->near.stale = true;
	return status;
}

enum status world_end_step(struct world *world)
{
	if (world->params.attached == 0)
		return STATUS_OK;
	const double began = clock_seconds();
	const enum status status = world_end_change(world);
	world->counts.stage_seconds[WORLD_RECORD] += clock_seconds() - began;
	return status;
}

enum status world_step(struct world *world)
{
	return world_step_to(world, world_step_time(world->scene, world->step + 1));
}
