/* The settings of a scene as text: what run.json has of it, and what a study writes. */
#ifndef FURROW_SCENE_VALUES_H
#define FURROW_SCENE_VALUES_H

#include <stdio.h>

#include "scene/scene.h"
#include "scene/scene_tree.h"

#define SCENE_VALUE_LONG 400 /* bytes: a longer value is cut, and ends with its length and a hash of all of it */

/* Writes a node as YAML on one line. */
void scene_node_write(const struct scene_node *node, FILE *file);
/* Puts all settings of the tree into scene->values. The tree has no old names and no short forms any more. */
enum status scene_values_take(const struct scene_tree *tree, struct scene *scene) FURROW_CHECKED;
void scene_values_finish(struct scene *scene);

#endif
