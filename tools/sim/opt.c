/*
 * OPT (Belady, 1966): what goes is what is needed again last. No policy that must take in what it
 * was asked for misses less.
 *
 * 1. A resident tile that is needed again has one entry in a heap, the number of that access; what
 *    never is, is only counted, and goes first.
 * 2. An entry is used up once its access has come. Those lie below every other in a heap whose top is
 *    the largest, so they are never on top while a tile that is needed again is resident; they are
 *    swept out when the heap is full.
 */
#include "sim/internal.h"

#include <assert.h>

#define NEVER UINT32_MAX

struct heap {
	uint32_t *entries;
	size_t count, room;
};

static void sift_down(struct heap *heap, size_t at)
{
	uint32_t entry = heap->entries[at];
	for (size_t child; (child = 2 * at + 1) < heap->count; at = child) {
		child += child + 1 < heap->count && heap->entries[child + 1] > heap->entries[child];
		if (heap->entries[child] <= entry)
			break;
		heap->entries[at] = heap->entries[child];
	}
	heap->entries[at] = entry;
}

static void sweep(struct heap *heap, uint32_t now)
{
	size_t kept = 0;
	for (size_t i = 0; i < heap->count; i++)
		if (heap->entries[i] > now)
			heap->entries[kept++] = heap->entries[i];
	heap->count = kept;
	for (size_t i = kept / 2; i-- > 0;)
		sift_down(heap, i);
}

static void push(struct heap *heap, uint32_t entry, uint32_t now)
{
	if (heap->count == heap->room)
		sweep(heap, now);
	assert(heap->count < heap->room);
	size_t at = heap->count++;
	for (; at > 0 && heap->entries[(at - 1) / 2] < entry; at = (at - 1) / 2)
		heap->entries[at] = heap->entries[(at - 1) / 2];
	heap->entries[at] = entry;
}

static uint32_t pop(struct heap *heap)
{
	uint32_t top = heap->entries[0];
	heap->entries[0] = heap->entries[--heap->count];
	sift_down(heap, 0);
	return top;
}

static enum status one_size(const struct sim_run *run, const uint32_t *next, struct heap *heap, bool *resident,
			    uint32_t slots, uint64_t *misses)
{
	const struct sim_accesses *accesses = run->accesses;
	uint32_t taken = 0, unneeded = 0;
	*misses = 0;
	heap->count = 0;
	for (uint32_t i = 0; i < accesses->tile_count; i++)
		resident[i] = false;
	for (uint32_t i = 0; i < accesses->count; i++) {
		TRY(sim_tick(run, i));
		uint32_t tile = accesses->tiles[i];
		if (!resident[tile]) {
			++*misses;
			if (taken < slots) {
				taken++;
			} else if (unneeded > 0) {
				unneeded--;
			} else {
				uint32_t last = pop(heap);
				assert(last > i); /* 2 */
				resident[accesses->tiles[last]] = false;
			}
			resident[tile] = true;
		}
		if (next[i] == NEVER)
			unneeded++;
		else
			push(heap, next[i], i);
	}
	return STATUS_OK;
}

/* next[i]: the access after i of the same tile. */
static void find_next(const struct sim_accesses *accesses, uint32_t *next, uint32_t *following)
{
	for (uint32_t i = 0; i < accesses->tile_count; i++)
		following[i] = NEVER;
	for (uint32_t i = (uint32_t)accesses->count; i-- > 0;) {
		next[i] = following[accesses->tiles[i]];
		following[accesses->tiles[i]] = i;
	}
}

enum status sim_opt(struct sim_run *run, const uint32_t *slots, size_t count, uint64_t *misses)
{
	const struct sim_accesses *accesses = run->accesses;
	size_t tiles = accesses->tile_count, room = 2 * tiles + 16;
	enum status status = STATUS_OK;
	struct heap heap = {.entries = mem_alloc(room, sizeof *heap.entries)};
	uint32_t *next = mem_alloc(accesses->count + 1, sizeof *next);
	uint32_t *following = mem_alloc(tiles + 1, sizeof *following);
	bool *resident = mem_alloc(tiles + 1, sizeof *resident);
	if (heap.entries == NULL || next == NULL || following == NULL || resident == NULL)
		TRY_OR(done, fail_memory("the simulated cache"));
	find_next(accesses, next, following);
	for (; run->pass < count; run->pass++) {
		uint32_t size = slots[run->pass];
		heap.room = size < tiles ? 2 * (size_t)size + 16 : room; /* 1: most are in use, half are used up */
		TRY_OR(done, one_size(run, next, &heap, resident, size, &misses[run->pass]));
	}
done:
	mem_free_all(heap.entries, next, following, resident);
	return status;
}
