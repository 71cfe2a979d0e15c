/* Reads the tree of a scene into typed values, and checks it by the table of keys. See scene_read.h. */
#include "scene/scene_read.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/nearest.h"
#include "scene/scene_error.h"

static enum status read_row(const struct scene_tree *tree, const struct scene_row *row, const struct scene_node *node, char *base);

static const char *kind_name(const struct scene_node *node)
{
	if (node->kind == SCENE_MAPPING)
		return "is a mapping";
	return node->kind == SCENE_SEQUENCE ? "is a list" : "is a single value";
}

/* --- single values --- */

/* What numbers of a row may be: "above 0 to 1000, in m". */
struct range {
	char text[80];
};
static struct range range_of(const struct scene_row *row)
{
	const char *in = row->unit != NULL ? ", in " : "", *unit = row->unit != NULL ? row->unit : "";
	struct range range;
	if (row->low == row->high)
		snprintf(range.text, sizeof range.text, "%.10g%s%s", row->low, in, unit);
	else
		snprintf(range.text, sizeof range.text, "%s%.10g to %.10g%s%s", row->above ? "above " : "", row->low, row->high, in, unit);
	return range;
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

static enum status read_number(const struct scene_tree *tree, const struct scene_row *row, const struct scene_node *node, void *at)
{
	const bool whole = row->type == ROW_WHOLE;
	const char *kind = whole ? "a whole number" : "a number";
	double value = 0;
	if (node->kind != SCENE_SCALAR)
		return scene_error(tree->file, node, "%s; allowed: %s, %s", kind_name(node), kind, range_of(row).text);
	errno = 0;
	if (!node->plain || !scene_number_read(node->text, whole, &value))
		return scene_error(tree->file, node, "%s is not %s; allowed: %s, %s%s", scene_quote(node->text).text, kind, kind, range_of(row).text,
				   has_decimal_comma(node->text) ? "; write a decimal point, as in 0.25" : "");
	if (errno == ERANGE || !isfinite(value) || value < row->low || value > row->high || (row->above && value == row->low))
		return scene_error(tree->file, node, "%.40s %s; allowed: %s", node->text, row->why != NULL ? row->why : "is out of range", range_of(row).text);
	if (whole)
		memcpy(at, &(int64_t){(int64_t)value}, sizeof(int64_t));
	else
		memcpy(at, &value, sizeof value);
	return STATUS_OK;
}

static enum status read_word(const struct scene_tree *tree, const struct scene_row *row, const struct scene_node *node, int *at)
{
	struct scene_list words = {.length = 0};
	struct nearest nearest = nearest_begin(node->kind == SCENE_SCALAR ? node->text : "");
	for (const struct scene_word *word = row->words; word->word != NULL; word++) {
		nearest_offer(&nearest, word->word);
		if (node->kind == SCENE_SCALAR && strcmp(node->text, word->word) == 0) {
			*at = word->value;
			return STATUS_OK;
		}
		scene_list_add(&words, word->word);
	}
	if (node->kind != SCENE_SCALAR)
		return scene_error(tree->file, node, "%s; allowed: %s", kind_name(node), words.text);
	return scene_error(tree->file, node, "%s is unknown; allowed: %s%s", scene_quote(node->text).text, words.text,
			   nearest_ask(&nearest).text);
}

static enum status read_text(const struct scene_tree *tree, const struct scene_row *row, const struct scene_node *node, char **at)
{
	if (node->kind != SCENE_SCALAR)
		return scene_error(tree->file, node, "%s; allowed: text", kind_name(node));
	const size_t length = strlen(node->text);
	if (length < 1)
		return scene_error(tree->file, node, "is empty; allowed: text");
	if (length > row->longest)
		return scene_error(tree->file, node, "%s is too long; allowed: %u bytes", scene_quote(node->text).text, row->longest);
	*at = mem_strdup(node->text);
	return *at != NULL ? STATUS_OK : fail_memory("reading the scene");
}

static enum status read_switch(const struct scene_tree *tree, const struct scene_node *node, bool *at)
{
	if (node->kind != SCENE_SCALAR)
		return scene_error(tree->file, node, "%s; allowed: true, false", kind_name(node));
	*at = strcmp(node->text, "true") == 0;
	if (!node->plain || (!*at && strcmp(node->text, "false") != 0))
		return scene_error(tree->file, node, "%s is unknown; allowed: true, false", scene_quote(node->text).text);
	return STATUS_OK;
}

/* --- mappings --- */

/* Returns the keys of the scene that have this one in a mapping of theirs, as output.forces for forces. */
static struct scene_list elsewhere(const char *key)
{
	struct scene_list found = {.length = 0};
	struct scene_rows walk = scene_rows_begin(scene_schema);
	const struct scene_row *row;
	char path[160];
	while ((row = scene_rows_next(&walk)) != NULL) {
		if (row->type != ROW_MAPPING || row->form == ROW_LIST || scene_row_find(row->rows, key, strlen(key)) == NULL)
			continue;
		snprintf(path, sizeof path, "%s.%s", row->key, key);
		scene_list_add(&found, path);
	}
	return found;
}

static struct scene_list keys_of(const struct scene_row *rows)
{
	struct scene_list keys = {.length = 0};
	struct scene_rows walk = scene_rows_begin(rows);
	const struct scene_row *row;
	while ((row = scene_rows_next(&walk)) != NULL)
		scene_list_add(&keys, row->key);
	return keys;
}

static enum status unknown_key(const struct scene_tree *tree, const struct scene_row *rows, const struct scene_node *node)
{
	struct nearest nearest = nearest_begin(node->key);
	/* Layers are asked for by names that no key is near to. */
	static const char *const layers[] = {"depth", "layer", "layers", "below", "base"};
	const bool of_soil = node->parent != NULL && node->parent->key != NULL && strcmp(node->parent->key, "soil") == 0;
	for (size_t i = 0; of_soil && i < sizeof layers / sizeof *layers; i++)
		if (strcmp(node->key, layers[i]) == 0)
			return scene_error(tree->file, node, "unknown key; a soil that ends somewhere has a thickness, and lies over another or over rigid ground: write {name: snow_us, thickness: "
					   "0.1, over: rigid}; redistribute.depth is how deep soil slides");
	struct scene_rows walk = scene_rows_begin(rows);
	const struct scene_row *row;
	while ((row = scene_rows_next(&walk)) != NULL)
		nearest_offer(&nearest, row->key);
	const struct nearest_text asks = nearest_ask(&nearest);
	const struct scene_list inner = asks.text[0] == '\0' ? elsewhere(node->key) : (struct scene_list){.length = 0};
	return scene_error(tree->file, node, "unknown key; allowed: %s%s%s%s%s", keys_of(rows).text, asks.text, inner.length > 0 ? "; did you mean " : "",
			   inner.length > 0 ? inner.text : "", inner.length > 0 ? "?" : "");
}

/* A key that its mapping must have is not there. */
static enum status missing(const struct scene_tree *tree, const struct scene_row *row, const struct scene_node *node)
{
	static const char *const kinds[] = {
		[ROW_NUMBER] = "a number, ", [ROW_WHOLE] = "a whole number, ", [ROW_SWITCH] = "true or false", [ROW_WORD] = "a word", [ROW_TEXT] = "a text",
		[ROW_MAPPING] = "a mapping",
	};
	const bool list = scene_row_lists(row) > 0, number = !list && (row->type == ROW_NUMBER || row->type == ROW_WHOLE);
	struct scene_node here = *node;
	here.parent = (struct scene_node *)node;
	here.key = (char *)row->key;
	return scene_error(tree->file, &here, "is missing; add it: %s%s", list ? "a list" : kinds[row->type], number ? range_of(row).text : "");
}

static enum status read_mapping(const struct scene_tree *tree, const struct scene_row *rows, const struct scene_node *node, char *base)
{
	if (node->kind != SCENE_MAPPING)
		return scene_error(tree->file, node, "%s; allowed: a mapping of %s", kind_name(node), keys_of(rows).text);
	for (const struct scene_node *child = node->first; child != NULL; child = child->next) {
		const struct scene_row *row = scene_row_find(rows, child->key, strlen(child->key));
		if (row == NULL)
			return unknown_key(tree, rows, child);
		if (scene_node_child(node, child->key) != child)
			return scene_error(tree->file, child, "is given twice, once in a short form; allowed: each key once");
		TRY(read_row(tree, row, child, base));
	}
	struct scene_rows walk = scene_rows_begin(rows);
	const struct scene_row *row;
	while ((row = scene_rows_next(&walk)) != NULL)
		if ((row->needed || (row->command && !tree->hosted)) && scene_node_child(node, row->key) == NULL)
			return missing(tree, row, node);
	return STATUS_OK;
}

/* --- a row --- */

/* Reads one value of the row into `at`, which has row->size bytes, all zero. */
static enum status read_value(const struct scene_tree *tree, const struct scene_row *row, const struct scene_node *node, char *at)
{
	switch (row->type) {
	case ROW_SWITCH:
		return read_switch(tree, node, (bool *)(void *)at);
	case ROW_WORD:
		return read_word(tree, row, node, (int *)(void *)at);
	case ROW_MAPPING:
		return read_mapping(tree, row->rows, node, at);
	case ROW_TEXT:
		return read_text(tree, row, node, (char **)(void *)at);
	default:
		return read_number(tree, row, node, at);
	}
}

/* Refuses what is no list of `least` to `most` entries. */
static enum status check_length(const struct scene_tree *tree, const struct scene_row *row, bool of_lists, uint32_t least, uint32_t most,
				const struct scene_node *node)
{
	char size[48];
	if (node->kind == SCENE_SEQUENCE && node->count >= least && node->count <= most)
		return STATUS_OK;
	if (least == most)
		snprintf(size, sizeof size, "a list of %u%s", least,
			 of_lists ? "" : row->type == ROW_NUMBER ? " numbers" : row->type == ROW_WHOLE ? " whole numbers" : "");
	else if (most == ENDLESS)
		snprintf(size, sizeof size, "a list of at least %u", least);
	else
		snprintf(size, sizeof size, "a list of %u to %u", least, most);
	if (node->kind != SCENE_SEQUENCE)
		return scene_error(tree->file, node, "%s; allowed: %s", kind_name(node), size);
	return scene_error(tree->file, node, "holds %zu; allowed: %s", node->count, size);
}

/* Reads the entries of a list into `at`, which has room for them, all zero. */
static enum status read_entries(const struct scene_tree *tree, const struct scene_row *row, const struct scene_node *node, char *at)
{
	for (const struct scene_node *child = node->first; child != NULL; child = child->next, at += row->size) {
		if (row->each == 0) {
			TRY(read_value(tree, row, child, at));
			continue;
		}
		TRY(check_length(tree, row, false, row->each, row->each, child));
		char *number = at;
		for (const struct scene_node *inner = child->first; inner != NULL; inner = inner->next, number += row->size / row->each)
			TRY(read_number(tree, row, inner, number));
	}
	return STATUS_OK;
}

/* Makes room for `count` values of the row, all zero, and hangs it into the struct at `base`. Whoever fails later leaves it there. */
static enum status make_room(const struct scene_row *row, size_t count, char *base, char **room)
{
	TRY(mem_zeroed(room, count, row->size, "reading the scene"));
	memcpy(base + row->at, room, sizeof *room);
	return STATUS_OK;
}

/* Reads what the scene says of a row into the struct at `base`. */
static enum status read_row(const struct scene_tree *tree, const struct scene_row *row, const struct scene_node *node, char *base)
{
	char *room;
	switch (row->form) {
	case ROW_HERE:
		return read_value(tree, row, node, base + row->at);
	case ROW_POINTER:
		TRY(make_room(row, 1, base, &room));
		return read_value(tree, row, node, room);
	case ROW_FIXED:
		TRY(check_length(tree, row, row->each > 0, row->least, row->most, node));
		return read_entries(tree, row, node, base + row->at);
	default:
		TRY(check_length(tree, row, row->each > 0, row->least, row->most, node));
		if (node->count == 0)
			return STATUS_OK;
		TRY(make_room(row, node->count, base, &room));
		memcpy(base + row->count_at, &(uint32_t){(uint32_t)node->count}, sizeof(uint32_t));
		return read_entries(tree, row, node, room);
	}
}

/* --- the end of the values --- */

static void drop_mapping(const struct scene_row *rows, char *base);

static void drop_value(const struct scene_row *row, char *at)
{
	char *text;
	if (row->type == ROW_MAPPING)
		drop_mapping(row->rows, at);
	if (row->type != ROW_TEXT)
		return;
	memcpy(&text, at, sizeof text);
	mem_free(text);
}

static void drop_mapping(const struct scene_row *rows, char *base)
{
	struct scene_rows walk = scene_rows_begin(rows);
	const struct scene_row *row;
	while ((row = scene_rows_next(&walk)) != NULL) {
		char *room = NULL;
		uint32_t count = 1;
		if (row->form == ROW_FIXED)
			continue;
		if (row->form == ROW_HERE) {
			drop_value(row, base + row->at);
			continue;
		}
		memcpy(&room, base + row->at, sizeof room);
		if (row->form == ROW_LIST)
			memcpy(&count, base + row->count_at, sizeof count);
		for (uint32_t i = 0; i < count && room != NULL && (row->type == ROW_TEXT || row->type == ROW_MAPPING); i++)
			drop_value(row, room + (size_t)i * row->size);
		mem_free(room);
	}
}

void scene_raw_destroy(struct raw_scene *raw)
{
	if (raw != NULL)
		drop_mapping(scene_schema, (char *)raw);
	mem_free(raw);
}

enum status scene_read(const struct scene_tree *tree, struct raw_scene **out)
{
	struct raw_scene *raw;
	*out = NULL;
	TRY(mem_zeroed(&raw, 1, sizeof *raw, "reading the scene"));
	const enum status status = read_mapping(tree, scene_schema, tree->root, (char *)raw);
	if (status == STATUS_OK)
		*out = raw;
	else
		scene_raw_destroy(raw);
	return status;
}
