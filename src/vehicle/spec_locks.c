/*
 * Joints that nothing drives.
 *
 * A URDF has no actuators, so arms and legs would hang while a vehicle follows a path. So joints with limits are locked in their first pose, by an equality.
 * Those of a suspension move freely: wheels are below them, and hold the vehicle up. A vehicle on W wheels is held up if 3 + N joints are at most W. Legs with wheels
 * have more joints, and would give way: they are locked, too. The scene's servo.lock and servo.free name joints of any model that are locked, and that are not.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "vehicle/spec.h"

#define LEVEL 0.5   /* how much of a wheel's axle looks up at most */
#define TURNS 2.0   /* more than that between its limits, and a hinge is a wheel's */
#define ABOVE 0.05  /* m: a wheel that the driver does not name has its axle at most so far above those that it names */

/* A body with its joint, in the first pose. */
struct link {
	mjsJoint *joint;         /* NULL: it is fixed to the body above */
	double height, axis_up;  /* m: of the joint; how much of its axis looks up */
	size_t above;            /* number of the body above it; its own: it is a root */
	bool is_wheel, has_wheels; /* has_wheels: below it */
};

struct links {
	struct link *list;
	size_t count, room;
};

static bool moves(const mjsJoint *joint)
{
	return joint->type == mjJNT_HINGE || joint->type == mjJNT_SLIDE;
}

/* Returns true if a hinge turns round and round, as a wheel does. Some files give wheels limits of many turns. */
static bool turns_round(const mjsJoint *joint)
{
	return joint->type == mjJNT_HINGE && (!vehicle_spec_limited(joint) || joint->range[1] - joint->range[0] > TURNS * 2 * M_PI);
}

/* Returns true for a slide whose limits are equal, which MuJoCo would let go: a URDF has no slide without limits. */
static bool has_no_way(const mjsJoint *joint)
{
	return joint->type == mjJNT_SLIDE && !vehicle_spec_limited(joint);
}

static bool has_servo(const struct spec *spec, const char *joint)
{
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_ACTUATOR); each != NULL; each = mjs_nextElement(spec->spec, each))
		if (strcmp(mjs_getString(mjs_asActuator(each)->target), joint) == 0)
			return true;
	return false;
}

static bool follows_another(const struct spec *spec, const char *joint)
{
	for (size_t i = 0; i < spec->mimic_count; i++)
		if (strcmp(spec->mimics[i].joint, joint) == 0)
			return true;
	return false;
}

/* --- the tree of bodies --- */

/* `pos`, `quat`: of the body above. */
static enum status add_links(const struct spec *spec, struct links *links, const mjsBody *above, size_t number, const double pos[3], const double quat[4])
{
	const int up = spec->scene->y_up ? 1 : 2;
	for (mjsElement *child = mjs_firstChild(above, mjOBJ_BODY, 0); child != NULL; child = mjs_nextChild(above, child, 0)) {
		const mjsBody *body = mjs_asBody(child);
		mjsElement *joint = mjs_firstChild(body, mjOBJ_JOINT, 0);
		double place[3], turn[4], axis[3];
		mju_rotVecQuat(place, body->pos, quat);
		mju_addTo3(place, pos);
		mju_mulQuat(turn, quat, body->quat);
		TRY(mem_grow(&links->list, &links->room, links->count + 1, sizeof *links->list, "a vehicle"));
		struct link *link = &links->list[links->count];
		*link = (struct link){.height = place[up], .above = above->element == mjs_findBody(spec->spec, "world")->element ? links->count : number};
		if (joint != NULL && moves(mjs_asJoint(joint))) {
			link->joint = mjs_asJoint(joint);
			mju_rotVecQuat(axis, link->joint->axis, turn);
			link->axis_up = fabs(axis[up]);
		}
		TRY(add_links(spec, links, body, links->count++, place, turn));
	}
	return STATUS_OK;
}

static void mark_wheel(struct links *links, size_t number)
{
	links->list[number].is_wheel = true;
	while (links->list[number].above != number) {
		number = links->list[number].above;
		links->list[number].has_wheels = true;
	}
}

/* Marks the wheels that the driver names, and those at their height: of castors and trailers. Returns how many there are. */
static size_t find_wheels(const struct spec *spec, struct links *links)
{
	const struct scene_vehicle *scene = spec->scene;
	double highest = -INFINITY;
	size_t count = 0;
	for (int named = 1; named >= 0; named--)
		for (size_t i = 0; i < links->count; i++) {
			const struct link *link = &links->list[i];
			const char *name = link->joint != NULL ? mjs_getString(mjs_getName(link->joint->element)) : NULL;
			if (name == NULL || link->is_wheel || link->joint->type != mjJNT_HINGE || vehicle_matches(&scene->steer, name, false))
				continue;
			const bool drives = vehicle_matches(&scene->drive, name, false) || vehicle_matches(&scene->powertrain.wheels, name, false);
			if (named == 1 ? !drives : !turns_round(link->joint) || link->axis_up > LEVEL || link->height > highest + ABOVE)
				continue;
			if (named == 1)
				highest = fmax(highest, link->height);
			mark_wheel(links, i);
			count++;
		}
	return count;
}

