/*
 * Slots: where resident tiles live.
 *
 * A base slot:   empty -> has a base texture (first load), for good.
 * A deform slot: absent -> held by one base slot -> free -> held again. Never freed before the end.
 *
 * Invariants:
 *   1. slot.offset, slot.dirt and slot.deform are all of the slot's deform slot, or all NULL.
 *   2. A deform slot is held by exactly one base slot, or is in the free list.
 *   3. dirt exists in every deform slot or in none.
 */
#include <string.h>

#include "gpu/internal.h"

#define SCRATCH_COUNT 4 /* patches in flight before an upload queues behind the pass of another */

struct deform_slot {
	struct deform_slot *next; /* of all that were made */
	struct deform_slot *free; /* of the free ones */
	struct gpu_texture *offset, *dirt;
	struct gpu_target *target;
};

struct entry {
	struct gpu_slot slot;
	struct gpu_target *base_target; /* NULL until a base is interpolated here */
	struct deform_slot *home;
};

struct gpu_slots {
	struct gpu *gpu;
	uint32_t cells, count;
	bool dirt;
	struct entry *entries;
	struct deform_slot *all, *free;
	struct gpu_texture *scratch[SCRATCH_COUNT];
	uint32_t next_scratch;
};

static struct gpu_rect whole(const struct gpu_slots *slots)
{
	return (struct gpu_rect){0, 0, slots->cells + 1, slots->cells + 1};
}

static struct entry *entry_of(const struct gpu_slots *slots, uint32_t slot)
{
	assert(slot < slots->count);
	struct entry *entry = &slots->entries[slot];
	assert((entry->home != NULL) == (entry->slot.offset != NULL));
	assert((entry->home != NULL) == (entry->slot.deform != NULL));
	assert((entry->slot.dirt != NULL) == (entry->home != NULL && slots->dirt));
	return entry;
}

enum status gpu_slots_create(struct gpu *gpu, uint32_t cells, uint32_t count, bool dirt,
			     struct gpu_slots **out)
{
	assert(cells > 0 && count > 0);
	struct gpu_slots *slots = mem_calloc(1, sizeof *slots);
	struct entry *entries = mem_calloc(count, sizeof *entries);
	if (slots == NULL || entries == NULL) {
		mem_free(slots);
		mem_free(entries);
		return fail_memory("slots");
	}
	*slots = (struct gpu_slots){.gpu = gpu, .cells = cells, .count = count, .dirt = dirt, .entries = entries};
	*out = slots;
	return STATUS_OK;
}

static void deform_slot_destroy(struct deform_slot *home)
{
	gpu_target_destroy(home->target);
	gpu_texture_destroy(home->offset);
	gpu_texture_destroy(home->dirt);
	mem_free(home);
}

void gpu_slots_destroy(struct gpu_slots *slots)
{
	if (slots == NULL)
		return;
	while (slots->all != NULL) {
		struct deform_slot *home = slots->all;
		slots->all = home->next;
		deform_slot_destroy(home);
	}
	for (uint32_t i = 0; i < slots->count; i++) {
		gpu_target_destroy(slots->entries[i].base_target);
		gpu_texture_destroy(slots->entries[i].slot.base);
	}
	for (uint32_t i = 0; i < SCRATCH_COUNT; i++)
		gpu_texture_destroy(slots->scratch[i]);
	mem_free(slots->entries);
	mem_free(slots);
}

const struct gpu_slot *gpu_slots_get(const struct gpu_slots *slots, uint32_t slot)
{
	return &entry_of(slots, slot)->slot;
}

void gpu_slots_bytes(const struct gpu_slots *slots, struct gpu_slots_bytes *bytes)
{
	*bytes = (struct gpu_slots_bytes){0};
	for (uint32_t i = 0; i < slots->count; i++)
		if (slots->entries[i].slot.base != NULL)
			bytes->base += slots->entries[i].slot.base->bytes;
	for (const struct deform_slot *home = slots->all; home != NULL; home = home->next) {
		bytes->offset += home->offset->bytes;
		bytes->dirt += home->dirt != NULL ? home->dirt->bytes : 0;
	}
}

static enum status need_base(struct gpu_slots *slots, struct entry *entry)
{
	if (entry->slot.base != NULL)
		return STATUS_OK;
	return gpu_texture_create(slots->gpu, GPU_R32I, slots->cells + 1, slots->cells + 1, 0, &entry->slot.base);
}

enum status gpu_slots_upload_base(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				  size_t posts)
{
	struct entry *entry = entry_of(slots, slot);
	enum status status = need_base(slots, entry);
	if (status != STATUS_OK)
		return status;
	gpu_texture_upload_from(entry->slot.base, 0, whole(slots), staging, posts);
	return gpu_check(slots->gpu, "upload of a tile");
}

