/* What sets the controls of a vehicle's actuators: a path that it follows, a table in time, or constants. */
#include <math.h>

#include "dem/dem.h"
#include "vehicle/powertrain.h"

#define ACROSS 3.0 /* times as much as to the left an axle looks forward: its wheel rolls to a side */

static enum status no_actuator(const struct vehicle *vehicle, const char *where, const char *key, const char *name)
{
	char names[VEHICLE_NAMES];
	vehicle_list_names(vehicle->model, mjOBJ_ACTUATOR, vehicle->own.actuator.first, vehicle->own.actuator.end, names);
	return fail_with(STATUS_INPUT, "%s: driver.%s: %.64s names no actuator of the model; there are: %s", where, key, name, names);
}

/* Finds the actuators that one of the patterns names, in the model's order. */
static enum status find(const struct vehicle *vehicle, const char *where, const char *key, const struct scene_texts *patterns, int **out,
			size_t *count)
{
	const mjModel *model = vehicle->model;
	*out = mem_calloc(range_count(vehicle->own.actuator) + 1, sizeof **out);
	if (*out == NULL)
		return fail_memory("a driver");
	for (int i = vehicle->own.actuator.first; i < vehicle->own.actuator.end; i++) {
		const char *name = vehicle_part_name(model, mjOBJ_ACTUATOR, i);
		if (name != NULL && vehicle_matches(patterns, name, false))
			(*out)[(*count)++] = i;
	}
	for (size_t p = 0; p < patterns->count; p++) {
		const struct scene_texts one = {&patterns->list[p], 1};
		bool any = false;
		for (size_t i = 0; i < *count; i++)
			any = any || vehicle_matches(&one, vehicle_part_name(model, mjOBJ_ACTUATOR, (*out)[i]), false);
		if (!any)
			return no_actuator(vehicle, where, key, patterns->list[p]);
	}
	return STATUS_OK;
}

/* A path needs joints or tendons: their lengths are what steers and drives. */
static enum status check_joints(const struct vehicle *vehicle, const char *where, const char *key, const int *list, size_t count)
{
	const mjModel *model = vehicle->model;
	for (size_t i = 0; i < count; i++) {
		const int kind = model->actuator_trntype[list[i]], joint = model->actuator_trnid[2 * list[i]];
		const bool turns = (kind == mjTRN_JOINT || kind == mjTRN_JOINTINPARENT) && (model->jnt_type[joint] == mjJNT_HINGE || model->jnt_type[joint] == mjJNT_SLIDE);
		if (!turns && kind != mjTRN_TENDON)
			return fail_with(STATUS_INPUT, "%s: driver.%s: %s moves no hinge, slide or tendon; name actuators of these", where, key,
					 vehicle_part_name(model, mjOBJ_ACTUATOR, list[i]));
	}
	return STATUS_OK;
}

/* Returns the cylinder that a hinge turns about another axis than its own, and the angle between both in degrees; NULL: there is none. */
static const struct soil_geom *crossed(const struct vehicle *vehicle, int joint, double *degrees)
{
	const mjModel *model = vehicle->model;
	for (const struct soil_geom *geom = vehicle->geoms; geom < vehicle->geoms + vehicle->geom_count; geom++) {
		const double *mat = &vehicle->data->geom_xmat[9 * geom->geom], axis[3] = {mat[2], mat[5], mat[8]};
		*degrees = acos(fmin(fabs(mju_dot3(axis, &vehicle->data->xaxis[3 * joint])), 1)) * 180 / M_PI;
		if (geom->shape.kind == SOIL_CYLINDER && model->geom_bodyid[geom->geom] == model->jnt_bodyid[joint] && *degrees > 0.05)
			return geom;
	}
	return NULL;
}

