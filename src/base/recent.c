#include "base/recent.h"

#include "base/key_set.h"
#include "base/memory.h"

/* --- the list --- */

static void unlink_place(struct recent *recent, uint32_t place)
{
	const struct recent_place *at = &recent->places[place];
	*(at->before != RECENT_NONE ? &recent->places[at->before].after : &recent->first) = at->after;
	*(at->after != RECENT_NONE ? &recent->places[at->after].before : &recent->last) = at->before;
}

static void append(struct recent *recent, uint32_t place)
{
	struct recent_place *at = &recent->places[place];
	at->before = recent->last;
	at->after = RECENT_NONE;
	*(at->before != RECENT_NONE ? &recent->places[at->before].after : &recent->first) = place;
	recent->last = place;
}

static void prepend(struct recent *recent, uint32_t place)
{
	struct recent_place *at = &recent->places[place];
	at->before = RECENT_NONE;
	at->after = recent->first;
	*(at->after != RECENT_NONE ? &recent->places[at->after].before : &recent->last) = place;
	recent->first = place;
}

/* --- the buckets --- */

static uint32_t *bucket_of(const struct recent *recent, uint64_t key)
{
	return &recent->buckets[key_hash(key) & recent->mask];
}

static void enter(struct recent *recent, uint32_t place)
{
	uint32_t *bucket = bucket_of(recent, recent->places[place].key);
	recent->places[place].same_bucket = *bucket;
	*bucket = place;
}

static void leave(struct recent *recent, uint32_t place)
{
	uint32_t *at = bucket_of(recent, recent->places[place].key);
	while (*at != place)
		at = &recent->places[*at].same_bucket;
	*at = recent->places[place].same_bucket;
}

/* --- places --- */

enum status recent_create(struct recent *recent, uint32_t count)
{
	*recent = (struct recent){.first = RECENT_NONE, .last = RECENT_NONE};
	return recent_grow(recent, count);
}

void recent_finish(struct recent *recent)
{
	mem_free_all(recent->places, recent->buckets);
}

enum status recent_grow(struct recent *recent, uint32_t count)
{
	if (count <= recent->count)
		return STATUS_OK;
	size_t room = 16;
	while (room < count)
		room *= 2;
	uint32_t *buckets = mem_alloc(room, sizeof *buckets);
	struct recent_place *places = buckets != NULL ? mem_realloc(recent->places, count, sizeof *places) : NULL;
	if (places == NULL) {
		mem_free(buckets);
		return fail_memory("a cache of tiles");
	}
	mem_free(recent->buckets);
	recent->places = places;
	recent->buckets = buckets;
	recent->mask = (uint32_t)(room - 1);
	for (size_t i = 0; i < room; i++)
		buckets[i] = RECENT_NONE;
	for (uint32_t i = 0; i < recent->count; i++)
		if (places[i].used)
			enter(recent, i);
	for (; recent->count < count; recent->count++) {
		places[recent->count] = (struct recent_place){.used = false};
		prepend(recent, recent->count);
	}
	return STATUS_OK;
}

uint32_t recent_find(const struct recent *recent, uint64_t key)
{
	uint32_t place = *bucket_of(recent, key);
	while (place != RECENT_NONE && recent->places[place].key != key)
		place = recent->places[place].same_bucket;
	return place;
}

uint32_t recent_oldest(const struct recent *recent, uint32_t spared)
{
	return recent->first != spared ? recent->first : recent->places[recent->first].after;
}

void recent_use(struct recent *recent, uint32_t place, uint64_t key)
{
	struct recent_place *at = &recent->places[place];
	if (!at->used || at->key != key) {
		if (at->used)
			leave(recent, place);
		at->key = key;
		at->used = true;
		enter(recent, place);
	}
	unlink_place(recent, place);
	append(recent, place);
}

void recent_empty(struct recent *recent, uint32_t place)
{
	if (!recent->places[place].used)
		return;
	leave(recent, place);
	recent->places[place].used = false;
	unlink_place(recent, place);
	prepend(recent, place);
}
