/* Deform slots: the textures of offsets, and who holds them. */
#include <string.h>

#include "gpu/slots.h"

static const enum gpu_format formats[PLANES] = {
	[PLANE_OFFSET] = GPU_R32I,  [PLANE_DISTURBANCE] = GPU_R8UI,   [PLANE_DEPOSITED] = GPU_R32I,
	[PLANE_PLASTIC_SINKAGE] = GPU_R32I, [PLANE_SHEAR] = GPU_R32I,   [PLANE_DUG] = GPU_R32I,
	[PLANE_SETTLED] = GPU_R32I, [PLANE_LOOSE] = GPU_R32I, [PLANE_FLOOR] = GPU_R32I, [PLANE_DENSITY] = GPU_R32I,
	[PLANE_SLOPE] = GPU_R32I,   [PLANE_HEALED] = GPU_R32I, [PLANE_RISEN] = GPU_R32I, [PLANE_GROWN] = GPU_R32I,
};

enum status gpu_slots_in_arrays(struct gpu_slots *slots)
{
	const uint32_t posts = slots->cells + 1;
	if (slots->bases == NULL)
		TRY(gpu_pool_create(slots->gpu, GPU_R32I, posts, slots->count, &slots->bases));
	for (uint32_t i = 0; i < slots->count; i++)
		assert(slots->entries[i].slot.base == NULL && slots->all == NULL);
	for (int plane = 0; plane < PLANES; plane++)
		if ((slots->planes & GPU_DRAWN_PLANES & PLANE_BIT(plane)) && slots->drawn[plane] == NULL)
			TRY(gpu_pool_create(slots->gpu, formats[plane], posts, slots->count, &slots->drawn[plane]));
	return STATUS_OK;
}

static enum status plane_create(struct gpu_slots *slots, struct deform_slot *home, int plane)
{
	uint32_t posts = slots->cells + 1;
	if (slots->drawn[plane] != NULL)
		return gpu_pool_take(slots->drawn[plane], &home->planes[plane]);
	return gpu_texture_create(slots->gpu, formats[plane], posts, posts, 0, &home->planes[plane]);
}

void gpu_deform_slot_destroy(struct deform_slot *home)
{
	gpu_target_destroy(home->target);
	for (int plane = 0; plane < PLANES; plane++)
		gpu_texture_destroy(home->planes[plane]);
	mem_free(home);
}

static enum status deform_slot_create(struct gpu_slots *slots, struct deform_slot **out)
{
	struct deform_slot *home = mem_calloc(1, sizeof *home);
	TRY_MEM(home, "deform slot");
	struct gpu_attachment drawn[PLANES];
	uint32_t count = 0;
	enum status status = STATUS_OK;
	for (int plane = 0; plane < PLANES; plane++)
		if (slots->planes & GPU_DRAWN_PLANES & PLANE_BIT(plane)) {
			TRY_OR(failed, plane_create(slots, home, plane));
			drawn[count++] = (struct gpu_attachment){home->planes[plane], 0};
		}
	TRY_OR(failed, gpu_target_create(slots->gpu, drawn, count, (struct gpu_attachment){NULL, 0}, &home->target));
	home->next = slots->all;
	slots->all = home;
	*out = home;
	return STATUS_OK;
failed:
	/* Drawn planes of a deform slot have the same layer of their arrays. */
	for (int plane = 0; plane < PLANES; plane++)
		if (home->planes[plane] != NULL && slots->drawn[plane] != NULL) {
			gpu_pool_return(slots->drawn[plane], home->planes[plane]);
			home->planes[plane] = NULL;
		}
	gpu_deform_slot_destroy(home);
	return status;
}

/* Takes a deform slot from a free list, if possible from the list that `state` names. Returns NULL if both lists are empty. */
static struct deform_slot *take_free(struct gpu_slots *slots, bool state)
{
	struct deform_slot **list = slots->free[state] != NULL ? &slots->free[state] : &slots->free[!state];
	struct deform_slot *home = *list;
	if (home != NULL) {
		*list = home->free;
		home->free = NULL;
	}
	return home;
}

