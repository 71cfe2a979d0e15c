/*
 * terrain: finds which tiles a view needs and at which level, and what height the ground has at a point.
 *
 * Selection is the dissertation's, in doubles, in world coordinates. A tile is drawn at the level that its distance asks for
 * (radii). Or it is drawn at the coarsest level whose error is small on the screen (Equation 3). Pure: no GL, no store. The
 * source says which tiles exist and are resident.
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
	/* a tile is divided when nearer than radius x its error; radius is the focal length / the error allowed, both pixels */
	bool by_error;
	int finest;          /* no tile of this level or a finer one is divided; at least TILE_LEVEL_MIN */
};

struct terrain_source {
	void *user;
	/* Tells the heights over the whole subtree, with deformation. False: nothing to draw there. Level >= 0: all is nodata.
	 * Below: the tile has no offsets, so the parent draws that quadrant. */
	bool (*bounds)(void *user, struct tile tile, double *low, double *high);
	/* Returns true, with the slot, if the tile is resident now. Asked only of tiles that the picture needs or that could be
	 * drawn instead of those. If it always returns false, all tiles of the picture become wanted. */
	bool (*resident)(void *user, struct tile tile, uint32_t *slot);
	/* Returns true if this tile may be divided: its children exist (level > 0), or there are offset tiles below. Not asked
	 * about children outside the world. */
	bool (*divisible)(void *user, struct tile tile);
	/* With by_error: returns metres that the ground may lie above or below the drawn tile, over its whole subtree with
	 * deformation. Asked only of tiles that have bounds. A child's error should not exceed its parent's. A greater one is
	 * used only where the parent is divided. NaN and negative values count as 0. */
	double (*error)(void *user, struct tile tile);
};

/* One drawn tile, without the quadrants that finer tiles cover (bit 0 sw, 1 se, 2 nw, 3 ne). */
#define TERRAIN_NO_SLOT UINT32_MAX
#define TERRAIN_STRIDES 12 /* strides 2^0 .. 2^10 between drawn posts of a tile */
struct terrain_draw {
	struct tile tile;
	uint32_t slot;
	uint32_t ground; /* slot of the level-0 tile it lies in (its own if level >= 0), or TERRAIN_NO_SLOT */
	unsigned quadrants;
	bool finest;  /* nothing finer exists below */
	bool divided; /* finer tiles are drawn in the other quadrants, or wanted in `standing` */
	unsigned standing; /* quadrants that should be drawn finer, but their finer tiles are not resident */
	bool replaces; /* the complete picture does not need it; it replaces finer tiles that are not resident */
	double low, high, distance; /* metres; distance: eye to its box */
	/* With by_error: metres, the error when it is drawn at a stride of 2^k, which is that of the tile k levels above it.
	 * Beyond the coarsest level: its relief. No entry is less than the one before. */
	double errors[TERRAIN_STRIDES];
};

#define TERRAIN_DRAWS_MAX 1024
struct terrain_selection {
	struct terrain_draw draws[TERRAIN_DRAWS_MAX]; /* near to far */
	size_t draw_count;
	/* Keys of tiles that the complete picture needs and that are not resident: coarse first, then near to far. */
	uint64_t wanted[TERRAIN_DRAWS_MAX];
	size_t wanted_count;
	size_t visited, culled;
	size_t ideal;  /* tiles the complete picture draws */
	size_t needed; /* tiles that it needs resident: the drawn ones, level 0 under finer ones, the coarsest */
};

/*
 * Selects the tiles of a picture. Coarser resident tiles replace those that are not resident, quadrant by quadrant. While the
 * coarsest tile is resident, every point of the ground in the frustum is drawn exactly once. This also holds when an array is
 * full; then tiles stay undivided. The coarsest tile is always wanted if it is not resident. So is the level-0 tile below which
 * finer ones are drawn.
 */
void terrain_select(const struct extent *extent, const struct terrain_view *view,
		    const struct terrain_source *source, struct terrain_selection *selection);

/* Makes the view coarser, by radius and finest, until its picture needs at most `budget` tiles (or only the coarsest). It
 * reduces first what is farthest for its size. Returns false if it changed the view. It costs as much as selecting the result. */
bool terrain_fit(const struct extent *extent, const struct terrain_source *source, size_t budget,
		 struct terrain_view *view);

