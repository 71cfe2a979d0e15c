/* The vehicles of a scene: their life, their steps, and what is told of them. */
#include "vehicle/vehicle.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "vehicle/internal.h"
#include "vehicle/load.h"
#include "vehicle/powertrain.h"
#include "vehicle/settle.h"
#include "vehicle/thin.h"

#define THIN_LEAST 2000 /* triangles: meshes with no more stay as they are */
#define THIN_MOST 0.2   /* posts */
#define SUNK_LONG 1.0 /* s: a soil geom that is sunk for longer, without a break, is told */

/* --- loading --- */

static enum status make_lists(struct vehicles *vehicles)
{
	for (size_t v = 0; v < vehicles->all; v++) {
		vehicles->geom_count += vehicles->list[v].geom_count;
		vehicles->carrying_count += vehicles->list[v].carrying_count;
		vehicles->attached += vehicle_state_numbers(&vehicles->list[v]);
	}
	vehicles->numbers = mem_calloc(vehicles->geom_count + 1, sizeof *vehicles->numbers);
	vehicles->states = mem_calloc(vehicles->geom_count + 1, sizeof *vehicles->states);
	vehicles->belts = mem_calloc(vehicles->geom_count + 1, sizeof *vehicles->belts);
	vehicles->contacts = mem_calloc(vehicles->geom_count + 1, sizeof *vehicles->contacts);
	vehicles->record = mem_calloc(vehicles->attached + 1, sizeof *vehicles->record);
	vehicles->aboard_shapes = mem_calloc(vehicles->carrying_count + 1, sizeof *vehicles->aboard_shapes);
	if (vehicles->numbers == NULL || vehicles->states == NULL || vehicles->belts == NULL || vehicles->contacts == NULL ||
	    vehicles->record == NULL || vehicles->aboard_shapes == NULL)
		return fail_memory("the vehicles");
	size_t next = 0;
	for (size_t v = 0; v < vehicles->all; v++)
		for (size_t g = 0; g < vehicles->list[v].geom_count; g++)
			if (vehicles->list[v].geoms[g].carries)
				vehicles->aboard_shapes[next++] = &vehicles->list[v].geoms[g].shape;
	return STATUS_OK;
}

/* Vehicles by name, then what `world` has. */
static void sort_by_name(struct vehicles *vehicles)
{
	for (size_t i = 0; i < vehicles->count; i++) {
		size_t at = i;
		for (; at > 0 && strcmp(vehicles->list[vehicles->order[at - 1]].scene->name, vehicles->list[i].scene->name) > 0; at--)
			vehicles->order[at] = vehicles->order[at - 1];
		vehicles->order[at] = i;
	}
	if (vehicles->all > vehicles->count)
		vehicles->order[vehicles->count] = vehicles->count;
}

static enum status read_all(const struct scene *scene, struct vehicles *vehicles)
{
	const size_t things = scene->things != NULL;
	TRY(mem_zeroed(&vehicles->list, scene->vehicle_count + things, sizeof *vehicles->list, "the vehicles"));
	TRY(mem_zeroed(&vehicles->order, scene->vehicle_count + things, sizeof *vehicles->order, "the vehicles"));
	for (size_t i = 0; i < scene->vehicle_count + things; i++) {
		vehicles->all = i + 1;
		vehicles->count = i < scene->vehicle_count ? i + 1 : i;
		vehicles->list[i].scene = i < scene->vehicle_count ? &scene->vehicles[i] : scene->things;
		vehicles->list[i].is_world = i == scene->vehicle_count;
		TRY(vehicle_read(&vehicles->list[i], scene));
	}
	return STATUS_OK;
}

/* Reads all models, and makes what is made of them once. */
static enum status load(const struct scene *scene, struct vehicles *vehicles)
{
	TRY(read_all(scene, vehicles));
	sort_by_name(vehicles);
	TRY(vehicle_merge(vehicles));
	vehicle_fit(vehicles);
	vehicle_find_inertia(vehicles);
	for (size_t i = 0; i < vehicles->all; i++) {
		TRY(vehicle_find_parts(&vehicles->list[i], scene));
		TRY(vehicle_make_tyres(&vehicles->list[i], scene));
		if (scene->time_step > 0) /* else nothing will move */
			vehicle_tell_hanging(&vehicles->list[i]);
	}
	TRY(vehicle_divide_step(vehicles));
	TRY(vehicle_set_timestep(vehicles));
	vehicle_soften_servos(vehicles);
	TRY(make_lists(vehicles));
	TRY(vehicle_check_cameras(vehicles));
	TRY(vehicle_make_senses(vehicles));
	return scene->view.present ? vehicle_make_figures(vehicles, scene->view.effects) : STATUS_OK;
}

