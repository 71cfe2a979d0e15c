/*
 * Everything about a drive that is known before it makes anything: its level, its parameters, and its plan. A drive uses these
 * same functions. So the plan and the drive agree.
 */
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "dem/dem.h"
#include "world/internal.h"

/* Assumed without a store: tiles as import makes them, on the widest ground, of little relief. */
enum { ASSUMED_CELLS = 256 };
#define ASSUMED_SPACING 1.0
#define ASSUMED_POSTS ((int64_t)1 << 24)
/* So few bodies would save less in their steps than the many further programs of a model that conserves soil cost at the start. */

/* --- facts that follow from scene and store --- */

enum status world_settle_level(struct world *world)
{
	const struct extent *extent = &world->resident.meta->extent;
	if (!isnan(world->resident.meta->low) && !lattice_fits(world->resident.meta->low, world->resident.meta->high))
		return fail_with(STATUS_INPUT, "store: heights from %g to %g m are more relief than can be deformed (about 16 "
					       "km); import a smaller part, or say what a PNG means with --height-range",
				 world->resident.meta->low, world->resident.meta->high);
	world->resident.was_deformed = store_has_working_level(world->resident.store, NULL);
	world->facts.slip_sinkage = world->resident.was_deformed || scene_slips(world->scene) ? world->scene->slip_sinkage : 0;
	double asked = world->scene->spacing;
	int level = 0;
	if (asked > 0) {
		level = extent_level_for(extent, asked);
		if (level < TILE_LEVEL_MIN)
			return fail_with(STATUS_INPUT, "spacing: %g m is finer than %s m, the finest this store can be divided to; "
						       "give that or more, or import with a finer --spacing",
					 asked, number_exact(extent_spacing(extent, TILE_LEVEL_MIN)).text);
	} else {
		store_has_working_level(world->resident.store, &level); /* stays 0 without one */
	}
	world->resident.level = level;
	world->resident.spacing = extent_spacing(extent, level);
	return store_set_working_level(world->resident.store, level);
}

unsigned world_planes(const struct world *world)
{
	const struct scene *scene = world->scene;
	unsigned planes = deform_planes(scene->model, scene->disturbance && scene->heals <= 0, (scene->heals > 0 ? DEFORM_HEALS : 0) |
								    (scene->vegetation.present ? DEFORM_GROWS : 0) | (world->facts.slip_sinkage > 0 ? DEFORM_DIGS : 0) |
								    (scene->loosening > 0 ? DEFORM_LOOSENS : 0) | (scene->hardening > 0 ? DEFORM_HARDENS : 0) |
								    (deform_slopes_count(scene->model, scene->soils, scene->soil_count) ? DEFORM_SLOPES : 0));
	if (scene->object_count > 0 || scene_moves_bodies(scene))
		return planes;
	return world->resident.was_deformed && scene->view.present ? planes & GPU_DRAWN_PLANES : 0;
}

uint64_t world_effects(const struct world *world)
{
	uint64_t effects = scene_effects(world->scene, world->resident.level);
	if (world->facts.limits.all)
		effects &= ~(EFFECT_BIT(EFFECT_LOADERS) | EFFECT_BIT(EFFECT_PREFETCH));
	if (world->facts.slip_sinkage > 0 && world_deforms(world))
		effects |= EFFECT_BIT(EFFECT_SLIP);
	return effects;
}

bool world_needs_soil_map(const struct scene *scene)
{
	bool read = deform_model_row(scene->model)->numbers != NULL &&
		    (scene->object_count > 0 || scene_moves_bodies(scene));
	return scene_has_classes(scene) && (read || scene_draws_classes(scene) || scene_covers_by_class(scene));
}

