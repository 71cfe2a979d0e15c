/* Adds up what posts bear, and how that changes as the body moves. */
#include "deform/probe/sums.h"

#include <math.h>
#include <string.h>

#include "deform/probe/brim.h"
#include "deform/probe/places.h"

/* What the posts of a batch bear: means over their places, by area. Posts that do not bear have area 0. */
struct lane_bearings {
	double area[LANES], ground[LANES];         /* m2: of the surface; posts: of the ground */
	double arm[3][LANES], stress[3][LANES];    /* m, Pa */
	double deeper[3][LANES];                   /* Pa/m: how the stress grows as the surface goes down by a metre */
};

/* Adds the force at a place to the sums of lane i. weight: its area, m2. */
static inline void add_force(const struct probe_form *form, const struct probe_place *place, double weight, int i, struct sums *sums)
{
	double shear[3], stress[3], moment[3], belt[3];
	stress_at(place, shear, stress);
	cross(place->arm, stress, moment);
	cross(place->normal, form->belt, belt);
	for (int k = 0; k < 3; k++) {
		sums->force[k][i] += weight * stress[k];
		sums->force[3 + k][i] += weight * moment[k];
		sums->sheared[k][i] += weight * place->strength * shear[k];
	}
	sums->pull[i] -= weight * dot(stress, belt);
	sums->normal_force[i] += weight * place->stress;
	sums->shear_limit[i] += weight * place->strength;
}

/* Returns the mean of two places, by area. Without any it has area 0, and a level surface. */
LANES_INLINED static inline struct probe_place mean_of(const struct probe_place *a, const struct probe_place *b)
{
	const double area = a->area + b->area, by = 1 / probe_most(area, 1e-30), of_a = a->area * by, of_b = b->area * by;
	struct probe_place mean = {.area = area, .ground = a->ground + b->ground};
	for (int k = 0; k < 3; k++) {
		mean.arm[k] = of_a * a->arm[k] + of_b * b->arm[k];
		mean.normal[k] = of_a * a->normal[k] + of_b * b->normal[k];
		mean.across[0][k] = of_a * a->across[0][k] + of_b * b->across[0][k];
		mean.across[1][k] = of_a * a->across[1][k] + of_b * b->across[1][k];
		mean.bends[k] = of_a * a->bends[k] + of_b * b->bends[k];
	}
	mean.normal[2] = probe_either(area > 0, mean.normal[2], 1);
	mean.stress = of_a * a->stress + of_b * b->stress;
	mean.strength = of_a * a->strength + of_b * b->strength;
	mean.holds = of_a * a->holds + of_b * b->holds;
	mean.sinks = of_a * a->sinks + of_b * b->sinks;
	mean.damps = of_a * a->damps + of_b * b->damps;
	for (int k = 0; k < 2; k++) {
		mean.mobilised[k] = of_a * a->mobilised[k] + of_b * b->mobilised[k];
		mean.dragged[k] = of_a * a->dragged[k] + of_b * b->dragged[k];
		for (int j = 0; j < 2; j++) {
			mean.shears[k][j] = of_a * a->shears[k][j] + of_b * b->shears[k][j];
			mean.drags[k][j] = of_a * a->drags[k][j] + of_b * b->drags[k][j];
		}
	}
	return mean;
}

/* --- how the force changes --- */

/* Adds a column times a row. */
LANES_INLINED static inline void add_product(const double a[3], double by, const double b[3], double matrix[3][3])
{
	for (int i = 0; i < 3; i++) {
		const double times = a[i] * by;
		for (int k = 0; k < 3; k++)
			matrix[i][k] += times * b[k];
	}
}

/* Gives how the stress at a place, times its area, changes with the way and the speed of the surface there. */
LANES_INLINED static inline void changes_at(const struct probe_place *place, double area, double stress[3], double stiff[3][3], double slow[3][3])
{
	const double *n = place->normal;
	double shear[3], grows[3];
	stress_at(place, shear, stress);
	for (int k = 0; k < 3; k++)
		grows[k] = (n[k] - place->holds * shear[k]) * area;
	/* The surface rises above a place of the ground by n . motion / n_z. */
	add_product(grows, -place->sinks / n[2], n, stiff);
	add_product(grows, -place->damps, n, slow);
	for (int i = 0; i < 2; i++) {
		double shears[3], drags[3];
		for (int k = 0; k < 3; k++) {
			shears[k] = place->shears[i][0] * place->across[0][k] + place->shears[i][1] * place->across[1][k];
			drags[k] = place->drags[i][0] * place->across[0][k] + place->drags[i][1] * place->across[1][k];
		}
		add_product(place->across[i], -area * place->strength, shears, stiff);
		add_product(place->across[i], -area, drags, slow);
	}
}

