/* Objects in the picture: what objects*.c share. */
#ifndef FURROW_RENDER_OBJECTS_H
#define FURROW_RENDER_OBJECTS_H

#include "render/internal.h"

/* --- objects_mesh.c, objects_file.c: a shape as triangles, in its own axes; pure --- */

/* As the vertex shader reads it. `at`: metres. `look`: the normal, 10 bits for each axis from bit 0 on, and the material from bit 30
 * on. */
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
	uint32_t corner_room, index_room;
	uint32_t first[OBJECT_DETAILS + 1]; /* of each detail, the finest first, and the end; an empty detail uses the one before it */
	bool closed; /* only fronts of triangles are seen */
	bool failed; /* out of memory; render_object_mesh_make returns it */
};
/* A wheel has its grousers where deform has them at turn 0. */
enum status render_object_mesh_make(const struct deform_shape *shape, struct object_mesh *mesh) FURROW_CHECKED;
void render_object_mesh_finish(struct object_mesh *mesh);
/* Returns the number of the new corner. */
uint32_t render_object_mesh_corner(struct object_mesh *mesh, const double at[3], uint32_t look);
void render_object_mesh_triangle(struct object_mesh *mesh, uint32_t a, uint32_t b, uint32_t c);
/* objects_file.c: adds a file's triangles. They look smooth where they meet at less than 40 degrees. */
void render_object_mesh_of_file(struct object_mesh *mesh, const struct deform_mesh *file);

/* --- objects_shadow.c --- */

/* shaders/shadow.vert's, std430. */
struct object_shadow {
	float to_own[3][4];    /* from a place relative to the eye, metres, to the form's own axes */
	float form[4];         /* half its size along these axes; its size as one number */
	float to_volume[3][4]; /* to the volume that is shaded, -1 .. 1 each way */
	float kind[4];         /* 0 a box, 1 a cylinder about its y, 2 a ball */
};
/* Fills the shadow of an object whose centre is `at`, from the eye. Also finds the ball around the volume: `middle` from the eye,
 * and `radius`. Metres. */
void render_object_shadow_of(const struct deform_shape *shape, double axes[3][3], const double at[3], const double sun[3],
		      struct object_shadow *shadow, double middle[3], double *radius);

/* --- objects.c --- */

struct object_shape {
	const struct deform_shape *shape;
	struct gpu_buffer *corners, *indices;
	uint32_t first[OBJECT_DETAILS + 1];
	double bound; /* metres: radius of a ball about its centre */
	bool closed;
};

/* shaders/object.vert's, std430. */
struct object_posed {
	float axes[3][4];
	float size[4];
};

struct object_seen {
	uint32_t shape, detail;
	struct object_posed posed;
};

struct render_objects {
	const struct scene_object *objects; /* the caller's */
	size_t count;
	bool casts;
	struct object_shape *shapes; /* distinct ones */
	uint32_t *shape_of;   /* by object */
	struct render_object *shown;
	size_t shown_count;
	struct object_seen *seen;    /* of the present picture, as these: */
	struct object_posed *posed;
	struct object_shadow *shadows;
	struct gpu_buffer *instances, *casters, *volume; /* the latter two NULL without shadows */
	struct gpu_target *over; /* the picture's colour alone */
};

#endif
