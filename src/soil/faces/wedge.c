#include "soil/faces/wedge.h"

#include <math.h>

#define LEAST_RAKE (10 * M_PI / 180)
#define RAKE_STEP (5 * M_PI / 180)
#define STEPS 200 /* of the wedge's angle, before it is refined */

static double cot(double angle)
{
	return 1 / tan(angle);
}

/* Returns N of the weight for a wedge of angle b; INFINITY: no such wedge moves. */
static double weight_of(double rake, double phi, double delta, double b)
{
	const double below = cos(rake + delta) + sin(rake + delta) * cot(b + phi), above = cot(rake) + cot(b);
	return below > 1e-6 && above > 0 ? above / (2 * below) : INFINITY;
}

/* Returns the wedge's angle with the least N of the weight. */
static double weakest(double rake, double phi, double delta)
{
	const double low = 0.01, high = M_PI / 2 - 0.01, step = (high - low) / STEPS;
	int best = 0;
	double least = INFINITY;
	for (int i = 0; i <= STEPS; i++) {
		const double n = weight_of(rake, phi, delta, low + i * step);
		best = n < least ? i : best;
		least = fmin(n, least);
	}
	/* Ternary search between the neighbours of the best step. */
	double from = fmax(low + (best - 1) * step, low), to = fmin(low + (best + 1) * step, high);
	for (int i = 0; i < 40; i++) {
		const double a = from + (to - from) / 3, b = to - (to - from) / 3;
		if (weight_of(rake, phi, delta, a) <= weight_of(rake, phi, delta, b))
			to = b;
		else
			from = a;
	}
	return (from + to) / 2;
}

void soil_wedge_of(double phi, double delta, struct soil_wedge *wedge)
{
	if (wedge->weight[0] > 0 && fabs(phi - wedge->phi) < 1e-12 && fabs(delta - wedge->delta) < 1e-12)
		return;
	wedge->phi = phi;
	wedge->delta = delta;
	for (int i = 0; i < WEDGE_RAKES; i++) {
		const double rake = LEAST_RAKE + i * RAKE_STEP, b = weakest(rake, phi, delta), share = sin(rake) * cos(delta);
		const double below = cos(rake + delta) + sin(rake + delta) * cot(b + phi);
		wedge->weight[i] = (float)(2 * weight_of(rake, phi, delta, b) * share);
		wedge->cohesion[i] = (float)((1 + cot(b) * cot(b + phi)) / below * share);
	}
}

void soil_wedge_at(const struct soil_wedge *wedge, float up, float *weight, float *cohesion)
{
	const double place = fmin(fmax((acos(fmin(fmax((double)up, 0), 1)) - LEAST_RAKE) / RAKE_STEP, 0), WEDGE_RAKES - 1);
	const int first = place < WEDGE_RAKES - 2 ? (int)place : WEDGE_RAKES - 2;
	const float share = (float)(place - first);
	*weight = wedge->weight[first] + share * (wedge->weight[first + 1] - wedge->weight[first]);
	*cohesion = wedge->cohesion[first] + share * (wedge->cohesion[first + 1] - wedge->cohesion[first]);
}