/* Fails for an actuator that turns no wheel. */
static enum status fail_wheel(const struct vehicle *vehicle, const char *where, int actuator)
{
	const mjModel *model = vehicle->model;
	const int joint = model->actuator_trnid[2 * actuator];
	const bool hinged = model->actuator_trntype[actuator] == mjTRN_JOINT && model->jnt_type[joint] == mjJNT_HINGE;
	double degrees;
	const struct soil_geom *geom = hinged ? crossed(vehicle, joint, &degrees) : NULL;
	const char *hinge = hinged ? vehicle_part_name(model, mjOBJ_JOINT, joint) : NULL;
	if (geom != NULL)
		return fail_with(STATUS_INPUT, "%s: driver.drive: %s turns no wheel: %s is a cylinder whose axis is %.3g degrees off its hinge%s%s; check its "
					       "euler, and angle of the model's compiler", where, vehicle_part_name(model, mjOBJ_ACTUATOR, actuator), geom->name,
				 degrees, hinge != NULL ? " " : "", hinge != NULL ? hinge : "");
	return fail_with(STATUS_INPUT, "%s: driver.drive: %s turns no wheel and no belt that presses the ground; name actuators of wheels or belts",
			 where, vehicle_part_name(model, mjOBJ_ACTUATOR, actuator));
}

/* Leaves out what turns no wheel, told once. One at least must turn one. */
static enum status check_wheels(struct vehicle *vehicle, const char *where)
{
	struct driver *driver = &vehicle->driver;
	struct steering *steering = &driver->steering;
	const size_t all = driver->drive_count;
	size_t kept = 0;
	for (size_t i = 0; i < all; i++)
		kept += !steering->idle[i];
	if (kept == 0)
		return fail_wheel(vehicle, where, driver->drive[0]);
	if (kept == all)
		return STATUS_OK;
	driver->drive_count = 0;
	for (size_t i = 0; i < all; i++)
		if (!steering->idle[i])
			driver->drive[driver->drive_count++] = driver->drive[i];
		else
			note("%s: driver.drive: %s turns no wheel and no belt that presses the ground, so it stays at 0; leave it out, or name its wheel in soil", where,
			     vehicle_part_name(vehicle->model, mjOBJ_ACTUATOR, driver->drive[i]));
	vehicle_free_steering(steering);
	*steering = (struct steering){.plain = false};
	return vehicle_measure(vehicle, where, false);
}

/* Tells of what drives or steers in a way that is not its own. */
static void tell_kinds(const struct vehicle *vehicle, const char *where)
{
	const mjModel *model = vehicle->model;
	const struct driver *driver = &vehicle->driver;
	for (size_t i = 0; i < driver->drive_count; i++)
		if (!vehicle_keeps_rate(model, driver->drive[i]) && vehicle_keeps_place(model, driver->drive[i]))
			note("%s: driver.drive: %s keeps a place of its wheel, not a speed; it is driven like a motor, by where it is; a velocity servo or a motor fits better", where,
			     vehicle_part_name(model, mjOBJ_ACTUATOR, driver->drive[i]));
}

/* Tells of a model that looks elsewhere: its axles look along the way. */
static void tell_forward(const struct vehicle *vehicle, const char *where)
{
	const struct driver *driver = &vehicle->driver;
	double forward = 0, left = 0, axes[9];
	vehicle_root_axes(vehicle, vehicle->data, axes);
	for (size_t i = 0; i < driver->drive_count; i++) {
		const int joint = vehicle->model->actuator_trnid[2 * driver->drive[i]];
		if (vehicle->model->actuator_trntype[driver->drive[i]] != mjTRN_JOINT)
			continue;
		const double *axle = &vehicle->data->xaxis[3 * joint];
		forward += fabs(axle[0] * axes[0] + axle[1] * axes[3] + axle[2] * axes[6]);
		left += fabs(axle[0] * axes[1] + axle[1] * axes[4] + axle[2] * axes[7]);
	}
	if (forward > ACROSS * left)
		note("%s: its axles look along its %s axis, so it cannot roll along its path; give forward: %s", where,
		     vehicle->scene->forward < SCENE_PLUS_Y ? "x" : "y", vehicle->scene->forward < SCENE_PLUS_Y ? "+y or -y" : "+x or -x");
}

