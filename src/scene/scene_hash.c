/*
 * Computes the hash of a scene. It covers all checked values that decide how the ground changes. Two scenes with the same hash
 * change a terrain in the same way. Each value is added as little-endian bytes.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <xxhash.h>

#include "scene/scene_check.h"

static void add_whole(XXH3_state_t *state, uint64_t value)
{
	unsigned char bytes[8];
	for (int i = 0; i < 8; i++)
		bytes[i] = (unsigned char)(value >> (8 * i));
	XXH3_128bits_update(state, bytes, sizeof bytes);
}

static void add_number(XXH3_state_t *state, double value)
{
	uint64_t bits;
	value += 0.0; /* minus zero is zero */
	memcpy(&bits, &value, sizeof bits);
	add_whole(state, bits);
}

static void add_text(XXH3_state_t *state, const char *text)
{
	add_whole(state, text == NULL ? UINT64_MAX : strlen(text));
	if (text != NULL)
		XXH3_128bits_update(state, text, strlen(text));
}

static void add_object(XXH3_state_t *state, const struct scene_object *object)
{
	const struct soil_shape *shape = &object->shape;
	const struct scene_path *path = &object->path;
	add_text(state, object->name);
	add_whole(state, (uint64_t)shape->kind);
	add_number(state, shape->radius);
	add_number(state, shape->width);
	for (int i = 0; i < 3; i++)
		add_number(state, shape->size[i]);
	add_number(state, object->sink);
	add_number(state, path->speed);
	add_whole(state, (uint64_t)path->loop | (uint64_t)path->timed << 1 |
				 (uint64_t)path->has_z << 2 | (uint64_t)path->has_attitude << 3);
	add_whole(state, path->count);
	for (size_t i = 0; i < path->count; i++) {
		const struct scene_waypoint *point = &path->points[i];
		add_number(state, point->t);
		add_number(state, point->x);
		add_number(state, point->y);
		add_number(state, point->z);
		add_number(state, point->yaw);
		add_number(state, point->pitch);
		add_number(state, point->roll);
	}
}

/* Parts of a scene that were added to the hash later come last, each after a letter of its own. So a scene without such parts
 * keeps its hash. */
static void add_part(XXH3_state_t *state, char letter, size_t index)
{
	add_whole(state, (uint64_t)letter);
	add_whole(state, index);
}

static void add_road(XXH3_state_t *state, size_t index, const struct scene_road *road)
{
	add_part(state, 'R', index);
	add_number(state, road->width);
	add_whole(state, road->soil);
	add_whole(state, road->line_count);
	for (size_t i = 0; i < road->line_count; i++) {
		const struct scene_path *line = &road->lines[i];
		add_whole(state, (uint64_t)line->degrees | (uint64_t)line->smooth << 1);
		add_whole(state, line->count);
		for (size_t k = 0; k < line->count; k++) {
			add_number(state, line->points[k].x);
			add_number(state, line->points[k].y);
		}
	}
}

static void add_mesh(XXH3_state_t *state, size_t index, const struct soil_mesh *mesh)
{
	add_part(state, 'm', index);
	add_whole(state, mesh->vertex_count);
	for (uint32_t i = 0; i < mesh->vertex_count; i++)
		for (int k = 0; k < 3; k++)
			add_number(state, (double)mesh->vertices[i][k]);
	add_whole(state, mesh->triangle_count);
	for (uint32_t i = 0; i < mesh->triangle_count; i++)
		for (int k = 0; k < 3; k++)
			add_whole(state, mesh->triangles[i][k]);
}

static void add_way(XXH3_state_t *state, size_t index, const struct scene_path *path)
{
	if (path->rotate != 0) {
		add_part(state, 'r', index);
		add_number(state, path->rotate);
	}
	if (path->offset[0] != 0 || path->offset[1] != 0) {
		add_part(state, 'o', index);
		add_number(state, path->offset[0]);
		add_number(state, path->offset[1]);
	}
	if (path->beside[0] != 0 || path->beside[1] != 0) {
		add_part(state, 'p', index);
		add_number(state, path->beside[0]);
		add_number(state, path->beside[1]);
	}
	if (path->delay != 0) {
		add_part(state, 'd', index);
		add_number(state, path->delay);
	}
	if (path->degrees || path->smooth) {
		add_part(state, 'w', index);
		add_whole(state, (uint64_t)path->degrees | (uint64_t)path->smooth << 1);
	}
}

