/*
 * Motors on the wheels that a powertrain drives, by which MuJoCo gets their torques.
 *
 * A wheel is named by its hinge, or by an actuator that the model has there. Such actuators are taken away: the powertrain takes their place, and their names.
 */
#include <stdio.h>
#include <string.h>

#include "vehicle/spec.h"

/* Finds the hinge of a name. */
static mjsJoint *joint_of(const struct spec *spec, const char *name)
{
	mjsElement *element = mjs_findElement(spec->spec, mjOBJ_JOINT, name);
	return element != NULL ? mjs_asJoint(element) : NULL;
}

static enum status add_motor(struct spec *spec, mjsJoint *joint, const char *name)
{
	mjsActuator *motor = mjs_addActuator(spec->spec, NULL);
	TRY_MEM(motor, "a vehicle");
	(void)mjs_setName(motor->element, name);
	motor->trntype = mjTRN_JOINT;
	mjs_setString(motor->target, mjs_getString(mjs_getName(joint->element)));
	(void)mjs_setToMotor(motor);
	joint->actfrclimited = mjLIMITED_FALSE; /* a limit of the servo that the URDF knows */
	return STATUS_OK;
}

/* Hinges that get a motor. */
struct driven {
	mjsJoint *joint;
	char name[256]; /* of its motor */
};
#define DRIVEN_MOST 256

static bool add_driven(struct driven *list, size_t *count, mjsJoint *joint, const char *name)
{
	for (size_t i = 0; i < *count; i++)
		if (list[i].joint == joint)
			return true;
	if (*count == DRIVEN_MOST)
		return false;
	list[*count].joint = joint;
	snprintf(list[(*count)++].name, sizeof list->name, "%s", name);
	return true;
}

static int control_count(const mjsActuator *actuator)
{
	return actuator->ctrlspec == 0 ? 1 : __builtin_popcount((unsigned)actuator->ctrlspec);
}

static int state_count(const mjsActuator *actuator)
{
	return actuator->dyntype == mjDYN_NONE ? 0 : actuator->actdim > 1 ? actuator->actdim : 1;
}

static void cut(mjDoubleVec *vector, int from, int count)
{
	int length;
	const double *numbers = mjs_getDouble(vector, &length);
	double *kept;
	if (count == 0 || from + count > length || mem_make(&kept, (size_t)length + 1, sizeof *kept, "a powertrain") != STATUS_OK)
		return;
	memcpy(kept, numbers, (size_t)from * sizeof *kept);
	memcpy(kept + from, numbers + from + count, (size_t)(length - from - count) * sizeof *kept);
	mjs_setDouble(vector, kept, length - count);
	mem_free(kept);
}

/* Takes the numbers of an actuator out of all keyframes, which have them in the order of actuators: those behind it keep theirs. */
static void forget(const struct spec *spec, const mjsElement *gone)
{
	int control = 0, state = 0;
	mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_ACTUATOR);
	for (; each != NULL && each != gone; each = mjs_nextElement(spec->spec, each)) {
		control += control_count(mjs_asActuator(each));
		state += state_count(mjs_asActuator(each));
	}
	if (each == NULL)
		return;
	for (mjsElement *key = mjs_firstElement(spec->spec, mjOBJ_KEY); key != NULL; key = mjs_nextElement(spec->spec, key)) {
		cut(mjs_asKey(key)->ctrl, control, control_count(mjs_asActuator(each)));
		cut(mjs_asKey(key)->act, state, state_count(mjs_asActuator(each)));
	}
}

/* Takes one actuator of a hinge away whose name or whose hinge's name matches. Returns false if there is none. */
static bool take_away(struct spec *spec, const struct scene_texts *patterns, struct driven *list, size_t *count, struct spec_names *told)
{
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_ACTUATOR); each != NULL; each = mjs_nextElement(spec->spec, each)) {
		const mjsActuator *actuator = mjs_asActuator(each);
		const char *target = mjs_getString(actuator->target), *name = mjs_getString(mjs_getName(each));
		mjsJoint *joint = actuator->trntype == mjTRN_JOINT ? joint_of(spec, target) : NULL;
		const bool named = vehicle_matches(patterns, name, false);
		if (joint == NULL || joint->type != mjJNT_HINGE || (!named && !vehicle_matches(patterns, target, false)))
			continue;
		if (!add_driven(list, count, joint, named ? name : target))
			return false;
		vehicle_spec_name(told, name[0] != '\0' ? name : target);
		forget(spec, each);
		(void)mjs_delete(spec->spec, each);
		return true;
	}
	return false;
}

enum status vehicle_spec_powertrain(struct spec *spec)
{
	const struct scene_powertrain *scene = &spec->scene->powertrain;
	const struct scene_texts *patterns = scene->wheels.count > 0 ? &scene->wheels : &spec->scene->drive;
	struct spec_names told = {.count = 0};
	struct driven *list;
	size_t count = 0;
	if (!scene->present)
		return STATUS_OK;
	TRY(mem_zeroed(&list, DRIVEN_MOST, sizeof *list, "a powertrain"));
	while (take_away(spec, patterns, list, &count, &told))
		;
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_JOINT); each != NULL; each = mjs_nextElement(spec->spec, each)) {
		const char *name = mjs_getString(mjs_getName(each));
		if (mjs_asJoint(each)->type == mjJNT_HINGE && vehicle_matches(patterns, name, false))
			(void)add_driven(list, &count, mjs_asJoint(each), name);
	}
	enum status status = STATUS_OK;
	for (size_t i = 0; i < count && status == STATUS_OK; i++)
		status = add_motor(spec, list[i].joint, list[i].name);
	mem_free(list);
	if (told.count > 0)
		vehicle_spec_tell(spec, "its powertrain takes the place of the actuator%s %s", told.count > 1 ? "s" : "", told.text);
	return status;
}
