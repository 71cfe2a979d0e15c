/*
 * Queries of the ground: heights at points, and rays. A source given by the caller gives the ground. Pure: no GL, no store. Any thread.
 *
 * A query uses the ground that wheels feel: bilinear between the four posts of a cell of level 0. Where finer tiles have offsets or
 * insets, the cells are those of the finest level there. Pictures show the same ground from nearby, within 0.5 mm between posts of the
 * source. A cell with a nodata corner has the triangles that are left: its diagonal goes from its south-west to its north-east post.
 * There are no walls at the terrain's edge or at a hole.
 *
 * All values are metres from the world's south-west post, in doubles. They are as exact at 10,000 km as at 0.
 */
#ifndef FURROW_RESIDENT_HEIGHTS_H
#define FURROW_RESIDENT_HEIGHTS_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

/* The posts of a tile of level 0 or below. The source owns them. They are valid until the source is asked for another tile. */
#define RESIDENT_BLOCK 8 /* cells along a block's side */
struct resident_posts {
	const double *heights;      /* (cells + 1)^2, row 0 south, metres; NaN: nodata */
	const double (*blocks)[2];  /* (cells / RESIDENT_BLOCK)^2: lowest and highest post of each block; the bounds may be wider */
};

/* The source of a query. Its functions are asked only about tiles within the world, on the calling thread. If one fails, the
 * query ends with its status. */
struct resident_source {
	void *user;
	const struct extent *extent;
	int finest; /* level of the finest tiles; at most 0 */
	/* Gives the posts of a tile. Asked for levels finest .. 0. */
	enum status (*posts)(void *user, struct tile tile, struct resident_posts *posts);
	/* Tells if this tile, or a finer tile below it, has offsets or posts of an inset. Asked for levels finest .. -1. */
	enum status (*present)(void *user, struct tile tile, bool *present);
	/* Gives bounds of the heights in this tile and all finer tiles below it, at any level. They may be too wide, and
	 * infinite. *any is false if all is nodata. */
	enum status (*bounds)(void *user, struct tile tile, double *low, double *high, bool *any);
};

/* Computes the bounds in resident_posts.blocks. */
void resident_fill_blocks(uint32_t cells, const double *heights, double (*blocks)[2]);

struct resident_point {
	double x, y;
};

struct resident_height {
	double height;    /* height of the ground at the point; NaN if outside or nodata */
	/* The same, but NaN if any post with weight is nodata: only a triangle is left there. `furrow query` shows it, and objects
	 * are placed on it. */
	double bilinear;
	double normal[3]; /* of the ground, a unit vector, upward; NaN if beside a hole only a post or an edge exists here */
	int level;        /* level of the posts */
	bool outside, nodata; /* `nodata` is also true if `outside` is */
};

/* Finds the heights at `count` points. A point outside or over a hole is flagged; that is no failure. A NaN coordinate is
 * outside. Points of one tile are computed together, and tiles in the order of their keys, whatever the order of the points. */
enum status resident_heights(const struct resident_source *ground, const struct resident_point *points, size_t count,
			    struct resident_height *heights) FURROW_CHECKED;

struct resident_ray {
	double origin[3], direction[3]; /* direction may have any length but 0 */
	double length;                  /* metres, 0 or more; INFINITY: to the end of the world */
};

struct resident_hit {
	bool hit;
	bool below;       /* the ray came from below the ground */
	double distance;  /* metres from the origin */
	double point[3];
	double normal[3]; /* of the ground, upward, even if it was hit from below */
	struct tile tile; /* the tile, and the cell in it */
	uint32_t x, y;
};

/* Finds the first place where each ray meets the ground, from above or from below. This may be the origin, if it lies on the
 * ground. No ray passes between two cells that share an edge. STATUS_INPUT: a number is NaN or infinite, the direction is
 * 0, or the length is negative. */
enum status resident_rays(const struct resident_source *ground, const struct resident_ray *rays, size_t count,
			 struct resident_hit *hits) FURROW_CHECKED;

#endif