static void add_object_more(XXH3_state_t *state, size_t index, const struct scene_object *object)
{
	const struct soil_shape *shape = &object->shape;
	if (shape->grousers > 0) {
		add_part(state, 'g', index);
		add_whole(state, (uint64_t)shape->grousers);
		add_number(state, shape->grouser_height);
		add_number(state, shape->grouser_thickness);
	}
	if (shape->tyre.stiffness > 0) {
		add_part(state, 'y', index);
		add_number(state, shape->tyre.pressure);
		add_number(state, shape->tyre.stiffness);
		add_number(state, shape->tyre.damping);
	}
	if (shape->length > 0) {
		add_part(state, 'z', index);
		add_number(state, shape->length);
	}
	if (shape->belt)
		add_part(state, 'b', index);
	if (object->load > 0) {
		add_part(state, 'l', index);
		add_number(state, object->load);
	}
	if (object->carry)
		add_part(state, 'k', index);
	add_way(state, index, &object->path);
	if (object->slip != 0) {
		add_part(state, 's', index);
		add_number(state, object->slip);
	}
	if (!object->path.has_attitude && scene_is_turned(object)) {
		add_part(state, 'y', index);
		for (int i = 0; i < 3; i++)
			add_number(state, object->path.attitude[i]);
	}
	if (object->interface.has_friction) {
		add_part(state, 'f', index);
		add_number(state, object->interface.friction_angle);
	}
	if (object->interface.has_adhesion) {
		add_part(state, 'a', index);
		add_number(state, object->interface.adhesion);
	}
	if (object->mesh != NULL)
		add_mesh(state, index, object->mesh);
}

static void add_texts(XXH3_state_t *state, const struct scene_texts *texts)
{
	add_whole(state, texts->count);
	for (size_t i = 0; i < texts->count; i++)
		add_text(state, texts->list[i]);
}

static void add_powertrain(XXH3_state_t *state, size_t index, const struct scene_vehicle *vehicle)
{
	const struct scene_powertrain *train = &vehicle->powertrain;
	if (vehicle->brakes > 0) {
		add_part(state, 'B', index);
		add_number(state, vehicle->brakes);
	}
	if (!train->present)
		return;
	const double numbers[] = {train->inertia, train->idle, train->drag, train->reverse, train->final, train->shifts, train->down, train->up, train->shift_time,
				  train->clutch, train->engage, train->capacity, train->stall_ratio, train->coupling, train->centre, train->front, train->rear,
				  train->bias, train->lock};
	add_part(state, 'E', index);
	add_texts(state, &train->wheels);
	add_whole(state, train->engine_count);
	for (size_t i = 0; i < train->engine_count; i++) {
		add_number(state, train->engine[i][0]);
		add_number(state, train->engine[i][1]);
	}
	add_whole(state, train->gear_count);
	for (size_t i = 0; i < train->gear_count; i++)
		add_number(state, train->gears[i]);
	for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
		add_number(state, numbers[i]);
}

static void add_named(XXH3_state_t *state, const struct scene_named *named)
{
	add_texts(state, &named->names);
	for (size_t i = 0; i < named->names.count; i++)
		add_number(state, named->values[i]);
}

/* Counts only where the scene gives something. */
static void add_start(XXH3_state_t *state, size_t index, const struct scene_start *start)
{
	const double numbers[] = {start->pitch, start->roll, start->height, start->speed, start->unsettled};
	bool any = start->joints.names.count + start->controls.names.count > 0;
	for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
		any = any || numbers[i] != 0;
	if (!any)
		return;
	add_part(state, 'S', index);
	for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
		add_number(state, numbers[i]);
	add_named(state, &start->joints);
	add_named(state, &start->controls);
}

