/*
 * 3D-RFT, a second time and in doubles: what dry soil presses on a facet, by the angles that the authors name, and on any set of facets in level ground.
 * S. Agarwal, D. I. Goldman and K. Kamrin, PNAS 120 (2023), doi 10.1073/pnas.2214017120, supplement S3. The numbers come from public copies of the fit.
 * Pure.
 */
#ifndef FURROW_TESTS_FACES_ORACLE_H
#define FURROW_TESTS_FACES_ORACLE_H

#include <stdbool.h>

#include "soil/faces/facets.h"

/* What is asked for. {.mu = ..., .lift = 1}: the law as published. */
struct faces_oracle_law {
	double xi;       /* N/m3 */
	double mu;       /* tangent of the friction between soil and surface */
	double lift;     /* share of the upward stress that is left where a facet moves level; 1: all of it */
	bool upright_part; /* a facet whose normal points up presses with the upright part of its area only, else with all of it */
	/* Above 0: the part of the stress along a facet that helps its sliding is taken away, but for the share helps / (s + helps), with s the squared sine
	 * of the angle between velocity and normal. The smaller, the sharper: at 0 there is a jump where a facet moves along its normal. */
	double helps;
};

/* A facet in the world: z up, m, m2. */
struct faces_oracle_facet {
	double at[3], normal[3], area;
};

/* A body's motion: the velocity of its centre, m/s, and its rate of rotation about axes through it, rad/s. A wheel's rate has that about its axle. */
struct faces_oracle_twist {
	double centre[3], velocity[3], rate[3];
};

/* Returns xi, N/m3. unit_weight: N/m3; tan_phi: of the soil's inner friction, 0.3 to 0.9. */
double faces_oracle_xi(double unit_weight, double tan_phi);
/* Gives the stress for each unit of xi and metre of depth. normal: unit vector; velocity: of any length. Zero unless normal . velocity > 0. A facet whose
 * normal points up counts as an upright one: it lies outside of the fit. */
void faces_oracle_alpha(const struct faces_oracle_law *law, const double normal[3], const double velocity[3], double alpha[3]);
/* Sums force and moment about the twist's centre, N and N m. level: height of the ground, m. A facet presses if its middle is below that. */
void faces_oracle_force(const struct faces_oracle_law *law, const struct faces_oracle_facet *facets, size_t count, double level,
			const struct faces_oracle_twist *twist, double force[3], double moment[3]);
/* Puts a body's facets into the world. axes: the body's own x, y, z. */
void faces_oracle_place(const struct soil_facets *facets, const double axes[3][3], const double centre[3], struct faces_oracle_facet *out);

#endif
