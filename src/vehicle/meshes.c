/* Triangles of a model's meshes. */
#include <math.h>

#include "vehicle/internal.h"

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

enum status vehicle_make_mesh(const mjModel *model, int geom, struct soil_mesh **out)
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

void vehicle_free_mesh(struct soil_mesh *mesh)
{
	if (mesh == NULL)
		return;
	mem_free_all(mesh->vertices, mesh->triangles, mesh);
}
