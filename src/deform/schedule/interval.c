/*
 * An interval: all active blocks make `iterations` iterations of the sliding rule, as if the whole lattice did.
 *
 * Blocks are computed in regions (regions.h), and these in an atlas, a layer like a window's. It holds a batch of regions at a time.
 * Each region has a rim around it. Values near the rim's border become wrong, and the rim is wide enough to keep them
 * out of the blocks. Results wait in `results` until all regions have been gathered. So no region reads another's result.
 */
#include <assert.h>
#include <string.h>

#include "deform/internal.h"
#include "deform/schedule/regions.h"

#define CONTACT_CLOSED 8 /* lib/window.glsl */
_Static_assert(REGION_ALIGN == CELL, "cells of a block lie in no other block");
#define RESULT_COLUMNS (SIDE / SOIL_BLOCK)
#define QUADS (CELLS_ACROSS * CELLS_ACROSS) /* the most that a pass draws */
#define RESULTS (RESULT_COLUMNS * RESULT_COLUMNS) /* blocks a layer */

struct interval {
	struct region_limits limits;
	struct regions regions;
	const struct deform_rest *objects;
	size_t object_count;
	size_t begun;                  /* number of regions of which a part was gathered */
	struct gpu_buffer *quads;      /* indices of quads: two triangles over four vertices each */
	struct gpu_texture *cells;     /* marks of the atlas's cells; NULL: the height of slopes does not count */
	struct gpu_texture *results[PLANES];
	struct gpu_buffer *flags;      /* one word for each block */
};

/* std140 twin of held.frag's block. */
struct held_params {
	uint32_t zero[4];
	int32_t window[4];
};

static void drop_results(struct deform *deform)
{
	struct interval *interval = deform->interval;
	for (int plane = 0; plane < PLANES; plane++) {
		gpu_texture_destroy(interval->results[plane]);
		interval->results[plane] = NULL;
	}
	deform->figures.result_layers = 0;
}

/* Returns the planes that sliding changes, a mask of PLANE_BIT. */
static unsigned sliding_planes(const struct deform_params *params)
{
	return deform_planes(params->model, params->disturbance, deform_memory(params)) & (PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_SLOPE));
}

static enum status make_results(struct deform *deform, uint32_t layers)
{
	for (int plane = 0; plane < PLANES; plane++)
		if (sliding_planes(&deform->params) & PLANE_BIT(plane))
			TRY(gpu_texture_create(deform->params.gpu, GPU_R32I, SIDE, SIDE, layers, &deform->interval->results[plane]));
	return STATUS_OK;
}

static enum status need_results(struct deform *deform, size_t blocks)
{
	uint32_t layers = deform->figures.result_layers;
	while ((size_t)layers * RESULTS < blocks)
		layers = layers != 0 ? 2 * layers : 1;
	if (layers == deform->figures.result_layers)
		return STATUS_OK;
	drop_results(deform);
	enum status status = make_results(deform, layers);
	if (status != STATUS_OK) {
		drop_results(deform);
		return status;
	}
	deform->figures.result_layers = layers;
	return STATUS_OK;
}

static enum status make_quads(struct deform *deform)
{
	uint16_t indices[QUADS][6];
	static const uint16_t corners[6] = {0, 1, 2, 2, 1, 3};
	for (int quad = 0; quad < QUADS; quad++)
		for (int i = 0; i < 6; i++)
			indices[quad][i] = (uint16_t)(4 * quad + corners[i]);
	return gpu_buffer_create(deform->params.gpu, GPU_INDICES, sizeof indices, indices, &deform->interval->quads);
}

enum status deform_interval_create(struct deform *deform)
{
	struct interval *interval = mem_calloc(1, sizeof *interval);
	TRY_MEM(interval, "the awake blocks");
	deform->interval = interval;
	interval->limits = (struct region_limits){SIDE, (uint32_t)deform_slide_rim(deform), deform->params.extent->cells, RESULT_COLUMNS};
	TRY(gpu_buffer_create(deform->params.gpu, GPU_STORAGE, DEFORM_BLOCKS_MAX * sizeof(uint32_t), NULL, &interval->flags));
	TRY(make_quads(deform));
	if (deform_has_slopes(&deform->params))
		TRY(gpu_texture_create(deform->params.gpu, GPU_R8UI, CELLS_ACROSS, CELLS_ACROSS, 0, &interval->cells));
	return need_results(deform, 1);
}

