/* Checks the cameras of a scene and fills their values: where each is, what it sees, and what it writes. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scene/scene_check.h"
#include "scene/scene_error.h"
#include "scene/scene_file.h"
#include "scene/scene_path.h"

#define RADIANS (M_PI / 180)

/* An entry of the list, and what is made of it. */
struct entry {
	const struct scene_tree *tree;
	const struct raw_listed_camera *raw;
	size_t index;
	const struct scene *scene;
	struct scene_camera *camera;
};

static const struct scene_node *node_of(const struct entry *entry, const char *key)
{
	return scene_tree_find(entry->tree, "cameras[%zu]%s%s", entry->index, key[0] != '\0' ? "." : "", key);
}

static const char *const kinds[] = {
	[SCENE_CHASE] = "chase", [SCENE_OVERHEAD] = "overhead", [SCENE_FIXED] = "fixed", [SCENE_MOUNTED] = "mounted", [SCENE_BY_POSES] = "poses",
};

/* The keys that say where a camera is, and the kinds that have each. */
static const struct {
	const char *key;
	unsigned needed, allowed; /* 1 << enum scene_camera_kind */
} places[] = {
	{"on", 1u << SCENE_CHASE | 1u << SCENE_OVERHEAD | 1u << SCENE_MOUNTED, 1u << SCENE_CHASE | 1u << SCENE_OVERHEAD | 1u << SCENE_MOUNTED},
	{"body", 0, 1u << SCENE_MOUNTED},
	{"pose", 1u << SCENE_FIXED, 1u << SCENE_FIXED | 1u << SCENE_MOUNTED},
	{"back", 0, 1u << SCENE_CHASE},
	{"up", 0, 1u << SCENE_CHASE},
	{"height", 1u << SCENE_OVERHEAD, 1u << SCENE_OVERHEAD},
	{"file", 1u << SCENE_BY_POSES, 1u << SCENE_BY_POSES},
};

static enum status check_keys(const struct entry *entry)
{
	const struct raw_listed_camera *raw = entry->raw;
	const bool given[] = {raw->on != NULL, raw->body != NULL, raw->pose != NULL, raw->back != NULL, raw->up != NULL, raw->height != NULL, raw->file != NULL};
	for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
		struct scene_list with = {.length = 0};
		for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; k++)
			if (places[i].allowed >> k & 1)
				scene_list_add(&with, kinds[k]);
		if (given[i] && !(places[i].allowed >> raw->kind & 1))
			return scene_error(entry->tree->file, node_of(entry, places[i].key), "is not of a camera of kind %s; allowed with: %s",
					   kinds[raw->kind], with.text);
		if (!given[i] && (places[i].needed >> raw->kind & 1))
			return scene_error(entry->tree->file, node_of(entry, ""), "is of kind %s and has no %s; needed: %s", kinds[raw->kind],
					   places[i].key, places[i].key);
	}
	return STATUS_OK;
}

static enum status check_name(const struct entry *entry, const char *name)
{
	const struct scene_node *node = node_of(entry, "name");
	TRY(scene_check_name(entry->tree, node, name));
	for (size_t i = 0; i < entry->scene->camera_count; i++)
		if (&entry->scene->cameras[i] != entry->camera && entry->scene->cameras[i].name != NULL && strcmp(entry->scene->cameras[i].name, name) == 0)
			return scene_error(entry->tree->file, node, "%s is the name of another camera; allowed: unique names",
					   scene_quote(name).text);
	return mem_text(&entry->camera->name, name, "reading the cameras");
}

/* --- where it is --- */

static enum status check_pose(const struct entry *entry)
{
	const struct raw_camera_pose *pose = entry->raw->pose;
	struct scene_camera *camera = entry->camera;
	if (pose == NULL)
		return STATUS_OK;
	const bool turned = pose->yaw != NULL || pose->pitch != NULL || pose->roll != NULL;
	if (pose->target != NULL && turned)
		return scene_error(entry->tree->file, node_of(entry, "pose.target"), "and an angle are given; allowed: a target, or yaw, pitch and roll");
	memcpy(camera->aim.eye, pose->at, sizeof pose->at);
	camera->yaw = pose->yaw != NULL ? *pose->yaw * RADIANS : 0;
	camera->pitch = pose->pitch != NULL ? *pose->pitch * RADIANS : 0;
	camera->roll = pose->roll != NULL ? *pose->roll * RADIANS : 0;
	if (pose->target == NULL)
		return STATUS_OK;
	const double dx = pose->target[0] - pose->at[0], dy = pose->target[1] - pose->at[1], dz = pose->target[2] - pose->at[2];
	if (dx == 0 && dy == 0 && dz == 0)
		return scene_error(entry->tree->file, node_of(entry, "pose.target"), "is where the camera is; allowed: another place");
	/* straight down or up: the second axis is the picture's top */
	camera->yaw = dx == 0 && dy == 0 ? M_PI / 2 : atan2(dy, dx);
	camera->pitch = atan2(dz, hypot(dx, dy));
	return STATUS_OK;
}

