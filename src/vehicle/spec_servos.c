/*
 * Servos on the joints that a driver names, where the model has no actuator: a URDF has none.
 *
 * A joint that is driven gets a velocity servo, one that steers or is held a position servo. The torque is the joint's own limit, or what lifts
 * the vehicle at the end of its largest shape, shared by the joints that drive.
 */
#include <fnmatch.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "vehicle/spec.h"
#include "vehicle/table.h"

#define REACH_LEAST 0.05 /* m */
#define LIFTS 10.0       /* times what lifts the vehicle: a servo is as stiff as for that torque at most */
#define SLACK 0.1        /* rad/s: how far a driven joint is behind at the torque that the scene gives, */
#define SOFT 0.5         /* and at its share of what lifts the vehicle. A stiffer servo goes from one end of its torque to the other in each step of a light wheel */
#define BEND 0.02        /* rad: how far a held joint gives at full torque */

static bool any_actuator(const struct spec *spec, const char *pattern)
{
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_ACTUATOR); each != NULL; each = mjs_nextElement(spec->spec, each))
		if (fnmatch(pattern, mjs_getString(mjs_getName(each)), 0) == 0)
			return true;
	return false;
}

static bool turns(const mjsJoint *joint)
{
	return joint->type == mjJNT_HINGE || joint->type == mjJNT_SLIDE;
}

static double largest_size(const struct spec *spec)
{
	double size = REACH_LEAST;
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_GEOM); each != NULL; each = mjs_nextElement(spec->spec, each)) {
		const mjsGeom *geom = mjs_asGeom(each);
		for (int i = 0; i < 3 && geom->type != mjGEOM_PLANE && geom->type != mjGEOM_MESH; i++)
			size = isfinite(geom->size[i]) ? fmax(size, geom->size[i]) : size;
	}
	return size;
}

static enum status add_servo(struct spec *spec, const mjsJoint *joint, bool drives, double share, struct spec_names *told, double *torque)
{
	const char *name = mjs_getString(mjs_getName(joint->element));
	mjsActuator *servo = mjs_addActuator(spec->spec, NULL);
	TRY_MEM(servo, "a vehicle");
	const struct scene_servo *given = &spec->scene->servo;
	const double limit = joint->actfrcrange[1], lifts = fmax(vehicle_spec_mass(spec), 1) * spec->gravity * largest_size(spec) * share;
	*torque = given->torque > 0 ? given->torque : limit > 0 ? limit : lifts;
	/* An effort of 1000 N m in the file of a robot of 2 kg is no measure of how stiff it is. */
	const double stiff = given->torque > 0 ? *torque : fmin(*torque, LIFTS * lifts);
	if (spec->spec->option.integrator == mjINT_EULER || spec->spec->option.integrator == mjINT_RK4)
		spec->spec->option.integrator = mjINT_IMPLICITFAST; /* servos of ours are stiff */
	(void)mjs_setName(servo->element, name);
	servo->trntype = mjTRN_JOINT;
	mjs_setString(servo->target, name);
	servo->forcelimited = mjLIMITED_TRUE;
	servo->forcerange[0] = -*torque;
	servo->forcerange[1] = *torque;
	double damped = 1;
	if (drives)
		(void)mjs_setToVelocity(servo, given->kv > 0 ? given->kv : given->torque > 0 ? *torque / SLACK : fmin(*torque, lifts) / SOFT);
	else
		(void)mjs_setToPosition(servo, stiff / BEND, NULL, &damped, NULL, 0);
	vehicle_spec_name(told, name);
	return STATUS_OK;
}

static size_t count_joints(const struct spec *spec, const struct scene_texts *patterns)
{
	size_t count = 0;
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_JOINT); each != NULL; each = mjs_nextElement(spec->spec, each))
		count += turns(mjs_asJoint(each)) && vehicle_matches(patterns, mjs_getString(mjs_getName(each)), false);
	return count;
}

/* Which joints get a servo: all, or those with limits, or those without. */
enum kind { ANY, LIMITED, FREE };

static enum status add_servos(struct spec *spec, const struct scene_texts *patterns, bool drives, enum kind kind)
{
	struct spec_names told = {.count = 0};
	double torque = 0;
	for (size_t i = 0; i < patterns->count; i++) {
		const struct scene_texts one = {&patterns->list[i], 1};
		if (any_actuator(spec, patterns->list[i]))
			continue;
		const double share = 1.0 / fmax((double)count_joints(spec, &one), 1);
		for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_JOINT); each != NULL; each = mjs_nextElement(spec->spec, each)) {
			const mjsJoint *joint = mjs_asJoint(each);
			if (turns(joint) && (kind == ANY || (kind == LIMITED) == vehicle_spec_limited(joint)) && vehicle_matches(&one, mjs_getString(mjs_getName(each)), false))
				TRY(add_servo(spec, joint, drives, share, &told, &torque));
		}
	}
	if (told.count > 0)
		vehicle_spec_tell(spec, "%s ha%s no actuator: %s gets a %s servo, the last with at most %.3g N m; servo: {torque: N} sets it", told.text, told.count > 1 ? "ve" : "s",
				  told.count > 1 ? "each" : "it", drives ? "velocity" : "position", torque);
	return STATUS_OK;
}

/* Servos for the columns of a table of controls: of a place for joints with limits, of a rate for those without. What is wrong with the table is told when it
 * is read: controls.c. */
static enum status add_columns(struct spec *spec)
{
	char *line = mem_calloc(TABLE_LINE, 1), **list = mem_calloc(TABLE_LINE, sizeof *list);
	struct scene_texts columns = {list, 0};
	enum status status = line != NULL && list != NULL ? STATUS_OK : fail_memory("a vehicle");
	FILE *file = status == STATUS_OK ? input_open(spec->scene->controls) : NULL;
	if (file != NULL && fgets(line, TABLE_LINE, file) != NULL) {
		line[strcspn(line, "\r\n")] = '\0';
		char *rest = line, *name = strsep(&rest, ",");
		while ((name = strsep(&rest, ",")) != NULL)
			if (*name != '\0')
				list[columns.count++] = name;
		status = add_servos(spec, &columns, false, LIMITED);
		if (status == STATUS_OK)
			status = add_servos(spec, &columns, true, FREE);
	}
	if (file != NULL)
		fclose(file);
	mem_free_all(line, list);
	return status;
}

enum status vehicle_spec_servos(struct spec *spec)
{
	const struct scene_vehicle *scene = spec->scene;
	TRY(add_servos(spec, &scene->drive, true, ANY));
	TRY(add_servos(spec, &scene->steer, false, ANY));
	TRY(add_servos(spec, &scene->held.names, false, ANY));
	if (scene->controls != NULL)
		TRY(add_columns(spec));
	return STATUS_OK;
}
