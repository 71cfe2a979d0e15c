/* The step loop: events, deformation, epochs, frames; and the times it took. */
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "run/internal.h"

double drive_steps_until(const struct scene *scene, double time)
{
	return ceil(time / scene->time_step - 1e-9);
}

int64_t drive_step_count(const struct drive *drive)
{
	int64_t whole = (int64_t)drive_steps_until(drive->scene, drive->scene->end_time);
	if (drive->params->steps > 0 && drive->params->steps < whole)
		whole = drive->params->steps;
	return whole;
}

double drive_step_time(const struct scene *scene, int64_t step)
{
	double time = (double)step * scene->time_step;
	/* The last step ends where the scene does, whatever the time step: the same stations are due. */
	return time < scene->end_time * (1 - 1e-12) ? time : scene->end_time;
}

static enum status fill_record(struct drive *drive)
{
	struct record *record = drive->record;
	const struct deform_block *awake;
	size_t count = 0;
	if (drive->deform != NULL) {
		enum status status = deform_awake(drive->deform, &awake, &count);
		if (status != STATUS_OK)
			return status;
	}
	if (count > 0)
		memcpy(record->awake, awake, count * sizeof *awake);
	record->awake_count = count;
	record->step = drive->step;
	record->time = drive->time;
	record->level = drive->level;
	record->ended = false;
	for (size_t i = 0; i < drive->scene->object_count; i++) {
		const struct rider *rider = &drive->riders[i];
		record->objects[i] = (struct record_object){
			.next = rider->next,
			.in_contact = rider->in_contact,
			.last = rider->last,
			.distance = rider->distance,
			.sinkage = rider->sinkage,
			.force = record->objects[i].force, /* forces_settle's */
			.skipped = rider->skipped,
		};
	}
	return STATUS_OK;
}

static enum status deform_step(struct drive *drive, double until)
{
	enum status status = STATUS_OK;
	for (size_t i = 0; i < drive->event_count && status == STATUS_OK; i++) {
		struct event *event = &drive->events[i];
		struct rider *rider = &drive->riders[event->rider];
		status = drive_intervals(drive, event->time, false);
		if (status == STATUS_OK)
			status = forces_rows(drive->forces, event->time, false);
		if (status != STATUS_OK)
			return status;
		if (!event->contact) {
			status = drive_let_go(drive, rider);
			rider->in_contact = false;
			rider->skipped++;
			forces_absent(drive->forces, event->rider, event);
			continue;
		}
		rider->distance += event->distance;
		if (rider->object->load == 0)
			rider->sinkage = event->sinkage;
		status = drive_sweep(drive, event, event->next_time > until);
	}
	if (status == STATUS_OK)
		status = drive_intervals(drive, until, true);
	return status == STATUS_OK ? forces_end_step(drive->forces, until) : status;
}

static bool is_image_step(const struct drive *drive)
{
	int64_t every = drive->scene->view.images;
	return every > 0 && drive->step % every == 0 && drive->params->host == NULL;
}

enum status drive_begin(struct drive *drive)
{
	drive_intervals_from(drive, drive->time);
	/* Killed before its first epoch it is not to be taken for the drive before it. */
	if (!drive->resumed) {
		enum status status = fill_record(drive);
		return status == STATUS_OK ? page_cache_flush(drive->cache, drive->record) : status;
	}
	/* The step was committed; its picture may not have been written. One that was cut short is yet to end. */
	bool ended = drive->step == drive->record->step;
	bool image = drive->view != NULL && drive->step > 0 && ended && is_image_step(drive);
	return image ? view_frame(drive->view, drive, true) : STATUS_OK;
}

enum status drive_end_step(struct drive *drive)
{
	enum status status = drive->pyramid != NULL ? pyramid_flush(drive->pyramid, drive->cache) : STATUS_OK;
	if (status == STATUS_OK)
		status = fill_record(drive);
	/* Until the record is of this step too there is nothing to commit. */
	if (status != STATUS_OK)
		return status;
	drive->torn = false;
	return page_cache_end_step(drive->cache, drive->record);
}

