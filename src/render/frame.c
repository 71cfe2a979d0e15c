/*
 * One frame. Each selected tile is one instanced draw of its visible blocks. Then the sky is drawn where no ground is. Positions are
 * relative to the eye: the CPU subtracts in doubles and on the integer lattice. The shader only adds small numbers.
 */
#include <cglm/cglm.h>
#include <math.h>
#include <string.h>

#include "render/imagery.h"


static void to_floats(float out[4], double x, double y, double z, double w)
{
	out[0] = (float)x;
	out[1] = (float)y;
	out[2] = (float)z;
	out[3] = (float)w;
}

/* Reversed depth without a far plane: near is 1, infinity 0. */
static void project(const struct render *render, const struct render_axes *axes, float matrix[16])
{
	mat4 view = GLM_MAT4_IDENTITY_INIT, lens = GLM_MAT4_ZERO_INIT, both;
	for (int i = 0; i < 3; i++) {
		view[i][0] = (float)axes->right[i];
		view[i][1] = (float)axes->up[i];
		view[i][2] = (float)-axes->forward[i];
	}
	lens[0][0] = (float)(2 * axes->focal / render->screen->width);
	lens[1][1] = (float)(2 * axes->focal / render->screen->height);
	lens[2][3] = -1;
	lens[3][2] = (float)RENDER_NEAR;
	glm_mat4_mul(lens, view, both);
	memcpy(matrix, both, sizeof both);
}

static void fill_marks(const struct render *render, struct picture_params *params)
{
	const struct scene_vegetation *plants = render->vegetation;
	memcpy(params->marks, (const int32_t[]){render->marks.now, render->marks.heals, render->marks.rises, render->marks.grows}, sizeof params->marks);
	for (int i = 0; i < SOIL_CLASSES && plants != NULL; i++)
		params->cover[i / 4][i % 4] = (float)plants->cover[i];
	if (plants != NULL)
		to_floats(params->plants, plants->height, 0, 0, 0);
}

static void fill_frame(const struct render *render, const struct render_camera *camera,
		       const struct render_axes *axes, struct picture_params *params)
{
	double wide = render->screen->width / 2.0 / axes->focal, high = render->screen->height / 2.0 / axes->focal;
	const double *r = axes->right, *u = axes->up, *f = axes->forward;
	project(render, axes, params->project);
	to_floats(params->right, r[0] * wide, r[1] * wide, r[2] * wide, 1 / axes->focal);
	to_floats(params->up, u[0] * high, u[1] * high, u[2] * high, 0);
	to_floats(params->forward, f[0], f[1], f[2], 0);
	const struct scene_light *light = &render->light;
	to_floats(params->sun, sin(light->azimuth) * cos(light->height), cos(light->azimuth) * cos(light->height),
		  sin(light->height), render_body_exposure(light) - 1);
	render_body_fill(light, render->soils, params);
	render_shade_fill(render, camera->eye, params);
	fill_marks(render, params);

	/* Clear air over large terrains; over small ones enough haze to soften the world's edge. */
	double across = hypot((double)(render->extent.width - 1), (double)(render->extent.height - 1)) * render->extent.spacing;
	double extinction = fmin(fmax(0.6 / across, 1.8e-5), 2e-4), layer = fmin(fmax(0.1 * across, 900), 3500);
	extinction *= render_body_air(light);
	double above = fmax(camera->eye[2] - render->low, 0);
	to_floats(params->haze, extinction * exp(-above / layer), 1 / layer, above, 0);
	double relief = fmax(render->high - render->low, 1);
	double mountain = fmin(fmax((relief - 250) / 650, 0), 1);
	to_floats(params->relief, render->low, 1 / relief, mountain * mountain * (3 - 2 * mountain), camera->eye[2]);
}

/* Tells whether some tile is coarser than it should be: a finer one is not resident, or the budget does not allow it. Its edges
 * may then be off by more than in a complete picture. */
static bool is_patched(const struct render *render, const struct render_axes *axes, const struct render_selection *selection)
{
	for (size_t i = 0; i < selection->draw_count; i++) {
		const struct render_draw *draw = &selection->draws[i];
		double reaches[RENDER_STRIDES];
		render_reaches(render, axes, draw, reaches);
		if (draw->standing != 0 || (!draw->finest && !draw->divided && draw->distance < reaches[0]))
			return true;
	}
	return false;
}

