/* The law of scm at a batch of posts. See shaders/lib/scm_post.glsl and SOIL.md. */
#include "deform/probe/place.h"

#include <string.h>

#include "deform/probe/over.h"

#define REACHED_LEAST 1e-9    /* m: more than rounding of doubles */

void deform_law_take(const struct probe_law *law, size_t number, const double at[2], struct lanes *l)
{
	const double *axis = law->form.axis;
	const struct probe_post *ground = &law->patch->posts[number];
	const struct probe_soil *soil = &law->patch->soils[ground->soil];
	const int i = l->count;
	l->number[i] = number;
	l->at[0][i] = at[0];
	l->at[1][i] = at[1];
	l->height[i] = ground->height - law->above_zero;
	l->base[i] = l->height[i] - ground->deposited;
	l->rise[0][i] = axis[0] * ground->rise[0] + axis[1] * ground->rise[1];
	l->rise[1][i] = axis[0] * ground->rise[1] - axis[1] * ground->rise[0];
	l->up[i] = ground->up;
	l->by_up[i] = ground->by_up;
	l->was[i] = ground->was;
	l->dug[i] = ground->dug;
	l->shear[0][i] = axis[0] * ground->shear[0] + axis[1] * ground->shear[1];
	l->shear[1][i] = axis[0] * ground->shear[1] - axis[1] * ground->shear[0];
	l->reached[i] = ground->reached - law->above_zero;
	l->k[i] = probe_most(soil->k_c * law->by_width + soil->k_phi, 0);
	l->n[i] = soil->n;
	l->elastic[i] = soil->elastic;
	l->by_elastic[i] = soil->by_elastic;
	l->cohesion[i] = soil->cohesion;
	l->tan_phi[i] = soil->tan_phi;
	l->modulus[i] = soil->shear;
	l->by_modulus[i] = soil->by_shear;
	l->damping[i] = soil->damping;
	if (law->form.kind == SOIL_WHEEL || deform_over_post(&law->form, l, i))
		l->count++;
}

/* --- what a post remembers --- */

static bool any_above(const double numbers[LANES], double least)
{
	double most[4] = {numbers[0], numbers[1], numbers[2], numbers[3]};
	for (int i = 4; i < LANES; i += 4) {
		most[0] = probe_most(most[0], numbers[i]);
		most[1] = probe_most(most[1], numbers[i + 1]);
		most[2] = probe_most(most[2], numbers[i + 2]);
		most[3] = probe_most(most[3], numbers[i + 3]);
	}
	return probe_most(probe_most(most[0], most[1]), probe_most(most[2], most[3])) > least;
}

LANES_CLONED static void put_depths(struct lanes *restrict l)
{
	for (int i = 0; i < LANES; i++)
		l->depth[i] = l->height[i] - probe_either(l->over[i] > 0, l->rests[i], l->face.height[i]);
}

/* Sets `plastic`. */
LANES_CLONED static void put_plastic(struct lanes *restrict l)
{
	if (!any_above(l->was, 0)) {
		memset(l->plastic, 0, sizeof l->plastic);
		return;
	}
	for (int i = 0; i < LANES; i++) {
		const struct place_soil soil = soil_of(l, i);
		l->plastic[i] = plastic_of(&soil, l->was[i]);
	}
}

/* Gives the shares of the shear strength, by size, that were mobilised before the motion, in its middle and at its end; and their mean. */
static inline double mean_mobilised(const double shear[2], const double direction[2], double halfway)
{
	double sizes[3] = {0, 0, 0};
	for (int k = 0; k < 2; k++) {
		const double more = shear[k] - direction[k], middle = direction[k] + halfway * more, end = direction[k] + halfway * halfway * more;
		sizes[0] += shear[k] * shear[k];
		sizes[1] += middle * middle;
		sizes[2] += end * end;
	}
	return (sqrt(sizes[0]) + 4 * sqrt(sizes[1]) + sqrt(sizes[2])) * (1.0 / 6);
}

