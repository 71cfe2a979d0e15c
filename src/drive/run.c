/* A whole drive: makes steps and pictures from a checked scene and a store, until its end. */
#include <unistd.h>

#include "drive/internal.h"

/* How often it is told how far a drive is, s. */
#define TERMINAL_SECONDS 0.2
#define LOG_SECONDS 10.0

/* --- the loop --- */

static bool is_image_step(const struct drive *drive)
{
	int64_t every = world_scene(drive->world)->view.images;
	return every > 0 && world_steps_done(drive->world) % every == 0 && drive->params.host == NULL;
}

/* Draws the frames of cameras that follow the present step. */
static enum status draw_cameras(struct drive *drive)
{
	return render_view_cameras(drive->view, drive->pictures, report_poses_sink(drive->poses));
}

/* Draws the pictures that follow the present step. */
static enum status draw_step(struct drive *drive)
{
	TRY(is_image_step(drive) ? render_view_frame(drive->view, drive->pictures, true) : render_view_between(drive->view, drive->pictures));
	return draw_cameras(drive);
}

/* The frames of cameras before the first step. */
static enum status draw_beginning(struct drive *drive)
{
	const bool first = drive->view != NULL && world_steps_done(drive->world) == 0 && drive->params.host == NULL;
	return first ? draw_cameras(drive) : STATUS_OK;
}

/* The step was committed, but its picture may be missing. A step that was cut short is still to be finished. */
static enum status begin(struct drive *drive)
{
	const struct world *world = drive->world;
	struct world_recorded recorded;
	world_recorded(world, &recorded);
	bool ended = world_facts(world)->resumed.is && world_steps_done(world) == recorded.step;
	const bool again = ended && drive->view != NULL && world_steps_done(world) > 0 && drive->params.host == NULL;
	if (again && is_image_step(drive))
		TRY(render_view_frame(drive->view, drive->pictures, true));
	if (again)
		TRY(draw_cameras(drive));
	TRY(drive_begin(drive));
	return draw_beginning(drive);
}

/* Drawing that was timed, and not yet added to the times of pictures. */
struct pictures_time {
	uint64_t frames; /* when it was last added */
	double seconds;
};

/* How long all steps have taken so far. */
struct steps_time {
	bool terminal;        /* progress is on one line that changes */
	double shown;         /* s, of the system's clock: when progress was told last */
	double drawing;       /* s */
	uint64_t before;      /* pictures before the first step */
	struct pictures_time pictures;
};

#define DRAWING_TOLD 0.1 /* share of the drive's time: if pictures take more, it is told */

/* Pictures often take more time than steps: tells how long one takes. `drawing`: seconds for `frames` of them. */
static void tell_drawing(double drawing, double elapsed, uint64_t frames, char *text, size_t room)
{
	text[0] = '\0';
	if (frames > 0 && drawing > DRAWING_TOLD * elapsed)
		snprintf(text, room, "; pictures take %.2g s each, %.0f %% of the time", drawing / (double)frames, 100 * drawing / elapsed);
}

static uint64_t frames_of(const struct drive *drive)
{
	struct render_view_figures figures = {.frames = 0};
	if (drive->view != NULL)
		render_view_figures(drive->view, &figures);
	return figures.frames;
}

/* Tells how far the drive is: on a terminal in one line that changes, otherwise in a line now and then. */
static void show_progress(const struct drive *drive, struct steps_time *times, int64_t total)
{
	const bool terminal = times->terminal;
	const struct world *world = drive->world;
	double now = clock_seconds();
	if (now - times->shown < (terminal ? TERMINAL_SECONDS : LOG_SECONDS))
		return;
	times->shown = now;
	double elapsed = now - drive->began, rate = (double)(world_steps_done(world) - world_facts(world)->resumed.from) / elapsed;
	if (rate <= 0)
		return;
	char pictures[96];
	tell_drawing(times->drawing, elapsed, frames_of(drive) - times->before, pictures, sizeof pictures);
	fprintf(stderr, "%s: step %lld of %lld (%.0f %%), %.*f a second, %.0f s left%s%s", terminal ? "\rdrive" : "furrow: note: drive",
		(long long)world_steps_done(world), (long long)total, 100.0 * (double)world_steps_done(world) / (double)total, rate < 10 ? 2 : 0, rate,
		(double)(total - world_steps_done(world)) / rate, pictures, terminal ? "\033[K" : "\n");
	fflush(stderr);
}

/* Adds `seconds` of drawing to the time of the pictures that came in them. Where none came, to that of the next: its tiles are loaded in the
 * steps before. */
static void count_pictures(struct drive *drive, struct pictures_time *pictures, double seconds)
{
	const uint64_t frames = frames_of(drive), count = frames - pictures->frames;
	pictures->seconds += seconds;
	for (uint64_t i = 0; i < count; i++)
		times_add(&drive->report.picture_ms, pictures->seconds / (double)count * 1e3);
	if (count > 0)
		*pictures = (struct pictures_time){.frames = frames};
}