/* The next scratch texture, with the patch in it. */
static enum status upload_patch(struct gpu_slots *slots, struct gpu_staging *staging, size_t patch,
				uint32_t stride, struct gpu_texture **out)
{
	struct gpu_texture **scratch = &slots->scratch[slots->next_scratch];
	if (*scratch == NULL) {
		uint32_t side = slots->cells / 2 + 1;
		enum status status = gpu_texture_create(slots->gpu, GPU_R32I, side, side, 0, scratch);
		if (status != STATUS_OK)
			return status;
	}
	slots->next_scratch = (slots->next_scratch + 1) % SCRATCH_COUNT;
	gpu_texture_upload_from(*scratch, 0, (struct gpu_rect){0, 0, stride, stride}, staging, patch);
	*out = *scratch;
	return STATUS_OK;
}

enum status gpu_slots_subdivide_base(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				     size_t patch, int shift, uint32_t sub_x, uint32_t sub_y)
{
	static const struct gpu_program_request request = {"full.vert", "subdivide.frag", {NULL}};
	struct entry *entry = entry_of(slots, slot);
	struct gpu_program *program;
	struct gpu_texture *scratch;
	assert(shift >= 1 && shift <= -TILE_LEVEL_MIN);
	struct {
		uint32_t sub_x, sub_y, stride;
		int32_t shift;
	} params = {sub_x, sub_y, lattice_patch_posts(slots->cells, shift), shift};
	enum status status = gpu_program_get(slots->gpu, &request, &program);
	if (status == STATUS_OK)
		status = need_base(slots, entry);
	if (status == STATUS_OK && entry->base_target == NULL)
		status = gpu_target_create(slots->gpu, &(struct gpu_attachment){entry->slot.base, 0}, 1,
					   (struct gpu_attachment){NULL, 0}, &entry->base_target);
	if (status == STATUS_OK)
		status = upload_patch(slots, staging, patch, params.stride, &scratch);
	if (status != STATUS_OK)
		return status;
	gpu_pass_run(slots->gpu, &(struct gpu_pass){
		.stage = GPU_SUBDIVIDE,
		.program = program,
		.target = entry->base_target,
		.viewport = whole(slots),
		.textures = {scratch},
		.params = &params,
		.params_bytes = sizeof params,
	});
	return gpu_check(slots->gpu, "subdivision of a tile");
}

static enum status deform_slot_create(struct gpu_slots *slots, struct deform_slot **out)
{
	uint32_t posts = slots->cells + 1;
	struct deform_slot *home = mem_calloc(1, sizeof *home);
	if (home == NULL)
		return fail_memory("deform slot");
	enum status status = gpu_texture_create(slots->gpu, GPU_R32I, posts, posts, 0, &home->offset);
	if (status == STATUS_OK && slots->dirt)
		status = gpu_texture_create(slots->gpu, GPU_R8UI, posts, posts, 0, &home->dirt);
	if (status == STATUS_OK) {
		struct gpu_attachment planes[2] = {{home->offset, 0}, {home->dirt, 0}};
		status = gpu_target_create(slots->gpu, planes, slots->dirt ? 2 : 1, (struct gpu_attachment){NULL, 0},
					   &home->target);
	}
	if (status != STATUS_OK) {
		deform_slot_destroy(home);
		return status;
	}
	home->next = slots->all;
	slots->all = home;
	*out = home;
	return STATUS_OK;
}

/* Gives the entry a deform slot, whatever is in it, if it has none. */
static enum status need_deform(struct gpu_slots *slots, struct entry *entry)
{
	struct deform_slot *home = slots->free;
	if (entry->home != NULL)
		return STATUS_OK;
	if (home != NULL) {
		slots->free = home->free;
		home->free = NULL;
	} else {
		enum status status = deform_slot_create(slots, &home);
		if (status != STATUS_OK)
			return status;
	}
	entry->home = home;
	entry->slot.offset = home->offset;
	entry->slot.dirt = home->dirt;
	entry->slot.deform = home->target;
	return STATUS_OK;
}

static void clear_deform(const struct entry *entry, struct gpu_rect rect)
{
	gpu_texture_clear(entry->slot.offset, 0, rect, 0);
	if (entry->slot.dirt != NULL)
		gpu_texture_clear(entry->slot.dirt, 0, rect, 0);
}

enum status gpu_slots_deform(struct gpu_slots *slots, uint32_t slot)
{
	struct entry *entry = entry_of(slots, slot);
	if (entry->home != NULL)
		return gpu_check(slots->gpu, "deform slot");
	enum status status = need_deform(slots, entry);
	if (status != STATUS_OK)
		return status;
	clear_deform(entry, whole(slots));
	return gpu_check(slots->gpu, "deform slot");
}

