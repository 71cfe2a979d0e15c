/* Prepares a body's form and motion for the law. */
#include "soil/law/form.h"

#include "soil/shape/bars.h"
#include "soil/shape/body.h"

static void into_frame(const struct soil_body *body, double v[2])
{
	const double east = v[0], north = v[1];
	v[0] = body->axis[0] * east + body->axis[1] * north;
	v[1] = body->axis[0] * north - body->axis[1] * east;
}

static void put(float to[2], const struct soil_body *body, const double v[2])
{
	double turned[2] = {v[0], v[1]};
	into_frame(body, turned);
	to[0] = (float)turned[0];
	to[1] = (float)turned[1];
}

static void put3(float to[3], const struct soil_body *body, const double v[3])
{
	put(to, body, v);
	to[2] = (float)v[2];
}

static void look_along(struct soil_body *body, const double v[2])
{
	const double length = hypot(v[0], v[1]);
	body->axis[0] = length > 0 ? v[0] / length : 1;
	body->axis[1] = length > 0 ? v[1] / length : 0;
}

/* run, rises: of the circles in the whole motion, m. */
static void put_run(struct soil_form *form, double run, double rises)
{
	const double rise = run > 0 ? rises / run : 0, lift = form->lift;
	form->run = (float)run;
	form->rise = (float)rise;
	form->sine = (float)(rise / sqrt(lift * lift + rise * rise));
	form->plunge = (float)(rises / lift);
}

/* A wheel, or a cylinder. The frame looks across its axis. In the plane across the axis it moves as a level wheel does. */
static void put_cylinder(struct soil_body *body, struct soil_form *form, const double way[3])
{
	const struct lower_envelope *lower = &body->lower;
	const double c = fmax(lower->level, FORM_LEVEL_LEAST), s = lower->axis[2], x = lower->along[1], y = -lower->along[0];
	const double forward = way[0] * x + way[1] * y, aside = way[0] * lower->along[0] + way[1] * lower->along[1], sign = forward < 0 ? -1 : 1;
	form->kind = s <= FORM_LEANS_MOST ? FORM_RIM : FORM_END;
	form->lean = (float)(sign * s);
	form->level = (float)c;
	form->lift = (float)(1 / c);
	form->rim_level = form->kind == FORM_RIM ? (float)c : 1;
	form->half_axis = (float)lower->half;
	form->half[1] = form->kind == FORM_RIM ? (float)(lower->half * c) : 0;
	body->axis[0] = sign * x;
	body->axis[1] = sign * y;
	put_run(form, fabs(forward), way[2] - aside * s / c);
}

static void put_capsule(struct soil_body *body, struct soil_form *form, const double way[3])
{
	look_along(body, way);
	form->kind = FORM_CAPSULE;
	form->lean = (float)body->lower.axis[2];
	form->level = (float)fmax(body->lower.level, FORM_LEVEL_LEAST);
	form->half_axis = (float)body->lower.half;
	put(form->along, body, body->lower.along);
}

/* A ball is an ellipsoid. `lower`: of that. */
static void put_ball(struct soil_body *body, struct soil_form *form, const double way[3])
{
	const struct lower_envelope *lower = &body->lower;
	look_along(body, way);
	const double *q = lower->inside, x = body->axis[0], y = body->axis[1];
	const double ahead = q[0] * x * x + 2 * q[1] * x * y + q[2] * y * y, both = (q[2] - q[0]) * x * y + q[1] * (x * x - y * y);
	const double beside = q[0] * y * y - 2 * q[1] * x * y + q[2] * x * x;
	form->kind = FORM_BALL;
	form->ahead_by = (float)ahead;
	form->skew = (float)(both / ahead);
	form->aside_by = (float)(beside - both * both / ahead);
	form->shrinks = (float)sqrt((q[0] + q[2]) / 2 + hypot((q[0] - q[2]) / 2, q[1]));
	form->drop = (float)lower->lift;
	form->lift = (float)(lower->lift * sqrt(ahead));
	put(form->tilt, body, lower->rise);
	put_run(form, hypot(way[0], way[1]), way[2] - lower->rise[0] * way[0] - lower->rise[1] * way[1]);
}

