/* Part of bear.c: how deep and how long the body is over each post of a block, and how its surface slides there. Also what the post remembers, and which
 * part of its cell bears. */
#ifndef FURROW_SOIL_BEAR_BLOCK_H
#define FURROW_SOIL_BEAR_BLOCK_H

#include "soil/law/bear_lanes.h"
#include "soil/faces/slid.h"
#include "soil/law/face.h"
#include "soil/law/tyre.h"

/* What one evaluation knows of a block of posts. Heights and depths are in metres. */
struct block {
	bool floored;                   /* some post has a loose layer on a floor */
	float ground[LANES];            /* above the centre, less what slip digs */
	float depth[LANES];             /* of the end pose below the ground, vertically */
	float was[LANES], plastic[LANES]; /* along the normal: the largest sinkage before, less what slip digs; its plastic part */
	float passed[LANES], slides[LANES], direction[2][LANES]; /* share of the motion; way in units of the modulus; where it slid to */
	float more[LANES];              /* what slip digs */
	float springs[LANES];           /* 1: the soil holds shear, and springs back or is loaded anew */
	float yields[LANES];            /* Pa: at the sinkage `was`, until slip digs */
	float stamped[LANES], printed[LANES], lasts[LANES], back[LANES];
	float unknown[LANES];           /* by how much the way before the motion would have lowered the post more than it remembers */
	float bottom[LANES];            /* of a rim: rim_bottom */
	float beneath[LANES];           /* how much lower than now the body passed the post, or passes it before it leaves the cell */
	float centre[2][LANES], end[2][LANES], first[LANES], last[LANES], share[LANES];
	float keeps[LANES];             /* share of the law of the lower envelope; the rest is that of faces */
	/* Of a tyre. least_of: tyre_least. flat, flattest: struct soil_kept. leans: tyre_share at the end pose. gives: how much deeper yielding soil gets for
	 * each metre of the rim. rim, soil: along the normal, a depth of the rim and the soil's sinkage below it. From put_rims on `was` is a depth of the rim. */
	float least_of[LANES], leans[LANES], flat[LANES], flattest[LANES], gives[LANES], rim[LANES], soil[LANES];
};

SOIL_INLINED struct stress_soil soil_of(const struct lane_posts *p, int i)
{
	struct stress_soil s = {
		.k = p->k[i], .n = p->n[i], .elastic = p->elastic[i], .by_elastic = p->by_elastic[i], .cohesion = p->cohesion[i], .tan_phi = p->tan_phi[i],
		.modulus = p->modulus[i], .by_modulus = p->by_modulus[i], .damping = p->damping[i], .whole = p->whole[i], .loose = p->loose_thick[i], .under = p->under[i],
	};
#if SOIL_LAYERED
	s.thick = p->thick[i];
	s.bulb = p->bulb[i];
	s.base_k = p->base_k[i];
	s.base_n = p->base_n[i];
	s.base_elastic = p->base_elastic[i];
#endif
	return s;
}

SOIL_INLINED bool any_above(const float numbers[LANES], float than)
{
	uint32_t any = 0;
	SOIL_WHOLE
	EACH_LANE any |= numbers[i] > than ? 1 : 0;
	return any != 0;
}

/* --- how a surface slides --- */

SOIL_INLINED void normal_of(const struct soil_form *f, const struct lane_posts *p, int i, const struct face *face, float normal[3])
{
	const float ground = f->ground_normals, body = 1 - f->ground_normals; /* products, so that no lane skips reading a raster */
	normal[0] = body * face->normal[0] - ground * p->rise_x[i] * p->up[i];
	normal[1] = body * face->normal[1] - ground * p->rise_y[i] * p->up[i];
	normal[2] = body * face->normal[2] + ground * p->up[i];
}

/* Gives how the surface moves over the body at a place, by the body's turning and by its belt, along `across`. */
SOIL_INLINED void running_at(const struct soil_form *f, const float spin[3], float ran, const float arm[3], const float normal[3], float across[2][3],
			     float along[2])
{
	float moved[3], belt[3];
	cross3(spin, arm, moved);
	cross3(normal, f->belt, belt);
	for (int k = 0; k < 3; k++)
		moved[k] += ran * belt[k];
	along[0] = dot3(moved, across[0]);
	along[1] = dot3(moved, across[1]);
}

/* How long a body's rolling surface is above a place, of the time for which the soil lies below the body. A rim passes over the soil faster than the
 * axle if it slips, and its surface is longer than its way. A belt at rest has the longest time. 1: the surface does not roll. */
SOIL_INLINED float time_of(const struct soil_form *f, const float running[2], float passes, float up)
{
	const float squares = running[0] * running[0] + running[1] * running[1], ran = sqrtf(squares), way = f->passes[0];
	const float along = running[0] * f->way[0] + running[1] * f->way[1], both = squares * way * way;
	const float aligned = either(both > 0, along * along / most(both, 1e-30f), f->ahead) * f->rolls;
	const float share = either(ran > 0.1f * passes, most(passes / most(ran, 1e-30f), 0.1f), 10), runs = clamped(10 * ran / most(passes, 1e-30f), 0, 1);
	return 1 + most(runs, f->locked) * ((1 + (share - 1) * aligned) * up - 1);
}

