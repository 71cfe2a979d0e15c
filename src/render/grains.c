/*
 * Grains of thrown soil in the picture. One draw shows all of them, as small balls, each stretched and turned by its own number. They are lit as objects are, and stand
 * in depth and in numbers as objects do. They cast no shadow.
 */
#include <assert.h>
#include <math.h>
#include <string.h>

#include "render/objects.h"

struct render_grains {
	struct gpu_buffer *corners, *indices;
	uint32_t first, end;     /* indices of the detail that is drawn */
	struct gpu_list *instances;
	struct render_grain *shown;
	struct object_posed *posed;
	size_t count, room;
};

static bool shows(const struct render_params *params)
{
	return params->grains > 0;
}

/* Objects have the same program for numbers, and the same passes: those are theirs, if there are any. */
static bool objects_shown(const struct render_params *params)
{
	return (params->effects >> EFFECT_OBJECTS & 1) && params->object_count > 0;
}

static struct gpu_program_request request_of(uint64_t effects, const char *body)
{
	struct gpu_program_request request = {.vertex = "object.vert", .fragment = "object.frag", .defines = {"GRAINS"}};
	size_t count = 1;
	if (effects >> EFFECT_FOG & 1)
		request.defines[count++] = scene_effect_row(EFFECT_FOG)->define;
	if (effects >> EFFECT_TERRAIN_SHADOW & 1)
		request.defines[count++] = scene_effect_row(EFFECT_TERRAIN_SHADOW)->define;
	if (effects >> EFFECT_LIGHT & 1)
		request.defines[count++] = render_light_define(effects);
	request.defines[count] = body;
	return request;
}

static const struct gpu_program_request measure_request = {.vertex = "object.vert", .fragment = "measure_object.frag"};

static enum status program_of(struct render *render, struct gpu_program **out)
{
	if (render->measuring)
		return gpu_program_get(render->gpu, &measure_request, out);
	const struct gpu_program_request request = request_of(render->effects, render_body_define(&render->light));
	return gpu_program_get(render->gpu, &request, out);
}

/* A ball of 1 m. */
static enum status make_ball(struct object_mesh *mesh)
{
	const struct soil_shape ball = {.kind = SOIL_SPHERE, .radius = 1};
	return render_object_mesh_make(&ball, mesh);
}

/* Finds the coarsest detail. */
static void coarsest(const struct object_mesh *mesh, uint32_t *first, uint32_t *end)
{
	int detail = OBJECT_DETAILS - 1;
	while (detail > 0 && mesh->first[detail] == mesh->first[detail + 1])
		detail--;
	*first = mesh->first[detail];
	*end = mesh->first[detail + 1];
}

void render_grains_plan(const struct render_params *params, struct plan *plan)
{
	const char *effect = scene_effect_row(EFFECT_THROWN)->name;
	const struct scene_light light = params->light != NULL ? *params->light : scene_light_default();
	struct gpu_program_request requests[] = {request_of(params->effects, render_body_define(&light)), measure_request};
	struct object_mesh mesh;
	char name[GPU_PROGRAM_NAME];
	if (!shows(params))
		return;
	for (int i = 0; i < (params->measures && !objects_shown(params) ? 2 : 1); i++) {
		gpu_program_name(&requests[i], name, sizeof name);
		plan_add(plan, &(struct plan_line){.kind = PLAN_PROGRAM, .unit = PLAN_ONCE, .effect = i == 0 ? effect : scene_effect_row(EFFECT_CAMERAS)->name, .object = -1, .amount = 1}, name);
	}
	if (make_ball(&mesh) != STATUS_OK) {
		plan->failed = true;
		return;
	}
	const struct {
		uint64_t bytes;
		const char *name;
	} buffers[] = {{mesh.corner_count * sizeof *mesh.corners, "grains: corners"}, {mesh.index_count * sizeof *mesh.indices, "grains: triangles"},
		       {gpu_list_bytes(params->grains * sizeof(struct object_posed)), "grains: where they are"}};
	for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++)
		plan_add(plan, &(struct plan_line){.kind = PLAN_BUFFER, .unit = PLAN_ONCE, .effect = effect, .object = -1, .amount = 1, .bytes = buffers[i].bytes}, buffers[i].name);
	if (!objects_shown(params))
		plan_add(plan, &(struct plan_line){.kind = PLAN_PASS, .unit = PLAN_OBJECTS, .effect = effect, .object = -1, .amount = 1}, gpu_stage_name(GPU_OBJECTS));
	render_object_mesh_finish(&mesh);
}

