/* Numbers for keys, in the order in which they come: the dictionary of a trace. */
#include "page/page_internal.h"
#include "page/page_trace_format.h"

/* Where `entry` is, or would be. */
static size_t place_of(const uint64_t *keys, size_t room, uint64_t entry)
{
	size_t at = page_hash(entry) & (room - 1);
	while (keys[at] != 0 && keys[at] != entry)
		at = (at + 1) & (room - 1);
	return at;
}

static enum status grow(struct page_trace_index *index)
{
	size_t room = index->room != 0 ? 2 * index->room : 256;
	struct page_trace_index wider = {
		.keys = mem_calloc(room, sizeof *wider.keys),
		.numbers = mem_alloc(room, sizeof *wider.numbers),
		.room = room,
		.count = index->count,
	};
	if (wider.keys == NULL || wider.numbers == NULL) {
		page_trace_index_finish(&wider);
		return fail_memory("the trace's tiles");
	}
	for (size_t i = 0; i < index->room; i++)
		if (index->keys[i] != 0) {
			size_t at = place_of(wider.keys, room, index->keys[i]);
			wider.keys[at] = index->keys[i];
			wider.numbers[at] = index->numbers[i];
		}
	page_trace_index_finish(index);
	*index = wider;
	return STATUS_OK;
}

enum status page_trace_index_put(struct page_trace_index *index, uint64_t key, uint32_t *number,
				 bool *fresh)
{
	if (index->room < 2 * ((size_t)index->count + 1)) {
		enum status status = grow(index);
		if (status != STATUS_OK)
			return status;
	}
	size_t at = place_of(index->keys, index->room, key + 1);
	*fresh = index->keys[at] == 0;
	if (*fresh) {
		index->keys[at] = key + 1;
		index->numbers[at] = index->count++;
	}
	*number = index->numbers[at];
	return STATUS_OK;
}

void page_trace_index_finish(struct page_trace_index *index)
{
	mem_free(index->keys);
	mem_free(index->numbers);
}
