/* The command's loop: makes steps, pictures, objects.csv, run.json and a map from a checked scene and a store. */
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "api/internal.h"

/* How often it is told how far a drive is, s. */
#define TERMINAL_SECONDS 0.2
#define LOG_SECONDS 10.0

/* --- the view --- */

static void before_record(void *user)
{
	struct drive *drive = user;
	render_pictures_mark(drive->pictures);
}

/* A run resumed from this commit draws the picture of its step again, and none before it. */
static enum status before_commit(void *user)
{
	const struct drive *drive = user;
	return render_pictures_await(drive->pictures);
}

static enum status start_view(struct drive *drive)
{
	const bool watched = drive->params->host != NULL;
	if (!drive->world.scene->view.present)
		return STATUS_OK;
	enum status status = render_view_create(&drive->world, watched, &drive->view);
	const size_t bytes = watched ? 0 : render_pictures_bytes(drive->world.scene);
	if (status == STATUS_OK && bytes > 0)
		status = render_pictures_create(drive->world.gpu, drive->params->directory, bytes, &drive->pictures);
	if (status != STATUS_OK)
		return status;
	drive->commits = (struct world_commits){drive, before_record, before_commit};
	drive->world.commits = &drive->commits;
	drive->watcher = render_view_watcher(drive->view);
	world_watch(&drive->world, &drive->watcher);
	return STATUS_OK;
}

/* --- a drive's life --- */

/* Of many processes that step the world together, the first writes the files. */
static bool writes(const struct drive *drive)
{
	return drive->params->ranks == NULL || drive->params->ranks->rank == 0;
}

/* Returns the failure of any process on all of them. */
static enum status agree(struct drive *drive, enum status status)
{
	const struct world_ranks *ranks = drive->params->ranks;
	return ranks != NULL ? ranks->agree(ranks->user, &drive->world, status) : status;
}

static enum status start_pages(struct drive *drive)
{
	const struct api_params *params = drive->params;
	FILE *commit_log = NULL;
	struct page_trace *trace = NULL;
	enum status status = writes(drive) ? api_folder_commits(params->directory, &commit_log) : STATUS_OK;
	if (status != STATUS_OK)
		return status;
	if (params->trace != NULL)
		status = page_trace_create(params->trace, &trace);
	if (status == STATUS_OK)
		return world_start_pages(&drive->world, commit_log, trace);
	if (commit_log != NULL)
		fclose(commit_log);
	return status;
}

/* Opens the files of rows, and says who takes the rows. */
static enum status start_rows(struct drive *drive)
{
	const struct api_params *params = drive->params;
	struct world *world = &drive->world;
	enum status status = STATUS_OK;
	if (writes(drive)) {
		status = api_folder_clear(world, params->directory);
		if (status == STATUS_OK && drive->pictures != NULL)
			status = render_cameras_folders(world->scene, params->directory);
		if (status == STATUS_OK)
			status = report_rows_open(world, params->directory, &drive->rows);
		if (status == STATUS_OK)
			status = report_vehicles_open(world, drive->vehicles, params->directory, &drive->vehicle_rows);
		if (status == STATUS_OK)
			status = report_volume_open(world, params->directory, &drive->volume);
	}
	if (status == STATUS_OK && drive->view != NULL && params->host == NULL)
		status = report_poses_open(world, params->directory, &drive->poses);
	const struct world_rows *rows = report_rows_sink(drive->rows);
	world->rows = params->ranks != NULL ? params->share_rows(params->ranks->user, rows) : rows;
	vehicle_set_rows(drive->vehicles, report_vehicles_sink(drive->vehicle_rows));
	return status;
}

/* What changes something. */
static enum status start(struct drive *drive)
{
	struct world *world = &drive->world;
	const struct scene *scene = world->scene;
	enum status status = world_start(world);
	if (status == STATUS_OK && scene->view.present)
		status = render_check_samples(world->gpu, scene->view.samples);
	if (status == STATUS_OK && drive->params->host == NULL)
		status = render_cameras_fit(scene, mem_physical());
	/* A drive that could not begin leaves nothing behind. */
	if (status == STATUS_OK && writes(drive))
		status = api_folder_make(drive->params->directory);
	if (status == STATUS_OK)
		status = start_pages(drive);
	world->figures = vehicle_figures(drive->vehicles);
	if (status == STATUS_OK)
		status = start_view(drive);
	if (status == STATUS_OK)
		status = world_warm(world);
	if (status == STATUS_OK && drive->view != NULL)
		status = render_view_warm(drive->view);
	if (status == STATUS_OK && drive->vehicles != NULL)
		status = vehicle_join(drive->vehicles, world);
	if (status != STATUS_OK)
		return status;
	world_seal(world);
	return start_rows(drive);
}