struct slip {
	float direction[2], size, time; /* along the surface; m; time_of, or 1 with normals of the ground */
};

SOIL_INLINED struct slip slip_at(const struct soil_form *f, enum soil_form_kind kind, const float arm[3], const float normal[3], float across[2][3])
{
	float running[2], turning[3];
	running_at(f, f->rolling, f->ran, arm, normal, across, running);
	cross3(f->turning, arm, turning);
	const float x = dot3(f->way, across[0]) + dot3(turning, across[0]) + running[0], y = dot3(f->way, across[1]) + dot3(turning, across[1]) + running[1];
	const float squares = x * x + y * y, by = 1 / sqrtf(most(squares, 1e-20f)), up = f->rim_level * f->belt_level / normal[2];
	const float time = kind == FORM_RIM ? f->rim_time[0] + f->rim_time[1] * up : time_of(f, running, f->passes[0], up);
	return (struct slip){{x * by, y * by}, squares * by, either(f->ground_normals > 0, 1, time)};
}

/* The same where faces push, too. What the body pushes is not dug, in the share in which faces push. A rim digs by its own slip, not by that of its bars:
 * these scoop. goes, runs: m, in plan. */
SOIL_INLINED float digs_beside_faces(const struct soil_form *f, enum soil_form_kind kind, float x, float y, const float goes[2], const float runs[2])
{
	const struct slide s = slide_of(goes, runs);
	const float keeps = f->slides > 0 ? 1 - faces_share(slid_at(f, x, y)) : 1, along = kind == FORM_RIM ? s.braked[0] : sqrtf(s.braked[0] * s.braked[0] + s.braked[1] * s.braked[1]);
	const float aside = kind == FORM_RIM ? keeps * s.braked[1] : 0, ahead = most(s.spins - f->bars_beyond * s.runs, 0) + keeps * keeps * fabsf(along);
	return sqrtf(ahead * ahead + aside * aside);
}

/* How far the surface slips over the ground, m, as if the place were at the body's lowest level. So a rim that rolls slips nowhere. It counts for
 * the time in which a rolling surface passes. */
SOIL_INLINED float dig_way(const struct soil_form *f, enum soil_form_kind kind, float x, float y)
{
	const float *rolls = f->rolling, *turns = f->turning, reach = f->rim_reach;
	const float running[2] = {-rolls[1] * reach - rolls[2] * y - f->ran * f->belt[1], rolls[2] * x + rolls[0] * reach + f->ran * f->belt[0]};
	const float u = f->way[0] * f->along_ground - turns[1] * reach - turns[2] * y + running[0], v = f->way[1] * f->along_ground + turns[2] * x + turns[0] * reach + running[1];
	const float way = f->all_round > 0 ? digs_beside_faces(f, kind, x, y, (const float[2]){u - running[0], v - running[1]}, running) : sqrtf(u * u + v * v);
	const float time = kind == FORM_RIM ? f->rim_digs : time_of(f, running, f->passes[1], 1);
	return either(way >= (float)SOIL_SLIP_LEAST, way, 0) * either(f->ground_normals > 0, 1, time);
}

/* --- 1 to 3 --- */

#define BENDS_LEAST 1e-6f /* m: what bends by less is straight, and bends by rounding */

