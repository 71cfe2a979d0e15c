/*
 * Where and how a vehicle begins.
 *
 * Its pose is that of its model, of `start.keyframe`, or of `start.joints`. It is turned by yaw, pitch and roll about the origin of its root body, which stays
 * above `at`. Then it is lifted, so that its lowest soil geom touches the ground, or is `start.height` above it. Of what is set down bars dig in as it settles; what falls has them
 * above the ground, too.
 */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "vehicle/spec.h"
#include "vehicle/start.h"

#define SIDES 8         /* directions each way in which the lowest places of a geom are looked for */
#define ALONG 0.01      /* of the speed: by so much the joints of a root may miss it */
#define DEEP 0.25       /* of the radius around a thing of `world`: deeper than this it starts under ground */
#define AT_LEAST 0.05   /* m: half the length of the smallest vehicle that is told to have moved */

enum status vehicle_fail_start(const struct vehicles *vehicles, const struct vehicle *vehicle, const char *format, ...)
{
	char why[900], line[16] = "";
	va_list args;
	va_start(args, format);
	vsnprintf(why, sizeof why, format, args);
	va_end(args);
	if (vehicle->scene->line > 0)
		snprintf(line, sizeof line, ":%d", vehicle->scene->line);
	return vehicle->is_world ? fail_with(STATUS_INPUT, "%s%s: world: %s", vehicles->scene->file, line, why)
				  : fail_with(STATUS_INPUT, "%s%s: vehicles.%s.start: %s", vehicles->scene->file, line, vehicle->scene->name, why);
}

/* --- the pose --- */

static bool holds_one(const mjModel *model, int joint)
{
	return model->jnt_type[joint] == mjJNT_HINGE || model->jnt_type[joint] == mjJNT_SLIDE;
}

static enum status fail_joint(const struct vehicle *vehicle, const char *where, const char *name)
{
	char names[VEHICLE_NAMES];
	vehicle_list_names(vehicle->model, mjOBJ_JOINT, vehicle->own.joint.first, vehicle->own.joint.end, names);
	return fail_with(STATUS_INPUT, "%s: start.joints: %.64s names no hinge or slide of the model; there are: %s", where, name, names);
}

/* The control at which a servo holds its joint at a place. A servo pulls by gain x control + bias x length. */
static void hold_joint(struct vehicle *vehicle, int joint, double value)
{
	const mjModel *model = vehicle->model;
	for (int i = vehicle->own.actuator.first; i < vehicle->own.actuator.end; i++) {
		double *control = &vehicle->start_controls[i - vehicle->own.actuator.first];
		const double gain = model->actuator_gainprm[mjNGAIN * i], bias = model->actuator_biasprm[mjNBIAS * i + 1];
		if (model->actuator_trntype[i] != mjTRN_JOINT || model->actuator_trnid[2 * i] != joint || !vehicle_holds_place(vehicle, i) || gain == 0)
			continue;
		*control = -bias * vehicle_gear(model, i)[0] * value / gain;
		const int own = model->actuator_ctrladr[i];
		if (model->actuator_ctrllimited[own])
			*control = fmin(fmax(*control, model->actuator_ctrlrange[2 * own]), model->actuator_ctrlrange[2 * own + 1]);
	}
}

/* Joints that are locked (spec_locks.c) keep their places of the first pose. */
static void lock_joints(const struct vehicle *vehicle)
{
	mjModel *model = vehicle->model;
	for (int i = vehicle->own.equality.first; i < vehicle->own.equality.end; i++) {
		const char *name = vehicle_part_name(model, mjOBJ_EQUALITY, i);
		const int at = name != NULL && strncmp(name, SPEC_LOCK, strlen(SPEC_LOCK)) == 0 ? model->jnt_qposadr[model->eq_obj1id[i]] : -1;
		if (at >= 0)
			model->eq_data[mjNEQDATA * i] = vehicle->data->qpos[at] - model->qpos0[at];
	}
}

static enum status set_joint(struct vehicle *vehicle, const char *where, int joint, const char *name, double value)
{
	const mjModel *model = vehicle->model;
	const double *range = model->jnt_range + 2 * joint;
	const char *unit = model->jnt_type[joint] == mjJNT_HINGE ? "rad" : "m";
	if (model->jnt_limited[joint] && !(value >= range[0] && value <= range[1]))
		return fail_with(STATUS_INPUT, "%s: start.joints: %.64s: %g %s is outside its range of %.6g to %.6g %s; give a value inside it", where, name, value, unit,
				 range[0], range[1], unit);
	vehicle->data->qpos[model->jnt_qposadr[joint]] = value;
	hold_joint(vehicle, joint, value);
	return STATUS_OK;
}

