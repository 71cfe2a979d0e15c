/* Adds up what posts bear, and how that changes as the body moves. */
#include "deform/probe/sums.h"

#include <math.h>
#include <string.h>

#include "deform/probe/place.h"

/* A vector at a place, and its moment about the body's centre. */
static void wrench(const double v[3], const double arm[3], double out[6])
{
	memcpy(out, v, 3 * sizeof *v);
	cross(arm, v, out + 3);
}

/* Gives the stress on the body at a place, Pa: of the surface. shear: of its shear, the direction times the share of the strength. */
static void stress_at(const struct probe_place *place, double shear[3], double stress[3])
{
	for (int k = 0; k < 3; k++) {
		shear[k] = place->mobilised[0] * place->across[0][k] + place->mobilised[1] * place->across[1][k];
		stress[k] = place->stress * place->normal[k] - place->strength * shear[k] - place->dragged[0] * place->across[0][k] -
			    place->dragged[1] * place->across[1][k];
	}
}

/* Returns the pull of a belt against the soil's shear at a place, Pa. */
static double pull_at(const struct probe_form *form, const struct probe_place *place, const double stress[3])
{
	double along[3];
	cross(place->normal, form->belt, along);
	return -(stress[0] * along[0] + stress[1] * along[1] + stress[2] * along[2]);
}

static void add_force(const struct probe_form *form, const struct probe_place *place, double post, struct sums *sums)
{
	const double area = place->area * post;
	double shear[3], force[3], column[6];
	stress_at(place, shear, force);
	wrench(force, place->arm, column);
	for (int k = 0; k < 6; k++)
		sums->force[k] += area * column[k];
	for (int k = 0; k < 3; k++)
		sums->sheared[k] += area * place->strength * shear[k];
	sums->pull += area * pull_at(form, place, force);
	sums->normal_force += area * place->stress;
	sums->shear_limit += area * place->strength;
	sums->area += place->ground * post;
}

/* Adds to a matrix that of a place: [1; S] by_place [1, S'], S the cross product with the arm. Forces, then moments, of motions, then turns. */
static void add_placed(const double by_place[3][3], const double arm[3], double matrix[6][6])
{
	double moments[3][3];
	for (int k = 0; k < 3; k++) {
		const double column[3] = {by_place[0][k], by_place[1][k], by_place[2][k]};
		double moment[3];
		cross(arm, column, moment);
		for (int i = 0; i < 3; i++)
			moments[i][k] = moment[i];
	}
	for (int i = 0; i < 3; i++) {
		double turned[3], moment_turned[3];
		cross(arm, by_place[i], turned);
		cross(arm, moments[i], moment_turned);
		for (int k = 0; k < 3; k++) {
			matrix[i][k] += by_place[i][k];
			matrix[i][3 + k] += turned[k];
			matrix[3 + i][k] += moments[i][k];
			matrix[3 + i][3 + k] += moment_turned[k];
		}
	}
}

/* Adds a column times a row. */
static void add_product(const double a[3], double by, const double b[3], double matrix[3][3])
{
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++)
			matrix[i][k] += by * a[i] * b[k];
}

/* Adds how the normals turn as the body moves, while the place on the ground stays. They turn with the body, and a body that is not flat
 * shows another part of its surface. */
static void add_turning(const struct probe_place *place, double area, double by_place[3][3], struct sums *sums)
{
	const double *n = place->normal, x = n[0] / n[2], y = n[1] / n[2], by = area * n[2] * place->stress, *arm = place->arm, *bends = place->bends;
	const double rows[2][3] = {{-x * y * by, (1 + x * x) * by, -y * by}, {(-1 - y * y) * by, x * y * by, x * by}};
	by_place[0][0] += by * bends[0];
	by_place[0][1] += by * bends[1];
	by_place[1][0] += by * bends[1];
	by_place[1][1] += by * bends[2];
	double(*matrix)[6] = sums->stiffness.matrix;
	for (int k = 0; k < 3; k++) {
		matrix[0][3 + k] += rows[0][k];
		matrix[1][3 + k] += rows[1][k];
		matrix[3][3 + k] -= arm[2] * rows[1][k];
		matrix[4][3 + k] += arm[2] * rows[0][k];
		matrix[5][3 + k] += arm[0] * rows[1][k] - arm[1] * rows[0][k];
	}
}

