/* Part of bear.c: what a probe adds up. How the force on the body changes as it moves, turns, or gets faster. */
#ifndef FURROW_SOIL_BEAR_CHANGES_H
#define FURROW_SOIL_BEAR_CHANGES_H

#include "soil/law/bear_places.h"

/* What a probe adds up, for each lane. */
struct lane_changes {
	float normal[3][LANES], normal_force[LANES], shear_limit[LANES], sheared[3][LANES];
	float stiffness[6][6][LANES], damping[6][6][LANES];
};

/* The places of the lanes, as a probe needs them: means of both places of a lane, by area. */
struct lane_places {
	float area[LANES], ground[LANES], stress[LANES], strength[LANES], holds[LANES], sinks[LANES], damps[LANES];
	float arm[3][LANES], normal[3][LANES], across[2][3][LANES], mobilised[2][LANES], dragged[2][LANES], shears[2][2][LANES], drags[2][2][LANES], bends[3][LANES];
};

/* Adds a place, times its area. */
SOIL_INLINED void add_place(const struct place *place, const float bends[3], int i, struct lane_places *all)
{
	const float area = place->area;
	all->area[i] += area;
	all->ground[i] += place->ground;
	all->stress[i] += area * place->stress;
	all->strength[i] += area * place->strength;
	all->holds[i] += area * place->holds;
	all->sinks[i] += area * place->sinks;
	all->damps[i] += area * place->damps;
	for (int k = 0; k < 3; k++) {
		all->arm[k][i] += area * place->arm[k];
		all->normal[k][i] += area * place->normal[k];
		all->across[0][k][i] += area * place->across[0][k];
		all->across[1][k][i] += area * place->across[1][k];
		all->bends[k][i] += area * bends[k];
	}
	for (int k = 0; k < 2; k++) {
		all->mobilised[k][i] += area * place->mobilised[k];
		all->dragged[k][i] += area * place->dragged[k];
		for (int j = 0; j < 2; j++) {
			all->shears[k][j][i] += area * place->shears[k][j];
			all->drags[k][j][i] += area * place->drags[k][j];
		}
	}
}

/* Returns the mean of a lane. Without any area it is a level surface. */
SOIL_INLINED struct place mean_of(const struct lane_places *all, int i)
{
	const float by = 1 / most(all->area[i], 1e-30f);
	struct place mean = {
		.area = all->area[i], .ground = all->ground[i], .stress = all->stress[i] * by, .strength = all->strength[i] * by, .holds = all->holds[i] * by,
		.sinks = all->sinks[i] * by, .damps = all->damps[i] * by,
	};
	for (int k = 0; k < 3; k++) {
		mean.arm[k] = all->arm[k][i] * by;
		mean.normal[k] = all->normal[k][i] * by;
		mean.across[0][k] = all->across[0][k][i] * by;
		mean.across[1][k] = all->across[1][k][i] * by;
	}
	mean.normal[2] = either(mean.area > 0, mean.normal[2], 1);
	for (int k = 0; k < 2; k++) {
		mean.mobilised[k] = all->mobilised[k][i] * by;
		mean.dragged[k] = all->dragged[k][i] * by;
		for (int j = 0; j < 2; j++) {
			mean.shears[k][j] = all->shears[k][j][i] * by;
			mean.drags[k][j] = all->drags[k][j][i] * by;
		}
	}
	return mean;
}

/* Adds a column times a row. */
SOIL_INLINED void add_product(const float a[3], float by, const float b[3], float matrix[3][3])
{
	for (int i = 0; i < 3; i++) {
		const float times = a[i] * by;
		matrix[i][0] += times * b[0];
		matrix[i][1] += times * b[1];
		matrix[i][2] += times * b[2];
	}
}

/* How the force at the lanes' places changes with a way, and with a speed, of the surface there: N/m, N s/m. */
struct lane_growths {
	float stiff[3][3][LANES], slow[3][3][LANES], stress[3][LANES];
};

