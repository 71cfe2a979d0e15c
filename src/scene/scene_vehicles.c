/* Checks the vehicles of a scene and fills their values. What the model itself says is checked when it is read: src/vehicle. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scene/scene_check.h"
#include "scene/scene_error.h"
#include "scene/scene_file.h"
#include "scene/scene_powertrain.h"
#include "scene/scene_way.h"

#define MODEL_BYTES ((uint64_t)64 << 20)    /* the largest file of a model */
#define CONTROLS_BYTES ((uint64_t)256 << 20) /* the largest table of controls */

static enum status take_name(const struct scene_tree *tree, const struct scene *scene, size_t index, const char *name, char **out)
{
	const struct scene_node *node = scene_tree_find(tree, "vehicles[%zu].name", index);
	TRY(scene_check_name(tree, node, name));
	for (size_t i = 0; i < scene->object_count; i++)
		if (scene->objects[i].name != NULL && strcmp(scene->objects[i].name, name) == 0)
			return scene_error(tree->file, node, "%s is the name of an object; allowed: unique names", scene_quote(name).text);
	for (size_t i = 0; i < index; i++)
		if (strcmp(scene->vehicles[i].name, name) == 0)
			return scene_error(tree->file, node, "%s is the name of another vehicle; allowed: unique names", scene_quote(name).text);
	return mem_text(out, name, "reading the vehicles");
}

enum status scene_take_texts(char *const *from, uint32_t count, struct scene_texts *texts)
{
	TRY(mem_zeroed(&texts->list, count + 1, sizeof *texts->list, "reading the vehicles"));
	for (; texts->count < count; texts->count++)
		if ((texts->list[texts->count] = mem_strdup(from[texts->count])) == NULL)
			return fail_memory("reading the vehicles");
	return STATUS_OK;
}

/* Finds the path of a file that the scene names, and hashes its bytes. */
static enum status take_file(const struct scene_tree *tree, const struct scene_node *node, const char *name, uint64_t most, char **path,
			     uint64_t hash[2])
{
	*path = scene_file_beside(tree->folder, name);
	if (*path == NULL)
		return fail_memory("reading the vehicles");
	return scene_file_hash(*path, scene_told(tree->file, node, name).text, most, hash);
}

/* Resolves folders relative to the scene's file. */
static enum status take_folders(const struct scene_tree *tree, char *const *from, uint32_t count, struct scene_texts *texts)
{
	TRY(mem_zeroed(&texts->list, count + 1, sizeof *texts->list, "reading the vehicles"));
	for (; texts->count < count; texts->count++) {
		texts->list[texts->count] = scene_file_beside(tree->folder, from[texts->count]);
		TRY_MEM(texts->list[texts->count], "reading the vehicles");
	}
	return STATUS_OK;
}

/* Reads speeds, one for each point. All drive the same way. */
static enum status take_speeds(const struct scene_tree *tree, const struct raw_path *raw, const char *where, struct scene_vehicle *vehicle)
{
	const struct scene_node *node = scene_tree_find(tree, "%s.speeds", where);
	if (raw->points == NULL || raw->speeds_count != raw->points_count || (raw->smooth != NULL && *raw->smooth))
		return scene_error(tree->file, node, "has %u; allowed: one for each of points, without smooth", raw->speeds_count);
	TRY(mem_zeroed(&vehicle->speeds, raw->speeds_count, sizeof *vehicle->speeds, "reading the vehicles"));
	for (uint32_t i = 0; i < raw->speeds_count; i++) {
		vehicle->speeds[i] = raw->speeds[i];
		if (raw->speeds[i] == 0 || (raw->speeds[i] > 0) != (raw->speeds[0] > 0))
			return scene_error(tree->file, scene_tree_find(tree, "%s.speeds[%u]", where, i), "%g goes no way on; allowed: all above 0, or all below for driving backward; stop says when it stands",
					   raw->speeds[i]);
	}
	return STATUS_OK;
}

static enum status take_stops(const struct scene_tree *tree, const struct raw_path *raw, const char *where, struct scene_vehicle *vehicle)
{
	TRY(mem_zeroed(&vehicle->stops, raw->stop_count + 1, sizeof *vehicle->stops, "reading the vehicles"));
	for (uint32_t i = 0; i < raw->stop_count; i++) {
		if (!(raw->stop[i][0] < raw->stop[i][1]))
			return scene_error(tree->file, scene_tree_find(tree, "%s.stop[%u]", where, i), "ends before it begins; allowed: [from, to], s");
		memcpy(vehicle->stops[vehicle->stop_count++], raw->stop[i], sizeof *vehicle->stops);
	}
	return STATUS_OK;
}

