/* The ground of queries and plain answers about it: every triangle, in long doubles. */
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

static enum status rig_posts(void *user, struct tile tile, struct terrain_posts *posts)
{
	struct rig *rig = user;
	int64_t cells = rig->extent.cells;
	assert_true(extent_has(&rig->extent, tile) && tile.level <= 0 && tile.level >= rig->finest);
	if (++rig->reads == rig->fails_at)
		return fail_with(STATUS_INPUT, "rig: it is broken; mend it");
	for (int64_t y = 0; y <= cells; y++)
		for (int64_t x = 0; x <= cells; x++)
			rig->heights[y * (cells + 1) + x] = rig_height(rig, tile.level, tile.x * cells + x, tile.y * cells + y);
	terrain_fill_blocks(rig->extent.cells, rig->heights, rig->blocks);
	*posts = (struct terrain_posts){rig->heights, (const double(*)[2])rig->blocks};
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
	rig->ground = (struct terrain_ground){rig, &rig->extent, rig->finest, rig_posts, rig_ask, rig_bounds};
}

size_t rig_triangles(const struct rig *rig, struct rig_triangle **out)
{
	size_t count = 0, room = 1 << 16;
	struct rig_triangle *all = malloc(room * sizeof *all);
	int64_t across = (rig->extent.width - 1) << -rig->finest, up = (rig->extent.height - 1) << -rig->finest;
	assert_non_null(all);
	for (int level = 0; level >= rig->finest; level--) {
		int64_t width = across >> (level - rig->finest), height = up >> (level - rig->finest), cells = rig->extent.cells;
		double spacing = extent_spacing(&rig->extent, level);
		for (int64_t y = 0; y < height; y++)
			for (int64_t x = 0; x < width; x++) {
				struct tile own = {level, (uint32_t)(x / cells), (uint32_t)(y / cells)};
				struct tile below = {level - 1, (uint32_t)(2 * x / cells), (uint32_t)(2 * y / cells)};
				if ((level < 0 && !rig_present(rig, own)) || (level > rig->finest && rig_present(rig, below)))
					continue;
				for (int upper = 0; upper < 2; upper++) {
					const int64_t corners[3][2] = {{x, y}, {x + !upper, y + upper}, {x + 1, y + 1}};
					struct rig_triangle triangle = {.level = level};
					for (int i = 0; i < 3; i++) {
						triangle.corner[i][0] = (double)corners[i][0] * spacing;
						triangle.corner[i][1] = (double)corners[i][1] * spacing;
						triangle.corner[i][2] = rig_height(rig, level, corners[i][0], corners[i][1]);
					}
					if (isnan(triangle.corner[0][2] + triangle.corner[1][2] + triangle.corner[2][2]))
						continue;
					if (count == room)
						assert_non_null(all = realloc(all, (room *= 2) * sizeof *all));
					all[count++] = triangle;
				}
			}
	}
	*out = all;
	return count;
}

/* --- plain answers --- */

/* Where the ray meets a triangle, made larger or smaller by `slack`; INFINITY: nowhere. */
static long double meets(const struct rig_triangle *triangle, const long double origin[3], const long double way[3],
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

/* Seen from above the ray's line passes a triangle by: corner 0 is farther from it than any point of the triangle is from that corner,
 * sqrt(2) sides, and a third more. `across`: length of the direction from above. */
static bool passes_by(const struct rig_triangle *triangle, const struct terrain_ray *ray, double across)
{
	const double(*c)[3] = triangle->corner;
	double x = c[0][0] - ray->origin[0], y = c[0][1] - ray->origin[1];
	double reach = c[2][0] - c[0][0] + (c[2][1] - c[0][1]); /* two sides: corner 2 is opposite to corner 0 in the cell */
	return fabs(ray->direction[0] * y - ray->direction[1] * x) > across * reach;
}

struct rig_strike rig_strike(const struct rig_triangle *all, size_t count, const struct terrain_ray *ray, long double slack)
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
		long double t = meets(&all[i], origin, way, slack);
		if (t <= ray->length + slack && t < struck.first)
			struck = (struct rig_strike){t, &all[i]};
	}
	return struck;
}

const struct rig_triangle *rig_over(const struct rig_triangle *all, size_t count, struct terrain_point point, double slack,
				    double *height)
{
	for (size_t i = 0; i < count; i++) {
		const double(*c)[3] = all[i].corner;
		long double ex = c[1][0] - c[0][0], ey = c[1][1] - c[0][1], fx = c[2][0] - c[0][0], fy = c[2][1] - c[0][1];
		long double x = (long double)point.x - c[0][0], y = (long double)point.y - c[0][1], det = ex * fy - ey * fx;
		long double u = (x * fy - y * fx) / det, v = (ex * y - ey * x) / det;
		if (u < slack || v < slack || u + v > 1 - slack)
			continue;
		*height = (double)(c[0][2] + u * (c[1][2] - c[0][2]) + v * (c[2][2] - c[0][2]));
		return &all[i];
	}
	return NULL;
}
