/*
 * Three-dimensional resistive force theory: what dry soil pushes on a small flat facet that moves through it. The stress is
 *
 *     xi depth alpha(normal, direction of motion),    xi in N/m3
 *
 * with alpha a polynomial of three numbers of the facet. With the outward normal n, the direction of motion v and z up these are x1 = -v_z, x2 = -n_z and
 * x3 = n . v, and alpha = f1 n + f2 v - f3 z, f_i the polynomials of degree 3 below. So no angle is computed, and none jumps.
 *
 * Source: S. Agarwal, D. I. Goldman, K. Kamrin, PNAS 120 (2023), doi 10.1073/pnas.2214017120, supplement S3. The numbers were read
 * from public copies of the fit. Pure.
 */
#ifndef FURROW_SOIL_RESIST_H
#define FURROW_SOIL_RESIST_H

#include "soil/law/real.h"

#define RESIST_LIFT 0.55f /* share of the upward stress that is left where a facet moves level. Chosen on a rig's locked wheel, which rode too high */

SOIL_INLINED float resist_sum(const float c[20], float x, float y, float w)
{
	return ((c[0] + c[1] * x) + (c[2] * y + c[3] * w)) + ((c[4] * x * x + c[5] * y * y) + (c[6] * w * w + c[7] * x * y)) + ((c[8] * y * w + c[9] * w * x) + (c[10] * x * x * x + c[11] * y * y * y)) +
	       ((c[12] * w * w * w + c[13] * x * y * y) + (c[14] * y * x * x + c[15] * y * w * w)) + ((c[16] * w * y * y + c[17] * w * x * x) + (c[18] * x * w * w + c[19] * x * y * w));
}

/* Gives alpha of a facet. n: its outward unit normal; v: its direction of motion, a unit vector; mu: the tangent of the friction between soil and surface. The
 * fit has no facets that face upwards. One counts as an upright wall of the same heading, and its stress is turned about that heading. */
SOIL_INLINED void resist_alpha(const float n[3], const float v[3], float mu, float alpha[3])
{
	static const float c1[20] = {.00212f, -.02320f, -.20890f, -.43083f, -.00259f, .48872f, -.00415f, .07204f, -.02750f, -.08772f, .01992f, -.45961f, .40799f, -.10107f, -.06576f, .05664f, -.09269f, .01892f, .01033f, .15120f};
	static const float c2[20] = {-.06796f, -.10941f, .04725f, -.06914f, -.05835f, -.65880f, -.11985f, -.25739f, -.26834f, .02692f, -.00736f, .63758f, .08997f, .21069f, .04748f, .20406f, .18519f, .04934f, .13527f, -.33207f};
	static const float c3[20] = {-.02634f, -.03436f, .45256f, .00835f, .02553f, -1.31290f, -.05532f, .06790f, -.16404f, .02287f, .02927f, .95406f, -.00131f, -.11028f, .01487f, -.02730f, .10911f, -.04097f, .07881f, -.27519f};
	const float level = sqrtf(n[0] * n[0] + n[1] * n[1]), by_level = 1 / most(level, 1e-9f), up = most(n[2], 0);
	const bool leans = n[2] > 0;
	const float m[3] = {either(leans, n[0] * by_level, n[0]), either(leans, n[1] * by_level, n[1]), either(leans, 0, n[2])};
	const float x = -v[2], y = -m[2], w = dot3(m, v);
	const float f1 = resist_sum(c1, x, y, w), f2 = resist_sum(c2, x, y, w), f3 = resist_sum(c3, x, y, w);
	const float a[3] = {f1 * m[0] + f2 * v[0], f1 * m[1] + f2 * v[1], f1 * m[2] + f2 * v[2] - f3};
	/* The part across the facet pushes. The part along it is friction: it does not drive the facet, and is limited. */
	const float across = dot3(a, m), pushes = most(-across, 0);
	float t[3], along[3];
	for (int k = 0; k < 3; k++) {
		t[k] = a[k] - across * m[k];
		along[k] = v[k] - w * m[k];
	}
	const float drives = most(dot3(t, along), 0) / (dot3(along, along) + 0.02f);
	for (int k = 0; k < 3; k++)
		t[k] -= drives * along[k];
	const float limit = least(mu * pushes / most(sqrtf(dot3(t, t)), 1e-12f), 1), lift = RESIST_LIFT + (1 - RESIST_LIFT) * fabsf(v[2]);
	const float wall[3] = {limit * t[0] - pushes * m[0], limit * t[1] - pushes * m[1], (limit * t[2] - pushes * m[2]) * lift};
	/* A facet that leans back. */
	const float rise[3] = {-up * m[0], -up * m[1], level}, pushed = -dot3(wall, m), climbs = wall[2];
	for (int k = 0; k < 3; k++) {
		const float turned = wall[k] + pushed * (m[k] - n[k]) + climbs * (rise[k] - (k == 2 ? 1 : 0));
		alpha[k] = either(leans, turned, wall[k]);
	}
}

#endif
