/* The scene outside its objects and its view; see scene_check.h. */
#include "scene/scene_check.h"

#include <string.h>

#include "scene/scene_error.h"
#include "scene/scene_file.h"

static double number_or(const double *value, double absent)
{
	return value != NULL ? *value : absent;
}

static int64_t whole_or(const int64_t *value, int64_t absent)
{
	return value != NULL ? *value : absent;
}

static enum status copy(char **out, const char *text)
{
	*out = mem_strdup(text);
	return *out == NULL ? fail_memory("reading the scene") : STATUS_OK;
}

static enum status check_soil(const struct scene_tree *tree, const struct raw_soil *soil,
			      struct scene *scene)
{
	static const char *const names[] = {
		"dry_sand",	 "sandy_loam_15", "sandy_loam_22", "clayey_38",
		"heavy_clay_25", "heavy_clay_40", "lean_clay_22",  "lete_sand",
		"upland_loam_51", "snow_us",	  "snow_sweden",   "lunar"};
	struct scene_list list = {.length = 0};
	bool known = false;
	if (soil == NULL)
		return STATUS_OK;
	for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
		known = known || (soil->name != NULL && strcmp(soil->name, names[i]) == 0);
		scene_list_add(&list, names[i]);
	}
	if (soil->name != NULL && !known)
		return scene_error(tree->file, scene_tree_find(tree, "soil.name"),
				   "%s is unknown; allowed: %s", scene_quote(soil->name).text,
				   list.text);
	note("%s: soil: is checked but not read: no model of this version depends on it", tree->file);
	return soil->name != NULL ? copy(&scene->soil, soil->name) : STATUS_OK;
}

static enum status check_redistribute(const struct scene_tree *tree,
				      const struct raw_redistribute *redistribute,
				      struct scene *scene)
{
	scene->model = DEFORM_NONE;
	scene->box_radius = 1;
	scene->box_repetitions = 1;
	if (redistribute == NULL)
		return STATUS_OK;
	scene->model = (enum deform_model)redistribute->model;
	if (scene->model == DEFORM_NONE &&
	    (redistribute->radius != NULL || redistribute->repetitions != NULL))
		return scene_error(tree->file,
				   scene_tree_find(tree, redistribute->radius != NULL
								 ? "redistribute.radius"
								 : "redistribute.repetitions"),
				   "is no parameter of model none; allowed with: box");
	scene->box_radius = (int)whole_or(redistribute->radius, 1);
	scene->box_repetitions = (int)whole_or(redistribute->repetitions, 1);
	return STATUS_OK;
}

static enum status check_attributes(const struct scene_tree *tree, const struct raw_scene *raw,
				    struct scene *scene)
{
	const char *dirt = scene_effect_row(EFFECT_DIRT)->name;
	for (uint32_t i = 0; i < raw->attributes_count; i++) {
		const struct scene_node *node = scene_tree_find(tree, "attributes[%u]", i);
		if (strcmp(raw->attributes[i], dirt) != 0)
			return scene_error(tree->file, node, "%s is unknown; allowed: %s",
					   scene_quote(raw->attributes[i]).text, dirt);
		if (scene->dirt)
			return scene_error(tree->file, node, "%s is named twice; allowed: once", dirt);
		scene->dirt = true;
	}
	return STATUS_OK;
}

static enum status check_coordinates(const struct raw_scene *raw, struct scene *scene)
{
	if (raw->coordinates == NULL || strcmp(raw->coordinates, "local") == 0)
		return STATUS_OK;
	if (strcmp(raw->coordinates, "store") == 0) {
		scene->coordinates = SCENE_STORE;
		return STATUS_OK;
	}
	scene->coordinates = SCENE_SRS;
	return copy(&scene->srs, raw->coordinates);
}

enum status scene_check(const struct scene_tree *tree, const struct raw_scene *raw,
			struct scene *scene)
{
	const struct raw_cache none = {.slots = NULL};
	const struct raw_cache *cache = raw->cache != NULL ? raw->cache : &none;
	enum status status;

	if (raw->store != NULL) {
		scene->store = scene_file_beside(tree->file, raw->store);
		if (scene->store == NULL)
			return fail_memory("reading the scene");
	}
	scene->time_step = number_or(raw->time_step, 0.02);
	scene->end_time = raw->end_time;
	scene->gravity = number_or(raw->gravity, 9.81);
	scene->spacing = number_or(raw->spacing, 0);
	scene->outside = raw->outside != NULL ? (enum scene_outside)*raw->outside : SCENE_STOP;
	scene->slots = (uint32_t)whole_or(cache->slots, 256);
	scene->loaders = (uint32_t)whole_or(cache->loaders, 2);
	scene->prefetch = number_or(cache->prefetch, 1.5);

	if ((status = check_coordinates(raw, scene)) != STATUS_OK ||
	    (status = check_redistribute(tree, raw->redistribute, scene)) != STATUS_OK ||
	    (status = check_attributes(tree, raw, scene)) != STATUS_OK ||
	    (status = scene_check_objects(tree, raw, scene)) != STATUS_OK ||
	    (status = scene_check_view(tree, raw, scene)) != STATUS_OK ||
	    (status = check_soil(tree, raw->soil, scene)) != STATUS_OK)
		return status;
	return scene_hash(raw, scene);
}
