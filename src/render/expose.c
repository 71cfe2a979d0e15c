/*
 * A frame that is drawn as light, and exposed when it is whole. The light's luminance is summed in cells, in a fixed order, and the
 * cells by the CPU. So an automatic exposure follows from this frame alone, and is the same each time.
 */
#include <math.h>

#include "render/internal.h"

#define GREY 0.18          /* what the mean of a frame becomes: a middle grey, as cameras take it */
#define LEAST 0x1p-10      /* range of an automatic exposure */
#define MOST 0x1p16

static bool draws_light(uint64_t effects)
{
	return effects >> EFFECT_LIGHT & 1;
}

const char *render_light_define(uint64_t effects)
{
	return draws_light(effects) ? scene_effect_row(EFFECT_LIGHT)->define : NULL;
}

enum gpu_format render_light_format(uint64_t effects)
{
	return draws_light(effects) ? GPU_RGBA32F : GPU_SRGB8_ALPHA8;
}

/* --- the screen --- */

enum status render_expose_screen(struct render *render, struct render_screen *screen)
{
	const struct gpu_attachment none = {NULL, 0};
	struct gpu *gpu = render->gpu;
	if (!draws_light(render->effects))
		return STATUS_OK;
	TRY(gpu_texture_create(gpu, GPU_RGBA32F, screen->width, screen->height, 0, &screen->light));
	TRY(gpu_texture_create(gpu, GPU_R32F, RENDER_METER, RENDER_METER, 0, &screen->meter));
	TRY(gpu_target_create(gpu, &(struct gpu_attachment){screen->colour, 0}, 1, none, &screen->exposed));
	return gpu_target_create(gpu, &(struct gpu_attachment){screen->meter, 0}, 1, none, &screen->metered);
}

void render_expose_screen_finish(struct render_screen *screen)
{
	gpu_target_destroy(screen->metered);
	gpu_target_destroy(screen->exposed);
	gpu_texture_destroy(screen->meter);
	gpu_texture_destroy(screen->light);
}

/* --- programs and plan --- */

static const struct gpu_program_request expose_request = {.vertex = "full.vert", .fragment = "expose.frag"};
static const struct gpu_program_request meter_request = {.vertex = "full.vert", .fragment = "meter.frag"};

enum status render_expose_warm(struct render *render)
{
	struct gpu_program *program;
	if (!draws_light(render->effects))
		return STATUS_OK;
	TRY(gpu_program_get(render->gpu, &meter_request, &program));
	return gpu_program_get(render->gpu, &expose_request, &program);
}

void render_expose_plan(const struct render_params *params, struct plan *plan)
{
	const struct gpu_program_request *requests[] = {&expose_request, &meter_request};
	const uint64_t pixels = (uint64_t)params->width * (uint64_t)params->height;
	struct plan_line line = {.kind = PLAN_PROGRAM, .unit = PLAN_ONCE, .effect = scene_effect_row(EFFECT_LIGHT)->name, .object = -1, .amount = 1};
	char name[GPU_PROGRAM_NAME];
	if (!draws_light(params->effects))
		return;
	for (int i = 0; i < 2; i++) {
		gpu_program_name(requests[i], name, sizeof name);
		plan_add(plan, &line, name);
	}
	line.kind = PLAN_TEXTURE;
	line.bytes = gpu_format_bytes(GPU_RGBA32F) * pixels;
	plan_add(plan, &line, "light");
	line.bytes = RENDER_METER_BYTES;
	plan_add(plan, &line, "light meter");
	line = (struct plan_line){.kind = PLAN_PASS, .unit = PLAN_FRAME, .effect = line.effect, .object = -1, .amount = 1};
	for (int i = 0; i < 2; i++)
		plan_add(plan, &line, gpu_stage_name(GPU_EXPOSE));
}

/* --- a frame --- */

/* The colour's way back through the film's curve of lib/tone.glsl. */
void render_expose_background(const struct render *render, float rgba[4])
{
	for (int i = 0; i < 3 && draws_light(render->effects); i++) {
		const double y = (double)rgba[i], a = 2.51 - 2.43 * y, b = 0.03 - 0.59 * y, c = -0.14 * y;
		rgba[i] = (float)((-b + sqrt(b * b - 4 * a * c)) / (2 * a));
	}
}

static void run(struct render *render, struct gpu_program *program, struct gpu_target *target, struct gpu_rect viewport, const void *params, size_t bytes)
{
	gpu_pass_run(render->gpu, &(struct gpu_pass){
		.stage = GPU_EXPOSE,
		.program = program,
		.target = target,
		.viewport = viewport,
		.textures = {render->screen->light},
		.params = params,
		.params_bytes = bytes,
	});
}

/* Sums the frame's light, and finds its mean if that is asked for. */
static enum status meter(struct render *render, bool asked, double *mean)
{
	const struct render_screen *screen = render->screen;
	const struct gpu_rect cells = {0, 0, RENDER_METER, RENDER_METER};
	const int32_t size[4] = {(int32_t)screen->width, (int32_t)screen->height, RENDER_METER, RENDER_METER};
	float sums[RENDER_METER * RENDER_METER];
	struct gpu_program *program;
	double sum = 0;
	TRY(gpu_program_get(render->gpu, &meter_request, &program));
	run(render, program, screen->metered, cells, size, sizeof size);
	if (!asked)
		return STATUS_OK;
	gpu_texture_read(screen->meter, 0, cells, sums);
	TRY(gpu_check(render->gpu, "reading the frame's light"));
	for (size_t i = 0; i < RENDER_METER * RENDER_METER; i++)
		sum += (double)sums[i];
	*mean = sum / ((double)screen->width * screen->height);
	return STATUS_OK;
}

enum status render_expose(struct render *render)
{
	const struct render_screen *screen = render->screen;
	const bool by_frame = render->light.exposure == SCENE_EXPOSURE_AUTO;
	struct gpu_program *program;
	double mean = 0;
	render->exposed = render_body_exposure(&render->light);
	if (!draws_light(render->effects))
		return STATUS_OK;
	TRY(meter(render, by_frame, &mean));
	if (by_frame)
		render->exposed = exp2(render->light.ev) * (mean > 0 ? fmin(fmax(GREY / mean, LEAST), MOST) : 1);
	TRY(gpu_program_get(render->gpu, &expose_request, &program));
	const float params[4] = {(float)render->exposed, 0, 0, 0};
	run(render, program, screen->exposed, (struct gpu_rect){0, 0, screen->width, screen->height}, params, sizeof params);
	return STATUS_OK;
}
