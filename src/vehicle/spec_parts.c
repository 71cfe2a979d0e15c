/* Parts of a model that MuJoCo refuses: shapes without a size, skins. Parts that a scene could not name. Joints that follow others. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "vehicle/spec.h"

#define NOTHING 1e-9       /* kg: an inertial with less has no mass */
#define MASS_LEAST 1e-4    /* kg: of all links, where MuJoCo refuses some as too light */
#define INERTIA_LEAST 1e-8 /* kg m2 */

/* --- shapes --- */

static bool has_size(const mjsGeom *geom)
{
	const int needed = geom->type == mjGEOM_SPHERE ? 1 : geom->type == mjGEOM_CAPSULE || geom->type == mjGEOM_CYLINDER ? 2 : 3;
	bool has = true;
	for (int i = 0; i < needed; i++)
		has = has && geom->size[i] > 0;
	return has || geom->type == mjGEOM_PLANE || geom->type == mjGEOM_HFIELD || geom->type == mjGEOM_MESH || geom->type == mjGEOM_SDF;
}

static void leave_out_empty(struct spec *spec)
{
	struct spec_names empty = {.count = 0};
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_GEOM), *next; each != NULL; each = next) {
		next = mjs_nextElement(spec->spec, each);
		if (has_size(mjs_asGeom(each)))
			continue;
		vehicle_spec_name(&empty, mjs_getString(mjs_getName(mjs_getParent(each)->element)));
		(void)mjs_delete(spec->spec, each);
	}
	if (empty.count > 0)
		vehicle_spec_tell(spec, "%zu shape%s of size 0 (%s) %s left out", empty.count, empty.count > 1 ? "s" : "", empty.text, empty.count > 1 ? "are" : "is");
}

static void leave_out_skins(struct spec *spec)
{
	size_t count = 0;
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_SKIN), *next; each != NULL; each = next) {
		next = mjs_nextElement(spec->spec, each);
		count += mjs_delete(spec->spec, each) == 0;
	}
	if (count > 0)
		vehicle_spec_tell(spec, "%zu skin%s left out: skins are not drawn", count, count > 1 ? "s are" : " is");
}

/* Takes away the name of a material that the model does not have. A part may have its assets in a file of its own. */
static void leave_out_material(const struct spec *spec, mjString *material, struct spec_names *lost)
{
	const char *name = mjs_getString(material);
	if (name == NULL || name[0] == '\0' || mjs_findElement(spec->spec, mjOBJ_MATERIAL, name) != NULL)
		return;
	if (strstr(lost->text, name) == NULL)
		vehicle_spec_name(lost, name);
	mjs_setString(material, "");
}

static void leave_out_materials(struct spec *spec)
{
	struct spec_names lost = {.count = 0};
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_GEOM); each != NULL; each = mjs_nextElement(spec->spec, each))
		leave_out_material(spec, mjs_asGeom(each)->material, &lost);
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_SITE); each != NULL; each = mjs_nextElement(spec->spec, each))
		leave_out_material(spec, mjs_asSite(each)->material, &lost);
	if (lost.count > 0)
		vehicle_spec_tell(spec, "it has no material %s: the shapes' own colours are taken", lost.text);
}

/* --- masses --- */

/* Returns true if the body, or one that is fixed to it, has an inertial with a mass. */
static bool has_mass(const mjsBody *body)
{
	bool has = body->explicitinertial && body->mass >= NOTHING;
	for (mjsElement *child = mjs_firstChild(body, mjOBJ_BODY, 0); child != NULL; child = mjs_nextChild(body, child, 0))
		has = has || (mjs_firstChild(mjs_asBody(child), mjOBJ_JOINT, 0) == NULL && has_mass(mjs_asBody(child)));
	return has;
}