/* Returns since which last share of the motion the body has been deeper than the soil was compacted. Below 0: it was not. */
SOIL_INLINED float passed_at(const struct soil_form *f, enum soil_form_kind kind, const struct lane_posts *p, int i, float gains)
{
	const float x = p->x[i], y = p->y[i];
	float share;
	if (is_round(kind)) {
		/* When the circle in which the body is cut along its motion first reached the place. It may have left again, and the cell still bear elsewhere. */
		const float squares = ring_squares(f, kind, y), ahead = ring_ahead(f, kind, x, y), moves = f->run * f->run + f->plunge * f->plunge;
		const float level = gains / f->lift - root(squares - ahead * ahead), nears = ahead * f->run + level * f->plunge;
		const float beyond = ahead * ahead + level * level - squares, rooted = nears * nears - moves * beyond;
		const float apart = either(nears > 0, -beyond, root(rooted) - nears), by = either(nears > 0, nears + root(rooted), moves);
		share = either(moves > 0, apart / most(by, 1e-30f), 1e3f);
	} else if (kind == FORM_RASTER) {
		/* A parabola through the heights above the post at the motion's start, halfway, and at its end. */
		const float whole = p->begun[i], half = p->halfway[i];
		const float speed = 4 * half - whole, bent = 2 * whole - 4 * half, bends = bent - clamped(bent, -BENDS_LEAST, BENDS_LEAST);
		const float rooted = speed * speed + 4 * bends * gains, rises = either(bends > 0, (root(rooted) - speed) / most(2 * bends, 1e-30f), 1e3f);
		share = either(rooted >= 0, 2 * gains / most(speed + root(rooted), 1e-30f), either(gains > 0, 1e3f, -4));
		share = either(speed <= 0, rises, share); /* it was lower before */
		share = least(share, either(p->over[i] > 0, p->entered[i], 1e3f));
	} else {
		const float speed = p->print[i] - p->height[i] - f->way[2];
		share = either(speed > 0, gains / most(speed, 1e-18f), 1e3f);
	}
	/* Then its sides pass. */
	const float ahead_by = 1 / most(fabsf(f->way[0]), 1e-9f), aside_by = 1 / most(fabsf(f->way[1]), 1e-9f), over = p->over[i];
	if (kind == FORM_BOX) {
		const float side = either(f->way[0] < 0, f->enters[0][0], f->enters[0][1]), beyond = most(side - x * either(f->way[0] < 0, -1, 1), 0) * ahead_by;
		share = least(share, either((over > 0) & (f->half[0] > 0) & (fabsf(f->way[0]) > 1e-9f), beyond, 1e3f));
	}
	if (kind == FORM_BOX || kind == FORM_RIM) {
		const float side = either(f->way[1] < 0, f->enters[1][0], f->enters[1][1]);
		const float beyond = most(side - aside_of(f, kind, x, y) * either(f->way[1] < 0, -1, 1), 0) * aside_by;
		share = least(share, either((over > 0) & (f->half[1] > 0) & (fabsf(f->way[1]) > 1e-9f), beyond, 1e3f));
	}
	return clamped(share, -4, 1e3f);
}

SOIL_INLINED float lasted(const struct lane_posts *p, int i, float passed)
{
	return either(p->over[i] > 0, least(passed, 1), passed);
}

/* The law of soil that may lie loose on a floor costs another power. So what needs it is compiled twice. Blocks without a loose layer take the plain one.
 * Tells whether some post has such a layer. */
SOIL_INLINED bool are_floored(const struct lane_posts *p)
{
	return any_above(p->loose_thick, 0);
}

SOIL_INLINED void put_yields(const struct lane_posts *p, bool floored, struct block *l)
{
	EACH_LANE {
		const struct stress_soil s = soil_of(p, i);
		l->yields[i] = yield_stress_on(&s, l->was[i], floored);
		l->plastic[i] = plastic_part(&s, l->was[i], l->yields[i]);
	}
}

/* Returns how much slip can dig of a post, m: rigid ground ends it. */
SOIL_INLINED float room_above(const struct lane_posts *p, int i)
{
#if SOIL_LAYERED
	const bool is = p->thick[i] < LAYER_NONE, loose = p->loose_thick[i] > 0;
	const float rigid = either(is, p->base_k[i], either(loose, p->whole[i], p->k[i])), left = either(is, p->thick[i] + either(loose, p->loose_thick[i] - p->under[i], 0), p->loose_thick[i]);
	return either(rigid > LAYER_RIGID, most(left * p->by_up[i] - LAYER_FILM, 0), 1e9f);
#else
	(void)p;
	(void)i;
	return 1e9f;
#endif
}

/* Takes what is dug off a loose layer, and what is more off its floor. A post whose loose layer is gone has its floor alone, whose undisturbed surface is
 * above the floor by its plastic sinkage. gone: m along the
 * normal. was: before. */
SOIL_INLINED void dig_loose(struct lane_posts *p, int i, float gone, float was, struct block *l)
{
	const float thick = p->loose_thick[i], floor = (float)p->floor[i] * SOIL_UNIT, under = p->under[i];
	const bool through = (thick > 0) & (gone >= thick);
	const float sank = most(either(was > thick, was - thick + under, 0), floor), rise = either(through, under * p->by_up[i], 0);
	l->was[i] = either(through, most(sank - (gone - thick), 0), l->was[i]);
	l->ground[i] += rise;
	l->depth[i] += rise;
	p->deposited[i] += whole_of(rise * 1048576.0f);
	p->k[i] = either(through, p->whole[i], p->k[i]);
	p->loose_thick[i] = either(through, 0, thick - either(thick > 0, gone, 0));
#if SOIL_LAYERED
	p->thick[i] = either((p->thick[i] < LAYER_NONE) & (through | (thick <= 0)), most(p->thick[i] - (gone - thick), 0), p->thick[i]);
#endif
}

/* Takes soil off a post, m. Compacted soil stays where it is, so it lies less deep below the lowered ground. */
SOIL_INLINED void take_off(struct lane_posts *p, int i, bool floored, float by, struct block *l)
{
	const float was = l->was[i], gone = p->up[i] * by;
	l->ground[i] -= by;
	l->depth[i] -= by;
	l->was[i] = most(was - gone, 0);
	if (floored)
		dig_loose(p, i, gone, was, l);
#if SOIL_LAYERED
	else
		p->thick[i] = either(p->thick[i] < LAYER_NONE, most(p->thick[i] - gone, 0), p->thick[i]);
#endif
}

