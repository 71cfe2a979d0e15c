/* Makes the surface of a mesh: see surface.h. */
#include "soil/law/surface.h"

#include <string.h>

#include "soil/law/pieces.h"

#define NONE UINT32_MAX

/* What is needed while a surface is made. */
struct making {
	uint32_t *same;          /* the surface's vertex of each of the mesh */
	uint32_t *table;         /* of hashes */
	uint32_t table_mask;
	uint32_t *stack;
	uint8_t *known;          /* 1: a triangle is reached */
	void *memory;
};

static uint32_t mixed(uint32_t a, uint32_t b, uint32_t c)
{
	uint64_t h = (uint64_t)a * 0x9e3779b97f4a7c15u;
	h = (h ^ (h >> 29) ^ b) * 0xbf58476d1ce4e5b9u;
	h = (h ^ (h >> 32) ^ c) * 0x94d049bb133111ebu;
	return (uint32_t)(h >> 32);
}

static uint32_t word_of(float v)
{
	const float whole = v + 0.0f; /* no negative zero */
	uint32_t word;
	memcpy(&word, &whole, sizeof word);
	return word;
}

/* Gives vertices in one place one number. */
static void weld(const struct soil_mesh *mesh, struct making *making, struct soil_surface *s)
{
	memset(making->table, 0xff, ((size_t)making->table_mask + 1) * sizeof *making->table);
	for (uint32_t i = 0; i < mesh->vertex_count; i++) {
		const float *v = mesh->vertices[i];
		uint32_t at = mixed(word_of(v[0]), word_of(v[1]), word_of(v[2])) & making->table_mask;
		for (; making->table[at] != NONE; at = (at + 1) & making->table_mask) {
			const uint32_t other = making->table[at];
			if (!(s->x[other] < v[0] || s->x[other] > v[0] || s->y[other] < v[1] || s->y[other] > v[1] || s->z[other] < v[2] || s->z[other] > v[2]))
				break;
		}
		if (making->table[at] == NONE) {
			making->table[at] = s->vertex_count;
			s->x[s->vertex_count] = v[0];
			s->y[s->vertex_count] = v[1];
			s->z[s->vertex_count++] = v[2];
		}
		making->same[i] = making->table[at];
	}
	for (uint32_t t = 0; t < mesh->triangle_count; t++) {
		uint32_t c[3];
		for (int k = 0; k < 3; k++)
			c[k] = making->same[mesh->triangles[t][k]];
		if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0])
			continue;
		memcpy(s->corners[s->triangle_count++], c, sizeof c);
	}
}

/* Pairs the triangles at each edge. Returns false if an edge has one triangle, or more than two. */
static bool pair(struct making *making, struct soil_surface *s)
{
	memset(making->table, 0xff, ((size_t)making->table_mask + 1) * sizeof *making->table);
	memset(s->across, 0xff, (size_t)s->triangle_count * sizeof *s->across);
	for (uint32_t e = 0; e < 3 * s->triangle_count; e++) {
		const uint32_t a = s->corners[e / 3][e % 3], b = s->corners[e / 3][(e + 1) % 3], low = a < b ? a : b, high = a < b ? b : a;
		uint32_t at = mixed(low, high, 1) & making->table_mask;
		for (; making->table[at] != NONE; at = (at + 1) & making->table_mask) {
			const uint32_t *c = s->corners[making->table[at] / 3], k = making->table[at] % 3;
			if ((c[k] == low && c[(k + 1) % 3] == high) || (c[k] == high && c[(k + 1) % 3] == low))
				break;
		}
		const uint32_t other = making->table[at];
		if (other == NONE) {
			making->table[at] = e;
			continue;
		}
		if (s->across[other / 3][other % 3] >= 0)
			return false;
		s->across[other / 3][other % 3] = (int32_t)(e / 3);
		s->across[e / 3][e % 3] = (int32_t)(other / 3);
	}
	for (uint32_t e = 0; e < 3 * s->triangle_count; e++)
		if (s->across[e / 3][e % 3] < 0)
			return false;
	return true;
}

/* Turns a triangle over. */
static void turn_over(struct soil_surface *s, uint32_t t)
{
	uint32_t *c = s->corners[t];
	int32_t *across = s->across[t];
	const uint32_t corner = c[1];
	const int32_t first = across[0];
	c[1] = c[2];
	c[2] = corner;
	across[0] = across[2];
	across[2] = first;
}

/* Returns six times the volume between a triangle and the origin. */
static double volume_of(const struct soil_surface *s, uint32_t t)
{
	const uint32_t *c = s->corners[t];
	double at[3][3];
	for (int k = 0; k < 3; k++) {
		at[k][0] = (double)s->x[c[k]];
		at[k][1] = (double)s->y[c[k]];
		at[k][2] = (double)s->z[c[k]];
	}
	return at[0][0] * (at[1][1] * at[2][2] - at[1][2] * at[2][1]) + at[0][1] * (at[1][2] * at[2][0] - at[1][0] * at[2][2]) +
	       at[0][2] * (at[1][0] * at[2][1] - at[1][1] * at[2][0]);
}

/* Returns true if a triangle has an edge from a to b. */
static bool runs(const uint32_t c[3], uint32_t a, uint32_t b)
{
	return (c[0] == a && c[1] == b) || (c[1] == a && c[2] == b) || (c[2] == a && c[0] == b);
}

