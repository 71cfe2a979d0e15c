/* One time step: what the soil does, what the vehicles do, and which of their geoms change the ground. */
#include <math.h>
#include <stdio.h>

#include "vehicle/internal.h"
#include "vehicle/start.h"

#define DIP_LEAST 2e-5    /* m: so much down changes the ground where the body leaves that dip: a hundredth of what soil springs back */
#define BACK_SHARE 0.05   /* of a post: so much along the level changes it where the motion turns back */
#define TURN_MOST 1.0     /* rad: so much turn changes the ground */

/* --- the ground --- */

static void turn_between(const struct furrow_pose *a, const struct furrow_pose *b, double angles[3])
{
	double back[4], turn[4];
	mju_negQuat(back, a->orientation);
	mju_mulQuat(turn, b->orientation, back);
	mju_quat2Vel(angles, turn, 1);
}

/* Places of a geom: where it last changed the ground; where this step started, and where it ends. */
enum { TOUCHED, START, END, PLACES };

static void find_places(const struct vehicles *vehicles, const struct soil_geom *geom, const struct furrow_state *to, double places[PLACES][3])
{
	mju_copy3(places[TOUCHED], geom->touched.pose.position);
	mju_addScl3(places[START], geom->now.pose.position, geom->now.linear, -vehicles->scene->time_step);
	mju_copy3(places[END], to->pose.position);
}

/* Finds their heights above the undisturbed ground, m. Where a place lies over no ground, all are plain heights. */
static enum status find_heights(const struct vehicles *vehicles, double places[PLACES][3], double heights[PLACES])
{
	double ground[PLACES];
	bool all = true;
	for (int i = 0; i < PLACES; i++) {
		int64_t height;
		bool any;
		TRY(resident_ground_height(world_resident(vehicles->world)->ground, lattice_offset(places[i][0]), lattice_offset(places[i][1]), &height, &any));
		all = all && any;
		ground[i] = any ? lattice_offset_metres(height) : 0;
	}
	for (int i = 0; i < PLACES; i++)
		heights[i] = places[i][2] - (all ? ground[i] : 0);
	return STATUS_OK;
}

/*
 * Tells whether a geom's motion since it last changed the ground is worth a contact. What it does in between is elastic for the soil.
 * So where a motion turns back, the ground must know how far it went: how deep it yielded, and how far it was sheared.
 */
static enum status find_due(const struct vehicles *vehicles, const struct soil_geom *geom, const struct furrow_state *to, const struct furrow_belt *belt, bool *due)
{
	const double spacing = world_resident(vehicles->world)->spacing;
	const struct furrow_pose *from = &geom->touched.pose;
	double way[2], turns[3], places[PLACES][3], heights[PLACES];
	*due = true;
	if (!geom->is_touched)
		return STATUS_OK;
	find_places(vehicles, geom, to, places);
	TRY(find_heights(vehicles, places, heights));
	mju_sub(way, to->pose.position, from->position, 2);
	turn_between(from, &to->pose, turns);
	const double level = hypot(way[0], way[1]), turn = mju_norm3(turns), sank = heights[TOUCHED] - heights[END];
	const double turned = geom->shape.kind == SOIL_SPHERE ? 0 : turn;
	if (level >= spacing || fabs(belt->travel - geom->touched_belt.travel) >= spacing || fabs(sank) >= WORLD_SINKAGE_SHARE * spacing ||
	    turned >= TURN_MOST || turned * soil_shape_bound(&geom->shape) >= spacing)
		return STATUS_OK;
	const double now[2] = {to->angular[0] * vehicles->scene->time_step, to->angular[1] * vehicles->scene->time_step};
	/* What runs over the ground changes it often enough, so only its middle counts. More contacts would cost it energy. */
	const bool rolls = soil_shape_runs(&geom->shape);
	const struct world_sinking sinking = {
		.sank = heights[TOUCHED] - heights[START], .went = hypot(places[START][0] - from->position[0], places[START][1] - from->position[1]),
		.turned = {turns[0] - now[0], turns[1] - now[1]}, .sinks = heights[START] - heights[END],
		.goes = rolls ? 0 : hypot(places[END][0] - places[START][0], places[END][1] - places[START][1]), .turns = {now[0], now[1]},
		.reach = rolls ? 0 : world_turning_reach(&geom->shape),
	};
	const bool returns = level > BACK_SHARE * spacing && way[0] * to->linear[0] + way[1] * to->linear[1] < 0 &&
			     way[0] * geom->now.linear[0] + way[1] * geom->now.linear[1] >= 0;
	*due = geom->contact.state != FURROW_AIR && (returns || world_leaves_dip(&sinking, DIP_LEAST));
	return STATUS_OK;
}

