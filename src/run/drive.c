/* One drive from a checked scene to run.json: opens everything, turns the crank, closes everything. */
#include <errno.h>
#include <math.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "run/internal.h"

#define EPOCH_AGE 1.0 /* s: how much of a drive a kill may cost */

static enum status make_directory(const char *path)
{
	struct stat found;
	if (mkdir(path, 0777) != 0 && errno != EEXIST)
		return fail_with(STATUS_FAILED, "%s: %s; give a folder that can be made", path, strerror(errno));
	if (stat(path, &found) != 0 || !S_ISDIR(found.st_mode))
		return fail_with(STATUS_FAILED, "%s: is not a folder; give another", path);
	return STATUS_OK;
}

/* The log is also what says that a drive writes into this folder; the lock goes with the process. */
static enum status open_epochs(struct drive *drive)
{
	char path[4096];
	snprintf(path, sizeof path, "%s/epochs.log", drive->params->directory);
	drive->epochs = fopen(path, "a+");
	if (drive->epochs == NULL)
		return fail_with(STATUS_FAILED, "%s: %s; give a folder that can be written", path, strerror(errno));
	if (flock(fileno(drive->epochs), LOCK_EX | LOCK_NB) != 0)
		return fail_with(STATUS_FAILED, "%s: another drive writes into this folder; give another, or wait for it to "
						"end",
				 drive->params->directory);
	return STATUS_OK;
}

/* What an earlier drive left, but for the lines a resumed one goes on with; a kill may have torn the last. */
static enum status clear_folder(struct drive *drive)
{
	char path[4096];
	long whole = 0;
	for (int c; drive->resumed && (c = getc(drive->epochs)) != EOF;)
		if (c == '\n')
			whole = ftell(drive->epochs);
	if (whole < 0 || ferror(drive->epochs) || ftruncate(fileno(drive->epochs), whole) != 0)
		return fail_with(STATUS_FAILED, "%s/epochs.log: %s; give a folder that can be written",
				 drive->params->directory, strerror(errno));
	rewind(drive->epochs);
	snprintf(path, sizeof path, "%s/run.json", drive->params->directory);
	unlink(path);
	snprintf(path, sizeof path, "%s/map.png", drive->params->directory);
	unlink(path);
	return STATUS_OK;
}

/* Ahead of everything: it reads while the GPU's programs are made. */
static enum status start_scout(struct drive *drive)
{
	const struct scene *scene = drive->scene;
	if (scene->prefetch == 0 || scene->object_count == 0)
		return STATUS_OK;
	const struct track **tracks = mem_alloc(scene->object_count, sizeof *tracks);
	if (tracks == NULL)
		return fail_memory("the scout");
	for (size_t i = 0; i < scene->object_count; i++)
		tracks[i] = drive->riders[i].track;
	uint32_t tiles = drive->ground_tiles;
	bool follows = scene->view.present && scene->view.camera != SCENE_FIXED;
	struct scout_params params = {
		.store = drive->store,
		.ground = drive->ground,
		.tiles = tiles - tiles / 4, /* the rest is for what the view asks for, and for what was passed */
		.tracks = tracks,
		.count = scene->object_count,
		.post = drive->spacing,
		.camera = follows ? view_places : NULL,
		.user = drive,
		.camera_speed = follows ? track_fastest(tracks[scene->view.target_object]) : 0,
		.prefetch = scene->prefetch,
		.end = scene->end_time,
	};
	enum status status = scout_create(&params, &drive->scout);
	mem_free(tracks);
	return status;
}

static enum status before_read_back(void *user, struct tile tile, uint32_t slot)
{
	struct drive *drive = user;
	return drive->pyramid != NULL ? pyramid_flush_tile(drive->pyramid, drive->cache, tile, slot) : STATUS_OK;
}

