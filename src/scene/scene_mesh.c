/*
 * Makes the mesh of an object from the triangles of a mesh file. It scales and checks them, removes triangles without area, and
 * joins equal vertices.
 *
 * Vertices are in the order in which the triangles first use them. So the same file always makes the same mesh.
 */
#include "scene/scene_mesh.h"

#include <math.h>
#include <string.h>
#include <strings.h>

#include "scene/scene.h"
#include "scene/scene_mesh_import.h"

/* Which vertex is at a place: open addressing, at most half full. Not a key_set: its keys have 64 bits and a place has 96. With
 * two of those, one for x and y and one for z, a mesh of a million triangles took up to twice as long. */
struct places {
	uint32_t *vertex; /* + 1; 0: free */
	size_t mask;
};

static enum status places_create(struct places *places, size_t corners)
{
	size_t room = 16;
	while (room < 2 * corners)
		room *= 2;
	*places = (struct places){mem_calloc(room, sizeof *places->vertex), room - 1};
	return places->vertex != NULL ? STATUS_OK : fail_memory("a mesh");
}

static size_t hash_of(const float at[3])
{
	uint64_t hash = 0;
	for (int k = 0; k < 3; k++) {
		uint32_t word;
		memcpy(&word, &at[k], sizeof word);
		hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
		hash ^= hash >> 29;
	}
	return (size_t)hash;
}

static uint32_t vertex_at(struct places *places, struct soil_mesh *mesh, const float at[3])
{
	size_t i = hash_of(at) & places->mask;
	for (; places->vertex[i] != 0; i = (i + 1) & places->mask)
		if (memcmp(mesh->vertices[places->vertex[i] - 1], at, sizeof mesh->vertices[0]) == 0)
			return places->vertex[i] - 1;
	memcpy(mesh->vertices[mesh->vertex_count], at, sizeof mesh->vertices[0]);
	places->vertex[i] = ++mesh->vertex_count;
	return mesh->vertex_count - 1;
}

static bool has_area(float corners[3][3])
{
	double a[3], b[3], area = 0;
	for (int k = 0; k < 3; k++) {
		a[k] = (double)corners[1][k] - corners[0][k];
		b[k] = (double)corners[2][k] - corners[0][k];
	}
	for (int k = 0; k < 3; k++)
		area += fabs(a[k] * b[(k + 1) % 3] - a[(k + 1) % 3] * b[k]);
	return area > 0;
}

enum status scene_mesh_check(const struct mesh_corners *corners, const char *told, double scale)
{
	double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, size = 0;
	for (size_t i = 0; i < 3 * corners->triangles; i++)
		for (int k = 0; k < 3; k++) {
			double v = corners->at[i][k] * scale;
			/* Far from its own origin, a mesh has no digits left for its shape. */
			if (!(fabs(v) <= SCENE_MESH_METRES_MAX))
				return fail_with(STATUS_INPUT, "%s: triangle %zu has a corner that is %s; allowed: within %g m of "
							       "the origin, once scaled",
						 told, i / 3, isfinite(v) ? "too far out" : "not finite", SCENE_MESH_METRES_MAX);
			low[k] = fmin(low[k], v);
			high[k] = fmax(high[k], v);
		}
	for (int k = 0; k < 3; k++)
		size = fmax(size, high[k] - low[k]);
	if (size < SCENE_MESH_METRES_MIN || size > SCENE_MESH_METRES_MAX)
		return fail_with(STATUS_INPUT, "%s: it is %g m long; allowed: %g to %g m (give a scale)", told, size,
				 SCENE_MESH_METRES_MIN, SCENE_MESH_METRES_MAX);
	return STATUS_OK;
}