enum status drive_step(struct drive *drive)
{
	double until = drive_step_time(drive->scene, drive->step + 1);
	/* Before anything changes: a scene that leaves the ground stops at a step's end. */
	enum status status = drive_collect_events(drive, until);
	if (status == STATUS_OK)
		status = page_cache_poll(drive->cache);
	if (status == STATUS_OK)
		status = prefetch_step(drive->prefetch);
	if (status != STATUS_OK)
		return status;
	drive->torn = true;
	status = deform_step(drive, until);
	if (status != STATUS_OK)
		return status;
	drive->step++;
	drive->time = until;
	if (drive->scout != NULL)
		scout_tell(drive->scout, until);
	return drive_end_step(drive);
}

void drive_stalls(const struct drive *drive, struct stalls *stalls)
{
	struct page_stats pages;
	struct ground_figures ground;
	page_cache_stats(drive->cache, &pages);
	ground_figures(drive->ground, &ground);
	*stalls = (struct stalls){
		.count = pages.stalls + ground.waits - drive->stalls_before.count,
		.ms = pages.stall_ms + ground.wait_ms - drive->stalls_before.ms,
	};
}

static void show_progress(const struct drive *drive, int64_t total, double *shown)
{
	double now = clock_seconds();
	if (now - *shown < 0.2)
		return;
	*shown = now;
	double elapsed = now - drive->began, rate = (double)(drive->step - drive->resumed_from) / elapsed;
	if (rate <= 0)
		return;
	fprintf(stderr, "\rdrive: step %lld of %lld (%.0f %%), %.0f a second, %.0f s left\033[K",
		(long long)drive->step, (long long)total, 100.0 * (double)drive->step / (double)total, rate,
		(double)(total - drive->step) / rate);
	fflush(stderr);
}

bool drive_stopped(const struct drive *drive)
{
	return drive->params->stop != NULL && *drive->params->stop;
}

enum status drive_interrupted(const struct drive *drive)
{
	return fail_with(STATUS_INTERRUPTED, "drive: interrupted after step %lld; all of it is in the store",
			 (long long)drive->step);
}

/* One after the other, each with its picture. */
static enum status all_steps(struct drive *drive, int64_t total)
{
	bool terminal = drive->params->progress && isatty(STDERR_FILENO) != 0;
	double shown = 0;
	enum status status = STATUS_OK;
	while (drive->step < total && status == STATUS_OK) {
		if (drive_stopped(drive)) {
			status = drive_interrupted(drive);
			break;
		}
		double started = clock_seconds();
		status = drive_step(drive);
		double stepped = clock_seconds(), framed = stepped;
		if (status == STATUS_OK && drive->view != NULL) {
			status = view_frame(drive->view, drive, is_image_step(drive));
			framed = clock_seconds();
		}
		if (status == STATUS_OK)
			status = page_trace_status(drive->trace);
		if (status == STATUS_OK) {
			times_add(&drive->step_ms, (stepped - started) * 1e3);
			times_add(&drive->frame_ms, (framed - started) * 1e3);
		}
		if (!drive->settled && framed - drive->began > 1) {
			drive_stalls(drive, &drive->stalls_settled);
			drive->settled = true;
		}
		if (terminal)
			show_progress(drive, total, &shown);
	}
	if (terminal)
		fputs("\r\033[K", stderr);
	return status;
}

enum status drive_steps(struct drive *drive)
{
	int64_t total = drive_step_count(drive);
	drive_stalls(drive, &drive->stalls_before);
	drive->began = clock_seconds();
	enum status status = drive->params->host != NULL ? host_steps(drive, total) : all_steps(drive, total);
	struct failure failure;
	failure_capture(&failure, status);
	drive->record->ended = status == STATUS_OK && drive->step >= total;
	/* A step that failed half-way is no state to commit: the last epoch stands. */
	enum status flushed = drive->torn ? STATUS_OK : page_cache_flush(drive->cache, drive->record);
	drive->seconds = clock_seconds() - drive->began;
	/* An interrupted drive that could not be committed has failed. */
	if (flushed != STATUS_OK && (status == STATUS_OK || status == STATUS_INTERRUPTED))
		return flushed;
	return status == STATUS_OK ? status : failure_restore(&failure);
}