/* What grousers scoop (faces/trend.c) does not bear, also ahead of where they have reached it. Below it the bars shear the soil, from where they touch the ground.
 * The ground loses it as the wheel sinks into it. */
SOIL_INLINED void scoop(const struct soil_form *f, struct lane_posts *p, bool floored, struct block *l)
{
	EACH_LANE {
		const float by = most(least(f->scooped - p->dug[i], room_above(p, i)), 0);
		l->more[i] = either((p->over[i] > 0) & (p->up[i] * l->depth[i] > most(l->plastic[i], 0)), most(least(by, l->depth[i] - 2 * SOIL_UNIT), 0), 0);
		take_off(p, i, floored, by, l);
	}
	put_yields(p, floored, l);
}

/* Lets depths count from where faces do. Soil that a body has pushed off counts as if it were there, and as deep as the body has been. */
SOIL_INLINED void count_ahead(struct lane_posts *p, bool floored, struct block *l)
{
	EACH_LANE {
		const int32_t units = whole_of(p->heap[i] * 1048576.0f);
		take_off(p, i, floored, p->heap[i], l);
		p->ground[i] -= units;
		p->deposited[i] -= units;
	}
}

SOIL_INLINED void put_depths(const struct soil_form *f, enum soil_form_kind kind, struct lane_posts *p, int32_t raised, struct block *l)
{
	EACH_LANE {
		l->ground[i] = (float)(p->ground[i] - raised) * SOIL_UNIT - f->beyond;
		l->depth[i] = l->ground[i] - p->height[i] - p->above[i];
		l->was[i] = p->was[i];
		l->more[i] = 0;
		l->share[i] = either(p->room[i] > (float)raised * SOIL_UNIT + f->beyond, p->share[i], 0);
		l->yields[i] = l->plastic[i] = 0;
	}
	if (f->slides > 0) {
		if (l->floored)
			count_ahead(p, true, l);
		else
			count_ahead(p, false, l);
	}
	if (any_above(l->was, 0)) {
		if (l->floored)
			put_yields(p, true, l);
		else
			put_yields(p, false, l);
	}
	EACH_LANE l->passed[i] = passed_at(f, kind, p, i, l->depth[i] - l->plastic[i] * p->by_up[i]);
	if (f->scooped > 0) {
		if (l->floored)
			scoop(f, p, true, l);
		else
			scoop(f, p, false, l);
	}
}

#if SOIL_LAYERED
/* As a layer is used up, its shear and its damping go over to those of the soil below it. Of two soils in line the weaker one gives way. */
SOIL_INLINED float weaker_of(float own, float base, float share)
{
	return either(share >= 1, own, own * base / most(share * base + (1 - share) * own, 1e-20f));
}

SOIL_INLINED void put_layers(struct lane_posts *p, const struct block *l)
{
	EACH_LANE {
		const struct stress_soil s = soil_of(p, i);
		const float share = either(s.thick < LAYER_NONE, layer_shears(&s, most(l->was[i], p->up[i] * l->depth[i])), 1);
		p->cohesion[i] = weaker_of(s.cohesion, p->base_cohesion[i], share);
		p->tan_phi[i] = weaker_of(s.tan_phi, p->base_tan_phi[i], share);
		p->modulus[i] = either(share >= 1, s.modulus, share * s.modulus + (1 - share) * p->base_modulus[i]);
		p->by_modulus[i] = either(share >= 1, s.by_modulus, 1 / p->modulus[i]);
		p->damping[i] = either(share >= 1, s.damping, share * s.damping + (1 - share) * p->base_damping[i]);
	}
}
#endif

/* Returns the strength of a post's soil at a sinkage along the normal, while it springs back or is loaded anew. stress: where it yields; Pa. */
SOIL_INLINED float strength_at(const struct soil_form *f, const struct stress_soil *s, float stress, float plastic, float by_elastic, float sinkage)
{
	float grows;
	return strength_of(&f->surface, s, stress * clamped((sinkage + SOIL_LEAST - plastic) * by_elastic, 0, 1), &grows);
}

/* Returns the mean share of the shear strength, by size, that is mobilised in the motion: Simpson's rule. */
SOIL_INLINED float mean_mobilised(float x, float y, const float direction[2], float halfway)
{
	const float dx = x - direction[0], dy = y - direction[1];
	const float mx = direction[0] + halfway * dx, my = direction[1] + halfway * dy, ex = direction[0] + halfway * halfway * dx, ey = direction[1] + halfway * halfway * dy;
	return (sqrtf(x * x + y * y) + 4 * sqrtf(mx * mx + my * my) + sqrtf(ex * ex + ey * ey)) * (1 / 6.0f);
}

/* --- a tyre --- */

