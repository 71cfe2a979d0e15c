/*
 * The ground under a body, mirrored on the host: what a probe reads in place of the GPU's planes.
 *
 * States: empty -> coming (deform_patch_begin; transfers are under way) -> known (deform_patch_land) -> coming again when the ground
 * changed or the body moved on.
 *
 * Invariants:
 * - `posts` hold the ground as it was at the last read that landed. Nothing but deform_patch_reach changes them in between, and that
 *   changes only `reached`.
 * - The base, the classes and the numbers of the soil never change, so they are read once for each rectangle.
 */
#include "deform/probe/patch.h"

#include <math.h>
#include <string.h>

#include "deform/internal.h"

#define WORDS 5 /* int32 for each post: base, then these planes */
#define POST_BYTES ((WORDS + 2) * sizeof(int32_t)) /* with numbers and classes of the soil */
static const enum plane planes[WORDS] = {PLANES, PLANE_DEPOSITED, PLANE_PLASTIC_SINKAGE, PLANE_SHEAR, PLANE_DUG};

enum status deform_patch_create(struct deform *deform, struct deform_patch **out)
{
	*out = mem_calloc(1, sizeof **out);
	if (*out == NULL)
		return fail_memory("the ground of a probe");
	(*out)->deform = deform;
	return STATUS_OK;
}

void deform_patch_plan(const struct deform_params *params, struct plan *plan)
{
	plan_add(plan, &(struct plan_line){.kind = PLAN_BUFFER, .unit = PLAN_PROBED, .effect = "forces", .object = -1,
					   .amount = 1, .bytes = POST_BYTES}, "ground under probed bodies");
}

static void forget_staging(struct deform_patch *patch)
{
	gpu_staging_destroy(patch->staging);
	patch->staging = NULL;
	patch->deform->figures.probed -= patch->staged / POST_BYTES;
	patch->staged = 0;
}

void deform_patch_destroy(struct deform_patch *patch)
{
	if (patch == NULL)
		return;
	forget_staging(patch);
	mem_free(patch->bases);
	mem_free(patch->kinds);
	mem_free(patch->posts);
	mem_free(patch->lows);
	mem_free(patch->soils);
	mem_free(patch->soil_kinds);
	mem_free(patch);
}

struct post_rect deform_patch_rect(const struct deform_patch *patch)
{
	return patch->known || patch->coming ? patch->rect : (struct post_rect){0, 0, 0, 0};
}

void deform_patch_forget(struct deform_patch *patch)
{
	patch->known = false;
}

/* --- reading --- */

static size_t posts_in(struct post_rect rect)
{
	return (size_t)(rect.x1 - rect.x0) * (size_t)(rect.y1 - rect.y0);
}

static enum status make_room(struct deform_patch *patch, size_t count)
{
	if (count <= patch->room)
		return STATUS_OK;
	mem_free(patch->bases);
	mem_free(patch->kinds);
	mem_free(patch->posts);
	mem_free(patch->lows);
	patch->room = 0;
	patch->bases = mem_alloc(count, sizeof *patch->bases);
	patch->kinds = mem_alloc(count, 2 * sizeof *patch->kinds);
	patch->posts = mem_alloc(count, sizeof *patch->posts);
	patch->lows = mem_alloc(count, 2 * sizeof *patch->lows);
	if (patch->bases == NULL || patch->kinds == NULL || patch->posts == NULL || patch->lows == NULL)
		return fail_memory("the ground of a probe");
	patch->room = count;
	return STATUS_OK;
}

