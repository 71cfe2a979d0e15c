/* The law of scm at one post. See shaders/lib/scm_post.glsl and SOIL.md. */
#include "deform/probe/place.h"

#define REACHED_LEAST 1e-9    /* m: more than rounding of doubles */
/* At rest a body would rock and slide to and fro for long, since soil springs back without loss. So what moves slower than these is damped more. */
#define STICKS 0.003          /* m/s along a surface: by the soil's own damping */
#define SETTLES 0.002         /* m/s across it: by SETTLING times as much */
#define SETTLING 10.0

static bool in_contact(double sunk, double most, double plastic)
{
	return sunk > 0 && (sunk >= most - PROBE_UNIT || sunk > plastic);
}

static double displacement_of(double mobilised)
{
	return mobilised > 0.9999 ? 1e3 : -log(1 - mobilised);
}

static void put_slide(struct post *p)
{
	const struct probe_form *form = p->form;
	const double half = 0.5 * probe_most(p->share, 0), back[2] = {p->at[0] + half * form->way[0], p->at[1] + half * form->way[1]};
	struct probe_face then;
	double normal[3], across[2][3];
	probe_face_at(form, p->own, back, &then);
	normal_at(form, p->rise, p->ground->up, &then, normal);
	put_across(normal, across);
	const double arm[3] = {back[0], back[1], then.height + (p->over ? p->rests - p->face.height : 0)};
	const struct slip passed = slip_at(form, arm, across);
	const double rim = form->rim > 0 ? form->rim * form->level / normal[2] : 1;
	p->slides = passed.size * rim * p->soil->by_shear;
	if (!(form->dig_most > 0 && form->slip > 0 && p->over))
		return;
	/* Slip digs: SOIL.md, step 5. */
	const struct probe_soil *s = p->soil;
	const double deepest = probe_most(p->ground->up * (p->height - p->lowest), 0), sunk = probe_most(p->ground->up * (p->height - p->rests), 0);
	const double after = probe_most(p->was, deepest);
	if (!in_contact(sunk, after, plastic_of(p->law, s, after)))
		return;
	const double touching = probe_most(p->share, 0), halfway = stays_after(0.5 * p->slides * touching);
	double sizes[3] = {0, 0, 0};
	for (int k = 0; k < 2; k++) {
		const double middle = passed.direction[k] + halfway * (p->shear[k] - passed.direction[k]);
		const double end = passed.direction[k] + halfway * halfway * (p->shear[k] - passed.direction[k]);
		sizes[0] += p->shear[k] * p->shear[k];
		sizes[1] += middle * middle;
		sizes[2] += end * end;
	}
	const double mean = (sqrt(sizes[0]) + 4 * sqrt(sizes[1]) + sqrt(sizes[2])) / 6;
	const double most = probe_least(form->dig_most * s->shear * p->ground->by_up, 95), digs = 1 - stays_after(form->slip * touching * s->by_shear * mean);
	const double more = probe_most(probe_least(probe_most(most - p->ground->dug, 0) * digs, p->height - p->rests - 2 * PROBE_UNIT), 0);
	p->height -= more;
	p->was = probe_most(p->was - p->ground->up * more, 0);
}

static void begin(const struct probe_law *law, size_t number, const double at[2], struct post *p)
{
	const struct probe_form *form = law->form;
	const struct probe_post *ground = &law->patch->posts[number];
	*p = (struct post){
		.law = law, .form = form, .ground = ground, .soil = &law->patch->soils[ground->soil], .at = {at[0], at[1]},
		.rise = {form->axis[0] * ground->rise[0] + form->axis[1] * ground->rise[1],
			 form->axis[0] * ground->rise[1] - form->axis[1] * ground->rise[0]},
		.height = ground->height - law->above_zero, .was = ground->was,
		.shear = {form->axis[0] * ground->shear[0] + form->axis[1] * ground->shear[1],
			  form->axis[0] * ground->shear[1] - form->axis[1] * ground->shear[0]},
	};
	p->over = deform_form_over(form, number, at, &p->rests, &p->lowest);
	deform_form_own(form, number, p->own);
	probe_face_at(form, p->own, at, &p->face);
	p->depth = p->height - (p->over ? p->rests : p->face.height);
}

