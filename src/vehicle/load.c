/* Reads the model of a vehicle, and checks that it fits the scene. */
#include <math.h>
#include <stdio.h>
#include <xxhash.h>

#include "vehicle/drives.h"
#include "vehicle/load.h"
#include "vehicle/powertrain.h"
#include "vehicle/spec.h"
#include "vehicle/start.h"

#define WHOLE 1e-6 /* of a step of the engine: a time step that is longer than some by less has no more */
#define STEPS_MOST 1e4
#define RECORD 2 /* what its numbers mean: 2 since all vehicles have one origin */

/* The world's gravity counts, and nothing of the models' own worlds. */
void vehicle_fit(struct vehicles *vehicles)
{
	mjModel *model = vehicles->model;
	const double gravity[3] = {0, 0, -vehicles->scene->gravity};
	mju_copy3(model->opt.gravity, gravity);
	model->opt.disableflags |= mjDSBL_AUTORESET; /* one that diverges must not set the others back */
	for (int i = 0; i < model->ngeom; i++) {
		const struct vehicle *of = vehicle_of_geom(vehicles, i);
		const bool floor = model->geom_type[i] == mjGEOM_PLANE;
		if (vehicle_is_fixed(model, i) && (of == NULL || !of->is_world || floor))
			model->geom_contype[i] = model->geom_conaffinity[i] = 0;
	}
	mju_zero(vehicles->data->ctrl, (int)model->nu);
}

void vehicle_where(const struct vehicle *vehicle, const struct scene *scene, char where[VEHICLE_WHERE])
{
	snprintf(where, VEHICLE_WHERE, "%.200s: %s%s", scene->file, vehicle->is_world ? "" : "vehicles.", vehicle->scene->name);
}

/* Steps of the engine divide a time step, and are at most as long as the models ask for. */
enum status vehicle_set_timestep(struct vehicles *vehicles)
{
	mjModel *model = vehicles->model;
	const struct scene *scene = vehicles->scene;
	if (scene->time_step == 0) { /* nothing will move: outline.c */
		vehicles->engine_steps = 1;
		return STATUS_OK;
	}
	const double steps = fmax(ceil(scene->time_step / model->opt.timestep - WHOLE), 1);
	if (!(steps <= STEPS_MOST)) {
		char where[VEHICLE_WHERE];
		const struct vehicle *shortest = &vehicles->list[0];
		for (size_t v = 0; v < vehicles->count; v++)
			if (vehicles->list[v].single->opt.timestep < shortest->single->opt.timestep)
				shortest = &vehicles->list[v];
		vehicle_where(shortest, scene, where);
		return fail_with(STATUS_INPUT, "%s: its timestep of %g s makes %.3g steps of MuJoCo in a time_step of %g s; allowed: %g; shorten time_step, or give the model a longer timestep",
				 where, model->opt.timestep, steps, scene->time_step, STEPS_MOST);
	}
	vehicles->engine_steps = (int)steps;
	model->opt.timestep = scene->time_step / steps;
	return STATUS_OK;
}

/* The body whose motion is the vehicle's: the one below the model's world that has the first soil geom. */
static enum status find_root(struct vehicle *vehicle, const char *where)
{
	const mjModel *model = vehicle->model;
	if (vehicle->is_world)
		return STATUS_OK;
	if (range_count(vehicle->own.dof) == 0)
		return fail_with(STATUS_INPUT, "%s: none of its bodies moves; give its root body a free joint", where);
	vehicle->root = model->body_rootid[model->geom_bodyid[vehicle->geoms[0].geom]];
	vehicle_set_root_axes(vehicle);
	vehicle_place_imu(vehicle);
	return STATUS_OK;
}

static enum status find_joints(struct vehicle *vehicle)
{
	const mjModel *model = vehicle->model;
	vehicle->joints = mem_calloc(range_count(vehicle->own.joint) + 1, sizeof *vehicle->joints);
	vehicle->row_joints = mem_calloc(range_count(vehicle->own.joint) + 1, sizeof *vehicle->row_joints);
	TRY_MEM(vehicle->joints != NULL && vehicle->row_joints != NULL, "a vehicle");
	for (int i = vehicle->own.joint.first; i < vehicle->own.joint.end; i++)
		if (model->jnt_type[i] == mjJNT_HINGE || model->jnt_type[i] == mjJNT_SLIDE)
			vehicle->joints[vehicle->joint_count++] = i;
	return STATUS_OK;
}

