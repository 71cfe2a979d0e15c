/* Checks the objects of a scene and fills their values: names, paths, and the loads that they carry. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scene/scene_alias.h"
#include "scene/scene_check.h"
#include "scene/scene_error.h"
#include "scene/scene_read.h"
#include "scene/scene_mesh.h"
#include "scene/scene_path.h"
#include "scene/scene_way.h"

/* Returns true if another object of the scene already has the name. While the scene is read, later objects have no names yet. */
static bool is_named(const struct scene *scene, const struct scene_object *object, const char *name)
{
	for (size_t i = 0; i < scene->object_count; i++)
		if (&scene->objects[i] != object && scene->objects[i].name != NULL &&
		    strcmp(scene->objects[i].name, name) == 0)
			return true;
	return false;
}

static enum status take_name(const struct scene_tree *tree, const struct scene *scene, size_t index,
			     const char *name, struct scene_object *object)
{
	const struct scene_node *node = scene_tree_find(tree, "objects[%zu].name", index);
	TRY(scene_check_name(tree, node, name));
	if (is_named(scene, object, name))
		return scene_error(tree->file, node,
				   "%s is the name of another object; allowed: unique names",
				   scene_quote(name).text);
	return mem_text(&object->name, name, "reading the objects");
}

/* Names an object body-1, or body-N with the first N whose name no other object has. */
static enum status make_name(const struct scene *scene, struct scene_object *object)
{
	char name[32];
	size_t number = 1;
	do
		snprintf(name, sizeof name, "body-%zu", number++);
	while (is_named(scene, object, name));
	object->name = mem_strdup(name);
	object->name_is_made = true;
	return object->name != NULL ? STATUS_OK : fail_memory("reading the objects");
}

/* Checks the keys that need a model that computes forces. */
static enum status check_forces(const struct scene_tree *tree, const struct raw_object *raw,
				const struct scene_object *object, const struct scene *scene, size_t index)
{
	const char *model = deform_model_row(scene->model)->name;
	const bool forces = deform_tells_forces(scene->model);
	const struct scene_node *load = scene_tree_find(tree, "objects[%zu].load", index);
	const struct scene_node *slip = scene_tree_find(tree, "objects[%zu].slip", index);
	const struct scene_node *interface = scene_tree_find(tree, "objects[%zu].interface", index);
	if (raw->load != NULL && raw->sink != NULL)
		return scene_error(tree->file, load, "sink is given too; allowed: one of sink, load");
	if (raw->load != NULL && !forces && !deform_is_elastic(scene->model))
		return scene_error(tree->file, load, "model %s computes no force that carries it; allowed with: "
				   "redistribute: {model: %s}", model, scene_models_with_loads().text);
	if (raw->load != NULL && !forces && scene->compute == SCENE_GPU)
		return scene_error(tree->file, load, "the CPU finds how deep a sheet bears it; allowed with: compute: cpu, or without compute");
	if (raw->load != NULL && object->path.has_z)
		return scene_error(tree->file, load, "its poses say z already; allowed with: poses t,x,y, or points");
	if (raw->slip != NULL && !soil_shape_runs(&object->shape))
		return scene_error(tree->file, slip, "only a wheel or a belt slips; allowed with: wheel, or belt: true of a box or a mesh");
	if (raw->slip != NULL && !forces && !scene->vegetation.present)
		return scene_error(tree->file, slip, "model %s does not depend on it; allowed with: redistribute: "
				   "{model: %s}, or attributes: [vegetation]", model, scene_models_with_forces().text);
	if (raw->carry != NULL && *raw->carry && !forces)
		return scene_error(tree->file, scene_tree_find(tree, "objects[%zu].carry", index), "model %s lets no soil lie on a body; allowed with: redistribute: {model: %s}", model,
				   scene_models_with_forces().text);
	if (raw->carry != NULL && *raw->carry && object->shape.kind != SOIL_BOX && object->shape.kind != SOIL_MESH)
		return scene_error(tree->file, scene_tree_find(tree, "objects[%zu].carry", index), "soil rolls off this shape; allowed with: box, mesh");
	if (raw->carry != NULL && *raw->carry && object->shape.belt)
		return scene_error(tree->file, scene_tree_find(tree, "objects[%zu].carry", index), "a belt would take its soil along; allowed with: belt: false");
	if (raw->shape.wheel != NULL && raw->shape.wheel->tyre != NULL && !forces)
		return scene_error(tree->file, scene_tree_find(tree, "objects[%zu].shape.wheel.tyre", index), "model %s does not depend on it; allowed with: redistribute: {model: %s}", model,
				   scene_models_with_forces().text);
	if (raw->interface != NULL && !forces)
		return scene_error(tree->file, interface, "model %s does not depend on it; allowed with: redistribute: "
				   "{model: %s}", model, scene_models_with_forces().text);
	return STATUS_OK;
}