static enum status set_joints(struct vehicle *vehicle, const char *where)
{
	const struct scene_named *joints = &vehicle->scene->start.joints;
	for (size_t n = 0; n < joints->names.count; n++) {
		const struct scene_texts pattern = {.list = &joints->names.list[n], .count = 1};
		bool any = false;
		for (int i = vehicle->own.joint.first; i < vehicle->own.joint.end; i++) {
			const char *name = vehicle_part_name(vehicle->model, mjOBJ_JOINT, i);
			if (name == NULL || !holds_one(vehicle->model, i) || !vehicle_matches(&pattern, name, false))
				continue;
			TRY(set_joint(vehicle, where, i, name, joints->values[n]));
			any = true;
		}
		if (!any)
			return fail_joint(vehicle, where, joints->names.list[n]);
	}
	return STATUS_OK;
}

static enum status set_control(struct vehicle *vehicle, const char *where, const char *name, double value)
{
	const mjModel *model = vehicle->model;
	const struct range actuators = vehicle->own.actuator;
	const struct scene_texts pattern = {.list = (char *[]){(char *)(uintptr_t)name}, .count = 1};
	char names[VEHICLE_NAMES];
	bool any = false;
	for (int i = actuators.first; i < actuators.end; i++) {
		const char *own = vehicle_part_name(model, mjOBJ_ACTUATOR, i);
		const int at = model->actuator_ctrladr[i];
		const double *range = model->actuator_ctrlrange + 2 * at;
		if (own == NULL || !vehicle_matches(&pattern, own, false))
			continue;
		if (model->actuator_ctrllimited[at] && !(value >= range[0] && value <= range[1]))
			return fail_with(STATUS_INPUT, "%s: start.controls: %.64s: %g is outside its range of %.6g to %.6g; give a value inside it", where, own, value,
					 range[0], range[1]);
		vehicle->start_controls[i - actuators.first] = value;
		any = true;
	}
	if (any)
		return STATUS_OK;
	vehicle_list_names(model, mjOBJ_ACTUATOR, actuators.first, actuators.end, names);
	return fail_with(STATUS_INPUT, "%s: start.controls: %.64s names no actuator of the model; there are: %s", where, name, names);
}

enum status vehicle_start_pose(struct vehicle *vehicle, const char *where)
{
	const struct scene_start *start = &vehicle->scene->start;
	const size_t count = range_count(vehicle->own.actuator);
	if (start->unsettled)
		TRY(mem_zeroed(&vehicle->kept, range_count(vehicle->own.qpos) + range_count(vehicle->own.dof), sizeof *vehicle->kept, "a vehicle"));
	if (start->joints.names.count + start->controls.names.count == 0) {
		lock_joints(vehicle);
		return STATUS_OK;
	}
	TRY(mem_make(&vehicle->start_controls, count + 1, sizeof *vehicle->start_controls, "a vehicle"));
	for (size_t i = 0; i < count; i++)
		vehicle->start_controls[i] = (double)NAN;
	TRY(set_joints(vehicle, where));
	for (size_t i = 0; i < start->controls.names.count; i++)
		TRY(set_control(vehicle, where, start->controls.names.list[i], start->controls.values[i]));
	lock_joints(vehicle);
	mj_forward(vehicle->model, vehicle->data);
	return STATUS_OK;
}

/* --- the place --- */

/* Returns where a root body of the model is: its free joint, or its place in the model's world. Three numbers, and four of its orientation. */
static double *place_of(struct vehicle *vehicle, int body, double **quat)
{
	const mjModel *model = vehicle->model;
	double *pos = vehicle_is_free(model, body) ? &vehicle->data->qpos[model->jnt_qposadr[model->body_jntadr[body]]] : &model->body_pos[3 * body];
	*quat = vehicle_is_free(model, body) ? pos + 3 : &model->body_quat[4 * body];
	return pos;
}

/* Turns by an angle, rad, about one of the axes. */
static void about(int axis, double angle, double turn[4])
{
	const double axes[3] = {axis == 0, axis == 1, axis == 2};
	mju_axisAngle2Quat(turn, axes, angle);
}

