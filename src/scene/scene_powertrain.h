/* Checks the powertrain of a vehicle: its keys, and the table of its engine. */
#ifndef FURROW_SCENE_POWERTRAIN_H
#define FURROW_SCENE_POWERTRAIN_H

#include "scene/scene.h"
#include "scene/scene_schema.h"
#include "scene/scene_tree.h"

/* Fills vehicle->powertrain from what the scene gives for its vehicle `index`. Call it after the driver was checked. STATUS_INPUT: values that do not
 * fit together, or a table that cannot be read. scene_vehicle_finish frees it. */
enum status scene_check_powertrain(const struct scene_tree *tree, const struct raw_powertrain *raw, size_t index, struct scene_vehicle *vehicle) FURROW_CHECKED;

#endif
