/* A map from tile keys to pairs of doubles. It grows until it is cleared. A cache with limited memory consists of two such maps. One thread. */
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
	struct key_pair *pairs; /* indexed by the number of a key */
	size_t room;            /* number of pairs allocated */
};

void key_map_finish(struct key_map *map);
void key_map_clear(struct key_map *map); /* removes all keys and keeps the memory */
/* Returns the pair of a key, or NULL. It is valid until the next put. */
const struct key_pair *key_map_find(const struct key_map *map, uint64_t key);
enum status key_map_put(struct key_map *map, uint64_t key, double a, double b) FURROW_CHECKED;

/* A cache of two maps, a younger and an older one. A key that is asked for moves to the younger. When the younger is full, the
 * older is dropped, and the younger becomes the older. So every key is kept that was among the last `most` keys asked for. */
struct key_cache {
	struct key_map young, old;
	size_t most; /* most keys in each of the two maps, at least 1 */
};

void key_cache_finish(struct key_cache *cache);
enum status key_cache_find(struct key_cache *cache, uint64_t key, struct key_pair *pair, bool *found)
	FURROW_CHECKED;
enum status key_cache_put(struct key_cache *cache, uint64_t key, double a, double b) FURROW_CHECKED;

#endif
