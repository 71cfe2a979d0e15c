/*
 * What a driver asks of an actuator, whatever kind it is: a rate, a force, or a place.
 *
 * Each is of the actuator's length, as MuJoCo has it: the joint's angle or the tendon's length times `gear`.
 */
#include <math.h>

#include "vehicle/internal.h"

#define STEER_RATE 8.0   /* 1/s: a velocity servo that steers goes to its place with this */
#define STEER_SWING 25.0 /* rad/s: so does an actuator that gives a torque, as fast as a spring with this and critical damping */

/* Returns the number of its control that has this meaning; -1: it has none. */
static int input_of(const mjModel *model, int actuator, int input)
{
	const int all = model->actuator_ctrlspec[actuator];
	int number = 0;
	if (!(all & input))
		return -1;
	for (int bit = 1; bit < input; bit *= 2)
		number += (all & bit) != 0;
	return number;
}

bool vehicle_keeps_rate(const mjModel *model, int actuator)
{
	const double *gain = &model->actuator_gainprm[actuator * mjNGAIN], *bias = &model->actuator_biasprm[actuator * mjNBIAS];
	return input_of(model, actuator, mjINPUT_VEL) >= 0 ||
	       (model->actuator_biastype[actuator] == mjBIAS_AFFINE && bias[1] == 0 && bias[2] != 0 && bias[2] == -gain[0]);
}

bool vehicle_keeps_place(const mjModel *model, int actuator)
{
	if (model->actuator_ctrlspec[actuator] != 0)
		return input_of(model, actuator, mjINPUT_POS) >= 0;
	return model->actuator_biastype[actuator] == mjBIAS_AFFINE && model->actuator_biasprm[actuator * mjNBIAS + 1] < 0;
}

static double length_of(const struct vehicle *vehicle, int actuator)
{
	return vehicle->data->actuator_length[vehicle->model->actuator_outadr[actuator]];
}

static double rate_of(const struct vehicle *vehicle, int actuator)
{
	return vehicle->data->actuator_velocity[vehicle->model->actuator_outadr[actuator]];
}

void vehicle_ask_rate(const struct vehicle *vehicle, int actuator, double rate)
{
	double *ctrl = vehicle_ctrl(vehicle, actuator);
	const int place = input_of(vehicle->model, actuator, mjINPUT_POS), speed = input_of(vehicle->model, actuator, mjINPUT_VEL);
	if (place >= 0)
		ctrl[place] = length_of(vehicle, actuator); /* it is where it should be */
	ctrl[speed >= 0 ? speed : 0] = rate;
}

void vehicle_ask_force(const struct vehicle *vehicle, int actuator, double force)
{
	const mjModel *model = vehicle->model;
	const double *gain = &model->actuator_gainprm[actuator * mjNGAIN], *bias = &model->actuator_biasprm[actuator * mjNBIAS];
	double *ctrl = vehicle_ctrl(vehicle, actuator), factor = gain[0];
	if (model->actuator_gaintype[actuator] == mjGAIN_DCMOTOR) { /* volts: the resistance takes some, the motor's own voltage the others */
		const double resistance = gain[0], constant = gain[1];
		ctrl[0] = force * resistance / constant + constant * rate_of(vehicle, actuator);
		return;
	}
	if (model->actuator_biastype[actuator] == mjBIAS_AFFINE) {
		force -= bias[0] + bias[1] * length_of(vehicle, actuator) + bias[2] * rate_of(vehicle, actuator);
		factor = model->actuator_gaintype[actuator] == mjGAIN_PID ? -bias[1] : factor;
	}
	ctrl[0] = force / (factor != 0 ? factor : 1);
}

void vehicle_ask_place(const struct vehicle *vehicle, int actuator, double length)
{
	const mjModel *model = vehicle->model;
	const double lacks = length - length_of(vehicle, actuator);
	if (vehicle_keeps_place(model, actuator)) {
		const int place = input_of(model, actuator, mjINPUT_POS), speed = input_of(model, actuator, mjINPUT_VEL);
		vehicle_ctrl(vehicle, actuator)[place >= 0 ? place : 0] = length;
		if (speed >= 0)
			vehicle_ctrl(vehicle, actuator)[speed] = 0;
	} else if (vehicle_keeps_rate(model, actuator)) {
		vehicle_ask_rate(vehicle, actuator, STEER_RATE * lacks);
	} else {
		const double swing = fmin(STEER_SWING, 0.2 / model->opt.timestep), inertia = 1 / fmax(model->actuator_acc0[model->actuator_outadr[actuator]], mjMINVAL);
		vehicle_ask_force(vehicle, actuator, inertia * swing * (swing * lacks - 2 * rate_of(vehicle, actuator)));
	}
}
