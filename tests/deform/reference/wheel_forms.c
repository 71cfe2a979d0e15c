/*
 * The forces of scm soil on a rigid wheel that rolls straight and level at a constant slip, as integrals over its arc.
 * Nothing is laid around the wheel, nothing is damped, and the soil was undisturbed before it.
 *
 * An angle t is from the wheel's lowest point, positive forwards. The rim at t lies at x = r sin t before the axle.
 * It lies z = r (cos t - cos t1) below the surface, where cos t1 = 1 - z0 / r. The soil yields from t1 to 0.
 * Behind 0 it springs back with K_e, until the pressure is 0.
 *
 * Per metre of way the rim at t moves by (1 - k cos t, k sin t) in x and down; k is `turned`. Along the ground that is
 * k cos t - 1 backwards, and along the rim k - cos t. The slip displacement j is its integral from t1 to t:
 *
 *     over a place of the soil   dx = r cos t dt of way:  surface  j = r (k S - C),   ground  j = r (k C - S)
 *     over a point of the rim    r dt / k of way:         surface  j = r (A - S / k), ground  j = r (S - A / k)
 *
 * with A = t1 - t, S = sin t1 - sin t, and C the integral of cos^2 t. Wong and Reece's is surface over the rim.
 */
#include <math.h>

#include "deform/reference/quadrature.h"
#include "deform/reference/reference.h"

#define TOLERANCE 1e-9
#define LEAST 1e-9  /* of the radius: the least sinkage that is looked for */
#define STEPS 256   /* between that and the radius, each by the same factor */

struct arc {
	const struct soil_numbers *soil;
	const struct reference_rolling *wheel;
	double entry, exit; /* rad: t where contact begins, in front, and where it ends */
};

double reference_turned(double slip)
{
	return slip < 0 ? 1 + slip : 1 / (1 - slip);
}

/* How much higher the rim is at `end` than at t, m: r (cos t - cos end), without its cancellation. */
static double height(const struct arc *arc, double t, double end)
{
	return 2 * arc->wheel->radius * sin((end - t) / 2) * sin((end + t) / 2);
}

/* The angle at which the rim is so much higher than its lowest point. */
static double angle_of(double radius, double height)
{
	return 2 * asin(sqrt(fmin(height / (2 * radius), 1)));
}

/* The slip displacement at t, m; above 0 where the rim has moved backwards over the soil. */
static double displacement(const struct arc *arc, double t)
{
	double r = arc->wheel->radius, turned = arc->wheel->turned;
	double angle = arc->entry - t, along = sin(arc->entry) - sin(t);
	double squares = (angle + (sin(2 * arc->entry) - sin(2 * t)) / 2) / 2;
	bool surface = arc->wheel->normals == REFERENCE_NORMALS_SURFACE;
	if (arc->wheel->follows == REFERENCE_FOLLOWS_SOIL)
		return surface ? r * (turned * along - squares) : r * (turned * squares - along);
	if (turned == 0)
		return -INFINITY;
	return surface ? r * (angle - along / turned) : r * (along - angle / turned);
}

/* The pressure at t, Pa. */
static double pressure(const struct arc *arc, double t)
{
	if (t >= 0)
		return reference_yield(arc->soil, arc->wheel->width, fmax(0, height(arc, t, arc->entry)));
	return arc->soil->elastic_stiffness * fmax(0, height(arc, t, arc->exit));
}

enum value { DRAWBAR, VERTICAL, MOMENT, SHEAR_MOMENT, SHEAR_VERTICAL };

