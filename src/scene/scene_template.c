/* Replaces templates of objects by their copies; see scene_template.h. */
#include "scene/scene_template.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scene/scene_error.h"
#include "scene/scene_read.h"

struct template {
	const struct scene_tree *tree;
	const struct scene_node *node;    /* has the keys template, at, every */
	const struct scene_node *objects; /* one mapping, or a list of them */
	double every;                     /* s */
};

/* Where a copy is, seen from the template: m east and north, and degrees. */
struct place {
	size_t number; /* from 1 */
	double offset[2], rotate;
};

static enum status is_wrong(const struct template *template, const struct scene_node *node, const char *what)
{
	return scene_error(template->tree->file, node, "%s", what);
}

/* Reads `count` numbers of a list; those after the first `least` may be missing and then stay as they are. */
static bool read_list(const struct scene_node *node, size_t least, size_t most, double *numbers)
{
	size_t count = 0;
	if (node->kind != SCENE_SEQUENCE || node->count < least || node->count > most)
		return false;
	for (const struct scene_node *child = node->first; child != NULL; child = child->next)
		if (child->kind != SCENE_SCALAR || !scene_number_read(child->text, false, &numbers[count++]) || !(fabs(numbers[count - 1]) <= 1e9))
			return false;
	return true;
}

static bool read_number(const struct scene_node *node, bool whole, double *number)
{
	return node->kind == SCENE_SCALAR && scene_number_read(node->text, whole, number);
}

/* --- changing a copy --- */

static struct scene_node *copy_node(const struct scene_node *from)
{
	struct scene_node *node = scene_node_create(from->kind, from->key);
	if (node == NULL)
		return NULL;
	node->plain = from->plain;
	node->place = from->place;
	node->setting = from->setting;
	node->text = from->text != NULL ? mem_strdup(from->text) : NULL;
	bool whole = from->text == NULL || node->text != NULL;
	for (const struct scene_node *child = from->first; child != NULL && whole; child = child->next) {
		struct scene_node *copy = copy_node(child);
		whole = copy != NULL;
		if (whole)
			scene_node_append(node, copy);
	}
	if (whole)
		return node;
	scene_node_destroy(node);
	return NULL;
}

/* Sets the text of a scalar below `parent`; key NULL: it is added to a list. */
static enum status put_text(struct scene_node *parent, const char *key, const char *text)
{
	struct scene_node *node = key != NULL ? scene_node_child(parent, key) : NULL;
	char *copy = mem_strdup(text);
	if (copy != NULL && node == NULL) {
		node = scene_node_create(SCENE_SCALAR, key);
		if (node != NULL) {
			node->place = parent->place;
			node->setting = parent->setting;
			scene_node_append(parent, node);
		}
	}
	if (copy == NULL || node == NULL) {
		mem_free(copy);
		return fail_memory("reading the objects");
	}
	mem_free(node->text);
	node->text = copy;
	node->plain = true;
	return STATUS_OK;
}

static enum status put_number(struct scene_node *parent, const char *key, double number)
{
	char text[32];
	snprintf(text, sizeof text, "%.17g", number);
	return put_text(parent, key, text);
}

/* Adds to the number at `key`, 0 if there is none. What is no number stays, and is refused where all keys are checked. */
static enum status add_to_number(struct scene_node *path, const char *key, double more)
{
	const struct scene_node *node = scene_node_child(path, key);
	double number = 0;
	if (more == 0 || (node != NULL && !read_number(node, false, &number)))
		return STATUS_OK;
	return put_number(path, key, number + more);
}

static enum status add_to_offset(struct scene_node *path, const double more[2])
{
	struct scene_node *node = scene_node_child(path, "offset");
	double numbers[2] = {0};
	if ((more[0] == 0 && more[1] == 0) || (node != NULL && !read_list(node, 2, 2, numbers)))
		return STATUS_OK;
	if (node != NULL) {
		scene_node_remove(node);
		scene_node_destroy(node);
	}
	node = scene_node_create(SCENE_SEQUENCE, "offset");
	TRY_MEM(node, "reading the objects");
	node->place = path->place;
	node->setting = path->setting;
	scene_node_append(path, node);
	TRY(put_number(node, NULL, numbers[0] + more[0]));
	return put_number(node, NULL, numbers[1] + more[1]);
}

