/* The two triangles of a cell, as pictures draw them: parted from its south-west to its north-east post. */
#ifndef FURROW_TERRAIN_CELL_H
#define FURROW_TERRAIN_CELL_H

#include <math.h>

#include "terrain/terrain.h"

/* height = at + slope[0] u + slope[1] v, (u, v) in cells from the cell's south-west post. */
struct terrain_plane {
	double at, slope[2];
};

/* Of the cell whose south-west post is `sw`, in rows of `stride`; `upper`: the triangle to the north-west. NaN where a corner
 * has no data. */
static inline struct terrain_plane terrain_plane_of(const double *sw, size_t stride, bool upper)
{
	const double a = sw[0], d = sw[stride + 1];
	const double turn = upper ? sw[stride] : sw[1];
	return upper ? (struct terrain_plane){a, {d - turn, turn - a}} : (struct terrain_plane){a, {turn - a, d - turn}};
}

static inline bool terrain_plane_whole(const struct terrain_plane *plane)
{
	return !isnan(plane->slope[0] + plane->slope[1]);
}

/* Upward, of length 1. */
static inline void terrain_plane_normal(const struct terrain_plane *plane, double spacing, double normal[3])
{
	const double x = plane->slope[0] / spacing, y = plane->slope[1] / spacing, length = sqrt(x * x + y * y + 1);
	normal[0] = -x / length;
	normal[1] = -y / length;
	normal[2] = 1 / length;
}

/* Cells of a tile that are in the world, along a side of so many posts at level 0. */
static inline uint32_t terrain_cells_in(const struct extent *extent, int level, uint32_t tile, int64_t posts)
{
	const int64_t left = extent_posts(posts, level) - 1 - (int64_t)tile * extent->cells;
	return left < extent->cells ? (uint32_t)left : extent->cells;
}

#endif
