#include "run/wishes.h"

#include <stdlib.h>

void wishes_clear(struct wishes *wishes)
{
	wishes->count = 0;
}

void wishes_finish(struct wishes *wishes)
{
	mem_free(wishes->wishes);
	mem_free(wishes->keys);
	*wishes = (struct wishes){.wishes = NULL};
}

enum status wishes_add(struct wishes *wishes, uint64_t key, double time)
{
	if (wishes->count == wishes->room) {
		size_t room = wishes->room != 0 ? 2 * wishes->room : 64;
		struct wish *grown = mem_realloc(wishes->wishes, room, sizeof *grown);
		if (grown != NULL)
			wishes->wishes = grown;
		uint64_t *keys = mem_realloc(wishes->keys, room, sizeof *keys);
		if (keys != NULL)
			wishes->keys = keys;
		if (grown == NULL || keys == NULL)
			return fail_memory("the list of pages to load ahead");
		wishes->room = room;
	}
	wishes->wishes[wishes->count] = (struct wish){key, time, wishes->count};
	wishes->count++;
	return STATUS_OK;
}

static int by_key_then_time(const void *a, const void *b)
{
	const struct wish *x = a, *y = b;
	if (x->key != y->key)
		return x->key < y->key ? -1 : 1;
	if (x->time != y->time)
		return x->time < y->time ? -1 : 1;
	return (x->order > y->order) - (x->order < y->order);
}

static int by_time(const void *a, const void *b)
{
	const struct wish *x = a, *y = b;
	if (x->time != y->time)
		return x->time < y->time ? -1 : 1;
	return (x->order > y->order) - (x->order < y->order);
}

size_t wishes_order(struct wishes *wishes, const uint64_t **keys)
{
	size_t kept = 0;
	if (wishes->count > 0)
		qsort(wishes->wishes, wishes->count, sizeof *wishes->wishes, by_key_then_time);
	for (size_t i = 0; i < wishes->count; i++)
		if (kept == 0 || wishes->wishes[i].key != wishes->wishes[kept - 1].key)
			wishes->wishes[kept++] = wishes->wishes[i];
	wishes->count = kept;
	if (kept > 0)
		qsort(wishes->wishes, kept, sizeof *wishes->wishes, by_time);
	for (size_t i = 0; i < kept; i++)
		wishes->keys[i] = wishes->wishes[i].key;
	*keys = wishes->keys;
	return kept;
}
