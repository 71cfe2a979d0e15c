/*
 * Thins a mesh, so that the soil need not look at triangles that its posts cannot tell apart.
 *
 * 1. Vertices of one cell of a fine grid become one of them.
 * 2. Vertices are moved onto neighbours, those first that change the surface least. In each turn a vertex takes the best neighbour: its own place is then
 *    nearest to the triangles that are left around it. What it gives up is added to what that neighbour gave up before.
 * 3. Every vertex, and the middle of every edge and every triangle of the given mesh, is then compared with what is left. Where one of them is farther than
 *    `most`, the corners of its triangle stay where they are, and step 2 is done again. So that triangle stays. After some of these the mesh stays as it is.
 *
 * All vertices that are left are vertices of the given mesh, so it reaches nowhere farther than before. Triangles may be of any topology.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "vehicle/thin.h"

#define CELL 0.12       /* of `most`: side of a cell; its diagonal is 0.21 of it */
#define MOVES 0.6       /* of `most`: what moves may give up together */
#define TRIES 8
#define AROUND_MOST 64  /* triangles about a vertex that may be moved */
#define FLIPS 0.2       /* cosine of the greatest turn of a triangle's normal in one move */
#define FEW 200         /* a turn that moves fewer than one of so many vertices is the last with its error */
#define GRID 32         /* cells along the longest side, in which triangles that are left are looked up */

#define NONE UINT32_MAX

struct thinned {
	const float (*places)[3];
	uint32_t (*triangles)[3]; /* NONE in the first: it is gone */
	uint32_t *next, *first;   /* corners of a vertex: the first of each vertex, and the next of each corner; a corner is 3 triangle + k */
	double *given;            /* m: what each vertex gave up */
	bool *moved;              /* in this turn: it, or a neighbour */
	bool *stays;              /* it must not move */
	uint32_t vertex_count, triangle_count;
};

/* --- vectors --- */

static void minus(const float a[3], const float b[3], double out[3])
{
	for (int k = 0; k < 3; k++)
		out[k] = (double)a[k] - (double)b[k];
}

