/*
 * The programs that draw a picture, and its plan. Each kind of tile that there may be has a variant. It has only the code of the
 * effects that the view names.
 */
#include <string.h>

#include "render/imagery.h"
#include "render/textures.h"

/* By pixel error each draw has its own reaches. All code that changes a mesh with the distance must read them. */
static bool asks_reaches(uint64_t effects, bool by_error)
{
	return by_error && (effects & (EFFECT_BIT(EFFECT_GEOMORPH) | EFFECT_BIT(EFFECT_SKIRTS)));
}

uint64_t render_effects(const struct render_params *params)
{
	bool classes = params->soils != NULL && (params->effects >> EFFECT_TEXTURE & 1);
	bool casts = render_objects_are_cast(params);
	uint64_t one = classes && params->one_soil ? EFFECT_BIT(EFFECT_SPLAT) | RENDER_ONE_SOIL : 0;
	return one | (params->effects & ~((classes ? 0 : EFFECT_BIT(EFFECT_SPLAT)) | (casts ? 0 : EFFECT_BIT(EFFECT_SHADOW))));
}

static bool is_interpolated(unsigned variant)
{
	return variant == RENDER_LEVEL0 || variant == RENDER_SMOOTH;
}

/* The planes beside the offset that a picture shows. */
struct shown {
	bool disturbance, heals, vegetation, by_class;
};

static struct gpu_program_request request_of(uint64_t effects, const char *body, struct shown shown, bool by_error, unsigned variant)
{
	struct gpu_program_request request = {.vertex = "terrain.vert", .fragment = "terrain.frag"};
	size_t count = 0;
	for (int effect = 0; effect < EFFECT_COUNT; effect++) {
		const char *define = scene_effect_row((enum scene_effect)effect)->define;
		if ((effects >> effect & 1) && define[0] != '\0')
			request.defines[count++] = define;
	}
	if (effects & RENDER_ONE_SOIL)
		request.defines[count++] = RENDER_ONE_SOIL_DEFINE;
	if (asks_reaches(effects, by_error))
		request.defines[count++] = scene_effect_row(EFFECT_PIXEL_ERROR)->define;
	const bool offset = variant == RENDER_OFFSET || variant == RENDER_LEVEL0;
	if (offset)
		request.defines[count++] = "OFFSET";
	if (offset && (shown.disturbance || shown.heals))
		request.defines[count++] = "DISTURBANCE";
	if (offset && shown.heals)
		request.defines[count++] = "HEALS";
	if (shown.vegetation)
		request.defines[count++] = shown.by_class ? "VEGETATION 2" : "VEGETATION 1";
	if (is_interpolated(variant))
		request.defines[count++] = "LEVEL0";
	request.defines[count] = body;
	return request;
}

void render_request_truth(struct gpu_program_request *request)
{
	const char *detail = scene_effect_row(EFFECT_DETAIL)->define;
	size_t count = 0;
	while (count < GPU_DEFINES_MAX && request->defines[count] != NULL && strcmp(request->defines[count], detail) != 0)
		count++;
	assert(count < GPU_DEFINES_MAX);
	request->defines[count] = "TRUTH";
}

static struct gpu_program_request picture_request_of(uint64_t effects, const char *body, struct shown shown, bool by_error, bool truth, unsigned variant)
{
	struct gpu_program_request request = request_of(effects, body, shown, by_error, variant);
	if (truth)
		render_request_truth(&request);
	return request;
}

/* The request for false colours. It has the effects that change the ground's shape, and shadows, but
 * not what else changes its look. */
static struct gpu_program_request layer_request_of(const struct render *render, unsigned variant)
{
	uint64_t shape = render->effects & (EFFECT_BIT(EFFECT_GEOMORPH) | EFFECT_BIT(EFFECT_SKIRTS) | EFFECT_BIT(EFFECT_SHADOW));
	struct gpu_program_request request = request_of(shape, NULL, (struct shown){render->disturbance, render->heals, false, false}, render->pixel_error > 0, variant);
	size_t count = 0;
	while (request.defines[count] != NULL)
		count++;
	assert(count < GPU_DEFINES_MAX);
	request.defines[count] = "LAYER";
	return request;
}

/* The request for numbers: normals, heights and classes. */
static struct gpu_program_request measure_request_of(uint64_t effects, bool classes, bool by_error, unsigned variant)
{
	uint64_t shape = effects & (EFFECT_BIT(EFFECT_GEOMORPH) | EFFECT_BIT(EFFECT_SKIRTS));
	struct gpu_program_request request = request_of(shape, NULL, (struct shown){false, false, false, false}, by_error, variant);
	size_t count = 0;
	while (request.defines[count] != NULL)
		count++;
	assert(count < GPU_DEFINES_MAX);
	request.fragment = "measure.frag";
	if (classes)
		request.defines[count] = "CLASSES";
	return request;
}

