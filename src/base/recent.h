/*
 * Remembers which tile is in which of a few places. When a new place is needed, the least recently used one is reused. Caches
 * of decoded tiles use it. The cache keeps the data of a place in arrays, indexed by the place's number. Not locked.
 *
 * Invariant: no two used places have the same key.
 */
#ifndef FURROW_BASE_RECENT_H
#define FURROW_BASE_RECENT_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"

#define RECENT_NONE UINT32_MAX

struct recent_place {
	uint64_t key;
	uint64_t used; /* value of `clock` at the last use; 0: empty */
};
struct recent {
	struct recent_place *places;
	uint32_t count;
	uint64_t clock;
};

enum status recent_create(struct recent *recent, uint32_t count) FURROW_CHECKED; /* at least 1 place, all empty */
void recent_finish(struct recent *recent);
/* Returns the place of the key, or RECENT_NONE. */
uint32_t recent_find(const struct recent *recent, uint64_t key);
/* Returns an empty place, or else the least recently used one, but never `spared`. RECENT_NONE: there is no other. */
uint32_t recent_oldest(const struct recent *recent, uint32_t spared);
/* Puts the key into the place, and marks it as just used. */
void recent_use(struct recent *recent, uint32_t place, uint64_t key);
void recent_empty(struct recent *recent, uint32_t place);

#endif