static void add_vehicle(XXH3_state_t *state, size_t index, const struct scene_vehicle *vehicle)
{
	add_part(state, 'v', index);
	add_text(state, vehicle->name);
	for (int i = 0; i < 2; i++) {
		add_whole(state, vehicle->model_hash[i]);
		add_whole(state, vehicle->controls_hash[i]);
		add_number(state, vehicle->at[i]);
	}
	add_number(state, vehicle->yaw);
	add_whole(state, (uint64_t)vehicle->driver);
	add_number(state, vehicle->way.speed);
	add_whole(state, vehicle->way.count);
	for (size_t i = 0; i < vehicle->way.count; i++) {
		add_number(state, vehicle->way.points[i].x);
		add_number(state, vehicle->way.points[i].y);
	}
	add_texts(state, &vehicle->soil);
	add_texts(state, &vehicle->steer);
	add_texts(state, &vehicle->drive);
	add_named(state, &vehicle->held);
	if (vehicle->keyframe != NULL)
		add_text(state, vehicle->keyframe);
	add_start(state, index, &vehicle->start);
	if (vehicle->fixed != SCENE_FIXED_BY_MODEL)
		add_whole(state, 1000 + (uint64_t)vehicle->fixed);
	if (vehicle->servo.kv > 0 || vehicle->servo.torque > 0) {
		add_number(state, vehicle->servo.kv);
		add_number(state, vehicle->servo.torque);
	}
	if (vehicle->follows_origin)
		add_whole(state, 2001);
	if (vehicle->forward != SCENE_PLUS_X || vehicle->y_up)
		add_whole(state, 2010 + 2 * (uint64_t)vehicle->forward + vehicle->y_up);
	for (size_t i = 0; i < vehicle->way.count && vehicle->speeds != NULL; i++)
		add_number(state, vehicle->speeds[i]);
	for (size_t i = 0; i < vehicle->stop_count; i++) {
		add_whole(state, 2020);
		add_number(state, vehicle->stops[i][0]);
		add_number(state, vehicle->stops[i][1]);
	}
	for (size_t i = 0; i < vehicle->surface_count; i++) {
		const struct soil_interface *interface = &vehicle->surfaces[i].interface;
		add_text(state, vehicle->surfaces[i].geoms);
		add_whole(state, 2030 + 2 * (uint64_t)interface->has_friction + interface->has_adhesion);
		add_number(state, interface->friction_angle);
		add_number(state, interface->adhesion);
	}
	if (vehicle->imu.present) { /* it is a part of the model */
		add_text(state, "imu");
		add_text(state, vehicle->imu.body != NULL ? vehicle->imu.body : "");
		for (int i = 0; i < 3; i++)
			add_number(state, vehicle->imu.at[i]);
	}
	for (int i = 0; i < 2 && vehicle->pushes != NULL; i++)
		add_whole(state, vehicle->pushes_hash[i]);
	add_way(state, index, &vehicle->way);
	if (vehicle->servo.free.count > 0) {
		add_part(state, 'J', index);
		add_texts(state, &vehicle->servo.free);
	}
	if (vehicle->servo.lock.count > 0) {
		add_part(state, 'L', index);
		add_texts(state, &vehicle->servo.lock);
	}
	if (vehicle->no_soil.count > 0) {
		add_part(state, 'N', index);
		add_texts(state, &vehicle->no_soil);
	}
	for (size_t i = 0; i < vehicle->tyre_count; i++) {
		const struct scene_tyre *tyre = &vehicle->tyres[i];
		add_part(state, 'Y', index);
		add_text(state, tyre->geom);
		add_number(state, tyre->width);
		add_number(state, tyre->told.stiffness);
		add_number(state, tyre->told.load);
		add_number(state, tyre->told.pressure);
		add_number(state, tyre->told.damping);
	}
	if (vehicle->carry.count > 0) {
		add_part(state, 'K', index);
		add_texts(state, &vehicle->carry);
	}
	add_powertrain(state, index, vehicle);
}

/*
 * What a soil has no number for was filled in from another soil when hashes were first kept. It counts as that still, so that
 * drives of then can be resumed. No model reads it.
 */
static void fill_soil(const char *name, struct soil_numbers *soil)
{
	struct soil_numbers from = {.cohesion = 0};
	double numbers[offsetof(struct soil_numbers, over) / sizeof(double)], others[sizeof numbers / sizeof(double)];
	if (strncmp(name, "unnamed", strlen("unnamed")) != 0 &&
	    soil_named(strcmp(name, "snow") == 0 ? "snow_us" : "dry_sand", &from) != STATUS_OK)
		return;
	memcpy(numbers, soil, sizeof numbers);
	memcpy(others, &from, sizeof others);
	for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
		numbers[i] = isnan(numbers[i]) ? others[i] : numbers[i];
	memcpy(soil, numbers, sizeof numbers);
}