void render_fill_height(const struct render *render, const struct render_camera *camera, struct picture_params *params)
{
	const double eye = camera->eye[2] - render->reference;
	const double half = fmin(fmax(round(ldexp(eye, BASE_BITS - 1)), -0x1p30 + 1), 0x1p30 - 1);
	params->origin[3] = (float)(eye - ldexp(half, 1 - BASE_BITS));
	params->tile[2] = (int32_t)half;
}

static void fill_tile(const struct render *render, const struct render_camera *camera, const struct render_axes *axes,
		      const struct render_draw *draw, uint32_t first, bool patched, double lowest,
		      struct picture_params *params)
{
	double reaches[RENDER_STRIDES];
	render_reaches(render, axes, draw, reaches);
	uint32_t cells = render->extent.cells;
	double spacing = extent_spacing(&render->extent, draw->tile.level);
	double west = draw->tile.x * spacing * cells, south = draw->tile.y * spacing * cells;
	to_floats(params->origin, west - camera->eye[0], south - camera->eye[1], spacing, 0);
	render_fill_height(render, camera, params);
	to_floats(params->pattern, fmod(west, RENDER_PATTERN_PERIOD), fmod(south, RENDER_PATTERN_PERIOD), spacing, log2(1 / axes->focal));
	double near_x = (2 * west + south) / RENDER_GROUND_NEAR, near_y = (2 * south - west) / RENDER_GROUND_NEAR;
	double far_x = (3 * west + south) / RENDER_GROUND_FAR, far_y = (3 * south - west) / RENDER_GROUND_FAR;
	to_floats(params->corner_squares, near_x - floor(near_x), near_y - floor(near_y), fmod(far_x, 16), fmod(far_y, 16));
	to_floats(params->detail, render_mesh_reach(render, axes), patched ? draw->high - lowest : 0, RENDER_RUT_REACH * render_mesh_reach(render, axes),
		  fmax(render->pixel_error, 1) / axes->focal);
	for (int k = 0; k < RENDER_STRIDES; k++)
		params->reaches[k] = (float)reaches[k];
	params->tile[0] = (int32_t)cells;
	params->tile[1] = (int32_t)first;
	params->tile[3] = (int32_t)render_block_cells(&render->extent);

	to_floats(params->layer, render->layer.kind, render->layer.low, 1 / (render->layer.high - render->layer.low),
		  2 * (draw->tile.level - TILE_LEVEL_MIN) + (int)((draw->tile.x + draw->tile.y) & 1));

	struct tile top = tile_ancestor(draw->tile, draw->ground_level);
	double fine = ldexp(1, draw->tile.level - draw->ground_level);
	to_floats(params->ground, draw->tile.x * fine * cells - (double)top.x * cells,
		  draw->tile.y * fine * cells - (double)top.y * cells, fine, extent_spacing(&render->extent, top.level));
}

struct drawn {
	uint32_t first, count; /* blocks */
};

/* Collects blocks of draws, beginning with the first, until the GPU's buffer is full. *end: the first draw that did not fit. */
static enum status collect_blocks(struct render *render, const struct render_view *view, const struct render_axes *axes,
				  const struct render_selection *selection, size_t first, size_t *end, struct drawn *drawn)
{
	struct render_blocks *blocks = &render->blocks;
	blocks->count = 0;
	for (*end = first; *end < selection->draw_count; ++*end) {
		const struct render_draw *draw = &selection->draws[*end];
		size_t before = blocks->count;
		double reaches[RENDER_STRIDES];
		render_reaches(render, axes, draw, reaches);
		TRY(render_blocks_add(blocks, &render->extent, view, reaches, draw));
		if (blocks->count > RENDER_BLOCKS_ROOM) {
			blocks->count = before;
			break;
		}
		drawn[*end] = (struct drawn){(uint32_t)before, (uint32_t)(blocks->count - before)};
	}
	if (blocks->count > 0)
		gpu_list_write(render->instances, blocks->count * sizeof(uint32_t), blocks->blocks);
	return STATUS_OK;
}

