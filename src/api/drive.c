/* The command's loop: makes steps and pictures from a checked scene and a store. */
#include <string.h>
#include <unistd.h>

#include "api/internal.h"

/* How often it is told how far a drive is, s. */
#define TERMINAL_SECONDS 0.2
#define LOG_SECONDS 10.0

/* --- the loop --- */

static bool is_image_step(const struct drive *drive)
{
	int64_t every = world_scene(drive->world)->view.images;
	return every > 0 && world_steps_done(drive->world) % every == 0 && drive->params->host == NULL;
}

/* Draws the frames of cameras that follow the present step. */
static enum status draw_cameras(struct drive *drive)
{
	return render_view_cameras(drive->view, drive->pictures, report_poses_sink(drive->poses));
}

/* Draws the pictures that follow the present step. */
static enum status draw_step(struct drive *drive)
{
	enum status status = is_image_step(drive) ? render_view_frame(drive->view, drive->pictures, true)
						  : render_view_between(drive->view, drive->pictures);
	return status == STATUS_OK ? draw_cameras(drive) : status;
}

/* The frames of cameras before the first step. */
static enum status draw_beginning(struct drive *drive)
{
	const bool first = drive->view != NULL && world_steps_done(drive->world) == 0 && drive->params->host == NULL;
	return first ? draw_cameras(drive) : STATUS_OK;
}

/* The step was committed, but its picture may be missing. A step that was cut short is still to be finished. */
static enum status begin(struct drive *drive)
{
	const struct world *world = drive->world;
	struct world_recorded recorded;
	world_recorded(world, &recorded);
	bool ended = world_facts(world)->resumed.is && world_steps_done(world) == recorded.step;
	enum status status = STATUS_OK;
	const bool again = ended && drive->view != NULL && world_steps_done(world) > 0 && drive->params->host == NULL;
	if (again && is_image_step(drive))
		status = render_view_frame(drive->view, drive->pictures, true);
	if (again && status == STATUS_OK)
		status = draw_cameras(drive);
	if (status == STATUS_OK)
		status = world_begin(drive->world);
	if (status == STATUS_OK && drive->vehicles != NULL)
		status = vehicle_begin(drive->vehicles);
	if (status == STATUS_OK)
		status = report_vehicles_write(drive->vehicle_rows);
	if (status == STATUS_OK)
		status = api_take(drive);
	return status == STATUS_OK ? draw_beginning(drive) : status;
}

enum status api_take(struct drive *drive)
{
	size_t count;
	const struct world_row *rows = world_rows(drive->world, &count);
	const struct world_ranks *ranks = drive->params->ranks;
	TRY(ranks != NULL ? ranks->rows(ranks->user, rows, count) : report_rows_write(drive->rows, rows, count));
	world_rows_clear(drive->world);
	return drive->view != NULL ? render_view_update(drive->view) : STATUS_OK;
}

enum status api_one_step(struct drive *drive)
{
	if (drive->view != NULL)
		TRY(render_view_wish(drive->view));
	TRY(drive->vehicles != NULL ? vehicle_step(drive->vehicles) : world_step(drive->world));
	TRY(report_vehicles_write(drive->vehicle_rows));
	return api_take(drive);
}

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

/* Tells how far the drive is: on a terminal in one line that changes, otherwise in a line now and then. `drawing`: seconds for the pictures
 * after the first `before` ones. */
static void show_progress(const struct drive *drive, bool terminal, int64_t total, double drawing, uint64_t before, double *shown)
{
	const struct world *world = drive->world;
	double now = clock_seconds();
	if (now - *shown < (terminal ? TERMINAL_SECONDS : LOG_SECONDS))
		return;
	*shown = now;
	double elapsed = now - drive->began, rate = (double)(world_steps_done(world) - world_facts(world)->resumed.from) / elapsed;
	if (rate <= 0)
		return;
	char pictures[96];
	tell_drawing(drawing, elapsed, frames_of(drive) - before, pictures, sizeof pictures);
	fprintf(stderr, "%s: step %lld of %lld (%.0f %%), %.*f a second, %.0f s left%s%s", terminal ? "\rdrive" : "furrow: note: drive",
		(long long)world_steps_done(world), (long long)total, 100.0 * (double)world_steps_done(world) / (double)total, rate < 10 ? 2 : 0, rate,
		(double)(total - world_steps_done(world)) / rate, pictures, terminal ? "\033[K" : "\n");
	fflush(stderr);
}

/* Drawing that was timed, and not yet added to the times of pictures. */
struct pictures_time {
	uint64_t frames; /* when it was last added */
	double seconds;
};

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

/* Makes all steps, some of them with a picture. */
static enum status all_steps(struct drive *drive, int64_t total)
{
	struct world *world = drive->world;
	bool terminal = drive->params->progress && isatty(STDERR_FILENO) != 0;
	double shown = terminal ? 0 : drive->began, drawing = 0;
	struct pictures_time pictures = {.frames = frames_of(drive)};
	const uint64_t before = frames_of(drive);
	enum status status = STATUS_OK;
	while (world_steps_done(world) < total && status == STATUS_OK && !vehicle_stuck(drive->vehicles)) {
		if (world_stopped(world)) {
			status = world_interrupted(world);
			break;
		}
		double started = clock_seconds();
		status = api_one_step(drive);
		double stepped = clock_seconds(), framed = stepped;
		if (status == STATUS_OK && drive->view != NULL) {
			status = draw_step(drive);
			framed = clock_seconds();
			drawing += framed - stepped;
			count_pictures(drive, &pictures, framed - stepped);
		}
		if (status == STATUS_OK)
			status = page_trace_status(world_resident(world)->trace);
		if (status == STATUS_OK)
			times_add(&drive->report.step_ms, (stepped - started) * 1e3);
		if (!drive->report.settled && framed - drive->began > 1) {
			world_stalls(world, &drive->report.stalls_settled);
			drive->report.settled = true;
		}
		if (drive->params->progress)
			show_progress(drive, terminal, total, drawing, before, &shown);
	}
	if (terminal)
		fputs("\r\033[K", stderr);
	return status;
}

