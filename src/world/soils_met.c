/*
 * Which soils lie along the paths of objects and drivers, and what they cannot carry. Found before a drive, at path samples that are spread
 * evenly over what is due until the drive's end. So a map of soils beside the paths is told before the drive, not by its ruts.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "world/internal.h"

#define SAMPLES 1024 /* of all paths together; each path has two at least */
#define VALUES 256   /* of the map */

/* What is at one post. */
struct post_soil {
	int soil, value; /* value: the map's, or SOIL_MAP_NONE, SOIL_MAP_ROAD or SOIL_MAP_ROCK */
	bool has[SOIL_RASTERS];
	struct soil_numbers numbers;
};

/* Needs a post of the terrain. */
static enum status read_post(const struct world *world, int64_t column, int64_t row, struct post_soil *out)
{
	const struct scene *scene = world->scene;
	uint8_t levels[PAGES_NUMBER_BYTES] = {0};
	struct soil_raster rasters[SOIL_RASTERS];
	enum status status = STATUS_OK;
	*out = (struct post_soil){.value = SOIL_MAP_NONE};
	uint8_t soil = 0;
	if (world->resident.soil_map != NULL)
		status = resident_soil_map_value(world->resident.soil_map, world->resident.level, column, row, &out->value, &soil);
	out->soil = soil;
	out->numbers = scene->soils[out->soil];
	if (status != STATUS_OK || world->resident.soil_rasters == NULL)
		return status;
	status = resident_soil_rasters_levels(world->resident.soil_rasters, world->resident.level, column, row, levels);
	const int count = world_rasters(world, rasters);
	for (int i = 0; i < count && status == STATUS_OK; i++) {
		out->has[i] = levels[i] != 0;
		if (out->has[i])
			*soil_number_in(&out->numbers, rasters[i].number) = soil_raster_value(&rasters[i], levels[i]);
	}
	return status;
}

/* Returns the depth at which the soil bears about as much as it ever does, m. A wheel below its axle finds no more soil. A box sinks in whole. */
static double sinks_at_most(const struct soil_shape *shape)
{
	return soil_shape_reach(shape, 0, 0) * (shape->kind == SOIL_WHEEL ? 1 : 2);
}

/* Adds one place, which counts as `weight` path samples. `object` NULL: a driver's. Places off the terrain do not count. */
static enum status add_place(const struct world *world, double x, double y, double weight, const struct scene_object *object, double *least,
			     struct world_soils_met *met)
{
	const struct extent *extent = &world->resident.meta->extent;
	struct post_soil post;
	if (!extent_holds(extent, x, y))
		return STATUS_OK;
	TRY(read_post(world, (int64_t)floor(x / world->resident.spacing + 0.5), (int64_t)floor(y / world->resident.spacing + 0.5), &post));
	met->places++;
	met->all += weight;
	met->soils[post.soil] += weight;
	*(post.value >= 0 ? &met->values[post.value] : post.value == SOIL_MAP_ROAD ? &met->roads : post.value == SOIL_MAP_ROCK ? &met->rocks : &met->none) += weight;
	for (int i = 0; i < SOIL_RASTERS; i++)
		met->numbers[i] += post.has[i] ? weight : 0;
	if (object != NULL && object->load > 0 && deform_tells_forces(world->scene->model)) {
		const double carries = soil_load_at(&object->shape, &object->interface, object->slip, &post.numbers, sinks_at_most(&object->shape));
		if (!(least[post.soil] <= carries)) { /* or nothing yet: NAN */
			least[post.soil] = carries;
			met->weakest[(size_t)(object - world->scene->objects) * SOIL_CLASSES + (size_t)post.soil] = post.numbers;
		}
	}
	return STATUS_OK;
}