/* Notes which posts of which tiles are read. */
static enum status cut(struct deform_patch *patch, const struct deform_tile *tiles, size_t count)
{
	size_t bytes = 0;
	patch->part_count = 0;
	for (size_t i = 0; i < count; i++) {
		const struct post_rect part = post_rect_intersect(tile_post_rect(patch->deform->params.extent, tiles[i].tile), patch->rect);
		if (post_rect_empty(part))
			continue;
		if (patch->part_count == PATCH_PARTS)
			return fail_with(STATUS_INPUT, "probe: the ground under a body lies on more than %d tiles; use larger tiles", PATCH_PARTS);
		patch->parts[patch->part_count++] = (struct patch_part){.rect = part, .at = bytes};
		bytes += POST_BYTES * posts_in(part);
	}
	if (bytes <= patch->staged)
		return STATUS_OK;
	forget_staging(patch);
	enum status status = gpu_staging_create(patch->deform->params.gpu, bytes, &patch->staging);
	patch->staged = status == STATUS_OK ? bytes : 0;
	patch->deform->figures.probed += patch->staged / POST_BYTES;
	return status;
}

static void read_part(struct deform_patch *patch, struct patch_part *part, const struct deform_tile *tile)
{
	const struct gpu_slot *slot = gpu_slots_get(patch->deform->params.slots, tile->slot);
	const struct post_rect own = tile_post_rect(patch->deform->params.extent, tile->tile);
	const struct gpu_rect in = {(uint32_t)(part->rect.x0 - own.x0), (uint32_t)(part->rect.y0 - own.y0),
				    (uint32_t)(part->rect.x1 - part->rect.x0), (uint32_t)(part->rect.y1 - part->rect.y0)};
	const size_t plane = posts_in(part->rect) * sizeof(int32_t);
	if (patch->whole) {
		gpu_texture_read_into(slot->base, 0, in, patch->staging, part->at);
		part->numbered = patch->deform->numbers != NULL && slot->numbers != NULL;
		if (part->numbered)
			gpu_texture_read_into(slot->numbers, 0, in, patch->staging, part->at + WORDS * plane);
		part->classed = patch->deform->classes != NULL && slot->classes != NULL;
		if (part->classed)
			gpu_texture_read_into(slot->classes, 0, in, patch->staging, part->at + (WORDS + 1) * plane);
	}
	for (int k = 1; k < WORDS; k++)
		if (slot->planes[planes[k]] != NULL) {
			part->deformed |= 1u << k;
			gpu_texture_read_into(slot->planes[planes[k]], 0, in, patch->staging, part->at + (size_t)k * plane);
		}
}

enum status deform_patch_begin(struct deform_patch *patch, struct post_rect rect, const struct deform_tile *tiles, size_t count)
{
	const struct post_rect *had = &patch->rect;
	patch->whole = !patch->known || rect.x0 != had->x0 || rect.y0 != had->y0 || rect.x1 != had->x1 || rect.y1 != had->y1;
	patch->known = patch->known && !patch->whole;
	patch->rect = rect;
	patch->width = (size_t)(rect.x1 - rect.x0);
	patch->count = posts_in(rect);
	enum status status = make_room(patch, patch->count);
	if (status == STATUS_OK)
		status = cut(patch, tiles, count);
	if (status != STATUS_OK) {
		patch->known = false;
		return status;
	}
	size_t part = 0;
	for (size_t i = 0; i < count && part < patch->part_count; i++)
		if (!post_rect_empty(post_rect_intersect(tile_post_rect(patch->deform->params.extent, tiles[i].tile), rect)))
			read_part(patch, &patch->parts[part++], &tiles[i]);
	patch->coming = true;
	return gpu_check(patch->deform->params.gpu, "the ground of a probe");
}

/* --- landing --- */

static struct probe_soil soil_of(const struct deform_params *params, uint32_t class, const uint8_t levels[SOIL_RASTERS])
{
	struct soil_numbers soil = params->soils[class < (uint32_t)params->soil_count ? class : 0];
	for (int i = 0; i < params->raster_count; i++)
		if (levels[i] != 0)
			*soil_number_in(&soil, params->rasters[i].number) = soil_raster_value(&params->rasters[i], levels[i]);
	return (struct probe_soil){
		.k_c = soil.bekker_kc, .k_phi = soil.bekker_kphi, .n = soil.bekker_n,
		.elastic = fmin(soil.elastic_stiffness, 1e30), .by_elastic = fmin(1 / soil.elastic_stiffness, 1e30),
		.cohesion = soil.cohesion, .tan_phi = tan(soil.friction_angle),
		.shear = fmin(soil.janosi_shear, 1e30), .by_shear = fmin(1 / soil.janosi_shear, 1e30), .damping = soil.damping,
	};
}

