/* Replaces each short form in a scene's tree by the full form, as scene_fold.h describes. */
#include "scene/scene_fold.h"

#include <string.h>

#include "scene/scene_error.h"

/* The keys of a camera may be written without its kind: {over, height}. Moves them into a mapping named by the kind. */
static enum status fold_camera(struct scene_node *camera, const char *name,
			       const char *const keys[2])
{
	struct scene_node *inner = NULL;
	if (scene_node_child(camera, name) != NULL)
		return STATUS_OK;
	for (int i = 0; i < 2; i++) {
		struct scene_node *child = scene_node_child(camera, keys[i]);
		if (child == NULL)
			continue;
		if (inner == NULL) {
			inner = scene_node_create(SCENE_MAPPING, name);
			TRY_MEM(inner, "reading the scene");
			inner->place = child->place;
			inner->setting = child->setting;
			scene_node_append(camera, inner);
		}
		scene_node_remove(child);
		scene_node_append(inner, child);
	}
	return STATUS_OK;
}

static enum status fold_cameras(const struct scene_tree *tree)
{
	static const char *const overhead[] = {"over", "height"}, *const fixed[] = {"eye", "target"};
	struct scene_node *view = scene_node_child(tree->root, "view");
	struct scene_node *camera = view != NULL ? scene_node_child(view, "camera") : NULL;
	if (camera == NULL || camera->kind != SCENE_MAPPING)
		return STATUS_OK;
	TRY(fold_camera(camera, "overhead", overhead));
	return fold_camera(camera, "fixed", fixed);
}

/* --set view.images=0 for a scene without a view: there is nothing to draw, and nothing changes. */
static void drop_view(struct scene_tree *tree)
{
	struct scene_node *view = scene_node_child(tree->root, "view");
	if (view == NULL || view->kind != SCENE_MAPPING || view->count != 1)
		return;
	const struct scene_node *images = view->first;
	if (images->setting == NULL || images->kind != SCENE_SCALAR || strcmp(images->key, "images") != 0 || strcmp(images->text, "0") != 0)
		return;
	scene_node_remove(view);
	scene_node_destroy(view);
}

/* Adds a text below `parent`. The tree owns the text; on failure it is freed. */
static enum status add_text(struct scene_node *parent, const char *key, char *text, bool plain)
{
	struct scene_node *node = scene_node_create(SCENE_SCALAR, key);
	if (node == NULL) {
		mem_free(text);
		return fail_memory("reading the scene");
	}
	node->text = text;
	node->plain = plain;
	node->place = parent->place;
	node->setting = parent->setting;
	scene_node_append(parent, node);
	return STATUS_OK;
}

/* `KEY: {...}` in a mapping is `{name: KEY, ...}` in a list. */
static enum status fold_key(struct scene_node *node, const char *name)
{
	char *key = node->key;
	node->key = NULL;
	return add_text(node, name, key, true);
}

/* `dry_sand` is `{name: dry_sand}`, with the key `name`. */
static enum status fold_value(struct scene_node *soil, const char *key)
{
	if (soil->kind != SCENE_SCALAR)
		return STATUS_OK;
	char *text = soil->text;
	soil->text = NULL;
	soil->kind = SCENE_MAPPING;
	return add_text(soil, key, text, soil->plain);
}

/* A class `VALUE: SCALAR` is `{value: VALUE, KEY: SCALAR}`. */
static enum status fold_class(const struct scene_tree *tree, struct scene_node *soil,
			      const char *key_of_scalar)
{
	TRY(fold_value(soil, key_of_scalar));
	if (soil->kind != SCENE_MAPPING)
		return STATUS_OK;
	const struct scene_node *value = scene_node_child(soil, "value");
	if (value != NULL)
		return scene_error(tree->file, value, "is said by the key; allowed: each value once");
	return fold_key(soil, "value");
}

/* What a soil lies over may be a name. */
static enum status fold_over(const struct scene_node *soil)
{
	struct scene_node *over = soil->kind == SCENE_MAPPING ? scene_node_child(soil, "over") : NULL;
	return over != NULL ? fold_value(over, "name") : STATUS_OK;
}

