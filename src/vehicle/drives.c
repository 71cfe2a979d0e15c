/* Sums what electric drives take, give back and do. */
#include "vehicle/drives.h"

#include <math.h>

enum status vehicle_make_drives(struct vehicle *vehicle)
{
	const mjModel *model = vehicle->model;
	TRY(mem_zeroed(&vehicle->drives, range_count(vehicle->own.actuator) + 1, sizeof *vehicle->drives, "a vehicle"));
	for (int i = vehicle->own.actuator.first; i < vehicle->own.actuator.end; i++) {
		const double *gain = model->actuator_gainprm + i * mjNGAIN;
		if (model->actuator_gaintype[i] == mjGAIN_DCMOTOR && gain[0] > 0 && gain[1] > 0)
			vehicle->drives[vehicle->drive_count++] = (struct drive){.actuator = i, .resistance = gain[0], .constant = gain[1]};
	}
	return STATUS_OK;
}

static double torque_of(const struct vehicle *vehicle, const struct drive *drive)
{
	return vehicle->data->actuator_force[vehicle->model->actuator_outadr[drive->actuator]];
}

/* A motor with an inductance has its current as its one activation. */
static double current_of(const struct vehicle *vehicle, const struct drive *drive)
{
	const mjModel *model = vehicle->model;
	const int i = drive->actuator;
	if (model->actuator_dynprm[i * mjNDYN] > 0 && model->actuator_actnum[i] == 1)
		return vehicle->data->act[model->actuator_actadr[i]];
	return torque_of(vehicle, drive) / drive->constant;
}

/* rad/s of the motor, before its gear: by velocities of the joints, or as MuJoCo last found it. */
static double speed_of(const struct vehicle *vehicle, const struct drive *drive, const double *a, const double *b)
{
	const mjModel *model = vehicle->model;
	const int i = drive->actuator;
	if (model->actuator_trntype[i] != mjTRN_JOINT)
		return vehicle->data->actuator_velocity[model->actuator_outadr[i]];
	const int dof = model->jnt_dofadr[model->actuator_trnid[2 * i]];
	return vehicle_gear(model, i)[0] * (a[dof] + b[dof]) / 2;
}

void vehicle_drives_sum(struct vehicle *vehicle, double h, const double *before)
{
	for (struct drive *drive = vehicle->drives; drive < vehicle->drives + vehicle->drive_count; drive++) {
		const double current = current_of(vehicle, drive), power = torque_of(vehicle, drive) * speed_of(vehicle, drive, before, vehicle->data->qvel);
		const double electric = drive->resistance * current * current + power;
		drive->mechanical += power * h;
		*(electric > 0 ? &drive->taken : &drive->recovered) += fabs(electric) * h;
	}
}

double *vehicle_drives_save(const struct vehicle *vehicle, double *to)
{
	for (const struct drive *drive = vehicle->drives; drive < vehicle->drives + vehicle->drive_count; drive++) {
		*to++ = drive->taken;
		*to++ = drive->recovered;
		*to++ = drive->mechanical;
	}
	return to;
}

const double *vehicle_drives_restore(struct vehicle *vehicle, const double *from)
{
	for (struct drive *drive = vehicle->drives; drive < vehicle->drives + vehicle->drive_count; drive++) {
		drive->taken = *from++;
		drive->recovered = *from++;
		drive->mechanical = *from++;
	}
	return from;
}

size_t vehicle_drive_count(const struct vehicles *vehicles, size_t vehicle)
{
	return vehicles->list[vehicle].drive_count;
}

void vehicle_drive(const struct vehicles *vehicles, size_t index, size_t number, struct vehicle_drive *out)
{
	const struct vehicle *vehicle = &vehicles->list[index];
	const struct drive *drive = &vehicle->drives[number];
	const double *speeds = vehicle->data->qvel;
	const char *name = vehicle_part_name(vehicle->model, mjOBJ_ACTUATOR, drive->actuator);
	*out = (struct vehicle_drive){.name = name != NULL ? name : "", .torque = torque_of(vehicle, drive), .current = current_of(vehicle, drive),
				      .speed = speed_of(vehicle, drive, speeds, speeds), .taken = drive->taken, .recovered = drive->recovered, .mechanical = drive->mechanical};
	out->voltage = drive->resistance * out->current + drive->constant * out->speed;
	out->heat = drive->taken - drive->recovered - drive->mechanical;
}
