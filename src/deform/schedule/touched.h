/*
 * A set of touched posts: posts that may have changed. It has a bit for each post. The bits are in blocks; a block without a
 * touched post takes no memory. A block needs about 170 bytes, or 16 bytes if all its posts are touched. A set starts as {0}, and
 * grows until it is cleared. One thread at a time uses it.
 */
#ifndef FURROW_DEFORM_TOUCHED_H
#define FURROW_DEFORM_TOUCHED_H

#include "deform/deform.h"

struct touched {
	struct soil_block_set blocks;
	uint32_t *whiches;              /* for each block its index in `rows`; 0: all its posts are touched */
	uint32_t (*rows)[SOIL_BLOCK]; /* `count` entries, the first all ones; rows from the south, bit 0 is the west */
	size_t which_room, count, room;
};

void deform_touched_finish(struct touched *touched);
/* Removes all posts from the set and keeps its memory. */
void deform_touched_clear(struct touched *touched);
/* Adds the posts of a rectangle. Posts south or west of the world are ignored. */
enum status deform_touched_add(struct touched *touched, struct post_rect rect) FURROW_CHECKED;
bool deform_touched_any(const struct touched *touched, struct post_rect rect);
/* Adds posts of a block that are near posts of the set `from`: at most `by` posts away along x and along y. Only some parts of the
 * block are filled. `by` is less than SOIL_BLOCK. `parts`: a bit for each square of TOUCHED_PART x TOUCHED_PART posts, from the
 * south-west. */
enum status deform_touched_grow(struct touched *touched, const struct touched *from, struct soil_block block, int64_t by,
			 uint32_t parts) FURROW_CHECKED;
#define TOUCHED_PART 8
#define TOUCHED_PARTS 0xffffu
/* Returns the posts of a part of a block. */
struct post_rect deform_touched_part(struct soil_block block, int part);

#endif