/* Finds what slid and what was dug, and what the post remembers. */
static void remember(struct post *p)
{
	const struct probe_form *form = p->form;
	const double by_up = p->ground->by_up, had = p->was, had_plastic = had > 0 ? plastic_of(p->law, p->soil, had) : 0;
	p->since = deform_form_share(form, p->own, p->at, p->depth, had_plastic * by_up, &p->face, p->over);
	p->share = p->over ? probe_least(p->since, 1) : p->since;
	if (p->over) {
		const double excess = p->lowest - (p->ground->reached - p->law->above_zero);
		p->excess = excess > REACHED_LEAST ? excess : 0;
	}
	put_slide(p);
	p->depth = p->height - (p->over ? p->rests : p->face.height);
	const double mobilised = sqrt(p->shear[0] * p->shear[0] + p->shear[1] * p->shear[1]);
	p->lasts = form->moved;
	if (p->over && p->since > 1 && form->moved > 0)
		p->lasts *= probe_clamp(displacement_of(mobilised) / probe_most(p->slides * (p->since - 1), 1e-9), 0, 1);
	p->stamped = p->was > 0 ? form->stamps : 0;
	const double before[2] = {p->at[0] + form->way[0], p->at[1] + form->way[1]};
	if (p->was > 0) {
		p->print_height = probe_height_at(form, p->own, before);
		const double depth = p->depth + p->face.height - p->print_height + form->way[2], stays = (p->was == had ? had_plastic : plastic_of(p->law, p->soil, p->was)) * by_up;
		p->printed = probe_clamp((depth - stays + 4 * PROBE_LEAST) / probe_most(p->was * by_up - stays, 1e-9), 0, 1);
	}
	p->lowered = p->over ? p->rests - p->lowest : 0;
	p->back = p->over ? form->run + probe_least(form->run, form->half_across) : 1e3;
}

/* Returns the largest sinkage that a place of the cell remembers, vertically. rise: of the ground from the post to the place. */
static double remembered_at(const struct post *p, const double there[2], double deep, double rise)
{
	const double before[2] = {there[0] + p->form->way[0], there[1] + p->form->way[1]};
	if (!(p->was > 0))
		return 0;
	const struct probe_form *form = p->form;
	const double print = p->printed > 0 ? rise + p->print_height - probe_height_at(form, p->own, before) : 0;
	/* Across its way a rut leans as the cylinder does. */
	const double leans = probe_strips(form) ? (1 - p->stamped) * (p->rise[1] - form->lean * form->lift) * (there[1] - p->at[1]) : 0;
	return p->was * p->ground->by_up + p->printed * print + (1 - p->printed) * (p->stamped * (deep - p->depth) + leans);
}

/* Returns how much lower than now the body was above a place in the contact. *since: how long ago, in contacts. */
static double lowered_at(const struct post *p, const double there[2], double *since)
{
	double way = 0;
	const double lowered = probe_is_round(p->form) ? probe_lowered(p->form, there, p->back, p->rise[0], &way) : p->lowered;
	*since = probe_is_round(p->form) ? (way > 0 ? probe_least(way / p->form->run, 1) : 0) : lowered > 0;
	return lowered;
}

void deform_place_shears(const struct post *p, const struct slip *slip, double touching, double stays, double rim, struct probe_place *place)
{
	const double by_shear = p->soil->by_shear;
	if (!(slip->size > 1e-9)) { /* it begins to slide: half as stiff on, and half as much stiffer back */
		place->shears[0][0] = place->shears[1][1] = by_shear;
		place->shears[0][1] = place->shears[1][0] = 0;
		return;
	}
	const double aside = touching > 0 ? (1 - stays) / slip->size : 0;
	for (int i = 0; i < 2; i++)
		for (int k = 0; k < 2; k++)
			place->shears[i][k] = (slip->direction[i] - place->mobilised[i]) * slip->direction[k] * by_shear * rim +
					      ((i == k) - slip->direction[i] * slip->direction[k]) * aside;
}

/* How a damping that is for slow motion alone fades. squares: of the speed, as a share of the speed at which it is halved. */
static double fade(double squares)
{
	return 1 / (1 + squares);
}

/* Returns how the stress of such a damping grows with the speed, where `fades` is what fade returned; 0 where it falls. */
static double fade_slope(double fades)
{
	return fades * probe_most(2 * fades - 1, 0);
}

