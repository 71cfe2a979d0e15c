/* The ground of queries and plain answers about it: every face, in long doubles. */
#include "query_rig.h"

/* --- ground --- */

uint64_t rig_mix(uint64_t v)
{
	v = (v ^ v >> 31) * 0x7fb5d329728ea185ull;
	v = (v ^ v >> 27) * 0x81dadef4bc2dd44dull;
	return v ^ v >> 33;
}

double rig_unit(uint64_t *state)
{
	*state = rig_mix(*state + 0x9e3779b97f4a7c15ull);
	return (double)(*state >> 11) * 0x1p-53;
}

double rig_between(uint64_t *state, double low, double high)
{
	return low + rig_unit(state) * (high - low);
}

double rig_post(const struct rig *rig, int64_t x, int64_t y)
{
	if (x >= rig->extent.width || y >= rig->extent.height)
		return NAN;
	uint64_t hash = rig_mix((uint64_t)(x - rig->far) * 0x10001 + rig_mix((uint64_t)(y - rig->far) + rig->seed));
	if (hash % 1000 < rig->holes)
		return NAN;
	double wave = sin((double)(x - rig->far) / 7) * cos((double)(y - rig->far) / 5);
	double height = rig->relief * (wave + (double)(hash >> 20 & 1023) / 2048);
	return floor(height * 0x1p18) * 0x1p-18;
}

bool rig_present(const struct rig *rig, struct tile tile)
{
	if (!extent_has(&rig->extent, tile))
		return false;
	if (tile.level == rig->finest)
		return rig_mix(tile_key(tile) + rig->seed) % 100 < rig->fine;
	for (unsigned i = 0; i < 4; i++)
		if (rig_present(rig, (struct tile){tile.level - 1, 2 * tile.x + (i & 1), 2 * tile.y + (i >> 1)}))
			return true;
	return false;
}

/* Bilinear without rounding: of dyadic posts it is exact. A post of the finest level has an offset if every tile that has the
 * post is there. */
