/*
 * Bodies of a host in a step: what their motion does to the ground, and what the soil tells of them.
 *
 * A host moves a body by less than a post in a step. So its motion accumulates. It changes the ground when it is worth a swept
 * contact:
 * - after a working post of travel or of turn,
 * - after a tenth of a post of sinkage,
 * - where it turns back: rises after it sank, or goes on along the ground after it sank steeply,
 * - where it goes or slides back, or sinks steeply after it slid,
 * - at a checkpoint, and before a query.
 *
 * In between only the forces are computed, over the same ground (bearing_feel).
 */
#include <math.h>
#include <string.h>

#include "world/internal.h"

#define PART_MORE 0.25    /* a contact may be longer than a post by this share, so that a step that ends just beyond a post makes one contact */
#define FLATTER 4.0       /* m in plan for each metre of sinking: a body that sank steeply and then goes more level than this leaves a dip */
#define DIP_SHARE 0.002   /* of a post: a body that was deeper than at both ends of its motion by less has not been deeper */

static struct event event_of(size_t number, const struct soil_pose *pose, double time)
{
	return (struct event){.body = number, .time = time, .contact = true, .next_time = INFINITY, .pose = *pose};
}

/* Sets what depends on the base below the body: whether there is a contact, and how deep the body is below the base. */
static enum status over_ground(struct world *world, struct event *event, const struct soil_shape *shape)
{
	int64_t ground;
	TRY(resident_ground_height(world->resident.ground, event->pose.x, event->pose.y, &ground, &event->contact));
	if (event->contact)
		event->sinkage = lattice_offset_metres(ground - event->pose.z) + soil_shape_reach(shape, event->pose.pitch, event->pose.roll);
	return STATUS_OK;
}

static double travel(const struct soil_pose *from, const struct soil_pose *to)
{
	return hypot(lattice_offset_metres(to->x - from->x), lattice_offset_metres(to->y - from->y));
}

static double turn_between(double from, double to)
{
	return remainder(to - from, 2 * M_PI);
}

/* The pose of a sphere has no attitude. Returns how far it turned, rad; 0: another shape. */
static double spun(const struct body *body, const double rotated[3])
{
	return body->object->shape.kind == SOIL_SPHERE ? sqrt(rotated[0] * rotated[0] + rotated[1] * rotated[1] + rotated[2] * rotated[2]) : 0;
}

/* Returns the angle between two attitudes, rad. */
static double angle_between(const struct soil_pose *from, const struct soil_pose *to)
{
	double a[3][3], b[3][3], trace = 0;
	if (from->yaw == to->yaw && from->pitch == to->pitch && from->roll == to->roll)
		return 0;
	soil_axes(from->yaw, from->pitch, from->roll, 0, a);
	soil_axes(to->yaw, to->pitch, to->roll, 0, b);
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++)
			trace += (a[i][k] - b[i][k]) * (a[i][k] - b[i][k]);
	return 2 * asin(fmin(sqrt(trace / 8), 1));
}

/* Metres by which its outermost points have turned, or its belt has run. */
static double turned_by(const struct body *body, const struct soil_pose *to)
{
	const double attitude = angle_between(&body->last, to) + spun(body, body->host.rotated);
	const struct soil_shape *shape = &body->object->shape;
	const double bound = soil_shape_bound(shape);
	return shape->belt ? fmax(bound * attitude, fabs(body->host.turned)) : bound * fmax(attitude, fabs(body->host.turned));
}

/* Finds where it is now. How far its belt has run is told beside the attitude. */
static enum status pose_of(const struct body *body, struct soil_pose *pose)
{
	enum status status = world_attitude(&body->object->shape, body->object->name, &body->host.now.pose, pose);
	if (body->object->shape.belt)
		pose->turn = body->host.belt.travel;
	return status;
}

/* Returns what its belt has run since its last contact, m. */
static double ran_to(const struct body *body, const struct soil_pose *to)
{
	return body->has_last ? to->turn - body->last.turn : 0;
}

static bool is_worth_a_contact(const struct world *world, const struct body *body, const struct soil_pose *to)
{
	const double sinkage = fabs(lattice_offset_metres(to->z - body->last.z));
	return travel(&body->last, to) >= world->resident.spacing || turned_by(body, to) >= world->resident.spacing ||
	       sinkage >= WORLD_SINKAGE_SHARE * world->resident.spacing;
}

static bool has_moved(const struct body *body, const struct soil_pose *to)
{
	const struct soil_pose *at = &body->host.felt;
	return at->x != to->x || at->y != to->y || at->z != to->z || at->yaw != to->yaw || at->pitch != to->pitch || at->roll != to->roll ||
	       body->host.turned != body->host.felt_turned;
}

