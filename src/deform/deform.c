/*
 * Copies posts from tiles into a window (gather), runs the stages there, and copies the results to the tiles (scatter).
 *
 * Invariant: a window's layer holds the ground as the tiles had it before the contact. Nothing is written to a tile before
 * deform_scatter. So the windows of one contact do not see each other's results.
 */
#include "deform/deform.h"

#include <assert.h>

#include "deform/internal.h"

/* Makes buffers, layers and what the model needs. */
static enum status make(struct deform *deform)
{
	const bool conserves = deform_conserves(deform->params.model);
	TRY(gpu_buffer_create(deform->params.gpu, GPU_STORAGE, sizeof(struct deform_tally), NULL, &deform->tally));
	TRY(deform_need_layers(deform, 1, SIDE));
	if (deform->params.batches)
		TRY(deform_batch_create(deform));
	if (!conserves)
		return STATUS_OK;
	TRY(deform_spread_create(deform));
	TRY(deform_active_create(deform));
	return deform_interval_create(deform);
}

enum status deform_create(const struct deform_params *params, struct deform **out)
{
	struct deform *deform = mem_calloc(1, sizeof *deform);
	TRY_MEM(deform, "deformation");
	assert(!deform_model_row(params->model)->bears);
	deform->params = *params;
	deform->params.batches = params->batches && deform_model_row(params->model)->batch != NULL && gpu_info(params->gpu)->vertices_pass;
	deform->planes = deform_planes(params->model, params->disturbance, deform_marks(params));
	deform->spacing = extent_spacing(params->extent, params->level);
	deform->reach = deform_reach(params);
	deform->border = deform_border(params);
	if (deform_conserves(params->model))
		deform_slide_prepare(deform);
	enum status status = make(deform);
	if (status != STATUS_OK) {
		deform_destroy(deform);
		return status;
	}
	*out = deform;
	return STATUS_OK;
}

void deform_destroy(struct deform *deform)
{
	if (deform == NULL)
		return;
	deform_interval_destroy(deform);
	deform_batch_destroy(deform);
	deform_active_destroy(deform->active);
	deform_drop_layers(deform);
	deform_facets_destroy(deform->facets);
	gpu_buffer_destroy(deform->laying);
	gpu_buffer_destroy(deform->tally);
	mem_free(deform);
}

/* Finds the posts that a tile and a rectangle share: their place in the tile and their place in the window. Returns false if
 * they share none. */
static bool shared(const struct deform *deform, struct tile tile, struct post_rect rect, struct post_rect window,
		   struct gpu_rect *in_tile, struct gpu_rect *in_window)
{
	struct post_rect own = tile_post_rect(deform->params.extent, tile);
	struct post_rect both = post_rect_intersect(own, rect);
	if (post_rect_empty(both))
		return false;
	uint32_t width = (uint32_t)(both.x1 - both.x0), height = (uint32_t)(both.y1 - both.y0);
	*in_tile = (struct gpu_rect){(uint32_t)(both.x0 - own.x0), (uint32_t)(both.y0 - own.y0), width, height};
	*in_window = (struct gpu_rect){(uint32_t)(both.x0 - window.x0), (uint32_t)(both.y0 - window.y0), width, height};
	return true;
}

/* Beyond the world there is no data. */
static void clear_beyond(struct deform *deform, struct post_rect read, uint32_t layer, uint32_t x, uint32_t y, bool atlas, unsigned planes)
{
	struct gpu_rect all = {x, y, (uint32_t)(read.x1 - read.x0), (uint32_t)(read.y1 - read.y0)};
	const struct post_rect extent = {0, 0, extent_tiles_x(deform->params.extent, deform->params.level) *
							      (int64_t)deform->params.extent->cells + 1,
					extent_tiles_y(deform->params.extent, deform->params.level) *
							      (int64_t)deform->params.extent->cells + 1};
	bool beyond = read.x0 < 0 || read.y0 < 0 || read.x1 > extent.x1 || read.y1 > extent.y1;
	for (int plane = 0; beyond && plane < PLANES; plane++)
		if (planes & PLANE_BIT(plane))
			gpu_texture_clear(deform->planes_of[atlas][plane], layer, all, 0);
	if (beyond)
		gpu_texture_clear(deform->bases, layer, all, BASE_NODATA);
}

void deform_gather(struct deform *deform, struct post_rect read, uint32_t layer, uint32_t x, uint32_t y, bool atlas,
		   unsigned planes, const struct tile_slot *tiles, size_t count)
{
	clear_beyond(deform, read, layer, x, y, atlas, planes);
	deform_gather_more(deform, read, layer, x, y, atlas, planes, tiles, count);
}

