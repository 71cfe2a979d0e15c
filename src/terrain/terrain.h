/*
 * terrain: which tiles a view needs, at which level, and what height the ground has at a point.
 *
 * Selection is the dissertation's, in doubles, relative to nothing but the world: a tile is drawn at the
 * level its distance asks for (radii), or at the coarsest whose error is small on the screen (Equation 3).
 * Pure: no GL, no store; the source says what is where.
 */
#ifndef FURROW_TERRAIN_H
#define FURROW_TERRAIN_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

/* Metres, store axes (x east, y north, z up), absolute. */
struct terrain_view {
	double eye[3];
	double planes[5][4]; /* inward: a x + b y + c z + d >= 0 inside; left right bottom top far */
	double radius;       /* a tile is divided when nearer than radius x its side */
	bool by_error;       /* nearer than radius x its error: radius is the focal length / the error allowed, both pixels */
	int finest;          /* no tile of this level or a finer one is divided; at least TILE_LEVEL_MIN */
};

struct terrain_source {
	void *user;
	/* Heights over the whole subtree, deformation included; false: nothing to draw there (level
	 * >= 0: all nodata; below: no offset tile there, so the parent goes on drawing that quadrant). */
	bool (*bounds)(void *user, struct tile tile, double *low, double *high);
	/* Resident now? Asked only of tiles the picture needs or that could stand in for those. A source
	 * that says no to all gets every tile of the picture as wanted. */
	bool (*resident)(void *user, struct tile tile, uint32_t *slot);
	/* May this tile be divided further: its children exist (level > 0), or offset tiles below.
	 * Children outside the world are not asked about. */
	bool (*divisible)(void *user, struct tile tile);
	/* By error: metres the ground may lie above or below what drawing this tile shows, over its whole subtree,
	 * deformation included. Asked only of tiles that have bounds. A child's should be no greater than its
	 * parent's: more, and it counts only where the parent is divided. What is no number, or negative, is 0. */
	double (*error)(void *user, struct tile tile);
};

/* One drawn tile: the quadrants of it that no finer tile covers (bit 0 sw, 1 se, 2 nw, 3 ne). */
#define TERRAIN_NO_SLOT UINT32_MAX
#define TERRAIN_STRIDES 12 /* a tile's posts can be drawn 2^0 .. 2^10 apart */
struct terrain_draw {
	struct tile tile;
	uint32_t slot;
	uint32_t ground; /* slot of the level-0 tile it lies in (its own if level >= 0), or TERRAIN_NO_SLOT */
	unsigned quadrants;
	bool finest;  /* nothing finer exists below */
	bool divided; /* finer tiles are drawn of the other quadrants, or wanted of the standing */
	unsigned standing; /* those of its quadrants that should be drawn finer and cannot */
	bool stands_in; /* the complete picture does not need it: only finer tiles that are not resident */
	double low, high, distance; /* metres; distance: eye to its box */
	/* By error: metres, of what is drawn of it at a stride of 2^k: of the tile k levels above it. Beyond the
	 * coarsest: its relief. None is less than the one before. */
	double errors[TERRAIN_STRIDES];
};

#define TERRAIN_DRAWS_MAX 1024
struct terrain_selection {
	struct terrain_draw draws[TERRAIN_DRAWS_MAX]; /* near to far */
	size_t draw_count;
	/* Keys the complete picture needs and that are not resident: coarse first, then near to far. */
	uint64_t wanted[TERRAIN_DRAWS_MAX];
	size_t wanted_count;
	size_t visited, culled;
	size_t ideal;  /* tiles the complete picture draws */
	size_t needed; /* those it needs resident: the drawn, level 0 under finer ones, the coarsest */
};

/*
 * Coarser resident tiles stand in for what is not resident, quadrant by quadrant. While the coarsest
 * tile is resident, every point of the ground in the frustum is drawn exactly once, also when an
 * array is full (then tiles stay undivided). The coarsest is wanted whenever it is not resident, and
 * so is the level-0 tile below which finer ones are drawn.
 */
void terrain_select(const struct extent *extent, const struct terrain_view *view,
		    const struct terrain_source *source, struct terrain_selection *selection);

/* Makes the view coarser, by radius and finest, until its picture needs at most `budget` tiles (or
 * the coarsest alone): what was furthest for its size goes first. False if it had to. A view that
 * fits stays as it is. Costs as much as selecting the result. */