static void count_triangles(struct render *render)
{
	uint64_t cells = render_block_cells(&render->extent);
	render->triangles += render->blocks.count * 2 * cells * cells;
	if (render->effects >> EFFECT_SKIRTS & 1)
		for (size_t i = 0; i < render->blocks.count; i++)
			render->triangles += 2 * cells * (uint64_t)__builtin_popcount(render->blocks.blocks[i] >> 24);
}

static struct gpu_target *target_of(const struct render *render)
{
	if (render->shading != NULL)
		return render->shading;
	const struct render_screen *screen = render->screen;
	return render->measuring ? screen->measure : screen->ground != NULL ? screen->ground : screen->target;
}

/* Returns whether the ground that is drawn now has the colours of imagery. */
static bool shows_imagery(const struct render *render)
{
	return render->imagery != NULL && render->shading == NULL && !render->measuring && render->layer.kind == RENDER_NATURAL;
}

/* `ground`: the base of the tile that its base is interpolated from, or NULL. */
static enum status run_tile(struct render *render, const struct gpu_slot *slot, struct gpu_texture *ground, uint32_t blocks,
			    const struct picture_params *params)
{
	const struct gpu_rect shade_rect = {0, 0, RENDER_SHADE_SIZE, RENDER_SHADE_SIZE};
	const bool shown = render->shading == NULL && !render->measuring, coloured = shows_imagery(render);
	struct gpu_pass pass = {
		.stage = GPU_TERRAIN,
		.target = target_of(render),
		.viewport = render->shading != NULL ? shade_rect : (struct gpu_rect){0, 0, render->screen->width, render->screen->height},
		.textures = {slot->base, slot->planes[PLANE_OFFSET], NULL, ground, render->ground, slot->classes,
			     shown ? render_shade_texture(render->shade) : NULL, coloured ? render->imagery->texture : NULL,
			     coloured ? render->imagery->tables[render->imagery->table] : NULL},
		.lists = {render->instances},
		.images = {slot->base, slot->planes[PLANE_OFFSET]},
		.only_reads = true,
		.params = params,
		.params_bytes = coloured ? sizeof *params : RENDER_PARAMS_BYTES,
		.indices = render->indices,
		.index_count = render->index_count,
		.instances = blocks,
		.depth_test = true,
		.cull_back = true,
	};
	if (render->disturbance)
		pass.images[2] = slot->planes[PLANE_DISTURBANCE];
	else if (render->heals)
		pass.images[2] = slot->planes[PLANE_HEALED];
	if (render->vegetation != NULL) {
		pass.images[3] = slot->planes[PLANE_RISEN];
		pass.images[4] = slot->planes[PLANE_GROWN];
	}
	const bool smooth = ground != NULL && render->shading == NULL && !render->measuring;
	unsigned variant = slot->planes[PLANE_OFFSET] == NULL ? (smooth ? RENDER_SMOOTH : RENDER_PLAIN) : smooth ? RENDER_LEVEL0 : RENDER_OFFSET;
	TRY(render_tile_program(render, variant, &pass.program));
	gpu_pass_run(render->gpu, &pass);
	return STATUS_OK;
}

static enum status draw_tile(struct render *render, const struct render_draw *draw, const struct drawn *drawn,
			     const struct picture_params *params)
{
	bool interpolated = draw->ground_level != draw->tile.level && draw->ground != RENDER_NO_SLOT;
	if (render->show != NULL)
		TRY(render->show(render->user, draw->slot, true));
	if (render->show != NULL && interpolated)
		TRY(render->show(render->user, draw->ground, false));
	const struct gpu_slot *slot = gpu_slots_get(render->slots, draw->slot);
	TRY(run_tile(render, slot, interpolated ? gpu_slots_get(render->slots, draw->ground)->base : NULL, drawn->count, params));
	render->tiles.drawn++;
	render->tiles.deformed += slot->target != NULL;
	return STATUS_OK;
}

static enum status draw_sky(struct render *render, const struct picture_params *params)
{
	struct gpu_pass pass = {
		.stage = GPU_SKY,
		.target = render->screen->target,
		.viewport = {0, 0, render->screen->width, render->screen->height},
		.params = params,
		.params_bytes = RENDER_PARAMS_BYTES,
		.depth_test = true,
	};
	TRY(render_sky_program(render, &pass.program));
	gpu_pass_run(render->gpu, &pass);
	return STATUS_OK;
}