/* Makes a step, and the picture that follows it, if there is one. */
static enum status step_and_draw(struct drive *drive, struct steps_time *times)
{
	const double began = clock_seconds();
	TRY(drive_step(drive));
	const double stepped = clock_seconds();
	if (drive->view != NULL) {
		TRY(draw_step(drive));
		const double seconds = clock_seconds() - stepped;
		times->drawing += seconds;
		count_pictures(drive, &times->pictures, seconds);
	}
	times_add(&drive->report.step_ms, (stepped - began) * 1e3);
	if (!drive->report.settled && clock_seconds() - drive->began > 1) {
		world_stalls(drive->world, &drive->report.stalls_settled);
		drive->report.settled = true;
	}
	return STATUS_OK;
}

/* Makes all steps, some of them with a picture. */
static enum status all_steps(struct drive *drive, int64_t total)
{
	struct world *world = drive->world;
	const bool terminal = drive->params.progress && isatty(STDERR_FILENO) != 0;
	const uint64_t before = frames_of(drive);
	struct steps_time times = {terminal, terminal ? 0 : drive->began, 0, before, {.frames = before}};
	enum status status = STATUS_OK;
	while (world_steps_done(world) < total && vehicle_stopped(drive->vehicles) == NULL) {
		TRY_OR(done, world_stopped(world) ? world_interrupted(world) : step_and_draw(drive, &times));
		if (drive->params.progress)
			show_progress(drive, &times, total);
	}
done:
	if (terminal)
		fputs("\r\033[K", stderr);
	return status;
}

/* Returns true if nobody else uses the drive's files, and no earlier run left anything in them. */
static bool owns_its_files(const struct drive *drive)
{
	return !world_facts(drive->world)->resumed.is && drive->params.ranks == NULL && drive->params.host == NULL;
}

/* Begins, makes the steps, and commits the last of them. */
static enum status all(struct drive *drive)
{
	struct world *world = drive->world;
	const struct world_ranks *ranks = drive->params.ranks;
	const int64_t total = world_step_count(world);
	enum status status = begin(drive);
	drive->unbegun = status == STATUS_INPUT && world_steps_done(world) == 0 && owns_its_files(drive);
	if (status != STATUS_OK && ranks == NULL)
		return status;
	drive->began = clock_seconds();
	const double used = clock_process_seconds();
	drive->report.warm_seconds = drive->began - drive->entered;
	if (status == STATUS_OK)
		status = drive->params.host != NULL ? drive_host_steps(drive, total) : all_steps(drive, total);
	drive->report.processor = clock_process_seconds() - used;
	if (ranks != NULL)
		status = ranks->end(ranks->user, status);
	struct failure failure;
	failure_capture(&failure, status);
	const enum status flushed = drive_end(drive, status == STATUS_OK && (world_steps_done(world) >= total || vehicle_stopped(drive->vehicles) != NULL));
	drive->report.seconds = clock_seconds() - drive->began;
	/* An interrupted drive that could not be committed has failed. */
	if (flushed != STATUS_OK && (status == STATUS_OK || status == STATUS_INTERRUPTED))
		return flushed;
	return status == STATUS_OK ? status : failure_restore(&failure);
}

/* --- a drive --- */

static bool is_there(const char *path)
{
	return path == NULL || access(path, F_OK) == 0;
}

/* Everything after the world is open. */
static enum status start_to_end(struct drive *drive, struct drive_result *result)
{
	if (world_facts(drive->world)->resumed.nothing_left)
		return drive_conclude_again(drive, result);
	const enum status status = drive_start(drive);
	drive->ran = status == STATUS_OK;
	drive->unbegun = !drive->ran && owns_its_files(drive);
	return drive->ran ? drive_conclude(drive, result, all(drive)) : status;
}

enum status drive_run(const struct drive_params *params, struct drive_result *result)
{
	struct drive drive = {.entered = clock_seconds(), .new_folder = !is_there(params->directory), .new_overlay = !is_there(params->overlay)};
	*result = (struct drive_result){.ended = "failed"};
	enum status status = drive_prepare(&drive, params);
	if (status == STATUS_OK)
		status = start_to_end(&drive, result);
	const int64_t step = drive.ran ? world_steps_done(drive.world) : 0;
	const double time = drive.ran ? world_time(drive.world) : 0;
	drive_let_go(&drive, status);
	if (drive.unbegun)
		drive_remove_made(&drive);
	if (drive.ran && params->ranks != NULL)
		status = drive_conclude_ranks(&drive, step, time, result, status);
	drive_let_go_vehicles(&drive);
	return status;
}

/* --- queries --- */

enum status drive_heights(struct drive *drive, const struct resident_point *points, size_t count, struct resident_height *heights)
{
	return world_heights(drive->world, points, count, heights);
}

enum status drive_rays(struct drive *drive, const struct resident_ray *rays, size_t count, struct resident_hit *hits)
{
	return world_rays(drive->world, rays, count, hits);
}
