/*
 * Makes a tree of nodes from the events of the YAML parser. Each node knows its place. scene_tree.h tells the limits that protect
 * against hostile files.
 */
#include "scene/scene_tree.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

#include "scene/scene_error.h"

struct builder {
	const char *file, *setting;
	struct scene_node *root, *at; /* the open collection; NULL outside of any */
	char *key;                    /* read, its value still to come */
	struct scene_place key_place;
	int depth;
};

struct scene_node *scene_node_create(enum scene_kind kind, const char *key)
{
	struct scene_node *node = mem_calloc(1, sizeof *node);
	if (node == NULL)
		return NULL;
	node->kind = kind;
	if (key != NULL && (node->key = mem_strdup(key)) == NULL) {
		mem_free(node);
		return NULL;
	}
	return node;
}

void scene_node_append(struct scene_node *parent, struct scene_node *child)
{
	child->parent = parent;
	child->next = NULL;
	child->index = parent->count++;
	if (parent->last == NULL)
		parent->first = child;
	else
		parent->last->next = child;
	parent->last = child;
}

void scene_node_remove(struct scene_node *child)
{
	struct scene_node *parent = child->parent, *before = NULL;
	for (struct scene_node *node = parent->first; node != child; node = node->next)
		before = node;
	if (before == NULL)
		parent->first = child->next;
	else
		before->next = child->next;
	if (parent->last == child)
		parent->last = before;
	parent->count--;
	for (struct scene_node *node = child->next; node != NULL; node = node->next)
		node->index--;
	child->parent = NULL;
	child->next = NULL;
}

void scene_node_destroy(struct scene_node *node)
{
	if (node == NULL)
		return;
	for (struct scene_node *child = node->first, *next; child != NULL; child = next) {
		next = child->next;
		scene_node_destroy(child);
	}
	mem_free_all(node->key, node->text, node->items, node);
}

static enum status list_items(struct scene_node *node)
{
	if (node->kind == SCENE_SEQUENCE && node->count > 0)
		TRY(mem_make(&node->items, node->count, sizeof *node->items, "reading the scene"));
	for (struct scene_node *child = node->first; child != NULL; child = child->next) {
		if (node->items != NULL)
			node->items[child->index] = child;
		TRY(list_items(child));
	}
	return STATUS_OK;
}

enum status scene_tree_list(struct scene_tree *tree)
{
	return list_items(tree->root);
}

void scene_tree_finish(struct scene_tree *tree)
{
	scene_node_destroy(tree->root);
	tree->root = NULL;
}

struct scene_node *scene_node_child(const struct scene_node *parent, const char *key)
{
	for (struct scene_node *node = parent->first; node != NULL; node = node->next)
		if (node->key != NULL && strcmp(node->key, key) == 0)
			return node;
	return NULL;
}

void scene_node_path(const struct scene_node *node, bool anonymous, char *text, size_t size)
{
	size_t used = 0;
	text[0] = '\0';
	if (node->parent == NULL)
		return;
	scene_node_path(node->parent, anonymous, text, size);
	used = strlen(text);
	if (node->key != NULL)
		snprintf(text + used, size - used, "%s%.40s", used == 0 ? "" : ".", node->key);
	else if (anonymous)
		snprintf(text + used, size - used, "[]");
	else
		snprintf(text + used, size - used, "[%zu]", node->index);
}

const struct scene_node *scene_tree_find(const struct scene_tree *tree, const char *format, ...)
{
	char path[160];
	va_list args;
	va_start(args, format);
	vsnprintf(path, sizeof path, format, args);
	va_end(args);
	const struct scene_node *at = tree->root;
	for (char *c = path; *c != '\0';) {
		const struct scene_node *child;
		if (*c == '.')
			c++;
		if (*c == '[') {
			size_t index = strtoul(c + 1, &c, 10);
			c++; /* the closing bracket */
			child = at->items == NULL ? at->first : index < at->count ? at->items[index] : NULL;
			while (child != NULL && child->index != index)
				child = child->next;
		} else {
			size_t length = strcspn(c, ".[");
			char after = c[length];
			c[length] = '\0';
			child = scene_node_child(at, c);
			c += length;
			*c = after;
		}
		if (child == NULL)
			return at;
		at = child;
	}
	return at;
}

static struct scene_place place_of(const yaml_mark_t *mark)
{
	return (struct scene_place){(int)mark->line + 1, (int)mark->column + 1};
}

