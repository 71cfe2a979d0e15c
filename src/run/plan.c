/*
 * Everything that is known of a drive before it makes anything: its level, its parameters, and the plan of what it will
 * make and run. What a drive does by these it does by these functions alone, so that the plan cannot say otherwise.
 */
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "render/render.h"
#include "run/internal.h"

#define GROUND_BYTES (64 << 20)
enum { GROUND_LEAST = 16, GROUND_MOST = 256 }; /* tiles */

/* Where there is no store: tiles as import makes them, on ground as wide as can be, of little relief. */
enum { ASSUMED_CELLS = 256 };
#define ASSUMED_SPACING 1.0
#define ASSUMED_POSTS ((int64_t)1 << 24)

/* --- what follows from scene and store --- */

enum status drive_settle_level(struct drive *drive)
{
	const struct world *world = &drive->meta->world;
	if (!isnan(drive->meta->low) && !lattice_fits(drive->meta->low, drive->meta->high))
		return fail_with(STATUS_INPUT, "store: heights from %g to %g m are more relief than can be deformed (about 16 "
					       "km); import a smaller part, or say what a PNG means with --height-range",
				 drive->meta->low, drive->meta->high);
	drive->was_deformed = store_has_working_level(drive->store, NULL);
	double asked = drive->scene->spacing;
	int level = 0;
	if (asked > 0) {
		level = world_level_for(world, asked);
		if (level < TILE_LEVEL_MIN)
			return fail_with(STATUS_INPUT, "spacing: %g m is finer than %g m, the finest this store can be divided to; "
						       "raise it, or import with a finer --spacing",
					 asked, world_spacing(world, TILE_LEVEL_MIN));
	} else {
		store_has_working_level(drive->store, &level); /* stays 0 without one */
	}
	drive->level = level;
	drive->spacing = world_spacing(world, level);
	return store_set_working_level(drive->store, level);
}

/* Tiles of the ground: a few for each object, while that is not too much. */
uint32_t drive_ground_tiles(const struct drive *drive)
{
	size_t side = tile_posts(&drive->meta->world), most = GROUND_BYTES / (side * side * sizeof(int32_t));
	size_t tiles = 4 + 4 * drive->scene->object_count;
	tiles = tiles < most ? tiles : most;
	tiles = tiles < GROUND_MOST ? tiles : GROUND_MOST;
	return tiles > GROUND_LEAST ? (uint32_t)tiles : GROUND_LEAST;
}

void drive_deform_params(const struct drive *drive, struct deform_params *params)
{
	const struct scene *scene = drive->scene;
	*params = (struct deform_params){
		.world = &drive->meta->world,
		.level = drive->level,
		.model = scene->model,
		.box_radius = scene->box_radius,
		.box_repetitions = scene->box_repetitions,
		.soil_count = scene->soil_count,
		.iterations = scene->iterations,
		.relief = isnan(drive->meta->low) ? 0 : drive->meta->high - drive->meta->low,
		.depth = scene->depth,
		.stands = scene->undisturbed == SCENE_STANDS,
		.tolerance = scene->tolerance,
		.bulldozing = scene->bulldozing,
		.touched = drive_asks_touched(drive),
		.dirt = scene->dirt,
	};
	memcpy(params->soils, scene->soils, sizeof params->soils);
	for (size_t i = 0; i < scene->object_count; i++)
		params->carriers += drive->riders[i].carrier > 0;
}

struct deform_planned drive_planned(const struct scene_object *object)
{
	return (struct deform_planned){&object->shape, object->load, object->path.count > 1};
}

/* --- advice --- */

/* Tiles that there are at all, of the working level and coarser ones. */
static double all_tiles(const struct drive *drive)
{
	const struct world *world = &drive->meta->world;
	double tiles = 0;
	for (int level = drive->level; level <= world_coarsest(world); level++)
		tiles += (double)world_tiles_x(world, level) * world_tiles_y(world, level);
	return tiles;
}

/* A spacing that the store cannot be divided to is taken finer, for up to four times the posts that were meant. */
static void advise_spacing(const struct drive *drive, scene_advice_fn tell, void *user)
{
	const struct world *world = &drive->meta->world;
	double asked = drive->scene->spacing, is = drive->spacing;
	char text[240];
	if (!(asked > 1.01 * is))
		return;
	if (drive->level == world_coarsest(world))
		snprintf(text, sizeof text, "spacing: %g m: posts will be %g m apart, and this store has none that are farther; give %g",
			 asked, is, is);
	else
		snprintf(text, sizeof text, "spacing: %g m: posts will be %g m apart, the coarsest of this store that is at most that; give "
					    "%g, or %g for a quarter of the posts",
			 asked, is, is, world_spacing(world, drive->level + 1));
	tell(user, text);
}

