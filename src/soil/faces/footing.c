/*
 * What a flat sole bears while it slides: as a footing does under an inclined load.
 *
 * Resistive force theory was fitted to narrow plates, whose stress grows with depth alone. A wide sole bears by its width, too. Its bearing capacity, Pa, is
 *
 *     c Nc ic + g z Nq iq + g B Ng ig / 2,    Nq = e^(pi tan phi) tan(45 + phi / 2)^2,  Nc = (Nq - 1) / tan phi,  Ng = 2 (Nq + 1) tan phi
 *     iq = (1 - h)^m,  ig = (1 - h)^(m + 1),  ic = iq - (1 - iq) / (Nc tan phi),  m = (2 + a) / (1 + a)
 *
 * h is the level part of the load over the upright one. The sole is `a` times as long along its way as across it, and B is the lesser of both lengths. Until it
 * has sunk so far, it bears what the law of the lower envelope says of its depth. So that law keeps the share of what is slid that fills up what the facets do
 * not bear.
 *
 * Source: A. S. Vesic, Analysis of ultimate loads of shallow foundations, Journal of the Soil Mechanics and Foundations Division 99 (1973). The load's inclination
 * counts as if it had no cohesion along the sole, which is less than Vesic's.
 */
#include "soil/faces/footing.h"

#include "soil/faces/slid.h"

#define TANGENT_LEAST 0.02 /* of the friction angle. Below it Nc is within 6 % of Prandtl's 5.14 */
#define INCLINED_MOST 0.95 /* h: a load that is more inclined counts as this */

void soil_footing_of(const struct soil_numbers *soil, double cohesion, double along, double level, struct soil_footing *footing)
{
	const double tangent = fmax(tan(soil->friction_angle), TANGENT_LEAST), phi = atan(tangent), root = tan(M_PI / 4 + phi / 2), nq = exp(M_PI * tangent) * root * root;
	const double nc = (nq - 1) / tangent, h = fmin(along * level, INCLINED_MOST);
	*footing = (struct soil_footing){
		.by_depth = (float)(soil->unit_weight * nq), .by_width = (float)(soil->unit_weight * (nq + 1) * tangent), .by_cohesion = (float)(cohesion * nc),
		.by_both = (float)(1 / (nc * tangent)), .upright = (float)(1 - h), .k_c = (float)soil->bekker_kc, .k_phi = (float)soil->bekker_kphi, .n = (float)soil->bekker_n,
	};
}

/* What of a sole is in soil. */
struct sole {
	float area, volume, force;  /* m2; m3 that it displaces; N that its facets bear */
	float sides[2];             /* along and across its way, m */
};

/* Returns how much of a facet is in soil and looks down, 0 .. 1. size: m, of a facet. */
static float looks_down(const struct soil_faces *faces, size_t n, float size)
{
	return faces->under[n] * faces->sole[n] * soil_facet_in(faces->deep[n], faces->tall[n], size);
}

static void place_along(const struct soil_faces *faces, size_t n, const float way[2], float at[2])
{
	at[0] = faces->x[n] * way[0] + faces->y[n] * way[1];
	at[1] = faces->y[n] * way[0] - faces->x[n] * way[1];
}

/* A facet counts for the lengths as far as it is in soil. So they change evenly as the body sinks. */
static struct sole sole_of(const struct soil_faces *faces, const float way[2], float size)
{
	struct sole s = {.area = 0};
	float at[2], middle[2] = {0}, most_of[2] = {0}, least_of[2] = {0};
	for (size_t n = 0; n < faces->count; n++) {
		const float area = looks_down(faces, n, size) * faces->whole[n];
		place_along(faces, n, way, at);
		s.area += area;
		s.volume += area * most(faces->deep[n], 0);
		s.force += faces->under[n] * faces->pressure[n] * faces->pz[n];
		for (int k = 0; k < 2; k++)
			middle[k] += area * at[k];
	}
	for (size_t n = 0; n < faces->count && s.area > 0; n++) {
		const float in = looks_down(faces, n, size), half = 0.5f * sqrtf(faces->whole[n]);
		place_along(faces, n, way, at);
		for (int k = 0; k < 2; k++) {
			most_of[k] = most(most_of[k], in * (at[k] - middle[k] / s.area + half));
			least_of[k] = most(least_of[k], in * (middle[k] / s.area - at[k] + half));
		}
	}
	for (int k = 0; k < 2; k++)
		s.sides[k] = most(most_of[k] + least_of[k], 1e-6f);
	return s;
}

float soil_footing_share(const struct soil_form *form, const struct soil_faces *faces, const float way[2])
{
	const struct soil_footing *footing = &faces->footing;
	const float slid = faces_share(slid_at(form, 0, 0));
	const struct sole sole = sole_of(faces, way, form->spacing);
	if (!(sole.area > 0) || !(slid > 0))
		return 0;
	/* Several feet have less area than the rectangle around them. */
	const float width = least(sole.area / most(sole.sides[0], sole.sides[1]), least(sole.sides[0], sole.sides[1])), depth = sole.volume / sole.area;
	const float aspect = sole.sides[0] / sole.sides[1];
	const float by_weight = power_of(footing->upright, (2 + aspect) / (1 + aspect)), by_cohesion = most(by_weight - (1 - by_weight) * footing->by_both, 0);
	const float bears = footing->by_cohesion * by_cohesion + by_weight * (footing->by_depth * depth + footing->by_width * footing->upright * width);
	const float plain = most(footing->k_c / width + footing->k_phi, 1e-6f) * power_of(most(depth, 1e-6f), footing->n), facets = sole.force / (slid * sole.area);
	return clamped((least(bears, plain) - facets) / plain, 0, 1);
}
