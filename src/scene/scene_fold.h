/* What may be written shortly, or with keys that no schema can name, as the schema knows it. */
#ifndef FURROW_SCENE_FOLD_H
#define FURROW_SCENE_FOLD_H

#include "scene/scene_tree.h"

/*
 * Rewrites the tree's short forms as the schema has them. Cameras written flat go under their names. `soil.classes` maps a
 * raster's values to soils: it becomes a list of soils, each with its `value`. A soil there, or in `soil.default`, may be only a
 * name: it becomes a mapping that holds the name. Everything else stays, and scene_match refuses it.
 */
enum status scene_fold(struct scene_tree *tree) FURROW_CHECKED;

#endif