/* Adds the copy's number to a name. */
static enum status number_name(struct scene_node *parent, const char *key, size_t number)
{
	const struct scene_node *node = scene_node_child(parent, key);
	char text[128];
	if (node == NULL || node->kind != SCENE_SCALAR || strlen(node->text) > 64)
		return STATUS_OK;
	snprintf(text, sizeof text, "%s-%zu", node->text, number);
	return put_text(parent, key, text);
}

/* Returns true if an object of the template has the name. */
static bool is_within(const struct template *template, const char *name)
{
	const struct scene_node *objects = template->objects;
	const struct scene_node *node = objects->kind == SCENE_SEQUENCE ? objects->first : objects;
	for (; node != NULL; node = objects->kind == SCENE_SEQUENCE ? node->next : NULL) {
		const struct scene_node *named = node->kind == SCENE_MAPPING ? scene_node_child(node, "name") : NULL;
		if (named != NULL && named->kind == SCENE_SCALAR && strcmp(named->text, name) == 0)
			return true;
	}
	return false;
}

static enum status move_path(const struct template *template, struct scene_node *path, const struct place *place)
{
	const struct scene_node *leader = scene_node_child(path, "relative_to");
	if (leader != NULL && leader->kind == SCENE_SCALAR && is_within(template, leader->text))
		return number_name(path, "relative_to", place->number);
	TRY(add_to_offset(path, place->offset));
	TRY(add_to_number(path, "rotate", place->rotate));
	return add_to_number(path, "delay", template->every * (double)(place->number - 1));
}

/* Adds a copy of one object of the template to `list`. */
static enum status add_copy(const struct template *template, const struct scene_node *object, const struct place *place, struct scene_node *list)
{
	struct scene_node *copy = copy_node(object);
	TRY_MEM(copy, "reading the objects");
	mem_free(copy->key);
	copy->key = NULL; /* in a list */
	scene_node_append(list, copy);
	if (copy->kind != SCENE_MAPPING)
		return STATUS_OK;
	struct scene_node *path = scene_node_child(copy, "path");
	TRY(number_name(copy, "name", place->number));
	return path != NULL && path->kind == SCENE_MAPPING ? move_path(template, path, place) : STATUS_OK;
}

static enum status add_copies(const struct template *template, const struct place *place, struct scene_node *list)
{
	const struct scene_node *objects = template->objects;
	if (list->count >= SCENE_OBJECTS)
		return scene_error(template->tree->file, template->node, "makes too many objects; allowed: %d in all", SCENE_OBJECTS);
	if (objects->kind != SCENE_SEQUENCE)
		return add_copy(template, objects, place, list);
	for (const struct scene_node *object = objects->first; object != NULL; object = object->next)
		TRY(add_copy(template, object, place, list));
	return STATUS_OK;
}

/* --- where copies are --- */

static enum status add_grid(const struct template *template, const struct scene_node *at, struct scene_node *list)
{
	static const char allowed[] = "is no grid; allowed: {rows: 1 or more, columns: 1 or more, step: [east, north], from: [east, north]}";
	double counts[2] = {1, 1}, step[2] = {0}, from[2] = {0};
	bool stepped = false;
	for (const struct scene_node *node = at->first; node != NULL; node = node->next) {
		const bool rows = strcmp(node->key, "rows") == 0, columns = strcmp(node->key, "columns") == 0, steps = strcmp(node->key, "step") == 0;
		if (!(rows || columns) && !steps && strcmp(node->key, "from") != 0)
			return scene_error(template->tree->file, node, "unknown key; allowed: rows, columns, step, from");
		const bool read = rows || columns ? read_number(node, true, &counts[columns]) && counts[columns] >= 1 && counts[columns] <= SCENE_OBJECTS
						  : read_list(node, 2, 2, steps ? step : from);
		if (!read)
			return is_wrong(template, node, allowed);
		stepped = stepped || steps;
	}
	if (!stepped)
		return is_wrong(template, at, allowed);
	struct place place = {.number = 0};
	for (double row = 0; row < counts[0]; row++)
		for (double column = 0; column < counts[1]; column++) {
			place.number++;
			place.offset[0] = from[0] + column * step[0];
			place.offset[1] = from[1] + row * step[1];
			TRY(add_copies(template, &place, list));
		}
	return STATUS_OK;
}