enum status vehicle_load(const struct scene *scene, struct vehicles **out)
{
	*out = NULL;
	if (scene->vehicle_count == 0)
		return STATUS_OK;
	TRY(vehicle_mujoco_load());
	struct vehicles *vehicles = mem_calloc(1, sizeof *vehicles);
	TRY_MEM(vehicles, "the vehicles");
	vehicles->scene = scene;
	enum status status = load(scene, vehicles);
	if (status != STATUS_OK) {
		vehicle_destroy(vehicles);
		return status;
	}
	*out = vehicles;
	return STATUS_OK;
}

const struct scene *vehicle_scene(const struct vehicles *vehicles, const struct scene *scene)
{
	return vehicles != NULL ? vehicles->scene : scene;
}

void vehicle_destroy(struct vehicles *vehicles)
{
	if (vehicles == NULL)
		return;
	for (size_t v = 0; v < vehicles->all; v++)
		vehicle_forget(&vehicles->list[v]);
	vehicle_free_figures(vehicles);
	vehicle_free_senses(vehicles->senses);
	if (vehicles->data != NULL)
		mj_deleteData(vehicles->data);
	if (vehicles->model != NULL)
		mj_deleteModel(vehicles->model);
	mem_free_all(vehicles->order, vehicles->room, vehicles->mass, vehicles->kept, vehicles->list, vehicles->numbers, vehicles->states, vehicles->belts, vehicles->contacts, vehicles->record, vehicles->aboard_shapes, vehicles);
}

size_t vehicle_attached(const struct vehicles *vehicles)
{
	return vehicles != NULL ? vehicles->attached : 0;
}

const struct soil_shape *const *vehicle_aboard_shapes(const struct vehicles *vehicles, size_t *count)
{
	*count = vehicles != NULL ? vehicles->carrying_count : 0;
	return vehicles != NULL ? (const struct soil_shape *const *)vehicles->aboard_shapes : NULL;
}

enum status vehicle_record(struct vehicles *vehicles)
{
	vehicle_save(vehicles, vehicles->record);
	world_attach(vehicles->world, vehicles->record);
	vehicle_show(vehicles);
	return world_end_step(vehicles->world);
}

/* --- joining the world --- */

/* Thins the meshes of soil geoms to the ground's posts, and tells it. Buckets stay as they are: their walls are thin. */
static enum status thin(const struct vehicle *vehicle, double spacing)
{
	for (struct soil_geom *geom = vehicle->geoms; geom < vehicle->geoms + vehicle->geom_count; geom++) {
		bool thinned;
		if (geom->mesh == NULL || geom->carries || geom->mesh->triangle_count <= THIN_LEAST)
			continue;
		const uint32_t before = geom->mesh->triangle_count;
		TRY(vehicle_thin(geom->mesh, THIN_MOST * spacing, &thinned));
		if (thinned)
			note("vehicles.%s: mesh of %u triangles: pressed with %u, which differ by less than %g posts", geom->name, before, geom->mesh->triangle_count, THIN_MOST);
	}
	return STATUS_OK;
}

static enum status add_body(struct world *world, const struct vehicle *vehicle, struct soil_geom *geom)
{
	struct scene_object object = {.name = mem_strdup(geom->name), .shape = geom->shape, .mesh = geom->mesh, .carry = geom->carries, .interface = vehicle_surface(vehicle, geom)};
	TRY_MEM(object.name, "a vehicle");
	enum status status = world_body_add(world, &object, &geom->number);
	if (status != STATUS_OK) {
		mem_free(object.name);
		return status;
	}
	geom->mesh = NULL; /* the body may live longer than the vehicle */
	world_body_of_vehicle(world, geom->number);
	return STATUS_OK;
}

enum status vehicle_add_bodies(struct vehicle *vehicle, struct world *world)
{
	TRY(thin(vehicle, world_resident(world)->spacing));
	for (size_t g = 0; g < vehicle->geom_count; g++)
		TRY(add_body(world, vehicle, &vehicle->geoms[g]));
	return STATUS_OK;
}

enum status vehicle_join(struct vehicles *vehicles, struct world *world)
{
	vehicles->world = world;
	TRY(vehicle_check_rasters(vehicles, world));
	for (size_t v = 0; v < vehicles->all; v++) {
		struct vehicle *vehicle = &vehicles->list[v];
		TRY(vehicle_add_bodies(vehicle, world));
		TRY(vehicle_place_driver(vehicle, world));
	}
	const double *recorded = world_attached(world);
	if (recorded != NULL) {
		TRY(vehicle_restore(vehicles, recorded));
		return world_carried_rejoin(world);
	}
	vehicle_save(vehicles, vehicles->record);
	world_attach(world, vehicles->record);
	vehicle_show(vehicles);
	return STATUS_OK;
}

