/* Values in a study file: texts, numbers, words of a list, and any YAML on one line. Also what a
 * study owns. */
#include <stdlib.h>
#include <string.h>

#include "scene/scene_error.h"
#include "scene/scene_values.h"
#include "study.h"

const char *study_keep(struct study *study, char *text)
{
	if (text == NULL)
		return NULL;
	if ((study->text_count & (study->text_count - 1)) == 0) {
		char **grown = mem_realloc(study->texts, study->text_count == 0 ? 1 : study->text_count * 2, sizeof *grown);
		if (grown == NULL) {
			free(text);
			return NULL;
		}
		study->texts = grown;
	}
	return study->texts[study->text_count++] = text;
}

const char *study_print(struct study *study, const char *format, ...)
{
	va_list args;
	va_start(args, format);
	const int length = vsnprintf(NULL, 0, format, args);
	va_end(args);
	char *text = length >= 0 ? mem_alloc((size_t)length + 1, 1) : NULL;
	if (text == NULL)
		return NULL;
	va_start(args, format);
	(void)vsnprintf(text, (size_t)length + 1, format, args);
	va_end(args);
	return study_keep(study, text);
}

void study_destroy(struct study *study)
{
	for (size_t i = 0; i < study->parameter_count; i++)
		mem_free(study->parameters[i].values);
	for (size_t i = 0; i < study->text_count; i++)
		free(study->texts[i]);
	mem_free_all(study->texts, study->parameters, study->values, study->runs, study->results, study->plots, study->folder,
		     study->text, study->directory, study->program);
	scene_node_destroy(study->root);
	*study = (struct study){.file = NULL};
}

enum status study_only(const struct study *study, const struct scene_node *node, const char *const *allowed)
{
	struct scene_list list = {.length = 0};
	for (const char *const *name = allowed; *name != NULL; name++)
		scene_list_add(&list, *name);
	if (node->kind != SCENE_MAPPING)
		return scene_error(study->file, node, "is no mapping; allowed: %s", list.text);
	for (const struct scene_node *child = node->first; child != NULL; child = child->next) {
		const char *const *name = allowed;
		while (*name != NULL && strcmp(*name, child->key) != 0)
			name++;
		if (*name == NULL)
			return scene_error(study->file, child, "is not a key of a study here; allowed: %s", list.text);
	}
	return STATUS_OK;
}

enum status study_text(const struct study *study, const struct scene_node *parent, const char *key, const char **out)
{
	const struct scene_node *node = scene_node_child(parent, key);
	*out = NULL;
	if (node == NULL)
		return STATUS_OK;
	if (node->kind != SCENE_SCALAR || node->text[0] == '\0' || strchr(node->text, '\n') != NULL)
		return scene_error(study->file, node, "is no text; allowed: one line");
	*out = node->text;
	return STATUS_OK;
}

enum status study_number(const struct study *study, const struct scene_node *parent, const char *key, double low, double high,
			 double *value)
{
	const struct scene_node *node = scene_node_child(parent, key);
	double number;
	if (node == NULL)
		return STATUS_OK;
	if (node->kind != SCENE_SCALAR || !node->plain || !parse_number(node->text, &number))
		return scene_error(study->file, node, "is no number; allowed: %g to %.16g", low, high);
	if (!(number >= low && number <= high))
		return scene_error(study->file, node, "is %.16g; allowed: %g to %.16g", number, low, high);
	*value = number;
	return STATUS_OK;
}

enum status study_choice(const struct study *study, const struct scene_node *parent, const char *key, const char *const *names,
			 int *value)
{
	const struct scene_node *node = scene_node_child(parent, key);
	struct scene_list list = {.length = 0};
	if (node == NULL)
		return STATUS_OK;
	for (int i = 0; names[i] != NULL; i++) {
		scene_list_add(&list, names[i]);
		if (node->kind == SCENE_SCALAR && strcmp(node->text, names[i]) == 0) {
			*value = i;
			return STATUS_OK;
		}
	}
	return scene_error(study->file, node, "is none of these; allowed: %s", list.text);
}

enum status study_yaml(struct study *study, const struct scene_node *node, const char **out)
{
	char *text = NULL;
	size_t size;
	FILE *file = open_memstream(&text, &size);
	TRY_MEM(file, "a value of the study");
	scene_node_write(node, file);
	bool whole = !ferror(file);
	whole = fclose(file) == 0 && whole;
	*out = study_keep(study, text);
	return whole && *out != NULL ? STATUS_OK : fail_memory("a value of the study");
}
