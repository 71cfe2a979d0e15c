/*
 * Critical height differences between two posts, from a soil's angles and cohesion.
 *
 * By Culmann's plane wedge a slope of height H and angle b fails if
 *     H > 4 c sin b cos phi / (gamma (1 - cos(b - phi))).
 * See Taylor, Fundamentals of Soil Mechanics, 1948. Here b depends on H, since the slope is the one between two posts.
 */
#include "soil/stability.h"

#include <math.h>

#define UPRIGHT (89.95 * M_PI / 180) /* rad; a slope with at least this angle of repose is stable at any height */

static int32_t whole(double metres)
{
	double units = floor(ldexp(metres, OFFSET_BITS));
	return units < INT32_MAX ? (int32_t)units : INT32_MAX;
}

int32_t soil_critical_difference(double angle, double apart)
{
	return angle < UPRIGHT ? whole(tan(angle) * apart) : INT32_MAX;
}

static bool slips(const struct soil_numbers *soil, double apart, int32_t units)
{
	double height = ldexp(units, -OFFSET_BITS), slope = atan2(height, apart), over = slope - soil->friction_angle;
	if (over <= 0)
		return false;
	/* 2 half^2 is 1 - cos(over), and keeps its precision where `over` is small. */
	double half = sin(over / 2), driving = soil->unit_weight * 2 * half * half;
	return height * driving > 4 * soil->cohesion * sin(slope) * cos(soil->friction_angle);
}

int32_t soil_critical_difference_cohesive(const struct soil_numbers *soil, double apart)
{
	int32_t critical = soil_critical_difference(soil->friction_angle, apart), fails = INT32_MAX;
	if (soil->cohesion <= 0 || critical == INT32_MAX || !slips(soil, apart, fails))
		return soil->cohesion <= 0 ? critical : INT32_MAX;
	/* Above phi a steeper slope is also higher, and less stable. So there is one height from which on it fails: bisection. */
	while (fails - critical > 1) {
		int32_t middle = critical + (fails - critical) / 2;
		if (slips(soil, apart, middle))
			fails = middle;
		else
			critical = middle;
	}
	return critical;
}

/*
 * With k = 4 c cos phi / gamma, m = sin phi + k / H and x = cot b, Culmann's equation is sqrt(1 + x^2) = x cos phi + m. Its
 * square is a quadratic equation in x. Written as below its root is exact for phi = 0 too, and below 0 for a slope that would
 * overhang.
 */
double soil_critical_cotangent(const struct soil_numbers *soil, double height)
{
	if (!(soil->friction_angle < UPRIGHT))
		return 0;
	double sine = sin(soil->friction_angle), cosine = cos(soil->friction_angle);
	double m = sine + fmin(fmax(0, 4 * soil->cohesion * cosine / (soil->unit_weight * height)), 1e6);
	return (1 - m) * (1 + m) / (m * cosine + sqrt(m * m - sine * sine));
}
