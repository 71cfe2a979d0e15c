/* Electric drives: MuJoCo's dcmotor actuators. Their currents, voltages and energies. */
#ifndef FURROW_VEHICLE_DRIVES_H
#define FURROW_VEHICLE_DRIVES_H

#include "vehicle/internal.h"

/* K: torque over current, N m/A, which is voltage over speed, too. The current is i = torque / K, or the activation of a motor with an inductance. The voltage is R i + K times the
 * motor's speed, and the electric power R i2 + torque times speed, of means over a step. */
struct drive {
	int actuator;
	double resistance, constant; /* ohm; N m/A */
	/* State: */
	double taken, recovered, mechanical; /* J: electric power above 0, and below 0, summed; torque times speed, summed */
};

/* Finds them. STATUS_MEMORY. */
enum status vehicle_make_drives(struct vehicle *vehicle) FURROW_CHECKED;
/* Sums the energies of the step of h seconds that has just ended. before: nv, velocities at its start. */
void vehicle_drives_sum(struct vehicle *vehicle, double h, const double *before);
#define DRIVE_STATE 3 /* numbers of the record for each */
double *vehicle_drives_save(const struct vehicle *vehicle, double *to);
const double *vehicle_drives_restore(struct vehicle *vehicle, const double *from);

#endif
