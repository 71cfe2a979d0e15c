/*
 * Rays: down the quadtree by bounds, front to back; then from block to block and cell to cell in the tiles at
 * its leaves.
 *
 * A ray is cut into pieces, one after another along it. Each is over one cell, over one triangle of a cell that lacks a post, or
 * over no ground. Over ground, what matters is whether the ray is above it or below. Invariants:
 *
 * 1. Pieces are told in order and without a gap wider than a rounding. Where a node is passed over, or there is
 *    no ground, the side is forgotten.
 * 2. The side at a piece's end is compared with that at the next one's begin. So whatever rounding does where
 *    two cells meet, and however slanted the ray, it cannot be above here and below there without a hit.
 * 3. A node is passed over only if the ray stays CLEAR of its bounds. CLEAR is more than the heights of neighbours can differ
 *    along their common edge, by roundings of the lattice. So the ray comes out on the same side, unless there was a hole.
 */
#include "resident/cell.h"

#define CLEAR 0x1p-10 /* metres */

enum side { SIDE_UNKNOWN, SIDE_ABOVE, SIDE_BELOW };

struct ray {
	const struct resident_source *ground;
	double origin[3], way[3]; /* way: of length 1 */
	double spacing;           /* of the tile below, and the ray in its cells: at + t step */
	double at[2], step[2];
	uint32_t in[2];           /* of its cells in the world: what is on the edge is in the last */
	struct tile tile;
	struct resident_posts posts;
	enum side side;
	struct resident_hit *hit;
};

static void hit_at(struct ray *ray, double t, bool below, const struct resident_plane *plane, uint32_t x, uint32_t y)
{
	struct resident_hit *hit = ray->hit;
	*hit = (struct resident_hit){.hit = true, .below = below, .distance = t, .tile = ray->tile, .x = x, .y = y};
	for (int i = 0; i < 3; i++)
		hit->point[i] = ray->origin[i] + t * ray->way[i];
	/* A ray straight down does not move in the cell. */
	const double u = ray->at[0] - x + (ray->step[0] == 0 ? 0 : t * ray->step[0]), v = ray->at[1] - y + (ray->step[1] == 0 ? 0 : t * ray->step[1]);
	resident_plane_normal(plane, fmin(fmax(u, 0), 1), fmin(fmax(v, 0), 1), ray->spacing, hit->normal);
}

/* How far a ray is above the ground: over + rate s + bend s^2, with s metres along the ray from the begin of a piece. */
struct above {
	double over, rate, bend;
};

static struct above above_of(const struct ray *ray, const struct resident_plane *plane, uint32_t x, uint32_t y, double begin)
{
	const double su = ray->step[0], sv = ray->step[1], p = plane->slope[0], q = plane->slope[1], twist = plane->twist;
	const double u = ray->at[0] - x + (su == 0 ? 0 : begin * su), v = ray->at[1] - y + (sv == 0 ? 0 : begin * sv);
	return (struct above){
		.over = ray->origin[2] + begin * ray->way[2] - (plane->at + p * u + q * v + twist * u * v),
		.rate = ray->way[2] - p * su - q * sv - twist * (u * sv + v * su),
		.bend = -twist * su * sv,
	};
}

/* Returns the first s from 0 to `length` at which the ray meets the ground; NAN: nowhere. `length` may be infinite if bend is 0. */
static double meets(const struct above *above, double length)
{
	const double a = above->bend, b = above->rate, c = above->over;
	const double last = isinf(length) ? (b == 0 ? c : b * length) : c + length * (b + a * length);
	const bool crosses = c > 0 ? last <= 0 : last >= 0; /* an odd number of times */
	double first = (double)NAN;
	if (a == 0) {
		first = -c / b;
	} else if (b * b >= 4 * a * c) {
		const double q = -0.5 * (b + copysign(sqrt(b * b - 4 * a * c), b)), one = q / a, other = q != 0 ? c / q : one;
		const double low = fmin(one, other), high = fmax(one, other);
		first = low >= 0 ? low : high;
	}
	if (crosses) /* also if rounding puts the first place outside, or finds none */
		return isnan(first) ? length : fmin(fmax(first, 0), length);
	return a != 0 && first >= 0 && first <= length ? first : (double)NAN;
}

