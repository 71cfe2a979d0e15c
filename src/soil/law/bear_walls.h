/*
 * Part of bear.c: what the walls of a tilted box bear. A wall is a steep lower face. In soil it is narrower than a cell. So it is summed over the edge of
 * the sole from which it rises. The post that bears there bears it, too. What the soil remembers there is what the post remembers, in the shape of the box.
 *
 * Soil lies at both ends of a box. On its lower end the wall feels it. The end across it looks up, or is upright, and the law of the lower envelope
 * has no soil there. Above the level of the sole's other edge the two hold each other. So from there on a wall bears upwards alone. Below, it
 * bears what the sole's tilt calls for: in even, level ground without friction no level force is left. The wall of a box that is nearly level
 * bears nearly nothing.
 */
#ifndef FURROW_SOIL_BEAR_WALLS_H
#define FURROW_SOIL_BEAR_WALLS_H

#include "soil/law/bear_changes.h"

#define WALL_SINKS 1000 /* a box has sunk as in its last motion for so many motions, at most */

/* The parts of a wall: from the edge up to the level of the sole's other edge, and from there to the ground. Shares of its height. */
struct wall_parts {
	float ends[3][LANES];
	float opens[LANES]; /* 1: the lower part ends below the ground */
};

/* Puts the wall beside each post: a block whose lines go up the wall. */
SOIL_INLINED void put_wall_lines(const struct soil_form *f, int w, const struct lane_posts *p, struct block *l, struct wall_parts *parts)
{
	const struct soil_box_wall *wall = &f->walls[w];
	const float *sole = f->faces[wall->sole], *up = wall->up, *back = wall->back, *lengths = w == 0 ? p->edge_long : p->other_long;
	const float *edge_x = w == 0 ? p->edge_x : p->other_x, *edge_y = w == 0 ? p->edge_y : p->other_y;
	EACH_LANE {
		const float x = edge_x[i], y = edge_y[i], rise_x = p->rise_x[i], rise_y = p->rise_y[i];
		const float depth = l->ground[i] + rise_x * (x - p->x[i]) + rise_y * (y - p->y[i]) - (sole[0] + sole[1] * x + sole[2] * y);
		const float by_rise = 1 / most(up[2] - rise_x * up[0] - rise_y * up[1], 1e-6f), open = least(back[2], back[2] - rise_x * back[0] - rise_y * back[1]);
		const float whole = clamped(depth * by_rise, 0, 1);
		parts->ends[0][i] = 0;
		parts->ends[1][i] = clamped(open * by_rise, 0, whole);
		parts->ends[2][i] = whole;
		parts->opens[i] = either((open > 0) & (parts->ends[1][i] < whole), 1, 0);
		l->centre[0][i] = x;
		l->centre[1][i] = y;
		l->end[0][i] = up[0];
		l->end[1][i] = up[1];
		l->stamped[i] = either(l->was[i] > 0, 1, 0);
		l->share[i] = either(l->share[i] > 0, 2 * lengths[i] * wall->wide / f->spacing, 0);
	}
}

/* Gives the shear on a wall. It began when the wall began to sink. */
SOIL_INLINED void shear_wall(const struct soil_form *f, bool asked, const struct lane_posts *p, int i, float deep, struct place *place)
{
	const float by_modulus = p->by_modulus[i], sank = deep / most(-f->way[2], 1e-9f), since = either(f->way[2] < 0, clamped(sank, 1, WALL_SINKS), 1), each = since * (1.0f / BRIM_STEPS);
	place->mobilised[0] = place->mobilised[1] = 0;
	brim_slides(f, 3.5f * each, each, by_modulus, place);
	brim_slides(f, 2.5f * each, each, by_modulus, place);
	brim_slides(f, 1.5f * each, each, by_modulus, place);
	brim_slides(f, 0.5f * each, each, by_modulus, place);
	if (asked) {
		const struct slip slip = slip_at(f, FORM_WALL, place->arm, place->normal, place->across);
		put_shears(&slip, by_modulus, by_modulus, (1 - exp_minus(slip.size * by_modulus)) / most(slip.size, 1e-9f), place);
	}
}

