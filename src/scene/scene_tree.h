/*
 * A scene's text as a tree of nodes that know their line, so that messages can name the place of a mistake. It is read from
 * libyaml's events, under limits that make hostile text harmless.
 */
#ifndef FURROW_SCENE_TREE_H
#define FURROW_SCENE_TREE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/base.h"

#define SCENE_DEPTH 16
#define SCENE_KEYS 64
#define SCENE_BYTES (1u << 20)

enum scene_kind { SCENE_SCALAR, SCENE_SEQUENCE, SCENE_MAPPING };

struct scene_node {
	enum scene_kind kind;
	char *key;  /* in a mapping */
	char *text; /* a scalar's */
	bool plain; /* a scalar without quotes: may be a number or a truth value */
	int line;   /* from 1, of the key where there is one */
	const char *setting; /* the --set key it came from, which outlives the tree; or NULL */
	struct scene_node *parent, *first, *last, *next;
	size_t count, index; /* children; place among its siblings */
};

struct scene_tree {
	const char *file;   /* what messages call it: the file as given; outlives the tree */
	const char *folder; /* where the files that it names are: "" or ends in '/'; outlives the tree */
	bool hosted;        /* read for a host: see scene_needed_by_command */
	struct scene_node *root; /* a mapping */
};

/* Reads YAML. `setting`: the text is that of a --set KEY, and messages say so. */
enum status scene_tree_parse(const char *file, const char *setting, const char *text, size_t length,
			     struct scene_node **out) FURROW_CHECKED;
void scene_node_destroy(struct scene_node *node);
void scene_tree_finish(struct scene_tree *tree);

struct scene_node *scene_node_create(enum scene_kind kind, const char *key); /* NULL: no memory */
void scene_node_append(struct scene_node *parent, struct scene_node *child);
/* Takes `child` out of its parent; it is the caller's. */
void scene_node_remove(struct scene_node *child);
struct scene_node *scene_node_child(const struct scene_node *parent, const char *key);

/* The node at a path such as "objects[1].path.speed", or the deepest one that exists on the way. */
const struct scene_node *scene_tree_find(const struct scene_tree *tree, const char *format, ...)
	FURROW_PRINTF(2, 3);

/* "objects[1].path.speed"; with `anonymous`, "objects[].path.speed". Cut if it does not fit. */
void scene_node_path(const struct scene_node *node, bool anonymous, char *text, size_t size);

#endif