/* Returns true if a side of a box is no part of its lower envelope. A strip of less than a quarter of a post counts as none. */
static bool is_upright(double half[3][3], int side, double spacing)
{
	double length[3], steepest = 0, height = 0;
	for (int k = 0; k < 3; k++) {
		length[k] = sqrt(half[k][0] * half[k][0] + half[k][1] * half[k][1] + half[k][2] * half[k][2]);
		if (fabs(half[k][2]) / length[k] > steepest) {
			steepest = fabs(half[k][2]) / length[k];
			height = 2 * length[k];
		}
	}
	const double leans = fabs(half[side][2]) / length[side];
	return leans < 1e-6 || (leans < steepest && leans * height < 0.25 * spacing);
}

/* A box with pitch and roll has six sides in plan. Its edges are not computed: each post that it covers bears for its whole cell. A corner that is
 * cut off by less than a tenth of a post does not count. */
static bool is_cut(const double size[3], const struct soil_pose *pose, double spacing)
{
	const double thinnest = fmin(size[0], fmin(size[1], size[2]));
	return fabs(sin(pose->pitch) * sin(pose->roll)) * thinnest > 0.1 * spacing;
}

#define TILT_WHOLE 0.0175 /* sine of a sole's tilt: a box that is tilted by less is partly computed as a level one */
#define TILT_LEAST 1e-6

/* Adds the wall `face` to a box. It rises from the edge that it has in common with a sole. a: half axes of the box in its frame, all upwards. steepest: it
 * has two such edges, and above each the part that is steepest from there. */
static void put_wall(double a[3][3], int face, int sole, bool steepest, struct soil_form *form)
{
	const int along = 3 - face - sole;
	const double length = sqrt(a[face][0] * a[face][0] + a[face][1] * a[face][1] + a[face][2] * a[face][2]), level = a[face][0] * a[face][0] + a[face][1] * a[face][1];
	struct soil_box_wall *wall = &form->walls[form->wall_count++];
	*wall = (struct soil_box_wall){.sole = sole, .face = face, .low = (float)(-a[face][2] - a[sole][2])};
	double up[3];
	for (int k = 0; k < 3; k++) {
		up[k] = steepest ? (k < 2 ? -a[face][k] * a[face][2] / level : 1) * 2 * length : 2 * a[sole][k];
		wall->up[k] = (float)up[k];
		wall->back[k] = (float)(2 * a[face][k]);
		wall->normal[k] = (float)(a[face][k] / length);
	}
	for (int k = 0; k < 2; k++) {
		wall->at[k] = (float)(-a[face][k] - a[sole][k]);
		wall->along[k] = (float)a[along][k];
	}
	wall->wide = (float)(fabs(a[along][0] * up[1] - a[along][1] * up[0]) / hypot(a[along][0], a[along][1]));
}

/* Sets the soles and walls of a tilted box. sides: half of its axes, in the frame. */
static void put_soles(double sides[3][3], const bool upright[3], struct soil_form *form)
{
	double a[3][3], up[3], flattest = 0;
	int soles = 0;
	for (int k = 0; k < 3; k++) {
		const double length = sqrt(sides[k][0] * sides[k][0] + sides[k][1] * sides[k][1] + sides[k][2] * sides[k][2]);
		up[k] = fabs(sides[k][2]) / length;
		flattest = fmax(flattest, up[k]);
		for (int i = 0; i < 3; i++)
			a[k][i] = sides[k][2] < 0 ? -sides[k][i] : sides[k][i];
		a[k][2] = fmax(a[k][2], TILT_LEAST * length); /* an upright side is a wall as soon as it turns either way */
	}
	const double tilt = sqrt(fmax(1 - flattest * flattest, 0));
	form->tilts = tilt > TILT_LEAST ? (float)fmin(tilt / TILT_WHOLE, 1) : 0;
	for (int k = 0; k < 3; k++) {
		const int i = (k + 1) % 3, j = (k + 2) % 3;
		form->is_sole[k] = up[k] >= FORM_WALL_LEAST && !upright[k];
		soles += form->is_sole[k];
		for (int n = 0; n < 2; n++) {
			form->soles[k].middle[n] = (float)-a[k][n];
			form->soles[k].half[0][n] = (float)a[i][n];
			form->soles[k].half[1][n] = (float)a[j][n];
		}
	}
	form->wall_count = 0;
	for (int k = 0; k < 3; k++)
		for (int n = 0; n < 3; n++)
			if (!form->is_sole[k] && form->is_sole[n])
				put_wall(a, k, n, soles > 1, form);
}

