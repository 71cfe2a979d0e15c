/* Checks the vehicles of a scene and fills their values. What the model itself says is checked when it is read: src/vehicle. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scene/scene_check.h"
#include "scene/scene_error.h"
#include "scene/scene_file.h"
#include "scene/scene_way.h"

#define MODEL_BYTES ((uint64_t)64 << 20)    /* the largest file of a model */
#define CONTROLS_BYTES ((uint64_t)256 << 20) /* the largest table of controls */

static enum status take_name(const struct scene_tree *tree, const struct scene *scene, size_t index, const char *name, char **out)
{
	const struct scene_node *node = scene_tree_find(tree, "vehicles[%zu].name", index);
	if (strspn(name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") != strlen(name))
		return scene_error(tree->file, node, "%s is not a name; allowed: A-Z a-z 0-9 _ -", scene_quote(name).text);
	for (size_t i = 0; i < scene->object_count; i++)
		if (scene->objects[i].name != NULL && strcmp(scene->objects[i].name, name) == 0)
			return scene_error(tree->file, node, "%s is the name of an object; allowed: unique names", scene_quote(name).text);
	for (size_t i = 0; i < index; i++)
		if (strcmp(scene->vehicles[i].name, name) == 0)
			return scene_error(tree->file, node, "%s is the name of another vehicle; allowed: unique names", scene_quote(name).text);
	return mem_text(out, name, "reading the vehicles");
}

static enum status take_texts(char *const *from, uint32_t count, struct scene_texts *texts)
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

static enum status check_follow(const struct scene_tree *tree, const struct raw_driver *raw, size_t index, struct scene_vehicle *vehicle)
{
	char where[48];
	if (raw->drive == NULL)
		return scene_error(tree->file, scene_tree_find(tree, "vehicles[%zu].driver", index),
				   "has a path and no actuators that drive; needed with path: drive");
	vehicle->driver = SCENE_FOLLOW;
	snprintf(where, sizeof where, "vehicles[%zu].driver.path", index);
	TRY(scene_way_take(tree, raw->path, where, &vehicle->way));
	if (vehicle->way.timed)
		return scene_error(tree->file, scene_tree_find(tree, "%s.file", where), "has times, and a driver has a speed; allowed: points, or "
							     "a file that ends in .gpx or .geojson");
	TRY(take_texts(raw->steer, raw->steer_count, &vehicle->steer));
	return take_texts(raw->drive, raw->drive_count, &vehicle->drive);
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
	struct scene_named held = {.values = NULL};
	vehicle->driver = SCENE_HOLD;
	snprintf(where, sizeof where, "vehicles[%zu].driver.hold", index);
	enum status status = take_named(tree, where, raw->hold, raw->hold_count, &held);
	vehicle->held = held.names;
	vehicle->values = held.values;
	return status;
}

static double given(const double *number)
{
	return number != NULL ? *number : 0;
}

static enum status check_start(const struct scene_tree *tree, const struct raw_start *raw, size_t index, struct scene_start *start)
{
	char where[64];
	start->pitch = given(raw->pitch) * M_PI / 180;
	start->roll = given(raw->roll) * M_PI / 180;
	start->height = given(raw->height);
	start->speed = given(raw->speed);
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
	if (raw->path == NULL && (raw->steer != NULL || raw->drive != NULL))
		return scene_error(tree->file, scene_tree_find(tree, "vehicles[%zu].driver.%s", index, raw->steer != NULL ? "steer" : "drive"),
				   "is not of this driver; allowed with: path");
	if (raw->path != NULL)
		return check_follow(tree, raw, index, vehicle);
	if (raw->hold != NULL)
		return check_hold(tree, raw, index, vehicle);
	vehicle->driver = SCENE_CONTROLS;
	return take_file(tree, scene_tree_find(tree, "vehicles[%zu].driver.controls", index), raw->controls, CONTROLS_BYTES,
			 &vehicle->controls, vehicle->controls_hash);
}

static enum status check_vehicle(const struct scene_tree *tree, const struct raw_vehicle *raw, size_t index, const struct scene *scene,
				 struct scene_vehicle *vehicle)
{
	TRY(take_name(tree, scene, index, raw->name, &vehicle->name));
	TRY(take_file(tree, scene_tree_find(tree, "vehicles[%zu].model", index), raw->model, MODEL_BYTES, &vehicle->model, vehicle->model_hash));
	TRY(take_texts(raw->soil, raw->soil_count, &vehicle->soil));
	TRY(take_texts(raw->no_soil, raw->no_soil_count, &vehicle->no_soil));
	TRY(take_texts(raw->carry, raw->carry_count, &vehicle->carry));
	const struct scene_node *at = scene_tree_find(tree, "vehicles[%zu].start.at", index);
	vehicle->line = at->setting == NULL ? at->line : 0;
	memcpy(vehicle->at, raw->start.at, sizeof vehicle->at);
	vehicle->yaw = (raw->start.yaw != NULL ? *raw->start.yaw : scene_absent("vehicles[].start.yaw")) * M_PI / 180;
	if (raw->start.keyframe != NULL)
		TRY(mem_text(&vehicle->keyframe, raw->start.keyframe, "reading the vehicles"));
	vehicle->fixed = raw->start.fixed == NULL ? SCENE_FIXED_BY_MODEL : *raw->start.fixed ? SCENE_FIXED_YES : SCENE_FIXED_NO;
	TRY(check_start(tree, &raw->start, index, &vehicle->start));
	TRY(take_folders(tree, raw->model_path, raw->model_path_count, &vehicle->model_path));
	if (raw->servo != NULL) {
		vehicle->servo.kv = raw->servo->kv != NULL ? *raw->servo->kv : 0;
		vehicle->servo.torque = raw->servo->torque != NULL ? *raw->servo->torque : 0;
	}
	return raw->driver != NULL ? check_driver(tree, raw->driver, index, vehicle) : STATUS_OK;
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
	const char *without = raw->stuck != NULL ? "stuck" : raw->stop_count > 0 ? "stop" : scene->vehicle_rows > 0 ? "output.vehicles" : NULL;
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
	return STATUS_OK;
}

static void finish_texts(struct scene_texts *texts)
{
	mem_free_list(texts->list, texts->count);
}

void scene_vehicle_finish(struct scene_vehicle *vehicle)
{
	mem_free_all(vehicle->name, vehicle->model, vehicle->keyframe, vehicle->controls, vehicle->way.points, vehicle->values,
		     vehicle->start.joints.values, vehicle->start.controls.values);
	finish_texts(&vehicle->start.joints.names);
	finish_texts(&vehicle->start.controls.names);
	finish_texts(&vehicle->soil);
	finish_texts(&vehicle->model_path);
	finish_texts(&vehicle->no_soil);
	finish_texts(&vehicle->carry);
	finish_texts(&vehicle->steer);
	finish_texts(&vehicle->drive);
	finish_texts(&vehicle->held);
}
