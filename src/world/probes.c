/* Probes: what the soil would do to bodies of a host. The law reads the ground where it lies, and changes nothing. */
#include <math.h>
#include <string.h>

#include "world/internal.h"

void world_rotation_between(const double from[4], const double to[4], double rotated[3])
{
	/* to * conjugate(from) */
	double w = to[0] * from[0] + to[1] * from[1] + to[2] * from[2] + to[3] * from[3];
	double v[3] = {-to[0] * from[1] + to[1] * from[0] - to[2] * from[3] + to[3] * from[2],
		       -to[0] * from[2] + to[2] * from[0] - to[3] * from[1] + to[1] * from[3],
		       -to[0] * from[3] + to[3] * from[0] - to[1] * from[2] + to[2] * from[1]};
	const double sine = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]), sign = w < 0 ? -1 : 1;
	const double by = sine > 0 ? 2 * atan2(sine, sign * w) / sine * sign : 0;
	for (int k = 0; k < 3; k++)
		rotated[k] = by * v[k];
}

/* Gives the body's present pose. Returns false if it has none, or is gone. */
static bool place_of(const struct host_body *host, struct soil_pose *pose)
{
	return host->placed && !host->removed && world_attitude(&host->body.object->shape, host->body.object->name, &host->now.pose, pose) == STATUS_OK;
}

/* The motion since the last contact. Poses are rounded; a probe is of the very place, to 2^-40 m. */
static struct soil_motion whole_motion(const struct host_body *host, const struct world_state *state, const struct soil_pose *now, const struct soil_pose *to)
{
	const struct scene_object *object = host->body.object;
	const bool known = host->body.in_contact && !host->fresh;
	const double unposed = world_rates_unposed(host, state);
	struct soil_motion motion = {
		.shape = &object->shape, .interface = object->interface, .from = known ? host->body.last : *to, .to = *to, .stamped = host->stamped,
		.turned = host->turned + remainder(to->turn - now->turn, 2 * M_PI) + world_spin(to, state->angular) * unposed, .hosted = true,
	};
	if (object->shape.belt) {
		const struct world_belt *belt = world_belt_of(host, state);
		motion.turned = known ? belt->travel - host->body.last.turn : 0;
		motion.runs = belt->speed;
	}
	world_rotation_between(host->now.pose.orientation, state->pose.orientation, motion.rotated);
	const int64_t place[3] = {to->x, to->y, to->z};
	for (int k = 0; k < 3; k++) {
		motion.rotated[k] += host->rotated[k];
		motion.rotated[k] += unposed * state->angular[k];
		motion.beyond[k] = rint((state->pose.position[k] - lattice_offset_metres(place[k])) * 0x1p40) * 0x1p-40;
	}
	memcpy(motion.linear, state->linear, sizeof motion.linear);
	memcpy(motion.angular, state->angular, sizeof motion.angular);
	return motion;
}

/*
 * Gives the motion that a step to this state would end with. Where the motion turns at the pose of the last step, the step makes a contact up to there
 * first. Then that comes before. Returns true if there is one.
 */
static bool motion_of(const struct world *world, const struct host_body *host, const struct world_state *state, const struct soil_pose *now, const struct soil_pose *to,
		      struct soil_motion *motion, struct soil_motion *before)
{
	double turned, rotated[3];
	*motion = whole_motion(host, state, now, to);
	turned = motion->turned - host->turned;
	for (int k = 0; k < 3; k++)
		rotated[k] = motion->rotated[k] - host->rotated[k];
	if (host->quiet || !world_turns_back(world, host, to, turned, rotated))
		return false;
	*before = *motion;
	before->to = motion->from = host->felt;
	before->turned = host->turned;
	before->runs = 0;
	memcpy(before->rotated, host->rotated, sizeof before->rotated);
	memset(before->beyond, 0, sizeof before->beyond);
	memset(before->linear, 0, sizeof before->linear);
	memset(before->angular, 0, sizeof before->angular);
	motion->turned = turned;
	memcpy(motion->rotated, rotated, sizeof rotated);
	motion->stamped = world_stamp_after(world, host, &host->felt);
	return true;
}

static bool fits(const struct world *world, struct post_rect rect)
{
	const size_t tiles = world_tiles_in(world, rect);
	return rect.x1 - rect.x0 <= DEFORM_WHOLE_POSTS && rect.y1 - rect.y0 <= DEFORM_WHOLE_POSTS && tiles > 0 && tiles <= world->counts.windows.tiles;
}

