/* Part of bear.c: pressure, damping and shear at a place of each lane, and at the lower end of a rim that leans. */
#ifndef FURROW_SOIL_BEAR_PLACES_H
#define FURROW_SOIL_BEAR_PLACES_H

#include "soil/law/bear_block.h"

/* At rest a body would rock and slide to and fro for long, since soil springs back without loss. So what moves slower than these is damped more. */
#define STICKS 0.003f    /* m/s along a surface: by the soil's own damping */
#define SETTLES 0.002f   /* m/s across it: by SETTLING times as much */
#define SETTLING 10.0f

/* --- 4: places --- */

/* The soil at a place of each lane. */
struct spots {
	float rims[LANES]; /* of a tyre: the rim's depth at which the soil is `most` deep */
	float x[LANES], y[LANES], height[LANES], deep[LANES], most[LANES], yields[LANES], grows[LANES], unloads[LANES], stays[LANES], touching[LANES], part[LANES], keeps[LANES], holds[LANES];
};

SOIL_INLINED void put_spot_yields(const struct lane_posts *p, bool floored, struct spots *spots)
{
	EACH_LANE {
		const struct stress_soil s = soil_of(p, i);
		spots->yields[i] = yield_stress_on(&s, spots->most[i], floored);
		spots->grows[i] = yield_growth_on(&s, spots->yields[i], spots->most[i], floored);
	}
}

SOIL_INLINED void put_spots(const struct soil_form *f, enum soil_form_kind kind, bool soft, const struct lane_posts *p, const struct block *l, float at,
			    struct spots *spots)
{
	const bool known = any_above(l->was, 0);
	EACH_LANE {
		const float on = 0.5f * (l->first[i] + l->last[i]) + at * (l->last[i] - l->first[i]);
		const float x = l->centre[0][i] + on * l->end[0][i], y = l->centre[1][i] + on * l->end[1][i];
		const float rise = p->rise_x[i] * (x - p->x[i]) + p->rise_y[i] * (y - p->y[i]);
		const float height = height_at(f, kind, p->own[i], x, y), deep = l->depth[i] + p->height[i] + rise - height;
		float since;
		const float lower = lower_at(f, kind, p, i, l, x, y, &since);
		spots->x[i] = x;
		spots->y[i] = y;
		spots->height[i] = height;
		spots->deep[i] = deep;
		spots->most[i] = deep + lower;
		/* Where the body was deeper before in its motion, its deepest pose sinks by less than the last one. */
		spots->unloads[i] = either(lower > 0, 1, 0) * either(f->passes[0] > 0, least(since, 1), 1);
		spots->keeps[i] = l->keeps[i];
		spots->part[i] = 0.25f * l->share[i] * (l->last[i] - l->first[i]); /* of two places, on a line from -1 to 1 */
		const float later = ((x - p->x[i]) * f->by_way[0] + (y - p->y[i]) * f->by_way[1]) * l->lasts[i];
		spots->touching[i] = l->slides[i] * most(lasted(p, i, l->passed[i]) - later, 0);
	}
	if (known)
		EACH_LANE {
			const float rise = p->rise_x[i] * (spots->x[i] - p->x[i]) + p->rise_y[i] * (spots->y[i] - p->y[i]);
			const float before = remembered_at(f, kind, p, i, l, i, spots->x[i], spots->y[i], spots->deep[i], rise);
			spots->unloads[i] = either(before >= spots->most[i], 1, spots->unloads[i]);
			spots->most[i] = most(spots->most[i], before);
		}
	EACH_LANE spots->most[i] *= p->up[i];
	if (soft) {
		memcpy(spots->rims, spots->most, sizeof spots->rims);
		if (l->floored)
			put_soil(f, p, l, true, spots->most);
		else
			put_soil(f, p, l, false, spots->most);
	}
	if (l->floored)
		put_spot_yields(p, true, spots);
	else
		put_spot_yields(p, false, spots);
	EACH_LANE {
		spots->stays[i] = exp_minus(spots->touching[i]);
		spots->holds[i] = 1 - 0.5f * l->springs[i] * spots->stays[i]; /* put_shares */
	}
}

/* What the lanes bear, in whole numbers. */
struct counts {
	int32_t force[3][LANES], moment[3][LANES], pull[LANES], area[LANES], saturated[LANES];
	float grows[LANES];
};

