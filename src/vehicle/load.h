/* One vehicle: its model. */
#ifndef FURROW_VEHICLE_LOAD_H
#define FURROW_VEHICLE_LOAD_H

#include "base/base.h"
#include "scene/scene.h"

struct vehicle;

/* Reads the model that vehicle->scene names. The caller calls vehicle_forget, even on failure. */
enum status vehicle_read(struct vehicle *vehicle, const struct scene *scene) FURROW_CHECKED;
void vehicle_forget(struct vehicle *vehicle);

#endif
