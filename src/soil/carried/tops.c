/*
 * The upper envelope below cells. A raster has up to 8 x 8 places in a cell. It tells which of them are above the body, and how high that is. Walls of a mesh are
 * hardly above the middle of any place. So each place also has a barrier: the highest of the walls that pass through it, or the envelope.
 *
 * In a cell soil lies on one basin: around its lowest place, or around that of another hollow in it if that is larger. The way to a place is the lowest
 * barrier over which soil gets there from the basin. Where the basin ends at the border of a cell, or beside the body, the way is the sill.
 */
#include "soil/carried/tops.h"

#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "soil/kinematic/rows.h"
#include "soil/kinematic/under.h"
#include "soil/shape/body.h"

#define FINE_MOST 8
#define FINE_PLACES 512 /* a raster has at most so many places in a row, unless it has one for each cell */
#define SHARE_LEAST 16  /* of CARRIED_SHARES: a smaller cell is a part of its neighbour, since little soil flows through it */
#define STEEP 0.2       /* the cosine of a triangle's tilt from which on it is a wall */

static const int ways[4][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}};

struct raster {
	int fine, side;       /* places in a row of a cell; in a row of all */
	size_t stride;
	int32_t *tops, *bars, *pass; /* of each place: the envelope, its barrier, and the way from its cell's basin; CARRIED_OPEN: the body is not below it */
};

static int fine_of(int side)
{
	int fine = FINE_MOST;
	while (fine > 1 && fine * side > FINE_PLACES)
		fine /= 2;
	return fine;
}

static size_t raster_bytes(const struct soil_shape *shape, int side)
{
	const int places = fine_of(side) * side;
	const size_t corners = shape->kind == SOIL_MESH ? shape->mesh->vertex_count * sizeof(struct facet_corner) : 0;
	return 3 * soil_under_stride(places) * (size_t)places * sizeof(int32_t) + corners;
}

enum status soil_carried_cells_make(const struct soil_shape *shape, int side, struct soil_carried_cells **out)
{
	const size_t count = (size_t)side * (size_t)side;
	struct soil_carried_cells *cells;
	enum status status;
	TRY(mem_zeroed(&cells, 1, sizeof *cells, "soil aboard a body"));
	TRY_OR(failed, mem_zeroed(&cells->shares, count, sizeof *cells->shares, "soil aboard a body"));
	TRY_OR(failed, mem_zeroed(&cells->rough, count, sizeof *cells->rough, "soil aboard a body"));
	TRY_OR(failed, mem_zeroed(&cells->lips, count, sizeof *cells->lips, "soil aboard a body"));
	for (int k = 0; k < 4; k++)
		TRY_OR(failed, mem_zeroed(&cells->sills[k], count, sizeof *cells->sills[k], "soil aboard a body"));
	TRY_OR(failed, mem_make(&cells->raster, raster_bytes(shape, side), 1, "soil aboard a body"));
	*out = cells;
	return STATUS_OK;
failed:
	soil_carried_cells_free(cells);
	return status;
}

void soil_carried_cells_free(struct soil_carried_cells *cells)
{
	if (cells == NULL)
		return;
	mem_free_all(cells->shares, cells->rough, cells->lips, cells->sills[0], cells->sills[1], cells->sills[2], cells->sills[3], cells->raster, cells);
}

/* The upper envelope is the lower one of the body upside down, mirrored. Mirrored in its own axes every shape but a mesh is itself. */
static struct raster sample(struct soil_carried *carried, const struct soil_pose *pose)
{
	struct soil_shape shape = *carried->shape;
	struct raster r = {.fine = fine_of(carried->side)};
	r.side = r.fine * carried->side;
	r.stride = soil_under_stride(r.side);
	const size_t all = r.stride * (size_t)r.side;
	r.bars = ((struct soil_carried_cells *)carried->scratch)->raster;
	r.tops = r.bars + all;
	r.pass = r.tops + all;
	/* The middle of a cell is a post if there is one place in it, and else lies between two. */
	const double spacing = carried->spacing / r.fine;
	const int64_t first = -(int64_t)carried->half * r.fine - r.fine / 2, apart = r.fine > 1 ? -lattice_offset(spacing / 2) : 0;
	const struct soil_pose at = {.x = apart, .y = apart, .yaw = -carried->heading, .pitch = -pose->pitch, .roll = -pose->roll, .turn = -pose->turn};
	if (shape.kind == SOIL_MESH)
		shape.mesh = &carried->mirrored;
	const struct under_motion motion = {.shape = &shape, .from = &at, .to = &at, .spacing = spacing, .posts = {first, first, first + r.side, first + r.side}};
	soil_under(&motion, (struct facet_corner *)(void *)(r.pass + all), r.bars, r.tops);
	for (size_t i = 0; i < all; i++)
		r.tops[i] = r.tops[i] == UNDER_NONE ? CARRIED_OPEN : -r.tops[i];
	memcpy(r.bars, r.tops, all * sizeof *r.bars);
	return r;
}