enum status world_open_soil_map(struct world *world)
{
	const struct scene *scene = world->scene;
	struct road_part *parts = NULL;
	size_t part_count = 0;
	if (!world_needs_soil_map(scene))
		return STATUS_OK;
	enum status status = world_road_parts(world, &parts, &part_count);
	const struct soil_map_params params = {
		.path = scene->soil_map,
		.parts = parts,
		.part_count = part_count,
		.rocks = scene->rocks_soil > 0 ? world_rocks(world) : NULL,
		.rocks_soil = scene->rocks_soil,
		.classes = scene->soil_class,
		.loaders = world->facts.limits.loaders,
		.places = scene_moves_bodies(scene) || (scene->forces > 0 && scene->object_count > 0),
		.meta = world->resident.meta,
	};
	if (status == STATUS_OK)
		status = resident_soil_map_open(&params, &world->resident.soil_map);
	mem_free(parts);
	return status;
}

size_t world_batched_bodies(const struct world *world, const struct deform_params *params)
{
	size_t count = 0;
	for (size_t i = 0; i < world->scene->object_count; i++) {
		const struct deform_planned planned = world_planned(&world->scene->objects[i]);
		count += world->scene->objects[i].path.count > 0 && deform_batches(params, &planned);
	}
	return count;
}

void world_deform_params(const struct world *world, struct deform_params *params)
{
	const struct scene *scene = world->scene;
	*params = (struct deform_params){
		.extent = &world->resident.meta->extent,
		.level = world->resident.level,
		.model = scene->model,
		.box_radius = scene->box_radius,
		.box_repetitions = scene->box_repetitions,
		.soil_count = scene->soil_count,
		.iterations = scene->iterations,
		.along_lines = true,
		.relief = isnan(world->resident.meta->low) ? 0 : world->resident.meta->high - world->resident.meta->low + 2 * relief_bound(world_relief(world), 0) + rocks_bound(world_rocks(world)),
		.depth = scene->depth,
		.undisturbed_stable = scene->undisturbed == SCENE_STABLE,
		.unsettled = world->resident.was_deformed,
		.tolerance = scene->tolerance,
		.bulldozing = scene->bulldozing,
		.slip_sinkage = world->facts.slip_sinkage,
		.loosening = scene->loosening, .hardening = scene->hardening,
		.ground_normals = scene->normals == SCENE_GROUND,
		.faces = scene->faces == SCENE_FACES_ON,
		.inertia = scene->inertia,
		.tension = scene->tension, .stiffness = scene->stiffness, .yield = scene->yield, .rut = scene->rut,
		.thrown = scene->thrown == SCENE_THROWN_ON, .gravity = scene->gravity,
		.touched = world_asks_touched(world),
		.disturbance = scene->disturbance && scene->heals <= 0,
		.batches = !world->params.alone && scene->regions == SCENE_WINDOWS && !world_keeps_marks(scene),
		.fixed = scene->regions == SCENE_FIXED_REGIONS && !world_keeps_marks(scene), /* marks that fade are written by windows */
	};
	const struct store_marks marks = {.heals = scene->heals, .rises = scene->vegetation.rises, .grows = scene->vegetation.grows};
	const struct plane_marks whole = store_marks_at(&marks, 0);
	params->heals = whole.heals;
	params->rises = whole.rises;
	params->grows = whole.grows;
	memcpy(params->soils, scene->soils, sizeof params->soils);
	params->raster_count = world_rasters(world, params->rasters);
	bool by_raster = false;
	for (int i = 0; i < params->raster_count; i++)
		by_raster = by_raster || params->rasters[i].number == SOIL_THICKNESS;
	for (int i = 0; i < params->soil_count && !by_raster; i++)
		soil_end_layer(&params->soils[i]);
	for (size_t i = 0; i < scene->object_count && i < world->body_count; i++)
		params->loaded_bodies += world->bodies[i]->loaded_body > 0;
	params->batches = world_batched_bodies(world, params) >= 2;
	params->roofs = world_has_rests(world);
}

bool world_computes_together(const struct world *world)
{
	struct deform_params params;
	world_deform_params(world, &params);
	return params.batches && !deform_conserves(params.model) && !world_is_bearing(world);
}

