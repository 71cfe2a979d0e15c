/*
 * Steep walls of a mesh, as the sides of a wheel that leans. In soil a wall is narrower than a place of the raster. So it bears beside the
 * cells that have its lower edge. See fine.h and `struct soil_brim`.
 */
#include "soil/law/fine.h"

#define PIECES_MOST 64 /* of an edge */
#define ACROSS 0.98f   /* cosine: a wall lies across the axis of a drum */

/* --- which pieces of the surface are walls --- */

/* Puts z of the least steep normal of each piece, of what looks down, and its highest vertex. */
static void put_levels(const struct soil_fine_work *work, const float up[3])
{
	const struct soil_surface *s = work->surface;
	for (uint32_t p = 0; p < s->piece_count; p++) {
		s->level[p] = 0;
		s->top[p] = -FINE_NONE;
	}
	for (uint32_t t = 0; t < s->triangle_count; t++) {
		const uint32_t *c = s->corners[t], p = s->pieces[t];
		const float *n = s->normals[t], *z = s->turned[2];
		if (work->looks[t] != 0)
			s->level[p] = most(s->level[p], -(n[0] * up[0] + n[1] * up[1] + n[2] * up[2]));
		s->top[p] = most(s->top[p], most(z[c[0]], most(z[c[1]], z[c[2]])));
	}
}

/* Returns true if a triangle rises from its edge `k`. */
static bool rises(const struct soil_surface *s, uint32_t t, uint32_t k)
{
	const uint32_t *c = s->corners[t];
	const float *z = s->turned[2];
	return z[c[(k + 2) % 3]] > 0.5f * (z[c[k]] + z[c[(k + 1) % 3]]);
}

static bool is_level(const struct soil_fine_work *work, uint32_t t)
{
	const struct soil_surface *s = work->surface;
	return work->looks[t] == FINE_SOLE && s->level[s->pieces[t]] >= FINE_WALL;
}

void soil_fine_mark(const struct soil_fine_work *work)
{
	const struct soil_surface *s = work->surface;
	for (uint32_t t = 0; work->any_wall && t < s->triangle_count; t++)
		work->looks[t] = work->looks[t] != 0 && s->level[s->pieces[t]] < 0 ? FINE_SIDE : work->looks[t];
}

void soil_fine_walls(struct soil_fine_work *work, const double own[3][3])
{
	const struct soil_surface *s = work->surface;
	const float up[3] = {(float)own[0][2], (float)own[1][2], (float)own[2][2]};
	bool steep = false, level = false;
	work->any_wall = false;
	if (!s->closed)
		return;
	put_levels(work, up);
	for (uint32_t p = 0; p < s->piece_count; p++) {
		level = level || s->level[p] >= FINE_WALL;
		steep = steep || (s->level[p] > 0 && s->level[p] < FINE_WALL);
	}
	for (uint32_t t = 0; steep && level && t < s->triangle_count; t++) {
		const uint32_t p = s->pieces[t];
		for (uint32_t k = 0; k < 3 && work->looks[t] != 0 && s->level[p] > 0 && s->level[p] < FINE_WALL; k++)
			if (is_level(work, (uint32_t)s->across[t][k]) && rises(s, t, k)) {
				s->level[p] = -1;
				work->any_wall = true;
			}
	}
	soil_fine_mark(work);
}

/* --- their lower edges --- */