/* Adds what shear along one of the two directions adds to how the stress grows. along: growths with ways, speeds along both. */
SOIL_INLINED void add_along(const struct place *place, int r, float by, const float along[2], float matrix[3][3])
{
	float both[3];
	for (int k = 0; k < 3; k++)
		both[k] = along[0] * place->across[0][k] + along[1] * place->across[1][k];
	add_product(place->across[r], -by, both, matrix);
}

SOIL_INLINED void put_matrix(const float matrix[3][3], int i, float to[3][3][LANES])
{
	for (int k = 0; k < 3; k++) {
		to[k][0][i] = matrix[k][0];
		to[k][1][i] = matrix[k][1];
		to[k][2][i] = matrix[k][2];
	}
}

/* The body's surface rises above a place of the ground by n . motion / n_z. */
SOIL_INLINED void put_growths(const struct soil_form *f, const struct lane_places *all, struct lane_growths *growths)
{
	const float post = f->spacing * f->spacing;
	EACH_LANE {
		const struct place place = mean_of(all, i);
		const float *n = place.normal, area = place.area * post, strength = area * place.strength;
		float shear[3], stress[3], grows[3], stiff[3][3] = {{0}}, slow[3][3] = {{0}};
		stress_at(&place, shear, stress);
		for (int k = 0; k < 3; k++) {
			grows[k] = (n[k] - place.holds * shear[k]) * area;
			growths->stress[k][i] = stress[k];
		}
		add_product(grows, -place.sinks / n[2], n, stiff);
		add_product(grows, -place.damps, n, slow);
		add_along(&place, 0, strength, place.shears[0], stiff);
		add_along(&place, 1, strength, place.shears[1], stiff);
		add_along(&place, 0, area, place.drags[0], slow);
		add_along(&place, 1, area, place.drags[1], slow);
		put_matrix((const float(*)[3])stiff, i, growths->stiff);
		put_matrix((const float(*)[3])slow, i, growths->slow);
	}
}

/* Adds how the normals turn as the body moves, while the place on the ground stays. They turn with the body, and since a body that is not flat shows
 * another part of its surface. Adds also how the arm grows as the surface rises. */
SOIL_INLINED void add_turning(const struct soil_form *f, const struct lane_places *all, struct lane_growths *growths, float matrix[6][6][LANES])
{
	const float post = f->spacing * f->spacing, turns = f->ground_normals > 0 ? 0 : 1;
	EACH_LANE {
		const float by = 1 / most(all->area[i], 1e-30f), area = all->area[i] * post;
		const float n[3] = {all->normal[0][i] * by, all->normal[1][i] * by, either(all->area[i] > 0, all->normal[2][i] * by, 1)};
		const float arm[3] = {all->arm[0][i] * by, all->arm[1][i] * by, all->arm[2][i] * by};
		const float by_up = 1 / n[2], x = n[0] * by_up, y = n[1] * by_up, force = turns * area * n[2] * all->stress[i] * by;
		const float rows[2][3] = {{-x * y * force, (1 + x * x) * force, -y * force}, {(-1 - y * y) * force, x * y * force, x * force}};
		float rise[3];
		growths->stiff[0][0][i] += force * all->bends[0][i] * by;
		growths->stiff[0][1][i] += force * all->bends[1][i] * by;
		growths->stiff[1][0][i] += force * all->bends[1][i] * by;
		growths->stiff[1][1][i] += force * all->bends[2][i] * by;
		cross3(arm, n, rise);
		const float pull_x = growths->stress[0][i] * area * by_up, pull_y = growths->stress[1][i] * area * by_up;
		for (int k = 0; k < 3; k++) {
			matrix[0][3 + k][i] += rows[0][k];
			matrix[1][3 + k][i] += rows[1][k];
			matrix[3][k][i] -= pull_y * n[k];
			matrix[4][k][i] += pull_x * n[k];
			matrix[3][3 + k][i] -= arm[2] * rows[1][k] + pull_y * rise[k];
			matrix[4][3 + k][i] += arm[2] * rows[0][k] + pull_x * rise[k];
			matrix[5][3 + k][i] += arm[0] * rows[1][k] - arm[1] * rows[0][k];
		}
	}
}

