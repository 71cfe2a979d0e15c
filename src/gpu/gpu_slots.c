/*
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
#include <string.h>

#include "gpu/internal.h"

#define SCRATCH_COUNT 4 /* scratch textures; if more patches are in flight, an upload waits on the GPU for the pass of an older one */

struct deform_slot {
	struct deform_slot *next; /* in the list of all deform slots */
	struct deform_slot *free; /* the next one in a list of free ones */
	struct gpu_texture *planes[PLANES];
	struct gpu_target *target;
};

struct entry {
	struct gpu_slot slot;
	struct gpu_target *base_target; /* NULL until a base is interpolated into this slot */
	struct deform_slot *home;       /* the deform slot that it holds; NULL: none */
};

struct gpu_slots {
	struct gpu *gpu;
	uint32_t cells, count;
	unsigned planes;
	struct gpu_pool *bases, *drawn[PLANES]; /* NULL: each texture is one of its own */
	struct entry *entries;
	struct deform_slot *all, *free[2]; /* lists. free[0]: without planes of the soil's state; free[1]: with them */
	struct gpu_texture *scratch[SCRATCH_COUNT];
	uint32_t next_scratch;
	uint64_t subdivided, decimated;
};

static struct gpu_rect whole(const struct gpu_slots *slots)
{
	return (struct gpu_rect){0, 0, slots->cells + 1, slots->cells + 1};
}

static struct entry *entry_of(const struct gpu_slots *slots, uint32_t slot)
{
	assert(slot < slots->count);
	struct entry *entry = &slots->entries[slot];
	assert((entry->home != NULL) == (entry->slot.planes[PLANE_OFFSET] != NULL));
	assert((entry->home != NULL) == (entry->slot.target != NULL));
	return entry;
}

enum status gpu_slots_create(struct gpu *gpu, uint32_t cells, uint32_t count, unsigned planes,
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
	*slots = (struct gpu_slots){
		.gpu = gpu,
		.cells = cells,
		.count = count,
		.planes = planes | PLANE_BIT(PLANE_OFFSET),
		.entries = entries,
	};
	*out = slots;
	return STATUS_OK;
}

struct gpu *gpu_slots_gpu(const struct gpu_slots *slots)
{
	return slots->gpu;
}

unsigned gpu_slots_planes(const struct gpu_slots *slots)
{
	return slots->planes;
}

static void deform_slot_destroy(struct deform_slot *home)
{
	gpu_target_destroy(home->target);
	for (int plane = 0; plane < PLANES; plane++)
		gpu_texture_destroy(home->planes[plane]);
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
		gpu_texture_destroy(slots->entries[i].slot.classes);
		gpu_texture_destroy(slots->entries[i].slot.numbers);
	}
	for (uint32_t i = 0; i < SCRATCH_COUNT; i++)
		gpu_texture_destroy(slots->scratch[i]);
	gpu_pool_destroy(slots->bases);
	for (int plane = 0; plane < PLANES; plane++)
		gpu_pool_destroy(slots->drawn[plane]);
	mem_free(slots->entries);
	mem_free(slots);
}

const struct gpu_slot *gpu_slots_get(const struct gpu_slots *slots, uint32_t slot)
{
	return &entry_of(slots, slot)->slot;
}

static uint64_t bytes_of(const struct gpu_texture *texture)
{
	return texture != NULL ? texture->bytes : 0;
}

void gpu_slots_bytes(const struct gpu_slots *slots, struct gpu_slots_bytes *bytes)
{
	*bytes = (struct gpu_slots_bytes){0};
	for (uint32_t i = 0; i < slots->count; i++) {
		bytes->base += bytes_of(slots->entries[i].slot.base);
		bytes->classes += bytes_of(slots->entries[i].slot.classes);
		bytes->numbers += bytes_of(slots->entries[i].slot.numbers);
	}
	for (const struct deform_slot *home = slots->all; home != NULL; home = home->next)
		for (int plane = 0; plane < PLANES; plane++)
			bytes->planes[plane] += bytes_of(home->planes[plane]);
	uint64_t arrays, layers, more;
	gpu_pool_figures(slots->bases, &arrays, &layers, &more);
	bytes->base += more;
	for (int plane = 0; plane < PLANES; plane++) {
		gpu_pool_figures(slots->drawn[plane], &arrays, &layers, &more);
		bytes->planes[plane] += more;
	}
}

static bool has_state(const struct deform_slot *home)
{
	for (int plane = 0; plane < PLANES; plane++)
		if (home->planes[plane] != NULL && !(GPU_DRAWN_PLANES & PLANE_BIT(plane)))
			return true;
	return false;
}