static enum status fold_soil(const struct scene_tree *tree)
{
	struct scene_node *soil = scene_node_child(tree->root, "soil");
	struct scene_node *elsewhere = soil != NULL ? scene_node_child(soil, "default") : NULL;
	struct scene_node *classes = soil != NULL ? scene_node_child(soil, "classes") : NULL;
	if (soil != NULL)
		TRY(fold_over(soil));
	if (elsewhere != NULL) {
		TRY(fold_value(elsewhere, "name"));
		TRY(fold_over(elsewhere));
	}
	if (classes == NULL || (classes->kind != SCENE_MAPPING && classes->kind != SCENE_SEQUENCE))
		return STATUS_OK;
	for (struct scene_node *node = classes->first; node != NULL; node = node->next) {
		if (classes->kind == SCENE_MAPPING)
			TRY(fold_class(tree, node, "name"));
		TRY(fold_over(node));
	}
	classes->kind = SCENE_SEQUENCE;
	return STATUS_OK;
}

/* The soil of a road may be a name. */
static enum status fold_roads(const struct scene_tree *tree)
{
	const struct scene_node *ground = scene_node_child(tree->root, "ground"), *roads = ground != NULL ? scene_node_child(ground, "roads") : NULL;
	for (struct scene_node *road = roads != NULL ? roads->first : NULL; road != NULL; road = road->next) {
		struct scene_node *soil = road->kind == SCENE_MAPPING ? scene_node_child(road, "soil") : NULL;
		if (soil == NULL)
			continue;
		TRY(fold_value(soil, "name"));
		TRY(fold_over(soil));
	}
	return STATUS_OK;
}

/* `1: 0.05` is `{value: 1, roughness: 0.05}`. */
static enum status fold_relief(const struct scene_tree *tree)
{
	struct scene_node *relief = scene_node_child(tree->root, "relief");
	struct scene_node *classes = relief != NULL && relief->kind == SCENE_MAPPING
					     ? scene_node_child(relief, "classes")
					     : NULL;
	if (classes == NULL || classes->kind != SCENE_MAPPING)
		return STATUS_OK;
	for (struct scene_node *node = classes->first; node != NULL; node = node->next)
		TRY(fold_class(tree, node, "roughness"));
	classes->kind = SCENE_SEQUENCE;
	return STATUS_OK;
}

/* `drive_1: 2.5` is `{actuator: drive_1, value: 2.5}`. */
static enum status fold_control(struct scene_node *control, const char *name)
{
	char *text = control->text;
	if (control->kind != SCENE_SCALAR)
		return STATUS_OK;
	control->text = NULL;
	control->kind = SCENE_MAPPING;
	enum status status;
	TRY_OR(failed, fold_key(control, name));
	return add_text(control, "value", text, control->plain);
failed:
	mem_free(text);
	return status;
}

/* `engine: [[1000, 100], ...]` is `torque: [[1000, 100], ...]`, and brakes of the powertrain are those of the vehicle. */
static enum status fold_powertrain(struct scene_node *vehicle)
{
	struct scene_node *powertrain = scene_node_child(vehicle, "powertrain");
	if (powertrain == NULL || powertrain->kind != SCENE_MAPPING)
		return STATUS_OK;
	struct scene_node *brakes = scene_node_child(powertrain, "brakes"), *engine = scene_node_child(powertrain, "engine");
	if (brakes != NULL && scene_node_child(vehicle, "brakes") == NULL) {
		scene_node_remove(brakes);
		scene_node_append(vehicle, brakes);
	}
	if (engine == NULL || engine->kind != SCENE_SEQUENCE || engine->count == 0)
		return STATUS_OK;
	char *key = mem_strdup("torque");
	TRY_MEM(key, "reading the scene");
	mem_free(engine->key);
	engine->key = key;
	return STATUS_OK;
}

/* A mapping of names to values is a list of both. `name`: the key of the names. */
static enum status fold_named(const struct scene_node *vehicle, const char *part, const char *key, const char *name)
{
	struct scene_node *of = vehicle->kind == SCENE_MAPPING ? scene_node_child(vehicle, part) : NULL;
	struct scene_node *list = of != NULL && of->kind == SCENE_MAPPING ? scene_node_child(of, key) : NULL;
	if (list == NULL || list->kind != SCENE_MAPPING)
		return STATUS_OK;
	for (struct scene_node *node = list->first; node != NULL; node = node->next)
		TRY(fold_control(node, name));
	list->kind = SCENE_SEQUENCE;
	return STATUS_OK;
}

