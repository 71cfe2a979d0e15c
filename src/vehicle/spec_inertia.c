/* Masses and inertias that no body has, as exporters write them. MuJoCo refuses them. */
#include <math.h>

#include "vehicle/spec.h"

#define MASS_LEAST 1e-3  /* kg: of a link that moves and has none */
#define INERTIA_LEAST 1e-12 /* kg m2: in a URDF less is none, since MuJoCo refuses less than 1e-15 */
#define DENSITY 1000.0   /* kg/m3: of a ball that gives an inertia to a mass without one */

static double ball_inertia(double mass)
{
	const double radius = cbrt(3 * mass / (4 * M_PI * DENSITY));
	return 0.4 * mass * radius * radius;
}

/* The principal moments, in rising order. */
static void moments_of(const mjsBody *body, double moments[3])
{
	const double *full = body->fullinertia;
	double vectors[9], quat[4];
	if (isnan(full[0])) {
		mju_copy3(moments, body->inertia);
	} else {
		const double matrix[9] = {full[0], full[3], full[4], full[3], full[1], full[5], full[4], full[5], full[2]};
		(void)mju_eig3(moments, vectors, quat, matrix);
	}
	for (int i = 0; i < 2; i++)
		for (int k = 0; k < 2 - i; k++)
			if (moments[k] > moments[k + 1]) {
				const double swap = moments[k];
				moments[k] = moments[k + 1];
				moments[k + 1] = swap;
			}
}

static void set_round(mjsBody *body, double inertia)
{
	for (int i = 0; i < 3; i++)
		body->inertia[i] = inertia;
	body->fullinertia[0] = (double)NAN;
}

/* The mass that moves with a joint of this body: its own, and of what is fixed to it. */
static double mass_with(const mjsBody *body)
{
	double mass = body->explicitinertial ? body->mass : 0;
	if (!body->explicitinertial && mjs_firstChild(body, mjOBJ_GEOM, 0) != NULL)
		return INFINITY; /* its shapes give one */
	for (mjsElement *child = mjs_firstChild(body, mjOBJ_BODY, 0); child != NULL; child = mjs_nextChild(body, child, 0))
		if (mjs_firstChild(mjs_asBody(child), mjOBJ_JOINT, 0) == NULL)
			mass += mass_with(mjs_asBody(child));
	return mass;
}

void vehicle_spec_inertias(struct spec *spec)
{
	struct spec_names light = {.count = 0}, round = {.count = 0}, balanced = {.count = 0};
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_BODY); each != NULL; each = mjs_nextElement(spec->spec, each)) {
		mjsBody *body = mjs_asBody(each);
		const char *name = mjs_getString(mjs_getName(each));
		const bool moves = mjs_firstChild(body, mjOBJ_JOINT, 0) != NULL;
		if (moves && mass_with(body) < MASS_LEAST / 1000) {
			body->explicitinertial = 1;
			body->mass = MASS_LEAST;
			set_round(body, ball_inertia(MASS_LEAST));
			vehicle_spec_name(&light, name);
		}
		if (!body->explicitinertial || !(body->mass > 0))
			continue;
		double moments[3];
		moments_of(body, moments);
		if (!(moments[0] > (spec->urdf ? INERTIA_LEAST : 0))) {
			set_round(body, fmax(fmax((moments[0] + moments[1] + moments[2]) / 3, ball_inertia(body->mass)), spec->urdf ? 2 * INERTIA_LEAST : 0));
			vehicle_spec_name(&round, name);
		} else if (moments[0] + moments[1] < moments[2] * (1 - 1e-12)) {
			set_round(body, (moments[0] + moments[1] + moments[2]) / 3);
			vehicle_spec_name(&balanced, name);
		}
	}
	if (light.count > 0)
		vehicle_spec_tell(spec, "%zu link%s that move%s without a mass (%s): %g kg each is added", light.count, light.count > 1 ? "s" : "", light.count > 1 ? "" : "s", light.text,
				  MASS_LEAST);
	if (round.count > 0)
		vehicle_spec_tell(spec, "%zu inertia%s that %s not positive (%s): that of a ball is taken", round.count, round.count > 1 ? "s" : "", round.count > 1 ? "are" : "is", round.text);
	if (balanced.count > 0)
		vehicle_spec_tell(spec, "%zu inertia%s that no body can have, one moment above the sum of the others (%s): their mean is taken", balanced.count,
				  balanced.count > 1 ? "s" : "", balanced.text);
}
