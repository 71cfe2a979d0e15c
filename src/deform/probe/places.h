/*
 * The soil at a place of the part that bears of each post's cell, for a batch of posts: lib/scm_post.glsl, bearing_of. First what the body is
 * there, for all lanes, then the law.
 */
#ifndef FURROW_DEFORM_PROBE_PLACES_H
#define FURROW_DEFORM_PROBE_PLACES_H

#include "deform/probe/lanes.h"
#include "deform/probe/law.h"
#include "deform/probe/place.h"

/* What is known of a place of each lane before the law is asked. */
struct lane_spots {
	double at[2][LANES], rise[LANES], deep[LANES]; /* m; of the ground from the post; of the body below the ground */
	double part[LANES];                            /* share of a post's area */
	double most[LANES], unloads[LANES];            /* m along the normal: the largest sinkage; share by which that stays as the body sinks */
	double yields[LANES];                          /* Pa: yield stress */
	double touching[LANES], stays[LANES];          /* way since the surface touches, of the shear modulus; stays_after that */
	double bends[3][LANES], ends[LANES];           /* deform_over_bends */
	struct lane_faces faces;
};

/* Computes one place on each post's line. share: where it lies on the part that bears, from -1 at its first end to 1. Call deform_law_bear first. */
void deform_places_put(const struct probe_form *form, const struct lanes *lanes, double share, struct lane_spots *spots);

/* Computes the place of a lane's spot. Its area is 0 if it does not bear. */
LANES_INLINED static inline void put_place(const struct probe_law *law, const struct lanes *l, const struct lane_spots *spots, int i,
					   struct probe_place *place)
{
	const struct probe_form *form = &law->form;
	const struct place_soil s = soil_of(l, i);
	const double up = l->up[i], rise[2] = {l->rise[0][i], l->rise[1][i]};
	const double facing[3] = {spots->faces.normal[0][i], spots->faces.normal[1][i], spots->faces.normal[2][i]};
	const double most = spots->most[i], z = up * spots->deep[i], yields = spots->yields[i];
	const double plastic = plastic_part(&s, most, yields), by_elastic = 1 / probe_most(most - plastic, 1e-9);
	const double springs = probe_clamp((z + PROBE_LEAST - plastic) * by_elastic, 0, 1); /* without a step, and no less than the GPU's */
	const double flows = probe_either(z >= most - 1e-9, 1, 0), share = probe_most(flows, springs);
	normal_at(form, rise, up, facing, place->normal);
	put_across(place->normal, place->across);
	place->arm[0] = spots->at[0][i];
	place->arm[1] = spots->at[1][i];
	place->arm[2] = spots->faces.height[i] + above_of(l, i);
	place->ground = probe_either(probe_least(z, share) > 0, 0.5 * spots->part[i], 0);
	const double ends = probe_either(spots->ends[i] > 0, probe_end_bears(form, rise, place->normal), 1);
	place->area = place->ground * ends / probe_either(form->ground_normals + spots->ends[i] > 0, 1, place->normal[2]);
	place->stress = yields * share;
	const double unloads = (1 - flows) * spots->unloads[i];
	place->sinks = up * ((1 - unloads) * yield_growth(&s, yields, most) + unloads * yields * by_elastic);
	put_rates(form, s.damping * probe_least(4 * share, 1) * probe_least(4 * probe_most(most, 0) * s.by_modulus, 1), place);
	const struct slip slip = slip_at(form, place->arm, place->normal, place->across);
	for (int k = 0; k < 2; k++)
		place->mobilised[k] = slip.direction[k] + spots->stays[i] * (l->shear[k][i] - slip.direction[k]);
	place->strength = strength_of(law, &s, place->stress, &place->holds);
	put_shears(&slip, s.by_modulus, spots->touching[i], spots->stays[i], rim_time(form, place->normal[2]), place);
	for (int k = 0; k < 3; k++)
		place->bends[k] = spots->bends[k][i];
}

/* Gives the stress on the body at a place, Pa: of the surface. shear: of its shear, the direction times the share of the strength. */
static inline void stress_at(const struct probe_place *place, double shear[3], double stress[3])
{
	for (int k = 0; k < 3; k++) {
		shear[k] = place->mobilised[0] * place->across[0][k] + place->mobilised[1] * place->across[1][k];
		stress[k] = place->stress * place->normal[k] - place->strength * shear[k] - place->dragged[0] * place->across[0][k] -
			    place->dragged[1] * place->across[1][k];
	}
}

#endif