/* Slip digs: SOIL.md, step 5. directions: in which the body's surface passed. */
LANES_CLONED static void dig(const struct probe_form *restrict form, struct lanes *restrict l, double directions[restrict 2][LANES])
{
	for (int i = 0; i < LANES; i++) {
		const struct place_soil s = soil_of(l, i);
		const double direction[2] = {directions[0][i], directions[1][i]}, shear[2] = {l->shear[0][i], l->shear[1][i]};
		const double deepest = probe_most(l->up[i] * (l->height[i] - l->lowest[i]), 0), sunk = l->up[i] * (l->height[i] - l->rests[i]);
		const double after = probe_most(l->was[i], deepest), least = probe_least(plastic_of(&s, after), after - PROBE_UNIT);
		const double touching = probe_most(probe_least(l->passed[i], 1), 0), halfway = stays_after(0.5 * l->slides[i] * touching);
		const double mean = mean_mobilised(shear, direction, halfway);
		const double most = probe_least(form->dig_most * s.modulus * l->by_up[i], 95) - l->dug[i];
		const double digs = probe_most(most, 0) * (1 - stays_after(form->slip * touching * s.by_modulus * mean));
		const double room = l->height[i] - l->rests[i] - 2 * PROBE_UNIT, deeper = probe_most(probe_least(digs, room), 0);
		const double in_contact = probe_either(sunk > probe_most(least, 0), l->over[i], 0), more = in_contact * deeper;
		l->height[i] -= more;
		l->was[i] = probe_most(l->was[i] - l->up[i] * more, 0);
	}
}

/* Finds what slid and what was dug. */
LANES_CLONED static void slide(const struct probe_form *restrict form, struct lanes *restrict l)
{
	struct lane_faces then;
	double back[2][LANES], directions[2][LANES];
	for (int i = 0; i < LANES; i++) {
		const double half = 0.5 * probe_most(lasted_of(l, i), 0);
		back[0][i] = l->at[0][i] + half * form->way[0];
		back[1][i] = l->at[1][i] + half * form->way[1];
	}
	deform_over_faces(form, l, back[0], back[1], &then);
	for (int i = 0; i < LANES; i++) {
		const double rise[2] = {l->rise[0][i], l->rise[1][i]}, facing[3] = {then.normal[0][i], then.normal[1][i], then.normal[2][i]};
		const double arm[3] = {back[0][i], back[1][i], then.height[i] + above_of(l, i)};
		double normal[3], across[2][3];
		normal_at(form, rise, l->up[i], facing, normal);
		put_across(normal, across);
		const struct slip slip = slip_at(form, arm, normal, across);
		l->slides[i] = slip.size * rim_time(form, normal[2]) * l->by_modulus[i];
		directions[0][i] = slip.direction[0];
		directions[1][i] = slip.direction[1];
	}
	if (form->dig_most > 0 && form->slip >= SOIL_SLIP_LEAST)
		dig(form, l, directions);
}

/* Finds how much of what a post remembers has the shape that the lower envelope had at the contact's start. */
LANES_CLONED static void print(const struct probe_form *restrict form, struct lanes *restrict l)
{
	double before[2][LANES];
	const double rose = form->way[2];
	for (int i = 0; i < LANES; i++)
		for (int k = 0; k < 2; k++)
			before[k][i] = l->at[k][i] + form->way[k];
	deform_over_heights(form, l, before[0], before[1], l->print_height);
	if (form->dig_most > 0 && form->slip >= SOIL_SLIP_LEAST)
		put_plastic(l);
	for (int i = 0; i < LANES; i++) {
		const double depth = l->depth[i] + l->face.height[i] - l->print_height[i] + rose, stays = l->plastic[i] * l->by_up[i];
		const double whole = probe_most(l->was[i] * l->by_up[i] - stays, 1e-9);
		l->printed[i] = probe_clamp((depth - stays + 4 * PROBE_LEAST) / whole, 0, 1);
		l->stamped[i] = probe_either(l->was[i] > 0, form->stamps, 0);
	}
}

