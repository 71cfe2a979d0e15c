/* Checks the lidars of a scene and fills their values: where each is, its rays, and how wrong it measures. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scene/scene_check.h"
#include "scene/scene_error.h"

#define RADIANS (M_PI / 180)
#define RAYS_MOST 4194304 /* of one lidar */

/* An entry of the list, and what is made of it. */
struct entry {
	const struct scene_tree *tree;
	const struct raw_lidar *raw;
	size_t index;
	const struct scene *scene;
	struct scene_lidar *lidar;
};

static const struct scene_node *node_of(const struct entry *entry, const char *key)
{
	return scene_tree_find(entry->tree, "lidars[%zu]%s%s", entry->index, key[0] != '\0' ? "." : "", key);
}

static enum status check_name(const struct entry *entry)
{
	const char *name = entry->raw->name;
	const struct scene_node *node = node_of(entry, "name");
	TRY(scene_check_name(entry->tree, node, name));
	for (size_t i = 0; i + 1 < entry->scene->lidar_count; i++)
		if (strcmp(entry->scene->lidars[i].name, name) == 0)
			return scene_error(entry->tree->file, node, "%s is the name of another lidar; allowed: unique names", scene_quote(name).text);
	for (size_t i = 0; i < entry->scene->camera_count; i++)
		if (strcmp(entry->scene->cameras[i].name, name) == 0)
			return scene_error(entry->tree->file, node, "%s is the name of a camera; allowed: unique names", scene_quote(name).text);
	return mem_text(&entry->lidar->name, name, "reading the lidars");
}

static enum status find_vehicle(const struct entry *entry)
{
	const struct scene *scene = entry->scene;
	struct scene_list names = {.length = 0};
	for (size_t i = 0; i < scene->vehicle_count; i++) {
		if (strcmp(scene->vehicles[i].name, entry->raw->on) == 0) {
			entry->lidar->vehicle = (int)i + 1;
			return STATUS_OK;
		}
		scene_list_add(&names, scene->vehicles[i].name);
	}
	return scene_error(entry->tree->file, node_of(entry, "on"), "%s is no vehicle; allowed: %s", scene_quote(entry->raw->on).text,
			   names.length > 0 ? names.text : "a vehicle, of which there is none");
}

/* The models are not read yet: vehicle_load looks for the body. */
static enum status check_place(const struct entry *entry)
{
	const struct raw_lidar *raw = entry->raw;
	struct scene_lidar *lidar = entry->lidar;
	if (raw->on != NULL)
		TRY(find_vehicle(entry));
	else if (raw->body != NULL)
		return scene_error(entry->tree->file, node_of(entry, "body"), "is a body of a vehicle, and the lidar is on none; allowed with: on");
	else if (raw->pose == NULL)
		return scene_error(entry->tree->file, node_of(entry, ""), "is nowhere; needed: on, or pose");
	if (raw->body != NULL)
		TRY(mem_text(&lidar->body, raw->body, "reading the lidars"));
	if (raw->pose == NULL)
		return STATUS_OK;
	const struct raw_camera_pose *pose = raw->pose;
	if (pose->target != NULL && (pose->yaw != NULL || pose->pitch != NULL || pose->roll != NULL))
		return scene_error(entry->tree->file, node_of(entry, "pose.target"), "and an angle are given; allowed: a target, or yaw, pitch and roll");
	memcpy(lidar->at, pose->at, sizeof lidar->at);
	lidar->yaw = pose->yaw != NULL ? *pose->yaw * RADIANS : 0;
	lidar->pitch = pose->pitch != NULL ? *pose->pitch * RADIANS : 0;
	lidar->roll = pose->roll != NULL ? *pose->roll * RADIANS : 0;
	if (pose->target == NULL)
		return STATUS_OK;
	const double dx = pose->target[0] - pose->at[0], dy = pose->target[1] - pose->at[1], dz = pose->target[2] - pose->at[2];
	if (dx == 0 && dy == 0 && dz == 0)
		return scene_error(entry->tree->file, node_of(entry, "pose.target"), "is where the lidar is; allowed: another place");
	lidar->yaw = dx == 0 && dy == 0 ? 0 : atan2(dy, dx);
	lidar->pitch = atan2(dz, hypot(dx, dy));
	return STATUS_OK;
}

static enum status check_rays(const struct entry *entry)
{
	const struct raw_lidar *raw = entry->raw;
	struct scene_lidar *lidar = entry->lidar;
	const double around = raw->fov != NULL ? raw->fov[0] : 360, up = raw->fov != NULL ? raw->fov[1] : 30;
	lidar->columns = raw->rays != NULL ? (int)raw->rays[0] : 360;
	lidar->rows = raw->rays != NULL ? (int)raw->rays[1] : 16;
	if ((int64_t)lidar->columns * lidar->rows > RAYS_MOST)
		return scene_error(entry->tree->file, node_of(entry, "rays"), "%d x %d are too many; allowed: %d in all", lidar->columns, lidar->rows, RAYS_MOST);
	if (up > 180)
		return scene_error(entry->tree->file, node_of(entry, "fov[1]"), "%g is out of range; allowed: 0 to 180", up);
	lidar->fov[0] = around * RADIANS;
	lidar->fov[1] = up * RADIANS;
	lidar->nearest = raw->range != NULL ? raw->range[0] : 0;
	lidar->farthest = raw->range != NULL ? raw->range[1] : 100;
	if (!(lidar->farthest > lidar->nearest))
		return scene_error(entry->tree->file, node_of(entry, "range"), "goes from %g to %g; allowed: a lower number, then a higher one", lidar->nearest, lidar->farthest);
	return STATUS_OK;
}

static enum status check_lidar(const struct entry *entry)
{
	const struct raw_lidar *raw = entry->raw;
	const double steps = 1 / entry->scene->time_step;
	TRY(check_name(entry));
	TRY(check_place(entry));
	TRY(check_rays(entry));
	entry->lidar->rate = raw->rate;
	entry->lidar->noise = raw->noise != NULL ? *raw->noise : scene_absent("lidars[].noise");
	entry->lidar->dropout = raw->dropout != NULL ? *raw->dropout : scene_absent("lidars[].dropout");
	if (raw->rate > steps * (1 + 1e-9))
		return scene_error(entry->tree->file, node_of(entry, "rate"), "%g a second are more than there are steps, %g a second; allowed: at most that, or a smaller "
				   "time_step", raw->rate, steps);
	return STATUS_OK;
}

enum status scene_check_lidars(const struct scene_tree *tree, const struct raw_scene *raw, struct scene *scene)
{
	if (raw->lidars_count == 0)
		return STATUS_OK;
	if (scene->hosted)
		return scene_tell_unused(scene, "lidars: write files of drives by the command, and a host asks for rays of its own; take them away");
	TRY(mem_zeroed(&scene->lidars, raw->lidars_count, sizeof *scene->lidars, "reading the lidars"));
	for (size_t i = 0; i < raw->lidars_count; i++) {
		const struct entry entry = {tree, &raw->lidars[i], i, scene, &scene->lidars[scene->lidar_count++]};
		TRY(check_lidar(&entry));
	}
	return STATUS_OK;
}

void scene_lidar_finish(struct scene_lidar *lidar)
{
	mem_free_all(lidar->name, lidar->body);
}