/* Tells the tile's rectangle of ground, cut at the world's edge. */
void terrain_box(const struct extent *extent, struct tile tile, double low[2], double high[2]);

/* Computes the five planes of a perspective camera. fov is vertical, radians; the axes are unit vectors. */
void terrain_frustum(const double eye[3], const double forward[3], const double right[3],
		     const double up[3], double fov, double aspect, double far, double planes[5][4]);
bool terrain_box_visible(const double planes[5][4], const double low[3], const double high[3]);
double terrain_box_distance(const double eye[3], const double low[3], const double high[3]);

/*
 * --- queries: heights at points, and rays ---
 *
 * A query sees the ground that a picture from nearby draws, without morphing or skirts. It is made of the triangles of level 0.
 * Where finer tiles have offsets, it is made of the triangles of the finest level there. Each cell is divided from its
 * south-west to its north-east post. A triangle with a corner in nodata does not exist. The terrain has no walls at its edge or
 * at a hole. All values are metres from the world's south-west post, in doubles. They are as exact at 10,000 km as at 0.
 */

/* The posts of a tile of level 0 or below. The source owns them; they are valid until it is asked for another tile. */
#define TERRAIN_BLOCK 8 /* cells on a block's side */
struct terrain_posts {
	const double *heights;      /* (cells + 1)^2, row 0 south, metres; NaN: nodata */
	const double (*blocks)[2];  /* (cells / TERRAIN_BLOCK)^2: lowest and highest post of each block, or wider bounds */
};

/* The source of a query. Each function is asked only about tiles of the world, on the calling thread. A failure ends the query
 * with its status. */
struct terrain_ground {
	void *user;
	const struct extent *extent;
	int finest; /* level of the finest tiles; at most 0 */
	/* Tells the posts of a tile. Levels finest .. 0. */
	enum status (*posts)(void *user, struct tile tile, struct terrain_posts *posts);
	/* Tells whether this tile, or one below it, has offsets. Levels finest .. -1. */
	enum status (*present)(void *user, struct tile tile, bool *present);
	/* Tells bounds of the heights in the subtree, at any level. They may be wider than needed, and infinite. *any false:
	 * all is nodata. */
	enum status (*bounds)(void *user, struct tile tile, double *low, double *high, bool *any);
};

/* Computes terrain_posts.blocks. */
void terrain_fill_blocks(uint32_t cells, const double *heights, double (*blocks)[2]);

struct terrain_point {
	double x, y;
};

struct terrain_height {
	double height;    /* of the triangle there; NaN if outside or nodata */
	/* between the cell's four posts, as `furrow query` tells it and as objects are set down. NaN: a post with weight is
	 * nodata. Equal to `height` at the posts and along the cell's sides */
	double bilinear;
	double normal[3]; /* of the triangle, unit vector, upward; NaN if only a post or an edge exists there, beside a hole */
	int level;        /* of the triangle */
	bool outside, nodata; /* `nodata` is also set where `outside` is */
};

/* Finds the heights at `count` points. A point outside or over a hole is flagged, and is no failure; NaN is outside. Points of
 * one tile are computed together, in the order of keys, whatever the order of the points. */
enum status terrain_heights(const struct terrain_ground *ground, const struct terrain_point *points, size_t count,
			    struct terrain_height *heights) FURROW_CHECKED;

struct terrain_ray {
	double origin[3], direction[3]; /* any length but 0 */
	double length;                  /* metres, 0 or more; INFINITY: as far as the world goes */
};

struct terrain_hit {
	bool hit;
	bool below;       /* the ray came from below the ground */
	double distance;  /* metres from the origin */
	double point[3];
	double normal[3]; /* of the triangle, upward, even if hit from below */
	struct tile tile; /* the tile, the cell in it, and which of the cell's triangles */
	uint32_t x, y;
	bool upper;       /* the triangle to the north-west */
};

/* Finds the first place where each ray meets the ground, from above or from below. It may be the origin, if that is on the
 * ground. No ray passes between two triangles that share an edge. STATUS_INPUT: a number is NaN or infinite, the direction is
 * 0, or the length is negative. */
enum status terrain_rays(const struct terrain_ground *ground, const struct terrain_ray *rays, size_t count,
			 struct terrain_hit *hits) FURROW_CHECKED;

#endif
