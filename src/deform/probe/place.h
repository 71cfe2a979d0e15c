/*
 * The formulas of the soil's law at one place: stress and strength of the soil, how a surface slides, damping. The same as
 * shaders/lib/scm_post.glsl, which says what each part is for. Here they also give how the force changes with the body's place and velocity.
 *
 * Loops over lanes inline them, so none has a branch with a side effect: both sides of a choice are computed.
 */
#ifndef FURROW_DEFORM_PROBE_PLACE_H
#define FURROW_DEFORM_PROBE_PLACE_H

#include "deform/probe/face.h"
#include "deform/probe/lanes.h"
#include "deform/probe/law.h"
#include "deform/probe/powers.h"

#define PROBE_UNIT 0x1p-20          /* m: a fixed-point unit */
#define PROBE_LEAST 1.2e-6          /* m: rounding to fixed-point units */
#define PROBE_STRESS_MOST 1e20      /* Pa */
/* At rest a body would rock and slide to and fro for long, since soil springs back without loss. So what moves slower than these is damped more. */
#define PROBE_STICKS 0.003          /* m/s along a surface: by the soil's own damping */
#define PROBE_SETTLES 0.002         /* m/s across it: by PROBE_SETTLING times as much */
#define PROBE_SETTLING 10.0

/* The soil of a post. k: k_c / b + k_phi, N/m^(n+2); b: the width of the contact patch. Others as in struct probe_soil. */
struct place_soil {
	double k, n, elastic, by_elastic, cohesion, tan_phi, modulus, by_modulus, damping;
};

static inline struct place_soil soil_of(const struct lanes *l, int i)
{
	return (struct place_soil){l->k[i], l->n[i], l->elastic[i], l->by_elastic[i], l->cohesion[i], l->tan_phi[i], l->modulus[i], l->by_modulus[i], l->damping[i]};
}

/* Returns for which share of the motion the body's surface has been at a post. */
static inline double lasted_of(const struct lanes *l, int i)
{
	return probe_least(l->passed[i], probe_either(l->over[i] > 0, 1, INFINITY));
}

/* Returns how far grousers are below the lower envelope of a body at a post, m above it. */
static inline double above_of(const struct lanes *l, int i)
{
	return probe_either(l->over[i] > 0, l->rests[i] - l->face.height[i], 0);
}

/* The soil at one place, in the body's frame. Amounts are those of the place's share of a post's area. */
struct probe_place {
	double arm[3], normal[3]; /* m from the body's centre; unit, of the stresses */
	double across[2][3];      /* two unit vectors along the surface: forwards, and to the left */
	double area;              /* of the surface, posts */
	double ground;            /* area of the ground that bears, in posts */
	double stress, strength;  /* Pa: normal, with damping; the most that shear can be */
	double mobilised[2];      /* shear along `across`, as a share of the strength */
	double holds;             /* growth of the strength with the normal stress */
	double sinks;             /* Pa/m: growth of the normal stress as the body's surface goes down by a metre */
	double damps;             /* Pa s/m: growth of the normal stress with the speed along the normal */
	double shears[2][2];      /* 1/m: how `mobilised` grows with a way along `across` */
	double dragged[2];        /* Pa: shear stress of damping along `across` */
	double drags[2][2];       /* Pa s/m: growth of that with the speed along `across` */
	double bends[3];          /* 1/m: second derivatives of the surface's height: xx, xy, yy */
};

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

/* --- the soil --- */

static inline double yield_stress(const struct place_soil *s, double z)
{
	const double yields = s->k * probe_pow(probe_most(z, PROBE_UNIT), s->n);
	const double least = probe_least(probe_least(yields, z * s->elastic), PROBE_STRESS_MOST);
	return probe_either(z > 0, least, 0);
}

static inline double yield_growth(const struct place_soil *s, double yields, double z)
{
	const double flows = yields * s->n / probe_most(z, PROBE_UNIT);
	return probe_either(yields >= 0.9999999 * s->elastic * z, s->elastic, flows);
}

static inline double plastic_part(const struct place_soil *s, double z, double yields)
{
	return probe_most(z - yields * s->by_elastic, 0);
}

static inline double plastic_of(const struct place_soil *s, double z)
{
	return plastic_part(s, z, yield_stress(s, z));
}

/* Returns the shear strength under a normal stress, and its growth with that. */
static inline double strength_of(const struct probe_law *law, const struct place_soil *s, double stress, double *grows)
{
	const double adhesion = probe_either(law->own[0] > 0, s->cohesion, law->surface[0]), tangent = probe_either(law->own[1] > 0, s->tan_phi, law->surface[1]);
	const double soil = s->cohesion + s->tan_phi * stress, along = adhesion + tangent * stress;
	*grows = probe_either(soil <= along, s->tan_phi, tangent);
	return probe_least(soil, along);
}

static inline double stays_after(double way)
{
	return probe_exp_minus(probe_least(way, 100));
}

/* --- along the surface --- */

static inline void normal_at(const struct probe_form *form, const double rise[2], double up, const double face[3], double normal[3])
{
	normal[0] = probe_either(form->ground_normals > 0, -rise[0] * up, face[0]);
	normal[1] = probe_either(form->ground_normals > 0, -rise[1] * up, face[1]);
	normal[2] = probe_either(form->ground_normals > 0, up, face[2]);
}

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

