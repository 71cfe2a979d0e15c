/*
 * Makes the mesh to draw from the triangles of a mesh file. Two triangles that meet at a small angle look smooth; at a larger
 * angle they show an edge. If more than MEET triangles share a vertex, each triangle keeps its own normal there. So the work is
 * bounded for any file.
 */
#include <math.h>

#include "render/objects.h"

#define MEET 32
#define SMOOTH 0.766 /* the cosine of 40 degrees */

/* Triangles by vertex: of[begin[i]] to of[begin[i + 1] - 1] are those of vertex i. */
struct meeting {
	uint32_t *begin, *of;
	float (*normals)[3]; /* of triangles; the length is twice the area */
};

static void normal_of(const struct soil_mesh *file, uint32_t triangle, float normal[3])
{
	const uint32_t *t = file->triangles[triangle];
	double u[3], v[3];
	for (int k = 0; k < 3; k++) {
		u[k] = (double)file->vertices[t[1]][k] - file->vertices[t[0]][k];
		v[k] = (double)file->vertices[t[2]][k] - file->vertices[t[0]][k];
	}
	for (int k = 0; k < 3; k++)
		normal[k] = (float)(u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
}

static double dot(const float a[3], const float b[3])
{
	return (double)a[0] * b[0] + (double)a[1] * b[1] + (double)a[2] * b[2];
}

static bool meet(const struct soil_mesh *file, struct meeting *meeting)
{
	size_t triangles = file->triangle_count;
	meeting->begin = mem_calloc((size_t)file->vertex_count + 2, sizeof *meeting->begin);
	meeting->of = mem_alloc(3 * triangles, sizeof *meeting->of);
	meeting->normals = mem_alloc(triangles, sizeof *meeting->normals);
	if (meeting->begin == NULL || meeting->of == NULL || meeting->normals == NULL)
		return false;
	/* Count at index + 2, sum, then fill by index + 1. Afterwards begin[i] is right for each vertex i. */
	for (uint32_t i = 0; i < triangles; i++) {
		normal_of(file, i, meeting->normals[i]);
		for (int k = 0; k < 3; k++)
			meeting->begin[file->triangles[i][k] + 2]++;
	}
	for (uint32_t i = 1; i < file->vertex_count + 2; i++)
		meeting->begin[i] += meeting->begin[i - 1];
	for (uint32_t i = 0; i < triangles; i++)
		for (int k = 0; k < 3; k++)
			meeting->of[meeting->begin[file->triangles[i][k] + 1]++] = i;
	return true;
}

/* Sums the normals around the vertex that are at a small angle to this triangle's. */
static void smooth(const struct meeting *meeting, uint32_t vertex, uint32_t triangle, double normal[3])
{
	const float *own = meeting->normals[triangle];
	uint32_t begin = meeting->begin[vertex], end = meeting->begin[vertex + 1];
	for (int k = 0; k < 3; k++)
		normal[k] = own[k];
	if (end - begin > MEET)
		return;
	for (uint32_t i = begin; i < end; i++) {
		const float *other = meeting->normals[meeting->of[i]];
		if (meeting->of[i] == triangle || dot(own, other) < SMOOTH * sqrt(dot(own, own) * dot(other, other)))
			continue;
		for (int k = 0; k < 3; k++)
			normal[k] += other[k];
	}
}

void render_object_mesh_of_file(struct object_mesh *mesh, const struct soil_mesh *file)
{
	struct meeting meeting = {NULL, NULL, NULL};
	/* For each vertex of the file: the last corner that was made there. The next triangle uses this corner again if its normal
	 * there is the same. */
	uint32_t *last = mem_alloc(file->vertex_count, sizeof *last);
	if (last == NULL || !meet(file, &meeting))
		mesh->failed = true;
	for (uint32_t i = 0; !mesh->failed && i < file->vertex_count; i++)
		last[i] = UINT32_MAX;
	for (uint32_t i = 0; !mesh->failed && i < file->triangle_count; i++) {
		uint32_t corners[3];
		for (int k = 0; k < 3; k++) {
			uint32_t vertex = file->triangles[i][k];
			double normal[3], at[3];
			smooth(&meeting, vertex, i, normal);
			uint32_t look = render_object_look(normal, OBJECT_PAINT);
			for (int c = 0; c < 3; c++)
				at[c] = file->vertices[vertex][c];
			if (last[vertex] == UINT32_MAX || mesh->corners[last[vertex]].look != look)
				last[vertex] = render_object_mesh_corner(mesh, at, look);
			corners[k] = last[vertex];
		}
		render_object_mesh_triangle(mesh, corners[0], corners[1], corners[2]);
	}
	mem_free_all(last, meeting.begin, meeting.of, meeting.normals);
}