static enum status add_track(const struct world *world, const struct track *track, uint64_t most, const struct scene_object *object, double *least,
			     struct world_soils_met *met)
{
	const uint64_t due = world_samples_until(track, world->scene->end_time), count = due < most ? due : most;
	for (uint64_t i = 0; i < count; i++) {
		struct track_point point;
		motion_track_sample(track, (int64_t)(count > 1 ? i * (due - 1) / (count - 1) : 0), &point);
		TRY(add_place(world, point.x, point.y, (double)due / (double)count, object, least, met));
	}
	return STATUS_OK;
}

/* The way of a driver, or where a vehicle starts whose way is not known. */
static enum status add_vehicle(const struct world *world, const struct scene_vehicle *vehicle, uint64_t most, struct world_soils_met *met)
{
	struct scene_path route;
	struct track *track = NULL;
	double at[2];
	if (vehicle->driver != SCENE_FOLLOW) {
		met->partly = true;
		enum status status = world_start_point(world, vehicle, at);
		return status == STATUS_OK ? add_place(world, at[0], at[1], 1, NULL, NULL, met) : status;
	}
	enum status status = world_route(world, &vehicle->way, vehicle->name, &route);
	if (status != STATUS_OK)
		return status;
	status = motion_track_create(&route, world->resident.spacing, 0, &track);
	if (status == STATUS_OK)
		status = add_track(world, track, most, NULL, NULL, met);
	motion_track_destroy(track);
	motion_route_finish(&route);
	return status;
}

static enum status add_all(const struct world *world, struct world_soils_met *met)
{
	const struct scene *scene = world->scene;
	const uint64_t most = SAMPLES / (scene->object_count + scene->vehicle_count) + 2;
	for (size_t i = 0; i < scene->object_count; i++) {
		met->partly = met->partly || world->bodies[i]->kind != BODY_PATH;
		if (world->bodies[i]->kind == BODY_PATH)
			TRY(add_track(world, world->bodies[i]->track, most, &scene->objects[i], &met->least[i * SOIL_CLASSES], met));
	}
	for (size_t i = 0; i < scene->vehicle_count; i++)
		TRY(add_vehicle(world, &scene->vehicles[i], most, met));
	return STATUS_OK;
}

void world_soils_met_free(struct world_soils_met *met)
{
	if (met == NULL)
		return;
	mem_free_all(met->least, met->weakest, met);
}

/* Writes "value 3" or "values 3, 4" of those that some path comes to and no class has. Returns their share of the places. */
static double unlisted(const struct world *world, char *text, size_t room)
{
	const struct world_soils_met *met = world->facts.met;
	double share = 0;
	char list[80] = "";
	size_t used = 0, count = 0;
	for (int value = 0; value < VALUES; value++)
		if (met->values[value] > 0 && world->scene->soil_class[value] == 0) {
			share += met->values[value] / met->all;
			if (count < 8)
				used += (size_t)snprintf(list + used, sizeof list - used, "%s%d", used > 0 ? ", " : "", value);
			count++;
		}
	snprintf(text, room, "value%s %s%s", count == 1 ? "" : "s", list, count > 8 ? ", ..." : "");
	return share;
}

/* Without a default, ground that has no class has no soil. */
static enum status check_covered(const struct world *world)
{
	const struct scene *scene = world->scene;
	const struct world_soils_met *met = world->facts.met;
	char values[120];
	if (scene->soil_map == NULL || world->resident.soil_map == NULL || scene->soil_default)
		return STATUS_OK;
	if (met->none > 0)
		return fail_with(STATUS_INPUT, "soil.map: %.200s covers %.3g %% of the paths, and there is no soil.default; look at its place and its reference "
					       "system (gdalinfo): without one it is in metres from the south-west post; or give soil.default",
				 scene->soil_map, 100 * (1 - met->none / met->all));
	const double share = unlisted(world, values, sizeof values);
	if (share > 0)
		return fail_with(STATUS_INPUT, "soil.map: %s, along %.3g %% of the paths, %s in no class, and there is no soil.default; give a soil in soil.classes, "
					       "or soil.default", values, 100 * share, strchr(values, ',') != NULL ? "are" : "is");
	return STATUS_OK;
}