/* Reads the way with its speed, or with speeds. */
static enum status take_way(const struct scene_tree *tree, struct raw_path *raw, const char *where, struct scene_vehicle *vehicle)
{
	if ((raw->speed != NULL) == (raw->speeds != NULL))
		return scene_error(tree->file, scene_tree_find(tree, "%s", where), "has %s; allowed: exactly one of speed, speeds", raw->speed != NULL ? "both speed and speeds" : "no speed");
	if (raw->speeds == NULL) {
		TRY(scene_way_take(tree, raw, where, &vehicle->way));
	} else {
		TRY(take_speeds(tree, raw, where, vehicle));
		raw->speed = &raw->speeds[0]; /* a way needs one; it is replaced below */
		const enum status status = scene_way_take(tree, raw, where, &vehicle->way);
		raw->speed = NULL;
		TRY(status);
		for (uint32_t i = 0; i < raw->speeds_count; i++)
			vehicle->way.speed = fabs(raw->speeds[i]) > fabs(vehicle->way.speed) ? raw->speeds[i] : vehicle->way.speed;
	}
	if (vehicle->way.speed == 0)
		return scene_error(tree->file, scene_tree_find(tree, "%s.speed", where), "0 goes no way; allowed: above 0, or below 0 for driving backward");
	return take_stops(tree, raw, where, vehicle);
}

static enum status check_follow(const struct scene_tree *tree, const struct raw_driver *raw, size_t index, struct scene_vehicle *vehicle)
{
	char where[48];
	if (raw->drive == NULL)
		return scene_error(tree->file, scene_tree_find(tree, "vehicles[%zu].driver", index),
				   "has a path and no actuators that drive; needed with path: drive");
	vehicle->driver = SCENE_FOLLOW;
	snprintf(where, sizeof where, "vehicles[%zu].driver.path", index);
	TRY(take_way(tree, raw->path, where, vehicle));
	vehicle->follows_origin = raw->follow != NULL && *raw->follow == 1;
	if (vehicle->way.timed)
		return scene_error(tree->file, scene_tree_find(tree, "%s.file", where), "has times, and a driver has a speed; allowed: points, or "
							     "a file that ends in .gpx or .geojson");
	TRY(scene_take_texts(raw->steer, raw->steer_count, &vehicle->steer));
	return scene_take_texts(raw->drive, raw->drive_count, &vehicle->drive);
}

/* Copies numbers by name. */
static enum status take_named(const struct scene_tree *tree, const char *where, const struct raw_control *list, size_t count, struct scene_named *out)
{
	TRY(mem_zeroed(&out->values, count + 1, sizeof *out->values, "reading the vehicles"));
	TRY(mem_zeroed(&out->names.list, count + 1, sizeof *out->names.list, "reading the vehicles"));
	for (size_t i = 0; i < count; i++) {
		for (size_t k = 0; k < i; k++)
			if (strcmp(list[i].name, list[k].name) == 0)
				return scene_error(tree->file, scene_tree_find(tree, "%s[%zu]", where, i), "%s is named twice; allowed: once",
						   scene_quote(list[i].name).text);
		out->values[i] = list[i].value;
		TRY(mem_text(&out->names.list[i], list[i].name, "reading the vehicles"));
		out->names.count = i + 1;
	}
	return STATUS_OK;
}

static enum status check_hold(const struct scene_tree *tree, const struct raw_driver *raw, size_t index, struct scene_vehicle *vehicle)
{
	char where[64];
	vehicle->driver = SCENE_HOLD;
	snprintf(where, sizeof where, "vehicles[%zu].driver.hold", index);
	return take_named(tree, where, raw->hold, raw->hold_count, &vehicle->held);
}

static enum status check_start(const struct scene_tree *tree, const struct raw_start *raw, size_t index, struct scene_start *start)
{
	char where[64];
	start->pitch = scene_or(raw->pitch, 0) * M_PI / 180;
	start->roll = scene_or(raw->roll, 0) * M_PI / 180;
	start->height = scene_or(raw->height, 0);
	start->speed = scene_or(raw->speed, 0);
	if (start->height > 0 && raw->settle != NULL && *raw->settle)
		return scene_error(tree->file, scene_tree_find(tree, "vehicles[%zu].start.settle", index),
				   "does not go with height, from which the vehicle falls at t = 0; allowed with height: false, or no settle");
	start->unsettled = start->height > 0 || (raw->settle != NULL && !*raw->settle);
	snprintf(where, sizeof where, "vehicles[%zu].start.joints", index);
	TRY(take_named(tree, where, raw->joints, raw->joints_count, &start->joints));
	snprintf(where, sizeof where, "vehicles[%zu].start.controls", index);
	return take_named(tree, where, raw->controls, raw->controls_count, &start->controls);
}

