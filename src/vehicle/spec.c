#define VEHICLE_NAMES_HERE /* a model alone has no prefixes */
#include "vehicle/spec.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <xxhash.h>

#include "vehicle/check.h"

#define TRIES 32      /* a model is made again when a mesh of it must be mended */
#define MASS_OFF 0.01 /* of the mass that the file gives: a model that differs by more is told */

void vehicle_spec_tell(struct spec *spec, const char *format, ...)
{
	char text[600];
	va_list args;
	va_start(args, format);
	vsnprintf(text, sizeof text, format, args);
	va_end(args);
	const uint64_t hash = XXH3_64bits(text, strlen(text));
	for (size_t i = 0; i < spec->told_count; i++)
		if (spec->told[i] == hash)
			return;
	if (mem_grow(&spec->told, &spec->told_room, spec->told_count + 1, sizeof *spec->told, "a vehicle") == STATUS_OK)
		spec->told[spec->told_count++] = hash;
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

/* MuJoCo has free joints at roots alone. So a floating joint further up, as some exporters put it between the ground and the vehicle, holds its link. */
static void hold_floating(struct spec *spec, mjsBody *above, struct spec_names *held)
{
	for (mjsElement *child = mjs_firstChild(above, mjOBJ_BODY, 0); child != NULL; child = mjs_nextChild(above, child, 0)) {
		for (mjsElement *joint = mjs_firstChild(mjs_asBody(child), mjOBJ_JOINT, 0), *next; joint != NULL; joint = next) {
			next = mjs_nextChild(mjs_asBody(child), joint, 0);
			if (mjs_asJoint(joint)->type != mjJNT_FREE)
				continue;
			vehicle_spec_name(held, mjs_getString(mjs_getName(joint)));
			(void)mjs_delete(spec->spec, joint);
		}
		hold_floating(spec, mjs_asBody(child), held);
	}
}

/* A URDF says of no joint that its root has. So it would be a part of the model's world, and its mass would be lost. */
static void free_roots(struct spec *spec)
{
	const enum scene_fixed fixed = spec->scene->fixed;
	mjsBody *world = mjs_findBody(spec->spec, "world");
	struct spec_names freed = {.count = 0}, kept = {.count = 0}, held = {.count = 0};
	if (spec->things) /* what has no joint there is fixed */
		return;
	for (mjsElement *child = mjs_firstChild(world, mjOBJ_BODY, 0); child != NULL; child = mjs_nextChild(world, child, 0)) {
		mjsBody *body = mjs_asBody(child);
		if (has_joint(body) || body->mocap)
			continue;
		const bool frees = fixed == SCENE_FIXED_NO || (fixed == SCENE_FIXED_BY_MODEL && spec->urdf && !spec->welded);
		vehicle_spec_name(frees ? &freed : &kept, mjs_getString(mjs_getName(child)));
		if (spec->urdf)
			hold_floating(spec, body, &held);
		if (frees && mjs_addFreeJoint(body) == NULL)
			spec->status = fail_memory("a vehicle");
	}
	if (held.count > 0)
		vehicle_spec_tell(spec, "%s float%s between links: %s held, since only a root moves freely", held.text, held.count > 1 ? "" : "s", held.count > 1 ? "they are" : "it is");
	if (freed.count > 0 && fixed == SCENE_FIXED_BY_MODEL)
		vehicle_spec_tell(spec, "its root %s has no joint, as in every URDF: it moves freely; start: {fixed: true} holds it", freed.text);
	if (kept.count > 0 && fixed == SCENE_FIXED_BY_MODEL && spec->urdf)
		vehicle_spec_tell(spec, "%s is fixed to its link world: it stays where it is set; start: {fixed: false} frees it", kept.text);
	else if (kept.count > 0 && fixed == SCENE_FIXED_BY_MODEL)
		vehicle_spec_tell(spec, "%s has no joint: it stays where it is set; start: {fixed: false} frees it", kept.text);
}

/* --- its own ground --- */

static void tell_floors(struct spec *spec)
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

double vehicle_spec_mass(const struct spec *spec)
{
	double mass = 0;
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_BODY); each != NULL; each = mjs_nextElement(spec->spec, each))
		if (mjs_asBody(each)->explicitinertial)
			mass += mjs_asBody(each)->mass;
	return mass;
}

