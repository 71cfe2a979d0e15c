/*
 * The carcass of a tyre, from its radial stiffness.
 *
 * A wheel of radius R and width b is pressed by D onto rigid level ground. Its patch is 2 a long, a^2 = D (2 R - D), and the segment of the circle below the ground has an
 * area S. With p = pressure + stiffness u at each place, its load is F = b (2 a pressure + S stiffness). Told is k = F / D at a load W. Where the first part is half of the
 * load, the tangent there is k, too: of small deflections the first part grows as D^0.5, the second as D^1.5.
 */
#include <math.h>

#include "soil/soil.h"

enum status soil_tyre_set(const char *what, const struct soil_tyre_told *told, struct soil_shape *shape, struct soil_tyre_patch *patch)
{
	const double radius = shape->radius, pressed = told->load / told->stiffness;
	if (!(pressed <= SOIL_TYRE_DEFLECTION * radius))
		return fail_with(STATUS_INPUT, "%s: a load of %g N presses its tyre by %.3g m, more than half of its radius; give a higher stiffness", what, told->load, pressed);
	const double half = sqrt(pressed * (2 * radius - pressed)), segment = radius * radius * asin(half / radius) - half * (radius - pressed);
	const double mean = told->load / (2 * half * shape->width), holds = isnan(told->pressure) ? 0.5 * mean : told->pressure;
	if (!(holds <= SOIL_TYRE_PRESSURE * mean))
		return fail_with(STATUS_INPUT, "%s: its tyre's pressure is %g Pa, and on rigid ground its load presses by %.4g Pa; give at most %.4g Pa, or a higher stiffness",
				 what, holds, mean, SOIL_TYRE_PRESSURE * mean);
	const double springs = (told->load / shape->width - 2 * half * holds) / segment;
	shape->tyre = (struct soil_tyre){
		.pressure = holds, .stiffness = springs, .growth = springs + holds / (2 * pressed),
		.damping = isnan(told->damping) ? 0 : told->damping / (2 * half * shape->width),
		.pressed = pressed,
	};
	if (patch != NULL)
		*patch = (struct soil_tyre_patch){pressed, 2 * half, mean};
	return STATUS_OK;
}