/* One place, as a probe needs it. Amounts are those of the place's share of a post's area. */
struct place {
	float arm[3], normal[3], across[2][3];
	float area, ground;              /* of the surface, and of the ground that bears; posts */
	float stress, strength, holds;   /* Pa: normal, with damping; the most that shear can be; how that grows with the normal stress */
	float mobilised[2], dragged[2];  /* shear along `across`: share of the strength; Pa, of damping */
	float unloads;                   /* 1: it springs back, or is loaded anew */
	float leans;                     /* of a tyre: the share of the rim's slope that its surface has */
	float sinks, damps;              /* growth of the normal stress: Pa/m as the surface goes down, Pa s/m with its speed along the normal */
	float shears[2][2], drags[2][2]; /* 1/m, Pa s/m: growth of `mobilised` and `dragged` with a way, a speed along `across` */
};

/* How a damping that is for slow motion alone fades. squares: of the speed, as a share of the speed at which it is halved. */
SOIL_INLINED float fade(float squares)
{
	return 1 / (1 + squares);
}

/* Returns how the stress of such a damping grows with the speed; 0 where it falls. */
SOIL_INLINED float fade_slope(float fades)
{
	return fades * most(2 * fades - 1, 0);
}

/* Adds damping, Pa s/m. damping: of the shear stress of a surface that hardly slides. normal: of the pressure of soil that is pushed down. both: of a carcass, which damps upward
 * motion, too. down: m/s, without the motion of grousers, since a bar that passes pushes no more soil down. */
SOIL_INLINED void put_rates_of(const struct soil_form *f, float damping, float normal, float both, float down, struct place *place)
{
	const float slow = fade(down * down / (SETTLES * SETTLES)), settles = SETTLING * normal, damps = either(down >= 0, normal, 0) + both;
	float along[2];
	place->stress = most(place->stress + (damps + settles * slow) * down, 0);
	place->damps = damps + settles * fade_slope(slow);
	running_at(f, f->angular, f->runs, place->arm, place->normal, place->across, along);
	along[0] += dot3(f->linear, place->across[0]);
	along[1] += dot3(f->linear, place->across[1]);
	const float squares = along[0] * along[0] + along[1] * along[1], fades = fade(squares / (STICKS * STICKS));
	const float sticks = damping * fades, drops = either(squares > 0, damping * (fades - fade_slope(fades)) / most(squares, 1e-30f), 0);
	for (int k = 0; k < 2; k++) {
		place->dragged[k] = sticks * along[k];
		for (int j = 0; j < 2; j++)
			place->drags[k][j] = (k == j ? sticks : 0) - drops * along[k] * along[j];
	}
}

SOIL_INLINED void put_rates(const struct soil_form *f, float damping, float down, struct place *place)
{
	put_rates_of(f, damping, damping, 0, down, place);
}

/* Returns how fast the surface at a place goes down along its normal, m/s. */
SOIL_INLINED float down_at(const struct soil_form *f, const float arm[3], float above, const float normal[3])
{
	const float place[3] = {arm[0], arm[1], arm[2] - above};
	float moves[3];
	cross3(f->angular, place, moves);
	return -(dot3(f->linear, normal) + dot3(moves, normal));
}

/* Gives how the mobilised shares grow with a way. by_modulus: 1/m, where the surface has not slid; slides: where it has. turning: 1/m, how they follow
 * the way's direction. */
SOIL_INLINED void put_shears(const struct slip *slip, float by_modulus, float slides, float turning, struct place *place)
{
	for (int k = 0; k < 2; k++)
		for (int j = 0; j < 2; j++) {
			const float grows = (slip->direction[k] - place->mobilised[k]) * slip->direction[j] * slides + ((k == j) - slip->direction[k] * slip->direction[j]) * turning;
			place->shears[k][j] = either(slip->size > 1e-9f, grows, k == j ? by_modulus : 0);
		}
}

/* Leans and raises the surface of a tyre at a place, by how far it gives way, m along the base's normal. share: of the rim's depth by which the soil sinks. */
SOIL_INLINED void put_carcass(const struct lane_posts *p, int i, float gives, float share, struct place *place)
{
	tyre_lean(share, p->rise_x[i], p->rise_y[i], place->normal);
	put_across(place->normal, place->across);
	place->arm[2] += gives * p->by_up[i];
}

