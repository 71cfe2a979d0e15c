/* Checks the view of a scene and fills its values: picture size, camera and effects. */
#include <stdio.h>
#include <string.h>

#include "scene/scene_check.h"
#include "scene/scene_error.h"
#include "scene/scene_sun.h"

enum status scene_find_target(const struct scene_tree *tree, const struct scene *scene, const char *name, const char *key,
			      struct scene_aim *aim)
{
	struct scene_list names = {.length = 0};
	for (size_t i = 0; i < scene->object_count; i++) {
		if (strcmp(scene->objects[i].name, name) == 0) {
			aim->object = (int)i;
			return STATUS_OK;
		}
		scene_list_add(&names, scene->objects[i].name);
	}
	for (size_t i = 0; i < scene->vehicle_count; i++) {
		if (strcmp(scene->vehicles[i].name, name) == 0) {
			aim->vehicle = (int)i + 1;
			return STATUS_OK;
		}
		scene_list_add(&names, scene->vehicles[i].name);
	}
	return scene_error(tree->file, scene_tree_find(tree, "%s", key),
			   "%s is no object; allowed: %s", scene_quote(name).text,
			   names.length > 0 ? names.text : "an object, of which there is none");
}

static enum status check_camera(const struct scene_tree *tree, const struct raw_camera *raw,
				struct scene *scene)
{
	struct scene_view *view = &scene->view;
	const struct scene_node *node = scene_tree_find(tree, "view.camera");
	int named = (raw->chase != NULL) + (raw->overhead != NULL) + (raw->fixed != NULL);
	if (named != 1)
		return scene_error(tree->file, node,
				   "names %d cameras; allowed: exactly one of chase, overhead, fixed",
				   named);
	if (raw->chase == NULL && (raw->back != NULL || raw->up != NULL))
		return scene_error(tree->file,
				   scene_tree_find(tree, raw->back != NULL ? "view.camera.back"
									   : "view.camera.up"),
				   "is not of this camera; allowed with: chase");
	if (raw->chase != NULL) {
		view->aim.kind = SCENE_CHASE;
		view->aim.back = raw->back != NULL ? *raw->back : scene_absent("view.camera.back");
		view->aim.up = raw->up != NULL ? *raw->up : scene_absent("view.camera.up");
		if (view->aim.back == 0 && view->aim.up == 0)
			return scene_error(tree->file, node,
					   "stands in its object; allowed: back or up above 0");
		return scene_find_target(tree, scene, raw->chase, "view.camera.chase", &view->aim);
	}
	if (raw->overhead != NULL) {
		view->aim.kind = SCENE_OVERHEAD;
		view->aim.over_height = raw->overhead->height;
		return scene_find_target(tree, scene, raw->overhead->over, "view.camera.overhead.over", &view->aim);
	}
	view->aim.kind = SCENE_FIXED;
	memcpy(view->aim.eye, raw->fixed->eye, sizeof view->aim.eye);
	memcpy(view->aim.target, raw->fixed->target, sizeof view->aim.target);
	if (view->aim.eye[0] == view->aim.target[0] && view->aim.eye[1] == view->aim.target[1] &&
	    view->aim.eye[2] == view->aim.target[2])
		return scene_error(tree->file, scene_tree_find(tree, "view.camera.fixed.target"),
				   "is the eye; allowed: another place");
	return STATUS_OK;
}

static enum status check_effects(const struct scene_tree *tree, const struct raw_view *raw,
				 struct scene_view *view)
{
	struct scene_list names = {.length = 0};
	for (int e = 0; e < EFFECT_COUNT; e++)
		if (strcmp(scene_effect_row((enum scene_effect)e)->key, "view.effects") == 0)
			scene_list_add(&names, scene_effect_row((enum scene_effect)e)->name);
	for (uint32_t i = 0; i < raw->effects_count; i++) {
		const struct scene_node *node = scene_tree_find(tree, "view.effects[%u]", i);
		uint64_t bit = 0;
		for (int e = 0; e < EFFECT_COUNT; e++) {
			const struct effect_row *row = scene_effect_row((enum scene_effect)e);
			if (strcmp(row->key, "view.effects") == 0 &&
			    strcmp(row->name, raw->effects[i]) == 0)
				bit = EFFECT_BIT(e);
		}
		if (bit == 0)
			return scene_error(tree->file, node, "%s is unknown; allowed: %s",
					   scene_quote(raw->effects[i]).text, names.text);
		if ((view->effects & bit) != 0)
			return scene_error(tree->file, node, "%s is named twice; allowed: once",
					   scene_quote(raw->effects[i]).text);
		view->effects |= bit;
	}
	return STATUS_OK;
}

static enum status check_samples(const struct scene_tree *tree, const struct raw_view *raw, struct scene_view *view)
{
	view->samples = raw->samples != NULL ? (int)*raw->samples : (int)scene_absent("view.samples");
	if ((view->samples & (view->samples - 1)) == 0)
		return STATUS_OK;
	return scene_error(tree->file, scene_tree_find(tree, "view.samples"), "%d is no number of samples; allowed: 1, 2, 4, 8",
			   view->samples);
}