static void put_box(struct soil_body *body, struct soil_form *form, double spacing)
{
	const struct soil_pose *to = &body->motion->to;
	const double *size = body->motion->shape->size;
	double sides[3][3];
	bool uprights[3];
	soil_body_axes(size, to->yaw, to->pitch, to->roll, sides);
	body->axis[0] = cos(to->yaw);
	body->axis[1] = sin(to->yaw);
	form->kind = FORM_BOX;
	for (int k = 0; k < 3; k++) {
		double *axis = sides[k];
		const double squares = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2];
		const bool upright = uprights[k] = is_upright(sides, k, spacing);
		into_frame(body, axis);
		form->faces[k][0] = upright ? -1e9f : (float)(-squares / fabs(axis[2]));
		form->faces[k][1] = upright ? 0 : (float)(-axis[0] / axis[2]);
		form->faces[k][2] = upright ? 0 : (float)(-axis[1] / axis[2]);
	}
	put_soles(sides, uprights, form);
	for (int k = 0; k < 3; k++) {
		const double length = hypot(sides[k][0], sides[k][1]), across[2] = {length > 1e-9 ? -sides[k][1] / length : 1, length > 1e-9 ? sides[k][0] / length : 0};
		double half = 0;
		for (int i = 0; i < 3; i++)
			half += fabs(across[0] * sides[i][0] + across[1] * sides[i][1]);
		form->slabs[k][0] = (float)across[0];
		form->slabs[k][1] = (float)across[1];
		form->slabs[k][2] = (float)(length > 1e-9 ? half : 1e9);
	}
	if (is_cut(size, to, spacing))
		return;
	form->half[0] = (float)(fabs(cos(to->pitch)) * size[0] / 2 + fabs(sin(to->pitch)) * size[2] / 2);
	form->half[1] = (float)(fabs(cos(to->roll)) * size[1] / 2 + fabs(sin(to->roll)) * size[2] / 2);
}

static void put_shape(struct soil_body *body, struct soil_form *form, double spacing, const double way[3])
{
	const struct soil_shape *shape = body->motion->shape;
	switch (shape->kind) {
	case SOIL_WHEEL:
	case SOIL_CYLINDER:
		put_cylinder(body, form, way);
		break;
	case SOIL_CAPSULE:
		put_capsule(body, form, way);
		break;
	case SOIL_SPHERE:
	case SOIL_ELLIPSOID:
		put_ball(body, form, way);
		break;
	case SOIL_BOX:
		put_box(body, form, spacing);
		break;
	case SOIL_MESH:
	case SOIL_SHAPES:
		form->kind = FORM_RASTER;
		look_along(body, way);
		break;
	}
}

void soil_form_spin(const struct soil_motion *motion, double spin[3])
{
	const struct soil_pose *from = &motion->from, *to = &motion->to;
	const bool wheel = motion->shape->kind == SOIL_WHEEL;
	double axes[3][3];
	soil_axes(to->yaw, wheel ? 0 : to->pitch, to->roll, 0, axes);
	const double yaw = remainder(to->yaw - from->yaw, 2 * M_PI), pitch = wheel ? 0 : remainder(to->pitch - from->pitch, 2 * M_PI);
	const double roll = remainder(to->roll - from->roll, 2 * M_PI);
	for (int k = 0; k < 3; k++) {
		spin[k] = motion->hosted && !wheel ? motion->rotated[k] : axes[0][k] * roll - axes[1][k] * pitch + (k == 2 ? yaw : 0);
		spin[k] += wheel ? axes[1][k] * motion->turned : 0;
	}
}

