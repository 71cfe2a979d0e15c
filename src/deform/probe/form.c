/* The body of a probe: how it moved since the last contact. src/deform/soil/between.c computes the same for the GPU. */
#include "deform/probe/form.h"

#include <string.h>

#include "deform/internal.h"
#include "soil/shape/body.h"



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

static void along_way(struct probe_form *form)
{
	const double way = hypot(form->way[0], form->way[1]);
	put_axis(form, way > 0 ? form->way[0] / way : 1, way > 0 ? form->way[1] / way : 0);
	form->slip = way;
}

/* rises: of the circle in the whole motion, m. */
static void put_rise(struct probe_form *form, double run, double rises)
{
	form->run = run;
	form->rise = run > 0 ? rises / run : 0;
	form->sine = form->rise / sqrt(form->lift * form->lift + form->rise * form->rise);
	form->plunge = rises / form->lift;
}

static void put_times(struct probe_form *form, double forward, double rise, double ran)
{
	if (form->ground_normals > 0)
		return;
	const struct deform_rim_times times = deform_rim_times_of(forward, hypot(form->way[0], form->way[1]), rise, ran, true);
	form->rim = times.shears;
	form->slip *= times.digs;
}

/* A wheel's turning, and how far it slips. */
static void put_turning(const struct deform_probe *probe, struct probe_form *form)
{
	const double x = cos(probe->to.yaw), y = sin(probe->to.yaw), level = cos(probe->to.roll);
	const double forward = form->way[0] * x + form->way[1] * y, aside = form->way[1] * x - form->way[0] * y;
	const double axle[3] = {-y * level, x * level, sin(probe->to.roll)};
	for (int k = 0; k < 3; k++)
		form->spin[k] = axle[k] * probe->turned;
	form->slip = hypot(deform_way_along(forward, form->way[2]) - probe->turned * form->radius, aside);
}

static void wheel(const struct deform_probe *probe, struct probe_form *form)
{
	const double x = cos(probe->to.yaw), y = sin(probe->to.yaw);
	const double forward = form->way[0] * x + form->way[1] * y, sign = forward < 0 ? -1 : 1;
	form->half[1] = probe->shape->width / 2;
	put_axis(form, sign * x, sign * y);
	put_rise(form, fabs(forward), form->way[2]);
	put_times(form, forward, form->way[2], form->radius * probe->turned);
}

/* A cylinder, or a wheel with camber. The frame looks across its axis. In the plane across the axis it moves as a level wheel does. */
static void cylinder(const struct deform_probe *probe, struct probe_form *form)
{
	const struct lower_envelope *lower = &form->lower;
	const double c = fmax(lower->level, DEFORM_LEVEL_LEAST), s = lower->axis[2], x = lower->along[1], y = -lower->along[0];
	const double forward = form->way[0] * x + form->way[1] * y, aside = form->way[0] * lower->along[0] + form->way[1] * lower->along[1];
	const double sign = forward < 0 ? -1 : 1, rises = form->way[2] - aside * s / c;
	const bool strips = s <= DEFORM_LEANS_MOST;
	form->lean = sign * s;
	form->level = c;
	form->lift = 1 / c;
	form->half_axis = lower->half;
	form->half[1] = strips ? lower->half * c : 0;
	put_axis(form, sign * x, sign * y);
	put_rise(form, fabs(forward), rises);
	if (!form->wheel)
		form->slip = hypot(form->way[0], form->way[1]);
	if (strips)
		put_times(form, forward, rises, form->wheel ? form->radius * probe->turned : 0);
}

static void sphere(struct probe_form *form)
{
	along_way(form);
	put_rise(form, form->slip, form->way[2]);
}

static void capsule(struct probe_form *form)
{
	along_way(form);
	form->lean = form->lower.axis[2];
	form->level = fmax(form->lower.level, DEFORM_LEVEL_LEAST);
	form->half_axis = form->lower.half;
	memcpy(form->along, form->lower.along, sizeof form->along);
	into_frame(form, form->along);
}

static void ellipsoid(struct probe_form *form)
{
	along_way(form);
	const struct lower_envelope *lower = &form->lower;
	const double *q = lower->inside, x = form->axis[0], y = form->axis[1];
	const double ahead = q[0] * x * x + 2 * q[1] * x * y + q[2] * y * y, both = (q[2] - q[0]) * x * y + q[1] * (x * x - y * y);
	const double beside = q[0] * y * y - 2 * q[1] * x * y + q[2] * x * x;
	form->ahead_by = ahead;
	form->skew = both / ahead;
	form->aside_by = beside - both * both / ahead;
	form->shrinks = sqrt((q[0] + q[2]) / 2 + hypot((q[0] - q[2]) / 2, q[1]));
	form->drop = lower->lift;
	form->lift = lower->lift * sqrt(ahead);
	put_rise(form, form->slip, form->way[2] - lower->rise[0] * form->way[0] - lower->rise[1] * form->way[1]);
	memcpy(form->tilt, lower->rise, sizeof form->tilt);
	into_frame(form, form->tilt);
}