static double rig_height(const struct rig *rig, int level, int64_t x, int64_t y)
{
	int shift = -level;
	int64_t part = ((int64_t)1 << shift) - 1, cx = x >> shift, cy = y >> shift;
	double u = ldexp((double)(x & part), level), v = ldexp((double)(y & part), level), height = 0;
	const double weights[4] = {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
	for (int i = 0; i < 4; i++)
		if (weights[i] != 0)
			height += weights[i] * rig_post(rig, cx + i % 2, cy + i / 2);
	if (level != rig->finest || level == 0)
		return height;
	int64_t cells = rig->extent.cells;
	height += rig->crack;
	for (int i = 0; i < 4; i++) {
		int64_t tx = x / cells - (i % 2 && x % cells == 0), ty = y / cells - (i / 2 && y % cells == 0);
		if (tx < 0 || ty < 0)
			continue;
		struct tile tile = {level, (uint32_t)tx, (uint32_t)ty};
		if (extent_has(&rig->extent, tile) && !rig_present(rig, tile))
			return height;
	}
	uint64_t hash = rig_mix((uint64_t)x + rig_mix((uint64_t)y * 3 + rig->seed));
	return height - floor(rig->rut * (double)(hash >> 40 & 255) / 255 * 0x1p20) * 0x1p-20;
}

static enum status rig_posts(void *user, struct tile tile, struct resident_posts *posts)
{
	struct rig *rig = user;
	int64_t cells = rig->extent.cells;
	assert_true(extent_has(&rig->extent, tile) && tile.level <= 0 && tile.level >= rig->finest);
	if (++rig->reads == rig->fails_at)
		return fail_with(STATUS_INPUT, "rig: it is broken; mend it");
	for (int64_t y = 0; y <= cells; y++)
		for (int64_t x = 0; x <= cells; x++)
			rig->heights[y * (cells + 1) + x] = rig_height(rig, tile.level, tile.x * cells + x, tile.y * cells + y);
	resident_fill_blocks(rig->extent.cells, rig->heights, rig->blocks);
	*posts = (struct resident_posts){rig->heights, (const double(*)[2])rig->blocks};
	return STATUS_OK;
}

static enum status rig_ask(void *user, struct tile tile, bool *present)
{
	*present = rig_present(user, tile);
	return STATUS_OK;
}

static enum status rig_bounds(void *user, struct tile tile, double *low, double *high, bool *any)
{
	const struct rig *rig = user;
	assert_true(extent_has(&rig->extent, tile));
	/* True of a single post, at least, in every other tile: so that much is passed over. */
	*low = -rig->relief - rig->rut;
	*high = 1.5 * rig->relief + rig->crack;
	*any = true;
	if (tile.level > 0)
		return STATUS_OK;
	double least = INFINITY, most = -INFINITY;
	int64_t side = rig->extent.cells >> -tile.level, cells = rig->extent.cells;
	side = side > 0 ? side : 1;
	int64_t x0 = (tile.x * cells) >> -tile.level, y0 = (tile.y * cells) >> -tile.level;
	for (int64_t y = y0; y <= y0 + side; y++)
		for (int64_t x = x0; x <= x0 + side; x++) {
			double height = rig_post(rig, x, y);
			least = height < least ? height : least;
			most = height > most ? height : most;
		}
	*any = least <= most;
	*low = least - rig->rut;
	*high = most + rig->crack;
	return STATUS_OK;
}

void rig_open(struct rig *rig)
{
	rig->ground = (struct resident_source){rig, &rig->extent, rig->finest, rig_posts, rig_ask, rig_bounds};
}

static void put_corner(const struct rig *rig, int level, int64_t x, int64_t y, double corner[3])
{
	double spacing = extent_spacing(&rig->extent, level);
	corner[0] = (double)x * spacing;
	corner[1] = (double)y * spacing;
	corner[2] = rig_height(rig, level, x, y);
}

/* The faces of one cell. Returns how many. */
static size_t faces_of(const struct rig *rig, int level, int64_t x, int64_t y, struct rig_face faces[2])
{
	size_t count = 0;
	struct rig_face cell = {.cell = true, .level = level};
	double sum = 0;
	for (int i = 0; i < 4; i++) {
		put_corner(rig, level, x + i % 2, y + i / 2, cell.corner[i]);
		sum += cell.corner[i][2];
	}
	faces[0] = cell;
	if (!isnan(sum))
		return 1;
	for (int upper = 0; upper < 2; upper++) {
		struct rig_face face = {.level = level};
		memcpy(face.corner[0], cell.corner[0], sizeof face.corner[0]);
		memcpy(face.corner[1], cell.corner[upper ? 2 : 1], sizeof face.corner[1]);
		memcpy(face.corner[2], cell.corner[3], sizeof face.corner[2]);
		if (!isnan(face.corner[0][2] + face.corner[1][2] + face.corner[2][2]))
			faces[count++] = face;
	}
	return count;
}

size_t rig_faces(const struct rig *rig, struct rig_face **out)
{
	size_t count = 0, room = 1 << 16;
	struct rig_face *all = malloc(room * sizeof *all);
	int64_t across = (rig->extent.width - 1) << -rig->finest, up = (rig->extent.height - 1) << -rig->finest;
	assert_non_null(all);
	for (int level = 0; level >= rig->finest; level--) {
		int64_t width = across >> (level - rig->finest), height = up >> (level - rig->finest), cells = rig->extent.cells;
		for (int64_t y = 0; y < height; y++)
			for (int64_t x = 0; x < width; x++) {
				struct tile own = {level, (uint32_t)(x / cells), (uint32_t)(y / cells)};
				struct tile below = {level - 1, (uint32_t)(2 * x / cells), (uint32_t)(2 * y / cells)};
				if ((level < 0 && !rig_present(rig, own)) || (level > rig->finest && rig_present(rig, below)))
					continue;
				if (count + 2 > room)
					assert_non_null(all = realloc(all, (room *= 2) * sizeof *all));
				count += faces_of(rig, level, x, y, all + count);
			}
	}
	*out = all;
	return count;
}

/* --- plain answers --- */

static long double height_in(const struct rig_face *face, long double u, long double v)
{
	const double(*c)[3] = face->corner;
	return (1 - u) * ((1 - v) * c[0][2] + v * c[2][2]) + u * ((1 - v) * c[1][2] + v * c[3][2]);
}

/* How far a ray is above a cell's ground t metres from its origin. *inside: it is over the cell, made larger by `slack`. */
static long double above(const struct rig_face *face, const long double origin[3], const long double way[3], long double t, long double slack, bool *inside)
{
	const double(*c)[3] = face->corner;
	long double side = c[1][0] - c[0][0], u = (origin[0] + t * way[0] - c[0][0]) / side, v = (origin[1] + t * way[1] - c[0][1]) / side;
	*inside = u >= -slack && v >= -slack && u <= 1 + slack && v <= 1 + slack;
	return origin[2] + t * way[2] - height_in(face, u, v);
}

/* The same as `meets`, for a cell: along the ray the difference is a parabola, found from three of its places. */
static long double meets_cell(const struct rig_face *face, const long double origin[3], const long double way[3], long double slack)
{
	const double(*c)[3] = face->corner;
	bool inside;
	/* around where the ray passes the cell's middle; in units of its side */
	long double side = c[1][0] - c[0][0], level = way[0] * way[0] + way[1] * way[1];
	long double middle = level > 0 ? ((c[0][0] + side / 2 - origin[0]) * way[0] + (c[0][1] + side / 2 - origin[1]) * way[1]) / level : 0;
	long double step = level > 0 ? side / sqrtl(level) : side;
	long double zero = above(face, origin, way, middle, slack, &inside), plus = above(face, origin, way, middle + step, slack, &inside);
	long double minus = above(face, origin, way, middle - step, slack, &inside);
	long double a = (plus + minus) / 2 - zero, b = (plus - minus) / 2, found = INFINITY;
	long double root = b * b - 4 * a * zero, roots[2] = {NAN, NAN};
	if (root >= 0 && (a != 0 || b != 0)) {
		long double q = -0.5L * (b + copysignl(sqrtl(root), b));
		roots[0] = q != 0 ? zero / q : 0;
		roots[1] = a != 0 ? q / a : (long double)NAN;
	}
	for (int i = 0; i < 2; i++) {
		long double t = middle + roots[i] * step;
		if (isnan(t) || t < -slack)
			continue;
		above(face, origin, way, t, slack, &inside);
		if (inside && t < found)
			found = t;
	}
	return found;
}

/* Where the ray meets a triangle, made larger or smaller by `slack`; INFINITY: nowhere. */
static long double meets(const struct rig_face *triangle, const long double origin[3], const long double way[3],
			 long double slack)
{
	const double(*c)[3] = triangle->corner;
	long double e[3], f[3], p[3], s[3], q[3];
	for (int i = 0; i < 3; i++) {
		e[i] = (long double)c[1][i] - c[0][i];
		f[i] = (long double)c[2][i] - c[0][i];
		s[i] = origin[i] - c[0][i];
	}
	for (int i = 0; i < 3; i++) {
		int j = (i + 1) % 3, k = (i + 2) % 3;
		p[i] = way[j] * f[k] - way[k] * f[j];
		q[i] = s[j] * e[k] - s[k] * e[j];
	}
	long double det = e[0] * p[0] + e[1] * p[1] + e[2] * p[2];
	if (det == 0)
		return INFINITY;
	long double u = (s[0] * p[0] + s[1] * p[1] + s[2] * p[2]) / det;
	long double v = (way[0] * q[0] + way[1] * q[1] + way[2] * q[2]) / det;
	long double t = (f[0] * q[0] + f[1] * q[1] + f[2] * q[2]) / det;
	return u >= -slack && v >= -slack && u + v <= 1 + slack && t >= -slack ? t : INFINITY;
}

/* Seen from above the ray's line passes a face by: corner 0 is farther from it than any point of the face is from that corner,
 * sqrt(2) sides, and a third more. `across`: length of the direction from above. */
static bool passes_by(const struct rig_face *face, const struct resident_ray *ray, double across)
{
	const double(*c)[3] = face->corner;
	double x = c[0][0] - ray->origin[0], y = c[0][1] - ray->origin[1];
	double reach = 2 * (fabs(c[1][0] - c[0][0]) + fabs(c[1][1] - c[0][1])); /* two sides */
	return fabs(ray->direction[0] * y - ray->direction[1] * x) > across * reach;
}

struct rig_strike rig_strike(const struct rig_face *all, size_t count, const struct resident_ray *ray, long double slack)
{
	struct rig_strike struck = {INFINITY, NULL};
	long double origin[3], way[3], length = 0;
	for (int i = 0; i < 3; i++) {
		origin[i] = ray->origin[i];
		way[i] = ray->direction[i];
		length += way[i] * way[i];
	}
	for (int i = 0; i < 3; i++)
		way[i] /= sqrtl(length);
	double across = hypot(ray->direction[0], ray->direction[1]);
	for (size_t i = 0; i < count; i++) {
		if (passes_by(&all[i], ray, across))
			continue;
		long double t = all[i].cell ? meets_cell(&all[i], origin, way, slack) : meets(&all[i], origin, way, slack);
		if (t <= ray->length + slack && t < struck.first)
			struck = (struct rig_strike){t, &all[i]};
	}
	return struck;
}

/* Where a point is between corner 0 and corners 1 and 2. */
static void place_in(const struct rig_face *face, long double x, long double y, long double *u, long double *v)
{
	const double(*c)[3] = face->corner;
	long double ex = c[1][0] - c[0][0], ey = c[1][1] - c[0][1], fx = c[2][0] - c[0][0], fy = c[2][1] - c[0][1];
	long double det = ex * fy - ey * fx;
	x -= c[0][0];
	y -= c[0][1];
	*u = (x * fy - y * fx) / det;
	*v = (ex * y - ey * x) / det;
}

static long double height_of(const struct rig_face *face, long double x, long double y)
{
	const double(*c)[3] = face->corner;
	long double u, v;
	place_in(face, x, y, &u, &v);
	return face->cell ? height_in(face, u, v) : c[0][2] + u * (c[1][2] - c[0][2]) + v * (c[2][2] - c[0][2]);
}

void rig_normal(const struct rig_face *face, long double x, long double y, double normal[3])
{
	/* along an axis the ground is linear, so that any difference is exact */
	long double east = (height_of(face, x + 0.25L, y) - height_of(face, x - 0.25L, y)) * 2;
	long double north = (height_of(face, x, y + 0.25L) - height_of(face, x, y - 0.25L)) * 2, length = sqrtl(east * east + north * north + 1);
	normal[0] = (double)(-east / length);
	normal[1] = (double)(-north / length);
	normal[2] = (double)(1 / length);
}

const struct rig_face *rig_over(const struct rig_face *all, size_t count, struct resident_point point, double slack, double *height,
				double normal[3])
{
	for (size_t i = 0; i < count; i++) {
		long double u, v;
		place_in(&all[i], point.x, point.y, &u, &v);
		if (u < slack || v < slack || (all[i].cell ? u > 1 - slack || v > 1 - slack : u + v > 1 - slack))
			continue;
		*height = (double)height_of(&all[i], point.x, point.y);
		rig_normal(&all[i], point.x, point.y, normal);
		return &all[i];
	}
	return NULL;
}
