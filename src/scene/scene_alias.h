/* Replaces old names of keys and words in a scene, so that old scenes still load. */
#ifndef FURROW_SCENE_ALIAS_H
#define FURROW_SCENE_ALIAS_H

#include "scene/scene_tree.h"

/* A name that was replaced. */
struct scene_former {
	const char *where; /* of a key: its mapping; of a word: its own place; with [] for indices. NULL: no part of a scene */
	const char *former, *name;
};
bool scene_alias_at(size_t index, struct scene_former *former); /* returns false behind the last */

/* Replaces each old name of a key or word in the tree by the present name. STATUS_INPUT: a mapping has both names of a key. */
enum status scene_alias(const struct scene_tree *tree) FURROW_CHECKED;

/* Returns the present name of `key` in the mapping `parent`. Returns `key` itself if it is not an old name there. */
const char *scene_alias_key(const struct scene_node *parent, const char *key);

#endif