/* Turns a root body about the pivot by `tilt`, then with the pivot by `yaw` about the model's origin, and puts it above the start. */
static void turn_root(struct vehicle *vehicle, int body, const double pivot[3], const double tilt[4], const double yaw[4])
{
	double turned[4], place[3], *quat, *pos = place_of(vehicle, body, &quat);
	if (tilt != NULL) {
		mju_sub3(place, pos, pivot);
		mju_rotVecQuat(pos, place, tilt);
		mju_addTo3(pos, pivot);
		mju_mulQuat(turned, tilt, quat);
		mju_copy4(quat, turned);
	}
	mju_rotVecQuat(place, pos, yaw);
	mju_mulQuat(turned, yaw, quat);
	mju_addTo3(place, vehicle->shift);
	mju_copy3(pos, place);
	mju_copy4(quat, turned);
}

static bool is_root(const struct vehicle *vehicle, int body)
{
	return vehicle->model->body_parentid[body] == 0;
}

enum status vehicle_find_origin(struct vehicles *vehicles)
{
	mju_zero3(vehicles->origin);
	if (vehicles->all > vehicles->count) /* the things of `world` have the terrain's own axes: metres, local */
		return STATUS_OK;
	return world_start_point(vehicles->world, vehicles->list[vehicles->order[0]].scene, vehicles->origin);
}

static enum status turn(const struct vehicles *vehicles, struct vehicle *vehicle)
{
	const struct scene_vehicle *scene = vehicle->scene;
	const double half = scene->yaw / 2, yaw[4] = {cos(half), 0, 0, sin(half)};
	double tilt[4], pitch[4], roll[4], pivot[3], *quat;
	about(1, -scene->start.pitch, pitch);
	about(0, scene->start.roll, roll);
	mju_mulQuat(tilt, pitch, roll);
	mju_copy3(vehicle->origin, vehicles->origin);
	if (vehicle->is_world)
		return STATUS_OK;
	double start[3] = {0, 0, 0};
	TRY(world_start_point(vehicles->world, scene, start));
	for (int i = 0; i < 2; i++)
		vehicle->shift[i] = start[i] - vehicles->origin[i];
	mju_copy3(pivot, place_of(vehicle, vehicle->root, &quat));
	for (int body = vehicle->own.body.first; body < vehicle->own.body.end; body++)
		if (is_root(vehicle, body))
			turn_root(vehicle, body, pivot, scene->start.pitch != 0 || scene->start.roll != 0 ? tilt : NULL, yaw);
	mju_copy(vehicle->placed, place_of(vehicle, vehicle->root, &quat), 2);
	return STATUS_OK;
}

static void lift(struct vehicle *vehicle)
{
	double *quat;
	for (int body = vehicle->own.body.first; body < vehicle->own.body.end; body++)
		if (is_root(vehicle, body))
			place_of(vehicle, body, &quat)[2] += vehicle->lift;
}

static bool is_solid(const struct vehicle *vehicle, int geom)
{
	const mjModel *model = vehicle->model;
	return !vehicle_is_fixed(model, geom) && (model->geom_contype[geom] != 0 || model->geom_conaffinity[geom] != 0 || vehicle_soil_geom_of(vehicle, geom) != NULL);
}

/* Finds half its length in plan: of all that collides, and of soil geoms, along its root body's x axis or across, which is longer. */
static void find_length(struct vehicle *vehicle)
{
	const double *mat = &vehicle->data->xmat[9 * vehicle->root];
	const double heading = hypot(mat[0], mat[3]) > 0.1 ? atan2(mat[3], mat[0]) : 0, along[2][3] = {{cos(heading), sin(heading), 0}, {-sin(heading), cos(heading), 0}};
	vehicle->half_length = AT_LEAST;
	for (int k = 0; k < 2; k++) {
		double high = -INFINITY, low = INFINITY;
		for (int i = vehicle->own.geom.first; i < vehicle->own.geom.end; i++) {
			const double back[3] = {-along[k][0], -along[k][1], 0};
			double place[3];
			if (!is_solid(vehicle, i))
				continue;
			vehicle_geom_support(vehicle->model, vehicle->data, i, along[k], place);
			high = fmax(high, mju_dot3(place, along[k]));
			vehicle_geom_support(vehicle->model, vehicle->data, i, back, place);
			low = fmin(low, mju_dot3(place, along[k]));
		}
		vehicle->half_length = fmax(vehicle->half_length, (high - low) / 2);
	}
}

