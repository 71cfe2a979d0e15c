/*
 * All vehicles of a scene, and the things of its `world`, in one model of MuJoCo.
 *
 * Each file was read, mended and compiled alone (spec.c). Here the specs are attached to an empty one, in the order of the vehicles' names,
 * and the whole is compiled. MuJoCo keeps the order: parts of one vehicle are neighbours. Only geoms of the models' own worlds come
 * before all others. A part has the number of its vehicle and a slash before its name (names.c).
 *
 * One model has one `option`. The shortest timestep counts. What else differs is told.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "vehicle/internal.h"
#include "vehicle/spec.h"

double vehicle_mass(const struct vehicle *vehicle)
{
	double mass = 0;
	for (int body = vehicle->own.body.first; body < vehicle->own.body.end; body++)
		mass += vehicle->model->body_mass[body];
	return mass;
}

const struct vehicle *vehicle_of_body(const struct vehicles *vehicles, int body)
{
	for (size_t v = 0; v < vehicles->all; v++)
		if (body >= vehicles->list[v].own.body.first && body < vehicles->list[v].own.body.end)
			return &vehicles->list[v];
	return NULL;
}

const struct vehicle *vehicle_of_geom(const struct vehicles *vehicles, int geom)
{
	const int body = vehicles->model->geom_bodyid[geom];
	for (size_t v = 0; v < vehicles->all && body == 0; v++)
		if (geom >= vehicles->list[v].own.fixed.first && geom < vehicles->list[v].own.fixed.end)
			return &vehicles->list[v];
	return vehicle_of_body(vehicles, body);
}

/* --- one option for all --- */

static const char *integrator_name(int integrator)
{
	return integrator == mjINT_IMPLICIT ? "implicit" : integrator == mjINT_IMPLICITFAST ? "implicitfast" : "Euler";
}

/* Forces of the soil are known at the start of a step only. */
static int integrator_of(const mjModel *model)
{
	return model->opt.integrator == mjINT_RK4 ? mjINT_EULER : model->opt.integrator;
}

/* The higher counts: it damps more at its end. */
static int rank_of(int integrator)
{
	return integrator == mjINT_IMPLICIT ? 2 : integrator == mjINT_IMPLICITFAST ? 1 : 0;
}

struct differing {
	char text[300];
	bool cone, solver, flags, other;
};

static void mix_with(mjOption *out, const mjOption *one, struct differing *differs)
{
	out->timestep = fmin(out->timestep, one->timestep);
	differs->cone |= out->cone != one->cone;
	out->cone = out->cone > one->cone ? out->cone : one->cone;
	differs->solver |= out->solver != one->solver || out->iterations != one->iterations || out->ls_iterations != one->ls_iterations ||
			   out->noslip_iterations != one->noslip_iterations || out->tolerance != one->tolerance;
	out->solver = out->solver > one->solver ? out->solver : one->solver;
	out->iterations = out->iterations > one->iterations ? out->iterations : one->iterations;
	out->ls_iterations = out->ls_iterations > one->ls_iterations ? out->ls_iterations : one->ls_iterations;
	out->noslip_iterations = out->noslip_iterations > one->noslip_iterations ? out->noslip_iterations : one->noslip_iterations;
	out->tolerance = fmin(out->tolerance, one->tolerance);
	differs->flags |= out->disableflags != one->disableflags || out->enableflags != one->enableflags || out->disableactuator != one->disableactuator;
	out->disableflags &= one->disableflags;
	out->enableflags |= one->enableflags;
	out->disableactuator &= one->disableactuator;
	differs->other |= out->impratio != one->impratio || out->density != one->density || out->viscosity != one->viscosity ||
			  memcmp(out->wind, one->wind, sizeof out->wind) != 0 || memcmp(out->magnetic, one->magnetic, sizeof out->magnetic) != 0;
	out->impratio = fmax(out->impratio, one->impratio);
}

