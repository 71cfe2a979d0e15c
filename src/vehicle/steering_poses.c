/*
 * Poses of a trial of the steering: joints follow a change of actuators' lengths by the shortest way that keeps all equalities.
 */
#include <math.h>
#include <string.h>

#include "vehicle/linear.h"
#include "vehicle/steering.h"

#define NEWTON 12 /* steps that find a pose */

/* The root's own freedoms stay. */
static bool is_held(const struct trial *trial, int dof)
{
	const mjModel *model = trial->model;
	return model->dof_bodyid[dof] == trial->vehicle->root || model->jnt_type[model->dof_jntid[dof]] == mjJNT_FREE;
}

static void add_moment(const struct trial *trial, int actuator, double *row)
{
	const mjData *data = trial->data;
	const int out = trial->model->actuator_outadr[actuator], first = trial->vehicle->own.dof.first, end = trial->vehicle->own.dof.end;
	for (int k = 0; k < data->moment_rownnz[out]; k++) {
		const int dof = data->moment_colind[data->moment_rowadr[out] + k];
		if (dof >= first && dof < end && !is_held(trial, dof))
			row[dof - first] = data->actuator_moment[data->moment_rowadr[out] + k];
	}
}

/* Adds an equality. Returns false if it does not move this vehicle's joints. */
static bool add_equality(const struct trial *trial, int equality, double *row)
{
	const mjData *data = trial->data;
	const int first = trial->vehicle->own.dof.first, count = vehicle_trial_dofs(trial), nv = trial->model->nv;
	const bool sparse = mj_isSparse(trial->model);
	const int entries = sparse ? data->efc_J_rownnz[equality] : nv;
	bool any = false;
	for (int k = 0; k < entries; k++) {
		const int dof = sparse ? data->efc_J_colind[data->efc_J_rowadr[equality] + k] : k;
		const double value = sparse ? data->efc_J[data->efc_J_rowadr[equality] + k] : data->efc_J[equality * nv + k];
		if (dof < first || dof >= first + count || is_held(trial, dof) || value == 0)
			continue;
		row[dof - first] = value;
		any = true;
	}
	return any;
}

/* Fills rows of all equalities, and of the listed actuators before them. `right`: what is lacking. Returns their number; -1: too many. */
static int fill_rows(struct trial *trial, const int *actuators, int actuator_count, const double *lacks)
{
	const int count = vehicle_trial_dofs(trial);
	int rows = 0;
	if (actuator_count + trial->data->ne > ROWS_MOST)
		return -1;
	for (int i = 0; i < actuator_count; i++, rows++) {
		memset(trial->rows + rows * count, 0, (size_t)count * sizeof *trial->rows);
		add_moment(trial, actuators[i], trial->rows + rows * count);
		trial->right[rows] = lacks[i];
	}
	for (int e = 0; e < trial->data->ne; e++) {
		memset(trial->rows + rows * count, 0, (size_t)count * sizeof *trial->rows);
		if (add_equality(trial, e, trial->rows + rows * count))
			trial->right[rows++] = -trial->data->efc_pos[e];
	}
	return rows;
}

/* Finds the smallest motion of joints that does what the rows ask for, into `motion` (nv numbers, 0 elsewhere). */
static bool least_motion(struct trial *trial, int rows, double *motion)
{
	const int count = vehicle_trial_dofs(trial);
	double trace = 0;
	for (int i = 0; i < rows; i++)
		for (int k = 0; k < rows; k++)
			trial->matrix[i * rows + k] = mju_dot(trial->rows + i * count, trial->rows + k * count, count);
	for (int i = 0; i < rows; i++)
		trace += trial->matrix[i * rows + i];
	for (int i = 0; i < rows; i++)
		trial->matrix[i * rows + i] += 1e-12 * trace + mjMINVAL; /* two equalities may say the same */
	memset(motion, 0, (size_t)trial->model->nv * sizeof *motion);
	if (rows == 0 || !vehicle_solve(trial->matrix, trial->right, (size_t)rows))
		return rows == 0;
	for (int i = 0; i < rows; i++)
		mju_addToScl(motion + trial->vehicle->own.dof.first, trial->rows + i * count, trial->right[i], count);
	return true;
}

bool vehicle_trial_pose(struct trial *trial, const double *lengths)
{
	double lacks[ROWS_MOST], *motion = trial->right + ROWS_MOST;
	mju_copy(trial->data->qpos, trial->vehicle->data->qpos, trial->model->nq);
	for (int step = 0; step < NEWTON; step++) {
		double most = 0;
		mj_fwdPosition(trial->model, trial->data);
		for (int i = 0; i < trial->steer_count; i++) {
			lacks[i] = trial->length0[i] + lengths[i] - trial->data->actuator_length[trial->model->actuator_outadr[trial->steer[i]]];
			most = fmax(most, fabs(lacks[i]));
		}
		if (step > 0 && most < 1e-10)
			return true;
		const int rows = fill_rows(trial, trial->steer, trial->steer_count, lacks);
		if (rows < 0 || !least_motion(trial, rows, motion))
			return false;
		mj_integratePos(trial->model, trial->data->qpos, motion, 1);
	}
	mj_fwdPosition(trial->model, trial->data);
	return true;
}

bool vehicle_trial_motions(struct trial *trial, const int *actuators, int count, double *motions)
{
	const int own = vehicle_trial_dofs(trial);
	double one = 1, *motion = trial->right + ROWS_MOST;
	for (int i = 0; i < count; i++) {
		const int rows = fill_rows(trial, &actuators[i], 1, &one);
		for (int k = 1; k < rows; k++)
			trial->right[k] = 0;
		if (rows < 0 || !least_motion(trial, rows, motion))
			return false;
		mju_copy(motions + i * own, motion + trial->vehicle->own.dof.first, own);
	}
	return true;
}
