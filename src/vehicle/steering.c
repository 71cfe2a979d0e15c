/*
 * What the driver's actuators do to the wheels, found by trial when the model is read.
 *
 * In the first pose the lengths of actuators are changed a little. Joints follow by the shortest way that keeps all equalities: connect, weld,
 * joint, tendon. So a wheel may be turned by a hinge of its own, by a rack, or by another joint that it follows. It may also turn with half of the
 * vehicle. For each curvature of a table those lengths are found with which the wheels slip least to their sides on such a way. For curvatures
 * between two rows of the table the driver interpolates.
 *
 * A vehicle is plain if each steering actuator is of an upright hinge that turns its own wheel alone. Each driving one is of the hinge of its wheel
 * or belt. It needs no table: pursuit.c has the angles by geometry.
 */
#include <math.h>

#include "vehicle/steering.h"

#define FELT 0.02       /* of the trial: what turns or moves less has no effect */
#define UPRIGHT 0.9     /* how much of a hinge's axis looks up */

/* --- wheels --- */

/* Returns true if a joint lies between the wheel and the root that nothing but the ground turns. The wheel runs behind it, as a castor or a
 * trailer does. */
static bool runs_behind(const struct trial *trial, int body)
{
	const mjModel *model = trial->model;
	const struct vehicle *vehicle = trial->vehicle;
	double axes[9];
	vehicle_root_axes(vehicle, trial->data, axes);
	for (; body > 0 && body != vehicle->root; body = model->body_parentid[body])
		for (int j = model->body_jntadr[body]; j >= 0 && j < model->body_jntadr[body] + model->body_jntnum[body]; j++) {
			const double *axis = &trial->data->xaxis[3 * j];
			const double up = fabs(axis[0] * axes[2] + axis[1] * axes[5] + axis[2] * axes[8]);
			const int dof = model->jnt_dofadr[j] - vehicle->own.dof.first;
			bool moved = model->jnt_stiffness[j] > 0;
			for (int i = 0; i < trial->steer_count && !moved; i++)
				moved = trial->rows[i * vehicle_trial_dofs(trial) + dof] != 0;
			if (model->jnt_type[j] == mjJNT_BALL || model->jnt_type[j] == mjJNT_FREE || (model->jnt_type[j] == mjJNT_HINGE && up > UPRIGHT && !moved))
				return true;
		}
	return body != vehicle->root;
}

static void find_wheels(struct trial *trial, const double *steered)
{
	const struct vehicle *vehicle = trial->vehicle;
	mju_copy(trial->rows, steered, trial->steer_count * vehicle_trial_dofs(trial));
	for (size_t g = 0; g < vehicle->geom_count; g++) {
		const struct soil_geom *geom = &vehicle->geoms[g];
		bool again = vehicle_turning_dof(geom) < 0;
		for (size_t w = 0; w < trial->wheel_count && !again; w++)
			again = trial->wheels[w].dof == vehicle_turning_dof(geom); /* twin tyres */
		if (!again)
			trial->wheels[trial->wheel_count++] =
				(struct rolling){vehicle_turning_dof(geom), geom->shape.belt, runs_behind(trial, trial->model->geom_bodyid[geom->geom]),
						 vehicle_turning_radius(geom), geom};
	}
}

/* --- what is plain, and what has no effect --- */

static bool turns_its_own(const struct trial *trial, int i, const double *motion)
{
	const mjModel *model = trial->model;
	const int actuator = trial->steer[i], joint = model->actuator_trnid[2 * actuator];
	double axes[9];
	if (model->actuator_trntype[actuator] != mjTRN_JOINT || model->jnt_type[joint] != mjJNT_HINGE || !vehicle_keeps_place(model, actuator))
		return false;
	for (int d = 0; d < vehicle_trial_dofs(trial); d++)
		if (d + trial->vehicle->own.dof.first != model->jnt_dofadr[joint] && fabs(motion[d]) > 1e-6)
			return false;
	vehicle_root_axes(trial->vehicle, trial->data, axes);
	const double *axis = &trial->data->xaxis[3 * joint];
	if (fabs(axis[0] * axes[2] + axis[1] * axes[5] + axis[2] * axes[8]) < 0.7)
		return false;
	for (size_t w = 0; w < trial->wheel_count; w++) { /* wheels that it turns stand near it */
		const struct rolling *wheel = &trial->wheels[w];
		int body = model->geom_bodyid[wheel->geom->geom];
		while (body > 0 && body != model->jnt_bodyid[joint])
			body = model->body_parentid[body];
		double from[3];
		mju_sub3(from, &trial->data->geom_xpos[3 * wheel->geom->geom], &trial->data->xanchor[3 * joint]);
		mju_addToScl3(from, axis, -mju_dot3(from, axis));
		if (body > 0 && mju_norm3(from) > 1.5 * fabs(wheel->radius) + 0.01)
			return false;
	}
	return true;
}

