/*
 * Writes the tree as JSON, which is a subset of YAML, and lets cyaml read that. So settings are applied, and cyaml sees only
 * text that scene_match has passed.
 */
#include "scene/scene_typed.h"

#include <stdio.h>
#include <string.h>

struct text {
	char *bytes;
	size_t used, size;
	bool failed;
};

static void put(struct text *text, const char *bytes, size_t count)
{
	text->failed = text->failed || mem_grow(&text->bytes, &text->size, text->used + count, 1, "reading the scene") != STATUS_OK;
	if (text->failed)
		return;
	memcpy(text->bytes + text->used, bytes, count);
	text->used += count;
}

static void put_quoted(struct text *text, const char *value)
{
	put(text, "\"", 1);
	for (const char *c = value; *c != '\0'; c++) {
		char escaped[8];
		if ((unsigned char)*c < 0x20 || *c == '"' || *c == '\\')
			put(text, escaped, (size_t)snprintf(escaped, sizeof escaped, "\\x%02x", *c));
		else
			put(text, c, 1);
	}
	put(text, "\"", 1);
}

static void put_node(struct text *text, const struct scene_node *node)
{
	if (node->kind == SCENE_SCALAR) {
		put_quoted(text, node->text);
		return;
	}
	bool mapping = node->kind == SCENE_MAPPING;
	put(text, mapping ? "{" : "[", 1);
	for (const struct scene_node *child = node->first; child != NULL; child = child->next) {
		if (mapping) {
			put_quoted(text, child->key);
			put(text, ": ", 2);
		}
		put_node(text, child);
		put(text, child->next != NULL ? ",\n" : "\n", child->next != NULL ? 2 : 1);
	}
	put(text, mapping ? "}" : "]", 1);
}

static void *typed_memory(void *context, void *memory, size_t size)
{
	if (size == 0) {
		mem_free(memory);
		return NULL;
	}
	return mem_realloc(memory, size, 1);
}

/* Keeps the first line of cyaml's backtrace, which tells the reason. */
static void keep_reason(cyaml_log_t level, void *context, const char *format, va_list args)
{
	char *reason = context;
	if (level >= CYAML_LOG_ERROR && reason[0] == '\0')
		vsnprintf(reason, 200, format, args);
}

static cyaml_config_t config_of(char *reason)
{
	return (cyaml_config_t){.log_fn = keep_reason, .log_ctx = reason, .mem_fn = typed_memory,
				.log_level = CYAML_LOG_ERROR, .flags = CYAML_CFG_NO_ALIAS};
}

enum status scene_typed_load(const struct scene_tree *tree, struct raw_scene **out)
{
	struct text text = {.bytes = NULL};
	char reason[200] = "";
	cyaml_config_t config = config_of(reason);
	cyaml_data_t *data = NULL;

	put_node(&text, tree->root);
	if (text.failed) {
		mem_free(text.bytes);
		return fail_memory("reading the scene");
	}
	cyaml_err_t error = cyaml_load_data((const uint8_t *)text.bytes, text.used, &config,
					    &scene_schema, &data, NULL);
	mem_free(text.bytes);
	if (error == CYAML_ERR_OOM || error == CYAML_ERR_LIBYAML_PARSER_INIT)
		return fail_memory("reading the scene");
	if (error != CYAML_OK)
		return fail_with(STATUS_INPUT, "%s: %s: %s; allowed: what the manual of scenes says",
				 tree->file, cyaml_strerror(error), reason);
	*out = data;
	return STATUS_OK;
}

void scene_typed_destroy(struct raw_scene *raw)
{
	char reason[200] = "";
	cyaml_config_t config = config_of(reason);
	if (raw != NULL)
		cyaml_free(&config, &scene_schema, raw, 0);
}