/* Tells of a root that no joint lets go anywhere: of a part that others attach to something, or one that is held. */
static void tell_held(const struct vehicle *vehicle, const char *where)
{
	const mjModel *model = vehicle->model;
	bool goes = false;
	for (int j = 0; j < model->body_jntnum[vehicle->root]; j++) {
		const int kind = model->jnt_type[model->body_jntadr[vehicle->root] + j];
		goes = goes || kind == mjJNT_FREE || kind == mjJNT_SLIDE;
	}
	if (!goes)
		note("%s: its root body %s has no joint by which it could go along its path; give it a free joint", where, vehicle_part_name(model, mjOBJ_BODY, vehicle->root));
}

static enum status make_follow(struct vehicle *vehicle, const char *where)
{
	struct driver *driver = &vehicle->driver;
	TRY(find(vehicle, where, "steer", &vehicle->scene->steer, &driver->steer, &driver->steer_count));
	TRY(find(vehicle, where, "drive", &vehicle->scene->drive, &driver->drive, &driver->drive_count));
	TRY(check_joints(vehicle, where, "steer", driver->steer, driver->steer_count));
	TRY(check_joints(vehicle, where, "drive", driver->drive, driver->drive_count));
	TRY(vehicle_measure(vehicle, where, true));
	TRY(check_wheels(vehicle, where));
	tell_kinds(vehicle, where);
	tell_forward(vehicle, where);
	tell_held(vehicle, where);
	return STATUS_OK;
}

static enum status make_hold(struct vehicle *vehicle, const char *where)
{
	struct driver *driver = &vehicle->driver;
	const struct scene_texts *names = &vehicle->scene->held.names;
	TRY(mem_zeroed(&driver->held, names->count + 1, sizeof *driver->held, "a driver"));
	for (size_t i = 0; i < names->count; i++) {
		driver->held[i] = vehicle_control_find(vehicle, names->list[i]);
		if (driver->held[i] < 0)
			return no_actuator(vehicle, where, "hold", names->list[i]);
		driver->held_count = i + 1;
	}
	driver->values = vehicle->scene->held.values;
	return STATUS_OK;
}

enum status vehicle_make_driver(struct vehicle *vehicle, const char *where)
{
	switch (vehicle->scene->driver) {
	case SCENE_FOLLOW:
		return make_follow(vehicle, where);
	case SCENE_CONTROLS:
		return vehicle_read_controls(vehicle, where);
	case SCENE_HOLD:
		return make_hold(vehicle, where);
	case SCENE_IDLE:
		break;
	}
	return STATUS_OK;
}

static bool names(const int *list, size_t count, size_t actuator)
{
	for (size_t i = 0; i < count; i++)
		if ((size_t)list[i] == actuator)
			return true;
	return false;
}

const char *vehicle_actuator_key(const struct vehicles *vehicles, size_t vehicle, size_t actuator)
{
	const struct driver *driver = &vehicles->list[vehicle].driver;
	const size_t own = range_count(vehicles->list[vehicle].own.actuator);
	if (actuator >= own) /* a control of the powertrain */
		return vehicle_train_key(&vehicles->list[vehicle], actuator - own);
	actuator += (size_t)vehicles->list[vehicle].own.actuator.first;
	if (names(driver->steer, driver->steer_count, actuator))
		return "steer";
	if (names(driver->drive, driver->drive_count, actuator))
		return "drive";
	if (!names(driver->held, driver->held_count, actuator))
		return NULL;
	return vehicles->list[vehicle].scene->driver == SCENE_HOLD ? "hold" : "controls";
}

enum status vehicle_place_driver(struct vehicle *vehicle, const struct world *world)
{
	struct driver *driver = &vehicle->driver;
	struct scene_path route;
	if (vehicle->scene->driver != SCENE_FOLLOW)
		return STATUS_OK;
	TRY(world_route(world, &vehicle->scene->way, vehicle->scene->name, &route));
	driver->route = mem_calloc(route.count, sizeof *driver->route);
	for (size_t i = 0; i < route.count && driver->route != NULL; i++) {
		driver->route[i][0] = route.points[i].x;
		driver->route[i][1] = route.points[i].y;
		driver->route_count = i + 1;
	}
	motion_route_finish(&route);
	driver->points = driver->route;
	driver->point_count = driver->route_count;
	return driver->route != NULL ? STATUS_OK : fail_memory("a driver");
}

