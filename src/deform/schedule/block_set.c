#include "deform/schedule/block_set.h"

#include <assert.h>
#include <stdlib.h>

void deform_block_set_finish(struct block_set *set)
{
	mem_free(set->blocks);
	key_set_finish(&set->keys);
	*set = (struct block_set){.count = 0};
}

/* Of a block of a world: none has 2^32 blocks a side. */
static uint64_t key_of(struct deform_block block)
{
	assert(block.x >= 0 && block.x < UINT32_MAX && block.y >= 0 && block.y < UINT32_MAX);
	return (uint64_t)block.y << 32 | (uint64_t)block.x;
}

static enum status grow(struct block_set *set)
{
	size_t room = set->room != 0 ? 2 * set->room : 64;
	struct deform_block *blocks = mem_realloc(set->blocks, room, sizeof *blocks);
	if (blocks == NULL)
		return fail_memory("the awake blocks");
	set->blocks = blocks;
	set->room = room;
	return STATUS_OK;
}

enum status deform_block_set_add(struct block_set *set, struct deform_block block)
{
	uint32_t number;
	bool fresh = false;
	enum status status = set->count == set->room ? grow(set) : STATUS_OK;
	if (status == STATUS_OK)
		status = key_set_number(&set->keys, key_of(block), &number, &fresh);
	if (fresh)
		set->blocks[set->count++] = block;
	return status;
}

bool deform_block_set_has(const struct block_set *set, struct deform_block block)
{
	return deform_block_set_place(set, block) < set->count;
}

size_t deform_block_set_place(const struct block_set *set, struct deform_block block)
{
	uint32_t number;
	bool below = block.x < 0 || block.y < 0; /* the neighbour of a block at the world's edge */
	return !below && key_set_find(&set->keys, key_of(block), &number) ? number : set->count;
}

void deform_block_set_clear(struct block_set *set)
{
	key_set_clear(&set->keys);
	set->count = 0;
}

/* The one with the higher differing bit decides. */
static int morton(const void *pa, const void *pb)
{
	const struct deform_block *a = pa, *b = pb;
	uint64_t dx = (uint64_t)(a->x ^ b->x), dy = (uint64_t)(a->y ^ b->y);
	if (dx == 0 && dy == 0)
		return 0;
	bool by_x = dy < dx && dy < (dx ^ dy);
	return (by_x ? a->x < b->x : a->y < b->y) ? -1 : 1;
}

void deform_block_set_sort(struct block_set *set)
{
	if (set->count > 0)
		qsort(set->blocks, set->count, sizeof *set->blocks, morton);
	/* The numbers follow the new order; there is room for them. */
	key_set_clear(&set->keys);
	for (size_t i = 0; i < set->count; i++)
		key_set_put(&set->keys, key_of(set->blocks[i]));
}
