/* The body of a probe: how it moved since the last contact, and its lower envelope. src/deform/soil/between.c computes the same for
 * the GPU. */
#include "deform/probe/form.h"

#include <string.h>

#include "deform/internal.h"
#include "deform/shape/body.h"

#define BESIDE 2e-9 /* m: places that are rounded differently by the GPU's whole numbers */

static void into_frame(const struct probe_form *form, double v[2])
{
	const double east = v[0], north = v[1];
	v[0] = form->axis[0] * east + form->axis[1] * north;
	v[1] = form->axis[0] * north - form->axis[1] * east;
}

static void put_axis(struct probe_form *form, double x, double y)
{
	form->axis[0] = x;
	form->axis[1] = y;
}

static void put_rise(struct probe_form *form)
{
	form->rise = form->run > 0 ? form->way[2] / form->run : 0;
	form->sine = form->rise / sqrt(1 + form->rise * form->rise);
}

/* Returns how much of a rise counts as a way along the ground. From a slope of 1 to one of 2 that is less and less. */
static double level_share(double forward, double rise)
{
	return forward != 0 ? fmin(fmax(2 - fabs(rise / forward), 0), 1) : 0;
}

static double time_of_rim(const struct probe_form *form, double forward, double way, double ran)
{
	const double rise = form->way[2], rolled = fabs(ran), along = hypot(way, level_share(forward, rise) * rise);
	/* A body that moves up or down neither rolls nor spins. */
	const double aligned = (way > 0 ? forward * forward / (way * way) : 1) * level_share(fmax(fabs(forward), rolled), rise);
	const double share = rolled > 0.1 * along ? fmax(along / rolled, 0.1) : 10;
	return 1 + (share - 1) * aligned;
}

static void wheel(const struct deform_probe *probe, struct probe_form *form)
{
	const double x = cos(probe->to.yaw), y = sin(probe->to.yaw), way = hypot(form->way[0], form->way[1]);
	const double forward = form->way[0] * x + form->way[1] * y, aside = form->way[1] * x - form->way[0] * y;
	const double sign = forward < 0 ? -1 : 1, rolled = deform_way_along(forward, form->way[2]) / form->radius;
	form->half[1] = probe->shape->width / 2;
	put_axis(form, sign * x, sign * y);
	form->run = fabs(forward);
	put_rise(form);
	if (!form->ground_normals)
		form->rim = time_of_rim(form, forward, way, form->radius * probe->turned);
	form->spin[1] = sign * probe->turned; /* in the frame already */
	form->slip = hypot((rolled - probe->turned) * form->radius, aside);
}

static void sphere(struct probe_form *form)
{
	const double way = hypot(form->way[0], form->way[1]);
	put_axis(form, way > 0 ? form->way[0] / way : 1, way > 0 ? form->way[1] / way : 0);
	form->run = form->slip = way;
	put_rise(form);
}

static void box(const struct deform_probe *probe, struct probe_form *form)
{
	const struct deform_pose *to = &probe->to;
	const double *size = probe->shape->size;
	deform_body_axes(size, to->yaw, to->pitch, to->roll, form->sides);
	put_axis(form, cos(to->yaw), sin(to->yaw));
	form->slip = hypot(form->way[0], form->way[1]);
	for (int k = 0; k < 3; k++) {
		double *axis = form->sides[k];
		const double squares = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2];
		const bool upright = deform_box_is_upright((const double(*)[3])form->sides, k, form->spacing, true);
		into_frame(form, axis);
		form->faces[k][0] = upright ? -1e9 : -squares / fabs(axis[2]);
		form->faces[k][1] = upright ? 0 : -axis[0] / axis[2];
		form->faces[k][2] = upright ? 0 : -axis[1] / axis[2];
	}
	if (deform_box_is_cut(probe->shape, to, form->spacing, true))
		return;
	form->half[0] = fabs(cos(to->pitch)) * size[0] / 2 + fabs(sin(to->pitch)) * size[2] / 2;
	form->half[1] = fabs(cos(to->roll)) * size[1] / 2 + fabs(sin(to->roll)) * size[2] / 2;
}