/* Returns the cell that bears what is at a place: the place's own, or the nearest one whose post is covered. */
static int32_t cell_at(const struct soil_fine_work *work, const struct soil_fine *fine, float x, float y)
{
	const float at[2] = {((x - fine->x) * fine->by_step + 0.5f) / (float)fine->parts, ((y - fine->y) * fine->by_step + 0.5f) / (float)fine->parts};
	const float *covered = work->sums[3];
	int32_t cell[2], best = 0;
	float nearest = FINE_NONE;
	for (int k = 0; k < 2; k++)
		cell[k] = (int32_t)clamped(at[k], 0, (float)(fine->cells[k] - 1));
	best = cell[1] * fine->cells[0] + cell[0];
	if (covered[best] > 0)
		return best;
	for (int32_t j = cell[1] > 0 ? cell[1] - 1 : 0; j <= cell[1] + 1 && j < fine->cells[1]; j++)
		for (int32_t i = cell[0] > 0 ? cell[0] - 1 : 0; i <= cell[0] + 1 && i < fine->cells[0]; i++) {
			const float u = at[0] - (float)i - 0.5f, v = at[1] - (float)j - 0.5f, away = u * u + v * v;
			if (covered[j * fine->cells[0] + i] > 0 && away < nearest) {
				nearest = away;
				best = j * fine->cells[0] + i;
			}
		}
	return best;
}

/* Adds the edge `k` of a triangle of a wall. */
static void add_edge(const struct soil_fine_work *work, const struct soil_fine *fine, uint32_t t, uint32_t k)
{
	const struct soil_surface *s = work->surface;
	const uint32_t a = s->corners[t][k], b = s->corners[t][(k + 1) % 3], c = s->corners[t][(k + 2) % 3];
	const float *x = s->turned[0], *y = s->turned[1], *z = s->turned[2];
	const float u[3] = {x[b] - x[a], y[b] - y[a], z[b] - z[a]}, v[3] = {x[c] - x[a], y[c] - y[a], z[c] - z[a]};
	/* The wall rises by `rise` for each metre to the east and to the north. */
	const float area = u[0] * v[1] - u[1] * v[0], by_area = 1 / area, rise[2] = {(u[2] * v[1] - v[2] * u[1]) * by_area, (v[2] * u[0] - u[2] * v[0]) * by_area};
	const float steep = sqrtf(rise[0] * rise[0] + rise[1] * rise[1]), out[2] = {rise[0] / steep, rise[1] / steep};
	const float plan = sqrtf(u[0] * u[0] + u[1] * u[1]), across = fabsf(u[0] * out[1] - u[1] * out[0]), side = area > 0 ? 1 : -1, by_plan = side / most(plan, 1e-9f);
	const float axial = s->drum ? fabsf((float)s->axis[0] * s->normals[t][0] + (float)s->axis[1] * s->normals[t][1] + (float)s->axis[2] * s->normals[t][2]) : 0;
	const int32_t pieces = (int32_t)clamped(ceilf(2 * plan / ((float)fine->parts * fine->step)), 1, PIECES_MOST);
	const float each = across / (float)pieces;
	for (int32_t i = 0; i < pieces; i++) {
		const float on = ((float)i + 0.5f) / (float)pieces, at[3] = {x[a] + on * u[0], y[a] + on * u[1], z[a] + on * u[2]};
		struct soil_brim *brim = &work->brims[cell_at(work, fine, at[0], at[1])];
		brim->length += each;
		brim->x += each * at[0];
		brim->y += each * at[1];
		brim->z += each * at[2];
		brim->out[0] += each * out[0];
		brim->out[1] += each * out[1];
		brim->aside[0] -= each * u[1] * by_plan;
		brim->aside[1] += each * u[0] * by_plan;
		brim->flat += each / steep;
		brim->tall += each * (s->top[s->pieces[t]] - at[2]);
		brim->end += axial >= ACROSS ? each : 0;
	}
}

void soil_fine_brims(const struct soil_fine_work *work, struct soil_fine *fine)
{
	const struct soil_surface *s = work->surface;
	fine->brims = NULL;
	if (!work->any_wall)
		return;
	memset(work->brims, 0, (size_t)fine->cells[0] * (size_t)fine->cells[1] * sizeof *work->brims);
	for (uint32_t t = 0; t < s->triangle_count; t++)
		for (uint32_t k = 0; k < 3 && work->looks[t] == FINE_SIDE; k++)
			if (work->looks[s->across[t][k]] == FINE_SOLE && rises(s, t, k))
				add_edge(work, fine, t, k);
	fine->brims = work->brims;
}