/* --- rows --- */

static void fill_row(const struct vehicle *vehicle, struct vehicle_row *row)
{
	const mjModel *model = vehicle->model;
	const mjData *data = vehicle->data;
	double mat[9], velocity[6];
	vehicle_root_axes(vehicle, data, mat);
	mj_objectVelocity(model, data, mjOBJ_XBODY, vehicle->root, velocity, 0);
	for (int i = 0; i < 3; i++) {
		row->position[i] = vehicle->origin[i] + data->xpos[3 * vehicle->root + i];
		row->velocity[i] = velocity[3 + i];
	}
	row->yaw = atan2(mat[3], mat[0]) * 180 / M_PI;
	row->pitch = atan2(mat[6], hypot(mat[0], mat[3])) * 180 / M_PI;
	row->roll = atan2(mat[7], mat[8]) * 180 / M_PI;
	row->kinetic = vehicle_kinetic(vehicle);
	row->work = vehicle->work;
	row->joints = vehicle->row_joints;
	row->controls = vehicle->row_actuators;
	row->forces = vehicle->row_actuators + vehicle_control_count(vehicle);
	vehicle_train_tell(vehicle, &row->train);
}

bool vehicle_rows_due(struct vehicles *vehicles)
{
	if (vehicles == NULL)
		return false;
	const double rate = vehicles->scene->vehicle_rows, now = world_time(vehicles->world) * rate * (1 + 1e-12);
	if (!(rate > 0) || now < vehicles->row)
		return false;
	vehicles->row = floor(now) + 1;
	return true;
}

struct world_aboard vehicle_geom_aboard(const struct vehicles *vehicles, size_t vehicle, size_t number, bool *carries)
{
	const struct soil_geom *geom = &vehicles->list[vehicle].geoms[number];
	*carries = geom->carries;
	return geom->carries ? world_aboard(vehicles->world, (size_t)geom->number) : (struct world_aboard){0, 0, 0};
}

enum status vehicle_geom_capacity(const struct vehicles *vehicles, size_t vehicle, size_t number, double *capacity)
{
	const struct vehicle *of = &vehicles->list[vehicle];
	const int body = of->model->geom_bodyid[of->geoms[number].geom];
	struct soil_part *parts;
	size_t count = 0;
	TRY(mem_make(&parts, of->geom_count, sizeof *parts, "the capacity of a bucket"));
	for (size_t g = 0; g < of->geom_count; g++) {
		const struct soil_geom *geom = &of->geoms[g];
		double own[9];
		if (!geom->carries || of->model->geom_bodyid[geom->geom] != body)
			continue;
		struct soil_part *part = &parts[count++];
		part->shape = &geom->shape;
		mju_copy3(part->at, &of->model->geom_pos[3 * geom->geom]);
		mju_quat2Mat(own, &of->model->geom_quat[4 * geom->geom]);
		for (int k = 0; k < 3; k++)
			mju_mulMatVec(part->axes[k], own, (const double[]){geom->axes[k], geom->axes[3 + k], geom->axes[6 + k]}, 3, 3);
	}
	const enum status status = soil_struck_capacity(parts, count, capacity);
	mem_free(parts);
	return status;
}

void vehicle_row(struct vehicles *vehicles, size_t index, struct vehicle_row *row)
{
	*row = (struct vehicle_row){.time = world_time(vehicles->world), .vehicle = index};
	vehicle_joints(vehicles, index, vehicles->list[index].row_joints, NULL);
	double *controls = vehicles->list[index].row_actuators;
	vehicle_actuators(vehicles, index, controls, controls + vehicle_control_count(&vehicles->list[index]));
	fill_row(&vehicles->list[index], row);
	for (size_t g = 0; g < vehicles->list[index].geom_count; g++) {
		bool carries;
		const struct world_aboard aboard = vehicle_geom_aboard(vehicles, index, g, &carries);
		row->aboard = (struct world_aboard){row->aboard.units + aboard.units, row->aboard.volume + aboard.volume, row->aboard.weight + aboard.weight};
	}
}

static enum deform_state state_of(enum furrow_contact_state state)
{
	switch (state) {
	case FURROW_TOUCHING:
		return DEFORM_TOUCHING;
	case FURROW_SLIDES:
		return DEFORM_SLIDES;
	case FURROW_SUNK:
		return DEFORM_SUNK;
	default:
		return DEFORM_AIR;
	}
}

