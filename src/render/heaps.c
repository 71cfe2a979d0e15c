/*
 * Soil aboard bodies in the picture: a surface over the cells that have some, lit as ground that was dug. Its light, depth and numbers are those of ground. It casts no
 * shadow. All bodies' soil is one draw, or one for each HEAP_QUADS quads. Where no body has soil aboard, nothing is written to the GPU and nothing is drawn.
 *
 * A cell is a quad whose corners lie between cells, at the mean height of the soil around. Where the body's surface is higher beside it, there is a wall somewhere in the cell.
 * The soil goes on for half a cell there. Where it is lower, the soil slopes down to it. Beside the body it ends in an upright side, where the
 * cell's share says that the body ends.
 */
#include <math.h>
#include <string.h>

#include "render/objects.h"

#define HEAP_QUADS ((size_t)4096) /* of a draw */
#define HEAP_LEAST (1 << 10)      /* fixed-point units, 1 mm: a cell with less is not drawn */

/* Read by shaders/heap.vert, std430. */
struct heap_corner {
	float place[3];
	uint32_t normal;
	float own[2], heading;
	uint32_t class_and_rise;
};

/* A corner of a quad in the cells' axes. */
struct heap_point {
	float own[3], normal[3];
};

struct heap_shown {
	double at[3], heading;
	uint32_t class_and_rise; /* as in struct heap_corner */
	size_t first, count; /* quads */
};

struct render_heaps {
	struct gpu_buffer *indices;
	struct gpu_list *corners;
	struct heap_corner *posed; /* of one draw */
	struct heap_shown *shown;
	struct heap_point (*quads)[4];
	double *heights;           /* of corners of cells; NaN: no soil is there */
	size_t shown_count, shown_room, quad_count, quad_room, height_room;
};

/* --- programs, plan and life --- */

static struct gpu_program_request request_of(uint64_t effects, const char *body, bool truth)
{
	static const enum scene_effect used[] = {EFFECT_TEXTURE, EFFECT_DETAIL, EFFECT_FOG, EFFECT_SPLAT, EFFECT_TERRAIN_SHADOW};
	struct gpu_program_request request = {.vertex = "heap.vert", .fragment = "heap.frag"};
	size_t count = 0;
	for (size_t i = 0; i < sizeof used / sizeof *used; i++)
		if (effects >> used[i] & 1)
			request.defines[count++] = scene_effect_row(used[i])->define;
	if (effects >> EFFECT_LIGHT & 1)
		request.defines[count++] = render_light_define(effects);
	if (effects & RENDER_ONE_SOIL)
		request.defines[count++] = RENDER_ONE_SOIL_DEFINE;
	request.defines[count] = body;
	if (truth)
		render_request_truth(&request);
	return request;
}

static const struct gpu_program_request measure_request = {.vertex = "heap.vert", .fragment = "measure_heap.frag"};

static enum status program_of(struct render *render, struct gpu_program **out)
{
	if (render->measuring)
		return gpu_program_get(render->gpu, &measure_request, out);
	const struct gpu_program_request request = request_of(render->effects, render_body_define(&render->light), render->truth);
	return gpu_program_get(render->gpu, &request, out);
}

enum status render_heaps_warm(struct render *render)
{
	struct gpu_program *program;
	if (render->heaps == NULL)
		return STATUS_OK;
	TRY(program_of(render, &program));
	return render->measures ? gpu_program_get(render->gpu, &measure_request, &program) : STATUS_OK;
}

void render_heaps_plan(const struct render_params *params, struct plan *plan)
{
	const char *effect = scene_effect_row(EFFECT_CARRIED)->name;
	const struct scene_light light = params->light != NULL ? *params->light : scene_light_default();
	const char *body = render_body_define(&light);
	const struct gpu_program_request requests[] = {request_of(render_effects(params), body, false), request_of(render_effects(params), body, true), measure_request};
	const bool used[] = {!params->only_truth, params->truth || params->only_truth, params->measures};
	const bool objects = (params->effects >> EFFECT_OBJECTS & 1) && params->object_count > 0;
	char name[GPU_PROGRAM_NAME];
	if (!params->heaps)
		return;
	for (int i = 0; i < 3; i++) {
		if (!used[i])
			continue;
		gpu_program_name(&requests[i], name, sizeof name);
		plan_add(plan, &(struct plan_line){.kind = PLAN_PROGRAM, .unit = PLAN_ONCE, .effect = i == 0 || (i == 1 && !used[0]) ? effect : scene_effect_row(EFFECT_CAMERAS)->name, .object = -1, .amount = 1}, name);
	}
	plan_add(plan, &(struct plan_line){.kind = PLAN_BUFFER, .unit = PLAN_ONCE, .effect = effect, .object = -1, .amount = 1, .bytes = gpu_list_bytes(HEAP_QUADS * 4 * sizeof(struct heap_corner))},
		 "soil aboard: corners");
	plan_add(plan, &(struct plan_line){.kind = PLAN_BUFFER, .unit = PLAN_ONCE, .effect = effect, .object = -1, .amount = 1, .bytes = HEAP_QUADS * 6 * sizeof(uint32_t)}, "soil aboard: triangles");
	if (!objects && params->grains == 0) /* objects and grains have the same passes: those are theirs, if there are any */
		plan_add(plan, &(struct plan_line){.kind = PLAN_PASS, .unit = PLAN_OBJECTS, .effect = effect, .object = -1, .amount = 1}, gpu_stage_name(GPU_OBJECTS));
}

