/* What a host is told about the soil under a body: the force's line, the normal, slip, and the shear limit. */
#include <math.h>
#include <string.h>

#include "world/internal.h"

#define NORMAL_POSTS 2 /* working posts to each side over which the base's slope is measured */

struct world_force world_no_force(int64_t z)
{
	return (struct world_force){.z = z, .state = DEFORM_AIR};
}

enum furrow_contact_state world_contact_state_of(enum deform_state state)
{
	static const enum furrow_contact_state states[DEFORM_STATES] = {
		[DEFORM_TOUCHING] = FURROW_TOUCHING, [DEFORM_SLIDES] = FURROW_SLIDES, [DEFORM_SUNK] = FURROW_SUNK, [DEFORM_AIR] = FURROW_AIR,
	};
	return states[state];
}

struct furrow_contact world_contact_unknown(void)
{
	struct furrow_contact contact = {
		.time = NAN, .force = {NAN, NAN, NAN}, .moment = {NAN, NAN, NAN}, .point = {NAN, NAN, NAN}, .normal = {NAN, NAN, NAN},
		.sinkage = NAN, .area = NAN, .slip = NAN, .normal_force = NAN, .shear_limit = NAN, .pull = NAN, .carried = NAN, .slip_velocity = NAN, .state = FURROW_UNKNOWN,
	};
	for (int i = 0; i < 6; i++)
		for (int k = 0; k < 6; k++)
			contact.stiffness[i][k] = contact.damping[i][k] = NAN;
	return contact;
}