static bool is_plain(const struct trial *trial, const double *steered)
{
	const mjModel *model = trial->model;
	bool plain = true;
	for (int i = 0; i < trial->steer_count && plain; i++)
		plain = turns_its_own(trial, i, steered + i * vehicle_trial_dofs(trial));
	for (int i = 0; i < trial->drive_count && plain; i++)
		plain = model->actuator_trntype[trial->drive[i]] == mjTRN_JOINT && vehicle_driven(trial->vehicle, model->actuator_trnid[2 * trial->drive[i]]) != NULL;
	return plain;
}

/* Returns true if a steering actuator turns or shifts what touches the ground. */
static bool has_effect(struct trial *trial, int i)
{
	const struct vehicle *vehicle = trial->vehicle;
	double change[ROWS_MOST] = {0};
	const double gear = fmax(fabs(vehicle_gear(trial->model, trial->steer[i])[0]), mjMINVAL);
	change[i] = TRIAL * gear;
	if (!vehicle_trial_pose(trial, change))
		return true; /* not known */
	bool felt = false;
	for (size_t g = 0; g < vehicle->geom_count && !felt; g++) {
		const int geom = vehicle->geoms[g].geom;
		const double *was = &vehicle->data->geom_xmat[9 * geom], *now = &trial->data->geom_xmat[9 * geom];
		double far = mju_dist3(&vehicle->data->geom_xpos[3 * geom], &trial->data->geom_xpos[3 * geom]);
		/* A wheel that only turns about its own axle is not steered. */
		for (int k = 0; k < 3; k++)
			far = fmax(far, vehicle->geoms[g].dof >= 0 && !vehicle->geoms[g].shape.belt ? 0 : fabs(now[k] - was[k]));
		if (vehicle->geoms[g].dof >= 0 && !vehicle->geoms[g].shape.belt) {
			const int joint = trial->model->dof_jntid[vehicle->geoms[g].dof];
			far = fmax(far, mju_dist3(&vehicle->data->xaxis[3 * joint], &trial->data->xaxis[3 * joint]));
		}
		felt = far > FELT * TRIAL;
	}
	return felt;
}

static void tell_idle(struct trial *trial, const char *where)
{
	for (int i = 0; i < trial->steer_count; i++)
		if (!has_effect(trial, i))
			note("%s: driver.steer: %s turns nothing that touches the ground, so it has no effect; name the actuators that turn wheels or halves", where,
			     vehicle_part_name(trial->model, mjOBJ_ACTUATOR, trial->steer[i]));
}

/* --- all of it --- */

static bool measure(struct trial *trial, struct steering *steering, const char *where)
{
	const size_t own = (size_t)vehicle_trial_dofs(trial);
	double *steered = mem_calloc((size_t)trial->steer_count * own + 1, sizeof *steered), *driven = mem_calloc((size_t)trial->drive_count * own + 1, sizeof *driven);
	bool done = steered != NULL && driven != NULL;
	mju_copy(trial->data->qpos, trial->vehicle->data->qpos, trial->model->nq);
	mj_fwdPosition(trial->model, trial->data);
	for (int i = 0; i < trial->steer_count; i++)
		trial->length0[i] = trial->data->actuator_length[trial->model->actuator_outadr[trial->steer[i]]];
	done = done && vehicle_trial_motions(trial, trial->steer, trial->steer_count, steered) && vehicle_trial_motions(trial, trial->drive, trial->drive_count, driven);
	if (done) {
		find_wheels(trial, steered);
		for (int i = 0; i < trial->drive_count; i++)
			for (size_t w = 0; w < trial->wheel_count; w++)
				trial->share[(size_t)i * trial->wheel_count + w] = driven[(size_t)i * own + (size_t)(trial->wheels[w].dof - trial->vehicle->own.dof.first)];
		for (int i = 0; i < trial->drive_count; i++)
			steering->idle[i] = mju_norm(trial->share + (size_t)i * trial->wheel_count, (int)trial->wheel_count) < FELT * TRIAL;
		steering->plain = is_plain(trial, steered);
		if (where != NULL)
			tell_idle(trial, where);
	}
	if (done && !steering->plain)
		done = trial->wheel_count > 0 && vehicle_trial_table(trial, steering);
	mem_free_all(steered, driven);
	return done;
}

