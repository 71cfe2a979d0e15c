/*
 * Fills the parameters from which lib/scm_body.glsl computes the lower envelope of an object between posts, for the stresses of scm.
 * At posts the lower envelope still comes from shape/envelope.c, in whole numbers.
 */
#include <math.h>

#include "soil/shape/body.h"
#include "soil/shape/lower_envelope.h"
#include "deform/internal.h"

static void put_heading(struct scm_params *params, double x, double y)
{
	params->heading[0] = (float)x;
	params->heading[1] = (float)y;
	params->heading[2] = (float)fmax(fabs(x), fabs(y));
}

/* Returns how much of a rise counts as a way along the ground. From a slope of 1 to one of 2 that is less and less. */
static double level_share(double forward, double rise)
{
	return forward != 0 ? fmin(fmax(2 - fabs(rise / forward), 0), 1) : 0;
}

double deform_way_along(double forward, double rise)
{
	return copysign(hypot(forward, level_share(forward, rise) * rise), forward);
}

/* passes: the body's way, metres. */
static double time_of_rim(double forward, double way, double rise, double ran, double passes, bool hosted)
{
	double aligned = way > 0 ? forward * forward / (way * way) : hosted;
	/* A body that moves up or down neither rolls nor spins. */
	if (hosted)
		aligned *= level_share(fmax(fabs(forward), ran), rise);
	double share = ran > 0.1 * passes ? fmax(passes / ran, 0.1) : 10;
	return 1 + (share - 1) * aligned;
}

struct deform_rim_times deform_rim_times_of(double forward, double way, double rise, double ran, bool hosted)
{
	const double along = hypot(way, level_share(forward, rise) * rise);
	return (struct deform_rim_times){time_of_rim(forward, way, rise, fabs(ran), way, hosted), time_of_rim(forward, way, rise, fabs(ran), along, hosted)};
}

static void put_times(const struct deform *deform, const struct deform_contact *contact, double forward, double rise, struct scm_params *params)
{
	if (deform->params.ground_normals)
		return;
	const double way = hypot(params->way[0], params->way[1]), ran = soil_shape_ran(contact->shape, contact->turned);
	const struct deform_rim_times times = deform_rim_times_of(forward, way, rise, ran, contact->hosted);
	params->moves[3] = (float)times.shears;
	params->digs[0] = (float)times.digs;
}

/* Turns the level part of a vector so that it is along the axes of a frame. heading: its x axis. */
static void turn(const float heading[2], float v[2])
{
	double east = v[0], north = v[1];
	v[0] = (float)(heading[0] * east + heading[1] * north);
	v[1] = (float)(heading[0] * north - heading[1] * east);
}

static void wheel(const struct deform *deform, const struct deform_contact *contact, struct scm_params *params)
{
	double yaw = contact->to.yaw, x = cos(yaw), y = sin(yaw);
	double forward = params->way[0] * x + params->way[1] * y;
	/* A wheel looks the same from both sides. So forwards is where it moves. */
	double sign = forward < 0 ? -1 : 1, slope = forward != 0 ? params->way[2] / fabs(forward) : 0;
	params->body[0] = (float)contact->shape->radius;
	params->body[1] = (float)(contact->shape->width / 2);
	put_heading(params, sign * x, sign * y);
	params->moves[0] = (float)fabs(forward);
	params->moves[1] = (float)slope;
	params->moves[2] = (float)(slope / hypot(1, slope));
	put_times(deform, contact, forward, params->way[2], params);
}

static void along_way(struct scm_params *params, double way)
{
	put_heading(params, way > 0 ? params->way[0] / way : 1, way > 0 ? params->way[1] / way : 0);
}

static void sphere(const struct deform_contact *contact, struct scm_params *params)
{
	double way = hypot(params->way[0], params->way[1]), slope = way > 0 ? params->way[2] / way : 0;
	params->body[0] = (float)contact->shape->radius;
	along_way(params, way);
	params->moves[0] = (float)way;
	params->moves[1] = (float)slope;
	params->moves[2] = (float)(slope / hypot(1, slope));
}

bool deform_box_is_cut(const struct soil_shape *shape, const struct soil_pose *pose, double spacing, bool hosted)
{
	const double *size = shape->size, least = fmin(size[0], fmin(size[1], size[2]));
	const double cut = fabs(sin(pose->pitch) * sin(pose->roll)) * least;
	return pose->pitch != 0 && pose->roll != 0 && (!hosted || cut > 0.1 * spacing);
}

bool deform_box_is_upright(const double half[3][3], int side, double spacing, bool hosted)
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
	return leans < 1e-6 || (hosted && leans < steepest && leans * height < 0.25 * spacing);
}

/* A cylinder, or a wheel with camber. The frame looks across its axis. In the plane across the axis it moves as a level wheel does. */
static void cylinder(const struct deform *deform, const struct deform_contact *contact, struct scm_params *params)
{
	struct lower_envelope lower;
	soil_lower_of(contact->shape, &contact->to, &lower);
	double c = fmax(lower.level, DEFORM_LEVEL_LEAST), s = lower.axis[2], x = lower.along[1], y = -lower.along[0];
	double forward = params->way[0] * x + params->way[1] * y, aside = params->way[0] * lower.along[0] + params->way[1] * lower.along[1];
	double sign = forward < 0 ? -1 : 1, rise = params->way[2] - aside * s / c, slope = forward != 0 ? rise / fabs(forward) : 0;
	bool strips = s <= DEFORM_LEANS_MOST;
	params->body[0] = (float)lower.radius;
	params->body[1] = strips ? (float)(lower.half * c) : 0;
	put_heading(params, sign * x, sign * y);
	params->moves[0] = (float)fabs(forward);
	params->moves[1] = (float)slope;
	params->moves[2] = (float)(slope * c / hypot(1, slope * c));
	if (strips)
		put_times(deform, contact, forward, rise, params);
	params->faces[0][0] = (float)(sign * s);
	params->faces[1][0] = (float)c;
	params->faces[2][0] = (float)lower.half;
}