/* Paths that leave the terrain before the drive ends: the one that does so first is named. Holes are not looked for. */
static void advise_leaving(const struct drive *drive, scene_advice_fn tell, void *user)
{
	const struct scene *scene = drive->scene;
	const struct world *world = &drive->meta->world;
	double width = (double)(world->width - 1) * world->spacing, height = (double)(world->height - 1) * world->spacing;
	struct track_point at = {.time = INFINITY};
	const struct rider *first = NULL;
	size_t leaving = 0;
	char text[480], others[40] = "";
	for (size_t i = 0; i < scene->object_count; i++) {
		const struct rider *rider = &drive->riders[i];
		int64_t station = track_leaves(rider->track, width, height);
		double time = station >= 0 ? track_station_time(rider->track, station) : INFINITY;
		if (time > scene->end_time)
			continue;
		leaving++;
		if (time >= at.time)
			continue;
		first = rider;
		track_station(rider->track, station, &at);
	}
	if (first == NULL)
		return;
	if (leaving > 1)
		snprintf(others, sizeof others, ", and %zu other%s later", leaving - 1, leaving > 2 ? "s" : "");
	snprintf(text, sizeof text, "objects.%s.path: is off the terrain after %.6g s, at %.3f, %.3f m%s: %s; keep within 0 to %g, 0 to %g m%s",
		 first->object->name, at.time, at.x, at.y, others,
		 scene->outside == SCENE_STOP ? "the drive will stop there" : "nothing is pressed there", width, height,
		 scene->outside == SCENE_STOP ? ", end before, or set outside: skip" : "");
	tell(user, text);
}

void drive_advise(const struct drive *drive, scene_advice_fn tell, void *user)
{
	const struct scene *scene = drive->scene;
	struct scene_parameter slots;
	char text[200];
	scene_parameter("cache.slots", &slots); /* the default was not asked for */
	bool known = drive->store != NULL || scene->spacing > 0;
	scene_advise(scene, known ? drive->spacing : 0, tell, user);
	if (drive->store != NULL) {
		advise_spacing(drive, tell, user);
		advise_leaving(drive, tell, user);
	}
	double tiles = drive->store != NULL ? all_tiles(drive) : INFINITY, enough = fmax(tiles, slots.low);
	if (enough >= scene->slots || scene->slots == slots.absent)
		return;
	snprintf(text, sizeof text, "cache.slots: %u, and the store has %.0f tile%s at this spacing: the others stay empty; give %.0f",
		 scene->slots, tiles, tiles == 1 ? "" : "s", enough);
	tell(user, text);
}

/* Room for one more is made before it is filled; a failure is kept by `failed`. */
struct notes {
	struct run_plan *plan;
	bool failed;
};

static void keep_note(void *user, const char *text)
{
	struct notes *notes = user;
	struct run_plan *plan = notes->plan;
	char **grown = mem_realloc(plan->notes, plan->note_count + 1, sizeof *grown);
	char *copy = mem_strdup(text);
	if (grown != NULL)
		plan->notes = grown;
	if (grown != NULL && copy != NULL)
		grown[plan->note_count++] = copy;
	else
		mem_free(copy);
	notes->failed = notes->failed || grown == NULL || copy == NULL;
}

/* --- the plan --- */

static enum status plan_deform(const struct drive *drive, struct plan *plan)
{
	const struct scene *scene = drive->scene;
	struct deform_params params;
	struct deform_planned *objects = mem_calloc(scene->object_count, sizeof *objects);
	if (objects == NULL)
		return fail_memory("the plan");
	for (size_t i = 0; i < scene->object_count; i++)
		objects[i] = drive_planned(&scene->objects[i]);
	drive_deform_params(drive, &params);
	deform_plan(&params, objects, scene->object_count, scene->forces > 0, plan);
	mem_free(objects);
	return STATUS_OK;
}

void drive_render_params(const struct drive *drive, struct render_params *params)
{
	const struct scene *scene = drive->scene;
	*params = (struct render_params){
		.world = &drive->meta->world,
		.width = scene->view.width,
		.height = scene->view.height,
		.effects = scene->view.effects,
		.dirt = scene->dirt,
		.pixel_error = scene->view.pixel_error,
		.samples = scene->view.samples,
		.objects = scene->objects,
		.object_count = scene->object_count,
		.light = &scene->view.light,
		.soils = scene_draws_classes(scene) ? scene : NULL,
	};
}

static enum status plan_lines(const struct drive *drive, struct plan *plan)
{
	const struct scene *scene = drive->scene;
	uint32_t cells = drive->meta->world.cells;
	unsigned planes = pages_planes_of(scene, drive->was_deformed);
	bool classes = soil_map_needed(scene);
	bool decimates = planes != 0 && scene->view.present;
	enum status status = scene->object_count > 0 ? plan_deform(drive, plan) : STATUS_OK;
	/* Its planes come first: what calls for the offset has the tiles deformed. */
	const char *effect = plan->count > 0 ? plan->lines[0].effect : NULL;
	gpu_slots_plan(cells, planes, classes, drive->level < 0, decimates, effect, plan);
	if (scene->view.present) {
		struct render_params render;
		drive_render_params(drive, &render);
		render_plan(&render, planes != 0, drive->level < 0, plan);
		if (scene->view.images > 0)
			pictures_plan((uint32_t)scene->view.width, (uint32_t)scene->view.height, plan);
	}
	pages_plan(scene, cells, drive->was_deformed, plan);
	scout_plan(scene->prefetch, scene->object_count, plan);
	return status == STATUS_OK ? plan_status(plan) : status;
}