/* Finds how far the carcass gives way at the posts, now and where the rim was deepest in its motion. */
SOIL_INLINED void put_flat(const struct soil_form *f, const struct lane_posts *p, bool floored, struct block *l)
{
	EACH_LANE {
		const struct stress_soil s = soil_of(p, i);
		const float up = p->up[i], d = most(up * l->depth[i], 0), deepest = most(up * (l->depth[i] + p->lowered[i]), d), was = l->was[i];
		const float first = tyre_least(f, &s), low = tyre_sinkage(f, &s, deepest, first, first, TYRE_TRIES, floored);
		const float largest = most(low, was), yields = yield_stress_on(&s, largest, floored), plastic = plastic_part(&s, largest, yields);
		float by_elastic;
		springs_at(&s, d, largest, yields, plastic, &by_elastic);
		const float grows = yield_growth_on(&s, yields, largest, floored), reached = either(low >= was, deepest, tyre_depth(f, was, yields));
		const float z = either(d >= reached, least(largest, d), tyre_springs(f, yields, plastic, by_elastic, d));
		l->least_of[i] = first;
		l->flat[i] = (d - z) * p->by_up[i];
		l->flattest[i] = (deepest - low) * p->by_up[i];
		l->leans[i] = either(d - z > 0, tyre_share(f, grows, yields * by_elastic, most(reached - d, 0)), 1);
		l->gives[i] = f->tyre_stiff / (f->tyre_stiff + grows);
		l->rim[i] = deepest;
		l->soil[i] = low;
	}
}

/* From here on the memory of a post is a depth of the rim, as the places around it have the rim's shape. */
SOIL_INLINED void put_rims(const struct soil_form *f, const struct lane_posts *p, bool floored, struct block *l)
{
	EACH_LANE {
		const struct stress_soil s = soil_of(p, i);
		const float was = l->was[i], rim = tyre_depth(f, was, yield_stress_on(&s, was, floored));
		const bool known = was > 0;
		l->soil[i] = either(known & (rim > l->rim[i]), was, l->soil[i]);
		l->rim[i] = either(known, most(rim, l->rim[i]), l->rim[i]);
		l->was[i] = either(known, rim, 0);
	}
}

/* Turns depths of the rim at places of the cells, along the normal, into the largest sinkage of the soil there. */
SOIL_INLINED void put_soil(const struct soil_form *f, const struct lane_posts *p, const struct block *l, bool floored, float depths[LANES])
{
	EACH_LANE {
		const struct stress_soil s = soil_of(p, i);
		const float d = depths[i], guess = l->soil[i] + (d - l->rim[i]) * l->gives[i];
		depths[i] = either(d > 0, tyre_sinkage(f, &s, d, l->least_of[i], guess, TYRE_MORE, floored), d);
	}
}

/* Slip digs soil from below the body, so the body must sink by that much more to be borne as before. For each way that it slips
 * dD = |e| (kappa K - D) / K, D what slip has dug, beyond what bars scooped. */
SOIL_INLINED void dig_in(const struct soil_form *f, enum soil_form_kind kind, bool soft, struct lane_posts *p, bool floored, struct block *l)
{
	EACH_LANE {
		const struct stress_soil s = soil_of(p, i);
		const float half = 0.5f * most(lasted(p, i, l->passed[i]), 0), x = p->x[i] + half * f->way[0], y = p->y[i] + half * f->way[1];
		const float lowest = p->height[i] + p->above[i] - p->lowered[i], up = p->up[i], was = l->was[i];
		const float deepest = most(up * (l->ground[i] - lowest - (soft ? l->flattest[i] : 0)), 0), sunk = up * l->depth[i], after = most(was, deepest);
		const float stays = least(plastic_on(&s, after, floored), after - SOIL_UNIT), touching = clamped(l->passed[i], 0, 1);
		const float halfway = exp_minus(0.5f * l->slides[i] * touching), direction[2] = {l->direction[0][i], l->direction[1][i]};
		const float mean = mean_mobilised(p->shear_x[i], p->shear_y[i], direction, halfway);
		const float limit = least(f->digs_most * s.modulus * p->by_up[i], 95) + f->scooped - (p->dug[i] + l->more[i]);
		const float digs = most(limit, 0) * (1 - exp_minus(dig_way(f, kind, x, y) * touching * s.by_modulus * mean));
		/* The body stays in the soil however much slips. Once it has reached the floor, it counts as deep as it is below the floor's undisturbed surface. */
		const float above = floored ? either((s.loose > 0) & (sunk > s.loose), s.under * p->by_up[i], 0) : 0;
		const float room = least(l->depth[i] - (soft ? l->flat[i] : 0) + above - 2 * SOIL_UNIT, room_above(p, i));
		const float by = either((p->over[i] > 0) & (sunk > most(stays, 0)), most(least(digs, room), 0), 0);
		l->more[i] += by;
		take_off(p, i, floored, by, l);
	}
	if (any_above(l->was, 0))
		EACH_LANE {
			const struct stress_soil s = soil_of(p, i);
			l->plastic[i] = plastic_on(&s, l->was[i], floored);
		}
}

