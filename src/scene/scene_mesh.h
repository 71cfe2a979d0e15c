/* An object's shape from a file of triangles. */
#ifndef FURROW_SCENE_MESH_H
#define FURROW_SCENE_MESH_H

#include "deform/deform.h"

/* Reads a mesh, times `scale`. STATUS_INPUT if it cannot be; the message begins with `told`, the place in
 * the scene that names it. Freed with scene_mesh_destroy. */
enum status scene_mesh_load(const char *path, const char *told, double scale, struct deform_mesh **out)
	FURROW_CHECKED;
void scene_mesh_destroy(struct deform_mesh *mesh); /* takes NULL */

#endif
