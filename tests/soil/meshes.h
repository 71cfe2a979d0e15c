/* Meshes of simple bodies, for tests that compare a mesh with the shape that it is made of. Free them with mesh_free. */
#ifndef FURROW_TESTS_SOIL_MESHES_H
#define FURROW_TESTS_SOIL_MESHES_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "soil/soil.h"

static inline void mesh_free(struct soil_mesh *mesh)
{
	free(mesh->vertices);
	free(mesh->triangles);
}

static inline struct soil_mesh mesh_with(uint32_t vertices, uint32_t triangles)
{
	struct soil_mesh mesh = {.vertex_count = vertices, .triangle_count = triangles};
	mesh.vertices = calloc(vertices, sizeof *mesh.vertices);
	mesh.triangles = calloc(triangles, sizeof *mesh.triangles);
	if (mesh.vertices == NULL || mesh.triangles == NULL)
		abort();
	return mesh;
}

static inline void mesh_bounds(struct soil_mesh *mesh)
{
	for (int k = 0; k < 3; k++) {
		mesh->low[k] = mesh->high[k] = (double)mesh->vertices[0][k];
		for (uint32_t i = 1; i < mesh->vertex_count; i++) {
			mesh->low[k] = fmin(mesh->low[k], (double)mesh->vertices[i][k]);
			mesh->high[k] = fmax(mesh->high[k], (double)mesh->vertices[i][k]);
		}
	}
}

static inline void mesh_put(struct soil_mesh *mesh, uint32_t t, uint32_t a, uint32_t b, uint32_t c)
{
	mesh->triangles[t][0] = a;
	mesh->triangles[t][1] = b;
	mesh->triangles[t][2] = c;
}

/* A closed drum about its own y axis: a prism of the circle's area. */
static inline struct soil_mesh mesh_drum(uint32_t facets, double radius, double width)
{
	struct soil_mesh mesh = mesh_with(2 * facets + 2, 4 * facets);
	const double step = 2 * M_PI / facets, r = radius * sqrt(step / sin(step));
	for (uint32_t i = 0; i < facets; i++)
		for (uint32_t side = 0; side < 2; side++) {
			float *v = mesh.vertices[2 * i + side];
			v[0] = (float)(r * cos((i + 0.5) * step));
			v[1] = (float)(side == 0 ? -width / 2 : width / 2);
			v[2] = (float)(r * sin((i + 0.5) * step));
		}
	mesh.vertices[2 * facets][1] = (float)(-width / 2);
	mesh.vertices[2 * facets + 1][1] = (float)(width / 2);
	for (uint32_t i = 0; i < facets; i++) {
		const uint32_t a = 2 * i, c = 2 * ((i + 1) % facets);
		mesh_put(&mesh, 4 * i, a, a + 1, c);
		mesh_put(&mesh, 4 * i + 1, a + 1, c + 1, c);
		mesh_put(&mesh, 4 * i + 2, 2 * facets, a, c);
		mesh_put(&mesh, 4 * i + 3, 2 * facets + 1, c + 1, a + 1);
	}
	mesh_bounds(&mesh);
	return mesh;
}

/* A block of 12 triangles. */
static inline struct soil_mesh mesh_block(double x, double y, double z)
{
	static const uint32_t sides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
	struct soil_mesh mesh = mesh_with(8, 12);
	for (uint32_t i = 0; i < 8; i++) {
		mesh.vertices[i][0] = (float)((i & 1) != 0 ? x / 2 : -x / 2);
		mesh.vertices[i][1] = (float)((i & 2) != 0 ? y / 2 : -y / 2);
		mesh.vertices[i][2] = (float)((i & 4) != 0 ? z / 2 : -z / 2);
	}
	for (uint32_t i = 0; i < 6; i++) {
		mesh_put(&mesh, 2 * i, sides[i][0], sides[i][1], sides[i][2]);
		mesh_put(&mesh, 2 * i + 1, sides[i][0], sides[i][2], sides[i][3]);
	}
	mesh_bounds(&mesh);
	return mesh;
}

/* A ball of rings about its own z axis, drawn out along that axis by `straight`: a capsule. 0: a sphere. */
static inline struct soil_mesh mesh_pill(uint32_t around, uint32_t rings, double radius, double straight)
{
	struct soil_mesh mesh = mesh_with(2 * rings * around + 2, 4 * rings * around);
	uint32_t t = 0;
	for (uint32_t ring = 0; ring < 2 * rings; ring++)
		for (uint32_t i = 0; i < around; i++) {
			const bool upper = ring >= rings;
			const double rise = (upper ? ring - rings : rings - 1 - ring) * (M_PI / 2) / rings, yaw = i * 2 * M_PI / around, sign = upper ? 1 : -1;
			float *v = mesh.vertices[ring * around + i];
			v[0] = (float)(radius * cos(rise) * cos(yaw));
			v[1] = (float)(radius * cos(rise) * sin(yaw));
			v[2] = (float)(sign * (radius * sin(rise) + straight / 2));
		}
	mesh.vertices[2 * rings * around][2] = (float)(-radius - straight / 2);
	mesh.vertices[2 * rings * around + 1][2] = (float)(radius + straight / 2);
	for (uint32_t i = 0; i < around; i++) {
		const uint32_t j = (i + 1) % around, top = (2 * rings - 1) * around;
		for (uint32_t ring = 0; ring + 1 < 2 * rings; ring++) {
			const uint32_t a = ring * around;
			mesh_put(&mesh, t++, a + i, a + j, a + around + i);
			mesh_put(&mesh, t++, a + j, a + around + j, a + around + i);
		}
		mesh_put(&mesh, t++, 2 * rings * around, j, i);
		mesh_put(&mesh, t++, 2 * rings * around + 1, top + i, top + j);
	}
	mesh.triangle_count = t;
	mesh_bounds(&mesh);
	return mesh;
}

#endif
