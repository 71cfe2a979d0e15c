/* Former names of keys and words that a scene may still use. */
#ifndef FURROW_SCENE_ALIAS_H
#define FURROW_SCENE_ALIAS_H

#include "scene/scene_tree.h"

/* Gives keys and words that have a former name their present one. STATUS_INPUT where a mapping has both names of a
 * key. */
enum status scene_alias(const struct scene_tree *tree) FURROW_CHECKED;

/* The present name of `key` in the mapping `parent`: `key` itself if it is no former name there. */
const char *scene_alias_key(const struct scene_node *parent, const char *key);

#endif