/* Adds to a matrix those of the places: [1; S] by_place [1, S'], S the cross product with the arm. Forces, then moments, of motions, then turns. */
SOIL_INLINED void add_placed(const struct lane_places *all, float by_place[3][3][LANES], float matrix[6][6][LANES])
{
	EACH_LANE {
		const float by = 1 / most(all->area[i], 1e-30f), arm[3] = {all->arm[0][i] * by, all->arm[1][i] * by, all->arm[2][i] * by};
		float rows[6][3], turned[3];
		for (int k = 0; k < 3; k++) {
			for (int r = 0; r < 3; r++)
				rows[r][k] = by_place[r][k][i];
			rows[3][k] = arm[1] * rows[2][k] - arm[2] * rows[1][k];
			rows[4][k] = arm[2] * rows[0][k] - arm[0] * rows[2][k];
			rows[5][k] = arm[0] * rows[1][k] - arm[1] * rows[0][k];
		}
		for (int r = 0; r < 6; r++) {
			cross3(arm, rows[r], turned);
			for (int k = 0; k < 3; k++) {
				matrix[r][k][i] += rows[r][k];
				matrix[r][3 + k][i] += turned[k];
			}
		}
	}
}

/* Adds how the part of the cell grows as a side of the body moves over it. side: 0 .. 3: behind, ahead, right, left. */
SOIL_INLINED void add_side(const struct soil_form *f, enum soil_form_kind kind, const float sides[LANES], int side, const struct block *l,
			   const struct lane_places *all, const struct lane_growths *growths, float matrix[6][6][LANES])
{
	const int axis = side / 2;
	const float ahead = side % 2 == 0 ? -1 : 1, edge = ahead * f->half[axis], post = f->spacing * f->spacing;
	if (!any_above(sides, 0))
		return;
	EACH_LANE {
		const float by = 1 / most(all->area[i], 1e-30f), was = all->arm[1][i] * by;
		const float grows = either(sides[i] > 0, ahead * f->by_step * all->area[i] * post / most(l->share[i], 1e-6f), 0);
		float arm[3] = {all->arm[0][i] * by, was, all->arm[2][i] * by}, column[6], row[6] = {0};
		arm[axis] = edge + (axis == 1 ? was - aside_of(f, kind, arm[0], was) : 0);
		/* The side of a cylinder that leans is deeper or less deep than the place. */
		const float deeper = kind == FORM_RIM ? -f->lean * f->lift * (arm[1] - was) * all->sinks[i] * by : 0;
		for (int k = 0; k < 3; k++)
			column[k] = growths->stress[k][i] + deeper * all->normal[k][i] * by;
		row[axis] = grows;
		cross3(arm, column, column + 3);
		cross3(arm, row, row + 3);
		for (int r = 0; r < 6; r++)
			for (int k = 0; k < 6; k++)
				matrix[r][k][i] += column[r] * row[k];
	}
}

/* Adds the figures of a place. area: m2; shear: as stress_at gives it. */
SOIL_INLINED void add_figures(const struct lane_posts *p, int i, const struct place *place, float area, const float shear[3], struct lane_changes *changes)
{
	const float up = place->ground * p->up[i];
	changes->normal_force[i] += area * place->stress;
	changes->shear_limit[i] += area * place->strength;
	for (int k = 0; k < 3; k++)
		changes->sheared[k][i] += area * place->strength * shear[k];
	changes->normal[0][i] -= up * p->rise_x[i];
	changes->normal[1][i] -= up * p->rise_y[i];
	changes->normal[2][i] += up;
}

