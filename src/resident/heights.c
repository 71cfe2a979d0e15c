/*
 * Heights at points: those of one tile together, so that each tile is asked for once however the points lie.
 *
 * Points are sorted by the key of the finest tile that could hold them; the tile that does is it or one above it.
 */
#include <stdlib.h>

#include "resident/cell.h"

#define BESIDE 1e-7 /* of a cell: a point no further from a post's row is on it */

struct place {
	uint64_t key; /* of the finest level; UINT64_MAX: outside */
	size_t index;
};

static int compare(const void *a, const void *b)
{
	const struct place *p = a, *q = b;
	if (p->key != q->key)
		return p->key < q->key ? -1 : 1;
	return p->index < q->index ? -1 : p->index > q->index;
}

/* Returns the number of the tile along one side that contains a position; there are `tiles` of them. The position is in the
 * world. */
static uint32_t along(double at, double side, uint32_t tiles)
{
	double tile = floor(at / side);
	return tile < tiles ? (uint32_t)tile : tiles - 1;
}

static void sides_of(const struct extent *extent, double most[2])
{
	most[0] = (double)(extent->width - 1) * extent->spacing;
	most[1] = (double)(extent->height - 1) * extent->spacing;
}

/* Onto the world, where it is a rounding beside it. */
static bool inside(const struct extent *extent, struct resident_point point, double on[2])
{
	const double asked[2] = {point.x, point.y};
	double most[2], slack = BESIDE * extent->spacing;
	sides_of(extent, most);
	for (int i = 0; i < 2; i++) {
		if (!(asked[i] >= -slack && asked[i] <= most[i] + slack))
			return false;
		on[i] = fmin(fmax(asked[i], 0), most[i]);
	}
	return true;
}

static uint64_t finest_key(const struct resident_source *ground, struct resident_point point)
{
	const struct extent *extent = ground->extent;
	double on[2], side = extent_spacing(extent, ground->finest) * extent->cells;
	if (!inside(extent, point, on))
		return UINT64_MAX;
	return tile_key((struct tile){ground->finest, along(on[0], side, extent_tiles_x(extent, ground->finest)),
				      along(on[1], side, extent_tiles_y(extent, ground->finest))});
}

/* Finds the tile whose triangles are the ground at a point. */
static enum status resolve(const struct resident_source *ground, struct tile finest, struct tile *tile)
{
	*tile = tile_ancestor(finest, 0);
	while (tile->level > finest.level) {
		struct tile below = tile_ancestor(finest, tile->level - 1);
		bool present;
		TRY(ground->present(ground->user, below, &present));
		if (!present)
			return STATUS_OK;
		*tile = below;
	}
	return STATUS_OK;
}

static void measure(const struct extent *extent, struct tile tile, const struct resident_posts *posts, const double on[2],
		    struct resident_height *height)
{
	const double spacing = extent_spacing(extent, tile.level), cells = extent->cells;
	/* On the world's edge it is in the last cell. */
	const uint32_t in[2] = {resident_cells_in(extent, tile.level, tile.x, extent->width),
				resident_cells_in(extent, tile.level, tile.y, extent->height)};
	double place[2] = {on[0] / spacing - tile.x * cells, on[1] / spacing - tile.y * cells}, part[2];
	size_t cell[2];
	for (int i = 0; i < 2; i++) {
		double whole = fmin(fmax(floor(place[i]), 0), in[i] - 1.0);
		cell[i] = (size_t)whole;
		part[i] = fmin(fmax(place[i] - whole, 0), 1);
	}
	const size_t stride = extent->cells + 1;
	const double *sw = posts->heights + cell[1] * stride + cell[0];
	const double u = part[0], v = part[1];
	const bool upper = v > u;
	const double corners[3] = {sw[0], upper ? sw[stride] : sw[1], sw[stride + 1]};
	const double weights[3] = {1 - fmax(u, v), fabs(u - v), fmin(u, v)};
	const double all[4] = {sw[0], sw[1], sw[stride], sw[stride + 1]};
	struct resident_plane plane = resident_cell_of(sw, stride);
	height->level = tile.level;
	height->bilinear = lattice_bilinear(all, u, v, BESIDE);
	height->height = height->bilinear;
	if (!resident_plane_whole(&plane)) {
		plane = resident_plane_of(sw, stride, upper);
		height->height = lattice_weighted(corners, weights, 3, BESIDE);
	}
	height->nodata = isnan(height->height);
	if (!height->nodata)
		resident_plane_normal(&plane, u, v, spacing, height->normal);
}

/* Computes the heights of all points. `places` has the points' keys and is sorted. */
static enum status measure_all(const struct resident_source *ground, const struct place *places,
			       const struct resident_point *points, size_t count, struct resident_height *heights)
{
	struct tile tile = {0};
	struct resident_posts posts;
	uint64_t at = UINT64_MAX;
	bool held = false;
	for (size_t i = 0; i < count; i++) {
		struct resident_height *height = &heights[places[i].index];
		double on[2];
		*height = (struct resident_height){NAN, NAN, {NAN, NAN, NAN}, 0, true, true};
		if (places[i].key == UINT64_MAX)
			continue;
		if (places[i].key != at) {
			struct tile found;
			TRY(resolve(ground, tile_from_key(places[i].key), &found));
			if (!(held && tile_equal(found, tile)))
				TRY(ground->posts(ground->user, found, &posts));
			tile = found;
			held = true;
			at = places[i].key;
		}
		height->outside = false;
		inside(ground->extent, points[places[i].index], on);
		measure(ground->extent, tile, &posts, on, height);
	}
	return STATUS_OK;
}

enum status resident_heights(const struct resident_source *ground, const struct resident_point *points, size_t count,
			    struct resident_height *heights)
{
	struct place one, *places = count > 1 ? mem_alloc(count, sizeof *places) : &one;
	TRY_MEM(places, "the points that are asked for");
	for (size_t i = 0; i < count; i++)
		places[i] = (struct place){finest_key(ground, points[i]), i};
	if (count > 1)
		qsort(places, count, sizeof *places, compare);
	enum status status = measure_all(ground, places, points, count, heights);
	if (places != &one)
		mem_free(places);
	return status;
}

void resident_fill_blocks(uint32_t cells, const double *heights, double (*blocks)[2])
{
	const uint32_t side = cells / RESIDENT_BLOCK;
	for (uint32_t by = 0; by < side; by++)
		for (uint32_t bx = 0; bx < side; bx++) {
			double low = INFINITY, high = -INFINITY;
			for (uint32_t y = 0; y <= RESIDENT_BLOCK; y++) {
				const double *row = heights + (size_t)(by * RESIDENT_BLOCK + y) * (cells + 1) + bx * RESIDENT_BLOCK;
				/* NaN compares as false: it counts as nothing. */
				for (uint32_t x = 0; x <= RESIDENT_BLOCK; x++) {
					low = row[x] < low ? row[x] : low;
					high = row[x] > high ? row[x] : high;
				}
			}
			blocks[by * side + bx][0] = low;
			blocks[by * side + bx][1] = high;
		}
}