static enum status hold(struct gpu_slots *slots, struct slot_entry *entry, bool state)
{
	struct deform_slot *home = take_free(slots, state);
	if (home == NULL)
		TRY(deform_slot_create(slots, &home));
	entry->home = home;
	entry->slot.target = home->target;
	return STATUS_OK;
}

static void release(struct gpu_slots *slots, struct slot_entry *entry)
{
	struct deform_slot **list = &slots->free[gpu_deform_slot_has_state(entry->home)];
	entry->home->free = *list;
	*list = entry->home;
	entry->home = NULL;
	entry->slot.target = NULL;
	memset(entry->slot.planes, 0, sizeof entry->slot.planes);
}

static void clear_planes(const struct slot_entry *entry, unsigned planes, struct gpu_rect rect)
{
	for (int plane = 0; plane < PLANES; plane++)
		if ((planes & PLANE_BIT(plane)) && entry->slot.planes[plane] != NULL)
			gpu_texture_clear(entry->slot.planes[plane], 0, rect, 0);
}

/* Gives the entry the planes that pictures show, and those of the mask `planes` that the slots have. *fresh: planes that it did not
 * have before; their content is undefined. If it had no planes, a failure leaves it without any. */
static enum status need_planes(struct gpu_slots *slots, struct slot_entry *entry, unsigned planes, unsigned *fresh)
{
	enum status status = STATUS_OK;
	bool state = (planes & slots->planes & ~GPU_DRAWN_PLANES) != 0;
	planes = state ? slots->planes : GPU_DRAWN_PLANES & slots->planes;
	*fresh = 0;
	bool had = entry->home != NULL;
	if (!had)
		TRY_OR(failed, hold(slots, entry, state));
	for (int plane = 0; plane < PLANES; plane++) {
		if (!(planes & PLANE_BIT(plane)) || entry->slot.planes[plane] != NULL)
			continue;
		if (entry->home->planes[plane] == NULL)
			TRY_OR(failed, plane_create(slots, entry->home, plane));
		entry->slot.planes[plane] = entry->home->planes[plane];
		*fresh |= PLANE_BIT(plane);
	}
	return STATUS_OK;
failed:
	for (int plane = 0; plane < PLANES; plane++)
		if (*fresh & PLANE_BIT(plane))
			entry->slot.planes[plane] = NULL;
	if (!had && entry->home != NULL)
		release(slots, entry);
	return status;
}

static enum status deform_with(struct gpu_slots *slots, struct slot_entry *entry, unsigned planes)
{
	unsigned fresh;
	TRY(need_planes(slots, entry, planes, &fresh));
	clear_planes(entry, fresh, slots_whole(slots));
	return gpu_check(slots->gpu, "deform slot");
}

enum status gpu_slots_deform(struct gpu_slots *slots, uint32_t slot)
{
	return deform_with(slots, slots_entry(slots, slot), slots->planes);
}

void gpu_slots_undeform(struct gpu_slots *slots, uint32_t slot)
{
	struct slot_entry *entry = slots_entry(slots, slot);
	if (entry->home != NULL)
		release(slots, entry);
}

enum status gpu_slots_upload_deform(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				    const size_t places[PLANES])
{
	struct slot_entry *entry = slots_entry(slots, slot);
	unsigned given = 0, fresh;
	for (int plane = 0; plane < PLANES; plane++)
		given |= places[plane] != GPU_NO_PLANE ? PLANE_BIT(plane) : 0;
	if (entry->home != NULL) /* of the tile before; this tile may have fewer planes */
		release(slots, entry);
	TRY(need_planes(slots, entry, given, &fresh));
	for (int plane = 0; plane < PLANES; plane++)
		if (entry->slot.planes[plane] != NULL && places[plane] != GPU_NO_PLANE)
			gpu_texture_upload_from(entry->slot.planes[plane], 0, slots_whole(slots), staging, places[plane]);
	clear_planes(entry, ~given, slots_whole(slots));
	return gpu_check(slots->gpu, "upload of offsets");
}