SOIL_INLINED void put_place(const struct soil_form *f, enum soil_form_kind kind, bool soft, bool asked, const struct lane_posts *p, int i,
			    const struct spots *spots, int lane, struct face *face, struct place *place)
{
	const struct stress_soil s = soil_of(p, i);
	const float up = p->up[i], x = spots->x[lane], y = spots->y[lane], largest = spots->most[lane], z = up * spots->deep[lane], yields = spots->yields[lane];
	face_at(f, kind, p->own[i], x, y, face);
	face->height = spots->height[lane];
	normal_of(f, p, i, face, place->normal);
	put_across(place->normal, place->across);
	place->arm[0] = x;
	place->arm[1] = y;
	place->arm[2] = face->height + p->above[i];
	float by_elastic;
	const float plastic = plastic_part(&s, largest, yields), rim = soft ? spots->rims[lane] : largest;
	float springs = springs_at(&s, z, largest, yields, plastic, &by_elastic), gives = 0, sinks = 1;
	if (soft) {
		const float sunk = either(z >= rim, least(largest, z), tyre_springs(f, yields, plastic, by_elastic, z));
		gives = z - sunk;
		springs = springs_at(&s, sunk, largest, yields, plastic, &by_elastic);
	}
	const float share = either(z >= rim, 1, springs);
	const float down = down_at(f, place->arm, p->above[i], place->normal);
	if (soft) {
		sinks = either(gives > 0, tyre_share(f, spots->grows[lane], yields * by_elastic, most(rim - z, 0)), 1);
		put_carcass(p, i, gives, sinks, place);
	}
	place->ground = either(least(z, share) > 0, spots->part[lane], 0);
	/* A flat end that is as wide as several cells bears by its area in plan: all of it on level ground. */
	const float level = clamped(1 - (place->normal[0] * p->rise_x[i] + place->normal[1] * p->rise_y[i]) / most(place->normal[2], 1e-6f), 0, 1);
	const float plane = either(f->ground_normals + face->end > 0, 1, place->normal[2]), bears = either((kind == FORM_END) & (face->end > 0) & (f->ground_normals == 0), level, 1);
	place->area = place->ground * bears / plane * spots->keeps[lane];
	place->stress = yields * share;
	if (soft) /* of two springs in line the softer one tells their force best */
		place->stress = either((gives > 0) & (f->tyre_stiff < yields * by_elastic), f->tyre_holds + f->tyre_stiff * gives, place->stress);
	/* At the yield surface the soil yields if the body goes on down, and springs back if it does not. */
	const float flows = either(z >= rim - SOIL_LEAST, either((down > 0) | (f->rates == 0), 1, 0), 0), unloads = (1 - flows) * either(z >= rim - SOIL_LEAST, 1, spots->unloads[lane]);
	place->unloads = unloads;
	place->sinks = up * ((1 - unloads) * spots->grows[lane] + unloads * yields * by_elastic);
	const float damping = s.damping * least(4 * share, 1) * least(4 * most(largest, 0) * s.by_modulus, 1);
	if (soft) { /* each part of the surface's speed damps: the soil's by the soil, the carcass's by the carcass */
		const float grows = place->sinks * p->by_up[i], series = f->tyre_grows / (f->tyre_grows + grows);
		place->sinks *= either(gives > 0, series, 1);
		put_rates_of(f, damping, damping * sinks * sinks, f->tyre_damps * (1 - sinks) * (1 - sinks), down, place);
	} else {
		put_rates(f, damping, down, place);
	}
	place->leans = sinks;
	const struct slip slip = slip_at(f, kind, place->arm, place->normal, place->across);
	place->mobilised[0] = sheared(p->shear_x[i], slip.direction[0], spots->stays[lane]);
	place->mobilised[1] = sheared(p->shear_y[i], slip.direction[1], spots->stays[lane]);
	place->strength = strength_of(&f->surface, &s, place->stress, &place->holds);
	place->holds *= spots->holds[lane];
	if (asked) {
		const float touching = spots->touching[lane], turning = either(touching > 0, (1 - spots->stays[lane]) / most(slip.size, 1e-9f), 0);
		/* A surface that slides already: its shear grows only by what Janosi's curve still has to give in the direction of the slide. */
		put_shears(&slip, s.by_modulus, s.by_modulus * slip.time, turning, place);
	}
}

/* --- the lower end of a rim that leans --- */

