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
#include <string.h>

#include "vehicle/internal.h"
#include "vehicle/linear.h"

#define EACH_WAY 16     /* curvatures of the table to each side */
#define CLOSEST 0.75    /* of the wheelbase: the radius of the closest turn in it */
#define ROWS_MOST 400   /* equalities and actuators: with more, the model is taken for plain */
#define NEWTON 12       /* steps that find a pose */
#define FITTING 8       /* steps that find lengths for a curvature */
#define TRIAL 1e-3      /* rad or m: of a trial movement */
#define FELT 0.02       /* of the trial: what turns or moves less has no effect */
#define UPRIGHT 0.9     /* how much of a hinge's axis looks up */
#define SLIPS 0.05      /* rad: a turn in which wheels slip more to the side is beyond what the steering can do */
#define STIFF 1e-6      /* what a length costs, beside wheels that slip to the side */

/* A wheel or a belt, in the axes of the root body. */
struct rolling {
	int dof;
	bool belt;
	bool trails;          /* a castor's, or a trailer's: it heads where it is pulled */
	double radius;        /* m; signed for a belt */
	const struct soil_geom *geom;
};

struct trial {
	const struct vehicle *vehicle;
	mjModel *model;
	mjData *data;
	const int *steer, *drive;
	int steer_count, drive_count;
	double *length0;          /* of steering actuators in the first pose */
	struct rolling *wheels;
	size_t wheel_count;
	double *lengths;          /* steer_count: changes that are tried */
	double *rows, *matrix, *right; /* room: ROWS_MOST x dofs, ROWS_MOST squared, ROWS_MOST */
	double *share;            /* drive_count x wheel_count: rate of a wheel for a rate of the actuator */
	double *fitting;          /* room for fit */
};

/* --- poses --- */

static int dofs(const struct trial *trial)
{
	return (int)range_count(trial->vehicle->own.dof);
}

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
	const int first = trial->vehicle->own.dof.first, count = dofs(trial), nv = trial->model->nv;
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
	const int count = dofs(trial);
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
	const int count = dofs(trial);
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

/* Brings the trial's pose to that in which steering actuators are longer by `lengths`, from the first pose on. */
static bool pose(struct trial *trial, const double *lengths)
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

/* --- wheels --- */

/* A wheel as it is now: place and direction in which it rolls, in the vehicle's axes. */
static void stand(const struct trial *trial, const struct rolling *wheel, double place[2], double heading[2])
{
	const struct vehicle *vehicle = trial->vehicle;
	const mjData *data = trial->data;
	double axes[9], from[3], at[3], way[3], along[3];
	vehicle_root_axes(vehicle, data, axes);
	const int joint = trial->model->dof_jntid[wheel->dof];
	mju_sub3(from, wheel->belt ? &data->geom_xpos[3 * wheel->geom->geom] : &data->xanchor[3 * joint], &data->xpos[3 * vehicle->root]);
	mju_mulMatTVec3(at, axes, from);
	if (wheel->belt) {
		const double *mat = &data->geom_xmat[9 * wheel->geom->geom];
		mju_mulMatTVec3(way, axes, (const double[]){mat[0], mat[3], mat[6]});
	} else {
		mju_mulMatTVec3(along, axes, &data->xaxis[3 * joint]);
		mju_cross(way, along, (const double[]){0, 0, 1});
	}
	const double size = fmax(hypot(way[0], way[1]), mjMINVAL);
	for (int i = 0; i < 2; i++) {
		place[i] = at[i];
		heading[i] = way[i] / size;
	}
}

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
				moved = trial->rows[i * dofs(trial) + dof] != 0;
			if (model->jnt_type[j] == mjJNT_BALL || model->jnt_type[j] == mjJNT_FREE || (model->jnt_type[j] == mjJNT_HINGE && up > UPRIGHT && !moved))
				return true;
		}
	return body != vehicle->root;
}