/* Raises the barrier at a place of the body's surface, m from its centre along the cells' axes. */
static void raise(const struct soil_carried *carried, const struct raster *r, const double at[3])
{
	const double by = r->fine / carried->spacing, middle = (carried->half + 0.5) * r->fine;
	const long column = (long)floor(at[0] * by + middle), row = (long)floor(at[1] * by + middle);
	if (column < 0 || row < 0 || column >= r->side || row >= r->side)
		return;
	int32_t *bar = &r->bars[(size_t)row * r->stride + (size_t)column];
	const int32_t z = (int32_t)lattice_offset(at[2]);
	*bar = z > *bar ? z : *bar;
}

/* The top of a wall is on its edges. They are barriers in each place through which they pass. */
static void put_walls(const struct soil_carried *carried, const struct raster *r, double axes[3][3])
{
	const struct soil_mesh *mesh = carried->shape->mesh;
	for (uint32_t t = 0; t < mesh->triangle_count; t++) {
		double at[3][3], a[3], b[3];
		for (int i = 0; i < 3; i++)
			for (int k = 0; k < 3; k++) {
				const float *v = mesh->vertices[mesh->triangles[t][i]];
				at[i][k] = v[0] * axes[0][k] + v[1] * axes[1][k] + v[2] * axes[2][k];
			}
		for (int k = 0; k < 3; k++) {
			a[k] = at[1][k] - at[0][k];
			b[k] = at[2][k] - at[0][k];
		}
		const double n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
		if (fabs(n[2]) > STEEP * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]))
			continue;
		for (int i = 0; i < 3; i++) {
			const double *from = at[i], *to = at[(i + 1) % 3];
			const int parts = (int)ceil(2 * hypot(to[0] - from[0], to[1] - from[1]) * r->fine / carried->spacing) + 1;
			for (int part = 0; part <= parts; part++) {
				double place[3];
				for (int k = 0; k < 3; k++)
					place[k] = from[k] + (to[k] - from[k]) * part / parts;
				raise(carried, r, place);
			}
		}
	}
}

/* --- cells --- */

struct cell {
	const struct raster *raster;
	int x, y;            /* of its first place */
	size_t at;           /* the same */
	int32_t low, high;   /* of its barriers */
	size_t lowest;
};

static bool is_open(const struct raster *r, int x, int y)
{
	return x < 0 || y < 0 || x >= r->side || y >= r->side || r->bars[(size_t)y * r->stride + (size_t)x] == CARRIED_OPEN;
}

/* Finds the way from a place to all places of the cell. */
static void find_ways(const struct cell *cell, size_t from)
{
	const struct raster *r = cell->raster;
	for (int y = 0; y < r->fine; y++)
		for (int x = 0; x < r->fine; x++)
			r->pass[cell->at + (size_t)y * r->stride + (size_t)x] = INT32_MAX;
	r->pass[from] = r->bars[from];
	for (bool again = true; again;) {
		again = false;
		for (int y = 0; y < r->fine; y++)
			for (int x = 0; x < r->fine; x++) {
				const size_t at = cell->at + (size_t)y * r->stride + (size_t)x;
				int32_t way = r->pass[at];
				if (r->bars[at] == CARRIED_OPEN)
					continue;
				const int32_t beside[4] = {x > 0 ? r->pass[at - 1] : INT32_MAX, x + 1 < r->fine ? r->pass[at + 1] : INT32_MAX, y > 0 ? r->pass[at - r->stride] : INT32_MAX,
							   y + 1 < r->fine ? r->pass[at + r->stride] : INT32_MAX};
				for (int k = 0; k < 4; k++)
					way = beside[k] < way ? beside[k] : way;
				way = way < r->bars[at] ? r->bars[at] : way;
				again |= way < r->pass[at];
				r->pass[at] = way < r->pass[at] ? way : r->pass[at];
			}
	}
}

