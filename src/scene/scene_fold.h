/* What may be written shortly, or with keys that no schema can name, as the schema knows it. */
#ifndef FURROW_SCENE_FOLD_H
#define FURROW_SCENE_FOLD_H

#include "scene/scene_tree.h"

/*
 * Cameras written flat go under their names. `soil.classes`, a mapping of a raster's values to soils,
 * becomes a list of soils that each hold their `value`; a soil there, or `soil.default`, that is only a
 * name becomes a mapping that holds it. What is none of these stays for scene_match to refuse.
 */
enum status scene_fold(struct scene_tree *tree) FURROW_CHECKED;

#endif
