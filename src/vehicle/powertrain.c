/* The parts of a powertrain: which wheels it drives and brakes, its controls, and its state in the record. */
#include "vehicle/powertrain.h"

#include <math.h>
#include <string.h>

#define ONE_AXLE 0.05 /* m: wheels that lie less apart along the way are on one axle */
#define STATE 7       /* numbers of the record, beside one for each wheel */

static const char *const names[POWERTRAIN_CONTROLS] = {"brake", "throttle", "gear"};

/* --- wheels --- */

/* Returns the motor that the powertrain has put on a hinge; -1: it does not drive it. */
static int motor_of(const struct vehicle *vehicle, int joint)
{
	const mjModel *model = vehicle->model;
	const struct scene_powertrain *scene = &vehicle->scene->powertrain;
	const struct scene_texts *patterns = scene->wheels.count > 0 ? &scene->wheels : &vehicle->scene->drive;
	for (int i = vehicle->own.actuator.first; i < vehicle->own.actuator.end; i++) {
		const char *name = vehicle_part_name(model, mjOBJ_ACTUATOR, i);
		if (model->actuator_trntype[i] == mjTRN_JOINT && model->actuator_trnid[2 * i] == joint && name != NULL && vehicle_matches(patterns, name, false))
			return i;
	}
	return -1;
}

/* Lists the freedoms that turn wheels or belts, once each. */
static enum status find_wheels(struct vehicle *vehicle, struct powertrain *train)
{
	const mjModel *model = vehicle->model;
	const mjData *data = vehicle->data;
	double axes[9];
	vehicle_root_axes(vehicle, data, axes);
	TRY(mem_zeroed(&train->wheels, vehicle->geom_count + 1, sizeof *train->wheels, "a powertrain"));
	for (const struct soil_geom *geom = vehicle->geoms; geom < vehicle->geoms + vehicle->geom_count; geom++) {
		bool listed = geom->dof < 0;
		for (size_t i = 0; i < train->wheel_count; i++)
			listed = listed || train->wheels[i].dof == geom->dof;
		if (listed)
			continue;
		const int joint = model->dof_jntid[geom->dof];
		double from[3], own[3], axis[3];
		mju_sub3(from, &data->geom_xpos[3 * geom->geom], &data->xpos[3 * vehicle->root]);
		mju_mulMatTVec3(own, axes, from);
		mju_mulMatTVec3(axis, axes, &data->xaxis[3 * joint]);
		train->wheels[train->wheel_count++] = (struct powertrain_wheel){
			.dof = geom->dof, .motor = train->scene != NULL ? motor_of(vehicle, joint) : -1, .side = axis[1] >= 0 ? 1 : -1, .x = own[0], .held = (double)NAN};
	}
	return STATUS_OK;
}

/* Parts the driven wheels into a front and a rear axle, and shares the torque. */
static void share(struct powertrain *train)
{
	double low = INFINITY, high = -INFINITY, middle = 0;
	size_t counts[2] = {0, 0};
	for (size_t i = 0; i < train->wheel_count; i++) {
		middle += train->wheels[i].x / (double)train->wheel_count;
		if (train->wheels[i].motor < 0)
			continue;
		low = fmin(low, train->wheels[i].x);
		high = fmax(high, train->wheels[i].x);
	}
	for (size_t i = 0; i < train->wheel_count; i++) {
		struct powertrain_wheel *wheel = &train->wheels[i];
		wheel->rear = high - low < ONE_AXLE ? wheel->x <= middle : wheel->x < (low + high) / 2;
		counts[wheel->rear] += wheel->motor >= 0;
	}
	for (size_t i = 0; i < train->wheel_count; i++) {
		struct powertrain_wheel *wheel = &train->wheels[i];
		if (wheel->motor >= 0)
			wheel->share = (counts[!wheel->rear] > 0 ? 0.5 : 1) / (double)counts[wheel->rear];
	}
}

/* --- rows --- */

