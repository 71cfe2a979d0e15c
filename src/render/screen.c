/* The textures that a picture is drawn into. One render draws into screens of several sizes, in turn. */
#include "render/internal.h"

static enum status create_target(struct render *render, struct render_screen *screen)
{
	struct gpu *gpu = render->gpu;
	uint32_t width = screen->width, height = screen->height, samples = screen->samples;
	TRY(gpu_texture_create(gpu, GPU_SRGB8_ALPHA8, width, height, 0, &screen->colour));
	TRY(render_expose_screen(render, screen));
	struct gpu_texture *shown = screen->light != NULL ? screen->light : screen->colour;
	if (samples > 1)
		TRY(gpu_texture_create_sampled(gpu, render_light_format(render->effects), width, height, samples, &screen->drawn));
	TRY(samples > 1 ? gpu_texture_create_sampled(gpu, GPU_DEPTH32F, width, height, samples, &screen->depth)
			: gpu_texture_create(gpu, GPU_DEPTH32F, width, height, 0, &screen->depth));
	TRY(gpu_target_create(gpu, &(struct gpu_attachment){samples > 1 ? screen->drawn : shown, 0}, 1,
			      (struct gpu_attachment){screen->depth, 0}, &screen->target));
	if (samples <= 1)
		return STATUS_OK;
	return gpu_target_create(gpu, &(struct gpu_attachment){shown, 0}, 1, (struct gpu_attachment){NULL, 0}, &screen->resolved);
}

enum status render_screen_init(struct render *render, uint32_t width, uint32_t height, uint32_t samples, struct render_screen *screen)
{
	*screen = (struct render_screen){.width = width, .height = height, .samples = samples};
	TRY(create_target(render, screen));
	if (!render_objects_cast(render->objects))
		return STATUS_OK;
	const enum gpu_format format = render_light_format(render->effects);
	struct gpu_texture *shown = screen->light != NULL ? screen->light : screen->colour;
	TRY(samples > 1 ? gpu_texture_create_sampled(render->gpu, format, width, height, samples, &screen->umbra)
			: gpu_texture_create(render->gpu, format, width, height, 0, &screen->umbra));
	const struct gpu_attachment colours[2] = {{screen->drawn != NULL ? screen->drawn : shown, 0}, {screen->umbra, 0}};
	TRY(gpu_target_create(render->gpu, colours, 2, (struct gpu_attachment){screen->depth, 0}, &screen->ground));
	return gpu_target_create(render->gpu, colours, 2, (struct gpu_attachment){NULL, 0}, &screen->over);
}

enum status render_screen_measures(struct render *render, struct render_screen *screen)
{
	if (screen->numbers != NULL)
		return STATUS_OK;
	TRY(gpu_texture_create(render->gpu, GPU_RGBA32F, screen->width, screen->height, 0, &screen->numbers));
	if (screen->samples > 1)
		TRY(gpu_texture_create(render->gpu, GPU_DEPTH32F, screen->width, screen->height, 0, &screen->single));
	return gpu_target_create(render->gpu, &(struct gpu_attachment){screen->numbers, 0}, 1,
				 (struct gpu_attachment){screen->single != NULL ? screen->single : screen->depth, 0}, &screen->measure);
}

void render_screen_finish(struct render_screen *screen)
{
	gpu_target_destroy(screen->over);
	gpu_target_destroy(screen->ground);
	gpu_texture_destroy(screen->umbra);
	gpu_target_destroy(screen->measure);
	gpu_texture_destroy(screen->numbers);
	gpu_texture_destroy(screen->single);
	gpu_target_destroy(screen->target);
	gpu_target_destroy(screen->resolved);
	render_expose_screen_finish(screen);
	gpu_texture_destroy(screen->drawn);
	gpu_texture_destroy(screen->colour);
	gpu_texture_destroy(screen->depth);
	*screen = (struct render_screen){.width = screen->width, .height = screen->height, .samples = screen->samples};
}