SOIL_INLINED void dig(const struct soil_form *f, enum soil_form_kind kind, bool soft, struct lane_posts *p, struct block *l)
{
	if (l->floored)
		dig_in(f, kind, soft, p, true, l);
	else
		dig_in(f, kind, soft, p, false, l);
}

SOIL_INLINED void put_slides(const struct soil_form *f, enum soil_form_kind kind, bool soft, const struct lane_posts *p, struct block *l)
{
	EACH_LANE {
		const float half = 0.5f * most(lasted(p, i, l->passed[i]), 0), x = p->x[i] + half * f->way[0], y = p->y[i] + half * f->way[1];
		struct face then;
		float normal[3], across[2][3];
		face_at(f, kind, p->own[i], x, y, &then);
		normal_of(f, p, i, &then, normal);
		if (soft)
			tyre_lean(l->leans[i], p->rise_x[i], p->rise_y[i], normal);
		put_across(normal, across);
		const float arm[3] = {x, y, then.height + p->above[i] + (soft ? l->flat[i] : 0)};
		const struct slip slip = slip_at(f, kind, arm, normal, across);
		l->slides[i] = slip.size * slip.time * p->by_modulus[i];
		l->direction[0][i] = slip.direction[0];
		l->direction[1][i] = slip.direction[1];
	}
}

#define SHEAR_LENIENT 1.1f /* so much stronger may soil get in a motion, for nothing: a body that rocks on a slope would creep */

/* Soil that is loaded anew gets stronger while it holds shear. Shear can give back at most K S e^2 / 2, with e the mobilised share of the strength S. If e
 * stayed, a body that slid over the soil lightly, was loaded and slid back would gain energy. So this grows only by what sliding in the motion dissipates,
 * which is 2 w times as much, w the way in units of K. Where the soil yields, or gets weaker, Janosi's share stays. */
SOIL_INLINED void put_shares(const struct soil_form *f, bool soft, struct lane_posts *p, struct block *l)
{
	float loads[LANES], sunk[LANES];
	memset(l->springs, 0, sizeof l->springs);
	EACH_LANE sunk[i] = soft ? l->depth[i] - l->flat[i] : l->depth[i];
	EACH_LANE loads[i] = either((l->was[i] > 0) & (p->shear[i] != 0), sunk[i] - (float)(p->ground[i] - p->surface[i]) * SOIL_UNIT, 0);
	if (!any_above(loads, 2 * SOIL_UNIT))
		return;
	EACH_LANE {
		const struct stress_soil s = soil_of(p, i);
		const float was = l->was[i], plastic = l->plastic[i], by_elastic = 1 / most(was - plastic, 1e-9f), up = p->up[i], yields = l->yields[i];
		const float before = strength_at(f, &s, yields, plastic, by_elastic, up * (float)(p->ground[i] - p->surface[i]) * SOIL_UNIT);
		const float now = strength_at(f, &s, yields, plastic, by_elastic, up * sunk[i]), way = l->slides[i] * clamped(lasted(p, i, l->passed[i]), 0, 1);
		const float pays = exp_minus(way), share = sqrtf(either(loads[i] > 2 * SOIL_UNIT, least(SHEAR_LENIENT * before / most(now * pays * pays, 1e-9f), 1), 1));
		l->springs[i] = either((share < 1) & (up * sunk[i] < was), 1, 0);
		p->shear_x[i] *= share;
		p->shear_y[i] *= share;
	}
}

/* A way in plan of the motion: its direction, and how the body rose along it. */
struct course {
	float x, y, rise;
};

SOIL_INLINED struct course course_of(const struct soil_form *f)
{
	const float by = f->passes[0] > 0 ? 1 / most(f->passes[0], 1e-9f) : 0;
	return (struct course){f->way[0] * by, f->way[1] * by, clamped(f->way[2] * by, -1, 1)};
}

/* Of a form that is known at posts alone: how much lower than now it passed a post. A body that is not flat may pass its lowest place within the
 * cell, after the post. */
SOIL_INLINED void put_beneath(const struct soil_form *f, enum soil_form_kind kind, const struct lane_posts *p, struct block *l)
{
	const struct course course = course_of(f);
	EACH_LANE {
		struct face face = {.height = 0};
		float bends[3];
		face_at(f, kind, p->own[i], p->x[i], p->y[i], &face);
		put_bends(f, kind, p->own[i], p->x[i], p->y[i], &face, bends);
		const float leans = face.slope[0] * course.x + face.slope[1] * course.y - course.rise;
		const float curved = bends[0] * course.x * course.x + 2 * bends[1] * course.x * course.y + bends[2] * course.y * course.y;
		const bool within = (leans > 0) & (leans < curved * least(f->passes[0] + f->half_across, 2 * f->half_across));
		const float later = either(within, 0.5f * leans * leans / most(curved, 1e-9f), 0);
		l->beneath[i] = either(p->lowered[i] > 0, p->lowered[i], later);
	}
}

