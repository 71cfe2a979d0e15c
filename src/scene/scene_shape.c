/* Checks the shape of an object and fills its values in the scene. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scene/scene_check.h"
#include "scene/scene_error.h"
#include "scene/scene_file.h"
#include "scene/scene_mesh.h"

/* default, as a share of the wheel's radius */
#define GROUSER_HEIGHT 0.05
#define GROUSER_THICKNESS 0.1
#define TYRE_DAMPING 0.05 /* of what is critical */

double scene_tyre_damping(const struct soil_tyre_told *told, double gravity)
{
	return TYRE_DAMPING * 2 * sqrt(told->stiffness * told->load / gravity);
}

/* load: of the object, N; 0: it has none. */
static enum status check_tyre(const struct scene_tree *tree, const struct raw_tyre *raw, size_t index, const struct scene *scene, double load, struct soil_shape *shape)
{
	const struct scene_node *node = scene_tree_find(tree, "objects[%zu].shape.wheel.tyre", index);
	struct soil_tyre_told told = {raw->stiffness, raw->load != NULL ? *raw->load : load, raw->pressure != NULL ? *raw->pressure : (double)NAN, 0};
	if (!(told.load > 0))
		return scene_error(tree->file, node, "has no load at which it has its stiffness; needed: load, of the tyre or of the object");
	told.damping = scene_tyre_damping(&told, scene->gravity); /* of a body that a host moves; the velocity of one on a path is not known */
	char what[60];
	snprintf(what, sizeof what, "objects[%zu].shape.wheel.tyre", index);
	return soil_tyre_set(what, &told, shape, NULL);
}

static enum status check_wheel(const struct scene_tree *tree, const struct raw_wheel *raw, size_t index, const struct scene *scene, double load,
			       struct soil_shape *shape)
{
	shape->kind = SOIL_WHEEL;
	shape->radius = raw->radius;
	shape->width = raw->width;
	shape->grousers = raw->grousers != NULL ? (int)*raw->grousers : 0;
	if (raw->tyre != NULL)
		TRY(check_tyre(tree, raw->tyre, index, scene, load, shape));
	if (shape->grousers == 0) {
		const char *key = raw->grouser_height != NULL ? "grouser_height" : "grouser_thickness";
		if (raw->grouser_height == NULL && raw->grouser_thickness == NULL)
			return STATUS_OK;
		return scene_error(tree->file, scene_tree_find(tree, "objects[%zu].shape.wheel.%s", index, key),
				   "is of grousers, and the wheel has none; allowed with: grousers above 0");
	}
	shape->grouser_height = raw->grouser_height != NULL ? *raw->grouser_height : GROUSER_HEIGHT * raw->radius;
	shape->grouser_thickness = raw->grouser_thickness != NULL ? *raw->grouser_thickness : GROUSER_THICKNESS * raw->radius;
	if (shape->grouser_height > shape->radius)
		return scene_error(tree->file, scene_tree_find(tree, "objects[%zu].shape.wheel.grouser_height", index),
				   "%.10g is out of range; allowed: above 0 to the wheel's radius, %.10g",
				   shape->grouser_height, shape->radius);
	return STATUS_OK;
}

static enum status check_mesh(const struct scene_tree *tree, const struct raw_mesh *raw, size_t index,
			      struct scene_object *object)
{
	const struct scene_node *node = scene_tree_find(tree, "objects[%zu].shape.mesh.file", index);
	char *file = scene_file_beside(tree->folder, raw->file);
	TRY_MEM(file, "reading a mesh");
	object->shape.kind = SOIL_MESH;
	object->shape.belt = raw->belt != NULL && *raw->belt;
	enum status status = scene_mesh_load(file, scene_told(tree->file, node, raw->file).text,
					     raw->scale != NULL ? *raw->scale : 1, &object->mesh);
	mem_free(file);
	object->shape.mesh = object->mesh;
	return status;
}

enum status scene_check_shape(const struct scene_tree *tree, const struct raw_shape *raw, size_t index, const struct scene *scene,
			      struct scene_object *object)
{
	struct soil_shape *shape = &object->shape;
	const struct raw_rod *rod = raw->cylinder != NULL ? raw->cylinder : raw->capsule;
	int named = (raw->wheel != NULL) + (raw->sphere != NULL) + (raw->box != NULL) + (raw->mesh != NULL) + (raw->cylinder != NULL) +
		    (raw->capsule != NULL) + (raw->ellipsoid != NULL);
	if (named != 1)
		return scene_error(tree->file, scene_tree_find(tree, "objects[%zu].shape", index),
				   "names %d shapes; allowed: exactly one of wheel, sphere, box, mesh, cylinder, capsule, ellipsoid", named);
	if (raw->wheel != NULL)
		return check_wheel(tree, raw->wheel, index, scene, object->load, shape);
	if (raw->mesh != NULL)
		return check_mesh(tree, raw->mesh, index, object);
	if (rod != NULL) {
		shape->kind = raw->cylinder != NULL ? SOIL_CYLINDER : SOIL_CAPSULE;
		shape->radius = rod->radius;
		shape->length = rod->length;
	} else if (raw->ellipsoid != NULL) {
		shape->kind = SOIL_ELLIPSOID;
		memcpy(shape->size, raw->ellipsoid->radii, sizeof shape->size);
	} else if (raw->sphere != NULL) {
		shape->kind = SOIL_SPHERE;
		shape->radius = raw->sphere->radius;
	} else {
		shape->kind = SOIL_BOX;
		memcpy(shape->size, raw->box->size, sizeof shape->size);
		shape->belt = raw->box->belt != NULL && *raw->box->belt;
	}
	return STATUS_OK;
}
