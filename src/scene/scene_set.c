/* Applies settings to the tree; see scene_set.h. */
#include "scene/scene_set.h"

#include <stdio.h>
#include <string.h>

#include "base/nearest.h"
#include "scene/scene_alias.h"
#include "scene/scene_error.h"

#define SEGMENTS_MAX 8 /* deeper than any key of a scene */
#define KEY_MAX 160    /* bytes of a key with its dots; a message that quotes it has room for the advice */

static enum status refuse(const struct scene_tree *tree, const struct scene_setting *setting,
			  const char *segment, const char *why)
{
	return fail_with(STATUS_INPUT, "%s: --set %s: %s %s", tree->file, setting->key,
			 scene_quote(segment).text, why);
}

/* Returns the element of a list that a part of the key names, or NULL. */
static struct scene_node *element_of(const struct scene_node *list, const char *segment)
{
	for (struct scene_node *node = list->first; node != NULL; node = node->next) {
		char index[24];
		const struct scene_node *name =
			node->kind == SCENE_MAPPING ? scene_node_child(node, "name") : NULL;
		snprintf(index, sizeof index, "%zu", node->index);
		const char *called = name != NULL && name->text != NULL ? name->text : index;
		if (strcmp(called, segment) == 0)
			return node;
	}
	return NULL;
}

static enum status element_missing(const struct scene_tree *tree,
				   const struct scene_setting *setting,
				   const struct scene_node *list, const char *segment)
{
	struct scene_list names = {.length = 0};
	struct nearest nearest = nearest_begin(segment);
	for (const struct scene_node *node = list->first; node != NULL; node = node->next) {
		char index[24];
		const struct scene_node *name =
			node->kind == SCENE_MAPPING ? scene_node_child(node, "name") : NULL;
		snprintf(index, sizeof index, "%zu", node->index);
		if (name != NULL && name->text != NULL)
			nearest_offer(&nearest, name->text);
		scene_list_add(&names, name != NULL && name->text != NULL ? name->text : index);
	}
	return fail_with(STATUS_INPUT, "%s: --set %s: %s is not in the list; allowed: %s%s",
			 tree->file, setting->key, scene_quote(segment).text,
			 names.length > 0 ? names.text : "nothing, the list is empty", nearest_ask(&nearest).text);
}

/* Steps from `at` to what `segment` names, which is made if a mapping lacks it. */
static enum status step(const struct scene_tree *tree, const struct scene_setting *setting,
			struct scene_node *at, const char *segment, struct scene_node **out)
{
	if (segment[0] == '\0')
		return refuse(tree, setting, segment, "is no key; allowed: keys joined by dots");
	if (at->kind == SCENE_SCALAR)
		return refuse(tree, setting, segment, "is below a single value; allowed: its own key");
	segment = scene_alias_key(at, segment);
	*out = at->kind == SCENE_SEQUENCE ? element_of(at, segment) : scene_node_child(at, segment);
	if (*out != NULL)
		return STATUS_OK;
	if (at->kind == SCENE_SEQUENCE)
		return element_missing(tree, setting, at, segment);
	if (at->count >= SCENE_KEYS)
		return refuse(tree, setting, segment, "is one key too many; allowed: 64");
	struct scene_node *made = scene_node_create(SCENE_MAPPING, segment);
	TRY_MEM(made, "setting a key of the scene");
	made->setting = setting->key;
	made->place = at->place;
	scene_node_append(at, made);
	*out = made;
	return STATUS_OK;
}

/* `node` becomes what `value` is, in its place and under its key. */
static void replace(struct scene_node *node, struct scene_node *value)
{
	struct scene_node old = *node;
	node->kind = value->kind;
	node->text = value->text;
	node->plain = value->plain;
	node->setting = value->setting;
	node->first = value->first;
	node->last = value->last;
	node->count = value->count;
	for (struct scene_node *child = node->first; child != NULL; child = child->next)
		child->parent = node;
	value->text = old.text;
	value->first = old.first;
	value->last = old.last;
}

enum status scene_set(struct scene_tree *tree, const struct scene_setting *setting)
{
	struct scene_node *value = NULL, *at = tree->root;
	size_t length = strlen(setting->key);
	int segments = 0;

	if (length > KEY_MAX)
		return fail_with(STATUS_INPUT, "%s: --set %s: the key has %zu bytes; allowed: at most %d", tree->file,
				 scene_quote(setting->key).text, length, KEY_MAX);
	char *key = mem_strdup(setting->key);
	TRY_MEM(key, "setting a key of the scene");
	enum status status;
	TRY_OR(done, scene_tree_parse(tree->file, setting->key, setting->value, strlen(setting->value), &value));
	for (char *segment = key, *dot; segment != NULL; segment = dot) {
		dot = strchr(segment, '.');
		if (dot != NULL)
			*dot++ = '\0';
		if (++segments > SEGMENTS_MAX)
			TRY_OR(done, refuse(tree, setting, segment, "is too deep; allowed: 8 keys"));
		TRY_OR(done, step(tree, setting, at, segment, &at));
	}
	if (value->plain && (strcmp(value->text, "null") == 0 || strcmp(value->text, "~") == 0)) {
		scene_node_remove(at);
		scene_node_destroy(at);
	} else {
		replace(at, value);
	}
done:
	scene_node_destroy(value);
	mem_free(key);
	return status;
}
