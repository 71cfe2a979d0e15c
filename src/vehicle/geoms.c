/* The soil geoms of a model: which they are, their shapes, and where they are. */
#include <fnmatch.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "vehicle/internal.h"

#define BELT "belt:"  /* how names in custom begin that are of a belt */
#define GROUSERS_MAX 128
#define LEVEL 0.5     /* sine of the steepest hinge about which a geom that carries soil is taken to roll */

bool vehicle_matches(const struct scene_texts *patterns, const char *name, bool none)
{
	for (size_t i = 0; i < patterns->count; i++)
		if (fnmatch(patterns->list[i], name, 0) == 0)
			return true;
	return patterns->count == 0 && none;
}

bool vehicle_is_fixed(const mjModel *model, int geom)
{
	return model->body_weldid[model->geom_bodyid[geom]] == 0;
}

struct soil_geom *vehicle_soil_geom_of(const struct vehicle *vehicle, int geom)
{
	for (size_t g = 0; g < vehicle->geom_count; g++)
		if (vehicle->geoms[g].geom == geom)
			return &vehicle->geoms[g];
	return NULL;
}

static bool is_soil_geom(const struct vehicle *vehicle, int geom)
{
	const mjModel *model = vehicle->model;
	char name[300];
	const bool collides = model->geom_contype[geom] != 0 || model->geom_conaffinity[geom] != 0;
	if (vehicle_is_fixed(model, geom))
		return false;
	vehicle_geom_name(vehicle, geom, name, sizeof name);
	return vehicle_matches(&vehicle->scene->soil, name, collides) && !vehicle_matches(&vehicle->scene->no_soil, name, false);
}

static bool can_touch(const mjModel *model, int geom)
{
	const int type = model->geom_type[geom];
	return type != mjGEOM_PLANE && type != mjGEOM_HFIELD && type != mjGEOM_SDF;
}

/* Tells once of geoms that collide and have a shape that cannot touch the ground. */
static void tell_left_out(const struct vehicle *vehicle, const char *where)
{
	char first[256] = "", others[48] = "";
	size_t count = 0;
	for (int i = vehicle->own.geom.first; i < vehicle->own.geom.end; i++)
		if (vehicle->scene->soil.count == 0 && !can_touch(vehicle->model, i) && is_soil_geom(vehicle, i) && count++ == 0)
			vehicle_geom_name(vehicle, i, first, sizeof first);
	if (count > 1)
		snprintf(others, sizeof others, ", and %zu other%s", count - 1, count > 2 ? "s" : "");
	if (count > 0)
		note("%s: %s%s: a plane, a height field or an SDF cannot press the ground: it is left out; use boxes, spheres, capsules, ellipsoids, cylinders or "
		     "meshes, or name it in no_soil", where, first, others);
}

/* Each pattern of no_soil must name a geom. */
static enum status check_no_soil(const struct vehicle *vehicle, const char *where)
{
	for (size_t i = 0; i < vehicle->scene->no_soil.count; i++) {
		struct scene_texts one = {.list = &vehicle->scene->no_soil.list[i], .count = 1};
		bool any = false;
		for (int geom = vehicle->own.geom.first; geom < vehicle->own.geom.end && !any; geom++) {
			char name[256];
			vehicle_geom_name(vehicle, geom, name, sizeof name);
			any = vehicle_matches(&one, name, false);
		}
		if (!any) {
			char names[VEHICLE_NAMES];
			vehicle_list_names(vehicle->model, mjOBJ_GEOM, vehicle->own.geom.first, vehicle->own.geom.end, names);
			return fail_with(STATUS_INPUT, "%s: no_soil: %.64s names no geom; the model has: %s", where, one.list[0], names);
		}
	}
	return STATUS_OK;
}

/* --- shapes --- */

