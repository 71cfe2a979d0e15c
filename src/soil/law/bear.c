/*
 * Evaluates the law over the posts of a body, a block of lanes at a time. For each post:
 *
 *  1. how deep the body is, and for which share of its motion it has been there;
 *  2. how its surface slid over the post, and what slip digs;
 *  3. what the post remembers of its largest sinkage, and which part of a line across its cell bears;
 *  4. at two places of that part (Gauss): pressure, damping, shear; their sum. Beside it what the lower end of a rim that leans bears.
 *
 * Each step is a loop over the lanes without a branch. The loops are compiled for each form of body, with and without what a probe asks.
 */
#include "soil/law/bear_walls.h"

/* --- sums --- */

/* Adds what one place of each lane bears. */
SOIL_INLINED void add_places(const struct soil_form *f, enum soil_form_kind kind, bool soft, bool asked, float unit, const struct lane_posts *p,
			     const struct spots *spots, float stresses[7][LANES], struct counts *counts, struct lane_places *all)
{
	EACH_LANE {
		struct face face;
		struct place place;
		float shear[3], stress[3], moment[3], belt[3];
		put_place(f, kind, soft, asked, p, i, spots, i, &face, &place);
		stress_at(&place, shear, stress);
		cross3(place.arm, stress, moment);
		cross3(place.normal, f->belt, belt);
		for (int k = 0; k < 3; k++) {
			stresses[k][i] += place.area * stress[k];
			stresses[3 + k][i] += place.area * moment[k];
		}
		stresses[6][i] -= place.area * dot3(stress, belt);
		counts->grows[i] += place.area * place.sinks * (place.normal[2] - place.holds * shear[2]) * unit;
		counts->area[i] += (int32_t)(place.ground * BEAR_AREA_UNITS + 0.5f);
		if (asked) {
			float bends[3];
			put_bends(f, kind, p->own[i], spots->x[i], spots->y[i], &face, bends);
			for (int k = 0; k < 3 && soft; k++)
				bends[k] *= place.leans;
			add_place(&place, bends, i, all);
		}
	}
}

/* Adds what the lower end of a rim bears beside each cell. Its place moves with the body, and it bears more where its edge sinks below the ground. */
SOIL_INLINED void add_brims(const struct soil_form *f, enum soil_form_kind kind, bool asked, float unit, const struct lane_posts *p, const struct block *l, float stresses[7][LANES],
			    struct counts *counts, struct lane_changes *changes)
{
	const float post = f->spacing * f->spacing;
	struct lane_brims brims;
	if (kind == FORM_RIM && !any_above(f->lean < 0 ? p->side_left : p->side_right, 0))
		return;
	EACH_LANE {
		struct place place;
		float shear[3], stress[3], moment[3];
		if (kind == FORM_RIM)
			put_brim(f, asked, p, l, i, &place);
		else
			put_wall(f, asked, p, l, i, &place);
		stress_at(&place, shear, stress);
		cross3(place.arm, stress, moment);
		for (int k = 0; k < 3; k++) {
			stresses[k][i] += place.area * stress[k];
			stresses[3 + k][i] += place.area * moment[k];
		}
		counts->grows[i] += place.area * place.sinks * place.normal[2] * unit;
		counts->area[i] += (int32_t)(place.ground * BEAR_AREA_UNITS + 0.5f);
		if (asked) {
			put_brim_lane(p, i, &place, place.area * post, &brims);
			add_figures(p, i, &place, place.area * post, shear, changes);
		}
	}
	if (asked)
		add_brim_changes(&brims, changes);
}

/* Sums of each lane, in units of struct soil_sums. */
struct lane_sums {
	int64_t force[3][LANES], moment[3][LANES], pull[LANES], area[LANES], saturated[LANES];
	int32_t deepest[LANES];
};

SOIL_INLINED void add_counts(const int32_t counts[LANES], int64_t sums[LANES])
{
	SOIL_WHOLE
	EACH_LANE sums[i] += counts[i];
}