static double *add_row(struct powertrain *train, struct powertrain_row row)
{
	train->rows[train->row_count] = row;
	return train->ways + train->row_count++ * train->wheel_count;
}

/* Wheels of an axle beside its first one. */
static void add_axle(struct powertrain *train, bool rear, enum scene_differential differential)
{
	const struct powertrain_wheel *first = NULL;
	for (const struct powertrain_wheel *wheel = train->wheels; wheel < train->wheels + train->wheel_count && differential != SCENE_OPEN; wheel++) {
		if (wheel->motor < 0 || wheel->rear != rear)
			continue;
		if (first == NULL) {
			first = wheel;
			continue;
		}
		double *way = add_row(train, (struct powertrain_row){.kind = POWERTRAIN_AXLE, .differential = differential, .share = wheel->share});
		way[first - train->wheels] = first->side;
		way[wheel - train->wheels] = -wheel->side;
	}
}

static void add_centre(struct powertrain *train, enum scene_differential differential)
{
	bool any[2] = {false, false};
	for (size_t i = 0; i < train->wheel_count; i++)
		any[train->wheels[i].rear] |= train->wheels[i].motor >= 0;
	if (differential == SCENE_OPEN || !any[0] || !any[1])
		return;
	double *way = add_row(train, (struct powertrain_row){.kind = POWERTRAIN_CENTRE, .differential = differential, .share = 0.5});
	for (size_t i = 0; i < train->wheel_count; i++)
		way[i] = (train->wheels[i].rear ? -2 : 2) * train->wheels[i].share * train->wheels[i].side;
}

static enum status make_rows(const struct vehicle *vehicle, struct powertrain *train)
{
	const size_t n = train->wheel_count, most = 2 * n + 2, nv = range_count(vehicle->own.dof);
	const size_t numbers = n * n + n + most * n + most * most + 5 * most + most * (most + 4) + nv * nv + 2 * nv;
	TRY(mem_zeroed(&train->rows, most, sizeof *train->rows, "a powertrain"));
	TRY(mem_zeroed(&train->ways, most * n, sizeof *train->ways, "a powertrain"));
	TRY(mem_zeroed(&train->room, numbers, sizeof *train->room, "a powertrain"));
	TRY(mem_zeroed(&train->bound, most, sizeof *train->bound, "a powertrain"));
	TRY(mem_zeroed(&train->listed, most, sizeof *train->listed, "a powertrain"));
	if (train->scene != NULL) {
		double *way = add_row(train, (struct powertrain_row){.kind = POWERTRAIN_INPUT});
		for (size_t i = 0; i < n; i++)
			way[i] = train->wheels[i].share * train->wheels[i].side;
		add_centre(train, train->scene->centre);
		add_axle(train, false, train->scene->front);
		add_axle(train, true, train->scene->rear);
	}
	for (size_t i = 0; i < n && train->brakes > 0; i++)
		add_row(train, (struct powertrain_row){.kind = POWERTRAIN_HOLDS, .wheel = i})[i] = 1;
	return STATUS_OK;
}

static enum status check(const struct vehicle *vehicle, const struct powertrain *train, const char *where)
{
	size_t driven = 0;
	if (train->wheel_count == 0)
		return fail_with(STATUS_INPUT, "%s: %s: no wheel or belt of the model turns about a hinge and presses the ground; name its wheels in soil", where,
				 train->scene != NULL ? "powertrain" : "brakes");
	for (size_t i = 0; i < train->wheel_count; i++)
		driven += train->wheels[i].motor >= 0;
	if (train->scene != NULL && driven == 0) {
		char list[VEHICLE_NAMES];
		vehicle_list_names(vehicle->model, mjOBJ_JOINT, vehicle->own.joint.first, vehicle->own.joint.end, list);
		return fail_with(STATUS_INPUT, "%s: powertrain.wheels: names no hinge that turns a wheel on the ground; there are: %s", where, list);
	}
	for (size_t i = 0; i < vehicle_train_controls(vehicle); i++)
		if (vehicle_find_part(vehicle, mjOBJ_ACTUATOR, names[i]) >= 0)
			return fail_with(STATUS_INPUT, "%s: its model has an actuator %s, which is a control of the %s; rename it", where, names[i],
					 train->scene != NULL ? "powertrain" : "brakes");
	return STATUS_OK;
}