static enum status make_indices(struct render *render, struct gpu_buffer **out)
{
	static const uint32_t two[6] = {0, 1, 2, 0, 2, 3};
	uint32_t *indices;
	TRY(mem_make(&indices, HEAP_QUADS * 6, sizeof *indices, "the picture's soil aboard bodies"));
	for (size_t i = 0; i < HEAP_QUADS * 6; i++)
		indices[i] = (uint32_t)(i / 6 * 4) + two[i % 6];
	const enum status status = gpu_buffer_create(render->gpu, GPU_INDICES, HEAP_QUADS * 6 * sizeof *indices, indices, out);
	mem_free(indices);
	return status;
}

enum status render_heaps_create(struct render *render, const struct render_params *params)
{
	if (!params->heaps)
		return STATUS_OK;
	TRY(mem_zeroed(&render->heaps, 1, sizeof *render->heaps, "the picture's soil aboard bodies")); /* from here on render_destroy frees it */
	struct render_heaps *heaps = render->heaps;
	TRY(mem_make(&heaps->posed, HEAP_QUADS * 4, sizeof *heaps->posed, "the picture's soil aboard bodies"));
	TRY(gpu_list_create(render->gpu, HEAP_QUADS * 4 * sizeof *heaps->posed, &heaps->corners));
	return make_indices(render, &heaps->indices);
}

void render_heaps_destroy(struct render_heaps *heaps)
{
	if (heaps == NULL)
		return;
	gpu_buffer_destroy(heaps->indices);
	gpu_list_destroy(heaps->corners);
	mem_free_all(heaps->posed, heaps->shown, heaps->quads, heaps->heights, heaps);
}

/* --- a surface over cells --- */

enum beside { SOIL, WALL, FLOOR, OPEN };

/* Returns the height of the soil in a cell, fixed-point units. */
static int64_t surface_of(const struct render_heap *heap, size_t cell)
{
	return heap->tops[cell] + (int64_t)heap->amounts[cell] * RENDER_HEAP_SHARES / (heap->shares != NULL ? heap->shares[cell] : RENDER_HEAP_SHARES);
}

/* Finds what a cell is for soil beside it that is so high, fixed-point units. */
static enum beside beside_of(const struct render_heap *heap, int column, int row, int64_t height)
{
	if (column < 0 || row < 0 || column >= heap->side || row >= heap->side)
		return OPEN;
	const size_t cell = (size_t)row * (size_t)heap->side + (size_t)column;
	if (heap->tops[cell] == CARRIED_OPEN)
		return OPEN;
	if (heap->amounts[cell] >= HEAP_LEAST)
		return SOIL;
	return heap->tops[cell] >= height ? WALL : FLOOR;
}

/* What is around a corner of cells. */
struct around {
	int soils;              /* cells with soil, of the four */
	int64_t height, floor;  /* fixed-point units: means over these, of the soil's surface and of the body's */
	double share;           /* mean over these, of a cell */
	enum beside cells[4];   /* south-west, south-east, north-west, north-east in the cells' axes */
};

static struct around around_of(const struct render_heap *heap, int column, int row)
{
	struct around around = {0};
	for (int k = 0; k < 4; k++) {
		const int c = column - 1 + k % 2, r = row - 1 + k / 2;
		if (beside_of(heap, c, r, 0) != SOIL)
			continue;
		const size_t cell = (size_t)r * (size_t)heap->side + (size_t)c;
		around.height += surface_of(heap, cell);
		around.share += heap->shares != NULL ? (double)heap->shares[cell] / RENDER_HEAP_SHARES : 1;
		around.floor += heap->tops[cell];
		around.soils++;
	}
	for (int k = 0; k < 4 && around.soils > 0; k++)
		around.cells[k] = beside_of(heap, column - 1 + k % 2, row - 1 + k / 2, around.height / around.soils);
	around.share /= around.soils > 0 ? around.soils : 1;
	around.height /= around.soils > 0 ? around.soils : 1;
	around.floor /= around.soils > 0 ? around.soils : 1;
	return around;
}

