/*
 * What is wrong with how a vehicle lies: told once each, with time and place.
 *
 * - under_ground: a geom that is no soil geom lies below the ground of now, deeper than a post, or 5 cm.
 * - overturned: the root body's up axis leans by more than 60 degrees from the vertical.
 * - high_centred: parts of the root body that do not roll bear more than half of the weight. The vehicle has wheels or belts.
 * - buried: the soil does not carry a soil geom (FURROW_SUNK).
 *
 * Each must be so for a while without a break.
 */
#include <math.h>
#include <stdio.h>

#include "vehicle/internal.h"
#include "vehicle/settle.h"

#define LOOKS 0.05      /* s: so often other geoms are compared with the ground */
#define DEEP_LEAST 0.05 /* m, or a post: what lies deeper is told */
#define UNDER_LONG 0.5  /* s */
#define LONG 1.0        /* s, of the others */
#define LEANS 0.5       /* cosine of 60 degrees */
#define BEARS 0.5       /* of the weight, as a mean over */
#define BEARS_LONG 0.5  /* s, since wheels that dig shake it */
#define WITHIN 0.1      /* of its size, and */
#define WITHIN_LEAST 0.02 /* m: what reaches so far beyond a soil geom is a part of it */
#define AROUND 2        /* directions each way in which the lowest places of a geom are looked for */
#define CORNERS_MOST 20000 /* a mesh with more counts as its box */
#define NUMBERS 8       /* of a lie in the record */

static const char *const whats[LIE_OWN + 1] = {"overturned", "high_centred", "buried", "under_ground"};
static const double longs[LIE_OWN + 1] = {LONG, LONG, LONG, UNDER_LONG};

/* --- which geoms are watched --- */

/* Returns true if two geoms are of bodies that are fixed to each other, or joined by one joint. */
static bool are_near(const mjModel *model, int a, int b)
{
	const int x = model->body_weldid[model->geom_bodyid[a]], y = model->body_weldid[model->geom_bodyid[b]];
	return x == y || model->body_weldid[model->body_parentid[x]] == y || model->body_weldid[model->body_parentid[y]] == x;
}

/* Returns true if the geom's box lies within the one of `other`, grown a little, in the first pose. */
static bool is_within(const struct vehicle *vehicle, int geom, int other)
{
	const mjModel *model = vehicle->model;
	const mjData *data = vehicle->data;
	const mjtNum *own = &model->geom_aabb[6 * geom], *around = &model->geom_aabb[6 * other];
	for (int corner = 0; corner < 8; corner++) {
		double at[3], place[3];
		for (int k = 0; k < 3; k++)
			at[k] = own[k] + (corner >> k & 1 ? own[3 + k] : -own[3 + k]);
		mju_mulMatVec3(place, &data->geom_xmat[9 * geom], at);
		mju_addTo3(place, &data->geom_xpos[3 * geom]);
		mju_sub3(place, place, &data->geom_xpos[3 * other]);
		mju_mulMatTVec3(at, &data->geom_xmat[9 * other], place);
		for (int k = 0; k < 3; k++)
			if (fabs(at[k] - around[k]) > (1 + WITHIN) * around[3 + k] + WITHIN_LEAST)
				return false;
	}
	return true;
}

static bool is_watched(const struct vehicle *vehicle, int geom)
{
	const mjModel *model = vehicle->model;
	const int type = model->geom_type[geom];
	const bool collides = model->geom_contype[geom] != 0 || model->geom_conaffinity[geom] != 0;
	const bool shown = model->geom_group[geom] < 3 && model->geom_rgba[4 * geom + 3] > 0;
	if (vehicle_is_fixed(model, geom) || vehicle_soil_geom_of(vehicle, geom) != NULL || type == mjGEOM_PLANE || type == mjGEOM_HFIELD || !(collides || shown))
		return false;
	for (size_t g = 0; g < vehicle->geom_count; g++)
		if (are_near(model, geom, vehicle->geoms[g].geom) && is_within(vehicle, geom, vehicle->geoms[g].geom))
			return false;
	return true;
}

