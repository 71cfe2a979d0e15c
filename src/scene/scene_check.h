/*
 * Makes the checked scene from the typed values. Sets defaults, converts units, and resolves references between keys. Checks
 * rules that concern several keys together. An error message names the line of the key.
 */
#ifndef FURROW_SCENE_CHECK_H
#define FURROW_SCENE_CHECK_H

#include "scene/scene.h"
#include "scene/scene_error.h"
#include "scene/scene_schema.h"
#include "scene/scene_tree.h"

/* Fills `scene`. Before the call it is zero, except for its file, folder and `hosted`. On failure the caller frees what `scene`
 * holds by then. */
enum status scene_check(const struct scene_tree *tree, const struct raw_scene *raw,
			struct scene *scene) FURROW_CHECKED;

/* Returns the number that the scene gives, or `otherwise` if it gives none. */
static inline double scene_or(const double *given, double otherwise)
{
	return given != NULL ? *given : otherwise;
}
/* The same with the default of the key. */
static inline double scene_number(const double *given, const char *key)
{
	return given != NULL ? *given : scene_absent(key);
}
/* Makes an interface. Degrees, Pa; NULL: the soil's own. */
struct soil_interface scene_interface(const double *friction_angle, const double *adhesion);
/* Copies texts. */
enum status scene_take_texts(char *const *from, uint32_t count, struct scene_texts *texts) FURROW_CHECKED;

/* Notes a setting that has no effect but is no error. scene_advise tells it. */
enum status scene_tell_unused(struct scene *scene, const char *format, ...) FURROW_PRINTF(2, 3) FURROW_CHECKED;

/* STATUS_INPUT unless the name has letters, digits, _ and - alone. `node`: that gives it. */
enum status scene_check_name(const struct scene_tree *tree, const struct scene_node *node, const char *name) FURROW_CHECKED;
/* The parts of scene_check, each in a file of its own. */
enum status scene_check_objects(const struct scene_tree *tree, const struct raw_scene *raw,
				struct scene *scene) FURROW_CHECKED;
/* Fills the shape and the mesh of objects[index]. */
enum status scene_check_shape(const struct scene_tree *tree, const struct raw_shape *raw, size_t index, const struct scene *scene,
			      struct scene_object *object) FURROW_CHECKED;
/* STATUS_INPUT if one of the scene's soils cannot carry the object, by the model's pressure-sinkage law. The object is the only
 * one of its tree. */
enum status scene_check_bearing(const struct scene_tree *tree, const struct scene *scene,
				const struct scene_object *object) FURROW_CHECKED;
/* Checks the vehicles, and when one is stuck. Call it after scene_check_objects, whose names they may not have. */
enum status scene_check_vehicles(const struct scene_tree *tree, const struct raw_scene *raw, struct scene *scene) FURROW_CHECKED;
void scene_vehicle_finish(struct scene_vehicle *vehicle);
/* Call this after scene_check_objects. */
enum status scene_check_soil(const struct scene_tree *tree, const struct raw_scene *raw,
			     struct scene *scene) FURROW_CHECKED;
/* Part of scene_check_soil: fills the roads, without their soils. */
enum status scene_roads_take(const struct scene_tree *tree, const struct raw_ground *raw, struct scene *scene) FURROW_CHECKED;
void scene_roads_finish(struct scene *scene);
/* Part of scene_check_soil: fills the rocks, without their soil. `raw` may be NULL. */
enum status scene_rocks_take(const struct scene_tree *tree, const struct raw_ground *raw, struct scene *scene) FURROW_CHECKED;
/* Part of scene_check_soil. `raw` may be NULL. */
enum status scene_check_rasters(const struct scene_tree *tree, const struct raw_rasters *raw, struct scene *scene) FURROW_CHECKED;
/* Gives the soil of a class that `node` names by its value, and notes it in `given`. STATUS_INPUT: soil.classes has no such class, or it was given before. */
enum status scene_check_class(const struct scene_tree *tree, const struct scene_node *node, int value, const struct scene *scene, bool given[SOIL_CLASSES],
			      uint8_t *soil) FURROW_CHECKED;
/* Call this after scene_check_soil. */
enum status scene_check_attributes(const struct scene_tree *tree, const struct raw_scene *raw, struct scene *scene) FURROW_CHECKED;
enum status scene_check_relief(const struct scene_tree *tree, const struct raw_scene *raw,
			       struct scene *scene) FURROW_CHECKED;
#define SCENE_RASTER_BYTES ((uint64_t)1 << 30) /* the largest file of a map or raster of the soil */
enum status scene_check_view(const struct scene_tree *tree, const struct raw_scene *raw,
			     struct scene *scene) FURROW_CHECKED;
/* Finds the object or the vehicle that a camera follows. `key`: its place in the scene, for the message. */
enum status scene_find_target(const struct scene_tree *tree, const struct scene *scene, const char *name, const char *key,
			      struct scene_aim *aim) FURROW_CHECKED;
/* Call this after scene_check_view. */
enum status scene_check_cameras(const struct scene_tree *tree, const struct raw_scene *raw, struct scene *scene) FURROW_CHECKED;
void scene_camera_finish(struct scene_camera *camera);
/* Call this after scene_check_cameras. */
enum status scene_check_lidars(const struct scene_tree *tree, const struct raw_scene *raw, struct scene *scene) FURROW_CHECKED;
void scene_lidar_finish(struct scene_lidar *lidar);

/* Notes the numbers that seem to be given in a wrong unit, for scene_advise_units. Call this after the other checks. */
enum status scene_check_units(const struct scene_tree *tree, const struct raw_scene *raw,
			      struct scene *scene) FURROW_CHECKED;
/* Returns the names of the models that compute forces. */
struct scene_list scene_models_with_forces(void);
struct scene_list scene_models_with_loads(void); /* those that bear a body with a load */
/* Tells which objects have so few posts below them that forces are off, and by how much. Part of scene_advise. */
void scene_advise_posts(const struct scene *scene, double spacing, scene_advice_fn tell, void *user);
/* Tells of the wheel that the soil's rebound pushes most, if the scene writes forces. Part of scene_advise. */
void scene_advise_rebound(const struct scene *scene, scene_advice_fn tell, void *user);
/* advice_effects.c: tells effects that nothing in the scene can show. spacing: m; 0: not known. */
void scene_advise_effects(const struct scene *scene, double spacing, scene_advice_fn tell, void *user);
void scene_drop_doubts(struct scene *scene); /* frees the notes of scene_check_units */

/* Computes scene->hash from all settings that decide the ground. The cache, the view, the output, the store's name and the end
 * time do not count. */
enum status scene_hash(struct scene *scene) FURROW_CHECKED;

#endif
