/* Grounds and contacts for the tests of the reference alone. */
#ifndef FURROW_TESTS_DEFORM_REFERENCE_RIG_H
#define FURROW_TESTS_DEFORM_REFERENCE_RIG_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "deform/reference/reference.h"

#define RADIANS (M_PI / 180)
#define POST(x, y) ((y) * ground.width + (x))

static inline double any_height(void)
{
	static uint32_t state = 12345;
	state = state * 1664525 + 1013904223;
	return (double)(state >> 8) / (1 << 24);
}

static inline struct reference_ground made(int width, int height, double spacing)
{
	struct reference_ground ground;
	assert_int_equal(reference_ground_init(&ground, width, height, spacing), STATUS_OK);
	return ground;
}

static inline struct deform_params with(enum deform_model model, const char *name)
{
	struct deform_params params = {.model = model, .soil_count = 1, .iterations = 4, .depth = INFINITY, .bulldozing = 0.6};
	assert_int_equal(soil_named(name, &params.soils[0]), STATUS_OK);
	if (model == DEFORM_SCM)
		params.depth = 0;
	return params;
}

static inline struct soil_pose at(const struct reference_ground *ground, double x, double y, double z)
{
	return (struct soil_pose){
		.x = lattice_offset(((double)ground->left + x) * ground->spacing),
		.y = lattice_offset(((double)ground->bottom + y) * ground->spacing),
		.z = lattice_offset(z),
	};
}

static inline void swept(struct reference_ground *ground, const struct deform_params *params, const struct deform_contact *sweep,
		  struct reference_forces *forces)
{
	double lower;
	assert_int_equal(reference_sweep(ground, params, sweep, forces, &lower), STATUS_OK);
}

#endif