enum status vehicle_replace(struct vehicles *vehicles, struct vehicle *vehicle)
{
	const double height = vehicle->origin[2];
	TRY(vehicle_find_origin(vehicles));
	vehicles->origin[2] = height;
	TRY(turn(vehicles, vehicle));
	if (vehicle->is_world)
		return STATUS_OK;
	lift(vehicle);
	mj_kinematics(vehicle->model, vehicle->data);
	find_length(vehicle);
	return STATUS_OK;
}

static enum status ground_at(const struct vehicles *vehicles, double x, double y, double *height, bool *found)
{
	int64_t whole;
	TRY(resident_ground_height(world_resident(vehicles->world)->ground, lattice_offset(x), lattice_offset(y), &whole, found));
	*height = *found ? lattice_offset_metres(whole) : 0;
	return STATUS_OK;
}

/* Finds how far a geom is below the ground at most; negative: above it. `at`: where, m, local. *any false: there is no ground under one of its places. */
static enum status depth_of(const struct vehicles *vehicles, const struct vehicle *vehicle, int geom, double *depth, double at[3], bool *any)
{
	*depth = -INFINITY;
	*any = true;
	for (int i = -SIDES; i <= SIDES; i++)
		for (int j = -SIDES; j <= SIDES; j++) {
			const double direction[3] = {(double)i / SIDES, (double)j / SIDES, -1};
			double place[3], height;
			bool found;
			vehicle_geom_support(vehicle->model, vehicle->data, geom, direction, place);
			mju_addTo3(place, vehicle->origin);
			TRY(ground_at(vehicles, place[0], place[1], &height, &found));
			*any = *any && found;
			if (!found || height - place[2] <= *depth)
				continue;
			*depth = height - place[2];
			mju_copy3(at, place);
		}
	return STATUS_OK;
}

enum status vehicle_check_start(const struct vehicles *vehicles, const struct vehicle *vehicle)
{
	for (int i = vehicle->own.geom.first; i < vehicle->own.geom.end; i++) {
		double depth, at[3];
		bool any;
		char name[256];
		if (vehicle_soil_geom_of(vehicle, i) != NULL || !is_solid(vehicle, i))
			continue;
		TRY(depth_of(vehicles, vehicle, i, &depth, at, &any));
		if (depth <= 0)
			continue;
		vehicle_geom_name(vehicle, i, name, sizeof name);
		return vehicle_fail_start(vehicles, vehicle, "its geom %s starts %.3g m under ground, at %.3f, %.3f, %.3f m, and does not press it; name it in soil, start "
							     "elsewhere, or give a height", name, depth, at[0], at[1], at[2]);
	}
	return STATUS_OK;
}

/* Fails for a vehicle that starts where there is no ground. Small numbers off a terrain that knows degrees are probably degrees. */
static enum status fail_ground(const struct vehicles *vehicles, const struct vehicle *vehicle, const struct soil_geom *geom)
{
	const struct extent *extent = &world_resident(vehicles->world)->meta->extent;
	const double *at = vehicles->origin, *from = &vehicle->data->geom_xpos[3 * geom->geom];
	const bool degrees = !extent_holds(extent, at[0], at[1]) && vehicles->scene->coordinates == SCENE_LOCAL && world_resident(vehicles->world)->meta->srs[0] != '\0' && fabs(at[0]) <= 360 && fabs(at[1]) <= 90;
	return vehicle_fail_start(vehicles, vehicle, "no ground under %s at %g, %g m; start on the terrain, %g x %g m, away from holes%s", geom->name, at[0] + from[0], at[1] + from[1],
				  extent_side(extent, 0), extent_side(extent, 1),
				  degrees ? "; if these are longitude and latitude, give coordinates: degrees" : "");
}

enum status vehicle_check_things(const struct vehicles *vehicles, const struct vehicle *things)
{
	for (size_t g = 0; g < things->geom_count; g++) {
		const struct soil_geom *geom = &things->geoms[g];
		const double *at = &things->data->geom_xpos[3 * geom->geom], bound = soil_shape_bound(&geom->shape);
		double depth, deepest[3];
		bool any;
		TRY(depth_of(vehicles, things, geom->geom, &depth, deepest, &any));
		if (!any)
			return vehicle_fail_start(vehicles, things, "no ground under %s at %g, %g m; move it onto the terrain", geom->name, at[0], at[1]);
		if (depth > DEEP * bound)
			return vehicle_fail_start(vehicles, things, "%s starts %.3g m under ground at %g, %g m; raise it by that", geom->name, depth, at[0], at[1]);
	}
	return STATUS_OK;
}

