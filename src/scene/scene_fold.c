/* Replaces each short form in a scene's tree by the full form, as scene_fold.h describes. */
#include "scene/scene_fold.h"

#include <string.h>

#include "scene/scene_error.h"
#include "scene/scene_row.h"

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

/* `KEY: {...}` in a mapping is `{name: KEY, ...}` in a list, if `name` is "name". */
static enum status fold_key(struct scene_node *node, const char *name)
{
	char *key = node->key;
	node->key = NULL;
	return add_text(node, name, key, true);
}

/* `dry_sand` is `{name: dry_sand}`, if `key` is "name". */
static enum status fold_value(struct scene_node *node, const char *key)
{
	char *text = node->text;
	node->text = NULL;
	node->kind = SCENE_MAPPING;
	return add_text(node, key, text, node->plain);
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

static enum status fold_powertrains(const struct scene_tree *tree)
{
	struct scene_node *vehicles = scene_node_child(tree->root, "vehicles");
	if (vehicles == NULL || vehicles->kind != SCENE_SEQUENCE)
		return STATUS_OK;
	for (struct scene_node *vehicle = vehicles->first; vehicle != NULL; vehicle = vehicle->next)
		if (vehicle->kind == SCENE_MAPPING)
			TRY(fold_powertrain(vehicle));
	return STATUS_OK;
}

/* `[disturbance]` is `{disturbance: {}}`. */
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
	return STATUS_OK;
}

/* --- by the table of keys: `alone` and `named` of its rows --- */

static enum status fold_keys(const struct scene_tree *tree, const struct scene_row *rows, const struct scene_node *mapping);

/* `1: 0.05` is `{value: 1, roughness: 0.05}`, and `wheel_*: {stiffness: 250e3}` is `{geom: wheel_*, stiffness: 250e3}`. */
static enum status fold_named(const struct scene_tree *tree, const struct scene_row *row, struct scene_node *entry)
{
	if (entry->kind == SCENE_SCALAR && row->alone != NULL) {
		char *text = entry->text;
		entry->text = NULL;
		entry->kind = SCENE_MAPPING;
		const enum status status = fold_key(entry, row->named);
		if (status == STATUS_OK)
			return add_text(entry, row->alone, text, entry->plain);
		mem_free(text);
		return status;
	}
	if (entry->kind != SCENE_MAPPING)
		return STATUS_OK;
	const struct scene_node *said = scene_node_child(entry, row->named);
	if (said != NULL)
		return scene_error(tree->file, said, "is said by the key; allowed: each value once");
	return fold_key(entry, row->named);
}

/* Folds what the scene says of one key. Wrong input stays as it is. */
static enum status fold_row(const struct scene_tree *tree, const struct scene_row *row, struct scene_node *node)
{
	if (row->form != ROW_LIST) {
		if (node->kind == SCENE_SCALAR && row->alone != NULL)
			TRY(fold_value(node, row->alone));
		return node->kind == SCENE_MAPPING ? fold_keys(tree, row->rows, node) : STATUS_OK;
	}
	if (node->kind == SCENE_MAPPING && row->named != NULL) {
		for (struct scene_node *entry = node->first; entry != NULL; entry = entry->next)
			TRY(fold_named(tree, row, entry));
		node->kind = SCENE_SEQUENCE;
	}
	for (struct scene_node *entry = node->kind == SCENE_SEQUENCE ? node->first : NULL; entry != NULL; entry = entry->next)
		if (entry->kind == SCENE_MAPPING)
			TRY(fold_keys(tree, row->rows, entry));
	return STATUS_OK;
}

static enum status fold_keys(const struct scene_tree *tree, const struct scene_row *rows, const struct scene_node *mapping)
{
	for (struct scene_node *node = mapping->first; node != NULL; node = node->next) {
		const struct scene_row *row = scene_row_find(rows, node->key, strlen(node->key));
		if (row != NULL && row->type == ROW_MAPPING)
			TRY(fold_row(tree, row, node));
	}
	return STATUS_OK;
}

enum status scene_fold(struct scene_tree *tree)
{
	drop_view(tree);
	TRY(fold_attributes(tree));
	TRY(fold_cameras(tree));
	TRY(fold_powertrains(tree));
	return fold_keys(tree, scene_schema, tree->root);
}