static enum status add_places(const struct template *template, const struct scene_node *at, struct scene_node *list)
{
	struct place place = {.number = 0};
	for (const struct scene_node *node = at->first; node != NULL; node = node->next) {
		double numbers[3] = {0};
		if (!read_list(node, 2, 3, numbers))
			return is_wrong(template, node, "is no place; allowed: [east, north] in m, or [east, north, degrees]");
		place = (struct place){place.number + 1, {numbers[0], numbers[1]}, numbers[2]};
		TRY(add_copies(template, &place, list));
	}
	return STATUS_OK;
}

static enum status expand(const struct scene_tree *tree, const struct scene_node *node, struct scene_node *list)
{
	struct template template = {.tree = tree, .node = node, .objects = scene_node_child(node, "template")};
	const struct scene_node *at = scene_node_child(node, "at"), *every = scene_node_child(node, "every");
	for (const struct scene_node *child = node->first; child != NULL; child = child->next)
		if (child != template.objects && child != at && child != every)
			return is_wrong(&template, child, "does not go beside template; allowed: template, at, every");
	if (at == NULL || at->kind == SCENE_SCALAR || at->count == 0)
		return is_wrong(&template, at != NULL ? at : node, "says no places of a template; needed: at: [[east, north], ...], or at: {rows, "
								     "columns, step, from}");
	if (every != NULL && !(read_number(every, false, &template.every) && template.every >= 0 && template.every <= 1e6))
		return is_wrong(&template, every, "is no time between copies; allowed: 0 to 1e6 s");
	if (template.objects->kind == SCENE_SCALAR)
		return is_wrong(&template, template.objects, "is no object; allowed: an object, or a list of them");
	return at->kind == SCENE_MAPPING ? add_grid(&template, at, list) : add_places(&template, at, list);
}

static bool is_template(const struct scene_node *node)
{
	return node->kind == SCENE_MAPPING && scene_node_child(node, "template") != NULL;
}

/* `objects: {template, at}` is a list with this entry. */
static enum status fold_alone(struct scene_node *objects)
{
	struct scene_node *inner = scene_node_create(SCENE_MAPPING, NULL);
	TRY_MEM(inner, "reading the objects");
	inner->place = objects->place;
	inner->setting = objects->setting;
	for (struct scene_node *child = objects->first, *next; child != NULL; child = next) {
		next = child->next;
		scene_node_append(inner, child);
	}
	objects->first = objects->last = NULL;
	objects->count = 0;
	objects->kind = SCENE_SEQUENCE;
	scene_node_append(objects, inner);
	return STATUS_OK;
}

enum status scene_template(const struct scene_tree *tree)
{
	struct scene_node *objects = scene_node_child(tree->root, "objects");
	enum status status = STATUS_OK;
	if (objects != NULL && is_template(objects))
		TRY(fold_alone(objects));
	if (objects == NULL || objects->kind != SCENE_SEQUENCE)
		return STATUS_OK;
	struct scene_node *all = objects->first;
	/* Children move to the end of the list that they began, one by one; templates are replaced on the way. */
	objects->first = objects->last = NULL;
	objects->count = 0;
	for (struct scene_node *node = all, *next; node != NULL; node = next) {
		next = node->next;
		if (status != STATUS_OK || !is_template(node)) {
			scene_node_append(objects, node);
			continue;
		}
		node->parent = objects;
		status = expand(tree, node, objects);
		scene_node_destroy(node);
	}
	return status;
}