/* A link without an inertial that is fixed to others with one has no mass, as in ROS. MuJoCo would give its shapes that of water. */
static void take_masses_away(struct spec *spec)
{
	struct spec_names names = {.count = 0};
	bool any = false;
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_BODY); each != NULL; each = mjs_nextElement(spec->spec, each))
		any = any || (mjs_asBody(each)->explicitinertial && mjs_asBody(each)->mass > 0);
	const mjsBody *world = mjs_findBody(spec->spec, "world");
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_BODY); each != NULL; each = mjs_nextElement(spec->spec, each)) {
		mjsBody *body = mjs_asBody(each);
		mjsElement *geom = mjs_firstChild(body, mjOBJ_GEOM, 0);
		if (body->explicitinertial && body->mass >= 0 && body->mass < NOTHING) { /* 0 kg, as some write for none */
			body->explicitinertial = 0;
			body->fullinertia[0] = (double)NAN;
		}
		const bool moves = mjs_firstChild(body, mjOBJ_JOINT, 0) != NULL || mjs_getParent(each) == world;
		if (!any || body->explicitinertial || geom == NULL || body == world || (moves && !has_mass(body)))
			continue;
		for (; geom != NULL; geom = mjs_nextChild(body, geom, 0))
			mjs_asGeom(geom)->mass = 0;
		vehicle_spec_name(&names, mjs_getString(mjs_getName(each)));
	}
	if (names.count > 0)
		vehicle_spec_tell(spec, "%zu link%s without an inertial (%s) ha%s no mass, as in ROS", names.count, names.count > 1 ? "s" : "", names.text, names.count > 1 ? "ve" : "s");
}

/* --- names --- */

static bool is_named(const mjsElement *element)
{
	const char *name = mjs_getString(mjs_getName((mjsElement *)element));
	return name != NULL && name[0] != '\0';
}

/* Calls it as `wanted`, or the same with a number where another one has that name. */
static const char *call(mjsElement *element, const char *wanted)
{
	char name[200];
	bool done = mjs_setName(element, wanted) == 0;
	for (int i = 2; !done && i < 10000; i++) {
		snprintf(name, sizeof name, "%.180s_%d", wanted, i);
		done = mjs_setName(element, name) == 0;
	}
	return mjs_getString(mjs_getName(element));
}

static void name_joints(struct spec *spec)
{
	struct spec_names names = {.count = 0};
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_JOINT); each != NULL; each = mjs_nextElement(spec->spec, each)) {
		const mjsJoint *joint = mjs_asJoint(each);
		if (is_named(each) || (joint->type != mjJNT_HINGE && joint->type != mjJNT_SLIDE))
			continue;
		const mjsElement *body = mjs_getParent(each)->element;
		vehicle_spec_name(&names, call(each, is_named(body) ? mjs_getString(mjs_getName((mjsElement *)body)) : "joint"));
	}
	if (names.count > 0)
		vehicle_spec_tell(spec, "%zu joint%s without a name %s called after %s bod%s: %s", names.count, names.count > 1 ? "s" : "", names.count > 1 ? "are" : "is",
				  names.count > 1 ? "their" : "its", names.count > 1 ? "ies" : "y", names.text);
}

static void name_actuators(struct spec *spec)
{
	struct spec_names names = {.count = 0};
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_ACTUATOR); each != NULL; each = mjs_nextElement(spec->spec, each)) {
		const char *target = mjs_getString(mjs_asActuator(each)->target);
		if (is_named(each))
			continue;
		vehicle_spec_name(&names, call(each, target != NULL && target[0] != '\0' ? target : "actuator"));
	}
	if (names.count > 0)
		vehicle_spec_tell(spec, "%zu actuator%s without a name %s called after what %s: %s", names.count, names.count > 1 ? "s" : "", names.count > 1 ? "are" : "is",
				  names.count > 1 ? "they move" : "it moves", names.text);
}

/* --- joints that follow others --- */

static bool has_joint(const struct spec *spec, const char *name)
{
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_JOINT); each != NULL; each = mjs_nextElement(spec->spec, each))
		if (strcmp(mjs_getString(mjs_getName(each)), name) == 0)
			return mjs_asJoint(each)->type == mjJNT_HINGE || mjs_asJoint(each)->type == mjJNT_SLIDE;
	return false;
}

/* MuJoCo may have made it. */
static mjsEquality *equality_of(const struct spec *spec, const struct spec_mimic *mimic)
{
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_EQUALITY); each != NULL; each = mjs_nextElement(spec->spec, each)) {
		mjsEquality *equality = mjs_asEquality(each);
		if (equality->type == mjEQ_JOINT && strcmp(mjs_getString(equality->name1), mimic->joint) == 0)
			return equality;
	}
	return mjs_addEquality(spec->spec, NULL);
}

