/*
 * Bodies that soil bears meet the ground together (src/world/meet.c) where their windows share a block of posts. Then one window has the posts of all of
 * them, also those between. So such bodies name all tiles of the rectangle around them, and their rank has all that the window reads.
 */
#include "fleet/internal.h"

#define BLOCK 32 /* posts on a side of a block, as there */

void fleet_together_finish(struct fleet_together *together)
{
	key_map_finish(&together->blocks);
	mem_free_all(together->areas, together->first);
	*together = (struct fleet_together){.areas = NULL};
}

enum status fleet_together_need(struct fleet_together *together, size_t count)
{
	if (count <= together->room)
		return STATUS_OK;
	TRY(mem_resize(&together->areas, count, sizeof *together->areas, "the ranks of bodies"));
	TRY(mem_resize(&together->first, count, sizeof *together->first, "the ranks of bodies"));
	together->room = count;
	return STATUS_OK;
}

static size_t first_of(size_t *first, size_t i)
{
	while (first[i] != i)
		i = first[i] = first[first[i]];
	return i;
}

static enum status join_block(struct fleet_together *together, uint64_t key, size_t i)
{
	const struct key_pair *pair = key_map_find(&together->blocks, key);
	if (pair == NULL)
		return key_map_put(&together->blocks, key, (double)i, 0);
	const size_t a = first_of(together->first, (size_t)pair->a), b = first_of(together->first, i);
	together->first[a > b ? a : b] = a > b ? b : a;
	return STATUS_OK;
}

enum status fleet_together_join(struct fleet_together *together, size_t count)
{
	struct post_rect *areas = together->areas;
	key_map_clear(&together->blocks);
	for (size_t i = 0; i < count; i++)
		together->first[i] = i;
	for (size_t i = 0; i < count; i++)
		for (int64_t y = areas[i].y0 > 0 ? areas[i].y0 / BLOCK : 0; y * BLOCK < areas[i].y1; y++)
			for (int64_t x = areas[i].x0 > 0 ? areas[i].x0 / BLOCK : 0; x * BLOCK < areas[i].x1; x++)
				TRY(join_block(together, (uint64_t)y << 32 | (uint64_t)x, i));
	for (size_t i = 0; i < count; i++) {
		const size_t first = first_of(together->first, i);
		areas[first] = post_rect_joined(areas[first], areas[i]);
	}
	for (size_t i = 0; i < count; i++)
		areas[i] = areas[first_of(together->first, i)];
	return STATUS_OK;
}
