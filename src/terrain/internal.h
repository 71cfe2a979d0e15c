/* What select.c and fit.c share: the box of a tile, and the test if a tile is divided. */
#ifndef FURROW_TERRAIN_INTERNAL_H
#define FURROW_TERRAIN_INTERNAL_H

#include <math.h>

#include "terrain/terrain.h"

/* A tile and its box. low[2] and high[2] are its lowest and highest height. */
struct terrain_place {
	struct tile tile;
	double low[3], high[3];
	double distance; /* metres, from the eye to the box */
	double error;    /* metres, as the source gives it; 0 if radii decide */
	double ratio;    /* distance / the tile's side; with by_error, distance / the tile's error */
	const struct terrain_place *above; /* the tile whose division gave this tile; NULL: none */
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

/* Fills `place`. Returns false if the tile has nothing to draw. */
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
	/* Equation 3: error x focal length / distance, in pixels, is compared with the allowed error. An error of NaN or below
	 * 0 counts as 0. */
	place->error = source->error(source->user, tile);
	place->ratio = place->error > 0 ? place->distance / place->error : INFINITY;
	return true;
}

/* Returns true if the tile is divided. The selection uses this expression, and so does the search for the radius that the budget
 * allows (fit.c). So they agree to the last bit. */
static inline bool terrain_near(const struct terrain_view *view, struct tile tile, double ratio)
{
	return tile.level > view->finest && ratio < view->radius;
}

static inline bool terrain_stored(const struct terrain_source *source, struct tile tile)
{
	return tile.level >= 0 || (source->stored != NULL && source->stored(source->user, tile));
}

/* Returns true if the tile has base heights of its own, and a tile below it is interpolated from them. */
static inline bool terrain_carries(const struct extent *extent, const struct terrain_source *source, struct tile tile)
{
	if (tile.level > 0 || !terrain_stored(source, tile))
		return false;
	for (unsigned quadrant = 0; quadrant < 4; quadrant++)
		if (extent_has(extent, terrain_child(tile, quadrant)) && !terrain_stored(source, terrain_child(tile, quadrant)))
			return true;
	return false;
}

#endif
