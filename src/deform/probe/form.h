/*
 * A body as a probe sees it, in doubles. It has a lower envelope at any place, and a motion since the last contact. It covers parts of
 * the posts' cells. The same formulas as shaders/lib/scm_body.glsl, which says what each of them is for.
 *
 * Places are in metres from the body's centre, in the body's frame: x forwards, y to its left, both level. Heights are above the centre.
 */
#ifndef FURROW_DEFORM_PROBE_FORM_H
#define FURROW_DEFORM_PROBE_FORM_H

#include <math.h>

#include "deform/deform.h"
#include "soil/shape/lower_envelope.h"

#define PROBE_STEEPEST 19.974984 /* lib/soil.glsl: the steepest slope, */
#define PROBE_UPRIGHT 0.05       /* and the z of its unit normal */
#define PROBE_BESIDE 2e-9        /* m: places that are rounded differently by the GPU's whole numbers */

/* The lower envelope of triangles at the posts of a patch, m above the centre; INFINITY: the body is not above the post. NULL: there are none. */
struct probe_low {
	double *rests, *lowest; /* in the end pose, and during the motion */
	size_t width;           /* posts in a row of the patch */
};

struct probe_form {
	enum soil_shape_kind kind; /* the form it is computed as: a wheel with camber is a cylinder (soil_kind_in) */
	bool wheel;             /* it turns about an axle */
	double radius;          /* wheel, sphere, cylinder, capsule; of other shapes: of a sphere around the body */
	double outer;           /* wheel: with its grousers */
	double by_radius;
	double half[2];         /* half of its length and of its width, seen from above; 0: whole posts bear */
	double axis[2];         /* the frame's x axis: east, north */
	double spacing;
	double half_across;     /* half the length of a line across a cell */
	double step_aside, by_step;
	/* Its circles: upright planes along the motion cut it in circles (ring), `lift` times as high, and sheared. */
	double run, rise, sine; /* way forwards; rise for each metre, less the shear; sine of that slope of the circle */
	double plunge;          /* how far the circle moved up, in units of `lift` */
	double lift;
	double rim;             /* how long a wheel's rim or a belt takes, of the soil's time; 0: 1 */
	double way[3], spin[3]; /* its motion since the last contact: m; rad */
	double by_way[2];
	double moved;           /* 0: it stood still; 1: it moved over half a cell */
	double stamps;          /* 1: the hollow that it left has its shape; 0: it is a flat rut */
	double slip, dig_most;  /* how far it slips; how deep that digs at most, in units of the shear modulus */
	double faces[3][3];     /* box: lower faces: height at the centre, slope along the frame's axes */
	double lean, level;     /* the axis' rise (wheel, cylinder: towards the left), and its length in plan */
	double half_axis;       /* half the length of its straight part */
	double along[2];        /* capsule: the axis in plan */
	/* Ellipsoid: height = tilt . at - drop sqrt(1 - squares), squares = ahead_by (x + skew y)^2 + aside_by y^2 <= (shrinks |at|)^2 */
	double tilt[2], drop, ahead_by, skew, aside_by, shrinks;
	struct soil_shape smooth;   /* without grousers */
	struct lower_envelope lower;  /* of `smooth`; points to it, so a form is not copied */
	struct probe_low low;         /* mesh; grousers of a wheel */
	double cut[2][2];       /* from a post to the next, along the lattice's axis that is nearest to the frame's x, and y */
	double linear[3], angular[3]; /* m/s, rad/s: how the body moves now; `angular` without a wheel's turning */
	double spins;           /* rad/s about a wheel's axle */
	double rolls[3], turns[3]; /* rad/s: how the body's surface turns: of a wheel as if it rolled without slip; as it does */
	/* A belt: the body's own axis to its left (0: there is no belt). What it ran since the last contact, m, and how fast it runs, m/s */
	double belt[3], ran, runs;
	double ground_normals;  /* 1: stresses act along the ground's normals; 0: along the body's */
};

struct probe_face {
	double height, slope[2], normal[3];
};

/* The motion that a probe asks about, and how the body moves. `low` is not set. */
void deform_probe_form_of(const struct deform *deform, const struct deform_probe *probe, struct probe_form *form);
/* Returns false if the body is not above the place, which is that of the patch's post `number`. *height: of its lower envelope in the end
 * pose, *lowest: during the motion. */
bool deform_form_over(const struct probe_form *form, size_t number, const double at[2], double *height, double *lowest);
/* The same of the end pose alone. */
bool deform_form_rests(const struct probe_form *form, size_t number, const double at[2], double *height);
/* Returns the last share of the contact during which the body was deeper than `stays` below the surface. own: as for probe_face_at. */
double deform_form_share(const struct probe_form *form, const double own[2], const double at[2], double depth, double stays,
			 const struct probe_face *now, bool over);
/* The part of a cell that a post bears: its share of a post's area, and its middle from the post. sides: 1 for each side of the body that
 * ends the part: behind, ahead, right, left. */
double deform_form_part(const struct probe_form *form, const double at[2], bool over, double middle[2], bool sides[4]);
/* Gives two numbers that decide the lower envelope in all of a post's cell. Of a mesh: its slope between this post and its neighbours. Of a
 * steep cylinder: 1 if its lower end alone bears, 2 if the higher of its end and its side does at each place. Of others: 0. */
void deform_form_own(const struct probe_form *form, size_t number, double own[2]);

static inline double probe_clamp(double v, double low, double high)
{
	return v < low ? low : v > high ? high : v;
}

static inline double probe_most(double a, double b)
{
	return a > b ? a : b;
}

static inline double probe_least(double a, double b)
{
	return a < b ? a : b;
}

/* Returns one of two numbers that are both computed, and read from memory, whichever it is. So loops over lanes have no branches. */
static inline double probe_either(bool first, double a, double b)
{
	return first ? a : b;
}

static inline double probe_root(double squares)
{
	return sqrt(probe_most(squares, 0));
}

/* Returns true for a cylinder whose side alone bears, and its lower end beside that. */
static inline bool probe_strips(const struct probe_form *form)
{
	return form->kind == SOIL_CYLINDER && form->half[1] > 0;
}

/* Returns true if circles tell how the body moved over a place. */
static inline bool probe_is_round(const struct probe_form *form)
{
	return form->kind == SOIL_WHEEL || form->kind == SOIL_SPHERE || form->kind == SOIL_ELLIPSOID || probe_strips(form);
}

/* Returns half the width of a cylinder's strip, `ahead` of its axis. */
static inline double probe_half_strip(const struct probe_form *form, double ahead)
{
	return probe_root(form->radius * form->radius - ahead * ahead);
}

/* Returns how far to the left of the middle between its sides a place is. */
static inline double probe_aside(const struct probe_form *form, const double at[2])
{
	return form->kind == SOIL_CYLINDER ? at[1] - form->lean * probe_half_strip(form, at[0]) : at[1];
}

/* -1: a cylinder's lower end is to the right. */
static inline double probe_low_side(const struct probe_form *form)
{
	return form->lean < 0 ? 1 : -1;
}

#endif
