/* Triangles of a model's geoms: of its meshes, and of round shapes, whose corners lie on them. */
#include <math.h>
#include <string.h>

#include "vehicle/internal.h"

#define ROUND 24 /* corners around */
#define RINGS 6  /* rings of corners from a round shape's middle to its end */

/* A ring of corners about the z axis. */
struct ring {
	double radius[2], height; /* along x and y */
};

static enum status make(size_t corners, size_t faces, struct soil_mesh **out)
{
	struct soil_mesh *mesh = *out = mem_calloc(1, sizeof *mesh);
	TRY_MEM(mesh, "a mesh");
	*mesh = (struct soil_mesh){mem_calloc(corners + 1, sizeof *mesh->vertices), mem_calloc(faces + 1, sizeof *mesh->triangles), (uint32_t)corners,
				   (uint32_t)faces, {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
	return mesh->vertices != NULL && mesh->triangles != NULL ? STATUS_OK : fail_memory("a mesh");
}

static void put_corner(struct soil_mesh *mesh, size_t corner, const double at[3])
{
	for (int k = 0; k < 3; k++) {
		mesh->vertices[corner][k] = (float)at[k];
		mesh->low[k] = fmin(mesh->low[k], at[k]);
		mesh->high[k] = fmax(mesh->high[k], at[k]);
	}
}

static enum status of_file(const mjModel *model, int geom, struct soil_mesh **out)
{
	const int mesh = model->geom_dataid[geom];
	const size_t corners = (size_t)model->mesh_vertnum[mesh], faces = (size_t)model->mesh_facenum[mesh];
	const float *from = &model->mesh_vert[3 * model->mesh_vertadr[mesh]];
	const int *face = &model->mesh_face[3 * model->mesh_faceadr[mesh]];
	TRY(make(corners, faces, out));
	for (size_t i = 0; i < corners; i++)
		put_corner(*out, i, (const double[]){(double)from[3 * i], (double)from[3 * i + 1], (double)from[3 * i + 2]});
	for (size_t i = 0; i < faces; i++)
		for (int k = 0; k < 3; k++)
			(*out)->triangles[i][k] = (uint32_t)face[3 * i + (size_t)k];
	return STATUS_OK;
}

/* Rings from below to above. The first and the last may be points. */
static enum status of_rings(const struct ring *rings, size_t count, struct soil_mesh **out)
{
	TRY(make(count * ROUND + 2, 2 * ROUND * count, out));
	struct soil_mesh *mesh = *out;
	size_t face = 0;
	for (size_t r = 0; r < count; r++)
		for (size_t i = 0; i < ROUND; i++) {
			const double angle = 2 * M_PI * (double)i / ROUND;
			put_corner(mesh, r * ROUND + i, (const double[]){rings[r].radius[0] * cos(angle), rings[r].radius[1] * sin(angle), rings[r].height});
		}
	put_corner(mesh, count * ROUND, (const double[]){0, 0, rings[0].height});
	put_corner(mesh, count * ROUND + 1, (const double[]){0, 0, rings[count - 1].height});
	for (uint32_t i = 0; i < ROUND; i++) {
		const uint32_t next = (i + 1) % ROUND, top = (uint32_t)(count - 1) * ROUND;
		memcpy(mesh->triangles[face++], (const uint32_t[]){(uint32_t)count * ROUND, next, i}, sizeof *mesh->triangles);
		memcpy(mesh->triangles[face++], (const uint32_t[]){(uint32_t)count * ROUND + 1, top + i, top + next}, sizeof *mesh->triangles);
		for (uint32_t r = 0; r + 1 < count; r++) {
			const uint32_t a = r * ROUND + i, b = r * ROUND + next;
			memcpy(mesh->triangles[face++], (const uint32_t[]){a, b, b + ROUND}, sizeof *mesh->triangles);
			memcpy(mesh->triangles[face++], (const uint32_t[]){a, b + ROUND, a + ROUND}, sizeof *mesh->triangles);
		}
	}
	return STATUS_OK;
}

enum status vehicle_make_mesh(const mjModel *model, int geom, struct soil_mesh **out)
{
	const double *size = &model->geom_size[3 * geom];
	struct ring rings[2 * RINGS + 2];
	size_t count = 0;
	*out = NULL;
	if (model->geom_type[geom] == mjGEOM_MESH)
		return of_file(model, geom, out);
	if (model->geom_type[geom] == mjGEOM_CYLINDER) {
		rings[count++] = (struct ring){{size[0], size[0]}, -size[1]};
		rings[count++] = (struct ring){{size[0], size[0]}, size[1]};
		return of_rings(rings, count, out);
	}
	/* A capsule and an ellipsoid: a ball that is cut in two and drawn apart, or stretched. */
	const bool capsule = model->geom_type[geom] == mjGEOM_CAPSULE;
	for (int half = 0; half < 2; half++)
		for (int i = 0; i <= RINGS; i++) {
			const double angle = M_PI / 2 * (half == 0 ? (double)i / RINGS - 1 : (double)i / RINGS), apart = capsule ? size[1] : 0;
			const double high = capsule ? size[0] : size[2];
			rings[count++] = (struct ring){{size[0] * cos(angle), (capsule ? size[0] : size[1]) * cos(angle)},
						       high * sin(angle) + (half == 0 ? -apart : apart)};
		}
	return of_rings(rings, count, out);
}

void vehicle_free_mesh(struct soil_mesh *mesh)
{
	if (mesh == NULL)
		return;
	mem_free_all(mesh->vertices, mesh->triangles, mesh);
}