/* The axis that looks up most, or down, in the model's own pose. */
static int find_up(const struct vehicle *vehicle)
{
	const mjModel *model = vehicle->model;
	const int joint = model->body_jntadr[vehicle->root];
	const mjtNum *quat = vehicle_is_free(model, vehicle->root) ? &model->qpos0[model->jnt_qposadr[joint] + 3] : &model->body_quat[4 * vehicle->root];
	double mat[9];
	int up = 2;
	mju_quat2Mat(mat, quat);
	for (int k = 0; k < 2; k++)
		up = fabs(mat[6 + k]) > fabs(mat[6 + up]) + 1e-6 ? k : up;
	return up;
}

enum status vehicle_make_lies(struct vehicle *vehicle)
{
	const struct range geoms = vehicle->own.geom;
	TRY(mem_zeroed(&vehicle->lies, LIE_OWN + range_count(geoms), sizeof *vehicle->lies, "a vehicle"));
	for (int i = 0; i < LIE_OWN; i++)
		vehicle->lies[vehicle->lie_count++] = (struct lie){.number = -1, .since = -1};
	for (int i = geoms.first; i < geoms.end; i++) {
		char geom[256], name[400];
		if (!is_watched(vehicle, i))
			continue;
		vehicle_geom_name(vehicle, i, geom, sizeof geom);
		snprintf(name, sizeof name, "%s.%s", vehicle->scene->name, geom);
		struct lie *lie = &vehicle->lies[vehicle->lie_count++];
		*lie = (struct lie){.number = i, .since = -1};
		TRY(mem_text(&lie->geom, name, "a vehicle"));
	}
	vehicle->up = find_up(vehicle);
	return STATUS_OK;
}

void vehicle_free_lies(struct vehicle *vehicle)
{
	for (size_t i = 0; i < vehicle->lie_count; i++)
		mem_free(vehicle->lies[i].geom);
	mem_free(vehicle->lies);
}

/* --- below the ground --- */

/* How far the ground is above one place, m. */
static enum status depth_at(const struct vehicles *vehicles, const double place[3], double *depth)
{
	const struct world_space space = {.low = {place[0], place[1]}, .high = {place[0], place[1]}, .lowest = place[2], .at = {place[0], place[1], place[2]}};
	return world_reach_into(vehicles->world, &space, depth);
}

/* Finds how far a geom is below the ground of now at most; below 0: it is above it. */
static enum status depth_of(const struct vehicles *vehicles, const struct vehicle *vehicle, int geom, double least, double *depth)
{
	const mjModel *model = vehicle->model;
	double at[3];
	struct world_space space;
	mju_add3(at, vehicle->origin, &vehicle->data->geom_xpos[3 * geom]);
	vehicle_space_of(vehicle, geom, at, &vehicle->data->geom_xmat[9 * geom], 0, &space);
	TRY(world_reach_into(vehicles->world, &space, depth));
	const int type = model->geom_type[geom], mesh = model->geom_dataid[geom];
	if (*depth < least || type == mjGEOM_BOX || type == mjGEOM_SDF || (type == mjGEOM_MESH && model->mesh_vertnum[mesh] > CORNERS_MOST))
		return STATUS_OK;
	const double whole = *depth;
	*depth = -INFINITY;
	for (int i = -AROUND; i <= AROUND; i++)
		for (int k = -AROUND; k <= AROUND; k++) {
			const double direction[3] = {(double)i / AROUND, (double)k / AROUND, -1};
			double place[3], here;
			vehicle_geom_support(model, vehicle->data, geom, direction, place);
			mju_addTo3(place, vehicle->origin);
			TRY(depth_at(vehicles, place, &here));
			*depth = fmax(*depth, here);
		}
	*depth = fmin(*depth, whole);
	return STATUS_OK;
}

/* --- whether it is so --- */