/* Each attitude has two triples of angles. Returns the one of `to` that is nearer to `from`. */
static struct soil_pose nearer(const struct soil_pose *from, const struct soil_pose *to)
{
	struct soil_pose other = *to;
	other.yaw += M_PI;
	other.pitch = copysign(M_PI, to->pitch) - to->pitch;
	other.roll += M_PI;
	const double near = fabs(turn_between(from->yaw, to->yaw)) + fabs(to->pitch - from->pitch) + fabs(turn_between(from->roll, to->roll));
	const double far = fabs(turn_between(from->yaw, other.yaw)) + fabs(other.pitch - from->pitch) + fabs(turn_between(from->roll, other.roll));
	return far < near ? other : *to;
}

static struct soil_pose between(const struct soil_pose *a, const struct soil_pose *to, size_t part, size_t parts)
{
	if (part == parts)
		return *to;
	const double share = (double)part / (double)parts;
	const struct soil_pose end = nearer(a, to), *b = &end;
	return (struct soil_pose){
		.x = a->x + llround((double)(b->x - a->x) * share),
		.y = a->y + llround((double)(b->y - a->y) * share),
		.z = a->z + llround((double)(b->z - a->z) * share),
		.yaw = a->yaw + turn_between(a->yaw, b->yaw) * share,
		.pitch = a->pitch + (b->pitch - a->pitch) * share,
		.roll = a->roll + turn_between(a->roll, b->roll) * share,
		.turn = a->turn + turn_between(a->turn, b->turn) * share,
	};
}

double world_stamp_after(const struct world *world, const struct body *body, const struct soil_pose *to)
{
	const struct soil_pose *from = &body->last;
	const double less = body->has_last ? 2 * travel(from, to) / world->resident.spacing : 0;
	const bool sinks = !body->has_last || lattice_offset_metres(from->z - to->z) > DIP_SHARE * world->resident.spacing;
	return fmax((sinks ? 1 : body->host.stamped) - less, 0);
}

/* Changes the ground up to this pose, by swept contacts of at most 1 + PART_MORE post spacings each. */
static enum status touch(struct world *world, size_t number, const struct soil_pose *to, double time)
{
	struct body *body = world->bodies[number];
	const struct soil_pose from = body->last;
	size_t parts = 1;
	if (body->has_last)
		parts = (size_t)fmin(WORLD_HOST_WAY, fmax(1, ceil(fmax(travel(&from, to), turned_by(body, to)) / world->resident.spacing - PART_MORE)));
	enum status status = STATUS_OK;
	for (size_t part = 1; part <= parts && status == STATUS_OK; part++) {
		struct soil_pose pose = body->has_last ? between(&from, to, part, parts) : *to;
		if (body->object->shape.belt)
			pose.turn = to->turn - body->host.turned * (double)(parts - part) / (double)parts;
		struct event event = event_of(number, &pose, time);
		event.seconds = body->host.since / (double)parts;
		event.turned = body->host.turned / (double)parts;
		for (int k = 0; k < 3; k++)
			event.rotated[k] = body->host.rotated[k] / (double)parts;
		event.distance = body->has_last ? travel(&body->last, &pose) : 0;
		event.stamped = body->host.stamped;
		body->host.stamped = world_stamp_after(world, body, &pose);
		status = over_ground(world, &event, &body->object->shape);
		if (status != STATUS_OK)
			return status;
		if (!event.contact) { /* off the terrain, or over a hole */
			status = world_let_go(world, body);
			body->has_last = false;
			body->trend = (struct soil_trend){.whole = {.ran = 0}};
			world_host_absent(world, event.body);
			continue;
		}
		body->distance += event.distance;
		body->sinkage = event.sinkage;
		status = world_contact(world, &event);
	}
	body->host.fresh = !body->has_last;
	body->host.since = body->host.turned = 0;
	memset(body->host.rotated, 0, sizeof body->host.rotated);
	body->host.felt = *to;
	body->host.felt_turned = 0;
	body->host.felt_moving = parts > 1 || from.x != to->x || from.y != to->y || from.z != to->z;
	return status;
}