/* Damping: of soil that is pushed down fast, and of a surface that hardly slides. */
void deform_place_rates(const struct post *p, double factor, struct probe_place *place)
{
	const struct probe_form *form = p->form;
	double rolls[3] = {form->angular[0], form->angular[1], form->angular[2]}, moves[3], turns[3];
	const double rolled = form->wheel ? form->linear[0] * form->by_radius : 0;
	rolls[1] += rolled * form->level;
	rolls[2] += rolled * form->lean;
	cross(rolls, place->arm, moves);
	const double down = -(dot(form->linear, place->normal) + dot(moves, place->normal));
	const double slow = fade(down * down / (SETTLES * SETTLES)), settles = SETTLING * p->soil->damping * factor;
	place->damps = down >= 0 ? p->soil->damping * factor : 0;
	place->stress = probe_most(place->stress + (place->damps + settles * slow) * down, 0);
	place->damps += settles * fade_slope(slow);
	rolls[1] = form->angular[1] + form->spins * form->level;
	rolls[2] = form->angular[2] + form->spins * form->lean;
	cross(rolls, place->arm, turns);
	for (int k = 0; k < 3; k++)
		turns[k] += form->linear[k];
	if (form->runs != 0)
		add_belt(form, place->normal, form->runs, turns);
	const double along[2] = {dot(turns, place->across[0]), dot(turns, place->across[1])};
	const double squares = along[0] * along[0] + along[1] * along[1], slow_along = fade(squares / (STICKS * STICKS));
	const double most = p->soil->damping * factor, less = squares > 0 ? most * (slow_along - fade_slope(slow_along)) / squares : 0;
	for (int i = 0; i < 2; i++) {
		place->dragged[i] = most * slow_along * along[i];
		/* It grows less along the way of the surface than across it. */
		for (int k = 0; k < 2; k++)
			place->drags[i][k] = (i == k ? most * slow_along : 0) - less * along[i] * along[k];
	}
}

/* Computes one place on the line. Returns false if it does not bear. */
static bool put_place(const struct post *p, const double there[2], double rise, double part, struct probe_place *place)
{
	const struct probe_form *form = p->form;
	const struct probe_soil *s = p->soil;
	const double up = p->ground->up;
	struct probe_face face;
	probe_face_at(form, p->own, there, &face);
	double since;
	const double deep = p->depth + p->face.height + rise - face.height, passed = deep + lowered_at(p, there, &since);
	const double remains = remembered_at(p, there, deep, rise), remembered = p->excess > 0 ? probe_most(remains, passed + p->excess) : remains;
	const double largest = probe_most(remembered, passed), most = up * largest, z = up * deep;
	if (z <= 0)
		return false;
	const double yields = yield_stress(p->law, s, most), plastic = plastic_part(s, most, yields), elastic = probe_most(most - plastic, 1e-9);
	const bool flows = z >= most - 1e-9;
	const double share = flows ? 1 : probe_clamp((z + PROBE_LEAST - plastic) / elastic, 0, 1); /* without a step, and no less than the GPU's */
	if (share <= 0)
		return false;
	normal_at(form, p->rise, up, &face, place->normal);
	probe_bends_at(form, p->own, there, &face, place->bends);
	put_across(place->normal, place->across);
	place->arm[0] = there[0];
	place->arm[1] = there[1];
	place->arm[2] = face.height + (p->over ? p->rests - p->face.height : 0);
	place->ground = 0.5 * part;
	place->area = form->ground_normals || probe_bears_by_end(form, p->own, there) ? 0.5 * part : 0.5 * part / place->normal[2];
	place->stress = yields * share;
	/* Where the body was deeper before, the deepest pose sinks by less than the last one. */
	const double unloads = flows ? 0 : largest > remembered ? since : 1;
	place->sinks = up * ((1 - unloads) * yield_growth(s, yields, most) + unloads * yields / elastic);
	deform_place_rates(p, probe_least(4 * share, 1) * probe_least(4 * most * s->by_shear, 1), place);
	const double later = ((there[0] - p->at[0]) * form->by_way[0] + (there[1] - p->at[1]) * form->by_way[1]) * p->lasts;
	const double touching = p->slides * probe_most(p->share - later, 0), stays = stays_after(touching);
	const struct slip slip = slip_at(form, place->arm, place->across);
	for (int k = 0; k < 2; k++)
		place->mobilised[k] = slip.direction[k] + stays * (p->shear[k] - slip.direction[k]);
	place->strength = strength_of(p->law, s, place->stress, &place->holds);
	deform_place_shears(p, &slip, touching, stays, form->rim > 0 ? form->rim * form->level / place->normal[2] : 1, place);
	return true;
}