/* The first numbers of a geom's `user`: how many grousers it has, their height and their thickness, m; 0: the default of a scene. */
static enum status set_grousers(const mjModel *model, struct soil_geom *out, const char *where)
{
	const int count = model->nuser_geom;
	const double *user = &model->geom_user[(size_t)count * (size_t)out->geom];
	if (count == 0 || user[0] == 0)
		return STATUS_OK;
	if (!(user[0] >= 1 && user[0] <= GROUSERS_MAX))
		return fail_with(STATUS_INPUT, "%s: %s: user says %g grousers; give 0 to %d", where, out->name, user[0], GROUSERS_MAX);
	out->shape.grousers = (int)user[0];
	out->shape.grouser_height = count > 1 && user[1] != 0 ? user[1] : 0.05 * out->shape.radius;
	out->shape.grouser_thickness = count > 2 && user[2] != 0 ? user[2] : 0.1 * out->shape.radius;
	return STATUS_OK;
}

/* A wheel's own y axis is the cylinder's z axis, and points to the vehicle's left. */
static enum status make_wheel(const struct vehicle *vehicle, struct soil_geom *out, const char *where)
{
	const mjModel *model = vehicle->model;
	const double *size = &model->geom_size[3 * out->geom], *mat = &vehicle->data->geom_xmat[9 * out->geom];
	const double side = mat[5] >= 0 ? 1 : -1;
	out->shape = (struct soil_shape){.kind = SOIL_WHEEL, .radius = size[0], .width = 2 * size[1]};
	vehicle_set_axes(out, (const double[]){1, 0, 0}, (const double[]){0, 0, side}, (const double[]){0, -side, 0});
	return set_grousers(model, out, where);
}

/* Finds the hinge and the radius that `custom` of the model gives for a belt: a text and a numeric, both named belt:GEOM. */
static enum status make_belt(const struct vehicle *vehicle, struct soil_geom *out, const char *where)
{
	const mjModel *model = vehicle->model;
	char geom[256], name[300];
	vehicle_geom_name(vehicle, out->geom, geom, sizeof geom);
	snprintf(name, sizeof name, BELT "%s", geom);
	const int text = vehicle_find_part(vehicle, mjOBJ_TEXT, name), numeric = vehicle_find_part(vehicle, mjOBJ_NUMERIC, name);
	if (text < 0 && numeric < 0)
		return STATUS_OK;
	const char *hinge = text >= 0 ? model->text_data + model->text_adr[text] : "";
	const int joint = vehicle_find_part(vehicle, mjOBJ_JOINT, hinge);
	if (joint < 0 || model->jnt_type[joint] != mjJNT_HINGE)
		return fail_with(STATUS_INPUT, "%s: %s: \"%s\" is no hinge of the model; give a text in custom that names the hinge of its sprocket", where, name,
				 hinge);
	const double radius = numeric >= 0 ? model->numeric_data[model->numeric_adr[numeric]] : 0;
	if (!(radius > 0 && radius <= 1000))
		return fail_with(STATUS_INPUT, "%s: %s: the radius of its sprocket is %g m; give a numeric in custom, above 0", where, name, radius);
	const double *mat = &vehicle->data->geom_xmat[9 * out->geom], *axis = &vehicle->data->xaxis[3 * joint];
	out->dof = model->jnt_dofadr[joint];
	out->sprocket = mat[1] * axis[0] + mat[4] * axis[1] + mat[7] * axis[2] >= 0 ? radius : -radius;
	out->shape.belt = true;
	return STATUS_OK;
}

static enum status check_belt(const struct vehicle *vehicle, const char *name, const char *where)
{
	if (name == NULL || strncmp(name, BELT, strlen(BELT)) != 0)
		return STATUS_OK;
	for (size_t g = 0; g < vehicle->geom_count; g++) {
		char geom[256];
		vehicle_geom_name(vehicle, vehicle->geoms[g].geom, geom, sizeof geom);
		if (vehicle->geoms[g].shape.belt && strcmp(name + strlen(BELT), geom) == 0)
			return STATUS_OK;
	}
	return fail_with(STATUS_INPUT, "%s: %s: no soil geom of this name is a box; give belts to boxes that touch the ground", where, name);
}