static double dot(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
	for (int k = 0; k < 3; k++)
		out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static void normal_of(const float a[3], const float b[3], const float c[3], double out[3])
{
	double ab[3], ac[3];
	minus(b, a, ab);
	minus(c, a, ac);
	cross(ab, ac, out);
}

/* The square of the distance of a point from a segment from `a` along `ab`. */
static double from_segment(const double p[3], const double ab[3])
{
	const double length = dot(ab, ab), share = length > 0 ? fmin(fmax(dot(p, ab) / length, 0), 1) : 0;
	double apart[3];
	for (int k = 0; k < 3; k++)
		apart[k] = p[k] - share * ab[k];
	return dot(apart, apart);
}

/* The square of the distance of a point from a triangle. */
static double from_triangle(const double point[3], const float a[3], const float b[3], const float c[3])
{
	double ab[3], ac[3], bc[3], p[3], q[3], normal[3], side[3];
	minus(b, a, ab);
	minus(c, a, ac);
	minus(c, b, bc);
	for (int k = 0; k < 3; k++) {
		p[k] = point[k] - (double)a[k];
		q[k] = point[k] - (double)b[k];
	}
	cross(ab, ac, normal);
	const double area = dot(normal, normal);
	bool inside = area > 0;
	cross(ab, p, side);
	inside = inside && dot(side, normal) >= 0;
	cross(bc, q, side);
	inside = inside && dot(side, normal) >= 0;
	cross(p, ac, side);
	inside = inside && dot(side, normal) >= 0;
	if (inside) {
		const double high = dot(p, normal);
		return high * high / area;
	}
	return fmin(from_segment(p, ab), fmin(from_segment(p, ac), from_segment(q, bc)));
}

/* --- 1: cells --- */

struct cell {
	int64_t at[3];
	uint32_t vertex;
};

static uint64_t hash_of(const int64_t at[3])
{
	uint64_t hash = 0x9e3779b97f4a7c15u;
	for (int k = 0; k < 3; k++) {
		hash = (hash ^ (uint64_t)at[k]) * 0xff51afd7ed558ccdu;
		hash ^= hash >> 32;
	}
	return hash;
}

/* Finds the first vertex in the cell of each. */
static enum status find_cells(const struct soil_mesh *mesh, double side, uint32_t *same)
{
	size_t room = 16;
	while (room < 2 * (size_t)mesh->vertex_count)
		room *= 2;
	struct cell *cells = mem_calloc(room, sizeof *cells);
	TRY_MEM(cells, "a mesh");
	for (uint32_t i = 0; i < mesh->vertex_count; i++) {
		int64_t at[3];
		for (int k = 0; k < 3; k++)
			at[k] = (int64_t)floor((double)mesh->vertices[i][k] / side);
		size_t slot = hash_of(at) & (room - 1);
		while (cells[slot].vertex != 0 && memcmp(cells[slot].at, at, sizeof at) != 0)
			slot = (slot + 1) & (room - 1);
		if (cells[slot].vertex == 0) {
			cells[slot].vertex = i + 1;
			memcpy(cells[slot].at, at, sizeof at);
		}
		same[i] = cells[slot].vertex - 1;
	}
	mem_free(cells);
	return STATUS_OK;
}

/* --- 2: moves --- */

static bool is_gone(const struct thinned *thinned, uint32_t triangle)
{
	return thinned->triangles[triangle][0] == NONE;
}

static void link_corner(struct thinned *thinned, uint32_t corner)
{
	const uint32_t vertex = thinned->triangles[corner / 3][corner % 3];
	thinned->next[corner] = thinned->first[vertex];
	thinned->first[vertex] = corner;
}

static void begin(struct thinned *thinned, const struct soil_mesh *mesh, const uint32_t *same)
{
	memset(thinned->first, 0xff, mesh->vertex_count * sizeof *thinned->first);
	memset(thinned->given, 0, mesh->vertex_count * sizeof *thinned->given);
	for (uint32_t t = 0; t < mesh->triangle_count; t++) {
		uint32_t *to = thinned->triangles[t];
		for (int k = 0; k < 3; k++)
			to[k] = same[mesh->triangles[t][k]];
		if (to[0] == to[1] || to[1] == to[2] || to[2] == to[0])
			to[0] = NONE;
		for (uint32_t k = 0; k < 3 && to[0] != NONE; k++)
			link_corner(thinned, 3 * t + k);
	}
}

/* Lists the triangles about a vertex. Returns their number; 0: none, or too many. */
static size_t list_around(const struct thinned *thinned, uint32_t vertex, uint32_t list[AROUND_MOST])
{
	size_t count = 0;
	for (uint32_t corner = thinned->first[vertex]; corner != NONE; corner = thinned->next[corner]) {
		if (is_gone(thinned, corner / 3))
			continue;
		if (count == AROUND_MOST)
			return 0;
		list[count++] = corner / 3;
	}
	return count;
}

static bool has(const uint32_t triangle[3], uint32_t vertex)
{
	return triangle[0] == vertex || triangle[1] == vertex || triangle[2] == vertex;
}

/* Lists the other corners of the triangles about a vertex, each once. */
static size_t list_neighbours(const struct thinned *thinned, uint32_t vertex, const uint32_t *around, size_t count, uint32_t list[2 * AROUND_MOST])
{
	size_t listed = 0;
	for (size_t i = 0; i < count; i++)
		for (int k = 0; k < 3; k++) {
			const uint32_t to = thinned->triangles[around[i]][k];
			size_t at = 0;
			while (at < listed && list[at] != to)
				at++;
			if (at == listed && to != vertex)
				list[listed++] = to;
		}
	return listed;
}

/* Returns how far, m, the place of a vertex is from the triangles about it once the vertex has moved onto `to`. INFINITY: that is farther
 * than `most`, or a triangle would turn over. */
static double error_of(const struct thinned *thinned, uint32_t vertex, uint32_t to, const uint32_t *around, size_t count, double most)
{
	const float *from = thinned->places[vertex];
	const double place[3] = {(double)from[0], (double)from[1], (double)from[2]};
	double least = INFINITY;
	for (size_t i = 0; i < count; i++) {
		const uint32_t *triangle = thinned->triangles[around[i]];
		const float *corner[3];
		double before[3], after[3];
		if (has(triangle, to))
			continue;
		for (int k = 0; k < 3; k++)
			corner[k] = thinned->places[triangle[k] == vertex ? to : triangle[k]];
		normal_of(thinned->places[triangle[0]], thinned->places[triangle[1]], thinned->places[triangle[2]], before);
		normal_of(corner[0], corner[1], corner[2], after);
		const double size = sqrt(dot(before, before) * dot(after, after));
		if (!(dot(before, after) > FLIPS * size) && size > 0)
			return INFINITY;
		least = fmin(least, from_triangle(place, corner[0], corner[1], corner[2]));
	}
	/* All triangles about the vertex go. Then `to` alone is left of them. */
	if (isinf(least)) {
		double apart[3];
		minus(from, thinned->places[to], apart);
		least = dot(apart, apart);
	}
	return least <= most * most ? sqrt(least) : INFINITY;
}

static void move_onto(struct thinned *thinned, uint32_t vertex, uint32_t to, const uint32_t *around, size_t count)
{
	thinned->first[vertex] = NONE;
	for (size_t i = 0; i < count; i++) {
		uint32_t *triangle = thinned->triangles[around[i]];
		for (int k = 0; k < 3; k++)
			thinned->moved[triangle[k]] = true;
		if (has(triangle, to)) {
			triangle[0] = NONE;
			continue;
		}
		for (uint32_t k = 0; k < 3; k++)
			if (triangle[k] == vertex) {
				triangle[k] = to;
				link_corner(thinned, 3 * around[i] + k);
			}
	}
}

/* Moves each vertex that gives up no more than `most`. Returns how many were moved. */
static size_t move_all(struct thinned *thinned, double most)
{
	uint32_t around[AROUND_MOST], beside[2 * AROUND_MOST];
	size_t moved = 0;
	memset(thinned->moved, 0, thinned->vertex_count * sizeof *thinned->moved);
	for (uint32_t v = 0; v < thinned->vertex_count; v++) {
		if (thinned->first[v] == NONE || thinned->moved[v] || thinned->stays[v] || thinned->given[v] > most)
			continue;
		const size_t count = list_around(thinned, v, around);
		uint32_t best = NONE;
		double least = INFINITY;
		const size_t neighbours = list_neighbours(thinned, v, around, count, beside);
		for (size_t i = 0; i < neighbours; i++) {
			const double error = error_of(thinned, v, beside[i], around, count, most - thinned->given[v]);
			if (error < least) {
				least = error;
				best = beside[i];
			}
		}
		if (best == NONE)
			continue;
		move_onto(thinned, v, best, around, count);
		thinned->given[best] = fmax(thinned->given[best], thinned->given[v] + least);
		moved++;
	}
	return moved;
}

/* --- 3: distances --- */

/* The triangles that are left, by cells of a grid. */
struct grid {
	double low[3], side;
	uint32_t *starts, *list; /* of cells: where their triangles begin in `list`, GRID^3 + 1 */
};

static void range_of(const struct grid *grid, const double low[3], const double high[3], int from[3], int to[3])
{
	for (int k = 0; k < 3; k++) {
		from[k] = (int)fmin(fmax(floor((low[k] - grid->low[k]) / grid->side), 0), GRID - 1);
		to[k] = (int)fmin(fmax(floor((high[k] - grid->low[k]) / grid->side), 0), GRID - 1);
	}
}

/* Counts a triangle in each cell that its box touches. With `fill` it puts the triangle into the lists of these cells instead. */
static void put_triangle(const struct thinned *thinned, struct grid *grid, uint32_t triangle, bool fill)
{
	double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
	int from[3], to[3];
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++) {
			low[k] = fmin(low[k], (double)thinned->places[thinned->triangles[triangle][i]][k]);
			high[k] = fmax(high[k], (double)thinned->places[thinned->triangles[triangle][i]][k]);
		}
	range_of(grid, low, high, from, to);
	for (int z = from[2]; z <= to[2]; z++)
		for (int y = from[1]; y <= to[1]; y++)
			for (int x = from[0]; x <= to[0]; x++) {
				const size_t cell = ((size_t)z * GRID + (size_t)y) * GRID + (size_t)x;
				if (fill)
					grid->list[--grid->starts[cell]] = triangle;
				else
					grid->starts[cell]++;
			}
}