/* What slides, and where those stand that carry a load: as what is resumed left it. */
static enum status go_on_with_ground(struct drive *drive)
{
	const struct record *record = drive->record;
	bool slides = drive->deform != NULL && drive->scene->undisturbed == SCENE_SLIDES && !drive->resumed;
	enum status status = slides ? drive_wake_all(drive) : STATUS_OK;
	for (size_t i = 0; i < record->awake_count && status == STATUS_OK; i++)
		status = deform_wake_block(drive->deform, record->awake[i]);
	for (size_t i = 0; i < drive->scene->object_count && drive->resumed; i++) {
		const struct rider *rider = &drive->riders[i];
		if (rider->carrier > 0 && rider->in_contact)
			deform_stands(drive->deform, rider->carrier, (int32_t)(rider->stands - rider->last.z));
	}
	return status;
}

static enum status start_gpu(struct drive *drive)
{
	const struct scene *scene = drive->scene;
	struct gpu_params gpu = {.draws = scene->view.present};
	enum status status = gpu_create(&gpu, &drive->gpu);
	if (status == STATUS_OK && scene->view.present)
		status = render_check_samples(drive->gpu, scene->view.samples);
	if (status == STATUS_OK)
		status = gpu_slots_create(drive->gpu, drive->meta->world.cells, scene->slots,
					  pages_planes_of(scene, drive->was_deformed), &drive->slots);
	struct deform_params deform;
	drive_deform_params(drive, &deform);
	drive->asks_touched = deform.touched;
	deform.gpu = drive->gpu;
	deform.slots = drive->slots;
	deform.reference = ground_reference(drive->store);
	if (status == STATUS_OK && scene->object_count > 0)
		status = deform_create(&deform, &drive->deform);
	if (status == STATUS_OK)
		status = budget_check(drive);
	if (status == STATUS_OK)
		status = go_on_with_ground(drive);
	if (status == STATUS_OK)
		status = forces_create(drive, &drive->forces);
	if (status == STATUS_OK && scene->view.present)
		status = pyramid_create(&drive->meta->world, drive->level, drive->slots, &drive->pyramid);
	return status;
}

static enum status before_epoch(void *user)
{
	struct drive *drive = user;
	pictures_mark(drive->pictures);
	return forces_settle(drive->forces, drive->record);
}

/* What goes on from this epoch draws its step's picture again, and none before. */
static enum status before_commit(void *user)
{
	const struct drive *drive = user;
	return pictures_await(drive->pictures);
}

static enum status tally_snapshot(void *user, struct gpu_staging *staging)
{
	const struct drive *drive = user;
	deform_tally_read_into(drive->deform, staging, 0);
	return STATUS_OK;
}

static enum status soil_classes(void *user, unsigned loader, struct tile tile, uint8_t *classes)
{
	const struct drive *drive = user;
	return soil_map_read(drive->soil_map, loader, tile, classes);
}

void drive_pages_params(const struct drive *drive, struct pages_params *params)
{
	const struct scene *scene = drive->scene;
	*params = (struct pages_params){
		.planes = pages_planes_of(scene, drive->was_deformed),
		.level = drive->level,
		.count = scene->slots,
		.loaders = scene->loaders,
		.step_pages = budget_step_pages(drive),
		.scene = scene,
		.epoch_age = EPOCH_AGE,
		.before_read_back = before_read_back,
		.before_epoch = before_epoch,
		.before_commit = before_commit,
		.snapshot = scene->object_count > 0 ? tally_snapshot : NULL,
		.classes = soil_map_needed(scene) ? soil_classes : NULL,
		.classes_drawn = scene_draws_classes(scene),
	};
}

static enum status start_pages(struct drive *drive)
{
	const struct scene *scene = drive->scene;
	struct pages_params params;
	drive_pages_params(drive, &params);
	params.store = drive->store;
	params.gpu = drive->gpu;
	params.slots = drive->slots;
	params.below = drive->record->sums.below;
	params.above = drive->record->sums.above;
	params.compacted = drive->record->sums.compacted;
	params.epochs = drive->epochs;
	params.trace = drive->trace;
	params.user = drive;
	enum status status = pages_create(&params, &drive->pages);
	if (status == STATUS_OK)
		drive->cache = pages_cache(drive->pages);
	if (status == STATUS_OK && scene->view.present)
		status = view_create(drive, &drive->view);
	if (status == STATUS_OK && scene->view.present && scene->view.images > 0 && drive->params->host == NULL)
		status = pictures_create(drive->gpu, drive->params->directory, (uint32_t)scene->view.width,
					 (uint32_t)scene->view.height, &drive->pictures);
	if (status == STATUS_OK)
		status = prefetch_create(drive, &drive->prefetch);
	return status;
}