/* Each belt must be of a soil geom that is a box. */
static enum status check_belts(const struct vehicle *vehicle, const char *where)
{
	for (int i = vehicle->own.text.first; i < vehicle->own.text.end; i++)
		TRY(check_belt(vehicle, vehicle_part_name(vehicle->model, mjOBJ_TEXT, i), where));
	for (int i = vehicle->own.numeric.first; i < vehicle->own.numeric.end; i++)
		TRY(check_belt(vehicle, vehicle_part_name(vehicle->model, mjOBJ_NUMERIC, i), where));
	return STATUS_OK;
}

static enum status make_mesh(const struct vehicle *vehicle, struct soil_geom *out)
{
	enum status status = vehicle_make_mesh(vehicle->model, out->geom, &out->mesh);
	out->shape = (struct soil_shape){.kind = SOIL_MESH, .mesh = out->mesh};
	return status;
}

bool vehicle_plain_shape(const mjModel *model, int geom, struct soil_shape *out)
{
	const double *size = &model->geom_size[3 * geom];
	switch (model->geom_type[geom]) {
	case mjGEOM_SPHERE:
		*out = (struct soil_shape){.kind = SOIL_SPHERE, .radius = size[0]};
		return true;
	case mjGEOM_BOX:
		*out = (struct soil_shape){.kind = SOIL_BOX, .size = {2 * size[0], 2 * size[1], 2 * size[2]}};
		return true;
	case mjGEOM_ELLIPSOID:
		*out = (struct soil_shape){.kind = SOIL_ELLIPSOID, .size = {size[0], size[1], size[2]}};
		return true;
	case mjGEOM_CYLINDER:
	case mjGEOM_CAPSULE:
		*out = (struct soil_shape){.kind = model->geom_type[geom] == mjGEOM_CYLINDER ? SOIL_CYLINDER : SOIL_CAPSULE, .radius = size[0], .length = 2 * size[1]};
		return true;
	default:
		return false;
	}
}

static enum status make_shape(const struct vehicle *vehicle, struct soil_geom *out, const char *where)
{
	const int type = vehicle->model->geom_type[out->geom];
	vehicle_set_axes(out, (const double[]){1, 0, 0}, (const double[]){0, 1, 0}, (const double[]){0, 0, 1});
	out->roll_dof = -1;
	out->dof = type == mjGEOM_CYLINDER ? vehicle_cylinder_turns(vehicle, out->geom) : -1;
	if (out->dof >= 0)
		return make_wheel(vehicle, out, where);
	if (type == mjGEOM_MESH)
		return vehicle_make_mesh_wheel(vehicle, out) ? set_grousers(vehicle->model, out, where) : make_mesh(vehicle, out);
	if (vehicle_plain_shape(vehicle->model, out->geom, &out->shape))
		return type == mjGEOM_BOX ? make_belt(vehicle, out, where) : STATUS_OK;
	return fail_with(STATUS_INPUT, "%s: %s: a shape like this cannot press the ground; use boxes, spheres, capsules, ellipsoids, cylinders or meshes, "
				       "or leave it out of soil", where, out->name);
}

/* A name of a body in the world: A-Z a-z 0-9 _ - and a dot. */
static enum status make_name(const struct vehicle *vehicle, size_t index)
{
	char geom[256], name[400];
	struct soil_geom *out = &vehicle->geoms[index];
	vehicle_geom_name(vehicle, out->geom, geom, sizeof geom);
	for (char *c = geom; *c != '\0'; c++)
		if (strchr("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-", *c) == NULL)
			*c = '_';
	snprintf(name, sizeof name, "%s.%s", vehicle->scene->name, geom);
	for (size_t i = 0; i < index; i++)
		if (strcmp(vehicle->geoms[i].name, name) == 0)
			snprintf(name, sizeof name, "%s.%s_%d", vehicle->scene->name, geom, out->geom);
	return mem_text(&out->name, name, "a vehicle");
}

