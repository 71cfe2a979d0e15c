/*
 * How coarse a view must be to need no more tiles than there are places for.
 *
 * Tiles are divided in the order in which a growing radius would divide them. With a limit on the error, it is the order of a
 * shrinking limit. Dividing stops before the tile that would exceed the budget, and the radius ends there. render_select then
 * draws with that smaller radius, by its usual rules. The result depends only on the view, so a fixed camera always gets the same
 * picture.
 *
 * Invariants:
 *   1. `needed` is at least what render_select would count if every tile divided here were.
 *   2. Tiles of one ratio are divided together or not at all: no radius lies between them. The eye
 *      inside a box is ratio 0 at any level: there it is the levels that part them, coarser first.
 *      What is without error is never near, so never divided.
 */
#include <float.h>

#include "render/select_place.h"

#define NODES_MAX (2 * RENDER_DRAWS_MAX)

/* A tile that the original view would divide. */
struct node {
	struct tile tile;
	double ratio; /* not less than its parent's */
	double low, high;
};

struct fitter {
	const struct extent *extent;
	const struct render_view *view;
	const struct render_source *source;
	struct node heap[NODES_MAX]; /* next to divide first */
	size_t count;
	size_t needed;
	bool full; /* a node had no place */
};

static bool before(const struct node *a, const struct node *b)
{
	return a->ratio != b->ratio ? a->ratio < b->ratio : a->tile.level > b->tile.level;
}

static void push(struct fitter *fitter, const struct node *node)
{
	if (fitter->count == NODES_MAX) {
		fitter->full = true;
		return;
	}
	size_t at = fitter->count++;
	for (; at > 0 && before(node, &fitter->heap[(at - 1) / 2]); at = (at - 1) / 2)
		fitter->heap[at] = fitter->heap[(at - 1) / 2];
	fitter->heap[at] = *node;
}

static struct node pop(struct fitter *fitter)
{
	struct node *heap = fitter->heap, first = heap[0], last = heap[--fitter->count];
	size_t at = 0;
	for (;;) {
		size_t next = 2 * at + 1;
		if (next + 1 < fitter->count && before(&heap[next + 1], &heap[next]))
			next++;
		if (next >= fitter->count || !before(&heap[next], &last))
			break;
		heap[at] = heap[next];
		at = next;
	}
	heap[at] = last;
	return first;
}

static bool in_view(const struct fitter *fitter, const struct render_place *place)
{
	return render_box_visible(fitter->view->planes, place->low, place->high);
}

/* Adds a tile that the picture may need. Returns false if it is out of view. */
static bool enter(struct fitter *fitter, const struct render_place *place, double least)
{
	if (!in_view(fitter, place))
		return false;
	struct node node = {place->tile, place->ratio > least ? place->ratio : least, place->low[2], place->high[2]};
	if (render_divides(fitter->view, place->tile, node.ratio) &&
	    fitter->source->divisible(fitter->source->user, place->tile))
		push(fitter, &node);
	return true;
}

static void divide(struct fitter *fitter, const struct node *node)
{
	size_t children = 0;
	bool own = false;
	for (unsigned quadrant = 0; quadrant < 4; quadrant++) {
		struct tile child = render_child(node->tile, quadrant);
		struct render_place place;
		if (!extent_has(fitter->extent, child))
			continue;
		if (render_place_find(fitter->extent, fitter->view, fitter->source, child, &place)) {
			children += enter(fitter, &place, node->ratio);
		} else if (node->tile.level <= 0) {
			render_place_put(fitter->extent, fitter->view, child, node->low, node->high, &place);
			own = own || in_view(fitter, &place);
		}
	}
	bool coarsest = node->tile.level == extent_coarsest(fitter->extent);
	bool ground = children > 0 && render_carries(fitter->extent, fitter->source, node->tile);
	fitter->needed += children - !(coarsest || ground || own);
}

bool render_fit(const struct extent *extent, const struct render_source *source, size_t budget,
		 struct render_view *view)
{
	struct fitter fitter = {.extent = extent, .view = view, .source = source, .needed = 1};
	struct render_place place;
	struct tile root = {extent_coarsest(extent), 0, 0};
	if (!render_place_find(extent, view, source, root, &place) || !enter(&fitter, &place, 0))
		return true;
	while (fitter.count > 0) {
		double ratio = fitter.heap[0].ratio;
		int level = fitter.heap[0].tile.level;
		while (fitter.count > 0 && !fitter.full && fitter.heap[0].ratio == ratio &&
		       (ratio > 0 || fitter.heap[0].tile.level == level)) {
			struct node node = pop(&fitter);
			divide(&fitter, &node);
		}
		if (fitter.needed <= budget && !fitter.full)
			continue;
		view->radius = ratio > 0 ? ratio : DBL_MIN;
		if (ratio == 0)
			view->finest = level;
		return false;
	}
	return true;
}
