/*
 * Makes a list of a scene's settings: a key with dots, as --set takes it, and its value as YAML on one line. An entry of a list that
 * has a name is named by it: "objects.left.load". Lists of plain values are one value.
 */
#include "scene/scene_values.h"

#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

/* --- YAML --- */

static bool is_safe(const char *text)
{
	static const char safe[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.+-/";
	return text[0] != '\0' && strcmp(text, "-") != 0 && strcmp(text, "---") != 0 && strcmp(text, "...") != 0 &&
	       text[strspn(text, safe)] == '\0';
}

static void write_scalar(const char *text, bool plain, FILE *file)
{
	if (plain && is_safe(text)) {
		fputs(text, file);
		return;
	}
	fputc('"', file);
	for (const char *c = text; *c != '\0'; c++)
		if (*c == '\n' || *c == '\t')
			fputs(*c == '\n' ? "\\n" : "\\t", file);
		else
			fprintf(file, "%s%c", *c == '"' || *c == '\\' ? "\\" : "", *c);
	fputc('"', file);
}

void scene_node_write(const struct scene_node *node, FILE *file)
{
	if (node->kind == SCENE_SCALAR) {
		write_scalar(node->text, node->plain || is_safe(node->text), file);
		return;
	}
	fputc(node->kind == SCENE_MAPPING ? '{' : '[', file);
	for (const struct scene_node *child = node->first; child != NULL; child = child->next) {
		if (child->key != NULL) {
			write_scalar(child->key, true, file);
			fputs(": ", file);
		}
		scene_node_write(child, file);
		fputs(child->next != NULL ? ", " : "", file);
	}
	fputc(node->kind == SCENE_MAPPING ? '}' : ']', file);
}

/* --- the list --- */

/* A node of the way from the root to a value. */
struct step {
	const struct step *up;
	const struct scene_node *node;
};

static const struct scene_node *name_of(const struct scene_node *node)
{
	const struct scene_node *name = node->kind == SCENE_MAPPING && node->key == NULL ? scene_node_child(node, "name") : NULL;
	return name != NULL && name->kind == SCENE_SCALAR ? name : NULL;
}

static void write_key(const struct step *step, FILE *file)
{
	const struct scene_node *node = step->node, *name = name_of(node);
	if (step->up == NULL)
		return;
	write_key(step->up, file);
	if (step->up->up != NULL)
		fputc('.', file);
	if (node->key != NULL)
		fputs(node->key, file);
	else if (name != NULL)
		fputs(name->text, file);
	else
		fprintf(file, "%zu", node->index);
}

/* Ends the writing of a text. NULL: out of memory. */
static char *whole(FILE *file, char **text)
{
	bool good = !ferror(file);
	good = fclose(file) == 0 && good;
	char *copy = good ? mem_strdup(*text) : NULL;
	free(*text);
	return copy;
}

static char *key_text(const struct step *step)
{
	char *text = NULL;
	size_t size;
	FILE *file = open_memstream(&text, &size);
	if (file == NULL)
		return NULL;
	write_key(step, file);
	return whole(file, &text);
}

/* A long text is cut between two characters, and tells what it was. */
static void shorten(char *text)
{
	char told[64];
	const size_t length = strlen(text);
	if (length <= SCENE_VALUE_LONG)
		return;
	snprintf(told, sizeof told, " ... (%zu bytes, hash %016llx)", length, (unsigned long long)XXH3_64bits(text, length));
	size_t at = SCENE_VALUE_LONG - strlen(told);
	while (at > 0 && ((unsigned char)text[at] & 0xc0) == 0x80)
		at--;
	memcpy(text + at, told, strlen(told) + 1);
}

static char *value_text(const struct scene_node *node)
{
	char *text = NULL;
	size_t size;
	FILE *file = open_memstream(&text, &size);
	if (file == NULL)
		return NULL;
	scene_node_write(node, file);
	text = whole(file, &text);
	if (text != NULL)
		shorten(text);
	return text;
}

static enum status add(const struct step *step, struct scene *scene)
{
	if ((scene->value_count & (scene->value_count - 1)) == 0) /* a power of two: no room is left */
		TRY(mem_resize(&scene->values, scene->value_count == 0 ? 1 : scene->value_count * 2, sizeof *scene->values, "reading the scene"));
	struct scene_value *value = &scene->values[scene->value_count++];
	*value = (struct scene_value){key_text(step), value_text(step->node)};
	return value->key != NULL && value->text != NULL ? STATUS_OK : fail_memory("reading the scene");
}

/* Whether the node's children have keys or names of their own. */
static bool has_parts(const struct scene_node *node)
{
	if (node->kind == SCENE_SCALAR || node->first == NULL)
		return false;
	return node->kind == SCENE_MAPPING || node->first->kind == SCENE_MAPPING;
}

/* No deeper than a tree is: SCENE_DEPTH. */
static enum status take(const struct step *step, struct scene *scene)
{
	if (!has_parts(step->node))
		return add(step, scene);
	for (const struct scene_node *child = step->node->first; child != NULL; child = child->next)
		if (child != name_of(step->node))
			TRY(take(&(struct step){step, child}, scene));
	return STATUS_OK;
}

enum status scene_values_take(const struct scene_tree *tree, struct scene *scene)
{
	return take(&(struct step){NULL, tree->root}, scene);
}

void scene_values_finish(struct scene *scene)
{
	for (size_t i = 0; i < scene->value_count; i++)
		mem_free_all(scene->values[i].key, scene->values[i].text);
	mem_free(scene->values);
}
