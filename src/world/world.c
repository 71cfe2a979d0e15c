/* A world's life: opened, started, warmed up, stopped, freed. */
#include "world/internal.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

/*
 * llvmpipe's raster threads draw a picture in half of the time, but small passes take up to five times longer with them. On two cores a
 * step of a vehicle loses what this many pixels win. Above this many bodies in batches, threads cost nothing there, and win on more cores.
 */
#define MANY_PIXELS 10000
#define MANY_BODIES 1000
#define COMMIT_AGE 1.0 /* s of a run that a kill may lose */

enum status world_make(const struct world_params *params, struct world **out)
{
	struct world *world = *out = mem_calloc(1, sizeof *world);
	TRY_MEM(world, "a world");
	world->params = *params;
	world->scene = params->scene;
	world->ranks = params->ranks;
	/* The caller's texts may go after world_open. */
	world->params.store = world->params.overlay = NULL;
	world->params.staged = NULL;
	world_changes_begin(world);
	return STATUS_OK;
}

static enum status open_store(struct world *world, const struct world_params *params)
{
	const struct scene *scene = params->scene;
	const char *path = params->store != NULL ? params->store : scene->store;
	if (path == NULL)
		return fail_with(STATUS_INPUT, "%s: names no store; add store:, or give --store", scene->file);
	const struct store_options options = {
		.mode = params->readonly ? STORE_READ : STORE_WRITE,
		.late = !params->readonly,
		.durable_full = params->durable_full,
		.keep_history = params->keep_history,
		.scene = scene->file,
		.staged = params->staged,
	};
	TRY(params->overlay != NULL ? store_open_overlay(params->overlay, path, &options, &world->resident.store)
				    : store_open(path, &options, &world->resident.store));
	world->facts.path = store_file_path(world->resident.store);
	world->resident.meta = store_meta(world->resident.store);
	return STATUS_OK;
}

enum status world_open(const struct world_params *params, struct world **out)
{
	TRY(world_make(params, out));
	struct world *world = *out;
	TRY(open_store(world, params));
	world_settle_light(world);
	TRY(world_settle_level(world));
	TRY(world_settle_relief(world));
	TRY(world_make_bodies(world));
	TRY(world_settle_limits(world));
	TRY(world_open_soil_map(world));
	TRY(world_open_rasters(world));
	TRY(world_find_soils_met(world));
	TRY(resident_ground_create(world->resident.store, world->facts.limits.ground, &world->resident.ground));
	TRY(world_find_ruts(world));
	if (params->resume)
		TRY(world_resume(world));
	else if (!params->readonly)
		world_tell_unfinished(world);
	return world_begin_age(world);
}

/* --- starting --- */

/* The look-ahead's thread. */
static size_t camera_places(const void *user, double time, double places[2][2])
{
	const struct world *world = user;
	const struct scene_view *view = &world->scene->view;
	const struct body *target = world->bodies[view->aim.object];
	return motion_track_camera_places(&view->aim, &target->object->path, target->track, time, places);
}

static enum status start_look_ahead(struct world *world)
{
	const struct scene *scene = world->scene;
	struct look_ahead_body *bodies = mem_calloc(scene->object_count + 1, sizeof *bodies);
	TRY_MEM(bodies, "the look-ahead");
	size_t count = 0;
	for (size_t i = 0; i < scene->object_count; i++)
		if (world->bodies[i]->kind == BODY_PATH)
			bodies[count++] = (struct look_ahead_body){motion_track_ahead(world->bodies[i]->track), &world->bodies[i]->object->shape, world->bodies[i]->next,
									&world->bodies[i]->elsewhere};
	uint32_t tiles = world->facts.limits.ground;
	bool follows = scene->view.present && scene->view.aim.kind != SCENE_FIXED && scene->view.aim.vehicle == 0 && scene->object_count > 0 &&
		       world->bodies[scene->view.aim.object]->kind == BODY_PATH;
	const struct look_ahead_params params = {
		.store = world->resident.store,
		.ground = world->resident.ground,
		.tiles = tiles - tiles / 4, /* the rest is for tiles of the view, and for passed ones */
		.bodies = bodies,
		.count = count,
		.spacing = world->resident.spacing,
		.camera = follows ? camera_places : NULL,
		.camera_user = world,
		.camera_speed = follows ? motion_track_fastest(world->bodies[scene->view.aim.object]->track) : 0,
		.prefetch = world->facts.limits.prefetch,
		.end = scene->hosted ? (double)INFINITY : scene->end_time,
	};
	enum status status = resident_look_ahead_create(&params, &world->ahead);
	mem_free(bodies);
	return status;
}

static enum status make_pyramid(struct world *world)
{
	struct resident *resident = &world->resident;
	return resident_pyramid_create(&resident->meta->extent, resident->level, resident->slots, resident->host, &resident->pyramid);
}

