/* Reads the surface of an object from a mesh file: OBJ, STL, DAE, glTF 2 (.gltf, .glb). */
#ifndef FURROW_SCENE_MESH_H
#define FURROW_SCENE_MESH_H

#include "scene/scene.h"
#include "soil/soil.h"

#define SCENE_MESH_BYTES (64u << 20) /* most bytes of the file together with the files it names */
#define SCENE_MESH_TRIANGLES 1000000u
#define SCENE_MESH_METRES_MIN 0.001 /* range of the mesh's longest side after scaling */
#define SCENE_MESH_METRES_MAX 1000.0

/*
 * Reads the triangles of a mesh file. The file's unit times `scale` is metres. Axes of OBJ, STL and DAE are x forward, y left, z up. A DAE's own unit counts, and its up axis does not.
 * glTF has other axes, which are converted: its front (z) to x, its left (x) to y, its up (y) to z. Transforms of nodes are
 * applied. Points, lines and triangles without area are left out. Equal vertices are shared. The order of triangles is that of
 * the file.
 *
 * The file is untrusted. STATUS_INPUT, with a message that begins with `told` (the place in the scene that names the file):
 * - it is missing, larger than SCENE_MESH_BYTES, or not a mesh;
 * - it has no triangle, or more than SCENE_MESH_TRIANGLES;
 * - a vertex is not finite, or its size is beyond SCENE_MESH_METRES_*;
 * - the build has no mesh reader.
 *
 * A glTF may name buffers in its own folder. No other file is opened. Any thread may call this; files are read one at a time.
 */
enum status scene_mesh_load(const char *path, const char *told, double scale, struct soil_mesh **out)
	FURROW_CHECKED;

#endif
