/* Setting vehicles down. */
#ifndef FURROW_VEHICLE_SETTLE_H
#define FURROW_VEHICLE_SETTLE_H

#include "base/base.h"

struct soil_geom;
struct vehicle;
struct vehicles;

/* Values of vehicle.begun: not set down; all motion is slowed; moves freely; drives. */
enum { VEHICLE_ABOVE, VEHICLE_SLOWED, VEHICLE_FREE, VEHICLE_DRIVES };

/* How near to rest settling vehicles have come. */
struct unrest {
	double least, mean;   /* m/s: the least mean speed of the times before, and that of the last one; least 0: nothing is known */
	double sum, samples;  /* m/s: of the speeds since `time` */
	double time, work;    /* s of motion, s of work */
};

/* Notes the speed, m/s, of the fastest vehicle after so much motion of a stage and so much work, s. Returns true if a start has failed: after much work it trembles, and comes no nearer to
 * rest. Heavy vehicles that come nearer get as much work as they need. */
bool vehicle_unrest_fails(struct unrest *unrest, double speed, double time, double work);
/* Sets the vehicles down and lets them settle, or goes on with that. STATUS_INPUT: also where the soil does not carry one. */
enum status vehicle_settle(struct vehicles *vehicles) FURROW_CHECKED;
/* Returns the deepest soil geom of those that are sunk (state of objects.csv); NULL: none is. */
const struct soil_geom *vehicle_sunk(const struct vehicle *vehicle);
/* Writes into `text` that a soil geom of the vehicle is sunk, and what to check. */
void vehicle_say_sunk(const struct vehicles *vehicles, const struct vehicle *vehicle, const struct soil_geom *geom, char *text, size_t size);

#endif
