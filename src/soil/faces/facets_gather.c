/*
 * Gathers the facets of a mesh of very many triangles. Parts of its surface that are in one cell, and look nearly in one direction, become one
 * facet. Its vector is the sum of theirs, and its place is their middle. So the sum of all vectors stays as it is.
 */
#include "soil/faces/facets_making.h"

#include <string.h>

#define SLOTS (1u << 17) /* at least twice the most facets */
#define LOOKS 4          /* each face of a cube of directions has so many along a side: they are 23 degrees wide */
#define CELLS (1 << 17)  /* a size is at least FACETS_LEAST of a body, so no cell is farther from its centre */

struct facets_gather {
	uint64_t keys[SLOTS]; /* 0: empty */
	double vector[SLOTS][3], at[SLOTS][3], area[SLOTS];
	size_t count;
};

enum status soil_facets_gather_create(struct facets_gather **out)
{
	return mem_zeroed(out, 1, sizeof **out, "a body's facets");
}

void soil_facets_gather_destroy(struct facets_gather *gather)
{
	mem_free(gather);
}

void soil_facets_gather_clear(struct facets_gather *gather)
{
	memset(gather->keys, 0, sizeof gather->keys);
	gather->count = 0;
}

static uint64_t look_of(const double v[3])
{
	int k = 0;
	for (int i = 1; i < 3; i++)
		if (fabs(v[i]) > fabs(v[k]))
			k = i;
	uint64_t look = (uint64_t)(2 * k + (v[k] < 0 ? 1 : 0));
	for (int i = 1; i < 3; i++)
		look = look * LOOKS + (uint64_t)fmin(floor((v[(k + i) % 3] / fabs(v[k]) + 1) / 2 * LOOKS), LOOKS - 1);
	return look;
}

static uint64_t key_of(double size, const double at[3], const double vector[3], enum soil_facet_kind kind)
{
	uint64_t key = look_of(vector) * 2 + (kind == FACET_SIDE ? 1 : 0);
	for (int k = 0; k < 3; k++)
		key = key * (2 * CELLS - 1) + (uint64_t)(fmin(fmax(floor(at[k] / size), -CELLS + 1), CELLS - 1) + CELLS - 1);
	return key + 1;
}

bool soil_facets_gather_add(struct facets_gather *gather, double size, const double at[3], const double vector[3], enum soil_facet_kind kind)
{
	const uint64_t key = key_of(size, at, vector, kind), mixed = (key ^ (key >> 31)) * 0x9e3779b97f4a7c15u;
	uint32_t slot = (uint32_t)(mixed >> 40) & (SLOTS - 1);
	while (gather->keys[slot] != 0 && gather->keys[slot] != key)
		slot = (slot + 1) & (SLOTS - 1);
	const bool first = gather->keys[slot] == 0;
	if (first && gather->count > SOIL_FACETS_MOST)
		return true; /* there are too many already */
	if (first) {
		gather->keys[slot] = key;
		gather->count++;
		gather->area[slot] = 0;
		for (int k = 0; k < 3; k++)
			gather->vector[slot][k] = gather->at[slot][k] = 0;
	}
	const double area = sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
	gather->area[slot] += area;
	for (int k = 0; k < 3; k++) {
		gather->vector[slot][k] += vector[k];
		gather->at[slot][k] += area * at[k];
	}
	return first;
}

void soil_facets_gather_put(const struct facets_gather *gather, struct facets_making *m)
{
	struct facets_gather *const own = m->gather;
	m->gather = NULL;
	for (size_t i = 0; i < SLOTS; i++) {
		if (gather->keys[i] == 0)
			continue;
		double at[3];
		for (int k = 0; k < 3; k++)
			at[k] = gather->at[i][k] / gather->area[i];
		/* The look's number is even for parts that are not sides. */
		const uint64_t cells = 2 * CELLS - 1, kind = (gather->keys[i] - 1) / cells / cells / cells % 2;
		soil_facets_put(m, at, gather->vector[i], kind != 0 ? FACET_SIDE : FACET_UNDER);
	}
	m->gather = own;
}