/* Finds the option of the model of all. It begins with that of the first vehicle by name. */
static void mix_options(const struct vehicles *vehicles, mjOption *out)
{
	struct differing differs = {.text = ""};
	const struct vehicle *first = &vehicles->list[vehicles->order[0]], *strongest = first;
	bool integrators = false;
	*out = first->single->opt;
	out->integrator = integrator_of(first->single);
	for (size_t i = 1; i < vehicles->all; i++) {
		const struct vehicle *vehicle = &vehicles->list[vehicles->order[i]];
		if (vehicle->single->nv == 0 || vehicle->is_world)
			continue; /* its own option does not count */
		const int integrator = integrator_of(vehicle->single);
		integrators |= integrator != out->integrator;
		if (rank_of(integrator) > rank_of(out->integrator)) {
			out->integrator = integrator;
			strongest = vehicle;
		}
		mix_with(out, &vehicle->single->opt, &differs);
	}
	size_t length = 0;
	if (integrators)
		length += (size_t)snprintf(differs.text, sizeof differs.text, "integrator %s as %s has it, ", integrator_name(out->integrator), strongest->scene->name);
	if (differs.cone)
		length += (size_t)snprintf(differs.text + length, sizeof differs.text - length, "cone elliptic, ");
	if (differs.solver)
		length += (size_t)snprintf(differs.text + length, sizeof differs.text - length, "the most iterations and the least tolerance of the solver, ");
	if (differs.flags)
		length += (size_t)snprintf(differs.text + length, sizeof differs.text - length, "no flag disabled that one of them needs, ");
	if (differs.other)
		length += (size_t)snprintf(differs.text + length, sizeof differs.text - length, "impratio the highest, density, viscosity and wind as %s has them, ", first->scene->name);
	if (length > 2)
		note("vehicles: they are one model of MuJoCo, and their options differ; for all of them count: %.*s", (int)length - 2, differs.text);
}

/* --- putting together --- */

struct merging {
	struct vehicles *vehicles;
	mjSpec *spec;
	char error[400];
};

static void attach(void *argument)
{
	struct merging *merging = argument;
	struct vehicles *vehicles = merging->vehicles;
	merging->spec = mj_makeSpec();
	mjsBody *world = merging->spec != NULL ? mjs_findBody(merging->spec, "world") : NULL;
	if (world == NULL)
		return;
	mix_options(vehicles, &merging->spec->option);
	for (size_t i = 0; i < vehicles->all; i++) {
		struct vehicle *vehicle = &vehicles->list[vehicles->order[i]];
		mjsFrame *frame = mjs_addFrame(world, NULL);
		if (vehicle->spec->memory > merging->spec->memory)
			merging->spec->memory = vehicle->spec->memory;
		if (frame == NULL || mjs_attach(frame->element, vehicle->spec->element, vehicle->prefix, "") == NULL) {
			const char *why = mjs_getError(merging->spec);
			snprintf(merging->error, sizeof merging->error, "%s: %s", vehicle->scene->name, why != NULL ? why : "");
			return;
		}
	}
	vehicles->model = mj_compile(merging->spec, NULL);
	if (vehicles->model == NULL) {
		const char *why = mjs_getError(merging->spec);
		snprintf(merging->error, sizeof merging->error, "%s", why != NULL ? why : "");
		return;
	}
	vehicles->data = mj_makeData(vehicles->model);
}

static struct range after(struct range range, mjtSize count)
{
	return (struct range){range.end, range.end + (int)count};
}

static int own_world_geoms(const mjModel *single)
{
	return single->body_geomnum[0];
}

/* Finds what is whose: MuJoCo keeps the order in which they were attached. */
static void share_out(struct vehicles *vehicles)
{
	struct owned last = {.body = {0, 1}};
	int keyframes = 0;
	for (size_t v = 0; v < vehicles->all; v++)
		last.geom.end += own_world_geoms(vehicles->list[v].single);
	for (size_t i = 0; i < vehicles->all; i++) {
		struct vehicle *vehicle = &vehicles->list[vehicles->order[i]];
		const mjModel *single = vehicle->single;
		const int fixed = own_world_geoms(single);
		last = (struct owned){
			.body = after(last.body, single->nbody - 1), .joint = after(last.joint, single->njnt), .geom = after(last.geom, single->ngeom - fixed),
			.actuator = after(last.actuator, single->nactuator), .equality = after(last.equality, single->neq), .tendon = after(last.tendon, single->ntendon),
			.text = after(last.text, single->ntext), .numeric = after(last.numeric, single->nnumeric), .sensor = after(last.sensor, single->nsensor),
			.qpos = after(last.qpos, single->nq), .dof = after(last.dof, single->nv), .act = after(last.act, single->na),
			.ctrl = after(last.ctrl, single->nu), .fixed = after(last.fixed, fixed), .geom_number = fixed,
		};
		vehicle->own = last;
		vehicle->model = vehicles->model;
		vehicle->data = vehicles->data;
		vehicle->keyframe += vehicle->keyframe >= 0 ? keyframes : 0;
		keyframes += (int)single->nkey;
	}
}

