/*
 * Selection: which tiles a view needs, and at which level.
 *
 * It is that of the dissertation, in doubles, in world coordinates. Either the distance of a tile decides its level
 * (radii). Or a tile is drawn at the coarsest level whose error is small on the screen (Equation 3). Pure: no GL, no store. A
 * source given by the caller says which tiles exist and which are resident. Any thread.
 */
#ifndef FURROW_RENDER_SELECT_H
#define FURROW_RENDER_SELECT_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

/* Metres, absolute, in the axes of the store: x east, y north, z up. */
struct render_view {
	double eye[3];
	/* planes of the frustum, in the order left, right, bottom, top, far. Inside, a x + b y + c z + d >= 0 */
	double planes[5][4];
	double radius;       /* a tile is divided if it is nearer than radius x its side */
	/* true: a tile is divided if it is nearer than radius x its error. Then radius is the focal length / the allowed error,
	 * both in pixels. */
	bool by_error;
	int finest;          /* tiles of this level are not divided, nor are finer ones; at least TILE_LEVEL_MIN */
};

struct render_source {
	void *user;
	/* Gives the lowest and highest height of the tile and of all finer tiles below it, with deformation. Returns false if
	 * there is nothing to draw. At level >= 0 that means: all is nodata. Below level 0: its parent is drawn
	 * there, since the tile would show nothing else. */
	bool (*bounds)(void *user, struct tile tile, double *low, double *high);
	/* Returns true if the tile is resident now, and gives its slot. Asked only about tiles that the picture needs, or that
	 * may be drawn in their place. If it always returns false, all tiles of the picture become wanted. */
	bool (*resident)(void *user, struct tile tile, uint32_t *slot);
	/* Returns true if finer tiles may be drawn in place of this tile. At level > 0: its children exist. At level 0 and finer:
	 * some of its children may have bounds. the selection never asks about children outside the world. */
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
#define RENDER_NO_SLOT UINT32_MAX
#define RENDER_STRIDES 12 /* strides 2^0 .. 2^10 between drawn posts of a tile */
struct render_draw {
	struct tile tile;
	uint32_t slot;
	/* Slot of the tile from which this tile's base is interpolated, and that tile's level: at level >= 0, and in an inset, this tile
	 * itself. RENDER_NO_SLOT: it is not resident. */
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
	double errors[RENDER_STRIDES];
};

#define RENDER_DRAWS_MAX 1024
struct render_selection {
	struct render_draw draws[RENDER_DRAWS_MAX]; /* near to far */
	uint32_t coarsest; /* slot of the coarsest tile; RENDER_NO_SLOT: it is not resident, or has no ground */
	size_t draw_count;
	/* Keys of tiles that the complete picture needs but that are not resident. Coarser levels come first; within a level,
	 * nearer tiles. */
	uint64_t wanted[RENDER_DRAWS_MAX];
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
void render_select(const struct extent *extent, const struct render_view *view,
		    const struct render_source *source, struct render_selection *selection);

/* Reduces the detail of a view (its radius and finest) until its picture needs at most `budget` tiles, or only the coarsest
 * one. Detail that is far away for its size goes first. Returns false if it changed the view. It costs as much as selecting the
 * result. */
bool render_fit(const struct extent *extent, const struct render_source *source, size_t budget,
		 struct render_view *view);

/* Gives the rectangle of ground that the tile covers, cut at the world's edge. */
void render_box(const struct extent *extent, struct tile tile, double low[2], double high[2]);

/* Computes the planes of a perspective camera's frustum: left, right, bottom, top, far. fov is vertical, in radians. The axes
 * are unit vectors. */
void render_frustum(const double eye[3], const double forward[3], const double right[3],
		     const double up[3], double fov, double aspect, double far, double planes[5][4]);
bool render_box_visible(const double planes[5][4], const double low[3], const double high[3]);
double render_box_distance(const double eye[3], const double low[3], const double high[3]);

#endif
