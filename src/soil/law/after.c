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

#if SOIL_LAYERED
/* What lies below the soil of a block of posts. */
struct layers {
	float thick[POSTS_LANES], bulb[POSTS_LANES], k[POSTS_LANES], n[POSTS_LANES], elastic[POSTS_LANES];
};

SOIL_INLINED void take_layers(const struct soil_posts *posts, size_t b, struct layers *layers)
{
	for (int i = 0; i < POSTS_LANES; i++) {
		layers->thick[i] = posts->thick[b + i];
		layers->bulb[i] = posts->bulb[b + i];
		layers->k[i] = posts->base_k[b + i];
		layers->n[i] = posts->base_n[b + i];
		layers->elastic[i] = posts->base_elastic[b + i];
	}
}

/* What slip digs is missing from the layer. */
SOIL_INLINED void thin_layers(const float up[POSTS_LANES], const int32_t digs[POSTS_LANES], struct layers *layers)
{
	for (int i = 0; i < POSTS_LANES; i++) {
		const float dug = up[i] * (float)digs[i] * SOIL_UNIT;
		layers->thick[i] = most(layers->thick[i] - either(layers->thick[i] < LAYER_NONE, dug, 0), 0);
	}
}
#else
struct layers {
	float none;
};
#endif

/* Gives the plastic part of sinkages in fixed-point units, m. */
SOIL_INLINED void put_plastic(const float k[POSTS_LANES], const float n[POSTS_LANES], const float elastic[POSTS_LANES], const float by_elastic[POSTS_LANES],
			      const struct layers *layers, const int32_t sinkage[POSTS_LANES], float plastic[POSTS_LANES])
{
	(void)layers;
	for (int i = 0; i < POSTS_LANES; i++) {
		struct stress_soil soil = {.k = k[i], .n = n[i], .elastic = elastic[i], .by_elastic = by_elastic[i]};
#if SOIL_LAYERED
		soil.thick = layers->thick[i];
		soil.bulb = layers->bulb[i];
		soil.base_k = layers->k[i];
		soil.base_n = layers->n[i];
		soil.base_elastic = layers->elastic[i];
#endif
		plastic[i] = plastic_of(&soil, (float)sinkage[i] * SOIL_UNIT);
	}
}