/* A host may turn a wheel as it likes. */
static bool leans(const struct scene_object *object)
{
	bool found = object->path.count == 0 || object->path.attitude[2] != 0;
	for (size_t i = 0; i < object->path.count && object->path.has_attitude; i++)
		found = found || object->path.points[i].roll != 0;
	return found && object->shape.kind == SOIL_WHEEL;
}

struct deform_planned world_planned(const struct scene_object *object)
{
	return (struct deform_planned){&object->shape, object->path.count != 1, leans(object)};
}

/* --- advice --- */

double world_all_tiles(const struct world *world)
{
	const struct extent *extent = &world->resident.meta->extent;
	double tiles = 0;
	for (int level = world->resident.level; level <= extent_coarsest(extent); level++)
		tiles += (double)extent_tiles_x(extent, level) * extent_tiles_y(extent, level);
	return tiles;
}

/* The store can only be divided by powers of two. A spacing in between becomes finer, with up to four times as many posts. */
static void advise_spacing(const struct world *world, scene_advice_fn tell, void *user)
{
	const struct extent *extent = &world->resident.meta->extent;
	double asked = world->scene->spacing, is = world->resident.spacing;
	char text[240];
	if (!(asked > 1.01 * is))
		return;
	if (world->resident.level == extent_coarsest(extent))
		snprintf(text, sizeof text, "spacing: %g m: posts will be %s m apart, and this store has none that are farther; give %s",
			 asked, number_exact(is).text, number_exact(is).text);
	else
		snprintf(text, sizeof text, "spacing: %g m: posts will be %s m apart, the coarsest of this store that is at most that; give "
					    "%s, or %s for a quarter of the posts",
			 asked, number_exact(is).text, number_exact(is).text, number_exact(extent_spacing(extent, world->resident.level + 1)).text);
	tell(user, text);
}

/* Returns true if the path's first point is on the terrain with its coordinates of `srs` in the other order. */
static bool is_swapped(const struct world *world, const struct scene_path *path, const char *srs)
{
	double x = path->points[0].y, y = path->points[0].x;
	if (dem_transform(srs, world->resident.meta->srs, 1, &x, &y) != STATUS_OK)
		return false;
	x -= world->resident.meta->origin[0];
	y -= world->resident.meta->origin[1];
	return extent_holds(&world->resident.meta->extent, x, y);
}

/* Writes what is probably wrong with a path far off the terrain. */
static void guess_far(const struct world *world, const struct scene_path *path, char *hint, size_t room)
{
	const struct scene *scene = world->scene;
	const char *srs = path->degrees ? DEM_SRS_DEGREES : scene->coordinates == SCENE_SRS ? scene->srs : NULL;
	if (srs != NULL && is_swapped(world, path, srs))
		snprintf(hint, room, "; are its %s swapped?", strcmp(srs, DEM_SRS_DEGREES) == 0 ? "longitude and latitude" : "x and y");
	else if (path->degrees)
		hint[0] = '\0';
	else if (scene->coordinates == SCENE_LOCAL)
		snprintf(hint, room, "; if these are coordinates of a reference system, say which in coordinates");
	else
		snprintf(hint, room, "; is coordinates: %.80s right?", srs != NULL ? srs : "store");
}

