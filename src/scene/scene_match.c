/* Checks a scene's tree against the schema: keys, types, ranges and words. See scene_match.h. */
#include "scene/scene_match.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/nearest.h"
#include "scene/scene_error.h"

static enum status match_value(const struct scene_tree *tree, const cyaml_schema_value_t *schema,
			       const struct scene_node *node);

static const char *kind_name(const struct scene_node *node)
{
	if (node->kind == SCENE_MAPPING)
		return "is a mapping";
	return node->kind == SCENE_SEQUENCE ? "is a list" : "is a single value";
}

static void range_text(const struct scene_limit *limit, char *text, size_t size)
{
	const char *in = limit->unit != NULL ? ", in " : "", *unit = limit->unit != NULL ? limit->unit : "";
	if (limit->low == limit->high)
		snprintf(text, size, "%.10g%s%s", limit->low, in, unit);
	else
		snprintf(text, size, "%s%.10g to %.10g%s%s", limit->above ? "above " : "", limit->low, limit->high, in, unit);
}

bool scene_number_read(const char *text, bool whole, double *value)
{
	const char *digits = text + (*text == '-' || *text == '+');
	size_t length = strspn(digits, whole ? "0123456789" : "0123456789.eE+-");
	char *end;
	if (length == 0 || digits[length] != '\0')
		return false;
	if (whole && digits[0] == '0' && length > 1)
		return false;
	*value = strtod(text, &end);
	return *end == '\0';
}

/* As in 0,25. */
static bool has_decimal_comma(const char *text)
{
	const size_t before = strspn(text, "+-0123456789"), after = text[before] == ',' ? strspn(text + before + 1, "0123456789") : 0;
	return before > 0 && after > 0 && text[before + 1 + after] == '\0';
}

static enum status match_number(const struct scene_tree *tree, const struct scene_node *node, bool whole)
{
	char path[160], range[80] = "";
	const struct scene_limit *limit;
	double value = 0;
	scene_node_path(node, true, path, sizeof path);
	limit = scene_limit_of(path);
	if (limit != NULL)
		range_text(limit, range, sizeof range);
	const char *kind = whole ? "a whole number" : "a number";
	const char *space = range[0] == '\0' ? "" : ", ";
	if (node->kind != SCENE_SCALAR)
		return scene_error(tree->file, node, "%s; allowed: %s%s%s", kind_name(node), kind, space,
				   range);
	errno = 0;
	if (!node->plain || !scene_number_read(node->text, whole, &value))
		return scene_error(tree->file, node, "%s is not %s; allowed: %s%s%s%s", scene_quote(node->text).text, kind, kind, space, range,
				   has_decimal_comma(node->text) ? "; write a decimal point, as in 0.25" : "");
	if (errno == ERANGE || !isfinite(value) || fabs(value) > 1e15 ||
	    (limit != NULL && (value < limit->low || value > limit->high ||
			       (limit->above && value == limit->low))))
		return scene_error(tree->file, node, "%.40s %s; allowed: %s", node->text,
				   limit != NULL && limit->why != NULL ? limit->why
								       : "is out of range",
				   range[0] == '\0' ? "-1e15 to 1e15" : range);
	return STATUS_OK;
}

static enum status match_word(const struct scene_tree *tree, const cyaml_schema_value_t *schema,
			      const struct scene_node *node)
{
	struct scene_list words = {.length = 0};
	struct nearest nearest = nearest_begin(node->kind == SCENE_SCALAR ? node->text : "");
	for (uint32_t i = 0; i < schema->enumeration.count; i++) {
		const char *word = schema->enumeration.strings[i].str;
		nearest_offer(&nearest, word);
		if (node->kind == SCENE_SCALAR && strcmp(node->text, word) == 0)
			return STATUS_OK;
		scene_list_add(&words, word);
	}
	if (node->kind != SCENE_SCALAR)
		return scene_error(tree->file, node, "%s; allowed: %s", kind_name(node), words.text);
	return scene_error(tree->file, node, "%s is unknown; allowed: %s%s", scene_quote(node->text).text, words.text,
			   nearest_ask(&nearest).text);
}

