/* Between the reader of mesh files (assimp, or none) and what makes a mesh of their triangles. */
#ifndef FURROW_SCENE_MESH_IMPORT_H
#define FURROW_SCENE_MESH_IMPORT_H

#include "scene/scene_mesh.h"

/* Corners in the file's units and in our axes, three in a row a triangle. */
struct mesh_corners {
	double (*at)[3];
	size_t triangles;
};

/* `at` is freed with mem_free, also after a failure. */
enum status scene_mesh_import(const char *path, const char *told, struct mesh_corners *corners) FURROW_CHECKED;

#endif
