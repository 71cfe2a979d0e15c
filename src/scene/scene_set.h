/* `--set KEY=VALUE` onto a scene's tree, before it is checked. */
#ifndef FURROW_SCENE_SET_H
#define FURROW_SCENE_SET_H

#include "scene/scene.h"
#include "scene/scene_tree.h"

/* Writes the value (YAML, so lists and mappings too) at the dotted key, making the mappings on the
 * way. An element of `objects` is named by its name, of another list by its index. `null` takes
 * the key away. Whether the key and the value are allowed is for scene_match to say. */
enum status scene_set(struct scene_tree *tree, const struct scene_setting *setting) FURROW_CHECKED;

#endif
