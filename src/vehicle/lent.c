/*
 * A model of MuJoCo that a host owns and steps: an engine plugin, or a program with a loop of its own.
 *
 * The soil geoms of the whole model are those of one vehicle here. coupling.c and step.c do for it what they do for vehicles of a scene. Of the
 * host's structs there are copies, so that the soil's forces get an array of their own. All other arrays stay the host's. A host with another
 * version of MuJoCo has other structs. It names its arrays, and the copies are filled with these. So here nothing of MuJoCo may be called that
 * needs more than these arrays: names, Jacobians, velocities, and the factors of the inertia.
 */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "vehicle/internal.h"

#define PATTERNS_MOST 64
#define ELSEWHERE_POSTS 0.5 /* a geom that is farther from where its step ended, besides twice the way of a step, was put there */
#define ELSEWHERE_TURN 1.0  /* rad, the same */

struct vehicle_lent {
	struct vehicles all;
	struct vehicle one;
	struct scene_vehicle told;
	struct scene scene;         /* the world's, with the step of the host */
	mjModel model;              /* copies of the structs, */
	mjData data;
	bool named;                 /* filled with the arrays that the host names */
	char *patterns, *carry, *tyres;
	char *list[PATTERNS_MOST], *carry_list[PATTERNS_MOST];
	double *forces;             /* nv: what the soil does to the joints */
	double *before, *start, *after; /* nv each: velocities at the start of the step; in the state with which it was begun last (RK4 has four); at its end */
	struct furrow_state *last;  /* of each geom: when the ground got it, or it was placed */
	double *velocities;         /* the host's, of those that it names */
	bool placed, ended;         /* the geoms are in the world; a step has ended that the ground does not know yet */
	bool begun;                 /* a step has begun, and has not ended */
	bool stepping;              /* the world was to make a step since */
	double time;                /* s, of the world: at the start of the last step */
};

/* --- the host's arrays --- */

struct member {
	const char *name;
	size_t offset;
};

#define MODEL(member) {"model." #member, offsetof(mjModel, member)}
#define DATA(member) {"data." #member, offsetof(mjData, member)}

static const struct member model_members[] = {
	MODEL(body_parentid), MODEL(body_rootid), MODEL(body_weldid), MODEL(body_jntnum), MODEL(body_jntadr), MODEL(body_dofnum), MODEL(body_dofadr), MODEL(body_geomnum),
	MODEL(jnt_type), MODEL(jnt_qposadr), MODEL(jnt_dofadr), MODEL(dof_bodyid), MODEL(dof_jntid), MODEL(dof_parentid), MODEL(dof_damping), MODEL(dof_M0),
	MODEL(body_mass), MODEL(geom_type), MODEL(geom_contype), MODEL(geom_conaffinity), MODEL(geom_condim), MODEL(geom_priority), MODEL(geom_bodyid), MODEL(geom_dataid), MODEL(geom_size), MODEL(geom_aabb), MODEL(geom_user),
	MODEL(mesh_vertadr), MODEL(mesh_vertnum), MODEL(mesh_faceadr), MODEL(mesh_facenum), MODEL(mesh_vert), MODEL(mesh_face),
	MODEL(name_bodyadr), MODEL(name_geomadr), MODEL(name_jntadr), MODEL(name_textadr), MODEL(name_numericadr), MODEL(names),
	MODEL(text_adr), MODEL(text_data), MODEL(numeric_adr), MODEL(numeric_data),
	MODEL(actuator_trntype), MODEL(actuator_trnid), MODEL(actuator_gear), MODEL(actuator_outadr), MODEL(actuator_biastype), MODEL(actuator_biasprm),
	MODEL(M_rownnz), MODEL(M_rowadr), MODEL(M_colind),
};
static const struct member data_members[] = {
	DATA(qpos), DATA(qvel), DATA(xpos), DATA(xmat), DATA(xanchor), DATA(xaxis), DATA(geom_xpos), DATA(geom_xmat), DATA(subtree_com), DATA(cdof), DATA(cvel),
	DATA(M), DATA(qLD), DATA(qLDiagInv),
};

static void *array_of(const struct vehicle_lending *lending, const char *name)
{
	for (size_t i = 0; i < lending->array_count; i++)
		if (strcmp(lending->arrays[i].name, name) == 0)
			return lending->arrays[i].at;
	return NULL;
}

