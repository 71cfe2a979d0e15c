/* The keys that were ever pinned: an open-addressed set, at most half full. */
#include "page/page_internal.h"

#include <assert.h>

static void put(uint64_t *keys, size_t room, uint64_t entry, size_t *count)
{
	size_t at = page_hash(entry) & (room - 1);
	while (keys[at] != 0 && keys[at] != entry)
		at = (at + 1) & (room - 1);
	*count += keys[at] == 0;
	keys[at] = entry;
}

enum status page_touched_reserve(struct page_touched *touched, size_t more)
{
	size_t room = touched->room != 0 ? touched->room : 256, count = 0;
	while (room < 2 * (touched->count + more))
		room *= 2;
	if (room == touched->room)
		return STATUS_OK;
	uint64_t *keys = mem_calloc(room, sizeof *keys);
	if (keys == NULL)
		return fail_memory("the set of touched pages");
	for (size_t i = 0; i < touched->room; i++)
		if (touched->keys[i] != 0)
			put(keys, room, touched->keys[i], &count);
	mem_free(touched->keys);
	*touched = (struct page_touched){keys, room, count};
	return STATUS_OK;
}

void page_touched_add(struct page_touched *touched, uint64_t key)
{
	assert(key != UINT64_MAX && touched->room > touched->count);
	put(touched->keys, touched->room, key + 1, &touched->count);
}

void page_touched_finish(struct page_touched *touched)
{
	mem_free(touched->keys);
}