SOIL_CLONED void soil_after(const struct soil_form *restrict f, const float axis[restrict 2], int32_t raised, const struct soil_posts *restrict posts, size_t b,
				  const struct soil_kept *restrict kept, const float bulldozing, struct soil_after *restrict a)
{
	int32_t far[POSTS_LANES], ground[POSTS_LANES], rests[POSTS_LANES], lowest[POSTS_LANES], deposited[POSTS_LANES], sinkage[POSTS_LANES], dug[POSTS_LANES], before[POSTS_LANES];
	float up[POSTS_LANES], by_up[POSTS_LANES], over[POSTS_LANES], swept[POSTS_LANES], more[POSTS_LANES];
	float k[POSTS_LANES], n[POSTS_LANES], elastic[POSTS_LANES], by_elastic[POSTS_LANES], shear_x[POSTS_LANES], shear_y[POSTS_LANES];
	struct layers layers;
#if SOIL_LAYERED
	take_layers(posts, b, &layers);
#endif
	const int32_t near = (int32_t)fminf((float)AFTER_SHEAR_ENDS * f->spacing * 1048576.0f, 1e9f);
	for (int i = 0; i < POSTS_LANES; i++) {
		const float height = posts->height[b + i] + posts->above[b + i] + f->beyond;
		ground[i] = posts->ground[b + i] - raised;
		far[i] = (posts->ground[b + i] >= AFTER_FAR) | (posts->ground[b + i] <= -AFTER_FAR);
		rests[i] = whole_units(height);
		lowest[i] = whole_units(height - posts->lowered[b + i]);
		deposited[i] = posts->deposited[b + i];
		sinkage[i] = posts->sinkage[b + i];
		dug[i] = posts->digs[b + i];
		before[i] = posts->surface[b + i] - posts->ground[b + i] + deposited[i]; /* its offset */
		up[i] = posts->up[b + i];
		by_up[i] = posts->by_up[b + i];
		over[i] = posts->over[b + i];
		swept[i] = most(posts->swept[b + i], over[i]);
		more[i] = kept->more[b + i];
		k[i] = posts->k[b + i];
		n[i] = posts->n[b + i];
		elastic[i] = posts->elastic[b + i];
		by_elastic[i] = posts->by_elastic[b + i];
		shear_x[i] = kept->shear_x[b + i];
		shear_y[i] = kept->shear_y[b + i];
	}
	int32_t largest[POSTS_LANES], digs[POSTS_LANES], remains[POSTS_LANES], held[POSTS_LANES], touched[POSTS_LANES], sunk[POSTS_LANES];
	float had[POSTS_LANES], plastic[POSTS_LANES];
	for (int i = 0; i < POSTS_LANES; i++) {
		sunk[i] = over[i] > 0 ? ground[i] - rests[i] : 0;
		largest[i] = larger(sinkage[i], sinkage_of(up[i], ground[i] - lowest[i]));
	}
	put_plastic(k, n, elastic, by_elastic, &layers, sinkage, had);
	put_plastic(k, n, elastic, by_elastic, &layers, largest, plastic);
	for (int i = 0; i < POSTS_LANES; i++) {
		const int32_t deepest = sinkage_of(up[i], ground[i] - lowest[i]);
		const int32_t may = (swept[i] > 0) & (lowest[i] < ground[i]), touches = may & has_last(deepest, sinkage[i], had[i]);
		const int32_t holds = touches & has_last(sinkage_of(up[i], sunk[i]), largest[i], plastic[i]);
		/* What slip digs. */
		digs[i] = larger(smaller(whole_units(more[i]), sunk[i] - 2), 0) * holds;
		remains[i] = larger(sinkage[i] - whole_of(up[i] * (float)digs[i]), 0);
		largest[i] = larger(remains[i], sinkage_of(up[i], ground[i] - digs[i] - lowest[i]));
		touched[i] = touches;
		held[i] = holds;
	}
#if SOIL_LAYERED
	thin_layers(up, digs, &layers);
#endif
	put_plastic(k, n, elastic, by_elastic, &layers, remains, had);
	put_plastic(k, n, elastic, by_elastic, &layers, largest, plastic);
	for (int i = 0; i < POSTS_LANES; i++) {
		const int32_t still = has_last(sinkage_of(up[i], sunk[i] - digs[i]), largest[i], plastic[i]), holds = held[i] & (still | (digs[i] == 0));
		const int32_t released = whole_units(plastic[i] * by_up[i]), released_before = whole_units(had[i] * by_up[i]);
		const int32_t sinks = released + holds * (sunk[i] - digs[i] - released), heap = deposited[i] - digs[i], offset = heap - sinks;
		const int32_t refused = touched[i] & ((far[i] != 0) | (sinks > OFFSET_MOST) | (offset > OFFSET_MOST) | (offset < -OFFSET_MOST)), changes = touched[i] & (refused ^ 1);
		const int32_t flows = larger(released - released_before, 0), room = larger(CARRIED_MOST - digs[i], 0);
		const int32_t carries = (int32_t)least(bulldozing * (float)flows, (float)room) + smaller(digs[i], CARRIED_MOST);
		/* Only soil that the floor gives up is carried. What slip digs under a body that does not go down stays there, loosened. */
		const int32_t carried = larger(smaller(carries, before[i] - offset), 0) * changes;
		a->touched[i] = changes;
		a->held[i] = changes & holds;
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
	for (int i = 0; i < POSTS_LANES; i++)
		a->shear[i] = shear_of(axis, shear_x[i] * (float)a->held[i], shear_y[i] * (float)a->held[i]);
}
