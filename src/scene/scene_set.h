/* Applies `--set KEY=VALUE` to a scene's tree before the tree is checked. */
#ifndef FURROW_SCENE_SET_H
#define FURROW_SCENE_SET_H

#include "scene/scene.h"
#include "scene/scene_tree.h"

/* Writes the value at the dotted key and adds missing mappings on the way. The value is YAML, so it may be a list or a mapping.
 * An element of `objects` is given by its name, an element of another list by its index. The value `null` removes the key.
 * scene_read checks later whether key and value are allowed. */
enum status scene_set(struct scene_tree *tree, const struct scene_setting *setting) FURROW_CHECKED;

#endif
