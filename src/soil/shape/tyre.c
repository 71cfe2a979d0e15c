/*
 * The carcass of a tyre, from its radial stiffness.
 *
 * A tyre of radius R and width b has the deflection D on rigid level ground. Its patch is 2 a long, a^2 = D (2 R - D), and the segment of the circle below the ground has an
 * area S. With p = pressure + stiffness u at each place, its load is F = b (2 a pressure + S stiffness). Told is k = F / D at a load W. Of small
 * deflections the first part grows as D^0.5, the second as D^1.5. So where the first is half of the load, the tangent is k, too.
 */
#include <math.h>

#include "soil/soil.h"

enum status soil_tyre_set(const char *what, const struct soil_tyre_told *told, struct soil_shape *shape, struct soil_tyre_patch *patch)
{
	const double radius = shape->radius, deflection = told->load / told->stiffness;
	if (!(deflection <= SOIL_TYRE_DEFLECTION * radius))
		return fail_with(STATUS_INPUT, "%s: a load of %g N presses its tyre by %.3g m, more than half of its radius; give a higher stiffness", what, told->load, deflection);
	const double half = sqrt(deflection * (2 * radius - deflection)), segment = radius * radius * asin(half / radius) - half * (radius - deflection);
	const double mean = told->load / (2 * half * shape->width), holds = isnan(told->pressure) ? 0.5 * mean : told->pressure;
	if (!(holds <= SOIL_TYRE_PRESSURE * mean))
		return fail_with(STATUS_INPUT, "%s: its tyre's pressure is %g Pa, and on rigid ground its load presses by %.4g Pa; give at most %.4g Pa, or a higher stiffness",
				 what, holds, mean, SOIL_TYRE_PRESSURE * mean);
	const double springs = (told->load / shape->width - 2 * half * holds) / segment;
	shape->tyre = (struct soil_tyre){
		.pressure = holds, .stiffness = springs, .growth = springs + holds / (2 * deflection),
		.damping = isnan(told->damping) ? 0 : told->damping / (2 * half * shape->width),
		.deflection = deflection,
	};
	if (patch != NULL)
		*patch = (struct soil_tyre_patch){deflection, 2 * half, mean};
	return STATUS_OK;
}
