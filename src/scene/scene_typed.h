/* Loads a matched tree as typed values, with cyaml. */
#ifndef FURROW_SCENE_TYPED_H
#define FURROW_SCENE_TYPED_H

#include "scene/scene_schema.h"
#include "scene/scene_tree.h"

enum status scene_typed_load(const struct scene_tree *tree, struct raw_scene **out) FURROW_CHECKED;
void scene_typed_destroy(struct raw_scene *raw);

#endif
