/* Setting vehicles down. */
#ifndef FURROW_VEHICLE_SETTLE_H
#define FURROW_VEHICLE_SETTLE_H

#include "base/base.h"

struct vehicle;
struct vehicles;

/* Values of vehicle.begun: not set down; all motion is slowed; moves freely; drives. */
enum { VEHICLE_ABOVE, VEHICLE_SLOWED, VEHICLE_FREE, VEHICLE_DRIVES };

/* Sets the vehicles down and lets them settle, or goes on with that. */
enum status vehicle_settle(struct vehicles *vehicles) FURROW_CHECKED;
/* Puts the model of a resumed vehicle to where it was set down. Its state is to be filled in after that. */
enum status vehicle_replace(const struct vehicles *vehicles, struct vehicle *vehicle) FURROW_CHECKED;

#endif
