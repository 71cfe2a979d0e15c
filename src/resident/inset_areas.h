/* Where the store's insets lie, so that walkers go in small steps there and in large ones
 * elsewhere. Any thread; never changes. */
#ifndef FURROW_RESIDENT_INSET_AREAS_H
#define FURROW_RESIDENT_INSET_AREAS_H

#include "store/store.h"

struct inset_area {
	double x0, y0, x1, y1; /* posts of level 0, with the edge */
	int level;             /* below 0 */
};

struct inset_areas {
	uint32_t cells;
	struct inset_area *areas; /* owned */
	size_t count;
};

/* Lists the insets. A store that has some and does not say where counts as one inset. */
enum status resident_inset_areas_init(const struct store *store,
                               struct inset_areas *insets) FURROW_CHECKED;
void resident_inset_areas_finish(struct inset_areas *insets); /* may be all zero */
/* Returns the finest level of which a base tile may lie within `reach` of (x, y), in posts of level
 * 0; 0: no inset does. */
int resident_inset_areas_level(const struct inset_areas *insets, double x, double y, double reach);

#endif