static void finish(struct drive *drive, enum status status)
{
	world_stop(&drive->world);
	render_view_destroy(drive->view);
	render_pictures_destroy(drive->pictures);
	world_finish(&drive->world, status);
	report_rows_close(drive->rows);
	report_vehicles_close(drive->vehicle_rows);
	report_poses_close(drive->poses);
	if (drive->volume != NULL)
		fclose(drive->volume);
}

/* Also for a drive that failed or was interrupted, once it began. The drive's own failure is returned before the trace's. */
static enum status publish_trace(const struct drive *drive, enum status status)
{
	struct failure failure;
	failure_capture(&failure, status);
	enum status published = page_trace_publish(drive->world.trace);
	if (published != STATUS_OK && (status == STATUS_OK || status == STATUS_INTERRUPTED))
		return published;
	return status == STATUS_OK ? STATUS_OK : failure_restore(&failure);
}

/* Makes the text of run.json. */
static enum status describe(struct drive *drive, struct api_result *result)
{
	const struct world *world = &drive->world;
	struct report *report = &drive->report;
	report->world = world;
	report->view = drive->view;
	report->pictures = drive->pictures;
	report->poses = drive->poses;
	report->vehicles = drive->vehicles;
	report->advised = drive->params->host == NULL;
	result->steps = world->step;
	result->seconds = report->seconds;
	result->rtf = report->seconds > 0 ? (world->time - world->resumed.time) / report->seconds : 0;
	result->json = report_json(report, result->ended);
	return result->json != NULL ? STATUS_OK : fail_memory("run.json");
}

/* Writes run.json, unless `keep` and it exists. */
static enum status report(struct drive *drive, bool keep, struct api_result *result)
{
	char path[4096];
	snprintf(path, sizeof path, "%s/run.json", drive->params->directory);
	enum status status = describe(drive, result);
	if (status != STATUS_OK)
		return status;
	return keep && access(path, F_OK) == 0 ? STATUS_OK : report_write(drive->params->directory, result->json);
}

/* Draws map.png and what is asked for beside it. `keep`: only those that do not exist. */
static enum status write_maps(const struct drive *drive, const struct world *world, bool keep, struct api_result *result)
{
	char path[4096];
	snprintf(path, sizeof path, "%s/map.png", drive->params->directory);
	const char *const paths[] = {path, drive->params->map_also};
	enum status status = STATUS_OK;
	for (size_t i = 0; i < 2 && status == STATUS_OK; i++) {
		if (paths[i] == NULL || (keep && access(paths[i], F_OK) == 0))
			continue;
		status = report_map(world, drive->vehicles, paths[i], result->ended);
		if (i == 0)
			result->map = status == STATUS_OK;
		else
			result->map_also = status == STATUS_OK;
	}
	return status;
}

/* Draws the maps, if asked for, unless the drive failed in its first step. `keep` is as in write_maps. Returns `status` if that is a failure,
 * otherwise the status of the maps. */
static enum status draw_map(const struct drive *drive, bool keep, struct api_result *result, enum status status)
{
	struct failure failure;
	const bool empty = status != STATUS_OK && status != STATUS_INTERRUPTED && drive->world.step == 0;
	if (!drive->params->map || empty)
		return status;
	failure_capture(&failure, status);
	enum status drawn = write_maps(drive, &drive->world, keep, result);
	if (status == STATUS_OK)
		return drawn;
	if (drawn != STATUS_OK)
		note("%s", failure_message());
	return failure_restore(&failure);
}

/* --- the loop --- */

static bool is_image_step(const struct drive *drive)
{
	int64_t every = drive->world.scene->view.images;
	return every > 0 && drive->world.step % every == 0 && drive->params->host == NULL;
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
	const bool first = drive->view != NULL && drive->world.step == 0 && drive->params->host == NULL;
	return first ? draw_cameras(drive) : STATUS_OK;
}