/* Tells masses that MuJoCo made from shapes, which a URDF does not give. `given`: kg, by the file's inertials. */
static void tell_mass(struct spec *spec, double given)
{
	const double mass = mj_getTotalmass(spec->model);
	if (spec->urdf && fabs(mass - given) > MASS_OFF * given)
		vehicle_spec_tell(spec, "its links' inertials have %.4g kg together, and the model has %.4g kg: links without an inertial get the mass of their shapes, at 1000 kg/m3", given, mass);
}

/* --- the pose --- */

/* A joint outside its limits is thrown into them, and the vehicle with it. */
static void begin_within_limits(struct spec *spec)
{
	const mjModel *model = spec->model;
	struct spec_names moved = {.count = 0};
	for (int i = 0; i < model->njnt && !spec->things; i++) {
		double *place = &spec->data->qpos[model->jnt_qposadr[i]];
		if (model->jnt_type[i] != mjJNT_HINGE && model->jnt_type[i] != mjJNT_SLIDE)
			continue;
		const double first = vehicle_spec_first(model->jnt_limited[i], model->jnt_range + 2 * i, *place);
		if (first != *place)
			vehicle_spec_name(&moved, mj_id2name(model, mjOBJ_JOINT, i));
		*place = first;
	}
	if (moved.count > 0)
		vehicle_spec_tell(spec, "%zu joint%s (%s) %s outside %s limits at 0: %s at the nearest one; start.joints gives another place", moved.count, moved.count > 1 ? "s" : "", moved.text,
				  moved.count > 1 ? "are" : "is", moved.count > 1 ? "their" : "its", moved.count > 1 ? "they begin" : "it begins");
}

