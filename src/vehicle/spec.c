#define VEHICLE_NAMES_HERE /* a model alone has no prefixes */
#include "vehicle/spec.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "vehicle/check.h"

#define MASS_OFF 0.01 /* of the mass that the file gives: a model that differs by more is told */

void vehicle_spec_tell(const struct spec *spec, const char *format, ...)
{
	char text[600];
	va_list args;
	va_start(args, format);
	vsnprintf(text, sizeof text, format, args);
	va_end(args);
	note("%s%s: %s", spec->things ? "" : "vehicles.", spec->scene->name, text);
}

void vehicle_spec_name(struct spec_names *names, const char *name)
{
	const size_t length = strlen(names->text);
	if (names->count++ < 3)
		snprintf(names->text + length, sizeof names->text - length, "%s%.48s", length > 0 ? ", " : "", name);
	else if (names->count == 4)
		snprintf(names->text + length, sizeof names->text - length, ", ...");
}

/* --- the root --- */

static bool has_joint(const mjsBody *body)
{
	return mjs_firstChild(body, mjOBJ_JOINT, 0) != NULL;
}

/* A URDF says of no joint that its root has. So it would be a part of the model's world, and its mass would be lost. */
static void free_roots(struct spec *spec)
{
	const enum scene_fixed fixed = spec->scene->fixed;
	mjsBody *world = mjs_findBody(spec->spec, "world");
	struct spec_names freed = {.count = 0}, kept = {.count = 0};
	if (spec->things) /* what has no joint there is fixed */
		return;
	for (mjsElement *child = mjs_firstChild(world, mjOBJ_BODY, 0); child != NULL; child = mjs_nextChild(world, child, 0)) {
		mjsBody *body = mjs_asBody(child);
		if (has_joint(body) || body->mocap)
			continue;
		const bool frees = fixed == SCENE_FIXED_NO || (fixed == SCENE_FIXED_BY_MODEL && spec->urdf && !spec->welded);
		vehicle_spec_name(frees ? &freed : &kept, mjs_getString(mjs_getName(child)));
		if (frees && mjs_addFreeJoint(body) == NULL)
			spec->status = fail_memory("a vehicle");
	}
	if (freed.count > 0 && fixed == SCENE_FIXED_BY_MODEL)
		vehicle_spec_tell(spec, "its root %s has no joint, as in every URDF: it moves freely; start: {fixed: true} holds it", freed.text);
	if (kept.count > 0 && fixed == SCENE_FIXED_BY_MODEL && spec->urdf)
		vehicle_spec_tell(spec, "%s is fixed to its link world: it stays where it is set; start: {fixed: false} frees it", kept.text);
}

/* --- its own ground --- */

static void tell_floors(const struct spec *spec)
{
	const mjsBody *world = mjs_findBody(spec->spec, "world");
	struct spec_names floors = {.count = 0};
	for (mjsElement *child = mjs_firstChild(world, mjOBJ_GEOM, 0); child != NULL; child = mjs_nextChild(world, child, 0)) {
		const mjsGeom *geom = mjs_asGeom(child);
		const char *name = mjs_getString(mjs_getName(child));
		if ((geom->type == mjGEOM_PLANE || (geom->type == mjGEOM_HFIELD && !spec->things)) && (geom->contype != 0 || geom->conaffinity != 0))
			vehicle_spec_name(&floors, name[0] != '\0' ? name : "a plane");
	}
	if (floors.count > 0 && spec->things)
		vehicle_spec_tell(spec, "its floor (%s) is taken away: the terrain is the ground; a slab is a box", floors.text);
	else if (floors.count > 0)
		vehicle_spec_tell(spec, "its own floor (%s) is taken away: it stands on the terrain", floors.text);
}

/* --- mass --- */

static double mass_of_file(const struct spec *spec)
{
	double mass = 0;
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_BODY); each != NULL; each = mjs_nextElement(spec->spec, each))
		if (mjs_asBody(each)->explicitinertial)
			mass += mjs_asBody(each)->mass;
	return mass;
}

/* Tells masses that MuJoCo made from shapes, which a URDF does not give. `given`: kg, by the file's inertials. */
static void tell_mass(const struct spec *spec, double given)
{
	const double mass = mj_getTotalmass(spec->model);
	if (spec->urdf && fabs(mass - given) > MASS_OFF * given)
		vehicle_spec_tell(spec, "its links' inertials have %.4g kg together, and the model has %.4g kg: links without an inertial get the mass of their shapes, at 1000 kg/m3", given, mass);
}

/* --- the pose --- */

/* The pose of a keyframe. Joints that the driver holds by servos of ours start where these hold them. */
static void set_pose(struct spec *spec)
{
	const mjModel *model = spec->model;
	const struct scene_texts *held = &spec->scene->held;
	if (spec->scene->keyframe != NULL)
		spec->keyframe = mj_name2id(model, mjOBJ_KEY, spec->scene->keyframe);
	if (spec->keyframe >= 0)
		mj_resetDataKeyframe(model, spec->data, spec->keyframe);
	for (size_t i = 0; spec->urdf && i < held->count; i++) {
		const int joint = mj_name2id(model, mjOBJ_JOINT, held->list[i]);
		if (joint < 0 || (model->jnt_type[joint] != mjJNT_HINGE && model->jnt_type[joint] != mjJNT_SLIDE))
			continue;
		const double *range = model->jnt_range + 2 * joint, value = spec->scene->values[i];
		spec->data->qpos[model->jnt_qposadr[joint]] = model->jnt_limited[joint] ? fmin(fmax(value, range[0]), range[1]) : value;
	}
}