double soil_form_level_share(double forward, double rise)
{
	return forward > 0 ? fmin(fmax(2 - fabs(rise / forward), 0), 1) : 0;
}

void soil_form_split(const struct soil_form *form, const float spin[3], float rolling[3], float turning[3])
{
	const float about = dot3(spin, form->roll_axis);
	for (int k = 0; k < 3; k++) {
		rolling[k] = form->rolls_about == ROLLS_NOT ? 0 : form->rolls_about == ROLLS_ABOUT_AXIS ? about * form->roll_axis[k] : k < 2 ? spin[k] : 0;
		turning[k] = spin[k] - rolling[k];
	}
}

/* axis: of a body that rolls about it alone; NULL: about any level axis. flat: about none. */
static void split_spin(struct soil_form *form, const float axis[3], bool flat)
{
	form->rolls_about = flat ? ROLLS_NOT : axis != NULL ? ROLLS_ABOUT_AXIS : ROLLS_ABOUT_LEVEL;
	for (int k = 0; k < 3; k++)
		form->roll_axis[k] = axis != NULL ? axis[k] : 0;
	soil_form_split(form, form->spin, form->rolling, form->turning);
}

static void put_rolling(struct soil_form *form)
{
	const float axis[3] = {0, form->level, form->lean};
	split_spin(form, form->kind == FORM_RIM ? axis : NULL, form->kind == FORM_BOX || form->kind == FORM_END);
}

/* A rim, a belt or a drum that is locked while its body goes on is the limit of one that runs slowly. Wong and Reece count the slip of a place of the
 * rim for as long as it is in the soil. forward: m, of its way across its axis; rolls: it is one of these. */
static void put_standing(struct soil_form *form, double forward, double radius, bool rolls)
{
	const double plan = (double)form->passes[0], turns = sqrt((double)dot3(form->turning, form->turning)) * radius;
	form->ahead = plan > 0 ? (float)(forward * forward / (plan * plan)) : 1;
	form->locked = plan > 0 && rolls ? (float)(plan * plan / (plan * plan + turns * turns)) : 0;
}

void soil_form_drum(const struct soil_body *body, const double axis[3], double radius, struct soil_form *form)
{
	float turned[3];
	put3(turned, body, axis);
	const bool rolls = fabs(axis[2]) <= FORM_LEANS_MOST;
	const float level = (float)hypot(axis[0], axis[1]);
	split_spin(form, turned, !rolls);
	form->rim_level = rolls ? level : 1;
	form->rim_reach = (float)radius;
	form->bulges = (float)(fabs(axis[2]) / radius);
	put_standing(form, rolls ? (double)(form->way[0] * turned[1] - form->way[1] * turned[0]) / fmax(hypot(axis[0], axis[1]), FORM_LEVEL_LEAST) : 0, radius, rolls);
}

/* Sets how long a rim is above a place, and above one below its bars. It is what time_of of bear_block.h tells of other bodies. All around a rim it is the
 * same, so it is found once. */
static void put_times(const struct soil_body *body, struct soil_form *form, const double way[3])
{
	const bool rim = form->kind == FORM_RIM;
	const double yaw = body->motion->to.yaw, radius = (double)form->radius, ran = sqrt((double)dot3(form->rolling, form->rolling)) * radius;
	double times[2], rolls[2];
	put_standing(form, rim ? (double)form->way[0] : way[0] * cos(yaw) + way[1] * sin(yaw), radius, rim || body->motion->shape->belt);
	for (int k = 0; k < 2; k++) {
		const double passes = (double)form->passes[k], share = ran > 0.1 * passes ? fmax(passes / ran, 0.1) : 10;
		times[k] = 1 + (share - 1) * (double)(form->ahead * form->rolls);
		rolls[k] = fmax(fmin(10 * ran / fmax(passes, 1e-30), 1), (double)form->locked);
	}
	form->rim_time[0] = (float)(1 - rolls[0]);
	form->rim_time[1] = (float)(rolls[0] * times[0]);
	form->rim_digs = (float)(1 + rolls[1] * (times[1] - 1));
}