enum status vehicle_make_powertrain(struct vehicle *vehicle, const char *where)
{
	const struct scene_powertrain *scene = &vehicle->scene->powertrain;
	if (!scene->present && vehicle->scene->brakes == 0)
		return STATUS_OK;
	struct powertrain *train;
	TRY(mem_zeroed(&train, 1, sizeof *train, "a powertrain"));
	vehicle->train = train;
	train->scene = scene->present ? scene : NULL;
	train->brakes = vehicle->scene->brakes;
	train->speed = scene->present ? scene->idle * M_PI / 30 : 0;
	train->gear = scene->present ? 1 : 0;
	TRY(find_wheels(vehicle, train));
	TRY(check(vehicle, train, where));
	share(train);
	vehicle_train_rest(vehicle);
	return make_rows(vehicle, train);
}

void vehicle_free_powertrain(struct powertrain *train)
{
	if (train == NULL)
		return;
	mem_free_all(train->wheels, train->rows, train->ways, train->room, train->bound, train->listed, train);
}

/* --- controls --- */

int vehicle_train_find(const struct vehicle *vehicle, const char *name)
{
	for (size_t i = 0; i < vehicle_train_controls(vehicle); i++)
		if (strcmp(names[i], name) == 0)
			return (int)i;
	return -1;
}

const char *vehicle_train_name(size_t control)
{
	return names[control];
}

int vehicle_control_find(const struct vehicle *vehicle, const char *name)
{
	const int control = vehicle_train_find(vehicle, name);
	return control >= 0 ? (int)vehicle->model->nactuator + control : vehicle_find_part(vehicle, mjOBJ_ACTUATOR, name);
}

double *vehicle_train_control(const struct vehicle *vehicle, size_t control)
{
	return &vehicle->train->controls[control];
}

void vehicle_train_rest(struct vehicle *vehicle)
{
	struct powertrain *train = vehicle->train;
	if (train == NULL)
		return;
	train->controls[POWERTRAIN_THROTTLE] = train->controls[POWERTRAIN_BRAKE] = 0;
	train->controls[POWERTRAIN_GEAR] = train->scene == NULL ? 0 : train->scene->shifts ? (double)train->scene->gear_count : 1;
}

void vehicle_train_effort(struct vehicle *vehicle, double effort)
{
	struct powertrain *train = vehicle->train;
	if (train == NULL)
		return;
	train->controls[POWERTRAIN_BRAKE] = fmin(fmax(-effort, 0), 1);
	train->controls[POWERTRAIN_THROTTLE] = train->scene != NULL ? fmin(fmax(effort, 0), 1) : 0;
}

double vehicle_train_effort_for(const struct vehicle *vehicle, double acceleration)
{
	const struct powertrain *train = vehicle->train;
	double radius = 0, brakes = 0;
	size_t driven = 0;
	if (train == NULL)
		return 0;
	const double mass = vehicle_mass(vehicle);
	for (const struct powertrain_wheel *wheel = train->wheels; wheel < train->wheels + train->wheel_count; wheel++) {
		const struct soil_geom *geom = vehicle_driven(vehicle, vehicle->model->dof_jntid[wheel->dof]);
		const double lever = geom == NULL ? 0 : geom->shape.belt ? fabs(geom->sprocket) : geom->shape.radius;
		radius += wheel->motor >= 0 ? lever : 0;
		driven += wheel->motor >= 0;
		brakes += lever > 0 ? train->brakes / lever : 0;
	}
	if (acceleration < 0)
		return brakes > 0 ? fmax(mass * acceleration / brakes, -1) : 0;
	if (train->scene == NULL || driven == 0)
		return 0;
	const struct scene_powertrain *scene = train->scene;
	const double ratio = scene->final * (train->gear < 0 ? scene->reverse : scene->gears[train->gear > 0 ? (size_t)train->gear - 1 : 0]);
	const double most = vehicle_engine_torque(scene, train->speed, 1) * ratio / (radius / (double)driven);
	return most > 0 ? fmin(mass * acceleration / most, 1) : 1;
}