/* Turns the triangles of one piece so that they agree with the first, then all outwards. Returns false if they cannot agree. */
static bool orient_piece(struct making *making, struct soil_surface *s, uint32_t first)
{
	uint32_t count = 0, done = 0;
	double volume = 0;
	making->stack[count++] = first;
	making->known[first] = 1;
	while (done < count) {
		const uint32_t t = making->stack[done++];
		volume += volume_of(s, t);
		for (int k = 0; k < 3; k++) {
			const uint32_t a = s->corners[t][k], b = s->corners[t][(k + 1) % 3], other = (uint32_t)s->across[t][k];
			if (runs(s->corners[other], a, b)) {
				if (making->known[other] != 0)
					return false;
				turn_over(s, other);
			}
			if (making->known[other] == 0) {
				making->known[other] = 1;
				making->stack[count++] = other;
			}
		}
	}
	for (uint32_t i = 0; i < count && volume < 0; i++)
		turn_over(s, making->stack[i]);
	return true;
}

static bool orient(struct making *making, struct soil_surface *s)
{
	memset(making->known, 0, s->triangle_count);
	for (uint32_t t = 0; t < s->triangle_count; t++)
		if (making->known[t] == 0 && !orient_piece(making, s, t))
			return false;
	return true;
}

static enum status make(const struct soil_mesh *mesh, struct soil_surface *s)
{
	const size_t vertices = mesh->vertex_count, triangles = mesh->triangle_count;
	size_t slots = 64;
	while (slots < 4 * (vertices > 3 * triangles ? vertices : 3 * triangles))
		slots *= 2;
	struct making making = {.table_mask = (uint32_t)(slots - 1)};
	mem_free(s->memory);
	*s = (struct soil_surface){0};
	uint32_t *memory = mem_alloc(9 * vertices + 15 * triangles, sizeof *memory);
	uint32_t *scratch = mem_alloc(vertices + 2 * triangles + slots, sizeof *scratch);
	if (memory == NULL || scratch == NULL) {
		mem_free_all(memory, scratch);
		return fail_memory("a mesh");
	}
	s->memory = memory;
	s->x = (float *)memory;
	s->y = s->x + vertices;
	s->z = s->y + vertices;
	s->source = (float(*)[3])(s->z + vertices);
	s->source_triangles = (uint32_t(*)[3])(memory + 9 * vertices);
	s->corners = s->source_triangles + triangles;
	s->across = (int32_t(*)[3])(s->corners + triangles);
	s->normals = (float(*)[3])(s->across + triangles);
	s->pieces = (uint32_t *)(s->normals + triangles);
	s->level = (float *)(s->pieces + triangles);
	s->top = s->level + triangles;
	for (int k = 0; k < 3; k++)
		s->turned[k] = (float *)memory + (6 + (size_t)k) * vertices;
	making.table = scratch;
	making.same = scratch + slots;
	making.stack = making.same + vertices;
	making.known = (uint8_t *)(making.stack + triangles);
	memcpy(s->source, mesh->vertices, vertices * sizeof *s->source);
	memcpy(s->source_triangles, mesh->triangles, triangles * sizeof *s->source_triangles);
	s->source_vertices = mesh->vertex_count;
	s->source_count = mesh->triangle_count;
	weld(mesh, &making, s);
	s->closed = pair(&making, s) && orient(&making, s);
	soil_surface_pieces(s, making.stack);
	mem_free(scratch);
	return STATUS_OK;
}

static bool is_of(const struct soil_surface *s, const struct soil_mesh *mesh)
{
	return s->memory != NULL && s->source_vertices == mesh->vertex_count && s->source_count == mesh->triangle_count &&
	       memcmp(s->source_triangles, mesh->triangles, mesh->triangle_count * sizeof *mesh->triangles) == 0 &&
	       memcmp(s->source, mesh->vertices, mesh->vertex_count * sizeof *mesh->vertices) == 0;
}

enum status soil_surface_of(struct soil_surfaces *surfaces, const struct soil_mesh *mesh, const struct soil_surface **out)
{
	*out = NULL;
	for (unsigned i = 0; i < SURFACES; i++)
		if (is_of(&surfaces->kept[i], mesh))
			*out = &surfaces->kept[i];
	if (*out != NULL)
		return STATUS_OK;
	struct soil_surface *s = &surfaces->kept[surfaces->next];
	TRY(make(mesh, s));
	surfaces->next = (surfaces->next + 1) % SURFACES;
	*out = s;
	return STATUS_OK;
}

void soil_surfaces_finish(struct soil_surfaces *surfaces)
{
	for (unsigned i = 0; i < SURFACES; i++)
		mem_free(surfaces->kept[i].memory);
	*surfaces = (struct soil_surfaces){0};
}

size_t soil_surfaces_bytes(const struct soil_surfaces *surfaces)
{
	size_t words = 0;
	for (int i = 0; i < SURFACES; i++)
		if (surfaces->kept[i].memory != NULL)
			words += 9 * (size_t)surfaces->kept[i].source_vertices + 15 * (size_t)surfaces->kept[i].source_count;
	return words * sizeof(uint32_t);
}
