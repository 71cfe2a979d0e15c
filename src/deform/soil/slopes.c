/*
 * Finds how high slopes are. A cohesive soil is stable up to Culmann's height. This is the height of a whole slope, not of the step
 * between two posts. Passes over blocks find for each post how far its slope rises above it and falls below it (slope.frag).
 *
 * A slope is followed by hops of 8, 4, 2 and 1 posts in eight directions. Each hop leads to a post that is higher (or lower) by
 * more than the angle of friction gives. The first hop goes on with what the interval before left in the plane `slope`. The last one writes that plane, and turns
 * the height of a post's slope into the critical difference there (src/soil/sliding/slopes.c says more).
 *
 * Soil slides only where two neighbours differ by more than the least critical difference. So a first pass marks the cells around such
 * neighbours (steep.frag), and around posts whose plane is not 0. The others draw only those. Elsewhere the results are undefined, and nothing that slides reads them.
 *
 * The result at a post depends only on the heights and the plane before the first iteration, and on posts within a fixed distance. So it is the
 * same in every block that computes the post.
 */
#include <assert.h>
#include <math.h>
#include <string.h>

#include "deform/internal.h"

#define NEAR_HOPS 1  /* posts: passes with at most so many posts of hops after them draw only marked cells */

/* posts: so much farther around steep posts cells are marked. Beside walls of a kilometre soil slid from cells that were not (tests/hard/slopes.c) */
#define MARKED_MORE CELL

/* std140 twin of slope.frag's block. */
struct slope_params {
	int32_t place[4];
	int32_t soils[SOIL_CLASSES * (1 + SOIL_SLOPE_HEIGHTS / 4)][4]; /* rises of all soils, then cotangents of all soils */
};

int deform_slope_passes(const struct deform_params *params)
{
	return deform_has_slopes(params) ? 1 + SOIL_SLOPE_HOPS : 0;
}

int64_t deform_slope_reach(const struct deform_params *params)
{
	int64_t reach = 0;
	for (int number = 0; number < SOIL_SLOPE_HOPS && deform_has_slopes(params); number++)
		reach += soil_sliding_way(number);
	return reach;
}

static struct gpu_texture *extents(const struct deform *deform, int hop)
{
	return hop % 2 == 0 ? deform->deposits : deform->under;
}

struct gpu_texture *deform_slopes_found(const struct deform *deform)
{
	return extents(deform, SOIL_SLOPE_HOPS - 1);
}

/* Returns the number of posts over which the hops after this one go. */
static int64_t after(int number)
{
	return soil_sliding_way(number) - 1;
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

/* Gives the least differences that slide in any slope: axial, diagonal. For diagonal neighbours it is sqrt(2) times as large, by the same sum as
 * in slide_excess.frag. */
static void least_in_slopes(const struct deform *deform, int32_t least[2])
{
	least[0] = deform->sliding.slope_least;
	least[1] = soil_sliding_diagonal(least[0]);
	for (int i = 0; i < deform->params.soil_count; i++)
		for (int k = 0; k < 2; k++)
			least[k] = deform->sliding.classes[i].critical[k] < least[k] ? deform->sliding.classes[i].critical[k] : least[k];
}

static enum status hop(struct deform *deform, const struct slide_place *place, int number)
{
	struct deform_request request;
	bool first = number == 0, last = number == SOIL_SLOPE_HOPS - 1;
	enum slope_hop kind = first ? SLOPE_FIRST : last ? SLOPE_LAST : SLOPE_BETWEEN;
	struct gpu_program **program = &deform->slope[kind];
	deform_programs_slope(&deform->params, kind, &request);
	TRY(deform_program(deform, &request, program));
	const int64_t way = soil_sliding_way(number);
	bool near = after(number) <= NEAR_HOPS;
	struct slope_params params = {
		.place = {(int32_t)place->layer, (int32_t)way, deform->sliding.apart, near ? 0 : 1},
	};
	int slots = deform_soil_slots(&deform->params);
	int32_t least[2];
	least_in_slopes(deform, least);
	for (int i = 0; i < deform->params.soil_count; i++) {
		for (int k = 0; k < 2; k++)
			params.soils[i][k] = at_most(way * deform->sliding.classes[i].rise[k]);
		memcpy(params.soils[slots + i * (SOIL_SLOPE_HEIGHTS / 4)], deform->sliding.classes[i].slope, sizeof deform->sliding.classes[i].slope);
	}
	memcpy(&params.soils[0][2], least, sizeof least);
	deform_atlas_run(deform, place, ATLAS_CELLS, 0, &(struct gpu_pass){
		.stage = GPU_SETTLE,
		.program = *program,
		.target = deform->scratch[place->layer].to[first ? TO_SLOPES_FIRST : number % 2 == 0 ? TO_SLOPES_1 : TO_SLOPES_0],
		.images = {first ? deform->bases : deform->carried,
			   first ? deform->planes_of[1][PLANE_OFFSET] : extents(deform, number - 1), deform->classes,
			   first || last ? deform->planes_of[1][PLANE_SLOPE] : NULL, last && deform_asks_what_stood(&deform->params) ? deform->bases : NULL},
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
	int32_t least[2];
	least_in_slopes(deform, least);
	const int32_t near = (int32_t)around(deform, NEAR_HOPS) + MARKED_MORE, steps = (2 * near + CELL - 1) / CELL, step = (2 * near + steps - 1) / steps;
	assert(around(deform, after(0)) <= near + CELL); /* other hops draw the cells around */
	const int32_t params[2][4] = {
		{(int32_t)place->layer, least[0], least[1]},
		{near, step, steps * step - near},
	};
	gpu_texture_clear(place->atlas->cells, 0, (struct gpu_rect){0, 0, CELLS_ACROSS, CELLS_ACROSS}, 0);
	deform_atlas_run(deform, place, ATLAS_REGIONS, deform_slope_reach(&deform->params), &(struct gpu_pass){
		.stage = GPU_SETTLE,
		.program = deform->steep,
		.target = deform->scratch[place->layer].to[TO_BARE],
		.images = {deform->bases, place->atlas->cells, deform->planes_of[1][PLANE_OFFSET], deform->planes_of[1][PLANE_SLOPE]},
		.params = params,
		.params_bytes = sizeof params,
	});
	return STATUS_OK;
}

enum status deform_slopes_run(struct deform *deform, const struct slide_place *place)
{
	TRY(mark(deform, place));
	for (int number = 0; number < SOIL_SLOPE_HOPS; number++)
		TRY(hop(deform, place, number));
	return STATUS_OK;
}
