/* The new state of posts that a body touched, in whole numbers. */
#include "soil/law/after.h"

#define AFTER_FAR ((1 << 30) - (1 << 20)) /* fixed-point units: ground so far from the body is clamped to this (posts.c) */
#define CARRIED_MOST (1 << 23)    /* fixed-point units: the most that one post gives away */
#define OFFSET_MOST (1 << 30)         /* fixed-point units: 1024 m */

SOIL_INLINED int32_t whole_units(float metres)
{
	return whole_of(clamped(metres * 1048576.0f, -2e9f, 2e9f));
}

/* Tells whether a body whose lower envelope has this sinkage is in contact. largest: the largest sinkage so far; plastic: its plastic part, m. */
SOIL_INLINED int32_t has_last(int32_t sunk, int32_t largest, float plastic)
{
	return (sunk > 0) & ((sunk >= largest) | ((float)sunk * SOIL_UNIT > plastic));
}

SOIL_INLINED int32_t sinkage_of(float up, int32_t depth)
{
	return whole_of(clamped(up * (float)depth, 0, 1.9e9f));
}

SOIL_INLINED int32_t larger(int32_t a, int32_t b)
{
	return a > b ? a : b;
}

SOIL_INLINED int32_t smaller(int32_t a, int32_t b)
{
	return a < b ? a : b;
}

/* Mobilised shear of the frame as a post stores it. */
SOIL_INLINED int32_t shear_of(const float axis[2], float x, float y)
{
	const int32_t east = whole_of(clamped((axis[0] * x - axis[1] * y) * 32768, -32767, 32767));
	const int32_t north = whole_of(clamped((axis[1] * x + axis[0] * y) * 32768, -32767, 32767));
	return (int32_t)(((uint32_t)east & 0xffffu) | (uint32_t)north << 16);
}

/* The soil of the posts: struct stress_soil. loose: of the loose layer that is left. */
struct soils {
	float k[POSTS_LANES], n[POSTS_LANES], elastic[POSTS_LANES], by_elastic[POSTS_LANES], whole[POSTS_LANES], loose[POSTS_LANES], under[POSTS_LANES];
#if SOIL_LAYERED
	float thick[POSTS_LANES], bulb[POSTS_LANES], base_k[POSTS_LANES], base_n[POSTS_LANES], base_elastic[POSTS_LANES];
#endif
};

SOIL_INLINED struct stress_soil soil_at(const struct soils *soils, int i)
{
	struct stress_soil s = {
		.k = soils->k[i], .n = soils->n[i], .elastic = soils->elastic[i], .by_elastic = soils->by_elastic[i], .whole = soils->whole[i], .loose = soils->loose[i], .under = soils->under[i],
	};
#if SOIL_LAYERED
	s.thick = soils->thick[i];
	s.bulb = soils->bulb[i];
	s.base_k = soils->base_k[i];
	s.base_n = soils->base_n[i];
	s.base_elastic = soils->base_elastic[i];
#endif
	return s;
}

SOIL_INLINED void take_layers(const struct soil_posts *posts, size_t b, struct soils *soils)
{
#if SOIL_LAYERED
	for (int i = 0; i < POSTS_LANES; i++) {
		soils->thick[i] = posts->thick[b + i];
		soils->bulb[i] = posts->bulb[b + i];
		soils->base_k[i] = posts->base_k[b + i];
		soils->base_n[i] = posts->base_n[b + i];
		soils->base_elastic[i] = posts->base_elastic[b + i];
	}
#else
	(void)posts;
	(void)b;
	(void)soils;
#endif
}

/* What is gone of the ground is missing from the layer. Where a loose layer lies on it, that goes first (take_loose), so there it is not. */
SOIL_INLINED void thin_layers(const float up[POSTS_LANES], const int32_t gone[POSTS_LANES], struct soils *soils)
{
#if SOIL_LAYERED
	for (int i = 0; i < POSTS_LANES; i++) {
		const float thinner = up[i] * (float)gone[i] * SOIL_UNIT;
		soils->thick[i] = most(soils->thick[i] - either((soils->thick[i] < LAYER_NONE) & (soils->loose[i] <= 0), thinner, 0), 0);
	}
#else
	(void)up;
	(void)gone;
	(void)soils;
#endif
}

