/*
 * From typed values to the checked scene: defaults, units, references between keys, and what no
 * single key can say about itself. What it refuses it refuses with the line of the key.
 */
#ifndef FURROW_SCENE_CHECK_H
#define FURROW_SCENE_CHECK_H

#include "scene/scene.h"
#include "scene/scene_schema.h"
#include "scene/scene_tree.h"

/* Fills `scene`, zeroed but for its file. On failure what it holds so far is the caller's. */
enum status scene_check(const struct scene_tree *tree, const struct raw_scene *raw,
			struct scene *scene) FURROW_CHECKED;

/* Something that the scene says is of no use, and no mistake: kept for scene_advise. */
enum status scene_tell_unused(struct scene *scene, const char *format, ...) FURROW_PRINTF(2, 3) FURROW_CHECKED;

/* The parts of it, one a file. */
enum status scene_check_objects(const struct scene_tree *tree, const struct raw_scene *raw,
				struct scene *scene) FURROW_CHECKED;
/* Fills the shape, and the mesh, of objects[index]. */
enum status scene_check_shape(const struct scene_tree *tree, const struct raw_shape *raw, size_t index,
			      struct scene_object *object) FURROW_CHECKED;
/* After the objects. */
enum status scene_check_soil(const struct scene_tree *tree, const struct raw_scene *raw,
			     struct scene *scene) FURROW_CHECKED;
enum status scene_check_view(const struct scene_tree *tree, const struct raw_scene *raw,
			     struct scene *scene) FURROW_CHECKED;

/* scene->hash, of all that decides what the ground becomes: not of the cache, the view, the output, the
 * store's name, or when the drive ends. */
enum status scene_hash(struct scene *scene) FURROW_CHECKED;

#endif
