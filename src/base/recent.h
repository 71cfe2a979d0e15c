/*
 * Which tile is in which of a few places, the one used longest ago going to the next: what caches of decoded tiles share. The
 * owner keeps what is in a place by its number. Not locked.
 *
 * Invariant: no two places that are used have the same key.
 */
#ifndef FURROW_BASE_RECENT_H
#define FURROW_BASE_RECENT_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"

#define RECENT_NONE UINT32_MAX

struct recent_place {
	uint64_t key;
	uint64_t used; /* by the clock; 0: empty */
};
struct recent {
	struct recent_place *places;
	uint32_t count;
	uint64_t clock;
};

enum status recent_create(struct recent *recent, uint32_t count) FURROW_CHECKED; /* at least 1 place, all empty */
void recent_finish(struct recent *recent);
/* RECENT_NONE: it is in none. */
uint32_t recent_find(const struct recent *recent, uint64_t key);
/* An empty place, or the one used longest ago, but for `spared`; RECENT_NONE if there is no other. */
uint32_t recent_oldest(const struct recent *recent, uint32_t spared);
/* The key is in the place, and was just used. */
void recent_use(struct recent *recent, uint32_t place, uint64_t key);
void recent_empty(struct recent *recent, uint32_t place);

#endif