/* Lists the bodies beside a host's body, in world->near.rests. Returns how many there are. */
static size_t list_beside(struct world *world, size_t body, struct post_rect rect)
{
	struct near_table *near = &world->near;
	size_t count = 0;
	world_near_find(world, rect);
	for (size_t i = 0; i < near->found_count; i++)
		if (near->found[i].body != body)
			near->rests[count++] = near->found[i].rest;
	return count;
}

/* world_near_begin was called. */
static enum status probe_host(struct world *world, size_t body, const struct host_body *host, const struct world_state *state, struct soil_probed *probed)
{
	const struct scene_object *object = host->body.object;
	struct held_tiles held;
	struct soil_pose to, now;
	probed->known = false;
	enum status status = world_state_check(&object->shape, object->name, state, &to);
	if (status != STATUS_OK || world_is_torn(world) || !place_of(host, &now))
		return status;
	struct soil_motion motion, before;
	const bool turns = motion_of(world, host, state, &now, &to, &motion, &before);
	struct post_rect rect = bearing_probe_posts(world->bearing, &motion);
	if (post_rect_empty(rect))
		return STATUS_OK;
	if (turns)
		rect = post_rect_joined(rect, bearing_probe_posts(world->bearing, &before));
	if (!fits(world, rect))
		return STATUS_OK;
	const size_t beside = list_beside(world, body, rect);
	status = world_hold(world, rect, &held);
	if (status == STATUS_OK)
		status = bearing_probe(world->bearing, turns ? &before : NULL, &motion, world->near.rests, beside, held.tiles, held.count, probed);
	world_release(world, &held);
	return status;
}

enum status world_probes_now(struct world *world, int32_t number, struct soil_probed *probed)
{
	const struct host_body *host = world_host_body(world, number);
	const size_t index = world->scene->object_count + 1 + (size_t)number;
	probed->known = false;
	if (!host->placed || world->bearing == NULL || !world_feels(world) || host->body.elsewhere)
		return STATUS_OK;
	enum status status = world_near_begin(world, 0, NULL, NULL);
	return status == STATUS_OK ? probe_host(world, index, host, &host->now, probed) : status;
}

static struct host_body *probed_host(const struct world *world, int32_t number)
{
	struct host_body *host = world_feels(world) ? world_host_body(world, number) : NULL;
	return host != NULL && !host->removed ? host : NULL;
}

bool world_probe_reads(const struct world *world, size_t count, const int32_t *numbers)
{
	for (size_t i = 0; i < count; i++) {
		const struct host_body *host = probed_host(world, numbers[i]);
		if (host != NULL && host->placed && !world_is_torn(world))
			return true;
	}
	return false;
}

/* Checks a state whose contact is unknown. */
static enum status check(const struct world *world, int32_t number, const struct world_state *state)
{
	const struct host_body *host = world_host_body(world, number);
	const struct scene_object *object = host != NULL ? host->body.object : world->bodies[number].object;
	struct soil_pose pose;
	return world_state_check(&object->shape, object->name, state, &pose);
}

enum status world_probe(struct world *world, size_t count, const int32_t *numbers, const struct world_state *states,
			struct world_contact *contacts)
{
	const struct world_ranks *ranks = world->ranks;
	enum status status = STATUS_OK;
	if (ranks != NULL && world->unplaced)
		status = ranks->step(ranks->user, world->time, status);
	if (status == STATUS_OK && world->bearing != NULL && world_feels(world))
		status = world_near_begin(world, count, numbers, states);
	for (size_t i = 0; i < count && status == STATUS_OK; i++) {
		const struct host_body *host = probed_host(world, numbers[i]);
		struct soil_probed probed = {.known = false};
		contacts[i] = world_contact_unknown();
		if (host == NULL || host->body.elsewhere) {
			status = check(world, numbers[i], &states[i]);
			continue;
		}
		struct world_state state = states[i];
		status = check(world, numbers[i], &state);
		if (status == STATUS_OK && host->placed)
			world_rates_fill(&host->now.pose, world->scene->time_step, &state);
		if (status == STATUS_OK)
			status = probe_host(world, world->scene->object_count + 1 + (size_t)numbers[i], host, &state, &probed);
		if (probed.known)
			world_tell_probed(host, &state, &probed, world->time, &contacts[i]);
	}
	world_near_end(world);
	return ranks != NULL ? ranks->probed(ranks->user, count, numbers, contacts, status) : status;
}