static void put_motion(const struct deform_probe *probe, struct probe_form *form)
{
	const struct deform_contact contact = {.from = probe->from, .to = probe->to};
	memcpy(form->linear, probe->linear, sizeof form->linear);
	memcpy(form->angular, probe->angular, sizeof form->angular);
	if (deform_is_contact_only(&contact))
		return;
	form->way[0] = lattice_offset_metres(probe->to.x - probe->from.x) + probe->beyond[0];
	form->way[1] = lattice_offset_metres(probe->to.y - probe->from.y) + probe->beyond[1];
	form->way[2] = lattice_offset_metres(probe->to.z - probe->from.z) + probe->beyond[2];
	form->ran = probe->shape->belt ? probe->turned : 0;
	if (probe->shape->kind != DEFORM_WHEEL)
		memcpy(form->spin, probe->rotated, sizeof form->spin);
}

/* A belt: as in soil/scm.c and soil/between.c. */
static void put_belt(const struct deform_probe *probe, struct probe_form *form)
{
	const struct deform_pose *to = &probe->to;
	const double forward = form->way[0] * cos(to->yaw) + form->way[1] * sin(to->yaw);
	double axes[3][3], along[2] = {0, 0};
	deform_axes(to->yaw, to->pitch, to->roll, 0, axes);
	for (int i = 0; i < 2; i++)
		for (int k = 0; k < 3; k++)
			along[i] += form->way[k] * axes[i][k];
	memcpy(form->belt, axes[1], sizeof form->belt);
	form->runs = probe->runs;
	form->slip = hypot(along[0] - form->ran, along[1]);
	if (form->ground_normals)
		return;
	const double time = time_of_rim(form, forward, hypot(form->way[0], form->way[1]), form->ran);
	form->slip *= time;
	form->rim = time * hypot(axes[1][0], axes[1][1]);
}

static void turn_into_frame(struct probe_form *form)
{
	into_frame(form, form->way);
	into_frame(form, form->linear);
	into_frame(form, form->angular);
	into_frame(form, form->belt);
	if (form->kind == DEFORM_WHEEL) {
		form->spins = form->angular[1];
		form->angular[1] = 0;
	} else {
		into_frame(form, form->spin);
	}
	const bool northward = fabs(form->axis[1]) > fabs(form->axis[0]);
	const double ahead[2][2] = {{copysign(1, form->axis[0]), 0}, {0, copysign(1, form->axis[1])}};
	const double aside[2][2] = {{0, copysign(1, form->axis[0])}, {copysign(1, -form->axis[1]), 0}};
	for (int k = 0; k < 2; k++) {
		form->cut[0][k] = form->spacing * ahead[northward][k];
		form->cut[1][k] = form->spacing * aside[northward][k];
	}
	into_frame(form, form->cut[0]);
	into_frame(form, form->cut[1]);
}

void deform_probe_form_of(const struct deform *deform, const struct deform_probe *probe, struct probe_form *form)
{
	*form = (struct probe_form){
		.kind = probe->shape->kind, .radius = probe->shape->radius, .axis = {1, 0}, .spacing = deform->spacing,
		.ground_normals = deform->params.ground_normals, .dig_most = deform->params.slip_sinkage,
	};
	put_motion(probe, form);
	if (form->kind == DEFORM_WHEEL)
		wheel(probe, form);
	else if (form->kind == DEFORM_SPHERE)
		sphere(form);
	else
		box(probe, form);
	if (form->rim > 0)
		form->slip *= form->rim;
	if (probe->shape->belt)
		put_belt(probe, form);
	turn_into_frame(form);
	if (!probe_is_round(form))
		form->radius = deform_shape_bound(probe->shape);
	form->by_radius = 1 / form->radius;
	const double larger = fmax(fabs(form->axis[0]), fabs(form->axis[1])), way = hypot(form->way[0], form->way[1]);
	form->half_across = 0.5 * form->spacing / (form->kind == DEFORM_WHEEL ? larger : 1);
	form->step_aside = larger * form->spacing;
	form->by_step = 1 / form->step_aside;
	for (int k = 0; k < 2; k++)
		form->by_way[k] = way > 0 ? form->way[k] / fmax(way * way, 1e-12) : 0;
	form->moved = fmin(way / form->half_across, 1);
	form->stamps = fmin(1 - form->moved, probe->stamped);
}

