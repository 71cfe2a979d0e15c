/*
 * From typed values to the checked scene: defaults, units, references between keys, and what no
 * single key can say about itself. What it refuses it refuses with the line of the key.
 */
#ifndef FURROW_SCENE_CHECK_H
#define FURROW_SCENE_CHECK_H

#include "scene/scene.h"
#include "scene/scene_error.h"
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
/* Fills `object`, which is zeroed, from entry `index` of the tree's objects. The name stays NULL where none is
 * given. What the caller gets on failure it frees, too. */
enum status scene_check_object(const struct scene_tree *tree, const struct raw_object *raw, size_t index,
			       const struct scene *scene, struct scene_object *object) FURROW_CHECKED;
/* Fills the shape, and the mesh, of objects[index]. */
enum status scene_check_shape(const struct scene_tree *tree, const struct raw_shape *raw, size_t index,
			      struct scene_object *object) FURROW_CHECKED;
/* Refuses an object, the only one of its tree, that one of the scene's soils cannot bear. */
enum status scene_check_bearing(const struct scene_tree *tree, const struct scene *scene,
				const struct scene_object *object) FURROW_CHECKED;
/* After the objects. */
enum status scene_check_soil(const struct scene_tree *tree, const struct raw_scene *raw,
			     struct scene *scene) FURROW_CHECKED;
enum status scene_check_view(const struct scene_tree *tree, const struct raw_scene *raw,
			     struct scene *scene) FURROW_CHECKED;

/* Keeps notes of numbers that are probably in another unit, for scene_advise_units. After the others. */
enum status scene_check_units(const struct scene_tree *tree, const struct raw_scene *raw,
			      struct scene *scene) FURROW_CHECKED;
/* Returns the names of the models that tell forces. */
struct scene_list scene_models_with_forces(void);
void scene_drop_doubts(struct scene *scene); /* frees those notes */

/* scene->hash, of all that decides what the ground becomes: not of the cache, the view, the output, the
 * store's name, or when the drive ends. */
enum status scene_hash(struct scene *scene) FURROW_CHECKED;

#endif
