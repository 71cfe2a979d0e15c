/*
 * Position servos that Furrow gives a URDF are as stiff as their torque allows. A finger of some grams whose file has an effort of 1000 N m would swing ever more.
 * MuJoCo takes a servo's stiffness k at a step's start, and its damping at the end. I is the inertia of the joint, and h the step. A servo that is damped critically
 * is stable for h sqrt(k / I) below 2 + 2 sqrt(2). Half of that leaves room for joints that move together. What is stiffer gets k = SWING^2 I / h^2.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "vehicle/internal.h"
#include "vehicle/load.h"

#define SWING 2.0 /* h sqrt(k / I) */
#define NAMED 3   /* servos that are named */

/* Softens one servo if it is too stiff for a step of h seconds. Returns true if it was. */
static bool soften(mjModel *model, int actuator, double h)
{
	double *gain = &model->actuator_gainprm[mjNGAIN * actuator], *bias = &model->actuator_biasprm[mjNBIAS * actuator];
	const int joint = model->actuator_trnid[2 * actuator];
	if (model->actuator_trntype[actuator] != mjTRN_JOINT || model->actuator_biastype[actuator] != mjBIAS_AFFINE || !(bias[1] < 0))
		return false;
	const double inverse = model->dof_invweight0[model->jnt_dofadr[joint]], most = inverse > 0 ? SWING * SWING / (inverse * h * h) : INFINITY;
	if (!(gain[0] > most))
		return false;
	gain[0] = most;
	bias[1] = -most;
	bias[2] = -2 * sqrt(most / inverse);
	return true;
}

void vehicle_soften_servos(struct vehicles *vehicles)
{
	mjModel *model = vehicles->model;
	for (size_t v = 0; v < vehicles->count; v++) {
		const struct vehicle *vehicle = &vehicles->list[v];
		char names[256] = "";
		size_t count = 0;
		for (int i = vehicle->own.actuator.first; i < vehicle->own.actuator.end && vehicle->is_urdf; i++) { /* a URDF has no actuators of its own */
			if (!soften(model, i, model->opt.timestep))
				continue;
			const char *name = vehicle_part_name(model, mjOBJ_ACTUATOR, i);
			const size_t used = strlen(names);
			if (count < NAMED)
				snprintf(names + used, sizeof names - used, "%s%.64s", count > 0 ? ", " : "", name != NULL ? name : "");
			count++;
		}
		if (count > 0)
			note("vehicles.%s: %zu position servo%s (%s%s) would be too stiff for the mass that %s, in steps of %.3g s: softened as far as needed; a shorter time_step keeps more", vehicle->scene->name,
			     count, count == 1 ? "" : "s", names, count > NAMED ? ", ..." : "", count == 1 ? "it moves" : "they move", model->opt.timestep);
	}
}