void gpu_slots_figures(const struct gpu_slots *slots, struct gpu_slots_figures *figures)
{
	*figures = (struct gpu_slots_figures){.subdivided = slots->subdivided, .decimated = slots->decimated};
	for (uint32_t i = 0; i < slots->count; i++) {
		figures->base_slots += slots->entries[i].slot.base != NULL;
		figures->class_slots += slots->entries[i].slot.classes != NULL;
		figures->number_slots += slots->entries[i].slot.numbers != NULL;
	}
	for (const struct deform_slot *home = slots->all; home != NULL; home = home->next) {
		figures->deform_slots++;
		figures->state_slots += has_state(home);
	}
	for (int i = 0; i < SCRATCH_COUNT; i++)
		figures->patches += slots->scratch[i] != NULL;
	uint64_t bytes;
	gpu_pool_figures(slots->bases, &figures->base_arrays, &figures->base_layers, &bytes);
	gpu_pool_figures(slots->drawn[PLANE_OFFSET], &figures->deform_arrays, &figures->deform_layers, &bytes);
}

static enum status need_base(struct gpu_slots *slots, struct entry *entry)
{
	if (entry->slot.base != NULL)
		return STATUS_OK;
	if (slots->bases != NULL)
		return gpu_pool_take(slots->bases, &entry->slot.base);
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

/* Uploads the patch into the next scratch texture. */
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

/* Runs the pass that fills a base from a patch of stride x stride posts. */
static enum status subdivide(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
			     size_t patch, uint32_t stride, bool relief, const void *params,
			     size_t params_bytes)
{
	struct entry *entry = entry_of(slots, slot);
	struct gpu_program *program;
	struct gpu_texture *scratch;
	enum status status =
		gpu_program_get(slots->gpu, gpu_slots_subdivide_request(relief), &program);
	if (status == STATUS_OK)
		status = need_base(slots, entry);
	if (status == STATUS_OK && entry->base_target == NULL)
		status = gpu_target_create(slots->gpu, &(struct gpu_attachment){entry->slot.base, 0}, 1,
					   (struct gpu_attachment){NULL, 0}, &entry->base_target);
	if (status == STATUS_OK)
		status = upload_patch(slots, staging, patch, stride, &scratch);
	if (status != STATUS_OK)
		return status;
	slots->subdivided++;
	gpu_pass_run(slots->gpu, &(struct gpu_pass){
		.stage = GPU_SUBDIVIDE,
		.program = program,
		.target = entry->base_target,
		.viewport = whole(slots),
		.textures = {scratch},
		.params = params,
		.params_bytes = params_bytes,
	});
	return gpu_check(slots->gpu, "subdivision of a tile");
}

struct subdivide_params {
	uint32_t sub_x, sub_y, stride;
	int32_t shift;
};

enum status gpu_slots_subdivide_base(struct gpu_slots *slots, uint32_t slot,
				     struct gpu_staging *staging, size_t patch, int shift,
				     uint32_t sub_x, uint32_t sub_y)
{
	assert(shift >= 1 && shift <= -TILE_LEVEL_MIN);
	const struct subdivide_params params = {sub_x, sub_y,
						lattice_patch_posts(slots->cells, shift), shift};
	return subdivide(slots, slot, staging, patch, params.stride, false, &params, sizeof params);
}

enum status gpu_slots_subdivide_relief(struct gpu_slots *slots, uint32_t slot,
				       struct gpu_staging *staging, size_t patch, uint32_t sub_x,
				       uint32_t sub_y, struct tile tile,
				       const struct relief *relief)
{
	assert(tile.level < 0 && relief->classes == 1);
	struct {
		struct subdivide_params base;
		int32_t count, down, unused[2];
		struct relief_part parts[RELIEF_BANDS];
	} params = {.base = {sub_x, sub_y, lattice_patch_posts(slots->cells, -tile.level),
			     -tile.level}};
	int down;
	params.count = relief_parts(relief, tile.level, 0, (int64_t)tile.x * slots->cells,
				    (int64_t)tile.y * slots->cells, params.parts, &down);
	params.down = down;
	return subdivide(slots, slot, staging, patch, params.base.stride, true, &params,
			 sizeof params);
}

/* Uploads a whole texture of a slot. Makes it if it is not there yet. */
static enum status upload_whole(struct gpu_slots *slots, enum gpu_format format, struct gpu_texture **texture,
				struct gpu_staging *staging, size_t place, const char *what)
{
	uint32_t posts = slots->cells + 1;
	enum status status = STATUS_OK;
	if (*texture == NULL)
		status = gpu_texture_create(slots->gpu, format, posts, posts, 0, texture);
	if (status != STATUS_OK)
		return status;
	gpu_texture_upload_from(*texture, 0, whole(slots), staging, place);
	return gpu_check(slots->gpu, what);
}

enum status gpu_slots_upload_classes(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				     size_t classes)
{
	return upload_whole(slots, GPU_R8UI, &entry_of(slots, slot)->slot.classes, staging, classes, "upload of classes");
}

enum status gpu_slots_upload_numbers(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging, size_t numbers)
{
	return upload_whole(slots, GPU_RGBA8UI, &entry_of(slots, slot)->slot.numbers, staging, numbers, "upload of numbers");
}

/* --- deform slots --- */

static const enum gpu_format formats[PLANES] = {
	[PLANE_OFFSET] = GPU_R32I,  [PLANE_DISTURBANCE] = GPU_R8UI,   [PLANE_DEPOSITED] = GPU_R32I,
	[PLANE_PLASTIC_SINKAGE] = GPU_R32I, [PLANE_SHEAR] = GPU_R32I,   [PLANE_DUG] = GPU_R32I,
};

enum status gpu_slots_in_arrays(struct gpu_slots *slots)
{
	const uint32_t posts = slots->cells + 1;
	enum status status = slots->bases == NULL ? gpu_pool_create(slots->gpu, GPU_R32I, posts, slots->count, &slots->bases) : STATUS_OK;
	for (uint32_t i = 0; i < slots->count; i++)
		assert(slots->entries[i].slot.base == NULL && slots->all == NULL);
	for (int plane = 0; plane < PLANES && status == STATUS_OK; plane++)
		if ((slots->planes & GPU_DRAWN_PLANES & PLANE_BIT(plane)) && slots->drawn[plane] == NULL)
			status = gpu_pool_create(slots->gpu, formats[plane], posts, slots->count, &slots->drawn[plane]);
	return status;
}

static enum status plane_create(struct gpu_slots *slots, struct deform_slot *home, int plane)
{
	uint32_t posts = slots->cells + 1;
	if (slots->drawn[plane] != NULL)
		return gpu_pool_take(slots->drawn[plane], &home->planes[plane]);
	return gpu_texture_create(slots->gpu, formats[plane], posts, posts, 0, &home->planes[plane]);
}

static enum status deform_slot_create(struct gpu_slots *slots, struct deform_slot **out)
{
	struct deform_slot *home = mem_calloc(1, sizeof *home);
	if (home == NULL)
		return fail_memory("deform slot");
	struct gpu_attachment drawn[PLANES];
	uint32_t count = 0;
	enum status status = STATUS_OK;
	for (int plane = 0; plane < PLANES && status == STATUS_OK; plane++)
		if (slots->planes & GPU_DRAWN_PLANES & PLANE_BIT(plane)) {
			status = plane_create(slots, home, plane);
			drawn[count++] = (struct gpu_attachment){home->planes[plane], 0};
		}
	if (status == STATUS_OK)
		status = gpu_target_create(slots->gpu, drawn, count, (struct gpu_attachment){NULL, 0}, &home->target);
	if (status != STATUS_OK) {
		/* Drawn planes of a deform slot have the same layer of their arrays. */
		for (int plane = 0; plane < PLANES; plane++)
			if (home->planes[plane] != NULL && slots->drawn[plane] != NULL) {
				gpu_pool_return(slots->drawn[plane], home->planes[plane]);
				home->planes[plane] = NULL;
			}
		deform_slot_destroy(home);
		return status;
	}
	home->next = slots->all;
	slots->all = home;
	*out = home;
	return STATUS_OK;
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

static enum status hold(struct gpu_slots *slots, struct entry *entry, bool state)
{
	struct deform_slot *home = take_free(slots, state);
	if (home == NULL) {
		enum status status = deform_slot_create(slots, &home);
		if (status != STATUS_OK)
			return status;
	}
	entry->home = home;
	entry->slot.target = home->target;
	return STATUS_OK;
}

static void release(struct gpu_slots *slots, struct entry *entry)
{
	struct deform_slot **list = &slots->free[has_state(entry->home)];
	entry->home->free = *list;
	*list = entry->home;
	entry->home = NULL;
	entry->slot.target = NULL;
	memset(entry->slot.planes, 0, sizeof entry->slot.planes);
}

static void clear_planes(const struct entry *entry, unsigned planes, struct gpu_rect rect)
{
	for (int plane = 0; plane < PLANES; plane++)
		if ((planes & PLANE_BIT(plane)) && entry->slot.planes[plane] != NULL)
			gpu_texture_clear(entry->slot.planes[plane], 0, rect, 0);
}

/* Gives the entry the planes that pictures show, and those of the mask `planes` that the slots have. *fresh: planes that it did not
 * have before; their content is undefined. If it had no planes, a failure leaves it without any. */
static enum status need_planes(struct gpu_slots *slots, struct entry *entry, unsigned planes, unsigned *fresh)
{
	enum status status = STATUS_OK;
	bool state = (planes & slots->planes & ~GPU_DRAWN_PLANES) != 0;
	planes = state ? slots->planes : GPU_DRAWN_PLANES & slots->planes;
	*fresh = 0;
	bool had = entry->home != NULL;
	if (!had)
		status = hold(slots, entry, state);
	for (int plane = 0; plane < PLANES && status == STATUS_OK; plane++) {
		if (!(planes & PLANE_BIT(plane)) || entry->slot.planes[plane] != NULL)
			continue;
		if (entry->home->planes[plane] == NULL)
			status = plane_create(slots, entry->home, plane);
		entry->slot.planes[plane] = entry->home->planes[plane];
		*fresh |= PLANE_BIT(plane);
	}
	if (status == STATUS_OK)
		return STATUS_OK;
	for (int plane = 0; plane < PLANES; plane++)
		if (*fresh & PLANE_BIT(plane))
			entry->slot.planes[plane] = NULL;
	if (!had && entry->home != NULL)
		release(slots, entry);
	return status;
}

static enum status deform_with(struct gpu_slots *slots, struct entry *entry, unsigned planes)
{
	unsigned fresh;
	enum status status = need_planes(slots, entry, planes, &fresh);
	if (status != STATUS_OK)
		return status;
	clear_planes(entry, fresh, whole(slots));
	return gpu_check(slots->gpu, "deform slot");
}

enum status gpu_slots_deform(struct gpu_slots *slots, uint32_t slot)
{
	return deform_with(slots, entry_of(slots, slot), slots->planes);
}

void gpu_slots_undeform(struct gpu_slots *slots, uint32_t slot)
{
	struct entry *entry = entry_of(slots, slot);
	if (entry->home != NULL)
		release(slots, entry);
}

enum status gpu_slots_upload_deform(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				    const size_t places[PLANES])
{
	struct entry *entry = entry_of(slots, slot);
	unsigned given = 0, fresh;
	for (int plane = 0; plane < PLANES; plane++)
		given |= places[plane] != GPU_NO_PLANE ? PLANE_BIT(plane) : 0;
	if (entry->home != NULL) /* of the tile before; this tile may have fewer planes */
		release(slots, entry);
	enum status status = need_planes(slots, entry, given, &fresh);
	if (status != STATUS_OK)
		return status;
	for (int plane = 0; plane < PLANES; plane++)
		if (entry->slot.planes[plane] != NULL && places[plane] != GPU_NO_PLANE)
			gpu_texture_upload_from(entry->slot.planes[plane], 0, whole(slots), staging, places[plane]);
	clear_planes(entry, ~given, whole(slots));
	return gpu_check(slots->gpu, "upload of offsets");
}

enum status gpu_slots_read_deform(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				  const size_t places[PLANES])
{
	const struct entry *entry = entry_of(slots, slot);
	size_t posts = (size_t)(slots->cells + 1) * (slots->cells + 1);
	for (int plane = 0; plane < PLANES; plane++) {
		if (places[plane] == GPU_NO_PLANE)
			continue;
		if (entry->slot.planes[plane] != NULL)
			gpu_texture_read_into(entry->slot.planes[plane], 0, whole(slots), staging, places[plane]);
		else
			memset((char *)gpu_staging_bytes(staging) + places[plane], 0, posts * plane_bytes(plane));
	}
	return gpu_check(slots->gpu, "read back of offsets");
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
	const struct entry *from = entry_of(slots, fine);
	struct entry *to = entry_of(slots, coarse);
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
	enum status status = deform_with(slots, to, GPU_DRAWN_PLANES);
	if (status != STATUS_OK)
		return status;
	if (from->home == NULL) {
		clear_planes(to, GPU_DRAWN_PLANES, into);
		return gpu_check(slots->gpu, "decimation");
	}
	status = gpu_program_get(slots->gpu, gpu_slots_decimate_request(slots->planes), &program);
	if (status != STATUS_OK)
		return status;
	struct {
		int32_t from[2], to[2], steps, unused[3];
	} params = {
		.from = {(int32_t)rect.x, (int32_t)rect.y},
		.to = {(int32_t)to_x, (int32_t)to_y},
		.steps = shift,
	};
	slots->decimated++;
	gpu_pass_run(slots->gpu, &(struct gpu_pass){
		.stage = GPU_PYRAMID,
		.program = program,
		.target = to->slot.target,
		.viewport = into,
		.textures = {from->slot.planes[PLANE_OFFSET], from->slot.planes[PLANE_DISTURBANCE]},
		.params = &params,
		.params_bytes = sizeof params,
	});
	return gpu_check(slots->gpu, "decimation");
}
