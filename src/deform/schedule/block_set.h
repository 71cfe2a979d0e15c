/*
 * A set of blocks: a list, and a hash table of indices into the list. A key_set cannot be used: its keys have 64 bits, and a block
 * has 64 bits in x and 64 bits in y. One thread at a time uses a set. A set starts as {0}.
 */
#ifndef FURROW_DEFORM_BLOCK_SET_H
#define FURROW_DEFORM_BLOCK_SET_H

#include "deform/deform.h"

struct block_set {
	struct deform_block *blocks; /* `count` blocks, in the order in which they were added */
	uint32_t *places;            /* 1 + the index in blocks; 0: none */
	size_t count, room;          /* room: of places, a power of two or 0; blocks have half of it */
};

void deform_block_set_finish(struct block_set *set);
enum status deform_block_set_add(struct block_set *set, struct deform_block block) FURROW_CHECKED;
bool deform_block_set_has(const struct block_set *set, struct deform_block block);
/* Returns the block's index in `blocks`; `count` if it is not in the set. */
size_t deform_block_set_place(const struct block_set *set, struct deform_block block);
/* Removes all blocks from the set and keeps its memory. */
void deform_block_set_clear(struct block_set *set);
/* Sorts the blocks along a Morton curve. Then all blocks of one tile are neighbours in the list, for any size of tiles. No block
 * may have a negative x or y. */
void deform_block_set_sort(struct block_set *set);

#endif