/* Sets active blocks and the equilibrium heights of loaded bodies as the resumed run left them. */
static enum status go_on_with_ground(struct world *world)
{
	const struct record *record = world->record;
	bool relaxes = world_changes_ground(world) && world->scene->undisturbed == SCENE_SLIDES && (!world->facts.resumed.is || record->step == 0);
	if (relaxes)
		TRY(world_wake_all(world));
	for (size_t i = 0; i < record->active_count; i++)
		TRY(world_wake_block(world, record->active[i]));
	for (size_t i = 0; i < world->scene->object_count && world->facts.resumed.is; i++) {
		const struct body *body = world->bodies[i];
		world_set_equilibrium(world, body, body->equilibrium - body->last.z);
	}
	return STATUS_OK;
}

/* A host owns its environment, so it counts as if it had. A window draws after each step. */
static bool has_large_passes(const struct world *world, const struct deform_params *deform)
{
	return world->scene->hosted || world_batched_bodies(world, deform) >= MANY_BODIES ||
	       (world->params.draws && (world->params.drops || scene_pixels_a_step(world->scene) >= MANY_PIXELS));
}

/* Makes the GPU's context and slots: the home of pages; over pages in host memory their mirror, for pictures. */
static enum status start_gpu(struct world *world, const struct gpu_params *params)
{
	TRY(gpu_create(params, &world->resident.gpu));
	const unsigned planes = world->resident.host != NULL ? world_planes(world) & GPU_DRAWN_PLANES : world_planes(world);
	return gpu_slots_create(world->resident.gpu, world->resident.meta->extent.cells, world->facts.limits.slots, planes, &world->resident.slots);
}

/* Makes the home of pages: slots of the GPU, or in host memory where the CPU computes. Pictures need the GPU's in any case. A kinematic model needs no
 * GL, unless the scene says so. */
static enum status start_home(struct world *world)
{
	struct deform_params deform;
	enum status status = STATUS_OK;
	world_deform_params(world, &deform);
	const struct gpu_params gpu = {.draws = has_large_passes(world, &deform)};
	if (!world_is_bearing(world)) {
		const bool may_do_without = world_deforms(world) && !world->params.draws && world->scene->compute == SCENE_ANYWHERE;
		status = start_gpu(world, &gpu);
		if (status != STATUS_NO_GL || !may_do_without)
			return status;
		const char *why = failure_message(); /* what to do against it follows */
		note("%.*s: the CPU computes model %s, with the same result; compute: cpu asks for that", (int)strcspn(why, ";"), why,
		     deform_model_row(world->scene->model)->name);
		world->facts.without_gl = true;
	}
	status = resident_host_create(world->resident.meta->extent.cells, (uint32_t)world->facts.limits.slots, world_planes(world), &world->resident.host);
	return status == STATUS_OK && world->params.draws ? start_gpu(world, &gpu) : status;
}

/* An elastic sheet keeps its state in a plane in which scm keeps what it remembers of loose layers. */
static enum status check_sheet_ground(const struct world *world)
{
	struct store_numbers numbers;
	if (!world_deforms(world) || !deform_is_elastic(world->scene->model) || !world->resident.was_deformed || world->resident.store == NULL)
		return STATUS_OK;
	TRY(store_count(world->resident.store, &numbers));
	if (numbers.plane_tiles[PLANE_SETTLED] == 0 && numbers.plane_tiles[PLANE_LOOSE] == 0)
		return STATUS_OK;
	return fail_with(STATUS_INPUT, "redistribute.model: this store has loose soil of a drive under scm, which an elastic sheet cannot lie on; furrow reset it, or take "
				       "another store");
}

/* Makes what computes the ground: deform or bearing, and what lets contacts be computed together. */
static enum status start_surface(struct world *world)
{
	TRY(check_sheet_ground(world));
	struct deform_params deform;
	world_deform_params(world, &deform);
	if (world->resident.slots != NULL && world_computes_together(world))
		TRY(gpu_slots_in_arrays(world->resident.slots));
	world->aloft.asks_touched = deform.touched;
	deform.gpu = world->resident.gpu;
	deform.slots = world->resident.slots;
	deform.reference = resident_ground_reference(world->resident.store);
	TRY(world_surface_create(world, &deform));
	if (world->deform != NULL)
		TRY(world_batches_create(world));
	TRY(world_meetings_create(world));
	return world_crew_create(world);
}

enum status world_start(struct world *world)
{
	TRY(start_look_ahead(world));
	TRY(start_home(world));
	TRY(start_surface(world));
	TRY(world_budget_check(world));
	TRY(go_on_with_ground(world));
	TRY(world_forces_create(world, &world->forces));
	if (world->params.draws)
		TRY(make_pyramid(world));
	world_enter(world, WORLD_STARTED);
	return STATUS_OK;
}