/* Gives how a body's surface moves at a place, along `across`. The body moves by a way and a turn, and a belt runs; or these are rates. */
static inline void moved_along(const struct probe_form *form, const double way[3], const double turns[3], double ran, const double arm[3],
			       const double normal[3], double across[2][3], double along[2])
{
	double moved[3], belt[3];
	cross(turns, arm, moved);
	cross(normal, form->belt, belt);
	for (int k = 0; k < 3; k++)
		moved[k] += way[k] + ran * belt[k];
	along[0] = dot(moved, across[0]);
	along[1] = dot(moved, across[1]);
}

struct slip {
	double direction[2], size; /* along the surface; m */
};

static inline struct slip slip_at(const struct probe_form *form, const double arm[3], const double normal[3], double across[2][3])
{
	double along[2];
	moved_along(form, form->way, form->spin, form->ran, arm, normal, across, along);
	const double squares = along[0] * along[0] + along[1] * along[1], by = 1 / sqrt(probe_most(squares, 1e-24));
	return (struct slip){{along[0] * by, along[1] * by}, squares * by};
}

/* Returns how long a rim, or a belt, is above a place, of the soil's time. up: z of the surface's normal. */
static inline double rim_time(const struct probe_form *form, double up)
{
	const double time = form->rim * form->level / up;
	return probe_either(form->rim > 0, time, 1);
}

/* Gives how `mobilised` grows with a way of the surface: `shears` of the place. touching: the way since it touches, in units of the shear
 * modulus; stays: stays_after(touching); rim: the rim's time. */
static inline void put_shears(const struct slip *slip, double by_modulus, double touching, double stays, double rim, struct probe_place *place)
{
	const double turning = (1 - stays) / probe_most(slip->size, 1e-9), aside = probe_either(touching > 0, turning, 0);
	const double along[2] = {slip->direction[0] * by_modulus * rim, slip->direction[1] * by_modulus * rim};
	const bool slides = slip->size > 1e-9; /* else it begins to slide: half as stiff on, and half as much stiffer back */
	for (int i = 0; i < 2; i++)
		for (int k = 0; k < 2; k++) {
			const double grows = (slip->direction[i] - place->mobilised[i]) * along[k] + ((i == k) - slip->direction[i] * slip->direction[k]) * aside;
			place->shears[i][k] = probe_either(slides, grows, i == k ? by_modulus : 0);
		}
}

/* --- damping --- */

/* How a damping that is for slow motion alone fades. squares: of the speed, as a share of the speed at which it is halved. */
static inline double fade(double squares)
{
	return 1 / (1 + squares);
}

/* Returns how the stress of such a damping grows with the speed, where `fades` is what fade returned; 0 where it falls. */
static inline double fade_slope(double fades)
{
	return fades * probe_most(2 * fades - 1, 0);
}

/* Adds damping to a place: of soil that is pushed down fast, and of a surface that hardly slides. damping: Pa s/m, what counts of the soil's. */
static inline void put_rates(const struct probe_form *form, double damping, struct probe_place *place)
{
	double moves[3], along[2];
	cross(form->rolls, place->arm, moves);
	const double down = -(dot(form->linear, place->normal) + dot(moves, place->normal));
	const double slow = fade(down * down / (PROBE_SETTLES * PROBE_SETTLES)), settles = PROBE_SETTLING * damping, damps = probe_either(down >= 0, damping, 0);
	place->stress = probe_most(place->stress + (damps + settles * slow) * down, 0);
	place->damps = damps + settles * fade_slope(slow);
	moved_along(form, form->linear, form->turns, form->runs, place->arm, place->normal, place->across, along);
	const double squares = along[0] * along[0] + along[1] * along[1], fades = fade(squares / (PROBE_STICKS * PROBE_STICKS));
	const double sticks = damping * fades, falls = damping * (fades - fade_slope(fades)) / probe_most(squares, 1e-300), less = probe_either(squares > 0, falls, 0);
	/* It grows less along the way of the surface than across it. */
	for (int i = 0; i < 2; i++) {
		place->dragged[i] = sticks * along[i];
		for (int k = 0; k < 2; k++)
			place->drags[i][k] = (i == k ? sticks : 0) - less * along[i] * along[k];
	}
}

/* --- a line across the cell --- */

/* Returns the place on the line, -1 .. 1, beyond which a parabola through three depths, at -1, 0 and 1, is above 0. sign: the side from
 * which it is looked for. */
static inline double root_from(double sign, const double depths[3])
{
	const double bends = 0.5 * (depths[0] + depths[2]) - depths[1], rises = 0.5 * (depths[2] - depths[0]), over = depths[1];
	const double root = rises * rises - 4 * bends * over, by = sqrt(probe_most(root, 0)) - sign * rises;
	const bool touches = (bends < 0) & (root <= 0);
	const double top = -0.5 * rises / probe_least(bends, -1e-18), side = sign * 2 * over / probe_most(by, 1e-15), at = probe_either(touches, top, side);
	const double misses = 4 * bends * PROBE_LEAST;
	const bool never = (root < probe_either(touches, misses, 0)) | ((by <= 0) & !touches);
	const double found = probe_either(never, -sign, probe_clamp(at, -1, 1));
	return probe_either(depths[sign < 0 ? 0 : 2] > 0, sign, found);
}

#endif
