#include "base/key_map.h"

void key_map_finish(struct key_map *map)
{
	key_set_finish(&map->keys);
	mem_free(map->pairs);
	*map = (struct key_map){.room = 0};
}

void key_map_clear(struct key_map *map)
{
	key_set_clear(&map->keys);
}

const struct key_pair *key_map_find(const struct key_map *map, uint64_t key)
{
	uint32_t number;
	return key_set_find(&map->keys, key, &number) ? &map->pairs[number] : NULL;
}

enum status key_map_put(struct key_map *map, uint64_t key, double a, double b)
{
	TRY(mem_grow(&map->pairs, &map->room, map->keys.count + 1, sizeof *map->pairs, "a table of tiles"));
	uint32_t number;
	bool fresh;
	TRY(key_set_number(&map->keys, key, &number, &fresh));
	map->pairs[number] = (struct key_pair){key, a, b};
	return STATUS_OK;
}

void key_cache_finish(struct key_cache *cache)
{
	key_map_finish(&cache->young);
	key_map_finish(&cache->old);
}

enum status key_cache_put(struct key_cache *cache, uint64_t key, double a, double b)
{
	if (cache->young.keys.count >= cache->most) {
		key_map_finish(&cache->old);
		cache->old = cache->young;
		cache->young = (struct key_map){.room = 0};
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