/* --- all --- */

/* Compiles the spec into spec->model; NULL: MuJoCo refuses it. */
static void compile(struct spec *spec)
{
	spec->model = mj_compile(spec->spec, NULL);
	if (spec->model != NULL)
		return;
	const char *why = mjs_getError(spec->spec);
	snprintf(spec->error, sizeof spec->error, "%s", why != NULL ? why : "");
}

/* A body by itself without products of inertia is "simple" for MuJoCo, which then keeps no room for products of its freedoms. But the soil
 * couples them (coupling.c). So each such body gets an empty one below it. */
static void couple_freedoms(struct spec *spec)
{
	const mjModel *model = spec->model;
	mjsBody **list;
	size_t count = 0;
	spec->status = mem_make(&list, (size_t)model->nbody, sizeof *list, "a vehicle");
	if (spec->status != STATUS_OK)
		return;
	/* Adding one changes the numbers of others. */
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_BODY); each != NULL; each = mjs_nextElement(spec->spec, each)) {
		const int body = mjs_getId(each);
		if (body > 0 && body < model->nbody && model->body_simple[body] && model->body_dofnum[body] > 0)
			list[count++] = mjs_asBody(each);
	}
	for (size_t i = 0; i < count && spec->status == STATUS_OK; i++)
		spec->status = mjs_addBody(list[i], NULL) != NULL ? STATUS_OK : fail_memory("a vehicle");
	mem_free(list);
	if (count == 0 || spec->status != STATUS_OK)
		return;
	spec->spec->compiler.fusestatic = 0; /* it is done, and would take the empty ones away */
	mj_deleteModel(spec->model);
	compile(spec);
}

static void make(void *argument)
{
	struct spec *spec = argument;
	spec->spec = mj_parseXML(spec->path, NULL, spec->error, sizeof spec->error);
	if (spec->spec == NULL)
		return;
	if (spec->urdf) {
		spec->spec->strippath = 0;
		spec->spec->option.integrator = mjINT_IMPLICITFAST; /* servos are stiff */
	}
	free_roots(spec);
	tell_floors(spec);
	vehicle_spec_inertias(spec);
	if (spec->status == STATUS_OK)
		spec->status = vehicle_spec_meshes(spec);
	if (spec->status == STATUS_OK)
		spec->status = vehicle_spec_servos(spec);
	if (spec->status != STATUS_OK)
		return;
	mj_clearCache(mj_getCache()); /* it knows files by their second of change alone */
	const double given = mass_of_file(spec);
	compile(spec);
	if (spec->model != NULL)
		couple_freedoms(spec);
	if (spec->model == NULL || spec->status != STATUS_OK)
		return;
	tell_mass(spec, given);
	spec->data = mj_makeData(spec->model);
	if (spec->data == NULL)
		return;
	set_pose(spec);
	mj_forward(spec->model, spec->data);
}

/* One line of MuJoCo's message. */
static void join_lines(char *text)
{
	size_t length = strlen(text);
	while (length > 0 && (text[length - 1] == '\n' || text[length - 1] == ' '))
		text[--length] = '\0';
	for (; *text != '\0'; text++)
		if (*text == '\n')
			*text = ' ';
}

enum status vehicle_compile(struct vehicle *vehicle, const struct scene *scene, const char *where)
{
	struct spec spec = {.where = where, .path = vehicle->scene->model, .scene = vehicle->scene, .gravity = scene->gravity, .keyframe = -1, .things = vehicle->is_world};
	TRY(vehicle_check_model(where, spec.path, &spec.urdf, &spec.welded));
	enum status status = vehicle_guard(where, make, &spec);
	vehicle->single = spec.model;
	vehicle->posed = spec.data;
	if (status == STATUS_OK)
		vehicle->spec = spec.spec;
	if (status != STATUS_OK) /* what MuJoCo refuses is wrong with the file */
		return fail_with(STATUS_INPUT, "%s", failure_message());
	TRY(spec.status);
	join_lines(spec.error);
	if (vehicle->single == NULL)
		return fail_with(STATUS_INPUT, "%s: %s: %.300s; give an MJCF or URDF file that MuJoCo " VEHICLE_MUJOCO_VERSION " reads", where, spec.path,
				 spec.error[0] != '\0' ? spec.error : "MuJoCo does not read it");
	TRY_MEM(vehicle->posed, "a vehicle");
	vehicle->keyframe = spec.keyframe;
	if (vehicle->scene->keyframe != NULL && spec.keyframe < 0) {
		char names[VEHICLE_NAMES];
		vehicle_list_own_names(vehicle->single, mjOBJ_KEY, names);
		return fail_with(STATUS_INPUT, "%s: start.keyframe: %.64s is no keyframe of the model; there are: %s", where, vehicle->scene->keyframe, names);
	}
	const char *warning = vehicle_guard_warning();
	if (warning[0] != '\0')
		note("%s: %s: MuJoCo " VEHICLE_MUJOCO_VERSION " says: %s", where, spec.path, warning);
	return STATUS_OK;
}
