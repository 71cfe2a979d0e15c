/*
 * A scene's text as a tree of nodes. Each node knows its line and column, so that messages can name the place of a mistake. The tree is
 * made from libyaml's events. Limits on depth, keys and bytes make hostile text harmless.
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

/* Where a text has something: its line and its column, in characters. Both count from 1. */
struct scene_place {
	int line, column;
};

struct scene_node {
	enum scene_kind kind;
	char *key;  /* of a node in a mapping; else NULL */
	char *text; /* the text of a scalar */
	bool plain; /* a scalar without quotes: may be a number or a truth value */
	struct scene_place place; /* of the node in the text; if the node has a key, of the key */
	const char *setting; /* the --set key that this node comes from, or NULL; must stay valid longer than the tree */
	struct scene_node *parent, *first, *last, *next;
	size_t count, index; /* number of children; position among the parent's children, from 0 */
	struct scene_node **items; /* of a sequence: its children by index; NULL: not listed (scene_tree_list) */
};

struct scene_tree {
	const char *file;   /* name of the scene in messages: the file as given; must stay valid longer than the tree */
	const char *folder; /* folder of the files that the scene names: "" or ends in '/'; must stay valid longer than the tree */
	bool hosted;        /* the scene is read for a host: see `command` of struct scene_row */
	struct scene_node *root; /* a mapping */
};

/* Reads YAML into a tree. `setting`: the KEY of --set whose value this text is, for messages; NULL: the text is the scene
 * itself. */
enum status scene_tree_parse(const char *file, const char *setting, const char *text, size_t length,
			     struct scene_node **out) FURROW_CHECKED;
void scene_node_destroy(struct scene_node *node);
void scene_tree_finish(struct scene_tree *tree);

struct scene_node *scene_node_create(enum scene_kind kind, const char *key); /* returns NULL if out of memory */
void scene_node_append(struct scene_node *parent, struct scene_node *child);
/* Takes `child` out of its parent. The caller owns it then. */
void scene_node_remove(struct scene_node *child);
struct scene_node *scene_node_child(const struct scene_node *parent, const char *key);

/* Lists the children of every sequence, so that scene_tree_find takes the same time for each. The tree may not change afterwards. */
enum status scene_tree_list(struct scene_tree *tree) FURROW_CHECKED;
/* Returns the node at a path such as "objects[1].path.speed". If it does not exist, returns the deepest node on the way to it. */
const struct scene_node *scene_tree_find(const struct scene_tree *tree, const char *format, ...)
	FURROW_PRINTF(2, 3);

/* Writes a node's path: "objects[1].path.speed", or with `anonymous` "objects[].path.speed". A path that does not fit is cut. */
void scene_node_path(const struct scene_node *node, bool anonymous, char *text, size_t size);

#endif