/* Draws the ground beyond the terrain, and the sky. */
static enum status draw_beyond(struct render *render, const struct render_camera *camera, const struct render_selection *selection,
			       struct picture_params *params)
{
	struct render_axes axes;
	render_axes(render, camera, &axes);
	TRY(render_apron_draw(render, camera, &axes, selection, params));
	return draw_sky(render, params);
}

/* What the draws of a frame have in common. */
struct drawing {
	struct render *render;
	const struct render_camera *camera;
	const struct render_axes *axes;
	const struct render_selection *selection;
	struct picture_params *params;
	bool patched;
	double lowest;
};

static enum status draw_blocks(const struct drawing *drawing, const struct render_draw *draw, const struct drawn *drawn, const struct imagery_draw *imagery)
{
	fill_tile(drawing->render, drawing->camera, drawing->axes, draw, drawn->first, drawing->patched, drawing->lowest, drawing->params);
	if (imagery != NULL) {
		memcpy(drawing->params->layer, imagery->layer, sizeof imagery->layer);
		memcpy(drawing->params->imagery, imagery->levels, sizeof imagery->levels);
	}
	return draw_tile(drawing->render, draw, drawn, drawing->params);
}

static enum status run_imagery(void *user, const struct imagery_draw *part)
{
	const struct drawing *drawing = user;
	return draw_blocks(drawing, &drawing->selection->draws[part->draw], &(struct drawn){part->first, part->count}, part);
}

/* Draws tiles whose blocks are in the GPU's buffer. */
static enum status draw_tiles(struct drawing *drawing, const struct render_view *view, size_t first, size_t end, const struct drawn *drawn)
{
	struct render *render = drawing->render;
	const bool imagery = shows_imagery(render);
	for (size_t k = first; k < end; k++) {
		const struct render_draw *draw = &drawing->selection->draws[k];
		if (drawn[k].count == 0)
			continue;
		if (imagery)
			TRY(render_imagery_draw(render->imagery, view, drawing->axes->focal, draw, k, render->blocks.blocks, drawn[k].first, drawn[k].count, run_imagery, drawing));
		else
			TRY(draw_blocks(drawing, draw, &drawn[k], NULL));
	}
	return imagery ? render_imagery_flush(render->imagery, run_imagery, drawing) : STATUS_OK;
}

/* Draws the blocks of the selected tiles that `view` sees. */
static enum status draw_ground(struct render *render, const struct render_camera *camera, const struct render_axes *axes, const struct render_view *view,
			       const struct render_selection *selection, struct picture_params *params)
{
	struct drawn *drawn = mem_alloc(selection->draw_count + 1, sizeof *drawn);
	TRY_MEM(drawn, "the picture's draws");
	enum status status = STATUS_OK;
	struct drawing drawing = {render, camera, axes, selection, params, is_patched(render, axes, selection), INFINITY};
	for (size_t i = 0; i < selection->draw_count; i++)
		drawing.lowest = fmin(drawing.lowest, selection->draws[i].low);
	render->triangles = 0;
	render->tiles = (struct render_tiles){.drawn = 0};
	for (size_t i = 0, end; i < selection->draw_count; i = end) {
		TRY_OR(done, collect_blocks(render, view, axes, selection, i, &end, drawn));
		count_triangles(render);
		TRY_OR(done, draw_tiles(&drawing, view, i, end, drawn));
	}
done:
	mem_free(drawn);
	return status;
}

/* Draws the ground and the objects. */
static enum status draw_frame(struct render *render, const struct render_camera *camera, const struct render_selection *selection,
			      struct picture_params *params)
{
	struct render_axes axes;
	struct render_view view;
	render_axes(render, camera, &axes);
	render_view(render, camera, &view);
	fill_frame(render, camera, &axes, params);
	const bool counted = render->screen == &render->own && !render->measuring; /* overdraw is of that size */
	if (counted)
		gpu_counter_begin(render->ground_samples);
	enum status status = draw_ground(render, camera, &axes, &view, selection, params);
	if (counted)
		gpu_counter_end(render->ground_samples);
	TRY(status);
	TRY(render->objects != NULL ? render_objects_draw(render, camera, &axes, &view, params) : STATUS_OK);
	TRY(render->heaps != NULL ? render_heaps_draw(render, camera, &axes, params) : STATUS_OK);
	return render->grains != NULL ? render_grains_draw(render, camera, params) : STATUS_OK;
}

