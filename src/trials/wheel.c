/*
 * One wheel, by its curves: at any load and slip, and at a slip angle.
 *
 * The rig measures without a slip angle. At one, the soil shears along the sum of two displacements (Wong and Reece; Ishigami and others,
 * Journal of Field Robotics 24, 2007). theta1 is the angle at which the rim enters the soil. From there to the lowest point the
 * displacements are, for each metre that the rim turns:
 *
 *     s_x = 1 - (1 - s) sin(theta1) / theta1 along the wheel,    s_y = (1 - s) tan(beta) across
 *
 * So the shear is that of a wheel that runs straight with the same whole displacement, at slip s', and it lies along (s_x, s_y). The torque
 * over the radius is the shear along the rim. What that pulls more than the drawbar is the soil's resistance, which stays along the wheel.
 * tests/trials/wheel.c compares both forces with the integrals of these displacements along the rim. They are within 4 % of the load where the
 * wheel sinks by less than a sixth of its radius. Where it sinks by more they are within 8 %.
 */
#include <math.h>

#include "trials/trials.h"

static struct mobility_point between(struct mobility_point a, struct mobility_point b, double share)
{
	return (struct mobility_point){a.drawbar + (b.drawbar - a.drawbar) * share, a.torque + (b.torque - a.torque) * share,
				       a.sinkage + (b.sinkage - a.sinkage) * share, a.depth + (b.depth - a.depth) * share,
				       (share >= 1 || a.steady) && (share <= 0 || b.steady)};
}

void trials_wheel_load(const struct mobility_wheel_curves *curves, double load, struct mobility_wheel *out)
{
	size_t l = 0;
	while (l + 2 < MOBILITY_LOADS && load > curves->loads[l + 1])
		l++;
	const double share = (load - curves->loads[l]) / (curves->loads[l + 1] - curves->loads[l]);
	out->radius = curves->radius;
	for (size_t s = 0; s < MOBILITY_SLIPS; s++)
		out->points[s] = between(curves->points[l][s], curves->points[l + 1][s], share);
}

struct mobility_point trials_wheel_straight(const struct mobility_wheel *wheel, double slip)
{
	size_t s = 0;
	while (s + 2 < MOBILITY_SLIPS && slip > trials_slips[s + 1])
		s++;
	return between(wheel->points[s], wheel->points[s + 1], (slip - trials_slips[s]) / (trials_slips[s + 1] - trials_slips[s]));
}

double trials_wheel_free_slip(const struct mobility_wheel *wheel)
{
	double low = trials_slips[0], high = trials_slips[MOBILITY_SLIPS - 1];
	for (int i = 0; i < 40; i++) {
		const double middle = (low + high) / 2;
		*(trials_wheel_straight(wheel, middle).torque > 0 ? &high : &low) = middle;
	}
	return (low + high) / 2;
}

/* The straight wheel whose whole displacement is this, for each metre that the rim turns. Beyond the curves it is that at their end: the shear is
 * mobilised there. */
static struct mobility_point same_displacement(const struct mobility_wheel *wheel, double displacement, double arc)
{
	const double slip = 1 - (1 - displacement) / arc;
	return trials_wheel_straight(wheel, fmin(fmax(slip, trials_slips[0]), trials_slips[MOBILITY_SLIPS - 1]));
}

struct mobility_pull trials_wheel_at(const struct mobility_wheel *wheel, double slip, double tangent)
{
	const struct mobility_point straight = trials_wheel_straight(wheel, slip);
	if (tangent == 0)
		return (struct mobility_pull){straight.drawbar, 0, straight.torque, straight.sinkage, straight.steady};
	/* sin(theta) / theta from 1 - cos(theta) = depth / radius */
	const double theta = acos(1 - fmin(fmax(straight.depth / wheel->radius, 1e-6), 1)), arc = sin(theta) / theta;
	const double along = 1 - (1 - slip) * arc, across = (1 - slip) * tangent, whole = hypot(along, across);
	/* A wheel that is braked has the curve of negative slips, and less of it the more it slides aside. */
	const double driven = along >= 0 ? 1 : 1 + along / whole;
	const struct mobility_point a = same_displacement(wheel, whole, arc), b = same_displacement(wheel, -whole, arc);
	const double shear = (driven * a.torque - (1 - driven) * b.torque) / wheel->radius;
	const double resistance = driven * (a.torque / wheel->radius - a.drawbar) + (1 - driven) * (b.torque / wheel->radius - b.drawbar);
	return (struct mobility_pull){shear * along / whole - resistance, shear * across / whole, shear * wheel->radius * along / whole,
				      driven < 1 ? fmax(a.sinkage, b.sinkage) : a.sinkage, a.steady && (driven >= 1 || b.steady)};
}