/* Finds how joints move if one actuator alone becomes longer by 1, for each of them. `motions`: count rows, with a number for each freedom of the vehicle. */
static bool move_each(struct trial *trial, const int *actuators, int count, double *motions)
{
	const int own = dofs(trial);
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

static void find_wheels(struct trial *trial, const double *steered)
{
	const struct vehicle *vehicle = trial->vehicle;
	mju_copy(trial->rows, steered, trial->steer_count * dofs(trial));
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

/* --- curvatures --- */

/* Finds how far each wheel slips to its side while the vehicle goes 1 m along a way of this curvature. `aside`: m, how its origin goes aside. */
static void find_slips(const struct trial *trial, double curvature, double aside, double *slips)
{
	for (size_t w = 0; w < trial->wheel_count; w++) {
		double at[2], way[2];
		stand(trial, &trial->wheels[w], at, way);
		slips[w] = trial->wheels[w].trails ? 0 : -way[1] * (1 - curvature * at[1]) + way[0] * (aside + curvature * at[0]);
	}
}

/* What a length may be: joints and controls have limits. */
static double within(const struct trial *trial, int i, double change)
{
	const mjModel *model = trial->model;
	const int actuator = trial->steer[i], ctrl = model->actuator_ctrladr[actuator], joint = model->actuator_trnid[2 * actuator];
	const double gear = vehicle_gear(model, actuator)[0];
	double length = trial->length0[i] + change;
	if (vehicle_keeps_place(model, actuator) && model->actuator_ctrllimited[ctrl])
		length = fmin(fmax(length, model->actuator_ctrlrange[2 * ctrl]), model->actuator_ctrlrange[2 * ctrl + 1]);
	if (model->actuator_trntype[actuator] == mjTRN_JOINT && model->jnt_limited[joint]) {
		const double a = gear * model->jnt_range[2 * joint], b = gear * model->jnt_range[2 * joint + 1];
		length = fmin(fmax(length, fmin(a, b)), fmax(a, b));
	}
	return length - trial->length0[i];
}

/* Finds lengths, and how the origin goes aside, with which wheels slip least to their sides (Gauss and Newton). They are where the search begins, too.
 * *slip: the largest that is left. */
static bool fit(struct trial *trial, double curvature, double *lengths, double *aside, double *slip)
{
	const int unknown = trial->steer_count + 1;
	const size_t wheels = trial->wheel_count;
	double *slips = trial->fitting, *other = slips + wheels, *slope = other + wheels, *normal = slope + wheels * (size_t)unknown;
	double *step = normal + unknown * unknown, *tried = step + unknown;
	for (int turn = 0; turn < FITTING; turn++) {
		if (!pose(trial, lengths))
			return false;
		find_slips(trial, curvature, *aside, slips);
		find_slips(trial, curvature, *aside + 1, other);
		for (size_t w = 0; w < wheels; w++)
			slope[w * (size_t)unknown + (size_t)unknown - 1] = other[w] - slips[w];
		for (int i = 0; i < trial->steer_count; i++) {
			mju_copy(tried, lengths, trial->steer_count);
			tried[i] += TRIAL;
			if (!pose(trial, tried))
				return false;
			find_slips(trial, curvature, *aside, other);
			for (size_t w = 0; w < wheels; w++)
				slope[w * (size_t)unknown + (size_t)i] = (other[w] - slips[w]) / TRIAL;
		}
		for (int i = 0; i < unknown; i++) {
			step[i] = i < trial->steer_count ? -STIFF * lengths[i] : 0;
			for (size_t w = 0; w < wheels; w++)
				step[i] -= slope[w * (size_t)unknown + (size_t)i] * slips[w];
			for (int k = 0; k < unknown; k++) {
				normal[i * unknown + k] = i == k ? STIFF : 0;
				for (size_t w = 0; w < wheels; w++)
					normal[i * unknown + k] += slope[w * (size_t)unknown + (size_t)i] * slope[w * (size_t)unknown + (size_t)k];
			}
		}
		if (!vehicle_solve(normal, step, (size_t)unknown))
			return false;
		double moved = 0;
		for (int i = 0; i < trial->steer_count; i++) {
			const double to = within(trial, i, lengths[i] + step[i]);
			moved = fmax(moved, fabs(to - lengths[i]));
			lengths[i] = to;
		}
		*aside += step[unknown - 1];
		if (moved < 1e-9 && turn > 1)
			break;
	}
	if (!pose(trial, lengths))
		return false;
	find_slips(trial, curvature, *aside, slips);
	*slip = 0;
	for (size_t w = 0; w < wheels; w++)
		*slip = fmax(*slip, fabs(slips[w]));
	return true;
}

/* Fills the row of the table: what a curvature asks of actuators. The trial is in that pose. */
static void fill_table(const struct trial *trial, struct steering *steering, size_t row, double curvature, const double *lengths, double aside)
{
	steering->curvatures[row] = curvature;
	for (int i = 0; i < trial->steer_count; i++)
		steering->lengths[row * (size_t)trial->steer_count + (size_t)i] = trial->length0[i] + lengths[i];
	for (int i = 0; i < trial->drive_count; i++) {
		double rate = 0, squares = 0;
		for (size_t w = 0; w < trial->wheel_count; w++) {
			double at[2], way[2];
			const double share = trial->share[(size_t)i * trial->wheel_count + w];
			stand(trial, &trial->wheels[w], at, way);
			const double goes = way[0] * (1 - curvature * at[1]) + way[1] * (aside + curvature * at[0]);
			rate += share * goes / trial->wheels[w].radius;
			squares += share * share;
		}
		steering->rates[row * (size_t)trial->drive_count + (size_t)i] = squares > 0 ? rate / squares : 0;
	}
}

/* Finds how far its wheels are apart lengthwise. */
static double base_of(const struct trial *trial)
{
	double low = INFINITY, high = -INFINITY;
	for (size_t w = 0; w < trial->wheel_count; w++) {
		double at[2], way[2];
		const struct rolling *wheel = &trial->wheels[w];
		const double half = wheel->belt ? wheel->geom->shape.size[0] / 2 : 0;
		stand(trial, wheel, at, way);
		low = wheel->trails ? low : fmin(low, at[0] - half);
		high = wheel->trails ? high : fmax(high, at[0] + half);
	}
	return fmax(high - low, 0.1);
}

/* Fills the table to one side, as far as steering and wheels allow. `straight`, `aside`, `least`: how it goes straight on. Returns how many rows. */
static int fill_side(struct trial *trial, struct steering *steering, int side, const double *straight, double aside, double least)
{
	double lengths[ROWS_MOST], slip;
	const double begun = aside;
	mju_copy(lengths, straight, trial->steer_count);
	for (int i = 1; i <= EACH_WAY; i++) {
		const double curvature = side * i / (CLOSEST * steering->base * EACH_WAY);
		if (!fit(trial, curvature, lengths, &aside, &slip) || (i > 1 && trial->steer_count > 0 && slip > least + SLIPS))
			return i - 1;
		if (i == 1)
			steering->middle = (begun - aside) / curvature;
		fill_table(trial, steering, (size_t)(EACH_WAY + side * i), curvature, lengths, aside);
	}
	return EACH_WAY;
}

static bool make_table(struct trial *trial, struct steering *steering)
{
	double straight[ROWS_MOST] = {0}, aside = 0, slip;
	if (!fit(trial, 0, straight, &aside, &slip))
		return false;
	steering->base = base_of(trial);
	fill_table(trial, steering, EACH_WAY, 0, straight, aside);
	const int right = fill_side(trial, steering, -1, straight, aside, slip), left = fill_side(trial, steering, 1, straight, aside, slip);
	steering->first = (size_t)(EACH_WAY - right);
	steering->end = (size_t)(EACH_WAY + left + 1);
	return right > 0 && left > 0;
}

/* --- what is plain, and what has no effect --- */

static bool turns_its_own(const struct trial *trial, int i, const double *motion)
{
	const mjModel *model = trial->model;
	const int actuator = trial->steer[i], joint = model->actuator_trnid[2 * actuator];
	double axes[9];
	if (model->actuator_trntype[actuator] != mjTRN_JOINT || model->jnt_type[joint] != mjJNT_HINGE || !vehicle_keeps_place(model, actuator))
		return false;
	for (int d = 0; d < dofs(trial); d++)
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
		plain = turns_its_own(trial, i, steered + i * dofs(trial));
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
	if (!pose(trial, change))
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
	const size_t own = (size_t)dofs(trial);
	double *steered = mem_calloc((size_t)trial->steer_count * own + 1, sizeof *steered), *driven = mem_calloc((size_t)trial->drive_count * own + 1, sizeof *driven);
	bool done = steered != NULL && driven != NULL;
	mju_copy(trial->data->qpos, trial->vehicle->data->qpos, trial->model->nq);
	mj_fwdPosition(trial->model, trial->data);
	for (int i = 0; i < trial->steer_count; i++)
		trial->length0[i] = trial->data->actuator_length[trial->model->actuator_outadr[trial->steer[i]]];
	done = done && move_each(trial, trial->steer, trial->steer_count, steered) && move_each(trial, trial->drive, trial->drive_count, driven);
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
		done = trial->wheel_count > 0 && make_table(trial, steering);
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
