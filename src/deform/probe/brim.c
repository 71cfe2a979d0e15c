/* The lower end of a cylinder that leans: what it bears beside a cell. */
#include "deform/probe/place.h"

#define STEPS 4 /* lib/scm_post.glsl, sheared_by_end */

/* The lower edge of a cylinder that leans, beside a cell. */
struct edge {
	double at[2], lowest, depth; /* its lowest place beside the part that bears; below the ground there */
	double length, strip;        /* of that part, in lines across a cell; half-width of the strip there */
};

/* height: of the ground at the middle of the line. Returns false if the edge is above the ground. */
static bool find_edge(const struct post *p, const double middle[2], double height, struct edge *edge)
{
	const struct probe_form *form = p->form;
	const double beside = probe_low_side(form) * form->half_axis * form->level;
	double depths[3];
	for (int k = 0; k < 3; k++) {
		const double x = middle[0] + (k - 1) * form->half_across, strip = probe_half_strip(form, x), y = form->lean * strip + beside;
		depths[k] = height + p->rise[0] * (x - middle[0]) + p->rise[1] * (y - middle[1]) - (form->lean * y - strip) * form->lift;
	}
	const double first = root_from(-1, depths), last = probe_most(first, root_from(1, depths));
	edge->at[0] = middle[0] + 0.5 * (first + last) * form->half_across;
	edge->strip = probe_half_strip(form, edge->at[0]);
	edge->at[1] = form->lean * edge->strip + beside;
	edge->lowest = (form->lean * edge->at[1] - edge->strip) * form->lift;
	edge->depth = height + p->rise[0] * (edge->at[0] - middle[0]) + p->rise[1] * (edge->at[1] - middle[1]) - edge->lowest;
	edge->length = 0.5 * (last - first);
	return edge->depth > 0 && edge->length > 0;
}

/* How long the lower end has slid over the soil beside its edge, in contacts. It began when the rim came from ahead, or the end from above. */
static double brim_since(const struct post *p, const struct edge *edge, double mean, double below)
{
	const struct probe_form *form = p->form;
	const double came = form->run > 0 ? probe_most(probe_half_strip(form, below) - edge->at[0], 0) / form->run : 1e9;
	const double sank = form->way[2] < 0 ? -mean / form->way[2] : 1e9, since = probe_least(came, sank);
	return since < 1e9 ? since : 1;
}

/* Gives how the soil is sheared that the lower end slid over. The end turns over the soil, so its way is followed from where it began. */
static void put_sheared(const struct post *p, double since, struct probe_place *place)
{
	const struct probe_form *form = p->form;
	const double each = since / STEPS;
	double all = 0;
	place->mobilised[0] = place->mobilised[1] = 0;
	for (int n = STEPS - 1; n >= 0; n--) {
		double arm[3];
		for (int k = 0; k < 3; k++)
			arm[k] = place->arm[k] + (n + 0.5) * each * form->way[k];
		const struct slip slip = slip_at(form, arm, place->across);
		const double way = slip.size * each * p->soil->by_shear, stays = stays_after(way);
		for (int k = 0; k < 2; k++)
			place->mobilised[k] = slip.direction[k] + stays * (place->mobilised[k] - slip.direction[k]);
		all += way;
	}
	const struct slip slip = slip_at(form, place->arm, place->across);
	deform_place_shears(p, &slip, all, stays_after(all), 1, place);
}

/* What the lower end of a cylinder that leans bears beside a cell: lib/scm_post.glsl, bear_brim. Its area counts as that in plan. */
bool deform_place_brim(const struct post *p, const double middle[2], double height, struct probe_place *place)
{
	const struct probe_form *form = p->form;
	const struct probe_soil *s = p->soil;
	const double low = probe_low_side(form), leans = probe_most(fabs(form->lean), 1e-6), steep = form->level / leans, up = p->ground->up;
	struct edge edge;
	if (!find_edge(p, middle, height, &edge))
		return false;
	const double width = probe_clamp(edge.depth / probe_most(steep - low * p->rise[1], 1e-6), 0, 2 * edge.strip * fabs(form->lean));
	const double mean = edge.depth * pow(s->n + 1, -1 / s->n), out_by = width / (s->n + 2), part = edge.length * width * form->by_step;
	if (!(mean > 0 && part > 0))
		return false;
	const struct probe_face wall = {.normal = {0, -low * form->level, fabs(form->lean)}};
	const double yields = yield_stress(p->law, s, up * mean);
	*place = (struct probe_place){
		.arm = {edge.at[0], edge.at[1] + low * out_by, edge.lowest + out_by * steep + (p->over ? p->rests - p->face.height : 0)},
		.area = part, .ground = part, .stress = yields, .sinks = yields * (s->n + 1) / edge.depth,
	};
	normal_at(form, p->rise, up, &wall, place->normal);
	put_across(place->normal, place->across);
	deform_place_rates(p, probe_least(4 * up * mean * s->by_shear, 1), place);
	place->strength = strength_of(p->law, s, place->stress, &place->holds);
	put_sheared(p, brim_since(p, &edge, mean, edge.strip - out_by / leans), place);
	return true;
}