/* Returns how much lower than now the body was above a place of a cell. Of a form that is known at posts alone: its lowest height goes on along the
 * motion from the post, where it was lower before. */
SOIL_INLINED float lower_at(const struct soil_form *f, enum soil_form_kind kind, const struct lane_posts *p, int i, const struct block *l, float x, float y,
			    float *since)
{
	*since = 1;
	if (knows_places(kind))
		return lowered_at(f, kind, x, y, l->back[i], p->rise_x[i], l->bottom[i], l->unknown[i], since);
	const struct course course = course_of(f);
	struct face face = {.height = 0};
	face_at(f, kind, p->own[i], x, y, &face);
	const float dx = x - p->x[i], dy = y - p->y[i], along = dx * course.x + dy * course.y, aside = course.x * dy - course.y * dx;
	const float leans = face.slope[0] * course.x + face.slope[1] * course.y - course.rise, across = course.x * p->slope_y[i] - course.y * p->slope_x[i];
	/* In a short motion it was lower by no more than it rose since. */
	const float lowest = p->height[i] - l->beneath[i] + course.rise * along + across * aside, rose = most(l->beneath[i], -leans * f->passes[0]);
	const float lower = either(leans < 0, clamped(face.height - lowest, 0, rose), 0);
	return either(f->passes[0] > 0, lower, p->lowered[i]) * p->over[i];
}

SOIL_INLINED void put_keeps(const struct soil_form *f, const struct lane_posts *p, struct block *l)
{
	EACH_LANE l->keeps[i] = 1;
	if (f->slides > 0)
		EACH_LANE l->keeps[i] = 1 - (1 - f->sole) * faces_share(slid_at(f, p->x[i] + p->middle_x[i], p->y[i] + p->middle_y[i]));
}

/* The stored sinkage counts for the post's whole cell. Where the body bore at the motion's start, it has the shape of the lower envelope there
 * (printed). Else it is a flat rut, or the impression of a body that hardly moved (stamped). */
SOIL_INLINED void put_memory(const struct soil_form *f, enum soil_form_kind kind, const struct lane_posts *p, struct block *l)
{
	EACH_LANE {
		const float stays = l->plastic[i] * p->by_up[i], whole = l->was[i] * p->by_up[i] - stays;
		const float before = l->depth[i] + p->height[i] - p->print[i] + f->way[2];
		l->printed[i] = f->prints * clamped((before - stays + 4 * SOIL_LEAST) / most(whole, 1e-9f), 0, 1);
		l->stamped[i] = either(l->was[i] > 0, f->stamps, 0);
		l->bottom[i] = rim_bottom(f, p->rise_x[i]);
		l->back[i] = either(p->over[i] > 0, f->run + least(f->run, f->half_across), 1e3f);
		/* The body may have come another way: it turned back, or sank. At the post itself it was no lower than the post remembers. */
		float since;
		const float lower = lowered_at(f, kind, p->x[i], p->y[i], l->back[i], p->rise_x[i], l->bottom[i], 0, &since);
		l->unknown[i] = either((p->over[i] > 0) & (f->outer <= f->radius), most(lower - most(p->lowered[i], l->was[i] * p->by_up[i] - l->depth[i]), 0), 0);
		/* Of the places in a cell, those farther ahead came into contact later, so they slid less. But if the post stores less shear than the
		 * motion since the first touch gives, the body was on it at rest, or left it. Then the places differ less. */
		const float mobilised = sqrtf(p->shear_x[i] * p->shear_x[i] + p->shear_y[i] * p->shear_y[i]);
		const float way = either(mobilised > 0.9999f, 1e3f, -0.69314718f * log2_of(most(1 - mobilised, 1e-4f)));
		const float known = clamped(way / most(l->slides[i] * (l->passed[i] - 1), 1e-9f), 0, 1);
		l->lasts[i] = either((p->over[i] > 0) & ((l->passed[i] > 1) | ((l->depth[i] < stays) & (l->passed[i] > 0))), known, 1) * f->moved;
	}
}

/* Returns the largest sinkage that a place of the cell remembers, vertically. depth: of the body there; rise: of the ground from the post. */
SOIL_INLINED float remembered_at(const struct soil_form *f, enum soil_form_kind kind, const struct lane_posts *p, int i, const struct block *l, int lane,
				 float x, float y, float depth, float rise)
{
	const float own = kind == FORM_BOX ? 0 : p->own[i]; /* there it may have been another face */
	const float print = rise + p->print[i] - height_at(f, kind, own, x + f->way[0], y + f->way[1]);
	/* The rut of a rim that leans, or of such a drum, leans too. A mesh moves along the frame's x axis. */
	const float slope = kind == FORM_RIM ? f->lean * f->lift : p->slope_y[i], rut = kind == FORM_RIM ? 1 : kind == FORM_RASTER ? either(f->bulges > 0, 1, 0) : 0;
	const float leans = kind == FORM_RIM || kind == FORM_RASTER ? rut * (1 - l->stamped[lane]) * (p->rise_y[i] - slope) * (y - p->y[i]) : 0;
	const float hollow = l->stamped[lane] * (depth - l->depth[lane]) + leans;
	const float all = l->was[lane] * p->by_up[i] + l->printed[lane] * print + (1 - l->printed[lane]) * hollow;
	return all * either(l->was[lane] > 0, 1, 0);
}

