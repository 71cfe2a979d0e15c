/* Slots in host memory: who is in them, and their coarser levels. Memory of tiles is in host_planes.c. */

#include "resident/host_slots.h"

enum status resident_host_create(uint32_t cells, uint32_t count, unsigned planes, struct host_slots **out)
{
	assert(cells > 0 && count > 0);
	const size_t posts = (size_t)(cells + 1) * (cells + 1);
	struct host_slots *slots = mem_calloc(1, sizeof *slots);
	struct host_entry *entries = mem_calloc(count, sizeof *entries);
	struct host_plane *zeros = mem_calloc(1, sizeof *zeros + posts * sizeof(int32_t));
	if (slots == NULL || entries == NULL || zeros == NULL) {
		mem_free_all(slots, entries, zeros);
		return fail_memory("slots in memory");
	}
	*slots = (struct host_slots){
		.cells = cells,
		.count = count,
		.posts = posts,
		.planes = planes | PLANE_BIT(PLANE_OFFSET),
		.entries = entries,
		.zeros = zeros,
	};
	atomic_init(&zeros->refs, 1);
	mutex_init(&slots->mutex);
	*out = slots;
	return STATUS_OK;
}

void resident_host_destroy(struct host_slots *slots)
{
	if (slots == NULL)
		return;
	for (uint32_t i = 0; i < slots->count; i++)
		resident_host_tile_finish(slots, &slots->entries[i].tile);
	resident_host_planes_finish(slots);
	mutex_finish(&slots->mutex);
	mem_free_all(slots->entries, slots);
}

unsigned resident_host_planes(const struct host_slots *slots)
{
	return slots->planes;
}

void resident_host_get(const struct host_slots *slots, uint32_t slot, struct host_slot *out)
{
	const struct host_tile *tile = &host_entry(slots, slot)->tile;
	*out = (struct host_slot){.base = tile->base, .classes = tile->classes, .levels = tile->levels};
	for (int plane = 0; plane < PLANES; plane++)
		out->planes[plane] = host_tile_plane(slots, tile, plane);
}

enum status resident_host_write(struct host_slots *slots, uint32_t slot, unsigned planes)
{
	return resident_host_tile_write(slots, &host_entry(slots, slot)->tile, planes);
}

void *resident_host_plane(struct host_slots *slots, uint32_t slot, enum plane plane)
{
	struct host_plane *held = host_entry(slots, slot)->tile.planes[plane];
	assert(held != NULL && atomic_load(&held->refs) == 1); /* 2 */
	return held->posts;
}

void resident_host_changed(struct host_slots *slots, uint32_t slot, struct gpu_rect rect)
{
	struct host_entry *entry = host_entry(slots, slot);
	struct gpu_rect *changed = &entry->changed;
	if (rect.width == 0 || rect.height == 0)
		return;
	assert(rect.x + rect.width <= slots->cells + 1 && rect.y + rect.height <= slots->cells + 1);
	if (changed->width == 0 || changed->height == 0) {
		*changed = rect;
		return;
	}
	const uint32_t right = changed->x + changed->width, top = changed->y + changed->height;
	const uint32_t x = rect.x < changed->x ? rect.x : changed->x, y = rect.y < changed->y ? rect.y : changed->y;
	*changed = (struct gpu_rect){x, y, (rect.x + rect.width > right ? rect.x + rect.width : right) - x,
				     (rect.y + rect.height > top ? rect.y + rect.height : top) - y};
}

/* --- figures --- */

void resident_host_figures(struct host_slots *slots, struct resident_host_figures *figures)
{
	mutex_lock(&slots->mutex);
	*figures = slots->figures;
	mutex_unlock(&slots->mutex);
	figures->base_bytes = figures->bases * slots->posts * sizeof(int32_t);
	figures->class_bytes = figures->classes * slots->posts;
	figures->level_bytes = figures->levels * slots->posts * PAGES_NUMBER_BYTES;
	figures->bytes = figures->base_bytes + figures->class_bytes + figures->level_bytes;
	for (int plane = 0; plane < PLANES; plane++) {
		figures->plane_bytes[plane] = figures->planes[plane] * slots->posts * plane_bytes((enum plane)plane);
		figures->bytes += figures->plane_bytes[plane];
	}
}

void resident_host_in_slots(const struct host_slots *slots, struct resident_host_in_slots *in)
{
	*in = (struct resident_host_in_slots){.bases = 0};
	for (uint32_t i = 0; i < slots->count; i++) {
		const struct host_tile *tile = &slots->entries[i].tile;
		bool deformed = false;
		in->bases += tile->base != NULL;
		in->classes += tile->classes != NULL;
		in->levels += tile->levels != NULL;
		for (int plane = 0; plane < PLANES; plane++) {
			in->planes[plane] += host_tile_plane(slots, tile, plane) != NULL;
			deformed = deformed || host_tile_plane(slots, tile, plane) != NULL;
		}
		in->deformed += deformed;
	}
	in->base_bytes = in->bases * slots->posts * sizeof(int32_t);
	in->class_bytes = in->classes * slots->posts;
	in->level_bytes = in->levels * slots->posts * PAGES_NUMBER_BYTES;
	for (int plane = 0; plane < PLANES; plane++)
		in->plane_bytes[plane] = in->planes[plane] * slots->posts * plane_bytes((enum plane)plane);
}