/* How far the body's lowest place slid over the ground in a motion, m, east and north. rotated, turned: as in struct body_hosted. */
static void slide_of(const struct body *body, const struct soil_pose *from, const struct soil_pose *to, double turned, const double rotated[3], double slide[2])
{
	const struct soil_shape *shape = &body->object->shape;
	const double ran = soil_shape_ran(shape, turned), reach = soil_shape_runs(shape) ? 0 : soil_shape_reach(shape, to->pitch, to->roll);
	slide[0] = lattice_offset_metres(to->x - from->x) - cos(to->yaw) * ran - rotated[1] * reach;
	slide[1] = lattice_offset_metres(to->y - from->y) - sin(to->yaw) * ran + rotated[0] * reach;
}

bool world_leaves_dip(const struct world_sinking *s, double least)
{
	static const int axes[] = {0, 0, 0, 1, 1}, ways[] = {0, 1, -1, 1, -1}; /* the middle, and places to its left, right, behind and ahead */
	for (int k = 0; k < 5; k++) {
		const double by = ways[k] * s->reach, sank = s->sank + by * s->turned[axes[k]], sinks = s->sinks + by * s->turns[axes[k]];
		if (sank >= least && (sinks < 0 || (sank > s->went && FLATTER * sinks < s->goes)))
			return true;
	}
	return false;
}

/* Tells whether the body leaves a dip in this step. rotated: in this step. */
static bool leaves_dip(const struct world *world, const struct body *body, const struct soil_pose *to, const double rotated[3])
{
	const struct soil_pose *from = &body->last, *at = &body->host.felt;
	const struct world_sinking sinking = {
		.sank = lattice_offset_metres(from->z - at->z), .went = travel(from, at), .turned = {body->host.rotated[0], body->host.rotated[1]},
		.sinks = lattice_offset_metres(at->z - to->z), .goes = travel(at, to), .turns = {rotated[0], rotated[1]},
		.reach = world_turning_reach(&body->object->shape),
	};
	return world_leaves_dip(&sinking, DIP_SHARE * world->resident.spacing);
}

double world_turning_reach(const struct soil_shape *shape)
{
	return shape->kind == SOIL_WHEEL || shape->kind == SOIL_SPHERE ? 0 : M_SQRT1_2 * soil_shape_bound(shape);
}

static bool goes_back(const struct world *world, const struct body *body, const struct soil_pose *to, double turned, const double rotated[3])
{
	const struct soil_pose *from = &body->last, *at = &body->host.felt;
	double before[2], after[2];
	if (!body->has_last || body->host.fresh)
		return false;
	const double went[2] = {lattice_offset_metres(at->x - from->x), lattice_offset_metres(at->y - from->y)};
	const double goes[2] = {lattice_offset_metres(to->x - at->x), lattice_offset_metres(to->y - at->y)};
	if (went[0] * goes[0] + went[1] * goes[1] < 0 && hypot(went[0], went[1]) >= WORLD_SINKAGE_SHARE * world->resident.spacing)
		return true;
	slide_of(body, from, at, body->host.felt_turned, body->host.rotated, before);
	slide_of(body, at, to, turned, rotated, after);
	const double slid = hypot(before[0], before[1]), sinks = lattice_offset_metres(at->z - to->z);
	return slid >= WORLD_SINKAGE_SHARE * world->resident.spacing && (before[0] * after[0] + before[1] * after[1] < 0 || sinks > hypot(after[0], after[1]));
}

/*
 * Tells whether the motion turns at the pose of the last step. There the body leaves a dip, goes or slides back, or sinks after it slid. A contact is taken
 * as straight, so one must end there. Shear that the body mobilised while it was light is not that of the load. turned, rotated: in this step.
 */
bool world_turns_back(const struct world *world, const struct body *body, const struct soil_pose *to, double turned, const double rotated[3])
{
	return (body->has_last && !body->host.fresh && leaves_dip(world, body, to, rotated)) || goes_back(world, body, to, turned, rotated);
}

/* Computes only the forces, without changing the ground. */
static enum status feel(struct world *world, size_t number, const struct soil_pose *to, double time, bool moves)
{
	struct body *body = world->bodies[number];
	struct event event = event_of(number, to, time);
	event.seconds = moves ? body->host.since : 0;
	event.turned = body->host.turned;
	event.stamped = body->host.stamped;
	memcpy(event.rotated, body->host.rotated, sizeof event.rotated);
	TRY(over_ground(world, &event, &body->object->shape));
	body->host.felt = *to;
	body->host.felt_turned = body->host.turned;
	body->host.felt_moving = moves;
	if (event.contact)
		return world_feel(world, &event);
	world_host_absent(world, event.body);
	return STATUS_OK;
}