void gpu_slots_undeform(struct gpu_slots *slots, uint32_t slot)
{
	struct entry *entry = entry_of(slots, slot);
	if (entry->home == NULL)
		return;
	entry->home->free = slots->free;
	slots->free = entry->home;
	entry->home = NULL;
	entry->slot.offset = NULL;
	entry->slot.dirt = NULL;
	entry->slot.deform = NULL;
}

enum status gpu_slots_upload_deform(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				    size_t offset, size_t dirt)
{
	struct entry *entry = entry_of(slots, slot);
	enum status status = need_deform(slots, entry);
	if (status != STATUS_OK)
		return status;
	gpu_texture_upload_from(entry->slot.offset, 0, whole(slots), staging, offset);
	if (entry->slot.dirt != NULL && dirt != GPU_NO_PLANE)
		gpu_texture_upload_from(entry->slot.dirt, 0, whole(slots), staging, dirt);
	else if (entry->slot.dirt != NULL)
		gpu_texture_clear(entry->slot.dirt, 0, whole(slots), 0);
	return gpu_check(slots->gpu, "upload of offsets");
}

static void read_plane(const struct gpu_slots *slots, struct gpu_texture *plane, size_t texel,
		       struct gpu_staging *staging, size_t offset)
{
	size_t posts = (size_t)(slots->cells + 1) * (slots->cells + 1);
	if (plane != NULL)
		gpu_texture_read_into(plane, 0, whole(slots), staging, offset);
	else
		memset((char *)gpu_staging_bytes(staging) + offset, 0, posts * texel);
}

enum status gpu_slots_read_deform(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				  size_t offset, size_t dirt)
{
	const struct entry *entry = entry_of(slots, slot);
	read_plane(slots, entry->slot.offset, sizeof(int32_t), staging, offset);
	if (dirt != GPU_NO_PLANE)
		read_plane(slots, entry->slot.dirt, sizeof(uint8_t), staging, dirt);
	return gpu_check(slots->gpu, "read back of offsets");
}

/* Of `length` posts, how many are kept, beginning with the first. */
static uint32_t kept(uint32_t length, int steps)
{
	return length == 0 ? 0 : ((length - 1) >> steps) + 1;
}

enum status gpu_slots_decimate(struct gpu_slots *slots, uint32_t fine, struct gpu_rect rect, int steps,
			       uint32_t coarse, uint32_t to_x, uint32_t to_y)
{
	static const struct gpu_program_request plain = {"full.vert", "decimate.frag", {NULL}},
						with_dirt = {"full.vert", "decimate.frag", {"DIRT"}};
	const struct entry *from = entry_of(slots, fine);
	struct entry *to = entry_of(slots, coarse);
	struct gpu_program *program;
	assert(steps >= 1 && fine != coarse);
	/* Beyond a tile's side a single post is kept, whatever the steps. */
	int shift = steps < 16 ? steps : 16;
	struct gpu_rect into = {to_x, to_y, kept(rect.width, shift), kept(rect.height, shift)};
	if (into.width == 0 || into.height == 0)
		return STATUS_OK;
	assert(rect.x <= slots->cells && rect.width <= slots->cells + 1 - rect.x);
	assert(rect.y <= slots->cells && rect.height <= slots->cells + 1 - rect.y);
	assert((1u << shift) > slots->cells || ((rect.x | rect.y) & ((1u << shift) - 1)) == 0);
	assert(to_x <= slots->cells && into.width <= slots->cells + 1 - to_x);
	assert(to_y <= slots->cells && into.height <= slots->cells + 1 - to_y);
	if (from->slot.offset == NULL && to->slot.offset == NULL)
		return STATUS_OK; /* zero to zero */
	enum status status = gpu_slots_deform(slots, coarse);
	if (status != STATUS_OK)
		return status;
	if (from->slot.offset == NULL) {
		clear_deform(to, into);
		return gpu_check(slots->gpu, "decimation");
	}
	status = gpu_program_get(slots->gpu, slots->dirt ? &with_dirt : &plain, &program);
	if (status != STATUS_OK)
		return status;
	struct {
		int32_t from[2], to[2], steps, unused[3];
	} params = {
		.from = {(int32_t)rect.x, (int32_t)rect.y},
		.to = {(int32_t)to_x, (int32_t)to_y},
		.steps = shift,
	};
	gpu_pass_run(slots->gpu, &(struct gpu_pass){
		.stage = GPU_PYRAMID,
		.program = program,
		.target = to->slot.deform,
		.viewport = into,
		.textures = {from->slot.offset, from->slot.dirt},
		.params = &params,
		.params_bytes = sizeof params,
	});
	return gpu_check(slots->gpu, "decimation");
}