LANES_CLONED static void remember(const struct probe_form *restrict form, struct lanes *restrict l)
{
	const double moved = form->moved, most_back = form->run + probe_least(form->run, form->half_across);
	put_plastic(l);
	deform_over_passed(form, l);
	slide(form, l);
	put_depths(l);
	for (int i = 0; i < LANES; i++) {
		const double excess = l->lowest[i] - l->reached[i], over = l->over[i];
		l->excess[i] = probe_either(excess > REACHED_LEAST, over * excess, 0);
		l->lowered[i] = over * (l->rests[i] - l->lowest[i]);
		l->back[i] = probe_either(over > 0, most_back, 1e3);
	}
	for (int i = 0; i < LANES; i++) {
		/* The way that mobilises so much from rest, in units of the shear modulus. */
		const double mobilised = sqrt(l->shear[0][i] * l->shear[0][i] + l->shear[1][i] * l->shear[1][i]);
		const double way = probe_either(mobilised > 0.9999, 1e3, probe_minus_log(probe_most(1 - mobilised, 1e-4)));
		const double before = probe_clamp(way / probe_most(l->slides[i] * (l->passed[i] - 1), 1e-9), 0, 1);
		const double lasts = probe_either(l->passed[i] > 1, before, 1);
		l->lasts[i] = probe_either(l->over[i] > 0, lasts, 1) * moved;
	}
	print(form, l);
}

/* --- the line across a cell --- */

/* Gives the largest sinkage that places of the cells remember, vertically. rise: of the ground from the posts. */
LANES_CLONED void deform_law_remembered(const struct probe_form *restrict form, const struct lanes *restrict l, const double x[restrict LANES],
			   const double y[restrict LANES], const double depth[restrict LANES], const double rise[restrict LANES],
			   double remembered[restrict LANES])
{
	double before[2][LANES], height[LANES];
	if (!any_above(l->was, 0)) {
		memset(remembered, 0, LANES * sizeof *remembered);
		return;
	}
	const double leaning = probe_strips(form) ? 1 : 0;
	for (int i = 0; i < LANES; i++) {
		before[0][i] = x[i] + form->way[0];
		before[1][i] = y[i] + form->way[1];
	}
	deform_over_heights(form, l, before[0], before[1], height);
	for (int i = 0; i < LANES; i++) {
		const double print = rise[i] + l->print_height[i] - height[i];
		/* Across its way a rut leans as the cylinder does. */
		const double leans = leaning * (1 - l->stamped[i]) * (l->rise[1][i] - form->lean * form->lift) * (y[i] - l->at[1][i]);
		const double hollow = l->stamped[i] * (depth[i] - l->depth[i]) + leans;
		const double all = l->was[i] * l->by_up[i] + l->printed[i] * print + (1 - l->printed[i]) * hollow;
		remembered[i] = probe_either(l->was[i] > 0, all, 0);
	}
}

LANES_CLONED static void put_line(const struct probe_form *restrict form, struct lanes *restrict l)
{
	const double least = form->kind == SOIL_WHEEL || probe_strips(form) ? INFINITY : 1e-8;
	for (int i = 0; i < LANES; i++) {
		const double x = l->rise[0][i] - l->face.slope[0][i], y = l->rise[1][i] - l->face.slope[1][i], squares = x * x + y * y;
		const double by = form->half_across / sqrt(probe_most(squares, 1e-8));
		l->end[0][i] = probe_either(squares >= least, x * by, form->half_across);
		l->end[1][i] = probe_either(squares >= least, y * by, 0);
		l->centre[0][i] = l->at[0][i] + l->middle[0][i];
		l->centre[1][i] = l->at[1][i] + l->middle[1][i];
	}
}

