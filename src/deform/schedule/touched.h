/*
 * Which posts may be other than they ever were: a bit a post, in blocks, of which only those are kept that have one. One
 * thread. Starts as {0}. It never forgets: about 170 bytes for each block in which anything was touched, 16 where all is.
 */
#ifndef FURROW_DEFORM_TOUCHED_H
#define FURROW_DEFORM_TOUCHED_H

#include "deform/schedule/block_set.h"

struct touched {
	struct block_set blocks;
	uint32_t *whiches;              /* of each of the blocks: its rows; 0: those of blocks that came whole */
	uint32_t (*rows)[DEFORM_BLOCK]; /* `count` of them, the first all ones; from the south, bit 0 is the west */
	size_t which_room, count, room;
};

void deform_touched_finish(struct touched *touched);
/* Empties it and keeps the memory. */
void deform_touched_clear(struct touched *touched);
/* Of rectangles what lies south or west of the world is not looked at. */
enum status deform_touched_add(struct touched *touched, struct post_rect rect) FURROW_CHECKED;
bool deform_touched_any(const struct touched *touched, struct post_rect rect);
/* Into it come the block's posts, of the parts, that lie no farther than `by` (less than a block), along x and along y, from
 * any that is in `from`. Parts: squares of TOUCHED_PART x TOUCHED_PART posts, a bit each, from the south-west. */
enum status deform_touched_grow(struct touched *touched, const struct touched *from, struct deform_block block, int64_t by,
			 uint32_t parts) FURROW_CHECKED;
#define TOUCHED_PART 8
#define TOUCHED_PARTS 0xffffu
/* The posts of a part of a block. */
struct post_rect deform_touched_part(struct deform_block block, int part);

#endif