static void stresses(const void *user, double t, double *values)
{
	const struct arc *arc = user;
	double r = arc->wheel->radius, normal = pressure(arc, t), slid = displacement(arc, t);
	double strength = reference_strength(arc->soil, &arc->wheel->interface, normal);
	double shear = copysign(strength * (1 - exp(-fabs(slid) / arc->soil->janosi_shear)), slid);
	double area = r * arc->wheel->width; /* of a radian of rim */
	for (int i = 0; i < QUADRATURE_MOST; i++)
		values[i] = 0;
	if (arc->wheel->normals == REFERENCE_NORMALS_SURFACE) {
		values[DRAWBAR] = area * (shear * cos(t) - normal * sin(t));
		values[VERTICAL] = area * (normal * cos(t) + shear * sin(t));
		values[MOMENT] = values[SHEAR_MOMENT] = -area * r * shear;
		values[SHEAR_VERTICAL] = area * shear * sin(t);
		return;
	}
	area *= cos(t); /* of the ground below it */
	values[DRAWBAR] = area * shear;
	values[VERTICAL] = area * normal;
	values[MOMENT] = -area * r * (shear * cos(t) + normal * sin(t));
	values[SHEAR_MOMENT] = -area * r * shear * cos(t);
}

/* Adds a part of the arc on which the pressure rises or falls all the way. The strength has a kink where the pressure is the cohesion. */
static void add_part(const struct arc *arc, double from, double to, double tolerance, double *sums)
{
	const double c = arc->soil->cohesion;
	double low = from, high = to;
	const bool rises = pressure(arc, to) > pressure(arc, from);
	for (int i = 0; i < 60; i++) {
		const double middle = (low + high) / 2;
		*((pressure(arc, middle) < c) == rises ? &low : &high) = middle;
	}
	quadrature_add(stresses, arc, from, low, tolerance, sums);
	quadrature_add(stresses, arc, low, to, tolerance, sums);
}

struct reference_rolling_force reference_rolling(const struct soil_numbers *soil, const struct reference_rolling *wheel,
						 double sinkage)
{
	double r = wheel->radius, sums[QUADRATURE_MOST] = {0};
	struct arc arc = {soil, wheel, .entry = angle_of(r, sinkage)};
	double most = reference_yield(soil, wheel->width, sinkage);
	/* p <= K_e z: it springs back by no more than it was pressed. */
	arc.exit = wheel->rebound ? -angle_of(r, fmin(most / soil->elastic_stiffness, sinkage)) : 0;
	double tolerance = TOLERANCE / 4 * r * wheel->width * (most + soil->cohesion) * (arc.entry - arc.exit);
	/* The pressure has a kink where yield begins or ends. */
	double kink = reference_yield_crossing(soil, wheel->width);
	double at = kink < sinkage ? angle_of(r, sinkage - kink) : 0;
	add_part(&arc, arc.exit, 0, tolerance, sums);
	add_part(&arc, 0, at, tolerance, sums);
	add_part(&arc, at, arc.entry, tolerance, sums);
	return (struct reference_rolling_force){
		.drawbar = sums[DRAWBAR], .vertical = sums[VERTICAL], .moment = sums[MOMENT],
		.shear_moment = sums[SHEAR_MOMENT], .shear_vertical = sums[SHEAR_VERTICAL],
	};
}

double reference_rolling_sinkage(const struct soil_numbers *soil, const struct reference_rolling *wheel, double load)
{
	double low = 0, high = LEAST * wheel->radius, factor = pow(LEAST, -1.0 / STEPS);
	for (int i = 0; reference_rolling(soil, wheel, fmin(high, wheel->radius)).vertical < load; i++) {
		if (i > STEPS)
			return (double)NAN;
		low = high;
		high *= factor;
	}
	high = fmin(high, wheel->radius);
	for (int i = 0; i < 60 && low < high; i++) {
		double middle = (low + high) / 2;
		if (reference_rolling(soil, wheel, middle).vertical < load)
			low = middle;
		else
			high = middle;
	}
	return high;
}

double reference_standing_load(const struct soil_numbers *soil, double sinkage, double width, double radius)
{
	/* Both halves yield: each carries what the front of a rolling wheel does. */
	struct reference_rolling wheel = {.radius = radius, .width = width, .turned = 1, .normals = REFERENCE_NORMALS_GROUND};
	return 2 * reference_rolling(soil, &wheel, sinkage).vertical;
}