/* Finds the basin of a cell that walls pass through. tolerance: a hollow is deeper. */
static void find_basin(const struct cell *cell, int32_t tolerance)
{
	const struct raster *r = cell->raster;
	size_t here = 0, there = 0, other = cell->lowest;
	find_ways(cell, cell->lowest);
	for (int y = 0; y < r->fine; y++)
		for (int x = 0; x < r->fine; x++) {
			const size_t at = cell->at + (size_t)y * r->stride + (size_t)x;
			if (r->bars[at] == CARRIED_OPEN)
				continue;
			const bool hollow = (int64_t)r->bars[at] + tolerance < r->pass[at];
			here += !hollow && (int64_t)r->bars[at] + tolerance < cell->high;
			there += hollow;
			other = hollow && (other == cell->lowest || r->bars[at] < r->bars[other]) ? at : other;
		}
	if (there > here)
		find_ways(cell, other);
}

/* Returns where soil leaves the basin to beside the body. */
static int32_t lip_of(const struct cell *cell)
{
	const struct raster *r = cell->raster;
	int32_t lip = INT32_MAX;
	for (int y = 0; y < r->fine; y++)
		for (int x = 0; x < r->fine; x++) {
			const int32_t way = r->pass[cell->at + (size_t)y * r->stride + (size_t)x];
			const int gx = cell->x + x, gy = cell->y + y;
			if (!is_open(r, gx, gy) && way < lip && (is_open(r, gx - 1, gy) || is_open(r, gx + 1, gy) || is_open(r, gx, gy - 1) || is_open(r, gx, gy + 1)))
				lip = way;
		}
	return lip == INT32_MAX ? CARRIED_OPEN : lip;
}

/* Finds what one cell is. Returns true if soil passes over sills to its neighbours. */
static bool find_cell(struct soil_carried *carried, const struct raster *r, int column, int row)
{
	const size_t number = (size_t)row * (size_t)carried->side + (size_t)column;
	struct soil_carried_cells *cells = carried->scratch;
	struct cell cell = {.raster = r, .x = column * r->fine, .y = row * r->fine, .low = INT32_MAX, .high = CARRIED_OPEN};
	const int32_t tolerance = (int32_t)lattice_offset(fmin(carried->spacing / 2, 500));
	int64_t sum = 0;
	int count = 0;
	cell.at = (size_t)cell.y * r->stride + (size_t)cell.x;
	for (int y = 0; y < r->fine; y++)
		for (int x = 0; x < r->fine; x++) {
			const size_t at = cell.at + (size_t)y * r->stride + (size_t)x;
			r->pass[at] = r->bars[at] == CARRIED_OPEN ? INT32_MAX : r->bars[at];
			if (r->bars[at] == CARRIED_OPEN)
				continue;
			cell.lowest = r->bars[at] < cell.low ? at : cell.lowest;
			cell.low = r->bars[at] < cell.low ? r->bars[at] : cell.low;
			cell.high = r->bars[at] > cell.high ? r->bars[at] : cell.high;
		}
	carried->tops[number] = cells->lips[number] = CARRIED_OPEN;
	cells->shares[number] = 1;
	if (cell.high == CARRIED_OPEN)
		return false;
	const bool rough = (int64_t)cell.high - cell.low > tolerance;
	if (rough)
		find_basin(&cell, tolerance);
	for (int y = 0; y < r->fine; y++)
		for (int x = 0; x < r->fine; x++) {
			const size_t at = cell.at + (size_t)y * r->stride + (size_t)x;
			if (r->tops[at] == CARRIED_OPEN || (int64_t)r->bars[at] + tolerance < r->pass[at])
				continue;
			sum += r->tops[at];
			count++;
		}
	/* A wall without a thickness is as wide as a place. */
	const int share = count * CARRIED_SHARES / (r->fine * r->fine);
	carried->tops[number] = count > 0 ? (int32_t)(sum / count) : cell.high;
	cells->shares[number] = (uint8_t)(share > 0 ? share : 1);
	cells->lips[number] = lip_of(&cell);
	return rough;
}

/* Returns the barrier of a place; beside the body there is none. */
static int32_t bar_at(const struct raster *r, int x, int y)
{
	return is_open(r, x, y) ? CARRIED_OPEN : r->bars[(size_t)y * r->stride + (size_t)x];
}

static int32_t most_of(int32_t a, int32_t b)
{
	return a > b ? a : b;
}

