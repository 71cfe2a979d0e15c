/* furrow.h: a world is stepped, and rolled back to a checkpoint. */
#include "api/library.h"

#include <math.h>

#define TIME_MOST 1e9 /* s: the longest end_time of a scene, too */

enum status api_library_checkpoint(struct furrow_world *host)
{
	TRY(drive_checkpoint(host->drive));
	host->mark = (struct library_mark){host->origin, host->steps};
	host->checkpoints++;
	return STATUS_OK;
}

/* Vehicles take whole steps of time_step. Those before one that failed stay. */
static enum status step_vehicles(struct furrow_world *host, double seconds)
{
	struct world *world = host->world;
	const double time_step = host->scene->time_step, count = seconds == 0 ? 1 : round(seconds / time_step);
	if (count < 1 || (seconds != 0 && fabs(seconds - count * time_step) > 1e-9 * seconds))
		return fail_with(STATUS_USAGE, "step: %g s is no whole number of time_steps of %g s, which vehicles need; give a multiple, or 0 for one", seconds,
				 time_step);
	/* The vehicles may have divided it. */
	const double parts = round(time_step / world_scene(world)->time_step);
	enum status status;
	for (double i = 0; i < count * parts; i++)
		TRY_OR(failed, drive_step(host->drive));
	return STATUS_OK;
failed:
	if (!world_is_torn(world)) {
		struct failure failure;
		failure_capture(&failure, status);
		if (vehicle_step_back(host->vehicles) != STATUS_OK)
			world_tear(world);
		return failure_restore(&failure);
	}
	return status;
}

enum status api_library_step(struct furrow_world *host, double seconds)
{
	struct world *world = host->world;
	if (!(seconds >= 0) || !isfinite(seconds))
		return fail_with(STATUS_USAGE, "step: %g s is no step; give 0 for the scene's time_step, or seconds above 0", seconds);
	const double until = seconds == 0 ? host->origin + (double)(host->steps + 1) * world_scene(world)->time_step : world_time(world) + seconds;
	if (until > TIME_MOST)
		return fail_with(STATUS_USAGE, "step: %g s from %g s on lead beyond %g s, where time does not tell steps of a microsecond apart; give %g s or less",
				 until - world_time(world), world_time(world), TIME_MOST, fmax(TIME_MOST - world_time(world), 0));
	if (world_is_torn(world))
		return fail_with(STATUS_FAILED, "step: the last one failed half-way; roll back first, or close the world");
	const double began = clock_seconds();
	enum status status = host->vehicles != NULL ? step_vehicles(host, seconds) : drive_step_to(host->drive, until);
	const double took = clock_seconds() - began;
	host->busy += took;
	host->failed = status != STATUS_OK && status != STATUS_USAGE;
	if (status != STATUS_OK)
		return status;
	host->steps++;
	if (host->vehicles != NULL) {
		host->steps = world_steps_done(world);
	} else if (seconds != 0) {
		host->origin = until;
		host->steps = 0;
	}
	times_add(&drive_report(host->drive)->step_ms, took * 1e3);
	return STATUS_OK;
}

furrow_status furrow_step(struct furrow_world *world, double seconds)
{
	struct library_call call;
	enum status status;
	TRY_OR(done, api_library_enter(&call, world));
	TRY_OR(done, api_library_need_writable(world, "step"));
done:
	return api_library_leave(&call, status == STATUS_OK ? api_library_step(world, seconds) : status);
}

double furrow_time(const struct furrow_world *world)
{
	return world != NULL ? world_time(world->world) : (double)NAN;
}

furrow_status furrow_checkpoint(struct furrow_world *world)
{
	struct library_call call;
	enum status status;
	TRY_OR(done, api_library_enter(&call, world));
	TRY_OR(done, api_library_need_writable(world, "checkpoint"));
	TRY_OR(done, api_library_checkpoint(world));
done:
	return api_library_leave(&call, status);
}

furrow_status furrow_rollback(struct furrow_world *world)
{
	struct library_call call;
	enum status status = api_library_enter(&call, world);
	if (status == STATUS_OK)
		status = drive_rollback(world->drive);
	if (status == STATUS_OK) {
		world->origin = world->mark.origin;
		world->steps = world->mark.steps;
		world->failed = false;
	}
	return api_library_leave(&call, status);
}
