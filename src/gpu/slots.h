/*
 * Shared by gpu_slots.c and gpu_slots_deform.c.
 *
 * Slots: the textures that hold resident tiles. A tile has a base slot. If it is deformed, its base slot also holds a deform slot.
 *
 * A base slot:   empty -> has a base texture, from its first load to the end.
 * A deform slot: absent -> held by one base slot -> free -> held again. Its textures exist until the end.
 *
 * Invariants:
 *   1. slot.planes and slot.target belong to the deform slot that the base slot holds. If it holds none, all are NULL.
 *   2. A deform slot is held by exactly one base slot, or is in one of the free lists.
 *   3. A deform slot always has the planes that pictures show. It gets all other planes (those of the soil's state) as soon as one
 *      of them is needed. Only tiles of the working level need them.
 *   4. There are never more deform slots than base slots.
 */
#ifndef FURROW_GPU_SLOTS_H
#define FURROW_GPU_SLOTS_H

#include <assert.h>

#include "gpu/internal.h"

#define SCRATCH_COUNT 4 /* scratch textures; if more patches are in flight, an upload waits on the GPU for the pass of an older one */

struct deform_slot {
	struct deform_slot *next; /* in the list of all deform slots */
	struct deform_slot *free; /* the next one in a list of free ones */
	struct gpu_texture *planes[PLANES];
	struct gpu_target *target;
};

struct slot_entry {
	struct gpu_slot slot;
	struct gpu_target *base_target; /* NULL until a base is interpolated into this slot */
	struct deform_slot *home;       /* the deform slot that it holds; NULL: none */
};

struct gpu_slots {
	struct gpu *gpu;
	uint32_t cells, count;
	unsigned planes;
	struct gpu_pool *bases, *drawn[PLANES]; /* NULL: each texture is one of its own */
	struct slot_entry *entries;
	struct deform_slot *all, *free[2]; /* lists. free[0]: without planes of the soil's state; free[1]: with them */
	struct gpu_texture *scratch[SCRATCH_COUNT];
	uint32_t next_scratch;
	uint64_t subdivided, decimated;
};

static inline struct gpu_rect slots_whole(const struct gpu_slots *slots)
{
	return (struct gpu_rect){0, 0, slots->cells + 1, slots->cells + 1};
}

static inline struct slot_entry *slots_entry(const struct gpu_slots *slots, uint32_t slot)
{
	assert(slot < slots->count);
	struct slot_entry *entry = &slots->entries[slot];
	assert((entry->home != NULL) == (entry->slot.planes[PLANE_OFFSET] != NULL));
	assert((entry->home != NULL) == (entry->slot.target != NULL));
	return entry;
}

/* Returns true if the deform slot has planes of the soil's state. */
static inline bool gpu_deform_slot_has_state(const struct deform_slot *home)
{
	for (int plane = 0; plane < PLANES; plane++)
		if (home->planes[plane] != NULL && !(GPU_DRAWN_PLANES & PLANE_BIT(plane)))
			return true;
	return false;
}

void gpu_deform_slot_destroy(struct deform_slot *home);

#endif