void deform_interval_plan(const struct deform_params *params, struct plan *plan)
{
	const char *effect = deform_slide_effect(params->model);
	for (int plane = 0; plane < PLANES; plane++) {
		if (!(sliding_planes(params) & PLANE_BIT(plane)))
			continue;
		struct plan_line line = {.kind = PLAN_TEXTURE, .unit = PLAN_ONCE, .effect = effect, .object = -1, .amount = 1};
		plan_add(plan, &line, "slid blocks");
		line.unit = PLAN_RESULT_LAYER;
		line.amount = 0;
		line.bytes = (uint64_t)SIDE * SIDE * gpu_format_bytes(GPU_R32I);
		plan_add(plan, &line, "slid blocks");
	}
	if (deform_has_slopes(params))
		plan_add(plan, &(struct plan_line){.kind = PLAN_TEXTURE, .unit = PLAN_ONCE, .effect = effect, .object = -1, .amount = 1,
						   .bytes = CELLS_ACROSS * CELLS_ACROSS}, "steep cells");
	deform_plan_buffer(plan, effect, 1, DEFORM_BLOCKS_MAX * sizeof(uint32_t), "blocks' flags");
	deform_plan_buffer(plan, effect, 1, QUADS * 6 * sizeof(uint16_t), "blocks' corners");
}

void deform_interval_destroy(struct deform *deform)
{
	struct interval *interval = deform->interval;
	if (interval == NULL)
		return;
	drop_results(deform);
	deform_regions_finish(&interval->regions);
	gpu_texture_destroy(interval->cells);
	gpu_buffer_destroy(interval->quads);
	gpu_buffer_destroy(interval->flags);
	mem_free(interval);
}

static struct deform_contact rest_contact(const struct deform_rest *object)
{
	return (struct deform_contact){.shape = object->shape, .from = object->pose, .to = object->pose};
}

enum status deform_interval_begin(struct deform *deform, const struct deform_rest *objects, size_t object_count,
				  struct deform_interval *size)
{
	struct interval *interval = deform->interval;
	const struct soil_block_set *active;
	*size = (struct deform_interval){.blocks = 0};
	if (interval == NULL)
		return STATUS_OK;
	interval->begun = 0;
	TRY(deform_active_visit(deform, &active));
	if (active->count == 0)
		return STATUS_OK;
	interval->objects = objects;
	interval->object_count = object_count;
	for (size_t i = 0; i < object_count; i++)
		if (objects[i].roofs)
			TRY(deform_need_roofs(deform));
	/* Makes all layers that the objects' windows will need. Making them later would lose the gathered posts. */
	for (size_t i = 0; i < object_count; i++) {
		const struct deform_contact contact = rest_contact(&objects[i]);
		struct deform_window windows[DEFORM_WINDOWS_MAX];
		size_t needed;
		TRY(deform_windows(deform, &contact, windows, &needed));
	}
	TRY(need_results(deform, active->count));
	TRY(deform_regions_cut(active, &interval->limits, &interval->regions));
	gpu_buffer_clear(interval->flags, 0, active->count * sizeof(uint32_t));
	*size = (struct deform_interval){active->count, interval->regions.region_count, interval->regions.run_count, interval->regions.atlas_count};
	return STATUS_OK;
}

int64_t deform_interval_rim(const struct deform *deform)
{
	return deform->interval->limits.rim;
}

struct post_rect deform_interval_writes(const struct deform *deform, size_t run)
{
	const struct extent *extent = deform->params.extent;
	const struct run *at = &deform->interval->regions.runs[run];
	int64_t x = at->first.x * SOIL_BLOCK, y = at->first.y * SOIL_BLOCK;
	return post_rect_intersect((struct post_rect){x, y, x + at->count * SOIL_BLOCK, y + SOIL_BLOCK},
				   (struct post_rect){0, 0, extent_posts(extent->width, deform->params.level),
						      extent_posts(extent->height, deform->params.level)});
}

struct post_rect deform_interval_reads(const struct deform *deform, size_t region)
{
	const struct region *at = &deform->interval->regions.regions[region];
	int64_t rim = deform->interval->limits.rim, x = at->x * SOIL_BLOCK, y = at->y * SOIL_BLOCK;
	return (struct post_rect){x - rim, y - rim, x + at->columns * SOIL_BLOCK + rim, y + at->rows * SOIL_BLOCK + rim};
}