static enum status read_poses(const struct entry *entry)
{
	struct scene_path *poses = &entry->camera->poses;
	const struct scene_node *node = node_of(entry, "file");
	char *file = scene_file_beside(entry->tree->folder, entry->raw->file);
	TRY_MEM(file, "reading poses");
	const enum status status = scene_path_read(file, scene_told(entry->tree->file, node, entry->raw->file).text, poses);
	mem_free(file);
	TRY(status);
	if (!poses->has_attitude)
		return scene_error(entry->tree->file, node, "its rows say no attitude; allowed: t,x,y,z,yaw,pitch,roll");
	return STATUS_OK;
}

/* The models are not read yet: vehicle_load looks for the body. */
static enum status check_body(const struct entry *entry)
{
	struct scene_camera *camera = entry->camera;
	if (entry->raw->body == NULL)
		return STATUS_OK;
	if (camera->aim.vehicle == 0)
		return scene_error(entry->tree->file, node_of(entry, "body"), "is given, and %s is no vehicle; allowed with: a vehicle",
				   scene_quote(entry->raw->on).text);
	return mem_text(&camera->body, entry->raw->body, "reading the cameras");
}

static enum status check_place(const struct entry *entry)
{
	const struct raw_listed_camera *raw = entry->raw;
	struct scene_aim *aim = &entry->camera->aim;
	char key[64];
	aim->kind = (enum scene_camera_kind)raw->kind;
	TRY(check_keys(entry));
	if (raw->on != NULL) {
		snprintf(key, sizeof key, "cameras[%zu].on", entry->index);
		TRY(scene_find_target(entry->tree, entry->scene, raw->on, key, aim));
	}
	TRY(check_body(entry));
	if (aim->kind == SCENE_CHASE) {
		aim->back = raw->back != NULL ? *raw->back : scene_absent("cameras[].back");
		aim->up = raw->up != NULL ? *raw->up : scene_absent("cameras[].up");
		if (aim->back == 0 && aim->up == 0)
			return scene_error(entry->tree->file, node_of(entry, ""), "stands in its object; allowed: back or up above 0");
	}
	if (raw->height != NULL)
		aim->over_height = *raw->height;
	TRY(check_pose(entry));
	return raw->file != NULL ? read_poses(entry) : STATUS_OK;
}

/* --- what it writes --- */

const char *scene_image_name(enum scene_image image)
{
	static const char *const names[SCENE_IMAGES] = {[SCENE_IMAGE_COLOUR] = "colour", [SCENE_IMAGE_DEPTH] = "depth", [SCENE_IMAGE_NORMALS] = "normals",
						   [SCENE_IMAGE_HEIGHT] = "height", [SCENE_IMAGE_CLASS] = "class", [SCENE_IMAGE_INSTANCE] = "instance", [SCENE_IMAGE_LINEAR] = "linear"};
	return names[image];
}

static enum status check_images(const struct entry *entry)
{
	const struct raw_listed_camera *raw = entry->raw;
	struct scene_list names = {.length = 0};
	for (int k = 0; k < SCENE_IMAGES; k++)
		scene_list_add(&names, scene_image_name((enum scene_image)k));
	if (raw->images_count == 0)
		entry->camera->images = 1u << SCENE_IMAGE_COLOUR;
	for (uint32_t i = 0; i < raw->images_count; i++) {
		const struct scene_node *node = scene_tree_find(entry->tree, "cameras[%zu].images[%u]", entry->index, i);
		unsigned bit = 0;
		for (int k = 0; k < SCENE_IMAGES; k++)
			bit |= strcmp(scene_image_name((enum scene_image)k), raw->images[i]) == 0 ? 1u << k : 0;
		if (bit == 0)
			return scene_error(entry->tree->file, node, "%s is unknown; allowed: %s", scene_quote(raw->images[i]).text, names.text);
		if ((entry->camera->images & bit) != 0)
			return scene_error(entry->tree->file, node, "%s is named twice; allowed: once", scene_quote(raw->images[i]).text);
		entry->camera->images |= bit;
	}
	entry->camera->video = raw->video != NULL && *raw->video;
	if (entry->camera->video && !(entry->camera->images >> SCENE_IMAGE_COLOUR & 1))
		return scene_error(entry->tree->file, node_of(entry, "video"), "is of colours, which it does not write; allowed with: images of colour");
	return STATUS_OK;
}