static enum status match_text(const struct scene_tree *tree, const cyaml_schema_value_t *schema,
			      const struct scene_node *node)
{
	if (node->kind != SCENE_SCALAR)
		return scene_error(tree->file, node, "%s; allowed: text", kind_name(node));
	size_t length = strlen(node->text);
	if (length < schema->string.min)
		return scene_error(tree->file, node, "is empty; allowed: text");
	if (length > schema->string.max)
		return scene_error(tree->file, node, "%s is too long; allowed: %u bytes",
				   scene_quote(node->text).text, schema->string.max);
	return STATUS_OK;
}

static const cyaml_schema_field_t *field_of(const cyaml_schema_field_t *fields, const char *key)
{
	for (; fields->key != NULL; fields++)
		if (strcmp(fields->key, key) == 0)
			return fields;
	return NULL;
}

/* Returns the keys of the scene that have this one in a mapping of theirs, as output.forces for forces. */
static struct scene_list elsewhere(const char *key)
{
	struct scene_list found = {.length = 0};
	char path[160];
	for (const cyaml_schema_field_t *field = scene_schema.mapping.fields; field->key != NULL; field++) {
		if (field->value.type != CYAML_MAPPING || field_of(field->value.mapping.fields, key) == NULL)
			continue;
		snprintf(path, sizeof path, "%s.%s", field->key, key);
		scene_list_add(&found, path);
	}
	return found;
}

static enum status unknown_key(const struct scene_tree *tree, const cyaml_schema_field_t *fields, const struct scene_node *node, const char *keys)
{
	struct nearest nearest = nearest_begin(node->key);
	/* Layers are asked for by names that no key is near to. */
	static const char *const layers[] = {"depth", "layer", "layers", "below", "base"};
	const bool of_soil = node->parent != NULL && node->parent->key != NULL && strcmp(node->parent->key, "soil") == 0;
	for (size_t i = 0; of_soil && i < sizeof layers / sizeof *layers; i++)
		if (strcmp(node->key, layers[i]) == 0)
			return scene_error(tree->file, node, "unknown key; a soil that ends somewhere has a thickness, and lies over another or over rigid ground: write {name: snow_us, thickness: "
					   "0.1, over: rigid}; redistribute.depth is how deep soil slides");
	for (; fields->key != NULL; fields++)
		nearest_offer(&nearest, fields->key);
	const struct nearest_text asks = nearest_ask(&nearest);
	const struct scene_list inner = asks.text[0] == '\0' ? elsewhere(node->key) : (struct scene_list){.length = 0};
	return scene_error(tree->file, node, "unknown key; allowed: %s%s%s%s%s", keys, asks.text, inner.length > 0 ? "; did you mean " : "",
			   inner.length > 0 ? inner.text : "", inner.length > 0 ? "?" : "");
}

/* Says what kind of value a key takes. */
static void describe(const cyaml_schema_value_t *schema, const struct scene_node *here, char *text, size_t size)
{
	char path[160], range[80] = "";
	scene_node_path(here, true, path, sizeof path);
	const struct scene_limit *limit = scene_limit_of(path);
	if (limit != NULL)
		range_text(limit, range, sizeof range);
	const char *kind = schema->type == CYAML_INT	   ? "a whole number"
			   : schema->type == CYAML_FLOAT   ? "a number"
			   : schema->type == CYAML_MAPPING ? "a mapping"
			   : schema->type == CYAML_STRING  ? "a text"
			   : schema->type == CYAML_ENUM	   ? "a word"
							   : "a list";
	snprintf(text, size, "%s%s%s", kind, range[0] != '\0' ? ", " : "", range);
}

