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
static bool place_of(const struct body *body, struct soil_pose *pose)
{
	return body->host.placed && !body->host.removed && world_attitude(&body->object->shape, body->object->name, &body->host.now.pose, pose) == STATUS_OK;
}

/* The motion since the last contact. Poses are rounded; a probe is of the very place, to 2^-40 m. */
static struct soil_motion whole_motion(const struct body *body, const struct furrow_state *state, const struct furrow_belt *belt, const struct soil_pose *now,
				       const struct soil_pose *to)
{
	const struct scene_object *object = body->object;
	const bool known = body->has_last && !body->host.fresh;
	const double unposed = world_rates_unposed(body, state);
	struct soil_motion motion = {
		.shape = &object->shape, .interface = object->interface, .from = known ? body->last : *to, .to = *to, .stamped = body->host.stamped,
		.trend = known ? body->trend : (struct soil_trend){.whole = {.ran = 0}},
		.turned = body->host.turned + remainder(to->turn - now->turn, 2 * M_PI) + (unposed != 0 ? world_spin(to, state->angular) * unposed : 0), .hosted = true,
	};
	if (object->shape.belt) {
		motion.turned = known ? belt->travel - body->last.turn : 0;
		motion.runs = belt->speed;
	}
	world_rotation_between(body->host.now.pose.orientation, state->pose.orientation, motion.rotated);
	const int64_t place[3] = {to->x, to->y, to->z};
	for (int k = 0; k < 3; k++) {
		motion.rotated[k] += body->host.rotated[k];
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
static bool motion_of(const struct world *world, const struct body *body, const struct furrow_state *state, const struct furrow_belt *belt,
		      const struct soil_pose *now, const struct soil_pose *to, struct soil_motion *motion, struct soil_motion *before)
{
	double turned, rotated[3];
	*motion = whole_motion(body, state, belt, now, to);
	turned = motion->turned - body->host.turned;
	for (int k = 0; k < 3; k++)
		rotated[k] = motion->rotated[k] - body->host.rotated[k];
	if (body->kind == BODY_VEHICLE || !world_turns_back(world, body, to, turned, rotated))
		return false;
	*before = *motion;
	before->to = motion->from = body->host.felt;
	before->turned = body->host.turned;
	before->runs = 0;
	memcpy(before->rotated, body->host.rotated, sizeof before->rotated);
	memset(before->beyond, 0, sizeof before->beyond);
	memset(before->linear, 0, sizeof before->linear);
	memset(before->angular, 0, sizeof before->angular);
	motion->trend = bearing_trend_of(world->bearing, before);
	motion->turned = turned;
	memcpy(motion->rotated, rotated, sizeof rotated);
	motion->stamped = world_stamp_after(world, body, &body->host.felt);
	return true;
}

static bool fits(const struct world *world, struct post_rect rect)
{
	const size_t tiles = world_tiles_in(world, rect);
	return rect.x1 - rect.x0 <= DEFORM_WHOLE_POSTS && rect.y1 - rect.y0 <= DEFORM_WHOLE_POSTS && tiles > 0 && tiles <= world->counts.windows.tiles;
}

/* Lists the bodies beside a host's body, in world->near.rests. Returns how many there are. */
static size_t list_beside(struct world *world, size_t number, struct post_rect rect)
{
	struct near_table *near = &world->near;
	size_t count = 0;
	world_near_find(world, rect);
	for (size_t i = 0; i < near->found_count; i++)
		if (near->found[i].body != number)
			near->rests[count++] = near->found[i].rest;
	return count;
}

/* world_near_begin was called. */
static enum status probe_one(struct world *world, size_t number, const struct furrow_state *state, const struct furrow_belt *belt, struct soil_probed *probed)
{
	const struct body *body = world->bodies[number];
	const struct scene_object *object = body->object;
	struct held_tiles held;
	struct soil_pose to, now;
	probed->known = false;
	enum status status = world_state_check(&object->shape, object->name, state, &to);
	if (status != STATUS_OK || world_is_torn(world) || !place_of(body, &now))
		return status;
	struct soil_motion motion, before;
	const bool turns = motion_of(world, body, state, belt, &now, &to, &motion, &before);
	struct post_rect rect = bearing_probe_posts(world->bearing, &motion);
	if (post_rect_empty(rect))
		return STATUS_OK;
	if (turns)
		rect = post_rect_joined(rect, bearing_probe_posts(world->bearing, &before));
	if (!fits(world, rect))
		return STATUS_OK;
	const size_t beside = list_beside(world, number, rect);
	status = world_hold(world, rect, &held);
	if (status == STATUS_OK)
		status = bearing_probe(world->bearing, turns ? &before : NULL, &motion, rect, world->near.rests, beside, held.tiles, held.count, probed);
	world_release(world, &held);
	return status;
}

enum status world_probes_now(struct world *world, int32_t number, struct soil_probed *probed)
{
	const struct body *body = world->bodies[number];
	probed->known = false;
	if (!body->host.placed || world->bearing == NULL || !world_feels(world) || body->elsewhere)
		return STATUS_OK;
	TRY(world_near_begin(world, 0, NULL, NULL));
	return probe_one(world, (size_t)number, &body->host.now, &body->host.belt, probed);
}

/* Returns the body with this number if its probes can be known; NULL: they cannot. */
static const struct body *probed_body(const struct world *world, int32_t number)
{
	const struct body *body = world_feels(world) ? world_body_hosted(world, (size_t)number) : NULL;
	return body != NULL && !body->host.removed ? body : NULL;
}

bool world_probe_reads(const struct world *world, size_t count, const int32_t *numbers)
{
	for (size_t i = 0; i < count; i++) {
		const struct body *body = probed_body(world, numbers[i]);
		if (body != NULL && body->host.placed && !world_is_torn(world))
			return true;
	}
	return false;
}

/* Checks all states, before the first contact is written. */
static enum status check_states(const struct world *world, size_t count, const int32_t *numbers, const struct furrow_state *states)
{
	struct soil_pose pose;
	for (size_t i = 0; i < count; i++) {
		const struct scene_object *object = world->bodies[numbers[i]]->object;
		TRY(world_state_check(&object->shape, object->name, &states[i], &pose));
	}
	return STATUS_OK;
}

/* Fills one contact. `belt` NULL: as world_belts_set told it. */
static enum status probe(struct world *world, int32_t number, const struct furrow_state *asked, const struct furrow_belt *belt, struct furrow_contact *contact)
{
	const struct body *body = probed_body(world, number);
	struct soil_probed probed;
	*contact = world_contact_unknown();
	if (body == NULL || body->elsewhere || !body->host.placed)
		return STATUS_OK;
	struct furrow_state state = *asked;
	world_rates_fill(&body->host.now.pose, world->scene->time_step, &state);
	belt = belt != NULL ? belt : &body->host.belt;
	TRY(probe_one(world, (size_t)number, &state, belt, &probed));
	if (probed.known)
		world_tell_probed(world, body, &state, belt, &probed, world->time, contact);
	return STATUS_OK;
}

static enum status probe_all(struct world *world, size_t count, const int32_t *numbers, const struct furrow_state *states, const struct furrow_belt *belts,
			     struct furrow_contact *contacts, size_t contact_size)
{
	struct furrow_contact whole; /* of an older host's shorter entries */
	TRY(check_states(world, count, numbers, states));
	if (world->bearing != NULL && world_feels(world))
		TRY(world_near_begin(world, count, numbers, states));
	for (size_t i = 0; i < count; i++) {
		struct furrow_contact *contact = contact_size == sizeof whole ? &contacts[i] : &whole;
		TRY(probe(world, numbers[i], &states[i], belts != NULL ? &belts[i] : NULL, contact));
		if (contact == &whole)
			memcpy((char *)contacts + i * contact_size, &whole, contact_size);
	}
	return STATUS_OK;
}

enum status world_probe(struct world *world, size_t count, const int32_t *numbers, const struct furrow_state *states, const struct furrow_belt *belts,
			struct furrow_contact *contacts, size_t contact_size)
{
	const struct world_ranks *ranks = world->ranks;
	enum status status = STATUS_OK;
	if (ranks != NULL && world->unplaced)
		status = ranks->step(ranks->user, world->time, status);
	if (status == STATUS_OK)
		status = probe_all(world, count, numbers, states, belts, contacts, contact_size);
	world_near_end(world);
	return ranks != NULL ? ranks->probed(ranks->user, count, numbers, contacts, status) : status;
}