static enum status make_geom(const struct vehicle *vehicle, size_t index, const char *where)
{
	struct soil_geom *out = &vehicle->geoms[index];
	TRY(make_name(vehicle, index));
	TRY(make_shape(vehicle, out, where));
	return STATUS_OK;
}

static enum status no_geom(const struct vehicle *vehicle, const char *key, const char *where)
{
	const struct scene_texts *patterns = strcmp(key, "soil") == 0 ? &vehicle->scene->soil : &vehicle->scene->carry;
	if (patterns->count == 0 && vehicle->scene->no_soil.count > 0)
		return fail_with(STATUS_INPUT, "%s: no_soil names all geoms that collide, so none presses the ground; leave those that it stands on out of it", where);
	if (patterns->count == 0)
		return fail_with(STATUS_INPUT, "%s: no geom of it collides, so none presses the ground; let geoms of moving bodies collide, or name them in soil",
				 where);
	char names[200] = "", name[80];
	size_t length = 0;
	const struct range geoms = vehicle->own.geom;
	int told = geoms.first;
	for (; told < geoms.end && length + sizeof name + 2 < sizeof names; told++) {
		vehicle_geom_name(vehicle, told, name, sizeof name);
		length += (size_t)snprintf(names + length, sizeof names - length, "%s%s", told > geoms.first ? ", " : "", name);
	}
	return fail_with(STATUS_INPUT, "%s: %s: %.64s names no geom of a body that moves; the model has: %s%s", where, vehicle->prefix[0] != '\0' ? key : "geoms", patterns->list[0], names,
			 told < geoms.end ? ", ..." : "");
}

/* --- geoms that carry soil --- */

/* Finds the level axis about which joints turn a geom: that of its own body's hinge, or of the nearest one above, in MuJoCo's axes. Returns false if there is none. */
static bool find_hinge(const struct vehicle *vehicle, int geom, double axis[3])
{
	const mjModel *model = vehicle->model;
	for (int body = model->geom_bodyid[geom]; body > 0; body = model->body_parentid[body])
		for (int j = 0; j < model->body_jntnum[body]; j++) {
			const int joint = model->body_jntadr[body] + j;
			mju_copy3(axis, &vehicle->data->xaxis[3 * joint]);
			if (model->jnt_type[joint] == mjJNT_HINGE && fabs(axis[2]) < LEVEL)
				return true;
		}
	return false;
}

/*
 * Lets the body's forward axis lie along the hinge that turns the geom, so that a bucket that curls and dumps rolls about it. With an axis across,
 * it would pitch through the upright. There a small lean turns yaw by any angle, and the cells of its soil with it.
 */
static void set_hinge_axes(const struct vehicle *vehicle, struct soil_geom *out)
{
	const double *mat = &vehicle->data->geom_xmat[9 * out->geom];
	double hinge[3], forward[3], left[3], up[3] = {mat[6], mat[7], mat[8]};
	struct soil_mesh *mesh = out->mesh;
	if (mesh == NULL || !find_hinge(vehicle, out->geom, hinge))
		return;
	mju_mulMatTVec(forward, mat, hinge, 3, 3);
	mju_normalize3(forward);
	mju_addToScl3(up, forward, -mju_dot3(up, forward));
	mju_normalize3(up);
	mju_cross(left, up, forward);
	vehicle_set_axes(out, forward, left, up);
	for (int k = 0; k < 3; k++) {
		mesh->low[k] = INFINITY;
		mesh->high[k] = -INFINITY;
	}
	for (uint32_t i = 0; i < mesh->vertex_count; i++) {
		float *at = mesh->vertices[i];
		const double from[3] = {(double)at[0], (double)at[1], (double)at[2]};
		const double to[3] = {mju_dot3(from, forward), mju_dot3(from, left), mju_dot3(from, up)};
		for (int k = 0; k < 3; k++) {
			at[k] = (float)to[k];
			mesh->low[k] = fmin(mesh->low[k], (double)at[k]);
			mesh->high[k] = fmax(mesh->high[k], (double)at[k]);
		}
	}
}