enum status vehicle_set_down(struct vehicles *vehicles, struct vehicle *vehicle)
{
	double deepest = -INFINITY;
	TRY(turn(vehicles, vehicle));
	if (vehicle->is_world)
		return STATUS_OK;
	mj_kinematics(vehicle->model, vehicle->data);
	find_length(vehicle);
	for (size_t g = 0; g < vehicle->geom_count; g++) {
		double depth, at[3];
		bool any;
		TRY(depth_of(vehicles, vehicle, vehicle->geoms[g].geom, &depth, at, &any));
		if (!any)
			return fail_ground(vehicles, vehicle, &vehicle->geoms[g]);
		const struct soil_shape *shape = &vehicle->geoms[g].shape;
		deepest = fmax(deepest, depth + (vehicle->scene->start.unsettled && shape->grousers > 0 ? shape->grouser_height : 0));
	}
	deepest += vehicle->scene->start.height;
	/* Whole metres are the origin's, so that MuJoCo's numbers stay small. */
	const bool first = vehicles->all == vehicles->count && vehicle == &vehicles->list[vehicles->order[0]];
	const double whole = first ? floor(deepest) : 0;
	if (first)
		vehicle->origin[2] = vehicles->origin[2] = whole;
	vehicle->lift = deepest - whole;
	lift(vehicle);
	return STATUS_OK;
}

/* --- the speed --- */

/* Gives a root body a velocity along the joints that it has. Returns what of it they cannot give, m/s. */
static double push_root(const struct vehicle *vehicle, int body, const double velocity[3])
{
	const mjModel *model = vehicle->model;
	double *qvel = vehicle->data->qvel, rest[3];
	mju_copy3(rest, velocity);
	for (int j = model->body_jntadr[body]; j < model->body_jntadr[body] + model->body_jntnum[body]; j++) {
		const double *axis = &vehicle->data->xaxis[3 * j];
		if (model->jnt_type[j] == mjJNT_FREE) {
			mju_copy3(qvel + model->jnt_dofadr[j], velocity);
			mju_zero3(rest);
		} else if (model->jnt_type[j] == mjJNT_SLIDE) {
			qvel[model->jnt_dofadr[j]] = mju_dot3(axis, velocity);
			mju_addToScl3(rest, axis, -mju_dot3(axis, velocity));
		}
	}
	return mju_norm3(rest);
}

/* Lets a wheel roll, or a belt run, as its middle moves. What does neither slides at that velocity, which is its slow part. */
static void roll(const struct vehicle *vehicle, struct soil_geom *geom, const double velocity[3])
{
	const mjModel *model = vehicle->model;
	double axes[9], forward[3];
	if (geom->dof < 0) {
		mju_copy3(geom->mean, velocity);
		return;
	}
	mju_mulMatMat(axes, &vehicle->data->geom_xmat[9 * geom->geom], geom->axes, 3, 3, 3);
	const double left[3] = {axes[1], axes[4], axes[7]}, up[3] = {axes[2], axes[5], axes[8]}, vertical[3] = {0, 0, 1};
	mju_cross(forward, left, geom->sprocket != 0 ? up : vertical);
	mju_normalize3(forward);
	const double speed = mju_dot3(forward, velocity);
	const double *axis = &vehicle->data->xaxis[3 * model->dof_jntid[geom->dof]];
	vehicle->data->qvel[geom->dof] = geom->sprocket != 0 ? speed / geom->sprocket : speed / geom->shape.radius * (mju_dot3(axis, left) >= 0 ? 1 : -1);
}

