/* Where the soil is asked on the lines of a batch of posts. */
#include "deform/probe/places.h"

#include "deform/probe/over.h"

LANES_CLONED void deform_places_put(const struct probe_form *restrict form, const struct lanes *restrict l, double share,
				    struct lane_spots *restrict spots)
{
	double lowered[LANES], since[LANES], remembered[LANES];
	for (int i = 0; i < LANES; i++) {
		const double on = 0.5 * (l->first[i] + l->last[i]) + 0.5 * share * (l->last[i] - l->first[i]);
		for (int k = 0; k < 2; k++)
			spots->at[k][i] = l->centre[k][i] + on * l->end[k][i];
		spots->rise[i] = l->rise[0][i] * (spots->at[0][i] - l->at[0][i]) + l->rise[1][i] * (spots->at[1][i] - l->at[1][i]);
		spots->part[i] = 0.5 * l->share[i] * (l->last[i] - l->first[i]);
	}
	deform_over_faces(form, l, spots->at[0], spots->at[1], &spots->faces);
	for (int i = 0; i < LANES; i++)
		spots->deep[i] = l->depth[i] + l->face.height[i] + spots->rise[i] - spots->faces.height[i];
	deform_over_lowered(form, l, spots->at[0], spots->at[1], lowered, since);
	deform_law_remembered(form, l, spots->at[0], spots->at[1], spots->deep, spots->rise, remembered);
	for (int i = 0; i < LANES; i++) {
		const double passed = spots->deep[i] + lowered[i], least = probe_either(l->excess[i] > 0, passed + l->excess[i], remembered[i]);
		const double before = probe_most(remembered[i], least);
		spots->most[i] = l->up[i] * probe_most(before, passed);
		/* Where the body was deeper before in the motion, its deepest pose sinks by less than the last one. */
		spots->unloads[i] = probe_either(passed > before, since[i], 1);
	}
	for (int i = 0; i < LANES; i++) {
		const struct place_soil s = soil_of(l, i);
		spots->yields[i] = yield_stress(&s, spots->most[i]);
	}
	for (int i = 0; i < LANES; i++) {
		const double later = (spots->at[0][i] - l->at[0][i]) * form->by_way[0] + (spots->at[1][i] - l->at[1][i]) * form->by_way[1];
		spots->touching[i] = l->slides[i] * probe_most(lasted_of(l, i) - later * l->lasts[i], 0);
		spots->stays[i] = stays_after(spots->touching[i]);
	}
	deform_over_bends(form, l, spots->at[0], spots->at[1], &spots->faces, spots->bends, spots->ends);
}
