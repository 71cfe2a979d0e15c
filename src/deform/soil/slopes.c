/*
 * Finds how high slopes are. A cohesive soil is stable up to Culmann's height. This is the height of a whole slope, not of the step
 * between two posts. Passes over blocks find for each post how far its slope rises above it and falls below it (slope.frag).
 *
 * A slope is followed by hops of 8, 4, 2 and 1 posts in eight directions. Each hop leads to a post that is higher (or lower) by
 * more than the angle of friction gives. So a slope is followed over any distance of 1 .. 15 posts. With a small spacing a longer
 * hop comes first. The last hop turns the height of a post's slope into the critical difference there.
 *
 * Soil slides only where two neighbours differ by more than the least critical difference. So a first pass marks the cells around such
 * neighbours (steep.frag), and the others draw only those. Elsewhere the results are undefined, and nothing that slides reads them.
 *
 * The result at a post depends only on the heights before the first iteration, and on posts within a fixed distance. So it is the
 * same in every block that computes the post.
 */
#include <assert.h>
#include <math.h>
#include <string.h>

#include "deform/internal.h"

#define NEAR_HOPS 1  /* posts: passes with at most so many posts of hops after them draw only marked cells */

/* std140 twin of slope.frag's block. */
struct slope_params {
	int32_t place[4];
	int32_t soils[SOIL_CLASSES * (1 + SOIL_SLOPE_HEIGHTS / 4)][4]; /* rises of all soils, then cotangents of all soils */
};

/* Returns the number of hops, and their lengths in posts. */
static int ways_of(const struct deform_params *params, int ways[SOIL_SLOPE_HOPS])
{
	if (!deform_has_slopes(params))
		return 0;
	return soil_sliding_ways(params->extent != NULL ? extent_spacing(params->extent, params->level) : (double)INFINITY, params->iterations, ways);
}

int deform_slope_passes(const struct deform_params *params)
{
	int ways[SOIL_SLOPE_HOPS], hops = ways_of(params, ways);
	return hops > 0 ? 1 + hops : 0;
}

int64_t deform_slope_reach(const struct deform_params *params)
{
	int ways[SOIL_SLOPE_HOPS], hops = ways_of(params, ways);
	int64_t reach = 0;
	for (int number = 0; number < hops; number++)
		reach += ways[number];
	return reach;
}

static struct gpu_texture *extents(const struct deform *deform, int hop)
{
	return hop % 2 == 0 ? deform->deposits : deform->under;
}

struct gpu_texture *deform_slopes_found(const struct deform *deform)
{
	return extents(deform, deform->sliding.hops - 1);
}

/* Returns the number of posts over which the hops after this one go. */
static int64_t after(const struct deform *deform, int number)
{
	int64_t posts = 0;
	while (++number < deform->sliding.hops)
		posts += deform->sliding.ways[number];
	return posts;
}

/* Returns how far from a steep pair of posts a pass must find extents, if later hops go over so many posts. In an iteration the posts
 * beside those that slid may become steep. */
static int64_t around(const struct deform *deform, int64_t later)
{
	return later + deform->params.iterations + 1;
}

static int32_t at_most(int64_t units)
{
	return (int32_t)(units < 1 << 30 ? units : 1 << 30);
}

static enum status hop(struct deform *deform, const struct slide_place *place, int number)
{
	struct deform_request request;
	bool first = number == 0, last = number == deform->sliding.hops - 1;
	enum slope_hop kind = first ? SLOPE_FIRST : last ? SLOPE_LAST : SLOPE_BETWEEN;
	struct gpu_program **program = &deform->slope[kind];
	deform_programs_slope(&deform->params, kind, &request);
	TRY(deform_program(deform, &request, program));
	int64_t way = deform->sliding.ways[number];
	bool near = after(deform, number) <= NEAR_HOPS;
	struct slope_params params = {
		.place = {(int32_t)place->layer, (int32_t)way, deform->sliding.apart, near ? 0 : 1},
	};
	int slots = deform_soil_slots(&deform->params);
	for (int i = 0; i < deform->params.soil_count; i++) {
		for (int k = 0; k < 2; k++)
			params.soils[i][k] = at_most(way * deform->sliding.classes[i].rise[k]);
		memcpy(params.soils[slots + i * (SOIL_SLOPE_HEIGHTS / 4)], deform->sliding.classes[i].slope, sizeof deform->sliding.classes[i].slope);
	}
	deform_atlas_run(deform, place, ATLAS_CELLS, 0, &(struct gpu_pass){
		.stage = GPU_SETTLE,
		.program = *program,
		.target = deform->scratch[place->layer].to[first ? TO_SLOPES_FIRST : number % 2 == 0 ? TO_SLOPES_1 : TO_SLOPES_0],
		.images = {first ? deform->bases : deform->carried,
			   first ? deform->planes_of[1][PLANE_OFFSET] : extents(deform, number - 1), deform->classes},
		.params = &params,
		.params_bytes = (size_t)((char *)params.soils[last ? slots * (1 + SOIL_SLOPE_HEIGHTS / 4) : slots] - (char *)&params),
	});
	return STATUS_OK;
}

/* Marks the cells in which soil may slide. */
static enum status mark(struct deform *deform, const struct slide_place *place)
{
	struct deform_request request;
	deform_programs_steep(&request);
	TRY(deform_program(deform, &request, &deform->steep));
	/* For diagonal neighbours it is sqrt(2) times as large, by the same sum as in slide_excess.frag. */
	int32_t slope = deform->sliding.slope_least, least[2] = {slope, soil_sliding_diagonal(slope)};
	for (int i = 0; i < deform->params.soil_count; i++)
		for (int k = 0; k < 2; k++)
			least[k] = deform->sliding.classes[i].critical[k] < least[k] ? deform->sliding.classes[i].critical[k] : least[k];
	const int32_t near = (int32_t)around(deform, NEAR_HOPS), steps = (2 * near + CELL - 1) / CELL, step = (2 * near + steps - 1) / steps;
	assert(around(deform, after(deform, 0)) <= near + CELL); /* other hops draw the cells around */
	const int32_t params[2][4] = {
		{(int32_t)place->layer, least[0], least[1]},
		{near, step, steps * step - near},
	};
	gpu_texture_clear(place->atlas->cells, 0, (struct gpu_rect){0, 0, CELLS_ACROSS, CELLS_ACROSS}, 0);
	deform_atlas_run(deform, place, ATLAS_REGIONS, deform_slope_reach(&deform->params), &(struct gpu_pass){
		.stage = GPU_SETTLE,
		.program = deform->steep,
		.target = deform->scratch[place->layer].to[TO_BARE],
		.images = {deform->heights[0], place->atlas->cells},
		.params = params,
		.params_bytes = sizeof params,
	});
	return STATUS_OK;
}

enum status deform_slopes_run(struct deform *deform, const struct slide_place *place)
{
	TRY(mark(deform, place));
	for (int number = 0; number < deform->sliding.hops; number++)
		TRY(hop(deform, place, number));
	return STATUS_OK;
}
