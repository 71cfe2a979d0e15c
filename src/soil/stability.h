/*
 * Computes critical height differences. A critical height difference is the largest one between two posts at which the slope is
 * stable. Pure.
 */
#ifndef FURROW_SOIL_STABILITY_H
#define FURROW_SOIL_STABILITY_H

#include <stdint.h>

#include "soil/soil.h"

/* Returns the critical difference of posts `apart` metres apart, fixed-point units. INT32_MAX: any difference is stable. `angle`:
 * angle of repose, radians, 0 or more. */
int32_t soil_critical_difference(double angle, double apart);
/* The same for a soil with cohesion, by Culmann's wedge. Without cohesion the angle of repose is friction_angle. */
int32_t soil_critical_difference_cohesive(const struct soil_numbers *soil, double apart);
/* Returns the cotangent of the steepest angle at which a slope of `height` metres is stable, by Culmann's wedge. 0 or
 * less: an upright slope is stable too, or even an overhang. */
double soil_critical_cotangent(const struct soil_numbers *soil, double height);

#endif