static enum status make_grid(const struct thinned *thinned, const struct soil_mesh *mesh, double most, struct grid *grid)
{
	const size_t cells = (size_t)GRID * GRID * GRID;
	*grid = (struct grid){.side = most, .starts = mem_calloc(cells + 1, sizeof *grid->starts)};
	TRY_MEM(grid->starts, "a mesh");
	for (int k = 0; k < 3; k++) {
		grid->low[k] = mesh->low[k];
		grid->side = fmax(grid->side, (mesh->high[k] - mesh->low[k]) / GRID);
	}
	for (uint32_t t = 0; t < thinned->triangle_count; t++)
		if (!is_gone(thinned, t))
			put_triangle(thinned, grid, t, false);
	for (size_t cell = 1; cell <= cells; cell++)
		grid->starts[cell] += grid->starts[cell - 1];
	grid->list = mem_calloc(grid->starts[cells] + 1, sizeof *grid->list);
	TRY_MEM(grid->list, "a mesh");
	for (uint32_t t = 0; t < thinned->triangle_count; t++)
		if (!is_gone(thinned, t))
			put_triangle(thinned, grid, t, true);
	return STATUS_OK;
}

/* Returns true if a triangle that is left is no farther from the place than `most`. */
static bool is_near(const struct thinned *thinned, const struct grid *grid, const double place[3], double most)
{
	double low[3], high[3];
	int from[3], to[3];
	for (int k = 0; k < 3; k++) {
		low[k] = place[k] - most;
		high[k] = place[k] + most;
	}
	range_of(grid, low, high, from, to);
	for (int z = from[2]; z <= to[2]; z++)
		for (int y = from[1]; y <= to[1]; y++)
			for (int x = from[0]; x <= to[0]; x++) {
				const size_t cell = ((size_t)z * GRID + (size_t)y) * GRID + (size_t)x;
				for (uint32_t i = grid->starts[cell]; i < grid->starts[cell + 1]; i++) {
					const uint32_t *t = thinned->triangles[grid->list[i]];
					if (from_triangle(place, thinned->places[t[0]], thinned->places[t[1]], thinned->places[t[2]]) <= most * most)
						return true;
				}
			}
	return false;
}