/* Makes a place bear upwards alone, if it is `upper`: 1 or 0. */
SOIL_INLINED void bear_upwards(float upper, struct place *place)
{
	const float stays = 1 - upper;
	place->area *= either(upper > 0, place->normal[2], 1);
	place->normal[0] *= stays;
	place->normal[1] *= stays;
	place->normal[2] = either(upper > 0, 1, place->normal[2]);
	place->strength *= stays;
	for (int k = 0; k < 2; k++) {
		place->dragged[k] *= stays;
		place->drags[k][0] *= stays;
		place->drags[k][1] *= stays;
	}
	put_across(place->normal, place->across);
}

/* Adds the places of one part of a wall. upper: 1: of the one that bears upwards alone. The places move with the box. What yields bears more as the box sinks. What springs back does as
 * the wall's surface moves. */
SOIL_INLINED void add_wall_places(const struct soil_form *f, bool asked, float unit, float upper, const struct lane_posts *p, const struct spots *spots, float stresses[7][LANES],
				  struct counts *counts, struct lane_changes *changes)
{
	const float post = f->spacing * f->spacing;
	float springs[LANES];
	struct lane_brims brims;
	EACH_LANE {
		struct face face;
		struct place place;
		float shear[3], stress[3], moment[3], belt[3];
		put_place(f, FORM_WALL, false, asked, p, i, spots, i, &face, &place);
		shear_wall(f, asked, p, i, spots->deep[i], &place);
		bear_upwards(upper, &place);
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
			const float flows = least(p->up[i] * (1 - place.unloads) * spots->grows[i], place.sinks);
			springs[i] = -place.area * post * (place.sinks - flows) / place.normal[2];
			place.sinks = flows;
			put_brim_lane(p, i, &place, place.area * post, &brims);
			add_figures(p, i, &place, place.area * post, shear, changes);
		}
	}
	if (asked) {
		float none[2][2][LANES] = {{{0}}};
		add_brim_changes(&brims, changes);
		add_outer(&brims, brims.normal, springs, none, changes->stiffness);
	}
}

/* Adds how the lower part of a wall grows as the box turns: it ends at the level of the sole's other edge. at: of the last place below. */
SOIL_INLINED void add_opening(const struct soil_form *f, int w, const struct wall_parts *parts, const float lengths[LANES], const struct spots *at, struct lane_changes *changes)
{
	const struct soil_box_wall *wall = &f->walls[w];
	const float by_level = 1 / sqrtf(most(wall->normal[0] * wall->normal[0] + wall->normal[1] * wall->normal[1], 1e-12f));
	float by[LANES], places[6][LANES];
	EACH_LANE {
		const float arm[3] = {at->x[i], at->y[i], at->height[i]}, level[3] = {wall->normal[0] * by_level, wall->normal[1] * by_level, 0};
		put_both(arm, level, i, places);
		by[i] = parts->opens[i] * at->keeps[i] * at->yields[i] * lengths[i] * f->spacing;
	}
	for (int r = 0; r < 6; r++)
		EACH_LANE {
			const float grows = by[i] * places[r][i];
			changes->stiffness[r][3][i] += grows * wall->back[1];
			changes->stiffness[r][4][i] -= grows * wall->back[0];
		}
}

/* Adds what the walls bear beside a block of posts. */
SOIL_INLINED void add_walls(const struct soil_form *f, bool asked, float unit, const struct lane_posts *p, const struct block *l, float stresses[7][LANES], struct counts *counts,
			    struct lane_changes *changes)
{
	_Pragma("GCC unroll 1") for (int w = 0; w < f->wall_count; w++) {
		struct lane_posts posts = *p;
		struct block block = *l;
		struct wall_parts parts;
		struct spots spots;
		if (!any_above(w == 0 ? p->edge_long : p->other_long, 0))
			continue;
		EACH_LANE posts.own[i] = (float)(1 + w);
		put_wall_lines(f, w, p, &block, &parts);
		/* One loop that is not unrolled: what it calls is large. */
		_Pragma("GCC unroll 1") for (int n = 0; n < 4; n++) {
			memcpy(block.first, parts.ends[n / 2], sizeof block.first);
			memcpy(block.last, parts.ends[n / 2 + 1], sizeof block.last);
			put_spots(f, FORM_WALL, false, &posts, &block, n % 2 == 0 ? -0.28867513f : 0.28867513f, &spots);
			add_wall_places(f, asked, unit, (float)(n / 2), &posts, &spots, stresses, counts, changes);
			if (asked && n == 1 && f->ground_normals == 0)
				add_opening(f, w, &parts, w == 0 ? p->edge_long : p->other_long, &spots, changes);
		}
	}
}

#endif
