/* Round geoms that are no cylinders and turn as wheels: spheres, capsules, ellipsoids, and meshes whose tread is too rough for a wheel. The soil takes them as
 * what they are; here is how they slip. */
#include <math.h>

#include "vehicle/internal.h"

#define MIDDLE 0.1   /* of the radius: how far the hinge may be from the geom's middle */
#define ROUND 0.8    /* of its radius a round geom reaches in all directions across its axle */
#define UPRIGHT 0.5  /* how much of an axle may look up */
#define AROUND 16    /* directions across the axle */
#define AT_REST 1e-3 /* m/s: the slip of a rim that is slower would be noise */

/* Finds how far the geom reaches across its hinge: the most and the least. */
static void reach_across(const struct vehicle *vehicle, int geom, int joint, double *most, double *least)
{
	const double *axle = &vehicle->data->xaxis[3 * joint], *anchor = &vehicle->data->xanchor[3 * joint];
	const double any[3] = {fabs(axle[0]) < 0.5, fabs(axle[0]) >= 0.5, 0};
	double forward[3], up[3];
	mju_cross(forward, axle, any);
	mju_normalize3(forward);
	mju_cross(up, axle, forward);
	*most = 0;
	*least = INFINITY;
	for (int i = 0; i < AROUND; i++) {
		double direction[3], place[3];
		mju_scl3(direction, forward, cos(2 * M_PI * i / AROUND));
		mju_addToScl3(direction, up, sin(2 * M_PI * i / AROUND));
		vehicle_geom_support(vehicle->model, vehicle->data, geom, direction, place);
		mju_sub3(place, place, anchor);
		const double reach = mju_dot3(place, direction);
		*most = fmax(*most, reach);
		*least = fmin(*least, reach);
	}
}

/* Returns true if the geom is round about this hinge, and near its middle. */
static bool turns_about(const struct vehicle *vehicle, int geom, int joint, double *radius)
{
	const double *axle = &vehicle->data->xaxis[3 * joint];
	double from[3], beside[3], least;
	if (vehicle->model->jnt_type[joint] != mjJNT_HINGE || fabs(axle[2]) > UPRIGHT)
		return false;
	reach_across(vehicle, geom, joint, radius, &least);
	mju_sub3(from, &vehicle->data->geom_xpos[3 * geom], &vehicle->data->xanchor[3 * joint]);
	mju_addScl3(beside, from, axle, -mju_dot3(from, axle));
	return *radius > 0 && least >= ROUND * *radius && mju_norm3(beside) <= MIDDLE * *radius;
}

void vehicle_find_roll(const struct vehicle *vehicle, struct soil_geom *geom)
{
	const mjModel *model = vehicle->model;
	const int kind = geom->shape.kind;
	int body = model->geom_bodyid[geom->geom];
	if (kind == SOIL_WHEEL || kind == SOIL_BOX || kind == SOIL_CYLINDER || geom->shape.belt) /* a cylinder that turns about another axis than its own is a mistake */
		return;
	while (body > 0 && model->body_jntnum[body] == 0)
		body = model->body_parentid[body];
	for (int j = 0; j < model->body_jntnum[body] && geom->roll_dof < 0; j++) {
		const int joint = model->body_jntadr[body] + j;
		double radius;
		if (!turns_about(vehicle, geom->geom, joint, &radius))
			continue;
		geom->roll_dof = model->jnt_dofadr[joint];
		geom->roll_radius = radius;
	}
}

void vehicle_tell_roll(const struct vehicle *vehicle, struct soil_geom *geom)
{
	const double *axle = &vehicle->data->xaxis[3 * vehicle->model->dof_jntid[geom->roll_dof]];
	const double *normal = geom->contact.state == FURROW_AIR || !(geom->contact.normal[2] > 0) ? (const double[3]){0, 0, 1} : geom->contact.normal;
	double heading[3], axes[9];
	mju_cross(heading, axle, normal);
	if (mju_normalize3(heading) < 1e-6)
		return;
	/* An axle that looks to the right has the opposite heading and turn. So its slip has the same sign, and its speed the other one. */
	vehicle_root_axes(vehicle, vehicle->data, axes);
	const double side = axle[0] * axes[1] + axle[1] * axes[4] + axle[2] * axes[7] < 0 ? -1 : 1;
	const double rim = geom->roll_radius * mju_dot3(geom->now.angular, axle), along = mju_dot3(geom->now.linear, heading);
	geom->contact.slip = fabs(rim) > AT_REST ? 1 - along / rim : (double)NAN;
	geom->contact.slip_velocity = side * (rim - along);
}
