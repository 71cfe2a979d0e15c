/* A set of blocks: a list, and a hash table of indices into the list. A key_set cannot be used: its keys have 64 bits, and a block has 64
 * bits in x and 64 bits in y. */
#include "soil/soil.h"

#include <stdlib.h>
#include <string.h>

void soil_block_set_finish(struct soil_block_set *set)
{
	mem_free_all(set->blocks, set->places);
	*set = (struct soil_block_set){.count = 0};
}

static size_t place_of(const struct soil_block_set *set, struct soil_block block)
{
	uint64_t hash = (uint64_t)block.x * 0x9e3779b97f4a7c15u ^ (uint64_t)block.y * 0xc2b2ae3d27d4eb4fu;
	size_t place = (size_t)((hash ^ hash >> 32) & (set->room - 1));
	for (;; place = (place + 1) & (set->room - 1)) {
		uint32_t at = set->places[place];
		if (at == 0 || (set->blocks[at - 1].x == block.x && set->blocks[at - 1].y == block.y))
			return place;
	}
}

static void index_all(struct soil_block_set *set)
{
	memset(set->places, 0, set->room * sizeof *set->places);
	for (size_t i = 0; i < set->count; i++)
		set->places[place_of(set, set->blocks[i])] = (uint32_t)i + 1;
}

static enum status grow(struct soil_block_set *set)
{
	size_t room = set->room != 0 ? 2 * set->room : 128;
	TRY(mem_resize(&set->blocks, room / 2, sizeof *set->blocks, "the active blocks"));
	TRY(mem_resize(&set->places, room, sizeof *set->places, "the active blocks"));
	set->room = room;
	index_all(set);
	return STATUS_OK;
}

enum status soil_block_set_add(struct soil_block_set *set, struct soil_block block)
{
	if (2 * set->count == set->room)
		TRY(grow(set));
	size_t place = place_of(set, block);
	if (set->places[place] == 0) {
		set->blocks[set->count++] = block;
		set->places[place] = (uint32_t)set->count;
	}
	return STATUS_OK;
}

bool soil_block_set_has(const struct soil_block_set *set, struct soil_block block)
{
	return set->room != 0 && set->places[place_of(set, block)] != 0;
}

size_t soil_block_set_place(const struct soil_block_set *set, struct soil_block block)
{
	uint32_t at = set->room != 0 ? set->places[place_of(set, block)] : 0;
	return at != 0 ? at - 1 : set->count;
}

void soil_block_set_clear(struct soil_block_set *set)
{
	if (set->count > 0)
		memset(set->places, 0, set->room * sizeof *set->places);
	set->count = 0;
}

/* The one with the higher differing bit decides. */
static int morton(const void *pa, const void *pb)
{
	const struct soil_block *a = pa, *b = pb;
	uint64_t dx = (uint64_t)(a->x ^ b->x), dy = (uint64_t)(a->y ^ b->y);
	if (dx == 0 && dy == 0)
		return 0;
	bool by_x = dy < dx && dy < (dx ^ dy);
	return (by_x ? a->x < b->x : a->y < b->y) ? -1 : 1;
}

void soil_block_set_sort(struct soil_block_set *set)
{
	if (set->count > 0)
		qsort(set->blocks, set->count, sizeof *set->blocks, morton);
	if (set->count > 0)
		index_all(set);
}

size_t soil_blocks_sort(struct soil_block *blocks, size_t count)
{
	size_t kept = 0;
	if (count > 0)
		qsort(blocks, count, sizeof *blocks, morton);
	for (size_t i = 0; i < count; i++)
		if (kept == 0 || morton(&blocks[kept - 1], &blocks[i]) != 0)
			blocks[kept++] = blocks[i];
	return kept;
}
