/*
 * The lower envelope of a body between posts: its height, its slope, how that bends, and how much lower it was during the motion. Below a
 * place that the body does not cover these go on from its edge. The same as shaders/lib/scm_body.glsl.
 *
 * own: what deform_form_own gives of the post whose cell the place is in.
 */
#ifndef FURROW_DEFORM_PROBE_FACE_H
#define FURROW_DEFORM_PROBE_FACE_H

#include "deform/probe/form.h"

#define PROBE_STEEPEST_PART 0.99874922 /* of a unit normal: what lies in plan where its z is PROBE_UPRIGHT */

static inline void probe_normal_of_slope(const double slope[2], double normal[3])
{
	double x = slope[0], y = slope[1];
	const double squares = x * x + y * y;
	if (squares > PROBE_STEEPEST * PROBE_STEEPEST) {
		const double less = PROBE_STEEPEST / sqrt(squares);
		x *= less;
		y *= less;
	}
	const double up = 1 / sqrt(1 + x * x + y * y);
	normal[0] = -x * up;
	normal[1] = -y * up;
	normal[2] = up;
}

static inline void probe_wheel_face(const struct probe_form *form, const double at[2], struct probe_face *face)
{
	const double r = form->radius, most = PROBE_STEEPEST_PART * r, up = probe_root(r * r - at[0] * at[0]), by = form->by_radius;
	*face = (struct probe_face){-up, {0, 0}, {-probe_clamp(at[0], -most, most) * by, 0, probe_most(up * by, PROBE_UPRIGHT)}};
}

/* The lower side of a ball. from: the place from its centre; above: height of its centre. */
static inline void probe_ball_face(const struct probe_form *form, const double from[2], double above, struct probe_face *face)
{
	const double r = form->radius, squares = from[0] * from[0] + from[1] * from[1], up = probe_root(r * r - squares);
	const double z = probe_most(up, sqrt(probe_most(r * r, squares)) * (1 / PROBE_STEEPEST)), by = 1 / sqrt(squares + z * z);
	*face = (struct probe_face){above - up, {from[0] / z, from[1] / z}, {-from[0] * by, -from[1] * by, z * by}};
}

static inline double probe_end_height(const struct probe_form *form, const double at[2])
{
	return (-form->half_axis + probe_low_side(form) * at[1] * form->level) / probe_most(fabs(form->lean), 1e-6);
}

/* Tells whether a steep cylinder bears on a place with its lower end, and not with its side. side: height of that. */
static inline bool probe_is_end(const struct probe_form *form, const double own[2], const double at[2], double side)
{
	return own[0] == 1 || probe_end_height(form, at) > side;
}

/* Returns true if the body bears on a place with a flat end that may be as wide as several cells. */
static inline bool probe_bears_by_end(const struct probe_form *form, const double own[2], const double at[2])
{
	return form->kind == SOIL_CYLINDER && !probe_strips(form) &&
	       probe_is_end(form, own, at, (form->lean * at[1] - probe_half_strip(form, at[0])) * form->lift);
}

/* Returns the share of its area in plan by which a flat end with this normal bears, on ground with this rise: lib/scm_post.glsl, end_bears. */
static inline double probe_end_bears(const struct probe_form *form, const double rise[2], const double normal[3])
{
	const double share = probe_clamp(1 - (normal[0] * rise[0] + normal[1] * rise[1]) / probe_most(normal[2], 1e-6), 0, 1);
	return probe_either(form->ground_normals > 0, 1, share);
}

/* The side of a cylinder. */
static inline void probe_side_face(const struct probe_form *form, const double at[2], struct probe_face *face)
{
	const double most = PROBE_STEEPEST_PART * form->radius, ahead = probe_clamp(at[0], -most, most), strip = probe_half_strip(form, ahead);
	const double up = strip * form->by_radius, lift = form->lift;
	*face = (struct probe_face){(form->lean * at[1] - probe_half_strip(form, at[0])) * lift, {ahead / strip * lift, form->lean * lift},
				    {-ahead * form->by_radius, -form->lean * up, form->level * up}};
}