/* Stations that are due until the end. */
static uint64_t stations_of(const struct track *track, double end)
{
	int64_t low = 0, high = 1, all = track_stations(track);
	while (high < all && track_station_time(track, high) <= end) {
		low = high;
		high = high < all / 2 ? 2 * high : all;
	}
	if (track_station_time(track, 0) > end)
		return 0;
	/* [low] is due; [high], if there is one, is not, or is the last. */
	while (high - low > 1) {
		int64_t middle = low + (high - low) / 2;
		if (track_station_time(track, middle) <= end)
			low = middle;
		else
			high = middle;
	}
	return (uint64_t)low + 1;
}

static enum status describe(struct drive *drive, struct run_plan *out)
{
	const struct scene *scene = drive->scene;
	struct pages_budget most;
	struct notes notes = {.plan = out};
	enum status status = budget_check(drive);
	if (status != STATUS_OK)
		return status;
	budget_bytes(drive, &most);
	out->effects = scene_effects(scene, drive->level);
	out->cells = drive->meta->world.cells;
	out->level = drive->level;
	out->spacing = drive->spacing;
	out->deformed = drive->was_deformed;
	out->most.slots = most.slots;
	out->most.loads = most.loads;
	out->most.queue = most.queue;
	out->most.queue_few = most.queue_few;
	out->most.ground = most.ground;
	out->window_tiles = drive->window_tiles;
	out->steps = (int64_t)drive_steps_until(scene, scene->end_time);
	out->pictures = scene->view.present ? out->steps : 0;
	out->stations = mem_calloc(scene->object_count + 1, sizeof *out->stations);
	if (out->stations == NULL)
		return fail_memory("the plan");
	for (size_t i = 0; i < scene->object_count; i++)
		out->stations[i] = stations_of(drive->riders[i].track, scene->end_time);
	drive_advise(drive, keep_note, &notes);
	status = plan_lines(drive, &out->plan);
	return status == STATUS_OK && notes.failed ? fail_memory("the plan") : status;
}

/* --- over what --- */

static enum status over_store(struct drive *drive, const char *path, struct run_plan *out)
{
	enum status status = store_open(path, &(struct store_options){.mode = STORE_READ}, &drive->store);
	if (status != STATUS_OK)
		return status;
	out->store = mem_strdup(path);
	drive->meta = store_meta(drive->store);
	status = out->store != NULL ? drive_settle_level(drive) : fail_memory("the plan");
	/* A drive would refuse one that cannot be read. */
	return status == STATUS_OK ? soil_map_open(drive->scene, drive->meta, &drive->soil_map) : status;
}

static enum status over_nothing(struct drive *drive, struct store_meta *assumed)
{
	const struct scene *scene = drive->scene;
	if (scene->coordinates == SCENE_SRS)
		return fail_with(STATUS_INPUT, "%s: coordinates: %s lie on a store's ground, and none is known; give --store", scene->file,
				 scene->srs);
	double spacing = scene->spacing > 0 ? scene->spacing : ASSUMED_SPACING;
	*assumed = (struct store_meta){
		.world = {ASSUMED_POSTS, ASSUMED_POSTS, spacing, ASSUMED_CELLS},
		.srs = "",
		.vertical = "",
		.sources = "",
	};
	drive->meta = assumed;
	drive->spacing = spacing;
	return STATUS_OK;
}

enum status run_plan(const struct scene *scene, const char *store, struct run_plan *out)
{
	struct drive drive = {.scene = scene};
	struct store_meta assumed;
	const char *path = store;
	if (path == NULL && scene->store != NULL && access(scene->store, F_OK) == 0)
		path = scene->store;
	*out = (struct run_plan){.store = NULL};
	if (path == NULL && scene->store != NULL && (out->missing = mem_strdup(scene->store)) == NULL)
		return fail_memory("the plan");
	enum status status = path != NULL ? over_store(&drive, path, out) : over_nothing(&drive, &assumed);
	if (status == STATUS_OK)
		status = drive_mount(&drive);
	if (status == STATUS_OK) {
		drive.ground_tiles = drive_ground_tiles(&drive);
		status = describe(&drive, out);
	}
	drive_unmount(&drive);
	soil_map_close(drive.soil_map);
	struct failure failure;
	failure_capture(&failure, status);
	store_close(drive.store);
	if (status == STATUS_OK)
		return STATUS_OK;
	run_plan_finish(out);
	return failure_restore(&failure);
}

void run_plan_finish(struct run_plan *plan)
{
	for (size_t i = 0; i < plan->note_count; i++)
		mem_free(plan->notes[i]);
	mem_free(plan->notes);
	mem_free(plan->stations);
	mem_free(plan->store);
	mem_free(plan->missing);
	plan_finish(&plan->plan);
	*plan = (struct run_plan){.store = NULL};
}