/* The step was committed, but its picture may be missing. A step that was cut short is still to be finished. */
static enum status begin(struct drive *drive)
{
	const struct world *world = &drive->world;
	struct world_recorded recorded;
	world_recorded(world, &recorded);
	bool ended = world->resumed.is && world->step == recorded.step;
	enum status status = STATUS_OK;
	const bool again = ended && drive->view != NULL && world->step > 0 && drive->params->host == NULL;
	if (again && is_image_step(drive))
		status = render_view_frame(drive->view, drive->pictures, true);
	if (again && status == STATUS_OK)
		status = draw_cameras(drive);
	if (status == STATUS_OK)
		status = world_begin(&drive->world);
	if (status == STATUS_OK && drive->vehicles != NULL)
		status = vehicle_begin(drive->vehicles);
	return status == STATUS_OK ? draw_beginning(drive) : status;
}

enum status api_one_step(struct drive *drive)
{
	return drive->vehicles != NULL ? vehicle_step(drive->vehicles) : world_step(&drive->world);
}

/* Tells how far the drive is: on a terminal in one line that changes, otherwise in a line now and then. */
static void show_progress(const struct drive *drive, bool terminal, int64_t total, double *shown)
{
	const struct world *world = &drive->world;
	double now = clock_seconds();
	if (now - *shown < (terminal ? TERMINAL_SECONDS : LOG_SECONDS))
		return;
	*shown = now;
	double elapsed = now - drive->began, rate = (double)(world->step - world->resumed.from) / elapsed;
	if (rate <= 0)
		return;
	fprintf(stderr, "%s: step %lld of %lld (%.0f %%), %.*f a second, %.0f s left%s", terminal ? "\rdrive" : "furrow: note: drive",
		(long long)world->step, (long long)total, 100.0 * (double)world->step / (double)total, rate < 10 ? 2 : 0, rate,
		(double)(total - world->step) / rate, terminal ? "\033[K" : "\n");
	fflush(stderr);
}

/* Makes all steps, some of them with a picture. */
static enum status all_steps(struct drive *drive, int64_t total)
{
	struct world *world = &drive->world;
	bool terminal = drive->params->progress && isatty(STDERR_FILENO) != 0;
	double shown = terminal ? 0 : drive->began;
	enum status status = STATUS_OK;
	while (world->step < total && status == STATUS_OK && !vehicle_stuck(drive->vehicles)) {
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
		}
		if (status == STATUS_OK)
			status = page_trace_status(world->trace);
		if (status == STATUS_OK) {
			times_add(&drive->report.step_ms, (stepped - started) * 1e3);
			times_add(&drive->report.frame_ms, (framed - started) * 1e3);
		}
		if (!drive->report.settled && framed - drive->began > 1) {
			world_stalls(world, &drive->report.stalls_settled);
			drive->report.settled = true;
		}
		if (drive->params->progress)
			show_progress(drive, terminal, total, &shown);
	}
	if (terminal)
		fputs("\r\033[K", stderr);
	return status;
}

static enum status all(struct drive *drive)
{
	struct world *world = &drive->world;
	int64_t total = world_step_count(world);
	enum status status = begin(drive);
	drive->unbegun = status == STATUS_INPUT && !world->resumed.is && world->step == 0 && drive->params->ranks == NULL && drive->params->host == NULL;
	if (status != STATUS_OK && drive->params->ranks == NULL)
		return status;
	drive->began = clock_seconds();
	drive->report.warm_seconds = drive->began - drive->entered;
	if (status == STATUS_OK)
		status = drive->params->host != NULL ? api_host_steps(drive, total) : all_steps(drive, total);
	struct failure failure;
	const struct world_ranks *ranks = drive->params->ranks;
	if (ranks != NULL)
		status = ranks->end(ranks->user, status);
	failure_capture(&failure, status);
	enum status flushed = world_end(world, status == STATUS_OK && (world->step >= total || vehicle_stuck(drive->vehicles)));
	if (ranks != NULL)
		flushed = agree(drive, flushed);
	drive->report.seconds = clock_seconds() - drive->began;
	/* An interrupted drive that could not be committed has failed. */
	if (flushed != STATUS_OK && (status == STATUS_OK || status == STATUS_INTERRUPTED))
		return flushed;
	return status == STATUS_OK ? status : failure_restore(&failure);
}