static enum status check_driver(const struct scene_tree *tree, const struct raw_driver *raw, size_t index, struct scene_vehicle *vehicle)
{
	const struct scene_node *node = scene_tree_find(tree, "vehicles[%zu].driver", index);
	const int named = (raw->path != NULL) + (raw->controls != NULL) + (raw->hold != NULL);
	if (named != 1)
		return scene_error(tree->file, node, "names %d drivers; allowed: exactly one of path, controls, hold", named);
	if (raw->path == NULL && (raw->steer != NULL || raw->drive != NULL || raw->follow != NULL))
		return scene_error(tree->file, scene_tree_find(tree, "vehicles[%zu].driver.%s", index, raw->steer != NULL ? "steer" : raw->drive != NULL ? "drive" : "follow"),
				   "is not of this driver; allowed with: path");
	if (raw->path != NULL)
		return check_follow(tree, raw, index, vehicle);
	if (raw->hold != NULL)
		return check_hold(tree, raw, index, vehicle);
	vehicle->driver = SCENE_CONTROLS;
	return take_file(tree, scene_tree_find(tree, "vehicles[%zu].driver.controls", index), raw->controls, CONTROLS_BYTES,
			 &vehicle->controls, vehicle->controls_hash);
}

/* A material has numbers; others may be given instead. */
static enum status take_surface(const struct scene_tree *tree, const struct raw_surface *raw, size_t index, size_t number, struct scene_surface *surface)
{
	static const double angles[] = {[SCENE_RUBBER] = 0, [SCENE_STEEL] = 17, [SCENE_CONCRETE] = 19.5}; /* degrees; NAVFAC: clean sand; rubber is rough */
	const bool numbers = raw->friction_angle != NULL || raw->adhesion != NULL;
	TRY(mem_text(&surface->geoms, raw->geoms, "reading the vehicles"));
	if ((raw->material != NULL) == numbers)
		return scene_error(tree->file, scene_tree_find(tree, "vehicles[%zu].interface[%zu]", index, number), "has %s; allowed: material, or friction_angle and adhesion",
				   numbers ? "a material and numbers" : "neither a material nor numbers");
	if (raw->material != NULL) {
		const bool smooth = *raw->material != SCENE_RUBBER;
		surface->interface = (struct soil_interface){.has_friction = smooth, .has_adhesion = smooth, .friction_angle = angles[*raw->material] * M_PI / 180};
		return STATUS_OK;
	}
	surface->interface = scene_interface(raw->friction_angle, raw->adhesion);
	return STATUS_OK;
}

static enum status take_surfaces(const struct scene_tree *tree, const struct raw_vehicle *raw, size_t index, struct scene_vehicle *vehicle)
{
	TRY(mem_zeroed(&vehicle->surfaces, raw->interface_count + 1, sizeof *vehicle->surfaces, "reading the vehicles"));
	for (uint32_t i = 0; i < raw->interface_count; i++) {
		vehicle->surface_count = i + 1;
		TRY(take_surface(tree, &raw->interface[i], index, i, &vehicle->surfaces[i]));
	}
	return STATUS_OK;
}

static enum status take_tyres(const struct raw_vehicle *raw, struct scene_vehicle *vehicle)
{
	TRY(mem_zeroed(&vehicle->tyres, raw->tyres_count + 1, sizeof *vehicle->tyres, "reading the vehicles"));
	for (size_t i = 0; i < raw->tyres_count; i++) {
		const struct raw_tyre *from = &raw->tyres[i];
		vehicle->tyres[i] = (struct scene_tyre){.width = scene_or(from->width, (double)NAN), .told = {from->stiffness, scene_or(from->load, (double)NAN), scene_or(from->pressure, (double)NAN), scene_or(from->damping, (double)NAN)}};
		TRY(mem_text(&vehicle->tyres[i].geom, from->geom, "reading the vehicles"));
		vehicle->tyre_count = i + 1;
	}
	return STATUS_OK;
}

/* Reads where the model looks. */
static enum status take_axes(const struct scene_tree *tree, const struct raw_vehicle *raw, size_t index, struct scene_vehicle *vehicle)
{
	vehicle->forward = raw->forward != NULL ? (enum scene_forward)*raw->forward : SCENE_PLUS_X;
	vehicle->y_up = raw->up != NULL && *raw->up == 1;
	if (vehicle->y_up && (vehicle->forward == SCENE_PLUS_Y || vehicle->forward == SCENE_MINUS_Y))
		return scene_error(tree->file, scene_tree_find(tree, "vehicles[%zu].forward", index), "looks where up: y looks; allowed with up: y: +x, -x");
	return STATUS_OK;
}