/* Gives the plastic part of sinkages in fixed-point units, m. */
SOIL_INLINED void put_plastic_on(const struct soils *soils, const int32_t sinkage[POSTS_LANES], bool floored, float plastic[POSTS_LANES])
{
	for (int i = 0; i < POSTS_LANES; i++) {
		const struct stress_soil soil = soil_at(soils, i);
		plastic[i] = plastic_on(&soil, (float)sinkage[i] * SOIL_UNIT, floored);
	}
}

SOIL_INLINED void put_plastic(const struct soils *soils, const int32_t sinkage[POSTS_LANES], bool floored, float plastic[POSTS_LANES])
{
	if (floored)
		put_plastic_on(soils, sinkage, true, plastic);
	else
		put_plastic_on(soils, sinkage, false, plastic);
}

/* Takes what is gone off a loose layer, and what is more off its floor. Where the layer is gone the floor is left, as a post without a loose layer. Its
 * undisturbed surface lies above the floor by its plastic sinkage. loose: of the layer; gone: of the ground, then of the floor alone; fixed-point units. */
SOIL_INLINED void take_loose(const struct soil_posts *posts, size_t b, const float up[POSTS_LANES], const float by_up[POSTS_LANES], struct soils *soils,
			     int32_t loose[POSTS_LANES], int32_t ground[POSTS_LANES], int32_t deposited[POSTS_LANES], int32_t sinkage[POSTS_LANES], int32_t largest[POSTS_LANES], int32_t gone[POSTS_LANES])
{
	for (int i = 0; i < POSTS_LANES; i++) {
		const int32_t thick = loose[i], through = (thick > 0) & (gone[i] >= thick), floor = posts->floor[b + i];
		const float layer = soils->loose[i], under = soils->under[i], was = (float)sinkage[i] * SOIL_UNIT, now = (float)largest[i] * SOIL_UNIT;
		const int32_t rises = whole_of(clamped(under * by_up[i] * 1048576.0f, 0, 1.9e9f)) - thick;
		const int32_t deep_was = whole_of(clamped(either(was > layer, was - layer + under, 0) * 1048576.0f, 0, 1.9e9f));
		const int32_t deep_now = whole_of(clamped(either(now > layer, now - layer + under, 0) * 1048576.0f, 0, 1.9e9f));
		ground[i] += through * rises;
		deposited[i] += through * rises;
		sinkage[i] = through ? larger(floor, deep_was) : sinkage[i];
		largest[i] = through ? larger(floor, deep_now) : largest[i];
		gone[i] -= through * thick;
		soils->k[i] = through ? soils->whole[i] : soils->k[i];
		loose[i] = through ? 0 : larger(thick - gone[i], smaller(thick, 1));
		soils->loose[i] = thick > 0 && !through ? most(layer - up[i] * (float)gone[i] * SOIL_UNIT, SOIL_UNIT) : 0;
	}
}

/* Gives what a touched post remembers. A loose layer is used up where the floor bears more than it does. Then the floor is all that is left. What it
 * remembers of its sinkage goes on. loose: what is left of the layer, fixed-point units. */
SOIL_INLINED void put_floors(const struct soil_posts *posts, size_t b, const struct soils *soils, const float by_up[POSTS_LANES], const int32_t loose[POSTS_LANES],
			     struct soil_after *a)
{
	for (int i = 0; i < POSTS_LANES; i++) {
		const struct stress_soil soil = soil_at(soils, i);
		const float z = (float)a->sinkage[i] * SOIL_UNIT;
		float grows;
		const int32_t thick = loose[i], is = thick > 0;
		const int32_t used = is & (floor_stress(&soil, z, &grows) >= yield_stress(&soil, z)) & (z > soil.loose);
		const int32_t deep = whole_of(clamped((z - soil.loose + soil.under) * 1048576.0f, 0, 1.9e9f)), floor = posts->floor[b + i];
		a->deposited[i] += used * (whole_of(clamped(soil.under * by_up[i] * 1048576.0f, 0, 1.9e9f)) - thick);
		a->sinkage[i] = used ? larger(floor, deep) : a->sinkage[i];
		a->loose[i] = is & !used ? thick : 0;
		a->floor[i] = is & !used ? floor : 0;
	}
}

