/*
 * Shadows that the terrain casts on itself: maps of depth toward the sun, in parallel projection. There are RENDER_SHADES of them. Each is
 * eight times as wide as the one before, and the first is as wide as the ground near the camera needs.
 *
 * A map shows the same mesh as the picture: levels and strides go by the distance from the camera's eye. It reaches toward the sun as far as the
 * terrain's relief can cast a shadow. Depth is reversed, as in pictures: the nearest to the sun is the largest.
 */
#include <math.h>
#include <string.h>

#include "render/internal.h"

#define LEAST 12.0        /* metres from the middle of the first map to its sides */
#define WIDER 8.0         /* times the one before */
#define FARTHEST 200000.0 /* metres toward the sun */

struct render_shade {
	struct gpu_texture *map;
	struct gpu_target *targets[RENDER_SHADES];
	double across[3], along[3], sun[3]; /* of the maps' axes; unit vectors */
	struct shade_box {
		bool drawn;
		double middle[3];          /* of the box along the three axes, absolute metres */
		double half[2], back, far; /* half its size; how far it reaches away from the sun, and toward it */
	} boxes[RENDER_SHADES];
};

static double dot(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

enum status render_shade_create(struct render *render)
{
	if (!(render->effects >> EFFECT_TERRAIN_SHADOW & 1))
		return STATUS_OK;
	struct render_shade *shade = mem_calloc(1, sizeof *shade);
	TRY_MEM(shade, "the terrain's shadows");
	render->shade = shade; /* from here on render_destroy frees it */
	TRY(gpu_texture_create(render->gpu, GPU_DEPTH32F, RENDER_SHADE_SIZE, RENDER_SHADE_SIZE, RENDER_SHADES, &shade->map));
	for (uint32_t i = 0; i < RENDER_SHADES; i++)
		TRY(gpu_target_create(render->gpu, NULL, 0, (struct gpu_attachment){shade->map, i}, &shade->targets[i]));
	return STATUS_OK;
}

void render_shade_destroy(struct render_shade *shade)
{
	if (shade == NULL)
		return;
	for (int i = 0; i < RENDER_SHADES; i++)
		gpu_target_destroy(shade->targets[i]);
	gpu_texture_destroy(shade->map);
	mem_free(shade);
}

struct gpu_texture *render_shade_texture(const struct render_shade *shade)
{
	return shade != NULL ? shade->map : NULL;
}

struct gpu_target *render_shade_target(const struct render_shade *shade, int index)
{
	return shade->targets[index];
}

void render_shade_begin(struct render *render)
{
	const struct scene_light *light = &render->light;
	struct render_shade *shade = render->shade;
	const double s = sin(light->azimuth), c = cos(light->azimuth);
	for (int i = 0; shade != NULL && i < RENDER_SHADES; i++)
		shade->boxes[i].drawn = false;
	if (shade == NULL)
		return;
	const double across[3] = {c, -s, 0}, sun[3] = {s * cos(light->height), c * cos(light->height), sin(light->height)};
	memcpy(shade->across, across, sizeof across);
	memcpy(shade->sun, sun, sizeof sun);
	/* upward in the map: along the ground, away from the sun, seen from above */
	shade->along[0] = -s * sin(light->height);
	shade->along[1] = -c * sin(light->height);
	shade->along[2] = cos(light->height);
}

bool render_shade_view(const struct render *render, const struct render_camera *camera, double ground, int index, struct render_view *view)
{
	struct render_shade *shade = render->shade;
	struct render_axes axes;
	if (shade == NULL || render->light.height <= 0)
		return false;
	struct shade_box *box = &shade->boxes[index];
	const double world = hypot((double)render->extent.width, (double)render->extent.height) * render->extent.spacing;
	const double least = fmax(LEAST, 2 * (camera->eye[2] - ground)), half = fmin(least * pow(WIDER, index), fmax(world, least));
	const double rise = sin(render->light.height);
	render_axes(render, camera, &axes);
	render_view(render, camera, view);
	/* The middle is ahead of the eye. It moves in whole texels, so that edges of shadows do not flicker. */
	const double at[3] = {camera->eye[0] + 0.7 * half * axes.forward[0], camera->eye[1] + 0.7 * half * axes.forward[1], ground};
	box->half[0] = half;
	box->half[1] = half * fmin(rise + 0.35, 1);
	for (int i = 0; i < 2; i++) {
		const double texel = 2 * box->half[i] / RENDER_SHADE_SIZE;
		box->middle[i] = texel * round(dot(i == 0 ? shade->across : shade->along, at) / texel);
	}
	box->middle[2] = dot(shade->sun, at);
	box->back = 2 * half;
	box->far = fmin((render->high - render->low) / rise + 2 * half, FARTHEST);
	const double *ways[3] = {shade->across, shade->along, shade->sun};
	for (int p = 0; p < 5; p++) {
		const double *way = ways[p / 2], sign = p % 2 == 0 ? 1 : -1;
		for (int i = 0; i < 3; i++)
			view->planes[p][i] = sign * way[i];
		view->planes[p][3] = p < 4 ? box->half[p / 2] - sign * box->middle[p / 2] : box->back - box->middle[2];
	}
	return true;
}

/* Metres relative to the eye. */
static void relative(const struct render_shade *shade, const struct shade_box *box, const double eye[3], double middle[3])
{
	middle[0] = box->middle[0] - dot(shade->across, eye);
	middle[1] = box->middle[1] - dot(shade->along, eye);
	middle[2] = box->middle[2] - dot(shade->sun, eye);
}

void render_shade_project(struct render *render, const double eye[3], int index, float matrix[16])
{
	struct render_shade *shade = render->shade;
	struct shade_box *box = &shade->boxes[index];
	double middle[3];
	relative(shade, box, eye, middle);
	const double deep = box->back + box->far, scale[3] = {1 / box->half[0], 1 / box->half[1], 1 / deep};
	const double *ways[3] = {shade->across, shade->along, shade->sun};
	memset(matrix, 0, 16 * sizeof *matrix);
	for (int row = 0; row < 3; row++) {
		for (int i = 0; i < 3; i++)
			matrix[4 * i + row] = (float)(ways[row][i] * scale[row]);
		matrix[12 + row] = (float)(-middle[row] * scale[row] + (row == 2 ? box->back / deep : 0));
	}
	matrix[15] = 1;
	box->drawn = true;
}

void render_shade_fill(const struct render *render, const double eye[3], struct picture_params *params)
{
	const struct render_shade *shade = render->shade;
	for (int i = 0; shade != NULL && i < 3; i++) {
		params->shade_across[i] = (float)shade->across[i];
		params->shade_along[i] = (float)shade->along[i];
	}
	for (int k = 0; k < RENDER_SHADES; k++) {
		float *to = params->shade_middle[k], *scale = params->shade_scale[k];
		memset(to, 0, sizeof params->shade_middle[k]);
		memset(scale, 0, sizeof params->shade_scale[k]);
		if (shade == NULL || !shade->boxes[k].drawn) {
			to[0] = 1e30f; /* no place is in it */
			scale[0] = 1;
			continue;
		}
		const struct shade_box *box = &shade->boxes[k];
		double middle[3];
		relative(shade, box, eye, middle);
		const double deep = box->back + box->far;
		for (int i = 0; i < 3; i++)
			to[i] = (float)middle[i];
		to[3] = (float)(box->back / deep);
		scale[0] = (float)(1 / box->half[0]);
		scale[1] = (float)(1 / box->half[1]);
		scale[2] = (float)(1 / deep);
		scale[3] = (float)(2 * box->half[0] / RENDER_SHADE_SIZE);
	}
}

void render_shade_plan(const struct render_params *params, struct plan *plan)
{
	if (!(params->effects >> EFFECT_TERRAIN_SHADOW & 1))
		return;
	plan_add(plan, &(struct plan_line){.kind = PLAN_TEXTURE, .unit = PLAN_ONCE, .effect = scene_effect_row(EFFECT_TERRAIN_SHADOW)->name, .object = -1,
					   .amount = 1,
					   .bytes = gpu_texture_bytes(GPU_DEPTH32F, RENDER_SHADE_SIZE, RENDER_SHADE_SIZE, RENDER_SHADES, 1)},
		 "shadows of the terrain");
}