/* The request for maps of shadows. */
static struct gpu_program_request shade_request_of(uint64_t effects, bool by_error, unsigned variant)
{
	struct gpu_program_request request = measure_request_of(effects, false, by_error, variant);
	request.fragment = "depth.frag";
	return request;
}

static struct gpu_program_request sky_of(uint64_t effects, const char *body)
{
	const char *light = render_light_define(effects);
	return (struct gpu_program_request){.vertex = "sky.vert", .fragment = "sky.frag", .defines = {light != NULL ? light : body, light != NULL ? body : NULL}};
}

static bool has_variant(unsigned variant, bool deformed, bool divided, bool smooth)
{
	switch (variant) {
	case RENDER_OFFSET:
		return deformed;
	case RENDER_LEVEL0:
		return deformed && divided;
	case RENDER_SMOOTH:
		return smooth;
	default:
		return true;
	}
}

static enum status measure_program(struct render *render, unsigned variant, struct gpu_program **out)
{
	struct gpu_program **program = &render->measure_programs[variant];
	if (*program == NULL) {
		const struct gpu_program_request request =
			measure_request_of(render->effects, render->classes, render->pixel_error > 0, variant);
		TRY(gpu_program_get(render->gpu, &request, program));
	}
	*out = *program;
	return STATUS_OK;
}

static enum status shade_program(struct render *render, unsigned variant, struct gpu_program **out)
{
	struct gpu_program **program = &render->shade_programs[variant];
	if (*program == NULL) {
		const struct gpu_program_request request = shade_request_of(render->effects, render->pixel_error > 0, variant);
		TRY(gpu_program_get(render->gpu, &request, program));
	}
	*out = *program;
	return STATUS_OK;
}

enum status render_tile_program(struct render *render, unsigned variant, struct gpu_program **out)
{
	if (render->shading != NULL)
		return shade_program(render, variant, out);
	if (render->measuring)
		return measure_program(render, variant, out);
	bool natural = render->layer.kind == RENDER_NATURAL;
	struct gpu_program **program = natural ? &render->tile_programs[render->truth][variant] : &render->layer_programs[variant];
	if (*program == NULL) {
		const char *body = render_body_define(&render->light);
		struct gpu_program_request request = natural ? picture_request_of(render->effects, body, (struct shown){render->disturbance, render->heals, render->vegetation != NULL, render->cover_by_class},
										  render->pixel_error > 0, render->truth, variant) :
							       layer_request_of(render, variant);
		TRY(gpu_program_get(render->gpu, &request, program));
	}
	*out = *program;
	return STATUS_OK;
}

enum status render_sky_program(struct render *render, struct gpu_program **out)
{
	struct gpu_program_request sky = sky_of(render->effects, render_body_define(&render->light));
	return gpu_program_get(render->gpu, &sky, out);
}

static enum status warm_variant(struct render *render, unsigned variant)
{
	struct gpu_program *program;
	TRY(render_tile_program(render, variant, &program));
	if (render->measures && !is_interpolated(variant))
		TRY(measure_program(render, variant, &program));
	if (render->shade != NULL && !is_interpolated(variant))
		TRY(shade_program(render, variant, &program));
	if (!render->layers)
		return STATUS_OK;
	const struct render_layer shown = render->layer;
	render->layer.kind = RENDER_TILES; /* any: they share a program */
	enum status status = render_tile_program(render, variant, &program);
	render->layer = shown;
	return status;
}

static enum status warm_ground(struct render *render, bool deformed, bool divided, bool smooth)
{
	for (unsigned variant = 0; variant < RENDER_VARIANTS; variant++)
		if (has_variant(variant, deformed, divided, smooth))
			TRY(warm_variant(render, variant));
	return render_heaps_warm(render);
}

enum status render_warm(struct render *render, bool deformed, bool divided, bool smooth)
{
	struct gpu_program *program;
	const bool truth = render->truth;
	enum status status = STATUS_OK;
	for (int kind = 0; kind < 2 && status == STATUS_OK; kind++) {
		render->truth = kind;
		status = render->truths[kind] ? warm_ground(render, deformed, divided, smooth) : STATUS_OK;
	}
	render->truth = truth;
	TRY(status);
	if (render->effects >> EFFECT_SKY & 1)
		TRY(render_sky_program(render, &program));
	TRY(render_apron_warm(render));
	TRY(render_expose_warm(render));
	TRY(render_grains_warm(render));
	return render_objects_warm(render);
}

/* --- the plan --- */

static void add(struct plan *plan, enum plan_kind kind, enum plan_unit unit, const char *effect, uint64_t bytes, const char *name)
{
	plan_add(plan, &(struct plan_line){.kind = kind, .unit = unit, .effect = effect, .object = -1, .amount = 1, .bytes = bytes},
		 name);
}