/* Returns the sill between a cell and the next one along a way: the lowest of the places along their border. */
static int32_t sill_of(const struct raster *r, int column, int row, int way)
{
	const int x = column * r->fine, y = row * r->fine, last = r->fine - 1;
	int32_t sill = INT32_MAX;
	for (int i = 0; i < (way < 2 ? r->fine : 1); i++) {
		const int px = way == 1 ? x + i : way == 3 ? x : x + last, py = way == 0 ? y + i : y + last;
		const int qx = px + ways[way][0], qy = py + ways[way][1];
		int32_t over = most_of(r->pass[(size_t)py * r->stride + (size_t)px], r->pass[(size_t)qy * r->stride + (size_t)qx]);
		if (way >= 2) { /* it also passes between the places beside the corner */
			const int32_t a = bar_at(r, qx, py), b = bar_at(r, px, qy);
			over = most_of(over, a < b ? a : b);
		}
		sill = over < sill ? over : sill;
	}
	return sill;
}

/* Returns the sill between neighbours of which one is (x, y) from the other; CARRIED_OPEN if no wall is there. */
static int32_t sill_between(const struct soil_carried *carried, const struct raster *r, int column, int row, int x, int y)
{
	const uint8_t *rough = ((struct soil_carried_cells *)carried->scratch)->rough;
	const bool back = y < 0 || (y == 0 && x < 0);
	const int from[2] = {back ? column + x : column, back ? row + y : row}, way = y == 0 ? 0 : x == 0 ? 1 : (x > 0) == (y > 0) ? 2 : 3;
	if (!rough[row * carried->side + column] && !rough[(row + y) * carried->side + column + x])
		return CARRIED_OPEN;
	return sill_of(r, from[0], from[1], way);
}

/* Makes a small cell a part of that neighbour to which soil passes most easily. */
static void join_small(struct soil_carried *carried, const struct raster *r, int column, int row)
{
	struct soil_carried_cells *cells = carried->scratch;
	const int side = carried->side;
	const size_t small = (size_t)(row * side + column);
	size_t into = small;
	int32_t least = INT32_MAX;
	for (int y = -1; y <= 1; y++)
		for (int x = -1; x <= 1; x++) {
			if (column + x < 0 || row + y < 0 || column + x >= side || row + y >= side)
				continue;
			const size_t near = (size_t)((row + y) * side + column + x);
			if (near == small || carried->tops[near] == CARRIED_OPEN || cells->shares[near] < SHARE_LEAST)
				continue;
			const int32_t sill = sill_between(carried, r, column, row, x, y);
			if (sill < least) {
				least = sill;
				into = near;
			}
		}
	if (into == small)
		return;
	const int32_t leaves = cells->lips[small] == CARRIED_OPEN ? CARRIED_OPEN : most_of(cells->lips[small], least);
	const int share = cells->shares[small], both = share + cells->shares[into];
	carried->tops[into] = (int32_t)(((int64_t)carried->tops[into] * cells->shares[into] + (int64_t)carried->tops[small] * share) / both);
	cells->shares[into] = (uint8_t)both;
	if (leaves != CARRIED_OPEN && (cells->lips[into] == CARRIED_OPEN || leaves < cells->lips[into]))
		cells->lips[into] = leaves;
	carried->tops[small] = CARRIED_OPEN;
}

void soil_carried_find_tops(struct soil_carried *carried, const struct soil_pose *pose)
{
	const int side = carried->side;
	const struct raster r = sample(carried, pose);
	struct soil_carried_cells *cells = carried->scratch;
	uint8_t *rough = cells->rough;
	if (carried->shape->kind == SOIL_MESH) {
		double axes[3][3];
		soil_axes(-carried->heading, pose->pitch, pose->roll, 0, axes);
		put_walls(carried, &r, axes);
	}
	for (int row = 0; row < side; row++)
		for (int column = 0; column < side; column++)
			rough[row * side + column] = find_cell(carried, &r, column, row);
	for (int row = 0; row < side; row++)
		for (int column = 0; column < side; column++)
			if (carried->tops[row * side + column] != CARRIED_OPEN && cells->shares[row * side + column] < SHARE_LEAST)
				join_small(carried, &r, column, row);
	for (int row = 0; row < side; row++)
		for (int column = 0; column < side; column++)
			for (int k = 0; k < 4; k++) {
				const int x = column + ways[k][0], y = row + ways[k][1];
				const bool walls = x >= 0 && x < side && y < side && (rough[row * side + column] || rough[y * side + x]);
				cells->sills[k][row * side + column] = walls ? sill_of(&r, column, row, k) : CARRIED_OPEN;
			}
}