/* Gives the ends of what bears on the line. An end bears from the surface on, or where it sank deeper before, from the plastic part of that on. */
LANES_CLONED static void put_ends(struct lanes *restrict l, double depths[restrict 3][LANES], double mosts[restrict 3][LANES])
{
	double above[3][LANES], unloads[2][LANES];
	bool known = false;
	for (int k = 0; k < 2; k++) {
		for (int i = 0; i < LANES; i++)
			unloads[k][i] = probe_either(mosts[2 * k][i] > probe_most(depths[2 * k][i], 0) + PROBE_LEAST, 1, 0);
		known = known || any_above(unloads[k], 0);
	}
	for (int k = 0; k < 3 && known; k++)
		for (int i = 0; i < LANES; i++) {
			const struct place_soil soil = soil_of(l, i);
			above[k][i] = depths[k][i] - plastic_of(&soil, mosts[k][i] * l->up[i]) * l->by_up[i];
		}
	if (!known)
		memcpy(above, depths, sizeof above);
	for (int i = 0; i < LANES; i++) {
		double from[3], to[3];
		for (int k = 0; k < 3; k++) {
			from[k] = probe_either(unloads[0][i] > 0, above[k][i], depths[k][i]);
			to[k] = probe_either(unloads[1][i] > 0, above[k][i], depths[k][i]);
		}
		l->first[i] = root_from(-1, from);
		l->last[i] = root_from(1, to);
	}
	for (int i = 0; i < LANES; i++)
		l->last[i] = probe_most(l->first[i], l->last[i]);
}

LANES_CLONED bool deform_law_bear(const struct probe_law *restrict law, struct lanes *restrict l)
{
	const struct probe_form *form = &law->form;
	double there[2][LANES], rise[LANES], heights[LANES], remembered[LANES], lowered[LANES], since[LANES], depths[3][LANES], mosts[3][LANES];
	if (form->kind == SOIL_WHEEL)
		deform_over_wheel(form, l);
	for (int i = l->count; i < LANES; i++)
		l->share[i] = 0;
	if (!any_above(l->share, 0))
		return false;
	remember(form, l);
	put_line(form, l);
	for (int k = 0; k < 3; k++) {
		for (int i = 0; i < LANES; i++) {
			there[0][i] = l->centre[0][i] + (k - 1) * l->end[0][i];
			there[1][i] = l->centre[1][i] + (k - 1) * l->end[1][i];
			rise[i] = l->rise[0][i] * (there[0][i] - l->at[0][i]) + l->rise[1][i] * (there[1][i] - l->at[1][i]);
		}
		deform_over_heights(form, l, there[0], there[1], heights);
		for (int i = 0; i < LANES; i++)
			depths[k][i] = l->depth[i] + l->face.height[i] + rise[i] - heights[i];
		deform_law_remembered(form, l, there[0], there[1], depths[k], rise, remembered);
		deform_over_lowered(form, l, there[0], there[1], lowered, since);
		for (int i = 0; i < LANES; i++)
			mosts[k][i] = probe_most(remembered[i], depths[k][i] + lowered[i] + l->excess[i]);
	}
	put_ends(l, depths, mosts);
	/* A wheel that sank to its axle does not bear on the soil in front of its rim. */
	for (int i = 0; i < LANES; i++) {
		const bool ahead = (l->over[i] == 0) & (fabs(l->at[0][i]) > form->radius) & (l->depth[i] > 0);
		l->share[i] = probe_either(ahead, 0, l->share[i]);
	}
	return true;
}

bool deform_law_touches(const struct probe_law *law, size_t number, const double at[2], double *height)
{
	const struct probe_post *ground = &law->patch->posts[number];
	double rests;
	if (ground->hole || !deform_form_rests(&law->form, number, at, &rests))
		return false;
	*height = rests + law->above_zero;
	return *height < ground->height;
}
