#include "base/key_set.h"

#include <string.h>

#define EMPTY UINT64_MAX

static size_t place(const struct key_set *set, uint64_t key)
{
	size_t at = (size_t)((key * 0x9e3779b97f4a7c15ull) >> 20) & (set->room - 1);
	while (set->keys[at] != EMPTY && set->keys[at] != key)
		at = (at + 1) & (set->room - 1);
	return at;
}

void key_set_finish(struct key_set *set)
{
	mem_free(set->keys);
	*set = (struct key_set){NULL, 0, 0};
}

void key_set_clear(struct key_set *set)
{
	if (set->count > 0)
		memset(set->keys, 0xff, set->room * sizeof *set->keys);
	set->count = 0;
}

bool key_set_has(const struct key_set *set, uint64_t key)
{
	return set->room > 0 && set->keys[place(set, key)] == key;
}

static enum status grow(struct key_set *set)
{
	struct key_set larger = {.room = set->room != 0 ? 2 * set->room : 256, .count = set->count};
	larger.keys = mem_alloc(larger.room, sizeof *larger.keys);
	if (larger.keys == NULL)
		return fail_memory("a set of tiles");
	memset(larger.keys, 0xff, larger.room * sizeof *larger.keys);
	for (size_t i = 0; i < set->room; i++)
		if (set->keys[i] != EMPTY)
			larger.keys[place(&larger, set->keys[i])] = set->keys[i];
	mem_free(set->keys);
	*set = larger;
	return STATUS_OK;
}

enum status key_set_add(struct key_set *set, uint64_t key)
{
	if (4 * (set->count + 1) > 3 * set->room) {
		enum status status = grow(set);
		if (status != STATUS_OK)
			return status;
	}
	uint64_t *at = &set->keys[place(set, key)];
	set->count += *at == EMPTY;
	*at = key;
	return STATUS_OK;
}
