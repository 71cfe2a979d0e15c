/* Keeps the facets of shapes that were asked for. */
#include "soil/faces/facets.h"

#include <string.h>

static bool equal(double a, double b)
{
	return !(a < b) && !(a > b);
}

static bool same_mesh(const struct soil_mesh *a, const struct soil_mesh *b)
{
	return a->vertex_count == b->vertex_count && a->triangle_count == b->triangle_count &&
	       memcmp(a->triangles, b->triangles, a->triangle_count * sizeof *a->triangles) == 0 &&
	       memcmp(a->vertices, b->vertices, a->vertex_count * sizeof *a->vertices) == 0;
}

static bool is_of(const struct soil_facets_entry *e, const struct soil_shape *s, double size)
{
	const struct soil_shape *k = &e->shape;
	if (e->asked == 0 || k->kind != s->kind || !equal(e->size, size))
		return false;
	if (s->kind == SOIL_MESH)
		return same_mesh(&e->mesh, s->mesh);
	return equal(k->radius, s->radius) && equal(k->width, s->width) && equal(k->length, s->length) && equal(k->size[0], s->size[0]) &&
	       equal(k->size[1], s->size[1]) && equal(k->size[2], s->size[2]);
}

static void empty(struct soil_facets_entry *e)
{
	soil_facets_finish(&e->facets);
	mem_free(e->mesh.vertices);
	*e = (struct soil_facets_entry){0};
}

static enum status make(struct soil_facets_entry *e, const struct soil_shape *shape, double size)
{
	TRY(soil_facets_of(shape, size, &e->facets));
	e->shape = *shape;
	e->shape.mesh = NULL;
	e->size = size;
	if (shape->kind != SOIL_MESH)
		return STATUS_OK;
	const struct soil_mesh *mesh = shape->mesh;
	TRY(mem_make(&e->mesh.vertices, (size_t)mesh->vertex_count + mesh->triangle_count, sizeof *mesh->vertices, "a mesh"));
	e->mesh.triangles = (uint32_t(*)[3])(e->mesh.vertices + mesh->vertex_count);
	e->mesh.vertex_count = mesh->vertex_count;
	e->mesh.triangle_count = mesh->triangle_count;
	memcpy(e->mesh.vertices, mesh->vertices, mesh->vertex_count * sizeof *mesh->vertices);
	memcpy(e->mesh.triangles, mesh->triangles, mesh->triangle_count * sizeof *mesh->triangles);
	return STATUS_OK;
}

enum status soil_facets_kept(struct soil_facets_cache *cache, const struct soil_shape *shape, double size, const struct soil_facets **out)
{
	struct soil_facets_entry *oldest = &cache->kept[0], *found = NULL;
	*out = NULL;
	for (size_t i = 0; i < SOIL_FACETS_KEPT && found == NULL; i++) {
		struct soil_facets_entry *e = &cache->kept[i];
		if (is_of(e, shape, size))
			found = e;
		else if (e->asked < oldest->asked)
			oldest = e;
	}
	if (found == NULL) {
		empty(oldest);
		const enum status status = make(oldest, shape, size);
		if (status != STATUS_OK) {
			empty(oldest);
			return status;
		}
		found = oldest;
	}
	found->asked = ++cache->asked;
	*out = &found->facets;
	return STATUS_OK;
}

void soil_facets_cache_finish(struct soil_facets_cache *cache)
{
	for (size_t i = 0; i < SOIL_FACETS_KEPT; i++)
		empty(&cache->kept[i]);
	cache->asked = 0;
}

size_t soil_facets_cache_bytes(const struct soil_facets_cache *cache)
{
	size_t bytes = 0;
	for (size_t i = 0; i < SOIL_FACETS_KEPT; i++) {
		const struct soil_facets_entry *e = &cache->kept[i];
		bytes += soil_facets_bytes(&e->facets) + ((size_t)e->mesh.vertex_count + e->mesh.triangle_count) * sizeof *e->mesh.vertices;
	}
	return bytes;
}