/* Stops all threads, so that the counts are complete. */
static void stop_threads(struct drive *drive)
{
	drive->report.threads = thread_running();
	render_pictures_stop(drive->pictures);
	world_stop(&drive->world);
	if (drive->view != NULL)
		render_view_settle(drive->view);
}

static bool is_there(const char *path)
{
	return path == NULL || access(path, F_OK) == 0;
}

/* Removes what a drive made that could not begin. What was there before stays. */
static void remove_made(const struct drive *drive)
{
	static const char *const endings[] = {"", "-wal", "-shm"};
	char path[4096];
	if (drive->new_folder)
		api_folder_remove(drive->params->directory);
	for (size_t i = 0; drive->new_overlay && i < sizeof endings / sizeof *endings; i++)
		if (snprintf(path, sizeof path, "%s%s", drive->params->overlay, endings[i]) < (int)sizeof path)
			(void)unlink(path);
}

#define DRIVES_STILL 0.25 /* of its commanded speed: from there on nothing holds a vehicle up */

/* A drive may end before a vehicle has come to the end of its path. */
static void tell_on_the_way(const struct drive *drive)
{
	for (size_t i = 0; drive->vehicles != NULL && i < drive->scene.vehicle_count; i++) {
		struct vehicle_info info;
		vehicle_info(drive->vehicles, i, &info);
		if (drive->scene.vehicles[i].driver != SCENE_FOLLOW || info.arrived)
			continue;
		if (info.speed >= DRIVES_STILL * drive->scene.vehicles[i].way.speed)
			note("vehicles.%s: is not at the end of its path, but still drives at %.2g m/s: it has come %.4g m, and %.4g m are left; give an end_time of "
			     "%.0f s or more", info.name, info.speed, info.distance, info.left, ceil(drive->world.time + info.left / info.speed + 1));
		else
			note("vehicles.%s: is not at the end of its path: it has come %.4g m; drive longer, or look at what holds it up (vehicles.csv)",
			     info.name, info.distance);
	}
}

static void tell_stuck(const struct drive *drive)
{
	for (size_t i = 0; i < vehicle_count(drive->vehicles); i++) {
		struct vehicle_info info;
		vehicle_info(drive->vehicles, i, &info);
		if (info.stuck && info.deepest != NULL)
			note("vehicles.%s: is stuck since %.2f s: it has come %.4g m, and %s is deepest in the soil, by %.3g m; look at its rows in objects.csv "
			     "(output.forces)", info.name, fmax(info.stuck_at, 0), info.distance, info.deepest, info.depth);
	}
}

static void tell_advice(void *user, const char *text)
{
	note("%s", text);
}

static enum status run(struct drive *drive, struct api_result *result)
{
	enum status status = all(drive);
	if (!drive->unbegun)
		status = publish_trace(drive, status);
	stop_threads(drive);
	if (drive->unbegun)
		return status;
	result->ended = status == STATUS_OK ? vehicle_stuck(drive->vehicles) ? "stuck" : "complete"
			: status == STATUS_INTERRUPTED ? "interrupted"
						       : "failed";
	if (strcmp(result->ended, "complete") == 0 && writes(drive)) {
		tell_on_the_way(drive);
		report_groundless(&drive->world, tell_advice, NULL);
	}
	if (strcmp(result->ended, "stuck") == 0 && writes(drive))
		tell_stuck(drive);
	struct failure failure;
	failure_capture(&failure, status);
	if (drive->params->ranks != NULL) { /* conclude() writes it */
		enum status made = describe(drive, result);
		return status == STATUS_OK ? made : failure_restore(&failure);
	}
	enum status written = report_cameras(drive->poses);
	if (status == STATUS_OK && written == STATUS_OK)
		report_videos(drive->poses);
	if (written == STATUS_OK)
		written = report(drive, false, result);
	bool tell_written = written != STATUS_OK && (status == STATUS_OK || status == STATUS_INTERRUPTED);
	if (!tell_written && status != STATUS_OK)
		status = failure_restore(&failure);
	return draw_map(drive, false, result, tell_written ? written : status);
}

