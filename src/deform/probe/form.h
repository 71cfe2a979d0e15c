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

#define PROBE_STEEPEST 19.974984 /* lib/soil.glsl: the steepest slope, */
#define PROBE_UPRIGHT 0.05       /* and the z of its unit normal */

struct probe_form {
	enum deform_shape_kind kind;
	double radius;          /* wheel, sphere; of other shapes: of a sphere around the body */
	double by_radius;
	double half[2];         /* half of its length and of its width, seen from above; 0: whole posts bear */
	double axis[2];         /* the frame's x axis: east, north */
	double spacing;
	double half_across;     /* half the length of a line across a cell */
	double step_aside, by_step;
	double run, rise, sine; /* round: way forwards; rise for each metre; sine of that slope */
	double rim;             /* how long a wheel's rim or a belt takes, of the soil's time; 0: 1 */
	double way[3], spin[3]; /* its motion since the last contact: m; rad */
	double by_way[2];
	double moved;           /* 0: it stood still; 1: it moved over half a cell */
	double stamps;          /* 1: the hollow that it left has its shape; 0: it is a flat rut */
	double slip, dig_most;  /* how far it slips; how deep that digs at most, in units of the shear modulus */
	double faces[3][3];     /* box: lower faces: height at the centre, slope along the frame's axes */
	double sides[3][3];     /* box: its axes in the frame, m: half of its sizes */
	double cut[2][2];       /* from a post to the next, along the lattice's axis that is nearest to the frame's x, and y */
	double linear[3], angular[3]; /* m/s, rad/s: how the body moves now; `angular` without a wheel's turning */
	double spins;           /* rad/s about a wheel's axle */
	double centre[2];       /* from the patch's first post, m, east and north */
	/* A belt: the body's own axis to its left (0: there is no belt). What it ran since the last contact, m, and how fast it runs, m/s */
	double belt[3], ran, runs;
	bool ground_normals;
};

struct probe_face {
	double height, slope[2], normal[3];
};

/* The motion that a probe asks about, and how the body moves. */
void deform_probe_form_of(const struct deform *deform, const struct deform_probe *probe, struct probe_form *form);
/* Returns false if the body is not above the place. *height: of its lower envelope in the end pose, *lowest: during the motion. */
bool deform_form_over(const struct probe_form *form, const double at[2], double *height, double *lowest);
/* Returns the last share of the contact during which the body was deeper than `stays` below the surface. */
double deform_form_share(const struct probe_form *form, const double at[2], double depth, double stays, const struct probe_face *now, bool over);
/* The part of a cell that a post bears: its share of a post's area, and its middle from the post. sides: 1 for each side of the body that
 * ends the part: behind, ahead, right, left. */
double deform_form_part(const struct probe_form *form, const double at[2], bool over, double middle[2], bool sides[4]);

static inline bool probe_is_round(const struct probe_form *form)
{
	return form->kind == DEFORM_WHEEL || form->kind == DEFORM_SPHERE;
}

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

static inline void probe_round_face(const struct probe_form *form, const double at[2], struct probe_face *face)
{
	const double r = form->radius;
	if (form->kind == DEFORM_WHEEL) {
		const double most = 0.99874922 * r, up = sqrt(probe_most(r * r - at[0] * at[0], 0)), by = form->by_radius;
		*face = (struct probe_face){-up, {0, 0}, {-probe_clamp(at[0], -most, most) * by, 0, probe_most(up * by, PROBE_UPRIGHT)}};
		return;
	}
	const double squares = at[0] * at[0] + at[1] * at[1], up = sqrt(probe_most(r * r - squares, 0));
	const double z = probe_most(up, sqrt(probe_most(r * r, squares)) * (1 / PROBE_STEEPEST)), by = 1 / sqrt(squares + z * z);
	*face = (struct probe_face){-up, {at[0] / z, at[1] / z}, {-at[0] * by, -at[1] * by, z * by}};
}

static inline void probe_flat_face(const struct probe_form *form, const double at[2], struct probe_face *face)
{
	*face = (struct probe_face){.height = -1e9};
	for (int k = 0; k < 3; k++) {
		const double height = form->faces[k][0] + form->faces[k][1] * at[0] + form->faces[k][2] * at[1];
		if (height > face->height) {
			face->height = height;
			face->slope[0] = form->faces[k][1];
			face->slope[1] = form->faces[k][2];
		}
	}
	double x = face->slope[0], y = face->slope[1];
	const double squares = x * x + y * y;
	if (squares > PROBE_STEEPEST * PROBE_STEEPEST) {
		const double less = PROBE_STEEPEST / sqrt(squares);
		x *= less;
		y *= less;
	}
	const double up = 1 / sqrt(1 + x * x + y * y);
	face->normal[0] = -x * up;
	face->normal[1] = -y * up;
	face->normal[2] = up;
}

static inline void probe_face_at(const struct probe_form *form, const double at[2], struct probe_face *face)
{
	if (probe_is_round(form))
		probe_round_face(form, at, face);
	else
		probe_flat_face(form, at, face);
}

static inline double probe_height_at(const struct probe_form *form, const double at[2])
{
	if (probe_is_round(form)) {
		const double aside = form->kind == DEFORM_SPHERE ? at[1] : 0;
		return -sqrt(probe_most(form->radius * form->radius - at[0] * at[0] - aside * aside, 0));
	}
	double height = -1e9;
	for (int k = 0; k < 3; k++)
		height = probe_most(height, form->faces[k][0] + form->faces[k][1] * at[0] + form->faces[k][2] * at[1]);
	return height;
}

/* Returns how much lower than now a round body was above a place during its last `back` metres. *since: how many metres ago it was lowest. */
static inline double probe_lowered(const struct probe_form *form, const double at[2], double back, double now, double *since)
{
	*since = 0;
	if (!(form->run > 0))
		return 0;
	const double r = form->radius, aside = form->kind == DEFORM_SPHERE ? at[1] : 0;
	const double squares = probe_most(r * r - aside * aside, 0), ring = form->kind == DEFORM_WHEEL ? r : sqrt(squares);
	double x = probe_least(probe_most(ring * form->sine, at[0]), at[0] + back);
	x = probe_clamp(x, -ring, ring);
	if (x == at[0])
		return 0;
	const double inside = probe_clamp(at[0], -ring, ring);
	*since = probe_most(x - at[0], 0);
	const double rises = (inside - x) * (inside + x) / probe_most(sqrt(probe_most(squares - x * x, 0)) - now, 1e-9);
	return probe_most(rises + form->rise * (x - at[0]), 0);
}

#endif