/* Tells about paths that leave the terrain before the drive ends. It names the first to leave. It does not look for holes. */
static void advise_leaving(const struct world *world, scene_advice_fn tell, void *user)
{
	const struct scene *scene = world->scene;
	const struct extent *extent = &world->resident.meta->extent;
	const double width = extent_side(extent, 0), height = extent_side(extent, 1);
	struct track_point at = {.time = INFINITY};
	const struct body *first = NULL;
	size_t leaving = 0;
	char text[560], others[40] = "", hint[160] = "";
	for (size_t i = 0; i < scene->object_count; i++) {
		const struct body *body = world->bodies[i];
		if (body->kind != BODY_PATH)
			continue;
		int64_t sample = motion_track_leaves(body->track, width, height);
		double time = sample >= 0 ? motion_track_sample_time(body->track, sample) : INFINITY;
		if (time > scene->end_time)
			continue;
		leaving++;
		if (time >= at.time)
			continue;
		first = body;
		motion_track_sample(body->track, sample, &at);
	}
	if (first == NULL)
		return;
	if (leaving > 1)
		snprintf(others, sizeof others, ", and %zu other%s later", leaving - 1, leaving > 2 ? "s" : "");
	const bool far = world->resident.meta->srs[0] != '\0' && (fabs(at.x - width / 2) > 10 * width || fabs(at.y - height / 2) > 10 * height);
	if (far)
		guess_far(world, &first->object->path, hint, sizeof hint);
	snprintf(text, sizeof text, "objects.%s.path: is off the terrain after %.6g s, at %.3f, %.3f m%s: %s; keep within 0 to %g, 0 to %g m%s%s",
		 first->object->name, at.time, at.x, at.y, others,
		 scene->outside == SCENE_STOP ? "the drive will stop there" : "nothing is pressed there", width, height,
		 scene->outside == SCENE_STOP ? ", end before, or set outside: skip" : "",
		 hint);
	tell(user, text);
}

/* Tells the first point of each vehicle's path that is not over the terrain. It does not look for holes. */
static void advise_ways(const struct world *world, scene_advice_fn tell, void *user)
{
	const struct extent *extent = &world->resident.meta->extent;
	for (size_t v = 0; v < world->scene->vehicle_count; v++) {
		const struct scene_vehicle *vehicle = &world->scene->vehicles[v];
		struct scene_path route;
		char text[300];
		if (vehicle->driver != SCENE_FOLLOW || world_route(world, &vehicle->way, vehicle->name, &route) != STATUS_OK)
			continue; /* a drive refuses a path that is nowhere */
		for (size_t i = 0; i < route.count; i++) {
			const double x = route.points[i].x, y = route.points[i].y;
			if (extent_holds(extent, x, y))
				continue;
			snprintf(text, sizeof text, "vehicles.%s.driver.path: point %zu, at %.3f, %.3f m, is off the terrain, where the drive would end; "
						    "keep within 0 to %g, 0 to %g m", vehicle->name, i + 1, x, y, extent_side(extent, 0), extent_side(extent, 1));
			tell(user, text);
			break;
		}
		motion_route_finish(&route);
	}
}

double world_way_at(const struct track *track, double time)
{
	double(*places)[2] = mem_alloc(motion_track_corners(track), sizeof *places), way = 0;
	if (places == NULL)
		return NAN;
	const size_t count = motion_track_way(track, time, places);
	for (size_t i = 1; i < count; i++)
		way += hypot(places[i][0] - places[i - 1][0], places[i][1] - places[i - 1][1]);
	mem_free(places);
	return way;
}

/* Tells about paths of which the drive's end cuts off more than a time step and a path sample. It names the one that needs the most time. */
static void advise_unfinished(const struct world *world, scene_advice_fn tell, void *user)
{
	const struct scene *scene = world->scene;
	const struct body *longest = NULL;
	double needed = 0;
	size_t unfinished = 0;
	char text[400], others[64] = "";
	for (size_t i = 0; i < scene->object_count; i++) {
		const struct track *track = world->bodies[i]->track;
		const int64_t samples = track != NULL ? motion_track_samples(track) : INT64_MAX;
		if (samples == INT64_MAX || motion_track_sample_time(track, 0) > scene->end_time)
			continue;
		const double end = motion_track_sample_time(track, samples - 1);
		if (end <= scene->end_time + scene->time_step || motion_track_sample_time(track, samples - 2) <= scene->end_time)
			continue;
		unfinished++;
		if (end <= needed)
			continue;
		needed = end;
		longest = world->bodies[i];
	}
	if (longest == NULL)
		return;
	if (unfinished > 1)
		snprintf(others, sizeof others, ", and %zu other%s not at the end either", unfinished - 1, unfinished > 2 ? "s are" : " is");
	snprintf(text, sizeof text, "objects.%s.path: the drive ends after %.6g s, when it has come %.4g m of %.4g m%s; the whole path takes %.6g s: give "
				    "end_time %s, or a shorter path", longest->object->name, scene->end_time, world_way_at(longest->track, scene->end_time),
		 world_way_at(longest->track, needed), others, needed, number_at_least(ceil(needed * 1e3) / 1e3, 6).text);
	tell(user, text);
}