/* Adds to one row of a 6 x 6 matrix: three columns for motions, three for turns. */
LANES_INLINED static inline void add_row(double row[6][LANES], int i, const double motion[3], const double turn[3])
{
	for (int k = 0; k < 3; k++) {
		row[k][i] += motion[k];
		row[3 + k][i] += turn[k];
	}
}

/* Adds to a matrix that of a place: [1; S] by_place [1, S'], S the cross product with the arm. Forces, then moments, of motions, then turns. */
LANES_INLINED static inline void add_placed(double by_place[3][3], const double arm[3], int i, struct lane_matrix *matrix)
{
	double moments[3][3], turned[3];
	for (int k = 0; k < 3; k++) {
		moments[0][k] = arm[1] * by_place[2][k] - arm[2] * by_place[1][k];
		moments[1][k] = arm[2] * by_place[0][k] - arm[0] * by_place[2][k];
		moments[2][k] = arm[0] * by_place[1][k] - arm[1] * by_place[0][k];
	}
	for (int k = 0; k < 3; k++) {
		cross(arm, by_place[k], turned);
		add_row(matrix->at[k], i, by_place[k], turned);
		cross(arm, moments[k], turned);
		add_row(matrix->at[3 + k], i, moments[k], turned);
	}
}

/* Adds how the normals turn as the body moves, while the place on the ground stays. They turn with the body, and a body that is not flat
 * shows another part of its surface. */
LANES_INLINED static inline void add_turning(const struct probe_place *place, double area, double by_place[3][3], int i, struct lane_matrix *matrix)
{
	const double *n = place->normal, by_up = 1 / n[2], x = n[0] * by_up, y = n[1] * by_up, by = area * n[2] * place->stress;
	const double *arm = place->arm, *bends = place->bends;
	const double rows[2][3] = {{-x * y * by, (1 + x * x) * by, -y * by}, {(-1 - y * y) * by, x * y * by, x * by}};
	by_place[0][0] += by * bends[0];
	by_place[0][1] += by * bends[1];
	by_place[1][0] += by * bends[1];
	by_place[1][1] += by * bends[2];
	for (int k = 0; k < 3; k++) {
		matrix->at[0][3 + k][i] += rows[0][k];
		matrix->at[1][3 + k][i] += rows[1][k];
		matrix->at[3][3 + k][i] -= arm[2] * rows[1][k];
		matrix->at[4][3 + k][i] += arm[2] * rows[0][k];
		matrix->at[5][3 + k][i] += arm[0] * rows[1][k] - arm[1] * rows[0][k];
	}
}

/* Adds how the force at a place changes. area: m2. stress: as stress_at gives it. */
LANES_INLINED static inline void add_changes(const struct probe_form *form, const struct probe_place *place, double area, int i, double stress[3],
					     struct sums *sums)
{
	double rise[3], stiff[3][3] = {{0}}, slow[3][3] = {{0}};
	changes_at(place, area, stress, stiff, slow);
	add_turning(place, probe_either(form->ground_normals > 0, 0, area), stiff, i, &sums->stiffness);
	add_placed(stiff, place->arm, i, &sums->stiffness);
	add_placed(slow, place->arm, i, &sums->damping);
	/* The arm grows as the surface rises. */
	cross(place->arm, place->normal, rise);
	const double by = area / place->normal[2];
	for (int k = 0; k < 3; k++) {
		sums->stiffness.at[3][k][i] -= stress[1] * by * place->normal[k];
		sums->stiffness.at[3][3 + k][i] -= stress[1] * by * rise[k];
		sums->stiffness.at[4][k][i] += stress[0] * by * place->normal[k];
		sums->stiffness.at[4][3 + k][i] += stress[0] * by * rise[k];
	}
}

LANES_CLONED static void add_places(const struct probe_law *restrict law, const struct lanes *restrict l, const struct lane_spots *restrict first,
				    const struct lane_spots *restrict second, struct lane_bearings *restrict bearings, struct sums *restrict sums)
{
	const double post = law->form.spacing * law->form.spacing;
	for (int i = 0; i < LANES; i++) {
		struct probe_place a, b;
		double stress[3];
		put_place(law, l, first, i, &a);
		put_place(law, l, second, i, &b);
		add_force(&law->form, &a, a.area * post, i, sums);
		add_force(&law->form, &b, b.area * post, i, sums);
		const struct probe_place mean = mean_of(&a, &b);
		add_changes(&law->form, &mean, mean.area * post, i, stress, sums);
		bearings->area[i] = mean.area * post;
		bearings->ground[i] = mean.ground;
		for (int k = 0; k < 3; k++) {
			bearings->arm[k][i] = mean.arm[k];
			bearings->stress[k][i] = stress[k];
			bearings->deeper[k][i] = mean.sinks * mean.normal[k];
		}
	}
}