/* Finds the soil of a kind, or adds it. */
static enum status find_soil(struct deform_patch *patch, const uint32_t kind[2], uint32_t *soil)
{
	for (size_t i = 0; i < patch->soil_count; i++)
		if (patch->soil_kinds[2 * i] == kind[0] && patch->soil_kinds[2 * i + 1] == kind[1]) {
			*soil = (uint32_t)i;
			return STATUS_OK;
		}
	if (patch->soil_count == patch->soil_room) {
		const size_t room = patch->soil_room > 0 ? 2 * patch->soil_room : 4;
		struct probe_soil *soils = mem_realloc(patch->soils, room, sizeof *soils);
		patch->soils = soils != NULL ? soils : patch->soils;
		uint32_t *kinds = mem_realloc(patch->soil_kinds, 2 * room, sizeof *kinds);
		patch->soil_kinds = kinds != NULL ? kinds : patch->soil_kinds;
		if (soils == NULL || kinds == NULL)
			return fail_memory("the ground of a probe");
		patch->soil_room = room;
	}
	uint8_t levels[SOIL_RASTERS];
	memcpy(levels, &kind[1], sizeof levels);
	*soil = (uint32_t)patch->soil_count;
	patch->soil_kinds[2 * patch->soil_count] = kind[0];
	patch->soil_kinds[2 * patch->soil_count + 1] = kind[1];
	patch->soils[patch->soil_count++] = soil_of(&patch->deform->params, kind[0], levels);
	return STATUS_OK;
}

static double rise_between(const struct deform_patch *patch, size_t low, size_t at, size_t high)
{
	const int32_t *bases = patch->bases;
	const bool no_low = bases[low] == BASE_NODATA, no_high = bases[high] == BASE_NODATA;
	const double first = no_low ? bases[at] : bases[low], last = no_high ? bases[at] : bases[high];
	const double rise = lattice_base_metres(1) * (last - first) / patch->deform->spacing;
	return no_low || no_high ? rise : 0.5 * rise;
}

/* How the base lies at each post that has neighbours in the patch. A slope counts as at most 87 degrees. */
static void put_inclines(struct deform_patch *patch)
{
	const size_t width = patch->width, height = patch->count / width;
	for (size_t y = 1; y + 1 < height; y++)
		for (size_t x = 1; x + 1 < width; x++) {
			const size_t at = y * width + x;
			struct probe_post *post = &patch->posts[at];
			const double east = rise_between(patch, at - 1, at, at + 1), north = rise_between(patch, at - width, at, at + width);
			const double squares = east * east + north * north, by_up = sqrt(1 + squares), most = 19.974984 / fmax(sqrt(squares), 19.974984);
			post->rise[0] = east * most;
			post->rise[1] = north * most;
			post->up = fmax(1 / by_up, 0.05);
			post->by_up = fmin(by_up, 20);
		}
}

/* The first post that is no hole gives the zero of heights. */
static void put_zero(struct deform_patch *patch)
{
	int32_t base = 0;
	for (size_t i = 0; i < patch->count; i++)
		if (patch->bases[i] != BASE_NODATA) {
			base = patch->bases[i];
			break;
		}
	patch->zero = patch->deform->params.reference * ((int64_t)1 << OFFSET_BITS) + base * ((int64_t)1 << (OFFSET_BITS - BASE_BITS));
}