static inline void probe_cylinder_face(const struct probe_form *form, const double own[2], const double at[2], struct probe_face *face)
{
	probe_side_face(form, at, face);
	if (probe_strips(form))
		return;
	if (probe_is_end(form, own, at, face->height))
		*face = (struct probe_face){.height = probe_end_height(form, at), .slope = {0, probe_low_side(form) * form->level / probe_most(fabs(form->lean), 1e-6)}};
	probe_normal_of_slope(face->slope, face->normal);
}

/* Which part of a capsule is above a place: -1: the lower end, 0: its side, 1: the upper end. */
static inline double probe_capsule_end(const struct probe_form *form, const double at[2], double *axial, double *aside)
{
	*axial = form->along[0] * at[0] + form->along[1] * at[1];
	*aside = form->along[0] * at[1] - form->along[1] * at[0];
	const double middle = probe_half_strip(form, *aside) * form->lean, reach = form->half_axis * form->level;
	return *axial <= middle - reach ? -1 : *axial > middle + reach ? 1 : 0;
}

static inline void probe_capsule_face(const struct probe_form *form, const double at[2], struct probe_face *face)
{
	double axial, aside;
	const double end = probe_capsule_end(form, at, &axial, &aside), reach = end * form->half_axis;
	const double strip = probe_half_strip(form, aside), *axis = form->along;
	if (end != 0) {
		const double from[2] = {at[0] - reach * form->level * axis[0], at[1] - reach * form->level * axis[1]};
		probe_ball_face(form, from, reach * form->lean, face);
		return;
	}
	const double middle = strip * form->lean, up = probe_most(form->level * strip, form->radius * (1 / PROBE_STEEPEST));
	const double x = -middle * axis[0] + aside * axis[1], y = -middle * axis[1] - aside * axis[0], by = 1 / sqrt(x * x + y * y + up * up);
	*face = (struct probe_face){(form->lean * axial - strip) / form->level, {-x / up, -y / up}, {x * by, y * by, up * by}};
}

static inline void probe_ellipsoid_face(const struct probe_form *form, const double at[2], struct probe_face *face)
{
	const double grows = form->ahead_by * (at[0] + form->skew * at[1]), half[2] = {grows, form->skew * grows + form->aside_by * at[1]};
	const double squares = at[0] * half[0] + at[1] * half[1], root = probe_root(1 - squares);
	const double steep = form->drop / probe_most(root, sqrt(probe_most(1, squares)) * (1 / PROBE_STEEPEST));
	face->height = form->tilt[0] * at[0] + form->tilt[1] * at[1] - form->drop * root;
	for (int k = 0; k < 2; k++)
		face->slope[k] = form->tilt[k] + half[k] * steep;
	probe_normal_of_slope(face->slope, face->normal);
}

static inline double probe_box_height(const struct probe_form *form, const double at[2])
{
	double height = -1e9;
	for (int k = 0; k < 3; k++)
		height = probe_most(height, form->faces[k][0] + form->faces[k][1] * at[0] + form->faces[k][2] * at[1]);
	return height;
}

static inline void probe_box_face(const struct probe_form *form, const double at[2], struct probe_face *face)
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
	probe_normal_of_slope(face->slope, face->normal);
}

static inline void probe_face_at(const struct probe_form *form, const double own[2], const double at[2], struct probe_face *face)
{
	switch (form->kind) {
	case SOIL_WHEEL:
		probe_wheel_face(form, at, face);
		break;
	case SOIL_SPHERE:
		probe_ball_face(form, at, 0, face);
		break;
	case SOIL_CYLINDER:
		probe_cylinder_face(form, own, at, face);
		break;
	case SOIL_CAPSULE:
		probe_capsule_face(form, at, face);
		break;
	case SOIL_ELLIPSOID:
		probe_ellipsoid_face(form, at, face);
		break;
	case SOIL_BOX:
		probe_box_face(form, at, face);
		break;
	default: /* a mesh */
		*face = (struct probe_face){.height = own[0] * at[0] + own[1] * at[1], .slope = {own[0], own[1]}};
		probe_normal_of_slope(own, face->normal);
		break;
	}
}