void vehicle_geom(const struct vehicles *vehicles, size_t vehicle, size_t geom, double spacing, struct vehicle_geom *out)
{
	const struct soil_geom *from = &vehicles->list[vehicle].geoms[geom];
	const double bound = soil_shape_bound(&from->shape), turn = fmin(TURN_MOST, spacing / bound);
	*out = (struct vehicle_geom){.name = from->name, .shape = &from->shape, .share = from->share, .contacts = 1 / spacing};
	out->hull = !from->is_standing;
	if (!from->is_standing) { /* it touches nothing on level ground */
		out->contacts = 0;
		return;
	}
	if (from->shape.kind == SOIL_WHEEL)
		out->contacts = fmax(out->contacts, 1 / (turn * from->shape.radius));
}

enum status vehicle_touch(struct vehicles *vehicles)
{
	size_t count = 0;
	for (size_t v = 0; v < vehicles->all; v++) {
		struct vehicle *vehicle = &vehicles->list[v];
		for (size_t g = 0; g < vehicle->geom_count; g++) {
			struct soil_geom *geom = &vehicle->geoms[g];
			struct furrow_state to;
			struct furrow_belt belt;
			bool due;
			if (geom->aloft)
				continue;
			vehicle_geom_state(vehicle, geom, &to, &belt);
			TRY(find_due(vehicles, geom, &to, &belt, &due));
			if (!due)
				continue;
			geom->touched = to;
			geom->touched_belt = belt;
			geom->is_touched = true;
			vehicles->numbers[count] = geom->number;
			vehicles->belts[count] = belt;
			vehicles->states[count++] = to;
		}
	}
	return count > 0 ? world_bodies_set(vehicles->world, count, vehicles->numbers, vehicles->states, vehicles->belts) : STATUS_OK;
}

/* --- contacts --- */

/* Moves a state on as it moves now. */
static void go_on(struct furrow_state *state, struct furrow_belt *belt, double seconds)
{
	double turn[4], axis[3], orientation[4];
	mju_addToScl3(state->pose.position, state->linear, seconds);
	belt->travel += belt->speed * seconds;
	mju_copy3(axis, state->angular);
	const double speed = mju_normalize3(axis); /* a body that does not turn gets some axis, and an angle of 0 */
	mju_axisAngle2Quat(turn, axis, speed * seconds);
	mju_mulQuat(orientation, turn, state->pose.orientation);
	mju_copy4(state->pose.orientation, orientation);
}

/* Parts the load of the soil aboard from the ground's force. The load has weight and mass wherever the geom is, and the ground does not pull: coupling.c. */
static void part_load(const struct vehicles *vehicles, struct soil_geom *geom)
{
	double *force = geom->contact.force, *moment = geom->contact.moment;
	if (!geom->carries || !world_body_load(vehicles->world, geom->number, &geom->load, geom->load_at))
		return;
	force[2] += geom->load;
	moment[0] += geom->load_at[1] * geom->load;
	moment[1] -= geom->load_at[0] * geom->load;
}