/* Refuses keys that a host's body cannot use, since the host moves and turns the body. */
static enum status check_hosted(const struct scene_tree *tree, const struct raw_object *raw, size_t index)
{
	const char *key = raw->load != NULL ? "load" : raw->sink != NULL ? "sink" : raw->slip != NULL ? "slip" : raw->attitude != NULL ? "attitude" : NULL;
	if (key == NULL)
		return STATUS_OK;
	return scene_error(tree->file, scene_tree_find(tree, "objects[%zu].%s", index, key),
			   "is for an object with a path, and the host moves this one; allowed with: path");
}

struct soil_interface scene_interface(const double *friction_angle, const double *adhesion)
{
	return (struct soil_interface){.has_friction = friction_angle != NULL, .has_adhesion = adhesion != NULL,
				       .friction_angle = scene_or(friction_angle, 0) * M_PI / 180, .adhesion = scene_or(adhesion, 0)};
}

/* Fills `object`, which is zero, from entry `index` of the tree's objects. The name stays NULL if the entry has none. */
static enum status take_object(const struct scene_tree *tree, const struct raw_object *raw, size_t index, const struct scene *scene,
			       struct scene_object *object)
{
	char where[40];
	snprintf(where, sizeof where, "objects[%zu].path", index);
	object->sink = scene_or(raw->sink, 0);
	object->load = scene_or(raw->load, 0);
	object->slip = scene_or(raw->slip, 0);
	object->carry = raw->carry != NULL && *raw->carry;
	if (raw->interface != NULL)
		object->interface = scene_interface(raw->interface->friction_angle, raw->interface->adhesion);
	if (raw->name != NULL)
		TRY(take_name(tree, scene, index, raw->name, object));
	TRY(scene_check_shape(tree, &raw->shape, index, scene, object));
	return raw->path != NULL ? scene_way_take(tree, raw->path, where, &object->path) : check_hosted(tree, raw, index);
}

/* Takes how the object is turned against its way. Of a wheel the axle counts. */
static enum status take_attitude(const struct scene_tree *tree, const struct raw_object *raw, size_t index, struct scene_object *object)
{
	double *attitude = object->path.attitude, axes[3][3];
	for (int i = 0; i < 3; i++)
		attitude[i] = raw->attitude != NULL ? raw->attitude[i] * M_PI / 180 : 0;
	if (raw->attitude == NULL)
		return STATUS_OK;
	if (object->path.has_attitude)
		return scene_error(tree->file, scene_tree_find(tree, "objects[%zu].attitude", index),
				   "its poses say yaw, pitch and roll already; allowed with: points, or poses t,x,y or t,x,y,z");
	if (object->shape.kind != SOIL_WHEEL)
		return STATUS_OK;
	if (attitude[2] != 0) {
		soil_axes(attitude[0], attitude[1], attitude[2], 0, axes);
		soil_wheel_attitude(axes[1], &attitude[0], &attitude[2]);
	}
	attitude[1] = 0;
	return STATUS_OK;
}

/* Checks what can be checked only when every path is known. */
static enum status check_taken(const struct scene_tree *tree, const struct raw_object *raw, size_t index, const struct scene *scene,
			       struct scene_object *object)
{
	scene_level_pitch(&object->shape, &object->path);
	TRY(take_attitude(tree, raw, index, object));
	return check_forces(tree, raw, object, scene, index);
}

