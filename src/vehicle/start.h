/* Where and how a vehicle begins. */
#ifndef FURROW_VEHICLE_START_H
#define FURROW_VEHICLE_START_H

#include "base/base.h"

struct vehicle;
struct vehicles;

/* Sets the joints that `start.joints` names, and finds the controls of `start.controls` and those that hold these joints. Comes after the model was
 * compiled, and before its soil geoms are found. STATUS_INPUT: a name that the model does not have, or a number outside its range. */
enum status vehicle_start_pose(struct vehicle *vehicle, const char *where) FURROW_CHECKED;
/* Turns the vehicle's root bodies as `start` says, and sets them so high that the lowest soil geom touches, or `start.height` above that. STATUS_INPUT: no
 * ground is there, or a geom that does not press the ground is in it. */
enum status vehicle_set_down(const struct vehicles *vehicles, struct vehicle *vehicle) FURROW_CHECKED;
/* Puts the model of a resumed vehicle to where it was set down. Its state is to be filled in after that. */
enum status vehicle_replace(const struct vehicles *vehicles, struct vehicle *vehicle) FURROW_CHECKED;
/* Gives the vehicle `start.speed`. Its wheels and belts roll without slip. STATUS_INPUT: its root cannot move that way. */
enum status vehicle_start_speed(const struct vehicles *vehicles, struct vehicle *vehicle) FURROW_CHECKED;
/* Fails for a vehicle that has moved too far from where it was set down. `seconds`: of settling. */
enum status vehicle_check_moved(const struct vehicles *vehicles, const struct vehicle *vehicle) FURROW_CHECKED;
/* Keep the places of vehicles that do not settle while others do: the first before a step, the second after it. */
void vehicle_keep_unsettled(struct vehicles *vehicles);
void vehicle_restore_unsettled(struct vehicles *vehicles);
/* Returns the failure of a vehicle that cannot start where the scene puts it: the file, the line, the key, and then the message. */
enum status vehicle_fail_start(const struct vehicles *vehicles, const struct vehicle *vehicle, const char *format, ...)
	FURROW_PRINTF(3, 4) FURROW_CHECKED;

#endif