/* A driver compiles a program when it first draws with it: now, and not in a step. The ground of the first steps is
 * read by then too. */
static enum status warm_up(struct drive *drive)
{
	enum status status = STATUS_OK;
	for (size_t i = 0; i < drive->scene->object_count && status == STATUS_OK; i++) {
		const struct deform_planned planned = drive_planned(&drive->scene->objects[i]);
		status = deform_warm(drive->deform, &planned, drive->scene->forces > 0);
	}
	if (status == STATUS_OK)
		status = drop_warm(drive);
	bool deformed = pages_planes_of(drive->scene, drive->was_deformed) != 0;
	if (status == STATUS_OK)
		status = gpu_slots_warm(drive->slots, drive->level < 0, deformed && drive->scene->view.present);
	if (status == STATUS_OK)
		status = prefetch_first(drive->prefetch);
	if (drive->scout != NULL) {
		scout_tell(drive->scout, drive->time);
		scout_wait(drive->scout);
	}
	if (status == STATUS_OK && drive->view != NULL)
		status = view_warm(drive->view);
	gpu_finish(drive->gpu);
	gpu_stats(drive->gpu, &drive->before);
	gpu_slots_figures(drive->slots, &drive->slots_before);
	gpu_seal(drive->gpu);
	return status;
}

/* What there is to be done. */
static enum status prepare(struct drive *drive)
{
	const char *path = drive->params->store != NULL ? drive->params->store : drive->scene->store;
	if (path == NULL)
		return fail_with(STATUS_INPUT, "%s: names no store; add store:, or give --store", drive->scene->file);
	struct store_options options = {STORE_WRITE, drive->params->durable_full};
	const char *overlay = drive->params->overlay;
	drive->path = overlay != NULL ? overlay : path;
	enum status status = overlay != NULL ? store_open_overlay(overlay, path, &options, &drive->store)
					     : store_open(path, &options, &drive->store);
	if (status != STATUS_OK)
		return status;
	drive->meta = store_meta(drive->store);
	status = drive_settle_level(drive);
	if (status == STATUS_OK)
		drive->ground_tiles = drive_ground_tiles(drive);
	if (status == STATUS_OK)
		status = ground_create(drive->store, drive->ground_tiles, &drive->ground);
	if (status == STATUS_OK)
		status = soil_map_open(drive->scene, drive->meta, &drive->soil_map);
	if (status == STATUS_OK)
		status = drive_mount(drive);
	if (status == STATUS_OK && drive->params->resume)
		status = drive_resume(drive);
	else if (status == STATUS_OK)
		drive_tell_unfinished(drive);
	return status;
}

/* What changes something. */
static enum status start(struct drive *drive)
{
	enum status status = start_scout(drive);
	if (status == STATUS_OK)
		status = start_gpu(drive);
	/* Nothing is left behind of a drive that could not begin. */
	if (status == STATUS_OK)
		status = make_directory(drive->params->directory);
	if (status == STATUS_OK)
		status = open_epochs(drive);
	if (status == STATUS_OK && drive->params->trace != NULL)
		status = page_trace_create(drive->params->trace, &drive->trace);
	if (status == STATUS_OK)
		status = start_pages(drive);
	if (status == STATUS_OK)
		status = warm_up(drive);
	if (status == STATUS_OK)
		status = clear_folder(drive);
	if (status == STATUS_OK)
		status = forces_open(drive);
	return status == STATUS_OK ? drive_begin(drive) : status;
}

static void finish(struct drive *drive, enum status status)
{
	scout_destroy(drive->scout);
	view_destroy(drive->view);
	newest_destroy(drive->newest);
	prefetch_destroy(drive->prefetch);
	wishes_finish(&drive->wishes);
	pages_destroy(drive->pages);
	pictures_destroy(drive->pictures);
	soil_map_close(drive->soil_map);
	page_trace_destroy(drive->trace);
	forces_destroy(drive->forces);
	pyramid_destroy(drive->pyramid);
	deform_destroy(drive->deform);
	gpu_slots_destroy(drive->slots);
	gpu_destroy(drive->gpu);
	drive_unmount(drive);
	key_set_finish(&drive->seen);
	key_set_finish(&drive->old);
	mem_free(drive->events);
	if (drive->epochs != NULL)
		fclose(drive->epochs);
	ground_destroy(drive->ground);
	if (status == STATUS_OK)
		store_close(drive->store);
	else
		store_abandon(drive->store);
}