/* Over one cell or triangle from `begin` to `end`, which may be infinite. True: hit. */
static bool piece(struct ray *ray, double begin, double end, const struct resident_plane *plane, uint32_t x, uint32_t y)
{
	if (!resident_plane_whole(plane)) {
		ray->side = SIDE_UNKNOWN;
		return false;
	}
	const struct above above = above_of(ray, plane, x, y, begin);
	const enum side side = above.over > 0 ? SIDE_ABOVE : above.over < 0 ? SIDE_BELOW : SIDE_UNKNOWN;
	if (side == SIDE_UNKNOWN || (ray->side != SIDE_UNKNOWN && side != ray->side)) {
		bool below = ray->side != SIDE_UNKNOWN ? ray->side == SIDE_BELOW : above.rate > 0;
		hit_at(ray, begin, below, plane, x, y);
		return true;
	}
	ray->side = side;
	const double met = meets(&above, end - begin);
	if (isnan(met))
		return false;
	hit_at(ray, begin + met, side == SIDE_BELOW, plane, x, y);
	return true;
}

static bool in_cell(struct ray *ray, uint32_t x, uint32_t y, double begin, double end)
{
	const size_t stride = ray->ground->extent->cells + 1;
	const double *sw = ray->posts.heights + y * stride + x;
	const struct resident_plane cell = resident_cell_of(sw, stride);
	if (resident_plane_whole(&cell))
		return piece(ray, begin, end, &cell, x, y);
	const struct resident_plane lower = resident_plane_of(sw, stride, false), upper = resident_plane_of(sw, stride, true);
	/* The sign of `apart` tells on which side of the diagonal the ray is. */
	const double apart = (ray->at[0] - x) - (ray->at[1] - y), rate = ray->step[0] - ray->step[1];
	const double first = apart + rate * begin, last = rate == 0 ? apart : apart + rate * end;
	if (first == 0 && last == 0)
		return piece(ray, begin, end, resident_plane_whole(&lower) ? &lower : &upper, x, y);
	if ((first >= 0 && last >= 0) || (first <= 0 && last <= 0))
		return piece(ray, begin, end, first + last < 0 ? &upper : &lower, x, y);
	const double middle = fmin(fmax(-apart / rate, begin), end);
	return piece(ray, begin, middle, first < 0 ? &upper : &lower, x, y) || piece(ray, middle, end, last < 0 ? &upper : &lower, x, y);
}

/* Returns true if the ray between `begin` and `end` stays above or below all heights in this range. */
static bool is_clear(const struct ray *ray, double begin, double end, double low, double high)
{
	const double first = ray->origin[2] + begin * ray->way[2];
	const double last = ray->way[2] == 0 ? first : ray->origin[2] + end * ray->way[2];
	return fmin(first, last) > high + CLEAR || fmax(first, last) < low - CLEAR;
}

struct cell_rect {
	uint32_t x0, y0, x1, y1; /* in squares */
};

/* Returns the ray parameter at which the ray leaves a row of squares. Each square is `size` cells wide. */
static double leaves(double at, double step, uint32_t square, uint32_t size)
{
	if (step == 0)
		return INFINITY;
	return ((square + (step > 0)) * (double)size - at) / step;
}

static uint32_t square_of(double at, uint32_t size, uint32_t first, uint32_t end)
{
	const double square = floor(at / size);
	return square <= first ? first : square >= end ? end - 1 : (uint32_t)square;
}

static uint32_t least(uint32_t a, uint32_t b)
{
	return a < b ? a : b;
}

static bool march(struct ray *ray, struct cell_rect rect, uint32_t size, double begin, double end);

static bool in_block(struct ray *ray, uint32_t x, uint32_t y, double begin, double end)
{
	const double *range = ray->posts.blocks[(size_t)y * (ray->ground->extent->cells / RESIDENT_BLOCK) + x];
	if (is_clear(ray, begin, end, range[0], range[1])) {
		ray->side = SIDE_UNKNOWN;
		return false;
	}
	const struct cell_rect cells = {x * RESIDENT_BLOCK, y * RESIDENT_BLOCK, least((x + 1) * RESIDENT_BLOCK, ray->in[0]),
					least((y + 1) * RESIDENT_BLOCK, ray->in[1])};
	return march(ray, cells, 1, begin, end);
}