/* Finds the first post of a region's rim in the atlas. */
static void place_of(const struct interval *interval, size_t region, uint32_t *x, uint32_t *y)
{
	const struct region *at = &interval->regions.regions[region];
	*x = at->at_x - interval->limits.rim;
	*y = at->at_y - interval->limits.rim;
}

/* Marks the posts of one region that an object at rest holds. The object's lower envelope over `window` is in layer 0.
 * `shadow`: the posts that the object can be above. Elsewhere the envelope was not drawn. */
static enum status hold(struct deform *deform, const struct deform_rest *object, struct post_rect window,
			struct post_rect shadow, size_t region)
{
	struct post_rect square = deform_interval_reads(deform, region);
	struct post_rect both = post_rect_intersect(post_rect_intersect(window, shadow), square);
	uint32_t x, y;
	if (post_rect_empty(both))
		return STATUS_OK;
	struct deform_request request;
	deform_programs_held(&request);
	TRY(deform_program(deform, &request, &deform->held));
	place_of(deform->interval, region, &x, &y);
	int64_t zero = object->pose.z - (int64_t)deform->params.reference * (1 << OFFSET_BITS);
	const struct held_params params = {
		.zero = {(uint32_t)zero, (uint32_t)((uint64_t)zero >> 32), 0, deform->layers},
		.window = {(int32_t)(window.x0 - square.x0 + x), (int32_t)(window.y0 - square.y0 + y)},
	};
	deform->figures.held++;
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_HOLD,
		.program = deform->held,
		.target = deform->scratch[deform->layers].to[TO_HELD],
		.viewport = {(uint32_t)(both.x0 - square.x0) + x, (uint32_t)(both.y0 - square.y0) + y,
			     (uint32_t)(both.x1 - both.x0), (uint32_t)(both.y1 - both.y0)},
		.images = {deform->rest, deform->bases, deform->planes_of[1][PLANE_OFFSET]},
		.params = &params,
		.params_bytes = sizeof params,
	});
	return STATUS_OK;
}

static bool overlaps(const struct deform *deform, struct post_rect window, size_t first, size_t last)
{
	for (size_t region = first; region <= last; region++)
		if (!post_rect_empty(post_rect_intersect(window, deform_interval_reads(deform, region))))
			return true;
	return false;
}

/* Notes the roofs of a part of an object at rest, in regions first .. last. */
static enum status roof(struct deform *deform, const struct deform_rest *object, struct post_rect posts, size_t first, size_t last)
{
	if (post_rect_empty(posts) || !overlaps(deform, posts, first, last))
		return STATUS_OK;
	TRY(deform_roof_envelopes(deform, object, posts));
	for (size_t region = first; region <= last; region++) {
		struct deform_roof_place place = {.posts = deform_interval_reads(deform, region), .layer = deform->layers};
		place_of(deform->interval, region, &place.x, &place.y);
		TRY(deform_roof_note(deform, object, posts, &place));
	}
	return STATUS_OK;
}

/* Marks the posts of regions first .. last that an object rests on as held, as at the end of a contact. */
static enum status hold_all(struct deform *deform, const struct deform_rest *object, size_t first, size_t last)
{
	const struct deform_contact contact = rest_contact(object);
	struct deform_window windows[DEFORM_WINDOWS_MAX];
	size_t count;
	TRY(deform_windows(deform, &contact, windows, &count));
	for (size_t i = 0; i < count; i++) {
		if (!overlaps(deform, windows[i].read, first, last))
			continue;
		if (object->roofs) {
			TRY(roof(deform, object, post_rect_intersect(windows[i].read, deform_shadow(deform, &contact)), first, last));
			continue;
		}
		deform->figures.resting += object->shape->kind != SOIL_MESH;
		TRY(deform_envelope(deform, &contact, &windows[i], 0));
		for (size_t region = first; region <= last; region++)
			TRY(hold(deform, object, windows[i].read, deform_shadow(deform, &contact), region));
	}
	return STATUS_OK;
}

/* Returns the first post of a column or row of blocks, counted from the first post of the region's rim. Columns -1 and `blocks` are
 * the rim. */
static uint32_t side_of(const struct interval *interval, int64_t column, uint32_t blocks)
{
	uint32_t rim = interval->limits.rim;
	return column < 0 ? 0 : column <= blocks ? rim + SOIL_BLOCK * (uint32_t)column : 2 * rim + SOIL_BLOCK * blocks;
}