/* --- the lower envelope --- */

/* Gives the lowest height at which the vertical line through a place is inside the box. Returns false if that line misses the box. */
static bool inside_box(const struct probe_form *form, const double at[2], double *low)
{
	double high = INFINITY;
	*low = -INFINITY;
	for (int k = 0; k < 3; k++) {
		const double *axis = form->sides[k];
		const double squares = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2], along = axis[0] * at[0] + axis[1] * at[1];
		if (form->faces[k][0] <= -1e9) {
			if (fabs(along) > squares + BESIDE * sqrt(squares))
				return false;
			continue;
		}
		*low = fmax(*low, (-along - squares * copysign(1, axis[2])) / axis[2]);
		high = fmin(high, (-along + squares * copysign(1, axis[2])) / axis[2]);
	}
	return *low <= high + BESIDE;
}

/* Gives the height of the box above a place at a share of its motion, back from its end. INFINITY: it is not above it then. */
static double back_at(const struct probe_form *form, const double at[2], double share)
{
	const double there[2] = {at[0] + share * form->way[0], at[1] + share * form->way[1]};
	double height;
	return inside_box(form, there, &height) ? height - share * form->way[2] : INFINITY;
}

/* Returns the lowest height of the box above a place during its motion. The highest of three planes is lowest at an end of the motion,
 * where the box leaves the place, or where two planes meet. */
static double lowest_of_box(const struct probe_form *form, const double at[2], double now)
{
	double lowest = now, inside = 0, outside = 1;
	if (form->way[0] == 0 && form->way[1] == 0)
		return now - fmax(form->way[2], 0);
	lowest = fmin(lowest, back_at(form, at, 1));
	if (!isfinite(back_at(form, at, 1))) {
		for (int k = 0; k < 20; k++) {
			const double middle = 0.5 * (inside + outside);
			*(isfinite(back_at(form, at, middle)) ? &inside : &outside) = middle;
		}
		lowest = fmin(lowest, back_at(form, at, inside));
	}
	for (int k = 0; k < 3; k++) {
		const double *a = form->faces[k], *b = form->faces[(k + 1) % 3];
		const double apart = a[0] - b[0] + (a[1] - b[1]) * at[0] + (a[2] - b[2]) * at[1];
		const double nears = (a[1] - b[1]) * form->way[0] + (a[2] - b[2]) * form->way[1];
		if (nears != 0 && -apart / nears > 0 && -apart / nears < 1)
			lowest = fmin(lowest, back_at(form, at, -apart / nears));
	}
	return lowest;
}

static bool over_round(const struct probe_form *form, const double at[2], double *height)
{
	const double r = form->radius, squares = at[0] * at[0] + (form->kind == DEFORM_SPHERE ? at[1] * at[1] : 0);
	*height = -sqrt(fmax(r * r - squares, 0));
	return squares <= r * r * (1 + 1e-12) && (form->kind == DEFORM_SPHERE || fabs(at[1]) <= form->half[1] + BESIDE);
}

bool deform_form_over(const struct probe_form *form, const double at[2], double *height, double *lowest)
{
	if (probe_is_round(form)) {
		double since;
		const bool over = over_round(form, at, height);
		*lowest = *height;
		if (form->run > 0)
			*lowest -= probe_lowered(form, at, form->run, *height, &since);
		else
			*lowest += fmin(-form->way[2], 0);
		return over;
	}
	const bool over = inside_box(form, at, height);
	*lowest = over ? lowest_of_box(form, at, *height) : INFINITY;
	return over;
}