enum status vehicle_tell_forces(struct vehicles *vehicles)
{
	if (vehicles->scene->forces == 0)
		return STATUS_OK;
	for (size_t v = 0; v < vehicles->all; v++)
		for (size_t g = 0; g < vehicles->list[v].geom_count; g++) {
			const struct soil_geom *geom = &vehicles->list[v].geoms[g];
			const struct furrow_contact *contact = &geom->contact;
			struct world_force force = {.sinkage = contact->sinkage, .area = contact->area, .work = geom->work, .state = state_of(contact->state),
						    .slip_velocity = isfinite(contact->slip_velocity) ? contact->slip_velocity : 0};
			if (force.state == DEFORM_AIR || !isfinite(force.area) || !isfinite(force.sinkage))
				force.sinkage = force.area = 0;
			memcpy(force.force, geom->force, sizeof force.force);
			memcpy(force.moment, geom->force + 3, sizeof force.moment);
			TRY(world_body_tell(vehicles->world, geom->number, &geom->now, &force, isfinite(contact->slip) ? contact->slip : 0));
		}
	return STATUS_OK;
}

/* --- steps --- */

void vehicle_skip_rows(struct vehicles *vehicles)
{
	vehicles->row = floor(world_time(vehicles->world) * vehicles->scene->vehicle_rows * (1 + 1e-12)) + 1;
	vehicles->sensor_row = floor(world_time(vehicles->world) * vehicles->scene->sensor_rows * (1 + 1e-12)) + 1;
}

enum status vehicle_begin(struct vehicles *vehicles)
{
	if (vehicles->list[0].begun == VEHICLE_DRIVES) { /* the rows of its time were written */
		vehicle_skip_rows(vehicles);
		return STATUS_OK;
	}
	TRY(vehicle_settle(vehicles));
	return vehicle_tell_forces(vehicles);
}

/* Tells once of each vehicle that the soil does not carry it. */
static void watch_sunk(const struct vehicles *vehicles, struct vehicle *vehicle)
{
	char text[500];
	bool long_sunk = false;
	for (struct soil_geom *geom = vehicle->geoms; geom < vehicle->geoms + vehicle->geom_count; geom++) {
		geom->sunk = geom->contact.state == FURROW_SUNK ? geom->sunk + vehicles->scene->time_step : 0;
		long_sunk = long_sunk || geom->sunk > SUNK_LONG;
	}
	if (!long_sunk || vehicle->told_sunk[0] != '\0')
		return;
	vehicle_say_sunk(vehicles, vehicle, vehicle_sunk(vehicle), text, sizeof text);
	snprintf(vehicle->told_sunk, sizeof vehicle->told_sunk, "after %.3g s, %.450s", world_time(vehicles->world), text);
	note("%s", vehicle->told_sunk);
}

/* m/s in plan. */
static double speed_of(const struct vehicle *vehicle)
{
	double velocity[6];
	mj_objectVelocity(vehicle->model, vehicle->data, mjOBJ_XBODY, vehicle->root, velocity, 0);
	return hypot(velocity[3], velocity[4]);
}

static enum status watch(struct vehicles *vehicles)
{
	const struct scene *scene = vehicles->scene;
	for (size_t v = 0; v < vehicles->count; v++) {
		struct vehicle *vehicle = &vehicles->list[v];
		const bool slow = speed_of(vehicle) < scene->stuck_below && !vehicle->driver.arrived;
		vehicle->slow = slow ? vehicle->slow + scene->time_step : 0;
		watch_sunk(vehicles, vehicle);
		TRY(vehicle_watch_lies(vehicles, vehicle));
	}
	return STATUS_OK;
}

enum status vehicle_step(struct vehicles *vehicles)
{
	TRY(vehicle_move(vehicles, 0, true));
	TRY(vehicle_tell_forces(vehicles));
	TRY(watch(vehicles));
	TRY(world_step(vehicles->world));
	return vehicle_record(vehicles);
}

static bool is_stuck(const struct vehicles *vehicles, const struct vehicle *vehicle)
{
	return vehicles->scene->stuck_after > 0 && vehicle->slow >= vehicles->scene->stuck_after * (1 - 1e-9);
}