SOIL_CLONED static void put_after(const struct soil_form *restrict f, const float axis[restrict 2], int32_t raised, const struct soil_posts *restrict posts, size_t b,
				  const struct soil_kept *restrict kept, const float bulldozing, const float slides, struct soil_after *restrict a)
{
	int32_t far[POSTS_LANES], ground[POSTS_LANES], rests[POSTS_LANES], lowest[POSTS_LANES], deposited[POSTS_LANES], sinkage[POSTS_LANES], dug[POSTS_LANES], before[POSTS_LANES], thick[POSTS_LANES];
	float up[POSTS_LANES], by_up[POSTS_LANES], over[POSTS_LANES], swept[POSTS_LANES], more[POSTS_LANES];
	float shear_x[POSTS_LANES], shear_y[POSTS_LANES];
	struct soils soils;
	int32_t loose = 0;
	const bool tyre = f->tyre_stiff > 0;
	take_layers(posts, b, &soils);
	const int32_t rim_above = whole_units(f->bars_beyond * f->outer); /* its drum */
	const int32_t near = (int32_t)fminf((float)AFTER_SHEAR_ENDS * f->spacing * 1048576.0f, 1e9f);
	for (int i = 0; i < POSTS_LANES; i++) {
		const float height = posts->height[b + i] + posts->above[b + i] + f->beyond, flat = tyre ? kept->flat[b + i] : 0, flattest = tyre ? kept->flattest[b + i] : 0;
		ground[i] = posts->ground[b + i] - raised;
		far[i] = (posts->ground[b + i] >= AFTER_FAR) | (posts->ground[b + i] <= -AFTER_FAR);
		rests[i] = whole_units(height + flat);
		lowest[i] = whole_units(height - posts->lowered[b + i] + flattest);
		deposited[i] = posts->deposited[b + i];
		sinkage[i] = posts->sinkage[b + i];
		dug[i] = posts->digs[b + i];
		before[i] = posts->surface[b + i] - posts->ground[b + i] + deposited[i]; /* its offset */
		up[i] = posts->up[b + i];
		by_up[i] = posts->by_up[b + i];
		over[i] = posts->over[b + i];
		swept[i] = most(posts->swept[b + i], over[i]);
		more[i] = kept->more[b + i];
		soils.k[i] = posts->k[b + i];
		soils.n[i] = posts->n[b + i];
		soils.elastic[i] = posts->elastic[b + i];
		soils.by_elastic[i] = posts->by_elastic[b + i];
		soils.whole[i] = posts->whole[b + i];
		soils.loose[i] = posts->loose_thick[b + i];
		soils.under[i] = posts->under[b + i];
		thick[i] = posts->loose[b + i];
		loose |= thick[i];
		shear_x[i] = kept->shear_x[b + i];
		shear_y[i] = kept->shear_y[b + i];
	}
	int32_t largest[POSTS_LANES], digs[POSTS_LANES], gone[POSTS_LANES], all[POSTS_LANES], remains[POSTS_LANES], held[POSTS_LANES], touched[POSTS_LANES], sunk[POSTS_LANES];
	float had[POSTS_LANES], plastic[POSTS_LANES];
	for (int i = 0; i < POSTS_LANES; i++) {
		sunk[i] = over[i] > 0 ? ground[i] - rests[i] : 0;
		largest[i] = larger(sinkage[i], sinkage_of(up[i], ground[i] - lowest[i]));
	}
	const bool floored = posts->floored && loose > 0;
	put_plastic(&soils, sinkage, floored, had);
	put_plastic(&soils, largest, floored, plastic);
	for (int i = 0; i < POSTS_LANES; i++) {
		const int32_t deepest = sinkage_of(up[i], ground[i] - lowest[i]);
		const int32_t may = (swept[i] > 0) & (lowest[i] < ground[i]), touches = may & has_last(deepest, sinkage[i], had[i]);
		const int32_t holds = touches & has_last(sinkage_of(up[i], sunk[i]), largest[i], plastic[i]);
		/* What slip digs. */
		const float layer = soils.loose[i], z = up[i] * (float)sunk[i] * SOIL_UNIT;
		const int32_t above = floored ? (layer > 0) & (z > layer) ? whole_of(clamped(soils.under[i] * by_up[i] * 1048576.0f, 0, 1.9e9f)) : 0 : 0;
		digs[i] = larger(smaller(whole_units(more[i]), sunk[i] + above - 2), 0) * holds;
		/* And what the body pushes off as it slides: so much of the soil above its lower envelope. */
		const int32_t below = holds ? sunk[i] : ground[i] - lowest[i], drop = below + before[i] - deposited[i] - digs[i];
		const int32_t cut = larger(smaller(whole_of(slides * (float)larger(drop, 0)), below - digs[i] - 2), 0) * touches;
		all[i] = gone[i] = digs[i] + cut;
		touched[i] = touches;
		held[i] = holds;
	}
	if (floored)
		take_loose(posts, b, up, by_up, &soils, thick, ground, deposited, sinkage, largest, gone);
	for (int i = 0; i < POSTS_LANES; i++) {
		remains[i] = larger(sinkage[i] - whole_of(up[i] * (float)gone[i]), 0);
		largest[i] = larger(remains[i], sinkage_of(up[i], ground[i] - gone[i] - lowest[i]));
		sunk[i] = over[i] > 0 ? ground[i] - rests[i] : 0;
	}
	thin_layers(up, gone, &soils);
	put_plastic(&soils, remains, floored, had);
	put_plastic(&soils, largest, floored, plastic);
	for (int i = 0; i < POSTS_LANES; i++) {
		const int32_t still = has_last(sinkage_of(up[i], sunk[i] - gone[i]), largest[i], plastic[i]), holds = held[i] & (still | (gone[i] == 0));
		const int32_t released = whole_units(plastic[i] * by_up[i]), released_before = whole_units(had[i] * by_up[i]);
		const int32_t sinks = released + holds * (sunk[i] - gone[i] - released), heap = deposited[i] - gone[i];
		/* A drum that counts for bars leaves their print, and that of the rim between them. The soil remembers the drum. */
		const int32_t print = smaller(whole_units(posts->bars[b + i] + f->beyond), lowest[i] + rim_above) - ground[i] + deposited[i];
		const int32_t offset = (f->bars > 0) & touched[i] & (holds ^ 1) ? smaller(heap, print) : heap - sinks;
		const int32_t refused = touched[i] & ((far[i] != 0) | (sinks > OFFSET_MOST) | (offset > OFFSET_MOST) | (offset < -OFFSET_MOST)), changes = touched[i] & (refused ^ 1);
		const int32_t flows = larger(released - released_before, 0), room = larger(CARRIED_MOST - all[i], 0);
		const int32_t carries = (int32_t)least(bulldozing * (float)flows, (float)room) + smaller(all[i], CARRIED_MOST);
		/* Only soil that the floor gives up is carried. What slip digs under a body that does not go down stays there, loosened. */
		const int32_t carried = larger(smaller(carries, before[i] - offset), 0) * changes;
		a->touched[i] = changes;
		a->held[i] = changes & holds;
		a->below[i] = (over[i] > 0) & (touched[i] ^ 1);
		a->gap[i] = rests[i] - (ground[i] - deposited[i] + before[i]);
		a->refused[i] = refused;
		a->offset[i] = offset;
		a->deposited[i] = heap;
		a->sinkage[i] = largest[i];
		a->dug[i] = dug[i] + digs[i];
		a->carried[i] = carried;
		a->lost[i] = (before[i] - offset) * changes - carried;
		/* The body has just left the post, or comes next, and the shear that the post stores ends. Below a higher body that shear may belong to a
		 * second one, so it stays. */
		a->ends[i] = (swept[i] > 0) & (lowest[i] - (ground[i] - deposited[i] + before[i]) < near);
	}
	/* A pass is over where the body has left the post. It makes the soil denser by half of what is left. */
	for (int i = 0; i < POSTS_LANES; i++) {
		const int32_t density = posts->density[b + i], left = density < 1 << 20 ? (1 << 20) - density : 0;
		a->density[i] = density + left / 2 * (a->touched[i] & (a->held[i] ^ 1));
		a->loose[i] = a->floor[i] = 0;
	}
	if (floored)
		put_floors(posts, b, &soils, by_up, thick, a);
	for (int i = 0; i < POSTS_LANES; i++)
		a->shear[i] = shear_of(axis, shear_x[i] * (float)a->held[i], shear_y[i] * (float)a->held[i]);
}

/* A function with copies for several instruction sets keeps its name in the shared library whatever its visibility is: the copies stay behind this one. */
void soil_after(const struct soil_form *form, const float axis[2], int32_t raised, const struct soil_posts *posts, size_t b, const struct soil_kept *kept,
		float bulldozing, float slides, struct soil_after *after)
{
	put_after(form, axis, raised, posts, b, kept, bulldozing, slides, after);
}