static void add(struct plan *plan, const char *effect, enum plan_unit unit, uint64_t bytes, const char *name)
{
	char line[64];
	snprintf(line, sizeof line, "in memory: %s", name);
	plan_add(plan, &(struct plan_line){.kind = PLAN_BUFFER, .unit = unit, .effect = effect, .object = -1, .amount = 1, .bytes = bytes}, line);
}

void resident_host_plan(uint32_t cells, unsigned planes, const char *classes_effect, const char *levels_effect,
			const char *const effects[PLANES], struct plan *plan)
{
	const uint64_t posts = (uint64_t)(cells + 1) * (cells + 1);
	planes |= planes != 0 ? PLANE_BIT(PLANE_OFFSET) : 0;
	plan_add(plan, &(struct plan_line){.kind = PLAN_PLANE, .object = -1, .amount = 1, .bytes = sizeof(int32_t)}, "base");
	add(plan, NULL, PLAN_HOST_BASE, posts * sizeof(int32_t), "base");
	if (classes_effect != NULL) {
		plan_add(plan, &(struct plan_line){.kind = PLAN_PLANE, .effect = classes_effect, .object = -1, .amount = 1, .bytes = 1}, "classes");
		add(plan, classes_effect, PLAN_HOST_CLASSES, posts, "classes");
	}
	if (levels_effect != NULL) {
		plan_add(plan, &(struct plan_line){.kind = PLAN_PLANE, .effect = levels_effect, .object = -1, .amount = 1, .bytes = PAGES_NUMBER_BYTES},
			 "numbers");
		add(plan, levels_effect, PLAN_HOST_NUMBERS, posts * PAGES_NUMBER_BYTES, "numbers");
	}
	for (int plane = 0; plane < PLANES; plane++)
		if (planes & PLANE_BIT(plane))
			add(plan, effects[plane], (enum plan_unit)(PLAN_HOST_OFFSET + plane), posts * plane_bytes((enum plane)plane),
			    plane_name((enum plane)plane));
}

/* --- coarser tiles --- */

/* Returns how many of length posts remain if only every 2^shift-th is kept, beginning with the first. */
static uint32_t kept(uint32_t length, int shift)
{
	return length == 0 ? 0 : ((length - 1) >> shift) + 1;
}

static void decimate_i32(const int32_t *from, int shift, struct gpu_rect into, size_t stride, int32_t *to)
{
	for (size_t y = 0; y < into.height; y++, to += stride)
		for (size_t x = 0; x < into.width; x++)
			to[x] = from != NULL ? from[(y * stride + x) << shift] : 0;
}

static void decimate_u8(const uint8_t *from, int shift, struct gpu_rect into, size_t stride, uint8_t *to)
{
	for (size_t y = 0; y < into.height; y++, to += stride)
		for (size_t x = 0; x < into.width; x++)
			to[x] = from != NULL ? from[(y * stride + x) << shift] : 0;
}

enum status resident_host_decimate(struct host_slots *slots, uint32_t fine, struct gpu_rect rect, int steps, uint32_t coarse,
				   uint32_t to_x, uint32_t to_y)
{
	const struct host_tile *from = &host_entry(slots, fine)->tile;
	struct host_tile *to = &host_entry(slots, coarse)->tile;
	const unsigned drawn = GPU_DRAWN_PLANES & slots->planes;
	const size_t stride = slots->cells + 1, first = (size_t)rect.y * stride + rect.x, at = (size_t)to_y * stride + to_x;
	bool any = false;
	assert(steps >= 1 && fine != coarse);
	const int shift = steps < 16 ? steps : 16; /* with more steps than the tile has cells, one post is kept */
	const struct gpu_rect into = {to_x, to_y, kept(rect.width, shift), kept(rect.height, shift)};
	assert(rect.x + rect.width <= stride && rect.y + rect.height <= stride && to_x + into.width <= stride && to_y + into.height <= stride);
	for (int plane = 0; plane < PLANES; plane++)
		any = any || ((drawn & PLANE_BIT(plane)) && (from->planes[plane] != NULL || to->planes[plane] != NULL));
	if (into.width == 0 || into.height == 0 || !any)
		return STATUS_OK;
	TRY(resident_host_tile_write(slots, to, drawn));
	const int32_t *offset = host_tile_plane(slots, from, PLANE_OFFSET);
	const uint8_t *disturbance = host_tile_plane(slots, from, PLANE_DISTURBANCE);
	decimate_i32(offset != NULL ? offset + first : NULL, shift, into, stride, (int32_t *)(void *)to->planes[PLANE_OFFSET]->posts + at);
	if (drawn & PLANE_BIT(PLANE_DISTURBANCE))
		decimate_u8(disturbance != NULL ? disturbance + first : NULL, shift, into, stride, to->planes[PLANE_DISTURBANCE]->posts + at);
	for (int plane = PLANE_HEALED; plane <= PLANE_GROWN; plane++) {
		const int32_t *mark = host_tile_plane(slots, from, plane);
		if (drawn & PLANE_BIT(plane))
			decimate_i32(mark != NULL ? mark + first : NULL, shift, into, stride, (int32_t *)(void *)to->planes[plane]->posts + at);
	}
	resident_host_changed(slots, coarse, into);
	mutex_lock(&slots->mutex);
	slots->figures.decimated++;
	mutex_unlock(&slots->mutex);
	return STATUS_OK;
}