void deform_gather_more(struct deform *deform, struct post_rect read, uint32_t layer, uint32_t x, uint32_t y, bool atlas,
			unsigned planes, const struct tile_slot *tiles, size_t count)
{
	for (size_t i = 0; i < count; i++) {
		struct gpu_rect from, to;
		if (!shared(deform, tiles[i].tile, read, read, &from, &to))
			continue;
		to.x += x;
		to.y += y;
		const struct gpu_slot *slot = gpu_slots_get(deform->params.slots, tiles[i].slot);
		gpu_texture_copy(slot->base, 0, from.x, from.y, deform->bases, layer, to);
		if (deform->classes != NULL && slot->classes != NULL)
			gpu_texture_copy(slot->classes, 0, from.x, from.y, deform->classes, layer, to);
		else if (deform->classes != NULL)
			gpu_texture_clear(deform->classes, layer, to, 0);
		for (int plane = 0; plane < PLANES; plane++) {
			if (!(planes & PLANE_BIT(plane)))
				continue;
			struct gpu_texture *into = deform->planes_of[atlas][plane], *held = slot->planes[plane];
			if (held != NULL)
				gpu_texture_copy(held, 0, from.x, from.y, into, layer, to);
			else
				gpu_texture_clear(into, layer, to, 0);
		}
	}
}

/* Gathers a window. Of a window in parts it gathers one part. Returns true if all parts are there. */
static bool gather(struct deform *deform, const struct deform_window *window, uint32_t layer, const struct tile_slot *tiles,
		   size_t count)
{
	const struct post_rect read = window->read, whole = deform_whole(deform, window).read;
	assert(whole.x1 - whole.x0 <= deform->side && whole.y1 - whole.y0 <= deform->side);
	assert(layer < deform->layers);
	deform_gather(deform, read, layer, (uint32_t)(read.x0 - whole.x0), (uint32_t)(read.y0 - whole.y0), false, deform->planes, tiles,
		      count);
	return window->part + 1 >= window->parts;
}

static uint32_t layer_of(const struct deform_window *window, uint32_t layer)
{
	return window->parts > 0 ? 0 : layer;
}

enum status deform_compute(struct deform *deform, const struct deform_contact *contact,
			   const struct deform_window *window, uint32_t layer, const struct tile_slot *tiles,
			   size_t count)
{
	if (!gather(deform, window, layer_of(window, layer), tiles, count))
		return STATUS_OK;
	const struct deform_window whole = deform_whole(deform, window);
	TRY(deform_run_stages(deform, contact, &whole, layer_of(window, layer)));
	return gpu_check(deform->params.gpu, "deformation");
}

enum status deform_scatter_from(struct deform *deform, struct post_rect write, const struct scatter_from *scatter,
				const struct tile_slot *tiles, size_t count)
{
	for (size_t i = 0; i < count; i++) {
		struct gpu_rect to, from;
		if (!shared(deform, tiles[i].tile, write, write, &to, &from))
			continue;
		TRY(gpu_slots_deform(deform->params.slots, tiles[i].slot));
		const struct gpu_slot *slot = gpu_slots_get(deform->params.slots, tiles[i].slot);
		for (int plane = 0; plane < PLANES; plane++)
			if (scatter->planes[plane] != NULL)
				gpu_texture_copy(scatter->planes[plane], scatter->layer, scatter->x + from.x, scatter->y + from.y,
						 slot->planes[plane], 0, to);
	}
	return gpu_check(deform->params.gpu, "deformation");
}

enum status deform_scatter(struct deform *deform, const struct deform_window *window, uint32_t layer,
			   const struct tile_slot *tiles, size_t count)
{
	const struct post_rect read = deform_whole(deform, window).read;
	struct scatter_from from = {.layer = layer_of(window, layer), .x = (uint32_t)(window->write.x0 - read.x0),
				    .y = (uint32_t)(window->write.y0 - read.y0)};
	for (int plane = 0; plane < PLANES; plane++)
		from.planes[plane] = deform->planes_of[deform->scratch[from.layer].now[plane]][plane];
	return deform_scatter_from(deform, window->write, &from, tiles, count);
}

enum status deform_tally(struct deform *deform, struct deform_tally *tally)
{
	gpu_buffer_read(deform->tally, 0, sizeof *tally, tally);
	return gpu_check(deform->params.gpu, "what deformation counts");
}

enum status deform_restore(struct deform *deform, const struct deform_tally *tally)
{
	enum status status = deform_forget_active(deform);
	gpu_buffer_write(deform->tally, 0, sizeof *tally, tally);
	TRY(status);
	return gpu_check(deform->params.gpu, "going back");
}

void deform_tally_read_into(struct deform *deform, struct gpu_staging *staging, size_t offset)
{
	gpu_buffer_read_into(deform->tally, 0, sizeof(struct deform_tally), staging, offset);
}
