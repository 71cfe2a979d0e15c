/* The table of the steering. For each curvature of a way it has lengths of steering actuators with which wheels slip least, and rates of driving ones. */
#include <math.h>

#include "vehicle/linear.h"
#include "vehicle/steering.h"

#define CLOSEST 0.75    /* of the wheelbase: the radius of the closest turn in it */
#define FITTING 8       /* steps that find lengths for a curvature */
#define SLIPS 0.05      /* rad: a turn in which wheels slip more to the side is beyond what the steering can do */
#define STIFF 1e-6      /* what a length costs, beside wheels that slip to the side */

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
		if (!vehicle_trial_pose(trial, lengths))
			return false;
		find_slips(trial, curvature, *aside, slips);
		find_slips(trial, curvature, *aside + 1, other);
		for (size_t w = 0; w < wheels; w++)
			slope[w * (size_t)unknown + (size_t)unknown - 1] = other[w] - slips[w];
		for (int i = 0; i < trial->steer_count; i++) {
			mju_copy(tried, lengths, trial->steer_count);
			tried[i] += TRIAL;
			if (!vehicle_trial_pose(trial, tried))
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
	if (!vehicle_trial_pose(trial, lengths))
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

bool vehicle_trial_table(struct trial *trial, struct steering *steering)
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
