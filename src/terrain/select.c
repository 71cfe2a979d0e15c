/*
 * Which tiles a view draws, by the dissertation's distance radii.
 *
 * One descent from the coarsest tile. A tile nearer than its radius is divided; each child covers its
 * quadrant or fails to, and what fails is drawn by the nearest ancestor that is resident.
 *
 * Invariants:
 *   1. cover() returns true only if the visible ground of the tile is drawn exactly once by the draws
 *      it appended; when it returns false it appended none.
 *   2. Draws a tile gives up (because an ancestor must draw their ground) are always the last ones,
 *      so giving up is shortening the array.
 *   3. A place is kept free for each tile that is being divided: it may have to stand in.
 */
#include "terrain/terrain.h"

#include <stdlib.h>

struct want {
	uint64_t key;
	int level;
	double distance;
};

struct selector {
	const struct world *world;
	const struct terrain_view *view;
	const struct terrain_source *source;
	struct terrain_selection *out;
	size_t open; /* tiles being divided */
	struct want wants[TERRAIN_DRAWS_MAX];
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

/* A full list loses its least needed entry. */
static void want(struct selector *s, struct tile tile, double distance)
{
	struct want entry = {tile_key(tile), tile.level, distance};
	if (s->want_count < TERRAIN_DRAWS_MAX) {
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

static bool append(struct selector *s, const struct terrain_draw *draw)
{
	if (s->out->draw_count + s->open >= TERRAIN_DRAWS_MAX)
		return false;
	s->out->draws[s->out->draw_count++] = *draw;
	return true;
}

static struct tile child_of(struct tile tile, unsigned quadrant)
{
	return (struct tile){tile.level - 1, 2 * tile.x + (quadrant & 1), 2 * tile.y + (quadrant >> 1)};
}

/* A tile in its box; low and high are of its heights. */
struct place {
	struct tile tile;
	double low[3], high[3], distance;
};

static void place_at(const struct selector *s, struct tile tile, double low, double high,
		     struct place *place)
{
	place->tile = tile;
	terrain_box(s->world, tile, place->low, place->high);
	place->low[2] = low;
	place->high[2] = high;
	place->distance = terrain_box_distance(s->view->eye, place->low, place->high);
}

static bool in_view(struct selector *s, const struct place *place)
{
	if (terrain_box_visible(s->view->planes, place->low, place->high))
		return true;
	s->out->culled++;
	return false;
}

static bool cover(struct selector *s, const struct place *place);

/* What of a divided tile is left for the tile itself: `own` has nothing finer, `standing` should be
 * drawn finer and cannot. */
static void cover_children(struct selector *s, const struct place *place, unsigned *own,
			   unsigned *standing)
{
	struct tile tile = place->tile;
	/* Nearest quadrant first: it gets what room there is. */
	double middle[2];
	double side = world_spacing(s->world, tile.level) * s->world->cells;
	middle[0] = (tile.x + 0.5) * side;
	middle[1] = (tile.y + 0.5) * side;
	unsigned nearest = (s->view->eye[0] >= middle[0] ? 1u : 0u) | (s->view->eye[1] >= middle[1] ? 2u : 0u);

	for (unsigned i = 0; i < 4; i++) {
		unsigned quadrant = nearest ^ i;
		struct tile child = child_of(tile, quadrant);
		struct place there;
		double low, high;
		if (!world_has(s->world, child))
			continue;
		if (s->source->bounds(s->source->user, child, &low, &high)) {
			place_at(s, child, low, high, &there);
			if (!cover(s, &there))
				*standing |= 1u << quadrant;
		} else if (tile.level <= 0) {
			place_at(s, child, place->low[2], place->high[2], &there);
			if (in_view(s, &there))
				*own |= 1u << quadrant;
		}
	}
}

static bool cover(struct selector *s, const struct place *place)
{
	struct terrain_selection *out = s->out;
	struct tile tile = place->tile;
	size_t mark = out->draw_count;

	out->visited++;
	if (!in_view(s, place))
		return true;

	bool divisible = tile.level > TILE_LEVEL_MIN && s->source->divisible(s->source->user, tile);
	double side = world_spacing(s->world, tile.level) * s->world->cells;
	unsigned own = 15, standing = 0;
	if (divisible && place->distance < s->view->radius * side) {
		own = 0;
		s->open++;
		cover_children(s, place, &own, &standing);
		s->open--;
		if ((own | standing) == 0)
			return true;
	}
	if (own)
		out->ideal++;

	struct terrain_draw draw = {
		.tile = tile, .ground = TERRAIN_NO_SLOT, .quadrants = own | standing, .finest = !divisible,
		.low = place->low[2], .high = place->high[2], .distance = place->distance,
	};
	if (!s->source->resident(s->source->user, tile, &draw.slot)) {
		if (own)
			want(s, tile, place->distance);
		out->draw_count = mark;
		return false;
	}
	return append(s, &draw);
}

static int compare_draws(const void *a, const void *b)
{
	const struct terrain_draw *p = a, *q = b;
	if (p->distance != q->distance)
		return p->distance < q->distance ? -1 : 1;
	uint64_t left = tile_key(p->tile), right = tile_key(q->tile);
	return left < right ? -1 : left > right;
}

/* Below level 0 the ground's broad shape is read from the level-0 tile. */
static void find_ground(struct selector *s)
{
	struct terrain_selection *out = s->out;
	for (size_t i = 0; i < out->draw_count; i++) {
		struct terrain_draw *draw = &out->draws[i];
		draw->ground = draw->slot;
		if (draw->tile.level >= 0)
			continue;
		struct tile tile = tile_ancestor(draw->tile, 0);
		if (!s->source->resident(s->source->user, tile, &draw->ground)) {
			draw->ground = TERRAIN_NO_SLOT;
			want(s, tile, draw->distance);
		}
	}
}

void terrain_select(const struct world *world, const struct terrain_view *view,
		    const struct terrain_source *source, struct terrain_selection *selection)
{
	struct selector s = {.world = world, .view = view, .source = source, .out = selection};
	struct tile root = {world_coarsest(world), 0, 0};
	struct place place;
	double low, high;
	uint32_t slot;

	selection->draw_count = selection->wanted_count = 0;
	selection->visited = selection->culled = selection->ideal = 0;
	if (!source->bounds(source->user, root, &low, &high))
		return;
	place_at(&s, root, low, high, &place);
	/* It stands in for everything: never let it age. */
	if (!source->resident(source->user, root, &slot))
		want(&s, root, place.distance);
	cover(&s, &place);
	qsort(selection->draws, selection->draw_count, sizeof *selection->draws, compare_draws);
	find_ground(&s);

	qsort(s.wants, s.want_count, sizeof *s.wants, compare_wants);
	for (size_t i = 0; i < s.want_count; i++) {
		bool again = false; /* a level-0 tile may be wanted for several below it */
		for (size_t k = selection->wanted_count; k-- > 0 && !again;)
			again = selection->wanted[k] == s.wants[i].key;
		if (!again)
			selection->wanted[selection->wanted_count++] = s.wants[i].key;
	}
}
