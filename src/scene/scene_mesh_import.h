/* The interface between the reader of mesh files (assimp, or none) and scene_mesh.c, which makes a mesh of the triangles. */
#ifndef FURROW_SCENE_MESH_IMPORT_H
#define FURROW_SCENE_MESH_IMPORT_H

#include "scene/scene_mesh.h"

/* Corners of triangles, three for each. They are in the file's unit, and in our axes. */
struct mesh_corners {
	double (*at)[3];
	size_t triangles;
};

/* Reads the corners of all triangles of a file. The caller frees `at` with mem_free, also after a failure. */
enum status scene_mesh_import(const char *path, const char *told, struct mesh_corners *corners) FURROW_CHECKED;

/* Refuse a file that has more parts than its triangles may need; see scene_mesh_count.c. STATUS_INPUT: it has. */
enum status scene_mesh_count_obj(const char *bytes, size_t length, const char *told) FURROW_CHECKED;
enum status scene_mesh_count_stl(const char *bytes, size_t length, const char *told) FURROW_CHECKED;
enum status scene_mesh_count_dae(const char *bytes, size_t length, const char *told) FURROW_CHECKED;

#endif