void world_advise(const struct world *world, scene_advice_fn tell, void *user)
{
	const struct scene *scene = world->scene;
	struct scene_parameter slots;
	char text[200];
	scene_parameter("cache.slots", &slots); /* the default was not asked for */
	bool known = world->resident.store != NULL || scene->spacing > 0;
	scene_advise(scene, known ? world->resident.spacing : 0, tell, user);
	world_advise_rasters(world, tell, user);
	world_advise_soils_met(world, tell, user);
	world_advise_planet(world, tell, user);
	if (world->resident.store != NULL) {
		advise_spacing(world, tell, user);
		advise_leaving(world, tell, user);
		advise_ways(world, tell, user);
		advise_unfinished(world, tell, user);
		world_advise_samples(world, tell, user);
		world_advise_relief(world, tell, user);
	}
	world_advise_limits(world, tell, user);
	if (scene->memory > 0)
		return;
	double tiles = world->resident.store != NULL ? world_all_tiles(world) : INFINITY, enough = fmax(tiles, slots.low);
	if (enough >= scene->slots || scene->slots == slots.absent)
		return;
	snprintf(text, sizeof text, "cache.slots: %u, and the store has %.0f tile%s at this spacing: the others stay empty; give %.0f",
		 scene->slots, tiles, tiles == 1 ? "" : "s", enough);
	tell(user, text);
}

/* --- plans --- */

enum status world_plan_deform(const struct world *world, const struct soil_shape *const *added, size_t count, struct plan *plan)
{
	const struct scene *scene = world->scene;
	const size_t all = scene->object_count + count;
	if (all == 0)
		return STATUS_OK;
	struct deform_params params;
	struct deform_planned *objects = mem_calloc(all, sizeof *objects);
	TRY_MEM(objects, "the plan");
	for (size_t i = 0; i < scene->object_count; i++)
		objects[i] = world_planned(&scene->objects[i]);
	for (size_t i = 0; i < count; i++)
		objects[scene->object_count + i] = world_planned_host(added[i]);
	world_deform_params(world, &params);
	world_crew_plan(world, plan);
	world_carried_plan(world, plan);
	world_thrown_plan(world, plan);
	if (world_is_bearing(world))
		bearing_plan(&params, plan);
	else
		deform_plan(&params, objects, all, plan);
	mem_free(objects);
	return STATUS_OK;
}

void world_plan_pages(const struct world *world, struct plan *plan)
{
	const struct scene *scene = world->scene;
	const bool deforms = scene->object_count > 0 || scene->vehicle_count > 0;
	const struct pages_planned planned = {
		.cells = world->resident.meta->extent.cells,
		.planes = world_planes(world),
		.loaders = world->facts.limits.loaders,
		.was_deformed = world->resident.was_deformed,
		.history = world->params.keep_history || (world->resident.store != NULL && store_has_history(world->resident.store)),
		.inherits = world->resident.store != NULL && store_depth(world->resident.store) > 0,
		.deforms = deforms,
		.lowers = deforms && !deform_raises(scene->model),
		.classes = world_needs_soil_map(scene),
		.numbers = world_needs_rasters(scene),
		.picture = scene->view.present,
		.host = world_is_bearing(world),
		.loaders_effect = scene_effect_row(EFFECT_LOADERS)->name,
		.classes_effect = scene_effect_row(EFFECT_SOIL_MAP)->name,
		.numbers_effect = scene_effect_row(EFFECT_SOIL_RASTERS)->name,
		.picture_effect = scene_effect_row(EFFECT_PICTURE)->name,
	};
	resident_pages_plan(&planned, plan);
	resident_look_ahead_plan(world->facts.limits.prefetch, scene->object_count, scene_effect_row(EFFECT_PREFETCH)->name, plan);
}