static enum status check_camera(const struct entry *entry)
{
	const struct raw_listed_camera *raw = entry->raw;
	struct scene_camera *camera = entry->camera;
	const double steps = 1 / entry->scene->time_step;
	camera->fov = (raw->fov != NULL ? *raw->fov : scene_absent("cameras[].fov")) * RADIANS;
	camera->width = raw->size != NULL ? (int)raw->size[0] : 640;
	camera->height = raw->size != NULL ? (int)raw->size[1] : 480;
	camera->depth_unit = raw->depth_unit != NULL ? *raw->depth_unit : scene_absent("cameras[].depth_unit");
	camera->rate = raw->rate;
	camera->exposure = raw->exposure != NULL ? (enum scene_exposure)*raw->exposure : entry->scene->view.light.exposure;
	camera->ev = raw->ev != NULL ? *raw->ev : entry->scene->view.light.ev;
	if (raw->rate > steps * (1 + 1e-9))
		return scene_error(entry->tree->file, node_of(entry, "rate"), "%g a second are more than there are steps, %g a second; allowed: at "
				   "most that, or a smaller time_step", raw->rate, steps);
	camera->pair = -1;
	TRY(check_name(entry, raw->name));
	TRY(check_place(entry));
	return check_images(entry);
}

/* Makes the right camera of a pair: NAME_right. It is like the left one, but for its place. */
static enum status add_right(const struct entry *left, struct scene *scene)
{
	struct scene_camera *camera = &scene->cameras[scene->camera_count];
	const struct entry right = {left->tree, left->raw, left->index, scene, camera};
	char name[64];
	*camera = *left->camera;
	camera->name = camera->body = NULL;
	camera->poses.points = NULL;
	camera->pair = (int)scene->camera_count - 1;
	camera->baseline = *left->raw->stereo;
	left->camera->pair = (int)scene->camera_count++;
	snprintf(name, sizeof name, "%s_right", left->raw->name);
	TRY(check_name(&right, name));
	TRY(check_body(&right));
	if (left->camera->poses.points == NULL)
		return STATUS_OK;
	TRY(mem_make(&camera->poses.points, camera->poses.count, sizeof *camera->poses.points, "reading poses"));
	memcpy(camera->poses.points, left->camera->poses.points, camera->poses.count * sizeof *camera->poses.points);
	return STATUS_OK;
}

/* A scene that has cameras and no view looks as the window's own view does. */
static void imply_view(struct scene *scene)
{
	struct scene_view *view = &scene->view;
	view->present = view->implied = true;
	view->width = scene->cameras[0].width;
	view->height = scene->cameras[0].height;
	view->samples = 1;
	view->imagery_budget = scene_absent("view.imagery_budget");
	view->light = scene_light_default();
	view->aim = (struct scene_aim){.kind = SCENE_FIXED, .target = {1, 0, 0}};
	view->effects = EFFECT_BIT(EFFECT_TEXTURE) | EFFECT_BIT(EFFECT_DETAIL) | EFFECT_BIT(EFFECT_FOG) | EFFECT_BIT(EFFECT_SKY) |
			EFFECT_BIT(EFFECT_GEOMORPH) | EFFECT_BIT(EFFECT_SKIRTS) | EFFECT_BIT(EFFECT_OBJECTS) | EFFECT_BIT(EFFECT_SHADOW);
}

enum status scene_check_cameras(const struct scene_tree *tree, const struct raw_scene *raw, struct scene *scene)
{
	if (raw->cameras_count == 0)
		return STATUS_OK;
	if (scene->hosted)
		return scene_tell_unused(scene, "cameras: write pictures of drives by the command, and a host draws its own; take them away");
	TRY(mem_zeroed(&scene->cameras, (size_t)2 * raw->cameras_count, sizeof *scene->cameras, "reading the cameras"));
	for (size_t i = 0; i < raw->cameras_count; i++) {
		const struct entry entry = {tree, &raw->cameras[i], i, scene, &scene->cameras[scene->camera_count++]};
		TRY(check_camera(&entry));
		if (raw->cameras[i].stereo != NULL)
			TRY(add_right(&entry, scene));
	}
	if (!scene->view.present)
		imply_view(scene);
	return STATUS_OK;
}

void scene_camera_finish(struct scene_camera *camera)
{
	mem_free_all(camera->name, camera->body, camera->poses.points);
}

int64_t scene_camera_frame(const struct scene_camera *camera, double time_step, int64_t step)
{
	const double each = camera->rate * time_step; /* frames a step */
	const int64_t frame = (int64_t)floor((double)step * each + 1e-9);
	return step == scene_camera_step(camera, time_step, frame) ? frame : -1;
}

int64_t scene_frame_at(double rate, double time_step, int64_t step)
{
	return scene_camera_frame(&(struct scene_camera){.rate = rate}, time_step, step);
}

int64_t scene_camera_step(const struct scene_camera *camera, double time_step, int64_t frame)
{
	return (int64_t)ceil((double)frame / (camera->rate * time_step) - 1e-6);
}