static inline double probe_height_at(const struct probe_form *form, const double own[2], const double at[2])
{
	if (form->kind == SOIL_WHEEL)
		return -probe_half_strip(form, at[0]);
	if (probe_strips(form))
		return (form->lean * at[1] - probe_half_strip(form, at[0])) * form->lift;
	if (form->kind == SOIL_SPHERE)
		return -probe_root(form->radius * form->radius - at[0] * at[0] - at[1] * at[1]);
	if (form->kind == SOIL_BOX)
		return probe_box_height(form, at);
	if (form->kind == SOIL_MESH)
		return own[0] * at[0] + own[1] * at[1];
	struct probe_face face;
	probe_face_at(form, own, at, &face);
	return face.height;
}

/* Adds how a ball's lower envelope curves, the second derivatives of its height, at the place where its unit normal is n. */
static inline void probe_ball_bends(const struct probe_form *form, const double n[3], double bends[3])
{
	const double x = n[0] / n[2], y = n[1] / n[2], by = 1 / (form->radius * n[2]);
	bends[0] = by * (1 + x * x);
	bends[1] = by * x * y;
	bends[2] = by * (1 + y * y);
}

/* Gives the second derivatives of the height: xx, xy, yy, 1/m. face: at the place. */
static inline void probe_bends_at(const struct probe_form *form, const double own[2], const double at[2], const struct probe_face *face, double bends[3])
{
	bends[0] = bends[1] = bends[2] = 0;
	if (form->kind == SOIL_WHEEL) {
		const double up = face->normal[2];
		bends[0] = form->by_radius / (up * up * up);
	} else if (form->kind == SOIL_SPHERE) {
		probe_ball_bends(form, face->normal, bends);
	} else if (form->kind == SOIL_CYLINDER) {
		if (probe_bears_by_end(form, own, at))
			return;
		const double up = face->normal[2] / form->level;
		bends[0] = form->lift * form->by_radius / (up * up * up);
	} else if (form->kind == SOIL_CAPSULE) {
		double axial, aside;
		if (probe_capsule_end(form, at, &axial, &aside) != 0) {
			probe_ball_bends(form, face->normal, bends);
			return;
		}
		const double up = probe_most(probe_half_strip(form, aside) * form->by_radius, PROBE_UPRIGHT);
		const double by = form->by_radius / (form->level * up * up * up), x = -form->along[1], y = form->along[0];
		bends[0] = by * x * x;
		bends[1] = by * x * y;
		bends[2] = by * y * y;
	} else if (form->kind == SOIL_ELLIPSOID) {
		const double grows = form->ahead_by * (at[0] + form->skew * at[1]), half[2] = {grows, form->skew * grows + form->aside_by * at[1]};
		const double squares = at[0] * half[0] + at[1] * half[1];
		const double root = probe_most(probe_root(1 - squares), sqrt(probe_most(1, squares)) * (1 / PROBE_STEEPEST));
		const double by = form->drop / root, more = by / (root * root);
		bends[0] = by * form->ahead_by + more * half[0] * half[0];
		bends[1] = by * form->ahead_by * form->skew + more * half[0] * half[1];
		bends[2] = by * (form->ahead_by * form->skew * form->skew + form->aside_by) + more * half[1] * half[1];
	}
}

/* Gives the radius of the circle through a place, and how far ahead of the circle's middle the place is. */
static inline void probe_ring(const struct probe_form *form, const double at[2], double *squares, double *ahead)
{
	*ahead = at[0];
	*squares = form->radius * form->radius;
	if (form->kind == SOIL_SPHERE)
		*squares = probe_most(*squares - at[1] * at[1], 0);
	if (form->kind != SOIL_ELLIPSOID)
		return;
	*squares = probe_most(1 - form->aside_by * at[1] * at[1], 0) / form->ahead_by;
	*ahead = at[0] + form->skew * at[1];
}

/* Returns how much lower a circle is at x than at `inside`, both m ahead of its middle. down: how far below its middle it is at `inside`. */
static inline double probe_lower_by(const struct probe_form *form, double squares, double x, double inside, double down)
{
	return form->lift * (inside - x) * (inside + x) / probe_most(probe_root(squares - x * x) + down, 1e-9);
}

