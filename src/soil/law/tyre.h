/*
 * Part of bear.c: a tyre's carcass in series with the soil of a post (SOIL.md, "Tyres"). The carcass is a bed of springs around the rim. It keeps its
 * shape up to a pressure, and beyond it each place gives way by u:
 *
 *     p = holds + stiff u
 *
 * The rim without a load is d below the ground, so the soil is z = d - u deep. Where soil bears less than `holds`, z is d. Depths are along the normal
 * of the base, m. A post remembers the soil's largest sinkage w. To it belongs a depth d of this rim, at which the soil is that deep.
 */
#ifndef FURROW_SOIL_TYRE_H
#define FURROW_SOIL_TYRE_H

#include "soil/law/form.h"

#define TYRE_TRIES 6 /* steps of Newton's method for a post, which has no guess */
#define TYRE_BLEND 2e-4f /* m: tyre_share */
#define TYRE_MORE 2  /* the same for a place of its cell, whose guess is what the post has */

/* Returns the depth of this rim at which the soil yields at sinkage w. */
SOIL_INLINED float tyre_depth(const struct soil_form *f, float w, float yields)
{
	return w + most(yields - f->tyre_holds, 0) / f->tyre_stiff;
}

/* Returns a sinkage that the soil has at least where the carcass gives way: there it bears `holds`. */
SOIL_INLINED float tyre_least(const struct soil_form *f, const struct stress_soil *s)
{
	const float yields = power_of(f->tyre_holds / most(s->k, 1e-3f), 1 / s->n), own = most(yields, f->tyre_holds * s->by_elastic);
	return SOIL_LAYERED ? 0 : either(s->loose > 0, least(own, s->loose), own);
}

/* Returns the soil's sinkage where it yields below a rim at depth d: the root of yield stress - holds - stiff (d - w). Newton's method between bounds. `first`: tyre_least. */
SOIL_INLINED float tyre_sinkage(const struct soil_form *f, const struct stress_soil *s, float d, float first, float guess, int tries, bool floored)
{
	const float all = f->tyre_holds + f->tyre_stiff * d;
	float low = least(first, d), high = d, w = clamped(guess, low, high);
	for (int i = 0; i < tries; i++) {
		const float yields = yield_stress_on(s, w, floored), grows = yield_growth_on(s, yields, w, floored), over = yields + f->tyre_stiff * w - all;
		low = either(over < 0, w, low);
		high = either(over > 0, w, high);
		w = clamped(w - over / (grows + f->tyre_stiff), low, high);
	}
	return w;
}

/* Returns the soil's sinkage where it springs back below a rim at depth d. by_elastic: 1/m, how its share of the yield stress grows. */
SOIL_INLINED float tyre_springs(const struct soil_form *f, float yields, float plastic, float by_elastic, float d)
{
	const float elastic = yields * by_elastic, from = plastic - SOIL_LEAST;
	return either(elastic * (d - from) > f->tyre_holds, (f->tyre_holds + f->tyre_stiff * d + elastic * from) / (elastic + f->tyre_stiff), d);
}

/* Returns dz / dd, how much of the rim's slope the soil's surface has. beyond: m, by which the rim was deeper than now. From 0 to TYRE_BLEND it goes from that of yielding soil to that of soil
 * that springs back. So rounding of what posts remember does not show in a wheel at rest. It shifts a rolling wheel's work between force and torque, and does not change it. */
SOIL_INLINED float tyre_share(const struct soil_form *f, float grows, float elastic, float beyond)
{
	const float yields = f->tyre_stiff / (f->tyre_stiff + grows), springs = f->tyre_stiff / (f->tyre_stiff + elastic);
	return springs + (yields - springs) * clamped(1 - beyond * (1 / TYRE_BLEND), 0, 1);
}

/* Leans a surface's normal towards the ground's, which rises by rise_x and rise_y. A share of the rim's slope is left, since the carcass gives way. */
SOIL_INLINED void tyre_lean(float share, float rise_x, float rise_y, float normal[3])
{
	const float by = 1 / most(normal[2], 1e-3f), x = -rise_x + share * (normal[0] * by + rise_x), y = -rise_y + share * (normal[1] * by + rise_y);
	const float up = 1 / sqrtf(1 + x * x + y * y);
	const bool leans = share < 1;
	normal[0] = either(leans, x * up, normal[0]);
	normal[1] = either(leans, y * up, normal[1]);
	normal[2] = either(leans, up, normal[2]);
}

#endif
