/* furrow.h: vehicles. Handles are their numbers in the scene. */
#include "api/library.h"

#include <math.h>
#include <string.h>

static enum status need_vehicle(const struct furrow_world *world, furrow_vehicle vehicle)
{
	TRY(api_library_need_world(world));
	if (vehicle >= 0 && (size_t)vehicle < vehicle_count(world->vehicles))
		return STATUS_OK;
	return fail_with(STATUS_USAGE, "vehicle %d: there is none; use a handle that furrow_vehicle_find gave", (int)vehicle);
}

/* Checks the vehicle, too. */
static enum status need_count(const struct furrow_world *world, furrow_vehicle vehicle, size_t count, enum furrow_part part)
{
	struct vehicle_info info;
	TRY(need_vehicle(world, vehicle));
	vehicle_info(world->vehicles, (size_t)vehicle, &info);
	const bool joints = part == FURROW_JOINT;
	const size_t has = joints ? info.joint_count : info.actuator_count;
	if (count == has)
		return STATUS_OK;
	return fail_with(STATUS_USAGE, "count: it is %zu, and %s has %zu %s; give room for each", count, info.name, has, joints ? "joints" : "actuators");
}

static enum status find(const struct furrow_world *world, const char *name, furrow_vehicle *vehicle)
{
	TRY(api_library_need_world(world));
	TRY(api_library_need(name, "name"));
	TRY(api_library_need(vehicle, "vehicle"));
	for (size_t i = 0; i < vehicle_count(world->vehicles); i++) {
		struct vehicle_info info;
		vehicle_info(world->vehicles, i, &info);
		if (strcmp(info.name, name) == 0)
			*vehicle = (furrow_vehicle)i;
	}
	return *vehicle >= 0 ? STATUS_OK : fail_with(STATUS_INPUT, "%s: no vehicle has this name; give one of the scene's vehicles", name);
}

furrow_status furrow_vehicle_find(struct furrow_world *world, const char *name, furrow_vehicle *vehicle)
{
	enum status status;
	if (vehicle != NULL)
		*vehicle = -1;
	TRY_OR(done, api_library_begin());
	TRY_OR(done, find(world, name, vehicle));
done:
	return api_library_end(status);
}

const char *furrow_vehicle_part(const struct furrow_world *world, furrow_vehicle vehicle, enum furrow_part part, size_t index)
{
	struct vehicle_info info;
	struct vehicle_geom geom;
	if (world == NULL || vehicle < 0 || (size_t)vehicle >= vehicle_count(world->vehicles))
		return NULL;
	vehicle_info(world->vehicles, (size_t)vehicle, &info);
	switch (part) {
	case FURROW_JOINT:
		return index < info.joint_count ? vehicle_joint_name(world->vehicles, (size_t)vehicle, index) : NULL;
	case FURROW_ACTUATOR:
		return index < info.actuator_count ? vehicle_actuator_name(world->vehicles, (size_t)vehicle, index) : NULL;
	case FURROW_SOIL_GEOM:
		if (index >= info.geom_count)
			return NULL;
		vehicle_geom(world->vehicles, (size_t)vehicle, index, world_resident(world->world)->spacing, &geom);
		return geom.name;
	case FURROW_MODEL_BODY:
		return index < vehicle_bodies(world->vehicles, (size_t)vehicle) ? vehicle_model_body_name(world->vehicles, (size_t)vehicle, index) : NULL;
	}
	return NULL;
}

static enum status get_state(struct furrow_world *world, furrow_vehicle vehicle, struct furrow_vehicle_state *state)
{
	struct vehicle_info info;
	TRY(need_vehicle(world, vehicle));
	TRY(api_library_need(state, "state"));
	TRY(api_library_need_size(state->size, sizeof state->size, sizeof *state, "vehicle_state"));
	vehicle_info(world->vehicles, (size_t)vehicle, &info);
	const size_t size = state->size < sizeof *state ? state->size : sizeof *state;
	struct furrow_vehicle_state all = {
		.size = state->size,
		.mass = info.mass,
		.distance = info.distance,
		.kinetic = info.kinetic,
		.work = info.work,
		.joints = info.joint_count,
		.actuators = info.actuator_count,
		.soil_geoms = info.geom_count,
		.arrived = info.arrived,
	};
	vehicle_state(world->vehicles, (size_t)vehicle, &all.state);
	memcpy(state, &all, size);
	return STATUS_OK;
}

furrow_status furrow_vehicle_get(struct furrow_world *world, furrow_vehicle vehicle, struct furrow_vehicle_state *state)
{
	enum status status;
	TRY_OR(done, api_library_begin());
	TRY_OR(done, get_state(world, vehicle, state));
done:
	return api_library_end(status);
}

furrow_status furrow_get_joints(struct furrow_world *world, furrow_vehicle vehicle, size_t count, double *values, double *rates)
{
	enum status status;
	TRY_OR(done, api_library_begin());
	TRY_OR(done, need_count(world, vehicle, count, FURROW_JOINT));
	vehicle_joints(world->vehicles, (size_t)vehicle, values, rates);
done:
	return api_library_end(status);
}

furrow_status furrow_get_actuators(struct furrow_world *world, furrow_vehicle vehicle, size_t count, double *controls, double *forces)
{
	enum status status;
	TRY_OR(done, api_library_begin());
	TRY_OR(done, need_count(world, vehicle, count, FURROW_ACTUATOR));
	vehicle_actuators(world->vehicles, (size_t)vehicle, controls, forces);
done:
	return api_library_end(status);
}

static enum status set_controls(struct furrow_world *world, furrow_vehicle vehicle, size_t count, const double *controls)
{
	TRY(need_count(world, vehicle, count, FURROW_ACTUATOR));
	if (count == 0)
		return STATUS_OK;
	TRY(api_library_need(controls, "controls"));
	for (size_t i = 0; i < count; i++)
		if (isinf(controls[i]))
			return fail_with(STATUS_USAGE, "controls: number %zu is infinite; give a finite one, or NaN for the driver's", i);
	vehicle_set_controls(world->vehicles, (size_t)vehicle, controls);
	return STATUS_OK;
}

furrow_status furrow_set_controls(struct furrow_world *world, furrow_vehicle vehicle, size_t count, const double *controls)
{
	enum status status;
	TRY_OR(done, api_library_begin());
	TRY_OR(done, set_controls(world, vehicle, count, controls));
done:
	return api_library_end(status);
}

static enum status set_force(struct furrow_world *world, furrow_vehicle vehicle, size_t body, const double *force, const double *torque)
{
	static const double none[3];
	const double *both[2] = {force != NULL ? force : none, torque != NULL ? torque : none};
	TRY(need_vehicle(world, vehicle));
	const size_t bodies = vehicle_bodies(world->vehicles, (size_t)vehicle);
	if (body >= bodies)
		return fail_with(STATUS_USAGE, "body: %zu is none; the vehicle has %zu bodies, from 0 on", body, bodies);
	for (int i = 0; i < 6; i++)
		if (!isfinite(both[i / 3][i % 3]))
			return fail_with(STATUS_USAGE, "%s: number %d is not finite; give N and N m", i < 3 ? "force" : "torque", i % 3);
	vehicle_set_force(world->vehicles, (size_t)vehicle, body, both[0], both[1]);
	return STATUS_OK;
}

furrow_status furrow_set_force(struct furrow_world *world, furrow_vehicle vehicle, size_t body, const double *force, const double *torque)
{
	enum status status;
	TRY_OR(done, api_library_begin());
	TRY_OR(done, set_force(world, vehicle, body, force, torque));
done:
	return api_library_end(status);
}
