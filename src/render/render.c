/* Makes and destroys what pictures need: the mesh of one block, the ground's textures, and a screen of their size. */
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
	TRY_MEM(indices, "the picture's mesh");
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
	TRY_MEM(texels, "the ground's textures");
	render_body_textures(&render->light, kinds);
	enum status status;
	TRY_OR(done, render_textures_fill(kinds, RENDER_GROUND_LAYERS, texels));
	TRY_OR(done, gpu_texture_create_mipmapped(render->gpu, GPU_RGBA8, size, RENDER_GROUND_LAYERS, &render->ground));
	for (uint32_t level = 0; level < gpu_mipmap_levels(size); level++) {
		if (level > 0)
			render_textures_halve(texels, size >> (level - 1), RENDER_GROUND_LAYERS);
		gpu_texture_upload_level(render->ground, level, texels);
	}
done:
	mem_free(texels);
	return status;
}

enum status render_resize(struct render *render, uint32_t width, uint32_t height)
{
	struct render_screen *screen = &render->own;
	render_screen_finish(screen);
	return render_screen_init(render, width, height, screen->samples, screen);
}

enum status render_check_samples(const struct gpu *gpu, int samples)
{
	const struct gpu_info *info = gpu_info(gpu);
	if (samples <= 1 || (uint32_t)samples <= info->samples_most)
		return STATUS_OK;
	return fail_with(STATUS_INPUT, "view.samples: %d: this driver (%s) draws at most %u a pixel; give that, or less", samples,
			 info->renderer, info->samples_most);
}

static enum status make(struct render *render, const struct render_params *params)
{
	TRY(render_check_samples(render->gpu, params->samples));
	TRY(create_mesh(render));
	TRY(gpu_list_create(render->gpu, RENDER_BLOCKS_ROOM * sizeof(uint32_t), &render->instances));
	if (render->effects >> EFFECT_TEXTURE & 1)
		TRY(create_ground(render));
	TRY(gpu_counter_create(render->gpu, &render->ground_samples));
	TRY(render_shade_create(render));
	TRY(render_objects_create(render, params));
	TRY(render_grains_create(render, params));
	TRY(render_heaps_create(render, params));
	return render_screen_init(render, (uint32_t)params->width, (uint32_t)params->height, params->samples > 1 ? (uint32_t)params->samples : 1,
				  &render->own);
}

enum status render_create(const struct render_params *params, struct render **out)
{
	struct render *render = mem_calloc(1, sizeof *render);
	TRY_MEM(render, "the picture");
	*render = (struct render){
		.gpu = params->gpu,
		.slots = params->slots,
		.extent = *params->extent,
		.reference = params->reference,
		.low = params->low,
		.high = params->high,
		.effects = render_effects(params),
		.disturbance = params->disturbance,
		.heals = params->heals,
		.vegetation = params->vegetation,
		.cover_by_class = params->cover_by_class,
		.imagery = params->effects >> EFFECT_IMAGERY & 1 ? params->imagery : NULL,
		.pixel_error = params->pixel_error,
		.layers = params->layers,
		.measures = params->measures,
		.classes = params->classes,
		.truths = {!params->only_truth, params->truth || params->only_truth},
		.truth = params->only_truth,
		.show = params->show,
		.user = params->user,
		.layer = {RENDER_NATURAL, 0, 1},
	};
	render->screen = &render->own;
	render->light = params->light != NULL ? *params->light : scene_light_default();
	render->soils = params->soils;
	enum status status = make(render, params);
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
	render_grains_destroy(render->grains);
	render_heaps_destroy(render->heaps);
	render_shade_destroy(render->shade);
	gpu_counter_destroy(render->ground_samples);
	render_screen_finish(&render->own);
	gpu_texture_destroy(render->ground);
	gpu_buffer_destroy(render->indices);
	gpu_list_destroy(render->instances);
	mem_free_all(render->blocks.blocks, render);
}

void render_show_layer(struct render *render, const struct render_layer *layer)
{
	assert(render->layers && layer->low < layer->high);
	render->layer = *layer;
}

void render_set_truth(struct render *render, bool truth)
{
	assert(render->truths[truth]);
	render->truth = truth;
}

void render_move_sun(struct render *render, double azimuth, double height)
{
	render->light.azimuth = azimuth;
	render->light.height = height;
}

void render_expose_by(struct render *render, enum scene_exposure exposure, double ev)
{
	render->light.exposure = exposure;
	render->light.ev = ev;
}

double render_exposed(const struct render *render)
{
	return render->exposed;
}

uint64_t render_triangles(const struct render *render)
{
	return render->triangles;
}

uint64_t render_take_overdraw(struct render *render, double *overdraw)
{
	uint64_t samples, frames;
	gpu_counter_take(render->ground_samples, &samples, &frames);
	*overdraw = (double)samples / ((double)render->own.width * render->own.height * render->own.samples);
	return frames;
}

void render_tiles(const struct render *render, struct render_tiles *tiles)
{
	*tiles = render->tiles;
}

void render_read_into(struct render *render, enum scene_image image, struct gpu_staging *staging)
{
	const struct render_screen *screen = render->screen;
	struct gpu_texture *depth = screen->single != NULL ? screen->single : screen->depth;
	struct gpu_texture *texture = image == SCENE_IMAGE_DEPTH ? depth : image == SCENE_IMAGE_COLOUR ? screen->colour : image == SCENE_IMAGE_LINEAR ? screen->light : screen->numbers;
	gpu_texture_read_into(texture, 0, (struct gpu_rect){0, 0, render->screen->width, render->screen->height}, staging, 0);
}

void render_depths(float *depth, size_t count)
{
	for (size_t i = 0; i < count; i++) /* the texture has near / distance; 0: nothing was drawn; less than 1e-11: the ground beyond the terrain, or the sky (shaders/apron.vert, sky.vert) */
		depth[i] = depth[i] > 1e-11f ? (float)RENDER_NEAR / depth[i] : INFINITY;
}

enum status render_read(struct render *render, uint8_t *pixels, float *depth)
{
	const struct gpu_rect all = {0, 0, render->screen->width, render->screen->height};
	const size_t count = (size_t)render->screen->width * render->screen->height;
	assert(depth == NULL || render->screen->samples <= 1);
	if (pixels != NULL)
		gpu_texture_read(render->screen->colour, 0, all, pixels);
	if (depth != NULL)
		gpu_texture_read(render->screen->depth, 0, all, depth);
	if (depth != NULL)
		render_depths(depth, count);
	return gpu_check(render->gpu, "reading the picture back");
}

enum status render_write_png(struct render *render, const char *path)
{
	uint8_t *pixels = mem_alloc((size_t)render->screen->width * render->screen->height, 4);
	TRY_MEM(pixels, "the picture's pixels");
	gpu_texture_read(render->screen->colour, 0, (struct gpu_rect){0, 0, render->screen->width, render->screen->height}, pixels);
	enum status status;
	TRY_OR(done, gpu_check(render->gpu, "reading the picture back"));
	TRY_OR(done, chart_png_write(path, pixels, render->screen->width, render->screen->height));
done:
	mem_free(pixels);
	return status;
}