/* Returns which of what the scene asks for has stopped the vehicle, as enum scene_stop; SCENE_STOPS: nothing. */
static enum scene_stop stopped_by(const struct vehicles *vehicles, const struct vehicle *vehicle)
{
	const unsigned asked = vehicles->scene->stop;
	if ((asked >> SCENE_STOP_OVERTURNED & 1) != 0 && vehicle_lies_so(vehicle, LIE_OVERTURNED))
		return SCENE_STOP_OVERTURNED;
	if ((asked >> SCENE_STOP_BURIED & 1) != 0 && vehicle_lies_so(vehicle, LIE_BURIED))
		return SCENE_STOP_BURIED;
	return (asked >> SCENE_STOP_STUCK & 1) != 0 && is_stuck(vehicles, vehicle) ? SCENE_STOP_STUCK : SCENE_STOPS;
}

const char *vehicle_stopped(const struct vehicles *vehicles)
{
	const char *first = NULL;
	for (size_t v = 0; vehicles != NULL && v < vehicles->count; v++) {
		const enum scene_stop by = stopped_by(vehicles, &vehicles->list[v]);
		if (by == SCENE_STOPS && !vehicles->list[v].driver.arrived)
			return NULL;
		if (by != SCENE_STOPS && first == NULL)
			first = scene_stop_name(by);
	}
	return first;
}

/* --- facts --- */

size_t vehicle_count(const struct vehicles *vehicles)
{
	return vehicles != NULL ? vehicles->count : 0;
}

void vehicle_info(const struct vehicles *vehicles, size_t index, struct vehicle_info *info)
{
	const struct vehicle *vehicle = &vehicles->list[index];
	*info = (struct vehicle_info){
		.name = vehicle->scene->name,
		.mass = vehicle_mass(vehicle),
		.gravity = -vehicle->model->opt.gravity[2],
		.own_gravity = {vehicle->gravity[0], vehicle->gravity[1], vehicle->gravity[2]},
		.geom_count = vehicle->geom_count,
		.standing_count = vehicle->standing_count,
		.joint_count = vehicle->joint_count,
		.actuator_count = vehicle_control_count(vehicle),
		.largest_step = vehicle->largest_step,
		.largest_geom = vehicle->geoms[vehicle->largest_geom].name,
		.largest_mass = vehicle->largest_mass,
		.largest_area = vehicle->largest_area,
		.engine_steps = vehicles->engine_steps,
		.settled = vehicle->begun == VEHICLE_DRIVES,
		.settle_seconds = vehicle->settle_seconds,
		.distance = vehicle->distance,
		.work = vehicle->work,
		.arrived = vehicle->driver.arrived,
		.speed = speed_of(vehicle),
		.left = vehicle->driver.left,
		.told_sunk = vehicle->told_sunk[0] != '\0' ? vehicle->told_sunk : NULL,
		.stuck = is_stuck(vehicles, vehicle),
	};
	double slips = 0;
	for (size_t g = 0; g < vehicle->geom_count && vehicles->world != NULL; g++) {
		const double slip = vehicle->geoms[g].contact.slip;
		if (vehicle_turning_dof(&vehicle->geoms[g]) >= 0 && isfinite(slip)) {
			info->slip += slip;
			slips++;
		}
		if (vehicle->geoms[g].contact.sinkage > info->depth) {
			info->deepest = vehicle->geoms[g].name;
			info->depth = vehicle->geoms[g].contact.sinkage;
		}
		const double *place = &vehicle->data->xpos[3 * vehicle->root];
		const double *at = &vehicle->data->geom_xpos[3 * vehicle->geoms[g].geom];
		info->reach = fmax(info->reach, hypot(at[0] - place[0], at[1] - place[1]) + soil_shape_bound(&vehicle->geoms[g].shape));
	}
	info->slip = slips > 0 ? info->slip / slips : (double)NAN;
	vehicle_train_tell(vehicle, &info->train);
	if (vehicles->world != NULL && vehicle->begun > VEHICLE_ABOVE)
		info->kinetic = vehicle_kinetic(vehicle);
	if (info->stuck)
		info->stuck_at = world_time(vehicles->world) - vehicle->slow;
}

const char *vehicle_joint_name(const struct vehicles *vehicles, size_t vehicle, size_t joint)
{
	const char *name = vehicle_part_name(vehicles->list[vehicle].model, mjOBJ_JOINT, vehicles->list[vehicle].joints[joint]);
	return name != NULL ? name : "";
}

const char *vehicle_actuator_name(const struct vehicles *vehicles, size_t vehicle, size_t actuator)
{
	const size_t own = range_count(vehicles->list[vehicle].own.actuator);
	if (actuator >= own)
		return vehicle_train_name(actuator - own);
	const char *name = vehicle_part_name(vehicles->list[vehicle].model, mjOBJ_ACTUATOR, vehicles->list[vehicle].own.actuator.first + (int)actuator);
	return name != NULL ? name : "";
}
