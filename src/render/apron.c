/*
 * The ground beyond the terrain: a frame around it, in one instanced draw. Its heights are the terrain's, mirrored at its edge, so that the
 * terrain does not end as a cliff before the sky. It is no data: depth and numbers have the sky there.
 */
#include <math.h>
#include <string.h>

#include "render/internal.h"

/* Blocks along each of the four sides, and away from it; shaders/apron.vert has both, too. */
#define RENDER_APRON_ALONG 8
#define RENDER_APRON_AWAY 2
/* How far from the terrain its edges' heights level off: a share of its size, or so many times its relief. */
#define LEVEL_SIZE 0.4
#define LEVEL_RELIEF 6.0
#define LEVEL_HEIGHT 0.3 /* to what share of the relief */

static struct gpu_program_request request_of(uint64_t effects, const char *body)
{
	static const enum scene_effect used[] = {EFFECT_TEXTURE, EFFECT_FOG, EFFECT_SPLAT};
	struct gpu_program_request request = {.vertex = "apron.vert", .fragment = "apron.frag"};
	size_t count = 0;
	for (size_t i = 0; i < sizeof used / sizeof *used; i++)
		if (effects >> used[i] & 1)
			request.defines[count++] = scene_effect_row(used[i])->define;
	if (effects & RENDER_ONE_SOIL)
		request.defines[count++] = RENDER_ONE_SOIL_DEFINE;
	request.defines[count] = body;
	return request;
}

static enum status program_of(struct render *render, struct gpu_program **out)
{
	const struct gpu_program_request request = request_of(render->effects, render_body_define(&render->light));
	return gpu_program_get(render->gpu, &request, out);
}

enum status render_apron_warm(struct render *render)
{
	struct gpu_program *program;
	return render->effects >> EFFECT_SKY & 1 ? program_of(render, &program) : STATUS_OK;
}

void render_apron_plan(const struct render_params *params, struct plan *plan)
{
	const struct scene_light light = params->light != NULL ? *params->light : scene_light_default();
	const struct gpu_program_request request = request_of(render_effects(params), render_body_define(&light));
	const char *effect = scene_effect_row(EFFECT_SKY)->name;
	char name[GPU_PROGRAM_NAME];
	if (!(params->effects >> EFFECT_SKY & 1))
		return;
	gpu_program_name(&request, name, sizeof name);
	plan_add(plan, &(struct plan_line){.kind = PLAN_PROGRAM, .unit = PLAN_ONCE, .effect = effect, .object = -1, .amount = 1}, name);
	plan_add(plan, &(struct plan_line){.kind = PLAN_PASS, .unit = PLAN_FRAME, .effect = effect, .object = -1, .amount = 1}, gpu_stage_name(GPU_SKY));
}

static enum status run(struct render *render, struct gpu_texture *base, const struct picture_params *params)
{
	struct gpu_pass pass = {
		.stage = GPU_SKY,
		.target = render->screen->target,
		.viewport = {0, 0, render->screen->width, render->screen->height},
		.textures = {base, [4] = render->ground},
		.params = params,
		.params_bytes = sizeof *params,
		.indices = render->indices,
		.index_count = render_index_count(render_block_cells(&render->extent), false),
		.instances = 4 * RENDER_APRON_ALONG * RENDER_APRON_AWAY,
		.depth_test = true,
		.cull_back = true, /* through a hole of the terrain the sky is seen */
	};
	TRY(program_of(render, &pass.program));
	gpu_pass_run(render->gpu, &pass);
	return STATUS_OK;
}

static void fill(const struct render *render, const struct render_camera *camera, const struct render_axes *axes, struct picture_params *params)
{
	const struct extent *extent = &render->extent;
	const int coarsest = extent_coarsest(extent);
	const double across[2] = {(double)(extent->width - 1) * extent->spacing, (double)(extent->height - 1) * extent->spacing};
	const double relief = fmax(render->high - render->low, 1);
	render_fill_height(render, camera, params);
	params->origin[0] = (float)-camera->eye[0];
	params->origin[1] = (float)-camera->eye[1];
	params->origin[2] = (float)extent_spacing(extent, coarsest);
	params->ground[0] = (float)(((extent->width - 1) >> coarsest));
	params->ground[1] = (float)(((extent->height - 1) >> coarsest));
	params->ground[2] = (float)across[0];
	params->ground[3] = (float)across[1];
	params->detail[0] = (float)fmax(LEVEL_SIZE * fmax(across[0], across[1]), LEVEL_RELIEF * relief);
	params->detail[1] = (float)(LEVEL_HEIGHT * relief);
	memset(params->corner_squares, 0, sizeof params->corner_squares);
	memcpy(params->pattern, (const float[4]){0, 0, 1, (float)log2(1 / axes->focal)}, sizeof params->pattern);
	params->tile[0] = (int32_t)extent->cells;
	params->tile[3] = (int32_t)render_block_cells(extent);
}

enum status render_apron_draw(struct render *render, const struct render_camera *camera, const struct render_axes *axes,
			      const struct render_selection *selection, struct picture_params *params)
{
	if (selection->coarsest == RENDER_NO_SLOT)
		return STATUS_OK;
	if (render->show != NULL)
		TRY(render->show(render->user, selection->coarsest, false));
	fill(render, camera, axes, params);
	return run(render, gpu_slots_get(render->slots, selection->coarsest)->base, params);
}

enum status render_apron_draw_unseen(struct render *render, struct gpu_texture *base, const struct picture_params *params)
{
	return run(render, base, params);
}
