/* What a row tells of its posts: their range, their sums, whether all are zero. Pure. */
#include "store/internal.h"

#include <math.h>

double store_rows_metres(enum row_table table, int32_t post, double step)
{
	return table == ROW_BASE    ? height_code_metres(post, step)
				    : plane_value(row_plane(table), post);
}

/* Gives the two halves of a post. Of shear they are to the east and to the north; of a slope, what is above and what is below. */
static void parts_of(enum row_table table, int32_t post, int32_t parts[2])
{
	const bool shear = table == ROW_SHEAR;
	parts[0] = shear ? plane_shear(post, PLANE_SHEAR_EAST) : (int32_t)((uint32_t)post & 0xffff);
	parts[1] = shear ? plane_shear(post, PLANE_SHEAR_NORTH) : (int32_t)((uint32_t)post >> 16);
}

void store_rows_range(enum row_table table, const int32_t *posts, size_t count, double step, double *low,
		double *high)
{
	int32_t least = INT32_MAX, most = INT32_MIN;
	for (size_t i = 0; i < count; i++) {
		if (table == ROW_BASE && posts[i] == HEIGHT_CODE_NODATA)
			continue;
		int32_t parts[2] = {posts[i], posts[i]};
		if (table == ROW_SHEAR || table == ROW_SLOPE)
			parts_of(table, posts[i], parts);
		for (int k = 0; k < 2; k++) {
			least = least < parts[k] ? least : parts[k];
			most = most > parts[k] ? most : parts[k];
		}
	}
	*low = *high = (double)NAN;
	if (least > most)
		return;
	if (table == ROW_SHEAR || table == ROW_SLOPE) {
		const int bits = table == ROW_SHEAR ? PLANE_SHEAR_BITS : PLANE_SLOPE_BITS;
		*low = ldexp(least, -bits);
		*high = ldexp(most, -bits);
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