enum status world_find_soils_met(struct world *world)
{
	const struct scene *scene = world->scene;
	const size_t rows = scene->object_count * SOIL_CLASSES + 1;
	const bool read = world->resident.soil_map != NULL || world->resident.soil_rasters != NULL;
	/* Without the files it is known only if there are none. */
	if ((scene->hosted && !world->params.advise) || scene->object_count + scene->vehicle_count == 0 || deform_model_row(scene->model)->numbers == NULL ||
	    (!read && (scene_has_classes(scene) || scene->raster_count > 0)))
		return STATUS_OK;
	struct world_soils_met *met = mem_calloc(1, sizeof *met);
	TRY_MEM(met, "the soils along the paths");
	met->least = mem_alloc(rows, sizeof *met->least);
	met->weakest = mem_calloc(rows, sizeof *met->weakest);
	if (met->least == NULL || met->weakest == NULL) {
		world_soils_met_free(met);
		return fail_memory("the soils along the paths");
	}
	for (size_t i = 0; i < rows; i++)
		met->least[i] = NAN;
	/* What cannot be read is refused by the drive where it comes to it, with the message of that place. */
	if (add_all(world, met) == STATUS_OK && met->all > 0)
		world->facts.met = met;
	else
		world_soils_met_free(met);
	return world->facts.met != NULL ? check_covered(world) : STATUS_OK;
}

int world_soil_index(const struct world *world, double x, double y)
{
	struct post_soil post;
	const bool read = extent_holds(&world->resident.meta->extent, x, y) &&
			  read_post(world, (int64_t)floor(x / world->resident.spacing + 0.5), (int64_t)floor(y / world->resident.spacing + 0.5), &post) == STATUS_OK;
	return read ? post.soil : -1;
}

/* --- what is told --- */

/* One line for all classes: a map of a region has many that a drive does not come to. */
static void advise_unmet(const struct world *world, scene_advice_fn tell, void *user)
{
	const struct scene *scene = world->scene;
	char text[500], list[300] = "";
	size_t used = 0, count = 0;
	for (int i = 1; i < scene->soil_count; i++)
		if (world->facts.met->soils[i] == 0 && scene_soil_value(scene, i) >= 0 && used < sizeof list) {
			used += (size_t)snprintf(list + used, sizeof list - used, "%s%d (%s)", used > 0 ? ", " : "", scene_soil_value(scene, i), scene->soil_names[i]);
			count++;
		}
	if (count == 0)
		return;
	snprintf(text, sizeof text, "soil.classes: class%s %s lie%s under no path (%zu place%s looked at)", count > 1 ? "es" : "", list,
		 count > 1 ? "" : "s", world->facts.met->places, world->facts.met->places > 1 ? "s" : "");
	tell(user, text);
}

static void advise_map(const struct world *world, scene_advice_fn tell, void *user)
{
	const struct scene *scene = world->scene;
	const struct world_soils_met *met = world->facts.met;
	char text[600], values[120];
	if (met->none > 0 && met->none + met->roads + met->rocks == met->all) {
		snprintf(text, sizeof text, "soil.map: %.200s covers 0 %% of the paths of objects and vehicles: all get the default soil, %s; look at its place and "
					    "its reference system (gdalinfo): without one it is in metres from the south-west post", scene->soil_map, scene->soil_names[0]);
		tell(user, text);
		return;
	}
	const double share = unlisted(world, values, sizeof values);
	if (share > 0) {
		snprintf(text, sizeof text, "soil.map: %s, along %.3g %% of the paths, %s in no class: the default soil is there, %s; give a soil in soil.classes", values,
			 100 * share, strchr(values, ',') != NULL ? "are" : "is", scene->soil_names[0]);
		tell(user, text);
	}
	if (!met->partly)
		advise_unmet(world, tell, user);
}