static void box(const struct deform_probe *probe, struct probe_form *form)
{
	const struct soil_pose *to = &probe->to;
	const double *size = probe->shape->size;
	double sides[3][3];
	soil_body_axes(size, to->yaw, to->pitch, to->roll, sides);
	put_axis(form, cos(to->yaw), sin(to->yaw));
	form->slip = hypot(form->way[0], form->way[1]);
	for (int k = 0; k < 3; k++) {
		double *axis = sides[k];
		const double squares = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2];
		const bool upright = deform_box_is_upright((const double(*)[3])sides, k, form->spacing, true);
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

static void put_shape(const struct deform_probe *probe, struct probe_form *form)
{
	switch (form->kind) {
	case SOIL_WHEEL:
		wheel(probe, form);
		break;
	case SOIL_SPHERE:
		sphere(form);
		break;
	case SOIL_BOX:
		box(probe, form);
		break;
	case SOIL_CYLINDER:
		cylinder(probe, form);
		break;
	case SOIL_CAPSULE:
		capsule(form);
		break;
	case SOIL_ELLIPSOID:
		ellipsoid(form);
		break;
	case SOIL_MESH:
	case SOIL_SHAPES: /* its posts tell; its frame is the lattice's */
		form->slip = hypot(form->way[0], form->way[1]);
		break;
	}
}

static void put_motion(const struct deform_probe *probe, struct probe_form *form)
{
	const struct deform_contact contact = {.from = probe->from, .to = probe->to};
	memcpy(form->linear, probe->linear, sizeof form->linear);
	memcpy(form->angular, probe->angular, sizeof form->angular);
	form->ran = probe->shape->belt ? probe->turned : 0;
	if (deform_is_contact_only(&contact)) {
		if (form->wheel)
			put_turning(probe, form);
		return;
	}
	form->way[0] = lattice_offset_metres(probe->to.x - probe->from.x) + probe->beyond[0];
	form->way[1] = lattice_offset_metres(probe->to.y - probe->from.y) + probe->beyond[1];
	form->way[2] = lattice_offset_metres(probe->to.z - probe->from.z) + probe->beyond[2];
	if (form->wheel)
		put_turning(probe, form);
	else
		memcpy(form->spin, probe->rotated, sizeof form->spin);
}

/* A belt: as in soil/scm.c and soil/between.c. */
static void put_belt(const struct deform_probe *probe, struct probe_form *form)
{
	const struct soil_pose *to = &probe->to;
	const double forward = form->way[0] * cos(to->yaw) + form->way[1] * sin(to->yaw);
	double axes[3][3], along[2] = {0, 0};
	soil_axes(to->yaw, to->pitch, to->roll, 0, axes);
	for (int i = 0; i < 2; i++)
		for (int k = 0; k < 3; k++)
			along[i] += form->way[k] * axes[i][k];
	memcpy(form->belt, axes[1], sizeof form->belt);
	form->runs = probe->runs;
	form->slip = hypot(along[0] - form->ran, along[1]);
	put_times(form, forward, form->way[2], form->ran);
	form->rim *= hypot(axes[1][0], axes[1][1]);
}

static void turn_into_frame(struct probe_form *form)
{
	into_frame(form, form->way);
	into_frame(form, form->linear);
	into_frame(form, form->angular);
	into_frame(form, form->spin);
	into_frame(form, form->belt);
	if (form->wheel) {
		form->spins = form->angular[1] * form->level + form->angular[2] * form->lean;
		form->angular[1] -= form->spins * form->level;
		form->angular[2] -= form->spins * form->lean;
	}
	const double axle[3] = {0, form->level, form->lean}, rolled = form->wheel ? form->linear[0] * form->by_radius : 0;
	for (int k = 0; k < 3; k++) {
		form->rolls[k] = form->angular[k] + rolled * axle[k];
		form->turns[k] = form->angular[k] + form->spins * axle[k];
	}
	const bool northward = fabsf((float)form->axis[1]) > fabsf((float)form->axis[0]); /* of two that are equal the GPU's choice */
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
		.kind = soil_kind_in(probe->shape, &probe->to), .wheel = probe->shape->kind == SOIL_WHEEL, .radius = probe->shape->radius,
		.outer = soil_body_wheel_radius(probe->shape), .axis = {1, 0}, .spacing = deform->spacing, .smooth = *probe->shape,
		.ground_normals = deform->params.ground_normals ? 1 : 0, .dig_most = deform->params.slip_sinkage, .lift = 1, .level = 1,
	};
	form->smooth.grousers = 0;
	if (form->kind != SOIL_WHEEL && form->kind != SOIL_SPHERE)
		soil_lower_of(&form->smooth, &probe->to, &form->lower);
	form->lower.beside = PROBE_BESIDE;
	put_motion(probe, form);
	put_shape(probe, form);
	if (probe->shape->belt)
		put_belt(probe, form);
	if (!(form->radius > 0))
		form->radius = soil_shape_bound(probe->shape);
	form->by_radius = 1 / form->radius;
	turn_into_frame(form);
	const double larger = fmax(fabs(form->axis[0]), fabs(form->axis[1])), way = hypot(form->way[0], form->way[1]);
	form->half_across = 0.5 * form->spacing / (form->kind == SOIL_WHEEL || probe_strips(form) ? larger : 1);
	form->step_aside = larger * form->spacing;
	form->by_step = 1 / form->step_aside;
	for (int k = 0; k < 2; k++)
		form->by_way[k] = way > 0 ? form->way[k] / fmax(way * way, 1e-12) : 0;
	form->moved = fmin(way / form->half_across, 1);
	form->stamps = fmin(1 - form->moved, probe->stamped);
}
