/*
 * Used inside scene only. A glTF 2 file, of which only nodes and the triangles of their meshes are read.
 *
 * The file is untrusted. Each number in it is checked before it is used: indices, lengths and places against what is there. The
 * time and the memory that a file takes are bounded by its bytes and by SCENE_MESH_TRIANGLES.
 */
#ifndef FURROW_SCENE_GLTF_H
#define FURROW_SCENE_GLTF_H

#include <cJSON.h>
#include <stdint.h>

#include "scene/scene_mesh_import.h"

enum scene_gltf_list { SCENE_GLTF_ACCESSORS, SCENE_GLTF_VIEWS, SCENE_GLTF_BUFFERS, SCENE_GLTF_MESHES, SCENE_GLTF_NODES, SCENE_GLTF_SCENES, SCENE_GLTF_LISTS };

struct scene_gltf_bytes {
	const uint8_t *at; /* NULL: not read yet */
	size_t length;
	char *owned; /* freed with mem_free; NULL: they are part of the file */
};

struct scene_gltf {
	const char *path, *told; /* the file, and how messages name it */
	cJSON *root;
	struct scene_gltf_bytes chunk; /* the bytes behind the text in a .glb */
	const cJSON **lists[SCENE_GLTF_LISTS];
	size_t counts[SCENE_GLTF_LISTS];
	struct scene_gltf_bytes *buffers;
	size_t left; /* bytes that other files may still have */
};

/* Reads the text of the file and finds its lists. `bytes` must outlive the struct. scene_gltf_close is due also after a failure. */
enum status scene_gltf_open(struct scene_gltf *gltf, const char *path, const char *told, bool packed, const char *bytes, size_t length) FURROW_CHECKED;
void scene_gltf_close(struct scene_gltf *gltf);
/* Gives the bytes of a buffer view from `offset` on. STATUS_INPUT: it does not have `length` bytes there. *stride: bytes from one
 * element to the next; `element` if the view says none. */
enum status scene_gltf_view(struct scene_gltf *gltf, size_t view, size_t offset, size_t count, size_t element, const uint8_t **at, size_t *stride)
	FURROW_CHECKED;
/* Reads a whole number from 0 to below `end`. Without the key *out is `absent`. STATUS_INPUT: it is none; the message names the key. */
enum status scene_gltf_whole(const struct scene_gltf *gltf, const cJSON *object, const char *key, size_t absent, size_t end, size_t *out) FURROW_CHECKED;
enum status scene_gltf_bad(const struct scene_gltf *gltf, const char *format, ...) FURROW_PRINTF(2, 3);

/* The corners of all triangles that the file's scene shows. They are in the file's axes. */
enum status scene_gltf_triangles(struct scene_gltf *gltf, struct mesh_corners *corners) FURROW_CHECKED;

#endif
