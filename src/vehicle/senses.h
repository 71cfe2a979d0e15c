/* Shared by the files of sensors. */
#ifndef FURROW_VEHICLE_SENSES_H
#define FURROW_VEHICLE_SENSES_H

#include "vehicle/internal.h"

/* Returns true if a sensor's numbers would be wrong: they miss the terrain, or are nobody's. */
bool vehicle_senses_unknown(const mjModel *model, int sensor);
/* Returns the standard deviation of the noise that a sensor's numbers get; 0: none. */
double vehicle_senses_noise(const struct vehicles *vehicles, const struct vehicle *vehicle, int sensor);
/* Finds the first geom that a ray meets, in MuJoCo's axes. Skips geoms of `excluded`, and floors that were taken away. `way`: of length 1. Returns the
 * distance, m; INFINITY: none. Runs within a guard. */
double vehicle_ray(const struct vehicles *vehicles, const double origin[3], const double way[3], int excluded, double normal[3]);

#endif