/* Adds how the force at a place changes. */
static void add_changes(const struct probe_form *form, const struct probe_place *place, double area, struct sums *sums)
{
	const double *n = place->normal, by_up = 1 / n[2], less = -area * place->strength;
	double shear[3], force[3], grows[3], row[6], stiff[3][3] = {{0}}, slow[3][3] = {{0}};
	stress_at(place, shear, force);
	for (int k = 0; k < 3; k++)
		grows[k] = (n[k] - place->holds * shear[k]) * area;
	/* The surface rises above a place of the ground by n . motion / n_z. */
	add_product(grows, -place->sinks * by_up, n, stiff);
	add_product(grows, -place->damps, n, slow);
	for (int i = 0; i < 2; i++)
		for (int k = 0; k < 2; k++) {
			add_product(place->across[i], less * place->shears[i][k], place->across[k], stiff);
			add_product(place->across[i], -area * place->drags[i][k], place->across[k], slow);
		}
	if (!form->ground_normals)
		add_turning(place, area, stiff, sums);
	add_placed((const double(*)[3])stiff, place->arm, sums->stiffness.matrix);
	add_placed((const double(*)[3])slow, place->arm, sums->damping.matrix);
	/* The arm grows as the surface rises. */
	wrench(n, place->arm, row);
	for (int k = 0; k < 6; k++) {
		sums->stiffness.matrix[3][k] -= force[1] * area * by_up * row[k];
		sums->stiffness.matrix[4][k] += force[0] * area * by_up * row[k];
	}
}

/* Adds how the part of the cell grows as a side of the body moves over it. */
static void add_sides(const struct probe_form *form, const struct probe_bearing *bearing, const struct probe_place *place, double area,
		      struct sums *sums)
{
	for (int side = 0; side < 4; side++) {
		const int axis = side / 2;
		const double ahead = side % 2 == 0 ? -1 : 1, by = ahead * area * form->by_step / bearing->share;
		if (!bearing->sides[side])
			continue;
		double shear[3], force[3], column[6], row[6], arm[3];
		const double out[3] = {axis == 0 ? by : 0, axis == 1 ? by : 0, 0}, *at = place->arm;
		memcpy(arm, place->arm, sizeof arm);
		arm[axis] = ahead * form->half[axis] + (axis == 1 ? at[1] - probe_aside(form, at) : 0);
		stress_at(place, shear, force);
		wrench(force, arm, column);
		wrench(out, arm, row);
		terms_put(&sums->stiffness, column, row);
	}
}

/* Adds what the lower end of a cylinder bears beside a cell. Its place moves with the body, and bears more where the edge sinks. */
static void add_brim(const struct probe_form *form, const struct probe_place *place, double post, struct sums *sums)
{
	static const double up[3] = {0, 0, 1};
	const double area = place->area * post;
	double column[6], row[6], slower[6], along[2][6], rows[2][6];
	add_force(form, place, post, sums);
	wrench(place->normal, place->arm, column);
	wrench(up, place->arm, row);
	for (int k = 0; k < 6; k++)
		slower[k] = -area * place->damps * column[k];
	terms_put(&sums->damping, slower, column);
	for (int k = 0; k < 6; k++)
		column[k] *= -area * place->sinks;
	terms_put(&sums->stiffness, column, row);
	wrench(place->across[0], place->arm, along[0]);
	wrench(place->across[1], place->arm, along[1]);
	for (int i = 0; i < 2; i++) {
		for (int k = 0; k < 6; k++) {
			rows[0][k] = -area * place->strength * (place->shears[i][0] * along[0][k] + place->shears[i][1] * along[1][k]);
			rows[1][k] = -area * (place->drags[i][0] * along[0][k] + place->drags[i][1] * along[1][k]);
		}
		terms_put(&sums->stiffness, along[i], rows[0]);
		terms_put(&sums->damping, along[i], rows[1]);
	}
}

/* Gives the mean of a post's places, by area. Returns their area, posts. */
static double mean_of(const struct probe_bearing *bearing, struct probe_place *mean)
{
	const struct probe_place *a = &bearing->places[0], *b = &bearing->places[1];
	_Static_assert(sizeof *mean % sizeof(double) == 0, "a place has nothing but doubles");
	if (bearing->count == 1) {
		*mean = *a;
		return a->area;
	}
	const double area = a->area + b->area, of_b = b->area / area, of_a = 1 - of_b;
	const double *from_a = (const double *)a, *from_b = (const double *)b;
	double *to = (double *)mean;
	for (size_t i = 0; i < sizeof *mean / sizeof *to; i++)
		to[i] = of_a * from_a[i] + of_b * from_b[i];
	return area;
}

void deform_sums_add(const struct probe_law *law, const struct probe_post *ground, const struct probe_bearing *bearing, struct sums *sums)
{
	const struct probe_form *form = law->form;
	const double post = form->spacing * form->spacing;
	struct probe_place mean;
	double bears = 0;
	for (int i = 0; i < bearing->count; i++) {
		add_force(form, &bearing->places[i], post, sums);
		bears += bearing->places[i].ground;
	}
	if (bears > 0) {
		const double area = mean_of(bearing, &mean) * post;
		add_changes(form, &mean, area, sums);
		add_sides(form, bearing, &mean, area, sums);
	}
	if (bearing->has_brim) {
		add_brim(form, &bearing->brim, post, sums);
		bears += bearing->brim.ground;
	}
	sums->normal[0] -= bears * ground->up * ground->rise[0];
	sums->normal[1] -= bears * ground->up * ground->rise[1];
	sums->normal[2] += bears * ground->up;
	sums->sinkage = fmax(sums->sinkage, bearing->sinkage);
}