/* `wheel_*: steel` is `{geoms: wheel_*, material: steel}`, and `track: {...}` is `{geoms: track, ...}`. */
static enum status fold_surfaces(struct scene_node *surfaces)
{
	for (struct scene_node *node = surfaces->first; node != NULL; node = node->next) {
		TRY(fold_value(node, "material"));
		if (node->kind == SCENE_MAPPING) {
			TRY(fold_key(node, "geoms"));
			continue;
		}
		mem_free(node->key);
		node->key = NULL; /* in a list */
	}
	surfaces->kind = SCENE_SEQUENCE;
	return STATUS_OK;
}

/* `wheel_*: {stiffness: 250e3}` is `{geom: wheel_*, stiffness: 250e3}`. */
static enum status fold_tyres(struct scene_node *tyres)
{
	if (tyres == NULL || tyres->kind != SCENE_MAPPING)
		return STATUS_OK;
	for (struct scene_node *node = tyres->first; node != NULL; node = node->next)
		if (node->kind == SCENE_MAPPING)
			TRY(fold_key(node, "geom"));
	tyres->kind = SCENE_SEQUENCE;
	return STATUS_OK;
}

static enum status fold_vehicles(const struct scene_tree *tree)
{
	struct scene_node *vehicles = scene_node_child(tree->root, "vehicles");
	if (vehicles == NULL || vehicles->kind != SCENE_SEQUENCE)
		return STATUS_OK;
	for (struct scene_node *vehicle = vehicles->first; vehicle != NULL; vehicle = vehicle->next) {
		if (vehicle->kind == SCENE_MAPPING)
			TRY(fold_powertrain(vehicle));
		TRY(fold_named(vehicle, "driver", "hold", "actuator"));
		TRY(fold_named(vehicle, "start", "controls", "actuator"));
		TRY(fold_named(vehicle, "start", "joints", "joint"));
		struct scene_node *surfaces = vehicle->kind == SCENE_MAPPING ? scene_node_child(vehicle, "interface") : NULL;
		if (surfaces != NULL && surfaces->kind == SCENE_MAPPING)
			TRY(fold_surfaces(surfaces));
		TRY(fold_tyres(vehicle->kind == SCENE_MAPPING ? scene_node_child(vehicle, "tyres") : NULL));
	}
	return STATUS_OK;
}

/* `[disturbance]` is `{disturbance: {}}`, and cover by class is folded as relief is. */
static enum status fold_attributes(const struct scene_tree *tree)
{
	struct scene_node *attributes = scene_node_child(tree->root, "attributes");
	if (attributes == NULL)
		return STATUS_OK;
	if (attributes->kind == SCENE_SCALAR)
		return scene_error(tree->file, attributes, "is a single value; allowed: a list or a mapping");
	for (struct scene_node *node = attributes->first; node != NULL && attributes->kind == SCENE_SEQUENCE; node = node->next) {
		if (node->kind != SCENE_SCALAR || (strcmp(node->text, "disturbance") != 0 && strcmp(node->text, "vegetation") != 0))
			return scene_error(tree->file, node, "%s is unknown; allowed: disturbance, vegetation", scene_quote(node->kind == SCENE_SCALAR ? node->text : "{}").text);
		for (const struct scene_node *other = attributes->first; other != node; other = other->next)
			if (strcmp(other->key, node->text) == 0)
				return scene_error(tree->file, node, "%s is named twice; allowed: once", node->text);
		node->key = node->text;
		node->text = NULL;
		node->kind = SCENE_MAPPING;
	}
	attributes->kind = SCENE_MAPPING;
	struct scene_node *vegetation = scene_node_child(attributes, "vegetation");
	struct scene_node *classes = vegetation != NULL && vegetation->kind == SCENE_MAPPING ? scene_node_child(vegetation, "classes") : NULL;
	if (classes == NULL || classes->kind != SCENE_MAPPING)
		return STATUS_OK;
	for (struct scene_node *node = classes->first; node != NULL; node = node->next)
		TRY(fold_class(tree, node, "cover"));
	classes->kind = SCENE_SEQUENCE;
	return STATUS_OK;
}

enum status scene_fold(struct scene_tree *tree)
{
	drop_view(tree);
	TRY(fold_attributes(tree));
	TRY(fold_cameras(tree));
	TRY(fold_soil(tree));
	TRY(fold_roads(tree));
	TRY(fold_relief(tree));
	return fold_vehicles(tree);
}
