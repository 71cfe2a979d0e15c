/* One contact of an object, and the height at which the soil carries it. */
#include <assert.h>
#include <math.h>

#include "deform/reference/reference.h"

#define DEEPEST 1024 /* metres: no offset goes further */

enum status reference_load(const struct reference_ground *ground, const struct soil_numbers *soil,
			   const struct deform_contact *sweep, const double *under, const double *rest, double *lower)
{
	/* From where it does not touch the ground to where it is carried. */
	double low = INFINITY, step = 1e-3;
	for (int i = 0; i < ground->width * ground->height; i++)
		if (rest[i] < INFINITY && !ground->hole[i])
			low = fmin(low, fmin(under[i], rest[i]) - ground->base[i] - ground->heaped[i]);
	low -= ground->spacing; /* between posts it may be lower */
	double high = low;
	do {
		if (!(low < INFINITY) || step > DEEPEST)
			return fail_with(STATUS_INPUT, "load: no ground under the object carries %g N; set it on the ground",
					 sweep->load);
		high += step;
		step *= 2;
	} while (reference_scm_vertical(ground, soil, sweep, under, rest, high) < sweep->load);
	for (int i = 0; i < 60; i++) {
		double middle = (low + high) / 2;
		if (reference_scm_vertical(ground, soil, sweep, under, rest, middle) < sweep->load)
			low = middle;
		else
			high = middle;
	}
	*lower = high;
	return STATUS_OK;
}

static enum status press(struct reference_ground *ground, const struct deform_params *params,
			 const struct deform_contact *sweep, const double *under, const double *rest,
			 struct reference_forces *forces, double *lower)
{
	const struct soil_numbers *soil = &params->soils[0];
	switch (params->model) {
	case DEFORM_NONE:
		reference_none(ground, under, rest);
		break;
	case DEFORM_SUMNER:
		reference_sumner(ground, soil, under, rest);
		break;
	case DEFORM_SLIPPAGE:
		reference_slippage(ground, under, rest);
		break;
	case DEFORM_SCM:
		if (sweep->load > 0) {
			enum status status = reference_load(ground, soil, sweep, under, rest, lower);
			if (status != STATUS_OK)
				return status;
		}
		reference_scm(ground, soil, params->bulldozing, sweep, under, rest, *lower, forces);
		break;
	case DEFORM_BOX_FILTER:
	case DEFORM_MODELS:
		assert(!"a model of this file");
	}
	return STATUS_OK;
}

enum status reference_sweep(struct reference_ground *ground, const struct deform_params *params,
			    const struct deform_contact *sweep, struct reference_forces *forces, double *lower)
{
	assert(sweep->load == 0 || params->model == DEFORM_SCM);
	size_t count = (size_t)ground->width * (size_t)ground->height;
	double *under = mem_alloc(count, sizeof *under), *rest = mem_alloc(count, sizeof *rest), moved;
	enum status status = STATUS_OK;
	*forces = (struct reference_forces){0};
	ground->ground_normals = params->ground_normals;
	*lower = 0;
	if (under == NULL || rest == NULL) {
		status = fail_memory("reference");
	} else {
		reference_undersides(ground, sweep, under, rest);
		status = press(ground, params, sweep, under, rest, forces, lower);
	}
	mem_free(under);
	mem_free(rest);
	if (status != STATUS_OK || params->model == DEFORM_NONE)
		return status;
	struct reference_laying laying;
	status = reference_spread(ground, params, sweep, &laying);
	return status == STATUS_OK ? reference_slide(ground, params, params->iterations, 0, &moved) : status;
}
