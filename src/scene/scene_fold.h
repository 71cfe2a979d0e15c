/* Rewrites short forms in a scene's tree into the full forms that the table of keys has. */
#ifndef FURROW_SCENE_FOLD_H
#define FURROW_SCENE_FOLD_H

#include "scene/scene_tree.h"

/*
 * Rewrites the short forms in the tree. The rows of the table of keys say which a mapping or a list of mappings has (`alone`, `named`). So
 * `soil.classes`, which maps values of a raster to soils, becomes a list of soils, each with its `value`. A soil that is only a name
 * becomes a mapping with that name. The keys of a camera written without its kind go into a mapping of that kind. Wrong input stays as it
 * is, and scene_read refuses it.
 */
enum status scene_fold(struct scene_tree *tree) FURROW_CHECKED;

#endif
