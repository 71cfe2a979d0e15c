/* What selecting and fitting share: a tile in its box, and when it is divided. */
#ifndef FURROW_TERRAIN_INTERNAL_H
#define FURROW_TERRAIN_INTERNAL_H

#include <math.h>

#include "terrain/terrain.h"

/* A tile in its box; the third of low and high is of its heights. */
struct terrain_place {
	struct tile tile;
	double low[3], high[3];
	double distance; /* metres, eye to box */
	double error;    /* metres, as the source says; 0 by radii */
	double ratio;    /* of the distance to the tile's side, or to its error */
	const struct terrain_place *above; /* the tile that was divided for it; NULL: none */
};

static inline struct tile terrain_child(struct tile tile, unsigned quadrant)
{
	return (struct tile){tile.level - 1, 2 * tile.x + (quadrant & 1), 2 * tile.y + (quadrant >> 1)};
}

static inline void terrain_put(const struct extent *extent, const struct terrain_view *view, struct tile tile,
			       double low, double high, struct terrain_place *place)
{
	place->tile = tile;
	terrain_box(extent, tile, place->low, place->high);
	place->low[2] = low;
	place->high[2] = high;
	place->distance = terrain_box_distance(view->eye, place->low, place->high);
}

/* False: nothing to draw there. */
static inline bool terrain_find(const struct extent *extent, const struct terrain_view *view,
				const struct terrain_source *source, struct tile tile, struct terrain_place *place)
{
	double low, high;
	if (!source->bounds(source->user, tile, &low, &high))
		return false;
	terrain_put(extent, view, tile, low, high, place);
	place->above = NULL;
	place->error = 0;
	if (!view->by_error) {
		place->ratio = place->distance / (extent_spacing(extent, tile.level) * extent->cells);
		return true;
	}
	/* Equation 3: error x focal / distance, in pixels, against what is allowed. NaN and less than 0: none. */
	place->error = source->error(source->user, tile);
	place->ratio = place->error > 0 ? place->distance / place->error : INFINITY;
	return true;
}

/* One expression for both: what is fitted must be what is selected, to the last bit. */
static inline bool terrain_near(const struct terrain_view *view, struct tile tile, double ratio)
{
	return tile.level > view->finest && ratio < view->radius;
}

#endif
