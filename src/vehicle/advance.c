/* The engine's steps of one time step. */
#include <math.h>

#include "vehicle/drives.h"
#include "vehicle/linear.h"
#include "vehicle/powertrain.h"

#define LIMITED_MOST 3 /* a step whose contacts reach their limits is repeated at most so many times */

/* What the actuators do in an engine step: their force times the mean of the velocities at its start and end. */
static double work_of(const struct vehicle *vehicle, const double *before)
{
	double work = 0;
	for (int i = vehicle->own.dof.first; i < vehicle->own.dof.end; i++)
		work += vehicle->data->qfrc_actuator[i] * (before[i] + vehicle->data->qvel[i]) / 2;
	return work;
}

/* Finds what takes the level motion and the yaw of a body away, as a crane does. The other velocities change as an impulse changes them. Adds
 * the change to `less`: nv. `room`: 12 nv. */
static void hold_level(const struct vehicle *vehicle, int body, double *room, double *less)
{
	const mjModel *model = vehicle->model;
	mjData *data = vehicle->data;
	const int nv = model->nv;
	double *rows = room, *solved = rows + 6 * nv, matrix[9], motion[3];
	mj_jacBody(model, data, rows, rows + 3 * nv, body);
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
	for (int i = 0; i < 3; i++)
		mju_addToScl(less, solved + i * nv, -motion[i], nv);
}

/* Holds each vehicle over its place, and each thing of `world` that moves freely. */
static void hold_all(struct vehicles *vehicles, double h)
{
	const mjModel *model = vehicles->model;
	mjData *data = vehicles->data;
	double *less = vehicles->room + 12 * model->nv;
	mju_zero(less, model->nv);
	mj_factorM(model, data);
	for (size_t v = 0; v < vehicles->all; v++) {
		const struct vehicle *vehicle = &vehicles->list[v];
		if (!vehicle->is_world)
			hold_level(vehicle, vehicle->root, vehicles->room, less);
		for (int body = vehicle->own.body.first; body < vehicle->own.body.end && vehicle->is_world; body++)
			if (model->body_parentid[body] == 0 && model->body_dofnum[body] == 6)
				hold_level(vehicle, body, vehicles->room, less);
	}
	mju_addTo(data->qvel, less, model->nv);
	mj_integratePos(model, data->qpos, less, h);
}

/* Sums what actuators, electric drives, powertrain and brakes did in a step. */
static void tell_works(struct vehicle *vehicle, double h, const double *before)
{
	vehicle->work += work_of(vehicle, before) * h;
	vehicle_drives_sum(vehicle, h, before);
	vehicle_train_sum(vehicle, h, before);
}

/* Stops wheels that are braked: with so much inertia even the slowest turn would count as motion. */
static void stop_wheels(struct vehicles *vehicles)
{
	for (size_t v = 0; v < vehicles->all; v++)
		for (size_t g = 0; g < vehicles->list[v].geom_count; g++)
			if (vehicle_turning_dof(&vehicles->list[v].geoms[g]) >= 0)
				vehicles->data->qvel[vehicle_turning_dof(&vehicles->list[v].geoms[g])] = 0;
}

/* Makes a step with the soil's forces at its end. `before`: nv, gets the velocities at its start. */
static void step_once(struct vehicles *vehicles, double h, double later, bool drives, double *before)
{
	const mjModel *model = vehicles->model;
	mjData *data = vehicles->data;
	vehicle_couple(vehicles, h, later, drives);
	mju_copy(before, data->qvel, model->nv);
	mj_getState(model, data, vehicles->kept, VEHICLE_KEPT);
	if (drives)
		vehicle_trains_solve(vehicles, h, true);
	mj_step2(model, data);
	for (int turn = 0; vehicle_couple_end(vehicles, h, before, drives) && turn < LIMITED_MOST; turn++) {
		mj_setState(model, data, vehicles->kept, VEHICLE_KEPT);
		if (drives)
			vehicle_trains_solve(vehicles, h, false);
		mj_step2(model, data);
	}
}

void vehicle_advance(struct vehicles *vehicles, double time, double seconds, double rate, bool drives)
{
	const mjModel *model = vehicles->model;
	mjData *data = vehicles->data;
	const double h = seconds / vehicles->engine_steps;
	double *before = vehicles->room + 14 * model->nv;
	for (int i = 0; i < vehicles->engine_steps; i++) {
		for (size_t v = 0; v < vehicles->all; v++)
			vehicle_push_bodies(&vehicles->list[v], time + i * h, h, drives);
		mj_step1(model, data);
		for (size_t v = 0; v < vehicles->all; v++)
			vehicle_control(&vehicles->list[v], time + i * h, drives);
		step_once(vehicles, h, (vehicles->engine_steps - 1 - i) * h, drives, before);
		for (size_t v = 0; v < vehicles->all && drives; v++)
			tell_works(&vehicles->list[v], h, before);
		vehicle_couple_done(vehicles, h, before, drives);
		vehicle_feel(vehicles, h, before);
		if (rate > 0) {
			hold_all(vehicles, h);
			mju_scl(data->qvel, data->qvel, exp(-rate * h), model->nv);
		}
	}
	if (!drives)
		stop_wheels(vehicles);
	vehicle_find_places(vehicles);
}

void vehicle_find_places(struct vehicles *vehicles)
{
	const mjModel *model = vehicles->model;
	mjData *data = vehicles->data;
	double *as_they_are = vehicles->room;
	/* This makes quaternions in qpos of length 1, and again if it is called again, which may change their last bits. So they stay as the step
	 * left them, and a run that is resumed from them finds the same places. */
	mju_copy(as_they_are, data->qpos, model->nq);
	mj_kinematics(model, data);
	mju_copy(data->qpos, as_they_are, model->nq);
	mj_comPos(model, data);
	mj_comVel(model, data);
}

void vehicle_find_inertia(struct vehicles *vehicles)
{
	vehicle_find_places(vehicles);
	mj_makeM(vehicles->model, vehicles->data);
	mj_factorM(vehicles->model, vehicles->data);
}
