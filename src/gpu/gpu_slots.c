/* Slots, and the textures of their bases. Offsets are in gpu_slots_deform.c. */

#include "gpu/slots.h"

enum status gpu_slots_create(struct gpu *gpu, uint32_t cells, uint32_t count, unsigned planes,
			     struct gpu_slots **out)
{
	assert(cells > 0 && count > 0);
	struct gpu_slots *slots = mem_calloc(1, sizeof *slots);
	struct slot_entry *entries = mem_calloc(count, sizeof *entries);
	if (slots == NULL || entries == NULL) {
		mem_free_all(slots, entries);
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
	return slots != NULL ? slots->planes : 0;
}

void gpu_slots_destroy(struct gpu_slots *slots)
{
	if (slots == NULL)
		return;
	while (slots->all != NULL) {
		struct deform_slot *home = slots->all;
		slots->all = home->next;
		gpu_deform_slot_destroy(home);
	}
	for (uint32_t i = 0; i < slots->count; i++) {
		gpu_target_destroy(slots->entries[i].base_target);
		gpu_texture_destroy(slots->entries[i].slot.base);
		gpu_texture_destroy(slots->entries[i].slot.classes);
	}
	for (uint32_t i = 0; i < SCRATCH_COUNT; i++)
		gpu_texture_destroy(slots->scratch[i]);
	gpu_pool_destroy(slots->bases);
	for (int plane = 0; plane < PLANES; plane++)
		gpu_pool_destroy(slots->drawn[plane]);
	mem_free_all(slots->entries, slots);
}

const struct gpu_slot *gpu_slots_get(const struct gpu_slots *slots, uint32_t slot)
{
	return &slots_entry(slots, slot)->slot;
}

static uint64_t bytes_of(const struct gpu_texture *texture)
{
	return texture != NULL ? texture->bytes : 0;
}

void gpu_slots_bytes(const struct gpu_slots *slots, struct gpu_slots_bytes *bytes)
{
	*bytes = (struct gpu_slots_bytes){0};
	if (slots == NULL)
		return;
	for (uint32_t i = 0; i < slots->count; i++) {
		bytes->base += bytes_of(slots->entries[i].slot.base);
		bytes->classes += bytes_of(slots->entries[i].slot.classes);
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

void gpu_slots_figures(const struct gpu_slots *slots, struct gpu_slots_figures *figures)
{
	*figures = (struct gpu_slots_figures){.subdivided = slots != NULL ? slots->subdivided : 0};
	if (slots == NULL)
		return;
	figures->decimated = slots->decimated;
	for (uint32_t i = 0; i < slots->count; i++) {
		figures->base_slots += slots->entries[i].slot.base != NULL;
		figures->class_slots += slots->entries[i].slot.classes != NULL;
	}
	for (const struct deform_slot *home = slots->all; home != NULL; home = home->next) {
		figures->deform_slots++;
		figures->state_slots += gpu_deform_slot_has_state(home);
	}
	for (int i = 0; i < SCRATCH_COUNT; i++)
		figures->patches += slots->scratch[i] != NULL;
	uint64_t bytes;
	gpu_pool_figures(slots->bases, &figures->base_arrays, &figures->base_layers, &bytes);
	gpu_pool_figures(slots->drawn[PLANE_OFFSET], &figures->deform_arrays, &figures->deform_layers, &bytes);
}

static enum status need_base(struct gpu_slots *slots, struct slot_entry *entry)
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
	struct slot_entry *entry = slots_entry(slots, slot);
	TRY(need_base(slots, entry));
	gpu_texture_upload_from(entry->slot.base, 0, slots_whole(slots), staging, posts);
	return gpu_check(slots->gpu, "upload of a tile");
}

enum status gpu_slots_put_base(struct gpu_slots *slots, uint32_t slot, const int32_t *posts)
{
	struct slot_entry *entry = slots_entry(slots, slot);
	TRY(need_base(slots, entry));
	gpu_texture_upload(entry->slot.base, 0, slots_whole(slots), posts);
	return gpu_check(slots->gpu, "upload of a tile");
}

/* Uploads the patch into the next scratch texture. */
static enum status upload_patch(struct gpu_slots *slots, struct gpu_staging *staging, size_t patch,
				uint32_t stride, struct gpu_texture **out)
{
	struct gpu_texture **scratch = &slots->scratch[slots->next_scratch];
	if (*scratch == NULL) {
		uint32_t side = slots->cells / 2 + 1;
		TRY(gpu_texture_create(slots->gpu, GPU_R32I, side, side, 0, scratch));
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
	struct slot_entry *entry = slots_entry(slots, slot);
	struct gpu_program *program;
	struct gpu_texture *scratch;
	TRY(gpu_program_get(slots->gpu, gpu_slots_subdivide_request(relief), &program));
	TRY(need_base(slots, entry));
	if (entry->base_target == NULL)
		TRY(gpu_target_create(slots->gpu, &(struct gpu_attachment){entry->slot.base, 0}, 1,
				      (struct gpu_attachment){NULL, 0}, &entry->base_target));
	TRY(upload_patch(slots, staging, patch, stride, &scratch));
	slots->subdivided++;
	gpu_pass_run(slots->gpu, &(struct gpu_pass){
		.stage = GPU_SUBDIVIDE,
		.program = program,
		.target = entry->base_target,
		.viewport = slots_whole(slots),
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

static enum status need_classes(struct gpu_slots *slots, struct gpu_texture **classes)
{
	const uint32_t posts = slots->cells + 1;
	return *classes != NULL ? STATUS_OK : gpu_texture_create(slots->gpu, GPU_R8UI, posts, posts, 0, classes);
}

enum status gpu_slots_upload_classes(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				     size_t classes)
{
	struct slot_entry *entry = slots_entry(slots, slot);
	TRY(need_classes(slots, &entry->slot.classes));
	gpu_texture_upload_from(entry->slot.classes, 0, slots_whole(slots), staging, classes);
	return gpu_check(slots->gpu, "upload of classes");
}

enum status gpu_slots_put_classes(struct gpu_slots *slots, uint32_t slot, const uint8_t *classes)
{
	struct slot_entry *entry = slots_entry(slots, slot);
	TRY(need_classes(slots, &entry->slot.classes));
	gpu_texture_upload(entry->slot.classes, 0, slots_whole(slots), classes);
	return gpu_check(slots->gpu, "upload of classes");
}