static enum status sum_model(struct vehicle *vehicle)
{
	const mjtSize bytes = mj_sizeModel(vehicle->single);
	void *buffer = mem_calloc((size_t)bytes, 1);
	TRY_MEM(buffer, "a vehicle");
	mj_saveModel(vehicle->single, NULL, buffer, bytes);
	const XXH64_hash_t hash = XXH3_64bits_withSeed(buffer, (size_t)bytes, RECORD);
	vehicle->checksum[0] = (double)(hash >> 32);
	vehicle->checksum[1] = (double)(hash & 0xffffffffu);
	mem_free(buffer);
	return STATUS_OK;
}

#define LARGE 20.0 /* m: what a soil geom reaches; larger ones are probably in mm or cm */

/* Units come first: numbers in mm also make other errors. */
static void doubt_sizes(const struct vehicle *vehicle, const char *where)
{
	size_t large = 0, first = 0;
	for (size_t i = vehicle->geom_count; i-- > 0;)
		if (soil_shape_bound(&vehicle->geoms[i].shape) > LARGE) {
			first = i;
			large++;
		}
	char others[48] = "";
	if (large > 1)
		snprintf(others, sizeof others, ", as %zu other%s", large - 1, large > 2 ? "s" : "");
	if (large > 0)
		note("%s: %s reaches %.4g m from its middle%s: that is large, and perhaps in mm; the unit of a model is m: if its sizes are in mm give "
		     "thousandths of them",
		     where, vehicle->geoms[first].name, soil_shape_bound(&vehicle->geoms[first].shape), others);
}

enum status vehicle_read(struct vehicle *vehicle, const struct scene *scene)
{
	char where[VEHICLE_WHERE];
	const double gravity[3] = {0, 0, -scene->gravity};
	vehicle_where(vehicle, scene, where);
	TRY(vehicle_compile(vehicle, scene, where));
	mju_copy3(vehicle->gravity, vehicle->single->opt.gravity);
	mju_copy3(vehicle->single->opt.gravity, gravity);
	TRY(sum_model(vehicle));
	vehicle_turn_single(vehicle);
	return STATUS_OK;
}

enum status vehicle_find_parts(struct vehicle *vehicle, const struct scene *scene)
{
	char where[VEHICLE_WHERE];
	vehicle_where(vehicle, scene, where);
	vehicle_turn_fixed(vehicle);
	TRY(vehicle_start_pose(vehicle, where));
	TRY(vehicle_find_geoms(vehicle, where));
	TRY(vehicle_check_surfaces(vehicle, where));
	doubt_sizes(vehicle, where);
	TRY(find_root(vehicle, where));
	TRY(vehicle_make_lies(vehicle));
	TRY(find_joints(vehicle));
	TRY(vehicle_make_room(vehicle));
	TRY(vehicle_make_powertrain(vehicle, where));
	TRY(vehicle_make_drives(vehicle));
	const size_t controls = vehicle_control_count(vehicle);
	vehicle->row_actuators = mem_calloc(2 * controls + 1, sizeof *vehicle->row_actuators);
	vehicle->host_controls = mem_alloc(controls + 1, sizeof *vehicle->host_controls);
	TRY_MEM(vehicle->row_actuators != NULL && vehicle->host_controls != NULL, "a vehicle");
	for (size_t i = 0; i < controls; i++)
		vehicle->host_controls[i] = (double)NAN;
	vehicle_find_bound(vehicle, scene);
	TRY(vehicle_make_pushes(vehicle, where));
	return vehicle_make_driver(vehicle, where);
}

void vehicle_forget(struct vehicle *vehicle)
{
	vehicle_free_driver(&vehicle->driver);
	vehicle_free_powertrain(vehicle->train);
	vehicle_free_lies(vehicle);
	vehicle_free_pushes(vehicle);
	vehicle_free_geoms(vehicle);
	if (vehicle->spec != NULL)
		mj_deleteSpec(vehicle->spec);
	if (vehicle->posed != NULL)
		mj_deleteData(vehicle->posed);
	if (vehicle->single != NULL)
		mj_deleteModel(vehicle->single);
	mem_free_all(vehicle->drives, vehicle->joints, vehicle->row_joints, vehicle->contacts, vehicle->columns, vehicle->row_actuators, vehicle->host_controls,
		     vehicle->start_controls, vehicle->kept);
}
