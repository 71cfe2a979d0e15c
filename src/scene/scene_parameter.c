/*
 * Tells what a scene may have at a key: its type, and the range, unit and default of a number. The answers come from the schema.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scene/scene.h"
#include "scene/scene_error.h"
#include "scene/scene_schema.h"

/* Goes one step down in the schema: into a list by "[]", into a mapping by a key. Moves *key behind the step. Returns NULL if
 * there is no such key. */
static const cyaml_schema_value_t *step(const cyaml_schema_value_t *at, const char **key)
{
	if (**key == '[') {
		*key += strlen("[]");
		bool list = at->type == CYAML_SEQUENCE || at->type == CYAML_SEQUENCE_FIXED;
		return list ? at->sequence.entry : NULL;
	}
	*key += **key == '.';
	size_t length = strcspn(*key, ".[");
	if (at->type != CYAML_MAPPING)
		return NULL;
	for (const cyaml_schema_field_t *field = at->mapping.fields; field->key != NULL; field++)
		if (strlen(field->key) == length && strncmp(field->key, *key, length) == 0) {
			*key += length;
			return &field->value;
		}
	return NULL;
}

static const char *kind_of(const cyaml_schema_value_t *schema)
{
	switch (schema->type) {
	case CYAML_INT:
		return "whole number";
	case CYAML_FLOAT:
		return "number";
	case CYAML_BOOL:
		return "switch";
	case CYAML_ENUM:
		return "word";
	case CYAML_MAPPING:
		return "mapping";
	case CYAML_SEQUENCE:
	case CYAML_SEQUENCE_FIXED:
		return "list";
	default:
		return "text";
	}
}

bool scene_parameter(const char *key, struct scene_parameter *parameter)
{
	const cyaml_schema_value_t *schema = &scene_schema;
	for (const char *rest = key; *rest != '\0' && schema != NULL;)
		schema = step(schema, &rest);
	if (schema == NULL)
		return false;
	*parameter = (struct scene_parameter){.kind = kind_of(schema), .low = NAN, .high = NAN, .absent = NAN};
	const struct scene_limit *limit = scene_limit_of(key);
	if (limit != NULL) {
		parameter->unit = limit->unit;
		parameter->low = limit->low;
		parameter->high = limit->high;
		parameter->above = limit->above;
		parameter->absent = limit->absent;
		parameter->otherwise = limit->otherwise;
	}
	struct scene_list words = {.length = 0};
	for (uint32_t i = 0; schema->type == CYAML_ENUM && i < schema->enumeration.count; i++)
		scene_list_add(&words, schema->enumeration.strings[i].str);
	snprintf(parameter->words, sizeof parameter->words, "%.95s", words.text);
	return true;
}