/* A body of a vehicle changes the ground whenever it is set. A wheel turns by less than half a turn between two contacts. */
static enum status step_of_vehicle(struct world *world, size_t number, double until)
{
	struct body *body = world->bodies[number];
	const double began = body->host.since;
	struct soil_pose to;
	if (!body->host.has_next)
		return STATUS_OK;
	world_rotation_between(body->host.now.pose.orientation, body->host.next.pose.orientation, body->host.rotated);
	body->host.now = body->host.next;
	body->host.belt = body->host.next_belt;
	body->host.has_next = false;
	enum status status = pose_of(body, &to);
	if (status != STATUS_OK)
		return status;
	body->host.turned = body->has_last ? turn_between(body->last.turn, to.turn) : 0;
	if (body->object->shape.belt)
		body->host.turned = ran_to(body, &to);
	body->host.since = body->has_last ? until - began : 0;
	status = touch(world, number, &to, until);
	body->host.since = until;
	return status;
}

static enum status step_body(struct world *world, size_t number, double seconds, double until)
{
	struct body *body = world->bodies[number];
	struct soil_pose to;
	if (body->kind == BODY_VEHICLE)
		return step_of_vehicle(world, number, until);
	world_rates_take(body, seconds);
	TRY(pose_of(body, &to));
	double turned = 0, rotated[3];
	if (body->object->shape.kind == SOIL_WHEEL)
		turned = world_spin(&to, body->host.now.angular) * seconds;
	if (body->object->shape.belt)
		turned = ran_to(body, &to) - body->host.turned;
	for (int k = 0; k < 3; k++)
		rotated[k] = body->host.now.angular[k] * seconds;
	if (world_turns_back(world, body, &to, turned, rotated)) {
		const struct soil_pose at = body->host.felt;
		TRY(touch(world, number, &at, until - seconds));
	}
	body->host.turned += turned;
	for (int k = 0; k < 3; k++)
		body->host.rotated[k] += rotated[k];
	const bool moved = has_moved(body, &to) || spun(body, rotated) > 0;
	body->host.since += moved ? seconds : 0;
	if (body->host.fresh || !body->has_last || is_worth_a_contact(world, body, &to))
		return touch(world, number, &to, until);
	/* Where it came to rest the rates go. */
	if (world_feels(world) && (moved || body->host.felt_moving))
		return feel(world, number, &to, until, moved);
	body->host.felt = to;
	body->host.felt_turned = body->host.turned;
	body->host.told = until; /* nothing moves: what was told holds */
	return STATUS_OK;
}

enum status world_hosts_step(struct world *world, double seconds, double until)
{
	world->near.stale |= seconds == 0; /* no step has listed them */
	for (size_t i = 0; i < world->body_count; i++)
		if (world_is_set_down(world->bodies[i]))
			TRY(step_body(world, i, seconds, until));
	return world_meetings_flush(world);
}

static bool is_behind(const struct world *world, const struct body *body, struct soil_pose *to)
{
	if (!world_is_set_down(body) || body->host.fresh || !body->has_last ||
	    pose_of(body, to) != STATUS_OK)
		return false;
	const struct soil_pose *last = &body->last;
	return to->x != last->x || to->y != last->y || to->z != last->z || to->yaw != last->yaw || to->pitch != last->pitch ||
	       to->roll != last->roll;
}

enum status world_hosts_commit(struct world *world)
{
	enum status status = STATUS_OK;
	bool any = false;
	struct soil_pose to;
	if (!world_has_begun(world)) /* no step has moved a body */
		return STATUS_OK;
	for (size_t i = 0; i < world->body_count && status == STATUS_OK; i++) {
		if (!is_behind(world, world->bodies[i], &to))
			continue;
		world_tear(world);
		any = true;
		status = touch(world, i, &to, world->time);
	}
	if (status == STATUS_OK)
		status = world_meetings_flush(world);
	if (status == STATUS_OK && any)
		status = world_forces_end_step(world->forces, world->time);
	return status == STATUS_OK && any ? world_end_change(world) : status;
}

/* --- being told --- */

void world_host_felt(struct world *world, size_t index, double time, const struct world_force *force)
{
	struct body *body = world->bodies[index];
	body->host.force = *force;
	body->host.told = time;
	body->host.state = world_contact_state_of(force->state);
	if (body->host.state == FURROW_AIR)
		body->trend.scooped = 0; /* its bars throw off what they carried, and take nothing */
}

void world_host_absent(struct world *world, size_t index)
{
	struct body *body = world->bodies[index];
	if (body->kind == BODY_VEHICLE)
		return;
	body->host.state = FURROW_AIR;
	body->host.force = world_no_force(0);
	body->host.told = world->until;
}
