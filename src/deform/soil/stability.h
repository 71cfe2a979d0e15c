/* What stands: the greatest difference of heights between two posts at which nothing slides. Pure. */
#ifndef FURROW_DEFORM_STABILITY_H
#define FURROW_DEFORM_STABILITY_H

#include <stdint.h>

#include "deform/deform.h"

/* Quanta, between posts `apart` metres apart; INT32_MAX: whatever the difference, it stands. */
int32_t deform_critical_difference(double angle, double apart); /* radians, 0 or more */
/* Culmann's: of a soil with cohesion; friction_angle's alone without. */
int32_t deform_critical_difference_cohesive(const struct deform_soil *soil, double apart);

#endif