static void advise_numbers(const struct world *world, scene_advice_fn tell, void *user)
{
	for (int i = 0; world->resident.soil_rasters != NULL && i < world->scene->raster_count; i++) {
		const struct world_raster told = world_raster(world, i);
		char text[500];
		if (world->facts.met->numbers[i] > 0)
			continue;
		snprintf(text, sizeof text, "soil.rasters.%s: %.200s covers 0 %% of the paths of objects and vehicles: the soil's own number counts there; look at its "
					    "place and its reference system (gdalinfo): without one it is in metres from the south-west post", told.key, told.path);
		tell(user, text);
	}
}

/* Two digits: it is an estimate. */
static double about(double newtons)
{
	const double unit = pow(10, floor(log10(fmax(newtons, 1e-9))) - 1);
	return unit * round(newtons / unit);
}

static bool is_like(const struct scene_object *a, const struct scene_object *b)
{
	return a->load == b->load && a->slip == b->slip && a->shape.kind == b->shape.kind && a->shape.radius == b->shape.radius && a->shape.width == b->shape.width && a->shape.tyre.stiffness == b->shape.tyre.stiffness &&
	       a->shape.tyre.pressure == b->shape.tyre.pressure &&
	       memcmp(a->shape.size, b->shape.size, sizeof a->shape.size) == 0;
}

static bool is_too_much(const struct world *world, size_t object, int soil)
{
	return world->facts.met->least[object * SOIL_CLASSES + (size_t)soil] < world->scene->objects[object].load;
}

/* Tells of one object for all that are like it. */
static void advise_load(const struct world *world, size_t first, int soil, scene_advice_fn tell, void *user)
{
	const struct scene *scene = world->scene;
	const struct scene_object *object = &scene->objects[first];
	const double most = sinks_at_most(&object->shape), shallow = soil_shape_reach(&object->shape, 0, 0) / 2;
	char text[500], others[48] = "";
	size_t alike = 0;
	for (size_t i = 0; i < scene->object_count; i++)
		if (i != first && is_too_much(world, i, soil) && is_like(object, &scene->objects[i])) {
			if (i < first)
				return;
			alike++;
		}
	if (alike > 0)
		snprintf(others, sizeof others, " (nor that of %zu other%s)", alike, alike > 1 ? "s" : "");
	const struct soil_numbers *weakest = &world->facts.met->weakest[first * SOIL_CLASSES + (size_t)soil];
	snprintf(text, sizeof text, "objects.%.160s.load: %s on its path does not carry %.6g N%s: it bears about %.9g N when the object has sunk by %.2g m, and "
				    "about %.9g N at %.2g m; give less load, or %s", object->name, scene->soil_names[soil], object->load, others,
		 about(world->facts.met->least[first * SOIL_CLASSES + (size_t)soil]), most,
		 about(soil_load_at(&object->shape, &object->interface, object->slip, weakest, shallow)), shallow,
		 object->shape.kind == SOIL_WHEEL ? "a wider wheel" : "a larger plate");
	tell(user, text);
}

void world_advise_soils_met(const struct world *world, scene_advice_fn tell, void *user)
{
	const struct scene *scene = world->scene;
	const struct world_soils_met *met = world->facts.met;
	if (met == NULL)
		return;
	if (world->resident.soil_map != NULL && scene->soil_map != NULL)
		advise_map(world, tell, user);
	if (scene->road_count > 0 && world->resident.soil_map != NULL && met->roads == 0 && !met->partly)
		tell(user, "ground.roads: no path of an object or a vehicle comes onto one; look at where they are, or take them away");
	advise_numbers(world, tell, user);
	for (size_t i = 0; i < scene->object_count && deform_tells_forces(scene->model); i++)
		for (int soil = 0; soil < scene->soil_count; soil++)
			if (is_too_much(world, i, soil))
				advise_load(world, i, soil, tell, user);
}
