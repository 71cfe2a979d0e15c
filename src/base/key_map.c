#include "base/key_map.h"

#define EMPTY UINT64_MAX

static size_t place(const struct key_map *map, uint64_t key)
{
	size_t at = (size_t)((key * 0x9e3779b97f4a7c15ull) >> 20) & (map->room - 1);
	while (map->pairs[at].key != EMPTY && map->pairs[at].key != key)
		at = (at + 1) & (map->room - 1);
	return at;
}

void key_map_finish(struct key_map *map)
{
	mem_free(map->pairs);
	*map = (struct key_map){NULL, 0, 0};
}

const struct key_pair *key_map_find(const struct key_map *map, uint64_t key)
{
	if (map->room == 0)
		return NULL;
	const struct key_pair *pair = &map->pairs[place(map, key)];
	return pair->key == key ? pair : NULL;
}

static enum status grow(struct key_map *map)
{
	struct key_map larger = {.room = map->room != 0 ? 2 * map->room : 256, .count = map->count};
	larger.pairs = mem_alloc(larger.room, sizeof *larger.pairs);
	if (larger.pairs == NULL)
		return fail_memory("a table of tiles");
	for (size_t i = 0; i < larger.room; i++)
		larger.pairs[i].key = EMPTY;
	for (size_t i = 0; i < map->room; i++)
		if (map->pairs[i].key != EMPTY)
			larger.pairs[place(&larger, map->pairs[i].key)] = map->pairs[i];
	mem_free(map->pairs);
	*map = larger;
	return STATUS_OK;
}

enum status key_map_put(struct key_map *map, uint64_t key, double a, double b)
{
	if (2 * (map->count + 1) > map->room) {
		enum status status = grow(map);
		if (status != STATUS_OK)
			return status;
	}
	struct key_pair *pair = &map->pairs[place(map, key)];
	map->count += pair->key == EMPTY;
	*pair = (struct key_pair){key, a, b};
	return STATUS_OK;
}

void key_cache_finish(struct key_cache *cache)
{
	key_map_finish(&cache->young);
	key_map_finish(&cache->old);
}

enum status key_cache_put(struct key_cache *cache, uint64_t key, double a, double b)
{
	if (cache->young.count >= cache->most) {
		key_map_finish(&cache->old);
		cache->old = cache->young;
		cache->young = (struct key_map){NULL, 0, 0};
	}
	return key_map_put(&cache->young, key, a, b);
}

enum status key_cache_find(struct key_cache *cache, uint64_t key, struct key_pair *pair, bool *found)
{
	const struct key_pair *known = key_map_find(&cache->young, key);
	bool aged = known == NULL;
	if (aged)
		known = key_map_find(&cache->old, key);
	*found = known != NULL;
	if (!*found)
		return STATUS_OK;
	*pair = *known;
	return aged ? key_cache_put(cache, key, pair->a, pair->b) : STATUS_OK;
}
