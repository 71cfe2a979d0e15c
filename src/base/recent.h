/*
 * Remembers which tile is in which of a few or many places. When a new place is needed, the least recently used one is reused.
 * Caches of decoded tiles use it. The cache keeps the data of a place in arrays, indexed by the place's number. Not locked.
 * Every function takes the same time however many places there are.
 *
 * Invariants:
 * - No two used places have the same key.
 * - Every place is in the list of places once: the empty ones first, then the used ones, the least recently used one first.
 */
#ifndef FURROW_BASE_RECENT_H
#define FURROW_BASE_RECENT_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"

#define RECENT_NONE UINT32_MAX

struct recent_place {
	uint64_t key;
	bool used;            /* false: empty */
	uint32_t before, after; /* in the list of places; RECENT_NONE: there is none */
	uint32_t same_bucket; /* the next place with the same hash; RECENT_NONE: there is none */
};
struct recent {
	struct recent_place *places;
	uint32_t count;
	uint32_t first, last; /* of the list of places */
	uint32_t *buckets;    /* first place of each hash; RECENT_NONE: there is none */
	uint32_t mask;        /* number of buckets - 1 */
};

enum status recent_create(struct recent *recent, uint32_t count) FURROW_CHECKED; /* at least 1 place, all empty */
void recent_finish(struct recent *recent);
/* Adds empty places, so that there are `count`. Does nothing if there are as many. On failure nothing changes. */
enum status recent_grow(struct recent *recent, uint32_t count) FURROW_CHECKED;
/* Returns the place of the key, or RECENT_NONE. */
uint32_t recent_find(const struct recent *recent, uint64_t key);
/* Returns an empty place, or else the least recently used one, but never `spared`. RECENT_NONE: there is no other. */
uint32_t recent_oldest(const struct recent *recent, uint32_t spared);
/* Puts the key into the place, and marks it as just used. */
void recent_use(struct recent *recent, uint32_t place, uint64_t key);
void recent_empty(struct recent *recent, uint32_t place);

#endif