/* Draws the map from the run's overlay, after what the ranks committed was gathered into it. */
static enum status map_gathered(const struct drive *drive, int64_t step, double time, struct api_result *result)
{
	struct world world;
	struct store_meta assumed;
	enum status status = world_prepare_plan(&world, &drive->scene, drive->params->ranks->over, false, &assumed);
	world.step = step;
	world.time = time;
	if (status == STATUS_OK)
		status = resident_ground_create(world.store, world.limits.ground, &world.ground);
	if (status == STATUS_OK)
		status = write_maps(drive, &world, false, result);
	world_finish(&world, STATUS_OK);
	return status;
}

/* Of many processes, when all have closed the ground: what they did comes together, and the first writes run.json and the map. `status`: how
 * this one ended. */
static enum status conclude(struct drive *drive, int64_t step, double time, struct api_result *result, enum status status)
{
	const struct world_ranks *ranks = drive->params->ranks;
	struct world_ranked ranked;
	struct failure failure;
	failure_capture(&failure, status);
	enum status gathered = ranks->gather(ranks->user, &ranked);
	if (gathered == STATUS_OK && writes(drive) && result->json != NULL) {
		gathered = report_gathered(&result->json, &ranked, ranks->ranks);
		if (gathered == STATUS_OK)
			gathered = report_write(drive->params->directory, result->json);
		if (gathered == STATUS_OK && drive->params->map)
			gathered = map_gathered(drive, step, time, result);
	}
	if (status == STATUS_OK || (status == STATUS_INTERRUPTED && gathered != STATUS_OK))
		return gathered;
	return failure_restore(&failure);
}

enum status api_drive(const struct api_params *params, struct api_result *result)
{
	struct drive drive = {.params = params, .scene = *params->scene, .entered = clock_seconds(), .new_folder = !is_there(params->directory),
			      .new_overlay = !is_there(params->overlay)};
	if (params->host == NULL)
		scene_unwatched(params->scene, &drive.scene);
	const struct world_ranks *ranks = params->ranks;
	struct world_params world = {
		.scene = &drive.scene,
		.store = ranks != NULL ? ranks->over : params->store,
		.overlay = ranks != NULL ? ranks->part : params->overlay,
		.staged = params->staged,
		.ranks = ranks,
		.resume = params->resume,
		.durable_full = params->durable_full,
		.keep_history = params->keep_history,
		.everywhere = params->everywhere,
		.alone = params->alone,
		.draws = drive.scene.view.present,
		.drops = params->host != NULL,
		.rows = true,
		.steps = params->steps,
		.stop = params->stop,
	};
	*result = (struct api_result){.ended = "failed"};
	enum status status = vehicle_load(&drive.scene, &drive.vehicles);
	world.attached = vehicle_attached(drive.vehicles);
	if (status == STATUS_OK)
		status = world_prepare(&drive.world, &world);
	status = agree(&drive, status);
	if (status == STATUS_OK && drive.world.resumed.nothing_left) {
		result->ended = "complete";
		if (params->trace != NULL)
			note("%s: no trace is written, since nothing is left to drive", params->trace);
		status = writes(&drive) ? api_folder_make(params->directory) : STATUS_OK;
		if (status == STATUS_OK && writes(&drive))
			status = draw_map(&drive, true, result, report(&drive, true, result));
	} else if (status == STATUS_OK) {
		if (params->host == NULL) { /* settings that a drive does not use may matter to who watches */
			world_advise(&drive.world, tell_advice, NULL);
			report_sun_advise(&drive.world, tell_advice, NULL);
			vehicle_advise(drive.vehicles, &drive.scene, drive.world.spacing, tell_advice, NULL);
		} else {
			scene_advise_units(params->scene, tell_advice, NULL);
		}
		status = agree(&drive, start(&drive));
		drive.ran = status == STATUS_OK;
		if (status == STATUS_OK)
			status = run(&drive, result);
	}
	const int64_t step = drive.world.step;
	const double time = drive.world.time;
	finish(&drive, status);
	if (drive.unbegun)
		remove_made(&drive);
	if (drive.ran && ranks != NULL)
		status = conclude(&drive, step, time, result, status);
	vehicle_destroy(drive.vehicles);
	return status;
}

/* --- queries --- */

enum status api_heights(struct drive *drive, const struct terrain_point *points, size_t count, struct terrain_height *heights)
{
	return world_heights(&drive->world, points, count, heights);
}

enum status api_rays(struct drive *drive, const struct terrain_ray *rays, size_t count, struct terrain_hit *hits)
{
	return world_rays(&drive->world, rays, count, hits);
}