static enum status missing(const struct vehicle_lending *lending, const char *name)
{
	return fail_with(STATUS_INPUT, "%s: the array %s of MuJoCo is missing; give it", lending->name, name);
}

static enum status fill_struct(const struct vehicle_lending *lending, const struct member *members, size_t count, void *to)
{
	for (size_t i = 0; i < count; i++) {
		void *at = array_of(lending, members[i].name);
		if (at == NULL)
			return missing(lending, members[i].name);
		memcpy((char *)to + members[i].offset, &at, sizeof at);
	}
	return STATUS_OK;
}

/* Sizes come as arrays of one number: `double` for the options, else int64_t. */
static enum status take_size(const struct vehicle_lending *lending, const char *name, int64_t *out)
{
	const int64_t *at = array_of(lending, name);
	if (at == NULL)
		return missing(lending, name);
	*out = *at;
	return STATUS_OK;
}

static enum status take_sizes(const struct vehicle_lending *lending, mjModel *model)
{
	int64_t n = 0;
#define SIZE(member) \
	TRY(take_size(lending, "model." #member, &n)); \
	model->member = (__typeof__(model->member))n
	SIZE(nq);
	SIZE(nv);
	SIZE(nbody);
	SIZE(njnt);
	SIZE(ngeom);
	SIZE(nC);
	SIZE(nactuator);
	SIZE(ntext);
	SIZE(nnumeric);
	SIZE(nuser_geom);
	SIZE(opt.integrator);
#undef SIZE
	return STATUS_OK;
}

static enum status take_arrays(const struct vehicle_lending *lending, struct vehicle_lent *lent)
{
	const double *gravity = array_of(lending, "model.opt.gravity");
	TRY(take_sizes(lending, &lent->model));
	TRY(fill_struct(lending, model_members, sizeof model_members / sizeof *model_members, &lent->model));
	TRY(fill_struct(lending, data_members, sizeof data_members / sizeof *data_members, &lent->data));
	if (gravity == NULL)
		return missing(lending, "model.opt.gravity");
	mju_copy3(lent->model.opt.gravity, gravity);
	return STATUS_OK;
}

/* Copies the host's data anew. The soil's forces and velocities keep arrays of their own. */
static void take_data(struct vehicle_lent *lent, const void *data)
{
	if (!lent->named) {
		lent->data = *(const mjData *)data;
		lent->data.nefc = 0; /* what follows from the inertia for constraints is the host's own to do */
	}
	mju_copy(lent->start, lent->named ? lent->velocities : lent->data.qvel, (int)lent->model.nv);
	lent->data.qvel = lent->start; /* the host's may go on to the step's end */
	lent->data.qfrc_applied = lent->forces;
}

/* --- a vehicle of it --- */

/* Cuts a copy of the patterns of a key into a list. */
static enum status split(const struct vehicle_lent *lent, const char *key, const char *patterns, char **copy, char *list[PATTERNS_MOST], struct scene_texts *to)
{
	*copy = mem_strdup(patterns);
	TRY_MEM(*copy, "patterns of geoms");
	to->list = list;
	for (char *word = *copy, *next; *(word += strspn(word, " \t\n")) != '\0'; word = next) {
		next = word + strcspn(word, " \t\n");
		if (*next != '\0')
			*next++ = '\0';
		if (to->count == PATTERNS_MOST)
			return fail_with(STATUS_INPUT, "%s: %s has more than %d patterns; give fewer, with wildcards", lent->told.name, key, PATTERNS_MOST);
		list[to->count++] = word;
	}
	return to->count > 0 ? STATUS_OK : fail_with(STATUS_INPUT, "%s: %s names nothing; give patterns of geoms, such as wheel_*, or leave it out", lent->told.name, key);
}

/* The whole model is the vehicle's, and no part of it has a prefix. */
static void own_all(struct vehicle_lent *lent)
{
	const mjModel *model = &lent->model;
	lent->one.own = (struct owned){
		.body = {1, (int)model->nbody}, .joint = {0, (int)model->njnt}, .geom = {0, (int)model->ngeom}, .actuator = {0, (int)model->nactuator},
		.text = {0, (int)model->ntext}, .numeric = {0, (int)model->nnumeric}, .qpos = {0, (int)model->nq}, .dof = {0, (int)model->nv},
	};
}

static enum status make_lists(struct vehicles *all)
{
	const size_t count = all->geom_count = all->list->geom_count, nv = (size_t)all->model->nv;
	TRY(mem_zeroed(&all->numbers, count + 1, sizeof *all->numbers, "soil geoms"));
	TRY(mem_zeroed(&all->states, count + 1, sizeof *all->states, "soil geoms"));
	TRY(mem_zeroed(&all->belts, count + 1, sizeof *all->belts, "soil geoms"));
	TRY(mem_zeroed(&all->contacts, count + 1, sizeof *all->contacts, "soil geoms"));
	TRY(mem_zeroed(&all->mass, (size_t)all->model->nC + 1, sizeof *all->mass, "soil geoms"));
	TRY(mem_zeroed(&all->room, VEHICLE_ROOM * nv + 64, sizeof *all->room, "soil geoms"));
	all->list->room = all->room;
	return STATUS_OK;
}

static enum status find_geoms(struct vehicle_lent *lent)
{
	struct vehicle *vehicle = &lent->one;
	const char *where = lent->told.name;
	if (lent->model.nv == 0)
		return fail_with(STATUS_INPUT, "%s: nothing moves in this model; give the bodies that are to press the ground joints", where);
	TRY(vehicle_find_geoms(vehicle, where));
	vehicle->root = lent->model.body_rootid[lent->model.geom_bodyid[vehicle->geoms[0].geom]];
	for (int i = 0; i < 9; i++)
		vehicle->axes[i] = i % 4 == 0;
	return vehicle_make_room(vehicle);
}

static void doubt_gravity(const struct vehicle_lent *lent)
{
	const double has = -lent->model.opt.gravity[2], scene = lent->scene.gravity;
	if (fabs(has - scene) > 0.01 * scene)
		note("%s: the model's gravity is %.4g m/s2, and the scene's is %.4g: soil that slides or is carried has the scene's; give both the same", lent->told.name, has, scene);
}

static enum status lend(const struct vehicle_lending *lending, struct world *world, struct vehicle_lent *lent)
{
	struct vehicle *vehicle = &lent->one;
	lent->told.name = mem_strdup(lending->name);
	TRY_MEM(lent->told.name, "soil geoms");
	lent->named = lending->model == NULL;
	if (lent->named) {
		TRY(take_arrays(lending, lent));
		lent->velocities = lent->data.qvel;
	} else {
		lent->model = *(const mjModel *)lending->model;
		lent->data = *(const mjData *)lending->data;
	}
	const size_t nv = (size_t)lent->model.nv;
	TRY(mem_zeroed(&lent->forces, nv + 1, sizeof *lent->forces, "soil geoms"));
	TRY(mem_zeroed(&lent->before, nv + 1, sizeof *lent->before, "soil geoms"));
	TRY(mem_zeroed(&lent->start, nv + 1, sizeof *lent->start, "soil geoms"));
	TRY(mem_zeroed(&lent->after, nv + 1, sizeof *lent->after, "soil geoms"));
	if (lending->geoms != NULL)
		TRY(split(lent, "geoms", lending->geoms, &lent->patterns, lent->list, &lent->told.soil));
	if (lending->carry != NULL)
		TRY(split(lent, "carry", lending->carry, &lent->carry, lent->carry_list, &lent->told.carry));
	lent->scene = *world_scene(world);
	lent->all = (struct vehicles){.scene = &lent->scene, .world = world, .model = &lent->model, .data = &lent->data, .engine_steps = 1, .list = vehicle, .count = 1, .all = 1};
	*vehicle = (struct vehicle){.scene = &lent->told, .model = &lent->model, .data = &lent->data, .keyframe = -1};
	mju_copy3(vehicle->origin, lending->origin);
	mju_copy3(lent->all.origin, lending->origin);
	own_all(lent);
	TRY(find_geoms(lent));
	if (lending->tyres != NULL) {
		lent->tyres = mem_strdup(lending->tyres);
		TRY_MEM(lent->tyres, "tyres");
		TRY(vehicle_lent_tyres(vehicle, lent->told.name, lent->tyres, lent->scene.gravity));
	}
	TRY(make_lists(&lent->all));
	doubt_gravity(lent);
	TRY(mem_zeroed(&lent->last, vehicle->geom_count + 1, sizeof *lent->last, "soil geoms"));
	for (size_t g = 0; g < vehicle->geom_count; g++)
		vehicle->geoms[g].number = -1;
	return vehicle_add_bodies(vehicle, world);
}

enum status vehicle_lend(const struct vehicle_lending *lending, struct world *world, struct vehicle_lent **out)
{
	*out = NULL;
	TRY(vehicle_mujoco_load());
	struct vehicle_lent *lent = mem_calloc(1, sizeof *lent);
	TRY_MEM(lent, "soil geoms");
	const enum status status = lend(lending, world, lent);
	if (status != STATUS_OK) {
		struct failure failure;
		failure_capture(&failure, status);
		const enum status removed = vehicle_lent_remove(lent); /* what was added before it failed */
		(void)removed; /* the first failure is told */
		vehicle_lent_destroy(lent);
		return failure_restore(&failure);
	}
	*out = lent;
	return STATUS_OK;
}

void vehicle_lent_destroy(struct vehicle_lent *lent)
{
	if (lent == NULL)
		return;
	struct vehicles *all = &lent->all;
	vehicle_free_geoms(&lent->one);
	mem_free_all(all->numbers, all->states, all->belts, all->contacts, all->mass, all->room, lent->one.contacts, lent->one.rows, lent->forces, lent->before, lent->start, lent->after,
		     lent->patterns, lent->carry, lent->tyres, lent->last, lent->told.name, lent);
}

enum status vehicle_lent_remove(struct vehicle_lent *lent)
{
	for (size_t g = 0; g < lent->one.geom_count && lent->last != NULL; g++) {
		const struct body *body = world_body(lent->all.world, (size_t)lent->one.geoms[g].number);
		if (body != NULL && !body->host.removed)
			TRY(world_body_remove(lent->all.world, lent->one.geoms[g].number));
	}
	return STATUS_OK;
}

/* --- steps --- */

/* Puts a geom where it is, at rest. */
static enum status place(struct vehicle_lent *lent, size_t g)
{
	struct soil_geom *geom = &lent->one.geoms[g];
	vehicle_geom_state(&lent->one, geom, &lent->last[g], &geom->touched_belt);
	geom->is_touched = false;
	return geom->aloft ? STATUS_OK : world_body_place(lent->all.world, geom->number, &lent->last[g].pose);
}

/* Tells whether a geom is farther from a place than it goes in a step, `way`, and turns, `turn`. */
static bool is_elsewhere(const struct vehicle_lent *lent, const struct soil_geom *geom, const struct furrow_pose *from, const struct furrow_pose *to, double way, double turn)
{
	const double *was = from->orientation, *is = to->orientation;
	const double dot = fmin(fabs(was[0] * is[0] + was[1] * is[1] + was[2] * is[2] + was[3] * is[3]), 1);
	return mju_dist3(from->position, to->position) > ELSEWHERE_POSTS * world_resident(lent->all.world)->spacing + way ||
	       (geom->shape.kind != SOIL_SPHERE && 2 * acos(dot) > ELSEWHERE_TURN + turn);
}

/* Puts all geoms where they are, or those that the host has put elsewhere since the ground knew them last. */
static enum status place_some(struct vehicle_lent *lent, bool all)
{
	for (size_t g = 0; g < lent->one.geom_count; g++) {
		struct furrow_state now;
		vehicle_geom_state(&lent->one, &lent->one.geoms[g], &now, NULL);
		if (all || is_elsewhere(lent, &lent->one.geoms[g], &lent->last[g].pose, &now.pose, 0, 0))
			TRY(place(lent, g));
	}
	lent->placed = true;
	return STATUS_OK;
}

enum status vehicle_lent_begin(struct vehicle_lent *lent, const void *data, double seconds, bool again, double *forces)
{
	const int nv = (int)lent->model.nv;
	if (!(seconds > 0 && seconds <= 1))
		return fail_with(STATUS_INPUT, "%s: the timestep is %g s; give one above 0 and at most 1 s", lent->told.name, seconds);
	take_data(lent, data);
	lent->scene.time_step = seconds;
	if (!again) {
		lent->begun = false;
		mju_copy(lent->before, lent->start, nv);
		const double now = world_time(lent->all.world);
		if (lent->placed && (lent->stepping ? now <= lent->time : now != lent->time))
			vehicle_lent_forget(lent); /* the world was rolled back, or somebody else stepped it */
		TRY(place_some(lent, !lent->placed));
		lent->stepping = false;
		lent->time = now;
		TRY(vehicle_ask(&lent->all));
	}
	vehicle_couple(&lent->all, seconds, 0, true);
	mju_copy(forces, lent->forces, nv);
	lent->begun = true;
	return STATUS_OK;
}

/* Lets the copy have the velocities at the step's end. */
static void let_end(struct vehicle_lent *lent, const double *qvel)
{
	mju_copy(lent->after, qvel, (int)lent->model.nv);
	lent->data.qvel = lent->after;
}

bool vehicle_lent_limit(struct vehicle_lent *lent, const double *qvel, double *forces)
{
	let_end(lent, qvel);
	const bool again = vehicle_couple_end(&lent->all, lent->scene.time_step, lent->start, true);
	lent->data.qvel = lent->start;
	if (again)
		mju_copy(forces, lent->forces, (int)lent->model.nv);
	return again;
}

void vehicle_lent_forces(struct vehicle_lent *lent, const double *qvel, double *forces)
{
	let_end(lent, qvel);
	vehicle_couple_forces(&lent->all, lent->start, forces);
	lent->data.qvel = lent->start;
}

void vehicle_lent_end(struct vehicle_lent *lent, const double *qvel)
{
	let_end(lent, qvel);
	if (lent->model.opt.integrator != mjINT_RK4) /* there the last state's own is told */
		vehicle_couple_tell(&lent->all, lent->start);
	vehicle_couple_done(&lent->all, lent->scene.time_step, lent->before, true);
	lent->data.qvel = lent->start;
	lent->begun = false;
	lent->ended = true;
}

/* Tells whether the host has put a geom elsewhere since its step ended. */
static bool has_jumped(const struct vehicle_lent *lent, const struct soil_geom *geom, const struct furrow_state *now)
{
	const double h = lent->scene.time_step;
	const double speed = fmax(mju_norm3(now->linear), mju_norm3(geom->now.linear)), spin = fmax(mju_norm3(now->angular), mju_norm3(geom->now.angular));
	return is_elsewhere(lent, geom, &geom->now.pose, &now->pose, 2 * h * speed, 2 * h * spin);
}

enum status vehicle_lent_touch(struct vehicle_lent *lent, const void *data, bool *moved)
{
	bool elsewhere = false;
	*moved = false;
	if (!lent->ended)
		return STATUS_OK;
	lent->ended = false;
	if (world_time(lent->all.world) != lent->time) {
		vehicle_lent_forget(lent);
		return STATUS_OK;
	}
	take_data(lent, data);
	for (size_t g = 0; g < lent->one.geom_count && !elsewhere; g++) {
		vehicle_geom_state(&lent->one, &lent->one.geoms[g], &lent->last[g], NULL);
		elsewhere = has_jumped(lent, &lent->one.geoms[g], &lent->last[g]);
	}
	TRY(vehicle_check_summed(&lent->all));
	if (elsewhere)
		TRY(place_some(lent, true));
	else
		TRY(vehicle_touch(&lent->all));
	*moved = true;
	lent->stepping = true;
	return vehicle_tell_forces(&lent->all);
}

void vehicle_lent_forget(struct vehicle_lent *lent)
{
	for (size_t g = 0; g < lent->one.geom_count; g++) {
		struct soil_geom *geom = &lent->one.geoms[g];
		geom->is_touched = false;
		geom->aloft = !geom->is_standing;
		geom->load = geom->work = geom->pulled = geom->sunk = 0;
		mju_zero3(geom->mean);
		mju_zero(geom->force, 6);
		geom->contact = world_contact_unknown();
	}
	lent->placed = lent->begun = lent->ended = lent->stepping = false;
}

bool vehicle_lent_takes(const struct vehicle_lent *lent, const void *data)
{
	return lent->named || data != NULL;
}

bool vehicle_lent_begun(const struct vehicle_lent *lent)
{
	return lent->begun;
}

bool vehicle_lent_ended(const struct vehicle_lent *lent)
{
	return lent->ended;
}

double vehicle_lent_seconds(const struct vehicle_lent *lent)
{
	return lent->scene.time_step;
}

size_t vehicle_lent_count(const struct vehicle_lent *lent)
{
	return lent->one.geom_count;
}

int vehicle_lent_geom(const struct vehicle_lent *lent, size_t index, const char **name, struct furrow_state *state, struct furrow_contact *contact)
{
	const struct soil_geom *geom = &lent->one.geoms[index];
	if (name != NULL)
		*name = geom->name;
	if (state != NULL)
		vehicle_geom_state(&lent->one, geom, state, NULL);
	if (contact != NULL)
		vehicle_geom_contact(&lent->all, geom, contact);
	return geom->geom;
}