/* Finds the normal of the undisturbed surface. NaN: it cannot be found. */
static enum status normal_at(const struct world *world, const double place[3], double normal[3])
{
	const double step = NORMAL_POSTS * world->resident.spacing;
	double height[4];
	static const double to[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
	for (int i = 0; i < 4; i++) {
		int64_t found;
		bool any;
		TRY(resident_ground_height(world->resident.ground, lattice_offset(place[0] + to[i][0] * step),
					   lattice_offset(place[1] + to[i][1] * step), &found, &any));
		height[i] = any ? lattice_offset_metres(found) : NAN;
	}
	const double dx = (height[0] - height[1]) / (2 * step), dy = (height[2] - height[3]) / (2 * step);
	const double length = sqrt(1 + dx * dx + dy * dy);
	normal[0] = -dx / length;
	normal[1] = -dy / length;
	normal[2] = 1 / length;
	return STATUS_OK;
}

/* Finds the place on the force's line nearest the body's lowest point. */
static void line_of(const double origin[3], double reach, const double force[3], const double moment[3], double point[3])
{
	const double squares = force[0] * force[0] + force[1] * force[1] + force[2] * force[2];
	double arm[3], along = 0;
	if (!(squares > 0)) {
		point[0] = point[1] = point[2] = NAN;
		return;
	}
	for (int i = 0; i < 3; i++) {
		const int j = (i + 1) % 3, k = (i + 2) % 3;
		arm[i] = (force[j] * moment[k] - force[k] * moment[j]) / squares;
	}
	const double low[3] = {0, 0, -reach};
	for (int i = 0; i < 3; i++)
		along += (low[i] - arm[i]) * force[i] / squares;
	for (int i = 0; i < 3; i++)
		point[i] = origin[i] + arm[i] + along * force[i];
}

#define AT_REST 1e-3 /* m/s. The slip of a rim that is slower would be noise */

/* Sets slip, and the speed of the rim or belt less that along the ground, m/s. `belt`: how fast the body's belt runs, m/s. `normal`: of the ground, along which
 * a wheel travels. Without one, travel counts in plan. A body on a path has no vertical velocity, so there it is upright. */
static void set_slip(const struct scene_object *object, const struct furrow_state *state, double belt, const double normal[3], struct furrow_contact *contact)
{
	struct soil_pose pose;
	contact->slip = NAN;
	contact->slip_velocity = 0;
	if (object->shape.belt) {
		double axes[3][3], along = 0;
		world_axes(state->pose.orientation, axes);
		for (int k = 0; k < 3; k++)
			along += state->linear[k] * axes[0][k];
		contact->slip = belt != 0 ? 1 - along / belt : NAN;
		contact->slip_velocity = belt - along;
		return;
	}
	if (object->shape.kind != SOIL_WHEEL || world_attitude(&object->shape, object->name, &state->pose, &pose) != STATUS_OK)
		return;
	const double c = cos(pose.yaw), s = sin(pose.yaw), rise = normal[2] > 0 ? -(normal[0] * c + normal[1] * s) / normal[2] : 0;
	const double along = (state->linear[0] * c + state->linear[1] * s + state->linear[2] * rise) / hypot(1, rise);
	const double rim = world_spin(&pose, state->angular) * object->shape.radius;
	contact->slip = fabs(rim) > AT_REST ? 1 - along / rim : NAN;
	contact->slip_velocity = rim - along;
}

/* Tells all but the slip. */
static enum status fill(struct world *world, const struct body *body, const struct furrow_state *state,
			const struct world_force *force, double time, enum furrow_contact_state touches, struct furrow_contact *contact)
{
	const struct scene_object *object = body->object;
	*contact = world_contact_unknown();
	contact->time = time;
	contact->carried = world_aboard_of(world, body).volume;
	contact->state = touches;
	contact->sinkage = touches == FURROW_AIR ? 0 : force->sinkage;
	enum status status = normal_at(world, state->pose.position, contact->normal);
	if (status != STATUS_OK || !world_feels(world))
		return status;
	double carries[3], turns[3];
	memcpy(carries, force->force, sizeof carries);
	memcpy(turns, force->moment, sizeof turns);
	world_carried_force(world, body, carries, turns);
	memcpy(contact->force, carries, sizeof contact->force);
	memcpy(contact->moment, turns, sizeof contact->moment);
	contact->area = force->area;
	contact->pull = object->shape.belt ? force->pull : (double)NAN;
	struct soil_pose pose = {.x = 0};
	status = world_attitude(&object->shape, object->name, &state->pose, &pose);
	if (status != STATUS_OK)
		return status;
	line_of(state->pose.position, soil_shape_reach(&object->shape, pose.pitch, pose.roll), carries, turns, contact->point);
	contact->normal_force = 0;
	for (int i = 0; i < 3; i++)
		contact->normal_force += contact->force[i] * contact->normal[i];
	struct soil_numbers soil;
	bool found;
	status = world_soil_numbers_at(world, state->pose.position[0], state->pose.position[1], &soil, &found);
	if (status != STATUS_OK || !found)
		return status;
	contact->shear_limit = soil_shear_limit(&soil, &object->interface, force->area, fmax(contact->normal_force, 0));
	return STATUS_OK;
}

void world_tell_probed(const struct world *world, const struct body *body, const struct furrow_state *state, const struct furrow_belt *belt, const struct soil_probed *probed,
		       double time, struct furrow_contact *contact)
{
	const struct scene_object *object = body->object;
	struct soil_pose pose = {.x = 0};
	*contact = world_contact_unknown();
	contact->time = time;
	contact->state = world_contact_state_of((enum deform_state)probed->state);
	contact->carried = world_aboard_of(world, body).volume;
	set_slip(object, state, belt->speed, probed->normal, contact);
	contact->pull = object->shape.belt ? probed->pull : (double)NAN;
	contact->sinkage = probed->sinkage;
	contact->area = probed->area;
	contact->normal_force = probed->normal_force;
	contact->shear_limit = probed->shear_limit;
	double force[3], moment[3];
	memcpy(force, probed->force, sizeof force);
	memcpy(moment, probed->moment, sizeof moment);
	world_carried_force(world, body, force, moment);
	memcpy(contact->force, force, sizeof contact->force);
	memcpy(contact->moment, moment, sizeof contact->moment);
	memcpy(contact->normal, probed->normal, sizeof contact->normal);
	memcpy(contact->stiffness, probed->stiffness, sizeof contact->stiffness);
	memcpy(contact->damping, probed->damping, sizeof contact->damping);
	if (world_attitude(&object->shape, object->name, &state->pose, &pose) == STATUS_OK)
		line_of(state->pose.position, soil_shape_reach(&object->shape, pose.pitch, pose.roll), force, moment,
			contact->point);
}

enum status world_body_contact(struct world *world, int32_t number, struct furrow_contact *contact)
{
	struct furrow_state state;
	*contact = world_contact_unknown();
	enum status status = world_body_state(world, number, &state);
	if (status != STATUS_OK)
		return status;
	const struct body *body = world->bodies[number];
	if (body->kind != BODY_PATH && !body->host.placed)
		return STATUS_OK;
	if (body->kind != BODY_PATH) {
		struct soil_probed probed;
		status = fill(world, body, &state, &body->host.force, body->host.told, body->host.state, contact);
		set_slip(body->object, &state, body->host.belt.speed, contact->normal, contact);
		if (status == STATUS_OK)
			status = world_probes_now(world, number, &probed);
		if (status == STATUS_OK && probed.known) {
			memcpy(contact->stiffness, probed.stiffness, sizeof contact->stiffness);
			memcpy(contact->damping, probed.damping, sizeof contact->damping);
		}
		return status;
	}
	if (body->next == 0)
		return STATUS_OK;
	struct world_force force = world_no_force(0);
	bool known = world_forces_known(world->forces, (size_t)number, &force);
	enum furrow_contact_state touches = !body->has_last ? FURROW_AIR : FURROW_TOUCHING;
	if (known)
		touches = world_contact_state_of(force.state);
	else
		force.sinkage = body->sinkage;
	/* The soil was last touched at the latest path sample. */
	enum status filled = fill(world, body, &state, &force, motion_track_sample_time(body->track, body->next - 1), touches, contact);
	set_slip(body->object, &state, 0, (const double[3]){0, 0, 1}, contact);
	if (body->object->shape.belt || body->object->path.attitude[0] != 0) { /* its rates are not those of the rim */
		contact->slip = body->object->slip;
		contact->slip_velocity = hypot(state.linear[0], state.linear[1]) * body->object->slip / (1 - body->object->slip);
	}
	return filled;
}

enum status world_path_state(const struct world *world, size_t body, struct furrow_state *state)
{
	const struct body *at = world->bodies[body];
	struct track_point point, before;
	const double moment = 1e-3; /* s over which velocities are measured */
	motion_track_at(at->track, world->time, &point);
	motion_track_at(at->track, fmax(world->time - moment, 0), &before);
	struct soil_pose pose = at->last;
	pose.yaw = point.yaw;
	pose.pitch = point.pitch;
	pose.roll = point.roll;
	*state = (struct furrow_state){.pose = {{point.x, point.y, lattice_offset_metres(at->last.z)}, {1, 0, 0, 0}}};
	if (!at->has_last)
		world_place(world, body, state->pose.position, &pose.yaw);
	else if (at->loaded_body > 0)
		state->pose.position[2] += lattice_offset_metres(at->raised);
	world_orientation(&pose, state->pose.orientation);
	const double seconds = fmin(moment, world->time);
	if (seconds > 0) {
		state->linear[0] = (point.x - before.x) / seconds;
		state->linear[1] = (point.y - before.y) / seconds;
		state->angular[2] = remainder(point.yaw - before.yaw, 2 * M_PI) / seconds;
	}
	const struct scene_object *object = at->object;
	if (object->shape.kind == SOIL_WHEEL) {
		const double rolls = scene_slip_way(object, state->linear[0], state->linear[1], pose.yaw) / (object->shape.radius * (1 - object->slip));
		double axes[3][3];
		soil_axes(pose.yaw, 0, pose.roll, 0, axes);
		for (int k = 0; k < 3; k++)
			state->angular[k] += axes[1][k] * rolls;
	}
	return STATUS_OK;
}
