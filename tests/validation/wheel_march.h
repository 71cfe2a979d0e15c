/*
 * The wheel of reference_rolling, derived a second time: posts of any width in x, from first touch backwards.
 * Nothing is taken over from it but the soil's law, and that is written again here. A post's place on the rim and
 * its stress are vectors. The rim's velocity there is a cross product, and j is summed from post to post.
 * The posts are midpoints, crowded towards the kinks of the pressure. Three widths are extrapolated after Richardson.
 */
#ifndef FURROW_TESTS_VALIDATION_WHEEL_MARCH_H
#define FURROW_TESTS_VALIDATION_WHEEL_MARCH_H

#include <math.h>

#include "deform/reference/reference.h"

#define MARCH_POSTS 300 /* of the coarsest of the widths, in each piece of the arc */

struct march_force {
	double sums[3]; /* N forwards, N up, N m about the axle to the left */
};

struct march_vector {
	double x, z;
};

/* z^n or K_e z, whichever is softer. */
static inline double march_pressure(const struct soil_numbers *soil, double width, double sinkage)
{
	double plastic = (soil->bekker_kc / width + soil->bekker_kphi) * exp(soil->bekker_n * log(sinkage));
	double elastic = soil->elastic_stiffness * sinkage;
	return plastic < elastic ? plastic : elastic;
}

/* Adds the posts from x0 back to x1, `posts` of them; none if that is nowhere. *slid: j at x0, then at x1. */
static inline void march_piece(const struct soil_numbers *soil, const struct reference_rolling *wheel, double sinkage, double x0,
			       double x1, int posts, double *slid, struct march_force *force)
{
	double r = wheel->radius, most = march_pressure(soil, wheel->width, sinkage);
	double stays = sinkage - most / soil->elastic_stiffness;
	for (int i = 0; i < posts && x0 > x1; i++) {
		/* Posts are narrow at both ends: the width's root is a polynomial of u. */
		double u = (i + 0.5) / posts;
		double x = x0 + (x1 - x0) * u * u * u * (10 - 15 * u + 6 * u * u);
		double dx = (x0 - x1) * 30 * u * u * (1 - u) * (1 - u) / posts;
		struct march_vector arm = {x, -sqrt(r * r - x * x)};
		double deep = sinkage - r - arm.z, stress;
		if (x > 0)
			stress = deep > 0 ? march_pressure(soil, wheel->width, deep) : 0;
		else
			stress = deep > stays ? soil->elastic_stiffness * (deep - stays) : 0;
		/* Per metre of way: the axle's 1 forwards, and the wheel's turning, omega x arm. */
		double omega = wheel->turned / r;
		struct march_vector spin = {omega * arm.z, -omega * arm.x}, way = {1 + spin.x, spin.z};
		bool rim = wheel->normals == REFERENCE_NORMALS_SURFACE;
		struct march_vector normal = rim ? (struct march_vector){-arm.x / r, -arm.z / r} : (struct march_vector){0, 1};
		struct march_vector back = {-normal.z, normal.x};
		double backwards = way.x * back.x + way.z * back.z;
		/* How much way goes by while the soil's place, or the rim's point, passes the post. */
		double passing = wheel->follows == REFERENCE_FOLLOWS_SOIL ? dx : dx / fabs(spin.x);
		double j = *slid + backwards * passing / 2;
		*slid += backwards * passing;
		double sticks = reference_adhesion(soil->cohesion) * (stress < soil->cohesion ? stress / soil->cohesion : 1);
		double shear = (sticks + stress * tan(soil->friction_angle)) * (1 - exp(-fabs(j) / soil->janosi_shear));
		if (j < 0)
			shear = -shear;
		double area = wheel->width * dx * (rim ? 1 / normal.z : 1);
		struct march_vector f = {(stress * normal.x - shear * back.x) * area, (stress * normal.z - shear * back.z) * area};
		force->sums[0] += f.x;
		force->sums[1] += f.z;
		force->sums[2] += arm.z * f.x - arm.x * f.z;
	}
}

/* Where the arc is `deep` below the surface, before the axle. */
static inline double march_place(double radius, double sinkage, double deep)
{
	double up = sinkage - deep;
	return sqrt(up * (2 * radius - up));
}

static inline struct march_force march_posts(const struct soil_numbers *soil, const struct reference_rolling *wheel,
					     double sinkage, int posts)
{
	struct march_force force = {{0, 0, 0}};
	double k = soil->bekker_kc / wheel->width + soil->bekker_kphi, slid = 0, r = wheel->radius;
	double kink = exp(log(soil->elastic_stiffness / k) / (soil->bekker_n - 1));
	double x = march_place(r, sinkage, 0), middle = march_place(r, sinkage, fmin(kink, sinkage));
	double stays = sinkage - march_pressure(soil, wheel->width, sinkage) / soil->elastic_stiffness;
	/* Where the pressure is the cohesion, on both sides of the axle: from there on the wheel touches wholly. */
	double low = 0, high = sinkage, back = stays + soil->cohesion / soil->elastic_stiffness;
	for (int i = 0; i < 60; i++) {
		double deep = (low + high) / 2;
		*(march_pressure(soil, wheel->width, deep) < soil->cohesion ? &low : &high) = deep;
	}
	double whole = march_place(r, sinkage, low), cuts[] = {x, fmax(whole, middle), fmin(whole, middle), 0};
	for (int i = 0; i < 3; i++)
		march_piece(soil, wheel, sinkage, cuts[i], cuts[i + 1], posts, &slid, &force);
	if (wheel->rebound) {
		double leaves = -march_place(r, sinkage, fmax(0, stays)), part = -march_place(r, sinkage, fmin(fmax(back, 0), sinkage));
		march_piece(soil, wheel, sinkage, 0, part, posts, &slid, &force);
		march_piece(soil, wheel, sinkage, part, leaves, posts, &slid, &force);
	}
	return force;
}

static inline struct march_force march_wheel(const struct soil_numbers *soil, const struct reference_rolling *wheel,
					     double sinkage)
{
	struct march_force at[3], out;
	for (int i = 0; i < 3; i++)
		at[i] = march_posts(soil, wheel, sinkage, MARCH_POSTS << i);
	for (int v = 0; v < 3; v++) {
		double a = at[0].sums[v], b = at[1].sums[v], c = at[2].sums[v];
		/* Errors of the second order, then of the third: the half post of j has one. */
		b += (b - a) / 3;
		c += (c - at[1].sums[v]) / 3;
		out.sums[v] = c + (c - b) / 7;
	}
	return out;
}

#endif
