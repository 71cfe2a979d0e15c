/*
 * Limbs that nothing holds: an arm whose joints have no actuator, or motors that no driver names, hangs as soon as the drive begins. It may be meant so,
 * and is told once. Joints above wheels are a suspension's, and those of castors turn round: they move freely by design.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "vehicle/internal.h"

#define NAMED 3 /* joints that are named */

struct hanging {
	size_t count;
	char names[256];
};

static void add(struct hanging *hanging, const char *name)
{
	const size_t used = strlen(hanging->names);
	if (hanging->count < NAMED)
		snprintf(hanging->names + used, sizeof hanging->names - used, "%s%.64s", hanging->count > 0 ? ", " : "", name);
	else if (hanging->count == NAMED)
		snprintf(hanging->names + used, sizeof hanging->names - used, ", ...");
	hanging->count++;
}

/* Returns true if a body is another one, or below it. */
static bool is_below(const mjModel *model, int body, int above)
{
	while (body > above)
		body = model->body_parentid[body];
	return body == above;
}

/* Returns true if a wheel or belt that turns is below a body: its joint is a suspension's. */
static bool holds_wheels(const struct vehicle *vehicle, int body)
{
	const mjModel *model = vehicle->model;
	for (size_t g = 0; g < vehicle->geom_count; g++) {
		const int dof = vehicle_turning_dof(&vehicle->geoms[g]);
		if (dof >= 0 && is_below(model, model->dof_bodyid[dof], body))
			return true;
	}
	return false;
}

/* Returns true if an equality or a tendon acts on the joint, or on what is below it. */
static bool is_tied(const struct vehicle *vehicle, int joint)
{
	const mjModel *model = vehicle->model;
	const int body = model->jnt_bodyid[joint];
	for (int i = vehicle->own.equality.first; i < vehicle->own.equality.end; i++) {
		const int type = model->eq_type[i], ends[2] = {model->eq_obj1id[i], model->eq_obj2id[i]};
		for (int k = 0; k < 2; k++) {
			if (type == mjEQ_JOINT && ends[k] == joint)
				return true;
			if (type != mjEQ_CONNECT && type != mjEQ_WELD)
				continue;
			const int at = model->eq_objtype[i] == mjOBJ_SITE ? model->site_bodyid[ends[k]] : ends[k];
			if (is_below(model, at, body))
				return true;
		}
	}
	for (int i = vehicle->own.tendon.first; i < vehicle->own.tendon.end; i++)
		for (int w = model->tendon_adr[i]; w < model->tendon_adr[i] + model->tendon_num[i]; w++) {
			if (model->wrap_type[w] == mjWRAP_JOINT && model->wrap_objid[w] == joint)
				return true;
			if (model->wrap_type[w] == mjWRAP_SITE && is_below(model, model->site_bodyid[model->wrap_objid[w]], body))
				return true;
		}
	return false;
}

/* Returns true if nothing of the model but its actuators holds the joint of a limb. */
static bool is_loose(const struct vehicle *vehicle, int joint)
{
	const mjModel *model = vehicle->model;
	const int type = model->jnt_type[joint];
	return (type == mjJNT_HINGE || type == mjJNT_SLIDE) && model->jnt_limited[joint] && !(model->jnt_stiffness[joint] > 0) &&
	       !(model->dof_frictionloss[model->jnt_dofadr[joint]] > 0) && !is_tied(vehicle, joint) && !holds_wheels(vehicle, model->jnt_bodyid[joint]);
}

/* Returns true if the actuator holds no place and no speed by itself: its control is a force. */
static bool gives_force(const mjModel *model, int actuator)
{
	return model->actuator_gaintype[actuator] == mjGAIN_FIXED && model->actuator_biastype[actuator] == mjBIAS_NONE && model->actuator_dyntype[actuator] == mjDYN_NONE;
}

/* What moves a joint: no actuator; motors alone, none of which a path's driver or the start names; something that may hold it. */
enum moved { BY_NOTHING, BY_MOTORS, BY_MORE };

static enum moved moved_by(const struct vehicle *vehicle, int joint)
{
	const mjModel *model = vehicle->model;
	const struct scene_vehicle *scene = vehicle->scene;
	enum moved by = BY_NOTHING;
	for (int i = vehicle->own.actuator.first; i < vehicle->own.actuator.end; i++) {
		const int type = model->actuator_trntype[i];
		const char *name = vehicle_part_name(model, mjOBJ_ACTUATOR, i);
		if ((type != mjTRN_JOINT && type != mjTRN_JOINTINPARENT) || model->actuator_trnid[2 * i] != joint)
			continue;
		if (!gives_force(model, i) || scene->driver != SCENE_FOLLOW || vehicle->start_controls != NULL || vehicle_matches(&scene->drive, name != NULL ? name : "", false) ||
		    vehicle_matches(&scene->steer, name != NULL ? name : "", false))
			return BY_MORE;
		by = BY_MOTORS;
	}
	return by;
}

void vehicle_tell_hanging(const struct vehicle *vehicle)
{
	const mjModel *model = vehicle->model;
	struct hanging hanging[BY_MORE] = {{0}};
	if (vehicle->is_world || (vehicle->is_urdf && vehicle->scene->driver != SCENE_IDLE)) /* spec_locks.c tells that */
		return;
	for (int joint = vehicle->own.joint.first; joint < vehicle->own.joint.end; joint++) {
		const enum moved by = is_loose(vehicle, joint) ? moved_by(vehicle, joint) : BY_MORE;
		const char *name = vehicle_part_name(model, mjOBJ_JOINT, joint);
		if (by != BY_MORE)
			add(&hanging[by], name != NULL ? name : "without a name");
	}
	static const char *const why[] = {"no actuator, spring or friction", "motors that the driver does not name"};
	for (int by = 0; by < BY_MORE; by++)
		if (hanging[by].count > 0)
			note("vehicles.%s: %zu joint%s with limits (%s) ha%s %s: nothing holds %s, and what is below hangs; servo: {lock: [JOINT, ...]} locks %s", vehicle->scene->name,
			     hanging[by].count, hanging[by].count == 1 ? "" : "s", hanging[by].names, hanging[by].count == 1 ? "s" : "ve", why[by], hanging[by].count == 1 ? "it" : "them",
			     hanging[by].count == 1 ? "it" : "them");
}