/* It covers less than a post in plan, so it is summed beside the last cell. Its shear is followed along its way, in four steps: it turns over the
 * soil, downwards ahead of the axle and upwards behind it. */
#define BRIM_STEPS 4

/* A wall bears beside the post, where no body has passed. So it finds the ground as it is below a loose layer: as if the post had none. Then it does not
 * change as that layer is used up, and a wall gains nothing by it. Returns how much lower the undisturbed surface of that ground is, m. */
SOIL_INLINED float below_loose(const struct lane_posts *p, int i)
{
	return either(p->loose_thick[i] > 0, (p->loose_thick[i] - p->under[i]) * p->by_up[i], 0);
}

SOIL_INLINED struct stress_soil firm_soil(const struct lane_posts *p, int i)
{
	struct stress_soil s = soil_of(p, i);
	s.k = either(s.loose > 0, s.whole, s.k);
	s.loose = 0;
	return s;
}

/* The edge of the lower end beside a cell. */
struct edge {
	float at[2], lowest, depth; /* its lowest place beside the part that bears; m below the ground there */
	float length, strip;        /* of that part, in lines across a cell; half the width of the strip there */
};

SOIL_INLINED struct edge edge_of(const struct soil_form *f, const struct lane_posts *p, const struct block *l, int i)
{
	const float beside = low_side(f) * f->half_axis * f->level, x = l->centre[0][i], y = l->centre[1][i], rise_x = p->rise_x[i], rise_y = p->rise_y[i];
	const float height = l->ground[i] - below_loose(p, i) + rise_x * (x - p->x[i]) + rise_y * (y - p->y[i]) - p->above[i];
	float depths[3];
	for (int k = 0; k < 3; k++) {
		const float along = (float)(k - 1) * f->half_across, strip = half_strip(f, x + along), aside = f->lean * strip + beside;
		depths[k] = height + rise_x * along + rise_y * (aside - y) - (f->lean * aside - strip) * f->lift;
	}
	const float first = root_from(-1, depths), last = most(first, root_from(1, depths)), at = 0.5f * (first + last) * f->half_across;
	const float strip = half_strip(f, x + at), aside = f->lean * strip + beside, lowest = (f->lean * aside - strip) * f->lift;
	return (struct edge){{x + at, aside}, lowest, height + rise_x * at + rise_y * (aside - y) - lowest, 0.5f * (last - first), strip};
}

/* How long the end has slid over the soil beside its edge, in motions. It began when the rim came from ahead, or the end from above. A short motion
 * says little of it. mean: m, of its depth; below: its place on the rim, ahead of the axle. */
SOIL_INLINED float brim_since(const struct soil_form *f, const struct edge *edge, float mean, float below)
{
	const float came = either(f->run > 0, most(half_strip(f, below) - edge->at[0], 0) / most(f->run, 1e-12f), 1e9f);
	const float sank = either(f->way[2] < 0, mean / most(-f->way[2], 1e-12f), 1e9f), since = least(came, sank), rolled = least(f->run / f->half_across, 1);
	return either(since < 1e9f, either(since > 1, 1 + (since - 1) * rolled * rolled, since), 1);
}

/* Follows its shear over one step. back: how long ago, each: how long it was, in motions. */
SOIL_INLINED void brim_slides(const struct soil_form *f, float back, float each, float by_modulus, struct place *place)
{
	const float arm[3] = {place->arm[0] + back * f->way[0], place->arm[1] + back * f->way[1], place->arm[2] + back * f->way[2]};
	const struct slip slip = slip_at(f, FORM_RIM, arm, place->normal, place->across);
	const float stays = exp_minus(slip.size * each * by_modulus);
	place->mobilised[0] = sheared(place->mobilised[0], slip.direction[0], stays);
	place->mobilised[1] = sheared(place->mobilised[1], slip.direction[1], stays);
}

