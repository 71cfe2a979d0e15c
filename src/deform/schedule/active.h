/* What the files of active blocks share: schedule/active.c, which is asked and told, and schedule/active_flags.c, which reads what the GPU says. */
#ifndef FURROW_DEFORM_ACTIVE_H
#define FURROW_DEFORM_ACTIVE_H

#include "deform/schedule/block_set.h"
#include "deform/internal.h"
#include "deform/schedule/touched.h"

#define VISITS 3 /* under way at most: then it is waited for */
#define CONTACT_WORDS 8192 /* of contacts between two intervals; those beyond wake all that they write */
#define WINDOW_BLOCKS ((SIDE / DEFORM_BLOCK + 1) * (SIDE / DEFORM_BLOCK + 1)) /* that a window lies on, at most */

#define CONTACT_BYTES ((CONTACT_WORDS + WINDOW_BLOCKS) * sizeof(uint32_t))
#define PERIOD_BYTES (CONTACT_WORDS * sizeof(uint32_t))
#define VISIT_BYTES (DEFORM_BLOCKS_MAX * sizeof(uint32_t))
#define CHANGED 16 /* flags.glsl: from this bit on, the parts that were changed */

struct visit {
	struct gpu_staging *flags;    /* DEFORM_BLOCKS_MAX words */
	struct deform_block *visited; /* in the order of their flags */
	size_t count;
};

/* A window whose flags are not here yet. */
struct swept {
	struct post_rect write;
	bool above;
};

/* From one visit to the next. */
struct period {
	struct block_set woken;
	struct swept *swept;       /* `count` of them */
	size_t count, room;
	struct gpu_staging *flags; /* CONTACT_WORDS: theirs, if they are asked for */
	bool asked;
};

struct active {
	struct block_set known, blocks, next;
	struct visit visits[VISITS];
	size_t visit_count;
	struct period periods[VISITS + 1]; /* [0] since what is known, [i + 1] since visits[i] */
	struct gpu_buffer *contact_flags;         /* CONTACT_WORDS, and a window's that nobody reads */
	uint32_t used;                     /* of them, in this period */
	struct touched touched, maybe;     /* empty unless it is asked for */
};

/* Blocks on which a window lies, counted through from the south-west. */
struct block_grid {
	int64_t x, y; /* the first */
	uint32_t columns, rows;
};

/* schedule/active_flags.c */
void deform_active_visit_finish(struct visit *visit);    /* but for its staging */
void deform_active_period_finish(struct period *period); /* likewise */
/* Inside the world; else nothing is added. */
enum status deform_active_add(const struct deform *deform, struct block_set *set, int64_t x, int64_t y) FURROW_CHECKED;
/* All blocks in which something changes within an interval if posts in here do. */
enum status deform_active_add_near(const struct deform *deform, struct block_set *set, struct post_rect changed) FURROW_CHECKED;
/* By a block all round. */
enum status deform_active_widen(const struct deform *deform, struct block_set *set) FURROW_CHECKED;
struct block_grid deform_active_grid(struct post_rect write);
bool deform_active_is_touched(const struct active *active, struct post_rect rect);
/* What they may have changed, while their flags are on their way. */
enum status deform_active_maybe_swept(struct active *active, const struct swept *swept) FURROW_CHECKED;
enum status deform_active_maybe_visited(struct deform *deform, const struct visit *visit) FURROW_CHECKED;
/* Looks whether flags have come; then all sets anew. Of `wait` all come. */
enum status deform_active_settle(struct deform *deform, bool *came) FURROW_CHECKED;
enum status deform_active_wait(struct deform *deform) FURROW_CHECKED;

#endif