/* What a named soil's compression was when hashes were first kept: the share that is displaced, taken for the share that is lost. */
static double former_compression(double compression)
{
	static const double named[][2] = {{0.7, 0.3}, {0.59, 0.41}, {1, 0}}; /* sand, mud, snow */
	for (size_t i = 0; i < sizeof named / sizeof named[0]; i++)
		if (compression == named[i][0])
			return named[i][1];
	return compression;
}

static void add_soil(XXH3_state_t *state, const struct soil_numbers *soil)
{
	const double numbers[] = {soil->bekker_kc,	   soil->bekker_kphi, soil->bekker_n,
				  soil->cohesion,	   soil->friction_angle,
				  soil->janosi_shear,	   soil->elastic_stiffness,
				  soil->damping,	   soil->unit_weight, soil->theta_in,
				  soil->theta_out,	   soil->theta_stop,  soil->roughness,
				  soil->compression,	   soil->repose};
	_Static_assert(sizeof numbers == offsetof(struct soil_numbers, over) - 3 * sizeof(double), "every parameter counts: density in unit_weight, numbers of faces where they are given; add_soils adds layers and compaction");
	for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
		add_number(state, numbers[i]);
}

/* Tells whether a soil has a density that is neither its name's, with that weight, nor what makes its weight. */
static bool has_own_density(const struct scene *scene, int i)
{
	const struct soil_numbers *soil = &scene->soils[i];
	struct soil_numbers named;
	if (isnan(soil->density) || fabs(soil->density * scene->gravity / soil->unit_weight - 1) < 1e-9)
		return false;
	return soil_named(scene->soil_names[i], &named) != STATUS_OK || soil->density != named.density || soil->unit_weight != named.unit_weight;
}

/* What the inertia of soil depends on, where it is not as by default. */
static void add_inertia(XXH3_state_t *state, const struct scene *scene)
{
	if (scene->inertia != SCENE_INERTIA) {
		add_part(state, 'i', 0);
		add_number(state, scene->inertia);
	}
	for (int i = 0; i < scene->soil_count && scene->inertia > 0; i++)
		if (has_own_density(scene, i)) {
			add_part(state, 'q', (size_t)i);
			add_number(state, scene->soils[i].density);
		}
}

/* Adds the numbers of faces that the scene gives. */
static void add_faces(XXH3_state_t *state, uint64_t i, const struct soil_numbers *soil)
{
	if (!isnan(soil->face_strength)) {
		add_part(state, 'x', i);
		add_number(state, soil->face_strength);
	}
	if (!isnan(soil->face_cohesion)) {
		add_part(state, 'y', i);
		add_number(state, soil->face_cohesion);
	}
}

static void add_soils(XXH3_state_t *state, const struct scene *scene)
{
	add_part(state, 'e', 0);
	add_whole(state, (uint64_t)scene->iterations);
	add_number(state, scene->interval);
	add_whole(state, (uint64_t)scene->undisturbed);
	add_number(state, scene->depth);
	add_number(state, scene->bulldozing);
	if (scene->slip_sinkage > 0)
		add_number(state, scene->slip_sinkage);
	if (deform_model_takes(scene->model, "loosening") && (scene->loosening != SCENE_LOOSENING || scene->hardening > 0)) {
		add_part(state, 'u', 0);
		add_number(state, scene->loosening);
		add_number(state, scene->hardening);
	}
	add_whole(state, (uint64_t)scene->soil_count);
	for (int i = 0; i < scene->soil_count; i++) {
		struct soil_numbers soil = scene->soils[i];
		fill_soil(scene->soil_names[i], &soil);
		if (!deform_model_reads(scene->model, "compression"))
			soil.compression = former_compression(soil.compression);
		add_soil(state, &soil);
		add_faces(state, (uint64_t)i, &scene->soils[i]);
		if (scene->hardening > 0 && soil.compaction > 0) {
			add_part(state, 'c', (uint64_t)i);
			add_number(state, soil.compaction);
		}
		if (soil.over != NULL) {
			add_part(state, 'l', (uint64_t)i);
			add_number(state, soil.thickness);
			add_soil(state, soil.over);
			add_faces(state, (uint64_t)i, soil.over);
		}
	}
	if (scene->faces != SCENE_FACES_ON)
		add_part(state, 'F', (uint64_t)scene->faces);
	if (deform_model_takes(scene->model, "inertia") && scene->faces == SCENE_FACES_ON)
		add_inertia(state, scene);
	if (scene->thrown != SCENE_THROWN_OFF) {
		add_part(state, 'T', (uint64_t)scene->thrown);
		add_number(state, scene->gravity);
	}
	if (scene->normals != SCENE_BODY)
		add_part(state, 'n', (uint64_t)scene->normals);
	if (scene->tolerance != 0) {
		add_part(state, 't', 0);
		add_number(state, scene->tolerance);
	}
	if (scene->soil_map != NULL) {
		add_part(state, 'c', 0);
		add_whole(state, scene->soil_map_hash[0]);
		add_whole(state, scene->soil_map_hash[1]);
		XXH3_128bits_update(state, scene->soil_class, sizeof scene->soil_class);
	}
	for (size_t i = 0; i < scene->road_count; i++)
		add_road(state, i, &scene->roads[i]);
	for (int i = 0; i < scene->raster_count; i++) {
		add_part(state, 'n', (size_t)scene->rasters[i].number);
		add_whole(state, scene->rasters[i].hash[0]);
		add_whole(state, scene->rasters[i].hash[1]);
	}
}

