/* Inside dem: what the files dem_inset*.c share. */
#ifndef FURROW_DEM_INSET_H
#define FURROW_DEM_INSET_H

#include "dem/dem.h"

/*
 * --- dem_inset_rim.c: how much an inset counts at each post ---
 *
 * The weight is 0 at the inset's outline and beyond. It rises to 1 over the feather's width, as 3 t^2 - 2 t^3; t is the share of
 * that width. In a hole it falls again the same way, from the hole's edge inwards. Distances are those of a grid of nodes, `block` posts
 * apart, bilinear between nodes. A node beside a post without data has distance 0.
 */
struct inset_rim {
	int64_t width, height; /* posts of the inset */
	int64_t block;         /* posts between nodes, a power of two */
	int64_t nodes[2];      /* along x and y */
	float *far;            /* metres from a node to the inset's outline */
	float *deep;           /* metres from a node in a hole to the hole's edge; 0 elsewhere; NULL: there are no holes */
	double spacing, feather; /* metres */
};

/* Reads the posts of the inset's rows, NaN: no data. */
typedef enum status (*inset_rows_fn)(void *user, int64_t y, int64_t rows, double *heights);
/* Fills the grid, from width, height, spacing and feather. dem_inset_rim_finish is due also after a failure. */
enum status dem_inset_rim_init(struct inset_rim *rim, inset_rows_fn rows, void *user) FURROW_CHECKED;
void dem_inset_rim_finish(struct inset_rim *rim);
double dem_inset_rim_far(const struct inset_rim *rim, int64_t x, int64_t y);    /* metres to the outline */
double dem_inset_rim_weight(const struct inset_rim *rim, int64_t x, int64_t y); /* 0 to 1 */

/*
 * --- insets ---
 *
 * Insets are in the order in which they are laid over each other: coarser ones first, and of one level the first named last. All posts
 * are counted from the terrain's south-west post.
 *
 * Invariant: a post has data of an inset only in cells of `around` that are covered. These are the cells of the level that surrounds
 * the inset which have a post of weight above 0. So an uncovered cell has corners without weight, and what is interpolated in it is the
 * ground that surrounds the inset.
 */
struct inset {
	struct dem_inset_info info;
	struct dem *dem;
	size_t named;           /* place among the sources */
	const struct dem_inset_source *from;
	bool missing;           /* it does not lie in the terrain, and is left out */
	int64_t x, y;           /* the dem's south-west post, in posts of info.level */
	struct post_rect rect;  /* the part of it within the terrain */
	struct inset_rim rim;   /* of rect */
	int around;             /* the level of the ground that surrounds it */
	struct post_rect cells; /* of level `around`, that `covered` tells about */
	uint8_t *covered;
	double lowered;         /* metres that its heights are lowered by, to match what surrounds it */
};

struct dem_insets {
	struct dem *country;
	struct extent extent;
	struct inset *list;
	size_t count;
	struct post_rect held;  /* posts of the country that `posts` has; empty: none */
	double *posts;
};

static inline int64_t dem_inset_width(struct post_rect rect)
{
	return rect.x1 - rect.x0;
}

static inline size_t dem_inset_posts(struct post_rect rect)
{
	return (size_t)dem_inset_width(rect) * (size_t)(rect.y1 - rect.y0);
}

/* Returns the posts of a level `shift` coarser from which a rectangle is interpolated. */
static inline struct post_rect dem_inset_around(struct post_rect rect, int shift)
{
	const int64_t up = ((int64_t)1 << shift) - 1;
	return (struct post_rect){rect.x0 >> shift, rect.y0 >> shift, ((rect.x1 - 1 + up) >> shift) + 1, ((rect.y1 - 1 + up) >> shift) + 1};
}

/* --- dem_inset_heights.c --- */
/* Computes the heights of the first `depth` insets over the country: posts of `rect` of a level that is at least as fine as theirs. `rect` is
 * within the terrain. */
enum status dem_inset_heights(struct dem_insets *insets, size_t depth, int level, struct post_rect rect, double *heights) FURROW_CHECKED;
/* Returns true if the post is in a covered cell, edges included. `level`: at most inset->around. */
bool dem_inset_covers(const struct inset *inset, int level, int64_t x, int64_t y);
/* Gives the rectangle of posts of a level, at most inset->around, that may be covered. */
struct post_rect dem_inset_covered_rect(const struct inset *inset, int level);

/* --- dem_inset_misfit.c --- */
/* Adds by how much a tile's codes are off an inset's heights, and by how much their surface is off its sources. Only posts count that are
 * one inset's alone: not in its feather, and not in another inset over it. */
enum status dem_inset_misfit(const struct dem_insets *insets, struct tile tile, const int32_t *codes, double step, struct misfit *resampled,
			     struct misfit *source) FURROW_CHECKED;

#endif
