/* Vehicles of a host's world: where they are, what the soil does to them, the host's controls, and the way back to a checkpoint. */

#include "vehicle/powertrain.h"

void vehicle_state(const struct vehicles *vehicles, size_t index, struct furrow_state *state)
{
	const struct vehicle *vehicle = &vehicles->list[index];
	const mjData *data = vehicle->data;
	double velocity[6]; /* rad/s, then m/s */
	mj_objectVelocity(vehicle->model, data, mjOBJ_XBODY, vehicle->root, velocity, 0);
	*state = (struct furrow_state){.pose = {.position = {0}}};
	mju_add3(state->pose.position, vehicle->origin, &data->xpos[3 * vehicle->root]);
	mju_copy4(state->pose.orientation, &data->xquat[4 * vehicle->root]);
	mju_copy3(state->angular, velocity);
	mju_copy3(state->linear, velocity + 3);
}

void vehicle_joints(const struct vehicles *vehicles, size_t index, double *values, double *rates)
{
	const struct vehicle *vehicle = &vehicles->list[index];
	for (size_t i = 0; i < vehicle->joint_count; i++) {
		if (values != NULL)
			values[i] = vehicle->data->qpos[vehicle->model->jnt_qposadr[vehicle->joints[i]]];
		if (rates != NULL)
			rates[i] = vehicle->data->qvel[vehicle->model->jnt_dofadr[vehicle->joints[i]]];
	}
}

void vehicle_actuators(const struct vehicles *vehicles, size_t index, double *controls, double *forces)
{
	const struct vehicle *vehicle = &vehicles->list[index];
	const struct range actuators = vehicle->own.actuator;
	for (int i = actuators.first; i < actuators.end; i++) {
		if (controls != NULL)
			controls[i - actuators.first] = *vehicle_ctrl(vehicle, i);
		if (forces != NULL)
			forces[i - actuators.first] = vehicle->data->actuator_force[vehicle->model->actuator_outadr[i]];
	}
	vehicle_train_tell_controls(vehicle, controls, forces);
}

void vehicle_set_controls(struct vehicles *vehicles, size_t index, const double *controls)
{
	struct vehicle *vehicle = &vehicles->list[index];
	mju_copy(vehicle->host_controls, controls, (int)vehicle_control_count(vehicle));
}

static const struct soil_geom *geom_of(const struct vehicles *vehicles, int32_t number, const struct vehicle **of)
{
	for (size_t v = 0; v < vehicle_count(vehicles); v++)
		for (size_t g = 0; g < vehicles->list[v].geom_count; g++)
			if (vehicles->list[v].geoms[g].number == number) {
				*of = &vehicles->list[v];
				return &vehicles->list[v].geoms[g];
			}
	return NULL;
}

const char *vehicle_body_name(const struct vehicles *vehicles, int32_t number)
{
	const struct vehicle *of = NULL;
	const struct soil_geom *geom = geom_of(vehicles, number, &of);
	return geom != NULL ? geom->name : NULL;
}

bool vehicle_body(const struct vehicles *vehicles, int32_t number, struct furrow_state *state, struct furrow_contact *contact)
{
	const struct vehicle *of = NULL;
	const struct soil_geom *geom = geom_of(vehicles, number, &of);
	if (geom == NULL)
		return false;
	if (state != NULL)
		vehicle_geom_state(of, geom, state, NULL);
	if (contact == NULL)
		return true;
	vehicle_geom_contact(vehicles, geom, contact);
	return true;
}

void vehicle_geom_contact(const struct vehicles *vehicles, const struct soil_geom *geom, struct furrow_contact *contact)
{
	*contact = geom->contact;
	if (contact->state == FURROW_UNKNOWN)
		return;
	/* The engine's steps went on from the probe's state: this force they applied last. */
	mju_copy3(contact->force, geom->force);
	mju_copy3(contact->moment, geom->force + 3);
	if (geom->load > 0) {
		contact->force[2] -= geom->load;
		contact->moment[0] -= geom->load_at[1] * geom->load;
		contact->moment[1] += geom->load_at[0] * geom->load;
	}
	contact->time = world_time(vehicles->world);
}

enum status vehicle_step_back(struct vehicles *vehicles)
{
	return vehicle_restore(vehicles, world_attached_last(vehicles->world));
}

enum status vehicle_rollback(struct vehicles *vehicles)
{
	TRY(vehicle_step_back(vehicles));
	vehicle_skip_rows(vehicles);
	return STATUS_OK;
}