/* Sets how fast the body moves and turns. A body on a path has no rates, but its motion took some time. */
static void put_speeds(const struct soil_body *body, const double way[3], const double spin[3], struct soil_form *form)
{
	const struct soil_motion *motion = body->motion;
	const double by = motion->seconds > 0 && !motion->jumped ? 1 / motion->seconds : 0;
	double goes[3], turns[3];
	for (int k = 0; k < 3; k++) {
		goes[k] = motion->linear[k] + way[k] * by;
		turns[k] = motion->angular[k] + spin[k] * by;
	}
	put3(form->goes, body, goes);
	put3(form->turns, body, turns);
}

static void put_motion(const struct soil_law *law, struct soil_body *body, struct soil_form *form, const double way[3])
{
	const struct soil_motion *motion = body->motion;
	const struct soil_pose *to = &motion->to;
	const bool wheel = motion->shape->kind == SOIL_WHEEL;
	double axes[3][3], spin[3];
	soil_axes(to->yaw, wheel ? 0 : to->pitch, to->roll, 0, axes);
	soil_form_spin(motion, spin);
	put3(form->way, body, way);
	put3(form->spin, body, spin);
	put_rolling(form);
	put3(form->linear, body, motion->linear);
	put3(form->angular, body, motion->angular);
	put_speeds(body, way, spin, form);
	form->reach = (float)soil_shape_reach(&body->smooth, to->pitch, to->roll);
	if (wheel)
		form->reach = form->radius;
	form->rim_reach = form->reach;
	form->belt_level = 1;
	if (motion->shape->belt) {
		put3(form->belt, body, axes[1]);
		form->belt_level = (float)hypot(axes[1][0], axes[1][1]);
		form->ran = (float)motion->turned;
		form->runs = (float)motion->runs;
	}
	const double plan = hypot(way[0], way[1]), turned = sqrt(spin[0] * spin[0] + spin[1] * spin[1]) * form->reach + fabs((double)form->ran);
	const double rise = soil_form_level_share(plan, way[2]) * way[2];
	form->passes[0] = (float)plan;
	form->passes[1] = (float)hypot(plan, rise);
	form->along_ground = plan > 0 ? (float)(hypot(plan, rise) / plan) : 1;
	form->rolls = (float)soil_form_level_share(fmax(plan, turned), way[2]);
	put_times(body, form, way);
	for (int k = 0; k < 2; k++)
		form->by_way[k] = plan > 0 ? (float)((double)form->way[k] / fmax(plan * plan, 1e-12)) : 0;
	form->moved = (float)fmin(plan / (double)form->half_across, 1);
	form->stamps = (float)fmin(1 - (double)form->moved, motion->hosted ? motion->stamped : 1);
	form->prints = (float)fmin(fmax(2 - 2 * plan / law->spacing, 0), 1);
	form->digs_most = (float)law->slip_sinkage;
}

static void put_cell(const struct soil_law *law, const struct soil_body *body, struct soil_form *form)
{
	const double *axis = body->axis, larger = fmax(fabs(axis[0]), fabs(axis[1])), spacing = law->spacing;
	const bool northward = fabs(axis[1]) > fabs(axis[0]);
	const double ahead[2][2] = {{copysign(spacing, axis[0]), 0}, {0, copysign(spacing, axis[1])}};
	const double aside[2][2] = {{0, copysign(spacing, axis[0])}, {copysign(spacing, -axis[1]), 0}};
	form->spacing = (float)spacing;
	form->half_across = (float)(0.5 * spacing / (form->kind == FORM_RIM ? larger : 1));
	form->step_aside = (float)(larger * spacing);
	form->by_step = (float)(1 / (larger * spacing));
	put(form->cut[0], body, ahead[northward]);
	put(form->cut[1], body, aside[northward]);
}

