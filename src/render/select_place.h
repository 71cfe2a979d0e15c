/* What select.c and fit.c share: the box of a tile, and the test if a tile is divided. */
#ifndef FURROW_RENDER_SELECT_PLACE_H
#define FURROW_RENDER_SELECT_PLACE_H

#include <math.h>

#include "render/select.h"

/* A tile and its box. low[2] and high[2] are its lowest and highest height. */
struct render_place {
	struct tile tile;
	double low[3], high[3];
	double distance; /* metres, from the eye to the box */
	double error;    /* metres, as the source gives it; 0 if radii decide */
	double ratio;    /* distance / the tile's side; with by_error, distance / the tile's error */
	const struct render_place *above; /* the tile whose division gave this tile; NULL: none */
};

static inline struct tile render_child(struct tile tile, unsigned quadrant)
{
	return (struct tile){tile.level - 1, 2 * tile.x + (quadrant & 1), 2 * tile.y + (quadrant >> 1)};
}

static inline void render_place_put(const struct extent *extent, const struct render_view *view, struct tile tile,
			       double low, double high, struct render_place *place)
{
	place->tile = tile;
	render_box(extent, tile, place->low, place->high);
	place->low[2] = low;
	place->high[2] = high;
	place->distance = render_box_distance(view->eye, place->low, place->high);
}

/* Fills `place`. Returns false if the tile has nothing to draw. */
static inline bool render_place_find(const struct extent *extent, const struct render_view *view,
				const struct render_source *source, struct tile tile, struct render_place *place)
{
	double low, high;
	if (!source->bounds(source->user, tile, &low, &high))
		return false;
	render_place_put(extent, view, tile, low, high, place);
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
static inline bool render_divides(const struct render_view *view, struct tile tile, double ratio)
{
	return tile.level > view->finest && ratio < view->radius;
}

static inline bool render_stored(const struct render_source *source, struct tile tile)
{
	return tile.level >= 0 || (source->stored != NULL && source->stored(source->user, tile));
}

/* Returns true if the tile has base heights of its own, and a tile below it is interpolated from them. */
static inline bool render_carries(const struct extent *extent, const struct render_source *source, struct tile tile)
{
	if (tile.level > 0 || !render_stored(source, tile))
		return false;
	for (unsigned quadrant = 0; quadrant < 4; quadrant++)
		if (extent_has(extent, render_child(tile, quadrant)) && !render_stored(source, render_child(tile, quadrant)))
			return true;
	return false;
}

#endif