/* Compares places of one triangle of the given mesh with what is left. */
static bool triangle_is_near(const struct thinned *thinned, const struct grid *grid, const struct soil_mesh *mesh, uint32_t triangle, double most)
{
	static const double shares[7][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5, 0.5, 0}, {0, 0.5, 0.5}, {0.5, 0, 0.5}, {1 / 3.0, 1 / 3.0, 1 / 3.0}};
	const uint32_t *corners = mesh->triangles[triangle];
	for (int i = 0; i < 7; i++) {
		double place[3] = {0, 0, 0};
		for (int c = 0; c < 3; c++)
			for (int k = 0; k < 3; k++)
				place[k] += shares[i][c] * (double)mesh->vertices[corners[c]][k];
		if (!is_near(thinned, grid, place, most))
			return false;
	}
	return true;
}

/* *near: all of the given mesh is near what is left. Corners of triangles that are not must stay. */
static enum status compare(struct thinned *thinned, const struct soil_mesh *mesh, const uint32_t *same, double most, bool *near)
{
	struct grid grid;
	enum status status;
	TRY_OR(done, make_grid(thinned, mesh, most, &grid));
	for (uint32_t t = 0; t < mesh->triangle_count; t++) {
		if (triangle_is_near(thinned, &grid, mesh, t, most))
			continue;
		*near = false;
		for (int k = 0; k < 3; k++)
			thinned->stays[same[mesh->triangles[t][k]]] = true;
	}
done:
	mem_free_all(grid.starts, grid.list);
	return status;
}