static bool may_touch(const struct post *p, const double middle[2])
{
	const struct probe_form *form = p->form;
	const double *rise = p->rise, there[2] = {p->at[0] + middle[0], p->at[1] + middle[1]};
	const double steep = form->kind == DEFORM_WHEEL ? fabs(rise[0]) : sqrt(rise[0] * rise[0] + rise[1] * rise[1]);
	/* The lower edge of a cylinder that leans lies up to a post beside the line. */
	const double reach = form->half_across + (form->kind == DEFORM_CYLINDER ? form->step_aside : 0);
	const double above = rise[0] * middle[0] + rise[1] * middle[1] + steep * reach - probe_lowest_near(form, p->own, there, reach);
	return p->depth + probe_most(above + p->face.height, 0) > 0;
}

/* Gives the ends of what bears on the line. An end bears from the surface on, or where it sank deeper before, from the plastic part of that on. */
static void put_ends(const struct post *p, const double depths[3], const double mosts[3], double ends[2])
{
	double above[3];
	bool known = false;
	for (int end = 0; end < 2; end++) {
		const double sign = end == 0 ? -1 : 1;
		const bool unloads = mosts[2 * end] > probe_most(depths[2 * end], 0) + PROBE_LEAST;
		for (int k = 0; k < 3 && unloads && !known; k++)
			above[k] = depths[k] - plastic_of(p->law, p->soil, mosts[k] * p->ground->up) * p->ground->by_up;
		known = known || unloads;
		ends[end] = root_from(sign, unloads ? above : depths);
	}
	ends[1] = probe_most(ends[0], ends[1]);
}

void deform_law_bearing(const struct probe_law *law, size_t number, const double at[2], struct probe_bearing *bearing)
{
	const struct probe_form *form = law->form;
	struct post p;
	double middle[2];
	bearing->count = 0;
	bearing->has_brim = false;
	bearing->sinkage = 0;
	if (law->patch->posts[number].hole)
		return;
	begin(law, number, at, &p);
	bearing->share = deform_form_part(form, at, p.over, middle, bearing->sides);
	if (bearing->share <= 0 || !may_touch(&p, middle))
		return;
	remember(&p);
	if (!p.over && fabs(at[0]) > form->radius && p.depth > 0)
		return; /* a wheel that sank to its axle does not bear on the soil in front of its rim */
	const double grows[2] = {p.rise[0] - p.face.slope[0], p.rise[1] - p.face.slope[1]}, squares = grows[0] * grows[0] + grows[1] * grows[1];
	double end[2] = {form->half_across, 0};
	if (form->kind != DEFORM_WHEEL && !probe_strips(form) && squares >= 1e-8)
		for (int k = 0; k < 2; k++)
			end[k] = grows[k] / sqrt(squares) * form->half_across;
	const double centre[2] = {at[0] + middle[0], at[1] + middle[1]}, rise = p.rise[0] * end[0] + p.rise[1] * end[1];
	const double risen = p.rise[0] * middle[0] + p.rise[1] * middle[1], height = p.depth + p.face.height;
	double depths[3], mosts[3], ends[2], since;
	for (int k = 0; k < 3; k++) {
		const double there[2] = {centre[0] + (k - 1) * end[0], centre[1] + (k - 1) * end[1]};
		const double lower = probe_height_at(form, p.own, there);
		depths[k] = height + risen + (k - 1) * rise - lower;
		mosts[k] = probe_most(remembered_at(&p, there, depths[k], risen + (k - 1) * rise), depths[k] + lowered_at(&p, there, &since) + p.excess);
	}
	put_ends(&p, depths, mosts, ends);
	const double part = 0.5 * bearing->share * (ends[1] - ends[0]);
	for (int k = 0; k < 2 && part > 0; k++) {
		const double on = 0.5 * (ends[0] + ends[1]) + (k - 0.5) * 0.57735026918962573 * (ends[1] - ends[0]);
		const double there[2] = {centre[0] + on * end[0], centre[1] + on * end[1]};
		bearing->count += put_place(&p, there, risen + on * rise, part, &bearing->places[bearing->count]);
	}
	if (probe_strips(form) && bearing->sides[form->lean < 0 ? 3 : 2])
		bearing->has_brim = deform_place_brim(&p, centre, height + risen, &bearing->brim);
	if ((bearing->count > 0 || bearing->has_brim) && p.over)
		bearing->sinkage = p.ground->height - law->above_zero - p.ground->deposited - p.rests;
}

bool deform_law_touches(const struct probe_law *law, size_t number, const double at[2], double *height)
{
	const struct probe_post *ground = &law->patch->posts[number];
	double rests;
	if (ground->hole || !deform_form_rests(law->form, number, at, &rests))
		return false;
	*height = rests + law->above_zero;
	return *height < ground->height;
}
