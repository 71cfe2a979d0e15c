/*
 * The life of a drive, written once for all who step a world:
 *
 *     open:  vehicles -> world prepared
 *     start: advice -> GL and bodies -> pages -> view -> warm -> vehicles joined -> sealed -> files of rows
 *     begin: world -> vehicles
 *     step ... (checkpoint, rollback)
 *     end:   the last commit
 *     stop:  threads
 *     finish
 */
#include <math.h>

#include "drive/internal.h"

bool drive_is_watched(const struct drive *drive)
{
	return drive->params.hosted || drive->params.host != NULL;
}

bool drive_writes(const struct drive *drive)
{
	return drive->params.directory != NULL && (drive->params.ranks == NULL || drive->params.ranks->rank == 0);
}

enum status drive_agree(struct drive *drive, enum status status)
{
	const struct world_ranks *ranks = drive->params.ranks;
	return ranks != NULL ? ranks->agree(ranks->user, drive->world, status) : status;
}

/* --- open --- */

static struct world_params world_params_of(const struct drive *drive)
{
	const struct drive_params *params = &drive->params;
	const struct world_ranks *ranks = params->ranks;
	size_t carrying;
	const struct soil_shape *const *shapes = vehicle_aboard_shapes(drive->vehicles, &carrying);
	return (struct world_params){
		.scene = drive->scene,
		.attached = vehicle_attached(drive->vehicles),
		.aboard_shapes = shapes,
		.carrying_count = carrying,
		.store = ranks != NULL ? ranks->over : params->store,
		.overlay = ranks != NULL ? ranks->part : params->overlay,
		.staged = params->staged,
		.ranks = ranks,
		.resume = params->resume,
		.durable_full = params->durable_full,
		.keep_history = params->keep_history,
		.readonly = params->readonly,
		.advise = params->advise,
		.threads = params->threads,
		.everywhere = params->everywhere,
		.alone = params->alone,
		.draws = drive->scene->view.present,
		.drops = params->host != NULL,
		.rows = params->directory != NULL,
		.steps = params->steps,
		.stop = params->stop,
	};
}

static enum status prepare(struct drive *drive)
{
	if (drive->params.map)
		TRY(report_map_check(drive->scene));
	TRY(vehicle_load(drive->scene, &drive->vehicles));
	drive->scene = vehicle_scene(drive->vehicles, drive->scene);
	const struct world_params world = world_params_of(drive);
	return world_open(&world, &drive->world);
}

enum status drive_prepare(struct drive *drive, const struct drive_params *params)
{
	drive->params = *params;
	drive->scene = params->scene;
	if (!drive_is_watched(drive)) {
		scene_unwatched(params->scene, &drive->unwatched);
		drive->scene = &drive->unwatched;
	}
	return drive_agree(drive, prepare(drive));
}

enum status drive_open(const struct drive_params *params, struct drive **out)
{
	*out = mem_calloc(1, sizeof **out);
	if (*out == NULL)
		return fail_memory("a drive");
	const enum status status = drive_prepare(*out, params);
	if (status == STATUS_OK)
		return STATUS_OK;
	drive_finish(*out, status);
	*out = NULL;
	return status;
}

/* --- start --- */

static void tell_advice(void *user, const char *text)
{
	(void)user;
	note("%s", text);
}

/* Says what looks wrong before anything runs. */
static void advise(const struct drive *drive)
{
	const struct world *world = drive->world;
	if (drive->params.host != NULL) { /* settings that a drive does not use may matter to who watches */
		scene_advise_units(drive->params.scene, tell_advice, NULL);
		return;
	}
	if (!drive->params.hosted)
		world_tell_written(world);
	if (!drive->params.hosted || drive->params.advise) {
		world_advise(world, tell_advice, NULL);
		report_sun_advise(world, tell_advice, NULL);
		report_pictures_advise(world_scene(world), world_step_count(world), tell_advice, NULL);
	}
	if (drive->vehicles != NULL || !drive->params.hosted)
		vehicle_advise(drive->vehicles, world, tell_advice, NULL);
}

/* A drive that could not begin leaves nothing behind: the folder is made after all that may fail by the scene. */
static enum status start_pages(struct drive *drive)
{
	const struct drive_params *params = &drive->params;
	FILE *commit_log = NULL;
	struct page_trace *trace = NULL;
	if (drive_writes(drive)) {
		TRY(drive_folder_make(params->directory));
		TRY(drive_folder_commits(params->directory, &commit_log));
	}
	const enum status status = params->trace != NULL ? page_trace_create(params->trace, &trace) : STATUS_OK;
	if (status == STATUS_OK)
		return world_start_pages(drive->world, commit_log, trace);
	if (commit_log != NULL)
		fclose(commit_log);
	return status;
}