enum status gpu_slots_read_deform(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				  const size_t places[PLANES])
{
	const struct slot_entry *entry = slots_entry(slots, slot);
	size_t posts = (size_t)(slots->cells + 1) * (slots->cells + 1);
	for (int plane = 0; plane < PLANES; plane++) {
		if (places[plane] == GPU_NO_PLANE)
			continue;
		if (entry->slot.planes[plane] != NULL)
			gpu_texture_read_into(entry->slot.planes[plane], 0, slots_whole(slots), staging, places[plane]);
		else
			memset((char *)gpu_staging_bytes(staging) + places[plane], 0, posts * plane_bytes(plane));
	}
	return gpu_check(slots->gpu, "read back of offsets");
}

enum status gpu_slots_put_drawn(struct gpu_slots *slots, uint32_t slot, struct gpu_rect rect, const void *const planes[PLANES])
{
	struct slot_entry *entry = slots_entry(slots, slot);
	unsigned fresh;
	TRY(need_planes(slots, entry, GPU_DRAWN_PLANES, &fresh));
	for (int plane = 0; plane < PLANES; plane++) {
		if (!(GPU_DRAWN_PLANES & PLANE_BIT(plane)) || entry->slot.planes[plane] == NULL)
			continue;
		const struct gpu_rect part = fresh & PLANE_BIT(plane) ? slots_whole(slots) : rect;
		if (planes[plane] != NULL)
			gpu_texture_upload_part(entry->slot.planes[plane], 0, part, planes[plane]);
		else
			clear_planes(entry, PLANE_BIT(plane), part);
	}
	return gpu_check(slots->gpu, "upload of offsets");
}

/* --- coarser tiles --- */

/* Returns how many of length posts remain if only every 2^steps-th is kept, beginning with the first. */
static uint32_t kept(uint32_t length, int steps)
{
	return length == 0 ? 0 : ((length - 1) >> steps) + 1;
}

enum status gpu_slots_decimate(struct gpu_slots *slots, uint32_t fine, struct gpu_rect rect, int steps,
			       uint32_t coarse, uint32_t to_x, uint32_t to_y)
{
	const struct slot_entry *from = slots_entry(slots, fine);
	struct slot_entry *to = slots_entry(slots, coarse);
	struct gpu_program *program;
	assert(steps >= 1 && fine != coarse);
	/* With so many steps that they exceed the tile's side, one post is kept. */
	int shift = steps < 16 ? steps : 16;
	struct gpu_rect into = {to_x, to_y, kept(rect.width, shift), kept(rect.height, shift)};
	if (into.width == 0 || into.height == 0)
		return STATUS_OK;
	assert(rect.x <= slots->cells && rect.width <= slots->cells + 1 - rect.x);
	assert(rect.y <= slots->cells && rect.height <= slots->cells + 1 - rect.y);
	assert((1u << shift) > slots->cells || ((rect.x | rect.y) & ((1u << shift) - 1)) == 0);
	assert(to_x <= slots->cells && into.width <= slots->cells + 1 - to_x);
	assert(to_y <= slots->cells && into.height <= slots->cells + 1 - to_y);
	if (from->home == NULL && to->home == NULL)
		return STATUS_OK; /* both tiles have no offsets, so nothing changes */
	TRY(deform_with(slots, to, GPU_DRAWN_PLANES));
	if (from->home == NULL) {
		clear_planes(to, GPU_DRAWN_PLANES, into);
		return gpu_check(slots->gpu, "decimation");
	}
	TRY(gpu_program_get(slots->gpu, gpu_slots_decimate_request(slots->planes), &program));
	struct {
		int32_t from[2], to[2], steps, unused[3];
	} params = {
		.from = {(int32_t)rect.x, (int32_t)rect.y},
		.to = {(int32_t)to_x, (int32_t)to_y},
		.steps = shift,
	};
	slots->decimated++;
	struct gpu_pass pass = {
		.stage = GPU_PYRAMID,
		.program = program,
		.target = to->slot.target,
		.viewport = into,
		.textures = {from->slot.planes[PLANE_OFFSET], from->slot.planes[PLANE_DISTURBANCE]},
		.params = &params,
		.params_bytes = sizeof params,
	};
	size_t marks = 2;
	for (int plane = PLANE_HEALED; plane <= PLANE_GROWN; plane++)
		if (slots->planes & PLANE_BIT(plane))
			pass.textures[marks++] = from->slot.planes[plane];
	gpu_pass_run(slots->gpu, &pass);
	return gpu_check(slots->gpu, "decimation");
}
