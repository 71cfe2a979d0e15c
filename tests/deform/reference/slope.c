/* A slope that slips along a plane: a wedge of soil held back by cohesion and friction. */
#include <math.h>

#include "deform/reference/reference.h"

#define PLANES 20000 /* that are tried */

double reference_safety(const struct soil_numbers *soil, double slope, double height)
{
	double least = INFINITY;
	for (int i = 1; i < PLANES; i++) {
		double plane = slope * i / PLANES;
		double length = height / sin(plane);
		double weight = soil->unit_weight * height * height * sin(slope - plane) / (2 * sin(slope) * sin(plane));
		double holds = soil->cohesion * length + weight * cos(plane) * tan(soil->friction_angle);
		least = fmin(least, holds / (weight * sin(plane)));
	}
	return least;
}

double reference_culmann(const struct soil_numbers *soil, double slope)
{
	if (slope <= soil->friction_angle)
		return INFINITY;
	return 4 * soil->cohesion * sin(slope) * cos(soil->friction_angle) /
	       (soil->unit_weight * (1 - cos(slope - soil->friction_angle)));
}