static enum status let_carry(struct vehicle *vehicle, struct soil_geom *geom, const char *where)
{
	if (geom->shape.kind != SOIL_BOX && geom->shape.kind != SOIL_MESH)
		return fail_with(STATUS_INPUT, "%s: carry: soil rolls off %s; name boxes and meshes, or make a mesh of it", where, geom->name);
	if (geom->shape.belt)
		return fail_with(STATUS_INPUT, "%s: carry: %s is a belt, which would take its soil along; leave it out of carry", where, geom->name);
	geom->carries = true;
	vehicle->carrying_count++;
	set_hinge_axes(vehicle, geom);
	return STATUS_OK;
}

static enum status find_carrying(struct vehicle *vehicle, const char *where)
{
	for (int i = vehicle->own.geom.first; i < vehicle->own.geom.end; i++) {
		char name[256];
		struct soil_geom *geom = vehicle_soil_geom_of(vehicle, i);
		vehicle_geom_name(vehicle, i, name, sizeof name);
		if (!vehicle_matches(&vehicle->scene->carry, name, false))
			continue;
		if (geom == NULL)
			return fail_with(STATUS_INPUT, "%s: carry: %.64s does not press the ground, so no soil comes onto it; name it in soil, too, or leave it out of carry",
					 where, name);
		TRY(let_carry(vehicle, geom, where));
	}
	return vehicle->scene->carry.count == 0 || vehicle->carrying_count > 0 ? STATUS_OK : no_geom(vehicle, "carry", where);
}

enum status vehicle_find_geoms(struct vehicle *vehicle, const char *where)
{
	TRY(mem_zeroed(&vehicle->geoms, range_count(vehicle->own.geom) + 1, sizeof *vehicle->geoms, "a vehicle"));
	TRY(check_no_soil(vehicle, where));
	tell_left_out(vehicle, where);
	for (int i = vehicle->own.geom.first; i < vehicle->own.geom.end; i++) {
		if (!is_soil_geom(vehicle, i) || (vehicle->scene->soil.count == 0 && !can_touch(vehicle->model, i)))
			continue;
		const size_t index = vehicle->geom_count++;
		vehicle->geoms[index].geom = i;
		TRY(make_geom(vehicle, index, where));
	}
	if (vehicle->geom_count == 0 && !vehicle->is_world)
		return no_geom(vehicle, "soil", where);
	TRY(check_belts(vehicle, where));
	TRY(find_carrying(vehicle, where));
	for (size_t g = 0; g < vehicle->geom_count; g++)
		vehicle_find_roll(vehicle, &vehicle->geoms[g]);
	vehicle_find_standing(vehicle);
	return STATUS_OK;
}

void vehicle_free_geoms(struct vehicle *vehicle)
{
	for (size_t i = 0; i < vehicle->geom_count; i++) {
		mem_free_all(vehicle->geoms[i].name, vehicle->geoms[i].chain, vehicle->geoms[i].places);
		vehicle_free_mesh(vehicle->geoms[i].mesh);
	}
	mem_free(vehicle->geoms);
}

/* --- where they are --- */

