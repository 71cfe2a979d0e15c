/* The interface between the reader of mesh files (assimp, or none) and scene_mesh.c, which makes a mesh of the triangles. */
#ifndef FURROW_SCENE_MESH_IMPORT_H
#define FURROW_SCENE_MESH_IMPORT_H

#include "scene/scene_mesh.h"

/* Corners of triangles, three for each. They are in the file's unit, and in our axes. */
struct mesh_corners {
	double (*at)[3];
	size_t triangles;
	uint8_t *parts; /* of each triangle the number of its colour; NULL: colours are not read */
	float (*colours)[4]; /* of each part, sRGB; [3] 0: the file gives none */
	size_t part_count;
};

/* Reads the corners of all triangles of a file. The caller frees `at` with mem_free, also after a failure. */
enum status scene_mesh_import(const char *path, const char *told, struct mesh_corners *corners) FURROW_CHECKED;
/* The same for a file to be looked at, with its colours (scene_mesh_parts_load). The caller frees `parts` and `colours`, too. */
enum status scene_mesh_import_parts(const char *path, const char *told, struct mesh_corners *corners) FURROW_CHECKED;

/* --- scene_mesh.c --- */

/* Refuses corners that are not finite, too far out, or of too small a size: SCENE_MESH_METRES_*. */
enum status scene_mesh_check(const struct mesh_corners *corners, const char *told, double scale) FURROW_CHECKED;
/* Makes the mesh of checked corners: joins equal ones. Destroy it also after a failure. STATUS_INPUT: no triangle has an area. */
enum status scene_mesh_of(const struct mesh_corners *corners, const char *told, double scale, struct soil_mesh *mesh) FURROW_CHECKED;

/* Refuse a file that has more parts than its triangles may need; see scene_mesh_count.c. STATUS_INPUT: it has. */
enum status scene_mesh_count_obj(const char *bytes, size_t length, const char *told) FURROW_CHECKED;
enum status scene_mesh_count_stl(const char *bytes, size_t length, const char *told) FURROW_CHECKED;
enum status scene_mesh_count_dae(const char *bytes, size_t length, const char *told) FURROW_CHECKED;

#endif