void vehicle_train_hold(struct vehicle *vehicle)
{
	vehicle_train_effort(vehicle, -1);
}

/* --- what is told --- */

void vehicle_train_tell(const struct vehicle *vehicle, struct vehicle_train *out)
{
	const struct powertrain *train = vehicle->train;
	*out = (struct vehicle_train){.has_engine = false};
	if (train == NULL)
		return;
	out->has_brakes = train->brakes > 0;
	out->brake_work = train->brake_work;
	if (train->scene == NULL)
		return;
	out->has_engine = true;
	out->engine_speed = train->speed * 30 / M_PI;
	out->engine_torque = train->torque;
	out->gear = train->shifting > 0 ? 0 : (int)train->gear;
	out->engine_work = train->engine_work;
	out->loss = train->loss;
	out->engine_kinetic = train->scene->inertia * train->speed * train->speed / 2;
}

void vehicle_train_tell_controls(const struct vehicle *vehicle, double *controls, double *forces)
{
	const struct powertrain *train = vehicle->train;
	const size_t own = range_count(vehicle->own.actuator);
	for (size_t i = 0; i < vehicle_train_controls(vehicle); i++) {
		if (controls != NULL)
			controls[own + i] = train->controls[i];
		if (forces != NULL)
			forces[own + i] = i == POWERTRAIN_THROTTLE ? train->torque : 0;
	}
	for (size_t i = 0; train != NULL && i < train->wheel_count && forces != NULL; i++)
		forces[own + POWERTRAIN_BRAKE] += fabs(train->wheels[i].brake);
}

const char *vehicle_train_key(const struct vehicle *vehicle, size_t control)
{
	const struct driver *driver = &vehicle->driver;
	if (vehicle->scene->driver == SCENE_FOLLOW)
		return control == POWERTRAIN_GEAR || (vehicle->train->scene == NULL && control == POWERTRAIN_BRAKE) ? NULL : "path";
	for (size_t i = 0; i < driver->held_count; i++)
		if (driver->held[i] == (int)(vehicle->model->nactuator + (int)control))
			return vehicle->scene->driver == SCENE_HOLD ? "hold" : "controls";
	return NULL;
}

bool vehicle_train_holds(const struct vehicle *vehicle, int dof)
{
	const struct powertrain *train = vehicle->train;
	for (size_t i = 0; train != NULL && i < train->wheel_count; i++)
		if (train->wheels[i].dof == dof)
			return !isnan(train->wheels[i].held);
	return false;
}

/* --- the record --- */

size_t vehicle_train_numbers(const struct vehicle *vehicle)
{
	return vehicle->train != NULL ? STATE + vehicle->train->wheel_count : 0;
}

double *vehicle_train_save(const struct vehicle *vehicle, double *to)
{
	const struct powertrain *train = vehicle->train;
	if (train == NULL)
		return to;
	const double own[STATE] = {train->speed, train->gear, train->shifting, train->input, train->engine_work, train->loss, train->brake_work};
	memcpy(to, own, sizeof own);
	to += STATE;
	for (size_t i = 0; i < train->wheel_count; i++)
		*to++ = train->wheels[i].held;
	return to;
}

const double *vehicle_train_restore(struct vehicle *vehicle, const double *from)
{
	struct powertrain *train = vehicle->train;
	if (train == NULL)
		return from;
	double *const own[STATE] = {&train->speed, &train->gear, &train->shifting, &train->input, &train->engine_work, &train->loss, &train->brake_work};
	for (size_t i = 0; i < STATE; i++)
		*own[i] = *from++;
	for (size_t i = 0; i < train->wheel_count; i++)
		train->wheels[i].held = *from++;
	return from;
}