static enum status take_imu(const struct raw_imu *raw, struct scene_imu *imu)
{
	if (raw == NULL)
		return STATUS_OK;
	imu->present = true;
	if (raw->at != NULL)
		memcpy(imu->at, raw->at, sizeof imu->at);
	if (raw->noise != NULL)
		memcpy(imu->noise, raw->noise, sizeof imu->noise);
	return raw->body != NULL ? mem_text(&imu->body, raw->body, "reading the vehicles") : STATUS_OK;
}

static enum status check_vehicle(const struct scene_tree *tree, const struct raw_vehicle *raw, size_t index, const struct scene *scene,
				 struct scene_vehicle *vehicle)
{
	TRY(take_name(tree, scene, index, raw->name, &vehicle->name));
	TRY(take_file(tree, scene_tree_find(tree, "vehicles[%zu].model", index), raw->model, MODEL_BYTES, &vehicle->model, vehicle->model_hash));
	TRY(scene_take_texts(raw->soil, raw->soil_count, &vehicle->soil));
	TRY(scene_take_texts(raw->no_soil, raw->no_soil_count, &vehicle->no_soil));
	TRY(scene_take_texts(raw->carry, raw->carry_count, &vehicle->carry));
	const struct scene_node *at = scene_tree_find(tree, "vehicles[%zu].start.at", index);
	vehicle->line = at->setting == NULL ? at->place.line : 0;
	memcpy(vehicle->at, raw->start.at, sizeof vehicle->at);
	vehicle->yaw = scene_number(raw->start.yaw, "vehicles[].start.yaw") * M_PI / 180;
	if (raw->start.keyframe != NULL)
		TRY(mem_text(&vehicle->keyframe, raw->start.keyframe, "reading the vehicles"));
	vehicle->fixed = raw->start.fixed == NULL ? SCENE_FIXED_BY_MODEL : *raw->start.fixed ? SCENE_FIXED_YES : SCENE_FIXED_NO;
	TRY(check_start(tree, &raw->start, index, &vehicle->start));
	TRY(take_folders(tree, raw->model_path, raw->model_path_count, &vehicle->model_path));
	if (raw->servo != NULL) {
		vehicle->servo.kv = scene_or(raw->servo->kv, 0);
		vehicle->servo.torque = scene_or(raw->servo->torque, 0);
		TRY(scene_take_texts(raw->servo->free, raw->servo->free_count, &vehicle->servo.free));
		TRY(scene_take_texts(raw->servo->lock, raw->servo->lock_count, &vehicle->servo.lock));
	}
	if (raw->tyres_count > 0)
		TRY(take_tyres(raw, vehicle));
	TRY(take_axes(tree, raw, index, vehicle));
	TRY(take_surfaces(tree, raw, index, vehicle));
	if (raw->pushes != NULL)
		TRY(take_file(tree, scene_tree_find(tree, "vehicles[%zu].pushes", index), raw->pushes, CONTROLS_BYTES, &vehicle->pushes, vehicle->pushes_hash));
	TRY(take_imu(raw->imu, &vehicle->imu));
	if (raw->driver != NULL)
		TRY(check_driver(tree, raw->driver, index, vehicle));
	vehicle->brakes = scene_or(raw->brakes, 0);
	return raw->powertrain != NULL ? scene_check_powertrain(tree, raw->powertrain, index, vehicle) : STATUS_OK;
}

/* What MuJoCo has besides vehicles: a file of its own, whose things keep their places. */
static enum status check_things(const struct scene_tree *tree, const struct raw_scene *raw, struct scene *scene)
{
	const struct scene_node *node = scene_tree_find(tree, "world");
	if (raw->world == NULL)
		return STATUS_OK;
	for (size_t i = 0; i < scene->vehicle_count; i++)
		if (strcmp(scene->vehicles[i].name, "world") == 0)
			return scene_error(tree->file, scene_tree_find(tree, "vehicles[%zu].name", i), "world is the name of the things of the key world; allowed with it: other names");
	for (size_t i = 0; i < scene->object_count; i++)
		if (scene->objects[i].name != NULL && strcmp(scene->objects[i].name, "world") == 0)
			return scene_error(tree->file, scene_tree_find(tree, "objects[%zu].name", i), "world is the name of the things of the key world; allowed with it: other names");
	TRY(mem_zeroed(&scene->things, 1, sizeof *scene->things, "reading the vehicles"));
	TRY(mem_text(&scene->things->name, "world", "reading the vehicles"));
	scene->things->line = node->setting == NULL ? node->place.line : 0;
	return take_file(tree, node, raw->world, MODEL_BYTES, &scene->things->model, scene->things->model_hash);
}

