/* What a model has: its joints and actuators, what they are for, and how large it is. */
#include <math.h>
#include <string.h>
#include <strings.h>

#define VEHICLE_NAMES_HERE
#include "vehicle/internal.h"

#define UPRIGHT 0.7  /* how much of the axis of a joint that steers looks up */
#define LEVEL 0.5    /* and of a wheel's at most */
#define BELOW 0.5    /* of its radius: how far a wheel's lowest point may be above the ground */
#define TRAIL 0.2    /* of the radius: a wheel that trails its upright joint by more is a castor's */

/* Finds the wheel or belt of a joint that is on the ground; NULL: there is none. */
static const struct soil_geom *wheel_of(const struct vehicle *vehicle, int joint)
{
	const struct soil_geom *wheel = vehicle_driven(vehicle, joint);
	double ground = INFINITY, bottom = INFINITY;
	if (wheel == NULL || fabs(vehicle->data->xaxis[3 * joint + 2]) > LEVEL)
		return NULL;
	for (size_t g = 0; g < vehicle->geom_count; g++) {
		const double low = vehicle_geom_lowest(vehicle, vehicle->geoms[g].geom);
		ground = fmin(ground, low);
		if (vehicle_turning_dof(&vehicle->geoms[g]) == vehicle->model->jnt_dofadr[joint])
			bottom = fmin(bottom, low);
	}
	return bottom <= ground + BELOW * fabs(vehicle_turning_radius(wheel)) ? wheel : NULL;
}

static bool has_name(const char *name, const char *const *parts)
{
	const size_t length = name != NULL ? strlen(name) : 0;
	for (; *parts != NULL; parts++)
		for (size_t i = 0; i + strlen(*parts) <= length; i++)
			if (strncasecmp(name + i, *parts, strlen(*parts)) == 0)
				return true;
	return false;
}

/* Returns the actuator of a joint; -1: there is none. */
static int actuator_of(const struct vehicle *vehicle, int joint)
{
	const mjModel *model = vehicle->model;
	for (int i = vehicle->own.actuator.first; i < vehicle->own.actuator.end; i++)
		if (model->actuator_trntype[i] == mjTRN_JOINT && model->actuator_trnid[2 * i] == joint)
			return i;
	return -1;
}

static bool is_below(const mjModel *model, int body, int above)
{
	while (body > above)
		body = model->body_parentid[body];
	return body == above;
}

static bool is_upright(const struct vehicle *vehicle, int joint)
{
	return vehicle->model->jnt_type[joint] == mjJNT_HINGE && fabs(vehicle->data->xaxis[3 * joint + 2]) >= UPRIGHT;
}

/* Returns true if no other upright joint is between a joint and a body below it: the lowest one steers, or is the castor's. */
static bool is_nearest(const struct vehicle *vehicle, int joint, int body)
{
	const mjModel *model = vehicle->model;
	for (; body > model->jnt_bodyid[joint]; body = model->body_parentid[body])
		for (int j = 0; j < model->body_jntnum[body]; j++)
			if (is_upright(vehicle, model->body_jntadr[body] + j))
				return false;
	return true;
}

/* An upright joint over wheels is a castor's if the wheel trails it, and nothing turns it. */
static enum vehicle_role over_wheels(const struct vehicle *vehicle, int joint)
{
	static const char *const castors[] = {"castor", "caster", "swivel", NULL}, *const steers[] = {"steer", NULL};
	const mjModel *model = vehicle->model;
	const mjData *data = vehicle->data;
	const char *name = vehicle_part_name(model, mjOBJ_JOINT, joint);
	enum vehicle_role role = VEHICLE_ROLE_HOLDS;
	for (int wheel = vehicle->own.joint.first; wheel < vehicle->own.joint.end; wheel++) {
		const struct soil_geom *geom = wheel != joint ? wheel_of(vehicle, wheel) : NULL;
		if (geom == NULL || !is_below(model, model->jnt_bodyid[wheel], model->jnt_bodyid[joint]) || !is_nearest(vehicle, joint, model->jnt_bodyid[wheel]))
			continue;
		const double *at = &data->xanchor[3 * wheel], *from = &data->xanchor[3 * joint], *axle = &data->xaxis[3 * wheel];
		const double trail = fabs((at[0] - from[0]) * axle[1] - (at[1] - from[1]) * axle[0]);
		const bool castor = has_name(name, castors) ||
				    (trail > TRAIL * fabs(vehicle_turning_radius(geom)) && !model->jnt_limited[joint] && actuator_of(vehicle, joint) < 0 && !has_name(name, steers));
		role = castor ? VEHICLE_ROLE_FOLLOWS : VEHICLE_ROLE_STEERS;
	}
	return role;
}

static bool any_wheel_has_actuator(const struct vehicle *vehicle)
{
	for (int joint = vehicle->own.joint.first; joint < vehicle->own.joint.end; joint++)
		if (actuator_of(vehicle, joint) >= 0 && wheel_of(vehicle, joint) != NULL)
			return true;
	return false;
}