enum status render_shade_draw(struct render *render, const struct render_camera *camera, int map, const struct render_view *view,
			      const struct render_selection *selection)
{
	struct picture_params params = {0};
	struct render_axes axes;
	static const float nothing[4] = {0, 0, 0, 0};
	render_axes(render, camera, &axes);
	fill_frame(render, camera, &axes, &params);
	render_shade_project(render, camera->eye, map, params.project);
	render->shading = render_shade_target(render->shade, map);
	gpu_target_clear(render->shading, nothing);
	enum status status = draw_ground(render, camera, &axes, view, selection, &params);
	render->shading = NULL;
	TRY(status);
	return gpu_check(render->gpu, "drawing shadows");
}

enum status render_frame(struct render *render, const struct render_camera *camera, const struct render_selection *selection)
{
	float background[4];
	struct picture_params params = {0};
	render_body_background(&render->light, background);
	render_expose_background(render, background);
	gpu_target_clear(target_of(render), background);
	if (render->imagery != NULL)
		render_imagery_begin_frame(render->imagery);
	TRY(draw_frame(render, camera, selection, &params));
	if (render->effects >> EFFECT_SKY & 1)
		TRY(draw_beyond(render, camera, selection, &params));
	if (render->screen->resolved != NULL)
		gpu_target_resolve(render->screen->target, render->screen->resolved);
	TRY(render_expose(render));
	return gpu_check(render->gpu, "drawing the picture");
}

enum status render_measure(struct render *render, const struct render_camera *camera, const struct render_selection *selection)
{
	static const float nothing[4] = {0, 0, 0, 0};
	struct picture_params params = {0};
	assert(render->measures && render->screen->measure != NULL);
	gpu_target_clear(render->screen->measure, nothing);
	render->measuring = true;
	enum status status = draw_frame(render, camera, selection, &params);
	render->measuring = false;
	TRY(status);
	return gpu_check(render->gpu, "drawing numbers");
}

/* --- before the first frame --- */

/* Which kinds of tiles there may be. */
struct kinds {
	bool deformed, divided, smooth;
};

/* Draws each kind of tile once. */
static enum status draw_kinds(struct render *render, const struct gpu_slot *deformed, const struct kinds *kinds, const struct picture_params *params)
{
	const struct gpu_slot plain = {.base = deformed->base};
	const bool shown = render->shading == NULL && !render->measuring;
	TRY(run_tile(render, &plain, NULL, 1, params));
	if (kinds->smooth && shown)
		TRY(run_tile(render, &plain, deformed->base, 1, params));
	if (kinds->deformed)
		TRY(run_tile(render, deformed, NULL, 1, params));
	return kinds->deformed && kinds->divided && shown ? run_tile(render, deformed, deformed->base, 1, params) : STATUS_OK;
}

/* The screen that numbers are drawn into may be another's, so this makes one of a pixel. */
static enum status measure_unseen(struct render *render, const struct gpu_slot *slot, const struct kinds *kinds, const struct picture_params *params)
{
	struct render_screen *shown = render->screen, small;
	enum status status;
	TRY_OR(done, render_screen_init(render, 1, 1, 1, &small));
	TRY_OR(done, render_screen_measures(render, &small));
	render->screen = &small;
	render->measuring = true;
	TRY_OR(done, draw_kinds(render, slot, kinds, params));
	if (render->objects != NULL)
		TRY_OR(done, render_objects_draw_unseen(render, params));
	if (render->grains != NULL)
		TRY_OR(done, render_grains_draw_unseen(render, params));
	if (render->heaps != NULL)
		TRY_OR(done, render_heaps_draw_unseen(render, params));
done:
	render->measuring = false;
	render->screen = shown;
	render_screen_finish(&small);
	return status;
}

/* Draws natural ground, and any layer. */
static enum status draw_layers(struct render *render, const struct gpu_slot *slot, const struct kinds *kinds, const struct picture_params *params)
{
	const struct render_layer shown = render->layer;
	TRY(draw_kinds(render, slot, kinds, params));
	if (!render->layers)
		return STATUS_OK;
	render->layer.kind = RENDER_TILES;
	enum status status = draw_kinds(render, slot, kinds, params);
	render->layer = shown;
	return status;
}