/* Adds what a probe asks. */
SOIL_INLINED void add_changes(const struct soil_form *f, enum soil_form_kind kind, const struct lane_posts *p, const struct block *l, const struct lane_places *all,
			      struct lane_changes *changes)
{
	struct lane_growths growths;
	const float post = f->spacing * f->spacing;
	put_growths(f, all, &growths);
	EACH_LANE {
		const struct place mean = mean_of(all, i);
		float shear[3], stress[3];
		stress_at(&mean, shear, stress);
		add_figures(p, i, &mean, mean.area * post, shear, changes);
	}
	add_turning(f, all, &growths, changes->stiffness);
	add_placed(all, growths.stiff, changes->stiffness);
	add_placed(all, growths.slow, changes->damping);
	if (kind == FORM_RIM || kind == FORM_BOX) {
		add_side(f, kind, p->side_right, 2, l, all, &growths, changes->stiffness);
		add_side(f, kind, p->side_left, 3, l, all, &growths, changes->stiffness);
	}
	if (kind == FORM_BOX) {
		add_side(f, kind, p->side_behind, 0, l, all, &growths, changes->stiffness);
		add_side(f, kind, p->side_ahead, 1, l, all, &growths, changes->stiffness);
	}
}

/* --- the lower end of a rim --- */

/* Products of columns and rows that are added to the matrices of the lanes: how the normal stress grows, then shear, and damping. */
struct lane_brims {
	float normal[6][LANES], up[6][LANES], along[2][6][LANES]; /* a force along each of these, and its moment */
	float sinks[LANES], damps[LANES], shears[2][2][LANES], drags[2][2][LANES];
};

SOIL_INLINED void put_both(const float arm[3], const float v[3], int i, float both[6][LANES])
{
	float moment[3];
	cross3(arm, v, moment);
	for (int k = 0; k < 3; k++) {
		both[k][i] = v[k];
		both[3 + k][i] = moment[k];
	}
}

/* area: m2 */
SOIL_INLINED void put_brim_lane(const struct lane_posts *p, int i, const struct place *place, float area, struct lane_brims *brims)
{
	const float up[3] = {-p->rise_x[i], -p->rise_y[i], 1};
	put_both(place->arm, place->normal, i, brims->normal);
	put_both(place->arm, up, i, brims->up);
	put_both(place->arm, place->across[0], i, brims->along[0]);
	put_both(place->arm, place->across[1], i, brims->along[1]);
	brims->sinks[i] = -area * place->sinks;
	brims->damps[i] = -area * place->damps;
	for (int j = 0; j < 2; j++)
		for (int k = 0; k < 2; k++) {
			brims->shears[j][k][i] = -area * place->strength * place->shears[j][k];
			brims->drags[j][k][i] = -area * place->drags[j][k];
		}
}

/* Adds the normal's column times a row, and those along the surface. by: of the first; along: of the others. */
SOIL_INLINED void add_outer(const struct lane_brims *brims, float row[6][LANES], const float by[LANES], float along[2][2][LANES], float matrix[6][6][LANES])
{
	for (int r = 0; r < 6; r++)
		for (int k = 0; k < 6; k++)
			EACH_LANE {
				float sum = matrix[r][k][i] + by[i] * brims->normal[r][i] * row[k][i];
				sum += along[0][0][i] * brims->along[0][r][i] * brims->along[0][k][i];
				sum += along[0][1][i] * brims->along[0][r][i] * brims->along[1][k][i];
				sum += along[1][0][i] * brims->along[1][r][i] * brims->along[0][k][i];
				sum += along[1][1][i] * brims->along[1][r][i] * brims->along[1][k][i];
				matrix[r][k][i] = sum;
			}
}

SOIL_INLINED void add_brim_changes(struct lane_brims *brims, struct lane_changes *changes)
{
	add_outer(brims, brims->up, brims->sinks, brims->shears, changes->stiffness);
	add_outer(brims, brims->normal, brims->damps, brims->drags, changes->damping);
}

#endif