enum status render_grains_create(struct render *render, const struct render_params *params)
{
	struct object_mesh mesh;
	if (!shows(params))
		return STATUS_OK;
	TRY(mem_zeroed(&render->grains, 1, sizeof *render->grains, "the picture's grains")); /* from here on render_destroy frees it */
	struct render_grains *grains = render->grains;
	grains->room = params->grains;
	TRY(mem_make(&grains->shown, grains->room, sizeof *grains->shown, "the picture's grains"));
	TRY(mem_make(&grains->posed, grains->room, sizeof *grains->posed, "the picture's grains"));
	TRY(gpu_list_create(render->gpu, grains->room * sizeof *grains->posed, &grains->instances));
	TRY(make_ball(&mesh));
	coarsest(&mesh, &grains->first, &grains->end);
	enum status status;
	TRY_OR(done, gpu_buffer_create(render->gpu, GPU_STORAGE, mesh.corner_count * sizeof *mesh.corners, mesh.corners, &grains->corners));
	TRY_OR(done, gpu_buffer_create(render->gpu, GPU_INDICES, mesh.index_count * sizeof *mesh.indices, mesh.indices, &grains->indices));
done:
	render_object_mesh_finish(&mesh);
	return status;
}

void render_grains_destroy(struct render_grains *grains)
{
	if (grains == NULL)
		return;
	gpu_buffer_destroy(grains->corners);
	gpu_buffer_destroy(grains->indices);
	gpu_list_destroy(grains->instances);
	mem_free_all(grains->shown, grains->posed, grains);
}

enum status render_grains_warm(struct render *render)
{
	struct gpu_program *program;
	if (render->grains == NULL)
		return STATUS_OK;
	TRY(program_of(render, &program));
	return render->measures ? gpu_program_get(render->gpu, &measure_request, &program) : STATUS_OK;
}

void render_set_grains(struct render *render, const struct render_grain *list, size_t count)
{
	struct render_grains *grains = render->grains;
	if (grains == NULL)
		return;
	assert(count <= grains->room);
	if (count > 0)
		memcpy(grains->shown, list, count * sizeof *list);
	grains->count = count;
}

/* Returns 0 .. 1 by bits of a grain's number. */
static double part_of(uint32_t number, int shift)
{
	return (double)(number >> shift & 255) / 255;
}

static struct object_posed posed_at(const struct render_grain *grain, const double eye[3])
{
	struct object_posed posed = {.size = {(float)grain->radius}};
	const uint32_t number = grain->number * 2654435761u;
	double axes[3][3];
	soil_axes(2 * M_PI * part_of(number, 0), M_PI * part_of(number, 8), 2 * M_PI * part_of(number, 16), 0, axes);
	for (int a = 0; a < 3; a++) {
		/* The product of the three stretches is near 1. */
		const double stretch = grain->radius * (a == 0 ? 1.3 : a == 1 ? 0.7 + 0.3 * part_of(number, 24) : 0.9);
		for (int k = 0; k < 3; k++)
			posed.axes[a][k] = (float)(stretch * axes[a][k]);
		posed.axes[a][3] = (float)(grain->at[a] - eye[a]);
	}
	return posed;
}

static enum status run(struct render *render, struct picture_params *params, size_t count)
{
	struct render_grains *grains = render->grains;
	struct gpu_program *program;
	TRY(program_of(render, &program));
	gpu_list_write(grains->instances, count * sizeof *grains->posed, grains->posed);
	params->tile[1] = 0;
	gpu_pass_run(render->gpu, &(struct gpu_pass){
		.stage = GPU_OBJECTS,
		.program = program,
		.target = render->measuring ? render->screen->measure : render->screen->target,
		.viewport = {0, 0, render->screen->width, render->screen->height},
		.textures = {[6] = render->measuring ? NULL : render_shade_texture(render->shade)},
		.storage = {grains->corners},
		.lists = {[1] = grains->instances},
		.params = params,
		.params_bytes = RENDER_PARAMS_BYTES,
		.indices = grains->indices,
		.wide_indices = true,
		.first_index = grains->first,
		.index_count = grains->end - grains->first,
		.instances = (uint32_t)count,
		.depth_test = true,
		.cull_back = true,
	});
	return STATUS_OK;
}

enum status render_grains_draw_unseen(struct render *render, const struct picture_params *params)
{
	struct picture_params own = *params;
	render->grains->posed[0] = (struct object_posed){.size = {0}};
	return run(render, &own, 1);
}

enum status render_grains_draw(struct render *render, const struct render_camera *camera, struct picture_params *params)
{
	struct render_grains *grains = render->grains;
	if (grains->count == 0)
		return STATUS_OK;
	for (size_t i = 0; i < grains->count; i++)
		grains->posed[i] = posed_at(&grains->shown[i], camera->eye);
	TRY(run(render, params, grains->count));
	render->tiles.objects++;
	render->triangles += (uint64_t)(grains->end - grains->first) / 3 * grains->count;
	return STATUS_OK;
}