static enum status ask(struct vehicles *vehicles)
{
	size_t count = 0;
	for (size_t v = 0; v < vehicles->all; v++)
		for (size_t g = 0; g < vehicles->list[v].geom_count; g++) {
			struct soil_geom *geom = &vehicles->list[v].geoms[g];
			vehicle_geom_state(&vehicles->list[v], geom, &geom->now, &geom->now_belt);
			go_on(&geom->now, &geom->now_belt, vehicles->scene->time_step);
			TRY(vehicle_lift_hull(vehicles, &vehicles->list[v], geom));
			if (geom->aloft)
				continue;
			vehicles->numbers[count] = geom->number;
			vehicles->belts[count] = geom->now_belt;
			vehicles->states[count++] = geom->now;
		}
	TRY(world_probe(vehicles->world, count, vehicles->numbers, vehicles->states, vehicles->belts, vehicles->contacts, sizeof *vehicles->contacts));
	count = 0;
	for (size_t v = 0; v < vehicles->all; v++)
		for (size_t g = 0; g < vehicles->list[v].geom_count; g++) {
			struct soil_geom *geom = &vehicles->list[v].geoms[g];
			if (geom->aloft) {
				geom->contact = vehicle_no_contact(vehicles);
				continue;
			}
			geom->contact = vehicles->contacts[count++];
			part_load(vehicles, geom);
			if (geom->roll_dof >= 0)
				vehicle_tell_roll(&vehicles->list[v], geom);
			if (geom->contact.state == FURROW_UNKNOWN && geom->is_touched)
				return fail_with(STATUS_FAILED, "%s: no ground is known under it at %.3f, %.3f after %.3f s; give a shorter time_step", geom->name,
						 geom->now.pose.position[0], geom->now.pose.position[1], world_time(vehicles->world));
		}
	return STATUS_OK;
}

/* A vehicle that leaves the terrain, or comes over a hole, ends the drive, unless the scene says skip. */
static enum status check_ground(const struct vehicles *vehicles, const struct soil_geom *geom)
{
	const struct world *world = vehicles->world;
	const double *at = geom->now.pose.position;
	int64_t height;
	bool any;
	TRY(resident_ground_height(world_resident(world)->ground, lattice_offset(at[0]), lattice_offset(at[1]), &height, &any));
	if (any || world_scene(world)->outside == SCENE_SKIP)
		return STATUS_OK;
	return world_no_ground(world, geom->name, false, at[0], at[1], world_time(world));
}

enum status vehicle_ask(struct vehicles *vehicles)
{
	for (size_t v = 0; v < vehicles->all; v++)
		vehicles->list[v].cut = NULL;
	TRY(ask(vehicles));
	for (size_t v = 0; v < vehicles->all; v++)
		for (size_t g = 0; g < vehicles->list[v].geom_count; g++)
			if (!vehicles->list[v].geoms[g].aloft)
				TRY(check_ground(vehicles, &vehicles->list[v].geoms[g]));
	return STATUS_OK;
}

/* --- the motion --- */

struct motion {
	struct vehicles *vehicles;
	double time, seconds, rate;
	bool drives;
};

static void advance(void *argument)
{
	const struct motion *motion = argument;
	vehicle_advance(motion->vehicles, motion->time, motion->seconds, motion->rate, motion->drives);
}

static bool is_finite(const struct vehicle *vehicle)
{
	const mjData *data = vehicle->data;
	double sum = 0;
	for (int i = vehicle->own.qpos.first; i < vehicle->own.qpos.end; i++)
		sum += fabs(data->qpos[i]);
	for (int i = vehicle->own.dof.first; i < vehicle->own.dof.end; i++)
		sum += fabs(data->qvel[i]);
	return isfinite(sum);
}

/* Returns the vehicle of whose numbers MuJoCo warned first, or that has numbers that are not finite; NULL: none. */
static const struct vehicle *diverged(const struct vehicles *vehicles)
{
	static const int warnings[] = {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC};
	const struct vehicle *bad = NULL;
	for (int w = 0; w < 3; w++) {
		const mjWarningStat *warning = &vehicles->data->warning[warnings[w]];
		for (size_t v = 0; v < vehicles->all && warning->number > 0; v++) {
			const struct owned *own = &vehicles->list[v].own;
			const struct range range = w == 0 ? own->qpos : own->dof;
			if (warning->lastinfo >= range.first && warning->lastinfo < range.end)
				return &vehicles->list[v];
		}
	}
	for (size_t v = 0; v < vehicles->all; v++)
		if (!is_finite(&vehicles->list[v]) && bad == NULL)
			bad = &vehicles->list[v];
	return bad;
}