/* Returns the surface's height at a corner, m; NaN: there is no soil around. */
static double height_of(const struct around *around)
{
	bool slopes = false;
	if (around->soils == 0)
		return (double)NAN;
	for (int k = 0; k < 4; k++)
		slopes |= around->cells[k] == FLOOR;
	return lattice_offset_metres(slopes ? around->floor : around->height);
}

/* Returns by how many cells a corner is moved along an axis: toward a wall, or back to where the body ends in the cells. a, b: the two cells before it; c, d: those
 * after. share: of these cells above the body. */
static double moved(enum beside a, enum beside b, enum beside c, enum beside d, double share)
{
	const double before = a == WALL && b == WALL ? -0.5 : a == OPEN && b == OPEN ? 1 - share : 0;
	const double after = c == WALL && d == WALL ? 0.5 : c == OPEN && d == OPEN ? share - 1 : 0;
	return before + after;
}

/* Returns the slope along an axis between the corners `step` before and after one, m for each cell. */
static double slope_of(const double *heights, size_t at, size_t step, bool first, bool last)
{
	const double here = heights[at], before = first || isnan(heights[at - step]) ? here : heights[at - step], after = last || isnan(heights[at + step]) ? here : heights[at + step];
	const int apart = (before != here) + (after != here);
	return apart > 0 ? (after - before) / apart : 0;
}

static struct heap_point point_of(const struct render_heap *heap, const double *heights, int column, int row)
{
	const size_t wide = (size_t)heap->side + 1, at = (size_t)row * wide + (size_t)column;
	const struct around around = around_of(heap, column, row);
	const enum beside *is = around.cells;
	const double middle = 0.5 * heap->side;
	const double x = (column - middle + moved(is[0], is[2], is[1], is[3], around.share)) * heap->spacing, y = (row - middle + moved(is[0], is[1], is[2], is[3], around.share)) * heap->spacing;
	const double slopes[2] = {slope_of(heights, at, 1, column == 0, column == heap->side), slope_of(heights, at, wide, row == 0, row == heap->side)};
	const double length = sqrt(slopes[0] * slopes[0] + slopes[1] * slopes[1] + heap->spacing * heap->spacing);
	return (struct heap_point){{(float)x, (float)y, (float)heights[at]}, {(float)(-slopes[0] / length), (float)(-slopes[1] / length), (float)(heap->spacing / length)}};
}

static enum status add_quad(struct render_heaps *heaps, const struct heap_point quad[4])
{
	TRY(mem_grow(&heaps->quads, &heaps->quad_room, heaps->quad_count + 1, sizeof *heaps->quads, "the picture's soil aboard bodies"));
	memcpy(heaps->quads[heaps->quad_count++], quad, sizeof *heaps->quads);
	return STATUS_OK;
}

/* Adds the quad of a cell, and its upright sides beside the body. */
static enum status add_cell(struct render_heaps *heaps, const struct render_heap *heap, int column, int row)
{
	static const int sides[4][4] = {{0, -1, 0, 1}, {1, 0, 1, 2}, {0, 1, 2, 3}, {-1, 0, 3, 0}}; /* the cell beside, and the two corners between */
	const float floor = (float)lattice_offset_metres(heap->tops[(size_t)row * (size_t)heap->side + (size_t)column]);
	struct heap_point top[4];
	for (int k = 0; k < 4; k++)
		top[k] = point_of(heap, heaps->heights, column + (k == 1 || k == 2), row + (k > 1));
	TRY(add_quad(heaps, top));
	for (int k = 0; k < 4; k++) {
		if (beside_of(heap, column + sides[k][0], row + sides[k][1], 0) != OPEN)
			continue;
		struct heap_point side[4] = {top[sides[k][2]], top[sides[k][3]], top[sides[k][3]], top[sides[k][2]]};
		side[2].own[2] = fminf(side[2].own[2], floor);
		side[3].own[2] = fminf(side[3].own[2], floor);
		TRY(add_quad(heaps, side));
	}
	return STATUS_OK;
}

static uint32_t class_and_rise(const struct render *render, const struct render_heap *heap)
{
	const double rise = (heap->ground - render->low) / fmax(render->high - render->low, 1);
	return (uint32_t)heap->class | (uint32_t)lround(fmin(fmax(rise, 0), 1) * 65535) << 8;
}

