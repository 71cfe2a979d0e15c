/* One vehicle: its model. */
#ifndef FURROW_VEHICLE_LOAD_H
#define FURROW_VEHICLE_LOAD_H

#include "base/base.h"
#include "scene/scene.h"

struct vehicle;

/* Reads the model that vehicle->scene names. The caller calls vehicle_forget, even on failure. */
enum status vehicle_read(struct vehicle *vehicle, const struct scene *scene) FURROW_CHECKED;
/* Finds how many steps of the engine make a time step of the scene. STATUS_INPUT: too many. */
enum status vehicle_set_timestep(struct vehicle *vehicle, const struct scene *scene) FURROW_CHECKED;
void vehicle_forget(struct vehicle *vehicle);

#endif