/* Rounds what the lanes bear to whole numbers, and adds them. */
SOIL_INLINED void count(const struct soil_form *f, bool soft, const struct lane_posts *p, float unit, const struct block *l, const float stresses[7][LANES],
			struct counts *c, struct lane_sums *sums)
{
	EACH_LANE {
		float large = 0;
		for (int k = 0; k < 3; k++) {
			const float force = stresses[k][i] * unit, moment = stresses[3 + k][i] * unit * f->by_arm;
			large = most(large, most(fabsf(force), fabsf(moment)));
			c->force[k][i] = whole_of(clamped(force, -BEAR_MOST, BEAR_MOST));
			c->moment[k][i] = whole_of(clamped(moment, -BEAR_MOST, BEAR_MOST));
		}
		c->pull[i] = whole_of(clamped(stresses[6][i] * unit, -BEAR_MOST, BEAR_MOST));
		c->saturated[i] = large > BEAR_MOST ? 1 : 0;
		const bool bears = (c->area[i] > 0) & (p->over[i] > 0);
		const float deep = l->depth[i] + l->more[i] - (soft ? l->flat[i] : 0); /* below the base: */
		const int32_t deepest = bears ? whole_of(least(deep, 2000) * 1048576.0f) - p->deposited[i] : 0;
		sums->deepest[i] = deepest > sums->deepest[i] ? deepest : sums->deepest[i];
	}
	for (int k = 0; k < 3; k++) {
		add_counts(c->force[k], sums->force[k]);
		add_counts(c->moment[k], sums->moment[k]);
	}
	add_counts(c->pull, sums->pull);
	add_counts(c->area, sums->area);
	add_counts(c->saturated, sums->saturated);
}

static int64_t total(const int64_t lanes[LANES])
{
	int64_t sum = 0;
	for (int i = 0; i < LANES; i++)
		sum += lanes[i];
	return sum;
}

static void total_sums(const struct lane_sums *lanes, struct soil_sums *sums)
{
	for (int k = 0; k < 3; k++) {
		sums->force[k] = total(lanes->force[k]);
		sums->moment[k] = total(lanes->moment[k]);
	}
	sums->pull = total(lanes->pull);
	sums->area = total(lanes->area);
	sums->saturated = total(lanes->saturated);
	for (int i = 0; i < LANES; i++)
		sums->deepest = lanes->deepest[i] > sums->deepest ? lanes->deepest[i] : sums->deepest;
}

/* --- a block --- */

SOIL_INLINED void keep(bool soft, const struct lane_posts *p, size_t b, const struct block *l, struct soil_kept *kept)
{
	EACH_LANE {
		const float stays = exp_minus(l->slides[i] * clamped(lasted(p, i, l->passed[i]), 0, 1));
		kept->more[b + i] = l->more[i];
		if (soft) {
			kept->flat[b + i] = l->flat[i];
			kept->flattest[b + i] = l->flattest[i];
		}
		kept->shear_x[b + i] = sheared(p->shear_x[i], l->direction[0][i], stays);
		kept->shear_y[b + i] = sheared(p->shear_y[i], l->direction[1][i], stays);
	}
}

/* What an evaluation asks and finds. */
struct asked {
	int32_t raised;
	float share;
	struct lane_sums *sums;
	double *grows; /* struct soil_sums; a search alone asks for it */
	struct soil_kept *kept;
	struct lane_changes *changes; /* NULL: not asked */
};

SOIL_INLINED void bear(const struct soil_form *f, enum soil_form_kind kind, bool soft, bool asked, const struct soil_posts *posts, const struct asked *a)
{
	const float unit = BEAR_UNITS_A_PASCAL / a->share, raised = (float)a->raised * SOIL_UNIT + f->beyond;
	const bool sparse = a->kept == NULL && are_sparse(posts, raised);
	struct waiting waiting = {.next = 0};
	struct lane_posts lanes;
	for (size_t b = 0; sparse ? take_waiting(posts, raised, &waiting, &lanes) : b < posts->count; b += LANES) {
		if (a->kept == NULL && !sparse && !any_above(posts->room + b, raised))
			continue;
		const struct lane_posts *p = &lanes;
		struct block l;
		struct spots spots;
		struct counts counts;
		struct lane_places all;
		float stresses[7][LANES] = {{0}};
		if (!sparse)
			take_lanes(posts, b, &lanes);
		memset(counts.area, 0, sizeof counts.area);
		memset(counts.grows, 0, sizeof counts.grows);
		l.floored = posts->floored && are_floored(p);
		put_depths(f, kind, &lanes, a->raised, &l);
#if SOIL_LAYERED
		put_layers(&lanes, &l);
#endif
		if (soft) {
			if (l.floored)
				put_flat(f, p, true, &l);
			else
				put_flat(f, p, false, &l);
		}
		put_slides(f, kind, soft, p, &l);
		put_shares(f, soft, &lanes, &l);
		if (f->digs_most > 0)
			dig(f, kind, soft, &lanes, &l);
		if (a->kept != NULL)
			keep(soft, p, b, &l, a->kept);
		if (!any_above(l.share, 0))
			continue;
		if (soft && any_above(l.was, 0)) {
			if (l.floored)
				put_rims(f, p, true, &l);
			else
				put_rims(f, p, false, &l);
		}
		put_memory(f, kind, p, &l);
		if (!knows_places(kind))
			put_beneath(f, kind, p, &l);
		put_line(f, kind, soft, p, &l);
		put_keeps(f, p, &l);
		if (asked)
			memset(&all, 0, sizeof all);
		for (int k = 0; k < 2; k++) {
			put_spots(f, kind, soft, p, &l, k == 0 ? -0.28867513f : 0.28867513f, &spots);
			add_places(f, kind, soft, asked, unit, p, &spots, stresses, &counts, &all);
		}
		if ((kind == FORM_RIM && f->lean != 0) || (kind == FORM_RASTER && f->fine.brims != NULL))
			add_brims(f, kind, asked, unit, p, &l, stresses, &counts, a->changes);
		if (kind == FORM_BOX && f->tilts > 0)
			add_walls(f, asked, unit, p, &l, stresses, &counts, a->changes);
		if (asked)
			add_changes(f, kind, p, &l, &all, a->changes);
		count(f, soft, p, unit, &l, (const float(*)[LANES])stresses, &counts, a->sums);
		for (int i = 0; i < LANES && a->kept == NULL && !asked; i++)
			*a->grows += (double)counts.grows[i];
	}
}