struct scene_light scene_light_default(void)
{
	return (struct scene_light){.body = SCENE_EARTH, .azimuth = SCENE_SUN_AZIMUTH, .height = SCENE_SUN_HEIGHT};
}

/* Says why a text is no time: what would make it one. */
static enum status refuse_time(const struct scene_tree *tree, const char *text)
{
	const struct scene_node *node = scene_tree_find(tree, "view.sun.time");
	char mended[80];
	double days;
	snprintf(mended, sizeof mended, "%sZ", text);
	if (scene_sun_time(mended, &days))
		return scene_error(tree->file, node, "%s has no Z at its end; end it with Z: UTC", scene_quote(text).text);
	snprintf(mended, sizeof mended, "%.8s01%s", text, strlen(text) > 10 ? text + 10 : "");
	if (scene_sun_time(mended, &days))
		return scene_error(tree->file, node, "%s is no time: its month has no day %.2s; allowed: a day of that month", scene_quote(text).text, text + 8);
	return scene_error(tree->file, node, "%s is no time; allowed: UTC from 1900 to 2100, as 2026-11-27T16:00:00Z", scene_quote(text).text);
}

/* The sun of a time and a place. */
static enum status check_time(const struct scene_tree *tree, const struct raw_sun *sun, struct scene_light *light)
{
	if (sun->at != NULL && sun->time == NULL)
		return scene_error(tree->file, scene_tree_find(tree, "view.sun.at"), "is where a time's sun is seen, and there is no time; allowed with: time");
	if (sun->time == NULL)
		return STATUS_OK;
	if (sun->azimuth != NULL || sun->height != NULL)
		return scene_error(tree->file, scene_tree_find(tree, "view.sun.time"), "and an angle are given; allowed: time, or azimuth and height");
	if (!scene_sun_time(sun->time, &light->days))
		return refuse_time(tree, sun->time);
	light->timed = true;
	light->placed = sun->at != NULL;
	if (sun->at != NULL && fabs(sun->at[1]) > 90)
		return scene_error(tree->file, scene_tree_find(tree, "view.sun.at[1]"), "%g is no latitude; allowed: longitude, latitude", sun->at[1]);
	light->longitude = light->placed ? sun->at[0] * M_PI / 180 : 0;
	light->latitude = light->placed ? sun->at[1] * M_PI / 180 : 0;
	return STATUS_OK;
}

static struct scene_light light_of(const struct raw_view *raw)
{
	const struct raw_sun *sun = raw->sun;
	struct scene_light light = scene_light_default();
	light.on_body = raw->body != NULL;
	if (raw->body != NULL)
		light.body = (enum scene_body)*raw->body;
	light.exposure = raw->exposure != NULL ? (enum scene_exposure)*raw->exposure : SCENE_EXPOSURE_FIXED;
	light.ev = raw->ev != NULL ? *raw->ev : scene_absent("view.ev");
	if (sun != NULL && sun->azimuth != NULL)
		light.azimuth = *sun->azimuth * M_PI / 180;
	if (sun != NULL && sun->height != NULL)
		light.height = *sun->height * M_PI / 180;
	if (sun != NULL && sun->colour != NULL) {
		light.coloured = true;
		memcpy(light.colour, sun->colour, sizeof light.colour);
	}
	return light;
}

enum status scene_check_view(const struct scene_tree *tree, const struct raw_scene *raw,
			     struct scene *scene)
{
	struct scene_view *view = &scene->view;
	if (raw->view == NULL)
		return STATUS_OK;
	view->present = true;
	view->aim.vehicle = 0;
	view->width = raw->view->size != NULL ? (int)raw->view->size[0] : 1280;
	view->height = raw->view->size != NULL ? (int)raw->view->size[1] : 720;
	view->images = raw->view->images != NULL ? *raw->view->images : (int64_t)scene_absent("view.images");
	view->pixel_error = raw->view->pixel_error != NULL ? *raw->view->pixel_error : 0;
	if (raw->view->truth != NULL)
		view->truth = *raw->view->truth ? SCENE_TRUTH_ALL : SCENE_TRUTH_NONE;
	view->imagery_budget = raw->view->imagery_budget != NULL ? *raw->view->imagery_budget : scene_absent("view.imagery_budget");
	view->light = light_of(raw->view);
	view->aim = (struct scene_aim){.kind = SCENE_FIXED, .target = {1, 0, 0}}; /* of a host, which gives a camera with each picture */
	if (raw->view->camera != NULL)
		TRY(check_camera(tree, raw->view->camera, scene));
	TRY(check_samples(tree, raw->view, view));
	if (raw->view->sun != NULL)
		TRY(check_time(tree, raw->view->sun, &view->light));
	return check_effects(tree, raw->view, view);
}