static double until_beyond(double at, double size, double speed)
{
	return size > 0 && fabs(speed) > 1e-9 ? fmax(size - at * copysign(1, speed), 0) / fabs(speed) : 1e3;
}

double deform_form_share(const struct probe_form *form, const double at[2], double depth, double stays, const struct probe_face *now, bool over)
{
	const double gains = depth - stays;
	double share = 1e3;
	if (probe_is_round(form)) {
		/* When the circle in which the body is cut along its motion leaves the place. */
		const double r = form->radius, aside = form->kind == DEFORM_SPHERE ? at[1] : 0, level = now->height + gains;
		const double moves = form->run * form->run + form->way[2] * form->way[2];
		const double nears = at[0] * form->run + level * form->way[2], beyond = at[0] * at[0] + level * level - (r * r - aside * aside);
		const double root = nears * nears - moves * beyond;
		if (moves > 0)
			share = root >= 0 ? -beyond / fmax(nears + sqrt(root), 1e-18) : -4;
	} else {
		const double before[2] = {at[0] + form->way[0], at[1] + form->way[1]};
		const double speed = probe_height_at(form, before) - now->height - form->way[2];
		if (speed > 0)
			share = gains / speed;
	}
	if (form->kind == DEFORM_BOX && over)
		share = fmin(share, until_beyond(at[0], form->half[0], form->way[0]));
	if (form->kind != DEFORM_SPHERE && over)
		share = fmin(share, until_beyond(at[1], form->half[1], form->way[1]));
	return fmin(fmax(share, -4), 1e3);
}

/* --- parts of cells --- */

/* Adds one direction: what the post bears of a strip, half way to the next post that is covered too, or to the strip's side. */
static void part_of(const struct probe_form *form, double at, double size, double part[2], bool sides[2])
{
	sides[0] = !(fabs(at - form->step_aside) <= size + BESIDE);
	sides[1] = !(fabs(at + form->step_aside) <= size + BESIDE);
	part[0] = sides[0] ? fmax((-size - at) * form->by_step, -1) : -0.5;
	part[1] = sides[1] ? fmin((size - at) * form->by_step, 1) : 0.5;
}

static bool bears_beside(const struct probe_form *form, const double at[2], bool narrow)
{
	const bool between = narrow && fabs(at[1] - 1e-4 * form->step_aside) <= 0.5 * form->step_aside;
	return form->kind == DEFORM_WHEEL && fabs(at[0]) < form->radius + form->half_across &&
	       (between || (fabs(at[0]) > form->radius && fabs(at[1]) <= form->half[1]));
}

double deform_form_part(const struct probe_form *form, const double at[2], bool over, double middle[2], bool sides[4])
{
	double share = over ? 1 : 0;
	middle[0] = middle[1] = 0;
	sides[0] = sides[1] = sides[2] = sides[3] = false;
	if (form->half[1] > 0) {
		double part[2];
		const bool narrow = 2 * form->half[1] < form->step_aside;
		part_of(form, at[1], form->half[1], part, sides + 2);
		if (!over && !bears_beside(form, at, narrow))
			return 0;
		if (!over && narrow) {
			part[0] = (-form->half[1] - at[1]) * form->by_step;
			part[1] = (form->half[1] - at[1]) * form->by_step;
		}
		share = fmax(part[1] - part[0], 0);
		for (int k = 0; k < 2; k++)
			middle[k] = 0.5 * (part[0] + part[1]) * form->cut[1][k];
	}
	if (form->kind == DEFORM_BOX && form->half[0] > 0 && form->half[1] > 0) {
		double part[2];
		part_of(form, at[0], form->half[0], part, sides);
		share *= fmax(part[1] - part[0], 0);
		for (int k = 0; k < 2; k++)
			middle[k] += 0.5 * (part[0] + part[1]) * form->cut[0][k];
	}
	return share;
}