enum status vehicle_start_speed(struct vehicles *vehicles, struct vehicle *vehicle)
{
	const double speed = vehicle->scene->start.speed;
	double axes[9];
	vehicle_root_axes(vehicle, vehicle->data, axes);
	const double velocity[3] = {speed * axes[0], speed * axes[3], speed * axes[6]};
	if (speed == 0)
		return STATUS_OK;
	for (int body = vehicle->own.body.first; body < vehicle->own.body.end; body++) {
		if (!is_root(vehicle, body) || vehicle->model->body_mocapid[body] >= 0 || push_root(vehicle, body, velocity) <= ALONG * fabs(speed))
			continue;
		const char *name = vehicle_part_name(vehicle->model, mjOBJ_BODY, body);
		return vehicle_fail_start(vehicles, vehicle, "speed: the joints of its root body %s do not let it move forward; give it a free joint, or no speed",
					  name != NULL ? name : "without a name");
	}
	for (size_t g = 0; g < vehicle->geom_count; g++)
		roll(vehicle, &vehicle->geoms[g], velocity);
	vehicle_find_places(vehicles);
	return STATUS_OK;
}

/* --- while it settles --- */

/* Returns the slope of the ground, degrees, over a vehicle's length where it was set down. NaN: not known. */
static enum status slope_of(const struct vehicles *vehicles, const struct vehicle *vehicle, double *slope)
{
	const double half = vehicle->half_length;
	double rise[2];
	*slope = (double)NAN;
	for (int k = 0; k < 2; k++) {
		double at[2] = {vehicle->origin[0] + vehicle->placed[0], vehicle->origin[1] + vehicle->placed[1]}, low, high;
		bool low_found, high_found;
		at[k] -= half;
		TRY(ground_at(vehicles, at[0], at[1], &low, &low_found));
		at[k] += 2 * half;
		TRY(ground_at(vehicles, at[0], at[1], &high, &high_found));
		if (!low_found || !high_found)
			return STATUS_OK;
		rise[k] = (high - low) / (2 * half);
	}
	*slope = atan(hypot(rise[0], rise[1])) * 180 / M_PI;
	return STATUS_OK;
}

enum status vehicle_check_moved(const struct vehicles *vehicles, const struct vehicle *vehicle)
{
	const double *now = &vehicle->data->xpos[3 * vehicle->root], moved = hypot(now[0] - vehicle->placed[0], now[1] - vehicle->placed[1]);
	double velocity[6], slope;
	bool brakes = false;
	if (!(moved > vehicle->half_length) || vehicle->scene->start.unsettled)
		return STATUS_OK;
	for (size_t g = 0; g < vehicle->geom_count; g++)
		brakes = brakes || vehicle->geoms[g].dof >= 0;
	mj_objectVelocity(vehicle->model, vehicle->data, mjOBJ_XBODY, vehicle->root, velocity, 0);
	TRY(slope_of(vehicles, vehicle, &slope));
	char on[64] = "";
	if (isfinite(slope) && slope >= 1)
		snprintf(on, sizeof on, " on this slope of %.3g degrees", slope);
	return vehicle_fail_start(vehicles, vehicle, "it moves before the drive begins: after %.3g s of settling it is %.3g m away, more than half its length of %.3g m, and moves at "
						     "%.2g m/s: the soil does not hold it%s%s; start on gentler ground, turn it, or begin without settling (start: {settle: false})",
				  vehicle->settle_seconds, moved, 2 * vehicle->half_length, mju_norm3(velocity + 3), on,
				  brakes ? ", with its wheels braked" : ", and it has no wheels or belts that brake");
}

void vehicle_keep_unsettled(struct vehicles *vehicles)
{
	for (struct vehicle *vehicle = vehicles->list; vehicle < vehicles->list + vehicles->count; vehicle++) {
		if (vehicle->kept == NULL)
			continue;
		const struct range qpos = vehicle->own.qpos, dof = vehicle->own.dof;
		mju_copy(vehicle->kept, vehicle->data->qpos + qpos.first, (int)range_count(qpos));
		mju_copy(vehicle->kept + range_count(qpos), vehicle->data->qvel + dof.first, (int)range_count(dof));
	}
}

void vehicle_restore_unsettled(struct vehicles *vehicles)
{
	bool any = false;
	for (struct vehicle *vehicle = vehicles->list; vehicle < vehicles->list + vehicles->count; vehicle++) {
		if (vehicle->kept == NULL)
			continue;
		any = true;
		const struct range qpos = vehicle->own.qpos, dof = vehicle->own.dof;
		mju_copy(vehicle->data->qpos + qpos.first, vehicle->kept, (int)range_count(qpos));
		mju_copy(vehicle->data->qvel + dof.first, vehicle->kept + range_count(qpos), (int)range_count(dof));
	}
	if (any)
		vehicle_find_places(vehicles);
}