static enum status refuse(const struct builder *builder, struct scene_place place, const char *why)
{
	if (builder->setting != NULL)
		return fail_with(STATUS_INPUT, "%s: --set %s: %s", builder->file, builder->setting, why);
	return fail_with(STATUS_INPUT, "%s:%d:%d: %s", builder->file, place.line, place.column, why);
}

/* Returns false for characters that YAML refuses unless they are escaped, or that break a line. These are C1 controls, line and
 * paragraph separators, byte order marks, and codes that are no character. */
static bool text_is_clean(const char *text, size_t length)
{
	static const char *const unclean[] = {"\xe2\x80\xa8", "\xe2\x80\xa9", "\xef\xbb\xbf", "\xef\xbf\xbe",
					      "\xef\xbf\xbf"};
	for (size_t i = 0; i < length; i++) {
		unsigned char c = (unsigned char)text[i];
		if ((c < 0x20 && c != '\n' && c != '\t') || c == 0x7f)
			return false;
		if (c == 0xc2 && i + 1 < length && (unsigned char)text[i + 1] < 0xa0)
			return false;
		for (size_t k = 0; k < sizeof unclean / sizeof unclean[0]; k++)
			if (length - i >= 3 && memcmp(text + i, unclean[k], 3) == 0)
				return false;
	}
	return true;
}

static enum status take_key(struct builder *builder, const char *text, struct scene_place place)
{
	struct scene_node *at = builder->at;
	if (scene_node_child(at, text) != NULL) {
		struct scene_node here = {.place = place, .setting = builder->setting, .parent = at,
					  .key = (char *)text};
		return scene_error(builder->file, &here,
				   "is written twice; allowed: each key once");
	}
	if (at->count >= SCENE_KEYS)
		return refuse(builder, place, "too many keys in one mapping; allowed: 64");
	builder->key = mem_strdup(text);
	builder->key_place = place;
	return builder->key == NULL ? fail_memory("reading the scene") : STATUS_OK;
}

/* Hangs a new node where the text has come to. */
static enum status add(struct builder *builder, enum scene_kind kind, const char *text, bool plain,
		       struct scene_place place)
{
	struct scene_node *node = scene_node_create(kind, NULL);
	TRY_MEM(node, "reading the scene");
	node->place = builder->key != NULL ? builder->key_place : place;
	node->setting = builder->setting;
	node->plain = plain;
	node->key = builder->key;
	builder->key = NULL;
	if (builder->at != NULL)
		scene_node_append(builder->at, node);
	else
		builder->root = node;
	if (kind != SCENE_SCALAR) {
		builder->at = node;
		builder->depth++;
		if (builder->depth > SCENE_DEPTH)
			return refuse(builder, place, "nested too deeply; allowed: 16 levels");
	} else if ((node->text = mem_strdup(text)) == NULL) {
		return fail_memory("reading the scene");
	}
	return STATUS_OK;
}

static enum status take_event(struct builder *builder, const yaml_event_t *event)
{
	const struct scene_place place = place_of(&event->start_mark);
	bool key_due = builder->at != NULL && builder->at->kind == SCENE_MAPPING &&
		       builder->key == NULL;
	const char *text;
	switch (event->type) {
	case YAML_DOCUMENT_START_EVENT:
		if (builder->root != NULL)
			return refuse(builder, place, "a second document begins; allowed: one");
		return STATUS_OK;
	case YAML_ALIAS_EVENT:
		return refuse(builder, place, "an alias (*name); allowed: the value written out");
	case YAML_SCALAR_EVENT:
		if (event->data.scalar.anchor != NULL || event->data.scalar.tag != NULL)
			return refuse(builder, place, "an anchor or a tag; allowed: plain values");
		text = (const char *)event->data.scalar.value;
		if (!text_is_clean(text, event->data.scalar.length))
			return refuse(builder, place, "a control character; allowed: printable text");
		if (key_due)
			return take_key(builder, text, place);
		return add(builder, SCENE_SCALAR, text,
			   event->data.scalar.style == YAML_PLAIN_SCALAR_STYLE, place);
	case YAML_SEQUENCE_START_EVENT:
	case YAML_MAPPING_START_EVENT:
		if (event->type == YAML_SEQUENCE_START_EVENT
			    ? event->data.sequence_start.anchor != NULL ||
				      event->data.sequence_start.tag != NULL
			    : event->data.mapping_start.anchor != NULL ||
				      event->data.mapping_start.tag != NULL)
			return refuse(builder, place, "an anchor or a tag; allowed: plain values");
		if (key_due)
			return refuse(builder, place, "a key that is no text; allowed: names");
		return add(builder,
			   event->type == YAML_SEQUENCE_START_EVENT ? SCENE_SEQUENCE : SCENE_MAPPING,
			   NULL, false, place);
	case YAML_SEQUENCE_END_EVENT:
	case YAML_MAPPING_END_EVENT:
		builder->at = builder->at->parent;
		builder->depth--;
		return STATUS_OK;
	default:
		return STATUS_OK;
	}
}