/* Gives the stresses of what bears beside a cell. area, arm and normal are set. mean: m, the sinkage at which soil bears the mean of the pressure; deep: m. */
SOIL_INLINED void bear_brim(const struct soil_form *f, bool asked, const struct lane_posts *p, int i, float mean, float deep, float since, struct place *place)
{
	const struct stress_soil s = firm_soil(p, i);
	const float up = p->up[i], each = since * (1.0f / BRIM_STEPS);
	place->stress = yield_stress(&s, up * mean);
	place->sinks = place->stress * (s.n + 1) / deep;
	put_across(place->normal, place->across);
	put_rates(f, s.damping * least(4 * up * mean * s.by_modulus, 1), down_at(f, place->arm, p->above[i], place->normal), place);
	place->strength = strength_of(&f->surface, &s, place->stress, &place->holds);
	place->mobilised[0] = place->mobilised[1] = 0;
	_Static_assert(BRIM_STEPS == 4, "one call each: gcc makes no vectors of a loop in a loop");
	brim_slides(f, 3.5f * each, each, s.by_modulus, place);
	brim_slides(f, 2.5f * each, each, s.by_modulus, place);
	brim_slides(f, 1.5f * each, each, s.by_modulus, place);
	brim_slides(f, 0.5f * each, each, s.by_modulus, place);
	if (asked) { /* how the way before this motion changes is left out */
		const struct slip slip = slip_at(f, FORM_RIM, place->arm, place->normal, place->across);
		const float turning = (1 - exp_minus(slip.size * least(since, 1) * s.by_modulus)) / most(slip.size, 1e-9f);
		put_shears(&slip, s.by_modulus, s.by_modulus, turning, place);
	}
}

/* Gives what the end bears beside a post's cell. It bears the mean of the pressure from 0 to the depth of its edge, by its area in plan. */
SOIL_INLINED void put_brim(const struct soil_form *f, bool asked, const struct lane_posts *p, const struct block *l, int i, struct place *place)
{
	const struct stress_soil s = soil_of(p, i);
	const struct edge edge = edge_of(f, p, l, i);
	const float low = low_side(f), leans = most(fabsf(f->lean), 1e-6f), steep = f->level / leans, up = p->up[i], rise_x = p->rise_x[i], rise_y = p->rise_y[i];
	const float width = clamped(edge.depth / most(steep - low * rise_y, 1e-6f), 0, 2 * edge.strip * fabsf(f->lean));
	const float deep = most(edge.depth, SOIL_UNIT), mean = deep * power_of(s.n + 1, -1 / s.n), out_by = width / (s.n + 2);
	const float bears = either(f->ground_normals > 0, 1, clamped(1 + low * f->level * rise_y / leans, 0, 1));
	const bool is = ((low < 0 ? p->side_right[i] : p->side_left[i]) > 0) & (l->share[i] > 0) & (edge.depth > 0);
	place->ground = either(is, edge.length * width * f->by_step * bears, 0);
	place->area = place->ground * l->keeps[i];
	const float since = brim_since(f, &edge, mean, edge.strip - out_by / leans);
	place->arm[0] = edge.at[0];
	place->arm[1] = edge.at[1] + low * out_by;
	place->arm[2] = edge.lowest + out_by * steep + p->above[i];
	place->normal[0] = either(f->ground_normals > 0, -rise_x * up, 0);
	place->normal[1] = either(f->ground_normals > 0, -rise_y * up, -low * f->level);
	place->normal[2] = either(f->ground_normals > 0, up, leans);
	bear_brim(f, asked, p, i, mean, deep, since, place);
}

#define WALL_MOTIONS 32 /* a wall slid over the soil beside it for so many motions, at most */

/* Returns how long a wall has slid over the soil beside it, in motions (brim_since). drifts: m, how far its edge moves outwards in a motion. out_by: m, how
 * far from the edge its soil bears. The edge of a drum is bent, so it reaches that soil otherwise. */
SOIL_INLINED float wall_since(const struct soil_form *f, float drifts, float out_by, float mean)
{
	const float run = f->passes[0], bent = sqrtf(drifts * drifts + 2 * f->bulges * run * run * out_by) - drifts;
	const float came = 2 * out_by / most(bent, 1e-9f), sank = mean / most(-f->way[2], 1e-9f), since = least(least(came, sank), WALL_MOTIONS), rolled = least(run / f->half_across, 1);
	return either(since > 1, 1 + (since - 1) * rolled * rolled, since);
}