/* The pose of a keyframe. Joints that the driver holds by servos of ours start where these hold them. */
static void set_pose(struct spec *spec)
{
	const mjModel *model = spec->model;
	const struct scene_texts *held = &spec->scene->held.names;
	if (spec->scene->keyframe != NULL)
		spec->keyframe = mj_name2id(model, mjOBJ_KEY, spec->scene->keyframe);
	if (spec->keyframe >= 0)
		mj_resetDataKeyframe(model, spec->data, spec->keyframe);
	else
		begin_within_limits(spec);
	for (size_t i = 0; spec->urdf && i < held->count; i++) {
		const int joint = mj_name2id(model, mjOBJ_JOINT, held->list[i]);
		if (joint < 0 || (model->jnt_type[joint] != mjJNT_HINGE && model->jnt_type[joint] != mjJNT_SLIDE))
			continue;
		spec->data->qpos[model->jnt_qposadr[joint]] = vehicle_spec_first(model->jnt_limited[joint], model->jnt_range + 2 * joint, spec->scene->held.values[i]);
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

static void parse(struct spec *spec)
{
	char *text = NULL;
	if (spec->urdf) {
		spec->status = vehicle_spec_text(spec, &text);
		spec->spec = spec->status == STATUS_OK ? mj_parseXMLString(text, NULL, spec->error, sizeof spec->error) : NULL;
		mem_free(text);
	} else {
		spec->spec = mj_parseXML(spec->path, NULL, spec->error, sizeof spec->error);
	}
}

static void make(void *argument)
{
	struct spec *spec = argument;
	spec->error[0] = '\0';
	parse(spec);
	if (spec->spec == NULL)
		return;
	if (spec->urdf) {
		spec->spec->strippath = 0;
		spec->spec->option.integrator = mjINT_IMPLICITFAST; /* servos are stiff */
	}
	vehicle_spec_parts(spec);
	free_roots(spec);
	tell_floors(spec);
	if (spec->status == STATUS_OK)
		spec->status = vehicle_spec_meshes(spec);
	if (spec->status == STATUS_OK)
		vehicle_spec_inertias(spec);
	if (spec->status == STATUS_OK)
		spec->status = vehicle_spec_powertrain(spec);
	if (spec->status == STATUS_OK)
		spec->status = vehicle_spec_servos(spec);
	if (spec->status == STATUS_OK)
		spec->status = vehicle_spec_locks(spec);
	if (spec->status == STATUS_OK)
		spec->status = vehicle_spec_imu(spec);
	if (spec->status != STATUS_OK)
		return;
	vehicle_spec_shells(spec);
	if (spec->tries == 0)
		mj_clearCache(mj_getCache()); /* it knows files by their second of change alone */
	const double given = vehicle_spec_mass(spec);
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

/* --- numbers that are none --- */

static bool all_finite(const mjtNum *numbers, mjtSize count)
{
	for (mjtSize i = 0; i < count; i++)
		if (!isfinite(numbers[i]))
			return false;
	return true;
}

/* MuJoCo takes NaN in most places. Returns the body that has it; 0: none has. */
static int not_finite(const mjModel *model)
{
	for (int i = 1; i < model->nbody; i++) {
		bool good = all_finite(model->body_pos + 3 * i, 3) && all_finite(model->body_quat + 4 * i, 4) && all_finite(model->body_ipos + 3 * i, 3) &&
			    all_finite(model->body_mass + i, 1) && all_finite(model->body_inertia + 3 * i, 3);
		for (int g = model->body_geomadr[i]; g >= 0 && g < model->body_geomadr[i] + model->body_geomnum[i]; g++)
			good = good && all_finite(model->geom_pos + 3 * g, 3) && all_finite(model->geom_quat + 4 * g, 4) && all_finite(model->geom_size + 3 * g, 3);
		for (int j = model->body_jntadr[i]; j >= 0 && j < model->body_jntadr[i] + model->body_jntnum[i]; j++)
			good = good && all_finite(model->jnt_pos + 3 * j, 3) && all_finite(model->jnt_axis + 3 * j, 3);
		if (!good)
			return i;
	}
	return 0;
}

static bool any_collides(const mjModel *model)
{
	for (int i = 0; i < model->ngeom; i++)
		if (model->body_weldid[model->geom_bodyid[i]] != 0 && (model->geom_contype[i] != 0 || model->geom_conaffinity[i] != 0))
			return true;
	return false;
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
	enum status status;
	bool again = true;
	for (; again; spec.tries++) {
		status = vehicle_guard(where, make, &spec);
		again = status == STATUS_OK && spec.status == STATUS_OK && spec.spec != NULL && spec.model == NULL && spec.tries < TRIES && vehicle_spec_flat(&spec);
		if (again)
			mj_deleteSpec(spec.spec);
	}
	vehicle->is_urdf = spec.urdf;
	vehicle->single = spec.model;
	vehicle->posed = spec.data;
	if (status == STATUS_OK)
		vehicle->spec = spec.spec;
	vehicle_spec_free(&spec);
	if (status != STATUS_OK) /* what MuJoCo refuses is wrong with the file */
		return fail_with(STATUS_INPUT, "%s", failure_message());
	TRY(spec.status);
	join_lines(spec.error);
	if (vehicle->single == NULL)
		return fail_with(STATUS_INPUT, "%s: %s: %.300s; give an MJCF or URDF file that MuJoCo " VEHICLE_MUJOCO_VERSION " reads", where, spec.path,
				 spec.error[0] != '\0' ? spec.error : "MuJoCo does not read it");
	TRY_MEM(vehicle->posed, "a vehicle");
	if (spec.lost.count > 0 && !vehicle->is_world && vehicle->scene->soil.count == 0 && !any_collides(vehicle->single))
		return fail_with(STATUS_INPUT, "%s: %s: %zu of its meshes %s not found or not read (%s), and nothing else of it collides; name the folder of its packages in model_path", where,
				 spec.path, spec.lost.count, spec.lost.count > 1 ? "are" : "is", spec.lost.text);
	const int bad = not_finite(vehicle->single);
	if (bad != 0)
		return fail_with(STATUS_INPUT, "%s: %s: body %.100s has a number that is not finite (nan or inf): its place, mass, inertia, shapes or joints; give numbers", where, spec.path,
				 mj_id2name(vehicle->single, mjOBJ_BODY, bad) != NULL ? mj_id2name(vehicle->single, mjOBJ_BODY, bad) : "without a name");
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
