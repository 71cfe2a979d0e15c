/* Makes and destroys what a picture needs: its targets, the mesh of one block, and the ground's textures. */
#include <assert.h>
#include <math.h>
#include <string.h>

#include "render/internal.h"
#include "render/textures.h"

/* Fills the indices of a block. Its vertices are its grid, row by row, then a row for each edge's skirt: south, north, west, east.
 * Triangles are counter-clockwise seen from above, those of skirts seen from outside. */
static uint32_t fill_indices(uint16_t *indices, uint32_t cells, bool skirts)
{
	uint32_t side = cells + 1, count = 0;
	for (uint32_t y = 0; y < cells; y++)
		for (uint32_t x = 0; x < cells; x++) {
			uint16_t a = (uint16_t)(y * side + x), b = (uint16_t)(a + 1);
			uint16_t c = (uint16_t)(a + side), d = (uint16_t)(c + 1);
			const uint16_t cell[6] = {a, b, d, a, d, c};
			memcpy(indices + count, cell, sizeof cell);
			count += 6;
		}
	for (uint32_t edge = 0; skirts && edge < 4; edge++)
		for (uint32_t i = 0; i < cells; i++) {
			uint32_t from = edge == 1 ? cells * side : edge == 3 ? cells : 0;
			uint32_t step = edge < 2 ? 1 : side;
			uint16_t top = (uint16_t)(from + i * step), next = (uint16_t)(top + step);
			uint16_t foot = (uint16_t)(side * side + edge * side + i), after = (uint16_t)(foot + 1);
			const uint16_t outward[6] = {top, foot, after, top, after, next};
			const uint16_t inward[6] = {top, after, foot, top, next, after};
			memcpy(indices + count, edge == 0 || edge == 3 ? outward : inward, sizeof outward);
			count += 6;
		}
	return count;
}

uint32_t render_index_count(uint32_t cells, bool skirts)
{
	return 6 * (cells * cells + (skirts ? 4 * cells : 0));
}

static enum status create_mesh(struct render *render)
{
	uint32_t cells = render_block_cells(&render->extent);
	bool skirts = render->effects >> EFFECT_SKIRTS & 1;
	uint16_t *indices = mem_alloc(render_index_count(cells, true), sizeof *indices);
	if (indices == NULL)
		return fail_memory("the picture's mesh");
	render->index_count = fill_indices(indices, cells, skirts);
	assert(render->index_count == render_index_count(cells, skirts));
	enum status status = gpu_buffer_create(render->gpu, GPU_INDICES, render->index_count * sizeof *indices,
					       indices, &render->indices);
	mem_free(indices);
	return status;
}

static enum status create_ground(struct render *render)
{
	const uint32_t size = RENDER_GROUND_SIZE;
	enum render_ground kinds[RENDER_GROUND_LAYERS];
	uint8_t *texels = mem_alloc((size_t)size * size * RENDER_GROUND_LAYERS, 4);
	if (texels == NULL)
		return fail_memory("the ground's textures");
	render_body_textures(&render->light, kinds);
	enum status status = render_textures_fill(kinds, RENDER_GROUND_LAYERS, texels);
	if (status == STATUS_OK)
		status = gpu_texture_create_mipmapped(render->gpu, GPU_RGBA8, size, RENDER_GROUND_LAYERS, &render->ground);
	for (uint32_t level = 0; status == STATUS_OK && level < gpu_mipmap_levels(size); level++) {
		if (level > 0)
			render_textures_halve(texels, size >> (level - 1), RENDER_GROUND_LAYERS);
		gpu_texture_upload_level(render->ground, level, texels);
	}
	mem_free(texels);
	return status;
}

static enum status create_target(struct render *render)
{
	struct gpu *gpu = render->gpu;
	uint32_t width = render->width, height = render->height, samples = render->samples;
	enum status status = gpu_texture_create(gpu, GPU_SRGB8_ALPHA8, width, height, 0, &render->colour);
	if (status == STATUS_OK && samples > 1)
		status = gpu_texture_create_sampled(gpu, GPU_SRGB8_ALPHA8, width, height, samples, &render->drawn);
	if (status == STATUS_OK)
		status = samples > 1 ? gpu_texture_create_sampled(gpu, GPU_DEPTH32F, width, height, samples, &render->depth)
				     : gpu_texture_create(gpu, GPU_DEPTH32F, width, height, 0, &render->depth);
	if (status == STATUS_OK)
		status = gpu_target_create(gpu, &(struct gpu_attachment){samples > 1 ? render->drawn : render->colour, 0}, 1,
					   (struct gpu_attachment){render->depth, 0}, &render->target);
	if (status == STATUS_OK && samples > 1)
		status = gpu_target_create(gpu, &(struct gpu_attachment){render->colour, 0}, 1, (struct gpu_attachment){NULL, 0},
					   &render->resolved);
	return status;
}