static void take_base(struct deform_patch *patch, const struct patch_part *part, const char *bytes)
{
	const size_t width = (size_t)(part->rect.x1 - part->rect.x0), posts = posts_in(part->rect);
	const int32_t *base = (const void *)bytes;
	const char *numbers = bytes + WORDS * sizeof(int32_t) * posts;
	const uint8_t *classes = (const void *)(numbers + sizeof(int32_t) * posts);
	for (size_t i = 0; i < posts; i++) {
		const size_t at = (size_t)(part->rect.y0 - patch->rect.y0 + (int64_t)(i / width)) * patch->width +
				  (size_t)(part->rect.x0 - patch->rect.x0) + i % width;
		patch->bases[at] = base[i];
		patch->kinds[2 * at] = part->classed ? classes[i] : 0;
		patch->kinds[2 * at + 1] = 0;
		if (part->numbered)
			memcpy(&patch->kinds[2 * at + 1], numbers + sizeof(int32_t) * i, sizeof(int32_t));
	}
}

static void take_state(struct deform_patch *patch, const struct patch_part *part, const char *bytes)
{
	const size_t width = (size_t)(part->rect.x1 - part->rect.x0), posts = posts_in(part->rect);
	const int32_t *words = (const void *)bytes;
	const int64_t zero = patch->zero - patch->deform->params.reference * ((int64_t)1 << OFFSET_BITS);
	int32_t state[WORDS] = {0};
	for (size_t i = 0; i < posts; i++) {
		const size_t at = (size_t)(part->rect.y0 - patch->rect.y0 + (int64_t)(i / width)) * patch->width +
				  (size_t)(part->rect.x0 - patch->rect.x0) + i % width;
		struct probe_post *post = &patch->posts[at];
		for (int k = 1; k < WORDS; k++)
			state[k] = part->deformed & 1u << k ? words[(size_t)k * posts + i] : 0;
		post->hole = patch->bases[at] == BASE_NODATA;
		post->height = post->hole ? 0 : lattice_offset_metres(patch->bases[at] * ((int64_t)1 << (OFFSET_BITS - BASE_BITS)) - zero + state[1]);
		post->deposited = lattice_offset_metres(state[1]);
		post->was = lattice_offset_metres(state[2]);
		post->shear[0] = ldexp(plane_shear(state[3], PLANE_SHEAR_EAST), -PLANE_SHEAR_BITS);
		post->shear[1] = ldexp(plane_shear(state[3], PLANE_SHEAR_NORTH), -PLANE_SHEAR_BITS);
		post->dug = lattice_offset_metres(state[4]);
	}
}

/* Beyond the world there is no ground. */
static void clear(struct deform_patch *patch)
{
	memset(patch->posts, 0, patch->count * sizeof *patch->posts);
	memset(patch->kinds, 0, 2 * patch->count * sizeof *patch->kinds);
	for (size_t i = 0; i < patch->count; i++) {
		patch->bases[i] = BASE_NODATA;
		patch->posts[i].hole = true;
		patch->posts[i].up = patch->posts[i].by_up = 1;
	}
}

static enum status take(struct deform_patch *patch)
{
	const char *bytes = patch->part_count > 0 ? gpu_staging_bytes(patch->staging) : NULL;
	enum status status = gpu_check(patch->deform->params.gpu, "the ground of a probe");
	if (status == STATUS_OK && patch->whole) {
		clear(patch);
		for (size_t i = 0; i < patch->part_count; i++)
			take_base(patch, &patch->parts[i], bytes + patch->parts[i].at);
		put_zero(patch);
		put_inclines(patch);
		for (size_t i = 0; i < patch->count && status == STATUS_OK; i++)
			status = find_soil(patch, &patch->kinds[2 * i], &patch->posts[i].soil);
	}
	for (size_t i = 0; i < patch->part_count && status == STATUS_OK; i++)
		take_state(patch, &patch->parts[i], bytes + patch->parts[i].at);
	return status;
}

enum status deform_patch_land(struct deform_patch *patch, bool anew)
{
	enum status status = STATUS_OK;
	const bool whole = patch->coming && patch->whole;
	if (patch->coming) {
		while (patch->staging != NULL && !gpu_staging_idle(patch->staging))
			gpu_finish(patch->deform->params.gpu);
		patch->coming = false;
		status = take(patch);
		patch->known = status == STATUS_OK;
	}
	for (size_t i = 0; i < patch->count && (anew || whole) && patch->known; i++)
		patch->posts[i].reached = INFINITY;
	return status;
}