/* Draws what there may be of pictures without and with truth. */
static enum status draw_truths(struct render *render, const struct gpu_slot *slot, const struct kinds *kinds, const struct picture_params *params)
{
	const bool shown = render->truth;
	enum status status = STATUS_OK;
	for (int truth = 0; truth < 2 && status == STATUS_OK; truth++) {
		render->truth = truth;
		status = render->truths[truth] ? draw_layers(render, slot, kinds, params) : STATUS_OK;
		if (status == STATUS_OK && render->truths[truth] && render->heaps != NULL)
			status = render_heaps_draw_unseen(render, params);
	}
	render->truth = shown;
	return status;
}

static enum status draw_shade(struct render *render, const struct gpu_slot *slot, const struct kinds *kinds, const struct picture_params *params)
{
	render->shading = render_shade_target(render->shade, 0);
	enum status status = draw_kinds(render, slot, kinds, params);
	render->shading = NULL;
	return status;
}

static enum status draw_unseen(struct render *render, const struct gpu_slot *slot, const struct kinds *kinds)
{
	struct picture_params params = {.project = {[12] = 4, [15] = 1}}; /* puts every vertex at one place beside the picture */
	uint32_t none = 0;
	params.tile[0] = (int32_t)render->extent.cells;
	params.tile[3] = (int32_t)render_block_cells(&render->extent);
	params.origin[2] = params.pattern[2] = params.ground[2] = params.ground[3] = params.detail[0] = params.detail[2] = 1;
	gpu_list_write(render->instances, sizeof none, &none);
	/* Count samples as in any frame, since llvmpipe compiles a program again for that. */
	gpu_counter_begin(render->ground_samples);
	enum status status = draw_truths(render, slot, kinds, &params);
	gpu_counter_end(render->ground_samples);
	TRY(status);
	if (render->shade != NULL)
		TRY(draw_shade(render, slot, kinds, &params));
	if (render->measures)
		TRY(measure_unseen(render, slot, kinds, &params));
	if (render->objects != NULL)
		TRY(render_objects_draw_unseen(render, &params));
	if (render->grains != NULL)
		TRY(render_grains_draw_unseen(render, &params));
	if (!(render->effects >> EFFECT_SKY & 1))
		return STATUS_OK;
	TRY(render_apron_draw_unseen(render, slot->base, &params));
	return draw_sky(render, &params);
}

enum status render_draw_unseen(struct render *render, bool deformed, bool divided, bool smooth)
{
	struct gpu *gpu = render->gpu;
	const uint32_t side = render->extent.cells + 1;
	struct gpu_slot slot = {.base = NULL};
	/* Textures like those of a slot, since a driver may compile again for others. */
	enum status status;
	TRY_OR(done, gpu_texture_create(gpu, GPU_R32I, side, side, 0, &slot.base));
	if (deformed)
		TRY_OR(done, gpu_texture_create(gpu, GPU_R32I, side, side, 0, &slot.planes[PLANE_OFFSET]));
	if (deformed && render->disturbance)
		TRY_OR(done, gpu_texture_create(gpu, GPU_R8UI, side, side, 0, &slot.planes[PLANE_DISTURBANCE]));
	for (int plane = PLANE_HEALED; plane <= PLANE_GROWN && deformed; plane++)
		if (plane == PLANE_HEALED ? render->heals : render->vegetation != NULL)
			TRY_OR(done, gpu_texture_create(gpu, GPU_R32I, side, side, 0, &slot.planes[plane]));
	TRY_OR(done, draw_unseen(render, &slot, &(struct kinds){deformed, divided, smooth}));
	TRY_OR(done, gpu_check(gpu, "drawing before the first picture"));
done:
	for (int plane = PLANE_HEALED; plane <= PLANE_GROWN; plane++)
		gpu_texture_destroy(slot.planes[plane]);
	gpu_texture_destroy(slot.planes[PLANE_DISTURBANCE]);
	gpu_texture_destroy(slot.planes[PLANE_OFFSET]);
	gpu_texture_destroy(slot.base);
	return status;
}

void render_set_marks(struct render *render, const struct plane_marks *marks)
{
	render->marks = *marks;
}