static enum status make_room(struct trial *trial, struct steering *steering)
{
	const size_t own = range_count(trial->vehicle->own.dof), steer = (size_t)trial->steer_count, drive = (size_t)trial->drive_count, rows = 2 * EACH_WAY + 1, wheels = trial->vehicle->geom_count;
	TRY(mem_zeroed(&trial->length0, steer + 1, sizeof *trial->length0, "a driver"));
	TRY(mem_zeroed(&trial->wheels, trial->vehicle->geom_count + 1, sizeof *trial->wheels, "a driver"));
	TRY(mem_zeroed(&trial->rows, ROWS_MOST * own + 1, sizeof *trial->rows, "a driver"));
	TRY(mem_zeroed(&trial->matrix, ROWS_MOST * ROWS_MOST, sizeof *trial->matrix, "a driver"));
	TRY(mem_zeroed(&trial->right, ROWS_MOST + (size_t)trial->model->nv, sizeof *trial->right, "a driver"));
	TRY(mem_zeroed(&trial->share, drive * trial->vehicle->geom_count + 1, sizeof *trial->share, "a driver"));
	TRY(mem_zeroed(&trial->fitting, wheels * (steer + 3) + (steer + 1) * (steer + 3), sizeof *trial->fitting, "a driver"));
	TRY(mem_zeroed(&steering->idle, drive + 1, sizeof *steering->idle, "a driver"));
	TRY(mem_zeroed(&steering->curvatures, rows, sizeof *steering->curvatures, "a driver"));
	TRY(mem_zeroed(&steering->lengths, rows * steer + 1, sizeof *steering->lengths, "a driver"));
	TRY(mem_zeroed(&steering->rates, rows * drive + 1, sizeof *steering->rates, "a driver"));
	trial->data = mj_makeData(trial->model);
	return trial->data != NULL ? STATUS_OK : fail_memory("a driver");
}

static bool all_hinges(const struct trial *trial)
{
	bool all = true;
	for (int i = 0; i < trial->steer_count + trial->drive_count && all; i++) {
		const int actuator = i < trial->steer_count ? trial->steer[i] : trial->drive[i - trial->steer_count];
		all = trial->model->actuator_trntype[actuator] == mjTRN_JOINT && trial->model->jnt_type[trial->model->actuator_trnid[2 * actuator]] == mjJNT_HINGE;
	}
	return all;
}

struct job {
	struct trial *trial;
	struct steering *steering;
	const char *where; /* NULL: nothing is told */
	bool done;
};

static void act(void *argument)
{
	struct job *job = argument;
	job->done = measure(job->trial, job->steering, job->where);
}

enum status vehicle_measure(struct vehicle *vehicle, const char *where, bool tell)
{
	struct driver *driver = &vehicle->driver;
	struct trial trial = {.vehicle = vehicle, .model = vehicle->model, .steer = driver->steer, .drive = driver->drive,
			      .steer_count = (int)driver->steer_count, .drive_count = (int)driver->drive_count};
	struct job job = {&trial, &driver->steering, tell ? where : NULL, false};
	enum status status;
	TRY_OR(done, make_room(&trial, &driver->steering));
	TRY_OR(done, vehicle_guard(vehicle->scene->name, act, &job));
	if (!job.done && all_hinges(&trial))
		driver->steering.plain = true; /* nothing is known beyond its hinges */
	else if (!job.done)
		status = fail_with(STATUS_INPUT, "%s: driver: how its actuators turn wheels cannot be found: its equalities contradict each other in its first pose, or there are more "
						 "than %d; start it from a keyframe that fits them, or drive it by controls", where, ROWS_MOST);
done:
	if (trial.data != NULL)
		mj_deleteData(trial.data);
	mem_free_all(trial.length0, trial.wheels, trial.rows, trial.matrix, trial.right, trial.share, trial.fitting);
	return status;
}

void vehicle_free_steering(struct steering *steering)
{
	mem_free_all(steering->curvatures, steering->lengths, steering->rates, steering->idle);
}
