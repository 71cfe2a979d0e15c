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
#include "soil/stability.h"

/* Heights of slopes are whole units of 2^-9 m. The steepest angles are known for eight heights in each octave, from 2^4 units on. */
#define EXTENT_BITS 9
#define OCTAVE 8
#define FIRST_OCTAVE 4

#define SHORT_HOPS 4 /* 8, 4, 2, 1 */
#define SHORT_REACH ((1 << SHORT_HOPS) - 1)
#define NEAR_HOPS 1  /* posts: passes with at most so many posts of hops after them draw only marked cells */
#define NEAR 0.03 /* m: with a smaller spacing there is a longer hop too */

/* std140 twin of slope.frag's block. */
struct slope_params {
	int32_t place[4];
	int32_t soils[SOIL_CLASSES * (1 + SLOPE_HEIGHTS / 4)][4]; /* rises of all soils, then cotangents of all soils */
};

static int hops_of(const struct deform_params *params)
{
	if (!deform_has_slopes(params))
		return 0;
	return params->extent != NULL && extent_spacing(params->extent, params->level) < NEAR ? SHORT_HOPS + 1 : SHORT_HOPS;
}

int deform_slope_passes(const struct deform_params *params)
{
	int hops = hops_of(params);
	return hops > 0 ? 1 + hops : 0;
}

/* Returns the length of a hop, in posts. The longest hop is as long as it can be: what an interval reads around a block must lie in
 * the blocks beside it. */
static int64_t way_of(const struct deform_params *params, int number)
{
	int shorter = hops_of(params) - 1 - number;
	return shorter < SHORT_HOPS ? 1 << shorter : DEFORM_BLOCK - SHORT_REACH - params->iterations - 1;
}

int64_t deform_slope_reach(const struct deform_params *params)
{
	int64_t reach = 0;
	for (int number = 0; number < hops_of(params); number++)
		reach += way_of(params, number);
	return reach;
}

/* Returns a height for which the steepest angle is known, metres. */
static double known_height(int i)
{
	return ldexp(1 + (double)(i % OCTAVE) / OCTAVE, FIRST_OCTAVE + i / OCTAVE - EXTENT_BITS);
}

/* Returns the binary digits of cotangents behind the point. A post's distance with as many digits fits 31 bits. */
static int digits_of(const struct deform *deform)
{
	int exponent;
	frexp(deform->spacing, &exponent);
	return exponent < -6 ? 17 : 11 - exponent;
}

void deform_slopes_prepare(const struct deform *deform, const struct soil_numbers *soil, struct slide_soil *to)
{
	for (int i = 0; i < SLOPE_HEIGHTS; i++) {
		double cotangent = ldexp(deform_model_row(deform->params.model)->cotangent(soil, known_height(i)), digits_of(deform));
		to->slope[i] = (int32_t)floor(fmax(-(1 << 19), fmin(cotangent, 1 << 22)));
	}
	for (int k = 0; k < 2; k++)
		to->rise[k] = soil_critical_difference(soil->friction_angle, k == 0 ? deform->spacing : deform->spacing * M_SQRT2);
}

static struct gpu_texture *extents(const struct deform *deform, int hop)
{
	return hop % 2 == 0 ? deform->deposits : deform->under;
}

struct gpu_texture *deform_slopes_found(const struct deform *deform)
{
	return extents(deform, hops_of(&deform->params) - 1);
}

/* Returns the number of posts over which the hops after this one go. */
static int64_t after(const struct deform_params *params, int number)
{
	int64_t posts = 0;
	while (++number < hops_of(params))
		posts += way_of(params, number);
	return posts;
}

/* Returns the distance of posts with as many binary digits as the cotangents, 2^-20 m. */
static int32_t apart_of(const struct deform *deform)
{
	return (int32_t)floor(ldexp(deform->spacing, OFFSET_BITS + digits_of(deform)));
}

/* As in_slope() of slope.frag. */
int32_t deform_slopes_least(const struct deform *deform)
{
	int32_t most = 0;
	for (int i = 0; i < deform->params.soil_count; i++)
		for (int k = 0; k < SLOPE_HEIGHTS; k++)
			most = deform->soils[i].slope[k] > most ? deform->soils[i].slope[k] : most;
	int32_t least = most > 0 ? apart_of(deform) / most : 1 << 30;
	return least < 1 << 30 ? least : 1 << 30;
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
	bool first = number == 0, last = number == hops_of(&deform->params) - 1;
	enum slope_hop kind = first ? SLOPE_FIRST : last ? SLOPE_LAST : SLOPE_BETWEEN;
	struct gpu_program **program = &deform->slope[kind];
	deform_programs_slope(&deform->params, kind, &request);
	enum status status = deform_program(deform, &request, program);
	if (status != STATUS_OK)
		return status;
	int64_t way = way_of(&deform->params, number);
	bool near = after(&deform->params, number) <= NEAR_HOPS;
	struct slope_params params = {
		.place = {(int32_t)place->layer, (int32_t)way, apart_of(deform), near ? 0 : 1},
	};
	int slots = deform_soil_slots(&deform->params);
	for (int i = 0; i < deform->params.soil_count; i++) {
		for (int k = 0; k < 2; k++)
			params.soils[i][k] = at_most(way * deform->soils[i].rise[k]);
		memcpy(params.soils[slots + i * (SLOPE_HEIGHTS / 4)], deform->soils[i].slope, sizeof deform->soils[i].slope);
	}
	deform_atlas_run(deform, place, ATLAS_CELLS, 0, &(struct gpu_pass){
		.stage = GPU_SETTLE,
		.program = *program,
		.target = deform->scratch[place->layer].to[first ? TO_SLOPES_FIRST : number % 2 == 0 ? TO_SLOPES_1 : TO_SLOPES_0],
		.images = {first ? deform->bases : deform->carried,
			   first ? deform->planes_of[1][PLANE_OFFSET] : extents(deform, number - 1), deform->classes},
		.params = &params,
		.params_bytes = (size_t)((char *)params.soils[last ? slots * (1 + SLOPE_HEIGHTS / 4) : slots] - (char *)&params),
	});
	return STATUS_OK;
}

/* Marks the cells in which soil may slide. */
static enum status mark(struct deform *deform, const struct slide_place *place)
{
	struct deform_request request;
	deform_programs_steep(&request);
	enum status status = deform_program(deform, &request, &deform->steep);
	if (status != STATUS_OK)
		return status;
	/* For diagonal neighbours it is sqrt(2) times as large, by the same sum as in slide_excess.frag. */
	int32_t slope = deform_slopes_least(deform), least[2] = {slope, slope + (slope >> 2) + (slope >> 3) + (slope >> 5) + (slope >> 7)};
	for (int i = 0; i < deform->params.soil_count; i++)
		for (int k = 0; k < 2; k++)
			least[k] = deform->soils[i].critical[k] < least[k] ? deform->soils[i].critical[k] : least[k];
	const int32_t near = (int32_t)around(deform, NEAR_HOPS), steps = (2 * near + CELL - 1) / CELL, step = (2 * near + steps - 1) / steps;
	assert(around(deform, after(&deform->params, 0)) <= near + CELL); /* other hops draw the cells around */
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
	enum status status = mark(deform, place);
	for (int number = 0; number < hops_of(&deform->params) && status == STATUS_OK; number++)
		status = hop(deform, place, number);
	return status;
}