/* What the store has after the commit is newer than what the view was told, so it is told first. Rows of the commit are written before it. */
static enum status before_record(void *user)
{
	struct drive *drive = user;
	if (drive->pictures != NULL)
		render_pictures_mark(drive->pictures);
	return drive_take(drive);
}

/* A run resumed from this commit draws the picture of its step again, and none before it. */
static enum status before_commit(void *user)
{
	const struct drive *drive = user;
	return drive->pictures != NULL ? render_pictures_await(drive->pictures) : STATUS_OK;
}

enum status drive_start_view(struct drive *drive)
{
	const bool watched = drive_is_watched(drive);
	TRY(vehicle_draw(drive->vehicles, drive->scene->view.effects));
	const struct world_figures figures = vehicle_figures(drive->vehicles);
	world_set_figures(drive->world, &figures);
	TRY(render_view_create(drive->world, watched, &drive->view));
	const size_t bytes = watched ? 0 : render_pictures_bytes(drive->scene);
	return bytes > 0 ? render_pictures_create(world_resident(drive->world)->gpu, drive->params.directory, bytes, &drive->pictures) : STATUS_OK;
}

static enum status open_rows(struct drive *drive)
{
	const struct world *world = drive->world;
	const char *directory = drive->params.directory;
	TRY(drive_folder_clear(world, directory));
	if (drive->pictures != NULL)
		TRY(render_cameras_folders(world_scene(world), directory));
	TRY(report_rows_open(world, directory, &drive->rows));
	TRY(report_vehicles_open(world, drive->vehicles, directory, &drive->vehicle_rows));
	TRY(report_lidars_open(drive->world, drive->vehicles, directory, &drive->lidars));
	TRY(report_sensors_open(world, drive->vehicles, directory, &drive->sensor_rows));
	return drive->params.hosted ? STATUS_OK : report_volume_open(world, directory, &drive->volume);
}

/* Opens the files of rows, and says who takes the rows. */
static enum status start_rows(struct drive *drive)
{
	const struct drive_params *params = &drive->params;
	struct world *world = drive->world;
	if (drive_writes(drive))
		TRY(open_rows(drive));
	if (drive->view != NULL && !drive_is_watched(drive))
		TRY(report_poses_open(world, params->directory, &drive->poses));
	if (params->ranks != NULL)
		params->share_rows(params->ranks->user, drive->rows);
	return STATUS_OK;
}

static enum status start(struct drive *drive)
{
	struct world *world = drive->world;
	const struct scene *scene = drive->scene;
	TRY(world_start(world));
	if (scene->view.present)
		TRY(render_check_samples(world_resident(world)->gpu, scene->view.samples));
	if (!drive_is_watched(drive))
		TRY(render_cameras_fit(scene, mem_usable().bytes));
	TRY(start_pages(drive));
	drive->commits = (struct world_commits){drive, before_record, before_commit};
	world_set_commits(world, &drive->commits);
	if (scene->view.present)
		TRY(drive_start_view(drive));
	TRY(world_warm(world));
	if (drive->view != NULL)
		TRY(render_view_warm(drive->view));
	if (drive->vehicles != NULL)
		TRY(vehicle_join(drive->vehicles, world));
	world_seal(world);
	return start_rows(drive);
}

enum status drive_start(struct drive *drive)
{
	advise(drive);
	return drive_agree(drive, start(drive));
}

/* --- steps --- */

static enum status take(struct drive *drive)
{
	size_t count;
	const struct world_row *rows = world_rows(drive->world, &count);
	const struct world_ranks *ranks = drive->params.ranks;
	TRY(ranks != NULL ? ranks->rows(ranks->user, rows, count) : report_rows_write(drive->rows, rows, count));
	world_rows_clear(drive->world);
	return drive->view != NULL ? render_view_update(drive->view) : STATUS_OK;
}

/* Rows may be in the file in part, and a commit would write all of them again. So a failure tears the world: no commit is made. */
enum status drive_take(struct drive *drive)
{
	const enum status status = take(drive);
	if (status != STATUS_OK)
		world_tear(drive->world);
	return status;
}

enum status drive_begin(struct drive *drive)
{
	TRY(world_begin(drive->world));
	if (drive->vehicles != NULL)
		TRY(vehicle_begin(drive->vehicles));
	TRY(report_vehicles_write(drive->vehicle_rows));
	TRY(report_sensors_write(drive->sensor_rows, drive->world));
	TRY(report_lidars_write(drive->lidars));
	return drive_take(drive);
}

