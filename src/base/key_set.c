#include "base/key_set.h"

#include <assert.h>
#include <string.h>

#define EMPTY UINT64_MAX

static size_t place(const struct key_set *set, uint64_t key)
{
	size_t at = key_hash(key) & (set->room - 1);
	while (set->keys[at] != EMPTY && set->keys[at] != key)
		at = (at + 1) & (set->room - 1);
	return at;
}

void key_set_finish(struct key_set *set)
{
	mem_free_all(set->keys, set->numbers);
	*set = (struct key_set){.count = 0};
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

bool key_set_find(const struct key_set *set, uint64_t key, uint32_t *number)
{
	if (set->room == 0)
		return false;
	const size_t at = place(set, key);
	*number = set->numbers[at];
	return set->keys[at] == key;
}

static enum status widen(struct key_set *set, size_t room)
{
	struct key_set wider = {.room = room, .count = set->count};
	wider.keys = mem_alloc(room, sizeof *wider.keys);
	wider.numbers = mem_alloc(room, sizeof *wider.numbers);
	if (wider.keys == NULL || wider.numbers == NULL) {
		key_set_finish(&wider);
		return fail_memory("a table of tiles");
	}
	memset(wider.keys, 0xff, room * sizeof *wider.keys);
	for (size_t i = 0; i < set->room; i++)
		if (set->keys[i] != EMPTY) {
			size_t at = place(&wider, set->keys[i]);
			wider.keys[at] = set->keys[i];
			wider.numbers[at] = set->numbers[i];
		}
	key_set_finish(set);
	*set = wider;
	return STATUS_OK;
}

enum status key_set_reserve(struct key_set *set, size_t more)
{
	size_t room = set->room != 0 ? set->room : 256;
	while (4 * (set->count + more) > 3 * room)
		room *= 2;
	return room == set->room ? STATUS_OK : widen(set, room);
}

static uint32_t put(struct key_set *set, uint64_t key, bool *fresh)
{
	assert(key != EMPTY && set->room > set->count);
	const size_t at = place(set, key);
	*fresh = set->keys[at] == EMPTY;
	if (*fresh) {
		set->keys[at] = key;
		set->numbers[at] = (uint32_t)set->count++;
	}
	return set->numbers[at];
}

enum status key_set_number(struct key_set *set, uint64_t key, uint32_t *number, bool *fresh)
{
	TRY(key_set_reserve(set, 1));
	*number = put(set, key, fresh);
	return STATUS_OK;
}

void key_set_put(struct key_set *set, uint64_t key)
{
	bool fresh;
	put(set, key, &fresh);
}

enum status key_set_add(struct key_set *set, uint64_t key)
{
	uint32_t number;
	bool fresh;
	return key_set_number(set, key, &number, &fresh);
}