/* Marks the posts in and around a region whose blocks are not visited, so that they exchange no soil with others. An earlier drive
 * may have left them steep. Then one post of a pair would change and the other would not. */
static void close_others(struct deform *deform, const struct region *region)
{
	const struct interval *interval = deform->interval;
	const uint32_t x = region->at_x - interval->limits.rim, y = region->at_y - interval->limits.rim;
	const int64_t columns = region->columns, rows = region->rows;
	for (int64_t j = -1; j <= rows; j++) {
		uint32_t y0 = side_of(interval, j, region->rows), y1 = side_of(interval, j + 1, region->rows);
		for (int64_t i = -1, first = -1; i <= columns + 1; i++) {
			bool visited = i > columns || deform_active_is_visited(deform, (struct soil_block){region->x + i, region->y + j});
			if (!visited)
				continue;
			uint32_t x0 = side_of(interval, first, region->columns), x1 = side_of(interval, i, region->columns);
			if (i > first)
				gpu_texture_clear(deform->contacts, deform->layers, (struct gpu_rect){x + x0, y + y0, x1 - x0, y1 - y0},
						  CONTACT_CLOSED);
			first = i + 1;
		}
	}
}

/* Finds the first post of a run in the atlas. */
static void place_of_run(const struct interval *interval, const struct run *run, uint32_t *x, uint32_t *y)
{
	const struct region *region = &interval->regions.regions[run->region];
	*x = region->at_x + SOIL_BLOCK * (uint32_t)(run->first.x - region->x);
	*y = region->at_y + SOIL_BLOCK * (uint32_t)(run->first.y - region->y);
}

/* Copies the blocks of a run from the atlas into `results`. */
static void keep(struct deform *deform, const struct run *run)
{
	const struct interval *interval = deform->interval;
	uint32_t x, y, to = run->slot % RESULTS;
	place_of_run(interval, run, &x, &y);
	for (int plane = 0; plane < PLANES; plane++)
		if (interval->results[plane] != NULL)
			gpu_texture_copy(deform->planes_of[1][plane], deform->layers, x, y, interval->results[plane], run->slot / RESULTS,
					 (struct gpu_rect){to % RESULT_COLUMNS * SOIL_BLOCK, to / RESULT_COLUMNS * SOIL_BLOCK,
							   run->count * SOIL_BLOCK, SOIL_BLOCK});
}

/* Lists the rectangles of regions first .. last, and of their blocks. */
static void describe(const struct deform *deform, size_t first, size_t last, struct slide_atlas *atlas)
{
	const struct interval *interval = deform->interval;
	const int32_t rim = (int32_t)interval->limits.rim;
	atlas->region_count = atlas->block_count = 0;
	atlas->quads = interval->quads;
	atlas->cells = interval->cells;
	for (size_t number = first; number <= last; number++) {
		const struct region *region = &interval->regions.regions[number];
		const int32_t square[4] = {(int32_t)region->at_x - rim, (int32_t)region->at_y - rim,
					   (int32_t)region->columns * SOIL_BLOCK + 2 * rim, (int32_t)region->rows * SOIL_BLOCK + 2 * rim};
		assert(atlas->region_count < ATLAS_MOST);
		memcpy(atlas->regions[atlas->region_count++], square, sizeof square);
		for (uint32_t i = 0; i < region->run_count; i++) {
			const struct run *run = &interval->regions.runs[region->first_run + i];
			for (uint32_t k = 0; k < run->count; k++) {
				uint32_t x, y, word = deform_active_word(deform, (struct soil_block){run->first.x + k, run->first.y});
				place_of_run(interval, run, &x, &y);
				const int32_t block[4] = {(int32_t)(x + k * SOIL_BLOCK), (int32_t)y, (int32_t)word};
				assert(atlas->block_count < ATLAS_MOST);
				memcpy(atlas->blocks[atlas->block_count++], block, sizeof block);
			}
		}
	}
}

/* Tells whether a body that keeps ground out of itself is near some of these regions. */
static bool any_roofs(const struct deform *deform, size_t first, size_t last)
{
	const struct interval *interval = deform->interval;
	for (size_t i = 0; i < interval->object_count; i++) {
		const struct deform_contact contact = rest_contact(&interval->objects[i]);
		if (interval->objects[i].roofs && overlaps(deform, deform_shadow(deform, &contact), first, last))
			return true;
	}
	return false;
}

