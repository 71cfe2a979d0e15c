/* 3D-RFT by its angles: see faces_oracle.h. */
#include "faces_oracle.h"

#include <math.h>

#define UPRIGHT 1e-9 /* a velocity with a smaller level part, of 1, is upright */

static const double c1[20] = {.00212, -.02320, -.20890, -.43083, -.00259, .48872, -.00415, .07204, -.02750, -.08772,
			      .01992, -.45961, .40799, -.10107, -.06576, .05664, -.09269, .01892, .01033, .15120};
static const double c2[20] = {-.06796, -.10941, .04725, -.06914, -.05835, -.65880, -.11985, -.25739, -.26834, .02692,
			      -.00736, .63758, .08997, .21069, .04748, .20406, .18519, .04934, .13527, -.33207};
static const double c3[20] = {-.02634, -.03436, .45256, .00835, .02553, -1.31290, -.05532, .06790, -.16404, .02287,
			      .02927, .95406, -.00131, -.11028, .01487, -.02730, .10911, -.04097, .07881, -.27519};

static double dot(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

double faces_oracle_xi(double unit_weight, double tan_phi)
{
	return unit_weight * (894 * pow(tan_phi, 3) - 386 * pow(tan_phi, 2) + 89 * tan_phi);
}

/* The local frame: r level along the motion, theta to its left, z up. */
static void frame_of(const double n[3], const double v[3], double r[3], double theta[3])
{
	const double *along = hypot(v[0], v[1]) > UPRIGHT ? v : n;
	const double level = hypot(along[0], along[1]);
	r[0] = level > UPRIGHT ? along[0] / level : 1;
	r[1] = level > UPRIGHT ? along[1] / level : 0;
	theta[0] = -r[1];
	theta[1] = r[0];
	r[2] = theta[2] = 0;
}

/* The fit: stress on a facet of tilt beta and twist psi that attacks by gamma, along r, theta and z. */
static void fit(double beta, double gamma, double psi, double stress[3])
{
	const double x1 = sin(gamma), x2 = cos(beta), x3 = cos(psi) * cos(gamma) * sin(beta) + sin(gamma) * cos(beta);
	const double terms[20] = {1, x1, x2, x3, x1 * x1, x2 * x2, x3 * x3, x1 * x2, x2 * x3, x3 * x1, x1 * x1 * x1, x2 * x2 * x2, x3 * x3 * x3,
				  x1 * x2 * x2, x2 * x1 * x1, x2 * x3 * x3, x3 * x2 * x2, x3 * x1 * x1, x1 * x3 * x3, x1 * x2 * x3};
	double f1 = 0, f2 = 0, f3 = 0;
	for (int k = 0; k < 20; k++) {
		f1 += c1[k] * terms[k];
		f2 += c2[k] * terms[k];
		f3 += c3[k] * terms[k];
	}
	stress[0] = f1 * sin(beta) * cos(psi) + f2 * cos(gamma);
	stress[1] = f1 * sin(beta) * sin(psi);
	stress[2] = -f1 * cos(beta) - f2 * sin(gamma) - f3;
}

/* Limits the part of a stress along the facet. n: its normal; v: unit vector. */
static void limit(const struct faces_oracle_law *law, const double n[3], const double v[3], double stress[3])
{
	const double across = dot(stress, n), through = dot(v, n);
	double along[3], slides[3];
	for (int k = 0; k < 3; k++) {
		along[k] = stress[k] - across * n[k];
		slides[k] = v[k] - through * n[k];
	}
	const double squares = dot(slides, slides), helps = dot(along, slides);
	for (int k = 0; k < 3 && law->helps > 0 && helps > 0; k++)
		along[k] -= helps / (squares + law->helps) * slides[k];
	const double size = sqrt(dot(along, along)), most = law->mu * fabs(across);
	for (int k = 0; k < 3; k++)
		stress[k] = across * n[k] + along[k] * (size > most ? most / size : 1);
}

void faces_oracle_alpha(const struct faces_oracle_law *law, const double normal[3], const double velocity[3], double alpha[3])
{
	const double speed = sqrt(dot(velocity, velocity)), level = hypot(normal[0], normal[1]);
	double n[3] = {normal[0], normal[1], normal[2]}, v[3], r[3], theta[3], stress[3], part = 1;
	alpha[0] = alpha[1] = alpha[2] = 0;
	if (!(dot(normal, velocity) > 0))
		return;
	for (int k = 0; k < 3; k++)
		v[k] = velocity[k] / speed;
	frame_of(n, v, r, theta);
	if (n[2] > 0) {
		n[0] = level > 0 ? n[0] / level : r[0];
		n[1] = level > 0 ? n[1] / level : r[1];
		n[2] = 0;
		part = law->upright_part ? level : 1;
	}
	const double beta = atan2(hypot(n[0], n[1]), -n[2]), psi = atan2(dot(n, theta), dot(n, r)), gamma = atan2(-v[2], dot(v, r));
	fit(beta, gamma, psi, stress);
	for (int k = 0; k < 3; k++)
		alpha[k] = stress[0] * r[k] + stress[1] * theta[k] + (k == 2 ? stress[2] : 0);
	limit(law, n, v, alpha);
	alpha[2] *= law->lift + (1 - law->lift) * fabs(v[2]);
	for (int k = 0; k < 3; k++)
		alpha[k] *= part;
}

void faces_oracle_force(const struct faces_oracle_law *law, const struct faces_oracle_facet *facets, size_t count, double level,
			const struct faces_oracle_twist *twist, double force[3], double moment[3])
{
	for (int k = 0; k < 3; k++)
		force[k] = moment[k] = 0;
	for (size_t i = 0; i < count; i++) {
		const double depth = level - facets[i].at[2];
		double arm[3], velocity[3], alpha[3], own[3];
		if (!(depth > 0))
			continue;
		for (int k = 0; k < 3; k++)
			arm[k] = facets[i].at[k] - twist->centre[k];
		for (int k = 0; k < 3; k++)
			velocity[k] = twist->velocity[k] + twist->rate[(k + 1) % 3] * arm[(k + 2) % 3] - twist->rate[(k + 2) % 3] * arm[(k + 1) % 3];
		faces_oracle_alpha(law, facets[i].normal, velocity, alpha);
		for (int k = 0; k < 3; k++)
			own[k] = law->xi * depth * facets[i].area * alpha[k];
		for (int k = 0; k < 3; k++) {
			force[k] += own[k];
			moment[k] += arm[(k + 1) % 3] * own[(k + 2) % 3] - arm[(k + 2) % 3] * own[(k + 1) % 3];
		}
	}
}

void faces_oracle_place(const struct soil_facets *facets, const double axes[3][3], const double centre[3], struct faces_oracle_facet *out)
{
	for (size_t i = 0; i < facets->count; i++) {
		double at[3] = {(double)facets->x[i], (double)facets->y[i], (double)facets->z[i]};
		double n[3] = {(double)facets->nx[i], (double)facets->ny[i], (double)facets->nz[i]};
		out[i].area = (double)facets->area[i];
		for (int k = 0; k < 3; k++) {
			out[i].at[k] = centre[k] + at[0] * axes[0][k] + at[1] * axes[1][k] + at[2] * axes[2][k];
			out[i].normal[k] = n[0] * axes[0][k] + n[1] * axes[1][k] + n[2] * axes[2][k];
		}
	}
}