/* Gives what walls of a mesh bear beside a post's cell. */
SOIL_INLINED void put_wall(const struct soil_form *f, bool asked, const struct lane_posts *p, const struct block *l, int i, struct place *place)
{
	const struct stress_soil s = soil_of(p, i);
	const struct soil_fine *fine = &f->fine;
	const float c = fine->axis[0], q = fine->axis[1], up = p->up[i], rise_x = p->rise_x[i], rise_y = p->rise_y[i], by_cell = fine->by_step / (float)fine->parts;
	const float half_place = 0.5f * fine->step, column = (c * p->x[i] - q * p->y[i] - fine->x + half_place) * by_cell, row = (q * p->x[i] + c * p->y[i] - fine->y + half_place) * by_cell;
	const bool within = (column >= 0) & (row >= 0) & (column < (float)fine->cells[0]) & (row < (float)fine->cells[1]);
	const struct soil_brim *b = &fine->brims[within ? (int32_t)row * fine->cells[0] + (int32_t)column : 0];
	const float by = 1 / most(b->length, 1e-12f), east = b->x * by, north = b->y * by, out[2] = {(c * b->out[0] + q * b->out[1]) * by, (c * b->out[1] - q * b->out[0]) * by};
	const float aside[2] = {(c * b->aside[0] + q * b->aside[1]) * by, (c * b->aside[1] - q * b->aside[0]) * by}, flat = most(b->flat * by, 1e-5f), tall = b->tall * by;
	const float x = c * east + q * north, y = c * north - q * east, half = 0.5f * b->length, along[2] = {-out[1] * half, out[0] * half};
	/* The part of the edge that is in soil. */
	const float beside = b->z * by - height_at(f, FORM_RASTER, 0, x, y), ground = l->ground[i] - below_loose(p, i) - p->above[i];
	float depths[3];
	for (int k = 0; k < 3; k++) {
		const float u = x + (float)(k - 1) * along[0], v = y + (float)(k - 1) * along[1];
		depths[k] = ground + rise_x * (u - p->x[i]) + rise_y * (v - p->y[i]) - height_at(f, FORM_RASTER, 0, u, v) - beside;
	}
	const float first = root_from(-1, depths), last = most(first, root_from(1, depths)), at = 0.5f * (first + last);
	const float bends = 0.5f * (depths[0] + depths[2]) - depths[1], rises = 0.5f * (depths[2] - depths[0]), depth = depths[1] + at * (rises + at * bends);
	const float width = clamped(depth / most(1 / flat - rise_x * out[0] - rise_y * out[1], 1e-6f), 0, tall * flat), size = 1 / sqrtf(out[0] * out[0] + out[1] * out[1] + flat * flat);
	const float deep = most(depth, SOIL_UNIT), share = power_of(s.n + 1, -1 / s.n), mean = most(deep * share, deep - (1 - share) * tall), out_by = width / (s.n + 2);
	const float normal[3] = {-out[0] * size, -out[1] * size, flat * size}, level = clamped(1 - (normal[0] * rise_x + normal[1] * rise_y) / normal[2], 0, 1);
	const float bears = either(f->ground_normals > 0, 1, either(2 * b->end > b->length, level, 1 / normal[2]));
	const bool is = within & (b->length > 0) & (l->share[i] > 0) & (depth > 0);
	place->ground = either(is, 0.5f * (last - first) * b->length * width / (f->spacing * f->spacing), 0);
	place->area = place->ground * bears * l->keeps[i];
	place->arm[0] = x + at * along[0] + out_by * out[0];
	place->arm[1] = y + at * along[1] + out_by * out[1];
	place->arm[2] = ground + rise_x * (place->arm[0] - out_by * out[0] - p->x[i]) + rise_y * (place->arm[1] - out_by * out[1] - p->y[i]) - depth + out_by / flat + p->above[i];
	for (int k = 0; k < 3; k++)
		place->normal[k] = either(f->ground_normals > 0, k == 0 ? -rise_x * up : k == 1 ? -rise_y * up : up, normal[k]);
	bear_brim(f, asked, p, i, mean, deep, wall_since(f, aside[0] * f->way[0] + aside[1] * f->way[1], out_by, mean), place);
}

/* Gives the stress on the body at a place, Pa of its surface. shear: of its shear, the direction times the share of the strength. */
SOIL_INLINED void stress_at(const struct place *place, float shear[3], float stress[3])
{
	for (int k = 0; k < 3; k++) {
		shear[k] = place->mobilised[0] * place->across[0][k] + place->mobilised[1] * place->across[1][k];
		stress[k] = place->stress * place->normal[k] - place->strength * shear[k] - place->dragged[0] * place->across[0][k] -
			    place->dragged[1] * place->across[1][k];
	}
}

#endif