void vehicle_free_driver(struct driver *driver)
{
	vehicle_free_steering(&driver->steering);
	mem_free_all(driver->steer, driver->drive, driver->route, driver->held, driver->table);
}

/* The driver's controls. */
static void drive(struct vehicle *vehicle, double time)
{
	const struct driver *driver = &vehicle->driver;
	switch (vehicle->scene->driver) {
	case SCENE_FOLLOW:
		vehicle_pursue(vehicle, time);
		return;
	case SCENE_CONTROLS:
		vehicle_table_control(vehicle, time);
		return;
	case SCENE_HOLD:
		for (size_t i = 0; i < driver->held_count; i++)
			*vehicle_ctrl(vehicle, driver->held[i]) = driver->values[i];
		return;
	case SCENE_IDLE:
		return;
	}
}

/* Returns true if an actuator turns a wheel or a belt: it stays at 0 while brakes hold the vehicle. */
static bool turns_wheel(const struct vehicle *vehicle, int actuator)
{
	const mjModel *model = vehicle->model;
	return model->actuator_trntype[actuator] == mjTRN_JOINT && vehicle_driven(vehicle, model->actuator_trnid[2 * actuator]) != NULL;
}

bool vehicle_holds_place(const struct vehicle *vehicle, int actuator)
{
	return vehicle->model->actuator_biastype[actuator] == mjBIAS_AFFINE && vehicle->model->actuator_biasprm[mjNBIAS * actuator + 1] < 0;
}

/* Returns true if `start` gives the actuator a control. */
static bool is_started(const struct vehicle *vehicle, int actuator)
{
	return vehicle->start_controls != NULL && !isnan(vehicle->start_controls[actuator - vehicle->own.actuator.first]);
}

/* While it settles wheels are braked. What holds a place, as legs do, holds that of the start. */
static void settle(struct vehicle *vehicle)
{
	const enum scene_driver driver = vehicle->scene->driver;
	double *keep = vehicle->row_actuators;
	const struct range actuators = vehicle->own.actuator;
	for (int i = actuators.first; i < actuators.end; i++)
		keep[i - actuators.first] = *vehicle_ctrl(vehicle, i);
	if (driver == SCENE_HOLD || driver == SCENE_CONTROLS)
		drive(vehicle, 0);
	for (int i = actuators.first; i < actuators.end; i++)
		if (turns_wheel(vehicle, i))
			*vehicle_ctrl(vehicle, i) = 0;
		else if (!vehicle_holds_place(vehicle, i) || is_started(vehicle, i))
			*vehicle_ctrl(vehicle, i) = keep[i - actuators.first];
}

void vehicle_control(struct vehicle *vehicle, double time, bool drives)
{
	const mjModel *model = vehicle->model;
	const struct range actuators = vehicle->own.actuator, ctrl = vehicle->own.ctrl;
	if (vehicle->keyframe >= 0)
		mju_copy(vehicle->data->ctrl + ctrl.first, model->key_ctrl + vehicle->keyframe * model->nu + ctrl.first, ctrl.end - ctrl.first);
	else
		mju_zero(vehicle->data->ctrl + ctrl.first, ctrl.end - ctrl.first);
	for (int i = actuators.first; i < actuators.end && vehicle->start_controls != NULL; i++)
		if (is_started(vehicle, i))
			*vehicle_ctrl(vehicle, i) = vehicle->start_controls[i - actuators.first];
	vehicle_train_rest(vehicle);
	if (!drives) {
		settle(vehicle);
		return;
	}
	drive(vehicle, time);
	for (size_t i = 0, own = range_count(actuators); i < vehicle_train_controls(vehicle); i++)
		if (!isnan(vehicle->host_controls[own + i]))
			*vehicle_train_control(vehicle, i) = vehicle->host_controls[own + i];
	for (int i = actuators.first; i < actuators.end; i++)
		if (!isnan(vehicle->host_controls[i - actuators.first]))
			*vehicle_ctrl(vehicle, i) = vehicle->host_controls[i - actuators.first];
}