/* Also of a drive that failed or was interrupted: it began. Its own failure goes before the trace's. */
static enum status publish_trace(struct drive *drive, enum status status)
{
	struct failure failure;
	failure_capture(&failure, status);
	enum status published = page_trace_publish(drive->trace);
	if (published != STATUS_OK && (status == STATUS_OK || status == STATUS_INTERRUPTED))
		return published;
	return status == STATUS_OK ? STATUS_OK : failure_restore(&failure);
}

/* run.json, unless `keep` and there is one. */
static enum status report(const struct drive *drive, bool keep, struct run_result *result)
{
	char path[4096];
	snprintf(path, sizeof path, "%s/run.json", drive->params->directory);
	result->steps = drive->step;
	result->seconds = drive->seconds;
	result->rtf = drive->seconds > 0 ? (drive->time - drive->resumed_time) / drive->seconds : 0;
	result->json = report_json(drive, result->ended);
	if (result->json == NULL)
		return fail_memory("run.json");
	return keep && access(path, F_OK) == 0 ? STATUS_OK : report_write(drive->params->directory, result->json);
}

/* map.png, if it is asked for; unless `keep` and there is one. Returns `status`, or if that is well what the map's is. */
static enum status draw_map(const struct drive *drive, bool keep, struct run_result *result, enum status status)
{
	char path[4096];
	struct failure failure;
	snprintf(path, sizeof path, "%s/map.png", drive->params->directory);
	if (!drive->params->map || (keep && access(path, F_OK) == 0))
		return status;
	failure_capture(&failure, status);
	enum status drawn = map_write(drive, path, result->ended);
	result->map = drawn == STATUS_OK;
	if (status == STATUS_OK)
		return drawn;
	if (drawn != STATUS_OK)
		note("%s", failure_message());
	return failure_restore(&failure);
}

/* No thread reads or writes any more: what is counted is whole. */
static void stop_threads(struct drive *drive)
{
	drive->threads = thread_running();
	scout_destroy(drive->scout);
	drive->scout = NULL;
	pictures_stop(drive->pictures);
	pages_stop(drive->pages);
	if (drive->view != NULL)
		view_settle(drive->view);
}

static enum status run_steps(struct drive *drive, struct run_result *result)
{
	enum status status = publish_trace(drive, drive_steps(drive));
	stop_threads(drive);
	result->ended = status == STATUS_OK ? "complete"
			: status == STATUS_INTERRUPTED ? "interrupted"
						       : "failed";
	struct failure failure;
	failure_capture(&failure, status);
	enum status written = report(drive, false, result);
	bool tell_written = written != STATUS_OK && (status == STATUS_OK || status == STATUS_INTERRUPTED);
	if (!tell_written && status != STATUS_OK)
		status = failure_restore(&failure);
	return draw_map(drive, false, result, tell_written ? written : status);
}

static void tell_advice(void *user, const char *text)
{
	note("%s", text);
}

enum status run_drive(const struct run_params *params, struct run_result *result)
{
	struct drive drive = {.params = params, .scene = params->scene};
	*result = (struct run_result){.ended = "failed"};
	enum status status = prepare(&drive);
	if (status == STATUS_OK && drive.nothing_left) {
		result->ended = "complete";
		if (params->trace != NULL)
			note("%s: no trace is written, since nothing is left to drive", params->trace);
		status = make_directory(params->directory);
		if (status == STATUS_OK)
			status = draw_map(&drive, true, result, report(&drive, true, result));
	} else if (status == STATUS_OK) {
		if (params->host == NULL) /* what is of no use to a drive may be of use to who watches */
			drive_advise(&drive, tell_advice, NULL);
		status = start(&drive);
		if (status == STATUS_OK)
			status = run_steps(&drive, result);
	}
	finish(&drive, status);
	return status;
}
