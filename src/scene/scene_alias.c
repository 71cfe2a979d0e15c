/*
 * Replaces old names of keys and words in a scene's tree by the new ones, so that old scenes still load. The table of old names is
 * here.
 */
#include "scene/scene_alias.h"

#include <string.h>

#include "scene/scene.h"
#include "scene/scene_error.h"

/* Without a place: what commands take and tell. */
static const struct scene_former aliases[] = {
	{"objects[].shape.wheel", "lugs", "grousers"},
	{"objects[].shape.wheel", "lug_height", "grouser_height"},
	{"objects[].shape.wheel", "lug_thickness", "grouser_thickness"},
	{"attributes[]", "dirt", "disturbance"},
	{"attributes", "dirt", "disturbance"},
	{"redistribute.undisturbed", "stands", "stable"},
	{NULL, "heaped", "deposited"},
	{NULL, "pressed", "plastic_sinkage"},
	{NULL, "quanta", "fixed_point"},
};
#define ALIASES (sizeof aliases / sizeof aliases[0])

bool scene_alias_at(size_t index, struct scene_former *former)
{
	if (index < ALIASES)
		*former = aliases[index];
	return index < ALIASES;
}

const char *scene_name_now(const char *name)
{
	for (size_t i = 0; i < ALIASES; i++)
		if (strcmp(aliases[i].former, name) == 0)
			return aliases[i].name;
	return name;
}

/* Returns the present name of a key in the mapping `place`, or of the word at `place`. NULL: it is not an old name. */
static const char *name_at(const struct scene_node *place, const char *former)
{
	char path[160];
	for (size_t i = 0; i < ALIASES; i++) {
		if (aliases[i].where == NULL || strcmp(aliases[i].former, former) != 0)
			continue;
		scene_node_path(place, true, path, sizeof path);
		if (strcmp(aliases[i].where, path) == 0)
			return aliases[i].name;
	}
	return NULL;
}

const char *scene_alias_key(const struct scene_node *parent, const char *key)
{
	const char *name = parent->kind == SCENE_MAPPING ? name_at(parent, key) : NULL;
	return name != NULL ? name : key;
}

static enum status rename_text(char **text, const char *name)
{
	char *copy = mem_strdup(name);
	TRY_MEM(copy, "reading the scene");
	mem_free(*text);
	*text = copy;
	return STATUS_OK;
}

static enum status rename_node(const struct scene_tree *tree, struct scene_node *node)
{
	const char *name = node->key != NULL ? name_at(node->parent, node->key) : NULL;
	if (name != NULL && scene_node_child(node->parent, name) != NULL)
		return scene_error(tree->file, node, "is the former name of %s, and both are given; allowed: %s alone", name, name);
	if (name != NULL)
		TRY(rename_text(&node->key, name));
	if (node->kind != SCENE_SCALAR)
		return STATUS_OK;
	name = name_at(node, node->text);
	return name != NULL ? rename_text(&node->text, name) : STATUS_OK;
}

static enum status rename_below(const struct scene_tree *tree, struct scene_node *parent)
{
	for (struct scene_node *node = parent->first; node != NULL; node = node->next) {
		TRY(rename_node(tree, node));
		TRY(rename_below(tree, node));
	}
	return STATUS_OK;
}

enum status scene_alias(const struct scene_tree *tree)
{
	return rename_below(tree, tree->root);
}
