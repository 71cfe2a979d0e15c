/* The checked objects: names, paths, what they bear. */
#include <string.h>

#include "scene/scene_check.h"
#include "scene/scene_error.h"
#include "scene/scene_file.h"
#include "scene/scene_path.h"

static enum status check_name(const struct scene_tree *tree, const struct scene *scene,
			      size_t index)
{
	const char *name = scene->objects[index].name;
	const struct scene_node *node = scene_tree_find(tree, "objects[%zu].name", index);
	if (strspn(name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") !=
	    strlen(name))
		return scene_error(tree->file, node, "%s is not a name; allowed: A-Z a-z 0-9 _ -",
				   scene_quote(name).text);
	for (size_t i = 0; i < index; i++)
		if (strcmp(scene->objects[i].name, name) == 0)
			return scene_error(tree->file, node,
					   "%s is the name of another object; allowed: unique names",
					   scene_quote(name).text);
	return STATUS_OK;
}

static enum status take_points(const struct raw_path *raw, struct scene_path *path)
{
	path->points = mem_calloc(raw->points_count, sizeof *path->points);
	if (path->points == NULL)
		return fail_memory("reading the points of a path");
	path->count = raw->points_count;
	path->loop = raw->loop != NULL && *raw->loop;
	path->speed = *raw->speed;
	for (uint32_t i = 0; i < raw->points_count; i++)
		path->points[i] =
			(struct scene_waypoint){.x = raw->points[i][0], .y = raw->points[i][1]};
	return STATUS_OK;
}

static enum status check_path(const struct scene_tree *tree, const struct raw_path *raw,
			      size_t index, struct scene_path *path)
{
	const struct scene_node *node = scene_tree_find(tree, "objects[%zu].path", index);
	if ((raw->points != NULL) == (raw->file != NULL))
		return scene_error(tree->file, node, "names %s; allowed: exactly one of points, file",
				   raw->file != NULL ? "both points and file"
						     : "neither points nor file");
	if (raw->points != NULL) {
		if (raw->speed == NULL)
			return scene_error(tree->file, node,
					   "has no speed; allowed: points with a speed in m/s");
		return take_points(raw, path);
	}
	if (raw->speed != NULL || raw->loop != NULL)
		return scene_error(tree->file,
				   scene_tree_find(tree, "objects[%zu].path.%s", index,
						   raw->speed != NULL ? "speed" : "loop"),
				   "does not go with a file; allowed with: points");
	node = scene_tree_find(tree, "objects[%zu].path.file", index);
	char *file = scene_file_beside(tree->file, raw->file);
	if (file == NULL)
		return fail_memory("reading poses");
	enum status status = scene_path_read(file, scene_told(tree->file, node, raw->file).text, path);
	mem_free(file);
	return status;
}

/* What only forces can decide: of model scm. */
static enum status check_forces(const struct scene_tree *tree, const struct raw_object *raw,
				const struct scene *scene, size_t index)
{
	const struct scene_object *object = &scene->objects[index];
	const char *model = scene_model_word(scene->model);
	const struct scene_node *load = scene_tree_find(tree, "objects[%zu].load", index);
	const struct scene_node *slip = scene_tree_find(tree, "objects[%zu].slip", index);
	if (raw->load != NULL && raw->sink != NULL)
		return scene_error(tree->file, load, "sink is given too; allowed: one of sink, load");
	if (raw->load != NULL && scene->model != DEFORM_SCM)
		return scene_error(tree->file, load, "model %s computes no force that carries it; allowed with: "
				   "redistribute: {model: scm}", model);
	if (raw->load != NULL && object->path.has_z)
		return scene_error(tree->file, load, "its poses say z already; allowed with: poses t,x,y, or points");
	if (raw->slip != NULL && object->shape.kind != DEFORM_WHEEL)
		return scene_error(tree->file, slip, "only a wheel slips; allowed with: wheel");
	if (raw->slip != NULL && scene->model != DEFORM_SCM)
		return scene_error(tree->file, slip, "model %s does not depend on it; allowed with: redistribute: "
				   "{model: scm}", model);
	return STATUS_OK;
}

enum status scene_check_objects(const struct scene_tree *tree, const struct raw_scene *raw,
				struct scene *scene)
{
	size_t count = raw->objects_count;
	if (count == 0) {
		if (raw->view != NULL)
			return STATUS_OK;
		return scene_error(tree->file, scene_tree_find(tree, "objects"),
				   "no object and no view; needed: objects, a view, or both");
	}
	scene->objects = mem_calloc(count, sizeof *scene->objects);
	if (scene->objects == NULL)
		return fail_memory("reading the objects");
	for (size_t i = 0; i < count; i++) {
		struct scene_object *object = &scene->objects[i];
		const struct raw_object *from = &raw->objects[i];
		enum status status;
		scene->object_count = i + 1;
		object->name = mem_strdup(from->name);
		if (object->name == NULL)
			return fail_memory("reading the objects");
		object->sink = from->sink != NULL ? *from->sink : 0;
		object->load = from->load != NULL ? *from->load : 0;
		object->slip = from->slip != NULL ? *from->slip : 0;
		if ((status = check_name(tree, scene, i)) != STATUS_OK ||
		    (status = scene_check_shape(tree, &from->shape, i, object)) != STATUS_OK ||
		    (status = check_path(tree, &from->path, i, &object->path)) != STATUS_OK ||
		    (status = check_forces(tree, from, scene, i)) != STATUS_OK)
			return status;
		if (object->path.has_z && from->sink != NULL)
			status = scene_tell_unused(scene, "objects.%s.sink: its poses say z already; take it away", object->name);
		if (status != STATUS_OK)
			return status;
	}
	return STATUS_OK;
}