void vehicle_geom_state(const struct vehicle *vehicle, const struct soil_geom *geom, struct furrow_state *state, struct furrow_belt *belt)
{
	double axes[9], velocity[6];
	mju_mulMatMat(axes, &vehicle->data->geom_xmat[9 * geom->geom], geom->axes, 3, 3, 3);
	mju_mat2Quat(state->pose.orientation, axes);
	mju_normalize4(state->pose.orientation);
	mj_objectVelocity(vehicle->model, vehicle->data, mjOBJ_GEOM, geom->geom, velocity, 0);
	for (int i = 0; i < 3; i++) {
		state->pose.position[i] = vehicle->origin[i] + vehicle->data->geom_xpos[3 * geom->geom + i];
		state->angular[i] = velocity[i];
		state->linear[i] = velocity[3 + i];
	}
	if (belt == NULL)
		return;
	*belt = (struct furrow_belt){0, 0};
	if (geom->shape.belt) {
		const int at = vehicle->model->jnt_qposadr[vehicle->model->dof_jntid[geom->dof]];
		*belt = (struct furrow_belt){geom->sprocket * vehicle->data->qpos[at], geom->sprocket * vehicle->data->qvel[geom->dof]};
	}
}

const struct soil_geom *vehicle_driven(const struct vehicle *vehicle, int joint)
{
	const mjModel *model = vehicle->model;
	for (size_t g = 0; g < vehicle->geom_count; g++) {
		const struct soil_geom *geom = &vehicle->geoms[g];
		if (vehicle_turning_dof(geom) == model->jnt_dofadr[joint])
			return geom;
	}
	return NULL;
}

static double sign(double value)
{
	return value >= 0 ? 1 : -1;
}

/* In the geom's own axes. */
static void own_support(const mjModel *model, int geom, const double d[3], double place[3])
{
	const double *size = &model->geom_size[3 * geom];
	const double level = hypot(d[0], d[1]), length = sqrt(level * level + d[2] * d[2]);
	switch (model->geom_type[geom]) {
	case mjGEOM_SPHERE:
	case mjGEOM_CAPSULE:
		for (int i = 0; i < 3; i++)
			place[i] = size[0] * d[i] / length;
		place[2] += model->geom_type[geom] == mjGEOM_CAPSULE ? size[1] * sign(d[2]) : 0;
		return;
	case mjGEOM_CYLINDER:
		place[0] = level > 0 ? size[0] * d[0] / level : 0;
		place[1] = level > 0 ? size[0] * d[1] / level : 0;
		place[2] = size[1] * sign(d[2]);
		return;
	case mjGEOM_ELLIPSOID: {
		const double scaled = sqrt(d[0] * d[0] * size[0] * size[0] + d[1] * d[1] * size[1] * size[1] + d[2] * d[2] * size[2] * size[2]);
		for (int i = 0; i < 3; i++)
			place[i] = size[i] * size[i] * d[i] / scaled;
		return;
	}
	case mjGEOM_MESH: {
		const int mesh = model->geom_dataid[geom];
		const float *from = &model->mesh_vert[3 * model->mesh_vertadr[mesh]];
		double most = -INFINITY;
		for (int i = 0; i < model->mesh_vertnum[mesh]; i++) {
			const double along = d[0] * (double)from[3 * i] + d[1] * (double)from[3 * i + 1] + d[2] * (double)from[3 * i + 2];
			if (along <= most)
				continue;
			most = along;
			for (int k = 0; k < 3; k++)
				place[k] = (double)from[3 * i + k];
		}
		return;
	}
	default: /* a box */
		for (int i = 0; i < 3; i++)
			place[i] = size[i] * sign(d[i]);
	}
}

void vehicle_geom_support(const mjModel *model, const mjData *data, int geom, const double direction[3], double place[3])
{
	double own[3], at[3];
	mju_mulMatTVec3(own, &data->geom_xmat[9 * geom], direction);
	own_support(model, geom, own, at);
	mju_mulMatVec3(place, &data->geom_xmat[9 * geom], at);
	mju_addTo3(place, &data->geom_xpos[3 * geom]);
}

double vehicle_geom_lowest(const struct vehicle *vehicle, int geom)
{
	static const double down[3] = {0, 0, -1};
	double place[3];
	vehicle_geom_support(vehicle->model, vehicle->data, geom, down, place);
	return place[2];
}