uint64_t world_samples_until(const struct track *track, double end)
{
	int64_t low = 0, high = 1, all = motion_track_samples(track);
	while (high < all && motion_track_sample_time(track, high) <= end) {
		low = high;
		high = high < all / 2 ? 2 * high : all;
	}
	if (motion_track_sample_time(track, 0) > end)
		return 0;
	/* Sample `low` is due. Sample `high`, if it exists, is not due, or is the last. */
	while (high - low > 1) {
		int64_t middle = low + (high - low) / 2;
		if (motion_track_sample_time(track, middle) <= end)
			low = middle;
		else
			high = middle;
	}
	return (uint64_t)low + 1;
}

/* --- over what --- */

static enum status over_store(struct world *world, const char *path)
{
	TRY(store_open(path, &(struct store_options){.mode = STORE_READ}, &world->resident.store));
	world->resident.meta = store_meta(world->resident.store);
	world_settle_light(world);
	TRY(world_settle_level(world));
	return world_settle_relief(world);
}

static enum status over_nothing(struct world *world, struct store_meta *assumed)
{
	const struct scene *scene = world->scene;
	if (scene->coordinates == SCENE_SRS)
		return fail_with(STATUS_INPUT, "%s: coordinates: %s lie on a store's ground, and none is known; give --store", scene->file,
				 scene->srs);
	for (size_t i = 0; i < scene->object_count; i++)
		if (scene->objects[i].path.degrees)
			return fail_with(STATUS_INPUT, "%s: the path of %s is in longitude and latitude, on a store's ground, and none is known; give --store",
					 scene->file, scene->objects[i].name);
	double spacing = scene->spacing > 0 ? scene->spacing : ASSUMED_SPACING;
	*assumed = (struct store_meta){
		.extent = {ASSUMED_POSTS, ASSUMED_POSTS, spacing, ASSUMED_CELLS},
		.srs = "",
		.vertical = "",
		.sources = "",
	};
	world->resident.meta = assumed;
	world_settle_light(world);
	world->resident.spacing = spacing;
	world->facts.slip_sinkage = scene_slips(scene) ? scene->slip_sinkage : 0;
	return STATUS_OK;
}

enum status world_open_plan(const struct scene *scene, const char *store, bool keep_history, const struct world_aboard_shapes *aboard, struct store_meta *assumed,
			    struct world **out)
{
	const struct world_params params = {.scene = scene, .rows = true, .keep_history = keep_history, .aboard_shapes = aboard != NULL ? aboard->list : NULL,
					    .carrying_count = aboard != NULL ? aboard->count : 0};
	TRY(world_make(&params, out));
	struct world *world = *out;
	TRY(store != NULL ? over_store(world, store) : over_nothing(world, assumed));
	TRY(world_make_bodies(world));
	TRY(world_settle_limits(world));
	/* A drive refuses a map or a raster of the soil that cannot be read, so this does too. */
	if (store != NULL) {
		TRY(world_open_soil_map(world));
		TRY(world_open_rasters(world));
	}
	return world_find_soils_met(world);
}

enum status world_open_ended(const struct scene *scene, const char *store, int64_t step, double time, struct world **out)
{
	TRY(world_open_plan(scene, store, false, NULL, NULL, out));
	struct world *world = *out;
	world->step = step;
	world->time = time;
	return resident_ground_create(world->resident.store, world->facts.limits.ground, &world->resident.ground);
}
