/* Tile keys to a pair of doubles: an open-addressed table that only grows. One thread. */
#ifndef FURROW_RUN_KEY_MAP_H
#define FURROW_RUN_KEY_MAP_H

#include "base/base.h"

struct key_pair {
	uint64_t key; /* UINT64_MAX: empty */
	double a, b;
};

struct key_map {
	struct key_pair *pairs;
	size_t count, room; /* room: a power of two, or 0 */
};

void key_map_finish(struct key_map *map);
/* NULL if absent. Valid until the next put. */
const struct key_pair *key_map_find(const struct key_map *map, uint64_t key);
enum status key_map_put(struct key_map *map, uint64_t key, double a, double b) FURROW_CHECKED;

#endif