static void capsule(const struct deform_contact *contact, struct scm_params *params)
{
	struct lower_envelope lower;
	soil_lower_of(contact->shape, &contact->to, &lower);
	params->body[0] = (float)lower.radius;
	along_way(params, hypot(params->way[0], params->way[1]));
	params->faces[0][0] = (float)lower.axis[2];
	params->faces[1][0] = (float)fmax(lower.level, DEFORM_LEVEL_LEAST);
	params->faces[2][0] = (float)lower.half;
	for (int k = 0; k < 2; k++)
		params->faces[0][1 + k] = (float)lower.along[k];
}

static void ellipsoid(const struct deform_contact *contact, struct scm_params *params)
{
	struct lower_envelope lower;
	double way = hypot(params->way[0], params->way[1]);
	soil_lower_of(contact->shape, &contact->to, &lower);
	along_way(params, way);
	/* The quadric in the frame: squares = ahead x^2 + 2 both x y + beside y^2. */
	const double *q = lower.inside, x = params->heading[0], y = params->heading[1];
	double ahead = q[0] * x * x + 2 * q[1] * x * y + q[2] * y * y, both = (q[2] - q[0]) * x * y + q[1] * (x * x - y * y);
	double beside = q[0] * y * y - 2 * q[1] * x * y + q[2] * x * x, lift = lower.lift * sqrt(ahead);
	double rise = params->way[2] - lower.rise[0] * params->way[0] - lower.rise[1] * params->way[1], slope = way > 0 ? rise / way : 0;
	params->body[0] = (float)(1 / sqrt(ahead));
	params->moves[0] = (float)way;
	params->moves[1] = (float)slope;
	params->moves[2] = (float)(slope / hypot(lift, slope));
	params->faces[0][0] = (float)lower.lift;
	for (int k = 0; k < 2; k++)
		params->faces[0][1 + k] = (float)lower.rise[k];
	params->faces[1][0] = (float)ahead;
	params->faces[1][3] = (float)(both / ahead);
	params->faces[2][0] = (float)(beside - both * both / ahead);
	params->faces[2][3] = (float)sqrt((q[0] + q[2]) / 2 + hypot((q[0] - q[2]) / 2, q[1]));
}

static void box(const struct deform_contact *contact, struct scm_params *params)
{
	const struct soil_pose *to = &contact->to;
	double half[3][3];
	soil_body_axes(contact->shape->size, to->yaw, to->pitch, to->roll, half);
	put_heading(params, cos(to->yaw), sin(to->yaw));
	for (int k = 0; k < 3; k++) {
		const double *axis = half[k];
		double squares = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2];
		bool upright = deform_box_is_upright((const double(*)[3])half, k, params->scale[1], contact->hosted);
		params->faces[k][0] = upright ? -1e9f : (float)(-squares / fabs(axis[2]));
		params->faces[k][1] = upright ? 0 : (float)(-axis[0] / axis[2]);
		params->faces[k][2] = upright ? 0 : (float)(-axis[1] / axis[2]);
	}
	if (deform_box_is_cut(contact->shape, to, params->scale[1], contact->hosted))
		return;
	params->heading[3] = (float)(fabs(cos(to->pitch)) * contact->shape->size[0] / 2 + fabs(sin(to->pitch)) * contact->shape->size[2] / 2);
	params->body[1] = (float)(fabs(cos(to->roll)) * contact->shape->size[1] / 2 + fabs(sin(to->roll)) * contact->shape->size[2] / 2);
}

static void belt(const struct deform *deform, const struct deform_contact *contact, struct scm_params *params)
{
	double forward = params->way[0] * cos(contact->to.yaw) + params->way[1] * sin(contact->to.yaw);
	put_times(deform, contact, forward, params->way[2], params);
}

void deform_between_posts(const struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
		      struct scm_params *params)
{
	deform_posts_in(window, post_rect_intersect(deform_shadow(deform, contact), window->read), params->drawn);
	put_heading(params, 1, 0);
	switch (soil_kind_in(contact->shape, &contact->to)) {
	case SOIL_WHEEL:
		wheel(deform, contact, params);
		break;
	case SOIL_SPHERE:
		sphere(contact, params);
		break;
	case SOIL_BOX:
		box(contact, params);
		break;
	case SOIL_CYLINDER:
		cylinder(deform, contact, params);
		break;
	case SOIL_CAPSULE:
		capsule(contact, params);
		break;
	case SOIL_ELLIPSOID:
		ellipsoid(contact, params);
		break;
	case SOIL_MESH:
	case SOIL_SHAPES:
		break; /* only its posts tell */
	}
	if (contact->shape->belt)
		belt(deform, contact, params);
}

void deform_turn_into_frame(struct scm_params *params)
{
	turn(params->heading, params->way);
	turn(params->heading, params->spin);
	turn(params->heading, params->rolls);
	turn(params->heading, params->belt);
	for (int k = 0; k < 3; k++)
		turn(params->heading, &params->faces[k][1]);
}
