/*
 * The earthmoving equation by trial wedges.
 *
 * A blade of rake a goes forwards, x. From its edge, d deep, a plane of failure rises by b ahead of it. Between both is the wedge, whose top is
 * d (cot a + cot b) long. The soil of the wedge rises along the plane, and along the blade. On the wedge act, for each metre of width:
 *
 *     the blade: P at the angle delta to its normal, so P (sin(a + delta), cos(a + delta)); along it adhesion, c_a d / sin a (cos a, -sin a)
 *     the soil below: R at the angle phi to the plane's normal, so R (-sin(b + phi), cos(b + phi)); along it cohesion, -c d / sin b (cos b, sin b)
 *     weight and surcharge: -(gamma d / 2 + q) d (cot a + cot b) (0, 1)
 *
 * Their sums along x and z are 0. R leaves the sum that is taken across it. What remains is P, divided here by sin(b + phi) into four terms: the factors
 * below. The soil fails on the plane that needs the least force.
 */
#include "mckyes.h"

#include <math.h>

#define TRIALS 2000
#define NARROWINGS 80

static double cot(double angle)
{
	return 1 / tan(angle);
}

struct mckyes_factors mckyes_factors_at(const struct mckyes_blade *blade, double failure)
{
	const double a = blade->rake, across = cot(failure + blade->friction);
	const double by = 1 / (cos(a + blade->tool) + sin(a + blade->tool) * across), top = cot(a) + cot(failure);
	return (struct mckyes_factors){.weight = top / 2 * by, .cohesion = (1 + cot(failure) * across) * by, .surcharge = top * by,
				       .adhesion = (1 - cot(a) * across) * by};
}

static double total_of(const struct mckyes_blade *blade, const struct mckyes_factors *n)
{
	const double d = blade->depth;
	const double pressure = blade->unit_weight * d * n->weight + blade->cohesion * n->cohesion + blade->surcharge * n->surcharge;
	return (pressure + blade->adhesion * n->adhesion) * d * blade->width;
}

static double total_at(const struct mckyes_blade *blade, double failure)
{
	const struct mckyes_factors factors = mckyes_factors_at(blade, failure);
	return total_of(blade, &factors);
}

struct mckyes_force mckyes_force_of(const struct mckyes_blade *blade)
{
	/* At the largest angle the soil below can no longer hold against the blade: the force is infinite. */
	const double most = M_PI - blade->rake - blade->tool - blade->friction, golden = (sqrt(5) - 1) / 2;
	int best = 1;
	for (int i = 2; i < TRIALS; i++)
		if (total_at(blade, most * i / TRIALS) < total_at(blade, most * best / TRIALS))
			best = i;
	double low = most * (best - 1) / TRIALS, high = most * (best + 1) / TRIALS;
	for (int i = 0; i < NARROWINGS; i++) {
		const double a = high - golden * (high - low), b = low + golden * (high - low);
		if (total_at(blade, a) < total_at(blade, b))
			high = b;
		else
			low = a;
	}
	struct mckyes_force force = {.failure = (low + high) / 2};
	const double sticks = blade->adhesion * blade->depth * blade->width, angle = blade->rake + blade->tool;
	force.factors = mckyes_factors_at(blade, force.failure);
	force.total = total_of(blade, &force.factors);
	force.draft = force.total * sin(angle) + sticks * cot(blade->rake);
	force.lift = sticks - force.total * cos(angle);
	force.ahead = blade->depth * cot(force.failure);
	return force;
}
