/*
 * A map from tile keys to a pair of doubles. It only grows. A cache of bounded memory is made of two of them. One thread.
 */
#ifndef FURROW_BASE_KEY_MAP_H
#define FURROW_BASE_KEY_MAP_H

#include "base/base.h"
#include "base/key_set.h"

struct key_pair {
	uint64_t key;
	double a, b;
};

struct key_map {
	struct key_set keys;
	struct key_pair *pairs; /* by the keys' numbers */
	size_t room;            /* of the pairs */
};

void key_map_finish(struct key_map *map);
/* Returns NULL if the key is absent. Valid until the next put. */
const struct key_pair *key_map_find(const struct key_map *map, uint64_t key);
enum status key_map_put(struct key_map *map, uint64_t key, double a, double b) FURROW_CHECKED;

/* A cache of two generations. A key that is asked for moves to the younger. When that is full it becomes the older one, and the
 * older one is dropped. Every key asked for within the last `most` keys is kept. */
struct key_cache {
	struct key_map young, old;
	size_t most; /* keys in each, at least 1 */
};

void key_cache_finish(struct key_cache *cache);
enum status key_cache_find(struct key_cache *cache, uint64_t key, struct key_pair *pair, bool *found)
	FURROW_CHECKED;
enum status key_cache_put(struct key_cache *cache, uint64_t key, double a, double b) FURROW_CHECKED;

#endif
