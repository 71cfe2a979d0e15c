/* Shared by the files objects*.c, which draw objects (bodies) and their shadows. */
#ifndef FURROW_RENDER_OBJECTS_H
#define FURROW_RENDER_OBJECTS_H

#include "render/internal.h"

/* --- objects_mesh.c, objects_file.c: a shape as triangles, in the axes of the object; pure --- */

/* A corner of a triangle, read by object.vert. `at`: metres. `look`: bits 0-29 hold the normal, 10 bits for each axis; bits
 * 30-31 hold the material. */
struct object_corner {
	float at[3];
	uint32_t look;
};
enum object_material { OBJECT_RUBBER, OBJECT_METAL, OBJECT_PAINT, OBJECT_DARK };
uint32_t render_object_look(const double normal[3], enum object_material material);

#define OBJECT_DETAILS 3
struct object_mesh {
	struct object_corner *corners;
	uint32_t *indices;
	uint32_t corner_count, index_count;
	size_t corner_room, index_room;
	/* first index of each detail, the finest first, and the end; an empty detail is drawn as the one before it */
	uint32_t first[OBJECT_DETAILS + 1];
	bool closed; /* the surface is closed, so back faces are never seen */
	bool failed; /* out of memory; render_object_mesh_make returns the failure */
};
/* Makes the triangles of a shape. A wheel is made at turn 0, with its grousers where deform computes them. */
enum status render_object_mesh_make(const struct soil_shape *shape, struct object_mesh *mesh) FURROW_CHECKED;
void render_object_mesh_finish(struct object_mesh *mesh);
/* Adds a corner and returns its number. */
uint32_t render_object_mesh_corner(struct object_mesh *mesh, const double at[3], uint32_t look);
void render_object_mesh_triangle(struct object_mesh *mesh, uint32_t a, uint32_t b, uint32_t c);
/* In objects_file.c: adds the triangles of a mesh file. Two triangles that meet at less than 40 degrees are shaded smoothly. */
void render_object_mesh_of_file(struct object_mesh *mesh, const struct soil_mesh *file);

/* --- objects_shadow.c --- */

/* Read by shaders/shadow.vert, std430. */
struct object_shadow {
	float to_own[3][4];    /* converts a point relative to the eye, in metres, to the object's axes */
	float form[4];         /* half the object's size along its axes; then its size as one number */
	float to_volume[3][4]; /* converts a point to the volume in which the shadow lies, -1 .. 1 on each axis */
	float kind[4];         /* [0]: 0 a box, 1 a cylinder around its y axis, 2 a ball */
};
/* Computes the shadow of an object. `at`: its centre, relative to the eye. Also gives a ball that contains the shadow's volume:
 * `middle` relative to the eye, and `radius`. Metres. */
void render_object_shadow_of(const struct soil_shape *shape, double axes[3][3], const double at[3], const double sun[3],
		      struct object_shadow *shadow, double middle[3], double *radius);

/* --- objects.c --- */

struct object_shape {
	const struct soil_shape *shape;
	struct gpu_buffer *corners, *indices;
	uint32_t first[OBJECT_DETAILS + 1];
	double bound; /* metres: radius of a ball around the object's centre that contains it */
	bool closed;
};

/* Read by shaders/object.vert, std430. */
struct object_posed {
	float axes[3][4];
	float size[4];  /* [0]: radius of a ball around it, m; [1]: its number */
	float paint[4]; /* colour; [3]: 0 the colours of its materials, 1 this one on all parts, 2 this one on all parts except metal and dark ones */
};

struct object_seen {
	uint32_t shape, detail;
	struct object_posed posed;
};

struct render_objects {
	const struct scene_object *objects; /* owned by the caller */
	size_t count;
	bool casts;
	struct object_shape *shapes; /* different shapes; several objects may share one */
	uint32_t *shape_of;   /* index into `shapes`, for each object */
	struct render_object *shown;
	size_t shown_count;
	struct object_seen *seen;    /* of the present picture; so are the next two */
	struct object_posed *posed;
	struct object_shadow *shadows;
	struct gpu_list *instances, *casters; /* casters and volume are NULL without shadows */
	struct gpu_buffer *volume;
};

#endif