/* --- pages --- */

static enum status before_read_back(void *user, struct tile tile, uint32_t slot)
{
	struct world *world = user;
	return world->resident.pyramid != NULL ? resident_pyramid_flush_tile(world->resident.pyramid, world->resident.cache, tile, slot) : STATUS_OK;
}

static enum status begin_commit(void *user)
{
	struct world *world = user;
	const struct world_commits *commits = world->commits;
	return commits != NULL && commits->before_record != NULL ? commits->before_record(commits->user) : STATUS_OK;
}

static enum status before_commit(void *user)
{
	const struct world *world = user;
	const struct world_commits *commits = world->commits;
	return commits != NULL && commits->before_commit != NULL ? commits->before_commit(commits->user) : STATUS_OK;
}

static enum status tally_snapshot(void *user, struct gpu_staging *staging)
{
	const struct world *world = user;
	deform_tally_read_into(world->deform, staging, 0);
	return STATUS_OK;
}

static enum status tally_bytes(void *user, uint8_t *bytes)
{
	const struct world *world = user;
	struct deform_tally tally;
	bearing_tally(world->bearing, &tally);
	_Static_assert(sizeof tally == PAGES_TALLY_BYTES, "resident.h");
	memcpy(bytes, &tally, sizeof tally);
	return STATUS_OK;
}

static enum status soil_classes(void *user, unsigned loader, struct tile tile, uint8_t *classes)
{
	const struct world *world = user;
	return resident_soil_map_read(world->resident.soil_map, loader, tile, classes);
}

static enum status soil_numbers(void *user, unsigned loader, struct tile tile, uint8_t *numbers)
{
	const struct world *world = user;
	return resident_soil_rasters_read(world->resident.soil_rasters, loader, tile, numbers);
}

void world_pages_params(const struct world *world, struct pages_params *params)
{
	const struct scene *scene = world->scene;
	*params = (struct pages_params){
		.planes = world_planes(world),
		.level = world->resident.level,
		.count = world->facts.limits.slots,
		.loaders = world->facts.limits.loaders,
		.step_pages = world_step_pages(world),
		.work_pages = world_work_pages(world),
		.images = world->facts.limits.images,
		.record = world_record_pages(scene),
		.commit_age = COMMIT_AGE,
		.commits_begun = world->ranks != NULL,
		.before_read_back = before_read_back,
		.begin_commit = begin_commit,
		.before_commit = before_commit,
		.snapshot = world_deforms(world) && !world_is_bearing(world) ? tally_snapshot : NULL,
		.tally = world_is_bearing(world) ? tally_bytes : NULL,
		.classes = world_needs_soil_map(scene) ? soil_classes : NULL,
		.numbers = world_needs_rasters(scene) ? soil_numbers : NULL,
		.classes_drawn = scene_draws_classes(scene) || scene_covers_by_class(scene),
	};
	params->record.bytes = world_record_bytes_with(scene->object_count, world->params.attached) + world_carried_numbers(world) * sizeof(int64_t) +
			       world_grains_most(world) * sizeof(struct bearing_grain);
	params->queue_bytes = world_queue_bytes(world, params);
}

static enum status take_prefetch(void *user, struct requests *requests)
{
	struct world *world = user;
	for (size_t i = 0; i < world->prefetch.count; i++)
		TRY(resident_requests_add(requests, world->prefetch.requests[i].key, world->prefetch.requests[i].time));
	resident_requests_clear(&world->prefetch);
	return STATUS_OK;
}

enum status world_start_pages(struct world *world, FILE *commit_log, struct page_trace *trace)
{
	struct pages_params params;
	world->commit_log = commit_log;
	world->resident.trace = trace;
	world_pages_params(world, &params);
	params.store = world->resident.store;
	params.gpu = world->resident.gpu;
	params.slots = world->resident.slots;
	params.host = world->resident.host;
	if (world->resident.host != NULL) {
		params.gpu = NULL;
		params.slots = NULL;
	}
	params.before = world->record->sums;
	params.commit_log = commit_log;
	params.trace = trace;
	params.user = world;
	TRY(resident_pages_create(&params, &world->resident.pages));
	world->resident.cache = resident_pages_cache(world->resident.pages);
	if (world->resident.host != NULL && world->resident.slots != NULL)
		resident_pages_mirror(world->resident.pages, world->resident.gpu, world->resident.slots);
	return STATUS_OK;
}

/* --- warming up --- */

/* Pictures of bearing soil need a context that the drive does not. */
static enum status start_mirror(struct world *world)
{
	TRY(start_gpu(world, &(struct gpu_params){.draws = true}));
	resident_pages_mirror(world->resident.pages, world->resident.gpu, world->resident.slots);
	return STATUS_OK;
}