/* A ball's lower envelope is that of an ellipsoid. bars: the share in which bars carry the soil between them, as a drum over their tips does. */
static void put_lower(const struct soil_motion *motion, double bars, struct soil_body *body)
{
	const struct soil_shape *shape = motion->shape;
	body->smooth = *shape;
	body->smooth.grousers = 0;
	body->smooth.radius += bars * shape->grouser_height;
	if (shape->kind == SOIL_SPHERE) {
		body->smooth.kind = SOIL_ELLIPSOID;
		for (int k = 0; k < 3; k++)
			body->smooth.size[k] = shape->radius;
	}
	soil_lower_of(&body->smooth, &motion->to, &body->lower);
	body->lower.beside = FORM_BESIDE;
}

void soil_form_of(const struct soil_law *law, const struct soil_motion *motion, struct soil_body *body, struct soil_form *form)
{
	const struct soil_pose *from = &motion->from, *to = &motion->to;
	const struct soil_interface *interface = &motion->interface;
	*body = (struct soil_body){.motion = motion, .axis = {1, 0}, .outer = soil_body_wheel_radius(motion->shape)};
	*form = (struct soil_form){.lift = 1, .level = 1, .rim_level = 1, .radius = (float)motion->shape->radius, .ground_normals = law->ground_normals ? 1 : 0,
				    .all_round = law->faces && !law->ground_normals ? 1 : 0};
	const int64_t place[3] = {to->x, to->y, to->z}, before[3] = {from->x, from->y, from->z};
	double way[3];
	const bool jumped = motion->jumped;
	for (int k = 0; k < 3; k++) {
		body->centre[k] = lattice_offset_metres(place[k]) + motion->beyond[k];
		way[k] = jumped ? 0 : lattice_offset_metres(place[k] - before[k]) + motion->beyond[k];
	}
	const double bars = form->all_round > 0 ? soil_bars_carry(motion->shape) : 0;
	form->bars = (float)bars;
	form->bars_beyond = (float)(bars > 0 ? bars * motion->shape->grouser_height / (motion->shape->radius + bars * motion->shape->grouser_height) : 0);
	put_lower(motion, bars, body);
	if (motion->shape->kind == SOIL_WHEEL)
		form->radius = (float)body->smooth.radius;
	if (form->all_round > 0)
		body->outer = soil_body_wheel_radius(&body->smooth);
	put_shape(body, form, law->spacing, way);
	for (int k = 0; k < 2; k++)
		form->enters[k][0] = form->enters[k][1] = form->half[k];
	if (!(form->radius > 0))
		form->radius = (float)soil_shape_bound(motion->shape);
	form->by_radius = 1 / form->radius;
	form->outer = motion->shape->kind == SOIL_WHEEL ? (float)body->outer : form->radius;
	put_cell(law, body, form);
	put_motion(law, body, form, way);
	for (int k = 0; k < 3; k++)
		body->way[k] = (double)form->way[k];
	form->beyond = (float)motion->beyond[2];
	form->by_arm = (float)exp2(-ceil(log2(soil_shape_bound(motion->shape))));
	bool moves = motion->runs != 0;
	for (int k = 0; k < 3; k++)
		moves = moves || motion->linear[k] != 0 || motion->angular[k] != 0;
	form->rates = moves ? 1 : 0;
	form->bulldozing = (float)law->bulldozing;
	const struct soil_tyre *tyre = &motion->shape->tyre;
	if (tyre->stiffness > 0 && form->kind == FORM_RIM) {
		form->tyre_holds = (float)tyre->pressure;
		form->tyre_stiff = (float)tyre->stiffness;
		form->tyre_grows = (float)tyre->growth;
		form->tyre_damps = (float)tyre->damping;
		form->rim_reach -= (float)tyre->deflection; /* about which it rolls without slip */
	}
	form->surface = (struct stress_surface){
		.adhesion = interface->has_adhesion ? (float)interface->adhesion : 0,
		.tangent = interface->has_friction ? (float)tan(interface->friction_angle) : 0,
		.own = {interface->has_adhesion ? 0 : 1, interface->has_friction ? 0 : 1},
		.carries = form->bars,
	};
}