/* --- what is locked --- */

static bool is_idle(const struct spec *spec, const struct link *link)
{
	const char *name = link->joint != NULL ? mjs_getString(mjs_getName(link->joint->element)) : NULL;
	return name != NULL && !turns_round(link->joint) && !link->is_wheel && !has_servo(spec, name) && !follows_another(spec, name) &&
	       !vehicle_matches(&spec->scene->servo.lock, name, false);
}

static void lock(struct spec *spec, const mjsJoint *joint)
{
	mjsEquality *equality = mjs_addEquality(spec->spec, NULL);
	if (equality == NULL) {
		spec->status = fail_memory("a vehicle");
		return;
	}
	char name[256];
	snprintf(name, sizeof name, SPEC_LOCK "%.240s", mjs_getString(mjs_getName(joint->element)));
	(void)mjs_setName(equality->element, name);
	equality->type = mjEQ_JOINT;
	equality->objtype = mjOBJ_JOINT;
	mjs_setString(equality->name1, mjs_getString(mjs_getName(joint->element)));
	mju_zero(equality->data, mjNEQDATA); /* vehicle_start_pose sets the place */
}

static void tell(struct spec *spec, const struct spec_names *names, const char *one, const char *several)
{
	if (names->count == 1)
		vehicle_spec_tell(spec, "1 joint with limits (%s) has no actuator, and the driver does not name it: it %s", names->text, one);
	else if (names->count > 1)
		vehicle_spec_tell(spec, "%zu joints with limits (%s) have no actuator, and the driver does not name them: they %s", names->count, names->text, several);
}

static void lock_idle(struct spec *spec, struct links *links)
{
	struct spec_names locked = {.count = 0}, free = {.count = 0};
	const bool path = spec->scene->driver == SCENE_FOLLOW;
	const size_t wheels = find_wheels(spec, links);
	size_t suspension = 0;
	for (size_t i = 0; i < links->count; i++)
		suspension += links->list[i].has_wheels && is_idle(spec, &links->list[i]) &&
			      !vehicle_matches(&spec->scene->servo.free, mjs_getString(mjs_getName(links->list[i].joint->element)), false);
	for (size_t i = 0; i < links->count && spec->status == STATUS_OK; i++) {
		const struct link *link = &links->list[i];
		if (!is_idle(spec, link))
			continue;
		const char *name = mjs_getString(mjs_getName(link->joint->element));
		const bool held_up = link->has_wheels && 3 + suspension <= wheels;
		if ((!has_no_way(link->joint) && (!path || held_up)) || vehicle_matches(&spec->scene->servo.free, name, false)) {
			vehicle_spec_name(&free, name);
		} else {
			lock(spec, link->joint);
			vehicle_spec_name(&locked, name);
		}
	}
	tell(spec, &free, "moves freely", "move freely");
	tell(spec, &locked, "is locked in its first pose; servo: {free: [JOINT]} lets it move", "are locked in their first pose; servo: {free: [JOINT, ...]} lets them move");
}

/* Locks joints that the scene names. */
static enum status lock_named(struct spec *spec)
{
	const struct scene_texts *const patterns[] = {&spec->scene->servo.lock, &spec->scene->servo.free};
	for (size_t k = 0; k < 2; k++)
		for (size_t i = 0; i < patterns[k]->count && spec->status == STATUS_OK; i++) {
			const struct scene_texts one = {&patterns[k]->list[i], 1};
			bool any = false;
			for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_JOINT); each != NULL; each = mjs_nextElement(spec->spec, each)) {
				const mjsJoint *joint = mjs_asJoint(each);
				if (!moves(joint) || !vehicle_matches(&one, mjs_getString(mjs_getName(each)), false))
					continue;
				const struct scene_texts earlier = {patterns[k]->list, i};
				any = true;
				if (k == 0 && !vehicle_matches(&earlier, mjs_getString(mjs_getName(each)), false)) /* else it is locked already */
					lock(spec, joint);
			}
			if (!any)
				return fail_with(STATUS_INPUT, "%s: servo.%s: %.64s names no hinge or slide of the model; furrow model lists them", spec->where, k == 0 ? "lock" : "free",
						 patterns[k]->list[i]);
		}
	return spec->status;
}

enum status vehicle_spec_locks(struct spec *spec)
{
	const double pos[3] = {0, 0, 0}, quat[4] = {1, 0, 0, 0};
	struct links links = {.count = 0};
	if (spec->things)
		return STATUS_OK;
	TRY(lock_named(spec));
	if (!spec->urdf || spec->scene->driver == SCENE_IDLE)
		return STATUS_OK;
	enum status status = add_links(spec, &links, mjs_findBody(spec->spec, "world"), 0, pos, quat);
	if (status == STATUS_OK)
		lock_idle(spec, &links);
	mem_free(links.list);
	return status == STATUS_OK ? spec->status : status;
}