/* Through the squares of the rectangle, each of size x size cells: blocks, or cells. */
static bool march(struct ray *ray, struct cell_rect rect, uint32_t size, double begin, double end)
{
	uint32_t x = square_of(ray->at[0] + (ray->step[0] == 0 ? 0 : begin * ray->step[0]), size, rect.x0, rect.x1);
	uint32_t y = square_of(ray->at[1] + (ray->step[1] == 0 ? 0 : begin * ray->step[1]), size, rect.y0, rect.y1);
	for (;;) {
		const double next_x = leaves(ray->at[0], ray->step[0], x, size), next_y = leaves(ray->at[1], ray->step[1], y, size);
		const double until = fmax(fmin(fmin(next_x, next_y), end), begin);
		if (size == 1 ? in_cell(ray, x, y, begin, until) : in_block(ray, x, y, begin, until))
			return true;
		/* Unsigned: one below the first is beyond the end, too. */
		if (next_x <= next_y)
			x += ray->step[0] > 0 ? 1 : UINT32_MAX;
		else
			y += ray->step[1] > 0 ? 1 : UINT32_MAX;
		if (until >= end || x - rect.x0 >= rect.x1 - rect.x0 || y - rect.y0 >= rect.y1 - rect.y0)
			return false;
		begin = until;
	}
}

static enum status in_posts(struct ray *ray, struct tile tile, struct cell_rect blocks, double begin, double end)
{
	const struct resident_source *ground = ray->ground;
	TRY(ground->posts(ground->user, tile, &ray->posts));
	ray->tile = tile;
	ray->in[0] = resident_cells_in(ground->extent, tile.level, tile.x, ground->extent->width);
	ray->in[1] = resident_cells_in(ground->extent, tile.level, tile.y, ground->extent->height);
	blocks.x1 = least(blocks.x1, (ray->in[0] + RESIDENT_BLOCK - 1) / RESIDENT_BLOCK);
	blocks.y1 = least(blocks.y1, (ray->in[1] + RESIDENT_BLOCK - 1) / RESIDENT_BLOCK);
	ray->spacing = extent_spacing(ground->extent, tile.level);
	const double side = ray->spacing * ground->extent->cells, corner[2] = {tile.x * side, tile.y * side};
	for (int i = 0; i < 2; i++) {
		ray->at[i] = (ray->origin[i] - corner[i]) / ray->spacing;
		ray->step[i] = ray->way[i] / ray->spacing;
	}
	march(ray, blocks, RESIDENT_BLOCK, begin, end);
	return STATUS_OK;
}

static enum status in_tile(struct ray *ray, struct tile tile, double begin, double end);

/* Follows the ray through a quarter of a tile. Uses the child tile there, or the posts of the tile itself if there is no child. */
static enum status in_quarter(struct ray *ray, struct tile tile, bool east, bool north, double begin, double end)
{
	const struct resident_source *ground = ray->ground;
	struct tile child = {tile.level - 1, 2 * tile.x + east, 2 * tile.y + north};
	/* At the edge of the world the quarter may have no child tile. Its posts are then in the last tile before it. */
	if (child.x >= extent_tiles_x(ground->extent, child.level))
		child.x--;
	if (child.y >= extent_tiles_y(ground->extent, child.level))
		child.y--;
	bool present = true;
	if (child.level < 0)
		TRY(ground->present(ground->user, child, &present));
	if (present)
		return in_tile(ray, child, begin, end);
	const uint32_t half = ground->extent->cells / RESIDENT_BLOCK / 2;
	if (half == 0) /* the tile is one block: the ray is cut, that is enough */
		return in_posts(ray, tile, (struct cell_rect){0, 0, 1, 1}, begin, end);
	const uint32_t x = child.x & 1 ? half : 0, y = child.y & 1 ? half : 0;
	return in_posts(ray, tile, (struct cell_rect){x, y, x + half, y + half}, begin, end);
}

/* Returns the ray parameter at which the ray crosses the middle of a tile along this axis; INFINITY: never. *beyond: the ray is on
 * the eastern or northern side before it crosses. */