static void fill(struct soil_mesh *mesh, struct places *places, const struct mesh_corners *corners, double scale)
{
	for (size_t t = 0; t < corners->triangles; t++) {
		float at[3][3];
		for (int c = 0; c < 3; c++)
			for (int k = 0; k < 3; k++)
				at[c][k] = (float)(corners->at[3 * t + (size_t)c][k] * scale) + 0.0f; /* -0 is 0 */
		if (!has_area(at))
			continue;
		uint32_t *triangle = mesh->triangles[mesh->triangle_count++];
		for (int c = 0; c < 3; c++)
			triangle[c] = vertex_at(places, mesh, at[c]);
	}
	for (int k = 0; k < 3; k++) {
		mesh->low[k] = INFINITY;
		mesh->high[k] = -INFINITY;
		for (uint32_t v = 0; v < mesh->vertex_count; v++) {
			mesh->low[k] = fmin(mesh->low[k], mesh->vertices[v][k]);
			mesh->high[k] = fmax(mesh->high[k], mesh->vertices[v][k]);
		}
	}
}

/* Gives back memory. Room was made for every triangle and three corners each, but triangles without area are left out and equal
 * corners are shared. */
static enum status trim(struct soil_mesh *mesh)
{
	TRY(mem_resize(&mesh->vertices, mesh->vertex_count, sizeof *mesh->vertices, "a mesh"));
	return mem_resize(&mesh->triangles, mesh->triangle_count, sizeof *mesh->triangles, "a mesh");
}

enum status scene_mesh_of(const struct mesh_corners *corners, const char *told, double scale, struct soil_mesh *mesh)
{
	struct places places = {NULL, 0};
	mesh->vertices = mem_alloc(3 * corners->triangles, sizeof *mesh->vertices);
	mesh->triangles = mem_alloc(corners->triangles, sizeof *mesh->triangles);
	TRY_MEM(mesh->vertices != NULL && mesh->triangles != NULL, "a mesh");
	TRY(places_create(&places, 3 * corners->triangles));
	fill(mesh, &places, corners, scale);
	mem_free(places.vertex);
	if (mesh->triangle_count == 0)
		return fail_with(STATUS_INPUT, "%s: none of its triangles has an area; needed: a surface", told);
	return trim(mesh);
}

enum status scene_mesh_load(const char *path, const char *told, double scale, struct soil_mesh **out)
{
	struct mesh_corners corners = {.at = NULL};
	struct soil_mesh *mesh = mem_calloc(1, sizeof *mesh);
	TRY_MEM(mesh, "a mesh");
	enum status status;
	TRY_OR(failed, scene_mesh_import(path, told, &corners));
	TRY_OR(failed, scene_mesh_check(&corners, told, scale));
	TRY_OR(failed, scene_mesh_of(&corners, told, scale, mesh));
	mem_free(corners.at);
	*out = mesh;
	return STATUS_OK;
failed:
	mem_free(corners.at);
	scene_mesh_destroy(mesh);
	return status;
}

void scene_mesh_destroy(struct soil_mesh *mesh)
{
	if (mesh == NULL)
		return;
	mem_free_all(mesh->vertices, mesh->triangles, mesh);
}

enum status scene_mesh_read(const char *path, const char *told, double scale, struct soil_mesh **out)
{
	const char *dot = strrchr(path, '.');
	TRY(scene_mesh_load(path, told, scale, out));
	if (strcasecmp(dot, ".gltf") != 0 && strcasecmp(dot, ".glb") != 0) /* what was read has an ending */
		return STATUS_OK;
	struct soil_mesh *mesh = *out;
	for (uint32_t i = 0; i < mesh->vertex_count; i++) { /* back from x forward, y left, z up */
		float *at = mesh->vertices[i];
		memcpy(at, (const float[]){at[1], at[2], at[0]}, sizeof mesh->vertices[i]);
	}
	memcpy(mesh->low, (const double[]){mesh->low[1], mesh->low[2], mesh->low[0]}, sizeof mesh->low);
	memcpy(mesh->high, (const double[]){mesh->high[1], mesh->high[2], mesh->high[0]}, sizeof mesh->high);
	return STATUS_OK;
}
