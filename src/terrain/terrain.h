/*
 * terrain: finds which tiles a view needs and at which level, and how high the ground is at a point.
 *
 * Selection is that of the dissertation, in doubles, in world coordinates. Either the distance of a tile decides its level
 * (radii). Or a tile is drawn at the coarsest level whose error is small on the screen (Equation 3). Pure: no GL, no store. A
 * source given by the caller says which tiles exist and which are resident.
 */
#ifndef FURROW_TERRAIN_H
#define FURROW_TERRAIN_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

/* Metres, absolute, in the axes of the store: x east, y north, z up. */
struct terrain_view {
	double eye[3];
	/* planes of the frustum, in the order left, right, bottom, top, far. Inside, a x + b y + c z + d >= 0 */
	double planes[5][4];
	double radius;       /* a tile is divided if it is nearer than radius x its side */
	/* true: a tile is divided if it is nearer than radius x its error. Then radius is the focal length / the allowed error,
	 * both in pixels. */
	bool by_error;
	int finest;          /* tiles of this level are not divided, nor are finer ones; at least TILE_LEVEL_MIN */
};

struct terrain_source {
	void *user;
	/* Gives the lowest and highest height of the tile and of all finer tiles below it, with deformation. Returns false if
	 * there is nothing to draw. At level >= 0 that means: all is nodata. Below level 0: its parent is drawn
	 * there, since the tile would show nothing else. */
	bool (*bounds)(void *user, struct tile tile, double *low, double *high);
	/* Returns true if the tile is resident now, and gives its slot. Asked only about tiles that the picture needs, or that
	 * may be drawn in their place. If it always returns false, all tiles of the picture become wanted. */
	bool (*resident)(void *user, struct tile tile, uint32_t *slot);
	/* Returns true if finer tiles may be drawn in place of this tile. At level > 0: its children exist. At level 0 and finer:
	 * some of its children may have bounds. terrain never asks about children outside the world. */
	bool (*divisible)(void *user, struct tile tile);
	/* Used if by_error. Returns the largest height difference, in metres, between the drawn tile and the finest ground,
	 * with deformation. Asked only about tiles that have bounds. A child's error should be at most its parent's. A larger
	 * one is used only where the parent is divided. NaN and negative values count as 0. */
	double (*error)(void *user, struct tile tile);
	/* Returns true if the tile has base heights of its own: at level >= 0, and below it where an inset lies. Those of other
	 * tiles are interpolated from the next tile above that has its own. NULL: there are no insets. */
	bool (*stored)(void *user, struct tile tile);
};

/* One drawn tile. A bit of `quadrants` is set for each quadrant that this tile draws; finer tiles draw the others. Bits: 0
 * south-west, 1 south-east, 2 north-west, 3 north-east. */
#define TERRAIN_NO_SLOT UINT32_MAX
#define TERRAIN_STRIDES 12 /* strides 2^0 .. 2^10 between drawn posts of a tile */
struct terrain_draw {
	struct tile tile;
	uint32_t slot;
	/* Slot of the tile from which this tile's base is interpolated, and that tile's level: at level >= 0, and in an inset, this tile
	 * itself. TERRAIN_NO_SLOT: it is not resident. */
	uint32_t ground;
	int ground_level;
	unsigned quadrants;
	bool finest;  /* there is no finer tile below */
	bool divided; /* the other quadrants are drawn by finer tiles; those in `standing` should be, but are not resident */
	unsigned standing; /* quadrants that finer tiles should draw, but these are not resident, so this tile draws them */
	bool replaces; /* drawn in place of finer tiles that are not resident; the complete picture does not have it */
	double low, high, distance; /* metres; distance: from the eye to the tile's box */
	/* Used if by_error. Entry k: error in metres if only every 2^k-th post is drawn, which is the error of the tile k
	 * levels above. Beyond the coarsest level: the relief of that tile. The entries never get smaller. */
	double errors[TERRAIN_STRIDES];
};

#define TERRAIN_DRAWS_MAX 1024
struct terrain_selection {
	struct terrain_draw draws[TERRAIN_DRAWS_MAX]; /* near to far */
	size_t draw_count;
	/* Keys of tiles that the complete picture needs but that are not resident. Coarser levels come first; within a level,
	 * nearer tiles. */
	uint64_t wanted[TERRAIN_DRAWS_MAX];
	size_t wanted_count;
	size_t visited, culled;
	size_t ideal;  /* number of tiles that the complete picture draws */
	/* number of tiles that it needs resident: the drawn ones, those that they are interpolated from, the coarsest tile */
	size_t needed;
};

