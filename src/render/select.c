/*
 * Which tiles a view draws: by the dissertation's distance radii, or by its Equation 3.
 *
 * One descent from the coarsest tile. A tile nearer than its radius is divided, and each child covers its quadrant or fails. If it
 * fails, the nearest resident ancestor draws that quadrant.
 *
 * Invariants:
 *   1. cover() returns true only if the visible ground of the tile is drawn exactly once by the draws
 *      it appended; when it returns false it appended none.
 *   2. Draws a tile gives up (because an ancestor must draw their ground) are always the last ones,
 *      so giving up is shortening the array.
 *   3. A place is kept free for each tile that is being divided: it may have to stand in.
 *   4. What is divided, and so what is needed, does not depend on what is resident; each needed tile
 *      that is not resident is wanted once.
 */
#include <stdlib.h>

#include "render/select_place.h"

struct want {
	uint64_t key;
	int level;
	double distance;
};

struct selector {
	const struct extent *extent;
	const struct render_view *view;
	const struct render_source *source;
	struct render_selection *out;
	size_t open; /* tiles being divided */
	struct want wants[RENDER_DRAWS_MAX];
	size_t want_count;
};

static int compare_wants(const void *a, const void *b)
{
	const struct want *p = a, *q = b;
	if (p->level != q->level)
		return p->level > q->level ? -1 : 1;
	if (p->distance != q->distance)
		return p->distance < q->distance ? -1 : 1;
	return p->key < q->key ? -1 : p->key > q->key;
}

/* Adds a wanted tile. If the list is full, its least needed entry is dropped. */
static void want(struct selector *s, struct tile tile, double distance)
{
	struct want entry = {tile_key(tile), tile.level, distance};
	if (s->want_count < RENDER_DRAWS_MAX) {
		s->wants[s->want_count++] = entry;
		return;
	}
	size_t worst = 0;
	for (size_t i = 1; i < s->want_count; i++)
		if (compare_wants(&s->wants[i], &s->wants[worst]) > 0)
			worst = i;
	if (compare_wants(&entry, &s->wants[worst]) < 0)
		s->wants[worst] = entry;
}

static bool append(struct selector *s, const struct render_draw *draw)
{
	if (s->out->draw_count + s->open >= RENDER_DRAWS_MAX)
		return false;
	s->out->draws[s->out->draw_count++] = *draw;
	return true;
}

static bool in_view(struct selector *s, const struct render_place *place)
{
	if (render_box_visible(s->view->planes, place->low, place->high))
		return true;
	s->out->culled++;
	return false;
}

static bool cover(struct selector *s, const struct render_place *place);

/* Selects the children of a divided tile. Then the tile itself must still draw some quadrants, each a bit. `own`: quadrants for
 * which there are no finer tiles. `standing`: quadrants whose finer tiles are not resident yet. */
static void cover_children(struct selector *s, const struct render_place *place, unsigned *own,
			   unsigned *standing)
{
	struct tile tile = place->tile;
	/* Begin with the nearest quadrant, so that it gets the slots that are still free. */
	double middle[2];
	double side = extent_spacing(s->extent, tile.level) * s->extent->cells;
	middle[0] = (tile.x + 0.5) * side;
	middle[1] = (tile.y + 0.5) * side;
	unsigned nearest = (s->view->eye[0] >= middle[0] ? 1u : 0u) | (s->view->eye[1] >= middle[1] ? 2u : 0u);

	for (unsigned i = 0; i < 4; i++) {
		unsigned quadrant = nearest ^ i;
		struct tile child = render_child(tile, quadrant);
		struct render_place there;
		if (!extent_has(s->extent, child))
			continue;
		if (render_place_find(s->extent, s->view, s->source, child, &there)) {
			there.above = place;
			if (!cover(s, &there))
				*standing |= 1u << quadrant;
		} else if (tile.level <= 0) {
			render_place_put(s->extent, s->view, child, place->low[2], place->high[2], &there);
			if (in_view(s, &there))
				*own |= 1u << quadrant;
		}
	}
}

/* A tile whose base is interpolated needs the tile above that has base heights too, for the broad shape of the ground. Counts that
 * tile, and requests it if it is not resident. */