enum status world_start_drawing(struct world *world)
{
	if (world->resident.pyramid != NULL)
		return STATUS_OK;
	/* Coarser tiles of changed pages are made from the store, so commit first. Before the first step there is hardly any. */
	world->params.draws = false;
	if (world_has_begun(world))
		TRY(page_cache_flush(world->resident.cache, world->record));
	if (world->resident.gpu == NULL)
		TRY(start_mirror(world));
	TRY(make_pyramid(world));
	world->params.draws = true;
	return STATUS_OK;
}

static void serve(struct world *world)
{
	resident_look_ahead_serve(world->ahead, &(struct look_ahead_pages){
					       .surface = world_changes_ground(world) ? &world->surface : NULL,
					       .extent = &world->resident.meta->extent,
					       .level = world->resident.level,
					       .cache = world->resident.cache,
					       .slots = world->facts.limits.slots,
					       .requests = world->happened.watched ? take_prefetch : NULL,
					       .user = world,
				       });
}

/* A driver compiles a program at its first draw. That happens here and not in a step. */
static enum status warm_programs(struct world *world)
{
	const struct scene *scene = world->scene;
	const bool deformed = world_planes(world) != 0 && world->resident.host == NULL;
	for (size_t i = 0; i < scene->object_count && world->deform != NULL; i++) {
		const struct deform_planned planned = world_planned(&scene->objects[i]);
		TRY(deform_warm(world->deform, &planned));
	}
	TRY(world_warm_drops(world));
	return world->resident.slots != NULL ? gpu_slots_warm(world->resident.slots, world_division(world), deformed && world->params.draws) : STATUS_OK;
}

/* By the end the ground of the first steps is read, too. */
enum status world_warm(struct world *world)
{
	const struct world_ranks *ranks = world->ranks;
	const enum status warmed = warm_programs(world);
	/* Ranks agree, so that nothing is loaded for bodies of other ranks. */
	TRY(ranks != NULL ? ranks->step(ranks->user, world_step_time(world->scene, world->step + 1), warmed) : warmed);
	serve(world);
	const double began = clock_seconds();
	TRY(resident_look_ahead_first(world->ahead, world->time, world->params.stop));
	world->counts.warmed.load_ms = (clock_seconds() - began) * 1e3;
	world_enter(world, WORLD_WARM);
	return STATUS_OK;
}

void world_seal(struct world *world)
{
	if (world->resident.gpu == NULL)
		return;
	gpu_finish(world->resident.gpu);
	gpu_stats(world->resident.gpu, &world->counts.warmed.gpu);
	gpu_slots_figures(world->resident.slots, &world->counts.warmed.slots);
	if (!world->scene->hosted) /* later bodies and pictures of a host need more programs */
		gpu_seal(world->resident.gpu);
}

/* --- the end --- */

void world_stop(struct world *world)
{
	if (world == NULL)
		return;
	if (world->phase != WORLD_ENDED)
		world_enter(world, WORLD_ENDED);
	resident_look_ahead_stop(world->ahead);
	if (world->resident.pages != NULL)
		resident_pages_stop(world->resident.pages);
}

void world_forked(const struct world *world)
{
	store_forked(world->resident.store);
	if (world->commit_log != NULL)
		close(fileno(world->commit_log));
}

void world_finish(struct world *world, enum status status)
{
	if (world == NULL)
		return;
	resident_look_ahead_stop(world->ahead);
	resident_newest_destroy(world->resident.newest);
	resident_pages_destroy(world->resident.pages);
	resident_look_ahead_destroy(world->ahead);
	resident_soil_map_close(world->resident.soil_map);
	world_relief_close(world->relief);
	resident_soil_rasters_close(world->resident.soil_rasters);
	world_soils_met_free(world->facts.met);
	page_trace_destroy(world->resident.trace);
	world_forces_destroy(world->forces);
	resident_pyramid_destroy(world->resident.pyramid);
	world_surface_destroy(world);
	resident_host_destroy(world->resident.host);
	gpu_slots_destroy(world->resident.slots);
	gpu_destroy(world->resident.gpu);
	world_checkpoint_free(world->checkpoint);
	world_changes_finish(world);
	world_batches_free(world);
	world_meetings_free(world);
	crew_destroy(world->crew);
	world_near_free(&world->near);
	world_free_bodies(world);
	key_set_finish(&world->aloft.seen);
	key_set_finish(&world->aloft.old);
	world_happened_finish(world);
	resident_requests_finish(&world->prefetch);
	mem_free_all(world->rows.list, world->events.list, world->events.ahead, world->events.runs);
	if (world->commit_log != NULL)
		fclose(world->commit_log);
	resident_ground_destroy(world->resident.ground);
	store_reader_destroy(world->follower);
	if (status == STATUS_OK)
		store_close(world->resident.store);
	else
		store_abandon(world->resident.store);
	mem_free(world);
}