/* Computes the regions in the atlas, first .. last, and keeps their blocks. */
static enum status compute(struct deform *deform, size_t first, size_t last)
{
	struct interval *interval = deform->interval;
	const struct regions *regions = &interval->regions;
	const struct gpu_rect all = {0, 0, SIDE, SIDE};
	deform->figures.atlases++;
	gpu_texture_clear(deform->contacts, deform->layers, all, 0);
	const bool roofed = any_roofs(deform, first, last);
	if (roofed)
		deform_clear_roofs(deform, deform->layers, all);
	for (size_t i = 0; i < interval->object_count; i++)
		TRY(hold_all(deform, &interval->objects[i], first, last));
	for (size_t region = first; region <= last; region++)
		close_others(deform, &regions->regions[region]);
	struct slide_atlas atlas;
	describe(deform, first, last, &atlas);
	const struct slide_place place = {
		.layer = deform->layers,
		.all = all,
		.written = all,
		.atlas = &atlas,
		.flags = {.words = interval->flags},
		.roofed = roofed,
	};
	TRY(deform_slide_run(deform, &place));
	for (size_t region = first; region <= last; region++)
		for (uint32_t i = 0; i < regions->regions[region].run_count; i++)
			keep(deform, &regions->runs[regions->regions[region].first_run + i]);
	return gpu_check(deform->params.gpu, "sliding");
}

void deform_interval_gather_part(struct deform *deform, size_t region, const struct tile_slot *tiles, size_t count)
{
	struct interval *interval = deform->interval;
	const struct post_rect reads = deform_interval_reads(deform, region);
	unsigned planes = sliding_planes(&deform->params);
	uint32_t x, y;
	assert(region < interval->regions.region_count);
	place_of(interval, region, &x, &y);
	if (interval->begun == region + 1)
		deform_gather_more(deform, reads, deform->layers, x, y, true, planes, tiles, count);
	else
		deform_gather(deform, reads, deform->layers, x, y, true, planes, tiles, count);
	interval->begun = region + 1;
}

enum status deform_interval_gather(struct deform *deform, size_t region, const struct tile_slot *tiles, size_t count)
{
	const struct regions *regions = &deform->interval->regions;
	const uint32_t atlas = regions->regions[region].atlas;
	size_t first = region;
	deform_interval_gather_part(deform, region, tiles, count);
	if (region + 1 < regions->region_count && regions->regions[region + 1].atlas == atlas)
		return STATUS_OK;
	while (first > 0 && regions->regions[first - 1].atlas == atlas)
		first--;
	return compute(deform, first, region);
}

enum status deform_interval_warm(struct deform *deform, const struct soil_shape *shape)
{
	struct interval *interval = deform->interval;
	const double middle = -(4 * SOIL_BLOCK - SOIL_BLOCK / 2) * deform->spacing;
	const struct deform_rest object = {.shape = shape}, roof = {.shape = shape, .pose = {.x = lattice_offset(middle), .y = lattice_offset(middle)}, .roofs = true};
	TRY(deform_regions_one((struct soil_block){-4, -4}, &interval->limits, &interval->regions));
	for (int roofed = 0; roofed <= deform->params.roofs; roofed++) {
		interval->begun = 0;
		interval->object_count = (size_t)roofed;
		interval->objects = &roof;
		TRY(deform_interval_gather(deform, 0, NULL, 0));
	}
	interval->object_count = 0;
	return hold(deform, &object, deform_interval_reads(deform, 0), deform_interval_reads(deform, 0), 0);
}

enum status deform_interval_scatter(struct deform *deform, size_t run, const struct tile_slot *tiles, size_t count)
{
	const struct interval *interval = deform->interval;
	const uint32_t slot = interval->regions.runs[run].slot, at = slot % RESULTS;
	struct scatter_from from = {
		.layer = slot / RESULTS,
		.x = at % RESULT_COLUMNS * SOIL_BLOCK,
		.y = at / RESULT_COLUMNS * SOIL_BLOCK,
	};
	for (int plane = 0; plane < PLANES; plane++)
		from.planes[plane] = interval->results[plane];
	return deform_scatter_from(deform, deform_interval_writes(deform, run), &from, tiles, count);
}

enum status deform_interval_end(struct deform *deform)
{
	return deform_active_visited(deform, deform->interval->flags);
}