#define BEAR_OF(kind, name, soft) \
	SOIL_CLONED static void bear_##name(const struct soil_form *restrict f, const struct soil_posts *restrict p, const struct asked *restrict a) \
	{ \
		if (a->changes != NULL) \
			bear(f, kind, soft, true, p, a); \
		else \
			bear(f, kind, soft, false, p, a); \
	}
BEAR_OF(FORM_RIM, rim, false)
BEAR_OF(FORM_RIM, tyre, true)
BEAR_OF(FORM_BALL, ball, false)
BEAR_OF(FORM_CAPSULE, capsule, false)
BEAR_OF(FORM_BOX, box, false)
BEAR_OF(FORM_END, end, false)
BEAR_OF(FORM_RASTER, raster, false)

static double total_real(const float lanes[LANES])
{
	float fours[4];
	for (int i = 0; i < 4; i++)
		fours[i] = (lanes[i] + lanes[i + 8]) + (lanes[i + 4] + lanes[i + 12]);
	return ((double)fours[0] + (double)fours[2]) + ((double)fours[1] + (double)fours[3]);
}

static void total_matrix(float (*lanes)[6][LANES], struct soil_matrix *matrix)
{
	for (int i = 0; i < 6; i++)
		for (int k = 0; k < 6; k++)
			matrix->at[i][k] = total_real(lanes[i][k]);
}

void soil_bear(const struct soil_form *form, const struct soil_posts *posts, int32_t raised, float share, struct soil_sums *sums, struct soil_kept *kept,
	       struct soil_changes *changes)
{
	static void (*const forms[])(const struct soil_form *restrict, const struct soil_posts *restrict, const struct asked *restrict) = {
		[FORM_RIM] = bear_rim, [FORM_BALL] = bear_ball, [FORM_CAPSULE] = bear_capsule, [FORM_BOX] = bear_box, [FORM_END] = bear_end, [FORM_RASTER] = bear_raster,
	};
	struct lane_changes lanes;
	struct lane_sums counted;
	if (changes != NULL)
		memset(&lanes, 0, sizeof lanes);
	memset(&counted, 0, sizeof counted);
	*sums = (struct soil_sums){.deepest = 0};
	const struct asked asked = {raised, share, &counted, &sums->grows, kept, changes != NULL ? &lanes : NULL};
	if (form->tyre_stiff > 0)
		bear_tyre(form, posts, &asked);
	else
		forms[form->kind](form, posts, &asked);
	total_sums(&counted, sums);
	if (changes == NULL)
		return;
	for (int k = 0; k < 3; k++) {
		changes->normal[k] = total_real(lanes.normal[k]);
		changes->sheared[k] = total_real(lanes.sheared[k]);
	}
	changes->normal_force = total_real(lanes.normal_force);
	changes->shear_limit = total_real(lanes.shear_limit);
	total_matrix(lanes.stiffness, &changes->stiffness);
	total_matrix(lanes.damping, &changes->damping);
}