static void add_relief(XXH3_state_t *state, const struct scene *scene)
{
	const struct relief_spec *relief = &scene->relief;
	add_part(state, 'r', (size_t)relief->classes);
	add_whole(state, relief->seed);
	for (int i = 0; i < relief->classes; i++) {
		add_number(state, relief->waves[i].roughness);
		add_number(state, relief->waves[i].wavelength);
	}
	if (relief->classes > 1) {
		add_whole(state, relief->map[0]);
		add_whole(state, relief->map[1]);
	}
}

enum status scene_hash(struct scene *scene)
{
	XXH3_state_t *state = XXH3_createState();
	TRY_MEM(state, "hashing the scene");
	XXH3_128bits_reset(state);
	add_text(state, "furrow scene 1");
	add_number(state, scene->time_step);
	add_number(state, scene->gravity);
	add_number(state, scene->spacing);
	add_whole(state, (uint64_t)scene->coordinates);
	add_text(state, scene->srs);
	add_whole(state, (uint64_t)scene->model);
	add_whole(state, (uint64_t)scene->box_radius);
	add_whole(state, (uint64_t)scene->box_repetitions);
	add_whole(state, scene->disturbance);
	add_whole(state, (uint64_t)scene->outside);
	add_whole(state, 0); /* once whether soil was named */
	add_whole(state, scene->object_count);
	for (size_t i = 0; i < scene->object_count; i++)
		add_object(state, &scene->objects[i]);
	for (size_t i = 0; i < scene->object_count; i++)
		add_object_more(state, i, &scene->objects[i]);
	if (deform_is_elastic(scene->model)) {
		const double sheet[] = {scene->tension, scene->stiffness, scene->yield, scene->rut};
		add_part(state, 'S', 0);
		for (size_t i = 0; i < sizeof sheet / sizeof *sheet; i++)
			add_number(state, sheet[i]);
	}
	if (deform_model_row(scene->model)->numbers != NULL) /* others may have soils to be drawn */
		add_soils(state, scene);
	for (size_t i = 0; i < scene->vehicle_count; i++)
		add_vehicle(state, i, &scene->vehicles[i]);
	if (scene->things != NULL) {
		add_text(state, "world");
		for (int i = 0; i < 2; i++)
			add_whole(state, scene->things->model_hash[i]);
	}
	if (scene->heals > 0) {
		add_text(state, "heals");
		add_number(state, scene->heals);
	}
	if (scene->vegetation.present) {
		add_text(state, "vegetation");
		add_number(state, scene->vegetation.tears);
		add_number(state, scene->vegetation.rises);
		add_number(state, scene->vegetation.grows);
	}
	if (scene->elapsed > 0) {
		add_text(state, "elapsed");
		add_number(state, scene->elapsed);
	}
	if (scene->relief.classes > 0)
		add_relief(state, scene);
	if (scene->rocks.cover > 0) {
		const double numbers[] = {scene->rocks.cover, scene->rocks.k, scene->rocks.smallest, scene->rocks.largest, scene->rocks.seed};
		add_text(state, "rocks");
		for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
			add_number(state, numbers[i]);
	}
	XXH128_hash_t hash = XXH3_128bits_digest(state);
	XXH3_freeState(state);
	snprintf(scene->hash, sizeof scene->hash, "%016llx%016llx", (unsigned long long)hash.high64,
		 (unsigned long long)hash.low64);
	return STATUS_OK;
}