/* --- what must be the same as in the models alone --- */

static bool same(const double *a, const double *b, size_t count)
{
	for (size_t i = 0; i < count; i++)
		if (fabs(a[i] - b[i]) > 1e-9 * (fabs(a[i]) + fabs(b[i])) + 1e-12)
			return false;
	return true;
}

/* A name of a part that is not what it is in its vehicle's own model. */
static const char *differing_part(const struct vehicle *vehicle)
{
	const mjModel *all = vehicle->model, *single = vehicle->single;
	const struct owned *own = &vehicle->own;
	const int fixed = own->geom_number;
	double axes[9];
	const bool turned = vehicle->scene != NULL && vehicle_scene_axes(vehicle->scene, axes); /* the model alone is by now: axes.c */
	for (int i = 1; i < single->nbody; i++) {
		const int at = own->body.first + i - 1, parent = single->body_parentid[i];
		const bool moved = turned && parent == 0 && !vehicle_is_free(single, i);
		if (all->body_jntnum[at] != single->body_jntnum[i] || all->body_geomnum[at] != single->body_geomnum[i] ||
		    all->body_parentid[at] != (parent > 0 ? own->body.first + parent - 1 : 0) ||
		    (!moved && !same(&all->body_pos[3 * at], &single->body_pos[3 * i], 3)))
			return "its bodies";
	}
	for (int i = 0; i < single->njnt; i++)
		if (all->jnt_type[own->joint.first + i] != single->jnt_type[i] || all->jnt_limited[own->joint.first + i] != single->jnt_limited[i])
			return "its joints";
	for (int i = fixed; i < single->ngeom; i++) {
		const int at = own->geom.first + i - fixed;
		if (all->geom_type[at] != single->geom_type[i] || all->geom_contype[at] != single->geom_contype[i] ||
		    !same(&all->geom_size[3 * at], &single->geom_size[3 * i], 3) || !same(&all->geom_friction[3 * at], &single->geom_friction[3 * i], 3))
			return "its geoms";
	}
	if (!same(all->dof_armature + own->dof.first, single->dof_armature, (size_t)single->nv) ||
	    !same(all->dof_damping + own->dof.first, single->dof_damping, (size_t)single->nv))
		return "its joints";
	for (int i = 0; i < single->nactuator; i++)
		if (all->actuator_trntype[own->actuator.first + i] != single->actuator_trntype[i] ||
		    !same(all->actuator_gainprm + mjNGAIN * (own->actuator.first + i), single->actuator_gainprm + mjNGAIN * i, mjNGAIN))
			return "its actuators";
	return NULL;
}

/* Takes the masses from the models alone: the compiler of one file may scale all its masses. */
static bool take_masses(const struct vehicle *vehicle)
{
	mjModel *all = vehicle->model;
	const mjModel *single = vehicle->single;
	const size_t first = (size_t)vehicle->own.body.first, count = (size_t)single->nbody - 1;
	if (same(all->body_mass + first, single->body_mass + 1, count) && same(all->body_inertia + 3 * first, single->body_inertia + 3, 3 * count))
		return false;
	mju_copy(all->body_mass + first, single->body_mass + 1, (int)count);
	mju_copy(all->body_inertia + 3 * first, single->body_inertia + 3, 3 * (int)count);
	return true;
}

