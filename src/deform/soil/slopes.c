/*
 * Finds how high slopes are. A cohesive soil is stable up to Culmann's height. This is the height of a whole slope, not of the step
 * between two posts. Passes over blocks find for each post how far its slope rises above it and falls below it (slope.frag).
 *
 * A slope is followed by hops of 8, 4, 2 and 1 posts in eight directions. Each hop leads to a post that is higher (or lower) by
 * more than the angle of friction gives. So a slope is followed over any distance of 1 .. 15 posts. With a small spacing a longer
 * hop comes first. The last hop turns the height of a post's slope into the critical difference there.
 *
 * The result at a post depends only on the heights before the first iteration, and on posts within a fixed distance. So it is the
 * same in every block that computes the post.
 */
#include <math.h>
#include <string.h>

#include "deform/internal.h"
#include "deform/soil/stability.h"

/* Heights of slopes are whole units of 2^-9 m. The steepest angles are known for eight heights in each octave, from 2^4 units on. */
#define EXTENT_BITS 9
#define OCTAVE 8
#define FIRST_OCTAVE 4

#define SHORT_HOPS 4 /* 8, 4, 2, 1 */
#define SHORT_REACH ((1 << SHORT_HOPS) - 1)
#define NEAR 0.03 /* m: with a smaller spacing there is a longer hop too */

/* std140 twin of slope.frag's block. */
struct slope_params {
	int32_t region[4], place[4];
	int32_t soils[DEFORM_SOILS * (1 + SLOPE_HEIGHTS / 4)][4]; /* rises of all soils, then cotangents of all soils */
};

int deform_slope_hops(const struct deform_params *params)
{
	if (!deform_has_slopes(params))
		return 0;
	return params->extent != NULL && extent_spacing(params->extent, params->level) < NEAR ? SHORT_HOPS + 1 : SHORT_HOPS;
}

/* Returns the length of a hop, in posts. The longest hop is as long as it can be: what an interval reads around a block must lie in
 * the blocks beside it. */
static int64_t way_of(const struct deform_params *params, int number)
{
	int shorter = deform_slope_hops(params) - 1 - number;
	return shorter < SHORT_HOPS ? 1 << shorter : DEFORM_BLOCK - SHORT_REACH - params->iterations - 1;
}

int64_t deform_slope_reach(const struct deform_params *params)
{
	int64_t reach = 0;
	for (int number = 0; number < deform_slope_hops(params); number++)
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

void deform_slopes_prepare(const struct deform *deform, const struct deform_soil *soil, struct slide_soil *to)
{
	for (int i = 0; i < SLOPE_HEIGHTS; i++) {
		double cotangent = ldexp(deform_model_row(deform->params.model)->cotangent(soil, known_height(i)), digits_of(deform));
		to->slope[i] = (int32_t)floor(fmax(-(1 << 19), fmin(cotangent, 1 << 22)));
	}
	for (int k = 0; k < 2; k++)
		to->rise[k] = deform_critical_difference(soil->friction_angle, k == 0 ? deform->spacing : deform->spacing * M_SQRT2);
}

static struct gpu_texture *extents(const struct deform *deform, int hop)
{
	return hop % 2 == 0 ? deform->deposits : deform->under;
}

struct gpu_texture *deform_slopes_found(const struct deform *deform)
{
	return extents(deform, deform_slope_hops(&deform->params) - 1);
}

static int32_t at_most(int64_t units)
{
	return (int32_t)(units < 1 << 30 ? units : 1 << 30);
}

static enum status hop(struct deform *deform, const struct slide_place *place, int number)
{
	struct deform_request request;
	bool first = number == 0;
	struct gpu_program **program = &deform->slope[first];
	deform_programs_slope(&deform->params, first, &request);
	enum status status = deform_program(deform, &request, program);
	if (status != STATUS_OK)
		return status;
	int hops = deform_slope_hops(&deform->params);
	int64_t way = way_of(&deform->params, number), later = 0; /* posts around that later hops read */
	for (int after = number + 1; after < hops; after++)
		later += way_of(&deform->params, after);
	const int32_t apart = (int32_t)floor(ldexp(deform->spacing, OFFSET_BITS + digits_of(deform)));
	struct slope_params params = {
		.region = {(int32_t)place->side, (int32_t)place->columns,
			   (int32_t)(deform_slide_rim(deform) - deform_slide_step(deform) * deform->params.iterations - later),
			   (int32_t)place->first},
		.place = {(int32_t)place->layer, (int32_t)way, number == hops - 1 ? apart : 0},
	};
	int slots = deform_soil_slots(&deform->params);
	for (int i = 0; i < deform->params.soil_count; i++) {
		for (int k = 0; k < 2; k++)
			params.soils[i][k] = at_most(way * deform->soils[i].rise[k]);
		memcpy(params.soils[slots + i * (SLOPE_HEIGHTS / 4)], deform->soils[i].slope, sizeof deform->soils[i].slope);
	}
	gpu_pass_run(deform->params.gpu, &(struct gpu_pass){
		.stage = GPU_SETTLE,
		.program = *program,
		.target = deform->scratch[place->layer].to[first ? TO_SLOPES_FIRST : number % 2 == 0 ? TO_SLOPES_1 : TO_SLOPES_0],
		.viewport = place->all,
		.instances = place->blocks,
		.images = {first ? deform->bases : deform->carried,
			   first ? deform->planes_of[1][PLANE_OFFSET] : extents(deform, number - 1), deform->classes},
		.params = &params,
		.params_bytes = (size_t)((char *)params.soils[first ? slots : slots * (1 + SLOPE_HEIGHTS / 4)] - (char *)&params),
	});
	return STATUS_OK;
}

enum status deform_slopes_run(struct deform *deform, const struct slide_place *place)
{
	enum status status = STATUS_OK;
	for (int number = 0; number < deform_slope_hops(&deform->params) && status == STATUS_OK; number++)
		status = hop(deform, place, number);
	return status;
}