static void need_ground(struct selector *s, const struct render_place *place)
{
	uint32_t slot;
	s->out->needed++;
	if (!s->source->resident(s->source->user, place->tile, &slot))
		want(s, place->tile, place->distance);
}

static void fill_errors(const struct render_place *place, double errors[RENDER_STRIDES])
{
	double most = 0;
	for (int k = 0; k < RENDER_STRIDES; k++) {
		most = fmax(most, place->error);
		errors[k] = most;
		if (place->above != NULL)
			place = place->above;
		else /* any surface through some of its posts is within their range */
			most = fmax(most, place->high[2] - place->low[2]);
	}
}

static bool cover(struct selector *s, const struct render_place *place)
{
	struct render_selection *out = s->out;
	struct tile tile = place->tile;
	size_t mark = out->draw_count;

	out->visited++;
	if (!in_view(s, place))
		return true;

	bool divisible = s->source->divisible(s->source->user, tile);
	bool coarsest = tile.level == extent_coarsest(s->extent);
	bool ground = false, divided = divisible && render_divides(s->view, tile, place->ratio);
	unsigned own = 15, standing = 0;
	if (divided) {
		size_t ideal = out->ideal;
		own = 0;
		s->open++;
		cover_children(s, place, &own, &standing);
		s->open--;
		ground = own == 0 && out->ideal > ideal && render_carries(s->extent, s->source, tile);
		if (ground && !coarsest)
			need_ground(s, place);
		if ((own | standing) == 0)
			return true;
	}
	if (own) {
		out->ideal++;
		out->needed += !coarsest;
	}

	struct render_draw draw = {
		.tile = tile, .ground = RENDER_NO_SLOT, .ground_level = tile.level, .quadrants = own | standing, .finest = !divisible,
		.divided = divided, .standing = standing, .replaces = own == 0 && !ground && !coarsest,
		.low = place->low[2], .high = place->high[2], .distance = place->distance,
	};
	if (s->view->by_error)
		fill_errors(place, draw.errors);
	if (!s->source->resident(s->source->user, tile, &draw.slot)) {
		if (own && !coarsest)
			want(s, tile, place->distance);
		out->draw_count = mark;
		return false;
	}
	return append(s, &draw);
}

static int compare_draws(const void *a, const void *b)
{
	const struct render_draw *p = a, *q = b;
	if (p->distance != q->distance)
		return p->distance < q->distance ? -1 : 1;
	uint64_t left = tile_key(p->tile), right = tile_key(q->tile);
	return left < right ? -1 : left > right;
}

static void find_ground(struct selector *s)
{
	struct render_selection *out = s->out;
	for (size_t i = 0; i < out->draw_count; i++) {
		struct render_draw *draw = &out->draws[i];
		struct tile tile = draw->tile;
		draw->ground = draw->slot;
		while (!render_stored(s->source, tile))
			tile = tile_ancestor(tile, tile.level + 1);
		draw->ground_level = tile.level;
		if (tile.level != draw->tile.level && !s->source->resident(s->source->user, tile, &draw->ground))
			draw->ground = RENDER_NO_SLOT;
	}
}

void render_select(const struct extent *extent, const struct render_view *view,
		    const struct render_source *source, struct render_selection *selection)
{
	struct selector s = {.extent = extent, .view = view, .source = source, .out = selection};
	struct tile root = {extent_coarsest(extent), 0, 0};
	struct render_place place;
	uint32_t slot;

	selection->coarsest = RENDER_NO_SLOT;
	selection->draw_count = selection->wanted_count = 0;
	selection->visited = selection->culled = selection->ideal = selection->needed = 0;
	if (!render_place_find(extent, view, source, root, &place))
		return;
	/* The coarsest tile can replace every other tile, so it is needed even if it is not visible. */
	selection->needed = 1;
	if (!source->resident(source->user, root, &slot))
		want(&s, root, place.distance);
	else
		selection->coarsest = slot;
	cover(&s, &place);
	qsort(selection->draws, selection->draw_count, sizeof *selection->draws, compare_draws);
	find_ground(&s);

	qsort(s.wants, s.want_count, sizeof *s.wants, compare_wants);
	for (size_t i = 0; i < s.want_count; i++)
		selection->wanted[i] = s.wants[i].key;
	selection->wanted_count = s.want_count;
}