static void destroy_target(struct render *render)
{
	gpu_target_destroy(render->target);
	gpu_target_destroy(render->resolved);
	gpu_texture_destroy(render->drawn);
	gpu_texture_destroy(render->colour);
	gpu_texture_destroy(render->depth);
	render->target = render->resolved = NULL;
	render->drawn = render->colour = render->depth = NULL;
}

enum status render_resize(struct render *render, uint32_t width, uint32_t height)
{
	destroy_target(render);
	render->width = width;
	render->height = height;
	enum status status = create_target(render);
	return status == STATUS_OK && render->objects != NULL ? render_objects_retarget(render) : status;
}

enum status render_check_samples(const struct gpu *gpu, int samples)
{
	const struct gpu_info *info = gpu_info(gpu);
	if (samples <= 1 || (uint32_t)samples <= info->samples_most)
		return STATUS_OK;
	return fail_with(STATUS_INPUT, "view.samples: %d: this driver (%s) draws at most %u a pixel; give that, or less", samples,
			 info->renderer, info->samples_most);
}

enum status render_create(const struct render_params *params, struct render **out)
{
	struct render *render = mem_calloc(1, sizeof *render);
	if (render == NULL)
		return fail_memory("the picture");
	*render = (struct render){
		.gpu = params->gpu,
		.slots = params->slots,
		.extent = *params->extent,
		.reference = params->reference,
		.low = params->low,
		.high = params->high,
		.width = (uint32_t)params->width,
		.height = (uint32_t)params->height,
		.effects = render_effects(params),
		.disturbance = params->disturbance,
		.pixel_error = params->pixel_error,
		.samples = params->samples > 1 ? (uint32_t)params->samples : 1,
		.layers = params->layers,
		.layer = {RENDER_NATURAL, 0, 1},
	};
	render->light = params->light != NULL ? *params->light : scene_light_default();
	render->soils = params->soils;
	enum status status = render_check_samples(render->gpu, params->samples);
	if (status == STATUS_OK)
		status = create_target(render);
	if (status == STATUS_OK)
		status = create_mesh(render);
	if (status == STATUS_OK)
		status = gpu_list_create(render->gpu, RENDER_BLOCKS_ROOM * sizeof(uint32_t), &render->instances);
	if (status == STATUS_OK && (render->effects >> EFFECT_TEXTURE & 1))
		status = create_ground(render);
	if (status == STATUS_OK)
		status = gpu_counter_create(render->gpu, &render->ground_samples);
	if (status == STATUS_OK)
		status = render_objects_create(render, params);
	if (status != STATUS_OK) {
		render_destroy(render);
		return status;
	}
	*out = render;
	return STATUS_OK;
}

void render_destroy(struct render *render)
{
	if (render == NULL)
		return;
	render_objects_destroy(render->objects);
	gpu_counter_destroy(render->ground_samples);
	destroy_target(render);
	gpu_texture_destroy(render->ground);
	gpu_buffer_destroy(render->indices);
	gpu_list_destroy(render->instances);
	mem_free(render->blocks.blocks);
	mem_free(render);
}

void render_show_layer(struct render *render, const struct render_layer *layer)
{
	assert(render->layers && layer->low < layer->high);
	render->layer = *layer;
}

uint64_t render_triangles(const struct render *render)
{
	return render->triangles;
}

uint64_t render_take_overdraw(struct render *render, double *overdraw)
{
	uint64_t samples, frames;
	gpu_counter_take(render->ground_samples, &samples, &frames);
	*overdraw = (double)samples / ((double)render->width * render->height * render->samples);
	return frames;
}

void render_tiles(const struct render *render, struct render_tiles *tiles)
{
	*tiles = render->tiles;
}

void render_read_into(struct render *render, struct gpu_staging *staging)
{
	gpu_texture_read_into(render->colour, 0, (struct gpu_rect){0, 0, render->width, render->height}, staging, 0);
}

enum status render_read(struct render *render, uint8_t *pixels, float *depth)
{
	const struct gpu_rect all = {0, 0, render->width, render->height};
	const size_t count = (size_t)render->width * render->height;
	assert(depth == NULL || render->samples <= 1);
	if (pixels != NULL)
		gpu_texture_read(render->colour, 0, all, pixels);
	if (depth != NULL)
		gpu_texture_read(render->depth, 0, all, depth);
	for (size_t i = 0; depth != NULL && i < count; i++) /* the buffer has near / distance; 0: infinitely far */
		depth[i] = depth[i] > 0 ? (float)RENDER_NEAR / depth[i] : INFINITY;
	return gpu_check(render->gpu, "reading the picture back");
}

enum status render_write_png(struct render *render, const char *path)
{
	uint8_t *pixels = mem_alloc((size_t)render->width * render->height, 4);
	if (pixels == NULL)
		return fail_memory("the picture's pixels");
	gpu_texture_read(render->colour, 0, (struct gpu_rect){0, 0, render->width, render->height}, pixels);
	enum status status = gpu_check(render->gpu, "reading the picture back");
	if (status == STATUS_OK)
		status = render_png_write(path, pixels, render->width, render->height);
	mem_free(pixels);
	return status;
}