static double crosses(const struct ray *ray, int axis, uint32_t tile, double side, bool *beyond)
{
	const double middle = (tile + 0.5) * side, way = ray->way[axis];
	*beyond = way == 0 ? ray->origin[axis] >= middle : way < 0;
	return way == 0 ? INFINITY : (middle - ray->origin[axis]) / way;
}

static enum status in_tile(struct ray *ray, struct tile tile, double begin, double end)
{
	const struct resident_source *ground = ray->ground;
	double low, high;
	bool any;
	TRY(ground->bounds(ground->user, tile, &low, &high, &any));
	if (!any || is_clear(ray, begin, end, low, high)) {
		ray->side = SIDE_UNKNOWN;
		return STATUS_OK;
	}
	if (tile.level <= 0 && tile.level == ground->finest) {
		const uint32_t blocks = ground->extent->cells / RESIDENT_BLOCK;
		return in_posts(ray, tile, (struct cell_rect){0, 0, blocks, blocks}, begin, end);
	}
	const double side = extent_spacing(ground->extent, tile.level) * ground->extent->cells;
	bool east, north;
	const double x = crosses(ray, 0, tile.x, side, &east), y = crosses(ray, 1, tile.y, side, &north);
	for (;;) {
		double until = end;
		until = x > begin && x < until ? x : until;
		until = y > begin && y < until ? y : until;
		TRY(in_quarter(ray, tile, east != (x <= begin), north != (y <= begin), begin, until));
		if (until >= end || ray->hit->hit)
			return STATUS_OK;
		begin = until;
	}
}

/* Finds the part of the ray that is over the world. */
static bool clip(const struct extent *extent, const struct ray *ray, double length, double *begin, double *end)
{
	const double most[2] = {(double)(extent->width - 1) * extent->spacing, (double)(extent->height - 1) * extent->spacing};
	*begin = 0;
	*end = length;
	for (int i = 0; i < 2; i++) {
		const double way = ray->way[i];
		if (way == 0 && !(ray->origin[i] >= 0 && ray->origin[i] <= most[i]))
			return false;
		if (way == 0)
			continue;
		*begin = fmax(*begin, ((way > 0 ? 0 : most[i]) - ray->origin[i]) / way);
		*end = fmin(*end, ((way > 0 ? most[i] : 0) - ray->origin[i]) / way);
	}
	return *begin <= *end;
}

/* Fills origin and way. */
static enum status take(const struct resident_ray *asked, size_t index, struct ray *ray)
{
	double most = 0, sum = 0;
	bool finite = asked->length >= 0;
	for (int i = 0; i < 3; i++) {
		finite = finite && isfinite(asked->origin[i]) && isfinite(asked->direction[i]);
		most = fmax(most, fabs(asked->direction[i]));
	}
	if (!finite)
		return fail_with(STATUS_INPUT, "ray %zu: an origin or a direction that is no number, or a length that is "
				 "none or negative; give metres", index);
	if (most == 0)
		return fail_with(STATUS_INPUT, "ray %zu: its direction is 0 0 0; give one", index);
	/* Neither what is huge nor what is tiny may be lost in the squares. */
	for (int i = 0; i < 3; i++) {
		ray->way[i] = asked->direction[i] / most;
		sum += ray->way[i] * ray->way[i];
	}
	for (int i = 0; i < 3; i++) {
		ray->origin[i] = asked->origin[i];
		ray->way[i] /= sqrt(sum);
	}
	return STATUS_OK;
}

enum status resident_rays(const struct resident_source *ground, const struct resident_ray *rays, size_t count,
			 struct resident_hit *hits)
{
	const struct tile all = {extent_coarsest(ground->extent), 0, 0};
	for (size_t i = 0; i < count; i++) {
		struct ray ray = {.ground = ground, .hit = &hits[i]};
		double begin, end;
		hits[i] = (struct resident_hit){.hit = false};
		TRY(take(&rays[i], i, &ray));
		if (clip(ground->extent, &ray, rays[i].length, &begin, &end))
			TRY(in_tile(&ray, all, begin, end));
	}
	return STATUS_OK;
}
