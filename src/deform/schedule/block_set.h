/* A set of blocks: a list, and a hash table of indices into the list. Not a key_set: its keys have 64 bits, and a block has 64 in x
 * and 64 in y. For one thread. Starts as {0}. */
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
/* Empties it and keeps the memory. */
void deform_block_set_clear(struct block_set *set);
/* Sorts the blocks along a Morton curve. Then the blocks of a tile are neighbours in the list, whatever the tiles' size. No block
 * may have a negative place. */
void deform_block_set_sort(struct block_set *set);

#endif