/* Returns the part of the root body that bears most, if those that do not roll bear most of the weight. NULL: they do not, or nothing of the vehicle rolls. */
static const struct soil_geom *hung_up(const struct vehicles *vehicles, struct vehicle *vehicle)
{
	const mjModel *model = vehicle->model;
	const struct soil_geom *most = vehicle->lies[LIE_HIGH_CENTRED].of;
	double bears = 0, *mean = &vehicle->lies[LIE_HIGH_CENTRED].bears;
	bool any = false;
	for (size_t g = 0; g < vehicle->geom_count; g++) {
		const struct soil_geom *geom = &vehicle->geoms[g];
		const bool rolls = vehicle_turning_dof(geom) >= 0;
		any = any || rolls;
		if (rolls || geom->carries || model->body_weldid[model->geom_bodyid[geom->geom]] != model->body_weldid[vehicle->root] || !(geom->force[2] > 0))
			continue;
		bears += geom->force[2];
		if (most == NULL || geom->force[2] > most->force[2])
			most = geom;
	}
	*mean += (bears - *mean) * vehicles->scene->time_step / BEARS_LONG;
	return any && *mean > BEARS * model->body_subtreemass[vehicle->root] * vehicles->scene->gravity ? most : NULL;
}

/* --- telling --- */

/* The cosine of the angle between the root body's up axis and the vertical. */
static double upright_of(const struct vehicle *vehicle)
{
	return vehicle->data->xmat[9 * vehicle->root + 6 + vehicle->up];
}

static void say(const struct vehicle *vehicle, size_t index, char *text, size_t size)
{
	const struct lie *lie = &vehicle->lies[index];
	const char *name = vehicle->scene->name;
	char where[96];
	snprintf(where, sizeof where, "since t = %.3g s, at %.6g, %.6g m", lie->time, lie->at[0], lie->at[1]);
	if (index >= LIE_OWN)
		snprintf(text, size, "vehicles.%.200s is %.3g m under the ground %s: it does not press the soil; let it collide, or name it in soil", lie->geom, lie->depth,
			 where);
	else if (index == LIE_OVERTURNED)
		snprintf(text, size, "vehicles.%.64s lies on its %s %s; stop: [overturned] ends a drive there", name, upright_of(vehicle) < -LEANS ? "roof" : "side", where);
	else
		snprintf(text, size, "vehicles.%.200s bears most of the weight %s: the vehicle hangs on it, and its wheels carry less than half", lie->of->name, where);
}

static void tell(struct vehicle *vehicle, size_t index)
{
	struct lie *lie = &vehicle->lies[index];
	char text[500];
	lie->told = true;
	if (lie->printed || index == LIE_BURIED) /* that is told with what the soil carries (vehicle.c) */
		return;
	lie->printed = true;
	say(vehicle, index, text, sizeof text);
	note("%s", text);
}

/* Takes whether it is so now. `geom`: of the model, whose place counts; -1: the vehicle's. */
static void take(const struct vehicles *vehicles, struct vehicle *vehicle, size_t index, bool is, int geom, double depth)
{
	struct lie *lie = &vehicle->lies[index];
	const double now = world_time(vehicles->world) + vehicles->scene->time_step;
	const double *place = geom >= 0 ? &vehicle->data->geom_xpos[3 * geom] : &vehicle->data->xpos[3 * vehicle->root];
	if (!is) {
		lie->since = -1;
		return;
	}
	if (lie->since < 0) {
		lie->since = now;
		if (!lie->told) {
			lie->time = now;
			lie->depth = depth;
			for (int k = 0; k < 2; k++)
				lie->at[k] = vehicle->origin[k] + place[k];
		}
	}
	lie->depth = fmax(lie->depth, depth);
	if (!lie->told && now - lie->since >= longs[index < LIE_OWN ? index : LIE_OWN])
		tell(vehicle, index);
}

