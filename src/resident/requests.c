/* Prefetch requests: gathered in any order, given out soonest first. */
#include "resident/look_ahead.h"

#include <stdlib.h>

void resident_requests_clear(struct requests *requests)
{
	requests->count = 0;
}

void resident_requests_finish(struct requests *requests)
{
	mem_free_all(requests->requests, requests->keys);
	*requests = (struct requests){.requests = NULL};
}

enum status resident_requests_add(struct requests *requests, uint64_t key, double time)
{
	if (requests->count == requests->room) {
		const size_t room = mem_room(requests->room, requests->count + 1);
		TRY(mem_resize(&requests->requests, room, sizeof *requests->requests, "the list of pages to load ahead"));
		TRY(mem_resize(&requests->keys, room, sizeof *requests->keys, "the list of pages to load ahead"));
		requests->room = room;
	}
	requests->requests[requests->count] = (struct request){key, time, requests->count};
	requests->count++;
	return STATUS_OK;
}

static int by_key_then_time(const void *a, const void *b)
{
	const struct request *x = a, *y = b;
	if (x->key != y->key)
		return x->key < y->key ? -1 : 1;
	if (x->time != y->time)
		return x->time < y->time ? -1 : 1;
	return (x->order > y->order) - (x->order < y->order);
}

static int by_time(const void *a, const void *b)
{
	const struct request *x = a, *y = b;
	if (x->time != y->time)
		return x->time < y->time ? -1 : 1;
	return (x->order > y->order) - (x->order < y->order);
}

size_t resident_requests_order(struct requests *requests, const uint64_t **keys)
{
	size_t kept = 0;
	if (requests->count > 0)
		qsort(requests->requests, requests->count, sizeof *requests->requests, by_key_then_time);
	for (size_t i = 0; i < requests->count; i++)
		if (kept == 0 || requests->requests[i].key != requests->requests[kept - 1].key)
			requests->requests[kept++] = requests->requests[i];
	requests->count = kept;
	if (kept > 0)
		qsort(requests->requests, kept, sizeof *requests->requests, by_time);
	for (size_t i = 0; i < kept; i++)
		requests->keys[i] = requests->requests[i].key;
	*keys = requests->keys;
	return kept;
}