/* Lets the view say what it will need, makes one step, and takes what it did. `until`: s; NAN: one time_step. Vehicles make one time_step always. */
static enum status step(struct drive *drive, double until)
{
	if (drive->view != NULL)
		TRY(render_view_prefetch(drive->view));
	if (drive->vehicles != NULL)
		TRY(vehicle_step(drive->vehicles));
	else
		TRY(isnan(until) ? world_step(drive->world) : world_step_to(drive->world, until));
	TRY(report_vehicles_write(drive->vehicle_rows));
	TRY(report_sensors_write(drive->sensor_rows, drive->world));
	TRY(report_lidars_write(drive->lidars));
	TRY(drive_take(drive));
	return page_trace_status(world_resident(drive->world)->trace);
}

enum status drive_step(struct drive *drive)
{
	return step(drive, (double)NAN);
}

enum status drive_step_to(struct drive *drive, double until)
{
	return step(drive, until);
}

enum status drive_checkpoint(struct drive *drive)
{
	struct drive_mark mark;
	TRY(report_vehicles_mark(drive->vehicle_rows, &mark.vehicle_rows));
	TRY(report_sensors_mark(drive->sensor_rows, &mark.sensor_rows));
	TRY(report_rows_mark(drive->rows, &mark.rows));
	TRY(world_checkpoint(drive->world));
	vehicle_mark_ways(drive->vehicles);
	drive->mark = mark;
	return STATUS_OK;
}

static enum status roll_rows_back(struct drive *drive)
{
	TRY(report_rows_rollback(drive->rows, drive->mark.rows));
	vehicle_mark_ways_back(drive->vehicles);
	if (drive->vehicles != NULL)
		TRY(vehicle_rollback(drive->vehicles));
	TRY(report_sensors_rollback(drive->sensor_rows, drive->mark.sensor_rows));
	return report_vehicles_rollback(drive->vehicle_rows, drive->mark.vehicle_rows);
}

enum status drive_rollback(struct drive *drive)
{
	/* What happened since the last step goes back, too. So it does not matter if the view cannot be told of it. */
	if (drive->view != NULL && render_view_update(drive->view) != STATUS_OK)
		world_happened_clear(drive->world);
	TRY(world_rollback(drive->world));
	const enum status status = roll_rows_back(drive);
	if (status != STATUS_OK)
		world_tear(drive->world);
	return status;
}

/* --- end --- */

enum status drive_end(struct drive *drive, bool complete)
{
	return drive_agree(drive, world_end(drive->world, complete));
}

void drive_stop(struct drive *drive)
{
	drive->report.threads = thread_running();
	render_pictures_stop(drive->pictures);
	world_stop(drive->world);
	if (drive->view != NULL && !drive->params.hosted)
		render_view_settle(drive->view);
}

void drive_fill_report(struct drive *drive)
{
	struct report *report = &drive->report;
	report->world = drive->world;
	report->view = drive->view;
	report->pictures = drive->pictures;
	report->poses = drive->poses;
	report->vehicles = drive->vehicles;
	report->advised = !drive_is_watched(drive);
}

char *drive_describe(struct drive *drive, const char *ended)
{
	drive_fill_report(drive);
	return report_json(&drive->report, ended);
}

void drive_let_go(struct drive *drive, enum status status)
{
	struct failure failure;
	failure_capture(&failure, status);
	world_stop(drive->world);
	render_view_destroy(drive->view);
	render_pictures_destroy(drive->pictures);
	world_finish(drive->world, status);
	report_rows_close(drive->rows);
	report_vehicles_close(drive->vehicle_rows);
	report_sensors_close(drive->sensor_rows);
	report_lidars_close(drive->lidars);
	report_poses_close(drive->poses);
	if (drive->volume != NULL)
		fclose(drive->volume);
	if (status != STATUS_OK)
		(void)failure_restore(&failure);
}

void drive_let_go_vehicles(struct drive *drive)
{
	vehicle_destroy(drive->vehicles);
	drive->vehicles = NULL;
}

void drive_finish(struct drive *drive, enum status status)
{
	if (drive == NULL)
		return;
	drive_let_go(drive, status);
	drive_let_go_vehicles(drive);
	mem_free(drive);
}

/* --- what it has --- */

struct world *drive_world(struct drive *drive)
{
	return drive->world;
}

struct vehicles *drive_vehicles(struct drive *drive)
{
	return drive->vehicles;
}

struct view *drive_view(struct drive *drive)
{
	return drive->view;
}

struct report *drive_report(struct drive *drive)
{
	return &drive->report;
}