/* Adds how the part of the cell grows as a side of the body moves over it. side: 0 .. 3: behind, ahead, right, left. */
static void add_side(const struct probe_form *form, const struct lanes *l, const struct lane_bearings *bearings, int side, struct sums *sums)
{
	const int axis = side / 2;
	const double ahead = side % 2 == 0 ? -1 : 1, by_step = ahead * form->by_step, edge = ahead * form->half[axis];
	for (int i = 0; i < LANES; i++) {
		if (l->sides[side][i] == 0 || bearings->area[i] == 0)
			continue;
		const double by = by_step * bearings->area[i] / l->share[i];
		double column[6], row[6] = {0}, arm[3];
		for (int k = 0; k < 3; k++) {
			arm[k] = bearings->arm[k][i];
			column[k] = bearings->stress[k][i];
		}
		arm[axis] = edge + (axis == 1 ? arm[1] - probe_aside(form, arm) : 0);
		/* The side of a cylinder that leans is deeper or less deep than the cell's middle. */
		const double deeper = probe_strips(form) ? -form->lean * form->lift * (arm[1] - bearings->arm[1][i]) : 0;
		for (int k = 0; k < 3; k++)
			column[k] += deeper * bearings->deeper[k][i];
		row[axis] = by;
		cross(arm, column, column + 3);
		cross(arm, row, row + 3);
		for (int r = 0; r < 6; r++)
			for (int k = 0; k < 6; k++)
				sums->stiffness.at[r][k][i] += column[r] * row[k];
	}
}

/* --- the lower end of a cylinder --- */

/* Adds what it bears beside a cell. Its place moves with the body, and bears more where the edge sinks below the ground. rise: of the ground. */
static void add_brim(const struct probe_form *form, const struct probe_place *place, const double rise[2], int i, struct sums *sums)
{
	const double up[3] = {-rise[0], -rise[1], 1};
	const double area = place->area * form->spacing * form->spacing;
	double column[6], row[6];
	add_force(form, place, area, i, sums);
	memcpy(column, place->normal, sizeof place->normal);
	cross(place->arm, place->normal, column + 3);
	memcpy(row, up, sizeof up);
	cross(place->arm, up, row + 3);
	for (int r = 0; r < 6; r++)
		for (int k = 0; k < 6; k++) {
			sums->damping.at[r][k][i] -= area * place->damps * column[r] * column[k];
			sums->stiffness.at[r][k][i] -= area * place->sinks * column[r] * row[k];
		}
	double along[2][6];
	for (int k = 0; k < 2; k++) {
		memcpy(along[k], place->across[k], sizeof place->across[k]);
		cross(place->arm, place->across[k], along[k] + 3);
	}
	for (int j = 0; j < 2; j++)
		for (int r = 0; r < 6; r++)
			for (int k = 0; k < 6; k++) {
				const double shears = place->shears[j][0] * along[0][k] + place->shears[j][1] * along[1][k];
				sums->stiffness.at[r][k][i] -= along[j][r] * area * place->strength * shears;
				sums->damping.at[r][k][i] -= along[j][r] * area * (place->drags[j][0] * along[0][k] + place->drags[j][1] * along[1][k]);
			}
}

static void add_brims(const struct probe_law *law, const struct lanes *l, struct lane_bearings *bearings, struct sums *sums)
{
	const int side = law->form.lean < 0 ? 3 : 2;
	for (int i = 0; i < LANES; i++) {
		struct probe_place brim;
		if (l->share[i] == 0 || l->sides[side][i] == 0 || !deform_brim_at(law, l, i, &brim))
			continue;
		add_brim(&law->form, &brim, (const double[]){l->rise[0][i], l->rise[1][i]}, i, sums);
		bearings->ground[i] += brim.ground;
	}
}

LANES_CLONED void deform_sums_add(const struct probe_law *restrict law, const struct lanes *restrict l, struct sums *restrict sums)
{
	static const double shares[2] = {-0.57735026918962573, 0.57735026918962573}; /* of Gauss's formula with two points */
	const struct probe_form *form = &law->form;
	const double post = form->spacing * form->spacing;
	struct lane_spots spots[2];
	struct lane_bearings bearings;
	for (int k = 0; k < 2; k++)
		deform_places_put(form, l, shares[k], &spots[k]);
	add_places(law, l, &spots[0], &spots[1], &bearings, sums);
	for (int side = 0; side < 4; side++)
		if (form->half[side / 2] > 0)
			add_side(form, l, &bearings, side, sums);
	if (probe_strips(form))
		add_brims(law, l, &bearings, sums);
	for (int i = 0; i < LANES; i++) {
		const double bears = bearings.ground[i], up = bears * l->up[i], sinkage = l->base[i] - l->rests[i];
		sums->normal[0][i] -= up * l->rise[0][i];
		sums->normal[1][i] -= up * l->rise[1][i];
		sums->normal[2][i] += up;
		sums->area[i] += bears * post;
		sums->sinkage[i] = probe_most(sums->sinkage[i], probe_either(bears * l->over[i] > 0, sinkage, 0));
	}
}
