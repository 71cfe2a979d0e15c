/* The engine's steps of one time step. */
#include <math.h>

#include "vehicle/internal.h"
#include "vehicle/linear.h"

#define BRAKE 1e12     /* kg m2: inertia of a wheel that does not turn, */
#define BRAKE_SOFT 1e6 /* or times its own, where the model has constraints: with more, MuJoCo's solver of constraints does not converge */

/* What the actuators do in an engine step: their force times the mean of the velocities at its start and end. */
static double work_of(const struct vehicle *vehicle, const double *before)
{
	const int nv = vehicle->model->nv;
	double work = 0;
	for (int i = 0; i < nv; i++)
		work += vehicle->data->qfrc_actuator[i] * (before[i] + vehicle->data->qvel[i]) / 2;
	return work;
}

/* Takes the level motion and the yaw of the root body in the last h seconds away, as a crane does. The other velocities change as an
 * impulse changes them. */
static void hold_level(struct vehicle *vehicle, double h)
{
	const mjModel *model = vehicle->model;
	mjData *data = vehicle->data;
	const int nv = model->nv;
	double *rows = vehicle->room, *solved = rows + 6 * nv, matrix[9], motion[3];
	mj_jacBody(model, data, rows, rows + 3 * nv, vehicle->root);
	mju_copy(rows + 2 * nv, rows + 5 * nv, nv); /* x, y and the turn about z */
	mj_solveM(model, data, solved, rows, 3);
	for (int i = 0; i < 3; i++) {
		motion[i] = mju_dot(rows + i * nv, data->qvel, nv);
		for (int k = 0; k < 3; k++)
			matrix[3 * i + k] = mju_dot(rows + i * nv, solved + k * nv, nv);
		if (!(matrix[4 * i] > mjMINVAL)) { /* its joints do not move that way */
			matrix[4 * i] = 1;
			motion[i] = 0;
		}
	}
	if (!vehicle_solve(matrix, motion, 3))
		return;
	double *less = rows; /* from here on */
	mju_scl(less, solved, -motion[0], nv);
	for (int i = 1; i < 3; i++)
		mju_addToScl(less, solved + i * nv, -motion[i], nv);
	mju_addTo(data->qvel, less, nv);
	mj_integratePos(model, data->qpos, less, h);
}

/* Returns true if the model has equalities, limits, friction of joints, or tendons. */
static bool is_constrained(const struct vehicle *vehicle)
{
	const mjModel *model = vehicle->model;
	bool any = model->neq > 0 || model->ntendon > 0;
	for (int i = vehicle->own.joint.first; i < vehicle->own.joint.end && !any; i++)
		any = model->jnt_limited[i];
	for (int i = vehicle->own.dof.first; i < vehicle->own.dof.end && !any; i++)
		any = model->dof_frictionloss[i] > 0;
	return any;
}

/* Gives wheels so much inertia that they do not turn, or what the model gives them. Then it stops them: with so much inertia even the
 * slowest turn would count as motion. */
static void brake(const struct vehicle *vehicle, bool braked)
{
	const bool constrained = is_constrained(vehicle);
	for (size_t g = 0; g < vehicle->geom_count; g++) {
		const struct soil_geom *geom = &vehicle->geoms[g];
		const int dof = vehicle_turning_dof(geom);
		if (dof < 0)
			continue;
		vehicle->model->dof_armature[dof] = !braked ? geom->armature : constrained ? BRAKE_SOFT * vehicle->model->dof_M0[dof] : BRAKE;
		if (!braked)
			vehicle->data->qvel[dof] = 0;
	}
}

/* Begins a step of the engine: finds all forces but the soil's. */
static void begin_step(struct vehicle *vehicle, double time, bool drives)
{
	mju_copy(vehicle->data->qfrc_applied, vehicle->pushed, vehicle->model->nv);
	mj_step1(vehicle->model, vehicle->data);
	vehicle_control(vehicle, time, drives);
	mj_fwdActuation(vehicle->model, vehicle->data);
	mj_fwdAcceleration(vehicle->model, vehicle->data);
}

void vehicle_prepare(struct vehicle *vehicle, double time, bool drives)
{
	mju_zero(vehicle->pushed, vehicle->model->nv);
	if (!drives)
		brake(vehicle, true);
	begin_step(vehicle, time, drives);
}

void vehicle_advance(struct vehicle *vehicle, double time, double seconds, double rate, bool drives)
{
	const mjModel *model = vehicle->model;
	mjData *data = vehicle->data;
	const double h = seconds / vehicle->engine_steps;
	double *before = vehicle->room + vehicle_coupling_room(vehicle) - (size_t)model->nv;
	mju_addTo(data->qfrc_applied, vehicle->pushed, model->nv);
	mju_addTo(data->qfrc_smooth, vehicle->pushed, model->nv);
	for (int i = 0; i < vehicle->engine_steps; i++) {
		if (i > 0)
			begin_step(vehicle, time + i * h, drives);
		vehicle_couple(vehicle, h, (vehicle->engine_steps - 1 - i) * h);
		mju_copy(before, data->qvel, model->nv);
		mj_step2(model, data);
		if (rate > 0) {
			hold_level(vehicle, h);
			mju_scl(data->qvel, data->qvel, exp(-rate * h), model->nv);
		}
		if (!drives)
			continue;
		vehicle->work += work_of(vehicle, before) * h;
		vehicle_couple_work(vehicle, h, before);
	}
	if (!drives)
		brake(vehicle, false);
	vehicle_find_places(vehicle);
}

void vehicle_find_places(struct vehicle *vehicle)
{
	const mjModel *model = vehicle->model;
	mjData *data = vehicle->data;
	double *as_they_are = vehicle->room;
	/* This makes quaternions in qpos of length 1, and again if it is called again, which may change their last bits. So they stay as the step
	 * left them, and a run that is resumed from them finds the same places. */
	mju_copy(as_they_are, data->qpos, model->nq);
	mj_kinematics(model, data);
	mju_copy(data->qpos, as_they_are, model->nq);
	mj_comPos(model, data);
	mj_comVel(model, data);
}
