/* Objects' surfaces from files: OBJ, STL, glTF 2 (.gltf, .glb). */
#ifndef FURROW_SCENE_MESH_H
#define FURROW_SCENE_MESH_H

#include "deform/deform.h"

#define SCENE_MESH_BYTES (64u << 20) /* the file, and all that it names beside it */
#define SCENE_MESH_TRIANGLES 1000000u
#define SCENE_MESH_METRES_MIN 0.001 /* its longest side once scaled */
#define SCENE_MESH_METRES_MAX 1000.0

/*
 * The triangles of a file whose units, times `scale`, are metres. OBJ and STL are taken as they are: x
 * forward, y left, z up. glTF has axes of its own, which become these: its front (z) is forward, its left (x)
 * left, its up (y) up. Nodes are applied; points, lines and triangles without area are left out;
 * equal vertices are one. The order is the file's.
 *
 * The file is untrusted. STATUS_INPUT, with a message that begins with `told` (the place in the scene that names the file):
 * - it is missing, larger than SCENE_MESH_BYTES, or not a mesh;
 * - it has no triangle, or more than SCENE_MESH_TRIANGLES;
 * - a vertex is not finite, or its size is beyond SCENE_MESH_METRES_*;
 * - the build has no mesh reader.
 *
 * A glTF may name buffers in its own folder, and nothing else is opened. Any thread; files are read one at a time.
 */
enum status scene_mesh_load(const char *path, const char *told, double scale, struct deform_mesh **out)
	FURROW_CHECKED;
void scene_mesh_destroy(struct deform_mesh *mesh); /* takes NULL */

#endif
