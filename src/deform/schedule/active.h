/* Shared by schedule/active.c, which has the functions that callers use, and schedule/active_flags.c, which reads the flags. */
#ifndef FURROW_DEFORM_ACTIVE_H
#define FURROW_DEFORM_ACTIVE_H

#include "deform/internal.h"
#include "deform/schedule/touched.h"

#define VISITS 3 /* the most visits whose flags are not read yet; before one more visit, the oldest flags are waited for */
/* flag words for all contacts of one period; if too few are left, a contact activates all blocks that its window lies on */
#define CONTACT_WORDS 8192
#define WINDOW_BLOCKS ((DEFORM_WHOLE_POSTS / SOIL_BLOCK + 1) * (DEFORM_WHOLE_POSTS / SOIL_BLOCK + 1)) /* most blocks that a window lies on */

#define CONTACT_BYTES ((CONTACT_WORDS + WINDOW_BLOCKS) * sizeof(uint32_t))
#define PERIOD_BYTES (CONTACT_WORDS * sizeof(uint32_t))
#define VISIT_BYTES (DEFORM_BLOCKS_MAX * sizeof(uint32_t))
#define CHANGED 16 /* in a flag word: the first of 16 bits, one for each part of the block, set if the part changed (flags.glsl) */

struct visit {
	struct gpu_staging *flags;    /* DEFORM_BLOCKS_MAX words, one for each visited block */
	struct soil_block *visited; /* the blocks that the interval computed, in the order of the flags */
	size_t count;
};

/* A window that was written to tiles, and whose flags have not been read from the GPU yet. */
struct swept {
	struct post_rect write;
	bool above; /* as in struct deform_contact */
};

/* A period: the time from one visit to the next. A visit is one interval of relaxation, in which all active blocks are computed. */
struct period {
	struct soil_block_set woken;    /* blocks that were activated without flags */
	struct swept *swept;       /* the windows of this period: `count` in use, room for `room` */
	size_t count, room;
	struct gpu_staging *flags; /* CONTACT_WORDS: flags of these windows, if `asked` */
	bool asked;                /* the transfer of the flags has started */
};

struct active {
	/* known: blocks that were active after the last visit whose flags were read. blocks: blocks that are active now, as far as is
	 * known; too many rather than too few. next: used to build the next `blocks` */
	struct soil_block_set known, blocks, next;
	struct visit visits[VISITS];       /* visits whose flags are not read yet, oldest first */
	size_t visit_count;                /* number of them */
	/* [0]: the period after the visit whose flags gave `known`; [i + 1]: the period after visits[i] */
	struct period periods[VISITS + 1];
	struct gpu_buffer *contact_flags;  /* CONTACT_WORDS, then room for one window whose flags nobody reads */
	uint32_t used;                     /* words of contact_flags that the current period uses so far */
	/* touched: posts known to have changed. maybe: posts that may have changed, since flags are missing. Both are used only
	 * if params.touched */
	struct touched touched, maybe;
};

/* The blocks on which a window lies, in rows from the south-west. */
struct block_grid {
	int64_t x, y; /* column and row of the first, counted from the south-west of the world */
	uint32_t columns, rows;
};

/* schedule/active_flags.c */
void deform_active_visit_finish(struct visit *visit);    /* keeps its staging buffer */
void deform_active_period_finish(struct period *period); /* keeps its staging buffer */
/* Adds a block. Does nothing if it lies outside the world. */
enum status deform_active_add(const struct deform *deform, struct soil_block_set *set, int64_t x, int64_t y) FURROW_CHECKED;
/* Adds all blocks that an interval may change if the posts of `changed` have changed. */
enum status deform_active_add_near(const struct deform *deform, struct soil_block_set *set, struct post_rect changed) FURROW_CHECKED;
/* Adds all neighbours of the blocks in the set. */
enum status deform_active_widen(const struct deform *deform, struct soil_block_set *set) FURROW_CHECKED;
/* Returns the blocks on which these posts lie. */
struct block_grid deform_active_grid(struct post_rect write);
/* Returns true if any post of the rectangle is in `touched` or in `maybe`. */
bool deform_active_is_touched(const struct active *active, struct post_rect rect);
/* Each adds to `maybe` all posts that a window or a visit with unknown flags may have changed. */
enum status deform_active_maybe_swept(struct active *active, const struct swept *swept) FURROW_CHECKED;
enum status deform_active_maybe_visited(struct deform *deform, const struct visit *visit) FURROW_CHECKED;
/* deform_active_settle: reads the flags whose fence has passed; if there are any, *came is true, and all sets are built again.
 * deform_active_wait: waits for all flags, then does the same. */
enum status deform_active_settle(struct deform *deform, bool *came) FURROW_CHECKED;
enum status deform_active_wait(struct deform *deform) FURROW_CHECKED;

#endif