static enum status check_sizes(const struct vehicles *vehicles)
{
	const mjModel *model = vehicles->model;
	const struct owned *last = &vehicles->list[vehicles->order[vehicles->all - 1]].own;
	if (last->body.end == model->nbody && last->joint.end == model->njnt && last->geom.end == model->ngeom && last->actuator.end == model->nactuator &&
	    last->qpos.end == model->nq && last->dof.end == model->nv && last->act.end == model->na && last->ctrl.end == model->nu && last->equality.end == model->neq)
		return STATUS_OK;
	return fail_with(STATUS_FAILED, "vehicles: MuJoCo makes other parts of their models together than of each alone; drive them in scenes of their own");
}

/* The pose that each has alone. */
static void set_poses(struct vehicles *vehicles)
{
	mjData *data = vehicles->data;
	for (size_t v = 0; v < vehicles->all; v++) {
		const struct vehicle *vehicle = &vehicles->list[v];
		mju_copy(data->qpos + vehicle->own.qpos.first, vehicle->posed->qpos, vehicle->single->nq);
		mju_copy(data->qvel + vehicle->own.dof.first, vehicle->posed->qvel, vehicle->single->nv);
		mju_copy(data->act + vehicle->own.act.first, vehicle->posed->act, vehicle->single->na);
	}
}

static void finish(void *argument)
{
	struct merging *merging = argument;
	struct vehicles *vehicles = merging->vehicles;
	bool changed = false;
	for (size_t v = 0; v < vehicles->all; v++)
		changed |= take_masses(&vehicles->list[v]);
	if (changed)
		mj_setConst(vehicles->model, vehicles->data);
	set_poses(vehicles);
}

static void forget_specs(struct vehicles *vehicles)
{
	for (size_t v = 0; v < vehicles->all; v++) {
		struct vehicle *vehicle = &vehicles->list[v];
		if (vehicle->spec != NULL)
			mj_deleteSpec(vehicle->spec);
		if (vehicle->posed != NULL)
			mj_deleteData(vehicle->posed);
		vehicle->spec = NULL;
		vehicle->posed = NULL;
	}
}

static enum status make_room(struct vehicles *vehicles)
{
	const mjModel *model = vehicles->model;
	vehicles->room = mem_calloc(VEHICLE_ROOM * (size_t)model->nv + 64, sizeof *vehicles->room);
	vehicles->mass = mem_calloc((size_t)model->nC + 1, sizeof *vehicles->mass);
	vehicles->kept = mem_calloc((size_t)mj_stateSize(model, VEHICLE_KEPT) + 1, sizeof *vehicles->kept);
	TRY_MEM(vehicles->room != NULL && vehicles->mass != NULL && vehicles->kept != NULL, "the vehicles");
	for (size_t v = 0; v < vehicles->all; v++)
		vehicles->list[v].room = vehicles->room;
	return STATUS_OK;
}

enum status vehicle_merge(struct vehicles *vehicles)
{
	struct merging merging = {.vehicles = vehicles, .error = ""};
	const char *where = vehicles->all == 1 ? vehicles->list[0].scene->name : "vehicles";
	for (size_t v = 0; v < vehicles->all; v++)
		vehicle_prefix(vehicles, v, vehicles->list[v].prefix);
	enum status status = vehicle_guard(where, attach, &merging);
	if (merging.spec != NULL && status == STATUS_OK)
		mj_deleteSpec(merging.spec);
	TRY(status);
	if (vehicles->model == NULL)
		return fail_with(STATUS_INPUT, "vehicles: MuJoCo cannot put their models together: %.300s; drive them in scenes of their own",
				 merging.error[0] != '\0' ? merging.error : "out of memory");
	TRY_MEM(vehicles->data, "the vehicles");
	share_out(vehicles);
	TRY(check_sizes(vehicles));
	TRY(vehicle_guard(where, finish, &merging));
	for (size_t v = 0; v < vehicles->all; v++) {
		const char *what = differing_part(&vehicles->list[v]);
		if (what != NULL)
			return fail_with(STATUS_FAILED, "vehicles.%s: MuJoCo makes %s other than in its model alone when vehicles are put together; drive it in a scene of its own",
					 vehicles->list[v].scene->name, what);
	}
	forget_specs(vehicles);
	return make_room(vehicles);
}
