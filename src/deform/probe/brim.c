/* The lower end of a cylinder that leans: what it bears beside a cell. */
#include "deform/probe/brim.h"

#define STEPS 4 /* lib/scm_post.glsl, sheared_by_end */

/* The lower edge of a cylinder that leans, beside a cell. */
struct edge {
	double at[2], lowest, depth; /* its lowest place beside the part that bears; below the ground there */
	double length, strip;        /* of that part, in lines across a cell; half-width of the strip there */
};

/* middle: of the line across the cell; height, rise: of the ground there. Returns false if the edge is above the ground. */
static bool find_edge(const struct probe_form *form, const double middle[2], double height, const double rise[2], struct edge *edge)
{
	const double beside = probe_low_side(form) * form->half_axis * form->level;
	double depths[3];
	for (int k = 0; k < 3; k++) {
		const double x = middle[0] + (k - 1) * form->half_across, strip = probe_half_strip(form, x), y = form->lean * strip + beside;
		depths[k] = height + rise[0] * (x - middle[0]) + rise[1] * (y - middle[1]) - (form->lean * y - strip) * form->lift;
	}
	const double first = root_from(-1, depths), last = probe_most(first, root_from(1, depths));
	edge->at[0] = middle[0] + 0.5 * (first + last) * form->half_across;
	edge->strip = probe_half_strip(form, edge->at[0]);
	edge->at[1] = form->lean * edge->strip + beside;
	edge->lowest = (form->lean * edge->at[1] - edge->strip) * form->lift;
	edge->depth = height + rise[0] * (edge->at[0] - middle[0]) + rise[1] * (edge->at[1] - middle[1]) - edge->lowest;
	edge->length = 0.5 * (last - first);
	return edge->depth > 0 && edge->length > 0;
}

/* How long the lower end has slid over the soil beside its edge, in contacts. It began when the rim came from ahead, or the end from above. A short
 * motion says little of it. */
static double brim_since(const struct probe_form *form, const struct edge *edge, double mean, double below)
{
	const double came = form->run > 0 ? probe_most(probe_half_strip(form, below) - edge->at[0], 0) / form->run : 1e9;
	const double sank = form->way[2] < 0 ? -mean / form->way[2] : 1e9, since = probe_least(came, sank), rolled = probe_least(form->run / form->half_across, 1);
	return !(since < 1e9) ? 1 : since > 1 ? 1 + (since - 1) * rolled * rolled : since;
}

/* Gives how the soil is sheared that the lower end slid over. The end turns over the soil, so its way is followed from where it began. */
static void put_sheared(const struct probe_form *form, double by_modulus, double since, struct probe_place *place)
{
	const double each = since / STEPS;
	place->mobilised[0] = place->mobilised[1] = 0;
	for (int n = STEPS - 1; n >= 0; n--) {
		double arm[3];
		for (int k = 0; k < 3; k++)
			arm[k] = place->arm[k] + (n + 0.5) * each * form->way[k];
		const struct slip slip = slip_at(form, arm, place->normal, place->across);
		const double stays = stays_after(slip.size * each * by_modulus);
		for (int k = 0; k < 2; k++)
			place->mobilised[k] = slip.direction[k] + stays * (place->mobilised[k] - slip.direction[k]);
	}
	const struct slip slip = slip_at(form, place->arm, place->normal, place->across);
	const double own = slip.size * probe_least(since, 1) * by_modulus; /* how the way before this motion changes is left out */
	put_shears(&slip, by_modulus, own, stays_after(own), 1, place);
}

/* lib/scm_post.glsl, bear_brim. Its area counts as that in plan. */
bool deform_brim_at(const struct probe_law *law, const struct lanes *l, int i, struct probe_place *place)
{
	const struct probe_form *form = &law->form;
	const struct place_soil s = soil_of(l, i);
	const double low = probe_low_side(form), leans = probe_most(fabs(form->lean), 1e-6), steep = form->level / leans, up = l->up[i];
	const double middle[2] = {l->centre[0][i], l->centre[1][i]}, rise[2] = {l->rise[0][i], l->rise[1][i]};
	const double height = l->height[i] + rise[0] * l->middle[0][i] + rise[1] * l->middle[1][i];
	const double above = above_of(l, i);
	struct edge edge;
	if (!find_edge(form, middle, height - above, rise, &edge))
		return false;
	const double width = probe_clamp(edge.depth / probe_most(steep - low * rise[1], 1e-6), 0, 2 * edge.strip * fabs(form->lean));
	const double mean = edge.depth * pow(s.n + 1, -1 / s.n), out_by = width / (s.n + 2), wall[3] = {0, -low * form->level, fabs(form->lean)};
	const double part = edge.length * width * form->by_step * probe_end_bears(form, rise, wall);
	if (!(mean > 0 && part > 0))
		return false;
	const double yields = yield_stress(&s, up * mean);
	*place = (struct probe_place){
		.arm = {edge.at[0], edge.at[1] + low * out_by, edge.lowest + out_by * steep + above},
		.area = part, .ground = part, .stress = yields, .sinks = yields * (s.n + 1) / edge.depth,
	};
	normal_at(form, rise, up, wall, place->normal);
	put_across(place->normal, place->across);
	put_rates(form, s.damping * probe_least(4 * up * mean * s.by_modulus, 1), place);
	place->strength = strength_of(law, &s, place->stress, &place->holds);
	put_sheared(form, s.by_modulus, brim_since(form, &edge, mean, edge.strip - out_by / leans), place);
	return true;
}