static enum vehicle_role role_of(const struct vehicle *vehicle, int joint)
{
	static const char *const castors[] = {"castor", "caster", NULL};
	const mjModel *model = vehicle->model;
	if (is_upright(vehicle, joint))
		return over_wheels(vehicle, joint);
	if (wheel_of(vehicle, joint) == NULL)
		return VEHICLE_ROLE_HOLDS;
	for (int body = model->body_parentid[model->jnt_bodyid[joint]]; body > 0; body = model->body_parentid[body])
		for (int j = 0; j < model->body_jntnum[body]; j++)
			if (is_upright(vehicle, model->body_jntadr[body] + j) && over_wheels(vehicle, model->body_jntadr[body] + j) == VEHICLE_ROLE_FOLLOWS)
				return VEHICLE_ROLE_FOLLOWS;
	if (has_name(vehicle_part_name(model, mjOBJ_JOINT, joint), castors) || (actuator_of(vehicle, joint) < 0 && any_wheel_has_actuator(vehicle)))
		return VEHICLE_ROLE_FOLLOWS;
	return VEHICLE_ROLE_DRIVES;
}

void vehicle_part_joint(const struct vehicles *vehicles, size_t index, size_t number, struct vehicle_joint *out)
{
	const struct vehicle *vehicle = &vehicles->list[index];
	const mjModel *model = vehicle->model;
	const int joint = vehicle->joints[number], actuator = actuator_of(vehicle, joint);
	const struct soil_geom *wheel = wheel_of(vehicle, joint);
	*out = (struct vehicle_joint){
		.name = vehicle_joint_name(vehicles, index, number),
		.slides = model->jnt_type[joint] == mjJNT_SLIDE,
		.limited = model->jnt_limited[joint],
		.low = model->jnt_limited[joint] ? model->jnt_range[2 * joint] : -INFINITY,
		.high = model->jnt_limited[joint] ? model->jnt_range[2 * joint + 1] : INFINITY,
		.value = vehicle->data->qpos[model->jnt_qposadr[joint]],
		.actuator = actuator >= 0 ? vehicle_part_name(model, mjOBJ_ACTUATOR, actuator) : NULL,
		.role = role_of(vehicle, joint),
	};
	mju_copy3(out->axis, &vehicle->data->xaxis[3 * joint]);
	mju_copy3(out->at, &vehicle->data->xanchor[3 * joint]);
	if (wheel != NULL) {
		out->wheel = wheel->name + strlen(vehicle->scene->name) + 1;
		out->radius = fabs(vehicle_turning_radius(wheel));
	}
}

void vehicle_part_actuator(const struct vehicles *vehicles, size_t index, size_t number, struct vehicle_actuator *out)
{
	const struct vehicle *vehicle = &vehicles->list[index];
	const mjModel *model = vehicle->model;
	const int i = vehicle->own.actuator.first + (int)number, ctrl = model->actuator_ctrladr[i];
	const bool joint = model->actuator_trntype[i] == mjTRN_JOINT;
	*out = (struct vehicle_actuator){
		.name = vehicle_actuator_name(vehicles, index, number),
		.joint = joint ? vehicle_part_name(model, mjOBJ_JOINT, model->actuator_trnid[2 * i]) : NULL,
		.keeps = vehicle_keeps_place(model, i) ? "place" : vehicle_keeps_rate(model, i) ? "rate" : "force",
		.limited = model->actuator_ctrllimited[ctrl],
		.low = model->actuator_ctrllimited[ctrl] ? model->actuator_ctrlrange[2 * ctrl] : -INFINITY,
		.high = model->actuator_ctrllimited[ctrl] ? model->actuator_ctrlrange[2 * ctrl + 1] : INFINITY,
	};
}

const char *vehicle_part_keyframe(const struct vehicles *vehicles, size_t index, size_t number)
{
	const mjModel *model = vehicles->list[index].single; /* its names have no prefix */
	const char *name = (int)number < model->nkey ? mj_id2name(model, mjOBJ_KEY, (int)number) : NULL;
	return name == NULL && (int)number < model->nkey ? "" : name;
}

void vehicle_part_size(const struct vehicles *vehicles, size_t index, struct vehicle_size *out)
{
	const struct vehicle *vehicle = &vehicles->list[index];
	const mjModel *model = vehicle->model;
	*out = (struct vehicle_size){.bodies = range_count(vehicle->own.body), .timestep = model->opt.timestep};
	for (int k = 0; k < 3; k++) {
		out->low[k] = INFINITY;
		out->high[k] = -INFINITY;
		for (size_t g = 0; g < vehicle->geom_count; g++) {
			double way[3] = {0, 0, 0}, place[3];
			way[k] = 1;
			vehicle_geom_support(model, vehicle->data, vehicle->geoms[g].geom, way, place);
			out->high[k] = fmax(out->high[k], place[k]);
			way[k] = -1;
			vehicle_geom_support(model, vehicle->data, vehicle->geoms[g].geom, way, place);
			out->low[k] = fmin(out->low[k], place[k]);
		}
	}
	out->free = vehicle_is_free(model, vehicle->root);
	const char *name = vehicle_part_name(model, mjOBJ_BODY, vehicle->root);
	out->root = name != NULL ? name : "";
}