/* Writes at which joint of the vehicle numbers first went bad, if that is known. */
static void say_joint(const struct vehicles *vehicles, const struct vehicle *bad, char *text, size_t size)
{
	const mjModel *model = vehicles->model;
	const mjWarningStat *places = &vehicles->data->warning[mjWARN_BADQPOS], *rates = &vehicles->data->warning[mjWARN_BADQVEL], *changes = &vehicles->data->warning[mjWARN_BADQACC];
	const int dof = rates->number > 0 ? rates->lastinfo : changes->number > 0 ? changes->lastinfo : -1;
	int joint = -1;
	text[0] = '\0';
	for (int i = bad->own.joint.first; i < bad->own.joint.end; i++) {
		const int end = i + 1 < bad->own.joint.end ? model->jnt_qposadr[i + 1] : bad->own.qpos.end;
		if (places->number > 0 ? places->lastinfo >= model->jnt_qposadr[i] && places->lastinfo < end : dof >= 0 && model->dof_jntid[dof] == i)
			joint = i;
	}
	const char *name = joint >= 0 ? vehicle_part_name(model, mjOBJ_JOINT, joint) : NULL;
	const char *body = joint >= 0 ? vehicle_part_name(model, mjOBJ_BODY, model->jnt_bodyid[joint]) : NULL;
	if (name != NULL || body != NULL)
		snprintf(text, size, ", first at %s %.64s", name != NULL ? "joint" : "body", name != NULL ? name : body);
}

/* MuJoCo sets all controls to 0 if one is out of its range: those of other vehicles, too. */
static enum status check_controls(const struct vehicles *vehicles)
{
	const mjWarningStat *warning = &vehicles->data->warning[mjWARN_BADCTRL];
	for (size_t v = 0; v < vehicles->all && warning->number > 0; v++) {
		const struct range ctrl = vehicles->list[v].own.ctrl;
		if (warning->lastinfo >= ctrl.first && warning->lastinfo < ctrl.end)
			return fail_with(STATUS_FAILED, "%s: control %d of its actuators is no finite number, or above 1e10; give a smaller one", vehicles->list[v].scene->name,
					 warning->lastinfo - ctrl.first + 1);
	}
	return STATUS_OK;
}

static enum status move_all(struct vehicles *vehicles, double rate, bool drives)
{
	struct motion motion = {vehicles, drives ? world_time(vehicles->world) : 0, vehicles->scene->time_step, rate, drives};
	for (size_t v = 0; v < vehicles->all; v++) {
		struct vehicle *vehicle = &vehicles->list[v];
		if (drives)
			vehicle_trail_add(vehicle);
		mju_copy(vehicle->was, &vehicle->data->xpos[3 * vehicle->root], 2);
	}
	TRY(vehicle_guard(vehicles->all == 1 ? vehicles->list[0].scene->name : "vehicles", advance, &motion));
	TRY(check_controls(vehicles));
	TRY(vehicle_check_summed(vehicles));
	const struct vehicle *bad = diverged(vehicles);
	char at[100];
	if (bad != NULL)
		say_joint(vehicles, bad, at, sizeof at);
	if (bad != NULL)
		return fail_with(STATUS_FAILED, "%s: its motion diverged after %.6g s%s%s; shorten time_step (now %g s, at most %s s), soften its "
						"actuators, or give its joints damping", bad->scene->name, motion.time, drives ? "" : " of settling", at, motion.seconds,
				 number_at_most(bad->largest_step, 3).text);
	for (size_t v = 0; v < vehicles->all; v++) {
		struct vehicle *vehicle = &vehicles->list[v];
		const double *now = &vehicle->data->xpos[3 * vehicle->root];
		vehicle->distance += drives ? hypot(now[0] - vehicle->was[0], now[1] - vehicle->was[1]) : 0;
	}
	return STATUS_OK;
}

enum status vehicle_move(struct vehicles *vehicles, double rate, bool drives)
{
	if (!drives)
		vehicle_keep_unsettled(vehicles);
	TRY(vehicle_ask(vehicles));
	TRY(move_all(vehicles, rate, drives));
	if (!drives)
		vehicle_restore_unsettled(vehicles);
	return vehicle_touch(vehicles);
}

double vehicle_kinetic(const struct vehicle *vehicle)
{
	const struct range dofs = vehicle->own.dof;
	mj_mulM(vehicle->model, vehicle->data, vehicle->room, vehicle->data->qvel);
	return mju_dot(vehicle->room + dofs.first, vehicle->data->qvel + dofs.first, (int)range_count(dofs)) / 2;
}
