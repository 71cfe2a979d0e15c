/* A post while a probe computes it, and the formulas of its places: the soil's stress and strength, and how a surface slides. */
#ifndef FURROW_DEFORM_PROBE_PLACE_H
#define FURROW_DEFORM_PROBE_PLACE_H

#include "deform/probe/face.h"
#include "deform/probe/law.h"

#define PROBE_UNIT 0x1p-20          /* m: a fixed-point unit */
#define PROBE_LEAST 1.2e-6          /* m: rounding to fixed-point units */
#define PROBE_STRESS_MOST 1e20      /* Pa */
/* --- the soil --- */

static inline double yield_stress(const struct probe_law *law, const struct probe_soil *s, double z)
{
	if (!(z > 0))
		return 0;
	const double k = probe_most(s->k_c * law->by_width + s->k_phi, 0);
	return probe_least(probe_least(k * pow(probe_most(z, PROBE_UNIT), s->n), z * s->elastic), PROBE_STRESS_MOST);
}

static inline double yield_growth(const struct probe_soil *s, double yields, double z)
{
	return yields >= 0.9999999 * s->elastic * z ? s->elastic : yields * s->n / probe_most(z, PROBE_UNIT);
}

static inline double plastic_part(const struct probe_soil *s, double z, double yields)
{
	return probe_most(0, z - yields * s->by_elastic);
}

static inline double plastic_of(const struct probe_law *law, const struct probe_soil *s, double z)
{
	return plastic_part(s, z, yield_stress(law, s, z));
}

/* Returns the shear strength under a normal stress, and its growth with that. */
static inline double strength_of(const struct probe_law *law, const struct probe_soil *s, double stress, double *grows)
{
	const double adhesion = law->own[0] ? s->cohesion : law->surface[0], tangent = law->own[1] ? s->tan_phi : law->surface[1];
	const double soil = s->cohesion + s->tan_phi * stress, along = adhesion + tangent * stress;
	*grows = soil <= along ? s->tan_phi : tangent;
	return probe_least(soil, along);
}

static inline double stays_after(double way)
{
	return exp(-probe_least(way, 100));
}

/* --- along the surface --- */

/* Two unit vectors along a surface: where the shortest rotation that makes the surface level has the axes of the frame. */
static inline void put_across(const double n[3], double across[2][3])
{
	const double by = 1 / (1 + n[2]);
	across[0][0] = 1 - n[0] * n[0] * by;
	across[0][1] = across[1][0] = -n[0] * n[1] * by;
	across[0][2] = -n[0];
	across[1][1] = 1 - n[1] * n[1] * by;
	across[1][2] = -n[1];
}

static inline double dot(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void cross(const double a[3], const double b[3], double out[3])
{
	out[0] = a[1] * b[2] - a[2] * b[1];
	out[1] = a[2] * b[0] - a[0] * b[2];
	out[2] = a[0] * b[1] - a[1] * b[0];
}

struct slip {
	double direction[2], size; /* along the surface; m */
};

/* Adds what a belt that ran so far, or runs so fast, moves the surface with this normal. */
static inline void add_belt(const struct probe_form *form, const double normal[3], double run, double to[3])
{
	double along[3];
	cross(normal, form->belt, along);
	for (int k = 0; k < 3; k++)
		to[k] += run * along[k];
}

static inline struct slip slip_at(const struct probe_form *form, const double arm[3], double across[2][3])
{
	double way[3];
	cross(form->spin, arm, way);
	for (int k = 0; k < 3; k++)
		way[k] += form->way[k];
	if (form->ran != 0) {
		double normal[3];
		cross(across[0], across[1], normal);
		add_belt(form, normal, form->ran, way);
	}
	const double along[2] = {dot(way, across[0]), dot(way, across[1])}, squares = along[0] * along[0] + along[1] * along[1];
	const double by = 1 / sqrt(probe_most(squares, 1e-24));
	return (struct slip){{along[0] * by, along[1] * by}, squares * by};
}

static inline void normal_at(const struct probe_form *form, const double rise[2], double up, const struct probe_face *face, double normal[3])
{
	for (int k = 0; k < 3; k++)
		normal[k] = !form->ground_normals ? face->normal[k] : k < 2 ? -rise[k] * up : up;
}

/* --- a line across the cell --- */

/* Returns the place on the line, -1 .. 1, beyond which a parabola through three depths, at -1, 0 and 1, is above 0. sign: the side from
 * which it is looked for. */
static inline double root_from(double sign, const double depths[3])
{
	const double bends = 0.5 * (depths[0] + depths[2]) - depths[1], rises = 0.5 * (depths[2] - depths[0]), over = depths[1];
	const double root = rises * rises - 4 * bends * over, by = sqrt(probe_most(root, 0)) - sign * rises;
	const bool touches = bends < 0 && root <= 0;
	const double at = touches ? -0.5 * rises / probe_least(bends, -1e-18) : sign * 2 * over / probe_most(by, 1e-15);
	const bool never = root < (touches ? 4 * bends * PROBE_LEAST : 0) || (by <= 0 && !touches);
	return depths[sign < 0 ? 0 : 2] > 0 ? sign : never ? -sign : probe_clamp(at, -1, 1);
}

/* --- the post --- */

/* A post while it is computed. Heights and depths are in metres, in the body's frame. */
struct post {
	const struct probe_law *law;
	const struct probe_form *form;
	const struct probe_post *ground;
	const struct probe_soil *soil;
	double at[2], rise[2], own[2];
	double height;              /* of the ground above the body's centre */
	bool over;
	double rests, lowest;       /* of the lower envelope */
	struct probe_face face;     /* at the post */
	double depth;               /* of the end pose below the ground */
	double was, excess;         /* the largest sinkage before, along the normal; how much deeper poses since then were, vertically */
	double shear[2];            /* before */
	double slides, since, share, lasts;
	double stamped, lowered, back;
	double printed;             /* how much of what it remembers has the shape that the lower envelope had at the contact's start, */
	double print_height;        /* whose height was this at the post */
};

/* Gives how `mobilised` grows with a way of the surface: `shears` of the place. touching: the way since it touches, in units of the shear
 * modulus; stays: stays_after(touching); rim: the rim's time, of the soil's. */
void deform_place_shears(const struct post *p, const struct slip *slip, double touching, double stays, double rim, struct probe_place *place);
/* Adds damping to a place: of soil that is pushed down fast, and of a surface that hardly slides. */
void deform_place_rates(const struct post *p, double factor, struct probe_place *place);
/* Computes what the lower end of a cylinder that leans bears beside a cell. middle: of the line across the cell; height: of the ground there.
 * Returns false if it bears nothing. */
bool deform_place_brim(const struct post *p, const double middle[2], double height, struct probe_place *place);

#endif