static const char *const stops[SCENE_STOPS] = {"overturned", "buried", "stuck"};

const char *scene_stop_name(enum scene_stop stop)
{
	return stops[stop];
}

/* Without the key `stop`, `stuck` stops the drive. */
static enum status take_stop(const struct scene_tree *tree, const struct raw_scene *raw, struct scene *scene)
{
	scene->stop = raw->stop_count == 0 && raw->stuck != NULL ? 1u << SCENE_STOP_STUCK : 0;
	for (uint32_t i = 0; i < raw->stop_count; i++) {
		int stop = 0;
		while (stop < SCENE_STOPS && strcmp(raw->stop[i], stops[stop]) != 0)
			stop++;
		if (stop == SCENE_STOPS)
			return scene_error(tree->file, scene_tree_find(tree, "stop[%u]", i), "%s ends no drive; allowed: overturned, buried, stuck",
					   scene_quote(raw->stop[i]).text);
		if (stop == SCENE_STOP_STUCK && raw->stuck == NULL)
			return scene_error(tree->file, scene_tree_find(tree, "stop[%u]", i), "stuck: nothing says when a vehicle is; needed with it: "
					   "stuck: {after: 5, below: 0.05}");
		scene->stop |= 1u << stop;
	}
	return STATUS_OK;
}

enum status scene_check_vehicles(const struct scene_tree *tree, const struct raw_scene *raw, struct scene *scene)
{
	const size_t count = raw->vehicles_count;
	const char *without = raw->stuck != NULL ? "stuck" : raw->stop_count > 0 ? "stop" : raw->world != NULL ? "world" : scene->vehicle_rows > 0 ? "output.vehicles" : scene->sensor_rows > 0 ? "output.sensors" : NULL;
	if (count == 0 && without != NULL)
		return scene_error(tree->file, scene_tree_find(tree, "%s", without), "is of vehicles, and there is none; allowed with: vehicles");
	if (count == 0)
		return STATUS_OK;
	if (!deform_tells_forces(scene->model))
		return scene_error(tree->file, scene_tree_find(tree, "vehicles"), "model %s computes no force that carries them; allowed with: "
				   "redistribute: {model: %s}", deform_model_row(scene->model)->name, scene_models_with_forces().text);
	if (raw->stuck != NULL) {
		scene->stuck_after = raw->stuck->after;
		scene->stuck_below = raw->stuck->below;
	}
	TRY(take_stop(tree, raw, scene));
	TRY(mem_zeroed(&scene->vehicles, count, sizeof *scene->vehicles, "reading the vehicles"));
	for (size_t i = 0; i < count; i++) {
		scene->vehicle_count = i + 1;
		TRY(check_vehicle(tree, &raw->vehicles[i], i, scene, &scene->vehicles[i]));
	}
	return check_things(tree, raw, scene);
}

static void finish_texts(struct scene_texts *texts)
{
	mem_free_list(texts->list, texts->count);
}

void scene_vehicle_finish(struct scene_vehicle *vehicle)
{
	for (size_t i = 0; i < vehicle->surface_count; i++)
		mem_free(vehicle->surfaces[i].geoms);
	mem_free_all(vehicle->name, vehicle->model, vehicle->keyframe, vehicle->controls, vehicle->way.points, vehicle->held.values, vehicle->speeds, vehicle->stops,
		     vehicle->surfaces, vehicle->pushes, vehicle->imu.body, vehicle->start.joints.values, vehicle->start.controls.values);
	finish_texts(&vehicle->start.joints.names);
	finish_texts(&vehicle->start.controls.names);
	mem_free(vehicle->powertrain.engine);
	finish_texts(&vehicle->powertrain.wheels);
	for (size_t i = 0; i < vehicle->tyre_count; i++)
		mem_free(vehicle->tyres[i].geom);
	mem_free(vehicle->tyres);
	finish_texts(&vehicle->soil);
	finish_texts(&vehicle->model_path);
	finish_texts(&vehicle->no_soil);
	finish_texts(&vehicle->servo.free);
	finish_texts(&vehicle->servo.lock);
	finish_texts(&vehicle->carry);
	finish_texts(&vehicle->steer);
	finish_texts(&vehicle->drive);
	finish_texts(&vehicle->held.names);
}
