/* The rule of sliding, from the numbers of soils. */
#include <math.h>

#include "soil/kinematic/shed.h"
#include "soil/sliding/sliding.h"
#include "soil/stability.h"

/* Heights of slopes are whole units of 2^-9 m. The steepest angles are known for eight heights in each octave, from 2^4 units on. */
#define EXTENT_BITS 9
#define OCTAVE 8
#define FIRST_OCTAVE 4

int32_t soil_sliding_with_tolerance(const struct soil_sliding *rule, int32_t critical)
{
	return critical < INT32_MAX - rule->tolerance ? critical + rule->tolerance : INT32_MAX;
}

static bool is_cohesive(const struct soil_sliding_params *params)
{
	bool is = false;
	for (int i = 0; i < params->soil_count; i++)
		is = is || params->soils[i].cohesion > 0;
	return is && params->cotangent != NULL;
}

/* Returns a height for which the steepest angle is known, metres. */
static double known_height(int i)
{
	return ldexp(1 + (double)(i % OCTAVE) / OCTAVE, FIRST_OCTAVE + i / OCTAVE - EXTENT_BITS);
}

/* Returns the binary digits of cotangents behind the point. A post's distance with as many digits fits 31 bits. */
static int digits_of(double spacing)
{
	int exponent;
	frexp(spacing, &exponent);
	return exponent < -6 ? 17 : 11 - exponent;
}

static void prepare_slopes(const struct soil_sliding_params *params, const struct soil_numbers *soil, struct soil_sliding_class *class)
{
	for (int i = 0; i < SOIL_SLOPE_HEIGHTS; i++) {
		double cotangent = ldexp(params->cotangent(soil, known_height(i)), digits_of(params->spacing));
		class->slope[i] = (int32_t)floor(fmax(-(1 << 19), fmin(cotangent, 1 << 22)));
	}
	for (int k = 0; k < 2; k++)
		class->rise[k] = soil_critical_difference(soil->friction_angle, k == 0 ? params->spacing : params->spacing * M_SQRT2);
}

int32_t soil_sliding_diagonal(int32_t axial)
{
	return axial + (axial >> 2) + (axial >> 3) + (axial >> 5) + (axial >> 7);
}

#define LEAST_SHARE 940 /* 2^-10: slopes.c lowers a difference in a slope to no less */

/* As slopes.c computes it. */
static int32_t least_in_slope(const struct soil_sliding *rule)
{
	int32_t most = 0;
	for (int i = 0; i < rule->class_count; i++)
		for (int k = 0; k < SOIL_SLOPE_HEIGHTS; k++)
			most = rule->classes[i].slope[k] > most ? rule->classes[i].slope[k] : most;
	int32_t least = most > 0 ? rule->apart / most : 1 << 30;
	return (int32_t)((int64_t)(least < 1 << 30 ? least : 1 << 30) * LEAST_SHARE >> 10);
}

static void prepare_hops(const struct soil_sliding_params *params, struct soil_sliding *rule)
{
	for (int i = 0; i < SOIL_SLOPE_HOPS; i++)
		rule->reach += soil_sliding_way(i);
	rule->apart = (int32_t)floor(ldexp(params->spacing, OFFSET_BITS + digits_of(params->spacing)));
	rule->slope_least = least_in_slope(rule);
}

void soil_sliding_prepare(const struct soil_sliding_params *params, struct soil_sliding *rule)
{
	double depth = floor(ldexp(params->depth, OFFSET_BITS)), most = (1 << 30) - 1;
	*rule = (struct soil_sliding){
		.class_count = params->soil_count,
		.iterations = params->iterations,
		.directions = params->directions,
		.tolerance = (int32_t)floor(ldexp(params->tolerance, OFFSET_BITS)),
		.bounded = isfinite(params->depth) && params->shed == NULL,
		.steep = !(params->relief < SOIL_STEEP_RELIEF),
		.shed = params->shed,
		.step = params->shed != NULL ? 2 : 1, /* posts shed, and then take what others shed */
	};
	rule->depth = rule->bounded ? (int32_t)(depth < most ? depth : most) : 0;
	/* If only deposited soil slides, undisturbed ground needs no comparison. */
	rule->undisturbed_stable = params->undisturbed_stable && !(rule->bounded && params->depth == 0);
	for (int i = 0; i < params->soil_count && params->critical != NULL; i++)
		for (int k = 0; k < 2; k++)
			rule->classes[i].critical[k] = params->critical(&params->soils[i], k == 0 ? params->spacing : params->spacing * M_SQRT2);
	bool cohesive = is_cohesive(params);
	for (int i = 0; i < params->soil_count && cohesive; i++)
		prepare_slopes(params, &params->soils[i], &rule->classes[i]);
	for (int k = 0; k < 2; k++) {
		int32_t critical = INT32_MAX;
		for (int i = 0; i < params->soil_count; i++)
			critical = rule->classes[i].critical[k] < critical ? rule->classes[i].critical[k] : critical;
		rule->least[k] = soil_sliding_with_tolerance(rule, critical);
	}
	if (params->shed != NULL)
		soil_shed_least(params->shed, params->soil_count, rule->least);
	if (cohesive)
		prepare_hops(params, rule);
}

int64_t soil_sliding_rim(const struct soil_sliding *rule)
{
	return rule->step * rule->iterations + rule->steep + rule->reach;
}