/* --- all --- */

/* Puts what is left in place of the mesh. */
static void take(const struct thinned *thinned, uint32_t *numbers, struct soil_mesh *mesh)
{
	uint32_t vertices = 0, triangles = 0;
	memset(numbers, 0xff, mesh->vertex_count * sizeof *numbers);
	for (uint32_t t = 0; t < thinned->triangle_count; t++)
		for (int k = 0; k < 3 && !is_gone(thinned, t); k++)
			numbers[thinned->triangles[t][k]] = 0;
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		if (numbers[v] == 0) {
			numbers[v] = vertices;
			memmove(mesh->vertices[vertices++], mesh->vertices[v], sizeof *mesh->vertices);
		}
	for (uint32_t t = 0; t < thinned->triangle_count; t++) {
		if (is_gone(thinned, t))
			continue;
		for (int k = 0; k < 3; k++)
			mesh->triangles[triangles][k] = numbers[thinned->triangles[t][k]];
		triangles++;
	}
	mesh->vertex_count = vertices;
	mesh->triangle_count = triangles;
	for (int k = 0; k < 3; k++) {
		mesh->low[k] = INFINITY;
		mesh->high[k] = -INFINITY;
		for (uint32_t v = 0; v < vertices; v++) {
			mesh->low[k] = fmin(mesh->low[k], (double)mesh->vertices[v][k]);
			mesh->high[k] = fmax(mesh->high[k], (double)mesh->vertices[v][k]);
		}
	}
}

static enum status thin(struct thinned *thinned, struct soil_mesh *mesh, const uint32_t *same, double most, bool *near)
{
	const double gives = MOVES * most;
	*near = false;
	for (int i = 0; i < TRIES && !*near; i++) {
		begin(thinned, mesh, same);
		for (double turn = gives / 8; turn <= gives; turn *= 2)
			while (move_all(thinned, turn) * FEW > thinned->vertex_count)
				;
		*near = true;
		TRY(compare(thinned, mesh, same, most, near));
	}
	return STATUS_OK;
}

enum status vehicle_thin(struct soil_mesh *mesh, double most, bool *thinned)
{
	struct thinned work = {.places = (const float(*)[3])mesh->vertices, .vertex_count = mesh->vertex_count, .triangle_count = mesh->triangle_count};
	uint32_t *same = mem_calloc((size_t)mesh->vertex_count + 1, sizeof *same);
	enum status status;
	bool near = false;
	*thinned = false;
	work.triangles = mem_calloc((size_t)mesh->triangle_count + 1, sizeof *work.triangles);
	work.next = mem_calloc(3 * (size_t)mesh->triangle_count + 1, sizeof *work.next);
	work.first = mem_calloc((size_t)mesh->vertex_count + 1, sizeof *work.first);
	work.given = mem_calloc((size_t)mesh->vertex_count + 1, sizeof *work.given);
	work.moved = mem_calloc((size_t)mesh->vertex_count + 1, sizeof *work.moved);
	work.stays = mem_calloc((size_t)mesh->vertex_count + 1, sizeof *work.stays);
	const bool whole = work.stays != NULL && same != NULL && work.triangles != NULL && work.next != NULL && work.first != NULL && work.given != NULL && work.moved != NULL;
	TRY_OR(done, whole ? STATUS_OK : fail_memory("a mesh"));
	TRY_OR(done, find_cells(mesh, CELL * most, same));
	TRY_OR(done, thin(&work, mesh, same, most, &near));
	if (near) {
		const uint32_t before = mesh->triangle_count;
		take(&work, same, mesh);
		*thinned = mesh->triangle_count < before;
	}
done:
	mem_free_all(same, work.triangles, work.next, work.first, work.given, work.moved, work.stays);
	return status;
}
