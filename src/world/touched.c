/*
 * Which mirrors of the ground changed in a step (probes.c). A step notes rectangles that it changed, and at its end each mirror is compared
 * with those near it. Each with each would take the square of the number of bodies.
 *
 * Rectangles are sorted by their first post along the axis on which they are spread most. One that meets a mirror begins before the mirror's
 * end, and no farther before its beginning than the longest one is long.
 */
#include <stdlib.h>

#include "world/internal.h"

void world_touched_note(struct world_touched *touched, struct post_rect rect)
{
	if (touched->count == touched->room) {
		const size_t room = touched->room > 0 ? 2 * touched->room : 64;
		struct post_rect *rects = mem_realloc(touched->rects, room, sizeof *rects);
		if (rects == NULL) {
			touched->all = true;
			return;
		}
		touched->rects = rects;
		touched->room = room;
	}
	touched->rects[touched->count++] = rect;
}

static int64_t begin_of(const struct post_rect *rect, bool north)
{
	return north ? rect->y0 : rect->x0;
}

static int by_east(const void *a, const void *b)
{
	const struct post_rect *one = a, *other = b;
	return (one->x0 > other->x0) - (one->x0 < other->x0);
}

static int by_north(const void *a, const void *b)
{
	const struct post_rect *one = a, *other = b;
	return (one->y0 > other->y0) - (one->y0 < other->y0);
}

void world_touched_sort(struct world_touched *touched)
{
	struct post_rect around = {INT64_MAX, INT64_MAX, INT64_MIN, INT64_MIN};
	for (size_t i = 0; i < touched->count; i++)
		around = post_rect_around(around, touched->rects[i]);
	touched->north = touched->count > 0 && around.y1 - around.y0 > around.x1 - around.x0;
	touched->longest = 0;
	for (size_t i = 0; i < touched->count; i++) {
		const struct post_rect *rect = &touched->rects[i];
		const int64_t length = touched->north ? rect->y1 - rect->y0 : rect->x1 - rect->x0;
		touched->longest = length > touched->longest ? length : touched->longest;
	}
	if (touched->count > 0)
		qsort(touched->rects, touched->count, sizeof *touched->rects, touched->north ? by_north : by_east);
}

bool world_touched_meets(const struct world_touched *touched, struct post_rect rect)
{
	if (touched->all)
		return true;
	const int64_t first = begin_of(&rect, touched->north) - touched->longest, last = touched->north ? rect.y1 : rect.x1;
	size_t low = 0, high = touched->count;
	while (low < high) {
		const size_t middle = low + (high - low) / 2;
		if (begin_of(&touched->rects[middle], touched->north) < first)
			low = middle + 1;
		else
			high = middle;
	}
	for (; low < touched->count && begin_of(&touched->rects[low], touched->north) < last; low++)
		if (!post_rect_empty(post_rect_intersect(touched->rects[low], rect)))
			return true;
	return false;
}

void world_touched_clear(struct world_touched *touched)
{
	touched->count = 0;
	touched->all = false;
}

void world_touched_free(struct world_touched *touched)
{
	mem_free(touched->rects);
	*touched = (struct world_touched){.count = 0};
}