/* Returns how much lower than now a round body was above a place during its last `back` metres. The place is on a circle; ring, squares: its
 * radius, and the square of that. Before the present contact the body moved along the ground. rise: how much that rises for each metre along the
 * frame's x axis, less the circles' shear. *since: how many metres ago it was lowest. */
static inline double probe_lowered_on(const struct probe_form *form, double squares, double ring, double ahead, double back, double rise, double *since)
{
	/* Within the contact and before it the circle took two ways. On each the lowest place is found; the lower of these counts. */
	const double first = ahead + form->run, inside = probe_clamp(ahead, -ring, ring), down = probe_root(squares - ahead * ahead);
	const double within = probe_clamp(probe_least(probe_most(ring * form->sine, ahead), first), -ring, ring);
	const double earlier = probe_clamp(probe_least(probe_most(ring * rise / sqrt(form->lift * form->lift + rise * rise), first), ahead + back), -ring, ring);
	const double less = probe_lower_by(form, squares, within, inside, down) + form->rise * (within - ahead);
	const double least = probe_lower_by(form, squares, earlier, inside, down) + form->rise * (earlier - ahead) +
			     probe_most(earlier - first, 0) * (rise - form->rise);
	*since = probe_most(probe_either(least > less, earlier, within) - ahead, 0);
	return probe_most(probe_most(less, least), 0);
}

/* The same at any place. ground: how much the ground rises for each metre. */
static inline double probe_lowered(const struct probe_form *form, const double at[2], double back, double ground, double *since)
{
	double squares, ahead;
	*since = 0;
	if (!(form->run > 0))
		return 0;
	probe_ring(form, at, &squares, &ahead);
	const double ring = form->kind == SOIL_WHEEL ? form->radius : sqrt(squares), rise = form->kind == SOIL_ELLIPSOID ? ground - form->tilt[0] : ground;
	return probe_lowered_on(form, squares, ring, ahead, back, rise, since);
}

/* Returns a height that the lower envelope is nowhere below, at places up to `reach` from a place. */
static inline double probe_lowest_near(const struct probe_form *form, const double own[2], const double at[2], double reach)
{
	const double r = form->radius;
	double lowest = -1e9;
	switch (form->kind) {
	case SOIL_WHEEL: {
		const double near = probe_most(fabs(at[0]) - reach, 0);
		return -probe_root(r * r - near * near);
	}
	case SOIL_SPHERE: {
		const double near = probe_most(sqrt(at[0] * at[0] + at[1] * at[1]) - reach, 0);
		return -probe_root(r * r - near * near);
	}
	case SOIL_CYLINDER: {
		const double side = (form->lean * at[1] - fabs(form->lean) * reach - probe_half_strip(form, probe_most(fabs(at[0]) - reach, 0))) * form->lift;
		const double end = probe_end_height(form, at) - reach * form->level / probe_most(fabs(form->lean), 1e-6);
		return probe_strips(form) ? side : own[0] > 1 ? probe_most(side, end) : end;
	}
	case SOIL_CAPSULE:
		return -form->half_axis * form->lean - r;
	case SOIL_ELLIPSOID: {
		const double ahead = at[0] + form->skew * at[1], squares = form->ahead_by * ahead * ahead + form->aside_by * at[1] * at[1];
		const double near = probe_most(sqrt(squares) - reach * form->shrinks, 0);
		return form->tilt[0] * at[0] + form->tilt[1] * at[1] - hypot(form->tilt[0], form->tilt[1]) * reach - form->drop * probe_root(1 - near * near);
	}
	case SOIL_BOX:
		for (int k = 0; k < 3; k++) {
			const double *f = form->faces[k];
			lowest = probe_most(lowest, f[0] + f[1] * at[0] + f[2] * at[1] - reach * sqrt(f[1] * f[1] + f[2] * f[2]));
		}
		return lowest;
	default:
		return own[0] * at[0] + own[1] * at[1] - reach * sqrt(own[0] * own[0] + own[1] * own[1]);
	}
}

#endif