static void add_program(struct plan *plan, const char *effect, const struct gpu_program_request *request)
{
	char name[GPU_PROGRAM_NAME];
	gpu_program_name(request, name, sizeof name);
	add(plan, PLAN_PROGRAM, PLAN_ONCE, effect, 0, name);
}

void render_plan(const struct render_params *params, bool deformed, bool divided, bool smooth, struct plan *plan)
{
	uint64_t pixels = (uint64_t)params->width * (uint64_t)params->height;
	uint64_t effects = render_effects(params);
	struct scene_light light = params->light != NULL ? *params->light : scene_light_default();
	const char *body = render_body_define(&light);
	bool skirts = effects >> EFFECT_SKIRTS & 1;
	const char *picture = scene_effect_row(EFFECT_PICTURE)->name, *by_error = scene_effect_row(EFFECT_PIXEL_ERROR)->name;
	for (unsigned variant = 0; variant < RENDER_VARIANTS; variant++)
		if (has_variant(variant, deformed, divided, smooth)) {
			const struct shown shown = {params->disturbance, params->heals, params->vegetation != NULL, params->cover_by_class};
			struct gpu_program_request request;
			for (int truth = params->only_truth; truth <= (params->truth || params->only_truth); truth++) {
				request = picture_request_of(effects, body, shown, params->pixel_error > 0, truth, variant);
				/* Beside pictures without truth, those with it are of cameras. */
				const char *effect = asks_reaches(effects, params->pixel_error > 0) ? by_error : picture;
				add_program(plan, truth && !params->only_truth ? scene_effect_row(EFFECT_CAMERAS)->name : effect, &request);
			}
			request = measure_request_of(effects, params->classes, params->pixel_error > 0, variant);
			if (params->measures && !is_interpolated(variant))
				add_program(plan, scene_effect_row(EFFECT_CAMERAS)->name, &request);
			request = shade_request_of(effects, params->pixel_error > 0, variant);
			if ((effects >> EFFECT_TERRAIN_SHADOW & 1) && !is_interpolated(variant))
				add_program(plan, scene_effect_row(EFFECT_TERRAIN_SHADOW)->name, &request);
		}
	add(plan, PLAN_PASS, PLAN_DRAWN, picture, 0, gpu_stage_name(GPU_TERRAIN));
	add(plan, PLAN_TEXTURE, PLAN_ONCE, picture, 4 * pixels, "colour");
	uint64_t samples = params->samples > 1 ? (uint64_t)params->samples : 1;
	const char *antialias = scene_effect_row(EFFECT_ANTIALIAS)->name;
	add(plan, PLAN_TEXTURE, PLAN_ONCE, samples > 1 ? antialias : picture, 4 * pixels * samples, "depth");
	if (samples > 1) {
		add(plan, PLAN_TEXTURE, PLAN_ONCE, antialias, gpu_format_bytes(render_light_format(effects)) * pixels * samples, "samples");
		add(plan, PLAN_PASS, PLAN_FRAME, antialias, 0, gpu_stage_name(GPU_RESOLVE));
	}
	add(plan, PLAN_BUFFER, PLAN_ONCE, skirts ? scene_effect_row(EFFECT_SKIRTS)->name : picture,
	    render_index_count(render_block_cells(params->extent), skirts) * sizeof(uint16_t), "block");
	add(plan, PLAN_BUFFER, PLAN_ONCE, picture, gpu_list_bytes(RENDER_BLOCKS_ROOM * sizeof(uint32_t)), "blocks");
	if (effects >> EFFECT_TEXTURE & 1)
		add(plan, PLAN_TEXTURE, PLAN_ONCE, scene_effect_row(EFFECT_TEXTURE)->name,
		    gpu_texture_bytes(GPU_RGBA8, RENDER_GROUND_SIZE, RENDER_GROUND_SIZE, RENDER_GROUND_LAYERS, gpu_mipmap_levels(RENDER_GROUND_SIZE)),
		    "ground");
	if (effects >> EFFECT_SKY & 1) {
		struct gpu_program_request sky = sky_of(effects, body);
		add_program(plan, scene_effect_row(EFFECT_SKY)->name, &sky);
		add(plan, PLAN_PASS, PLAN_FRAME, scene_effect_row(EFFECT_SKY)->name, 0, gpu_stage_name(GPU_SKY));
	}
	render_apron_plan(params, plan);
	render_objects_plan(params, plan);
	render_grains_plan(params, plan);
	render_heaps_plan(params, plan);
	render_shade_plan(params, plan);
	if (effects >> EFFECT_IMAGERY & 1)
		render_imagery_plan(params->extent, params->imagery_budget, params->loaders, plan);
	render_expose_plan(params, plan);
}