/* Gives the plastic part of vertical sinkages, vertically, m. */
SOIL_INLINED void put_stays(const struct soil_form *f, bool soft, const struct lane_posts *p, const struct block *l, const float mosts[LANES], bool floored, float stays[LANES])
{
	float largest[LANES];
	EACH_LANE largest[i] = mosts[i] * p->up[i];
	if (soft)
		put_soil(f, p, l, floored, largest);
	EACH_LANE {
		const struct stress_soil s = soil_of(p, i);
		stays[i] = plastic_on(&s, largest[i], floored) * p->by_up[i];
	}
}

/* A line across the cell, in the direction in which the depth of the lower envelope changes most. The depth along it is taken as a parabola. An end of
 * what bears lies where the body leaves the surface; where it unloads, where it leaves the plastic part of the earlier sinkage. */
SOIL_INLINED void put_line(const struct soil_form *f, enum soil_form_kind kind, bool soft, const struct lane_posts *p, struct block *l)
{
	float depths[3][LANES], mosts[3][LANES], unloads[2][LANES], stays[3][LANES];
	const bool known = any_above(l->was, 0);
	EACH_LANE {
		const float x = p->rise_x[i] - p->slope_x[i], y = p->rise_y[i] - p->slope_y[i], squares = x * x + y * y;
		const float half = kind == FORM_BOX ? p->half_line[i] : f->half_across, by = half / sqrtf(most(squares, 1e-8f));
		const bool turns = kind != FORM_RIM && squares >= 1e-8f;
		l->end[0][i] = either(turns, x * by, f->half_across);
		l->end[1][i] = either(turns, y * by, 0);
		l->centre[0][i] = p->x[i] + p->middle_x[i];
		l->centre[1][i] = p->y[i] + p->middle_y[i];
	}
	for (int k = 0; k < 3; k++) {
		EACH_LANE {
			const float x = l->centre[0][i] + (float)(k - 1) * l->end[0][i], y = l->centre[1][i] + (float)(k - 1) * l->end[1][i];
			const float rise = p->rise_x[i] * (x - p->x[i]) + p->rise_y[i] * (y - p->y[i]);
			const float depth = l->depth[i] + p->height[i] + rise - height_at(f, kind, p->own[i], x, y);
			float since;
			const float lower = lower_at(f, kind, p, i, l, x, y, &since);
			depths[k][i] = depth;
			mosts[k][i] = depth + lower;
		}
		if (known)
			EACH_LANE {
				const float x = l->centre[0][i] + (float)(k - 1) * l->end[0][i], y = l->centre[1][i] + (float)(k - 1) * l->end[1][i];
				const float rise = p->rise_x[i] * (x - p->x[i]) + p->rise_y[i] * (y - p->y[i]);
				mosts[k][i] = most(mosts[k][i], remembered_at(f, kind, p, i, l, i, x, y, depths[k][i], rise));
			}
	}
	for (int k = 0; k < 2; k++)
		EACH_LANE {
			/* Below a mesh the hollow ends anywhere in a cell. So it counts in proportion to its depth, up to a fiftieth of the distance of two places. */
			const float over = mosts[2 * k][i] - (most(depths[2 * k][i], 0) + SOIL_LEAST);
			unloads[k][i] = kind == FORM_RASTER ? clamped(over * (50 * f->by_step), 0, 1) : either(over > 0, 1, 0);
		}
	const bool any = any_above(unloads[0], 0) || any_above(unloads[1], 0);
	for (int k = 0; k < 3; k++)
		if (any && l->floored)
			put_stays(f, soft, p, l, mosts[k], true, stays[k]);
		else if (any)
			put_stays(f, soft, p, l, mosts[k], false, stays[k]);
		else
			memset(stays[k], 0, sizeof stays[k]);
	EACH_LANE {
		float from[3], to[3];
		for (int k = 0; k < 3; k++) {
			from[k] = depths[k][i] - stays[k][i] * unloads[0][i];
			to[k] = depths[k][i] - stays[k][i] * unloads[1][i];
		}
		l->first[i] = root_from(-1, from);
		l->last[i] = most(l->first[i], root_from(1, to));
		/* A wheel that sank to its axle does not bear on the soil in front of its rim. */
		const bool ahead = (p->over[i] == 0) & (fabsf(p->x[i]) > f->radius) & (l->depth[i] > 0);
		l->share[i] = either((kind == FORM_RIM) & ahead, 0, l->share[i]);
	}
}

#endif