/* Returns true if nobody else uses the drive's files, and no earlier run left anything in them. */
static bool owns_its_files(const struct drive *drive)
{
	return !world_facts(drive->world)->resumed.is && drive->params->ranks == NULL && drive->params->host == NULL;
}

static enum status all(struct drive *drive)
{
	struct world *world = drive->world;
	int64_t total = world_step_count(world);
	enum status status = begin(drive);
	drive->unbegun = status == STATUS_INPUT && world_steps_done(world) == 0 && owns_its_files(drive);
	if (status != STATUS_OK && drive->params->ranks == NULL)
		return status;
	drive->began = clock_seconds();
	const double used = clock_process_seconds();
	drive->report.warm_seconds = drive->began - drive->entered;
	if (status == STATUS_OK)
		status = drive->params->host != NULL ? api_host_steps(drive, total) : all_steps(drive, total);
	drive->report.processor = clock_process_seconds() - used;
	struct failure failure;
	const struct world_ranks *ranks = drive->params->ranks;
	if (ranks != NULL)
		status = ranks->end(ranks->user, status);
	failure_capture(&failure, status);
	enum status flushed = world_end(world, status == STATUS_OK && (world_steps_done(world) >= total || vehicle_stuck(drive->vehicles)));
	if (ranks != NULL)
		flushed = api_agree(drive, flushed);
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

static void tell_advice(void *user, const char *text)
{
	note("%s", text);
}

/* Says what looks wrong before anything runs. */
static void advise(const struct drive *drive)
{
	if (drive->params->host != NULL) { /* settings that a drive does not use may matter to who watches */
		scene_advise_units(drive->params->scene, tell_advice, NULL);
		return;
	}
	world_tell_written(drive->world);
	world_advise(drive->world, tell_advice, NULL);
	report_sun_advise(drive->world, tell_advice, NULL);
	vehicle_advise(drive->vehicles, drive->world, tell_advice, NULL);
}

static struct world_params world_params_of(const struct drive *drive)
{
	const struct api_params *params = drive->params;
	const struct world_ranks *ranks = params->ranks;
	return (struct world_params){
		.scene = &drive->scene,
		.attached = vehicle_attached(drive->vehicles),
		.store = ranks != NULL ? ranks->over : params->store,
		.overlay = ranks != NULL ? ranks->part : params->overlay,
		.staged = params->staged,
		.ranks = ranks,
		.resume = params->resume,
		.durable_full = params->durable_full,
		.keep_history = params->keep_history,
		.threads = params->threads,
		.everywhere = params->everywhere,
		.alone = params->alone,
		.draws = drive->scene.view.present,
		.drops = params->host != NULL,
		.rows = true,
		.steps = params->steps,
		.stop = params->stop,
	};
}

static void finish(struct drive *drive, enum status status)
{
	world_stop(drive->world);
	render_view_destroy(drive->view);
	render_pictures_destroy(drive->pictures);
	world_finish(drive->world, status);
	report_rows_close(drive->rows);
	report_vehicles_close(drive->vehicle_rows);
	report_poses_close(drive->poses);
	if (drive->volume != NULL)
		fclose(drive->volume);
}

enum status api_drive(const struct api_params *params, struct api_result *result)
{
	struct drive drive = {.params = params, .scene = *params->scene, .entered = clock_seconds(), .new_folder = !is_there(params->directory),
			      .new_overlay = !is_there(params->overlay)};
	if (params->host == NULL)
		scene_unwatched(params->scene, &drive.scene);
	*result = (struct api_result){.ended = "failed"};
	enum status status = params->map ? report_map_check(&drive.scene) : STATUS_OK;
	if (status == STATUS_OK)
		status = vehicle_load(&drive.scene, &drive.vehicles);
	const struct world_params world = world_params_of(&drive);
	if (status == STATUS_OK)
		status = world_open(&world, &drive.world);
	status = api_agree(&drive, status);
	if (status == STATUS_OK && world_facts(drive.world)->resumed.nothing_left) {
		status = api_end_again(&drive, result);
	} else if (status == STATUS_OK) {
		advise(&drive);
		status = api_agree(&drive, api_start(&drive));
		drive.ran = status == STATUS_OK;
		drive.unbegun = !drive.ran && owns_its_files(&drive);
		if (status == STATUS_OK)
			status = api_end(&drive, result, all(&drive));
	}
	const int64_t step = drive.ran ? world_steps_done(drive.world) : 0;
	const double time = drive.ran ? world_time(drive.world) : 0;
	finish(&drive, status);
	if (drive.unbegun)
		api_remove_made(&drive);
	if (drive.ran && params->ranks != NULL)
		status = api_conclude(&drive, step, time, result, status);
	vehicle_destroy(drive.vehicles);
	return status;
}

/* --- queries --- */

enum status api_heights(struct drive *drive, const struct resident_point *points, size_t count, struct resident_height *heights)
{
	return world_heights(drive->world, points, count, heights);
}

enum status api_rays(struct drive *drive, const struct resident_ray *rays, size_t count, struct resident_hit *hits)
{
	return world_rays(drive->world, rays, count, hits);
}
