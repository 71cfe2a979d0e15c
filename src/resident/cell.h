/*
 * The ground of a cell. Between four posts it is bilinear. If one of them is nodata, one of the cell's two triangles may be left.
 * Their diagonal goes from the cell's south-west to its north-east post.
 */
#ifndef FURROW_RESIDENT_CELL_H
#define FURROW_RESIDENT_CELL_H

#include <math.h>

#include "resident/heights.h"

/* The ground of a cell, or of a part of it: height = at + slope[0] u + slope[1] v + twist u v. (u, v) is in cells, from the
 * cell's south-west post. A triangle has no twist. */
struct resident_plane {
	double at, slope[2], twist;
};

/* Returns the bilinear ground of a cell. `sw`: pointer to the cell's south-west post, in rows of `stride` posts. If a corner is
 * nodata, it has NaN. */
static inline struct resident_plane resident_cell_of(const double *sw, size_t stride)
{
	const double a = sw[0], b = sw[1], c = sw[stride], d = sw[stride + 1];
	return (struct resident_plane){a, {b - a, c - a}, a - b - c + d};
}

/* Returns the plane of a triangle. `sw`: pointer to the cell's south-west post, in rows of `stride` posts. `upper`: the
 * north-west triangle. If a corner is nodata, the plane has NaN. */
static inline struct resident_plane resident_plane_of(const double *sw, size_t stride, bool upper)
{
	const double a = sw[0], d = sw[stride + 1];
	const double turn = upper ? sw[stride] : sw[1];
	return upper ? (struct resident_plane){a, {d - turn, turn - a}, 0} : (struct resident_plane){a, {turn - a, d - turn}, 0};
}

static inline bool resident_plane_whole(const struct resident_plane *plane)
{
	return !isnan(plane->slope[0] + plane->slope[1] + plane->twist);
}

/* Computes the upward unit normal at (u, v). `spacing`: metres between posts. */
static inline void resident_plane_normal(const struct resident_plane *plane, double u, double v, double spacing, double normal[3])
{
	const double x = (plane->slope[0] + plane->twist * v) / spacing, y = (plane->slope[1] + plane->twist * u) / spacing, length = sqrt(x * x + y * y + 1);
	normal[0] = -x / length;
	normal[1] = -y / length;
	normal[2] = 1 / length;
}

/* Returns how many of a tile's cells are within the world, along one side. `tile`: the tile's x or y. `posts`: posts of the
 * world along this side at level 0. */
static inline uint32_t resident_cells_in(const struct extent *extent, int level, uint32_t tile, int64_t posts)
{
	const int64_t left = extent_posts(posts, level) - 1 - (int64_t)tile * extent->cells;
	return left < extent->cells ? (uint32_t)left : extent->cells;
}

#endif
