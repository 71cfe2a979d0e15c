/* What a row tells of its posts: their range, their sums, whether all are zero. Pure. */
#include "store/internal.h"

#include <math.h>

double store_rows_metres(enum row_table table, int32_t post, double step)
{
	return table == ROW_BASE    ? height_code_metres(post, step)
				    : plane_value(row_plane(table), post);
}

void store_rows_range(enum row_table table, const int32_t *posts, size_t count, double step, double *low,
		double *high)
{
	int32_t least = INT32_MAX, most = INT32_MIN;
	for (size_t i = 0; i < count; i++) {
		if (table == ROW_BASE && posts[i] == HEIGHT_CODE_NODATA)
			continue;
		const bool parts = table == ROW_SHEAR;
		const int32_t east = parts ? plane_shear(posts[i], PLANE_SHEAR_EAST) : posts[i];
		const int32_t north = parts ? plane_shear(posts[i], PLANE_SHEAR_NORTH) : posts[i];
		least = least < east ? least : east;
		least = least < north ? least : north;
		most = most > east ? most : east;
		most = most > north ? most : north;
	}
	*low = *high = (double)NAN;
	if (least > most)
		return;
	if (table == ROW_SHEAR) {
		*low = ldexp(least, -PLANE_SHEAR_BITS);
		*high = ldexp(most, -PLANE_SHEAR_BITS);
		return;
	}
	/* Codes keep the order of heights. */
	*low = store_rows_metres(table, least, step);
	*high = store_rows_metres(table, most, step);
}

bool store_rows_all_zero(const int32_t *posts, size_t count)
{
	for (size_t i = 0; i < count; i++)
		if (posts[i] != 0)
			return false;
	return true;
}

void store_rows_sums(const struct extent *extent, struct tile tile, const int32_t *posts, int64_t *below,
	       int64_t *above)
{
	uint32_t side = tile_posts(extent);
	uint32_t width = tile.x + 1 == extent_tiles_x(extent, tile.level) ? side : side - 1;
	uint32_t height = tile.y + 1 == extent_tiles_y(extent, tile.level) ? side : side - 1;
	*below = *above = 0;
	for (uint32_t y = 0; y < height; y++)
		for (uint32_t x = 0; x < width; x++) {
			int64_t post = posts[(size_t)y * side + x];
			*below += post < 0 ? post : 0;
			*above += post > 0 ? post : 0;
		}
}