/*
 * Fills selection with the tiles of a picture. Where a tile is not resident, a coarser resident one is drawn for that quadrant.
 * While the coarsest tile is resident, each visible point of the ground is drawn exactly once. If draws is full, tiles are not
 * divided further. The tiles of the complete picture are put into wanted if not resident, and so is the coarsest tile. So are the
 * tiles from which finer ones are interpolated.
 */
void terrain_select(const struct extent *extent, const struct terrain_view *view,
		    const struct terrain_source *source, struct terrain_selection *selection);

/* Reduces the detail of a view (its radius and finest) until its picture needs at most `budget` tiles, or only the coarsest
 * one. Detail that is far away for its size goes first. Returns false if it changed the view. It costs as much as selecting the
 * result. */
bool terrain_fit(const struct extent *extent, const struct terrain_source *source, size_t budget,
		 struct terrain_view *view);

/* Gives the rectangle of ground that the tile covers, cut at the world's edge. */
void terrain_box(const struct extent *extent, struct tile tile, double low[2], double high[2]);

/* Computes the planes of a perspective camera's frustum: left, right, bottom, top, far. fov is vertical, in radians. The axes
 * are unit vectors. */
void terrain_frustum(const double eye[3], const double forward[3], const double right[3],
		     const double up[3], double fov, double aspect, double far, double planes[5][4]);
bool terrain_box_visible(const double planes[5][4], const double low[3], const double high[3]);
double terrain_box_distance(const double eye[3], const double low[3], const double high[3]);

/*
 * --- queries: heights at points, and rays ---
 *
 * A query uses the ground that wheels feel: bilinear between the four posts of a cell of level 0. Where finer tiles have offsets or
 * insets, the cells are those of the finest level there. Pictures show the same ground from nearby, within 0.5 mm between posts of the
 * source. A cell with a nodata corner has the triangles that are left: its diagonal goes from its south-west to its north-east post.
 * There are no walls at the terrain's edge or at a hole.
 *
 * All values are metres from the world's south-west post, in doubles. They are as exact at 10,000 km as at 0.
 */

/* The posts of a tile of level 0 or below. The source owns them. They are valid until the source is asked for another tile. */
#define TERRAIN_BLOCK 8 /* cells along a block's side */
struct terrain_posts {
	const double *heights;      /* (cells + 1)^2, row 0 south, metres; NaN: nodata */
	const double (*blocks)[2];  /* (cells / TERRAIN_BLOCK)^2: lowest and highest post of each block; the bounds may be wider */
};

/* The source of a query. Its functions are asked only about tiles within the world, on the calling thread. If one fails, the
 * query ends with its status. */
struct terrain_ground {
	void *user;
	const struct extent *extent;
	int finest; /* level of the finest tiles; at most 0 */
	/* Gives the posts of a tile. Asked for levels finest .. 0. */
	enum status (*posts)(void *user, struct tile tile, struct terrain_posts *posts);
	/* Tells if this tile, or a finer tile below it, has offsets or posts of an inset. Asked for levels finest .. -1. */
	enum status (*present)(void *user, struct tile tile, bool *present);
	/* Gives bounds of the heights in this tile and all finer tiles below it, at any level. They may be too wide, and
	 * infinite. *any is false if all is nodata. */
	enum status (*bounds)(void *user, struct tile tile, double *low, double *high, bool *any);
};

/* Computes the bounds in terrain_posts.blocks. */
void terrain_fill_blocks(uint32_t cells, const double *heights, double (*blocks)[2]);

struct terrain_point {
	double x, y;
};

struct terrain_height {
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
enum status terrain_heights(const struct terrain_ground *ground, const struct terrain_point *points, size_t count,
			    struct terrain_height *heights) FURROW_CHECKED;

struct terrain_ray {
	double origin[3], direction[3]; /* direction may have any length but 0 */
	double length;                  /* metres, 0 or more; INFINITY: to the end of the world */
};

struct terrain_hit {
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
enum status terrain_rays(const struct terrain_ground *ground, const struct terrain_ray *rays, size_t count,
			 struct terrain_hit *hits) FURROW_CHECKED;

#endif