enum status scene_check_objects(const struct scene_tree *tree, const struct raw_scene *raw,
				struct scene *scene)
{
	size_t count = raw->objects_count;
	if (count == 0) {
		if (raw->view != NULL || raw->cameras_count > 0 || raw->vehicles_count > 0 || scene->hosted)
			return STATUS_OK;
		return scene_error(tree->file, scene_tree_find(tree, "objects"),
				   "no object and no view or vehicle; needed: objects, vehicles or a view");
	}
	TRY(mem_zeroed(&scene->objects, count, sizeof *scene->objects, "reading the objects"));
	for (size_t i = 0; i < count; i++) {
		scene->object_count = i + 1;
		TRY(take_object(tree, &raw->objects[i], i, scene, &scene->objects[i]));
	}
	/* Names are made only after all given names are known. So a made name never takes a name that the scene gives later. */
	for (size_t i = 0; i < count; i++)
		if (scene->objects[i].name == NULL)
			TRY(make_name(scene, &scene->objects[i]));
	TRY(scene_way_follow(tree, raw, scene));
	for (size_t i = 0; i < count; i++) {
		struct scene_object *object = &scene->objects[i];
		TRY(check_taken(tree, &raw->objects[i], i, scene, object));
		if (object->path.has_z && raw->objects[i].sink != NULL)
			TRY(scene_tell_unused(scene, "objects.%s.sink: its poses say z already; take it away", object->name));
	}
	return STATUS_OK;
}

/* Makes the tree of a scene that has only the object `text`. */
static enum status plant(struct scene_tree *tree, const char *text)
{
	struct scene_node *list = NULL, *object = NULL;
	TRY(scene_tree_parse(tree->file, NULL, text, strlen(text), &object));
	tree->root = scene_node_create(SCENE_MAPPING, NULL);
	list = scene_node_create(SCENE_SEQUENCE, "objects");
	if (tree->root == NULL || list == NULL) {
		scene_node_destroy(list);
		scene_node_destroy(object);
		return fail_memory("reading an object");
	}
	tree->root->place = list->place = object->place;
	scene_node_append(tree->root, list);
	scene_node_append(list, object);
	return STATUS_OK;
}

static enum status parse(const struct scene *scene, const char *text, struct scene_object *object)
{
	struct scene_tree tree = {.file = "object text", .folder = scene->folder, .hosted = true};
	struct raw_scene *raw = NULL;
	enum status status;
	TRY_OR(done, plant(&tree, text));
	TRY_OR(done, scene_alias(&tree));
	TRY_OR(done, scene_read(&tree, &raw));
	TRY_OR(done, take_object(&tree, &raw->objects[0], 0, scene, object));
	if (raw->objects[0].path != NULL && raw->objects[0].path->relative_to != NULL)
		TRY_OR(done, scene_error(tree.file, scene_tree_find(&tree, "objects[0].path.relative_to"),
					 "is of objects that a scene lists; allowed: points, or a file"));
	TRY_OR(done, check_taken(&tree, &raw->objects[0], 0, scene, object));
	/* In a scene file this is a note, and `sink` is not used. A single object has no place for notes, so it is refused. */
	if (object->path.has_z && raw->objects[0].sink != NULL)
		TRY_OR(done, scene_error(tree.file, scene_tree_find(&tree, "objects[0].sink"),
					 "its poses say z already; allowed with: poses t,x,y, or points"));
	if (object->name == NULL)
		TRY_OR(done, make_name(scene, object));
	TRY_OR(done, scene_check_bearing(&tree, scene, object));
done:
	scene_raw_destroy(raw);
	scene_tree_finish(&tree);
	return status;
}

enum status scene_object_parse(const struct scene *scene, const char *text, struct scene_object *object)
{
	*object = (struct scene_object){0};
	if (strnlen(text, SCENE_BYTES + 1) > SCENE_BYTES)
		return fail_with(STATUS_INPUT, "object text: it is too large; allowed: %u bytes", SCENE_BYTES);
	enum status status = parse(scene, text, object);
	if (status != STATUS_OK)
		scene_object_finish(object);
	return status;
}

void scene_object_finish(struct scene_object *object)
{
	scene_mesh_destroy(object->mesh);
	mem_free_all(object->name, object->path.points);
	*object = (struct scene_object){0};
}
