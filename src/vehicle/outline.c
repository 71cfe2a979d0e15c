/* What of a vehicle decides where it can drive: its masses and wheels, in the model's first pose. */
#include <math.h>
#include <stdio.h>

#include "vehicle/internal.h"

/* Returns the joint about whose axis a wheel turns. */
static int joint_of(const struct vehicle *vehicle, const struct soil_geom *geom)
{
	return vehicle->model->dof_jntid[geom->dof];
}

/* The most torque that actuators give a joint: 0: none drives it. INFINITY: they are not limited. */
static double torque_of(const mjModel *model, int joint)
{
	double most = 0;
	for (int i = 0; i < model->nactuator; i++) {
		if (model->actuator_trntype[i] != mjTRN_JOINT || model->actuator_trnid[2 * i] != joint)
			continue;
		const double gear = fabs(vehicle_gear(model, i)[0]);
		const double *force = model->actuator_forcerange + 2 * i, *control = model->actuator_ctrlrange + 2 * model->actuator_ctrladr[i];
		const bool motor = model->actuator_gaintype[i] == mjGAIN_FIXED && model->actuator_biastype[i] == mjBIAS_NONE;
		if (model->actuator_forcelimited[i])
			most += gear * fmax(fabs(force[0]), fabs(force[1]));
		else if (motor && model->actuator_ctrllimited[model->actuator_ctrladr[i]])
			most += gear * fabs(model->actuator_gainprm[mjNGAIN * i]) * fmax(fabs(control[0]), fabs(control[1]));
		else
			return INFINITY;
	}
	return most;
}

static bool is_wheel(const struct soil_geom *geom)
{
	return geom->dof >= 0 && !geom->shape.belt;
}

/* A hull that collides is a soil geom, but hangs above the ground. So it counts as belly. */
static bool is_on_ground(const struct vehicle *vehicle, int geom, double ground)
{
	const struct soil_geom *soil = vehicle_soil_geom_of(vehicle, geom);
	return soil != NULL && (is_wheel(soil) || vehicle_geom_lowest(vehicle, geom) <= ground);
}

/* Finds the centre of gravity. */
static void find_balance(const struct vehicle *vehicle, double place[3])
{
	mju_zero3(place);
	for (int body = vehicle->own.body.first; body < vehicle->own.body.end; body++)
		mju_addToScl3(place, &vehicle->data->xipos[3 * body], vehicle->model->body_mass[body]);
	mju_scl3(place, place, 1 / vehicle_mass(vehicle));
}

static enum status outline(const struct vehicle *vehicle, struct vehicle_outline *out)
{
	const mjModel *model = vehicle->model;
	const mjData *data = vehicle->data;
	double axes[9], ground = INFINITY, belly = INFINITY, middle[3];
	vehicle_root_axes(vehicle, data, axes);
	find_balance(vehicle, middle);
	*out = (struct vehicle_outline){.mass = vehicle_mass(vehicle)};
	snprintf(out->name, sizeof out->name, "%s", vehicle->scene->name);
	for (size_t i = 0; i < vehicle->geom_count; i++)
		ground = fmin(ground, vehicle_geom_lowest(vehicle, vehicle->geoms[i].geom));
	for (int geom = vehicle->own.geom.first; geom < vehicle->own.geom.end; geom++)
		if (!is_on_ground(vehicle, geom, ground) && !vehicle_is_fixed(model, geom))
			belly = fmin(belly, vehicle_geom_lowest(vehicle, geom));
	out->height = middle[2] - ground;
	out->clearance = belly - ground;
	for (size_t i = 0; i < vehicle->geom_count; i++) {
		const struct soil_geom *geom = &vehicle->geoms[i];
		if (!is_on_ground(vehicle, geom->geom, ground))
			continue;
		if (!is_wheel(geom))
			return fail_with(STATUS_INPUT, "%s: touches the ground with more than wheels; only vehicles on wheels have an outline", geom->name);
		if (out->wheel_count == VEHICLE_WHEELS_MOST)
			return fail_with(STATUS_INPUT, "%s: it has more than %d wheels; give a model with fewer", vehicle->scene->name, VEHICLE_WHEELS_MOST);
		const double *at = data->geom_xpos + 3 * geom->geom, away[3] = {at[0] - middle[0], at[1] - middle[1], at[2] - middle[2]};
		const double torque = torque_of(model, joint_of(vehicle, geom));
		out->wheels[out->wheel_count++] = (struct vehicle_wheel){
			.x = axes[0] * away[0] + axes[3] * away[1] + axes[6] * away[2],
			.y = axes[1] * away[0] + axes[4] * away[1] + axes[7] * away[2],
			.radius = geom->shape.radius,
			.width = geom->shape.width,
			.driven = torque > 0,
			.torque_most = torque,
		};
	}
	return STATUS_OK;
}

enum status vehicle_outline(const struct scene *scene, size_t vehicle, struct vehicle_outline *out)
{
	struct vehicles *vehicles = NULL;
	struct scene still = *scene;
	still.time_step = 0;
	TRY(vehicle_load(&still, &vehicles));
	if (vehicle >= vehicle_count(vehicles)) {
		vehicle_destroy(vehicles);
		return fail_with(STATUS_INPUT, "scene: it has no vehicle; add one to vehicles");
	}
	vehicle_find_inertia(vehicles);
	enum status status = outline(&vehicles->list[vehicle], out);
	vehicle_destroy(vehicles);
	return status;
}