static bool is_needed(const struct scene_tree *tree, const cyaml_schema_field_t *field,
		      const struct scene_node *here)
{
	char path[160];
	if ((field->value.flags & CYAML_FLAG_OPTIONAL) == 0)
		return true;
	scene_node_path(here, true, path, sizeof path);
	return !tree->hosted && scene_needed_by_command(path);
}

static enum status match_mapping(const struct scene_tree *tree, const cyaml_schema_value_t *schema,
				 const struct scene_node *node)
{
	const cyaml_schema_field_t *fields = schema->mapping.fields;
	struct scene_list keys = {.length = 0};
	for (const cyaml_schema_field_t *field = fields; field->key != NULL; field++)
		scene_list_add(&keys, field->key);
	if (node->kind != SCENE_MAPPING)
		return scene_error(tree->file, node, "%s; allowed: a mapping of %s", kind_name(node),
				   keys.text);
	for (const struct scene_node *child = node->first; child != NULL; child = child->next) {
		const cyaml_schema_field_t *field = field_of(fields, child->key);
		if (field == NULL)
			return unknown_key(tree, fields, child, keys.text);
		TRY(match_value(tree, &field->value, child));
	}
	for (const cyaml_schema_field_t *field = fields; field->key != NULL; field++) {
		struct scene_node here = *node;
		here.parent = (struct scene_node *)node;
		here.key = (char *)field->key;
		if (scene_node_child(node, field->key) != NULL || !is_needed(tree, field, &here))
			continue;
		char value[120];
		describe(&field->value, &here, value, sizeof value);
		return scene_error(tree->file, &here, "is missing; add it: %s", value);
	}
	return STATUS_OK;
}

static enum status match_sequence(const struct scene_tree *tree, const cyaml_schema_value_t *schema,
				  const struct scene_node *node)
{
	uint32_t min = schema->sequence.min, max = schema->sequence.max;
	char size[48];
	const enum cyaml_type entry = schema->sequence.entry->type;
	if (min == max)
		snprintf(size, sizeof size, "a list of %u%s", min, entry == CYAML_FLOAT ? " numbers" : entry == CYAML_INT ? " whole numbers" : "");
	else if (max == CYAML_UNLIMITED)
		snprintf(size, sizeof size, "a list of at least %u", min);
	else
		snprintf(size, sizeof size, "a list of %u to %u", min, max);
	if (node->kind != SCENE_SEQUENCE)
		return scene_error(tree->file, node, "%s; allowed: %s", kind_name(node), size);
	if (node->count < min || node->count > max)
		return scene_error(tree->file, node, "holds %zu; allowed: %s", node->count, size);
	for (const struct scene_node *child = node->first; child != NULL; child = child->next)
		TRY(match_value(tree, schema->sequence.entry, child));
	return STATUS_OK;
}

static enum status match_value(const struct scene_tree *tree, const cyaml_schema_value_t *schema,
			       const struct scene_node *node)
{
	switch (schema->type) {
	case CYAML_INT:
		return match_number(tree, node, true);
	case CYAML_FLOAT:
		return match_number(tree, node, false);
	case CYAML_BOOL:
		if (node->kind != SCENE_SCALAR)
			return scene_error(tree->file, node, "%s; allowed: true, false", kind_name(node));
		if (!node->plain || (strcmp(node->text, "true") != 0 && strcmp(node->text, "false") != 0))
			return scene_error(tree->file, node, "%s is unknown; allowed: true, false",
					   scene_quote(node->text).text);
		return STATUS_OK;
	case CYAML_ENUM:
		return match_word(tree, schema, node);
	case CYAML_MAPPING:
		return match_mapping(tree, schema, node);
	case CYAML_SEQUENCE:
	case CYAML_SEQUENCE_FIXED:
		return match_sequence(tree, schema, node);
	default:
		return match_text(tree, schema, node);
	}
}

enum status scene_match(const struct scene_tree *tree)
{
	return match_value(tree, &scene_schema, tree->root);
}