static enum status parser_failed(const struct builder *builder, const yaml_parser_t *parser)
{
	if (parser->error == YAML_MEMORY_ERROR)
		return fail_memory("reading the scene");
	static const struct {
		const char *problem; /* as libyaml begins it */
		bool at_context;     /* it is where libyaml began to read, not where it stopped */
		const char *why;
	} known[] = {
		{"found a tab character", false, "not YAML: a tab before or between keys; indent with blanks only"},
		{"found character that cannot start any token", false, "not YAML: a tab, or a sign that needs quotes; indent with blanks only, and put such text in quotes"},
		{"did not find expected '-' indicator", false, "not YAML: the line begins in another column than the entries of its list; indent it as those"},
		{"did not find expected key", false, "not YAML: the line begins in another column than the keys beside it; indent it as those"},
		{"could not find expected ':'", true, "not YAML: no key with its value; write KEY: VALUE, with a blank after the colon"},
		{"did not find expected ',' or ']'", true, "not YAML: a list is not closed; write [A, B], with a ] for each ["},
		{"did not find expected ',' or '}'", true, "not YAML: a mapping is not closed; write {KEY: VALUE}, with a } for each {"},
	};
	char why[200];
	const yaml_mark_t *at = parser->error == YAML_READER_ERROR ? &parser->mark : &parser->problem_mark;
	const char *problem = parser->problem != NULL ? parser->problem : "unreadable";
	for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
		if (strncmp(problem, known[i].problem, strlen(known[i].problem)) == 0)
			return refuse(builder, place_of(known[i].at_context && parser->context != NULL ? &parser->context_mark : at), known[i].why);
	snprintf(why, sizeof why, "not YAML: %s; correct it as YAML wants", problem);
	return refuse(builder, place_of(at), why);
}

static enum status take_events(struct builder *builder, yaml_parser_t *parser)
{
	for (bool ended = false; !ended;) {
		yaml_event_t event;
		if (!yaml_parser_parse(parser, &event))
			return parser_failed(builder, parser);
		ended = event.type == YAML_STREAM_END_EVENT;
		const enum status status = take_event(builder, &event);
		yaml_event_delete(&event);
		TRY(status);
	}
	if (builder->root == NULL)
		return refuse(builder, (struct scene_place){1, 1}, "nothing is written here; allowed: keys and values, as in scene: 1");
	return STATUS_OK;
}

enum status scene_tree_parse(const char *file, const char *setting, const char *text, size_t length,
			     struct scene_node **out)
{
	struct builder builder = {.file = file, .setting = setting};
	yaml_parser_t parser;

	*out = NULL;
	if (length >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0) { /* an editor's byte order mark */
		text += 3;
		length -= 3;
	}
	if (strncmp(text, "SQLite format 3", strnlen("SQLite format 3", length)) == 0 && length > 0)
		return fail_with(STATUS_INPUT, "%s: it is a store, not a scene; name the YAML file of the scene, and the store with --store", file);
	if (memchr(text, '\0', length) != NULL)
		return refuse(&builder, (struct scene_place){1, 1}, "it is no text, it has a NUL byte; allowed: a scene, YAML in UTF-8");
	if (!yaml_parser_initialize(&parser))
		return fail_memory("reading the scene");
	yaml_parser_set_encoding(&parser, YAML_UTF8_ENCODING);
	yaml_parser_set_input_string(&parser, (const unsigned char *)text, length);
	const enum status status = take_events(&builder, &parser);
	yaml_parser_delete(&parser);
	mem_free(builder.key);
	if (status != STATUS_OK)
		scene_node_destroy(builder.root);
	else
		*out = builder.root;
	return status;
}
