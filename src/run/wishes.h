/*
 * Wishes: pages that will be needed, and when. Gathered anew from everything that looks ahead (the
 * objects' paths, the camera), then put in the order of need for the page cache.
 */
#ifndef FURROW_RUN_WISHES_H
#define FURROW_RUN_WISHES_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

struct wish {
	uint64_t key;
	double time; /* simulated seconds: when it is needed */
	size_t order; /* of adding: settles equal times */
};

struct wishes {
	struct wish *wishes;
	uint64_t *keys; /* filled by wishes_order */
	size_t count, room;
};

void wishes_clear(struct wishes *wishes);
void wishes_finish(struct wishes *wishes);
enum status wishes_add(struct wishes *wishes, uint64_t key, double time) FURROW_CHECKED;
/* Each key once, soonest first; of equal times the first added. Returns how many; valid until changed. */
size_t wishes_order(struct wishes *wishes, const uint64_t **keys);

#endif
