/* One vehicle: its model. */
#ifndef FURROW_VEHICLE_LOAD_H
#define FURROW_VEHICLE_LOAD_H

#include "base/base.h"
#include "scene/scene.h"

struct vehicle;
struct vehicles;

/* Reads the model that vehicle->scene names, alone. The caller calls vehicle_forget, even on failure. */
enum status vehicle_read(struct vehicle *vehicle, const struct scene *scene) FURROW_CHECKED;
/* Makes the model of all fit the scene: its gravity, and what of the files' own worlds counts. */
void vehicle_fit(struct vehicles *vehicles);
/* Finds what is made of a vehicle once, in the model of all. */
enum status vehicle_find_parts(struct vehicle *vehicle, const struct scene *scene) FURROW_CHECKED;
/* Finds how many steps of the engine make a time step of the scene. STATUS_INPUT: too many. */
enum status vehicle_set_timestep(struct vehicles *vehicles) FURROW_CHECKED;
/* Makes position servos of URDFs no stiffer than a step of the engine is stable with, and tells it. Comes after vehicle_set_timestep. */
void vehicle_soften_servos(struct vehicles *vehicles);
void vehicle_forget(struct vehicle *vehicle);

#endif