static enum status watch_under(const struct vehicles *vehicles, struct vehicle *vehicle)
{
	const double now = world_time(vehicles->world), step = vehicles->scene->time_step, least = fmax(DEEP_LEAST, world_resident(vehicles->world)->spacing);
	if (floor((now + step) / LOOKS * (1 + 1e-12)) == floor(now / LOOKS * (1 + 1e-12)))
		return STATUS_OK;
	for (size_t i = LIE_OWN; i < vehicle->lie_count; i++) {
		double depth;
		TRY(depth_of(vehicles, vehicle, vehicle->lies[i].number, least, &depth));
		take(vehicles, vehicle, i, depth >= least && isfinite(depth), vehicle->lies[i].number, depth);
	}
	return STATUS_OK;
}

enum status vehicle_watch_lies(const struct vehicles *vehicles, struct vehicle *vehicle)
{
	const struct soil_geom *hangs = hung_up(vehicles, vehicle), *sunk = vehicle_sunk(vehicle);
	const bool overturned = upright_of(vehicle) < LEANS;
	take(vehicles, vehicle, LIE_OVERTURNED, overturned, -1, 0);
	if (hangs != NULL)
		vehicle->lies[LIE_HIGH_CENTRED].of = hangs;
	take(vehicles, vehicle, LIE_HIGH_CENTRED, hangs != NULL && !overturned, hangs != NULL ? hangs->geom : -1, hangs != NULL ? hangs->contact.sinkage : 0);
	if (sunk != NULL)
		vehicle->lies[LIE_BURIED].of = sunk;
	take(vehicles, vehicle, LIE_BURIED, sunk != NULL, sunk != NULL ? sunk->geom : -1, sunk != NULL ? sunk->contact.sinkage : 0);
	return watch_under(vehicles, vehicle);
}

bool vehicle_lies_so(const struct vehicle *vehicle, int lie)
{
	return vehicle->lies[lie].told && vehicle->lies[lie].since >= 0;
}

bool vehicle_lie(const struct vehicles *vehicles, size_t index, size_t nth, struct vehicle_lie *out)
{
	const struct vehicle *vehicle = &vehicles->list[index];
	for (size_t i = 0; i < vehicle->lie_count; i++) {
		const struct lie *lie = &vehicle->lies[i];
		if (!lie->told || nth-- > 0)
			continue;
		*out = (struct vehicle_lie){whats[i < LIE_OWN ? i : LIE_OWN], lie->geom != NULL ? lie->geom : lie->of != NULL ? lie->of->name : NULL, lie->time,
					    {lie->at[0], lie->at[1]}, i == LIE_OVERTURNED ? (double)NAN : lie->depth};
		return true;
	}
	return false;
}

/* --- the record --- */

size_t vehicle_lies_numbers(const struct vehicle *vehicle)
{
	return NUMBERS * vehicle->lie_count;
}

double *vehicle_save_lies(const struct vehicle *vehicle, double *to)
{
	for (size_t i = 0; i < vehicle->lie_count; i++) {
		const struct lie *lie = &vehicle->lies[i];
		const double all[NUMBERS] = {lie->since, lie->time, lie->at[0], lie->at[1], lie->depth, lie->told,
						 lie->of != NULL ? (double)(lie->of - vehicle->geoms) : -1, lie->bears};
		for (size_t k = 0; k < NUMBERS; k++)
			*to++ = all[k];
	}
	return to;
}

const double *vehicle_restore_lies(struct vehicle *vehicle, const double *from)
{
	for (size_t i = 0; i < vehicle->lie_count; i++, from += NUMBERS) {
		struct lie *lie = &vehicle->lies[i];
		lie->since = from[0];
		lie->time = from[1];
		lie->at[0] = from[2];
		lie->at[1] = from[3];
		lie->depth = from[4];
		lie->told = from[5] != 0;
		lie->bears = from[7];
		lie->of = from[6] >= 0 && from[6] < (double)vehicle->geom_count ? &vehicle->geoms[(size_t)from[6]] : NULL;
	}
	return from;
}