static void add_mimics(struct spec *spec)
{
	struct spec_names names = {.count = 0};
	for (size_t i = 0; i < spec->mimic_count && spec->status == STATUS_OK; i++) {
		const struct spec_mimic *mimic = &spec->mimics[i];
		if (!has_joint(spec, mimic->joint) || !has_joint(spec, mimic->of) || strcmp(mimic->joint, mimic->of) == 0 || !isfinite(mimic->times) || !isfinite(mimic->plus))
			continue;
		mjsEquality *equality = equality_of(spec, mimic);
		if (equality == NULL) {
			spec->status = fail_memory("a vehicle");
			return;
		}
		equality->type = mjEQ_JOINT;
		equality->objtype = mjOBJ_JOINT;
		mjs_setString(equality->name1, mimic->joint);
		mjs_setString(equality->name2, mimic->of);
		equality->data[0] = mimic->plus;
		equality->data[1] = mimic->times;
		vehicle_spec_name(&names, mimic->joint);
	}
	if (names.count > 0)
		vehicle_spec_tell(spec, "%zu joint%s (%s) follow%s another one, as mimic says", names.count, names.count > 1 ? "s" : "", names.text, names.count > 1 ? "" : "s");
}

void vehicle_spec_parts(struct spec *spec)
{
	leave_out_skins(spec);
	leave_out_materials(spec);
	if (spec->urdf) {
		leave_out_empty(spec);
		take_masses_away(spec);
		add_mimics(spec);
	}
	name_joints(spec);
	name_actuators(spec);
}

/* --- meshes without a volume, links without a weight: MuJoCo tells while it compiles --- */

/* MuJoCo finds a mass for each mesh, even for one that needs none. */
bool vehicle_spec_flat(struct spec *spec)
{
	if (spec->urdf && !spec->bounded && strstr(spec->error, "larger than mjMINVAL") != NULL)
		return spec->bounded = true;
	static const char *const texts[] = {"mesh volume is too small: ", "mesh volume is negative (misoriented triangles): "};
	for (size_t i = 0; i < 2; i++) {
		const char *at = strstr(spec->error, texts[i]);
		if (at == NULL)
			continue;
		at += strlen(texts[i]);
		char name[sizeof spec->flat];
		snprintf(name, sizeof name, "%.*s", (int)strcspn(at, " \n"), at);
		if (strcmp(name, spec->flat) == 0) /* that did not help */
			return false;
		memcpy(spec->flat, name, sizeof name);
		return true;
	}
	return false;
}

bool vehicle_spec_weighs(mjsElement *element, const char *mesh)
{
	const mjsGeom *geom = mjs_asGeom(element);
	const char *of = mjs_getString(geom->meshname);
	return of != NULL && strcmp(of, mesh) == 0 && !mjs_getParent(element)->explicitinertial && (isnan(geom->mass) ? geom->density > 0 : geom->mass > 0);
}

static bool mass_counts(const struct spec *spec, const char *mesh)
{
	bool counts = false;
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_GEOM); each != NULL; each = mjs_nextElement(spec->spec, each))
		counts = counts || vehicle_spec_weighs(each, mesh);
	return counts;
}

static void take_shell(const struct spec *spec, mjsGeom *geom)
{
	const char *name = mjs_getString(geom->meshname);
	geom->typeinertia = mjINERTIA_VOLUME;
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_MESH); name != NULL && each != NULL; each = mjs_nextElement(spec->spec, each))
		if (strcmp(mjs_getString(mjs_getName(each)), name) == 0)
			mjs_asMesh(each)->inertia = mjMESH_INERTIA_SHELL;
}

/* Once MuJoCo has refused a mesh, all meshes whose mass nobody needs are taken as shells. */
void vehicle_spec_shells(struct spec *spec)
{
	if (spec->bounded) {
		spec->spec->compiler.boundmass = MASS_LEAST;
		spec->spec->compiler.boundinertia = INERTIA_LEAST;
		vehicle_spec_tell(spec, "links whose mass or inertia is too small to move get at least %g kg and %g kg m2", MASS_LEAST, INERTIA_LEAST);
	}
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_GEOM); each != NULL; each = mjs_nextElement(spec->spec, each))
		if (mjs_asGeom(each)->type == mjGEOM_MESH && mjs_asGeom(each)->typeinertia == mjINERTIA_SHELL)
			take_shell(spec, mjs_asGeom(each)); /* as older versions have it */
	if (spec->flat[0] == '\0')
		return;
	for (mjsElement *each = mjs_firstElement(spec->spec, mjOBJ_MESH); each != NULL; each = mjs_nextElement(spec->spec, each)) {
		const char *name = mjs_getString(mjs_getName(each));
		if (!mass_counts(spec, name))
			mjs_asMesh(each)->inertia = mjMESH_INERTIA_SHELL;
	}
}