bool terrain_fit(const struct extent *extent, const struct terrain_source *source, size_t budget,
		 struct terrain_view *view);

/* Where a tile lies: its rectangle of ground, cut at the world's edge. */
void terrain_box(const struct extent *extent, struct tile tile, double low[2], double high[2]);

/* The five planes of a perspective camera. fov is vertical, radians; the axes are unit vectors. */
void terrain_frustum(const double eye[3], const double forward[3], const double right[3],
		     const double up[3], double fov, double aspect, double far, double planes[5][4]);
bool terrain_box_visible(const double planes[5][4], const double low[3], const double high[3]);
double terrain_box_distance(const double eye[3], const double low[3], const double high[3]);

/*
 * --- queries: heights at points, and rays ---
 *
 * The ground, for a query, is what a picture from nearby draws without morphing or skirts: the triangles of level 0, and
 * where finer tiles have offsets those of the finest that is there; each cell parted from its south-west to its north-east
 * post. A triangle with a corner that is nodata is not there; the terrain has no walls, at its edge or at a hole. All in metres
 * from the world's south-west post, doubles: as exact at 10,000 km as at 0.
 */

/* What a tile of level 0 or below holds. The source's, valid until it is asked for another. */
#define TERRAIN_BLOCK 8 /* cells of a block's side */
struct terrain_posts {
	const double *heights;      /* (cells + 1)^2, row 0 south, metres; NaN: nodata */
	const double (*blocks)[2];  /* (cells / TERRAIN_BLOCK)^2: no post of the block is below the first or above the second */
};

/* The source of a query. Each function is asked only of tiles of the world, on the thread that asks; a failure ends the
 * query with its status. */
struct terrain_ground {
	void *user;
	const struct extent *extent;
	int finest; /* level of the finest tiles there are; at most 0 */
	/* Levels finest .. 0. */
	enum status (*posts)(void *user, struct tile tile, struct terrain_posts *posts);
	/* Levels finest .. -1: whether this tile, or one below it, has offsets. */
	enum status (*present)(void *user, struct tile tile, bool *present);
	/* Any level: no height in the subtree is below or above these; *any false: all of it is nodata. May be loose, and
	 * infinite. */
	enum status (*bounds)(void *user, struct tile tile, double *low, double *high, bool *any);
};

/* Fills terrain_posts.blocks. */
void terrain_fill_blocks(uint32_t cells, const double *heights, double (*blocks)[2]);

struct terrain_point {
	double x, y;
};

struct terrain_height {
	double height;    /* of the triangle there; NaN where outside or nodata */
	double bilinear;  /* between the cell's four posts, as `furrow query` tells and as objects are set down; NaN if one of them that
			   * has weight is nodata. It is `height` at the posts and along the cell's sides */
	double normal[3]; /* of the triangle, of length 1, upward; NaN where only a post or an edge is there, beside a hole */
	int level;        /* of the triangle */
	bool outside, nodata; /* nodata where outside, too */
};

/* Heights at `count` points. Points outside or over a hole are flagged, and no failure; NaN is outside. A tile's points are
 * worked on together, in the order of keys, whatever theirs is. */
enum status terrain_heights(const struct terrain_ground *ground, const struct terrain_point *points, size_t count,
			    struct terrain_height *heights) FURROW_CHECKED;

struct terrain_ray {
	double origin[3], direction[3]; /* any length but 0 */
	double length;                  /* metres, 0 or more; INFINITY: as far as the world goes */
};

struct terrain_hit {
	bool hit;
	bool below;       /* it came from under the ground */
	double distance;  /* metres from the origin */
	double point[3];
	double normal[3]; /* of the triangle, upward, whichever side was hit */
	struct tile tile; /* and the cell in it, and which of its triangles */
	uint32_t x, y;
	bool upper;       /* the one to the north-west */
};

/* The first place where each ray meets the ground, from above or from below: also its origin, if that is on it. No ray passes
 * between two triangles that share an edge. STATUS_INPUT for a ray that is no ray: a number that is none, no direction. */
enum status terrain_rays(const struct terrain_ground *ground, const struct terrain_ray *rays, size_t count,
			 struct terrain_hit *hits) FURROW_CHECKED;

#endif