static enum status add_heap(struct render *render, const struct render_heap *heap)
{
	struct render_heaps *heaps = render->heaps;
	const size_t first = heaps->quad_count, wide = (size_t)heap->side + 1;
	TRY(mem_grow(&heaps->heights, &heaps->height_room, wide * wide, sizeof *heaps->heights, "the picture's soil aboard bodies"));
	TRY(mem_grow(&heaps->shown, &heaps->shown_room, heaps->shown_count + 1, sizeof *heaps->shown, "the picture's soil aboard bodies"));
	for (int row = 0; row <= heap->side; row++)
		for (int column = 0; column <= heap->side; column++) {
			const struct around around = around_of(heap, column, row);
			heaps->heights[(size_t)row * wide + (size_t)column] = height_of(&around);
		}
	for (int row = 0; row < heap->side; row++)
		for (int column = 0; column < heap->side; column++)
			if (beside_of(heap, column, row, 0) == SOIL)
				TRY(add_cell(heaps, heap, column, row));
	struct heap_shown shown = {.heading = heap->heading, .class_and_rise = class_and_rise(render, heap), .first = first, .count = heaps->quad_count - first};
	memcpy(shown.at, heap->at, sizeof shown.at);
	heaps->shown[heaps->shown_count] = shown;
	heaps->shown_count += shown.count > 0;
	return STATUS_OK;
}

enum status render_set_heaps(struct render *render, const struct render_heap *list, size_t count)
{
	struct render_heaps *heaps = render->heaps;
	if (heaps == NULL)
		return STATUS_OK;
	heaps->quad_count = heaps->shown_count = 0;
	for (size_t i = 0; i < count; i++)
		TRY(add_heap(render, &list[i]));
	return STATUS_OK;
}

/* --- a picture --- */

static struct heap_corner corner_of(const struct heap_shown *shown, const struct heap_point *point, const double eye[3])
{
	const double c = cos(shown->heading), s = sin(shown->heading);
	const double normal[3] = {c * (double)point->normal[0] - s * (double)point->normal[1], s * (double)point->normal[0] + c * (double)point->normal[1], (double)point->normal[2]};
	return (struct heap_corner){
		.place = {(float)(shown->at[0] - eye[0] + c * (double)point->own[0] - s * (double)point->own[1]),
			  (float)(shown->at[1] - eye[1] + s * (double)point->own[0] + c * (double)point->own[1]), (float)(shown->at[2] - eye[2] + (double)point->own[2])},
		.normal = render_object_look(normal, 0),
		.own = {point->own[0], point->own[1]},
		.heading = (float)shown->heading,
		.class_and_rise = shown->class_and_rise,
	};
}

static enum status run(struct render *render, const struct picture_params *params, size_t quads)
{
	struct render_heaps *heaps = render->heaps;
	struct gpu_program *program;
	TRY(program_of(render, &program));
	gpu_list_write(heaps->corners, quads * 4 * sizeof *heaps->posed, heaps->posed);
	gpu_pass_run(render->gpu, &(struct gpu_pass){
		.stage = GPU_OBJECTS,
		.program = program,
		.target = render->measuring ? render->screen->measure : render->screen->target,
		.viewport = {0, 0, render->screen->width, render->screen->height},
		.textures = {[4] = render->measuring ? NULL : render->ground, [6] = render->measuring ? NULL : render_shade_texture(render->shade)},
		.lists = {heaps->corners},
		.params = params,
		.params_bytes = RENDER_PARAMS_BYTES,
		.indices = heaps->indices,
		.wide_indices = true,
		.index_count = (uint32_t)(quads * 6),
		.instances = 1,
		.depth_test = true,
	});
	return STATUS_OK;
}

enum status render_heaps_draw_unseen(struct render *render, const struct picture_params *params)
{
	memset(render->heaps->posed, 0, 4 * sizeof *render->heaps->posed);
	return run(render, params, 1);
}

enum status render_heaps_draw(struct render *render, const struct render_camera *camera, const struct render_axes *axes, struct picture_params *params)
{
	struct render_heaps *heaps = render->heaps;
	size_t waiting = 0;
	for (int k = 0; k < 2; k++)
		params->pattern[k] = (float)fmod(camera->eye[k], RENDER_PATTERN_PERIOD);
	params->pattern[3] = (float)log2(1 / axes->focal);
	for (size_t i = 0; i < heaps->shown_count; i++) {
		const struct heap_shown *shown = &heaps->shown[i];
		for (size_t q = 0; q < shown->count; q++) {
			for (int k = 0; k < 4; k++)
				heaps->posed[4 * waiting + (size_t)k] = corner_of(shown, &heaps->quads[shown->first + q][k], camera->eye);
			const bool last = i + 1 == heaps->shown_count && q + 1 == shown->count;
			if (++waiting < HEAP_QUADS && !last)
				continue;
			TRY(run(render, params, waiting));
			render->tiles.objects++;
			render->triangles += 2 * waiting;
			waiting = 0;
		}
	}
	return STATUS_OK;
}
